//! Progress: one bar for the whole, one a running scan; nothing where there is no terminal.

use std::path::Path;
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::term::Term;
use crate::pipeline::Progress;

/// Where bars are drawn, and lines between them.
pub(super) struct Board {
    pub(super) term: Term,
    bars: MultiProgress,
    looking: ProgressBar,
}

impl Board {
    pub(super) fn new(term: Term) -> Self {
        let target = if term.is_live() {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bars = MultiProgress::with_draw_target(target);
        let looking = bars.add(ProgressBar::new_spinner());
        Self { term, bars, looking }
    }

    /// Says how many files below an input were looked at.
    pub(super) fn looked_at(&self, path: &Path, n_files: usize) {
        if n_files.is_multiple_of(64) {
            self.looking.set_message(format!("{}: {n_files} files looked at", path.display()));
            self.looking.tick();
        }
    }

    /// Takes the searching line away.
    pub(super) fn clear(&self) {
        self.looking.finish_and_clear();
    }

    /// Prints with the bars out of the way. Where none is drawn a print that nobody takes keeps no scan
    /// from its end.
    pub(super) fn say<R>(&self, print: impl FnOnce() -> R) -> R {
        if self.term.is_live() { self.bars.suspend(print) } else { print() }
    }

    /// The bar of the whole, where there is more than one scan.
    pub(super) fn whole(&self, n_scans: usize) -> ProgressBar {
        if n_scans < 2 {
            return ProgressBar::hidden();
        }
        let bar = self.bars.add(ProgressBar::new(n_scans as u64));
        set_style(&bar, "{bar:40} {pos} of {len} scans, {eta} left");
        bar.enable_steady_tick(Duration::from_secs(1));
        bar
    }

    /// The bar of one scan.
    pub(super) fn scan(&self, name: &str) -> Bar {
        let bar = self.bars.insert(0, ProgressBar::no_length());
        set_style(&bar, "{bar:40} {pos} of {len} planes  {msg}");
        bar.set_message(name.to_owned());
        Bar(bar)
    }
}

fn set_style(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
}

/// The bar of one scan; it goes away with it.
pub(super) struct Bar(ProgressBar);

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

impl Progress for Bar {
    fn planes(&self, done: usize, of: usize) {
        self.0.set_length(of as u64);
        self.0.set_position(done as u64);
    }
}
