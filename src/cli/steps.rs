//! What is done to a volume before it is meshed: cropped, made a mask, blurred, downsampled, always
//! in this order.

use std::ops::Range;

use super::args::StepsArgs;
use crate::geom::Space;
use crate::source::{self, SourceError, Volume, WrapError};
use crate::volume::Meta;

/// Which samples are read.
#[derive(Clone, Debug, PartialEq)]
enum Part {
    Whole,
    /// Half-open ranges of indices.
    Indices([Range<usize>; 3]),
    /// The least box of samples around a box in the coordinates of a space.
    Around(Space, [[f64; 2]; 3]),
}

/// The steps that were asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Steps {
    part: Part,
    /// Millimetres; 0 for none.
    sigma_mm: f64,
    /// Samples a block; 1 for none.
    block: [usize; 3],
}

impl Steps {
    /// `space` is the output's.
    pub(crate) fn new(args: &StepsArgs, space: Space) -> Self {
        let part = match (args.crop, args.crop_mm) {
            (Some(ranges), _) => Part::Indices(ranges.map(|[low, high]| low..high)),
            (None, Some(sides)) => Part::Around(space, sides),
            (None, None) => Part::Whole,
        };
        let block = args.downsample.unwrap_or([1; 3]);
        Self { part, sigma_mm: args.blur.unwrap_or(0.0), block }
    }

    /// The part of the volume that is meant, as it is stored.
    pub(crate) fn part<'a>(&self, volume: Volume<'a>) -> Result<Volume<'a>, SourceError> {
        match &self.part {
            Part::Whole => Ok(volume),
            Part::Indices(ranges) => source::crop(volume, ranges),
            Part::Around(space, sides) => {
                let [min, max] = [0, 1].map(|end| sides.map(|side| side[end]));
                let ranges =
                    volume.meta.grid.box_around(*space, min, max).map_err(WrapError::from)?;
                source::crop(volume, &ranges)
            }
        }
    }

    /// All steps. The values of a mask, where there are any, are those that are stored: the blur and
    /// the means are of 1 and 0, in and out, then.
    pub(crate) fn apply<'a>(
        &self,
        volume: Volume<'a>,
        mask: Option<&[f64]>,
    ) -> Result<Volume<'a>, SourceError> {
        let part = self.part(volume)?;
        let marked = match mask {
            Some(values) => source::mask(part, values)?,
            None => part,
        };
        source::downsample(source::blur(marked, self.sigma_mm)?, self.block)
    }

    /// Whether the samples that are meshed are means, in `f64`.
    pub(crate) fn are_means(&self) -> bool {
        self.sigma_mm > 0.0 || self.block != [1; 3]
    }

    /// Bytes of the planes that the steps hold, about, of a volume that they are to be done to.
    pub(crate) fn held_bytes(&self, meta: &Meta) -> u64 {
        let grid = &meta.grid;
        let plane = (grid.dims.plane_len() as u64).saturating_mul(8);
        let window = if self.sigma_mm > 0.0 {
            // As far as the Gaussian reaches on either side.
            let reach = (4.0 * self.sigma_mm / grid.affine.spacing()[2] + 0.5) as u64;
            reach.saturating_mul(2).saturating_add(8).min(grid.dims.nz() as u64)
        } else {
            u64::from(self.are_means())
        };
        window.saturating_mul(plane)
    }
}
