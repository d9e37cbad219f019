//! From samples to triangles: bit planes, cases, vertices, triangles of one slab.
//!
//! Pure: knows nothing of files, threads or clocks.

mod cpu;
mod crossing;
mod cut;

pub use cpu::{Cpu, cpu};
pub use crossing::crossing;
pub use cut::{Cut, Side};
