//! `undula new --mesh`.

use super::Place;
use std::fs;
use std::path::{Path, PathBuf};

fn mesh(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Every mesh that the tests have, of the plane and of space, gives a case that can be run as it is.
#[test]
#[ignore = "long"]
fn a_mesh_gives_a_case_with_its_regions_and_boundaries() {
    let here = Place::new("starters");
    let inputs = "tests/cli/faults/inputs";
    for (file, words) in [
        (
            "../../examples/hydrofoil.msh",
            [
                "[boundary.inflow]  # 3 m, of the fluid",
                "condition = \"flux\"",
                "[boundary.hub]",
                "condition = \"clamped\"",
            ],
        ),
        (
            &format!("{inputs}/discovery/g4.msh"),
            ["region = \"fluid\"", "[boundary.lid]", "condition = \"no-slip\"", "on = [\""],
        ),
        (
            &format!("{inputs}/newcomer/artery.msh"),
            ["[boundary.outer]", "of the solid", "profile = \"parabolic\"", "taken for solid"],
        ),
        (
            &format!("{inputs}/newcomer/flap_tri2.msh"),
            ["[boundary.clamp]", "on = [\"interface\"]", "flow-rate = \"-0.1*ramp(t,", "Re 100"],
        ),
    ] {
        let name = Path::new(file).file_name().unwrap().to_str().unwrap();
        fs::copy(mesh(file), here.file(name)).unwrap();
        let case = name.replace(".msh", ".toml");
        here.run(&format!("new --mesh {name}"), &[]).expect(0, &["Wrote", &case]);
        let text = here.read(&case);
        for word in words {
            assert!(text.contains(word), "{name}: {word}\n{text}");
        }
        assert!(
            text.contains(&format!("file = \"{name}\""))
                && text.lines().all(|line| line.chars().count() <= 120)
        );
        let said = here.run(&format!("check {case}"), &[]).expect(0, &["unknowns"]);
        assert!(!said.out.contains("warning"), "{}", said.out);
        here.run(&format!("new --mesh {name}"), &[]).expect(2, &["exists already"]);
    }
    // Two steps, with the page at the end.
    let step = here.read("flap_tri2.toml");
    let step: f64 = step.split("step = ").nth(1).unwrap().split_whitespace().next().unwrap().parse().unwrap();
    here.run("run flap_tri2.toml -o out", &[&format!("time.end={}", 2.0 * step)]).expect(0, &["report.html"]);
    // Elsewhere the mesh is named by its whole path.
    fs::create_dir_all(here.file("sub")).unwrap();
    here.run("new --mesh g4.msh sub/own.toml", &[]).expect(0, &[]);
    here.run("check sub/own.toml", &[]).expect(0, &["own:", "unknowns"]);
    // Without an outlet all are walls, which is told.
    here.write("closed.msh", &here.read("g4.msh").replace("outflow", "drain"));
    let said = here.run("new --mesh closed.msh -", &[]);
    let said = said
        .expect(0, &["no boundary is called `outlet`", "`inflow`, `drain`, `walls`, `lid` got `no-slip`"]);
    assert!(
        said.out.starts_with("# A case for the mesh closed.msh") && said.out.contains("name = \"closed\"")
    );
    assert!(
        said.out.contains("# no boundary is called `outlet`") && !here.file("-").exists(),
        "{}",
        said.out
    );
    let said = here.run("new csm1 -", &[]).expect(0, &[]);
    assert!(said.out.contains("name = \"csm1\"") && !here.file("-").exists(), "{}", said.out);
    here.run("new --mesh none.msh", &[]).expect(2, &["none.msh"]);
    here.run("new g4.msh", &[]).expect(2, &["undula new --mesh g4.msh"]);
}
