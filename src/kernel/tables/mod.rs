//! Every way in which the surface may pass through a cell, made by rule before the first slab.
//!
//! ```text
//! cube ─► loops ─► fan, tunnel ─► sound ─► cases
//! ```
//!
//! Numbers of corners, edges and faces; the loops in which the surface crosses a case's faces; the
//! disks and annuli that fill them; whether those are sound patches; the tables. Knows no volume.

mod cases;
pub mod cube;
mod fan;
mod loops;
mod sound;
mod tunnel;

pub use cases::{Row, Tables};
