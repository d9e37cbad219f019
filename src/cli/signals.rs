//! Ctrl-C and SIGTERM: the run stops between slabs, its temporary files go, exit status 130.

use crate::cancel::Cancel;

/// The flag that the first such signal raises. The second ends the process at once, for a run that
/// waits for a reader which gives nothing; it may leave a temporary file, never one under a final
/// name.
pub(crate) fn cancel_on_signals() -> Cancel {
    let cancel = Cancel::new();
    let flag = cancel.clone();
    // Where no handler can be set, the system's own stays: the process ends at once.
    let _ = ctrlc::set_handler(move || {
        if flag.is_raised() {
            std::process::exit(130);
        }
        flag.raise();
    });
    cancel
}
