//! Pictures of a made-up run: a channel with a cylinder and a bent beam, and signals as of a flapping beam.
//! The pictures stay in the scratch directory of the build, to be looked at.

use crate::sources::plot::plot_directory;
use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};
use undula::output::{
    Collection, Field, FieldSnapshot, FunctionalSummary, HistoryWriter, Precision, RunDirectory, Status,
    Summary, write_vtu,
};

/// Undeformed positions, cells and kinds of a channel made of mapped blocks.
#[derive(Default)]
struct Channel {
    reference: Vec<[f64; 2]>,
    cells: Vec<u32>,
    solid: Vec<f64>,
}

impl Channel {
    /// `n` biquadratic cells of the image of the unit square.
    fn block(&mut self, n: [usize; 2], solid: bool, map: impl Fn(f64, f64) -> [f64; 2]) {
        let first = self.reference.len() as u32;
        let row = 2 * n[0] + 1;
        for (i, j) in (0..=2 * n[1]).flat_map(|j| (0..row).map(move |i| (i, j))) {
            self.reference.push(map(i as f64 / (2 * n[0]) as f64, j as f64 / (2 * n[1]) as f64));
        }
        for (i, j) in (0..n[1]).flat_map(|j| (0..n[0]).map(move |i| (2 * i, 2 * j))) {
            self.cells.extend((0..9).map(|k| first + (i + k % 3 + row * (j + k / 3)) as u32));
            self.solid.push(f64::from(u8::from(solid)));
        }
    }

    fn new() -> Self {
        let mut mesh = Channel::default();
        // Round the cylinder: angles on it, and the opposite sides of a square.
        let a = 0.2_f64.asin();
        let sectors = [
            (a, FRAC_PI_4, [0.35, 0.21], [0.35, 0.35], 6),
            (FRAC_PI_4, 3.0 * FRAC_PI_4, [0.35, 0.35], [0.05, 0.35], 12),
            (3.0 * FRAC_PI_4, 5.0 * FRAC_PI_4, [0.05, 0.35], [0.05, 0.05], 12),
            (5.0 * FRAC_PI_4, 7.0 * FRAC_PI_4, [0.05, 0.05], [0.35, 0.05], 12),
            (-FRAC_PI_4, -a, [0.35, 0.05], [0.35, 0.19], 6),
            (-a, a, [0.35, 0.19], [0.35, 0.21], 1),
        ];
        for (from, to, p, q, n) in sectors {
            mesh.block([6, n], n == 1, |s, t| {
                let angle = from + t * (to - from);
                let inner = [0.2 + 0.05 * angle.cos(), 0.2 + 0.05 * angle.sin()];
                std::array::from_fn(|d| (1.0 - s) * inner[d] + s * (p[d] + t * (q[d] - p[d])))
            });
        }
        let columns = [(0.0, 0.05, 3), (0.05, 0.35, 12), (0.35, 0.6, 12), (0.6, 1.2, 16), (1.2, 2.5, 22)];
        let rows = [(0.0, 0.05, 3), (0.05, 0.19, 6), (0.19, 0.21, 1), (0.21, 0.35, 6), (0.35, 0.41, 3)];
        for (c, (x0, x1, n)) in columns.into_iter().enumerate() {
            for (r, (y0, y1, m)) in rows.into_iter().enumerate().filter(|(r, _)| c != 1 || r % 4 == 0) {
                if c == 0 && r % 4 != 0 {
                    continue;
                }
                mesh.block([n, m], c == 2 && r == 2, |s, t| [x0 + s * (x1 - x0), y0 + t * (y1 - y0)]);
            }
        }
        mesh.block([3, 12], false, |s, t| [0.05 * s, 0.05 + 0.3 * t]);
        mesh
    }

    /// A bent beam in a street of vortices.
    fn snapshot(&self, tip: f64) -> FieldSnapshot {
        let deflection = |[x, y]: [f64; 2]| {
            let along = ((x - 0.25) / 0.35).max(0.0);
            let bending = if along < 1.0 {
                along * along
            } else {
                (2.0 * along - 1.0) * (-(along - 1.0).powi(2) * 4.0).exp()
            };
            let across = if y > 0.21 {
                (0.41 - y) / 0.2
            } else if y < 0.19 {
                y / 0.19
            } else {
                1.0
            };
            [-0.2 * tip * bending * across * across, tip * bending * across * across]
        };
        let vortices: Vec<(f64, f64, f64)> = (0..8)
            .map(|n| {
                (
                    0.72 + 0.24 * f64::from(n),
                    if n % 2 == 0 { 0.26 } else { 0.14 },
                    if n % 2 == 0 { -1.0 } else { 1.0 },
                )
            })
            .collect();
        let flow = |[x, y]: [f64; 2]| {
            let wall = 4.0 * y * (0.41 - y) / 0.1681;
            let near = 1.0 - (-(((x - 0.2).hypot(y - 0.2) - 0.05).max(0.0) / 0.03)).exp();
            let wake = 1.0 - 0.7 * (-((y - 0.2) / 0.05).powi(2)).exp() / (1.0 + (-(x - 0.25) * 40.0).exp());
            let (mut v, mut p) = (
                [3.0 * wall * near * wake, 0.0],
                3000.0 * (2.5 - x) / 2.5 + 2500.0 * (1.0 - near) * (0.2 - x) / 0.06,
            );
            for (cx, cy, sign) in &vortices {
                let (dx, dy) = (x - cx, y - cy);
                let bell = (-(dx * dx + dy * dy) / 0.004).exp();
                v[0] -= sign * 25.0 * dy * bell * wall;
                v[1] += sign * 25.0 * dx * bell * wall;
                p -= 1300.0 * bell;
            }
            (v, p)
        };
        let u: Vec<[f64; 2]> = self.reference.iter().map(|&x| deflection(x)).collect();
        let points: Vec<[f64; 3]> =
            self.reference.iter().zip(&u).map(|(x, u)| [x[0] + u[0], x[1] + u[1], 0.0]).collect();
        let in_beam = |&[x, y]: &[f64; 2]| x > 0.245 && x < 0.601 && (y - 0.2).abs() < 0.0101;
        let values: Vec<([f64; 2], f64)> = self
            .reference
            .iter()
            .zip(&u)
            .map(|(x, u)| if in_beam(x) { ([u[0] * 20.0, u[1] * 20.0], flow(*x).1) } else { flow(*x) })
            .collect();
        FieldSnapshot {
            kind: Default::default(),
            degree: 2,
            points,
            cells: self.cells.clone(),
            point_data: vec![
                Field::new("velocity", 2, values.iter().flat_map(|v| v.0).collect()),
                Field::new("pressure", 1, values.iter().map(|v| v.1).collect()),
                Field::new("deformation", 2, u.into_iter().flatten().collect()),
            ],
            cell_data: vec![Field::new("solid", 1, self.solid.clone())],
        }
    }
}

/// A directory in which nothing is.
pub fn scratch(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    path
}

pub fn run(path: &Path, case: &str, units: &[(&str, &str)]) -> RunDirectory {
    let run = RunDirectory::create(path, true).unwrap();
    run.write_case("[time]\n").unwrap();
    let functional = |unit: &str| FunctionalSummary { unit: unit.into(), ..Default::default() };
    let functionals = units.iter().map(|(name, unit)| (name.to_string(), functional(unit))).collect();
    let summary = Summary { status: Status::Completed, case: case.into(), functionals, ..Default::default() };
    summary.write(run.summary()).unwrap();
    run
}

pub fn fields(run: &RunDirectory, step: u64, time: f64, snapshot: &FieldSnapshot) {
    let mut collection = Collection::create(run.collection()).unwrap();
    let name = run.field_name(step);
    write_vtu(run.path().join(&name), snapshot, time, Precision::Auto).unwrap();
    collection.add(time, name).unwrap();
}

/// Width, height and pixels of a picture, three bytes each.
pub fn decoded(path: &Path) -> (usize, usize, Vec<u8>) {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width as usize, info.height as usize, pixels)
}

pub fn names(paths: &[PathBuf]) -> Vec<String> {
    paths.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect()
}

#[test]
#[ignore = "long"]
fn a_flapping_beam() {
    let units = [("drag", "N/m"), ("lift", "N/m"), ("ux_A", "m"), ("uy_A", "m")];
    let run = run(&scratch("plot-beam"), "fsi3", &units);
    let columns = "step,time,force_time,drag,lift,ux_A,uy_A,min_J,newton_steps,jacobians";
    let columns: Vec<String> = columns.split(',').map(String::from).collect();
    let mut history = HistoryWriter::create(run.history(), &columns).unwrap();
    for n in 1..=2400 {
        let t = 0.005 * f64::from(n);
        let ramp = if t < 2.0 { 0.5 - 0.5 * (PI / 2.0 * t).cos() } else { 1.0 };
        let size = ramp / (1.0 + (-3.0 * (t - 4.0)).exp());
        let at = TAU * 5.46 * t;
        let drag =
            439.0 * ramp + 18.3 * size + size * 22.66 * (2.0 * at).cos() + if n == 1 { 4000.0 } else { 0.0 };
        let lift = 2.5 * ramp + size * (120.0 * at.sin() + 35.0 * (3.0 * at + 1.0).sin());
        let ux = -2.88e-3 * size * (1.0 - 0.95 * (2.0 * at + 0.3).cos());
        let uy = 1.47e-3 * ramp + 34.99e-3 * size * (at + 0.2).sin();
        let min_j = 0.98 - 0.2 * size * (1.0 + (2.0 * at).cos());
        history.append(&[f64::from(n), t, t - 0.0025, drag, lift, ux, uy, min_j, 3.0, 1.0]).unwrap();
    }
    fields(&run, 2400, 12.0, &Channel::new().snapshot(0.034));
    let written = plot_directory(run.path(), None).unwrap();
    let expected = ["history.svg", "history.png", "path_A.svg", "path_A.png", "speed.png", "pressure.png"];
    assert_eq!(names(&written), expected);
    let svg = fs::read_to_string(&written[0]).unwrap();
    for text in ["fsi3", "drag [N/m]", "uy_A [mm]", "1.47 ± 34.99 mm, 5.4600 Hz", "10.9200 Hz"] {
        assert!(svg.contains(text), "{text}");
    }
    // The field is in the picture: thousands of pixels with the colours of viridis' upper half.
    let (width, height, pixels) = decoded(&written[4]);
    let bright = pixels.as_chunks::<3>().0.iter().filter(|p| p[1] > 150 && p[2] < 130).count();
    assert!(bright * 50 > width * height, "{bright} of {width} x {height}");
}

#[test]
fn a_stationary_run_has_pictures_only() {
    let run = run(&scratch("plot-stationary"), "box", &[("drag", "N/m")]);
    let columns: Vec<String> = ["step", "time", "drag"].map(String::from).to_vec();
    HistoryWriter::create(run.history(), &columns).unwrap().append(&[0.0, 0.0, 14.29]).unwrap();
    let mut mesh = Channel::default();
    mesh.block([6, 8], false, |s, t| [s + 0.1 * (PI * t).sin(), 1.3 * t]);
    let mut snapshot = mesh.snapshot(0.0);
    let pressure: Vec<f64> = mesh.reference.iter().map(|x| 1e-5 * (x[0] * x[0] - x[1])).collect();
    snapshot.point_data = vec![Field::new("pressure", 1, pressure)];
    fields(&run, 0, 0.0, &snapshot);
    assert_eq!(names(&plot_directory(run.path(), None).unwrap()), ["pressure.png"]);
}

#[test]
fn a_solid_alone_shows_its_deformation() {
    let run = run(&scratch("plot-solid"), "csm3", &[("uy_A", "m")]);
    let columns: Vec<String> = ["step", "time", "uy_A"].map(String::from).to_vec();
    let mut history = HistoryWriter::create(run.history(), &columns).unwrap();
    for n in 1..=500 {
        let t = 0.02 * f64::from(n);
        history.append(&[f64::from(n), t, -63.6e-3 * (1.0 - (TAU * 1.0995 * t).cos())]).unwrap();
    }
    let mut mesh = Channel::default();
    mesh.block([30, 2], true, |s, t| [0.25 + 0.35 * s, 0.19 + 0.02 * t]);
    fields(&run, 500, 10.0, &mesh.snapshot(-0.1));
    let written = names(&plot_directory(run.path(), None).unwrap());
    assert_eq!(written, ["history.svg", "history.png", "deformation.png"]);
}

#[test]
fn what_is_no_run_is_named() {
    let error = plot_directory(&scratch("plot-nothing"), None).unwrap_err().to_string();
    assert!(error.contains("plot-nothing: no run here (case.toml is missing)"), "{error}");
}
