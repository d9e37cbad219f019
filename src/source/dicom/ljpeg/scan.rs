//! The coded samples, line by line (T.81, H.1.2): a prediction from the neighbours before and a
//! difference, added modulo 2^16.

use super::bits::Bits;
use super::header::Header;
use crate::source::dicom::bits::Fault;

/// Decodes the first line after the start or a restart marker, each sample predicted by the one
/// before it and the first by half the range (T.81, H.1.2.1).
pub(super) fn first_line(
    bits: &mut Bits<'_>,
    header: &Header,
    line: &mut [u16],
) -> Result<(), Fault> {
    let mut a = 1 << (header.bits - header.point - 1);
    for to in line {
        a = (a + bits.difference(&header.table)?) & 0xFFFF;
        *to = a as u16;
    }
    Ok(())
}

/// Decodes a line below the line `above`, of the same length.
pub(super) fn line(
    bits: &mut Bits<'_>,
    header: &Header,
    above: &[u16],
    line: &mut [u16],
) -> Result<(), Fault> {
    match header.predictor {
        1 => predicted(bits, header, above, line, |a, _, _| a),
        2 => predicted(bits, header, above, line, |_, b, _| b),
        3 => predicted(bits, header, above, line, |_, _, c| c),
        4 => predicted(bits, header, above, line, |a, b, c| a + b - c),
        5 => predicted(bits, header, above, line, |a, b, c| a + ((b - c) >> 1)),
        6 => predicted(bits, header, above, line, |a, b, c| b + ((a - c) >> 1)),
        _ => predicted(bits, header, above, line, |a, b, _| (a + b) >> 1),
    }
}

/// Decodes a line with the predictor `predict` (T.81, table H.1), which is given the samples at the
/// left (a), above (b) and above at the left (c). The first sample is predicted by the one above.
#[inline]
fn predicted(
    bits: &mut Bits<'_>,
    header: &Header,
    above: &[u16],
    line: &mut [u16],
    predict: impl Fn(i32, i32, i32) -> i32,
) -> Result<(), Fault> {
    let first = above.first().map_or(0, |&b| i32::from(b));
    let (mut c, mut guess) = (first, first);
    let mut above = above.iter();
    above.next();
    for to in line {
        let a = (guess + bits.difference(&header.table)?) & 0xFFFF;
        *to = a as u16;
        let b = above.next().map_or(0, |&b| i32::from(b));
        guess = predict(a, b, c);
        c = b;
    }
    Ok(())
}
