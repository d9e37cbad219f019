//! Sources that wrap a source: crop, blur, downsample, masks, formulas.
