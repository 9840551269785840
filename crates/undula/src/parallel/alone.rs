//! A process without others.

use super::comm::{Comm, Fault, Message};

/// The only process of a run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Alone;

impl Comm for Alone {
    fn rank(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        1
    }

    fn barrier(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    fn broadcast(&mut self, _root: usize, _values: &mut [f64]) -> Result<(), Fault> {
        Ok(())
    }

    fn all_gather(&mut self, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        Ok(vec![values.to_vec()])
    }

    /// What it sends to itself arrives in the same order.
    fn exchange(&mut self, sent: &[Message], received: &mut [Message]) -> Result<(), Fault> {
        if sent.len() != received.len() {
            return Err(Fault::Mismatch(received.len(), sent.len()));
        }
        for (from, to) in sent.iter().zip(received) {
            if from.values.len() != to.values.len() {
                return Err(Fault::Mismatch(to.values.len(), from.values.len()));
            }
            to.values.copy_from_slice(&from.values);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::Reduce;

    #[test]
    fn one_process_is_all() {
        let mut comm = Alone;
        assert!((comm.rank(), comm.size(), comm.is_first()) == (0, 1, true));
        let mut values = [1.5, -2.0];
        comm.broadcast(0, &mut values).unwrap();
        for how in [Reduce::Sum, Reduce::Min, Reduce::Max] {
            comm.reduce(how, &mut values).unwrap();
        }
        assert_eq!(values, [1.5, -2.0]);
        assert_eq!(comm.all_gather_lists(&values).unwrap(), [vec![1.5, -2.0]]);
        assert_eq!((comm.sum(3.0), comm.all(false), comm.offset(7)), (Ok(3.0), Ok(false), Ok([0, 7])));
        let message = |values: &[f64]| vec![Message { rank: 0, values: values.to_vec() }];
        let mut received = message(&[0.0; 2]);
        comm.exchange(&message(&[1.0, 2.0]), &mut received).unwrap();
        assert_eq!(received, message(&[1.0, 2.0]));
        assert_eq!(comm.exchange(&message(&[1.0]), &mut received), Err(Fault::Mismatch(2, 1)));
    }

    #[test]
    fn a_number_that_is_none_is_never_lost() {
        for how in [Reduce::Sum, Reduce::Min, Reduce::Max] {
            assert!(how.of(f64::NAN, 1.0).is_nan() && how.of(1.0, f64::NAN).is_nan(), "{how:?}");
        }
        assert_eq!((Reduce::Min.of(1.0, -2.0), Reduce::Max.of(1.0, -2.0)), (-2.0, 1.0));
    }
}
