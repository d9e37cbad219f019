//! Bytes of pipes and devices, which may keep a reader waiting for ever: read on a thread of their
//! own, so that a stop is heard meanwhile.
//!
//! The thread does nothing but wait, read and hand over; how far it is ahead is bounded. After a
//! stop it stays behind until what it waits for comes, or the process ends.

use std::io::{self, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::time::Duration;

use crate::cancel::Cancel;

/// Bytes asked for at a time.
const BLOCK_BYTES: usize = 256 << 10;

/// Blocks that wait to be taken.
const N_AHEAD: usize = 4;

/// How often a wait looks for a stop.
const LOOK: Duration = Duration::from_millis(20);

/// The error of a read that was stopped.
#[derive(Debug, thiserror::Error)]
#[error("interrupted")]
struct Stopped;

/// Whether an error is that of a read that was stopped.
pub(super) fn is_stopped(error: &io::Error) -> bool {
    error.get_ref().is_some_and(<dyn std::error::Error + Send + Sync>::is::<Stopped>)
}

/// A buffer, and how many bytes of it were read.
type Block = (Vec<u8>, usize);

/// A stream whose reads end when a stop is asked for.
pub(super) struct Waiting {
    full: Receiver<io::Result<Block>>,
    empty: Sender<Vec<u8>>,
    block: Block,
    taken: usize,
    cancel: Cancel,
}

impl Waiting {
    /// Of what `open` opens, which may wait too. Its error is that of the first read.
    pub(super) fn new<R: Read>(
        open: impl FnOnce() -> io::Result<R> + Send + 'static,
        cancel: &Cancel,
    ) -> io::Result<Self> {
        let (send, full) = sync_channel(N_AHEAD);
        let (empty, used) = channel();
        let thread = std::thread::Builder::new().name("input".to_owned());
        thread.spawn(move || hand_over(open, &send, &used))?;
        Ok(Self { full, empty, block: (Vec::new(), 0), taken: 0, cancel: cancel.clone() })
    }

    /// Takes the next block; an empty one at the end.
    fn advance(&mut self) -> io::Result<()> {
        let next = loop {
            if self.cancel.is_raised() {
                return Err(io::Error::other(Stopped));
            }
            match self.full.recv_timeout(LOOK) {
                Ok(block) => break block?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break (Vec::new(), 0),
            }
        };
        let (used, _) = std::mem::replace(&mut self.block, next);
        self.taken = 0;
        // The thread may have ended.
        let _ = self.empty.send(used);
        Ok(())
    }
}

impl Read for Waiting {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.block.1 && !out.is_empty() {
            self.advance()?;
        }
        let (bytes, end) = &self.block;
        let mut rest = bytes.get(self.taken..*end).unwrap_or_default();
        let n = rest.read(out)?;
        self.taken += n;
        Ok(n)
    }
}

/// Reads until there is no more, or nobody to take it.
fn hand_over<R: Read>(
    open: impl FnOnce() -> io::Result<R>,
    send: &SyncSender<io::Result<Block>>,
    used: &Receiver<Vec<u8>>,
) {
    let mut input = match open() {
        Ok(input) => input,
        Err(e) => return send.send(Err(e)).unwrap_or(()),
    };
    // A header is waited for; from there on whole blocks come at less cost.
    let mut least = 1;
    loop {
        let mut bytes = used.try_recv().unwrap_or_default();
        bytes.resize(BLOCK_BYTES, 0);
        let (n, go_on) = fill(&mut input, &mut bytes, least);
        if n > 0 && send.send(Ok((bytes, n))).is_err() {
            return;
        }
        match go_on {
            Ok(true) => least = BLOCK_BYTES,
            Ok(false) => return,
            Err(e) => return send.send(Err(e)).unwrap_or(()),
        }
    }
}

/// Reads at least so many bytes into `out`; how many there were, and whether there may be more.
fn fill(input: &mut impl Read, out: &mut [u8], least: usize) -> (usize, io::Result<bool>) {
    let mut n = 0;
    while n < least {
        match input.read(out.get_mut(n..).unwrap_or_default()) {
            Ok(0) => return (n, Ok(false)),
            Ok(more) => n += more,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return (n, Err(e)),
        }
    }
    (n, Ok(true))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives what it is asked for, a byte at a time in the end.
    struct Dribble(Vec<u8>);

    impl Read for Dribble {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let n = if self.0.len() > 5000 { 3000 } else { self.0.len().min(1) };
            let rest = self.0.split_off(n.min(out.len()));
            let bytes = std::mem::replace(&mut self.0, rest);
            (&bytes[..]).read(out)
        }
    }

    #[test]
    fn all_bytes_come_in_order() {
        let bytes: Vec<u8> = (0..1_000_003_u32).map(|n| (n % 251) as u8).collect();
        let source = Dribble(bytes.clone());
        let mut waiting = Waiting::new(|| Ok(source), &Cancel::new()).unwrap();
        let mut read = Vec::new();
        waiting.read_to_end(&mut read).unwrap();
        assert!(read == bytes);
        assert_eq!(waiting.read(&mut [0]).unwrap(), 0);
    }

    #[test]
    fn errors_come_after_what_was_read() {
        let failing = || io::Result::<io::Empty>::Err(io::ErrorKind::PermissionDenied.into());
        let mut waiting = Waiting::new(failing, &Cancel::new()).unwrap();
        let error = waiting.read(&mut [0]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::PermissionDenied);
    }

    #[test]
    fn a_stop_ends_a_wait() {
        let (_writer, reader) = channel::<u8>();
        let cancel = Cancel::new();
        let open = move || reader.recv().map(|_| io::empty()).map_err(io::Error::other);
        let mut waiting = Waiting::new(open, &cancel).unwrap();
        let raised = cancel.clone();
        std::thread::spawn(move || {
            std::thread::sleep(LOOK);
            raised.raise();
        });
        let error = waiting.read(&mut [0]).unwrap_err();
        assert!(is_stopped(&error));
    }
}
