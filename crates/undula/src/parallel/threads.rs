//! Processes that are threads of one, for tests.

use super::comm::{Comm, Fault, Message};
use std::sync::mpsc::{Receiver, Sender, channel};

/// One of several threads that talk like processes.
pub struct Thread {
    rank: usize,
    to: Vec<Sender<Vec<f64>>>,
    from: Vec<Receiver<Vec<f64>>>,
}

/// What `work` gives on each of `n` threads.
pub fn together<T: Send>(n: usize, work: impl Fn(Thread) -> T + Sync) -> Vec<T> {
    let (mut to, mut from): (Vec<Vec<_>>, Vec<Vec<_>>) = Default::default();
    to.resize_with(n, Vec::new);
    from.resize_with(n, Vec::new);
    for sender in &mut to {
        for receiver in &mut from {
            let (send, receive) = channel();
            sender.push(send);
            receiver.push(receive);
        }
    }
    let threads = to.into_iter().zip(from).enumerate();
    let threads: Vec<Thread> = threads.map(|(rank, (to, from))| Thread { rank, to, from }).collect();
    std::thread::scope(|scope| {
        let work = &work;
        let running: Vec<_> = threads.into_iter().map(|one| scope.spawn(move || work(one))).collect();
        running.into_iter().map(|one| one.join().expect("a thread that ends")).collect()
    })
}

impl Thread {
    fn send(&self, rank: usize, values: &[f64]) -> Result<(), Fault> {
        self.to[rank].send(values.to_vec()).map_err(|_| Fault::Missing("a thread has ended".into()))
    }

    fn receive(&self, rank: usize) -> Result<Vec<f64>, Fault> {
        self.from[rank].recv().map_err(|_| Fault::Missing("a thread has ended".into()))
    }
}

impl Comm for Thread {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn barrier(&mut self) -> Result<(), Fault> {
        self.all_gather(&[]).map(|_| ())
    }

    fn broadcast(&mut self, root: usize, values: &mut [f64]) -> Result<(), Fault> {
        let all = self.all_gather(values)?;
        values.copy_from_slice(&all[root]);
        Ok(())
    }

    fn all_gather(&mut self, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        (0..self.size()).try_for_each(|rank| self.send(rank, values))?;
        (0..self.size()).map(|rank| self.receive(rank)).collect()
    }

    fn exchange(&mut self, sent: &[Message], received: &mut [Message]) -> Result<(), Fault> {
        sent.iter().try_for_each(|message| self.send(message.rank, &message.values))?;
        for message in received {
            let values = self.receive(message.rank)?;
            if values.len() != message.values.len() {
                return Err(Fault::Mismatch(message.values.len(), values.len()));
            }
            message.values = values;
        }
        Ok(())
    }
}
