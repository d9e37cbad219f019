//! Which row of the tables a cell takes whose corners alone do not say.
//!
//! A pure function of the cell's case and values: what its faces' deciders say chooses among the
//! rows without a tunnel, alike in both cells at each face; what happens inside is the cell's own.

use super::decide::{joins, waist};
use super::extra::{centre, walls};
use super::tables::cube::{edge_point, is_crossed};
use super::tables::{Row, Tables};

/// The surface of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellSurface {
    /// The number of its row in [`Tables::rows`].
    pub row: u16,
    /// How many vertices inside the cell: the row's walls (local ids 12 and on, in that order) or its
    /// centre (local id 15).
    pub n_extra: u8,
    /// Those vertices, in the cell's own coordinates, 0 to 1 along each axis.
    pub extra: [[f64; 3]; 3],
}

impl CellSurface {
    /// Where the vertex of a local id lies in the cell; `t` is what [`settle`] was given.
    pub fn point(&self, id: u8, t: impl Fn(usize) -> f64) -> [f64; 3] {
        match id {
            0..12 => edge_point(id.into(), t(id.into())),
            15 => self.extra[0],
            _ => self.extra[usize::from(id - 12) % 3],
        }
    }
}

/// Settles a cell.
///
/// `values` are those of the corners less the level, negated where inside is below it. What is
/// inside is for `case` to say. A corner outside the volume may have any value, NaN say: the only
/// face of a border cell that can be ambiguous is the one on the volume's side. `t` gives the
/// parameter of the vertex on an edge that the case crosses, from the edge's lower corner, clamped
/// to `[epsilon, 1 - epsilon]`; it is asked only where there are vertices inside the cell.
pub fn settle(
    tables: &Tables,
    case: u8,
    values: &[f64; 8],
    t: impl Fn(usize) -> f64,
    epsilon: f64,
) -> CellSurface {
    let at = usize::from(case);
    let mut number = tables.first_row[at];
    let faces = tables.ambiguous[at].iter().take(tables.n_ambiguous[at].into());
    for (bit, corners) in faces.enumerate() {
        let [a, b, c, d] = corners.map(|corner| values[usize::from(corner & 7)]);
        number += u16::from(joins([a, b], [c, d])) << bit;
    }
    let row = &tables.rows[usize::from(number)];
    if let Some(tunnel) = tunnel(tables, row, case, values, &t, epsilon) {
        return tunnel;
    }
    let mut extra = [[0.0; 3]; 3];
    if row.n_centres > 0 {
        extra[0] = centre(row, values, &crossings(case, t));
    }
    CellSurface { row: number, n_extra: row.n_centres, extra }
}

/// The surface with the tunnel that a row may have, unless it would be too thin for the mesh.
fn tunnel(
    tables: &Tables,
    row: &Row,
    case: u8,
    values: &[f64; 8],
    t: impl Fn(usize) -> f64,
    epsilon: f64,
) -> Option<CellSurface> {
    if row.tunnels == [0; 2] {
        return None;
    }
    let waist = waist(values)?;
    let first = row.tunnels[usize::from(waist.inside)];
    if first == 0 {
        return None;
    }
    let axis = usize::from(tables.rows[usize::from(first)].axis);
    let is_second = axis < 3 && waist.half[axis] * waist.half[(axis + 1) % 3] <= 0.0;
    let number = first + u16::from(is_second);
    let row = &tables.rows[usize::from(number)];
    let extra = walls(row, &waist, &crossings(case, t), epsilon)?;
    Some(CellSurface { row: number, n_extra: row.n_walls, extra })
}

fn crossings(case: u8, t: impl Fn(usize) -> f64) -> [f64; 12] {
    std::array::from_fn(|edge| if is_crossed(case, edge) { t(edge) } else { 0.5 })
}
