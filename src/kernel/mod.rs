//! From samples to triangles: bit planes, cases, vertices, triangles of one slab.
//!
//! Pure: knows nothing of files, threads or clocks.

mod cases;
mod cpu;
mod crossing;
pub mod cube;
mod cut;
mod fan;
mod loops;
mod sound;
mod tunnel;

pub use cases::{Row, Tables};
pub use cpu::{Cpu, cpu};
pub use crossing::crossing;
pub use cut::{Cut, Side};
