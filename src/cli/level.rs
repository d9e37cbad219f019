//! Iso values as they are asked for: numbers, tissues of CT, and values that the volume itself says.

use std::fmt;

use crate::error::Error;
use crate::pipeline::RunError;
use crate::source::{self, SourceError, Volume};
use crate::volume::{Meta, Note};

/// What decides where a surface lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Level {
    /// At this real value.
    Value(f64),
    /// At a tissue's value in CT.
    Tissue(Tissue),
    /// Where Otsu's threshold parts the values.
    Auto,
    /// Half way between the two values of a volume that has no others.
    Halfway,
    /// Around the labels that are named.
    Labels,
}

/// A tissue that Hounsfield units tell from what is around it. The guide names the sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tissue {
    Lung,
    Skin,
    Fat,
    Soft,
    Bone,
}

impl Tissue {
    const ALL: [Self; 5] = [Self::Bone, Self::Soft, Self::Fat, Self::Skin, Self::Lung];

    fn name(self) -> &'static str {
        match self {
            Self::Lung => "lung",
            Self::Skin => "skin",
            Self::Fat => "fat",
            Self::Soft => "soft",
            Self::Bone => "bone",
        }
    }

    /// The value at which it begins, coming from air.
    fn hounsfield(self) -> f64 {
        match self {
            Self::Lung => -500.0,
            Self::Skin => -300.0,
            Self::Fat => -190.0,
            Self::Soft => -30.0,
            Self::Bone => 300.0,
        }
    }
}

/// The word in file names and reports: a number as short as it can be, or the name.
impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(iso) => write!(f, "{iso}"),
            Self::Tissue(tissue) => f.write_str(tissue.name()),
            Self::Auto => f.write_str("auto"),
            Self::Halfway => f.write_str("half"),
            Self::Labels => f.write_str("labels"),
        }
    }
}

/// Understands one `--iso`.
pub(crate) fn parse(text: &str) -> Result<Level, String> {
    let word = text.trim();
    if word == "auto" {
        return Ok(Level::Auto);
    }
    if let Some(tissue) = Tissue::ALL.into_iter().find(|t| t.name() == word) {
        return Ok(Level::Tissue(tissue));
    }
    match word.parse::<f64>() {
        Ok(iso) if iso.is_finite() => Ok(Level::Value(iso)),
        _ if word.contains(',') => {
            Err(format!("{text:?} is several values: give --iso once for each"))
        }
        _ => {
            let names: Vec<&str> = Tissue::ALL.into_iter().map(Tissue::name).collect();
            Err(format!("{text:?} is not a finite number, auto, {}", names.join(", ")))
        }
    }
}

/// A real value, and what is to be said of how it was found.
pub(crate) struct Chosen {
    pub(crate) iso: f64,
    pub(crate) note: Option<Note>,
}

impl Chosen {
    fn plain(iso: f64) -> Self {
        Self { iso, note: None }
    }

    fn told(iso: f64, note: String) -> Self {
        Self { iso, note: Some(Note::Other(note)) }
    }
}

/// The real value that is meant in the volume of these facts. `open` is called where its samples
/// must be looked at.
///
/// # Errors
/// A tissue in a volume that is no CT; a volume whose values say nothing.
pub(crate) fn resolve(
    level: Level,
    meta: &Meta,
    cancel: &crate::cancel::Cancel,
    open: impl FnOnce() -> Result<Volume<'static>, Error>,
) -> Result<Chosen, Error> {
    match level {
        Level::Value(iso) => Ok(Chosen::plain(iso)),
        Level::Labels => Ok(Chosen::plain(0.5)),
        Level::Tissue(tissue) => in_ct(tissue, meta.modality.as_deref()),
        Level::Auto => {
            let survey = source::survey(open()?, cancel).map_err(Error::new)?;
            let Some(iso) = survey.otsu else { return Err(Error::new(RunError::OneValue)) };
            Ok(Chosen::told(
                iso,
                format!(
                    "--iso auto is {iso}: Otsu's threshold, which parts the values in two groups most unlike each other"
                ),
            ))
        }
        Level::Halfway => {
            let half = source::two_values(open()?, cancel).map_err(Error::new)?;
            let Some(iso) = half else { return Err(Error::new(RunError::NoIso)) };
            Ok(Chosen::told(iso, format!("the volume holds two values: meshed at the half, {iso}")))
        }
    }
}

fn in_ct(tissue: Tissue, modality: Option<&str>) -> Result<Chosen, Error> {
    let (name, iso) = (tissue.name(), tissue.hounsfield());
    match modality {
        Some("CT") => Ok(Chosen::plain(iso)),
        None => Ok(Chosen::told(
            iso,
            format!("--iso {name} is {iso} if these are Hounsfield units; the file does not say"),
        )),
        Some(other) => Err(Error::new(SourceError::Other {
            kind: crate::Kind::UnfitSeries,
            message: format!("--iso {name} is a value of CT, the modality is {other}"),
            hint: Some("--iso auto, or a number; mcubes info suggests some".to_owned()),
        })),
    }
}
