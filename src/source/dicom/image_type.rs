//! Which of several image types at the same positions comes first, and so is meshed where none is
//! asked for.

/// The better one is less: what was measured before what was made of it, magnitudes before phases
/// and parts of complex numbers, water before fat. Scanners name these by words or by letters in
/// the third value and those after it (PS3.3, C.8.3.1.1.1 and C.8.13.3.1.1).
pub(super) fn rank(image_type: &str) -> (bool, u8, u8) {
    let mut values = image_type.split('\\').map(str::trim);
    let derived = values.next() == Some("DERIVED");
    let (mut complex, mut water) = (1, 1);
    for value in values.skip(1) {
        match value {
            "M" | "MAGNITUDE" => complex = 0,
            "P" | "PHASE" | "PHASE MAP" | "R" | "REAL" | "I" | "IMAGINARY" => complex = 2,
            "W" | "WATER" => water = 0,
            "F" | "FAT" => water = 2,
            _ => {}
        }
    }
    (derived, complex, water)
}
