//! A process that has failed does not wait for ever for others that wait for it elsewhere, in a call of PETSc.

use crate::error::Error;
use crate::parallel::Team;
use std::process::exit;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

/// How long a process that has failed waits for the others: where one alone has failed they do not come.
const PATIENCE: Duration = Duration::from_secs(120);

/// Does something after a while, unless it is dropped before.
pub(super) struct Watch {
    _ends: Sender<()>,
}

impl Watch {
    /// Will `act` after `patience`.
    fn new(patience: Duration, act: impl FnOnce() + Send + 'static) -> Watch {
        let (ends, told) = channel();
        thread::spawn(move || {
            if told.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                act();
            }
        });
        Watch { _ends: ends }
    }

    /// For a process of several that has failed with `error`: it says so and ends, and the launcher ends the others with it.
    pub(super) fn of(team: &Team, error: &Error) -> Option<Watch> {
        let (rank, size, code) = (team.rank(), team.size(), error.exit_code());
        let text = format!(
            "error: process {rank} of {size}: {error}; the others have not come within {} s, so that all are ended: the last \
             checkpoint is kept",
            PATIENCE.as_secs()
        );
        let ends = move || {
            eprintln!("{text}");
            exit(i32::from(code.max(1)));
        };
        (size > 1).then(|| Watch::new(PATIENCE, ends))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_watch_acts_unless_it_is_dropped() {
        let (tell, told) = channel();
        let acted = |patience: u64, keep: u64| {
            let tell = tell.clone();
            let watch = Watch::new(Duration::from_millis(patience), move || tell.send(()).unwrap());
            thread::sleep(Duration::from_millis(keep));
            drop(watch);
            told.recv_timeout(Duration::from_millis(300)).is_ok()
        };
        assert!(acted(5, 200) && !acted(400, 5));
    }
}
