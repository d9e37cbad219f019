//! The one place where foreign decoders run: a panic of theirs becomes an error.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Runs `decode`; nothing if it panics. The panic is not printed: a hook, put in place once in
/// front of whatever hook there was, is silent on a thread while it is in here.
pub(super) fn contain<T>(decode: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !GUARDED.get() {
                before(info);
            }
        }));
    });
    let outer = GUARDED.replace(true);
    let result = catch_unwind(AssertUnwindSafe(decode)).ok();
    GUARDED.set(outer);
    result
}

#[cfg(test)]
mod tests {
    use super::contain;

    #[test]
    fn a_panic_becomes_nothing_and_the_rest_goes_on() {
        assert_eq!(contain(|| -> u8 { panic!("a decoder's mistake") }), None);
        assert_eq!(contain(|| 7), Some(7));
    }
}
