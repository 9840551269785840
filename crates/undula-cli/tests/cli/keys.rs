//! `undula keys`.

use super::*;

fn keys(arguments: &str) -> Said {
    Place::new(&format!("keys-{}", arguments.replace([' ', '.', '*'], "-")))
        .run(&format!("keys {arguments}"), &[])
}

#[test]
fn all_keys_are_listed_in_lines_of_120_characters() {
    let said = keys("").expect(0, &["time.scheme", "boundary.NAME.condition", "= bdf2", "kg/m³"]);
    let long: Vec<&str> = said.out.lines().filter(|line| line.chars().count() > 120).collect();
    assert!(long.is_empty(), "{long:#?}");
    // Columns stand below each other.
    let meaning = said.out.lines().next().unwrap().find("meaning").unwrap();
    for line in said.out.lines() {
        let letters: Vec<char> = line.chars().collect();
        assert!(letters[meaning - 1] == ' ' && letters[meaning] != ' ', "{line}");
    }
}

#[test]
fn a_table_a_key_and_a_value_are_found() {
    let said = keys("motion").expect(0, &["motion.model", "= biharmonic", "from the mesh", "motion.walls"]);
    assert!(
        said.out.lines().skip(1).all(|l| l.starts_with("motion.") || l.starts_with("  ")),
        "{}",
        said.out
    );
    let said = keys("time.scheme").expect(0, &["shifted-crank-nicolson", "= stationary", "= cg1"]);
    assert_eq!(said.out.matches("time.").count(), 1, "{}", said.out);
    let said = keys("faer").expect(0, &["linear.solver", "= faer"]);
    assert!(!said.out.contains("= multifrontal"), "{}", said.out);
    keys("*.step").expect(0, &["time.step"]);
    keys("dt").expect(0, &["time.step"]);
}

#[test]
fn what_matches_nothing_is_bad_input() {
    keys("nonsense")
        .expect(2, &["no key, table or value matches `nonsense`; ", " `undula keys` lists all keys"]);
    keys("time.schem*x").expect(2, &["did you mean `time.scheme`?"]);
    keys("motoin").expect(2, &["did you mean `motion`?"]);
}

/// `cargo run -- keys --markdown > docs/keys.md` writes the page anew.
#[test]
fn the_page_of_all_keys_is_up_to_date() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/keys.md");
    let (said, page) = (keys("--markdown").expect(0, &[]).out, fs::read_to_string(page).unwrap());
    for (line, printed) in page.lines().zip(said.lines()) {
        assert_eq!(line, printed, "docs/keys.md");
    }
    assert!(page == said, "docs/keys.md");
}

#[test]
fn a_reader_may_leave_early() {
    let mut child = Place::new("keys-head")
        .command("keys", &[])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let said = Said::of(child.wait_with_output().unwrap());
    assert_eq!((said.code, said.err.as_str()), (Some(0), ""));
}

/// What is wrong with `value` by `schema`, of which this knows what the schema of cases has.
fn wrong(schema: &Value, value: &Value, place: &str) -> Option<String> {
    let any = |schemas: &Value| {
        let tried: Vec<_> = schemas.as_array().unwrap().iter().map(|s| wrong(s, value, place)).collect();
        tried.iter().all(Option::is_some).then(|| format!("{place}: none of them: {value}"))
    };
    if let Some(schemas) = schema.get("anyOf") {
        return any(schemas);
    }
    if let Some(constant) = schema.get("const") {
        return (constant != value).then(|| format!("{place}: {value} is not {constant}"));
    }
    let kind = match value {
        Value::Object(_) => "object",
        Value::Array(_) => "array",
        Value::String(_) => "string",
        Value::Bool(_) => "boolean",
        _ => "number",
    };
    let types = &schema["type"];
    if types != kind && !types.as_array().is_some_and(|all| all.iter().any(|t| t == kind)) {
        return Some(format!("{place}: {kind} instead of {types}"));
    }
    if let (Some(items), Some(all)) = (schema.get("items"), value.as_array()) {
        return all.iter().find_map(|item| wrong(items, item, place));
    }
    let (Some(properties), Some(entries)) = (schema.get("properties"), value.as_object()) else {
        return None;
    };
    entries.iter().find_map(|(name, entry)| {
        let place = format!("{place}.{name}");
        match (properties.get(name), &schema["additionalProperties"]) {
            (Some(schema), _) => wrong(schema, entry, &place),
            (None, Value::Bool(false)) => Some(format!("{place} is unknown")),
            (None, schema) => wrong(schema, entry, &place),
        }
    })
}

#[test]
fn the_schema_accepts_all_built_in_cases_and_finds_wrong_keys() {
    let schema: Value = serde_json::from_str(&keys("--schema").expect(0, &["bdf2", "kg/m³"]).out).unwrap();
    let case = |text: &str| -> Value { toml::from_str(text).unwrap() };
    for builtin in undula::case::builtin::builtin_cases() {
        assert_eq!(wrong(&schema, &case(builtin.toml), builtin.name), None);
        let resolved =
            undula::case::Case::from_toml(builtin.toml, builtin.name, &[]).unwrap().resolved().to_toml();
        assert_eq!(wrong(&schema, &case(&resolved), builtin.name), None);
    }
    for (text, part) in [
        ("[time]\nstepp = 0.1", "time.stepp is unknown"),
        ("[boundary.inflow]\ncondition = \"no-split\"", "boundary.inflow.condition"),
        ("[boundary.inflow]\ncond = 1", "boundary.inflow.cond is unknown"),
        ("time = 3", "time: number"),
    ] {
        let found = wrong(&schema, &case(text), "").unwrap_or_default();
        assert!(found.contains(part), "{text}: {found}");
    }
}

#[test]
fn completions_and_manual_pages_know_all_commands() {
    let here = Place::new("shell");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        here.run(&format!("completions {shell}"), &[]).expect(0, &["reproduce", "report", "quiet"]);
    }
    here.run("completions tcsh", &[]).expect(2, &["bash"]);
    here.run("man pages", &[]).expect(0, &["pages"]);
    assert!(here.read("pages/undula.1").contains("Exit codes"));
    assert!(here.read("pages/undula-run.1").contains("threads"));
    assert!(here.read("pages/undula-plot.1").contains("animated PNG"));
}

#[test]
fn words_of_the_output_and_keys_are_explained() {
    let here = Place::new("explain");
    let explain = |word: &str| here.run(&format!("explain {word}"), &[]);
    explain("force_time").expect(0, &["history.csv", "t⁻ + θk"]);
    explain("folding").expect(0, &["breakdown", "biharmonic"]);
    explain("time.step").expect(0, &["step"]);
    // A word of both.
    explain("backflow").expect(0, &["outlet", "boundary.NAME.backflow"]);
    explain("foldin").expect(2, &["did you mean `folding`"]);
    explain("qwertzu").expect(2, &["nothing is known", "undula keys"]);
    // Every column and every name of a summary, and every cause of a breakdown.
    here.run("run fsi3 -o out --quiet", &SMALL).expect(0, &[]);
    let history = here.read("out/history.csv");
    let columns = ["time", "force_time", "min_J", "newton_steps", "jacobians"];
    for column in columns {
        assert!(history.lines().next().unwrap().split(',').any(|name| name == column), "{column}");
    }
    let names = [
        "mass_balance",
        "swept_volume",
        "linear_iterations",
        "direct_fallbacks",
        "largest_factor_unknowns",
        "cpu_seconds",
        "phases",
    ];
    let summary = here.json("out/summary.json");
    for name in names {
        assert!(summary.get(name).is_some(), "{name}");
    }
    let causes = ["folding", "divergence", "slow", "singular", "not-finite", "solver", "backflow", "closed"];
    for word in columns.iter().chain(&names).chain(&causes) {
        explain(word).expect(0, &[]);
    }
}
