//! Writes DICOM: real headers, explicit VR little endian, phantom pixels of known shape.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;

use mcubes::geom::vec3::{Vec3, add, norm, scale, sub};

/// Every patient attribute that is written holds this word, so that a leak can be searched for.
pub(crate) const SECRET: &str = "SECRETWORD";

/// An ellipsoid with axes along the patient's: real values rise through `LEVEL` at its surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ellipsoid {
    /// Centre, LPS mm.
    pub(crate) centre: Vec3,
    /// Semi-axes, mm.
    pub(crate) semi: Vec3,
}

impl Ellipsoid {
    pub(crate) const LEVEL: f64 = 500.0;

    /// 1000 well inside, 0 well outside, linear in between over 6 mm of the (first-order) distance
    /// to the surface.
    fn value(&self, point: Vec3) -> f64 {
        (Self::LEVEL - self.distance(point) / 6.0 * 1000.0).clamp(0.0, 1000.0)
    }

    /// The distance to the surface, to first order; negative inside.
    pub(crate) fn distance(&self, point: Vec3) -> f64 {
        let p = sub(point, self.centre);
        let once = norm([p[0] / self.semi[0], p[1] / self.semi[1], p[2] / self.semi[2]]);
        let twice = norm([0, 1, 2].map(|a: usize| p[a] / (self.semi[a] * self.semi[a])));
        if twice < 1e-9 { -self.semi[0] } else { once * (once - 1.0) / twice }
    }

    pub(crate) fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.semi[0] * self.semi[1] * self.semi[2]
    }
}

/// Explicit VR little endian.
pub(crate) const EXPLICIT: &str = "1.2.840.10008.1.2.1";

/// `PixelData`.
pub(crate) const PIXELS: (u16, u16) = (0x7FE0, 0x0010);

/// A series of slices through an ellipsoid.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    pub(crate) uid: String,
    pub(crate) number: u32,
    pub(crate) cols: u16,
    pub(crate) rows: u16,
    /// Between rows, between columns, mm.
    pub(crate) spacing: [f64; 2],
    /// Along a row (rising columns) and along a column, LPS.
    pub(crate) row: Vec3,
    pub(crate) column: Vec3,
    /// The first sample of each slice, LPS mm.
    pub(crate) positions: Vec<Vec3>,
    pub(crate) body: Ellipsoid,
    pub(crate) image_type: &'static str,
    /// Written in front of the pixels.
    pub(crate) extra: Elements,
}

impl Series {
    /// Slices of 40 × 36 samples whose middle is the ellipsoid's centre, moved by `step` from one
    /// to the next.
    pub(crate) fn through(row: Vec3, column: Vec3, step: Vec3, n: usize) -> Self {
        let body = Ellipsoid { centre: [11.0, -27.0, 43.0], semi: [17.0, 12.0, 14.0] };
        let (cols, rows, spacing) = (40_u16, 36_u16, [1.3, 1.2]);
        let corner = add(
            scale(row, -f64::from(cols - 1) / 2.0 * spacing[1]),
            scale(column, -f64::from(rows - 1) / 2.0 * spacing[0]),
        );
        let middle = (n - 1) as f64 / 2.0;
        let position = |k: usize| add(add(body.centre, corner), scale(step, k as f64 - middle));
        Self {
            uid: "1.2.826.0.1.3680043.9.7.1".to_owned(),
            number: 1,
            cols,
            rows,
            spacing,
            row,
            column,
            positions: (0..n).map(position).collect(),
            body,
            image_type: "ORIGINAL\\PRIMARY\\AXIAL",
            extra: Elements::default(),
        }
    }

    /// Axial slices 1.5 mm apart.
    pub(crate) fn axial(n: usize) -> Self {
        Self::through([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.5], n)
    }

    /// Writes one file a slice, in a scrambled order of names and instance numbers.
    pub(crate) fn write(&self, folder: &Path) {
        self.write_as(folder, EXPLICIT, |_, _| {});
    }

    /// As [`Self::write`], in a transfer syntax and with each slice's elements changed first.
    pub(crate) fn write_as(
        &self,
        folder: &Path,
        syntax: &str,
        change: impl Fn(usize, &mut Elements),
    ) {
        std::fs::create_dir_all(folder).unwrap();
        let n = self.positions.len();
        for k in 0..n {
            let name = format!("I{:04}", (k * 7 + 3) % 1009);
            let mut data = self.elements(k, n - k);
            change(k, &mut data);
            std::fs::write(folder.join(name), file(syntax, &data)).unwrap();
        }
    }

    /// The bytes of one slice's file.
    pub(crate) fn image(&self, k: usize, instance: usize) -> Vec<u8> {
        file(EXPLICIT, &self.elements(k, instance))
    }

    /// The data set of one slice.
    fn elements(&self, k: usize, instance: usize) -> Elements {
        let position = self.positions[k];
        let mut pixels = Vec::new();
        for j in 0..self.rows {
            for i in 0..self.cols {
                let point = add(
                    position,
                    add(
                        scale(self.row, f64::from(i) * self.spacing[1]),
                        scale(self.column, f64::from(j) * self.spacing[0]),
                    ),
                );
                // Stored with a slope of 0.25 and an intercept of -100.
                let stored = ((self.body.value(point) + 100.0) / 0.25).round() as u16;
                pixels.extend(stored.to_le_bytes());
            }
        }
        let decimals = |values: &[f64]| {
            values.iter().map(|v| format!("{v:.9}")).collect::<Vec<_>>().join("\\")
        };
        let directions = [self.row, self.column].concat();
        let mut data = Elements::default();
        data.text((0x0008, 0x0008), *b"CS", self.image_type);
        data.text((0x0008, 0x0016), *b"UI", "1.2.840.10008.5.1.4.1.1.2");
        data.text((0x0008, 0x0018), *b"UI", &format!("{}.{instance}", self.uid));
        data.text((0x0008, 0x0050), *b"SH", SECRET);
        data.text((0x0008, 0x0060), *b"CS", "CT");
        data.text((0x0008, 0x103E), *b"LO", "ellipsoid");
        data.text((0x0010, 0x0010), *b"PN", SECRET);
        data.text((0x0010, 0x0020), *b"LO", SECRET);
        data.text((0x0018, 0x0050), *b"DS", "9.75");
        data.text((0x0020, 0x000E), *b"UI", &self.uid);
        data.text((0x0020, 0x0011), *b"IS", &self.number.to_string());
        data.text((0x0020, 0x0013), *b"IS", &instance.to_string());
        data.text((0x0020, 0x0032), *b"DS", &decimals(&position));
        data.text((0x0020, 0x0037), *b"DS", &decimals(&directions));
        data.text((0x0020, 0x0052), *b"UI", "1.2.826.0.1.3680043.9.7.0");
        data.short((0x0028, 0x0002), 1);
        data.text((0x0028, 0x0004), *b"CS", "MONOCHROME2");
        data.short((0x0028, 0x0010), self.rows);
        data.short((0x0028, 0x0011), self.cols);
        data.text((0x0028, 0x0030), *b"DS", &decimals(&self.spacing));
        data.short((0x0028, 0x0100), 16);
        data.short((0x0028, 0x0101), 16);
        data.short((0x0028, 0x0102), 15);
        data.short((0x0028, 0x0103), 0);
        data.text((0x0028, 0x1052), *b"DS", "-100");
        data.text((0x0028, 0x1053), *b"DS", "0.25");
        data.0.extend(&self.extra.0);
        data.element(PIXELS, *b"OW", &pixels);
        data
    }
}

/// A data set being written, explicit VR little endian.
#[derive(Clone, Debug, Default)]
pub(crate) struct Elements(pub(crate) Vec<u8>);

impl Elements {
    pub(crate) fn element(&mut self, (group, element): (u16, u16), vr: [u8; 2], value: &[u8]) {
        self.0.extend(group.to_le_bytes());
        self.0.extend(element.to_le_bytes());
        self.0.extend(vr);
        let length = value.len() + value.len() % 2;
        if is_long(&vr) {
            self.0.extend([0, 0]);
            self.0.extend((length as u32).to_le_bytes());
        } else {
            self.0.extend((length as u16).to_le_bytes());
        }
        self.0.extend(value);
        if value.len() % 2 == 1 {
            self.0.push(if &vr == b"UI" { 0 } else { b' ' });
        }
    }

    /// The tag of the first element, and where its value begins and ends.
    fn first(&self) -> ((u16, u16), usize, usize) {
        let number = |at: usize, n: usize| {
            self.0[at..at + n].iter().rev().fold(0, |sum, &b| sum << 8 | usize::from(b))
        };
        let tag = (number(0, 2) as u16, number(2, 2) as u16);
        let (value, length) =
            if is_long(&self.0[4..6]) { (12, number(8, 4)) } else { (8, number(6, 2)) };
        (tag, value, value + length)
    }

    /// Where an element of the data set begins, and where its value begins and ends; an empty place
    /// in rising order of tags where there is none.
    fn find(&self, wanted: (u16, u16)) -> (usize, usize, usize) {
        let mut at = 0;
        while at < self.0.len() {
            let (tag, value, end) = Self(self.0[at..].to_vec()).first();
            if tag >= wanted {
                return if tag == wanted { (at, at + value, at + end) } else { (at, at, at) };
            }
            at += end;
        }
        (at, at, at)
    }

    /// An element's value; empty where there is none.
    pub(crate) fn value(&self, tag: (u16, u16)) -> &[u8] {
        let (_, from, to) = self.find(tag);
        &self.0[from..to]
    }

    /// Puts an element in its place, instead of the one that is there.
    pub(crate) fn set(&mut self, tag: (u16, u16), vr: [u8; 2], value: &[u8]) {
        let (from, _, to) = self.find(tag);
        let mut element = Self::default();
        element.element(tag, vr, value);
        self.0.splice(from..to, element.0);
    }

    /// Takes an element out.
    pub(crate) fn remove(&mut self, tag: (u16, u16)) {
        let (from, _, to) = self.find(tag);
        self.0.drain(from..to);
    }

    /// Makes an element's length, of four bytes, an undefined one; its value has a delimiter.
    pub(crate) fn leave_length_open(&mut self, tag: (u16, u16)) {
        let (_, value, _) = self.find(tag);
        self.0[value - 4..value].fill(0xFF);
    }

    /// Writes the elements in implicit VR.
    pub(crate) fn make_implicit(&mut self) {
        let mut implicit = Vec::new();
        let mut rest = Self(std::mem::take(&mut self.0));
        while !rest.0.is_empty() {
            let (_, value, end) = rest.first();
            implicit.extend(&rest.0[..4]);
            implicit.extend(((end - value) as u32).to_le_bytes());
            implicit.extend(&rest.0[value..end]);
            rest.0.drain(..end);
        }
        self.0 = implicit;
    }

    /// Sets an element to what a value is as text.
    pub(crate) fn set_text(&mut self, tag: (u16, u16), vr: [u8; 2], value: impl ToString) {
        self.set(tag, vr, value.to_string().as_bytes());
    }

    /// Encapsulates a compressed image as the pixels, which come last.
    pub(crate) fn set_image(&mut self, image: &[u8]) {
        self.set_fragments(&[], &[image.to_vec()]);
    }

    /// Encapsulates fragments behind a table of offsets as the pixels, which come last.
    pub(crate) fn set_fragments(&mut self, offsets: &[u32], fragments: &[Vec<u8>]) {
        let (from, ..) = self.find(PIXELS);
        self.0.truncate(from);
        self.0.extend([0xE0, 0x7F, 0x10, 0, b'O', b'B', 0, 0, 0xFF, 0xFF, 0xFF, 0xFF]);
        let table: Vec<u8> = offsets.iter().flat_map(|o| o.to_le_bytes()).collect();
        for item in [&table].into_iter().chain(fragments) {
            let even = item.len() + item.len() % 2;
            self.0.extend([0xFE, 0xFF, 0, 0xE0]);
            self.0.extend((even as u32).to_le_bytes());
            self.0.extend(item);
            self.0.resize(self.0.len() + even - item.len(), 0);
        }
        self.0.extend([0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
    }

    /// Writes the elements big endian.
    pub(crate) fn make_big(&mut self) {
        let mut big = Vec::new();
        let mut rest = Self(std::mem::take(&mut self.0));
        while !rest.0.is_empty() {
            let (_, value, end) = rest.first();
            let (head, content) = (rest.0[..value].to_vec(), &rest.0[value..end]);
            let vr = [head[4], head[5]];
            let flip = |bytes: &[u8]| bytes.iter().rev().copied().collect::<Vec<u8>>();
            let content = match &vr {
                b"US" | b"OW" => content.chunks(2).flat_map(flip).collect(),
                b"SQ" => {
                    let mut items = Vec::new();
                    let mut left = content;
                    while !left.is_empty() {
                        let length = u32::from_le_bytes([left[4], left[5], left[6], left[7]]);
                        let (item, others) = left.split_at(8 + length as usize);
                        items.extend([0xFF, 0xFE, 0xE0, 0x00]);
                        items.extend(length.to_be_bytes());
                        let mut inner = Self(item[8..].to_vec());
                        inner.make_big();
                        items.extend(inner.0);
                        left = others;
                    }
                    items
                }
                _ => content.to_vec(),
            };
            big.extend([flip(&head[..2]), flip(&head[2..4]), vr.to_vec()].concat());
            big.extend(if head.len() == 12 {
                [&[0, 0], &flip(&head[8..])[..]].concat()
            } else {
                flip(&head[6..])
            });
            big.extend(content);
            rest.0.drain(..end);
        }
        self.0 = big;
    }

    pub(crate) fn text(&mut self, tag: (u16, u16), vr: [u8; 2], value: &str) {
        self.element(tag, vr, value.as_bytes());
    }

    /// A sequence with the items given, all of defined length.
    pub(crate) fn sequence(&mut self, tag: (u16, u16), items: &[Self]) {
        let mut value = Vec::new();
        for item in items {
            value.extend([0xFE, 0xFF, 0x00, 0xE0]);
            value.extend((item.0.len() as u32).to_le_bytes());
            value.extend(&item.0);
        }
        self.element(tag, *b"SQ", &value);
    }

    pub(crate) fn short(&mut self, tag: (u16, u16), value: u16) {
        self.element(tag, *b"US", &value.to_le_bytes());
    }
}

fn is_long(vr: &[u8]) -> bool {
    matches!(vr, b"OB" | b"OW" | b"OF" | b"OD" | b"SQ" | b"UN")
}

/// Preamble, file meta group and data set.
pub(crate) fn file(syntax: &str, data: &Elements) -> Vec<u8> {
    let mut meta = Elements::default();
    meta.text((0x0002, 0x0002), *b"UI", "1.2.840.10008.5.1.4.1.1.2");
    meta.text((0x0002, 0x0010), *b"UI", syntax);
    let mut group = Elements::default();
    group.element((0x0002, 0x0000), *b"UL", &(meta.0.len() as u32).to_le_bytes());
    [&[0; 128], b"DICM".as_slice(), &group.0, &meta.0, &data.0].concat()
}
