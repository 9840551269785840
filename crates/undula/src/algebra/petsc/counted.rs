//! The rows that a process counts in norms and means, of a system that several may share.

use crate::parallel::{Halo, Reduce};
use std::sync::Arc;

/// The rows that a process counts: its own ones, where it has copies of those of others; else all.
#[derive(Debug, Clone, Default)]
pub(super) struct Counted {
    pub(super) rows: Vec<u32>,
    pub(super) halo: Option<Arc<Halo>>,
}

impl Counted {
    /// Those of a system of `n` rows here.
    pub(super) fn new(n: usize, halo: Option<Arc<Halo>>) -> Counted {
        let rows = halo.as_ref().map_or_else(|| (0..n as u32).collect(), |halo| halo.own().to_vec());
        Counted { rows, halo }
    }

    /// Their numbers.
    pub(super) fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.rows.iter().map(|&row| row as usize)
    }

    /// Numbers of all processes that share the system.
    pub(super) fn reduce(&self, how: Reduce, values: &mut [f64]) {
        if let Some(halo) = &self.halo {
            halo.crew().reduce(how, values);
        }
    }

    /// Whether it holds on one of them.
    pub(super) fn any(&self, holds: bool) -> bool {
        self.halo.as_ref().map_or(holds, |halo| halo.any(holds))
    }
}
