//! Sources that wrap a source: crop, mask, padding, downsample, blur, formulas.

mod crop;
mod labels;
mod sources;
