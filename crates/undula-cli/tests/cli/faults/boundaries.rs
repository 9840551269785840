//! Nodes at which boundaries of different bodies meet, and flow back in through outlets.

use super::{close, last, place, undula};
use crate::Place;

/// ½ ρ ∫ (4 y (1 − y))² over the channel of 4 m × 1 m \[J/m\].
const POISEUILLE: f64 = 16.0 / 15.0;

/// Kinetic energy of the fluid and axial displacement of the end of the elastic wall.
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
    let sets: [&[&str]; 2] = [&["solid.young=1e9", "time.step=0.02", "time.end=3"], &["mesh.cells=[16, 6]"]];
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

#[test]
fn a_compliant_channel_with_open_ends_runs() {
    let channel = channel("compliant-box");
    for condition in ["do-nothing", "traction-free"] {
        let condition = format!("boundary.right.condition={condition}");
        complete(&channel, &[&["mesh.cells=[16, 6]", "time.step=0.02", &condition]]);
        let (middle, end) = (value(&channel, "uy_mid"), value(&channel, "uy_end"));
        assert!((0.42..0.45).contains(&middle) && (0.5..0.65).contains(&end), "{middle} {end}");
    }
    let tube = tube("compliant-tube");
    for more in [&[][..], &TRIANGLES] {
        complete(&tube, &[&["time.step=0.02"], more]);
        close(value(&tube, "uy_mid"), 0.436, 0.01);
        close(value(&tube, "uy_end"), 0.611, 0.02);
    }
}

#[test]
fn a_clamped_end_stays_where_it_is() {
    let tube = tube("clamped");
    complete(&tube, &[&["boundary.wall_out.condition=clamped", "time.scheme=bdf2"]]);
    assert_eq!((value(&tube, "ux_end"), value(&tube, "uy_end")), (0.0, 0.0));
    close(value(&tube, "ke"), 0.0035, 0.05);
}

/// The deformation of the wall hardly depends on how the mesh follows, and not at all on how the equations are solved.
#[test]
fn outlets_move_with_every_motion_and_linearization() {
    let channel = channel("motions");
    let coarse = ["mesh.cells=[16, 6]", "time.step=0.02", "time.end=0.6"];
    for model in ["harmonic", "stiffened-harmonic", "pseudo-elastic", "jacobian-stiffened", "biharmonic"] {
        let model = format!("motion.model={model}");
        let mut ends = vec![];
        for linearization in ["newton.linearization=condensed", "newton.linearization=newton"] {
            complete(&channel, &[&coarse, &[&model, linearization]]);
            close(value(&channel, "uy_mid"), 0.17866, 1e-3);
            close(value(&channel, "ux_end"), -0.03036, 2e-3);
            ends.push(value(&channel, "uy_end"));
        }
        close(ends[0], ends[1], 1e-5);
    }
}

#[test]
fn velocity_data_on_the_solid_are_refused() {
    let channel = channel("driven-box");
    let sets = ["boundary.right.condition=no-slip", "boundary.left.velocity=[\"0.1*ramp(t,0.2)\", 0]"];
    let words = ["boundary.left.velocity", "0.1*ramp(t,0.2)", "(1.0000e-1, 0.0000e0) m/s", "0 on the solid"];
    for command in ["check case.toml", "run case.toml -o out"] {
        undula(&channel, command, &sets).expect(2, &words);
    }
    assert!(!channel.file("out").exists());

    // A free end of the wall at the inlet is clamped if the data vanish there, and a held one takes no data.
    let tube = tube("driven-tube");
    let free = "boundary.wall_in.condition=traction-free";
    let jump = "boundary.inlet.velocity=[\"4*y*(1.1-y)*ramp(t,0.2)\", 0]";
    undula(&tube, "check case.toml", &[free, jump]).expect(2, &["(0.000000, 1.000000)", "0 on the solid"]);
    undula(&tube, "check case.toml", &[free]).expect(0, &["the solid is clamped at (0.000000, 1.000000)"]);
    undula(&tube, "check case.toml", &[jump]).expect(0, &["where the solid is held; 0 is taken there"]);
}

#[test]
fn conditions_that_are_proposed_for_both_bodies_are_accepted() {
    let channel = channel("proposed");
    let proposed =
        "add [boundary.right] with condition = one of `velocity`, `no-slip`, `do-nothing`, `traction-free`";
    undula(&channel, "check case.toml", &["boundary.right=none"]).expect(2, &[proposed]);
    for condition in ["no-slip", "do-nothing", "traction-free"] {
        undula(&channel, "check case.toml", &[&format!("boundary.right.condition={condition}")])
            .expect(0, &[]);
    }
}

/// Pulsating flow that turns round at the outlet; coarse.
fn vessel(name: &str) -> (Place, [&'static str; 2]) {
    (place(name, &["backflow/case.toml"]), ["mesh.cells=[48, 12]", "time.step=0.005"])
}

const DIRECTIONAL: &str = "boundary.right.backflow=directional";

#[test]
fn flow_back_in_through_an_outlet_is_named() {
    let (vessel, [cells, step]) = vessel("backflow");
    let words =
        ["the flow comes back in through the outlet `right`", "m/s at (0.08", "boundary.right.backflow"];
    let run = "run case.toml --quiet --threads 1 -o out";
    undula(&vessel, run, &[cells, step, "time.max-halvings=0"]).expect(3, &words);
}

/// A pressure pulse at an inlet: when it is over, the flow turns round there, and a burst of it folds the wall beside it,
/// unless a term takes the energy out that it brings in, as by default.
#[test]
#[ignore = "long"]
fn a_burst_through_an_inlet_with_a_pressure_is_named() {
    let artery = place("artery", &["newcomer/artery.toml", "newcomer/artery.msh"]);
    let run = "run artery.toml --quiet --threads 1 --force -o out";
    let words =
        ["the flow comes back in through the outlet `inlet`", "boundary.inlet.backflow = \"tangential\""];
    undula(&artery, run, &["time.max-halvings=0", "boundary.inlet.backflow=none"]).expect(3, &words);
    undula(&artery, run, &["time.step=2e-4", "boundary.inlet.backflow=directional"]).expect(0, &[]);
    // As written, to its end.
    undula(&artery, run, &[]).expect(0, &[]);
    assert!(!artery.file("out/breakdown.txt").exists());
}

#[test]
fn the_directional_outlet_computes_through_backflow() {
    let (vessel, [cells, step]) = vessel("directional");
    let run = "run case.toml --quiet --force --threads 1 -o out";
    let mut energies = vec![];
    for linearization in ["newton.linearization=condensed", "newton.linearization=newton"] {
        undula(&vessel, run, &[cells, step, "time.end=0.65", DIRECTIONAL, linearization]).expect(0, &[]);
        energies.push(value(&vessel, "ke"));
    }
    close(energies[0], 0.045742, 1e-4);
    close(energies[0], energies[1], 1e-6);
    let written = undula(&vessel, "check case.toml --toml", &[DIRECTIONAL]).expect(0, &[]).out;
    assert!(written.contains("backflow = \"directional\""), "{written}");
    vessel.write("again.toml", &written);
    assert_eq!(undula(&vessel, "check again.toml --toml", &[]).expect(0, &[]).out, written);
}

/// Beside a wall that moves the outlet moves, too, so that ∂_t u takes part.
#[test]
fn jacobians_have_the_directional_term() {
    let channel = channel("directional-jacobian");
    for scheme in ["shifted-crank-nicolson", "bdf2", "cg1"] {
        let scheme = format!("time.scheme={scheme}");
        let sets = [DIRECTIONAL, "mesh.cells=[8, 6]", &scheme];
        undula(&channel, "check case.toml --jacobian", &sets).expect(0, &["all Jacobians agree"]);
    }
}

#[test]
fn backflow_where_nothing_flows_out_is_told() {
    let channel = channel("backflow-elsewhere");
    let solid = ["boundary.top.backflow=directional"];
    undula(&channel, "check case.toml", &solid)
        .expect(2, &["boundary.top.backflow", "only the solid is here"]);
    let pressure = ["boundary.top.condition=pressure", "boundary.top.pressure=1e-3"];
    let told = undula(&channel, "check case.toml", &pressure).expect(0, &[]);
    assert!(!told.out.contains("backflow") && !told.err.contains("backflow"));
    let wall = ["boundary.bottom.backflow=directional"];
    undula(&channel, "check case.toml", &wall).expect(0, &["boundary.bottom.backflow has no effect"]);
    let word = ["boundary.right.backflow=inward"];
    undula(&channel, "check case.toml", &word).expect(2, &["expected one of `none`, `directional`"]);
}

/// A flow without walls from a file: checked, computed, drawn, and resumed with the same bits.
#[test]
fn a_periodic_box_runs() {
    let here = Place::new("periodic-box");
    here.write(
        "torus.toml",
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 1]\ncells = [4, 4]\n[fluid]\ndensity = 1\n\
         kinematic-viscosity = 0.01\n[boundary.left]\ncondition = \"periodic\"\nwith = \"right\"\n[boundary.bottom]\n\
         condition = \"periodic\"\nwith = \"top\"\n[initial]\nvelocity = [\"1 - cos(2*pi*x)*sin(2*pi*y)\", \
         \"sin(2*pi*x)*cos(2*pi*y)\"]\n[time]\nstep = 0.05\nend = 0.1\n[output]\nfields-every = 1\n",
    );
    here.run("check torus.toml", &[])
        .expect(0, &["left: periodic", "top: periodic", "closed in on all sides"]);
    here.run("run torus.toml -o out", &[]).expect(0, &["completed", "out/plots/speed.png"]);
    here.run("run torus.toml -o out --resume --quiet", &["time.end=0.2"]).expect(0, &[]);
    here.run("run torus.toml -o whole --quiet", &["time.end=0.2"]).expect(0, &[]);
    assert_eq!(here.read("out/history.csv"), here.read("whole/history.csv"));
    here.run("check torus.toml", &["boundary.bottom.with=left"])
        .expect(2, &["boundary.bottom.with", "`left` is one with `right`"]);
}
