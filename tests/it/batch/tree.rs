//! All test data in one run.

use std::path::Path;

use serde_json::Value;

use crate::support::sandbox::Sandbox;
use crate::support::scans;

/// The objects about an input or something below it.
fn about<'v>(reported: &'v [Value], input: &Path) -> Vec<&'v Value> {
    let is_within = |o: &&Value| Path::new(o["input"].as_str().unwrap()).starts_with(input);
    reported.iter().filter(is_within).collect()
}

fn expected(name: &str, key: &str) -> Value {
    let text = std::fs::read(scans().join(name)).unwrap();
    serde_json::from_slice::<Value>(&text).unwrap()[key].clone()
}

/// Volumes that are read but have no surface that could be written: one value, or too far away.
fn is_without_surface(object: &Value) -> bool {
    ["iso-not-reached", "out-of-range-space"].iter().any(|kind| object["error"]["kind"] == *kind)
}

#[test]
#[ignore = "needs the whole collection of scans in MCUBES_SCANS"]
fn good_odd_and_malformed_scans_go_through_in_one_command() {
    let data = scans();
    let sandbox = Sandbox::new();
    let words = format!(
        "{} --recursive --iso auto -o out --name {{parent}}/{{file}}_{{series}} --format ply --json -q",
        data.display()
    );
    let (_, reported) = sandbox.ends(1, &words);
    for (name, item) in expected("expected-nifti.json", "nifti").as_object().unwrap() {
        // A folder called like an image, a file that is not there, the other part of a pair.
        let found = about(&reported, &data.join(name));
        let status = item["status"].as_str().unwrap();
        if status == "good" {
            let fine = |o: &&Value| o["status"] == "ok" || is_without_surface(o);
            assert!(!found.is_empty() && found.iter().all(fine), "{name}: {found:?}");
        }
        if status == "bad" {
            assert!(found.iter().all(|o| o["status"] == "failed"), "{name}: {found:?}");
            let is_there = data.join(name).is_file();
            assert_eq!(found.len(), usize::from(is_there), "{name}: {found:?}");
        }
    }
    for (name, item) in expected("expected-dicom.json", "items").as_object().unwrap() {
        let found = about(&reported, &data.join("dicom").join(name));
        let is_ok = found.iter().any(|o| o["status"] == "ok");
        // Segments are meshed only where their folder holds no images.
        let is_beside = name.contains("seg");
        match item["expect"].as_str().unwrap() {
            "mesh" | "mesh-warn" | "choose" => assert!(is_ok || is_beside, "{name}: {found:?}"),
            "error" => assert!(!is_ok, "{name}: {found:?}"),
            _ => {}
        }
    }
    let mut n_meshes = 0;
    for object in reported.iter().filter(|o| o["status"] == "ok") {
        let path = sandbox.path(object["output"].as_str().unwrap());
        let mesh = mcubes::reader::read(&path).unwrap();
        let mesh = mesh.topology();
        assert!(mesh.closed && mesh.manifold && mesh.outward, "{object}");
        n_meshes += 1;
    }
    assert!(n_meshes > 250, "{n_meshes}");
    assert_eq!(sandbox.names("out").len(), n_meshes);
}
