//! Where a NIfTI header says that the samples lie: sform, else qform, else pixdim, as nibabel has
//! it, in millimetres.

use super::NiftiError;
use super::fields::Fields;
use crate::geom::vec3::{cross, norm, scale};
use crate::geom::{Affine, Dims};
use crate::volume::Note;

/// Voxel indices to RAS millimetres, and what is to be said about it.
pub(super) fn affine(fields: &Fields, dims: Dims) -> Result<(Affine, Vec<Note>), NiftiError> {
    let mut notes = Vec::new();
    let (rows, from) = if fields.sform_code > 0 {
        (fields.srow, "sform")
    } else if fields.qform_code > 0 {
        (qform(fields)?, "qform")
    } else {
        notes.push(Note::AffineFromPixdim);
        (base(fields, dims), "pixdim")
    };
    if from != "sform" {
        let unit = match fields.xyzt_units & 7 {
            1 => "m",
            3 => "µm",
            _ => "mm",
        };
        let used = if from == "pixdim" { n_zooms(fields) } else { 3 };
        let zero = (1..=used).filter(|&d| fields.pixdim[d] == 0.0);
        notes.extend(zero.map(|d| Note::Other(format!("pixdim[{d}] is 0: taken as 1 {unit}"))));
    }
    let rows = match fields.xyzt_units & 7 {
        1 => {
            notes.push(Note::UnitsConverted { from: "metres" });
            rows.map(|row| row.map(|v| v * 1e3))
        }
        3 => {
            notes.push(Note::UnitsConverted { from: "micrometres" });
            rows.map(|row| row.map(|v| v / 1e3))
        }
        _ => rows,
    };
    let mut affine = Affine::from_rows(rows);
    if dims.nz() == 1 && affine.column(2) == [0.0; 3] {
        affine = with_normal(&affine);
        notes.push(Note::Other(format!(
            "the {from} has no step along k: 1 mm along the normal of the one slice"
        )));
    }
    if !affine.is_usable() {
        return Err(NiftiError::Affine { from, rows });
    }
    Ok((affine, notes))
}

/// With a third column of length 1 across the other two, as far as they have a normal.
fn with_normal(affine: &Affine) -> Affine {
    let [i, j, origin] = [0, 1, 3].map(|c| affine.column(c));
    let normal = cross(scale(i, 1.0 / norm(i)), scale(j, 1.0 / norm(j)));
    Affine::from_columns(i, j, scale(normal, 1.0 / norm(normal)), origin)
}

/// pixdim[1..=3]: 0 counts as 1, and signs are dropped.
fn zooms(fields: &Fields) -> [f64; 3] {
    [1, 2, 3].map(|d| match fields.pixdim[d].abs() {
        0.0 => 1.0,
        zoom => zoom,
    })
}

/// Method 2 of nifti1.h: a rotation from the quaternion (a, b, c, d) with a ≥ 0, the zooms, and a
/// third axis that is turned round where qfac (pixdim[0]) is -1. Any other qfac counts as 1.
fn qform(fields: &Fields) -> Result<[[f64; 4]; 3], NiftiError> {
    let [b, c, d] = fields.quatern;
    let a = scalar_part(fields.version, fields.quatern).ok_or(NiftiError::Quaternion(b, c, d))?;
    let zooms = zooms(fields);
    let qfac = if fields.pixdim[0] == -1.0 { -1.0 } else { 1.0 };
    // A quaternion a hair off unit length is taken in its direction.
    let s = 2.0 / (a * a + b * b + c * c + d * d);
    let rotation = [
        [1.0 - s * (c * c + d * d), s * (b * c - a * d), s * (b * d + a * c)],
        [s * (b * c + a * d), 1.0 - s * (b * b + d * d), s * (c * d - a * b)],
        [s * (b * d - a * c), s * (c * d + a * b), 1.0 - s * (b * b + c * c)],
    ];
    Ok(std::array::from_fn(|r| {
        let [x, y, z] = rotation[r];
        [x * zooms[0], y * zooms[1], z * zooms[2] * qfac, fields.qoffset[r]]
    }))
}

/// a, from b, c, d and unit length; nothing where they are longer than 1 by more than rounding.
/// NaN goes through, and the affine is refused for it.
fn scalar_part(version: u8, [b, c, d]: [f64; 3]) -> Option<f64> {
    const SINGLE: f64 = 3.0 * f32::EPSILON as f64;
    let square = 1.0 - (b * b + c * c + d * d);
    // nibabel rounds to 0 within three roundings of the field's type. NIfTI-2 files are often made
    // from NIfTI-1 headers, so single precision is allowed for there too.
    let zero = if version == 1 { SINGLE } else { 3.0 * f64::EPSILON };
    if square < -SINGLE {
        None
    } else if square < zero {
        Some(0.0)
    } else {
        Some(square.sqrt())
    }
}

/// How many of the first three dimensions there are, and so have a pixdim.
fn n_zooms(fields: &Fields) -> usize {
    usize::try_from(fields.dim[0]).unwrap_or(0).min(3)
}

/// nibabel's base affine, where neither form is set: pixdim along the axes that there are and 1
/// along others, x turned round, the volume's centre at the origin.
fn base(fields: &Fields, dims: Dims) -> [[f64; 4]; 3] {
    let mut zooms = zooms(fields);
    zooms.iter_mut().skip(n_zooms(fields)).for_each(|zoom| *zoom = 1.0);
    let [zx, zy, zz] = zooms;
    let centre = dims.to_array().map(|n| (n as f64 - 1.0) / 2.0);
    [
        [-zx, 0.0, 0.0, centre[0] * zx],
        [0.0, zy, 0.0, -centre[1] * zy],
        [0.0, 0.0, zz, -centre[2] * zz],
    ]
}
