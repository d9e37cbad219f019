//! Stored bytes to samples: byte order, BitsStored, HighBit, sign.

use std::ops::RangeInclusive;

use super::decode::Image;
use super::layout::{Layout, SampleKind};
use crate::volume::{Padding, Sample};

/// A sample type that integers of at most its size are handed on in.
pub(super) trait FromStored: Sample {
    /// The value of a stored integer, sign-extended.
    fn from_stored(value: i64) -> Self;
}

macro_rules! from_stored {
    ($($t:ty),*) => {$(
        impl FromStored for $t {
            fn from_stored(value: i64) -> Self {
                value as $t
            }
        }
    )*};
}

from_stored!(u8, i8, u16, i16, u32, i32);

/// Integers as they are stored; samples that are `padding` as [`padding_cells`] has it keep its value.
pub(super) fn integers<T: FromStored>(
    layout: &Layout,
    image: &Image,
    padding: Option<Padding>,
    stored: &[u8],
    out: &mut [T],
) {
    let size = layout.bytes;
    let whole = layout.bits_stored as usize == size * 8 && image.precision.is_none();
    let native_order = image.big == cfg!(target_endian = "big");
    let same_type = size_of::<T>() == size && layout.kind != SampleKind::Bit;
    if whole && native_order && same_type {
        // The bits are the value.
        let bytes: &mut [u8] = bytemuck::must_cast_slice_mut(out);
        let n = bytes.len().min(stored.len());
        if let (Some(to), Some(from)) = (bytes.get_mut(..n), stored.get(..n)) {
            to.copy_from_slice(from);
        }
        return;
    }
    each(layout, image, padding, stored, out.len(), |index, value| {
        if let Some(to) = out.get_mut(index) {
            *to = T::from_stored(value);
        }
    });
}

/// Samples of any kind through `real`, which is given stored values; `padding` as of [`integers`].
pub(super) fn real(
    layout: &Layout,
    image: &Image,
    padding: Option<Padding>,
    stored: &[u8],
    out: &mut [f64],
    real: impl Fn(f64) -> f64,
) {
    if layout.kind == SampleKind::Float {
        floats(layout, image, stored, out, real);
        return;
    }
    each(layout, image, padding, stored, out.len(), |index, value| {
        if let Some(to) = out.get_mut(index) {
            *to = real(value as f64);
        }
    });
}

/// Floats as they are stored, through `convert`.
pub(super) fn floats<T>(
    layout: &Layout,
    image: &Image,
    stored: &[u8],
    out: &mut [T],
    convert: impl Fn(f64) -> T,
) {
    if layout.bytes == 4 {
        for (to, from) in out.iter_mut().zip(stored.chunks_exact(4)) {
            let Some(&bytes) = from.first_chunk::<4>() else { continue };
            let value =
                if image.big { f32::from_be_bytes(bytes) } else { f32::from_le_bytes(bytes) };
            *to = convert(f64::from(value));
        }
    } else {
        for (to, from) in out.iter_mut().zip(stored.chunks_exact(8)) {
            let Some(&bytes) = from.first_chunk::<8>() else { continue };
            let value =
                if image.big { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) };
            *to = convert(value);
        }
    }
}

/// Where in a stored integer its value lies: the lowest bit, and how many there are.
fn value_bits(layout: &Layout, image: &Image) -> (u32, u32) {
    let below = layout.high_bit + 1 - layout.bits_stored;
    let Some(precision) = image.precision else { return (below, layout.bits_stored) };
    let precision = precision.clamp(1, layout.bytes as u32 * 8);
    // A codestream that reaches beyond HighBit holds the whole cells, with whatever lies in the
    // bits that BitsStored leaves unused (PS3.5, 8.1.1); any other holds values alone.
    let shift = if precision > layout.high_bit { below } else { 0 };
    // A value that a lossy codec carries past the range of BitsStored would wrap around to its
    // other end.
    let bits = if image.lossy { precision - shift } else { precision.min(layout.bits_stored) };
    (shift, bits)
}

/// The padding that whole cells are compared with, where `BitsStored` bits cannot hold it: some
/// scanners fill the corners with a value outside of them (63 536 in 12 bits), and what is left of
/// that without the upper bits is a value like any other.
fn padding_cells(layout: &Layout, padding: Option<Padding>) -> Option<RangeInclusive<i64>> {
    let Padding { low, high } = padding?;
    let bits = layout.bits_stored;
    if layout.high_bit + 1 != bits || bits as usize == layout.bytes * 8 {
        return None;
    }
    let all = match layout.kind {
        SampleKind::Unsigned => 0..=(1_i64 << bits) - 1,
        SampleKind::Signed => -(1_i64 << (bits - 1))..=(1_i64 << (bits - 1)) - 1,
        SampleKind::Bit | SampleKind::Float => return None,
    };
    let cells = low as i64..=high as i64;
    (!all.contains(cells.start()) || !all.contains(cells.end())).then_some(cells)
}

/// Calls `put` with the index and value of each of `n` stored integers.
fn each(
    layout: &Layout,
    image: &Image,
    padding: Option<Padding>,
    stored: &[u8],
    n: usize,
    mut put: impl FnMut(usize, i64),
) {
    if let Some(skipped) = image.packed.filter(|_| layout.kind == SampleKind::Bit) {
        let first = skipped as usize;
        for index in 0..n {
            let bit = first + index;
            let byte = stored.get(bit / 8).copied().unwrap_or(0);
            put(index, i64::from(byte >> (bit % 8) & 1));
        }
        return;
    }
    let (shift, bits) = value_bits(layout, image);
    // Left to the top of 64 bits, then back down with or without the sign.
    let up = 64 - bits - shift;
    let down = 64 - bits;
    let signed = layout.kind == SampleKind::Signed;
    let value = |raw: u64| {
        let top = raw << up;
        if signed { top as i64 >> down } else { (top >> down) as i64 }
    };
    // A loop of its own for the rare padding: the other one stays as fast as it is.
    let Some(padding) = padding_cells(layout, padding) else {
        cells(layout, image, stored, n, |index, raw| put(index, value(raw)));
        return;
    };
    let unused = 64 - 8 * layout.bytes as u32;
    cells(layout, image, stored, n, |index, raw| {
        let cell = if signed { (raw << unused) as i64 >> unused } else { raw as i64 };
        put(index, if padding.contains(&cell) { cell } else { value(raw) });
    });
}

/// Calls `put` with the index and the bits of each of `n` stored integers of whole bytes.
fn cells(layout: &Layout, image: &Image, stored: &[u8], n: usize, mut put: impl FnMut(usize, u64)) {
    match layout.bytes {
        1 => {
            for index in 0..n {
                put(index, u64::from(stored.get(index).copied().unwrap_or(0)));
            }
        }
        2 => {
            for (index, bytes) in stored.chunks_exact(2).take(n).enumerate() {
                let Some(&b) = bytes.first_chunk::<2>() else { continue };
                let raw = if image.big { u16::from_be_bytes(b) } else { u16::from_le_bytes(b) };
                put(index, u64::from(raw));
            }
        }
        _ => {
            for (index, bytes) in stored.chunks_exact(4).take(n).enumerate() {
                let Some(&b) = bytes.first_chunk::<4>() else { continue };
                let raw = if image.big { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) };
                put(index, u64::from(raw));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_the_bits_of_bits_stored_unless_the_codestream_has_fewer_or_is_lossy() {
        let of = |bits_stored, high_bit, precision, lossy| {
            let kind = SampleKind::Unsigned;
            let (rows, cols, bytes, big, swapped_pairs) = (1, 1, 2, false, false);
            let layout =
                Layout { rows, cols, kind, bytes, bits_stored, high_bit, big, swapped_pairs };
            let image = Image { precision, lossy, packed: None, big };
            let mut values = [0_u16; 2];
            integers(&layout, &image, None, &[0x01, 0x10, 0xF0, 0xFF], &mut values);
            values
        };
        assert_eq!(of(12, 11, None, false), [1, 0xFF0]);
        assert_eq!(of(12, 15, None, false), [0x100, 0xFFF]);
        assert_eq!(of(12, 11, Some(16), false), [1, 0xFF0]);
        assert_eq!(of(12, 15, Some(16), false), [0x100, 0xFFF]);
        assert_eq!(of(12, 15, Some(12), false), [1, 0xFF0]);
        assert_eq!(of(16, 15, Some(12), false), [1, 0xFF0]);
        // One above 4095, as a lossy codec may make of 4095.
        assert_eq!(of(12, 11, Some(16), true), [0x1001, 0xFFF0]);
    }
}
