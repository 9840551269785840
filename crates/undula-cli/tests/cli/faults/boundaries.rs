//! Nodes at which boundaries of different bodies meet, and flow back in through outlets.

use super::{close, last, place, undula};
use crate::Place;

/// ½ ρ ∫ (4 y (1 − y))² over the channel of 4 m × 1 m \[J/m\].
const POISEUILLE: f64 = 16.0 / 15.0;

/// Kinetic energy of the fluid as a functional `fke`, force on a whole wall, end of the elastic wall.
const MORE: [&str; 5] = [
    "functional.fke.kind=energy",
    "functional.fke.term=fluid-kinetic",
    "functional.ux_end.kind=displacement",
    "functional.ux_end.point=[4,1]",
    "functional.ux_end.component=x",
];

/// A stationary flow through the box, whose names touch both bodies.
const STATIONARY_BOX: [&str; 2] = ["time=none", "boundary.left.velocity=[\"if(y<1, 4*y*(1-y), 0)\", 0]"];

/// A stationary flow through the tube from Gmsh, where every part of the boundary has a name.
const STATIONARY_TUBE: [&str; 2] = ["time=none", "boundary.inlet.velocity=[\"4*y*(1-y)\", 0]"];

const TRIANGLES: [&str; 2] = ["mesh.file=tri.msh", "space.velocity=P2"];

fn channel(name: &str) -> Place {
    place(name, &["shared-boundary/case.toml"])
}

fn tube(name: &str) -> Place {
    place(name, &["corner-node/case.toml", "corner-node/tube.msh", "corner-node/tri.msh"])
}

/// Runs the case of `place` to its end.
#[track_caller]
fn complete(place: &Place, sets: &[&[&str]]) {
    let sets = [&MORE[..], &sets.concat()].concat();
    undula(place, "run case.toml --quiet --force --threads 1 -o out", &sets).expect(0, &[]);
}

fn value(place: &Place, name: &str) -> f64 {
    last(place, "out", name)
}

#[test]
fn a_stiff_wall_with_open_ends_is_a_channel() {
    let (channel, tube) = (channel("stiff-box"), tube("stiff-tube"));
    let stiff = ["solid.young=1e12"];
    let free = ["boundary.right.condition=traction-free"];
    let runs: [(&Place, &[&str], &[&str], f64); 4] = [
        (&channel, &STATIONARY_BOX, &[], 1e-7),
        // Poiseuille's flow has shear stress in the outlet, which a traction-free one does not have.
        (&channel, &STATIONARY_BOX, &free, 2e-3),
        (&tube, &STATIONARY_TUBE, &[], 1e-7),
        (&tube, &STATIONARY_TUBE, &TRIANGLES, 1e-7),
    ];
    for (place, flow, more, within) in runs {
        complete(place, &[flow, more, &stiff]);
        close(value(place, "fke"), POISEUILLE, within);
        assert!(value(place, "ke").abs() < 1e-30);
    }
}

#[test]
fn a_stiff_wall_does_not_move_in_time() {
    let sets: [&[&str]; 2] = [&["solid.young=1e9", "time.step=0.1"], &["mesh.cells=[16, 6]"]];
    let stiff_box = channel("stiff-box-in-time");
    for condition in ["do-nothing", "traction-free"] {
        let condition = format!("boundary.right.condition={condition}");
        complete(&stiff_box, &[sets[0], sets[1], &[&condition]]);
        close(value(&stiff_box, "fke"), POISEUILLE, 5e-3);
        assert!(value(&stiff_box, "ke") < 1e-8, "{}", value(&stiff_box, "ke"));
    }
    let stiff_tube = tube("stiff-tube-in-time");
    for scheme in ["time.scheme=shifted-crank-nicolson", "time.scheme=bdf2"] {
        complete(&stiff_tube, &[sets[0], &[scheme]]);
        close(value(&stiff_tube, "fke"), POISEUILLE, 5e-3);
        assert!(value(&stiff_tube, "ke") < 1e-8, "{}", value(&stiff_tube, "ke"));
    }
}

/// At rest nothing of the solid has a velocity, however far its end has moved.
#[test]
fn a_solid_at_rest_has_no_kinetic_energy() {
    let place = tube("at-rest");
    for more in [&[][..], &TRIANGLES] {
        complete(&place, &[&STATIONARY_TUBE, more]);
        assert!(value(&place, "ke").abs() < 1e-30);
        assert!(value(&place, "uy_end") > 1.0);
    }
}

/// One name over both bodies or a name for each: the same problem on the same cells.
#[test]
fn names_do_not_matter_to_a_compliant_channel() {
    let (channel, tube) = (channel("names-box"), tube("names-tube"));
    let short = ["time.end=0.3"];
    complete(&channel, &[&short, &["functional.uy_end.point=[4, 1.2]"]]);
    complete(&tube, &[&short]);
    for name in ["uy_mid", "uy_end", "ux_end", "ke", "fke"] {
        close(value(&channel, name), value(&tube, name), 1e-6);
    }
    let said = undula(&channel, "check case.toml", &[]);
    said.expect(
        0,
        &["boundary.right: the solid ends free at (4.000000, 1.000000)", "boundary.left", "clamped"],
    );
}
