//! What the fuzz targets share: bytes as a file, a volume read to its end, and a frame decoded.

use std::io::{Seek, Write};
use std::path::Path;

use mcubes::cancel::Cancel;
use mcubes::error::Failure;
use mcubes::source::dicom::{CodestreamError, DecodedFrame};
use mcubes::source::{Volume, survey};
use mcubes::{Error, Kind};

/// Planes beyond this are not asked for: a pipeline would refuse them under `--max-memory`.
const PLANE_BYTES: usize = 64 << 20;

thread_local! {
    static FILE: tempfile::NamedTempFile = tempfile::NamedTempFile::new().expect("a temporary file");
}

/// Puts `bytes` into a file and hands over its path.
pub fn with_file(bytes: &[u8], read: impl FnOnce(&Path)) {
    FILE.with(|named| {
        let mut file = named.as_file();
        file.set_len(0).and_then(|()| file.rewind()).expect("a file that can be emptied");
        file.write_all(bytes).expect("room for the input");
        read(named.path());
    });
}

/// Reads everything. Errors are fine, as long as none says that the program is wrong.
pub fn read_all(opened: Result<Volume<'static>, Error>) {
    let kind = match opened {
        Ok(volume) => {
            let meta = &volume.meta;
            if meta.grid.dims.plane_len().saturating_mul(8) > PLANE_BYTES {
                return;
            }
            assert!(meta.grid.affine.is_usable());
            match survey(volume, &Cancel::new()) {
                Ok(survey) => {
                    let _ = survey.suggested();
                    return;
                }
                Err(error) => error.kind(),
            }
        }
        Err(error) => {
            assert!(!error.to_string().contains('\n'));
            error.kind()
        }
    };
    assert_ne!(kind, Kind::Internal);
}

/// Decodes bytes of which the first two are the frame's rows and columns. Errors are fine.
pub fn decode_frame(
    bytes: &[u8],
    decode: impl Fn(&[u8], usize, usize) -> Result<DecodedFrame, CodestreamError>,
) {
    let [rows, cols, stream @ ..] = bytes else { return };
    let (rows, cols) = (usize::from(*rows), usize::from(*cols));
    if let Ok(decoded) = decode(stream, rows, cols) {
        assert_eq!(decoded.samples.len(), rows * cols);
        let largest = u16::MAX >> (16 - decoded.bits);
        assert!(decoded.samples.iter().all(|&sample| sample <= largest));
    }
}
