//! NIfTI of either version and byte order, written field by field as nifti1.h and nifti2.h have it.

use std::io::Write;

/// A volume of `i16` whose place and scaling are `f32`, which headers of both versions hold.
pub(crate) struct Nifti {
    pub(crate) dims: [i16; 3],
    /// The sform: voxel indices to RAS millimetres.
    pub(crate) rows: [[f32; 4]; 3],
    pub(crate) slope: f32,
    pub(crate) inter: f32,
    /// i fastest.
    pub(crate) samples: Vec<i16>,
}

/// How it is written.
#[derive(Clone, Copy)]
pub(crate) struct Form {
    /// 1 or 2.
    pub(crate) version: u8,
    pub(crate) big_endian: bool,
}

/// A header in the making.
struct Header {
    bytes: Vec<u8>,
    big_endian: bool,
}

impl Header {
    /// A field of one number, given little-endian.
    fn put<const N: usize>(&mut self, at: usize, mut number: [u8; N]) {
        if self.big_endian {
            number.reverse();
        }
        self.bytes[at..at + N].copy_from_slice(&number);
    }
}

impl Nifti {
    /// Header and samples in one file.
    pub(crate) fn file(&self, form: Form) -> Vec<u8> {
        [self.header(form, true), self.image(form)].concat()
    }

    /// The two files of a pair: `.hdr` and `.img`.
    pub(crate) fn pair(&self, form: Form) -> [Vec<u8>; 2] {
        [self.header(form, false), self.image(form)]
    }

    /// The samples alone.
    pub(crate) fn image(&self, form: Form) -> Vec<u8> {
        let bytes = |x: &i16| if form.big_endian { x.to_be_bytes() } else { x.to_le_bytes() };
        self.samples.iter().flat_map(bytes).collect()
    }

    fn header(&self, Form { version, big_endian }: Form, single: bool) -> Vec<u8> {
        // Four bytes say that no extension follows.
        let size = if version == 1 { 348 } else { 540 };
        let mut header = Header { bytes: vec![0; size + 4], big_endian };
        header.put(0, i32::to_le_bytes(size as i32));
        let magic = match (version, single) {
            (1, true) => "n+1\0",
            (1, false) => "ni1\0",
            (_, true) => "n+2\0\r\n\x1a\n",
            (_, false) => "ni2\0\r\n\x1a\n",
        };
        let at = if version == 1 { 344 } else { 4 };
        header.bytes[at..at + magic.len()].copy_from_slice(magic.as_bytes());
        let offset = if single { size + 4 } else { 0 };
        if version == 1 {
            self.version_1(&mut header, offset);
        } else {
            self.version_2(&mut header, offset);
        }
        header.bytes
    }

    fn dim(&self) -> [i16; 8] {
        let [nx, ny, nz] = self.dims;
        [3, nx, ny, nz, 1, 1, 1, 1]
    }

    fn version_1(&self, header: &mut Header, offset: usize) {
        self.dim().iter().enumerate().for_each(|(d, n)| header.put(40 + 2 * d, n.to_le_bytes()));
        header.put(70, 4_i16.to_le_bytes());
        header.put(72, 16_i16.to_le_bytes());
        (0..8).for_each(|d| header.put(76 + 4 * d, 1_f32.to_le_bytes()));
        header.put(108, (offset as f32).to_le_bytes());
        header.put(112, self.slope.to_le_bytes());
        header.put(116, self.inter.to_le_bytes());
        header.put(123, [2]);
        header.put(254, 1_i16.to_le_bytes());
        for (n, v) in self.rows.iter().flatten().enumerate() {
            header.put(280 + 4 * n, v.to_le_bytes());
        }
    }

    fn version_2(&self, header: &mut Header, offset: usize) {
        header.put(12, 4_i16.to_le_bytes());
        header.put(14, 16_i16.to_le_bytes());
        let dim = self.dim().map(i64::from);
        dim.iter().enumerate().for_each(|(d, n)| header.put(16 + 8 * d, n.to_le_bytes()));
        (0..8).for_each(|d| header.put(104 + 8 * d, 1_f64.to_le_bytes()));
        header.put(168, (offset as i64).to_le_bytes());
        header.put(176, f64::from(self.slope).to_le_bytes());
        header.put(184, f64::from(self.inter).to_le_bytes());
        header.put(348, 1_i32.to_le_bytes());
        for (n, v) in self.rows.iter().flatten().enumerate() {
            header.put(400 + 8 * n, f64::from(*v).to_le_bytes());
        }
        header.put(500, 2_i32.to_le_bytes());
    }
}

/// `bytes` gzipped into a file of `size` bytes: an extra field of the header (RFC 1952, 2.3.1.1)
/// fills it.
pub(crate) fn gzip_of_size(bytes: &[u8], size: usize) -> Vec<u8> {
    let packed = |extra: usize| {
        let gzip = flate2::GzBuilder::new().extra(vec![0; extra]);
        let mut encoder = gzip.write(Vec::new(), flate2::Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let file = packed(size - packed(0).len());
    assert_eq!(file.len(), size);
    file
}
