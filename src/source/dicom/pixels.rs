//! The stored bytes of a file's frames: where each is, read and decoded one at a time.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use super::blob::{Blob, Shared, Stream};
use super::decode::{self, Image};
use super::error::FileFault;
use super::fragments::{self, Fragment};
use super::instance::{Frame, Instance};
use super::layout::{Layout, SampleKind};
use super::series::FrameRef;
use super::syntax::{self, Codec};
use super::walk::PixelElement;
use crate::cancel::Cancel;
use crate::volume::{Inside, Padding};

/// The pixels of one file, ready to be read frame by frame from several threads.
pub(super) struct Pixels {
    /// The file, for messages.
    pub(super) name: String,
    pub(super) layout: Layout,
    syntax: String,
    bytes: Bytes,
    /// The fragments of each frame, where several frames are encapsulated.
    table: Option<Vec<Vec<Fragment>>>,
}

/// Where the value of the pixel element can be read.
enum Bytes {
    /// In a plain file, from this byte on.
    Plain { path: PathBuf, offset: u64 },
    /// By streaming through compressed bytes up to it: one frame.
    Streamed { blob: Arc<Blob>, deflated_at: Option<u64>, element: PixelElement },
    /// Inflated into a temporary file, which has no name any more.
    Spooled(Shared),
}

/// One slice: its pixels, which of their frames, and its rescale and padding.
pub(super) struct Slice {
    /// Nothing where no frame was stored: all zero.
    pub(super) pixels: Option<Arc<Pixels>>,
    pub(super) frame: u64,
    pub(super) slope: f64,
    pub(super) inter: f64,
    pub(super) padding: Option<Padding>,
    /// Where padding is handed on by its own value unless that is inside.
    pub(super) inside: Option<Inside>,
}

impl Pixels {
    /// The slices of a volume, each file looked at once.
    ///
    /// # Errors
    /// The name of a file whose frames cannot be found, and why.
    pub(super) fn prepare(
        frames: &[FrameRef],
        instances: &[Instance],
        cancel: &Cancel,
    ) -> Result<Vec<Slice>, (String, FileFault)> {
        let mut open: Vec<Option<Arc<Self>>> = vec![None; instances.len()];
        let mut slices = Vec::with_capacity(frames.len());
        for reference in frames {
            let found = reference.get(instances).zip(open.get_mut(reference.instance));
            let Some(((instance, frame), slot)) = found else {
                slices.push(Slice {
                    pixels: None,
                    frame: 0,
                    slope: 1.0,
                    inter: 0.0,
                    padding: None,
                    inside: None,
                });
                continue;
            };
            let pixels = if let Some(pixels) = slot {
                Arc::clone(pixels)
            } else {
                let named = |fault| (instance.name.clone(), fault);
                let pixels = Self::new(instance, cancel).map_err(named)?;
                Arc::clone(slot.insert(Arc::new(pixels)))
            };
            slices.push(Slice {
                pixels: Some(pixels),
                frame: frame.index,
                slope: frame.slope,
                inter: frame.inter,
                padding: instance.padding,
                inside: None,
            });
        }
        Ok(slices)
    }

    fn new(instance: &Instance, cancel: &Cancel) -> Result<Self, FileFault> {
        let (element, deflated_at) = (instance.element, instance.deflated_at);
        let encapsulated = syntax::is_encapsulated(&instance.syntax);
        let streamed =
            || Bytes::Streamed { blob: Arc::clone(&instance.blob), deflated_at, element };
        let bytes = match instance.blob.path() {
            Some(path) if deflated_at.is_none() => {
                Bytes::Plain { path: path.to_owned(), offset: element.offset }
            }
            _ if instance.n_frames == 1 => streamed(),
            _ => Bytes::Spooled(spool(instance, cancel)?),
        };
        let mut pixels = Self {
            name: instance.name.clone(),
            layout: instance.layout,
            syntax: instance.syntax.clone(),
            bytes,
            table: None,
        };
        if encapsulated && instance.n_frames > 1 {
            pixels.table = Some(pixels.index(instance.n_frames)?);
        }
        Ok(pixels)
    }

    /// Finds the fragments of each frame, with their places in the file.
    fn index(&self, n_frames: u64) -> Result<Vec<Vec<Fragment>>, FileFault> {
        let (file, base) = match &self.bytes {
            Bytes::Plain { path, offset } => (Shared::open(path).map_err(FileFault::io)?, *offset),
            Bytes::Spooled(file) => (file.clone(), 0),
            Bytes::Streamed { .. } => return Ok(Vec::new()),
        };
        let mut stream = Stream::within(file.clone(), base);
        // A frame of RLE is one fragment (PS3.5, annex A.4.2).
        let is_rle = syntax::codec(&self.syntax) == Some(Codec::Rle);
        fragments::list(&mut stream)?.by_frame(n_frames, |(offset, length)| {
            if is_rle {
                return Ok(length > 0);
            }
            let mut head = [0; 4];
            file.fill(&mut head, offset).map_err(FileFault::io)?;
            Ok(decode::begins_image(head))
        })
    }

    /// Reads and, if need be, decodes a frame.
    ///
    /// # Errors
    /// Bytes that end early or do not decode.
    pub(super) fn read(&self, frame: u64, stored: &mut Vec<u8>) -> Result<Image, FileFault> {
        match self.fetch(frame, stored)? {
            Some(image) => Ok(image),
            None => decode::decode(&self.syntax, &self.layout, stored),
        }
    }

    /// Reads the bytes of a frame, and says how to read them where they need no decoding.
    fn fetch(&self, frame: u64, stored: &mut Vec<u8>) -> Result<Option<Image>, FileFault> {
        stored.clear();
        if !syntax::is_encapsulated(&self.syntax) {
            return self.read_native(frame, stored).map(Some);
        }
        let most = self.layout.most_encoded(1);
        let mut gather = |mut stream: Stream<'_>| fragments::append_all(&mut stream, most, stored);
        match (&self.table, &self.bytes) {
            (Some(table), _) => {
                let fragments = usize::try_from(frame).ok().and_then(|f| table.get(f));
                for &(offset, length) in fragments.into_iter().flatten() {
                    self.append(offset, length, stored)?;
                }
            }
            (None, Bytes::Plain { path, offset }) => {
                gather(Stream::within(Shared::open(path).map_err(FileFault::io)?, *offset))?;
            }
            (None, Bytes::Spooled(file)) => gather(Stream::within(file.clone(), 0))?,
            (None, Bytes::Streamed { blob, deflated_at, element }) => {
                with_element(blob, *deflated_at, element, gather)?;
            }
        }
        Ok(None)
    }

    fn read_native(&self, frame: u64, stored: &mut Vec<u8>) -> Result<Image, FileFault> {
        let samples = self.layout.n_samples() as u64;
        let overflow = || FileFault::PixelsEnd { found: 0, wanted: u64::MAX };
        let first = samples.checked_mul(frame).ok_or_else(overflow)?;
        let (offset, length, packed) = if self.layout.kind == SampleKind::Bit {
            let end = first.checked_add(samples).ok_or_else(overflow)?;
            (first / 8, end.div_ceil(8) - first / 8, Some((first % 8) as u32))
        } else {
            let size = self.layout.frame_bytes() as u64;
            (size.checked_mul(frame).ok_or_else(overflow)?, size, None)
        };
        let base = match &self.bytes {
            Bytes::Plain { offset, .. } => *offset,
            Bytes::Streamed { .. } | Bytes::Spooled(_) => 0,
        };
        // Swapped pairs are read whole: a frame may begin and end within one.
        let before = if self.layout.swapped_pairs { offset % 2 } else { 0 };
        let after = if self.layout.swapped_pairs { (before + length) % 2 } else { 0 };
        let begin = base.checked_add(offset - before).ok_or_else(overflow)?;
        self.append(begin, before + length + after, stored)?;
        if self.layout.swapped_pairs {
            stored.chunks_exact_mut(2).for_each(<[u8]>::reverse);
            stored.drain(..stored.len().min(before as usize));
            stored.truncate(usize::try_from(length).unwrap_or(usize::MAX));
        }
        let found = stored.len() as u64;
        if found < length {
            return Err(FileFault::PixelsEnd { found, wanted: length });
        }
        Ok(Image { precision: None, lossy: false, packed, big: self.layout.big })
    }

    /// Appends bytes from a place in the file (plain), or in the pixel element's value.
    fn append(&self, offset: u64, length: u64, out: &mut Vec<u8>) -> Result<(), FileFault> {
        match &self.bytes {
            Bytes::Plain { path, .. } => {
                let file = Shared::open(path).map_err(FileFault::io)?;
                file.append(offset, length, out).map_err(FileFault::io)
            }
            Bytes::Spooled(file) => file.append(offset, length, out).map_err(FileFault::io),
            Bytes::Streamed { blob, deflated_at, element } => {
                with_element(blob, *deflated_at, element, |mut stream| {
                    if !stream.skip(offset).map_err(FileFault::io)? {
                        return Ok(());
                    }
                    stream.append(length, out).map_err(FileFault::io)?;
                    Ok(())
                })
            }
        }
    }

    /// Whether two frames have the same samples and the same rescale. Frames of compressed
    /// multi-frame files are never said to be the same.
    pub(super) fn same_frame(
        a: (&Instance, &Frame),
        b: (&Instance, &Frame),
        cancel: &Cancel,
    ) -> bool {
        let rescaled = |f: &Frame| (f.slope, f.inter);
        let comparable = |i: &Instance| i.n_frames == 1 || !syntax::is_encapsulated(&i.syntax);
        if rescaled(a.1) != rescaled(b.1) || !comparable(a.0) || !comparable(b.0) {
            return false;
        }
        // Copies of a file are the same byte for byte.
        let bytes = |(instance, frame): (&Instance, &Frame)| {
            let mut stored = Vec::new();
            Self::new(instance, cancel).ok()?.fetch(frame.index, &mut stored).ok()?;
            Some(stored)
        };
        let alike = a.0.n_frames == 1
            && b.0.n_frames == 1
            && (&a.0.syntax, a.0.layout) == (&b.0.syntax, b.0.layout);
        if alike && bytes(a).is_some_and(|stored| Some(stored) == bytes(b)) {
            return true;
        }
        let read = |(instance, frame): (&Instance, &Frame)| {
            let mut stored = Vec::new();
            let image = Self::new(instance, cancel).ok()?.read(frame.index, &mut stored).ok()?;
            let mut samples = vec![0.0; instance.layout.n_samples()];
            super::unpack::real(&instance.layout, &image, None, &stored, &mut samples, |v| v);
            Some(samples)
        };
        read(a).is_some_and(|samples| Some(samples) == read(b))
    }
}

/// Streams to the first byte of the pixel element's value; the bytes are verified as a whole where
/// that can be.
fn with_element<T>(
    blob: &Blob,
    deflated_at: Option<u64>,
    element: &PixelElement,
    read: impl FnOnce(Stream<'_>) -> Result<T, FileFault>,
) -> Result<T, FileFault> {
    blob.with_verified_stream(|mut stream| {
        if let Some(at) = deflated_at {
            stream.skip(at).map_err(FileFault::io)?;
            stream = stream.inflate();
        }
        stream.skip(element.offset).map_err(FileFault::io)?;
        read(stream)
    })
}

/// Inflates the value of a pixel element into a temporary file without a name, as much of it as the
/// frames need.
///
/// # Errors
/// Compressed pixels longer than any of that many frames; a system error of kind `Interrupted`
/// where the run is stopped.
fn spool(instance: &Instance, cancel: &Cancel) -> Result<Shared, FileFault> {
    let Instance { layout, n_frames, .. } = *instance;
    let is_encapsulated = syntax::is_encapsulated(&instance.syntax);
    let limit = if is_encapsulated {
        layout.most_encoded(n_frames)
    } else {
        let wanted = layout.native_bytes(n_frames).unwrap_or(u64::MAX);
        wanted.saturating_add(wanted % 2)
    };
    let mut file = tempfile::tempfile().map_err(FileFault::temporary)?;
    with_element(&instance.blob, instance.deflated_at, &instance.element, |mut stream| {
        let mut left = instance.element.length.unwrap_or(u64::MAX).min(limit);
        let mut chunk = Vec::new();
        while left > 0 {
            if cancel.is_raised() {
                return Err(FileFault::io(std::io::ErrorKind::Interrupted.into()));
            }
            chunk.clear();
            let n = stream.append(left.min(1 << 20), &mut chunk).map_err(FileFault::io)?;
            if n == 0 {
                return Ok(());
            }
            file.write_all(&chunk).map_err(FileFault::temporary)?;
            left -= n;
        }
        let is_more = is_encapsulated && stream.fill(&mut [0]).map_err(FileFault::io)? > 0;
        if is_more { Err(FileFault::PixelsTooLong { limit }) } else { Ok(()) }
    })?;
    Shared::over(file).map_err(FileFault::temporary)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::blob::Blob;
    use super::super::instance::{Scanned, scan_file};
    use super::super::unpack;
    use super::*;
    use crate::volume::Rescale;

    /// All real values of a file, frame after frame.
    fn values(path: &Path) -> Result<Vec<f64>, String> {
        let len = path.metadata().unwrap().len();
        let blob = Blob::File { path: path.to_owned(), len };
        let instance = match scan_file(blob, String::new()) {
            Scanned::Image(instance) => [*instance],
            Scanned::Broken { fault, .. } => return Err(fault.to_string()),
            Scanned::Aside { what, .. } => return Err(what.name(1).to_owned()),
            Scanned::Foreign => return Err("no DICOM".to_owned()),
        };
        let said = |fault: FileFault| fault.to_string();
        let n = instance[0].frames.len();
        let frames: Vec<FrameRef> = (0..n).map(|frame| FrameRef { instance: 0, frame }).collect();
        let slices = Pixels::prepare(&frames, &instance, &Cancel::new());
        let mut all = Vec::new();
        for slice in slices.map_err(|(_, fault)| said(fault))? {
            let (pixels, mut stored) = (slice.pixels.unwrap(), Vec::new());
            let image = pixels.read(slice.frame, &mut stored).map_err(said)?;
            let mut plane = vec![0.0; pixels.layout.n_samples()];
            let rescale = Rescale::new(slice.slope, slice.inter).unwrap();
            unpack::real(&pixels.layout, &image, None, &stored, &mut plane, |v| rescale.real(v));
            all.extend(plane);
        }
        Ok(all)
    }

    #[test]
    fn single_images_in_each_transfer_syntax_decode_to_what_pydicom_sees() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/dicom-single");
        let json = std::fs::read(folder.join("expected.json")).unwrap();
        let expected: serde_json::Value = serde_json::from_slice(&json).unwrap();
        for (name, image) in expected["items"].as_object().unwrap() {
            let found = match (values(&folder.join(name)), image["refused"].as_str()) {
                (Ok(found), None) => found,
                (Err(fault), Some(said)) if fault.contains(said) => continue,
                (found, said) => panic!("{name}: {:?}, not {said:?}", found.err()),
            };
            let of = |key: &str| image[key].as_f64().unwrap();
            if let Some(crc) = image["crc32_f64"].as_str() {
                let bytes: Vec<u8> = found.iter().flat_map(|v| v.to_le_bytes()).collect();
                assert_eq!(format!("{:08x}", crc32fast::hash(&bytes)), crc, "{name}");
            } else {
                let most = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let mean = found.iter().sum::<f64>() / found.len() as f64;
                let tolerance = 0.02 * (of("max") - of("min"));
                assert!((most - of("max")).abs() <= tolerance, "{name}: {most}");
                assert!((mean - of("mean")).abs() <= tolerance / 10.0, "{name}: {mean}");
            }
        }
    }
}
