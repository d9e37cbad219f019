//! Frames of a file: functional groups of enhanced objects, the vectors of nuclear medicine, and
//! the plain attributes of everything else.

use super::error::{FileFault, Tag};
use super::header::{self, Item, bad};
use super::instance::{CLOCK, Frame, SPLITTERS};
use super::tags;
use crate::geom::vec3::{add, cross, scale};
use crate::limits::MAX_FRAMES_BYTES;

const POSITION: &str = "ImagePositionPatient";
const ORIENTATION: &str = "ImageOrientationPatient";

/// SOPClassUID of nuclear medicine.
const NUCLEAR_CLASS: &str = "1.2.840.10008.5.1.4.1.1.20";

/// See [`Frame::unplaced`].
const ONE_POSITION: &str = "one ImagePositionPatient for all frames of the file, expected a PlanePositionSequence for each";
/// See [`Frame::unplaced`].
const NO_STEP: &str = "no SpacingBetweenSlices";
/// See [`Frame::unplaced`].
const TURNING: &str = "projections that turn around the patient (RotationVector)";

/// The frames of one file, in the order of its pixels.
///
/// # Errors
/// A place, spacing or rescale that cannot be; more frames than can be listed.
pub(super) fn frames(
    header: &Item,
    n_frames: u64,
    image_type: &[String],
    is_segmentation: bool,
) -> Result<Vec<Frame>, FileFault> {
    let per_frame = header::items(header, tags::PER_FRAME_FUNCTIONAL_GROUPS);
    let shared = header::items(header, tags::SHARED_FUNCTIONAL_GROUPS).first();
    let top = plain(header, image_type)?;
    if per_frame.is_empty() && shared.is_none() {
        let detector = header::items(header, tags::DETECTOR_INFORMATION_SEQUENCE).first();
        let is_nuclear =
            header::text(header, tags::SOP_CLASS_UID).as_deref() == Some(NUCLEAR_CLASS);
        let detector = detector.or(is_nuclear.then_some(header));
        return match detector {
            Some(detector) if n_frames > 1 => nuclear(header, detector, top, n_frames),
            Some(detector) => Ok(vec![detected(detector, top)?]),
            None if n_frames == 1 => Ok(vec![top]),
            // Frames without a word on where each of them lies: a film, or a stack that no part of
            // the standard gives a direction.
            None => {
                let unplaced = top.position.map(|_| ONE_POSITION);
                let all = Frame { position: None, unplaced, ..top };
                list(n_frames, |index| Ok(Frame { index, ..all.clone() }))
            }
        };
    }
    // One item a frame (PS3.3, C.7.6.16.1.2); of fewer no frame knows its own. More are what is left
    // where a tool has cut frames off a file's end.
    if !per_frame.is_empty() && (per_frame.len() as u64) < n_frames {
        return Err(FileFault::FrameItems { frames: n_frames, items: per_frame.len() });
    }
    let scale = if is_segmentation { fraction(header)? } else { 1.0 };
    list(n_frames, |index| {
        let own = usize::try_from(index).ok().and_then(|i| per_frame.get(i));
        let mut frame = grouped(own, shared, &top)?;
        frame.index = index;
        frame.slope *= scale;
        Ok(frame)
    })
}

/// Makes `n_frames` frames. Their number is only claimed, and each may hold text, so memory is
/// charged before it is taken.
fn list(
    n_frames: u64,
    frame: impl Fn(u64) -> Result<Frame, FileFault>,
) -> Result<Vec<Frame>, FileFault> {
    let too_many = || FileFault::TooManyFrames { frames: n_frames };
    let mut left = n_frames
        .checked_mul(size_of::<Frame>() as u64)
        .and_then(|bytes| MAX_FRAMES_BYTES.checked_sub(bytes))
        .ok_or_else(too_many)?;
    let mut frames = Vec::new();
    let n = usize::try_from(n_frames).map_err(|_| too_many())?;
    frames.try_reserve_exact(n).map_err(|_| too_many())?;
    for index in 0..n_frames {
        let frame = frame(index)?;
        left = left.checked_sub(frame.text_bytes()).ok_or_else(too_many)?;
        frames.push(frame);
    }
    Ok(frames)
}

/// What an image says outside functional groups.
fn plain(header: &Item, image_type: &[String]) -> Result<Frame, FileFault> {
    let (slope, inter) = rescale(header)?.unwrap_or((1.0, 0.0));
    let label = |tag| header::label(header, tag);
    let mut mixed = [const { None }; SPLITTERS.len()];
    mixed[0] = label(tags::ECHO_TIME);
    mixed[1] = label(tags::ECHO_NUMBERS);
    mixed[2] = label(tags::TEMPORAL_POSITION_IDENTIFIER);
    mixed[3] = label(tags::DIFFUSION_B_VALUE);
    mixed[4] = Some(image_type.join("\\")).filter(|t| !t.is_empty());
    mixed[5] = label(tags::TRIGGER_TIME);
    mixed[6] = label(tags::ACQUISITION_NUMBER);
    mixed[7] = label(tags::INVERSION_TIME);
    mixed[8] = label(tags::KVP);
    mixed[9] = label(tags::CONVOLUTION_KERNEL);
    mixed[10] = label(tags::FLIP_ANGLE);
    mixed[11] = label(tags::GRADIENT_DIRECTION);
    mixed[CLOCK] = label(tags::ACQUISITION_TIME);
    Ok(Frame {
        index: 0,
        position: position(header)?,
        unplaced: None,
        orientation: orientation(header)?,
        spacing: spacing(header)?,
        slice_spacing: slice_spacing(header),
        slope,
        inter,
        segment: None,
        apart: String::new(),
        mixed,
        dimensions: Vec::new(),
    })
}

/// Whether an image says in full where it lies, outside functional groups.
pub(super) fn is_placed(header: &Item) -> bool {
    let place = (position(header), orientation(header), spacing(header));
    matches!(place, (Ok(Some(_)), Ok(Some(_)), Ok(Some(_))))
}

/// One frame's functional groups over the shared ones over the top level.
fn grouped(own: Option<&Item>, shared: Option<&Item>, top: &Frame) -> Result<Frame, FileFault> {
    let group = |sequence: Tag| {
        let of = |item| header::items(item, sequence).first();
        own.and_then(of).or_else(|| shared.and_then(of))
    };
    let mut frame = top.clone();
    if let Some(item) = group(tags::PLANE_POSITION_SEQUENCE) {
        frame.position = position(item)?.or(frame.position);
    }
    if let Some(item) = group(tags::PLANE_ORIENTATION_SEQUENCE) {
        frame.orientation = orientation(item)?.or(frame.orientation);
    }
    if let Some(item) = group(tags::PIXEL_MEASURES_SEQUENCE) {
        frame.spacing = spacing(item)?.or(frame.spacing);
        frame.slice_spacing = slice_spacing(item).or(frame.slice_spacing);
    }
    if let Some(item) = group(tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE)
        && let Some((slope, inter)) = rescale(item)?
    {
        (frame.slope, frame.inter) = (slope, inter);
    }
    let mut label = |slot: usize, sequence, tag| {
        if let Some(text) = group(sequence).and_then(|item| header::label(item, tag))
            && let Some(slot) = frame.mixed.get_mut(slot)
        {
            *slot = Some(text);
        }
    };
    label(0, tags::MR_ECHO_SEQUENCE, tags::EFFECTIVE_ECHO_TIME);
    label(2, tags::FRAME_CONTENT_SEQUENCE, tags::TEMPORAL_POSITION_INDEX);
    label(3, tags::MR_DIFFUSION_SEQUENCE, tags::DIFFUSION_B_VALUE);
    label(4, tags::MR_IMAGE_FRAME_TYPE_SEQUENCE, tags::FRAME_TYPE);
    label(5, tags::CARDIAC_SYNCHRONIZATION_SEQUENCE, tags::CARDIAC_TRIGGER_DELAY);
    label(6, tags::FRAME_CONTENT_SEQUENCE, tags::FRAME_ACQUISITION_NUMBER);
    label(7, tags::MR_MODIFIER_SEQUENCE, tags::INVERSION_TIMES);
    label(8, tags::CT_X_RAY_DETAILS_SEQUENCE, tags::KVP);
    label(9, tags::CT_RECONSTRUCTION_SEQUENCE, tags::CONVOLUTION_KERNEL);
    label(10, tags::MR_TIMING_SEQUENCE, tags::FLIP_ANGLE);
    label(12, tags::TEMPORAL_POSITION_SEQUENCE, tags::TEMPORAL_POSITION_TIME_OFFSET);
    label(CLOCK, tags::FRAME_CONTENT_SEQUENCE, tags::FRAME_ACQUISITION_DATE_TIME);
    let gradient = group(tags::MR_DIFFUSION_SEQUENCE)
        .and_then(|item| header::items(item, tags::GRADIENT_DIRECTION_SEQUENCE).first())
        .and_then(|item| header::label(item, tags::GRADIENT_DIRECTION));
    frame.mixed[11] = gradient.or(frame.mixed[11].take());
    if let Some(content) = group(tags::FRAME_CONTENT_SEQUENCE) {
        frame.dimensions = header::texts(content, tags::DIMENSION_INDEX_VALUES);
    }
    let text = |sequence, tag| group(sequence).and_then(|item| header::label(item, tag));
    if let Some(stack) = text(tags::FRAME_CONTENT_SEQUENCE, tags::STACK_ID) {
        frame.apart = format!("stack {stack}");
    }
    if let Some(segment) =
        text(tags::SEGMENT_IDENTIFICATION_SEQUENCE, tags::REFERENCED_SEGMENT_NUMBER)
    {
        frame.segment = segment.parse().ok();
        frame.apart = format!("segment {segment}");
    }
    Ok(frame)
}

/// A frame that lies as its detector says (PS3.3, C.8.4.11), of several as the first.
fn detected(detector: &Item, top: Frame) -> Result<Frame, FileFault> {
    let position = position(detector)?.or(top.position);
    let orientation = orientation(detector)?.or(top.orientation);
    Ok(Frame { position, orientation, ..top })
}

/// Slices of nuclear medicine: the first one's place, then steps of SpacingBetweenSlices along the
/// normal (PS3.3, C.8.4.15 and C.8.4.8).
fn nuclear(
    header: &Item,
    detector: &Item,
    top: Frame,
    n_frames: u64,
) -> Result<Vec<Frame>, FileFault> {
    let top = detected(detector, top)?;
    let (orientation, position) = (top.orientation, top.position);
    let slices = header::numbers(header, tags::SLICE_VECTOR, "SliceVector")?;
    let mut vectors = vec![
        ("energy window", header::texts(header, tags::ENERGY_WINDOW_VECTOR)),
        ("detector", header::texts(header, tags::DETECTOR_VECTOR)),
        ("phase", header::texts(header, tags::PHASE_VECTOR)),
        ("R-R interval", header::texts(header, tags::RR_INTERVAL_VECTOR)),
        ("time slot", header::texts(header, tags::TIME_SLOT_VECTOR)),
    ];
    // What is the same in all frames sets none apart.
    vectors.retain(|(_, values)| values.iter().any(|v| Some(v) != values.first()));
    // Projections turn around the patient: no slices.
    let turns = !header::texts(header, tags::ROTATION_VECTOR).is_empty();
    let step = top.slice_spacing.filter(|&step| step != 0.0);
    let unplaced = match step {
        _ if turns => Some(TURNING),
        None => position.map(|_| NO_STEP),
        Some(_) => None,
    };
    let frame = |index: u64| {
        let at = usize::try_from(index).unwrap_or(usize::MAX);
        let number = slices.get(at).map_or(index as f64, |s| s - 1.0);
        let placed = position.zip(orientation).zip(step).filter(|_| !turns).map(
            |((position, [a, b, c, d, e, f]), step)| {
                add(position, scale(cross([a, b, c], [d, e, f]), number * step))
            },
        );
        let apart: Vec<String> = vectors
            .iter()
            .filter_map(|(name, values)| Some(format!("{name} {}", values.get(at)?)))
            .collect();
        let apart = apart.join(", ");
        Ok(Frame { index, position: placed, unplaced, apart, ..top.clone() })
    };
    list(n_frames, frame)
}

/// The factor that brings a fractional segmentation to 0..1.
fn fraction(header: &Item) -> Result<f64, FileFault> {
    if header::text(header, tags::SEGMENTATION_TYPE).as_deref() != Some("FRACTIONAL") {
        return Ok(1.0);
    }
    let attribute = "MaximumFractionalValue";
    match header::number(header, tags::MAXIMUM_FRACTIONAL_VALUE, attribute)? {
        Some(most) if most > 0.0 => Ok(1.0 / most),
        Some(most) => Err(bad(attribute, &most.to_string(), "above 0")),
        None => Err(FileFault::Missing { attribute }),
    }
}

fn position(item: &Item) -> Result<Option<[f64; 3]>, FileFault> {
    header::vector(item, tags::IMAGE_POSITION_PATIENT, POSITION, "3 numbers")
}

/// Unit vectors at right angles, within what six written digits lose.
fn orientation(item: &Item) -> Result<Option<[f64; 6]>, FileFault> {
    let found: Option<[f64; 6]> =
        header::vector(item, tags::IMAGE_ORIENTATION_PATIENT, ORIENTATION, "6 numbers")?;
    let Some(o @ [a, b, c, d, e, f]) = found else { return Ok(None) };
    let lengths = [a * a + b * b + c * c, d * d + e * e + f * f];
    let skew = a * d + b * e + c * f;
    if lengths.iter().all(|l| (l - 1.0).abs() < 0.02) && skew.abs() < 0.01 {
        return Ok(Some(o));
    }
    let found = header::texts(item, tags::IMAGE_ORIENTATION_PATIENT).join("\\");
    Err(bad(ORIENTATION, &found, "two unit vectors at right angles"))
}

fn spacing(item: &Item) -> Result<Option<[f64; 2]>, FileFault> {
    let attribute = "PixelSpacing";
    let found: Option<[f64; 2]> =
        header::vector(item, tags::PIXEL_SPACING, attribute, "2 numbers")?;
    match found {
        Some(s) if s.iter().all(|&v| v > 0.0) => Ok(Some(s)),
        Some([a, b]) => Err(bad(attribute, &format!("{a}\\{b}"), "two numbers above 0")),
        None => Ok(None),
    }
}

/// What is no number is none: where images have positions nothing depends on it.
fn slice_spacing(item: &Item) -> Option<f64> {
    header::number(item, tags::SPACING_BETWEEN_SLICES, "SpacingBetweenSlices").ok().flatten()
}

/// Slope and intercept, where either is given.
fn rescale(item: &Item) -> Result<Option<(f64, f64)>, FileFault> {
    let slope = header::number(item, tags::RESCALE_SLOPE, "RescaleSlope")?;
    let inter = header::number(item, tags::RESCALE_INTERCEPT, "RescaleIntercept")?;
    match (slope, inter) {
        (None, None) => Ok(None),
        (Some(0.0), _) => Err(bad("RescaleSlope", "0", "another number than 0")),
        _ => Ok(Some((slope.unwrap_or(1.0), inter.unwrap_or(0.0)))),
    }
}
