//! Ctrl-C and SIGTERM: the run stops between slabs, its temporary files go, exit status 130.

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::cancel::Cancel;

/// The flag that the first such signal raises. The second ends the process at once, for a run that
/// waits for a reader which gives nothing; it may leave a temporary file, never one under a final
/// name.
pub(crate) fn cancel_on_signals() -> Cancel {
    let cancel = Cancel::new();
    #[cfg(unix)]
    let signals = [SIGINT, SIGTERM, SIGHUP];
    #[cfg(not(unix))]
    let signals = [SIGINT, SIGTERM];
    // Where no handler can be set, the system's own stays: the process ends at once.
    for signal in signals {
        let _ = flag::register_conditional_shutdown(signal, 130, cancel.flag());
        let _ = flag::register(signal, cancel.flag());
    }
    // A file that grows beyond what the user may write is then an error of the write, not the end.
    #[cfg(unix)]
    let _ = flag::register(SIGXFSZ, std::sync::Arc::default());
    cancel
}
