//! What a checkpoint keeps of a simulation.

use super::Simulation;
use crate::error::Error;
use crate::functional::balance::Largest;
use crate::time::{self, adaptive};

/// All that a simulation needs to go on with the same bits: what a checkpoint keeps of it.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    /// Steps done.
    pub steps: u64,
    /// Solutions, Jacobian, counters.
    pub stepper: time::Memory,
    /// Of step-size control.
    pub adaptive: Option<adaptive::Memory>,
    /// Largest flows so far.
    pub balance: Option<Largest>,
    /// U at the nodes \[m\], see [`crate::space::Fabrics`]; empty without prestress.
    pub unloading: Vec<f64>,
}

impl<const D: usize> Simulation<D> {
    /// What a checkpoint keeps.
    #[doc(hidden)]
    pub fn save(&self) -> Memory {
        let Simulation {
            case: _,
            stepper,
            history: _,
            steps,
            report: _,
            adaptive,
            balance,
            functionals: _,
            names: _,
            fluid_residual: _,
            needs_residual: _,
            volume: _,
            threads: _,
            pool: _,
            begun: _,
        } = self;
        Memory {
            steps: *steps,
            stepper: stepper.save(),
            adaptive: adaptive.as_ref().map(|adaptive| adaptive.memory.clone()),
            balance: balance.as_ref().map(|balance| balance.largest),
            unloading: stepper.assembler.space.fabrics.unloading.clone(),
        }
    }

    /// Go on from a checkpoint.
    ///
    /// # Errors
    /// If the kept Jacobian cannot be factorised.
    #[doc(hidden)]
    pub fn restore(&mut self, memory: Memory) -> Result<(), Error> {
        self.steps = memory.steps;
        if let Some(adaptive) = &mut self.adaptive {
            match memory.adaptive {
                Some(memory) => adaptive.memory = memory,
                None => adaptive.memory.past.clear(),
            }
        }
        let stepper = &mut self.stepper;
        if !memory.unloading.is_empty() {
            stepper.assembler.unload(memory.unloading);
        }
        match &self.pool {
            None => stepper.restore(memory.stepper)?,
            Some(pool) => pool.install(|| stepper.restore(memory.stepper))?,
        }
        if let Some(balance) = &mut self.balance {
            balance.restart(&stepper.new, stepper.time);
            balance.largest = memory.balance.unwrap_or(balance.largest);
        }
        Ok(())
    }
}
