//! Progress of `mcubes info` on a terminal: headers while a study is looked through.

use indicatif::{ProgressBar, ProgressStyle};

use super::term::Term;

/// A count of the headers read so far, on a terminal; elsewhere nothing. Gone when dropped.
pub(crate) struct Headers(ProgressBar);

impl Headers {
    pub(crate) fn new(term: Term) -> Self {
        if !term.is_live() {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} reading headers, file {pos}") {
            bar.set_style(style);
        }
        Self(bar)
    }

    pub(crate) fn set(&self, n_files: usize) {
        self.0.set_position(n_files as u64);
    }
}

impl Drop for Headers {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
