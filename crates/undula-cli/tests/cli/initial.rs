//! How runs start: from the last state of another one, and in equilibrium.

use super::{Place, SMALL};
use std::fs;

/// A new Jacobian in every iteration, so that none is kept from before the start.
const FRESH: &str = "newton.rate-max=0";

/// The rows of a history without their steps, which every run counts from 1.
fn rows(here: &Place, directory: &str) -> Vec<String> {
    let text = here.read(&format!("{directory}/history.csv"));
    text.lines().skip(1).map(|row| row.split_once(',').unwrap().1.to_string()).collect()
}

/// The column `name` of a history.
fn column(here: &Place, directory: &str, name: &str) -> Vec<f64> {
    let text = here.read(&format!("{directory}/history.csv"));
    let at = text.lines().next().unwrap().split(',').position(|column| column == name).unwrap();
    text.lines().skip(1).map(|row| row.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

/// A run to t = 0.05 s in `first`.
fn first(here: &Place, sets: &[&str]) {
    here.run("run fsi3 -o first --quiet", &[&SMALL[..], sets].concat()).expect(0, &[]);
}

#[test]
#[ignore = "long"]
fn a_run_from_another_one_has_the_history_of_the_straight_run() {
    let here = Place::new("initial-straight");
    // The charge of a circuit goes on, too.
    let circuit = [
        "boundary.outflow.condition=windkessel",
        "boundary.outflow.proximal=1e3",
        "boundary.outflow.capacitance=1e-5",
        "boundary.outflow.distal=2e3",
        "boundary.outflow.initial=50",
    ];
    for (scheme, more) in [("shifted-crank-nicolson", &[][..]), ("bdf2", &[]), ("bdf2", &circuit)] {
        let scheme = format!("time.scheme={scheme}");
        let sets = [&[FRESH, &scheme], more].concat();
        here.run("run fsi3 -o first --quiet --force", &[&SMALL[..], &sets].concat()).expect(0, &[]);
        let longer = [&SMALL[..], &sets, &["time.end=0.1"]].concat();
        here.run("run fsi3 -o straight --quiet --force", &longer).expect(0, &[]);
        let from = [&longer[..], &["initial.from=first"]].concat();
        here.run("run fsi3 -o second --force", &from).expect(0, &["starts at t = 0.05 s", "copied"]);
        let (straight, second) = (rows(&here, "straight"), rows(&here, "second"));
        assert_eq!((straight.len(), second.len()), (10, 5));
        assert_eq!(straight[5..], second[..], "{scheme}");
    }
}

#[test]
fn a_resumed_run_does_not_need_the_run_it_began_from() {
    let here = Place::new("initial-resume");
    first(&here, &[]);
    fs::create_dir(here.file("cases")).unwrap();
    here.run("new fsi3 cases/own.toml", &[]).expect(0, &[]);
    let text = here.read("cases/own.toml") + "\n[initial]\nfrom = \"../first\"\n";
    here.write("cases/own.toml", &text);
    let [early, late] = ["time.end=0.08", "time.end=0.1"].map(|end| [&SMALL[..], &[end]].concat());
    here.run("run cases/own.toml -o whole --quiet", &late).expect(0, &[]);
    here.run("run cases/own.toml -o parts --quiet", &early).expect(0, &[]);
    let case = here.read("parts/case.toml");
    assert!(case.contains("start = 0.05") && case.contains("[initial]"), "{case}");
    here.run("check cases/own.toml", &late).expect(0, &["0.05 to 0.1 s"]);
    fs::remove_dir_all(here.file("first")).unwrap();
    here.run("run cases/own.toml -o parts --quiet --resume", &late).expect(0, &[]);
    assert_eq!(rows(&here, "parts"), rows(&here, "whole"));
    here.run("run parts/case.toml -o parts --quiet --resume", &["time.end=0.12"]).expect(0, &[]);
    here.run("check --jacobian --from parts", &[]).expect(0, &["t = 0.12 s"]);
    here.run("run cases/own.toml -o other", &late).expect(2, &["initial.from", "no run here"]);
}

/// The state of a coarse mesh goes on with other elements and on a finer mesh: the first row is that on the old mesh, up
/// to the errors of its functionals.
#[test]
#[ignore = "long"]
fn a_finer_run_goes_on_where_a_coarse_one_ended() {
    let here = Place::new("initial-finer");
    first(&here, &[]);
    let other = ["initial.from=first", "time.step=0.001", "time.end=0.052"];
    here.run("run fsi3 -o same", &[&SMALL[..], &other].concat()).expect(0, &["copied"]);
    let first_of = |directory: &str| ["uy_A", "drag"].map(|name| column(&here, directory, name)[0]);
    let same = first_of("same");
    for (sets, name) in [
        (&["mesh.refine=1"][..], "finer"),
        (&["space.velocity=Q3"], "higher"),
        (&["space.velocity=P2-bubble"], "triangles"),
        (&["space.pressure=Q1"], "continuous"),
    ] {
        let sets = [&SMALL[..], &other, sets].concat();
        here.run(&format!("run fsi3 -o {name}"), &sets).expect(0, &["interpolated"]);
        let times = column(&here, name, "time");
        assert!((times[0] - 0.051).abs() < 1e-12 && times.len() == 2, "{times:?}");
        let [uy, drag] = first_of(name);
        println!("{name}: uy_A {uy:e}, drag {drag}; on the same mesh {same:?}");
        assert!((uy / same[0] - 1.0).abs() < 1e-3, "{name}: {uy} {}", same[0]);
        // Its error on the coarsest mesh is of this size.
        assert!((drag / same[1] - 1.0).abs() < 0.1, "{name}: {drag} {}", same[1]);
    }
}

/// Another start, material and mesh motion are the new case's own.
#[test]
#[ignore = "long"]
fn a_start_that_is_given_holds() {
    let here = Place::new("initial-start");
    first(&here, &[]);
    let other =
        ["initial.from=first", "time.start=0", "time.end=0.02", "solid.mu=1e6", "motion.model=harmonic"];
    here.run("run fsi3 -o second", &[&SMALL[..], &other].concat()).expect(0, &["starts at t = 0 s"]);
    let times = column(&here, "second", "time");
    assert_eq!(times, [0.01, 0.02]);
}

#[test]
fn starts_that_are_not_there_are_refused() {
    let here = Place::new("initial-refused");
    first(&here, &[]);
    let refused = |arguments: &str, sets: &[&str], words: &[&str]| {
        here.run(&format!("run {arguments} -o out"), sets).expect(2, words);
        assert!(!here.file("out").exists(), "nothing is written");
    };
    let late = [&SMALL[..], &["time.end=0.1"]].concat();
    here.run("run fsi1 -o stationary --quiet", &["mesh.refine=0"]).expect(0, &[]);
    refused("fsi3", &[&late[..], &["initial.from=nowhere"]].concat(), &["initial.from", "no run here"]);
    refused("fsi3", &[&late[..], &["initial.from=stationary"]].concat(), &["initial.from", "no checkpoint"]);
    refused(
        "fsi3",
        &[&SMALL[..], &["initial.from=first"]].concat(),
        &["time.end", "0.05 s is not after 0.05 s"],
    );
    refused("fsi1", &["initial.from=first"], &["initial.from", "[time]"]);
    let words = ["initial.from", "first", "same geometry"];
    refused("rotor", &["initial.from=first", "mesh.refine=0", "time.end=1"], &words);
    let checkpoints = here.file("first/checkpoints");
    for entry in fs::read_dir(checkpoints).unwrap() {
        fs::write(entry.unwrap().path(), "no archive").unwrap();
    }
    let words = ["initial.from", "not a sound checkpoint"];
    refused("fsi3", &[&late[..], &["initial.from=first"]].concat(), &words);
}

/// It is found once: a run that is resumed goes on from its own state.
#[test]
#[ignore = "long"]
fn a_run_begins_in_equilibrium() {
    let here = Place::new("initial-static");
    let still = ["initial.static=true", "boundary.inflow.velocity=[0,0]", "solid.body-force=[0,-2]"];
    let early = [&SMALL[..], &still].concat();
    let late = [&early[..], &["time.end=0.1"]].concat();
    here.run("check fsi3", &early).expect(0, &["from the stationary solution"]);
    here.run("run fsi3 -o whole --threads 1", &late).expect(0, &["starts with the stationary solution"]);
    here.run("run fsi3 -o parts --quiet --threads 2", &early).expect(0, &[]);
    here.run("run fsi3 -o parts --quiet --resume --threads 1", &late).expect(0, &[]);
    assert_eq!(rows(&here, "parts"), rows(&here, "whole"));
    let u = column(&here, "whole", "uy_A");
    assert!(u.iter().all(|y| y.abs() > 1e-3 && (y / u[0] - 1.0).abs() < 1e-9), "{u:?}");
    assert!(here.read("parts/summary.json").contains("\"start\": \"stationary solution"));
    let hard = [&early[..], &["newton.max-steps=1"]].concat();
    here.run("run fsi3 -o none", &hard).expect(3, &["no equilibrium"]);
    assert!(!here.file("none").exists());
}
