//! Force of the fluid on boundaries.
#![allow(non_snake_case)]

use super::{Functional, Snapshot};
use crate::math::{Tensor, Vector};
use crate::mesh::{Facet, Side};
use crate::physics::kinematics::cofactor;
use crate::physics::{Fields, Fluid, Kinematics, axisymmetric};
use crate::sampling::{FacetPoint, facet_points, fields_at};
use crate::space::normals::normals;
use crate::space::{BoundaryCondition, FluidBoundary, FluidFacet, FsiSpace, State};
use std::collections::BTreeMap;

/// Boundaries of the fluid of which forces are asked for.
pub struct Surfaces<'a, const D: usize> {
    space: &'a FsiSpace<D>,
    boundary: FluidBoundary,
    /// By facet: whether the traction is given there, or the fluid goes on behind it, and the velocity is not given.
    natural: Vec<bool>,
    /// By facet: whether nothing is exerted along it, for the condition is `slip`.
    smooth: Vec<bool>,
    /// Normals at the nodes of boundaries with `slip`, orthonormal.
    normals: BTreeMap<u32, Vec<Vector<f64, D>>>,
    quadrature: usize,
}

/// A part of a unit normal that is rounding.
const STRAIGHT: f64 = 1e-9;

impl<'a, const D: usize> Surfaces<'a, D> {
    /// All boundaries of the fluid, with one condition per boundary of the mesh and `n` Gauss points.
    pub fn new(space: &'a FsiSpace<D>, conditions: &[BoundaryCondition<D>], n: usize) -> Self {
        let boundary = FluidBoundary::new(space);
        let outflow = |b: u16| matches!(conditions[b as usize], BoundaryCondition::Outflow { .. });
        let natural = boundary
            .facets
            .iter()
            .map(|f| f.at_seam || !f.at_solid && f.boundary.is_some_and(outflow))
            .collect();
        let slip = |b: u16| matches!(conditions[b as usize], BoundaryCondition::Slip);
        let is_smooth = |f: &FluidFacet| !f.at_solid && f.boundary.is_some_and(slip);
        let smooth: Vec<bool> = boundary.facets.iter().map(is_smooth).collect();
        let slips = space.mesh.facets.iter().filter(|f| slip(f.boundary));
        let normals = normals(space, slips);
        Surfaces { space, boundary, natural, smooth, normals, quadrature: n }
    }

    /// Whether the facet of number `n`, one with `slip`, takes part in the residual along `direction`.
    fn presses(&self, n: usize, direction: Vector<f64, D>) -> bool {
        let points = facet_points(self.space, &self.boundary.facets[n].facet(), self.quadrature);
        points.iter().any(|point| {
            let normal = point.normal;
            normal.dot(direction).abs() > STRAIGHT * normal.dot(normal).sqrt()
        })
    }

    /// The facets of the list that take part in the residual of `node`, direction by direction: projections that sum up to
    /// the identity.
    fn by_direction(&self, node: u32, list: &[usize]) -> Vec<(Tensor<f64, D>, Vec<usize>)> {
        let smooth = list.iter().any(|&n| self.smooth[n]);
        let normals = self.normals.get(&node).filter(|_| smooth).map_or(&[][..], Vec::as_slice);
        let mut along = Tensor::identity();
        let mut found = vec![];
        for &normal in normals {
            let across = Tensor(normal.0.map(|n| normal.0.map(|m| n * m)));
            along -= across;
            let takes_part = |&&n: &&usize| !self.smooth[n] || self.presses(n, normal);
            found.push((across, list.iter().filter(takes_part).copied().collect()));
        }
        found.push((along, list.iter().filter(|&&n| !self.smooth[n]).copied().collect()));
        found
    }

    /// Whether each facet belongs to one of the boundaries `names`.
    fn of(&self, names: &[String]) -> Vec<bool> {
        let mut on = vec![false; self.boundary.facets.len()];
        for name in names {
            self.boundary.numbers(&self.space.boundary_facets(name)).into_iter().for_each(|n| on[n] = true);
        }
        on
    }

    /// The facets of the boundaries `names` as seen from the fluid, the space, and the Gauss points per direction.
    pub(super) fn facets_on(&self, names: &[String]) -> (&'a FsiSpace<D>, Vec<Facet>, usize) {
        let on = self.of(names);
        let facets = (0..on.len()).filter(|&n| on[n] && self.counts(n));
        let facets = facets.map(|n| self.boundary.facets[n].facet());
        (self.space, facets.collect(), self.quadrature)
    }

    /// Whether this process counts the facet of number `n` in sums.
    fn counts(&self, n: usize) -> bool {
        self.space.owns_cell(self.boundary.facets[n].side.cell as usize)
    }

    /// The nodes of the boundaries `names` at which power may flow: where the velocity is given, ascending.
    pub(super) fn nodes_on(&self, names: &[String]) -> Vec<u32> {
        self.carrying(&self.of(names), |n| !self.smooth[n]).into_keys().collect()
    }

    pub(super) fn nodes(&self, n: usize) -> Vec<u32> {
        self.space.facet_nodes(&self.boundary.facets[n].facet())
    }

    /// The facet of number `n` with the weights that `factor` gives to its points.
    fn tractions(&self, n: usize, factor: impl Fn(&FacetPoint<D>) -> Tensor<f64, D>) -> Tractions<D> {
        let (space, facet) = (self.space, self.boundary.facets[n].facet());
        let cell = facet.cell as usize;
        let at = |point: FacetPoint<D>| {
            let pressure = space.pressure.basis(&space.mesh, cell, &point.xi, &point.x);
            (factor(&point) * point.weight, point, pressure)
        };
        Tractions { cell, points: facet_points(space, &facet, self.quadrature).into_iter().map(at).collect() }
    }

    /// The same, tested with the basis functions of some of its nodes, and mapped by their factors.
    pub(super) fn tested(&self, n: usize, at: &[(u32, Tensor<f64, D>)]) -> Tractions<D> {
        let nodes = self.space.nodes.cell(self.boundary.facets[n].side.cell as usize);
        // A cell between two sides of a seam has a node twice.
        let places = |node: u32| (0..nodes.len()).filter(move |&a| nodes[a] == node);
        let terms: Vec<(usize, Tensor<f64, D>)> =
            at.iter().flat_map(|&(node, factor)| places(node).map(move |a| (a, factor))).collect();
        self.tractions(n, |point| {
            terms.iter().fold(Tensor::zero(), |sum, &(a, factor)| sum + factor * point.value[a])
        })
    }

    /// For each node of this process on the facets `on` all facets there that take part in its residual, of those that `counts` is true of.
    fn carrying(&self, on: &[bool], counts: impl Fn(usize) -> bool) -> BTreeMap<u32, Vec<usize>> {
        let carries = |&n: &usize| !self.natural[n] && counts(n);
        let mut at_node: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for n in (0..on.len()).filter(|&n| on[n]).filter(carries) {
            let own = self.nodes(n).into_iter().filter(|&node| self.space.owns_node(node as usize));
            at_node.extend(own.map(|node| (node, vec![])));
        }
        for n in (0..on.len()).filter(carries) {
            for node in self.nodes(n) {
                if let Some(list) = at_node.get_mut(&node) {
                    list.push(n);
                }
            }
        }
        at_node
    }

    /// What the boundaries `names` take of the residual of the fluid.
    pub(super) fn shares(&self, names: &[String]) -> Shares<D> {
        let on = self.of(names);
        let at_node = self.carrying(&on, |_| true);
        let (mut whole, mut shared) = (vec![], vec![]);
        let mut integrals: BTreeMap<usize, Vec<(u32, Tensor<f64, D>)>> = BTreeMap::new();
        for (&node, list) in &at_node {
            if list.iter().all(|&n| on[n]) {
                whole.push(node);
                continue;
            }
            let mut all = Tensor::zero();
            for (projection, list) in self.by_direction(node, list) {
                let size = |part: bool| -> f64 {
                    list.iter().filter(|&&n| on[n] == part).map(|&n| self.measure(n)).sum()
                };
                let (own, other) = (size(true), size(false));
                if own == 0.0 {
                    continue;
                }
                let part = own / (own + other);
                all += projection * part;
                for &n in list.iter().filter(|_| other > 0.0) {
                    let factor = if on[n] { 1.0 - part } else { -part };
                    integrals.entry(n).or_default().push((node, projection * factor));
                }
            }
            shared.push((node, all));
        }
        let nodes = at_node.keys().copied().collect();
        let (seams, outflow) = (0..on.len())
            .filter(|&n| on[n] && self.natural[n] && self.counts(n))
            .partition(|&n| self.boundary.facets[n].at_seam);
        Shares { nodes, whole, shared, integrals, outflow, seams }
    }

    /// Length or area of the facet of number `n` on the reference domain.
    fn measure(&self, n: usize) -> f64 {
        facet_points(self.space, &self.boundary.facets[n].facet(), self.quadrature)
            .iter()
            .map(|p| p.weight)
            .sum()
    }
}

/// What boundaries take of the residual of the fluid, node by node.
pub(super) struct Shares<const D: usize> {
    /// All nodes whose residual is read.
    pub(super) nodes: Vec<u32>,
    /// Nodes that belong to the boundaries alone.
    pub(super) whole: Vec<u32>,
    /// Nodes that belong to them in part, and that part.
    pub(super) shared: Vec<(u32, Tensor<f64, D>)>,
    /// By facet the nodes of the latter at which its integral counts, with the factor.
    pub(super) integrals: BTreeMap<usize, Vec<(u32, Tensor<f64, D>)>>,
    /// Facets with an outflow condition.
    pub(super) outflow: Vec<usize>,
    /// Facets at seams.
    seams: Vec<usize>,
}

/// −R_f(e_i): the residual of the fluid alone, tested with e_i on the nodes of the boundaries and 0 elsewhere. On
/// a whole body it converges with twice the order of the surface integral.
///
/// A node at which the boundaries end belongs to its facets on both sides: R_a = Σ_f ∫_f J σ F⁻ᵀ n φ_a + d_a. Each
/// facet takes its own integral, and a part of the rest d_a in proportion to its size. So forces on parts add up
/// to that on the whole to rounding, they are exact where the discrete solution is, and elsewhere the last facet
/// alone errs as the surface integral does. A facet with an outflow condition takes the traction that the
/// condition gives it, of which R_a contains nothing. A facet of a periodic boundary takes its surface integral. Along
/// a boundary with `slip` nothing is exerted, so that nodes at its rim belong wholly to its neighbours in these directions,
/// whatever they are: parts of a node are maps of its residual.
///
/// A residual over fluid and solid would contain the inertia of the body, which is force only when steady.
pub struct ForceByResidual<const D: usize> {
    /// All nodes whose residual is read.
    nodes: Vec<u32>,
    /// Nodes that belong to the boundaries alone.
    whole: Vec<u32>,
    /// Nodes that belong to them in part, and that part.
    shared: Vec<(u32, Tensor<f64, D>)>,
    /// Surface integrals at the latter.
    tractions: Vec<Tractions<D>>,
    /// Facets with an outflow condition, and whether there are some, on any of the processes that share the space.
    outflow: Vec<Side>,
    flows_out: bool,
    component: usize,
    factor: f64,
    unit: &'static str,
}

impl<const D: usize> ForceByResidual<D> {
    /// On the boundaries `names`; the value is multiplied by `factor` and has then the unit `unit`.
    pub fn new(
        surfaces: &Surfaces<'_, D>,
        names: &[String],
        component: usize,
        factor: f64,
        unit: &'static str,
    ) -> Self {
        let Shares { nodes, whole, shared, integrals, outflow, seams } = surfaces.shares(names);
        ForceByResidual {
            nodes,
            whole,
            shared,
            tractions: {
                let tested = integrals.iter().map(|(&n, at)| surfaces.tested(n, at));
                // Residuals contain nothing of the tractions at seams.
                tested
                    .chain(seams.into_iter().map(|n| surfaces.tractions(n, |_| Tensor::identity())))
                    .collect()
            },
            flows_out: surfaces.space.any(!outflow.is_empty()),
            outflow: outflow.into_iter().map(|n| surfaces.boundary.facets[n].side).collect(),
            component,
            factor,
            unit,
        }
    }
}

impl<const D: usize> Functional<D> for ForceByResidual<D> {
    fn unit(&self) -> &'static str {
        self.unit
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn residual_nodes(&self) -> &[u32] {
        &self.nodes
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let residual = |n: u32, i: usize| at.fluid_residual[n as usize * D + i];
        let mut sum: f64 = self.whole.iter().map(|&n| residual(n, self.component)).sum();
        for (node, part) in &self.shared {
            let row = part.0[self.component];
            sum += (0..D).map(|i| row[i] * residual(*node, i)).sum::<f64>();
        }
        for tractions in &self.tractions {
            sum += tractions.sum(at).0[self.component];
        }
        // What the condition adds to the residual makes it vanish.
        if let (Some(system), true) = (at.system, self.flows_out) {
            sum -= system.force_through(&at.step(), &self.outflow).0[self.component];
        }
        -self.factor * at.space.sum(sum)
    }
}

/// ∫ J σ_f F⁻ᵀ n ds, n pointing into the fluid: the cross-check of [`ForceByResidual`].
pub struct ForceBySurface<const D: usize> {
    facets: Vec<Tractions<D>>,
    component: usize,
    factor: f64,
    unit: &'static str,
}

impl<const D: usize> ForceBySurface<D> {
    /// On those facets of the boundaries `names` that belong to the fluid.
    pub fn new(
        surfaces: &Surfaces<'_, D>,
        names: &[String],
        component: usize,
        factor: f64,
        unit: &'static str,
    ) -> Self {
        let on = surfaces.of(names);
        let counted = (0..on.len()).filter(|&n| on[n] && surfaces.counts(n));
        let facets = counted.map(|n| surfaces.tractions(n, |_| Tensor::identity())).collect();
        ForceBySurface { facets, component, factor, unit }
    }
}

impl<const D: usize> Functional<D> for ForceBySurface<D> {
    fn unit(&self) -> &'static str {
        self.unit
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let sum: f64 = self.facets.iter().map(|facet| facet.sum(at).0[self.component]).sum();
        -self.factor * at.space.sum(sum)
    }
}

/// The traction of the fluid at the quadrature points of a facet.
pub(super) struct Tractions<const D: usize> {
    cell: usize,
    /// Map with the weight, point, and the basis of the pressure there.
    points: Vec<(Tensor<f64, D>, FacetPoint<D>, Vec<f64>)>,
}

impl<const D: usize> Tractions<D> {
    /// Sum of the maps of J σ F⁻ᵀ n, n pointing out of the fluid, over the points and in the mean over the step.
    pub(super) fn sum(&self, at: &Snapshot<'_, D>) -> Vector<f64, D> {
        let (nodes, dofs) = (at.space.nodes.cell(self.cell), at.space.pressure.cell(self.cell));
        let fluid = at.physics.of(at.space.material[self.cell]).fluid;
        let theta = at.rule.theta;
        let mut sum = Vector::zero();
        for (weight, point, basis) in &self.points {
            let p: f64 = dofs.iter().zip(basis).map(|(&dof, b)| b * at.new.p[dof as usize]).sum();
            let fields = |state: &State| fields_at(nodes, &point.value, &point.grad, state);
            let mut add = |part: f64, fields: &Fields<f64, D>| {
                let traction = match point.radius {
                    None => traction(fluid, fields, p, point.normal),
                    Some(r) => {
                        let fields = axisymmetric::fields_at(fields, r);
                        axisymmetric::plane(&traction(fluid, &fields, p, axisymmetric::vector(&point.normal)))
                    }
                };
                sum += *weight * traction * part;
            };
            if at.rule.quadrature.is_empty() {
                add(theta, &fields(at.new));
                if theta < 1.0 {
                    add(1.0 - theta, &fields(at.old));
                }
            } else {
                let (old, new) = (fields(at.old), fields(at.new));
                at.rule.gauss_points::<D>().iter().for_each(|&(part, tau)| add(part, &old.lerp(&new, tau)));
            }
        }
        sum
    }
}

/// J σ F⁻ᵀ n of `fluid` at a point, with the pressure `p`.
fn traction<const D: usize>(
    fluid: Option<Fluid>,
    fields: &Fields<f64, D>,
    p: f64,
    normal: Vector<f64, D>,
) -> Vector<f64, D> {
    let Kinematics { F_inv, .. } = Kinematics::of(&fields.grad_u);
    let grad_v = fields.grad_v * F_inv;
    let friction = fluid.map_or(Tensor::zero(), |fluid| fluid.friction(grad_v, grad_v));
    let sigma = friction - p * Tensor::identity();
    sigma * (cofactor(&fields.grad_u) * normal)
}
