//! Which instruction set the kernel uses; asked once.

use std::sync::LazyLock;

/// Instruction sets, from the plainest to the widest. All give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cpu {
    /// Plain Rust; the definition of what the others do.
    Scalar,
    /// x86-64's baseline.
    Sse2,
    /// 256-bit integers and permutes.
    Avx2,
    /// 512-bit with BW, DQ, VL, VBMI, VBMI2, VPOPCNTDQ and GFNI.
    Avx512,
}

/// A set that this processor has: what makes it sound to call functions compiled for it.
#[derive(Clone, Copy, Debug)]
pub struct Detected(Cpu);

impl Detected {
    /// `asked`, or the widest set that this processor has.
    pub(super) fn at_most(asked: Cpu) -> Self {
        Self(asked.min(widest()))
    }

    /// The set.
    pub(super) fn cpu(self) -> Cpu {
        self.0
    }
}

/// The widest set that this processor has, or a lower one named in the environment variable
/// `MCUBES_CPU` (`scalar`, `sse2`, `avx2`, `avx512`), so that one machine tests them all.
pub fn cpu() -> Cpu {
    static CPU: LazyLock<Cpu> = LazyLock::new(|| {
        let best = widest();
        let asked = match std::env::var("MCUBES_CPU").as_deref() {
            Ok("scalar") => Cpu::Scalar,
            Ok("sse2") => Cpu::Sse2,
            Ok("avx2") => Cpu::Avx2,
            _ => Cpu::Avx512,
        };
        asked.min(best)
    });
    *CPU
}

#[cfg(target_arch = "x86_64")]
fn widest() -> Cpu {
    macro_rules! has {
        ($($feature:tt),*) => { $(std::arch::is_x86_feature_detected!($feature))&&* };
    }
    if has!(
        "avx512f",
        "avx512bw",
        "avx512dq",
        "avx512vl",
        "avx512vbmi",
        "avx512vbmi2",
        "avx512vpopcntdq",
        "gfni",
        "bmi1",
        "bmi2",
        "popcnt",
        "lzcnt",
        "avx2"
    ) {
        Cpu::Avx512
    } else if has!("avx2", "bmi1", "bmi2", "popcnt", "lzcnt") {
        Cpu::Avx2
    } else {
        Cpu::Sse2
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn widest() -> Cpu {
    Cpu::Scalar
}

#[cfg(test)]
mod tests {
    /// The words in quotes, divided by commas, that follow each `before` up to `after`.
    fn quoted<'a>(text: &'a str, before: &str, after: &str) -> Vec<&'a str> {
        let parts = text.split(before).skip(1).filter_map(|part| part.split(after).next());
        parts.flat_map(|part| part.split(['"', ',', '\n', ' '])).filter(|w| !w.is_empty()).collect()
    }

    /// A function for a set must not be called where the processor lacks a part of it.
    #[test]
    fn all_that_functions_are_compiled_for_is_asked_of_the_processor() {
        let own = include_str!("cpu.rs");
        let asked = [quoted(own, "    if has!(", ")"), quoted(own, "else if has!(", ")")];
        let files = [
            (include_str!("simd/avx512.rs"), 0),
            (include_str!("simd/vertices512.rs"), 0),
            (include_str!("simd/normals512.rs"), 0),
            (include_str!("simd/samples512.rs"), 0),
            (include_str!("simd/avx2.rs"), 1),
        ];
        for (text, set) in files {
            let used = quoted(text, "enable = ", ")]");
            assert!(used.contains(&"avx2"));
            for feature in used {
                assert!(asked[set].contains(&feature), "{feature}: {asked:?}");
            }
        }
    }
}
