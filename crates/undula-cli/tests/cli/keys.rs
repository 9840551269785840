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
