//! `--log json`: all of standard error for programs.

use super::{Place, SMALL, Said};
use serde_json::Value;

/// The events of standard error, every line of which is one.
fn events(said: &Said) -> Vec<Value> {
    said.err
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}")))
        .collect()
}

fn named<'a>(events: &'a [Value], name: &str) -> Vec<&'a Value> {
    events.iter().filter(|event| event["event"] == name).collect()
}

#[test]
fn every_line_of_a_run_is_an_event_and_the_numbers_are_those_of_its_files() {
    let here = Place::new("log");
    let krylov = [&SMALL[..], &["linear.krylov=gmres"]].concat();
    let said = here.run("run csm3 -o out --log json", &krylov).expect(0, &[]);
    assert!(said.out.contains("results"), "{}", said.out);
    let events = events(&said);
    assert_eq!((&events[0]["event"], &events[events.len() - 1]["event"]), (&"start".into(), &"end".into()));
    let (start, end) = (&events[0], &events[events.len() - 1]);
    let summary = here.json("out/summary.json");
    assert_eq!(start["unknowns"], summary["unknowns"]);
    assert_eq!(start["end"], 0.05);
    for key in ["status", "steps", "newton_steps", "jacobians", "linear_iterations", "wall_seconds"] {
        assert_eq!(end[key], summary[key], "{key}");
    }
    let steps = named(&events, "step");
    let history = here.read("out/history.csv");
    let mut lines = history.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let columns = lines.next().unwrap();
    for (step, line) in steps.iter().zip(lines) {
        for (column, text) in columns.iter().zip(line) {
            let value = if step[column].is_null() { &step["values"][column] } else { &step[column] };
            assert_eq!(value.as_f64(), text.parse().ok(), "{column}");
        }
    }
    let sum = |key: &str| steps.iter().map(|step| step[key].as_u64().unwrap()).sum::<u64>();
    assert_eq!(steps.len(), 5);
    for key in ["newton_steps", "jacobians", "linear_iterations", "factorizations"] {
        assert_eq!(Some(sum(key)), summary[key].as_u64(), "{key}");
    }
    assert!(sum("linear_iterations") > 0);
    assert!(steps.iter().all(|step| (1e-12..1.0).contains(&step["rate"].as_f64().unwrap())));
    assert!(steps.iter().all(|step| step["seconds"].as_f64().unwrap() > 0.0));
}

#[test]
fn notes_mistakes_and_breakdowns_are_events_too() {
    let here = Place::new("log-events");
    let said =
        here.run("run csm3 -o wrong --log json", &["solid.density=-1", "time.step=oops"]).expect(2, &[]);
    let wrong = events(&said);
    assert_eq!(wrong.len(), 1);
    assert!(
        wrong[0]["event"] == "error" && wrong[0]["text"].as_str().unwrap().contains("2 mistakes"),
        "{wrong:?}"
    );
    // A setting without effect is noted; a beam that is loaded too much breaks down.
    let heavy = ["mesh.refine=0", "solid.body-force=[0,-1e9]", "time.max-halvings=0", "newton.max-steps=3"];
    let said = here.run("run csm3 -o out --log json --quiet", &heavy).expect(3, &[]);
    let events = events(&said);
    assert!(said.out.is_empty(), "{}", said.out);
    assert_eq!(named(&events, "end")[0]["status"], "breakdown");
    assert!(named(&events, "breakdown")[0]["text"].as_str().unwrap().contains("no solution for the step"));
    // Text for people as before.
    here.run("run csm3 -o text --quiet --log text", &heavy)
        .expect(3, &["breakdown: no solution for the step"]);
}
