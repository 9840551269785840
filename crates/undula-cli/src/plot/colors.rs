//! Colours that print well and that colour-blind readers can tell apart.

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// Lines, after Okabe and Ito.
pub const LINES: [Rgb; 6] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [230, 159, 0]];

/// Text and axes.
pub const INK: Rgb = [51, 51, 51];
/// Less important text, and lines in the background.
pub const GREY: Rgb = [128, 128, 128];
/// Grid lines.
pub const GRID: Rgb = [230, 230, 230];
/// The solid where it has no value.
pub const SOLID: Rgb = [205, 205, 205];

/// Perceptually uniform, dark blue to yellow; 17 equidistant samples of viridis (CC0).
pub const VIRIDIS: [Rgb; 17] = [
    [68, 1, 84],
    [72, 24, 106],
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];

/// Perceptually uniform, dark violet to yellow; 17 equidistant samples of plasma (CC0).
pub const PLASMA: [Rgb; 17] = [
    [13, 8, 135],
    [49, 5, 151],
    [76, 2, 161],
    [102, 0, 167],
    [126, 3, 168],
    [149, 17, 161],
    [170, 35, 149],
    [188, 53, 135],
    [204, 71, 120],
    [218, 90, 106],
    [230, 108, 92],
    [240, 128, 78],
    [248, 149, 64],
    [253, 172, 51],
    [253, 197, 39],
    [248, 223, 37],
    [240, 249, 33],
];

/// The colour at `s` in [0, 1].
pub fn at(map: &[Rgb; 17], s: f64) -> Rgb {
    let s = 16.0 * s.clamp(0.0, 1.0);
    let n = (s as usize).min(15);
    std::array::from_fn(|c| {
        let (a, b) = (f64::from(map[n][c]), f64::from(map[n + 1][c]));
        (a + (s - n as f64) * (b - a)).round() as u8
    })
}
