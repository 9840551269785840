use super::*;
use crate::output::testing::scratch;

fn with_status(path: &Path, status: Status) {
    Summary { status, ..Summary::default() }.write(path.join("summary.json")).unwrap();
}

#[test]
fn completed_runs_are_replaced_with_force_and_only_their_own_files_go() {
    let directory = scratch("directory-replace");
    let path = directory.join("deep/run");
    let run = RunDirectory::create(&path, false).unwrap();
    run.write_case("a = 1").unwrap();
    write_atomic(path.join(run.field_name(3)), |f| f.write_all(b"x")).unwrap();
    fs::write(path.join("notes.txt"), "mine").unwrap();
    fs::write(path.join("fields/state.pvsm"), "mine").unwrap();
    with_status(&path, Status::Completed);
    drop(run);
    assert!(!path.join(".lock").exists());
    let message = RunDirectory::create(&path, false).unwrap_err().to_string();
    assert!(message.contains("holds a completed run") && message.contains("--force"), "{message}");
    assert!(path.join("case.toml").exists() && !path.join(".lock").exists());
    let run = RunDirectory::create(&path, true).unwrap();
    assert!(!run.case().exists() && !path.join(run.field_name(3)).exists());
    assert!(path.join("notes.txt").exists() && path.join("fields/state.pvsm").exists());
    assert_eq!(Summary::read(run.summary()).unwrap().status, Status::Running);
}

#[test]
fn unfinished_runs_need_force_or_resume() {
    for status in [Status::Running, Status::Interrupted, Status::Failed, Status::Breakdown] {
        let path = scratch("directory-unfinished");
        fs::write(path.join("case.toml"), "kept").unwrap();
        with_status(&path, status);
        let message = RunDirectory::create(&path, false).unwrap_err().to_string();
        assert!(message.contains("--resume") && message.contains("--force"), "{message}");
        assert!(message.contains(&status.to_string()), "{message}");
        assert_eq!(fs::read_to_string(path.join("case.toml")).unwrap(), "kept");
        drop(RunDirectory::open_for_resume(&path, false).unwrap());
        drop(RunDirectory::create(&path, true).unwrap());
        assert!(!path.join("case.toml").exists());
    }
}

#[test]
fn completed_runs_are_not_resumed_and_empty_directories_hold_no_run() {
    let path = scratch("directory-completed");
    assert!(matches!(RunDirectory::open_for_resume(&path, false), Err(OutputError::NoRun { .. })));
    fs::write(path.join("case.toml"), "").unwrap();
    with_status(&path, Status::Completed);
    assert!(matches!(RunDirectory::open_for_resume(&path, false), Err(OutputError::AlreadyCompleted { .. })));
}

#[test]
fn foreign_directories_and_files_are_refused_even_with_force() {
    let path = scratch("directory-foreign");
    fs::write(path.join("thesis.tex"), "years of work").unwrap();
    for force in [false, true] {
        let error = RunDirectory::create(&path, force).unwrap_err();
        assert!(matches!(error, OutputError::Foreign { .. }), "{error}");
        assert!(error.to_string().contains("thesis.tex"));
        assert!(RunDirectory::create(path.join("thesis.tex"), force).is_err());
    }
    fs::write(path.join("summary.json"), "{\"title\": \"of something else\"}").unwrap();
    assert!(matches!(RunDirectory::create(&path, true), Err(OutputError::Foreign { .. })));
    assert_eq!(fs::read_dir(&path).unwrap().count(), 2);
}

#[test]
fn a_directory_has_one_writer() {
    let path = scratch("directory-busy");
    let first = RunDirectory::create(&path, false).unwrap();
    assert!(matches!(RunDirectory::create(&path, true), Err(OutputError::Busy { .. })));
    drop(first);
    RunDirectory::create(&path, true).unwrap();
}

/// Many threads that create, hold and leave one directory: never two at once.
#[test]
fn the_lock_cannot_be_had_twice() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let path = scratch("directory-race");
    let (holders, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let begun = std::time::Instant::now();
                while begun.elapsed().as_millis() < 300 {
                    match RunDirectory::locked(&path) {
                        Ok(run) => {
                            assert_eq!(holders.fetch_add(1, Ordering::SeqCst), 0, "two have the lock");
                            taken.fetch_add(1, Ordering::SeqCst);
                            holders.fetch_sub(1, Ordering::SeqCst);
                            drop(run);
                        }
                        Err(OutputError::Busy { .. }) => {}
                        Err(error) => panic!("{error}"),
                    }
                }
            });
        }
    });
    assert!(taken.into_inner() > 10);
    assert!(!path.join(".lock").exists());
}

#[cfg(unix)]
#[test]
fn a_directory_that_is_gone_is_noticed_and_another_one_is_left_alone() {
    let directory = scratch("directory-gone");
    let path = directory.join("run");
    let run = RunDirectory::create(&path, false).unwrap();
    run.verify().unwrap();
    fs::rename(&path, directory.join("elsewhere")).unwrap();
    let message = run.verify().unwrap_err().to_string();
    assert!(message.contains("removed, moved or changed"), "{message}");
    let other = RunDirectory::create(&path, false).unwrap();
    assert!(run.verify().is_err() && other.verify().is_ok());
    drop(run);
    assert!(path.join(".lock").exists(), "the lock of the other run");
}

#[test]
fn unwritable_places_give_their_name() {
    // Below a file nothing can be created, whoever runs the test.
    let directory = scratch("directory-unwritable");
    let path = directory.join("file");
    fs::write(&path, "").unwrap();
    let message = RunDirectory::create(path.join("run"), false).unwrap_err().to_string();
    assert!(message.contains("file") && message.contains("cannot create directory"), "{message}");
}
