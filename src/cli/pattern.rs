//! `--name`: a name with fields in braces, as typed. What the fields stand for is not known here.

use std::path::{Component, Path};

use super::usage::Usage;
use crate::source::dicom::PatientField;

/// A name with fields, as typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pattern(Vec<Piece>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece {
    Text(String),
    Field(Field),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Field {
    Stem,
    File,
    Parent,
    Series,
    Modality,
    Iso,
    Label,
    Patient(PatientField),
}

impl Field {
    const ALL: [(&'static str, Self); 9] = [
        ("stem", Self::Stem),
        ("file", Self::File),
        ("parent", Self::Parent),
        ("series", Self::Series),
        ("modality", Self::Modality),
        ("iso", Self::Iso),
        ("label", Self::Label),
        ("patient_id", Self::Patient(PatientField::Id)),
        ("patient_name", Self::Patient(PatientField::Name)),
    ];
}

impl Pattern {
    /// Understands `{field}` and text around it.
    pub(crate) fn parse(text: &str) -> Result<Self, Usage> {
        let wrong = |what: String| {
            let names: Vec<String> = Field::ALL.iter().map(|(n, _)| format!("{{{n}}}")).collect();
            Usage::new(format!("--name {text}: {what}"))
                .hint(format!("fields: {}", names.join(" ")))
        };
        let mut pieces = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            let Some((name, after)) = after.split_once('}') else {
                return Err(wrong("a { without }".to_owned()));
            };
            let field = Field::ALL.iter().find(|(n, _)| *n == name).map(|(_, field)| *field);
            let field = field.ok_or_else(|| wrong(format!("no field is called {{{name}}}")))?;
            pieces.extend([Piece::Text(before.to_owned()), Piece::Field(field)]);
            rest = after;
        }
        pieces.push(Piece::Text(rest.to_owned()));
        let leaves = Path::new(text)
            .components()
            .any(|c| !matches!(c, Component::Normal(_) | Component::CurDir));
        if leaves || text.chars().any(|c| c.is_control() || c == '\\') {
            return Err(wrong("it must stay below the output folder".to_owned()));
        }
        if text.trim_matches(['/', '.']).is_empty() {
            return Err(wrong("it is empty".to_owned()));
        }
        Ok(Self(pieces))
    }

    /// The text, with what each field stands for.
    pub(crate) fn filled(&self, field: impl Fn(Field) -> String) -> String {
        let piece = |piece: &Piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Field(name) => field(*name),
        };
        self.0.iter().map(piece).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_are_checked() {
        for text in ["{stem}", "{parent}/{stem}_{iso}", "a/{modality}/{series}{label}", "./{file}"]
        {
            assert!(Pattern::parse(text).is_ok(), "{text}");
        }
        for text in ["", "/", ".", "../{stem}", "/{stem}", "{stem", "{nope}", "a/../{stem}", "a\n"]
        {
            assert!(Pattern::parse(text).is_err(), "{text:?}");
        }
    }
}
