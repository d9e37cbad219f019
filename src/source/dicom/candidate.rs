//! One candidate volume: its frames in order, what is known of it, and what stands in its way.

use super::doubles::drop_doubles;
use super::error::{DicomError, FileFault};
use super::instance::{Frame, Instance, frame_name};
use super::order::{self, ArrangeError, Arranged, Missing};
use super::series::{self, FrameRef, Group};
use super::syntax;
use crate::cancel::Cancel;
use crate::geom::Grid;
use crate::geom::vec3::Vec3;
use crate::volume::{Meta, Note, Padding, Rescale, SeriesFacts, SourceFormat};

/// Slices added at most to a segmentation that leaves out empty frames.
const MOST_FILLED: usize = 1 << 16;

/// Gaps that differ by less than this part are told as equal.
const EVEN: f64 = 0.005;

/// A volume that a study holds, or nearly holds.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// From 1, as `--series` counts.
    pub number: usize,
    /// Modality (CT, MR, ...).
    pub modality: Option<String>,
    /// The series it is part of.
    pub series: SeriesFacts,
    /// What sets it apart from other volumes of the same series, in words.
    pub apart: Option<String>,
    /// Columns, rows, slices.
    pub dims: [usize; 3],
    /// All that is known, where the images have a place. Present for volumes that are refused for
    /// a gap, too.
    pub meta: Option<Meta>,
    /// Why it cannot be meshed, if so.
    pub problem: Option<DicomError>,
    /// Whether it is a segmentation (0 and 1, or labels; the surface is at 0.5).
    pub is_segmentation: bool,
    pub(super) frames: Vec<FrameRef>,
    pub(super) uniform: bool,
    /// Whether it is what there is of a repeat that was broken off.
    pub(super) broken_off: bool,
}

impl Candidate {
    /// What `problem` there is, given whether gaps are to be spanned.
    pub(super) fn obstacle(&self, span_gaps: bool) -> Option<&DicomError> {
        self.problem
            .as_ref()
            .filter(|p| !(span_gaps && matches!(p, DicomError::MissingSlices { .. })))
    }

    /// Whether it has slices in space and is no fragment, whatever else is wrong with it.
    pub(super) fn is_plausible(&self) -> bool {
        self.meta.is_some() && !self.broken_off
    }

    /// A line for lists: number, series, size.
    pub fn title(&self) -> String {
        let [nx, ny, nz] = self.dims;
        let mut parts = Vec::new();
        parts.extend(self.modality.clone());
        parts.extend(self.series.number.as_ref().map(|n| format!("series {n}")));
        parts.extend(self.series.description.as_ref().map(|d| format!("\"{d}\"")));
        parts.extend(self.apart.clone());
        format!("{} ({}), {nx} x {ny} x {nz}", self.number, parts.join(", "))
    }
}

/// Makes a candidate of a group that is split as far as it goes. Its number is given later.
///
/// Where the run is stopped meanwhile, what comes back is not to be used.
pub(super) fn assess(
    mut group: Group,
    instances: &[Instance],
    cancel: &Cancel,
) -> Option<Candidate> {
    let n_images = group.frames.len();
    let (first, _) = group.frames.first()?.get(instances)?;
    let runs = series::sort(&mut group, instances);
    let mut notes: Vec<Note> = first.odd.iter().map(|odd| Note::Other((*odd).to_owned())).collect();
    let (frames, doubles) = drop_doubles(&group, &runs, instances, cancel, &mut notes);
    let mut candidate = Candidate {
        number: 0,
        modality: first.modality.clone(),
        series: facts(&group, instances, n_images),
        apart: (!group.apart.is_empty()).then(|| group.apart.join(", ")),
        dims: [first.layout.cols, first.layout.rows, frames.len()],
        meta: None,
        problem: None,
        is_segmentation: first.is_segmentation,
        frames,
        uniform: true,
        broken_off: group.broken_off,
    };
    let problem = place(&mut candidate, &group, instances, notes);
    let file = || file_problem(&candidate, instances);
    candidate.problem = match problem {
        // What is wrong with a file that stands alone says more than that it stands alone.
        Some(problem @ (DicomError::TooFew { .. } | DicomError::NoGeometry { .. })) => {
            file().or(Some(problem))
        }
        problem @ (None | Some(DicomError::MissingSlices { .. })) => file().or(doubles).or(problem),
        problem => problem,
    };
    Some(candidate)
}

fn facts(group: &Group, instances: &[Instance], n_images: usize) -> SeriesFacts {
    let first = group.frames.first().and_then(|r| r.get(instances)).map(|(i, _)| i);
    let mut transfer_syntaxes: Vec<String> =
        group.frames.iter().filter_map(|r| Some(r.get(instances)?.0.syntax.clone())).collect();
    transfer_syntaxes.sort();
    transfer_syntaxes.dedup();
    SeriesFacts {
        uid: first.map(|i| i.series_uid.clone()).unwrap_or_default(),
        number: first.and_then(|i| i.series_number.clone()),
        description: first.and_then(|i| i.description.clone()),
        n_images,
        tilt_degrees: 0.0,
        transfer_syntaxes,
    }
}

/// Finds a candidate's geometry, or why it has none.
fn place(
    candidate: &mut Candidate,
    group: &Group,
    instances: &[Instance],
    mut notes: Vec<Note>,
) -> Option<DicomError> {
    let (first, frame) = candidate.frames.first().or(group.frames.first())?.get(instances)?;
    if first.is_mosaic {
        return Some(DicomError::Mosaic);
    }
    let Some(facing) = group.facing else {
        candidate.dims[2] = group.frames.len();
        return Some(no_geometry(group, instances));
    };
    let positions: Vec<Vec3> =
        candidate.frames.iter().filter_map(|r| r.get(instances)?.1.position).collect();
    // Frames without a single sample of the segment may be left out (PS3.3, C.8.20.2).
    let alone = frame.slice_spacing;
    let omitting = alone.filter(|&s| first.is_segmentation && s > 0.0);
    let arranged = match order::arrange(&facing, &positions, alone, omitting) {
        Ok(Arranged { missing: Some(missing), .. })
            if first.is_segmentation && missing.count <= MOST_FILLED =>
        {
            let filled = missing.fill(&positions, &mut candidate.frames, FrameRef::EMPTY);
            candidate.dims[2] = filled.len();
            order::arrange(&facing, &filled, alone, omitting)
        }
        arranged => arranged,
    };
    let arranged = match arranged {
        Ok(arranged) => arranged,
        Err(ArrangeError::TooFew) => {
            let (images, name) = (group.frames.len(), first.name.clone());
            return Some(DicomError::TooFew { images, name, left_out: String::new() });
        }
        Err(ArrangeError::Flat) => {
            let what = "positions and orientation give no volume".to_owned();
            return Some(DicomError::NoGeometry { what, names: first.name.clone() });
        }
        Err(ArrangeError::Dims(error)) => {
            let fault = FileFault::Dims(error);
            return Some(DicomError::File { name: first.name.clone(), fault, more: 0 });
        }
    };
    candidate.series.tilt_degrees = arranged.tilt_degrees;
    let missing = arranged.missing;
    if let Some(gaps) = arranged.gaps_mm.as_ref().filter(|_| missing.is_none()) {
        notes.push(uneven(gaps, arranged.off_mm));
    }
    if candidate.dims[2] == 1 {
        notes.push(Note::Other(
            "one slice alone: its mesh is flat, whatever the slice's thickness".to_owned(),
        ));
    }
    let meta = meta(candidate, arranged.grid, arranged.gaps_mm, first, instances, notes);
    candidate.meta = Some(meta);
    missing.map(|m| missing_error(&m, candidate, instances, String::new()))
}

/// The error for missing slices, with the names of the files around each gap.
fn missing_error(
    missing: &Missing,
    candidate: &Candidate,
    instances: &[Instance],
    faults: String,
) -> DicomError {
    let name = |k: usize| {
        candidate.frames.get(k).and_then(|r| r.get(instances)).map_or_else(String::new, frame_name)
    };
    missing.error(name, faults)
}

fn uneven(gaps: &[f64], off_mm: f64) -> Note {
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let most = gaps.iter().copied().fold(0.0, f64::max);
    if most - least < EVEN * least {
        return Note::Other(format!(
            "the slices do not lie on one line, up to {off_mm:.2} mm beside it: each is meshed where it lies"
        ));
    }
    Note::Other(format!(
        "the slices are unevenly spaced ({least:.2} to {most:.2} mm): each is meshed where it lies"
    ))
}

fn meta(
    candidate: &mut Candidate,
    grid: Grid,
    gaps_mm: Option<Vec<f64>>,
    first: &Instance,
    instances: &[Instance],
    notes: Vec<Note>,
) -> Meta {
    let all: Vec<_> = candidate.frames.iter().filter_map(|r| r.get(instances)).collect();
    let scale = all.first().map(|(_, f)| (f.slope, f.inter));
    let padding = all.first().map(|(i, _)| i.padding);
    let stored = first.layout.stored_type();
    candidate.uniform = all.iter().all(|(i, f)| {
        Some((f.slope, f.inter)) == scale
            && Some(i.padding) == padding
            && i.layout.stored_type() == stored
    });
    let rescale = scale.filter(|_| candidate.uniform).and_then(|(s, i)| Rescale::new(s, i));
    let description = [candidate.series.description.clone(), candidate.apart.clone()];
    let description = description.into_iter().flatten().collect::<Vec<_>>().join(", ");
    Meta {
        rescale: rescale.unwrap_or(Rescale::IDENTITY),
        padding: padding.flatten().filter(|_| candidate.uniform),
        uneven_padding: uneven_padding(&all).filter(|_| !candidate.uniform),
        modality: candidate.modality.clone(),
        series: Some(candidate.series.clone()),
        gaps_mm,
        description: (!description.is_empty()).then_some(description),
        notes,
        ..Meta::plain(SourceFormat::Dicom, grid, stored)
    }
}

/// The least and the greatest real value of padding in any image.
fn uneven_padding(all: &[(&Instance, &Frame)]) -> Option<Padding> {
    let ends = all.iter().filter_map(|(instance, frame)| {
        let Padding { low, high } = instance.padding?;
        let rescale = Rescale::new(frame.slope, frame.inter).unwrap_or(Rescale::IDENTITY);
        Some([rescale.real(low), rescale.real(high)])
    });
    ends.flatten().fold(None, |range: Option<Padding>, x| {
        let Padding { low, high } = range.unwrap_or(Padding { low: x, high: x });
        Some(Padding { low: low.min(x), high: high.max(x) })
    })
}

fn no_geometry(group: &Group, instances: &[Instance]) -> DicomError {
    let mut what = Vec::new();
    let all: Vec<_> = group.frames.iter().filter_map(|r| r.get(instances)).collect();
    let mut absent = |name: &str, is: bool| {
        if is {
            what.push(name.to_owned());
        }
    };
    let unplaced = all.iter().find_map(|(_, f)| f.unplaced);
    let unknown = |f: &Frame| f.position.is_none() && f.unplaced.is_none();
    absent("ImagePositionPatient", all.iter().any(|(_, f)| unknown(f)));
    absent("ImageOrientationPatient", all.iter().any(|(_, f)| f.orientation.is_none()));
    absent("PixelSpacing", all.iter().any(|(_, f)| f.spacing.is_none()));
    let mut names: Vec<&str> = all.iter().map(|(i, _)| i.name.as_str()).collect();
    names.dedup();
    let more = names.len().saturating_sub(3);
    names.truncate(3);
    let mut names = names.join(", ");
    if more > 0 {
        names = format!("{names} and {more} more");
    }
    let absent = what.iter().map(|name| format!("no {name}"));
    let what: Vec<String> = unplaced.map(str::to_owned).into_iter().chain(absent).collect();
    DicomError::NoGeometry { what: what.join(", "), names }
}

/// The first fault among the files that make up a candidate.
fn file_problem(candidate: &Candidate, instances: &[Instance]) -> Option<DicomError> {
    let mut faults = Vec::new();
    let mut seen = None;
    for reference in &candidate.frames {
        if seen == Some(reference.instance) {
            continue;
        }
        seen = Some(reference.instance);
        let Some((instance, _)) = reference.get(instances) else { continue };
        if let Some(fault) = &instance.fault {
            faults.push((instance.name.clone(), fault.clone()));
        } else if instance.has_modality_lut {
            let fault = FileFault::Unsupported("a Modality LUT Sequence".to_owned());
            faults.push((instance.name.clone(), fault));
        }
    }
    let more = faults.len().saturating_sub(1);
    let (name, fault) = faults.into_iter().next()?;
    Some(DicomError::File { name, fault, more })
}

/// The transfer syntaxes of a series, by name.
pub(super) fn syntax_names(facts: &SeriesFacts) -> String {
    let names: Vec<&str> = facts.transfer_syntaxes.iter().map(|s| syntax::name(s)).collect();
    names.join(", ")
}

/// The same in one or two words each.
pub(super) fn short_syntax_names(facts: &SeriesFacts) -> String {
    let mut names: Vec<&str> =
        facts.transfer_syntaxes.iter().map(|s| syntax::short_name(s)).collect();
    names.dedup();
    match names.as_slice() {
        [] => String::new(),
        [name] => (*name).to_owned(),
        [name, others @ ..] => format!("{name} +{}", others.len()),
    }
}
