//! Unknowns of a system that processes share: whose they are, and which of them neighbours have copies of.

use super::comm::{Comm, Fault, Message, Reduce};
use super::crew::Crew;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// An unknown in the eyes of all: the process that it belongs to, and a number that it has on all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shared {
    /// Rank of the owner.
    pub owner: u32,
    /// Its name among those of the owner.
    pub id: u64,
}

/// The unknowns of a system as one process has them: its own ones, and copies of those of others.
///
/// Own unknowns of the processes follow each other in one numbering of all.
#[derive(Debug)]
pub struct Halo {
    crew: Crew,
    own: Vec<u32>,
    first: usize,
    total: usize,
    number: Vec<u64>,
    /// To whom which own ones go, and from whom which copies come.
    sent: Vec<(usize, Vec<u32>)>,
    received: Vec<(usize, Vec<u32>)>,
    buffers: Mutex<[Vec<Message>; 2]>,
}

/// Lists of numbers for every rank, to the same lists from every rank.
///
/// # Errors
/// If MPI fails.
pub fn exchange_all(comm: &mut dyn Comm, lists: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, Fault> {
    let (rank, size) = (comm.rank(), comm.size());
    let lengths: Vec<f64> = lists.iter().map(|list| list.len() as f64).collect();
    let all = comm.all_gather(&lengths)?;
    let some = |(_, list): &(usize, Vec<f64>)| !list.is_empty();
    let message = |(rank, values): (usize, Vec<f64>)| Message { rank, values };
    let sent: Vec<Message> = lists.into_iter().enumerate().filter(some).map(message).collect();
    let from = (0..size).map(|other| (other, vec![0.0; all[other][rank] as usize]));
    let mut received: Vec<Message> = from.filter(some).map(message).collect();
    comm.exchange(&sent, &mut received)?;
    let mut found = vec![vec![]; size];
    received.into_iter().for_each(|message| found[message.rank] = message.values);
    Ok(found)
}

impl Halo {
    /// Of the unknowns `shared`, which all processes tell at the same time.
    ///
    /// # Errors
    /// If MPI fails; [`Fault::Mismatch`] if an owner does not know an unknown that another process has a copy of.
    pub fn new(crew: &Crew, shared: &[Shared]) -> Result<Halo, Fault> {
        let (rank, size) = (crew.rank(), crew.size());
        let is_own = |i: &u32| shared[*i as usize].owner as usize == rank;
        let own: Vec<u32> = (0..shared.len() as u32).filter(is_own).collect();
        let local: HashMap<u64, u32> = own.iter().map(|&i| (shared[i as usize].id, i)).collect();
        let mut copies: Vec<Vec<u32>> = vec![vec![]; size];
        for (i, of) in (0..).zip(shared).filter(|(i, _)| !is_own(i)) {
            copies[of.owner as usize].push(i);
        }
        crew.with(|comm| {
            let [first, total] = comm.offset(own.len())?;
            let ids =
                |list: &Vec<u32>| list.iter().map(|&i| shared[i as usize].id as f64).collect::<Vec<f64>>();
            let wanted = exchange_all(comm, copies.iter().map(ids).collect())?;
            let find = |id: &f64| local.get(&(*id as u64)).copied();
            let found: Vec<Vec<Option<u32>>> =
                wanted.iter().map(|list| list.iter().map(find).collect()).collect();
            let lost = found.iter().flatten().filter(|place| place.is_none()).count();
            let all_lost = comm.sum(lost as f64)? as usize;
            if all_lost > 0 {
                return Err(Fault::Mismatch(0, all_lost));
            }
            let given: Vec<Vec<u32>> =
                found.into_iter().map(|list| list.into_iter().flatten().collect()).collect();
            let mut number = vec![0; shared.len()];
            own.iter().enumerate().for_each(|(n, &i)| number[i as usize] = (first + n) as u64);
            let numbers =
                |list: &Vec<u32>| list.iter().map(|&i| number[i as usize] as f64).collect::<Vec<f64>>();
            let answers = exchange_all(comm, given.iter().map(numbers).collect())?;
            for (places, numbers) in copies.iter().zip(answers) {
                places.iter().zip(numbers).for_each(|(&i, n)| number[i as usize] = n as u64);
            }
            let some = |lists: Vec<Vec<u32>>| {
                lists.into_iter().enumerate().filter(|(_, list)| !list.is_empty()).collect::<Vec<_>>()
            };
            let (sent, received) = (some(given), some(copies));
            let room = |lists: &[(usize, Vec<u32>)]| {
                let of =
                    |(rank, list): &(usize, Vec<u32>)| Message { rank: *rank, values: vec![0.0; list.len()] };
                lists.iter().map(of).collect::<Vec<_>>()
            };
            let buffers = Mutex::new([room(&sent), room(&received)]);
            Ok(Halo { crew: crew.clone(), own, first, total, number, sent, received, buffers })
        })
    }

    /// The processes.
    pub fn crew(&self) -> &Crew {
        &self.crew
    }

    /// Places of the own unknowns, ascending.
    pub fn own(&self) -> &[u32] {
        &self.own
    }

    /// Number of the first own unknown among those of all.
    pub fn first(&self) -> usize {
        self.first
    }

    /// How many all have.
    pub fn total(&self) -> usize {
        self.total
    }

    /// Number of each unknown among those of all.
    pub fn number(&self, place: usize) -> usize {
        self.number[place] as usize
    }

    /// Bytes that [`Halo::update`] sends from here.
    pub fn bytes(&self) -> usize {
        self.sent.iter().map(|(_, list)| size_of::<f64>() * list.len()).sum()
    }

    /// The copies in `x` become the numbers of their owners; NaN where MPI fails.
    pub fn update(&self, x: &mut [f64]) {
        let mut buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let [sent, received] = &mut *buffers;
        for (message, (_, list)) in sent.iter_mut().zip(&self.sent) {
            message.values.iter_mut().zip(list).for_each(|(value, &i)| *value = x[i as usize]);
        }
        self.crew.count(sent.len(), self.bytes());
        let failed = self.crew.with(|comm| comm.exchange(sent, received)).is_err();
        for (message, (_, list)) in received.iter().zip(&self.received) {
            for (value, &i) in message.values.iter().zip(list) {
                x[i as usize] = if failed { f64::NAN } else { *value };
            }
        }
    }

    /// The copies in `x` are added to the numbers of their owners, in the order of the ranks, and become these sums; NaN
    /// where MPI fails.
    pub fn add(&self, x: &mut [f64]) {
        {
            let mut buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
            let [received, sent] = &mut *buffers;
            for (message, (_, list)) in sent.iter_mut().zip(&self.received) {
                message.values.iter_mut().zip(list).for_each(|(value, &i)| *value = x[i as usize]);
            }
            let bytes = self.received.iter().map(|(_, list)| size_of::<f64>() * list.len()).sum();
            self.crew.count(sent.len(), bytes);
            let failed = self.crew.with(|comm| comm.exchange(sent, received)).is_err();
            for (message, (_, list)) in received.iter().zip(&self.sent) {
                for (value, &i) in message.values.iter().zip(list) {
                    x[i as usize] += if failed { f64::NAN } else { *value };
                }
            }
        }
        self.update(x);
    }

    /// Whether it holds on one of the processes.
    pub fn any(&self, holds: bool) -> bool {
        self.crew.one(Reduce::Max, f64::from(u8::from(holds))) > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::threads::together;

    /// A line of 10 unknowns, of which process r has 4 r … 4 r + 3 and a copy of each neighbour.
    fn line(rank: usize) -> Vec<Shared> {
        let ids = (4 * rank).saturating_sub(1)..(4 * rank + 5).min(10);
        ids.map(|id| Shared { owner: (id / 4) as u32, id: id as u64 }).collect()
    }

    #[test]
    fn copies_become_the_numbers_of_their_owners() {
        let found = together(3, |comm| {
            let (rank, crew) = (comm.rank(), Crew::new(comm));
            let shared = line(rank);
            let halo = Halo::new(&crew, &shared).unwrap();
            let mut x: Vec<f64> = shared
                .iter()
                .map(|s| if s.owner as usize == rank { s.id as f64 + 0.5 } else { -1.0 })
                .collect();
            halo.update(&mut x);
            let numbers: Vec<usize> = (0..x.len()).map(|place| halo.number(place)).collect();
            assert!(halo.any(rank == 1) && !halo.any(false));
            // Every place counts once for each process that has it.
            let mut counts = vec![1.0; shared.len()];
            halo.add(&mut counts);
            let at_ends = |s: &Shared| s.id > 0 && s.id.is_multiple_of(4) || s.id % 4 == 3;
            assert!(counts.iter().zip(&shared).all(|(n, s)| *n == if at_ends(s) { 2.0 } else { 1.0 }));
            let gathered = crew.collect(vec![rank as f64; rank + 1]).unwrap();
            assert_eq!(gathered.len(), if rank == 0 { 3 } else { 0 });
            (x, numbers, halo.first(), halo.total(), halo.own().len(), halo.bytes())
        });
        for (rank, (x, numbers, first, total, own, bytes)) in found.into_iter().enumerate() {
            let ids: Vec<u64> = line(rank).iter().map(|s| s.id).collect();
            assert_eq!(x, ids.iter().map(|id| *id as f64 + 0.5).collect::<Vec<_>>());
            assert_eq!(numbers, ids.iter().map(|id| *id as usize).collect::<Vec<_>>());
            assert_eq!((first, total, own), (4 * rank, 10, [4, 4, 2][rank]));
            assert_eq!(bytes, [8, 16, 8][rank]);
        }
    }

    #[test]
    fn a_copy_that_nobody_owns_is_told() {
        let found = together(2, |comm| {
            let (rank, crew) = (comm.rank(), Crew::new(comm));
            let id = if rank == 0 { 7 } else { 8 };
            Halo::new(&crew, &[Shared { owner: 1, id }]).err()
        });
        assert_eq!(found, [Some(Fault::Mismatch(0, 1)), Some(Fault::Mismatch(0, 1))]);
    }
}
