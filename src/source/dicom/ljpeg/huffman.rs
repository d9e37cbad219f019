//! Huffman tables (T.81, annex C): codes to categories, and, where code and number together are
//! short, straight to differences.

use super::super::codestream::CodestreamError;

/// Bits that index the short table.
pub(super) const PEEK: u32 = 12;

/// What the next [`PEEK`] bits begin with.
#[derive(Clone, Copy, Default)]
pub(super) struct Entry {
    /// The difference.
    pub(super) value: i32,
    /// Bits of the code and the number behind it.
    pub(super) length: u8,
    /// Whether all of them are among the bits.
    pub(super) is_whole: bool,
}

/// The table of a DHT segment, as it stands there.
#[derive(Clone, Copy)]
pub(super) struct Table<'a> {
    /// Codes of each length from 1 on.
    counts: &'a [u8; 16],
    /// Their categories, by rising code.
    categories: &'a [u8],
}

/// A table made ready.
pub(super) struct Huffman {
    short: Vec<Entry>,
    /// For each length from 1 on: the first code, the codes, and which category is the first's.
    lengths: [(u32, u32, usize); 16],
    categories: [u8; 256],
}

impl<'a> Table<'a> {
    /// Splits the first table off `content`: its class, its number, the table and the rest.
    pub(super) fn split(content: &'a [u8]) -> Option<(u8, u8, Self, &'a [u8])> {
        let (&id, rest) = content.split_first()?;
        let (counts, rest) = rest.split_first_chunk::<16>()?;
        let n = counts.iter().map(|&count| usize::from(count)).sum();
        let (categories, rest) = rest.split_at_checked(n)?;
        Some((id >> 4, id & 0xF, Self { counts, categories }, rest))
    }
}

impl Huffman {
    /// Makes a table ready.
    ///
    /// # Errors
    /// More codes than their lengths allow; a category that no difference has.
    pub(super) fn new(table: Table<'_>) -> Result<Self, CodestreamError> {
        let mut categories = [0; 256];
        for (to, &category) in categories.iter_mut().zip(table.categories) {
            if category > 16 {
                let found = category.into();
                return Err(CodestreamError::Field { field: "SSSS", found, least: 0, most: 16 });
            }
            *to = category;
        }
        let mut lengths = [(0, 0, 0); 16];
        let (mut code, mut index) = (0_u32, 0);
        for ((to, &found), length) in lengths.iter_mut().zip(table.counts).zip(1_u8..) {
            let most = (1 << length) - code;
            let count = u32::from(found);
            if count > most {
                return Err(CodestreamError::TooManyCodes { length, found, most });
            }
            *to = (code, count, index);
            code = (code + count) << 1;
            index += usize::from(found);
        }
        let short = vec![Entry::default(); 1 << PEEK];
        let mut huffman = Self { short, lengths, categories };
        huffman.fill_short();
        Ok(huffman)
    }

    fn fill_short(&mut self) {
        for bits in 0..1_u32 << PEEK {
            let Some((length, category)) = self.code((bits << (16 - PEEK)) as u16) else {
                continue;
            };
            let extra = if category == 16 { 0 } else { category };
            let Some(rest) = PEEK.checked_sub(length + extra) else { continue };
            let number = bits >> rest & ((1 << extra) - 1);
            if let Some(entry) = self.short.get_mut(bits as usize) {
                let length = (length + extra) as u8;
                *entry = Entry { value: extend(number, category), length, is_whole: true };
            }
        }
    }

    /// What `bits`, [`PEEK`] of them, begin with.
    #[inline]
    pub(super) fn entry(&self, bits: usize) -> Entry {
        self.short.get(bits).copied().unwrap_or_default()
    }

    /// The length and the category of the code that `bits` begin with.
    pub(super) fn code(&self, bits: u16) -> Option<(u32, u32)> {
        for (&(first, count, index), length) in self.lengths.iter().zip(1_u32..) {
            let place = (u32::from(bits) >> (16 - length)).checked_sub(first)?;
            if place < count {
                let category = self.categories.get(index + place as usize)?;
                return Some((length, u32::from(*category)));
            }
        }
        None
    }
}

/// The difference of a category (0 to 16) that `number` numbers (T.81, F.2.2.1 and H.1.2.2).
pub(super) fn extend(number: u32, category: u32) -> i32 {
    match category {
        0 => 0,
        16 => 1 << 15,
        _ if number >> (category - 1) != 0 => number as i32,
        _ => number as i32 - (1 << category) + 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(counts: [u8; 16], categories: &[u8]) -> Result<Huffman, CodestreamError> {
        Huffman::new(Table { counts: &counts, categories })
    }

    #[test]
    fn codes_are_numbered_as_the_standard_has_it() {
        let mut counts = [0; 16];
        (counts[0], counts[2], counts[15]) = (1, 2, 1);
        let table = of(counts, &[5, 0, 16, 15]).unwrap();
        assert_eq!(table.code(0), Some((1, 5)));
        assert_eq!(table.code(0b1000 << 12), Some((3, 0)));
        assert_eq!(table.code(0b1010 << 12), Some((3, 16)));
        assert_eq!(table.code(0b1100 << 12), Some((16, 15)));
        assert_eq!(table.code(0b1100 << 12 | 1), None);
        let entry = table.entry(0b0_01111 << 6);
        assert_eq!((entry.value, entry.length, entry.is_whole), (-16, 6, true));
        assert_eq!(table.entry(0b101 << 9).value, 32_768);
        assert!(!table.entry(0b110 << 9).is_whole);
    }

    #[test]
    fn a_table_with_more_codes_than_bits_is_refused() {
        let mut counts = [0; 16];
        (counts[0], counts[1]) = (1, 3);
        let wanted = CodestreamError::TooManyCodes { length: 2, found: 3, most: 2 };
        assert_eq!(of(counts, &[0, 1, 2, 3]).err(), Some(wanted));
        let wanted = CodestreamError::Field { field: "SSSS", found: 17, least: 0, most: 16 };
        counts[1] = 0;
        assert_eq!(of(counts, &[17]).err(), Some(wanted));
    }
}
