//! How a volume is cut into slabs. A matter of speed and memory alone: no plan changes the mesh.

use std::ops::Range;

use crate::geom::Dims;

/// Sample bytes a slab where several threads work: half a core's cache, and enough slabs to share.
const SLAB_BYTES: usize = 2 << 20;

/// Sample bytes a slab for one thread, which keeps the shared plane's bits from slab to slab.
const SLAB_BYTES_ALONE: usize = 1 << 20;

/// Slabs of equally many layers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    nz: usize,
    layers_each: usize,
    /// Planes on either side of those that a slab's cells touch.
    halo: usize,
}

impl Plan {
    /// Slabs of as many layers as were `asked` for, or as suit the size of a plane.
    pub(super) fn new(
        dims: Dims,
        sample_bytes: usize,
        threads: usize,
        asked: Option<usize>,
        halo: usize,
    ) -> Self {
        let target = if threads > 1 { SLAB_BYTES } else { SLAB_BYTES_ALONE };
        let plane_bytes = dims.plane_len().saturating_mul(sample_bytes).max(1);
        let least = if threads > 1 { 2 } else { 1 };
        let layers = (target / plane_bytes).clamp(least, 64);
        // Small volumes: still a few slabs for each thread.
        let layers = layers.min(dims.nz().div_ceil(threads.saturating_mul(4)).max(1));
        Self { nz: dims.nz(), layers_each: asked.unwrap_or(layers).max(1), halo }
    }

    pub(super) fn n_slabs(&self) -> usize {
        (self.nz + 1).div_ceil(self.layers_each)
    }

    /// The layers of a slab.
    pub(super) fn layers(&self, slab: usize) -> Range<usize> {
        let start = slab * self.layers_each;
        start..(start + self.layers_each).min(self.nz + 1)
    }

    /// The planes that a slab is given: those that its cells touch, and the halo.
    pub(super) fn planes(&self, slab: usize) -> Range<usize> {
        let layers = self.layers(slab);
        layers.start.saturating_sub(1 + self.halo)..(layers.end + self.halo).min(self.nz)
    }

    /// For each plane, how many slabs are given it.
    pub(super) fn uses(&self) -> Vec<usize> {
        let mut uses = vec![0; self.nz];
        for slab in 0..self.n_slabs() {
            for plane in &mut uses[self.planes(slab)] {
                *plane += 1;
            }
        }
        uses
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_hold_every_layer_once_and_every_plane_that_they_touch() {
        for nz in [1, 2, 5, 64, 301] {
            for threads in [1, 2, 7] {
                for (asked, halo) in [(None, 0), (Some(1), 1), (Some(3), 0), (Some(999), 1)] {
                    let dims = Dims::checked(7, 9, nz, 2).unwrap();
                    let plan = Plan::new(dims, 2, threads, asked, halo);
                    let mut next = 0;
                    for slab in 0..plan.n_slabs() {
                        let (layers, planes) = (plan.layers(slab), plan.planes(slab));
                        assert_eq!(layers.start, next);
                        assert!(!layers.is_empty() && !planes.is_empty());
                        next = layers.end;
                        for layer in layers {
                            for plane in layer.saturating_sub(1)..=layer.min(nz as usize - 1) {
                                assert!(planes.contains(&plane), "{plane} {planes:?}");
                            }
                        }
                    }
                    assert_eq!(next, nz as usize + 1);
                    assert!(plan.uses().iter().all(|&n| n > 0));
                }
            }
        }
    }
}
