//! Ctrl-C and SIGTERM: the run stops between slabs, its temporary files go, exit status 130.

use crate::cancel::Cancel;

/// The flag that those signals raise.
pub(crate) fn cancel_on_signals() -> Cancel {
    let cancel = Cancel::new();
    let flag = cancel.clone();
    // Where no handler can be set, the system's own stays: the process ends at once.
    let _ = ctrlc::set_handler(move || flag.raise());
    cancel
}
