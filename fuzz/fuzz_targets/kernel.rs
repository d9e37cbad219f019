//! Any bytes as a small volume and an iso value: the mesh keeps the promise, however it is cut
//! into slabs, by either method and with normals.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mcubes::kernel::Classify;
use mcubes::mesh::{Defects, Topology};
use mcubes::pipeline::{Method, RunOptions, SurfaceOptions};
use mcubes::volume::Side;
use ndarray::ArrayView3;

fuzz_target!(|bytes: &[u8]| {
    let Some((&[x, y, z, how, i0, i1], rest)) = bytes.split_first_chunk::<6>() else { return };
    let [nx, ny] = [x, y].map(|n| usize::from(n) % 70 + 1);
    let nz = usize::from(z) % 9 + 1;
    let n = nx * ny * nz;
    let side = if how & 1 == 1 { Side::Below } else { Side::AtLeast };
    let iso = f64::from(i16::from_le_bytes([i0, i1]));
    let method = if how & 16 == 16 { Method::Tetrahedra } else { Method::Cubes };
    let (open, normals) = (how & 2 == 2, how & 32 == 32);
    let surface = SurfaceOptions { side, method, open, normals, ..SurfaceOptions::at(iso / 8.0) };
    // Short inputs are repeated: small volumes are tried in full, large ones have patterns.
    let bytes = || rest.iter().copied().cycle();
    if rest.is_empty() {
        return;
    }
    match how >> 2 & 3 {
        0 => check::<u8>(bytes().take(n).collect(), [nz, ny, nx], &surface),
        1 => check::<i16>(chunks(bytes(), n, i16::from_le_bytes), [nz, ny, nx], &surface),
        2 => check::<f32>(chunks(bytes(), n, f32::from_le_bytes), [nz, ny, nx], &surface),
        _ => check::<f64>(chunks(bytes(), n, f64::from_le_bytes), [nz, ny, nx], &surface),
    }
});

fn chunks<const N: usize, T>(
    mut bytes: impl Iterator<Item = u8>,
    n: usize,
    make: impl Fn([u8; N]) -> T,
) -> Vec<T> {
    (0..n).map(|_| make(std::array::from_fn(|_| bytes.next().unwrap_or(0)))).collect()
}

fn check<T: Classify>(samples: Vec<T>, dims: [usize; 3], surface: &SurfaceOptions) {
    let volume = ArrayView3::from_shape(dims, &samples).expect("as many samples as wanted");
    let alone = RunOptions { threads: 1, ..RunOptions::default() };
    let mesh = mcubes::mesh(volume, surface, &alone).expect("small volumes are meshed");
    let slabs = RunOptions { threads: 2, slab_planes: Some(1), ..RunOptions::default() };
    let again = mcubes::mesh(volume, surface, &slabs).expect("small volumes are meshed");
    assert_eq!(mesh.vertices[..], again.vertices[..]);
    assert_eq!(mesh.triangles[..], again.triangles[..]);
    assert_eq!(mesh.normals.as_deref(), again.normals.as_deref());
    for normal in mesh.normals.as_deref().unwrap_or_default() {
        let length = normal.iter().map(|x| x * x).sum::<f32>();
        assert!((length - 1.0).abs() < 1e-5, "{normal:?}");
    }
    let found = Topology::of(&mesh.vertices, &mesh.triangles);
    let boundary = if surface.open { found.defects.boundary_edges } else { 0 };
    assert_eq!(found.defects, Defects { boundary_edges: boundary, ..Defects::default() });
    if found.n_triangles > 0 && !surface.open {
        assert!(found.closed && found.manifold && found.outward, "{found:?}");
    }
}
