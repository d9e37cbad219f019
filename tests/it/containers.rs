//! The same thing in any container gives the same bytes: the same affine to the bit, order of
//! samples, stored type and rescale.

use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::support::nifti::{Form, Nifti};
use crate::support::random::Random;
use crate::support::sandbox::{Sandbox, stderr};

const FORMS: [(&str, Form); 4] = [
    ("1", Form { version: 1, big_endian: false }),
    ("1-big", Form { version: 1, big_endian: true }),
    ("2", Form { version: 2, big_endian: false }),
    ("2-big", Form { version: 2, big_endian: true }),
];

/// Noise, so that the mesh has all that cells can have.
fn noise(rows: [[f32; 4]; 3], slope: f32, inter: f32) -> Nifti {
    let mut random = Random::new(71);
    let samples = (0..13 * 11 * 9).map(|_| random.below(2001) as i16 - 1000).collect();
    Nifti { dims: [13, 11, 9], rows, slope, inter, samples }
}

/// In two members, as several files put together have them.
fn gzip(bytes: &[u8]) -> Vec<u8> {
    let (head, tail) = bytes.split_at(bytes.len() / 3);
    let pack = |part: &[u8]| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(part).unwrap();
        encoder.finish().unwrap()
    };
    [pack(head), pack(tail)].concat()
}

/// The meshes that the command makes of a volume, by the arguments that name its container.
struct Meshes<'a> {
    sandbox: &'a Sandbox,
    /// Iso value and space.
    asked: &'a str,
    extension: &'a str,
    found: Vec<(String, Vec<u8>)>,
}

impl Meshes<'_> {
    fn of(&mut self, input: &str, stdin: Option<&Path>) {
        let (asked, out) = (self.asked, format!("out.{}", self.extension));
        let words = format!("{input} {asked} -q -o {out}");
        let mut command = self.sandbox.command(&words.split_whitespace().collect::<Vec<_>>());
        if let Some(path) = stdin {
            command.stdin(std::fs::File::open(path).unwrap());
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{words}: {}", stderr(&output));
        self.found.push((words, self.sandbox.bytes(&out)));
    }

    /// All are the same, and no mesh of a few triangles only; how many there are.
    fn same(&self) -> usize {
        let (first, bytes) = &self.found[0];
        assert!(bytes.len() > 50_000, "{first}: {} bytes", bytes.len());
        for (other, theirs) in &self.found {
            assert!(theirs == bytes, "{first}\n{other}");
        }
        self.found.len()
    }
}

/// Puts all files that NIfTI has for a volume into a folder; their names.
fn put_nifti(sandbox: &Sandbox, volume: &Nifti) -> Vec<String> {
    let mut names = Vec::new();
    let mut put = |name: String, bytes: &[u8]| {
        std::fs::write(sandbox.path(&name), bytes).unwrap();
        names.push(name);
    };
    for (form_name, form) in FORMS {
        let file = volume.file(form);
        put(format!("{form_name}.nii"), &file);
        put(format!("{form_name}.nii.gz"), &gzip(&file));
        let [header, image] = volume.pair(form);
        put(format!("{form_name}.hdr"), &header);
        put(format!("{form_name}.img"), &image);
        put(format!("{form_name}-packed.hdr"), &header);
        put(format!("{form_name}-packed.img.gz"), &gzip(&image));
    }
    names
}

#[test]
fn nifti_of_any_version_byte_order_and_packing_gives_the_same_bytes() {
    let sandbox = Sandbox::new();
    let rows = [[0.71, -0.29, 0.83, -101.3], [0.35, 0.88, -0.41, 47.7], [-0.13, 0.37, 2.09, 912.1]];
    let volume = noise(rows, 0.37, -13.9);
    let names = put_nifti(&sandbox, &volume);
    // The real value of a sample: on which side it lies hangs on the last bit of slope and inter.
    let iso = f64::from(0.37_f32) * f64::from(volume.samples[600]) + f64::from(-13.9_f32);
    for (space, extension) in [("ras", "stl"), ("lps", "ply"), ("voxel", "obj")] {
        let asked = format!("--iso {iso} --space {space} --threads 3");
        let found = Vec::new();
        let mut meshes = Meshes { sandbox: &sandbox, asked: &asked, extension, found };
        for name in &names {
            meshes.of(name, None);
        }
        assert_eq!(meshes.same(), 24);
    }
}

#[test]
fn raw_samples_give_the_bytes_of_the_same_samples_in_nifti() {
    let sandbox = Sandbox::new();
    // Numbers that decimals and single precision both hold, since raw takes the one, NIfTI the other.
    let rows = [[0.75, 0.0, 0.0, -101.25], [0.0, 1.5, 0.0, 47.5], [0.0, 0.0, 2.125, 912.0]];
    let volume = noise(rows, 1.0, 0.0);
    let names = put_nifti(&sandbox, &volume);
    let said = "--dims 13x11x9 --type i16 --spacing 0.75x1.5x2.125 --origin -101.25,47.5,912";
    for extension in ["stl", "ply"] {
        let asked = "--iso 17 --threads 2";
        let found = Vec::new();
        let mut meshes = Meshes { sandbox: &sandbox, asked, extension, found };
        for name in &names {
            meshes.of(name, None);
        }
        for (order, form) in [("little", FORMS[0].1), ("big", FORMS[1].1)] {
            let plain = volume.image(form);
            let later = [&[7; 5][..], &plain].concat();
            for (name, bytes, offset) in [
                ("a", &plain, 0),
                ("a.gz", &gzip(&plain), 0),
                ("b", &later, 5),
                ("b.gz", &gzip(&later), 5),
            ] {
                let path = sandbox.path(name);
                std::fs::write(&path, bytes).unwrap();
                let more = format!("{said} --endian {order} --offset {offset}");
                meshes.of(&format!("{name} {more}"), None);
                // Nothing tells the size of standard input.
                meshes.of(&format!("- {more}"), Some(&path));
            }
        }
        assert_eq!(meshes.same(), 24 + 16);
    }
}
