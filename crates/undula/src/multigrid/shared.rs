//! A level that processes share. Each has the rows of its own unknowns and of those in its blocks, and copies of the
//! columns of these rows.
//!
//! P ᵀ A P and P ᵀ b are sums of what the processes find in their own rows. Blocks of different processes have unknowns in
//! common: a sweep gives these the mean of the corrections.

use super::levels::Tier;
use super::lists::Lists;
use super::number::Number;
use super::transfer::Transfer;
use crate::algebra::{Csr, Pattern};
use crate::parallel::halo::exchange_all;
use crate::parallel::{Crew, Fault, Halo, Message, Shared};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Rows by their numbers in the whole, each with its columns.
type Columns = BTreeMap<u32, Vec<u32>>;

/// The unknowns of a level.
pub struct Share<T> {
    pub(super) halo: Arc<Halo>,
    /// How much of the correction of each unknown is that of this process.
    weights: Vec<f64>,
    before: Vec<T>,
    work: Vec<f64>,
    /// How the matrix of the coarser level comes together.
    pub(super) rows: Rows,
}

/// How a matrix comes together from products of the processes.
pub struct Rows {
    /// Where the product of this process has entries.
    pub(super) product: Arc<Pattern>,
    /// Entries of the product, and those of the matrix that they are added to.
    own: Vec<[u32; 2]>,
    /// Entries of the product to the owners of their rows, and those of the matrix that others add to, by process.
    sums: [Vec<(usize, Vec<u32>)>; 2],
    /// Entries of the matrix that others have copies of, and those that are copies.
    copies: [Vec<(usize, Vec<u32>)>; 2],
}

/// The next coarser level.
pub struct Coarser {
    pub(super) transfer: Transfer,
    pub(super) pattern: Arc<Pattern>,
    pub(super) rows: Rows,
    pub(super) halo: Arc<Halo>,
    /// Numbers in the whole of the unknowns here, ascending.
    pub(super) numbers: Vec<u32>,
    /// The process of each unknown of the whole.
    pub(super) owners: Vec<u32>,
}

/// What a process has of a level, by numbers in the whole.
pub struct Finer<'a> {
    pub(super) halo: &'a Halo,
    pub(super) pattern: &'a Pattern,
    pub(super) numbers: &'a [u32],
    pub(super) owners: &'a [u32],
}

/// Lists of rows of a message: number, number of columns, columns.
pub(super) fn flat(rows: impl Iterator<Item = (u32, Vec<u32>)>) -> Vec<f64> {
    let mut list = vec![];
    for (row, columns) in rows {
        list.extend([f64::from(row), columns.len() as f64]);
        list.extend(columns.iter().map(|&column| f64::from(column)));
    }
    list
}

/// Its rows again.
pub(super) fn rows_of(list: &[f64]) -> Vec<(u32, Vec<u32>)> {
    let (mut rows, mut rest) = (vec![], list);
    while let [row, n, behind @ ..] = rest {
        let (columns, others) = behind.split_at(*n as usize);
        rows.push((*row as u32, columns.iter().map(|&column| column as u32).collect()));
        rest = others;
    }
    rows
}

/// The process of each coarser unknown: that of the finer one that has most of it.
fn owners_of(tier: &Tier, finer: &[u32]) -> Vec<u32> {
    let mut most = vec![(0.0_f32, 0); tier.unknowns.len()];
    for (row, &rank) in tier.rows.iter().zip(finer) {
        for &(column, weight) in row {
            let best = &mut most[column as usize];
            if weight.abs() > best.0 {
                *best = (weight.abs(), rank);
            }
        }
    }
    most.into_iter().map(|(_, rank)| rank).collect()
}

impl Finer<'_> {
    /// The next coarser level by a `tier` of the whole; `wanted` are the unknowns that its blocks here have.
    pub(super) fn coarser(&self, tier: &Tier, wanted: Vec<u32>) -> Result<Coarser, Fault> {
        let (crew, owners) = (self.halo.crew(), owners_of(tier, self.owners));
        let rank = crew.rank() as u32;
        let entries = |number: &u32| tier.rows.get(*number as usize).iter();
        let mut seen: Vec<u32> = self.numbers.iter().flat_map(entries).map(|entry| entry.0).collect();
        sort(&mut seen);
        let first = self.transfer(tier, &seen).pattern(self.pattern);
        let found = |row: usize| first.columns(row).iter().map(|&at| seen[at as usize]).collect::<Vec<u32>>();
        let products: Columns = seen
            .iter()
            .enumerate()
            .map(|(row, &id)| (id, found(row)))
            .filter(|row| !row.1.is_empty())
            .collect();
        let mut own: Columns =
            (0..).zip(&owners).filter(|(_, owner)| **owner == rank).map(|(id, _)| (id, vec![id])).collect();
        let (sent, came) = gather(crew, &owners, &products, &mut own)?;
        let mut wanted: Vec<u32> = wanted.into_iter().filter(|id| owners[*id as usize] != rank).collect();
        sort(&mut wanted);
        let (asked, answers) = ask(crew, &owners, &wanted, &own)?;
        // All that is here.
        let mut numbers = seen;
        let copied = answers.iter().flatten();
        numbers.extend(own.iter().flat_map(|(id, columns)| columns.iter().chain([id])));
        numbers.extend(copied.clone().flat_map(|(id, columns)| columns.iter().chain([id])));
        sort(&mut numbers);
        let mut complete = own.clone();
        complete.extend(copied.cloned());
        let pattern = pattern_of(&numbers, &complete, true);
        let product = pattern_of(&numbers, &products, false);
        let rows = Places { numbers: &numbers, pattern: &pattern, product: &product };
        let rows = rows.rows(rank, &owners, (&products, &sent, &came), (&asked, &answers));
        let shared: Vec<Shared> =
            numbers.iter().map(|&id| Shared { owner: owners[id as usize], id: u64::from(id) }).collect();
        let halo = Arc::new(Halo::new(crew, &shared)?);
        let transfer = self.transfer(tier, &numbers);
        let (rows, pattern) = (Rows { product: Arc::new(product), ..rows }, Arc::new(pattern));
        Ok(Coarser { transfer, pattern, rows, halo, numbers, owners })
    }

    /// P of the unknowns here, with the columns `numbers` of the whole.
    fn transfer(&self, tier: &Tier, numbers: &[u32]) -> Transfer {
        let mut is_own = vec![false; self.numbers.len()];
        self.halo.own().iter().for_each(|&at| is_own[at as usize] = true);
        let mut rows = Lists::default();
        for &number in self.numbers {
            let entries = tier.rows.get(number as usize).iter();
            rows.push(entries.filter_map(|&(column, w)| Some((place(numbers, column)?, w))));
        }
        Transfer::of_own(rows, numbers.len(), |fine| is_own[fine])
    }
}

fn sort(list: &mut Vec<u32>) {
    list.sort_unstable();
    list.dedup();
}

fn place(numbers: &[u32], id: u32) -> Option<u32> {
    numbers.binary_search(&id).ok().map(|at| at as u32)
}

/// Brings the rows of `products` to their owners, where they join the `own` ones. Returns the numbers of the rows that were
/// sent, and what came, by process.
#[allow(clippy::type_complexity)]
fn gather(
    crew: &Crew,
    owners: &[u32],
    products: &Columns,
    own: &mut Columns,
) -> Result<(Vec<Vec<u32>>, Vec<Vec<(u32, Vec<u32>)>>), Fault> {
    let mut sent = vec![vec![]; crew.size()];
    for (id, columns) in products {
        match own.get_mut(id) {
            Some(row) => row.extend(columns),
            None => sent[owners[*id as usize] as usize].push(*id),
        }
    }
    let message = |list: &Vec<u32>| flat(list.iter().map(|id| (*id, products[id].clone())));
    let messages = sent.iter().map(message).collect();
    let came = crew.with(|comm| exchange_all(comm, messages))?;
    let came: Vec<_> = came.iter().map(|list| rows_of(list)).collect();
    for (id, columns) in came.iter().flatten() {
        own.entry(*id).or_default().extend(columns);
    }
    own.values_mut().for_each(sort);
    Ok((sent, came))
}

/// Complete rows of others: the numbers that others ask for here, and what they answer, by process.
#[allow(clippy::type_complexity)]
fn ask(
    crew: &Crew,
    owners: &[u32],
    wanted: &[u32],
    own: &Columns,
) -> Result<(Vec<Vec<u32>>, Vec<Vec<(u32, Vec<u32>)>>), Fault> {
    let mut lists = vec![vec![]; crew.size()];
    wanted.iter().for_each(|&id| lists[owners[id as usize] as usize].push(f64::from(id)));
    let asked = crew.with(|comm| exchange_all(comm, lists))?;
    let ids = |list: Vec<f64>| list.into_iter().map(|id| id as u32).collect::<Vec<u32>>();
    let asked: Vec<Vec<u32>> = asked.into_iter().map(ids).collect();
    let row = |id: &u32| (*id, own.get(id).cloned().unwrap_or_default());
    let messages = asked.iter().map(|list| flat(list.iter().map(row))).collect();
    let answers = crew.with(|comm| exchange_all(comm, messages))?;
    Ok((asked, answers.iter().map(|list| rows_of(list)).collect()))
}

/// Rows of the unknowns `numbers`, with a diagonal or not where there is no other column.
fn pattern_of(numbers: &[u32], rows: &Columns, diagonal: bool) -> Pattern {
    let columns = |(at, id): (u32, &u32)| match rows.get(id) {
        Some(columns) => columns.iter().filter_map(|&column| place(numbers, column)).collect(),
        None if diagonal => vec![at],
        None => vec![],
    };
    Pattern::from_rows(&(0..).zip(numbers).map(columns).collect::<Vec<Vec<u32>>>())
}

/// Where entries of rows are.
struct Places<'a> {
    numbers: &'a [u32],
    pattern: &'a Pattern,
    product: &'a Pattern,
}

impl Places<'_> {
    /// The entries of a row of `pattern` in these columns, all of them without.
    fn entries(&self, pattern: &Pattern, id: u32, columns: Option<&[u32]>) -> Vec<u32> {
        let Some(row) = place(self.numbers, id) else { return vec![] };
        let range = pattern.row(row as usize);
        let Some(columns) = columns else { return range.map(|at| at as u32).collect() };
        let here = columns.iter().filter_map(|&column| place(self.numbers, column));
        let found = here.filter_map(|column| pattern.columns(row as usize).binary_search(&column).ok());
        found.map(|at| (range.start + at) as u32).collect()
    }

    #[allow(clippy::type_complexity)]
    fn rows(
        &self,
        rank: u32,
        owners: &[u32],
        (products, sent, came): (&Columns, &[Vec<u32>], &[Vec<(u32, Vec<u32>)>]),
        (asked, answers): (&[Vec<u32>], &[Vec<(u32, Vec<u32>)>]),
    ) -> Rows {
        let mut own = vec![];
        for (&id, columns) in products.iter().filter(|(id, _)| owners[**id as usize] == rank) {
            let from = self.entries(self.product, id, None);
            own.extend(
                from.into_iter().zip(self.entries(self.pattern, id, Some(columns))).map(|(a, b)| [a, b]),
            );
        }
        let some = |lists: Vec<Vec<u32>>| -> Vec<(usize, Vec<u32>)> {
            lists.into_iter().enumerate().filter(|(_, list)| !list.is_empty()).collect()
        };
        let of_rows = |pattern: &Pattern, list: &Vec<u32>| -> Vec<u32> {
            list.iter().flat_map(|&id| self.entries(pattern, id, None)).collect()
        };
        let in_columns = |list: &Vec<(u32, Vec<u32>)>| -> Vec<u32> {
            list.iter().flat_map(|(id, columns)| self.entries(self.pattern, *id, Some(columns))).collect()
        };
        Rows {
            product: Arc::new(Pattern::from_rows::<Vec<u32>>(&[])),
            own,
            sums: [
                some(sent.iter().map(|list| of_rows(self.product, list)).collect()),
                some(came.iter().map(in_columns).collect()),
            ],
            copies: [
                some(asked.iter().map(|list| of_rows(self.pattern, list)).collect()),
                some(answers.iter().map(in_columns).collect()),
            ],
        }
    }
}

/// Values at places to others, and from them to places, where they are added or not.
fn exchange(
    crew: &Crew,
    from: &[f64],
    to: &mut [f64],
    [sent, received]: &[Vec<(usize, Vec<u32>)>; 2],
    adds: bool,
) -> Result<(), Fault> {
    let values = |list: &Vec<u32>| list.iter().map(|&at| from[at as usize]).collect();
    let sent: Vec<Message> =
        sent.iter().map(|(rank, list)| Message { rank: *rank, values: values(list) }).collect();
    let room = |(rank, list): &(usize, Vec<u32>)| Message { rank: *rank, values: vec![0.0; list.len()] };
    let mut messages: Vec<Message> = received.iter().map(room).collect();
    crew.with(|comm| comm.exchange(&sent, &mut messages))?;
    for (message, (_, list)) in messages.iter().zip(received) {
        for (value, &at) in message.values.iter().zip(list) {
            let kept = if adds { to[at as usize] } else { 0.0 };
            to[at as usize] = kept + value;
        }
    }
    Ok(())
}

impl Rows {
    /// The matrix on `pattern` from the `product` here and those of others.
    pub(super) fn complete(&self, crew: &Crew, product: &Csr, pattern: &Arc<Pattern>) -> Result<Csr, Fault> {
        let mut matrix = Csr::zeros(pattern);
        self.own.iter().for_each(|&[from, to]| matrix.values[to as usize] += product.values[from as usize]);
        exchange(crew, &product.values, &mut matrix.values, &self.sums, true)?;
        let own = matrix.values.clone();
        exchange(crew, &own, &mut matrix.values, &self.copies, false)?;
        Ok(matrix)
    }
}

impl<T: Number> Share<T> {
    /// Of unknowns with these `blocks` here.
    pub(super) fn new(halo: Arc<Halo>, blocks: &Lists<u32>, rows: Rows, n: usize) -> Share<T> {
        let mut work = vec![0.0; n];
        blocks.items().iter().for_each(|&at| work[at as usize] = 1.0);
        let mut weights = work.clone();
        halo.add(&mut work);
        weights.iter_mut().zip(&work).for_each(|(weight, count)| *weight /= count.max(1.0));
        Share { halo, weights, before: vec![T::default(); n], work, rows }
    }

    /// The copies in `x` become the numbers of their owners, or with `adds` the sums of all.
    pub(super) fn update(&mut self, x: &mut [T], adds: bool) {
        self.work.iter_mut().zip(&*x).for_each(|(to, from)| *to = from.double());
        if adds {
            self.halo.add(&mut self.work);
        } else {
            self.halo.update(&mut self.work);
        }
        x.iter_mut().zip(&self.work).for_each(|(to, from)| *to = T::of(*from));
    }

    /// A sweep begins at `x`.
    pub(super) fn begin(&mut self, x: &[T]) {
        self.before.copy_from_slice(x);
    }

    /// It has ended: what was common to several processes becomes the mean.
    pub(super) fn join(&mut self, x: &mut [T]) {
        let Share { halo, weights, before, work, .. } = self;
        for (((work, weight), before), x) in work.iter_mut().zip(&*weights).zip(&*before).zip(&*x) {
            *work = weight * (x.double() - before.double());
        }
        halo.add(work);
        for ((x, before), work) in x.iter_mut().zip(&*before).zip(&*work) {
            *x = T::of(before.double() + work);
        }
    }
}
