//! What is told to the volume terms of bodies, or asked of them alone.

use super::{Assembler, StepView};
use crate::space::Region;
use std::sync::Arc;

impl<const D: usize> Assembler<D> {
    /// Take U at the nodes \[m\], the displacement that takes away the stress of the reference domain.
    pub fn unload(&mut self, unloading: Vec<f64>) {
        Arc::make_mut(&mut self.space).fabrics.unloading = unloading;
        self.regions.iter_mut().for_each(|region| region.take_fabric(&self.space));
    }

    /// The residual of the volume terms of one material of a region with its explicit part, given rows not zeroed, with or
    /// without its body force: its φ rows are the forces that all else exerts on the nodes of the body \[N/m\].
    pub fn volume_residual(
        &mut self,
        step: &StepView<'_>,
        (body, material): (Region, u16),
        with_force: bool,
        out: &mut [f64],
    ) {
        out.fill(0.0);
        let own = self.regions.iter_mut().filter(|r| r.body() == body && r.material() == Some(material));
        own.for_each(|region| region.whole_residual(step, with_force, out));
    }
}
