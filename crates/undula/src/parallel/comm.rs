//! What a process knows of those that compute with it.

/// Why processes did not come together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// A call of MPI that failed.
    #[error("{function} of MPI returns error {code}")]
    Call {
        /// The function.
        function: &'static str,
        /// What it returned.
        code: i32,
    },
    /// More bytes than MPI counts in a call.
    #[error("a message of {0} bytes is too long: MPI counts to 2147483647")]
    Length(usize),
    /// Processes that disagree on what comes next.
    #[error("{0} numbers were expected of a process, and {1} came")]
    Mismatch(usize, usize),
    /// No MPI, or one that cannot be used.
    #[error("no MPI: {0}")]
    Missing(String),
}

/// Numbers for another process.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// From whom, or for whom.
    pub rank: usize,
    /// What is said; its length is known to both.
    pub values: Vec<f64>,
}

/// How numbers of all processes become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reduce {
    /// Added, in the order of the ranks.
    Sum,
    /// The least; NaN if one is NaN.
    Min,
    /// The largest; NaN if one is NaN.
    Max,
}

impl Reduce {
    pub(super) fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Reduce::Sum => a + b,
            _ if a.is_nan() || b.is_nan() => f64::NAN,
            Reduce::Min => a.min(b),
            Reduce::Max => a.max(b),
        }
    }
}

/// The processes of a run, as one of them sees them. All calls but those of one process alone are made by all, in the
/// same order.
pub trait Comm: Send {
    /// Number of this process, from 0 on.
    fn rank(&self) -> usize;

    /// How many there are.
    fn size(&self) -> usize;

    /// Whether this one speaks for all.
    fn is_first(&self) -> bool {
        self.rank() == 0
    }

    /// Waits for all.
    ///
    /// # Errors
    /// As all others: if MPI fails.
    fn barrier(&mut self) -> Result<(), Fault>;

    /// The numbers of `root` on all; the same length everywhere.
    ///
    /// # Errors
    /// See [`Comm::barrier`].
    fn broadcast(&mut self, root: usize, values: &mut [f64]) -> Result<(), Fault>;

    /// The numbers of all, by rank, on all; the same length everywhere.
    ///
    /// # Errors
    /// See [`Comm::barrier`].
    fn all_gather(&mut self, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault>;

    /// As [`Comm::all_gather`] where the lengths differ.
    ///
    /// # Errors
    /// See [`Comm::barrier`].
    fn all_gather_lists(&mut self, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        let lengths = self.all_gather(&[values.len() as f64])?;
        let longest = lengths.iter().map(|length| length[0] as usize).max().unwrap_or(0);
        let mut padded = values.to_vec();
        padded.resize(longest, 0.0);
        let mut lists = self.all_gather(&padded)?;
        lists.iter_mut().zip(&lengths).for_each(|(list, length)| list.truncate(length[0] as usize));
        Ok(lists)
    }

    /// Numbers to neighbours and from them: `received` has the lengths before, and the values after. Who sends to whom is
    /// known on both sides.
    ///
    /// # Errors
    /// See [`Comm::barrier`].
    fn exchange(&mut self, sent: &[Message], received: &mut [Message]) -> Result<(), Fault>;

    /// Each number becomes that of all, in the order of the ranks: the same bits on all.
    ///
    /// # Errors
    /// See [`Comm::barrier`].
    fn reduce(&mut self, how: Reduce, values: &mut [f64]) -> Result<(), Fault> {
        let all = self.all_gather(values)?;
        for (i, value) in values.iter_mut().enumerate() {
            let of_all = all.iter().map(|list| list[i]);
            *value = of_all.reduce(|a, b| how.of(a, b)).unwrap_or(*value);
        }
        Ok(())
    }

    /// Sum of one number of each.
    ///
    /// # Errors
    /// See [`Comm::barrier`].
    fn sum(&mut self, value: f64) -> Result<f64, Fault> {
        let mut values = [value];
        self.reduce(Reduce::Sum, &mut values)?;
        Ok(values[0])
    }

    /// Whether it holds on all.
    ///
    /// # Errors
    /// See [`Comm::barrier`].
    fn all(&mut self, holds: bool) -> Result<bool, Fault> {
        let mut values = [f64::from(u8::from(holds))];
        self.reduce(Reduce::Min, &mut values)?;
        Ok(values[0] > 0.0)
    }

    /// Σ of the counts of the processes before this one, and of all: where its own numbers begin.
    ///
    /// # Errors
    /// See [`Comm::barrier`].
    fn offset(&mut self, count: usize) -> Result<[usize; 2], Fault> {
        let counts = self.all_gather(&[count as f64])?;
        let sum = |of: &[Vec<f64>]| of.iter().map(|count| count[0] as usize).sum();
        Ok([sum(&counts[..self.rank()]), sum(&counts)])
    }
}
