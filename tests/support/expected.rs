//! What independent readers see in the test volumes.

use std::path::PathBuf;

use mcubes::volume::Meta;
use serde_json::Value;

/// One test volume and what is expected of it.
pub struct Entry {
    /// The folder that the name is in.
    pub root: PathBuf,
    pub name: String,
    pub facts: Value,
}

impl Entry {
    pub fn path(&self) -> PathBuf {
        self.root.join(&self.name)
    }

    pub fn is(&self, status: &str) -> bool {
        self.facts["status"] == status
    }
}

/// The entries of one section of `expected-nifti.json`: those in `testdata` always, those in the
/// whole collection where `MCUBES_SCANS` names it.
pub fn entries(section: &str) -> Vec<Entry> {
    let mut all = Vec::new();
    for root in [Some(super::repository("testdata")), super::named_scans()].into_iter().flatten() {
        let text = std::fs::read_to_string(root.join("expected-nifti.json")).unwrap();
        let mut facts: Value = serde_json::from_str(&text).unwrap();
        let Value::Object(facts) = facts[section].take() else { panic!("no section {section}") };
        all.extend(facts.into_iter().map(|(name, facts)| Entry {
            root: root.clone(),
            name,
            facts,
        }));
    }
    all
}

pub fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Compares range, number of values that are not finite, and checksums.
pub fn compare_values(what: &str, entry: &Value, meta: &Meta, stored: &[f64]) {
    use super::planes::checksum;
    assert_eq!(checksum(stored.iter().copied()), entry["crc_stored"].as_str().unwrap(), "{what}");
    let real: Vec<f64> = stored.iter().map(|&v| meta.rescale.real(v)).collect();
    if let Some(crc) = entry["crc_scaled"].as_str() {
        assert_eq!(checksum(real.iter().copied()), crc, "{what}: scaled");
    }
    let finite = || real.iter().copied().filter(|v| v.is_finite());
    let close = |got: f64, key: &str| {
        if let Some(want) = entry[key].as_f64() {
            assert!((got - want).abs() <= 1e-9 * want.abs(), "{what}: {key} {got}, not {want}");
        }
    };
    close(finite().fold(f64::INFINITY, f64::min), "min");
    close(finite().fold(f64::NEG_INFINITY, f64::max), "max");
    let n_odd = (real.len() - finite().count()) as u64;
    assert_eq!(n_odd, entry["nonfinite"].as_u64().unwrap(), "{what}: not finite");
    if let Some(iso) = entry["iso"].as_f64() {
        let n = real.iter().filter(|v| **v >= iso).count() as u64;
        assert_eq!(n, entry["voxels_ge_iso"].as_u64().unwrap(), "{what}: at or above {iso}");
    }
}
