//! Sources that wrap a source: crop, mask, padding, downsample, blur, formulas.

mod blur;
mod crop;
mod downsample;
mod formula;
mod labels;
pub(crate) mod sources;
