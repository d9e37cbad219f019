//! The guard: one pass over a file's elements that checks every length and depth against the file,
//! keeps the few elements that are read, and finds where the pixels are.
//!
//! Iterative, so nesting costs no stack; allocates only for what is kept, so a length is never
//! believed. What it hands on is small, whole and free of patient data.

use super::blob::Stream;
use super::element::{
    Element, Encoding, UNDEFINED, append, check_whole, defined_length, has_long_length,
    item_encoding, read_element, skip, standard_vr, value_bytes,
};
use super::error::{FileFault, Tag};
use super::start::{self, find_start, read_meta, settle_encoding};
use super::tags;

/// Levels of sequences and items that are followed.
const MAX_DEPTH: usize = 64;

/// The largest single value kept, in bytes.
const MAX_VALUE: u64 = 1 << 20;

/// The most that is kept of one header, in bytes: the functional groups of tens of thousands of
/// frames fit.
const MAX_KEPT: usize = 64 << 20;

const ITEM: Tag = Tag(0xFFFE, 0xE000);
const ITEM_END: Tag = Tag(0xFFFE, 0xE00D);
const SEQUENCE_END: Tag = Tag(0xFFFE, 0xE0DD);

/// Where the pixels of a file are.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelElement {
    /// Which of the three pixel elements it is.
    pub(super) tag: Tag,
    /// Whether 16-bit words are written (OW) rather than bytes.
    pub(super) words: bool,
    /// Its value's first byte, counted from the start of the file, or of the inflated data set.
    pub(super) offset: u64,
    /// Its length as claimed; nothing where the pixels are encapsulated.
    pub(super) length: Option<u64>,
    /// The bytes from `offset` to the end of the file, where that is known.
    pub(super) left: Option<u64>,
}

/// What the walk found.
pub(super) struct Walked {
    /// TransferSyntaxUID, as written; implied where there is no file meta group.
    pub(super) syntax: String,
    /// MediaStorageSOPClassUID, where there is a file meta group.
    pub(super) media_class: Option<String>,
    /// How `kept` is written.
    pub(super) encoding: Encoding,
    /// The elements kept, a data set of its own.
    pub(super) kept: Vec<u8>,
    /// The pixels.
    pub(super) pixels: Option<PixelElement>,
    /// Where the deflated part begins, if the data set is deflated.
    pub(super) deflated_at: Option<u64>,
}

/// Walks one file up to its pixels.
///
/// # Errors
/// [`FileFault::NotDicom`] where nothing looks like DICOM; a header that is damaged or too large.
pub(super) fn walk(stream: Stream<'_>) -> Result<Walked, FileFault> {
    walk_keeping(stream, &[])
}

/// [`walk`] that keeps some elements more.
pub(super) fn walk_keeping(mut stream: Stream<'_>, more: &[Tag]) -> Result<Walked, FileFault> {
    let marked = find_start(&mut stream)?;
    let meta = read_meta(&mut stream)?;
    let mut deflated_at = None;
    if meta.syntax.as_deref() == Some(start::DEFLATED) {
        deflated_at = Some(stream.at());
        stream = stream.inflate();
    }
    let encoding = settle_encoding(&mut stream, meta.syntax.as_deref())?;
    let syntax = meta.syntax.unwrap_or_else(|| start::syntax_of(encoding).to_owned());
    let mut walker = Walker { stream, encoding, more, kept: Vec::new(), levels: Vec::new() };
    match walker.run() {
        Ok(pixels) => Ok(Walked {
            syntax,
            media_class: meta.media_class,
            encoding,
            kept: walker.kept,
            pixels,
            deflated_at,
        }),
        // Without a mark or a meta group it was only a guess that this is DICOM.
        Err(_) if !marked => Err(FileFault::NotDicom),
        Err(fault) => Err(fault),
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum LevelKind {
    Sequence,
    Item,
    /// Encapsulated bytes (an icon): items without elements.
    Fragments,
}

struct Level {
    kind: LevelKind,
    tag: Tag,
    /// Where it ends; nothing where a delimiter ends it.
    end: Option<u64>,
    kept: bool,
    encoding: Encoding,
}

struct Walker<'a> {
    stream: Stream<'a>,
    encoding: Encoding,
    /// Elements kept beside those of [`tags`].
    more: &'a [Tag],
    kept: Vec<u8>,
    levels: Vec<Level>,
}

impl Walker<'_> {
    /// Walks to the pixels, or to the end.
    fn run(&mut self) -> Result<Option<PixelElement>, FileFault> {
        loop {
            self.close_ended()?;
            let encoding = self.encoding_here();
            let Some(element) = read_element(&mut self.stream, encoding)? else {
                return if self.levels.is_empty() {
                    Ok(None)
                } else {
                    Err(FileFault::HeaderEnds { at: self.stream.at() })
                };
            };
            match self.levels.last().map(|l| l.kind) {
                // One delimiter too many ends nothing.
                None if is_delimiter(&element) => {}
                None => {
                    if tags::is_pixels(element.tag) {
                        return Ok(Some(self.pixels(&element)));
                    }
                    // Nothing that is read comes after the pixels' group.
                    if element.tag.0 > 0x7FE0 {
                        return Ok(None);
                    }
                    self.element(&element)?;
                }
                Some(LevelKind::Item) => {
                    if element.tag == ITEM_END {
                        self.close();
                    } else if element.tag == SEQUENCE_END && self.is_open_ended() {
                        // The item's own delimiter was left out.
                        self.close();
                        if self.is_open_ended() {
                            self.close();
                        }
                    } else {
                        self.element(&element)?;
                    }
                }
                Some(LevelKind::Sequence) => self.in_sequence(&element)?,
                Some(LevelKind::Fragments) => match element.tag {
                    ITEM => {
                        let length = defined_length(&element, &self.stream)?;
                        skip(&mut self.stream, &element, length)?;
                    }
                    SEQUENCE_END => self.close(),
                    tag => {
                        return Err(FileFault::BadElement { tag, what: "found among fragments" });
                    }
                },
            }
        }
    }

    /// How the elements of the innermost level are written.
    fn encoding_here(&self) -> Encoding {
        self.levels.last().map_or(self.encoding, |level| level.encoding)
    }

    /// Whether a delimiter ends the innermost level.
    fn is_open_ended(&self) -> bool {
        self.levels.last().is_some_and(|level| level.end.is_none())
    }

    fn in_sequence(&mut self, element: &Element) -> Result<(), FileFault> {
        let Some(level) = self.levels.last() else { return Ok(()) };
        match element.tag {
            ITEM => {
                let (kept, around) = (level.kept, level.encoding);
                let end = self.end_of(element)?;
                // A file that is implicit has no sequences of unknown VR.
                let encoding = if self.encoding.explicit {
                    item_encoding(&mut self.stream, around, end)?
                } else {
                    around
                };
                self.open(Level { kind: LevelKind::Item, tag: ITEM, end, kept, encoding }, *b"  ")
            }
            SEQUENCE_END => {
                self.close();
                Ok(())
            }
            // An item of a length of its own that has a delimiter too.
            ITEM_END if is_delimiter(element) => Ok(()),
            tag => Err(FileFault::BadElement { tag, what: "found where an item was expected" }),
        }
    }

    /// One element of the data set or of an item.
    fn element(&mut self, element: &Element) -> Result<(), FileFault> {
        let parent_kept = self.levels.last().is_none_or(|l| l.kept);
        let kept = parent_kept && (tags::is_kept(element.tag) || self.more.contains(&element.tag));
        let around = self.encoding_here();
        let unknown = &element.vr == b"UN";
        let nameless = unknown || !around.explicit;
        let vr = if kept && nameless { standard_vr(element.tag) } else { element.vr };
        // A value of unknown VR is implicit and little endian in any file (PS3.5, 6.2.2, note 2).
        let encoding = if unknown { Encoding { explicit: false, big: false } } else { around };
        let undefined = element.length == UNDEFINED;
        let is_sequence = &vr == b"SQ" || (undefined && nameless && !kept);
        if is_sequence && (kept || undefined) {
            let end = self.end_of(element)?;
            let level = Level { kind: LevelKind::Sequence, tag: element.tag, end, kept, encoding };
            return self.open(level, vr);
        }
        if undefined && !nameless {
            // Bytes and words of undefined length are encapsulated.
            let kind = LevelKind::Fragments;
            let level = Level { kind, tag: element.tag, end: None, kept: false, encoding };
            return self.open(level, vr);
        }
        let length = defined_length(element, &self.stream)?;
        if !kept || &vr == b"UN" {
            return skip(&mut self.stream, element, length);
        }
        self.keep(&Element { vr, ..*element }, length, encoding.big)
    }

    /// Keeps a value, in the file's byte order.
    fn keep(&mut self, element: &Element, length: u64, big: bool) -> Result<(), FileFault> {
        let Element { tag, vr, .. } = *element;
        check_whole(element)?;
        if length > MAX_VALUE {
            return Err(FileFault::HeaderTooLarge { limit: MAX_VALUE });
        }
        if self.encoding.explicit && !has_long_length(vr) && length > u64::from(u16::MAX) {
            let what = "longer than 65535 bytes, too long for its value representation";
            return Err(FileFault::BadElement { tag, what });
        }
        let at = self.kept.len();
        self.emit(tag, vr, element.length)?;
        let start = self.kept.len();
        append(&mut self.stream, length, &mut self.kept)?;
        if big != self.encoding.big {
            let value = self.kept.get_mut(start..).unwrap_or_default();
            value.chunks_exact_mut(value_bytes(vr) as usize).for_each(<[u8]>::reverse);
        }
        if tags::is_padding(tag) && value_bytes(vr) == 1 {
            self.make_binary(tag, at, start);
        }
        Ok(())
    }

    /// Writes padding that was kept as text as a number of its own VR: `dicom-object` takes the bytes
    /// for one in any case, where samples have a sign.
    fn make_binary(&mut self, tag: Tag, at: usize, start: usize) {
        let text = String::from_utf8_lossy(self.kept.get(start..).unwrap_or_default());
        let text = text.trim_matches(|c: char| c == '\0' || c.is_whitespace());
        let value = text.parse::<i16>().or_else(|_| text.parse::<u16>().map(|v| v as i16));
        let Ok(value) = value else { return };
        self.kept.truncate(at);
        self.header(tag, *b"SS", 2);
        let big = self.encoding.big;
        self.kept.extend(if big { value.to_be_bytes() } else { value.to_le_bytes() });
    }

    /// Where a sequence or an item ends, which must lie within the file.
    fn end_of(&self, element: &Element) -> Result<Option<u64>, FileFault> {
        if element.length == UNDEFINED {
            return Ok(None);
        }
        Ok(Some(self.stream.at() + defined_length(element, &self.stream)?))
    }

    fn open(&mut self, level: Level, vr: [u8; 2]) -> Result<(), FileFault> {
        if self.levels.len() >= MAX_DEPTH {
            return Err(FileFault::TooDeep { limit: MAX_DEPTH });
        }
        if level.kept {
            self.emit(level.tag, vr, UNDEFINED)?;
        }
        self.levels.push(level);
        Ok(())
    }

    /// Closes the innermost level.
    fn close(&mut self) {
        let Some(level) = self.levels.pop() else { return };
        if level.kept {
            let tag = if level.kind == LevelKind::Item { ITEM_END } else { SEQUENCE_END };
            // Eight bytes beyond the limit do no harm.
            self.header(tag, *b"  ", 0);
        }
    }

    /// Closes the levels that end here.
    fn close_ended(&mut self) -> Result<(), FileFault> {
        let at = self.stream.at();
        while let Some(level) = self.levels.last() {
            match level.end {
                Some(end) if at == end => self.close(),
                Some(end) if at > end => {
                    let what = "an element reaches beyond the end of its sequence";
                    return Err(FileFault::BadElement { tag: level.tag, what });
                }
                _ => break,
            }
        }
        Ok(())
    }

    fn emit(&mut self, tag: Tag, vr: [u8; 2], length: u32) -> Result<(), FileFault> {
        if self.kept.len().saturating_add(length_or_none(length)) > MAX_KEPT {
            return Err(FileFault::HeaderTooLarge { limit: MAX_KEPT as u64 });
        }
        self.header(tag, vr, length);
        Ok(())
    }

    /// Writes an element's tag, VR and length as the file does.
    fn header(&mut self, tag: Tag, vr: [u8; 2], length: u32) {
        let big = self.encoding.big;
        let short = |v: u16| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        let long = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        self.kept.extend(short(tag.0));
        self.kept.extend(short(tag.1));
        // Items and delimiters never name a VR.
        if tag.0 == 0xFFFE || !self.encoding.explicit {
            self.kept.extend(long(length));
        } else {
            self.kept.extend(vr);
            if has_long_length(vr) {
                self.kept.extend([0, 0]);
                self.kept.extend(long(length));
            } else {
                self.kept.extend(short(length as u16));
            }
        }
    }

    fn pixels(&self, element: &Element) -> PixelElement {
        let undefined = element.length == UNDEFINED;
        let length = (!undefined).then_some(u64::from(element.length));
        let words = &element.vr == b"OW" || !self.encoding.explicit;
        let (offset, left) = (self.stream.at(), self.stream.left());
        PixelElement { tag: element.tag, words, offset, length, left }
    }
}

/// Whether it ends an item or a sequence.
fn is_delimiter(element: &Element) -> bool {
    matches!(element.tag, ITEM_END | SEQUENCE_END) && element.length == 0
}

fn length_or_none(length: u32) -> usize {
    if length == UNDEFINED { 0 } else { length as usize }
}
