//! Writes lossless JPEG (ITU-T T.81, process 14, predictor 1): one component.

/// The codestream of an image of 16 bits.
pub(crate) fn encode(samples: &[u16], cols: u16) -> Vec<u8> {
    encode_bits(samples, cols, 16)
}

/// The codestream of an image of `bits` bits.
pub(crate) fn encode_bits(samples: &[u16], cols: u16, bits: u8) -> Vec<u8> {
    let rows = (samples.len() / usize::from(cols)) as u16;
    let half = 1 << (bits - 1);
    let mut out = vec![0xFF, 0xD8, 0xFF, 0xC3, 0, 11, bits];
    out.extend(rows.to_be_bytes());
    out.extend(cols.to_be_bytes());
    out.extend([1, 1, 0x11, 0]);
    // The 17 categories of differences, each in 5 bits.
    out.extend([0xFF, 0xC4, 0, 36, 0]);
    out.extend([0, 0, 0, 0, 17, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    out.extend(0..=16);
    out.extend([0xFF, 0xDA, 0, 8, 1, 1, 0, 1, 0, 0]);
    let (mut bits, mut n) = (0_u64, 0);
    for (at, &sample) in samples.iter().enumerate() {
        let predicted = match at {
            0 => half,
            _ if at % usize::from(cols) == 0 => samples[at - usize::from(cols)],
            _ => samples[at - 1],
        };
        let difference = sample.wrapping_sub(predicted) as i16;
        let category = 16 - difference.unsigned_abs().leading_zeros();
        let low = i32::from(difference) - i32::from(difference < 0);
        // The one difference of category 16 has no bits of its own.
        let extra = if category == 16 { 0 } else { category };
        bits = bits << 5 | u64::from(category);
        bits = bits << extra | u64::from(low as u32) & ((1 << extra) - 1);
        n += 5 + extra;
        while n >= 8 {
            n -= 8;
            push(&mut out, (bits >> n) as u8);
        }
    }
    if n > 0 {
        push(&mut out, (bits << (8 - n)) as u8 | 0xFF >> n);
    }
    out.extend([0xFF, 0xD9]);
    out
}

/// A byte of coded data; FF is followed by a zero, or it would begin a marker.
fn push(out: &mut Vec<u8>, byte: u8) {
    out.push(byte);
    if byte == 0xFF {
        out.push(0);
    }
}
