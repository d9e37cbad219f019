//! The coded bits between two markers of a JPEG stream: takes out what is stuffed after FF, and holds
//! bits until they are taken. Knows no codes and no samples; never reads past a marker.

/// Why no more bits could be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// A marker, or the end of the data.
    End,
    /// A code that the process, or the stream's table, does not have.
    Code,
}

/// How a process tells FF that is data from FF that begins a marker.
pub(super) trait Stuffing: Default {
    /// The most bits of anything that an encoder adds to fill its last byte.
    const FILL: u32;

    /// Whether bytes other than FF are eight bits of data here.
    fn is_plain(&self) -> bool;

    /// The bits of the first of these bytes, how many they are, and how many bytes they take up;
    /// nothing where a marker begins.
    fn next(&mut self, bytes: &[u8]) -> Option<(u8, u32, usize)>;
}

/// Reads bits, the highest of a byte first.
pub(super) struct Bits<'a, S> {
    data: &'a [u8],
    /// The next byte that is not in `cache`.
    pos: usize,
    stuffing: S,
    /// Bits not yet taken, from the top; zero below the `held` topmost.
    pub(super) cache: u64,
    /// At most 63.
    pub(super) held: u32,
}

const LOW: u64 = 0x0101_0101_0101_0101;
const HIGH: u64 = 0x8080_8080_8080_8080;

impl<'a, S: Stuffing> Bits<'a, S> {
    /// Coded data that begin at `pos`.
    pub(super) fn new(data: &'a [u8], pos: usize) -> Self {
        Self { data, pos, stuffing: S::default(), cache: 0, held: 0 }
    }

    /// How far the data have been looked at: after [`Fault::End`] or [`Self::finish`], where the
    /// marker stands or the data end.
    pub(super) fn pos(&self) -> usize {
        self.pos
    }

    /// Brings the cache to at least 48 bits, unless a marker or the end comes first.
    #[inline]
    pub(super) fn refill(&mut self) {
        if self.stuffing.is_plain()
            && let Some(chunk) = self.data.get(self.pos..).and_then(|d| d.first_chunk::<8>())
        {
            let word = u64::from_be_bytes(*chunk);
            // The usual test for a zero byte, of the complement.
            if (!word).wrapping_sub(LOW) & word & HIGH == 0 {
                let bytes = (63 - self.held) / 8;
                let held = self.held + 8 * bytes;
                self.cache |= (word >> self.held) & !(u64::MAX >> held);
                self.held = held;
                self.pos += bytes as usize;
                return;
            }
        }
        self.refill_by_bytes();
    }

    #[inline(never)]
    fn refill_by_bytes(&mut self) {
        while self.held <= 55 {
            let bytes = self.data.get(self.pos..).unwrap_or_default();
            let Some((bits, width, n_bytes)) = self.stuffing.next(bytes) else { return };
            self.cache |= u64::from(bits) << (64 - width - self.held);
            self.held += width;
            self.pos += n_bytes;
        }
    }

    /// Drops `count` bits that are known to be held, at most 63.
    #[inline]
    pub(super) fn drop_held(&mut self, count: u32) {
        self.cache <<= count;
        self.held -= count;
    }

    /// Takes `count` bits that are known to be held, at most 31.
    #[inline]
    pub(super) fn take_held(&mut self, count: u32) -> u32 {
        let number = (self.cache >> 1 >> (63 - count)) as u32;
        self.drop_held(count);
        number
    }

    /// Goes on to the marker that ends the data, over what an encoder adds to fill its last byte:
    /// [`Stuffing::FILL`] bits of anything, then zeros.
    pub(super) fn finish(&mut self) -> Result<(), Fault> {
        self.refill_by_bytes();
        self.drop_held(self.held.min(S::FILL));
        loop {
            if self.cache != 0 {
                return Err(Fault::Code);
            }
            self.held = 0;
            self.refill_by_bytes();
            if self.held == 0 {
                return Ok(());
            }
        }
    }
}
