//! The levels of a system, whose unknowns processes share or not.

use super::levels::{System, Tier, tiers};
use crate::algebra::SolverError;
use crate::parallel::{Crew, Fault, Shared};
use crate::space::FsiSpace;

/// What levels are made of.
pub enum Tiers {
    /// Of a process alone, from the finest level down.
    Whole(Vec<Tier>),
    /// Of several processes.
    Parted(Parted),
}

/// The levels of a whole system, and what a process has of the finest one.
pub struct Parted {
    /// The processes.
    pub crew: Crew,
    /// From the finest level down.
    pub tiers: Vec<Tier>,
    /// Numbers in the whole finest level of the unknowns here.
    pub numbers: Vec<u32>,
    /// The process of each unknown of the whole finest level.
    pub owners: Vec<u32>,
}

impl Tiers {
    /// Those of a `system` on `space`, from the coarser meshes of the whole.
    ///
    /// # Errors
    /// If MPI fails, or if the whole space has been given back.
    pub fn new<const D: usize>(space: &FsiSpace<D>, system: System<'_>) -> Result<Tiers, SolverError> {
        if space.part.is_none() {
            return Ok(Tiers::Whole(tiers(space, system, &[])));
        }
        let parted = Parted::new(space, system).map_err(|fault| SolverError::Engine(fault.to_string()))?;
        Ok(Tiers::Parted(parted))
    }
}

impl Parted {
    fn new<const D: usize>(space: &FsiSpace<D>, system: System<'_>) -> Result<Parted, Fault> {
        let gone = || Fault::Missing("the whole mesh has been given back".into());
        let part = space.part.as_ref().ok_or_else(gone)?;
        let (whole, crew) = (part.whole().ok_or_else(gone)?, part.crew());
        let (System::Flow { places, .. } | System::Extension(places)) = system;
        let here: Vec<Shared> = places.iter().filter_map(|&place| space.shared(place)).collect();
        let mut all = vec![];
        for (rank, ids) in (0..).zip(crew.lists(&own_ids(&here, crew.rank()))?) {
            all.extend(ids.into_iter().map(|id| (id as u32, rank)));
        }
        all.sort_unstable();
        let (whole_places, owners): (Vec<u32>, Vec<u32>) = all.into_iter().unzip();
        let number = |of: &Shared| whole_places.binary_search(&(of.id as u32)).ok();
        let numbers: Vec<u32> = here.iter().filter_map(number).map(|number| number as u32).collect();
        let ranks = whole.ranks_of_cells(crew.size()).unwrap_or_default();
        let tiers = match system {
            System::Flow { given, .. } => {
                let places = (0..space.n_v() as u32).filter(|&place| given[place as usize]);
                let here: Vec<Shared> = places.filter_map(|place| space.shared(place)).collect();
                let mut given = vec![false; whole.n_field_unknowns()];
                for id in crew.lists(&own_ids(&here, crew.rank()))?.into_iter().flatten() {
                    given[id as usize] = true;
                }
                tiers(&whole, System::Flow { given: &given, places: &whole_places }, &ranks)
            }
            System::Extension(_) => tiers(&whole, System::Extension(&whole_places), &ranks),
        };
        if numbers.len() < places.len() {
            return Err(Fault::Mismatch(places.len(), numbers.len()));
        }
        Ok(Parted { crew: crew.clone(), tiers, numbers, owners })
    }
}

/// Numbers in the whole of those that belong to `rank`.
fn own_ids(here: &[Shared], rank: usize) -> Vec<f64> {
    let own = here.iter().filter(|shared| shared.owner as usize == rank);
    own.map(|shared| shared.id as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::super::lists::Lists;
    use super::super::{Settings, multigrid};
    use super::*;
    use crate::algebra::{Csr, Kind, LinearSolver, MultifrontalLu, Options, Pattern, Unknown};
    use crate::parallel::threads::together;
    use crate::parallel::{Comm, Halo};
    use std::sync::Arc;

    /// Nodes of a line, and cells of it, each of which has four of the finest nodes and the next one.
    const N: usize = 8 * 4 + 1;
    const CELLS: usize = 8;

    fn unknown(node: usize) -> Unknown {
        Unknown { node: node as u32, kind: Kind::Velocity, at: [node as f64, 0.0, 0.0] }
    }

    /// Where every second node is a coarser one, and the others are between; cells have `inner` steps.
    fn tier(n: usize, inner: usize, rank_of: &impl Fn(usize) -> u32) -> Tier {
        let (mut rows, mut blocks) = (Lists::default(), Lists::default());
        for node in 0..n as u32 {
            let half = node / 2;
            match node % 2 {
                0 => rows.push([(half, 1.0)]),
                _ => rows.push([(half, 0.5), (half + 1, 0.5)]),
            }
        }
        (0..CELLS).for_each(|cell| blocks.push((cell * inner..=(cell + 1) * inner).map(|node| node as u32)));
        let unknowns = (0..n.div_ceil(2)).map(unknown).collect();
        Tier { blocks, ranks: (0..CELLS).map(rank_of).collect(), rows, unknowns }
    }

    /// Entry of a row of -u'' + u' / 4 + u / 50.
    fn entry(row: usize, column: usize) -> f64 {
        match column as i64 - row as i64 {
            0 => 2.02,
            1 => -0.8,
            _ => -1.2,
        }
    }

    fn row(node: usize) -> Vec<u32> {
        (node.saturating_sub(1)..(node + 2).min(N)).map(|column| column as u32).collect()
    }

    fn right(node: usize) -> f64 {
        (0.7 * node as f64).sin()
    }

    /// x after `n` corrections by cycles, from 0.
    fn iterated(
        solver: &mut dyn LinearSolver,
        a: &Csr,
        b: &[f64],
        n: usize,
        bring: impl Fn(&mut [f64]),
    ) -> Vec<f64> {
        let (mut x, mut r, mut z) = (vec![0.0; b.len()], vec![0.0; b.len()], vec![0.0; b.len()]);
        for _ in 0..n {
            a.residual(b, &x, &mut r);
            bring(&mut r);
            solver.apply(&r, &mut z);
            x.iter_mut().zip(&z).for_each(|(x, z)| *x += z);
        }
        x
    }

    fn solver(tiers: Tiers) -> Box<dyn LinearSolver> {
        let settings = Settings { double: true, ..Settings::default() };
        multigrid(settings, tiers, Box::new(MultifrontalLu::multifrontal(Options::unprobed())))
    }

    /// A process has the nodes of its cells and the next ones; rows of these are not complete, and not a number.
    fn on_parts(size: usize, n: usize) -> Vec<Vec<(usize, f64)>> {
        together(size, |comm| {
            let (rank, crew) = (comm.rank() as u32, Crew::new(comm));
            let rank_of = |cell: usize| (cell * size / CELLS) as u32;
            let owner = |node: usize| rank_of((node.saturating_sub(1) / 4).min(CELLS - 1));
            let of_cells = |node: &usize| {
                (0..CELLS).any(|cell| rank_of(cell) == rank && (cell * 4..=cell * 4 + 4).contains(node))
            };
            let here: Vec<usize> =
                (0..N).filter(|node| row(*node).iter().any(|at| of_cells(&(*at as usize)))).collect();
            let shared: Vec<Shared> =
                here.iter().map(|&id| Shared { owner: owner(id), id: id as u64 }).collect();
            let halo = Arc::new(Halo::new(&crew, &shared).unwrap());
            let place = |id: u32| here.binary_search(&(id as usize)).ok().map(|at| at as u32);
            let rows: Vec<Vec<u32>> =
                here.iter().map(|&node| row(node).into_iter().filter_map(place).collect()).collect();
            let mut a = Csr::zeros(&Arc::new(Pattern::from_rows(&rows)));
            for (at, &node) in here.iter().enumerate() {
                for place in a.pattern.row(at) {
                    let value = entry(node, here[a.pattern.column(at, place) as usize]);
                    a.values[place] = if of_cells(&node) { value } else { f64::NAN };
                }
            }
            let tiers = vec![tier(N, 4, &rank_of), tier(N.div_ceil(2), 2, &rank_of)];
            let numbers = here.iter().map(|&node| node as u32).collect();
            let owners = (0..N).map(owner).collect();
            let mut solver = solver(Tiers::Parted(Parted { crew, tiers, numbers, owners }));
            solver.share(Arc::clone(&halo));
            solver.analyse(&a.pattern, &here.iter().map(|&node| unknown(node)).collect::<Vec<_>>()).unwrap();
            solver.factor(&a).unwrap();
            let b: Vec<f64> = here.iter().map(|&node| right(node)).collect();
            let x = iterated(&mut *solver, &a, &b, n, |r| halo.update(r));
            // Copies are the numbers of their owners.
            let mut same = x.clone();
            halo.update(&mut same);
            assert_eq!(same, x);
            halo.own().iter().map(|&at| (here[at as usize], x[at as usize])).collect()
        })
    }

    #[test]
    fn cycles_of_several_processes_solve_the_system() {
        let all: Vec<Vec<u32>> = (0..N).map(row).collect();
        let mut a = Csr::zeros(&Arc::new(Pattern::from_rows(&all)));
        for node in 0..N {
            for place in a.pattern.row(node) {
                a.values[place] = entry(node, a.pattern.column(node, place) as usize);
            }
        }
        let unknowns: Vec<Unknown> = (0..N).map(unknown).collect();
        let b: Vec<f64> = (0..N).map(right).collect();
        let mut exact = vec![0.0; N];
        let mut direct = MultifrontalLu::multifrontal(Options::unprobed());
        direct.analyse(&a.pattern, &unknowns).unwrap();
        direct.factor(&a).unwrap();
        direct.apply(&b, &mut exact);
        let tiers = vec![tier(N, 4, &|_| 0), tier(N.div_ceil(2), 2, &|_| 0)];
        let mut whole = solver(Tiers::Whole(tiers));
        whole.analyse(&a.pattern, &unknowns).unwrap();
        whole.factor(&a).unwrap();
        let after = |n: usize, solver: &mut dyn LinearSolver| {
            let x = iterated(solver, &a, &b, n, |_| ());
            x.iter().zip(&exact).map(|(x, exact)| (x - exact).abs()).fold(0.0, f64::max)
        };
        let errors = [4, 30].map(|n| after(n, &mut *whole));
        assert!(errors[0] > 1e-9 && errors[1] < 1e-12, "{errors:?}");
        // A level that nobody else has a part of is that of a process alone.
        let alone = iterated(&mut *whole, &a, &b, 4, |_| ());
        let found = on_parts(1, 4).remove(0);
        assert!(found.iter().zip(&alone).all(|((_, found), alone)| (found - alone).abs() < 1e-13));
        for size in [2, 3, 4, 8] {
            let error = |n: usize| {
                let found: Vec<(usize, f64)> = on_parts(size, n).into_iter().flatten().collect();
                assert_eq!(found.len(), N);
                found.into_iter().map(|(node, x)| (x - exact[node]).abs()).fold(0.0, f64::max)
            };
            let found = [4, 30].map(error);
            assert!(
                found[1] < 1e-12 && found[0] < 20.0 * errors[0].max(1e-6),
                "{size}: {found:?} {errors:?}"
            );
        }
    }
}
