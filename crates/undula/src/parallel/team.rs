//! What the processes of a run agree on, step by step.

use super::alone::Alone;
use super::comm::{Comm, Fault};
use super::crew::Crew;

/// What a process would do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// The next step.
    GoOn,
    /// End as after an interruption.
    Stop,
    /// End, since something went wrong, with this exit code.
    Fail(u8),
}

/// What all do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agreed {
    /// The next step.
    GoOn,
    /// End as after an interruption: at least one wants to.
    Stop,
    /// End; the `first` of those where something went wrong says why.
    Fail {
        /// Its rank.
        first: usize,
        /// Its exit code.
        code: u8,
    },
}

impl Wish {
    fn number(self) -> f64 {
        match self {
            Wish::GoOn => 0.0,
            Wish::Stop => -1.0,
            Wish::Fail(code) => f64::from(code.max(1)),
        }
    }
}

/// The processes of a run. Each has the whole state and takes every step; of the linear systems each solves its share.
/// The first one writes the files.
pub struct Team {
    comm: Box<dyn Comm>,
    crew: Option<Crew>,
}

impl Team {
    /// Of those that `comm` connects.
    pub fn new(comm: impl Comm + 'static) -> Team {
        Team { comm: Box::new(comm), crew: None }
    }

    /// With a handle of the same processes for those parts of a run that share a mesh.
    #[must_use]
    pub fn with_crew(self, crew: Crew) -> Team {
        Team { crew: Some(crew), ..self }
    }

    /// That handle, if there is one.
    pub fn crew(&self) -> Option<&Crew> {
        self.crew.as_ref()
    }

    /// A process without others.
    pub fn alone() -> Team {
        Team::new(Alone)
    }

    /// Number of this process.
    pub fn rank(&self) -> usize {
        self.comm.rank()
    }

    /// How many there are.
    pub fn size(&self) -> usize {
        self.comm.size()
    }

    /// Whether this one writes files and speaks.
    pub fn is_first(&self) -> bool {
        self.comm.is_first()
    }

    /// What all do next.
    ///
    /// # Errors
    /// If MPI fails.
    pub fn agree(&mut self, wish: Wish) -> Result<Agreed, Fault> {
        let wishes = self.comm.all_gather(&[wish.number()])?;
        let numbers = || wishes.iter().map(|wish| wish[0]);
        if let Some((first, code)) = numbers().enumerate().find(|(_, number)| *number > 0.0) {
            return Ok(Agreed::Fail { first, code: code as u8 });
        }
        Ok(if numbers().any(|number| number < 0.0) { Agreed::Stop } else { Agreed::GoOn })
    }

    /// The number of the first process, on all.
    ///
    /// # Errors
    /// If MPI fails.
    pub fn told(&mut self, number: f64) -> Result<f64, Fault> {
        let mut numbers = [number];
        self.comm.broadcast(0, &mut numbers)?;
        Ok(numbers[0])
    }

    /// The first process that has other `numbers` than process 0; the same length everywhere.
    ///
    /// # Errors
    /// If MPI fails.
    pub fn differing(&mut self, numbers: &[f64]) -> Result<Option<usize>, Fault> {
        let all = self.comm.all_gather(numbers)?;
        let bits = |list: &[f64]| list.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
        Ok(all.iter().position(|list| bits(list) != bits(&all[0])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::Message;

    /// The second of three processes, the others of which say what they always say.
    struct Played(Vec<f64>);

    impl Comm for Played {
        fn rank(&self) -> usize {
            1
        }
        fn size(&self) -> usize {
            3
        }
        fn barrier(&mut self) -> Result<(), Fault> {
            Ok(())
        }
        fn broadcast(&mut self, _: usize, _: &mut [f64]) -> Result<(), Fault> {
            Ok(())
        }
        fn all_gather(&mut self, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
            Ok(vec![vec![self.0[0]], values.to_vec(), vec![self.0[1]]])
        }
        fn exchange(&mut self, _: &[Message], _: &mut [Message]) -> Result<(), Fault> {
            Ok(())
        }
    }

    #[test]
    fn one_that_fails_or_stops_decides_for_all() {
        let agreed = |others: [f64; 2], wish: Wish| Team::new(Played(others.to_vec())).agree(wish).unwrap();
        assert_eq!(agreed([0.0, 0.0], Wish::GoOn), Agreed::GoOn);
        assert_eq!(agreed([0.0, -1.0], Wish::GoOn), Agreed::Stop);
        assert_eq!(agreed([0.0, 0.0], Wish::Stop), Agreed::Stop);
        assert_eq!(agreed([-1.0, 3.0], Wish::GoOn), Agreed::Fail { first: 2, code: 3 });
        assert_eq!(agreed([0.0, 3.0], Wish::Fail(2)), Agreed::Fail { first: 1, code: 2 });
        assert_eq!(Team::alone().agree(Wish::Fail(0)), Ok(Agreed::Fail { first: 0, code: 1 }));
    }

    #[test]
    fn processes_that_differ_are_found() {
        let differing =
            |others: [f64; 2], own: f64| Team::new(Played(others.to_vec())).differing(&[own]).unwrap();
        assert_eq!(differing([1.0, 1.0], 1.0), None);
        assert_eq!(differing([1.0, 1.0], 2.0), Some(1));
        assert_eq!(differing([1.0, 2.0], 1.0), Some(2));
    }
}
