//! Metaballs: a formula instead of a scan, meshed plane by plane without ever holding the volume.
//!
//! ```text
//! cargo run --release --example metaballs -- [RESOLUTION [ISO [OUT]]]
//! cargo run --release --example metaballs -- 200 1 metaballs.ply
//! ```
//!
//! The field is the classic sum of `s² / r²` over a few balls: at `ISO` 1 a ball alone would have
//! radius `s`; near one another they flow together. A smaller value makes them fatter. `OUT` may
//! end in .stl, .ply or .obj.

use std::error::Error;
use std::path::Path;

use mcubes::geom::{Affine, Dims, Place, Space};
use mcubes::pipeline::{RunOptions, SurfaceOptions, extract};
use mcubes::sink::{MeshFile, MeshFormat, MeshOptions, Sink};
use mcubes::source::formula;

/// Centre and `s` of each ball, in millimetres.
const BALLS: [([f64; 3], f64); 4] = [
    ([-14.0, -6.0, 0.0], 11.0),
    ([10.0, -9.0, 4.0], 10.0),
    ([2.0, 13.0, -3.0], 9.0),
    ([0.0, 0.0, 18.0], 7.0),
];

/// The box from -`HALF` to `HALF` mm is sampled; the surface is closed where it leaves it.
const HALF: f64 = 40.0;

fn field(x: f64, y: f64, z: f64) -> f32 {
    let sum: f64 = BALLS
        .iter()
        .map(|([a, b, c], s)| s * s / ((x - a).powi(2) + (y - b).powi(2) + (z - c).powi(2)))
        .sum();
    sum as f32
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let resolution: i64 = words.next().map_or(Ok(128), |w| w.parse())?;
    let iso: f64 = words.next().map_or(Ok(1.0), |w| w.parse())?;
    let out = words.next().unwrap_or_else(|| "metaballs.stl".to_owned());

    let dims = Dims::checked(resolution, resolution, resolution, size_of::<f32>())?;
    let step = 2.0 * HALF / (resolution - 1).max(1) as f64;
    let affine = Affine::from_columns(
        [step, 0.0, 0.0],
        [0.0, step, 0.0],
        [0.0, 0.0, step],
        [-HALF, -HALF, -HALF],
    );
    let volume = formula(dims, affine, field)?;

    let format =
        MeshFormat::from_path(Path::new(&out)).ok_or("the name ends in no .stl, .ply or .obj")?;
    let place = Place::new(&volume.meta.grid, Space::Ras)?;
    let mut file = MeshFile::create(Path::new(&out), &MeshOptions::new(format))?;
    let surfaces: Vec<(SurfaceOptions, &mut dyn Sink)> = vec![(SurfaceOptions::at(iso), &mut file)];
    let reports = extract(volume, &place, surfaces, &RunOptions::default())?;
    file.commit()?;

    for report in reports {
        println!(
            "{out}: {} vertices, {} triangles, {:.1} mm², {:.1} mm³, {:.2} s",
            report.n_vertices,
            report.n_triangles,
            report.measure.area,
            report.measure.volume,
            report.seconds.total
        );
    }
    Ok(())
}
