//! The progress bar.

use indicatif::{ProgressBar, ProgressStyle};

use super::term::Term;
use crate::pipeline::Progress;

/// A bar of planes on a terminal; elsewhere nothing.
pub(crate) struct Bar(ProgressBar);

impl Bar {
    pub(crate) fn new(term: Term, n_planes: usize) -> Self {
        if !term.is_live() {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new(n_planes as u64);
        let template = "meshing {bar:40} {pos}/{len} planes, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

impl Progress for Bar {
    fn planes(&self, done: usize, _: usize) {
        self.0.set_position(done as u64);
    }
}
