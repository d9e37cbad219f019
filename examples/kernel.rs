//! Meshes one volume in memory, several times, and prints how long it took as one line of JSON.
//!
//! ```text
//! kernel --vol FILE.npy --iso X [--method M] [--threads N] [--again K] [--normals yes]
//!        [--dump PREFIX]
//! ```
//!
//! `FILE.npy` is an array in C order, (z, y, x), of i16, u8, f32 and the like. `--dump` writes the
//! vertices as PREFIX.v.f32 (x y z, voxel coordinates) and the triangles as PREFIX.f.u32; `--normals`
//! makes a normal for each vertex too.

use std::error::Error;
use std::fs;
use std::time::Instant;

use mcubes::kernel::Classify;
use mcubes::mesh::Buffer;
use mcubes::pipeline::{Method, RunOptions, SurfaceOptions};
use ndarray::ArrayView3;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let mut arguments = Arguments::default();
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next().ok_or(format!("{word} wants a value"))?;
        match word.as_str() {
            "--vol" => arguments.volume = value,
            "--iso" => arguments.iso = value.parse()?,
            "--method" => {
                arguments.method = match value.as_str() {
                    "cubes" => Method::Cubes,
                    "tetrahedra" => Method::Tetrahedra,
                    other => return Err(format!("{other} is no method").into()),
                }
            }
            "--threads" => arguments.threads = value.parse()?,
            "--again" => arguments.again = value.parse()?,
            "--normals" => arguments.normals = value == "yes",
            "--dump" => arguments.dump = Some(value),
            _ => return Err(format!("{word} is no option of this example").into()),
        }
    }
    let bytes = fs::read(&arguments.volume)?;
    let npy = Npy::parse(&bytes)?;
    match npy.descr {
        "|u1" => run::<u8>(&npy, &arguments),
        "|i1" => run::<i8>(&npy, &arguments),
        "<u2" => run::<u16>(&npy, &arguments),
        "<i2" => run::<i16>(&npy, &arguments),
        "<i4" => run::<i32>(&npy, &arguments),
        "<f4" => run::<f32>(&npy, &arguments),
        "<f8" => run::<f64>(&npy, &arguments),
        other => Err(format!("arrays of {other} are not read here").into()),
    }
}

#[derive(Default)]
struct Arguments {
    volume: String,
    iso: f64,
    method: Method,
    threads: usize,
    again: usize,
    normals: bool,
    dump: Option<String>,
}

fn run<T: Classify>(npy: &Npy<'_>, arguments: &Arguments) -> Result<()> {
    // In huge pages, where the system has them, as numpy keeps its arrays.
    let n_samples = npy.data.len() / size_of::<T>();
    let mut samples = Buffer::<T>::reserve(n_samples).ok_or("no memory for the volume")?;
    let bytes = npy.data.get(..n_samples * size_of::<T>()).ok_or("the .npy data are cut short")?;
    bytemuck::cast_slice_mut(&mut samples).copy_from_slice(bytes);
    let volume = ArrayView3::from_shape(npy.shape, &samples)?;
    let Arguments { iso, method, normals, .. } = *arguments;
    let surface = SurfaceOptions { method, normals, ..SurfaceOptions::at(iso) };
    let options = RunOptions { threads: arguments.threads.max(1), ..RunOptions::default() };
    let before = status_kib("VmRSS");
    let (mut ms, mut cpu_ms) = (Vec::new(), Vec::new());
    for call in 0..=arguments.again {
        let (wall, cpu) = (Instant::now(), cpu_seconds());
        let mesh = mcubes::mesh(volume, &surface, &options)?;
        ms.push(wall.elapsed().as_secs_f64() * 1e3);
        cpu_ms.push((cpu_seconds() - cpu) * 1e3);
        if call == arguments.again {
            let peak = status_kib("VmHWM").saturating_sub(before) as f64 / 1024.0;
            println!(
                "{}",
                serde_json::json!({
                    "volume": arguments.volume, "threads": options.threads, "ms": ms,
                    "cpu_ms": cpu_ms, "triangles": mesh.triangles.len(),
                    "vertices": mesh.vertices.len(), "rss_extra_mib": peak,
                })
            );
            if let Some(prefix) = &arguments.dump {
                fs::write(format!("{prefix}.v.f32"), bytemuck::cast_slice(&mesh.vertices))?;
                fs::write(format!("{prefix}.f.u32"), bytemuck::cast_slice(&mesh.triangles))?;
            }
        }
    }
    Ok(())
}

/// The parts of a `.npy` file (NEP 1).
struct Npy<'a> {
    descr: &'a str,
    shape: (usize, usize, usize),
    data: &'a [u8],
}

impl<'a> Npy<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self> {
        let (header, data) = match bytes.strip_prefix(b"\x93NUMPY").ok_or("no .npy file")? {
            [1, _, a, b, rest @ ..] => rest.split_at_checked(u16::from_le_bytes([*a, *b]).into()),
            [_, _, a, b, c, d, rest @ ..] => {
                rest.split_at_checked(u32::from_le_bytes([*a, *b, *c, *d]) as usize)
            }
            _ => None,
        }
        .ok_or("the .npy header is cut short")?;
        let header = std::str::from_utf8(header)?;
        let field = |name: &str| {
            let rest = header.split_once(&format!("'{name}':")).ok_or(format!("no {name}"))?.1;
            Ok::<_, String>(rest.trim_start())
        };
        if field("fortran_order")?.starts_with("True") {
            return Err("the array must be in C order".into());
        }
        let descr = field("descr")?.split('\'').nth(1).ok_or("no descr")?;
        let shape = field("shape")?.trim_start_matches('(').split(')').next().unwrap_or_default();
        let shape: Vec<usize> =
            shape.split(',').map(|n| n.trim().parse()).collect::<std::result::Result<_, _>>()?;
        let [nz, ny, nx] = shape[..] else { return Err("the array must have three axes".into()) };
        Ok(Self { descr, shape: (nz, ny, nx), data })
    }
}

/// A line of /proc/self/status, in KiB; 0 where there is none.
fn status_kib(name: &str) -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
    line.and_then(|l| l.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

/// Seconds of processor time of all threads so far; the clock of the system counts in hundredths,
/// which is all that the standard library can see.
fn cpu_seconds() -> f64 {
    let threads = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let ticks = threads.rsplit(')').next().map(|rest| {
        rest.split_whitespace().skip(11).take(2).filter_map(|n| n.parse::<f64>().ok()).sum::<f64>()
    });
    ticks.unwrap_or(0.0) / 100.0
}
