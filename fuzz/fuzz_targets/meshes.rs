//! Any bytes as a mesh file: read, and judged.

#![no_main]

use libfuzzer_sys::fuzz_target;
use mcubes::Kind;

fuzz_target!(|bytes: &[u8]| {
    mcubes_fuzz::with_file(bytes, |path| match mcubes::reader::read(path) {
        Ok(mesh) => {
            let n_vertices = mesh.vertices.len();
            assert!(mesh.triangles.iter().flatten().all(|&id| (id as usize) < n_vertices));
            let topology = mesh.topology();
            assert_eq!(topology.n_triangles, mesh.triangles.len() as u64);
        }
        Err(error) => assert_ne!(error.kind(), Kind::Internal),
    });
});
