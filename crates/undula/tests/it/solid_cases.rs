//! Every law of the solid through the whole program, from the case to the end of the beam.

use crate::common::{builtin, wrong_builtin};
use undula::case::{Case, SolidLaw};
use undula::math::Tensor;
use undula::sampling::for_each_point;
use undula::simulation::{Row, Simulation};
use undula::space::Region;

fn run(case: Case) -> (Simulation, Row) {
    let mut simulation = Simulation::new(case, 1).unwrap();
    let mut row = simulation.step().unwrap();
    while !simulation.finished() {
        row = simulation.step().unwrap();
    }
    (simulation, row)
}

/// u_x and u_y of the end of the beam in csm1 on the coarsest mesh \[mm\].
fn csm1(overrides: &[&str]) -> [f64; 2] {
    let common = ["mesh.refine=0", "newton.tolerance=1e-10"];
    let (_, row) = run(builtin("csm1", &[&common[..], overrides].concat()));
    println!("{overrides:?}: {:.5?} mm, min J {:.4}", [row.values[0] * 1e3, row.values[1] * 1e3], row.min_j);
    [row.values[0] * 1e3, row.values[1] * 1e3]
}

/// The beam of csm1 bends far but its strains are small: the compressible laws agree with each other, the
/// linear one only roughly, as it knows no rotation. With ν = ½ the beam in plane strain is stiffer by
/// (E/(1 − ν²)) = 2 MPa to 1.667 MPa.
#[test]
fn csm1_with_every_law() {
    let venant = csm1(&[]);
    for overrides in [
        &["solid.law=neo-hookean"][..],
        &["solid.law=mooney-rivlin"],
        &["solid.law=mooney-rivlin", "solid.c2=1e5"],
    ] {
        let other = csm1(overrides);
        assert!((other[1] / venant[1] - 1.0).abs() < 0.01, "{overrides:?}: {other:?} and {venant:?}");
    }
    let linear = csm1(&["solid.law=linear"]);
    assert!((linear[1] / venant[1] - 1.0).abs() < 0.1 && linear[0].abs() < 0.1 * venant[0].abs());
    let kept = csm1(&["solid.law=incompressible-neo-hookean"]);
    assert!((kept[1] / venant[1] * 2.0 / (5.0 / 3.0) - 1.0).abs() < 0.03, "{kept:?} and {venant:?}");
    // In plane strain both are the same where J = 1, which the mesh keeps the better the finer it is.
    let gap = |refine: &str| {
        let neo = csm1(&["solid.law=incompressible-neo-hookean", refine]);
        let mooney = csm1(&["solid.law=incompressible-mooney-rivlin", "solid.c2=1e5", refine]);
        (mooney[1] / neo[1] - 1.0).abs()
    };
    let gaps = ["mesh.refine=0", "mesh.refine=1"].map(gap);
    println!("Mooney-Rivlin and neo-Hookean: {gaps:?}");
    assert!(gaps[0] < 2e-3 && gaps[1] < 0.5 * gaps[0], "{gaps:?}");
    let continuous = csm1(&["solid.law=incompressible-neo-hookean", "space.pressure=Q1"]);
    assert!((continuous[1] / kept[1] - 1.0).abs() < 0.01, "{continuous:?} and {kept:?}");
}

/// The limits of a large bulk modulus: the mixed form tends to J = 1 like 1/κ, and the compressible law without
/// a pressure comes to the same place.
#[test]
fn a_large_bulk_modulus_is_incompressible() {
    let kept = csm1(&["solid.law=incompressible-neo-hookean"])[1];
    let nearly = |bulk: &str| csm1(&["solid.law=incompressible-neo-hookean", bulk])[1];
    let gaps = [nearly("solid.bulk=5e7"), nearly("solid.bulk=5e8")].map(|u| (u - kept).abs());
    println!("gaps {gaps:?}");
    assert!((gaps[0] / gaps[1] - 10.0).abs() < 0.5, "{gaps:?}");
    // λ = κ − ⅔ μ = 4.9667e7 Pa.
    let gap = |refine: &str| {
        let compressible = csm1(&["solid.law=neo-hookean", "solid.lambda=49666666.666666664", refine])[1];
        let mixed = csm1(&["solid.law=incompressible-neo-hookean", "solid.bulk=5e7", refine])[1];
        (compressible / mixed - 1.0).abs()
    };
    let gaps = ["mesh.refine=0", "mesh.refine=1"].map(gap);
    println!("{gaps:?}");
    assert!(gaps[1] < 0.5 * gaps[0] && gaps[1] < 0.01, "{gaps:?}");
}

/// Mean of J over each cell of the solid, largest |J̄ − 1|; kinetic, stored and potential energy \[J/m\].
fn state_of(simulation: &Simulation) -> (f64, [f64; 3]) {
    let stepper = &simulation.stepper;
    let (space, solid) = (&stepper.assembler.space, stepper.assembler.physics.solid.unwrap());
    let (mut cells, mut energy) = (vec![[0.0; 2]; space.mesh.n_cells()], [0.0; 3]);
    for_each_point(space, &stepper.new, 3, |point| {
        if point.region == Region::Solid {
            let f = &point.fields;
            cells[point.cell][0] += point.weight * (Tensor::identity() + f.grad_u).det();
            cells[point.cell][1] += point.weight;
            energy[0] += point.weight * 0.5 * solid.rho * f.v.dot(f.v);
            energy[1] += point.weight * solid.material.energy(&f.grad_u);
            energy[2] += point.weight * solid.rho * 2.0 * f.u.0[1];
        }
    });
    let gap = cells.iter().filter(|c| c[1] > 0.0).map(|c| (c[0] / c[1] - 1.0).abs()).fold(0.0, f64::max);
    (gap, energy)
}

/// The swinging beam of csm3 over two thirds of a period, Crank-Nicolson: the largest |J − 1| as a mean over a cell,
/// and the largest error of the energy relative to the kinetic one.
fn swing(overrides: &[&str]) -> [f64; 2] {
    let common = ["solid.law=incompressible-neo-hookean", "mesh.refine=0", "time.end=0.6"];
    let mut simulation = Simulation::new(builtin("csm3", &[&common[..], overrides].concat()), 1).unwrap();
    let (mut worst, mut largest, mut volume) = (0.0f64, 0.0f64, 0.0f64);
    while !simulation.finished() {
        simulation.step().unwrap();
        let (gap, energy) = state_of(&simulation);
        worst = worst.max(energy.iter().sum::<f64>().abs());
        largest = largest.max(energy[0]);
        volume = volume.max(gap);
    }
    println!("{overrides:?}: |J - 1| {volume:.2e}, energy {:.2e}", worst / largest);
    [volume, worst / largest]
}

/// Without any damping energy is kept to second order in k and, gravity growing smoothly, the volume of every
/// cell to third order with a discontinuous pressure.
#[test]
fn a_swinging_incompressible_beam_keeps_volume_and_energy() {
    let steps = ["time.step=0.01", "time.step=0.005"];
    let [coarse, fine] = steps.map(|k| swing(&[k])[1]);
    assert!((coarse / fine).log2() > 1.8 && fine < 1e-5, "{coarse:e} {fine:e}");
    let slow = "solid.body-force=[0, \"-2*ramp(t,0.4)\"]";
    let [coarse, fine] = steps.map(|k| swing(&[k, slow])[0]);
    assert!((coarse / fine).log2() > 2.7 && fine < 1e-5, "{coarse:e} {fine:e}");
    let [volume, energy] = swing(&[steps[0], "space.pressure=Q1"]);
    assert!(volume < 0.01 && energy < 1e-4, "{volume:e} {energy:e}");
}

/// Flow around an incompressible beam: the condensed system and the whole Jacobian arrive at the same solution,
/// by dual numbers and by hand, with either pressure.
#[test]
fn every_linearization_has_the_same_solution() {
    let common = [
        "solid.law=incompressible-neo-hookean",
        "mesh.refine=0",
        "time.end=0.06",
        "time.step=0.01",
        "newton.tolerance=1e-10",
    ];
    for pressure in ["space.pressure=P1dc", "space.pressure=Q1"] {
        let with = |more: &[&'static str]| run(builtin("fsi3", &[&common[..], &[pressure], more].concat())).0;
        let reference = with(&["newton.linearization=newton", "newton.jacobian=analytic"]);
        let other = with(&["newton.linearization=condensed"]);
        assert_eq!(other.stepper.linear.detour, 0, "no step needed the whole Jacobian");
        let (a, b) = (&reference.stepper.new, &other.stepper.new);
        for (field, a, b) in [("v", &a.v, &b.v), ("u", &a.u, &b.u), ("p", &a.p, &b.p)] {
            let size = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let gap = a.iter().zip(b).fold(0.0f64, |gap, (a, b)| gap.max((a - b).abs())) / size;
            println!("{pressure} {field}: {gap:.1e}");
            assert!(gap < 1e-6, "{pressure} {field}: {gap:e}");
        }
    }
}

#[test]
fn constants_of_the_laws_are_checked() {
    let solid = |overrides: &[&str]| builtin("csm1", overrides).solids.remove(0);
    let mooney = solid(&["solid.law=mooney-rivlin", "solid.c2=1e5"]);
    assert_eq!((mooney.law, mooney.mu, mooney.c2, mooney.lambda), (SolidLaw::MooneyRivlin, 0.5e6, 1e5, 2e6));
    let kept = solid(&["solid.law=incompressible-neo-hookean"]);
    assert!(kept.lambda.is_infinite() && kept.bulk.is_none());
    for overrides in [
        &["solid.law=incompressible-mooney-rivlin", "solid.c2=1e5", "solid.bulk=1e9"][..],
        &["solid.law=mooney-rivlin", "solid.c2=1e5"],
        &["solid.law=linear"],
    ] {
        let case = builtin("csm1", overrides);
        let again = Case::from_toml(&case.to_toml(), "case.toml", &[]).unwrap();
        assert_eq!(case, again, "what is written is read");
    }
    for (overrides, expected) in [
        (&["solid.law=neo-hookean", "solid.c2=1"][..], "solid.c2=1: only for the laws `mooney-rivlin`"),
        (&["solid.bulk=1e9"], "solid.bulk=1e9: only for incompressible laws"),
        (&["solid.law=incompressible-neo-hookean", "solid.bulk=1"], "expected a number above 2/3 mu"),
        (&["solid.law=mooney-rivlin", "solid.c2=3e5"], "expected a number below mu/2 = 250000 Pa"),
        (
            &["solid.law=mooney-rivlin", "solid.c2=2e5", "solid.lambda=4e5"],
            "expected a number below lambda/4 = 100000 Pa",
        ),
        (
            &["solid.law=mooney-rivlin", "solid.c1=1", "solid.c2=1"],
            "give either `c1` and `c2` or `mu` and `c2`",
        ),
        (&["solid.law=incompressible-neo-hookean", "space.pressure=Q2"], "Q2 with Q2 is not stable"),
        (&["solid.law=hooke"], "expected one of `st-venant-kirchhoff`, `linear`, `neo-hookean`"),
    ] {
        let told = wrong_builtin("csm1", overrides);
        assert!(told.contains(expected), "{overrides:?}: {told}");
    }
}
