//! Encapsulated pixels: the fragments, and which of them make up each frame (PS3.5, A.4).

use super::blob::Stream;
use super::error::{FileFault, Tag};

/// Fragments listed at most.
const MAX_FRAGMENTS: usize = 1 << 22;

/// A fragment's first byte, counted from the start of the stream, and its length.
pub(super) type Fragment = (u64, u64);

/// The items of an encapsulated pixel element.
pub(super) struct Fragments {
    /// Offsets of the frames' first items, from the first item after the table. Often empty.
    offsets: Vec<u64>,
    list: Vec<Fragment>,
}

/// Lists the fragments of a pixel element; the stream stands at its first item. A missing
/// delimiter after the last fragment is forgiven where the file ends there.
///
/// # Errors
/// Items that are none, or that reach beyond the end.
pub(super) fn list(stream: &mut Stream<'_>) -> Result<Fragments, FileFault> {
    let mut fragments = Fragments { offsets: Vec::new(), list: Vec::new() };
    let mut is_table = true;
    while let Some((offset, length)) = next(stream)? {
        if is_table {
            is_table = false;
            let mut table = Vec::new();
            stream.append(length, &mut table).map_err(FileFault::io)?;
            let entries = table.chunks_exact(4).filter_map(|c| c.first_chunk::<4>());
            fragments.offsets = entries.map(|e| u64::from(u32::from_le_bytes(*e))).collect();
            continue;
        }
        if fragments.list.len() >= MAX_FRAGMENTS {
            return Err(FileFault::Unsupported(format!("more than {MAX_FRAGMENTS} fragments")));
        }
        if !stream.skip(length).map_err(FileFault::io)? {
            let left = stream.left().unwrap_or(0);
            return Err(FileFault::LengthBeyond { tag: Tag(0xFFFE, 0xE000), length, left });
        }
        fragments.list.push((offset, length));
    }
    Ok(fragments)
}

/// Appends the fragments of the only frame to `out`, at most `most` bytes; the stream stands at the
/// first item. Memory grows with what is there.
///
/// # Errors
/// As [`list`]; no fragment; more than `most` bytes.
pub(super) fn append_all(
    stream: &mut Stream<'_>,
    most: u64,
    out: &mut Vec<u8>,
) -> Result<(), FileFault> {
    let mut left = most;
    let mut items = 0_u64;
    while let Some((_, length)) = next(stream)? {
        let tag = Tag(0xFFFE, 0xE000);
        items += 1;
        if items == 1 {
            // The table of offsets says nothing of one frame.
            if !stream.skip(length).map_err(FileFault::io)? {
                let left = stream.left().unwrap_or(0);
                return Err(FileFault::LengthBeyond { tag, length, left });
            }
            continue;
        }
        left = left.checked_sub(length).ok_or(FileFault::PixelsTooLong { limit: most })?;
        let found = stream.append(length, out).map_err(FileFault::io)?;
        if found < length {
            return Err(FileFault::LengthBeyond { tag, length, left: found });
        }
    }
    if items < 2 {
        return Err(FileFault::NoFrame { frame: 1, fragments: 0, frames: 1 });
    }
    Ok(())
}

/// The next item's first byte and length; nothing after the last.
fn next(stream: &mut Stream<'_>) -> Result<Option<Fragment>, FileFault> {
    let mut head = [0; 8];
    if stream.fill(&mut head).map_err(FileFault::io)? < 8 {
        return Ok(None);
    }
    let [g0, g1, e0, e1, l0, l1, l2, l3] = head;
    let tag = Tag(u16::from_le_bytes([g0, g1]), u16::from_le_bytes([e0, e1]));
    let length = u64::from(u32::from_le_bytes([l0, l1, l2, l3]));
    match tag {
        Tag(0xFFFE, 0xE0DD) => Ok(None),
        Tag(0xFFFE, 0xE000) => match stream.left() {
            Some(left) if left < length => Err(FileFault::LengthBeyond { tag, length, left }),
            _ => Ok(Some((stream.at(), length))),
        },
        tag => Err(FileFault::BadElement { tag, what: "found among the pixel fragments" }),
    }
}

impl Fragments {
    /// The fragments of each of `n_frames` frames: all of them for one frame; as the offset table
    /// has it, where its offsets are those of fragments; one each where there are as many; and
    /// otherwise a new frame wherever a fragment begins with the first bytes of a compressed image.
    /// Frames beyond `n_frames` are passed over, as they are where pixels are not encapsulated.
    ///
    /// # Errors
    /// [`FileFault::NoFrame`] where none of these gives every frame a fragment.
    pub(super) fn by_frame(
        self,
        n_frames: u64,
        mut begins_image: impl FnMut(Fragment) -> Result<bool, FileFault>,
    ) -> Result<Vec<Vec<Fragment>>, FileFault> {
        let fragments = self.list.len() as u64;
        let absent =
            |frame: u64| FileFault::NoFrame { frame: frame + 1, fragments, frames: n_frames };
        if fragments == 0 {
            return Err(absent(0));
        }
        if n_frames == 1 {
            return Ok(vec![self.list]);
        }
        if fragments < n_frames {
            return Err(absent(fragments));
        }
        let by_table = self.begins_by_table(n_frames);
        if by_table.is_none() && fragments == n_frames {
            return Ok(self.list.into_iter().map(|f| vec![f]).collect());
        }
        let mut frames: Vec<Vec<Fragment>> = Vec::new();
        for (index, fragment) in self.list.into_iter().enumerate() {
            let begins = match &by_table {
                Some(begins) => begins.get(frames.len()) == Some(&index),
                None => begins_image(fragment)?,
            };
            if begins && frames.len() as u64 == n_frames {
                break;
            }
            match frames.last_mut() {
                Some(frame) if !begins => frame.push(fragment),
                _ => frames.push(vec![fragment]),
            }
        }
        if frames.len() as u64 == n_frames { Ok(frames) } else { Err(absent(frames.len() as u64)) }
    }

    /// The first fragment of each frame by the offset table; nothing where it has too few offsets, or
    /// offsets that do not rise from the first fragment to others.
    fn begins_by_table(&self, n_frames: u64) -> Option<Vec<usize>> {
        let base = self.list.first()?.0;
        let mut begins: Vec<usize> = Vec::new();
        for offset in &self.offsets {
            let at = base.checked_add(*offset)?;
            let index = self.list.binary_search_by_key(&at, |fragment| fragment.0).ok()?;
            let rises = begins.last().map_or(index == 0, |&before| before < index);
            if !rises {
                return None;
            }
            begins.push(index);
        }
        (begins.len() as u64 >= n_frames).then_some(begins)
    }
}
