//! Samples and what is known of them: stored types, rescaling, the facts about a volume.
//!
//! Knows nothing of files or meshes.

mod inside;
mod meta;
mod notes;
mod rescale;
mod stats;
mod tally;
mod voxel;

pub use inside::{Inside, Side};
pub use meta::{Meta, Padding, SeriesFacts, SourceFormat};
pub use notes::Note;
pub use rescale::Rescale;
pub use stats::{Histogram, Suggestion, Survey};
pub(crate) use tally::Tally;
pub use voxel::{Sample, StoredType};
