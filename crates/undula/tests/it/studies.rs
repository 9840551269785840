//! The studies of the book: what does not need their runs.

use std::path::Path;
use undula::study::{Study, chapter};

#[test]
fn all_cases_and_expressions_of_the_chapter_are_sound() {
    for (name, text) in chapter() {
        let study = Study::from_toml(text, name).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(study.name, *name);
        for quick in [false, true] {
            let jobs = study.jobs(quick, Path::new(""), name).unwrap_or_else(|e| panic!("{e}"));
            study.check(&jobs, name).unwrap_or_else(|e| panic!("{e}"));
            assert!(jobs.iter().any(|job| !job.left_out), "{name}");
        }
        for statement in &study.statement {
            assert!(
                !statement.text.is_empty() && !statement.section.is_empty() && !statement.holds.is_empty()
            );
        }
        assert!(text.lines().all(|line| line.chars().count() <= 120), "{name} has long lines");
    }
}
