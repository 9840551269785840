//! The processes that share a mesh: one handle for all that need numbers of the others.

use super::comm::{Comm, Fault, Message, Reduce};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// The processes that share a mesh. All calls are made by all of them, in the same order.
///
/// What MPI refuses makes numbers NaN: the step then ends, and the processes hear of it when they agree on the next one.
#[derive(Clone)]
pub struct Crew {
    rank: usize,
    size: usize,
    inner: Arc<Mutex<Inner>>,
}

struct Inner {
    comm: Box<dyn Comm>,
    traffic: Traffic,
}

/// What a process has had to do with others.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Time in calls of MPI: waiting, mostly \[s\].
    pub seconds: f64,
    /// Bytes sent for copies of unknowns.
    pub bytes: f64,
    /// Messages that these took.
    pub messages: f64,
}

impl fmt::Debug for Crew {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Crew").field("rank", &self.rank).field("size", &self.size).finish_non_exhaustive()
    }
}

impl Crew {
    /// Of those that `comm` connects.
    pub fn new(comm: impl Comm + 'static) -> Crew {
        let (rank, size) = (comm.rank(), comm.size());
        let inner = Inner { comm: Box::new(comm), traffic: Traffic::default() };
        Crew { rank, size, inner: Arc::new(Mutex::new(inner)) }
    }

    /// Number of this process.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// How many there are.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Calls of MPI, by one thread at a time.
    ///
    /// # Errors
    /// As the calls.
    pub fn with<T>(&self, act: impl FnOnce(&mut dyn Comm) -> Result<T, Fault>) -> Result<T, Fault> {
        let mut inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let start = Instant::now();
        let result = act(&mut *inner.comm);
        inner.traffic.seconds += start.elapsed().as_secs_f64();
        result
    }

    /// Counts messages of so many bytes in all.
    pub(super) fn count(&self, messages: usize, bytes: usize) {
        let traffic = &mut self.inner.lock().unwrap_or_else(PoisonError::into_inner).traffic;
        traffic.bytes += bytes as f64;
        traffic.messages += messages as f64;
    }

    /// What this process has had to do with the others.
    pub fn traffic(&self) -> Traffic {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner).traffic
    }

    /// Each number becomes that of all; NaN where MPI fails.
    pub fn reduce(&self, how: Reduce, values: &mut [f64]) {
        if self.with(|comm| comm.reduce(how, values)).is_err() {
            values.fill(f64::NAN);
        }
    }

    /// The number of all.
    pub fn one(&self, how: Reduce, value: f64) -> f64 {
        let mut values = [value];
        self.reduce(how, &mut values);
        values[0]
    }

    /// The lists of all, by rank.
    ///
    /// # Errors
    /// If MPI fails.
    pub fn lists(&self, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        self.with(|comm| comm.all_gather_lists(values))
    }

    /// The lists of all on process 0, by rank; none on the others.
    ///
    /// # Errors
    /// If MPI fails.
    pub fn collect(&self, values: Vec<f64>) -> Result<Vec<Vec<f64>>, Fault> {
        let (rank, size) = (self.rank, self.size);
        self.with(|comm| {
            let lengths = comm.all_gather(&[values.len() as f64])?;
            if rank > 0 {
                comm.exchange(&[Message { rank: 0, values }], &mut [])?;
                return Ok(vec![]);
            }
            let empty = |rank: usize| Message { rank, values: vec![0.0; lengths[rank][0] as usize] };
            let mut received: Vec<Message> = (1..size).map(empty).collect();
            comm.exchange(&[], &mut received)?;
            Ok([values].into_iter().chain(received.into_iter().map(|message| message.values)).collect())
        })
    }

    /// The number of process 0, on all.
    ///
    /// # Errors
    /// If MPI fails.
    pub fn told(&self, number: f64) -> Result<f64, Fault> {
        let mut numbers = [number];
        self.with(|comm| comm.broadcast(0, &mut numbers))?;
        Ok(numbers[0])
    }
}
