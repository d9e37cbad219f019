//! Ctrl-C and SIGTERM: the run stops between slabs, its temporary files go, exit status 130. A
//! command that writes no file ends where it is.

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::cancel::Cancel;

#[cfg(unix)]
const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

/// The flag that the first such signal raises. The second ends the process at once, for a run whose
/// output nobody takes; it may leave a temporary file, never one under a final name.
pub(crate) fn cancel_on_signals() -> Cancel {
    let cancel = Cancel::new();
    // Where no handler can be set, the system's own stays: the process ends at once.
    for signal in SIGNALS {
        let _ = flag::register_conditional_shutdown(signal, 130, cancel.flag());
        let _ = flag::register(signal, cancel.flag());
    }
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
