//! What `--resume` knows files by.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::time::UNIX_EPOCH;

use crate::cli::job::Scan;

/// Bytes of each input file that are read: headers lie within, so that a file that was replaced by
/// another of the same size and time is told apart by more than that.
const HEAD_BYTES: u64 = 4096;

/// What a volume is read from, in words that change when it does: how many files, their bytes in
/// all, the latest change, and a checksum over size, time and first bytes of each.
///
/// # Errors
/// A file that cannot be read, or only once: what is read here would be missing from the volume.
pub(super) fn of_input(scan: &Scan) -> io::Result<String> {
    let files = scan.files();
    if files.is_empty() {
        return Err(io::ErrorKind::Unsupported.into());
    }
    let mut sum = crc32fast::Hasher::new();
    let (mut bytes, mut latest) = (0, 0);
    let mut head = Vec::new();
    for path in &files {
        let facts = std::fs::metadata(path)?;
        // To open a pipe is to wait for it.
        if !facts.is_file() {
            return Err(io::ErrorKind::Unsupported.into());
        }
        let file = File::open(path)?;
        let changed = facts.modified()?.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos());
        head.clear();
        file.take(HEAD_BYTES).read_to_end(&mut head)?;
        sum.update(&facts.len().to_le_bytes());
        sum.update(&changed.to_le_bytes());
        sum.update(&head);
        bytes += facts.len();
        latest = latest.max(changed);
    }
    let volume = scan.series().unwrap_or_default();
    let (n, sum) = (files.len(), sum.finalize());
    Ok(format!("{n} files, {bytes} bytes, {latest} ns, {sum:08x}, volume {volume}"))
}

/// The size and the CRC-32 of a whole file.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn of_output(path: &Path) -> io::Result<(u64, u32)> {
    let mut file = File::open(path)?;
    let mut sum = crc32fast::Hasher::new();
    let mut buffer = vec![0; 256 << 10];
    let mut size = 0;
    loop {
        match file.read(&mut buffer) {
            Ok(0) => return Ok((size, sum.finalize())),
            Ok(n) => {
                sum.update(buffer.get(..n).unwrap_or_default());
                size += n as u64;
            }
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
}
