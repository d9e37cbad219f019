//! DICOM's RLE (PS3.5, annex G): PackBits, one segment a byte of the sample, high byte first.
//!
//! Written here because the library's decoder panics on short segments, believes the number of
//! segments, and takes no 32-bit samples.

/// What is wrong with an RLE frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum RleError {
    #[error("{found} bytes are too few for its header")]
    NoHeader { found: usize },
    #[error("{found} segments, expected {wanted}")]
    Segments { found: u32, wanted: usize },
    #[error("segment {segment} begins at byte {offset} of {len}")]
    Offset { segment: usize, offset: u32, len: usize },
    #[error("segment {segment} ends after {found} of {wanted} samples")]
    Short { segment: usize, found: usize, wanted: usize },
}

/// Decodes `n` samples of `bytes` bytes each, low byte first.
pub(super) fn decode(frame: &[u8], n: usize, bytes: usize) -> Result<Vec<u8>, RleError> {
    let word = |index: usize| {
        let bytes = frame.get(index * 4..).and_then(|b| b.first_chunk::<4>());
        bytes.map(|b| u32::from_le_bytes(*b)).ok_or(RleError::NoHeader { found: frame.len() })
    };
    // Sixteen words: the count and fifteen offsets.
    word(15)?;
    let found = word(0)?;
    if found as usize != bytes {
        return Err(RleError::Segments { found, wanted: bytes });
    }
    // Two bytes stand for 128 samples at most: a claim beyond that is not worth its memory.
    let most = frame.len().saturating_mul(64) / bytes.max(1);
    if most < n {
        return Err(RleError::Short { segment: 1, found: most, wanted: n });
    }
    let mut out = vec![0; n * bytes];
    for segment in 0..bytes {
        let offset = |segment: usize| {
            let (offset, len) = (word(segment + 1)?, frame.len());
            let within = offset >= 64 && offset as usize <= len;
            let wrong = RleError::Offset { segment: segment + 1, offset, len };
            if within { Ok(offset as usize) } else { Err(wrong) }
        };
        let begin = offset(segment)?;
        let end = if segment + 1 < bytes { offset(segment + 1)? } else { frame.len() };
        // Segments out of order are as good as empty.
        let packed = frame.get(begin..end).unwrap_or_default();
        let found = unpack(packed, &mut out, bytes - 1 - segment, bytes);
        if found < n {
            return Err(RleError::Short { segment: segment + 1, found, wanted: n });
        }
    }
    Ok(out)
}

/// Unpacks one segment into every `step`th byte from `first` on; how many there were.
fn unpack(packed: &[u8], out: &mut [u8], first: usize, step: usize) -> usize {
    let mut to = out.iter_mut().skip(first).step_by(step);
    let mut from = packed.iter().copied();
    let mut n = 0;
    while let Some(control) = from.next() {
        let control = control as i8;
        if control == -128 {
            continue;
        }
        let run = if control < 0 { from.next() } else { None };
        if control < 0 && run.is_none() {
            break;
        }
        let count = if control < 0 { 1 - i32::from(control) } else { 1 + i32::from(control) };
        for _ in 0..count {
            let Some(value) = run.or_else(|| from.next()) else { return n };
            let Some(to) = to.next() else { return n };
            *to = value;
            n += 1;
        }
    }
    n
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(segments: &[&[u8]]) -> Vec<u8> {
        let mut header = vec![segments.len() as u32];
        let mut at = 64;
        for s in segments {
            header.push(at);
            at += s.len() as u32;
        }
        header.resize(16, 0);
        let mut bytes: Vec<u8> = header.iter().flat_map(|w| w.to_le_bytes()).collect();
        bytes.extend(segments.iter().copied().flatten());
        bytes
    }

    #[test]
    fn literal_and_repeated_runs_make_samples_high_byte_first() {
        let high: &[u8] = &[2, 1, 2, 3];
        let low: &[u8] = &[0xFE, 9];
        assert_eq!(decode(&frame(&[high, low]), 3, 2), Ok(vec![9, 1, 9, 2, 9, 3]));
    }

    #[test]
    fn a_short_segment_is_reported_with_both_counts() {
        let short = RleError::Short { segment: 1, found: 2, wanted: 3 };
        assert_eq!(decode(&frame(&[&[1, 7, 8]]), 3, 1), Err(short));
        assert_eq!(decode(&[0; 12], 3, 1), Err(RleError::NoHeader { found: 12 }));
        let many = RleError::Segments { found: 40, wanted: 2 };
        let mut claims = frame(&[]);
        claims[0] = 40;
        assert_eq!(decode(&claims, 3, 2), Err(many));
    }
}
