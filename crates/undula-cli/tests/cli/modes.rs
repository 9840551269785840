//! `undula modes`.

use super::Place;
use std::fs;

#[test]
fn modes_are_printed_and_written() {
    let here = Place::new("modes");
    let said = here.run("modes fsi3 --count 3 -o shapes", &["mesh.refine=0"]);
    said.expect(
        0,
        &["frequency in vacuum (Hz)", "with the added mass of the fluid (Hz)", "shapes/modes.csv"],
    );
    let table = here.read("shapes/modes.csv");
    let rows: Vec<Vec<f64>> = (table.lines().skip(1))
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    assert!(table.starts_with("mode,frequency_vacuum,frequency_added_mass\n") && rows.len() == 3, "{table}");
    assert!(
        rows.iter().all(|row| row[2] < row[1]) && rows.windows(2).all(|two| two[0][1] < two[1][1]),
        "{table}"
    );
    let (shapes, _) = undula::output::read_vtu(here.file("shapes/modes.vtu")).unwrap();
    for name in ["mode_1_vacuum", "mode_3_added_mass"] {
        let values = &shapes.at_points(name).unwrap().values;
        let size = values.chunks_exact(3).map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
        assert!((size - 1.0).abs() < 1e-6, "{name}: {size}");
    }
    // The directory is not empty any more; the file and its content stay.
    here.run("modes fsi3 --count 1 -o shapes", &["mesh.refine=0"]).expect(2, &["shapes: not empty"]);
    assert_eq!(here.read("shapes/modes.csv"), table);
}

#[test]
fn a_solid_alone_has_modes_in_vacuum() {
    let here = Place::new("modes-vacuum");
    let said = here.run("modes csm3 --count 2 -o shapes", &["mesh.refine=0"]);
    let said = said.expect(0, &["frequency in vacuum (Hz)"]);
    assert!(!said.out.contains("added mass"), "{}", said.out);
    assert!(here.read("shapes/modes.csv").lines().skip(1).all(|line| line.ends_with(",nan")));
}

/// Loads that act are named, and those that are zero are not.
#[test]
fn loads_that_modes_leave_out_are_named() {
    let here = Place::new("modes-loads");
    let named = |case: &str, sets: &[&str]| -> Vec<String> {
        let words = format!("modes {case} --count 1");
        let said = here.run(&words, &[&["mesh.refine=0"], sets].concat()).expect(0, &[]);
        let lines = said.err.lines().filter_map(|line| line.split_once(" has no effect"));
        lines.map(|(key, _)| key.to_string()).collect()
    };
    assert_eq!(named("csm3", &[]), ["note: solid.body-force"], "gravity acts");
    assert!(named("csm3", &["solid.body-force=[0,0]"]).is_empty());
    let outlet = |load| ["boundary.outflow.condition=traction", load];
    assert_eq!(
        named("fsi3", &outlet("boundary.outflow.traction=[1,0]")),
        ["note: boundary.outflow.traction"]
    );
    assert!(named("fsi3", &outlet("boundary.outflow.traction=[0,0]")).is_empty());
}

#[test]
fn cases_without_modes_are_bad_input() {
    let here = Place::new("modes-refused");
    here.run("modes fsi3 -o shapes", &["solid=none"]).expect(2, &["solid", "expected an elastic body"]);
    here.run("modes rotor -o shapes", &[]).expect(2, &["nothing holds"]);
    here.run("modes csm1 -o shapes", &["solid.law=incompressible-neo-hookean"])
        .expect(2, &["not yet available"]);
    here.run("modes fsi3 --count 0", &[]).expect(2, &["--count"]);
    assert!(fs::exists(here.file("shapes")).is_ok_and(|there| !there), "nothing is written");
    here.write("file", "");
    here.run("modes fsi3 -o file", &["mesh.refine=0"]).expect(2, &["file: this is a file"]);
}
