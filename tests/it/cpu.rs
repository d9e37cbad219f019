//! Which instruction sets the tests of the kernel can try here: wider ones fall back to these.

use std::process::Command;

use mcubes::kernel::{Cpu, cpu};

const SETS: [(&str, Cpu); 4] =
    [("scalar", Cpu::Scalar), ("sse2", Cpu::Sse2), ("avx2", Cpu::Avx2), ("avx512", Cpu::Avx512)];

/// Set in a process that only says which set it found.
const ASKED: &str = "MCUBES_TEST_CPU";

/// The set that a process finds which is asked for one. Each looks once, so each has its own.
fn found(asked: &str) -> Cpu {
    let test = "cpu::the_widest_set_is_used_unless_a_lower_one_is_asked_for";
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args([test, "--exact", "--nocapture"]).env(ASKED, "1").env("MCUBES_CPU", asked);
    let said = String::from_utf8(command.output().unwrap().stdout).unwrap();
    let set = SETS.into_iter().find(|(_, set)| said.contains(&format!("found {set:?}.")));
    set.unwrap_or_else(|| panic!("{asked}: {said}")).1
}

#[test]
fn the_widest_set_is_used_unless_a_lower_one_is_asked_for() {
    if std::env::var_os(ASKED).is_some() {
        println!("found {:?}.", cpu());
        return;
    }
    let widest = found("");
    for (name, set) in SETS {
        assert_eq!(found(name), set.min(widest), "{name}");
    }
    // What tests/run shows.
    let lacking: Vec<&str> = SETS.iter().filter(|s| s.1 > widest).map(|s| s.0).collect();
    match lacking[..] {
        [] => println!("\ninstruction sets: all are tested here"),
        _ => println!("\ninstruction sets: not here, so not tested: {}", lacking.join(", ")),
    }
}
