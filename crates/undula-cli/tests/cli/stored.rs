//! Cases and checkpoints of older versions: they load, or are refused by name. `stored/DATE` is a run as the program of that
//! day has left it, without its fields.

use super::{Place, Said};
use serde_json::Value;
use std::fs;
use std::path::Path;
use undula::output::Checkpoint;

const STEP: u64 = 4;

/// A copy of the stored run, whose checkpoint says what `change` makes of it.
fn stored(here: &Place, name: &str, change: impl FnOnce(&mut Value)) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/stored/2026-11-29");
    let to = here.file(name);
    fs::create_dir_all(to.join("checkpoints")).unwrap();
    for file in ["case.toml", "history.csv", "summary.json"] {
        fs::copy(from.join(file), to.join(file)).unwrap();
    }
    let mut checkpoint = Checkpoint::load(Checkpoint::path(from.join("checkpoints"), STEP)).unwrap();
    let mut metadata: Value = serde_json::from_str(&checkpoint.metadata).unwrap();
    change(&mut metadata);
    checkpoint.metadata = metadata.to_string();
    checkpoint.save(to.join("checkpoints"), STEP).unwrap();
}

fn resume(here: &Place, name: &str) -> Said {
    here.run(&format!("run {name}/case.toml -o {name} --resume --quiet --threads 1"), &["time.end=0.3"])
}

/// The numbers of the rows behind the stored ones.
fn later(here: &Place, name: &str) -> Vec<Vec<f64>> {
    let rows = here.read(&format!("{name}/history.csv"));
    rows.lines()
        .skip(1 + STEP as usize)
        .map(|row| row.split(',').map(|x| x.parse().unwrap()).collect())
        .collect()
}

fn is_near(here: &Place, name: &str, expected: &[Vec<f64>]) {
    let found = later(here, name);
    assert_eq!((found.len(), expected.len()), (2, 2), "{name}");
    for (x, y) in found.concat().iter().zip(expected.concat()) {
        // Other processors round otherwise, and what is not stored, such as the age of a Jacobian, costs iterations.
        assert!((x - y).abs() <= 1e-6 * y.abs() || y.fract() == 0.0, "{name}: {found:?} {expected:?}");
    }
}

fn without(keys: &[&str], metadata: &mut Value) {
    let map = metadata.as_object_mut().unwrap();
    keys.iter().for_each(|key| assert!(map.remove(*key).is_some(), "{key}"));
}

#[test]
fn runs_of_older_versions_go_on() {
    let here = Place::new("stored");
    stored(&here, "old", |_| ());
    here.run("run old/case.toml -o whole --quiet --threads 1", &["time.end=0.3"]).expect(0, &[]);
    let expected = later(&here, "whole");
    resume(&here, "old").expect(0, &[]);
    is_near(&here, "old", &expected);
    // As the first version of the format had it.
    stored(&here, "first", |metadata| {
        without(
            &["damping", "age", "worsening", "detour", "adaptive", "balance", "linear_iterations"],
            metadata,
        );
        let case = metadata["case"].as_str().unwrap();
        let later = ["coordinates = ", "body-force-at = ", "quadrature = "];
        let kept = case.lines().filter(|line| !later.iter().any(|key| line.starts_with(key)));
        metadata["case"] = kept.collect::<Vec<_>>().join("\n").into();
    });
    resume(&here, "first").expect(0, &[]);
    is_near(&here, "first", &expected);
    // Other commands read it, too.
    here.run("check --jacobian --from old", &[]).expect(0, &[]);
    here.run("run old/case.toml -o on --quiet", &["initial.from=old", "time.end=0.4"]).expect(0, &[]);
    here.run("compare old whole", &[]).expect(0, &[]);
}

#[test]
fn what_cannot_be_read_of_an_older_version_is_named() {
    let here = Place::new("stored-refused");
    stored(&here, "format", |metadata| without(&["clock"], metadata));
    resume(&here, "format")
        .expect(2, &["checkpoint_00000004.npz: not a checkpoint of this program", "`clock`"]);
    stored(&here, "keys", |metadata| {
        let case = metadata["case"].as_str().unwrap();
        metadata["case"] = case.replace("[motion]\n", "[motion]\nelasticity = 3\n").into();
    });
    resume(&here, "keys").expect(2, &["motion.elasticity was 3, now absent"]);
    let case = here.read("keys/case.toml").replace("[motion]\n", "[motion]\nelasticity = 3\n");
    here.write("keys/case.toml", &case);
    resume(&here, "keys").expect(2, &["keys/case.toml:", "motion.elasticity: unknown key"]);
}
