//! Fields in field files against closed forms, and when they are written.
#![allow(non_snake_case)]

use crate::common::wrong_builtin;
use crate::functionals::{NEO, homogeneous, physics, stretched};
use crate::manufactured::*;
use crate::traction::channel;
use std::f64::consts::SQRT_2;
use std::fs;
use std::path::{Path, PathBuf};
use undula::case::{Case, OutputSpec};
use undula::functional::averages::{Averages, oscillatory_shear_index};
use undula::functional::nodal::NodalField;
use undula::math::Tensor;
use undula::output::{Collection, FieldSnapshot, Status, read_vtu};
use undula::run::{Flow, Observer, RunOptions, fields, run, snapshot};
use undula::simulation::{Row, Simulation};
use undula::space::PressureKind::Continuous;
use undula::space::Region;

const ALL: &str = r#"output.fields=["pressure", "stress", "von-mises", "principal-stress", "strain", "jacobian", "vorticity", "wall-shear-stress"]"#;

struct Quiet;

impl Observer for Quiet {
    fn after_step(&mut self, _: &Simulation, _: &Row) -> Flow {
        Flow::Continue
    }
}

/// The directory of a completed run.
fn written(name: &str, case: Case) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("output-fields-{name}"));
    let _ = fs::remove_dir_all(&directory);
    let options = RunOptions { directory, threads: 1, force: true, resume: false, commit: None };
    assert_eq!(run(case, &options, &mut Quiet).unwrap().status, Status::Completed);
    options.directory
}

/// Asserts that the array `name` has these values at the points that `right` gives some for.
fn compare(fields: &FieldSnapshot, name: &str, right: impl Fn([f64; 2]) -> Option<Vec<f64>>) {
    let field = fields.at_points(name).unwrap_or_else(|| panic!("no {name}"));
    let mut compared = 0;
    for (x, found) in fields.points.iter().zip(field.values.chunks_exact(field.components)) {
        let Some(right) = right([x[0], x[1]]) else { continue };
        compared += 1;
        for (found, right) in found.iter().zip(&right) {
            assert!((found - right).abs() < 1e-9, "{name} at {x:?}: {found} for {right}");
        }
    }
    assert!(compared > 0, "{name}");
}

/// v = 4 y (1 − y), p = 0.8 (4 − x), ρν = 0.1, through a file.
#[test]
fn derived_fields_of_poiseuille_flow_are_exact() {
    let elements: [&[&str]; 3] = [
        &[],
        &["space.velocity=P2", "space.pressure=P1"],
        &["space.velocity=P2-bubble", "space.pressure=P1dc", "output.cells=curved"],
    ];
    for (n, elements) in elements.into_iter().enumerate() {
        let case = channel("1", &[elements, &[ALL]].concat());
        assert_eq!(Case::from_toml(&case.to_toml(), "case.toml", &[]).unwrap().output, case.output);
        let directory = written(&format!("poiseuille-{n}"), case);
        let entry = Collection::read(directory.join("fields.pvd")).unwrap().entries()[0].1.clone();
        let (fields, _) = read_vtu(directory.join(entry)).unwrap();
        let names: Vec<&str> = fields.point_data.iter().map(|field| field.name.as_str()).collect();
        // Nothing moves and nothing is solid.
        assert_eq!(
            names,
            [
                "pressure",
                "fluid-stress",
                "fluid-von-mises",
                "fluid-principal-stress",
                "fluid-vorticity",
                "wall-shear-stress"
            ]
        );
        let (p, tau) = (|x: f64| 0.8 * (4.0 - x), |y: f64| 0.4 * (1.0 - 2.0 * y));
        compare(&fields, "fluid-stress", |[x, y]| {
            Some(vec![-p(x), tau(y), 0.0, tau(y), -p(x), 0.0, 0.0, 0.0, -p(x)])
        });
        compare(&fields, "fluid-von-mises", |[_, y]| Some(vec![3f64.sqrt() * tau(y).abs()]));
        compare(&fields, "fluid-principal-stress", |[x, y]| {
            Some(vec![tau(y).abs() - p(x), -tau(y).abs() - p(x), -p(x)])
        });
        compare(&fields, "fluid-vorticity", |[_, y]| Some(vec![-10.0 * tau(y)]));
        // Both walls are drawn along the flow; inlet, outlet and interior have none.
        compare(&fields, "wall-shear-stress", |[_, y]| {
            Some(vec![if y == 0.0 || y == 1.0 { 0.4 } else { 0.0 }, 0.0])
        });
    }
}

fn spec(fields: &[NodalField]) -> OutputSpec {
    OutputSpec { fields: fields.to_vec(), deformed: false, ..channel("1", &[]).output }
}

#[test]
fn derived_fields_of_a_homogeneous_strain_are_those_of_each_body() {
    let (a, b, angle) = (1.3, 0.9, 0.5f64);
    let (c, s) = (angle.cos(), angle.sin());
    let F = [[c * a, -s * b], [s * a, c * b]];
    let A = [[0.7, -0.2], [0.4, 0.5]];
    let L = Tensor(A) * Tensor(F).cofactor().t() * (1.0 / (a * b));
    let L = L.0;
    let physics = physics(NEO);
    use NodalField::*;
    let output = spec(&[Stress, VonMises, PrincipalStress, Strain, Jacobian, Vorticity]);
    for pair in [quadrilaterals(2, Continuous(1)), triangles(2, Continuous(1)), BUBBLE] {
        let (space, state) = homogeneous(pair, &physics, F, A);
        let all = fields(&space, &physics, &state, &output, &[]);
        let mut is_of = [0, 1].map(|_| vec![false; space.nodes.n_lagrange]);
        for cell in 0..space.mesh.n_cells() {
            let nodes =
                space.nodes.cell(cell).iter().filter(|&&node| (node as usize) < space.nodes.n_lagrange);
            nodes.for_each(|&node| {
                is_of[usize::from(space.regions[cell] == Region::Solid)][node as usize] = true
            });
        }
        let check = |name: &str, body: usize, right: &[f64]| {
            let field = all.at_points(name).unwrap_or_else(|| panic!("no {name}"));
            for (found, here) in field.values.chunks_exact(field.components).zip(&is_of[body]) {
                for (found, right) in found.iter().zip(right) {
                    assert!(
                        if *here { (found - right).abs() < 1e-11 } else { found.is_nan() },
                        "{name}: {found} for {right}"
                    );
                }
            }
        };
        let [x, y, z] = stretched(NEO, a, b);
        let (xx, yy, xy) = (c * c * x + s * s * y, s * s * x + c * c * y, c * s * (x - y));
        check("solid-stress", 1, &[xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, z]);
        let equivalent = ((x - y).powi(2) + (y - z).powi(2) + (z - x).powi(2)).sqrt() / SQRT_2;
        check("solid-von-mises", 1, &[equivalent]);
        check("solid-principal-stress", 1, &[x.max(y), x.min(y), z]);
        let strain = [0.5 * (a * a - 1.0), 0.5 * (b * b - 1.0)];
        check("solid-strain", 1, &[strain[0], 0.0, 0.0, 0.0, strain[1], 0.0, 0.0, 0.0, 0.0]);
        for (body, name) in ["fluid-jacobian", "solid-jacobian"].into_iter().enumerate() {
            check(name, body, &[a * b]);
        }
        check("fluid-vorticity", 0, &[L[1][0] - L[0][1]]);
        let mu = AUXETIC.rho * AUXETIC.nu;
        if !pair.bubble {
            let shear = mu * (L[0][1] + L[1][0]);
            let normal = [2.0 * mu * L[0][0] - 7.0, 2.0 * mu * L[1][1] - 7.0];
            check("fluid-stress", 0, &[normal[0], shear, 0.0, shear, normal[1], 0.0, 0.0, 0.0, -7.0]);
        }
        assert!(all.at_points("velocity").is_none() && all.at_points("pressure").is_none());
    }
}

#[test]
fn fields_by_default_are_velocity_displacement_and_pressure() {
    let physics = physics(NEO);
    let (space, state) =
        homogeneous(quadrilaterals(2, Continuous(1)), &physics, [[1.1, 0.0], [0.0, 1.0]], [[0.5; 2]; 2]);
    let output = channel("1", &[]).output;
    assert_eq!(fields(&space, &physics, &state, &output, &[]), snapshot(&space, &state, true));
    let names = |list: &[NodalField]| -> Vec<String> {
        fields(&space, &physics, &state, &spec(list), &[])
            .point_data
            .into_iter()
            .map(|field| field.name)
            .collect()
    };
    assert_eq!(names(&[NodalField::Pressure]), ["pressure"]);
    assert_eq!(
        names(&[NodalField::Displacement, NodalField::Jacobian]),
        ["deformation", "fluid-jacobian", "solid-jacobian"]
    );
}

/// Steps of 0.1 s; halfway between two steps it is the earlier one. The start is written, too.
#[test]
fn fields_are_written_at_the_steps_nearest_to_given_times() {
    let times = |name: &str, more: &[&str]| -> Vec<f64> {
        let all = [&["time.step=0.1", "time.end=1", "fluid.body-force=[\"4*y*(1-y)\",0]"], more].concat();
        let directory = written(name, channel("t", &all));
        let collection = Collection::read(directory.join("fields.pvd")).unwrap();
        collection.entries().iter().map(|(time, _)| *time).collect()
    };
    assert_eq!(times("times", &["output.fields-times=[0.12, 0.26, 0.31, 0.65]"]), [0.0, 0.1, 0.3, 0.6, 1.0]);
    let both = ["output.fields-times=[0.77]", "output.fields-every=4"];
    assert_eq!(times("both", &both), [0.0, 0.4, 0.8, 1.0]);
    // Steps are not changed by it.
    assert_eq!(times("none", &[]), [1.0]);
}

/// v, p and the wall shear stress grow like t: means over [0.1, 0.4] s are those of the steps there.
#[test]
fn means_over_a_window_are_those_of_the_steps_in_it() {
    let more = [
        "time.scheme=crank-nicolson",
        "time.step=0.1",
        "time.end=0.6",
        "fluid.body-force=[\"4*y*(1-y)\",0]",
        "output.window=[0.1, 0.4]",
    ];
    let directory = written("window", channel("t", &more));
    let (means, time) = read_vtu(directory.join("mean.vtu")).unwrap();
    assert_eq!(time, 0.25);
    let profile = |y: f64| 4.0 * y * (1.0 - y);
    compare(&means, "mean-velocity", |[_, y]| Some(vec![0.25 * profile(y), 0.0]));
    // 0.1, 0.2, 0.3, 0.4 with the weights 1, 2, 2, 1.
    let rms = ((2.0 * 0.15f64.powi(2) + 4.0 * 0.05f64.powi(2)) / 6.0).sqrt();
    compare(&means, "rms-velocity", |[_, y]| Some(vec![rms * profile(y), 0.0]));
    // The pressures of the steps that end at 0.2, 0.3, 0.4 belong to their middles.
    compare(&means, "mean-pressure", |[x, _]| Some(vec![0.25 * 0.8 * (4.0 - x)]));
    let rms = (2.0 * 0.1f64.powi(2) / 3.0).sqrt();
    compare(&means, "rms-pressure", |[x, _]| Some(vec![rms * 0.8 * (4.0 - x)]));
    let wall = |y: f64| if y == 0.0 || y == 1.0 { 0.25 * 0.4 } else { 0.0 };
    compare(&means, "mean-wall-shear-stress", |[_, y]| Some(vec![wall(y), 0.0]));
    compare(&means, "mean-wall-shear-magnitude", |[_, y]| Some(vec![wall(y)]));
    compare(&means, "oscillatory-shear-index", |_| Some(vec![0.0]));
}

#[test]
fn averages_and_the_shear_index_have_their_closed_forms() {
    let mut averages = Averages::new(2);
    // Large values with small deviations.
    for (weight, x) in [(0.5, 1e8 + 1.0), (2.0, 1e8 - 1.0), (1.5, 1e8 + 3.0)] {
        averages.add(&[x, 7.0], weight);
    }
    let mean = (0.5 - 2.0 + 4.5) / 4.0;
    assert!((averages.mean[0] - 1e8 - mean).abs() < 1e-7 && averages.mean[1] == 7.0);
    let variance =
        (0.5 * (1.0 - mean).powi(2) + 2.0 * (1.0 + mean).powi(2) + 1.5 * (3.0 - mean).powi(2)) / 4.0;
    assert!((averages.rms()[0] - variance.sqrt()).abs() < 1e-7, "{:?}", averages.rms());
    assert_eq!(averages.rms()[1], 0.0);
    // 1 and −⅓ of the time alike; there and back; one way; nothing.
    let third = 1.0 / 3.0;
    assert!((oscillatory_shear_index(&[0.5 * (1.0 - third)], 0.5 * (1.0 + third)) - 0.25).abs() < 1e-15);
    assert_eq!(oscillatory_shear_index(&[0.0, 0.0], 2.0), 0.5);
    assert_eq!(oscillatory_shear_index(&[3.0, 4.0], 5.0), 0.0);
    assert_eq!(oscillatory_shear_index(&[0.0, 0.0], 0.0), 0.0);
}

#[test]
fn mistakes_in_what_is_written_are_told() {
    for (set, expected) in [
        ("output.fields=[\"speed\"]", "`speed`: expected one of `velocity`, `displacement`, `pressure`"),
        ("output.fields=[1]", "expected an array of names, each one of `velocity`"),
        ("output.fields-times=[\"a\"]", "expected an array of numbers, such as [0.1, 0.25]"),
        ("output.window=[2, 1]", "expected two times, the first and the last [s]"),
        ("output.window=3", "expected two numbers"),
    ] {
        let told = wrong_builtin("fsi3", &[set]);
        assert!(told.contains(expected), "{set}: {told}");
    }
    let case =
        crate::common::builtin("fsi3", &["time.end=1", "output.fields-times=[3]", "output.window=[0.5, 2]"]);
    let notes = case.notes().join("; ");
    assert!(notes.contains("does not come to 3 s") && notes.contains("does not fill it"), "{notes}");
}
