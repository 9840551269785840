//! The energy of one body in a step: what it has, gets, carries off and dissipates.
//!
//! The momentum equation of a step, tested with the mean velocity v̄ = ½ (v⁻ + v), says of a body
//!
//! (E − E⁻)/k + C + D = P_f + P_∂ + P_I + r
//!
//! with its kinetic and stored energy E, the kinetic energy C that the flow carries out of it, the dissipation D, and the
//! power of the body force, of all that acts on its boundaries, and of the bodies that it touches. r is what the scheme
//! adds: nothing where it conserves energy, else a power of the step of its order. The powers are those of forces at the
//! nodes, R(v̄) with the residual R of the volume terms of the body, so that P_I of two bodies that touch are opposite.
#![allow(non_snake_case)]

use super::energy::dissipated;
use super::{Functional, Snapshot};
use crate::choice::{Choice, choice};
use crate::element::Quadrature;
use crate::math::Tensor;
use crate::parallel::Reduce;
use crate::physics::{Fabric, Fields, Kinematics, axisymmetric};
use crate::sampling::{PointValues, fields_at, for_each_point_of};
use crate::space::{FsiSpace, Region};
use crate::system::{Assembler, Physics, StepView};

/// A part of the balance.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// ½ (ρ J v, v) at the new time \[J/m\].
    Kinetic,
    /// Stored energy at the new time \[J/m\].
    Stored,
    /// (E − E⁻)/k \[W/m\].
    Rate,
    /// C \[W/m\].
    Carried,
    /// D \[W/m\].
    Dissipation,
    /// P_f \[W/m\].
    Force,
    /// P_∂ \[W/m\].
    Boundaries,
    /// P_I \[W/m\].
    Interface,
    /// r \[W/m\].
    Residual,
}

/// Their names in a case.
pub static PARTS: [Choice<Part>; 9] = [
    choice("kinetic", Part::Kinetic, "kinetic energy [J/m]"),
    choice("stored", Part::Stored, "stored energy of a solid [J/m]"),
    choice("rate", Part::Rate, "rate of both in the step [W/m]"),
    choice("carried", Part::Carried, "kinetic energy that a flow carries out [W/m]"),
    choice("dissipation", Part::Dissipation, "power that viscosity and damping dissipate [W/m]"),
    choice("force", Part::Force, "power of the body force [W/m]"),
    choice("boundaries", Part::Boundaries, "power of what acts on the outer boundaries [W/m]"),
    choice("interface", Part::Interface, "power of the bodies that it touches [W/m]"),
    choice(
        "residual",
        Part::Residual,
        "rate + carried + dissipation − all powers: what the scheme adds [W/m]",
    ),
];

impl Part {
    /// Whether it is a mean over the step.
    pub fn is_of_step(self) -> bool {
        !matches!(self, Part::Kinetic | Part::Stored)
    }
}

/// A kind of body with its material.
pub type Body = (Region, u16);

/// The residual of the volume terms of a body in a step, with and without its body force \[N/m\].
pub struct BodyResidual {
    body: Body,
    values: [Vec<f64>; 2],
}

impl BodyResidual {
    /// Room for each of `bodies`.
    pub fn of(bodies: impl Iterator<Item = Body>) -> Vec<BodyResidual> {
        let mut list: Vec<BodyResidual> = vec![];
        for body in bodies {
            if list.iter().all(|other| other.body != body) {
                list.push(BodyResidual { body, values: [vec![], vec![]] });
            }
        }
        list
    }

    /// Take those of `step`.
    pub fn fill<const D: usize>(&mut self, assembler: &mut Assembler<D>, step: &StepView<'_>) {
        for (values, with_force) in self.values.iter_mut().zip([true, false]) {
            values.resize(assembler.n_unknowns(), 0.0);
            assembler.volume_residual(step, self.body, with_force, values);
        }
    }
}

/// A part of the balance of one body.
pub struct BodyEnergy {
    body: Body,
    part: Part,
    quadrature: usize,
    /// Whether each node is shared with another body.
    shared: Vec<bool>,
}

impl BodyEnergy {
    /// Of `body`, with so many Gauss points per direction.
    pub fn new<const D: usize>(space: &FsiSpace<D>, body: Body, part: Part, quadrature: usize) -> BodyEnergy {
        let mut found = vec![[false; 2]; space.nodes.len()];
        for cell in 0..space.mesh.n_cells() {
            let other = (space.regions[cell], space.material[cell]) != body;
            space.nodes.cell(cell).iter().for_each(|&node| found[node as usize][usize::from(other)] = true);
        }
        let shared = found.into_iter().map(|[own, other]| own && other).collect();
        BodyEnergy { body, part, quadrature, shared }
    }

    /// ∫ of `density` of the fields at the new and at the old time over the reference domain.
    fn integral<const D: usize>(
        &self,
        at: &Snapshot<'_, D>,
        density: impl Fn(&PointValues<'_, D>, &Fields<f64, D>) -> f64,
    ) -> f64 {
        let rule = Quadrature::cell(at.space.mesh.shape, self.quadrature);
        let is_of_body = |cell: usize| (at.space.regions[cell], at.space.material[cell]) == self.body;
        let own = |cell: usize| at.space.owns_cell(cell) && is_of_body(cell);
        let mut sum = 0.0;
        for_each_point_of(at.space, at.new, &rule, own, |point| {
            let old = fields_at(at.space.nodes.cell(point.cell), point.value, point.grad, at.old);
            sum += point.weight * density(point, &old);
        });
        at.space.sum(sum)
    }

    /// ½ ρ J |v|² and the stored energy per volume of the reference domain at `fields`.
    fn energies<const D: usize>(
        &self,
        at: &Snapshot<'_, D>,
        point: &PointValues<'_, D>,
        fields: &Fields<f64, D>,
    ) -> [f64; 2] {
        let (body, physics) = (self.body.0, at.physics.of(self.body.1));
        match at.space.coordinates.radius(&point.x) {
            None => energies(body, &physics, (&point.fabric, fields)),
            Some(r) => {
                let fabric = axisymmetric::fabric(&point.fabric);
                energies(body, &physics, (&fabric, &axisymmetric::fields_at(fields, r)))
            }
        }
    }

    /// What the flow carries out, and what is dissipated, per volume of the reference domain.
    fn losses<const D: usize>(
        &self,
        at: &Snapshot<'_, D>,
        point: &PointValues<'_, D>,
        old: &Fields<f64, D>,
    ) -> [f64; 2] {
        let (body, physics, per_k) = (self.body.0, at.physics.of(self.body.1), at.rule.per_k);
        match at.space.coordinates.radius(&point.x) {
            None => losses(body, &physics, [&point.fields, old], per_k),
            Some(r) => {
                let [new, old] = [&point.fields, old].map(|fields| axisymmetric::fields_at(fields, r));
                losses(body, &physics, [&new, &old], per_k)
            }
        }
    }

    /// Power of the body force, on the outer boundaries and at other bodies.
    fn powers<const D: usize>(&self, at: &Snapshot<'_, D>) -> [f64; 3] {
        let Some(BodyResidual { values: [with, without], .. }) =
            at.volume.iter().find(|residual| residual.body == self.body)
        else {
            return [0.0; 3];
        };
        let mut powers = [0.0; 3];
        let entries = at.old.v.iter().zip(&at.new.v).enumerate();
        for (n, (old, new)) in entries.filter(|(n, _)| at.space.owns_node(n / D)) {
            let mean = 0.5 * (old + new);
            powers[0] += mean * (without[n] - with[n]);
            powers[if self.shared[n / D] { 2 } else { 1 }] += mean * with[n];
        }
        at.space.reduce(Reduce::Sum, &mut powers);
        powers
    }
}

/// ½ ρ J |v|² and the stored energy per volume of the reference domain.
fn energies<const D: usize>(
    body: Region,
    physics: &Physics,
    (fabric, fields): (&Fabric<f64, D>, &Fields<f64, D>),
) -> [f64; 2] {
    let square = 0.5 * fields.v.dot(fields.v);
    match (body, physics.fluid, physics.solid) {
        (Region::Fluid, Some(fluid), _) => {
            [fluid.rho * (Tensor::identity() + fields.grad_u).det() * square, 0.0]
        }
        (Region::Solid, _, Some(solid)) => [solid.rho * square, solid.stored(fabric, fields)],
        _ => [0.0; 2],
    }
}

/// What the flow carries out, and what is dissipated, in a step of 1/`per_k`.
fn losses<const D: usize>(
    body: Region,
    physics: &Physics,
    [new, old]: [&Fields<f64, D>; 2],
    per_k: f64,
) -> [f64; 2] {
    let mean = old.lerp(new, 0.5);
    match (body, physics.fluid, physics.solid) {
        (Region::Fluid, Some(fluid), _) => {
            let Kinematics { F_inv, J, .. } = Kinematics::of(&mean.grad_u);
            let carrier = mean.v - (new.u - old.u) * per_k;
            let transport = J * (mean.grad_v * (F_inv * carrier)).dot(mean.v);
            let volume = |fields: &Fields<f64, D>| (Tensor::identity() + fields.grad_u).det();
            let growth = (volume(new) - volume(old)) * per_k;
            let square = 0.25 * (new.v.dot(new.v) + old.v.dot(old.v));
            [fluid.rho * (transport - growth * square), dissipated(&fluid, &mean)]
        }
        (Region::Solid, _, Some(solid)) => [0.0, solid.dissipated(&mean)],
        _ => [0.0; 2],
    }
}

impl<const D: usize> Functional<D> for BodyEnergy {
    fn unit(&self) -> &'static str {
        if self.part.is_of_step() { "W/m" } else { "J/m" }
    }

    fn at_force_time(&self) -> bool {
        self.part.is_of_step()
    }

    fn residual_body(&self) -> Option<Body> {
        let of_forces = [Part::Force, Part::Boundaries, Part::Interface, Part::Residual];
        of_forces.contains(&self.part).then_some(self.body)
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let rate = || {
            self.integral(at, |point, old| {
                let [new, old] =
                    [&point.fields, old].map(|fields| self.energies(at, point, fields).iter().sum::<f64>());
                (new - old) * at.rule.per_k
            })
        };
        let loss = |n: usize| self.integral(at, |point, old| self.losses(at, point, old)[n]);
        match self.part {
            Part::Kinetic => self.integral(at, |point, _| self.energies(at, point, &point.fields)[0]),
            Part::Stored => self.integral(at, |point, _| self.energies(at, point, &point.fields)[1]),
            Part::Rate => rate(),
            Part::Carried => loss(0),
            Part::Dissipation => loss(1),
            Part::Force => self.powers(at)[0],
            Part::Boundaries => self.powers(at)[1],
            Part::Interface => self.powers(at)[2],
            Part::Residual => rate() + loss(0) + loss(1) - self.powers(at).iter().sum::<f64>(),
        }
    }
}
