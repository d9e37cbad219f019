//! Values out of the elements kept: text, numbers, sequences, each checked once.

use dicom_object::InMemDicomObject;
use dicom_transfer_syntax_registry::entries;

use super::element::Encoding;
use super::error::{FileFault, Tag};
use super::guard::contain;
use super::walk::Walked;

/// A data set, or an item of a sequence.
pub(super) type Item = InMemDicomObject;

/// Parses the elements kept by the walk.
///
/// # Errors
/// Elements that `dicom-object` cannot make sense of.
pub(super) fn parse(walked: &Walked) -> Result<Item, FileFault> {
    let syntax = match walked.encoding {
        Encoding { explicit: true, big: true } => entries::EXPLICIT_VR_BIG_ENDIAN.erased(),
        Encoding { explicit: true, big: false } => entries::EXPLICIT_VR_LITTLE_ENDIAN.erased(),
        Encoding { explicit: false, .. } => entries::IMPLICIT_VR_LITTLE_ENDIAN.erased(),
    };
    contain(|| Item::read_dataset_with_ts(walked.kept.as_slice(), &syntax))
        .and_then(Result::ok)
        .ok_or(FileFault::BadElement { tag: Tag(8, 5), what: "the elements after it do not parse" })
}

fn tag(tag: Tag) -> dicom_core::Tag {
    dicom_core::Tag(tag.0, tag.1)
}

/// The items of a sequence; none where it is absent or no sequence.
pub(super) fn items(item: &Item, of: Tag) -> &[Item] {
    item.get(tag(of)).and_then(|e| e.value().items()).unwrap_or_default()
}

/// The values of an element as text, without padding; none where it is absent or empty.
pub(super) fn texts(item: &Item, of: Tag) -> Vec<String> {
    let Some(values) = item
        .get(tag(of))
        .and_then(|e| e.value().primitive())
        .map(|v| v.to_multi_str().into_owned())
    else {
        return Vec::new();
    };
    let values: Vec<String> = values
        .iter()
        .map(|v| v.trim_matches(|c: char| c == '\0' || c.is_whitespace()).to_owned())
        .collect();
    if values.iter().all(String::is_empty) { Vec::new() } else { values }
}

/// The first value as text.
pub(super) fn text(item: &Item, of: Tag) -> Option<String> {
    texts(item, of).into_iter().next().filter(|t| !t.is_empty())
}

/// Text for people: all values, without control characters, not too long.
pub(super) fn label(item: &Item, of: Tag) -> Option<String> {
    let joined = texts(item, of).join("\\");
    let clean: String = joined.chars().filter(|c| !c.is_control()).take(128).collect();
    (!clean.is_empty()).then_some(clean)
}

/// All values as finite numbers; none where the element is absent or empty.
///
/// # Errors
/// A value that is no finite number.
pub(super) fn numbers(
    item: &Item,
    of: Tag,
    attribute: &'static str,
) -> Result<Vec<f64>, FileFault> {
    texts(item, of)
        .iter()
        .map(|t| {
            t.parse::<f64>()
                .ok()
                .filter(|v| v.is_finite())
                .ok_or_else(|| bad(attribute, t, "a decimal number"))
        })
        .collect()
}

/// The first value as a finite number.
///
/// # Errors
/// A value that is no finite number.
pub(super) fn number(
    item: &Item,
    of: Tag,
    attribute: &'static str,
) -> Result<Option<f64>, FileFault> {
    Ok(numbers(item, of, attribute)?.first().copied())
}

/// The first value as a number, be it infinite; none where it is NaN or no number.
pub(super) fn float(item: &Item, of: Tag) -> Option<f64> {
    text(item, of)?.parse::<f64>().ok().filter(|v| !v.is_nan())
}

/// As many numbers as wanted; none where the element is absent or empty.
///
/// # Errors
/// A value that is no finite number, or another count.
pub(super) fn vector<const N: usize>(
    item: &Item,
    of: Tag,
    attribute: &'static str,
    wanted: &'static str,
) -> Result<Option<[f64; N]>, FileFault> {
    let values = numbers(item, of, attribute)?;
    if values.is_empty() {
        return Ok(None);
    }
    let count = values.len();
    <[f64; N]>::try_from(values).map(Some).map_err(|_| FileFault::BadValue {
        attribute,
        found: format!("{count} numbers"),
        wanted,
    })
}

/// The first value as a whole number.
///
/// # Errors
/// A value that is no whole number.
pub(super) fn integer(
    item: &Item,
    of: Tag,
    attribute: &'static str,
) -> Result<Option<i64>, FileFault> {
    let Some(found) = text(item, of) else { return Ok(None) };
    let value = found.parse::<i64>().ok();
    // Decimal strings with a fraction of zero occur where integers belong.
    let value = value.or_else(|| {
        found.parse::<f64>().ok().filter(|v| v.fract() == 0.0 && v.abs() < 1e15).map(|v| v as i64)
    });
    value.map(Some).ok_or_else(|| bad(attribute, &found, "a whole number"))
}

/// A value that cannot be, for an error: shortened and without control characters.
pub(super) fn bad(attribute: &'static str, found: &str, wanted: &'static str) -> FileFault {
    let clean: String = found.chars().filter(|c| !c.is_control()).take(40).collect();
    let is_number = clean.parse::<i64>().is_ok();
    let found = if is_number { clean } else { format!("\"{clean}\"") };
    FileFault::BadValue { attribute, found, wanted }
}
