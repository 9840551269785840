//! The table of keys is what reading accepts.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use toml::{Table, Value};
use undula::case::Case;
use undula::case::builtin::builtin_cases;
use undula::case::keys::{KEYS, Key, find};

/// Cases that together have a value for each key that has a default.
const CASES: [&[&str]; 14] = [
    &[],
    &["space.velocity=Q1", "functional.f.component=y"],
    &["stabilization.transport=lps", "time.adaptive.safety=0.8"],
    &["newton.jacobian=finite-difference", "motion.model=jacobian-stiffened"],
    &["linear.krylov=gmres", "motion.model=biharmonic"],
    &["linear.engine=petsc"],
    &["time.scheme=rannacher"],
    &["solid.law=mooney-rivlin", "time.adaptive.tolerance=1e-3"],
    &["time.scheme=stationary"],
    &["solid.law=holzapfel-gasser-ogden", "solid.k1=1", "solid.k2=1", "solid.fibre-angle=0.5"],
    &[
        "fluid.kinematic-viscosity=none",
        "fluid.law=carreau-yasuda",
        "fluid.viscosity-zero=2",
        "fluid.viscosity-infinity=1",
        "fluid.time-constant=1",
        "fluid.power-index=0.5",
    ],
    &["mesh.generator=none", "mesh.file=none.msh"],
    &["mesh.extrude={depth=1,layers=1}"],
    &["mesh.generator=fsi-box", "mesh.wall={surface=\"walls\",thickness=1}"],
];

const TEXT: &str = r#"
[mesh]
generator = "turek-hron"
[fluid]
density = 1
kinematic-viscosity = 1
[solid]
density = 1
mu = 1
lambda = 1
[time]
step = 0.01
end = 1
[functional.f]
kind = "force"
on = "cylinder"
component = "x"
"#;

fn read(text: &str, sets: &[&str]) -> Result<Case, String> {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    Case::from_toml(text, "own.toml", &sets).map_err(|errors| errors.to_string())
}

/// Dotted keys and values of a table.
fn flatten(path: &str, table: &Table, found: &mut BTreeMap<String, Value>) {
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        match value {
            Value::Table(inner) => flatten(&path, inner, found),
            value => drop(found.insert(path, value.clone())),
        }
    }
}

fn values(case: &Case) -> BTreeMap<String, Value> {
    let mut found = BTreeMap::new();
    flatten("", &case.to_toml().parse::<Table>().unwrap(), &mut found);
    found
}

#[test]
fn every_key_of_the_built_in_cases_is_in_the_table() {
    for shipped in builtin_cases() {
        for key in values(&Case::builtin(shipped.name, &[]).unwrap()).keys() {
            assert!(find(key).is_some(), "{}: {key}", shipped.name);
        }
    }
}

/// The settings with which reading takes `key`: functionals have keys for each kind.
fn surroundings(key: &Key) -> Vec<Vec<String>> {
    if key.table() != "functional.NAME" {
        return vec![vec![]];
    }
    let kinds = find("functional.f.kind").unwrap().choices();
    let meshes = [vec![], vec!["mesh.extrude={depth=1,layers=1}".to_string()]];
    let kind = |(kind, _): &(&str, _)| format!("functional.x.kind={kind}");
    let of = |row| meshes.iter().map(move |mesh| [&mesh[..], &[kind(row)]].concat());
    kinds.iter().flat_map(of).collect()
}

/// What reading says of `key` with this value in all surroundings.
fn answers(key: &Key, value: &str) -> impl Iterator<Item = String> {
    let dotted = key.key.replace("NAME", "x");
    surroundings(key).into_iter().map(move |mut sets| {
        sets.push(format!("{dotted}={value}"));
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let errors = read(TEXT, &sets).err().unwrap_or_default();
        let about = format!("--set {dotted}=");
        errors.lines().filter(|line| line.starts_with(&about)).collect::<Vec<_>>().join("\n")
    })
}

/// What reading says of `key` with this value, at best.
fn said(key: &Key, value: &str) -> String {
    let texts = answers(key, value);
    let badness = |text: &String| match () {
        () if text.contains("unknown key") => 2,
        () if text.contains("expected one of") => 1,
        () => 0,
    };
    texts.min_by_key(badness).unwrap()
}

#[test]
fn reading_knows_every_key_and_value_of_the_table() {
    for key in KEYS.iter() {
        let answer = said(key, "[[1]]");
        assert!(!answer.is_empty() && !answer.contains("unknown key"), "{}: {answer}", key.key);
        for (name, _) in key.choices() {
            let answer = said(key, &format!("\"{name}\""));
            assert!(!answer.contains("expected one of"), "{} = {name}: {answer}", key.key);
        }
        if !key.choices().is_empty() {
            let names: Vec<String> = key.choices().iter().map(|(name, _)| format!("`{name}`")).collect();
            let all = format!("one of {}", names.join(", "));
            if key.key == "functional.NAME.component" {
                // Each kind takes a part of the values.
                let told: Vec<String> = answers(key, "7").filter(|text| text.contains("one of `")).collect();
                assert!(names.iter().all(|name| told.iter().any(|text| text.contains(name))), "{told:?}");
                continue;
            }
            assert!(said(key, "7").contains(&all), "{}: {}", key.key, said(key, "7"));
        }
    }
}

/// A default value that the table gives as such, not in words.
fn literal(key: &Key) -> Option<Value> {
    let is_name = key.choices().iter().any(|(name, _)| *name == key.default);
    let words = ["solid.region", "fluid.region"];
    if is_name || words.contains(&key.key) {
        return Some(Value::String(key.default.into()));
    }
    let value: Value = format!("x = {}", key.default).parse::<Table>().ok()?.remove("x")?;
    Some(value)
}

fn same(a: &Value, b: &Value) -> bool {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|n| n as f64));
    match (a, b) {
        // In space a vector of the table has one component more.
        (Value::Array(a), Value::Array(b)) => {
            let more = b.get(a.len()..).is_some_and(|more| more.iter().all(|x| same(&Value::Float(0.0), x)));
            more && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        _ => a == b || number(a).is_some() && number(a) == number(b),
    }
}

#[test]
fn defaults_of_the_table_are_those_of_reading() {
    let mut seen: BTreeSet<&str> = BTreeSet::new();
    for sets in CASES {
        let case = read(TEXT, sets).unwrap();
        for (dotted, value) in values(&case) {
            let key = find(&dotted).unwrap_or_else(|| panic!("{dotted} is not in the table"));
            let given = sets.iter().any(|set| set.split('=').next() == Some(&dotted))
                || TEXT.parse::<Table>().is_ok_and(|table| {
                    let mut found = BTreeMap::new();
                    flatten("", &table, &mut found);
                    found.contains_key(&dotted)
                });
            let Some(default) = literal(key).filter(|_| !given) else { continue };
            // `time.domain-motion` and the like: the default in a case without settings that change it.
            assert!(same(&default, &value), "{dotted}: {} in the table, {value} in a case", key.default);
            seen.insert(key.key);
        }
    }
    let of_conditions = ["at", "backflow", "stiffness", "damping", "direction", "initial", "profile"];
    let silent = [
        "mesh.leave-out",
        "solid.c2",
        "solid.prestress",
        "initial.velocity",
        "initial.displacement",
        "initial.static",
        "time.rannacher-interval",
    ];
    for key in KEYS.iter() {
        let of_condition =
            key.key.strip_prefix("boundary.NAME.").is_some_and(|last| of_conditions.contains(&last));
        // Those of one of several bodies are the same.
        let plain = ["fluid.", "solid."]
            .iter()
            .fold(key.key.to_string(), |key, kind| key.replacen(&format!("{kind}NAME."), kind, 1));
        let shown = seen.contains(&*plain) || silent.contains(&&*plain) || of_condition;
        let told = literal(key).is_none() || shown;
        assert!(told, "no case shows the default of {}", key.key);
    }
}

/// `none` removes a key, unless it is a value like others.
#[test]
fn none_is_given_where_it_is_no_default() {
    let has_none =
        |key: &&Key| key.choices().iter().any(|(name, _)| *name == "none") && key.default != "none";
    let keys: Vec<&str> = KEYS.iter().copied().filter(has_none).map(|key| key.key).collect();
    assert_eq!(keys, ["stabilization.map", "boundary.NAME.backflow"]);
    let case = read(TEXT, &["space.pressure=Q2", "stabilization.map=none"]).unwrap();
    assert!(case.to_toml().contains("map = \"none\""), "{}", case.to_toml());
}

#[test]
fn unknown_keys_are_answered_with_the_keys_of_the_table() {
    let error = read(TEXT, &["motion.colour=red"]).unwrap_err();
    let keys: Vec<String> = KEYS
        .iter()
        .filter(|key| key.table() == "motion")
        .map(|key| format!("`{}`", key.key.rsplit('.').next().unwrap()))
        .collect();
    assert!(error.ends_with(&format!("[motion] takes {}", keys.join(", "))), "{error}");
    // Those of another kind of functional are left out.
    let error = read(TEXT, &["functional.f.colour=red"]).unwrap_err();
    assert!(
        error.ends_with("[functional.f] takes `kind`, `on`, `method`, `component`, `coefficient`"),
        "{error}"
    );
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { sources(&path, found) } else { found.push(path) }
    }
}

/// A new value of a setting is a row of one table: no other file spells its name.
#[test]
fn names_of_values_are_spelled_in_one_file() {
    let mut files = vec![];
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    // The table of keys names defaults, which another test compares; that of built-in cases names cases, which may have
    // the name of their mesh; tests of a module and comments name what they like.
    files.retain(|file| !file.ends_with("case/keys.rs") && !file.ends_with("case/builtin.rs"));
    let texts: Vec<(PathBuf, String)> = files
        .into_iter()
        .map(|file| {
            let text = fs::read_to_string(&file).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap();
            let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
            (file, lines.collect::<Vec<_>>().join("\n"))
        })
        .collect();
    let short = [
        "bdf2",
        "esdirk3",
        "esdirk4",
        "cg1",
        "rannacher",
        "harmonic",
        "biharmonic",
        "pspg",
        "supg",
        "reduced",
        "condensed",
        "lagged",
    ];
    let mut checked = 0;
    for (name, _) in KEYS.iter().flat_map(|key| key.choices()) {
        // A label of the comparison of Jacobians has this name, too.
        if name == "finite-difference" || !(name.contains('-') || short.contains(&name)) {
            continue;
        }
        let quoted = format!("\"{name}\"");
        let places: Vec<&PathBuf> =
            texts.iter().filter(|(_, text)| text.contains(&quoted)).map(|(file, _)| file).collect();
        assert_eq!(places.len(), 1, "{name}: {places:?}");
        checked += 1;
    }
    assert!(checked > 30, "{checked} names");
}
