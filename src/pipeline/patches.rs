//! Patches to a sink: filled and encoded side by side, appended in order.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use super::RunError;
use super::run::{Counted, Output, Spent};
use super::sequence::{Sequence, Stop};
use crate::kernel::{Classify, PatchSlices, Totals};
use crate::mesh::{Measure, Patch};
use crate::sink::{Encoded, Encoder, Sink};

/// Triangles that a patch may have before it ends early, so that noise cannot swell memory. A patch
/// has one layer at least.
pub(super) const PATCH_TRIANGLES: u64 = 128 << 10;

/// Triangles encoded at once.
pub(super) const BATCH_TRIANGLES: usize = 128 << 10;

/// The sink of one surface, with the sums over what it was given.
pub(super) struct Patches<'a> {
    encoder: Arc<dyn Encoder>,
    normals: bool,
    sink: Sequence<(&'a mut dyn Sink, Measure)>,
}

/// A worker's patch and its bytes.
#[derive(Default)]
pub(super) struct Buffers {
    patch: Patch,
    encoded: Encoded,
}

impl<'a> Patches<'a> {
    pub(super) fn new(sink: &'a mut dyn Sink, normals: bool) -> Self {
        let encoder = sink.encoder();
        Self { encoder, normals, sink: Sequence::new((sink, Measure::default())) }
    }

    pub(super) fn into_inner(self) -> (&'a mut dyn Sink, Measure) {
        self.sink.into_inner()
    }
}

impl<T: Classify> Output<T> for Patches<'_> {
    type Claim = ();
    type Store = ();
    type Buffers = Buffers;

    fn halo(&self) -> usize {
        usize::from(self.normals)
    }

    fn store(&mut self) {}

    fn claim((): &mut (), _: Totals) -> Result<(), RunError> {
        Ok(())
    }

    /// One patch as a rule, made before its turn. A slab with too many triangles for that is made
    /// layer by layer when it is its turn.
    fn put(
        &self,
        counted: Counted<'_, T>,
        (): (),
        buffers: &mut Buffers,
        stop: &Stop,
    ) -> Result<Spent, RunError> {
        let mut spent = Spent::default();
        let layers = counted.slab.layers.clone();
        let mut first = counted.first_vertex;
        let mut begun = Instant::now();
        let (mut part, mut totals) = next_part(&counted, layers.start);
        fill(&counted, part.clone(), totals, first, self.normals, &mut buffers.patch);
        let is_small = buffers.patch.triangles.len() <= BATCH_TRIANGLES;
        spent.mesh += begun.elapsed();
        begun = Instant::now();
        if is_small {
            self.encode(buffers, 0..buffers.patch.triangles.len());
        }
        spent.write += begun.elapsed();
        self.sink.in_turn(stop, counted.number, |place| {
            begun = Instant::now();
            self.append(place, buffers, is_small)?;
            spent.write += begun.elapsed();
            while part.end < layers.end {
                begun = Instant::now();
                first = first.wrapping_add(totals.n_vertices as u32);
                (part, totals) = next_part(&counted, part.end);
                fill(&counted, part.clone(), totals, first, self.normals, &mut buffers.patch);
                spent.mesh += begun.elapsed();
                begun = Instant::now();
                self.append(place, buffers, false)?;
                spent.write += begun.elapsed();
            }
            Ok(())
        })?;
        Ok(spent)
    }

    fn wake(&self) {
        self.sink.wake();
    }
}

impl Patches<'_> {
    fn append(
        &self,
        (sink, sum): &mut (&mut dyn Sink, Measure),
        buffers: &mut Buffers,
        is_encoded: bool,
    ) -> Result<(), RunError> {
        let n = buffers.patch.triangles.len();
        let mut start = if is_encoded { n } else { 0 };
        loop {
            let end = n.min(start + BATCH_TRIANGLES);
            if !is_encoded {
                self.encode(buffers, start..end);
            }
            sink.append(&buffers.encoded)?;
            sum.merge(&buffers.encoded.measure);
            if end == n {
                return Ok(());
            }
            start = end;
        }
    }

    fn encode(&self, buffers: &mut Buffers, triangles: Range<usize>) {
        buffers.encoded.vertices.clear();
        buffers.encoded.faces.clear();
        buffers.encoded.measure = Measure::default();
        self.encoder.encode(&buffers.patch, triangles, &mut buffers.encoded);
    }
}

/// The next layers of a slab that make a patch, and what they come to.
fn next_part<T: Classify>(counted: &Counted<'_, T>, start: usize) -> (Range<usize>, Totals) {
    let layers = &counted.slab.layers;
    let mut totals = Totals::default();
    let mut end = start;
    while end < layers.end {
        let layer = counted.scratch.totals(end - layers.start);
        if end > start && totals.n_triangles + layer.n_triangles > PATCH_TRIANGLES {
            break;
        }
        totals.n_vertices += layer.n_vertices;
        totals.n_triangles += layer.n_triangles;
        end += 1;
    }
    (start..end, totals)
}

fn fill<T: Classify>(
    counted: &Counted<'_, T>,
    part: Range<usize>,
    totals: Totals,
    first: u32,
    with_normals: bool,
    patch: &mut Patch,
) {
    let n_ghosts = counted.kernel.n_ghosts(counted.slab, counted.scratch, part.start);
    patch.n_ghosts = n_ghosts;
    patch.first_id = first.wrapping_sub(n_ghosts as u32);
    resize(&mut patch.vertices, n_ghosts + totals.n_vertices as usize, [0.0; 3]);
    resize(&mut patch.triangles, totals.n_triangles as usize, [0; 3]);
    let (ghosts, vertices) = patch.vertices.split_at_mut(n_ghosts);
    let normals = with_normals.then(|| {
        resize(&mut patch.normals, totals.n_vertices as usize, [0.0; 3]);
        &mut patch.normals[..]
    });
    let triangles = &mut patch.triangles;
    let out = PatchSlices { ghosts: Some(ghosts), vertices, normals, triangles };
    counted.kernel.fill(counted.slab, counted.scratch, part, first, out);
}

/// Makes room for just so many, since a layer may have millions of triangles.
fn resize<T: Copy>(items: &mut Vec<T>, n: usize, filler: T) {
    items.reserve_exact(n.saturating_sub(items.len()));
    items.resize(n, filler);
}
