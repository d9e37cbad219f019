//! Ctrl-C and SIGTERM: the run stops between slabs, its temporary files go, exit status 130. A
//! command that has nothing to tidy up or to tell ends where it is.

use std::process;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::cancel::Cancel;

#[cfg(unix)]
const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// A signal so soon after another one is the same: `timeout` sends its own twice, to the process and to
/// its group.
const SAME: Duration = Duration::from_secs(1);

/// How often a look is taken at whether there was a signal.
const LOOK: Duration = Duration::from_millis(100);

/// How many writes are going on that a reader may keep waiting for ever.
static WRITES: AtomicUsize = AtomicUsize::new(0);

/// Writes to what may be a pipe that nobody reads: a signal ends the process if this goes on for as
/// long as [`SAME`] after it, since the write looks at no flag.
pub(crate) fn while_taken<R>(write: impl FnOnce() -> R) -> R {
    WRITES.fetch_add(1, Ordering::Relaxed);
    let written = write();
    WRITES.fetch_sub(1, Ordering::Relaxed);
    written
}

/// The flag that the first such signal raises. Another one, [`SAME`] later, ends the process at once;
/// it may leave a temporary file, never one under a final name.
pub(crate) fn cancel_on_signals() -> Cancel {
    let (cancel, ends_at_once) = (Cancel::new(), Cancel::new());
    // Where no handler can be set, the system's own stays: the process ends at once.
    for signal in SIGNALS {
        let _ = flag::register_conditional_shutdown(signal, 130, ends_at_once.flag());
        let _ = flag::register(signal, cancel.flag());
    }
    let raised = cancel.clone();
    let arm = move || {
        while !raised.is_raised() {
            thread::sleep(LOOK);
        }
        let raised_at = Instant::now();
        let mut is_stuck = true;
        while raised_at.elapsed() < SAME {
            thread::sleep(LOOK);
            is_stuck &= WRITES.load(Ordering::Relaxed) > 0;
        }
        if is_stuck {
            process::exit(130);
        }
        ends_at_once.raise();
    };
    // Without the thread one signal has to do.
    let _ = thread::Builder::new().name("signals".to_owned()).spawn(arm);
    hear_limits();
    cancel
}

/// Lets the first such signal end the process at once, with the same status: nothing waits to be
/// tidied up.
pub(crate) fn end_on_signals() {
    let raised = Cancel::new();
    raised.raise();
    for signal in SIGNALS {
        let _ = flag::register_conditional_shutdown(signal, 130, raised.flag());
    }
    hear_limits();
}

/// A file that grows beyond what the user may write is an error of the write, not the end.
fn hear_limits() {
    #[cfg(unix)]
    let _ = flag::register(SIGXFSZ, std::sync::Arc::default());
}
