//! Tests that measure memory run in a process of their own: others would be measured with them.
//! They are tests of Linux alone, which tells the peak: what cannot measure does not pass.

use std::process::Command;

/// Set in the process that runs one test alone.
const ALONE: &str = "MCUBES_TEST_ALONE";

/// Whether this is a process of the test's own. Where it is not, the test is run in one, and has to
/// pass there.
pub(crate) fn is_alone(test: &str) -> bool {
    if std::env::var_os(ALONE).is_some() {
        return true;
    }
    let mut command = Command::new(std::env::current_exe().unwrap());
    let output = command.args([test, "--exact"]).env(ALONE, "1").output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("1 passed"), "{test}: {said}");
    false
}

/// The most memory that this process has had, in KiB.
pub(crate) fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    peak.trim().trim_end_matches(" kB").parse().unwrap()
}

/// Holds the most memory that this process has had against a limit.
pub(crate) fn assert_peak_below(limit_mib: u64) {
    let peak = peak_kib();
    assert!(peak <= limit_mib << 10, "{} MiB, at most {limit_mib}", peak >> 10);
}
