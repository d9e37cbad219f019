//! Ctrl-C and SIGTERM: the run stops between slabs, its temporary files go, exit status 130. A
//! command that writes no file ends where it is.

use std::thread;
use std::time::Duration;

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

/// The flag that the first such signal raises. Another one, [`SAME`] later, ends the process at once,
/// for a run whose output nobody takes; it may leave a temporary file, never one under a final name.
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
        thread::sleep(SAME);
        ends_at_once.raise();
    };
    // Without the thread one signal has to do.
    let _ = thread::Builder::new().name("signals".to_owned()).spawn(arm);
    hear_limits();
    cancel
}

/// Lets the first such signal end the process at once, with the same status: nothing waits to be
/// tidied up, and a mesh that is being read or measured looks at no flag.
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
