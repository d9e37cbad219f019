//! Values as they are typed: numbers, sizes, lists, ranges.
//!
//! Each parser takes one argument and says in one line what it wanted. Nothing here looks at other
//! options or at files.

use crate::phantom::Shape;
use crate::volume::StoredType;

/// One finite number.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("{text:?} is not a finite number")),
    }
}

/// One finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|v| if v > 0.0 { Ok(v) } else { Err("must be above 0".to_owned()) })
}

/// One finite number, 0 or above it.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|v| if v >= 0.0 { Ok(v) } else { Err("must not be below 0".to_owned()) })
}

/// Finite numbers divided by commas.
pub(crate) fn list(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(finite).collect()
}

/// A size in bytes: a whole number, or one with K, M, G or T (powers of 1024).
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let unit = text.get(digits.len()..).unwrap_or_default().to_ascii_uppercase();
    let shift = match unit.trim_end_matches('B').trim_end_matches('I') {
        "" => 0,
        "K" => 10,
        "M" => 20,
        "G" => 30,
        "T" => 40,
        _ => return Err(format!("{text:?} is not a size such as 800M or 4G")),
    };
    let number: u64 =
        digits.parse().map_err(|_| format!("{text:?} is not a size such as 800M or 4G"))?;
    match number.checked_mul(1 << shift) {
        Some(n) if n > 0 => Ok(n),
        _ => Err(format!("{text:?} is not between 1 byte and 16 EiB")),
    }
}

/// `I/N`: the I-th of N parts, from 1.
pub(crate) fn shard(text: &str) -> Result<(usize, usize), String> {
    let wanted = || format!("{text:?} is not I/N, such as 1/8 to 8/8");
    let (part, of) = text.split_once('/').ok_or_else(wanted)?;
    let (part, of) = (part.parse().map_err(|_| wanted())?, of.parse().map_err(|_| wanted())?);
    if 1 <= part && part <= of { Ok((part, of)) } else { Err(wanted()) }
}

/// `A:B,C:D,E:F`: three half-open ranges of indices, none of them empty.
pub(crate) fn index_ranges(text: &str) -> Result<[[usize; 2]; 3], String> {
    three_ranges(text, |part| {
        let index = |t: &str| t.trim().parse().map_err(|_| format!("{t:?} is not an index"));
        let (low, high) = ends(part)?;
        let (low, high) = (index(low)?, index(high)?);
        if low < high { Ok([low, high]) } else { Err(format!("the range {part} is empty")) }
    })
}

/// `A:B,C:D,E:F`: three closed ranges of coordinates, none of them backward.
pub(crate) fn ranges(text: &str) -> Result<[[f64; 2]; 3], String> {
    three_ranges(text, |part| {
        let (low, high) = ends(part)?;
        let (low, high) = (finite(low)?, finite(high)?);
        if low <= high { Ok([low, high]) } else { Err(format!("the range {part} is backward")) }
    })
}

fn ends(range: &str) -> Result<(&str, &str), String> {
    range.split_once(':').ok_or_else(|| format!("{range:?} is not a range FROM:TO"))
}

fn three_ranges<T>(
    text: &str,
    range: impl Fn(&str) -> Result<T, String>,
) -> Result<[T; 3], String> {
    let parts: Vec<&str> = text.split(',').collect();
    let found = parts.len();
    let parts: [&str; 3] =
        parts.try_into().map_err(|_| format!("expected three ranges, found {found}"))?;
    let [i, j, k] = parts.map(range);
    Ok([i?, j?, k?])
}

/// Three numbers, written `1x2x3` or `1,2,3`.
fn three<T>(text: &str, one: impl Fn(&str) -> Result<T, String>) -> Result<[T; 3], String> {
    let parts: Vec<&str> = text.split(['x', 'X', ',']).collect();
    let found = parts.len();
    let parts: [&str; 3] =
        parts.try_into().map_err(|_| format!("expected three numbers, found {found}"))?;
    let [a, b, c] = parts.map(one);
    Ok([a?, b?, c?])
}

/// `XxYxZ`: three whole numbers of at least 1.
pub(crate) fn dims(text: &str) -> Result<[i64; 3], String> {
    three(text, count)
}

/// `XxYxZ` in millimetres, each above zero.
pub(crate) fn spacing(text: &str) -> Result<[f64; 3], String> {
    three(text, positive)
}

/// `N`, or `XxYxZ`.
fn one_or_three<T: Copy>(
    text: &str,
    one: impl Fn(&str) -> Result<T, String>,
) -> Result<[T; 3], String> {
    if text.contains(['x', 'X', ',']) { three(text, one) } else { one(text).map(|n| [n; 3]) }
}

fn count(text: &str) -> Result<i64, String> {
    match text.trim().parse::<i64>() {
        Ok(n) if n >= 1 => Ok(n),
        _ => Err(format!("{text:?} is not a whole number of at least 1")),
    }
}

/// `N` or `XxYxZ`: whole numbers of at least 1.
pub(crate) fn sizes(text: &str) -> Result<[i64; 3], String> {
    one_or_three(text, count)
}

/// `N` or `NxMxK`: samples of a block.
pub(crate) fn block(text: &str) -> Result<[usize; 3], String> {
    sizes(text).map(|n| n.map(|n| usize::try_from(n).unwrap_or(usize::MAX)))
}

/// `S` or `XxYxZ` in millimetres, each above zero.
pub(crate) fn steps(text: &str) -> Result<[f64; 3], String> {
    one_or_three(text, positive)
}

/// `X,Y,Z` in millimetres.
pub(crate) fn point(text: &str) -> Result<[f64; 3], String> {
    three(text, finite)
}

/// A stored type by its word.
pub(crate) fn stored_type(text: &str) -> Result<StoredType, String> {
    StoredType::ALL.into_iter().find(|t| t.as_str() == text).ok_or_else(|| {
        let words: Vec<&str> = StoredType::ALL.iter().map(|t| t.as_str()).collect();
        format!("expected one of {}", words.join(", "))
    })
}

/// A phantom by its word; `skull-like` is the skull.
pub(crate) fn shape(text: &str) -> Result<Shape, String> {
    if text == "skull-like" { Ok(Shape::Skull) } else { text.parse() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triples_are_checked() {
        assert_eq!(dims("3x4x5"), Ok([3, 4, 5]));
        assert!(dims("3x0x5").is_err());
        assert!(dims("3x4").is_err());
        assert!(spacing("1x1x0").is_err());
        assert!(point("0,nan,1").is_err());
        assert_eq!(index_ranges("0:2,3:9,1:2"), Ok([[0, 2], [3, 9], [1, 2]]));
        assert!(index_ranges("2:2,0:1,0:1").is_err());
        assert!(index_ranges("0:1,0:1").is_err());
        assert_eq!(ranges("-2.5:-1,0:0,1e1:11"), Ok([[-2.5, -1.0], [0.0, 0.0], [10.0, 11.0]]));
        assert!(ranges("1:0,0:1,0:1").is_err() && ranges("0:nan,0:1,0:1").is_err());
        assert_eq!((block("2"), block("1x2x3")), (Ok([2; 3]), Ok([1, 2, 3])));
        assert!(block("0").is_err() && block("1x2").is_err() && block("2.5").is_err());
        assert_eq!((steps("0.5"), steps("1,2,3")), (Ok([0.5; 3]), Ok([1.0, 2.0, 3.0])));
        assert!(not_negative("-1").is_err() && not_negative("NaN").is_err());
    }

    #[test]
    fn sizes_have_binary_units() {
        for (text, bytes) in [("7", 7), ("3k", 3 << 10), ("800M", 800 << 20), ("4GiB", 4 << 30)] {
            assert_eq!(super::bytes(text), Ok(bytes), "{text}");
        }
        for text in ["", "M", "-1", "1.5G", "4X", "0", "99999999999T", "1 G B"] {
            assert!(super::bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn only_the_skull_is_like_something() {
        assert_eq!((shape("skull"), shape("skull-like")), (Ok(Shape::Skull), Ok(Shape::Skull)));
        for text in ["torus-like", "skull-like-like", "-like", "Skull"] {
            assert!(shape(text).is_err(), "{text}");
        }
    }

    #[test]
    fn shards_count_from_one() {
        assert_eq!(shard("1/1"), Ok((1, 1)));
        assert_eq!(shard("3/8"), Ok((3, 8)));
        for text in ["0/3", "4/3", "1", "1/0", "a/b", "-1/2"] {
            assert!(shard(text).is_err(), "{text}");
        }
    }
}
