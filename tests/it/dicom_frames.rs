//! The frames of compressed and of packed files: which fragments they are, and how samples of one
//! bit lie in them.

use mcubes::source::dicom::{self, OpenOptions, ScanOptions};
use mcubes::source::survey;
use mcubes::{Error, Kind};
use tempfile::TempDir;

use crate::dicom::values;
use crate::support::dicom::{Elements, Series, file};
use crate::support::ljpeg::encode_bits;
use crate::support::repository;
use crate::support::segments::{COLS, Measures, Segmentation};

const RLE: &str = "1.2.840.10008.1.2.5";
const SV1: &str = "1.2.840.10008.1.2.4.70";
const J2K: &str = "1.2.840.10008.1.2.4.90";
const BIG_ENDIAN: &str = "1.2.840.10008.1.2.2";

/// The real values of the one volume of a file.
fn read(syntax: &str, data: &Elements) -> Result<Vec<f64>, Error> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("frames.dcm");
    std::fs::write(&path, file(syntax, data)).unwrap();
    let study = dicom::scan(&path, &ScanOptions::default())?;
    let volume = study.open(0, &OpenOptions::default())?;
    Ok(values(volume).unwrap())
}

/// Slices of segment 1, one a frame.
fn planes(n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|k| Segmentation::plane(1, k)).collect()
}

/// One segment of RLE: literal runs.
fn rle(bytes: &[u8]) -> Vec<u8> {
    let mut out = [1_u32, 64].iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    out.resize(64, 0);
    for run in bytes.chunks(128) {
        out.push(run.len() as u8 - 1);
        out.extend(run);
    }
    out.resize(out.len() + out.len() % 2, 0);
    out
}

fn bytes(plane: &[f64]) -> Vec<u8> {
    plane.iter().map(|&v| v as u8).collect()
}

fn lossless(plane: &[f64]) -> Vec<u8> {
    let samples: Vec<u16> = plane.iter().map(|&v| v as u16).collect();
    let mut image = encode_bits(&samples, COLS as u16, 8);
    image.resize(image.len() + image.len() % 2, 0);
    image
}

#[test]
fn compressed_samples_of_one_bit_have_a_byte_each() {
    let planes = planes(5);
    let frames: Vec<(u16, usize)> = (0..5).map(|k| (1, k)).collect();
    let data = Segmentation::binary(&frames, Measures::Shared).data();
    let whole = planes.concat();
    for (syntax, images) in [
        (RLE, planes.iter().map(|p| rle(&bytes(p))).collect::<Vec<_>>()),
        (SV1, planes.iter().map(|p| lossless(p)).collect()),
    ] {
        let mut data = data.clone();
        data.set_fragments(&[], &images);
        assert_eq!(read(syntax, &data).unwrap(), whole, "{syntax}");
    }
}

#[test]
fn packed_bits_written_as_big_endian_words_have_the_first_sample_in_the_second_byte() {
    // 15 bytes a frame, so that every other frame begins within a word.
    let frames: Vec<(u16, usize)> = (0..5).map(|k| (1, k)).collect();
    for vr in [*b"OW", *b"OB"] {
        let mut data = Segmentation::binary(&frames, Measures::Shared).data();
        let mut packed = data.value((0x7FE0, 0x0010)).to_vec();
        packed.resize(packed.len() + packed.len() % 2, 0);
        data.set((0x7FE0, 0x0010), vr, &packed);
        data.make_big();
        assert_eq!(read(BIG_ENDIAN, &data).unwrap(), planes(5).concat());
    }
}

/// A label map of five frames, the images of six, and where each image's fragment begins.
fn six_images() -> (Elements, Vec<Vec<u8>>, Vec<u32>) {
    let images: Vec<Vec<u8>> = planes(6).iter().map(|p| lossless(p)).collect();
    let begin = |n: usize| images[..n].iter().map(|i| i.len() as u32 + 8).sum();
    let offsets = (0..6).map(begin).collect();
    (Segmentation::label_map(5).data(), images, offsets)
}

#[test]
fn a_wrong_offset_table_is_not_believed() {
    let (data, images, offsets) = six_images();
    // The first image in two fragments.
    let (first, second) = images[0].split_at(40);
    let fragments: Vec<Vec<u8>> = [&[first.to_vec(), second.to_vec()], &images[1..5]].concat();
    let right: Vec<u32> = offsets[..5].iter().map(|&o| if o > 0 { o + 8 } else { 0 }).collect();
    let off: Vec<u32> = right.iter().map(|o| o + 8).collect();
    let of_the_second: Vec<u32> = right.iter().map(|&o| if o == 0 { 48 } else { o }).collect();
    for table in [right, off, of_the_second, vec![0; 5], vec![0xFFFF_FFFE; 5], vec![0], vec![]] {
        let mut data = data.clone();
        data.set_fragments(&table, &fragments);
        assert_eq!(read(SV1, &data).unwrap(), planes(5).concat(), "{table:?}");
    }
}

#[test]
fn frames_beyond_their_number_are_passed_over() {
    let (data, images, offsets) = six_images();
    for table in [&offsets[..], &[]] {
        let mut data = data.clone();
        data.set_fragments(table, &images);
        assert_eq!(read(SV1, &data).unwrap(), planes(5).concat(), "{table:?}");
    }
    let runs: Vec<Vec<u8>> = planes(6).iter().map(|p| rle(&bytes(p))).collect();
    let mut data = data;
    data.set_fragments(&[], &runs);
    assert_eq!(read(RLE, &data).unwrap(), planes(5).concat());
}

#[test]
fn fewer_images_than_frames_are_still_refused() {
    let (data, images, _) = six_images();
    let halves: Vec<Vec<u8>> =
        images[..4].iter().flat_map(|i| [i[..40].to_vec(), i[40..].to_vec()]).collect();
    let mut data = data;
    data.set_fragments(&[], &halves);
    let error = read(SV1, &data).unwrap_err();
    assert_eq!(error.kind(), Kind::CorruptPixels);
    assert!(error.to_string().contains("frame 5 is not in the pixel data"), "{error}");
}

/// Three slices of 2912 rows and columns with the same JPEG 2000 codestream.
fn large(image: &[u8]) -> TempDir {
    let series = Series { rows: 2, cols: 2, ..Series::axial(3) };
    let folder = TempDir::new().unwrap();
    series.write_as(folder.path(), J2K, |_, data| {
        for tag in [0x0010, 0x0011] {
            data.set((0x0028, tag), *b"US", &2912_u16.to_le_bytes());
        }
        data.set_image(image);
    });
    folder
}

#[test]
fn a_large_frame_that_is_mostly_one_value_is_decoded_however_small_it_is() {
    let image = std::fs::read(repository("testdata/j2k/blank-2912.j2k")).unwrap();
    assert!(image.len() * 64 < 2912 * 2912 * 2);
    let folder = large(&image);
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let volume = study.open(0, &OpenOptions::default()).unwrap();
    let survey = survey(volume, &mcubes::cancel::Cancel::new()).unwrap();
    // 0 and 1000, with a slope of 0.25 and an intercept of -100.
    assert_eq!(survey.range, Some((-100.0, 150.0)));
}

#[test]
fn a_component_of_fewer_samples_than_the_image_is_refused_by_name() {
    let mut image = std::fs::read(repository("testdata/j2k/blank-2912.j2k")).unwrap();
    // XRsiz, of the first component.
    image[43] = 2;
    let folder = large(&image);
    let study = dicom::scan(folder.path(), &ScanOptions::default()).unwrap();
    let volume = study.open(0, &OpenOptions::default()).unwrap();
    let error = survey(volume, &mcubes::cancel::Cancel::new()).unwrap_err();
    let error = Error::at(folder.path(), error).to_string();
    assert!(error.contains("every 2 x 1 samples (XRsiz, YRsiz) is not read"), "{error}");
}
