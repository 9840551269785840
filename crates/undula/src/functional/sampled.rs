//! Means, extremes and integrals of a quantity on boundaries and in regions, and its value at a point.
#![allow(non_snake_case)]

use super::force::Surfaces;
use super::quantity::{Quantity, Take};
use super::site::Place;
use super::{Functional, Snapshot};
use crate::element::{Quadrature, Shape, lagrange};
use crate::math::{Tensor, Vector};
use crate::mesh::{Locator, MeshError};
use crate::parallel::Reduce;
use crate::physics::axisymmetric;
use crate::sampling::{FacetPoint, fabric_at, facet_points, facet_points_of, fields_at, for_each_point_of};
use crate::space::{FsiSpace, Region, State};
use std::borrow::Cow;

/// The nodes `which` of cells of degree `degree` as the points of a rule.
fn nodes_of(shape: Shape, degree: usize, which: impl Iterator<Item = usize>) -> Quadrature {
    let points: Vec<[f64; 3]> = which.map(|a| lagrange::node(shape, degree, a)).collect();
    Quadrature { weights: vec![1.0; points.len()], points }
}

/// The solution to which a quantity belongs: the new one, or (1 − θ) U⁻ + θ U with the pressure of the step.
fn state_of<'a, const D: usize>(quantity: Quantity, at: &Snapshot<'a, D>) -> Cow<'a, State> {
    let theta = at.rule.theta;
    if theta == 1.0 || !quantity.at_force_time() {
        return Cow::Borrowed(at.new);
    }
    let between = |old: &[f64], new: &[f64]| -> Vec<f64> {
        old.iter().zip(new).map(|(old, new)| (1.0 - theta) * old + theta * new).collect()
    };
    let State { v, u, p, s } = at.new;
    Cow::Owned(State { v: between(&at.old.v, v), u: between(&at.old.u, u), p: p.clone(), s: s.clone() })
}

/// Sum and extremes of values.
struct Collected {
    sum: f64,
    size: f64,
    max: f64,
    min: f64,
}

impl Collected {
    fn new() -> Self {
        Collected { sum: 0.0, size: 0.0, max: f64::NEG_INFINITY, min: f64::INFINITY }
    }

    /// A value with the size of what it stands for.
    fn add(&mut self, value: f64, size: f64) {
        self.sum += size * value;
        self.size += size;
        self.max = self.max.max(value);
        self.min = self.min.min(value);
    }

    /// What all processes have collected; 0 where there was nothing.
    fn take<const D: usize>(mut self, take: Take, space: &FsiSpace<D>) -> f64 {
        let mut sums = [self.sum, self.size];
        space.reduce(Reduce::Sum, &mut sums);
        [self.sum, self.size] = sums;
        if take.is_extreme() {
            let how = if take == Take::Max { Reduce::Max } else { Reduce::Min };
            self.max = space.over_all(how, self.max);
            self.min = space.over_all(how, self.min);
        }
        match take {
            _ if self.size == 0.0 => 0.0,
            Take::Mean => self.sum / self.size,
            Take::Integral => self.sum,
            Take::Max => self.max,
            Take::Min => self.min,
        }
    }
}

/// A quantity on boundaries of the fluid, by the values in the cells of the fluid.
///
/// Integrals are those over the current boundary, ∫ f |J F⁻ᵀ n| ds.
pub struct OnBoundary<const D: usize> {
    quantity: Quantity,
    take: Take,
    /// Cell, points, and the basis of the pressure at each.
    facets: Vec<(usize, Vec<FacetPoint<D>>, Vec<Vec<f64>>)>,
}

impl<const D: usize> OnBoundary<D> {
    /// On those facets of the boundaries `names` that belong to the fluid.
    pub fn new(surfaces: &Surfaces<'_, D>, names: &[String], quantity: Quantity, take: Take) -> Self {
        let (space, facets, n) = surfaces.facets_on(names);
        let (shape, degree) = (space.mesh.shape, space.nodes.degree);
        let facets = facets.iter().map(|facet| {
            let points = if take.is_extreme() {
                let nodes = shape.facet_nodes(degree, facet.local as usize);
                facet_points_of(space, facet, &nodes_of(shape, degree, nodes.into_iter()))
            } else {
                facet_points(space, facet, n)
            };
            let cell = facet.cell as usize;
            let basis = |at: &FacetPoint<D>| space.pressure.basis(&space.mesh, cell, &at.xi, &at.x);
            let pressure = points.iter().map(basis).collect();
            (cell, points, pressure)
        });
        OnBoundary { quantity, take, facets: facets.collect() }
    }
}

impl<const D: usize> Functional<D> for OnBoundary<D> {
    fn unit(&self) -> &'static str {
        self.quantity.unit(if self.take == Take::Integral { 1 } else { 0 })
    }

    fn at_force_time(&self) -> bool {
        self.quantity.at_force_time()
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let state = state_of(self.quantity, at);
        let mut collected = Collected::new();
        for (cell, points, pressure) in &self.facets {
            let (nodes, dofs) = (at.space.nodes.cell(*cell), at.space.pressure.cell(*cell));
            let physics = at.physics.of(at.space.material[*cell]);
            for (point, basis) in points.iter().zip(pressure) {
                let mut fields = fields_at(nodes, &point.value, &point.grad, &state);
                fields.p = pressure_at(dofs, basis, &state);
                let (value, stretch) = match point.radius {
                    None => self.quantity.on_facet(&physics, &fields, point.normal),
                    Some(r) => {
                        let normal = axisymmetric::vector(&point.normal);
                        self.quantity.on_facet(&physics, &axisymmetric::fields_at(&fields, r), normal)
                    }
                };
                // The axis has a length, but no area.
                let on_axis = point.weight == 0.0 && self.take != Take::Integral;
                collected.add(value, if on_axis { point.length } else { point.weight * stretch });
            }
        }
        collected.take(self.take, at.space)
    }
}

/// A quantity in the cells of one body, or of one region of the mesh. Integrals are those over the current region, ∫ f J dx.
pub struct InRegion {
    place: Place,
    quantity: Quantity,
    take: Take,
    /// Gauss points per direction.
    quadrature: usize,
}

impl InRegion {
    /// In `place`, with so many Gauss points per direction.
    pub fn new(place: impl Into<Place>, quantity: Quantity, take: Take, quadrature: usize) -> Self {
        InRegion { place: place.into(), quantity, take, quadrature }
    }
}

impl<const D: usize> Functional<D> for InRegion {
    fn unit(&self) -> &'static str {
        self.quantity.unit(if self.take == Take::Integral { 2 } else { 0 })
    }

    fn at_force_time(&self) -> bool {
        self.quantity.at_force_time()
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let (shape, degree) = (at.space.mesh.shape, at.space.nodes.degree);
        let rule = match self.take.is_extreme() {
            true => nodes_of(shape, degree, 0..shape.n_nodes(degree)),
            false => Quadrature::cell(shape, self.quadrature),
        };
        let state = state_of(self.quantity, at);
        let mut collected = Collected::new();
        let wanted = |cell: usize| at.space.owns_cell(cell) && self.place.has(at.space, cell);
        for_each_point_of(at.space, &state, &rule, wanted, |point| {
            let physics = at.physics.of(at.space.material[point.cell]);
            let (fabric, fields, body) = (&point.fabric, &point.fields, self.place.body);
            let (value, J) = match at.space.coordinates.radius(&point.x) {
                None => self.quantity.inside(&physics, body, (fabric, fields)),
                Some(r) => {
                    let at = (&axisymmetric::fabric(fabric), &axisymmetric::fields_at(fields, r));
                    self.quantity.inside(&physics, body, at)
                }
            };
            collected.add(value, point.weight * J);
        });
        collected.take(self.take, at.space)
    }
}

/// A quantity at a material point: the mean over the cells of its body that meet there.
pub struct AtPoint<const D: usize> {
    quantity: Quantity,
    region: Region,
    /// Those that this process counts.
    cells: Vec<InCell<D>>,
    /// How many all processes have.
    number: usize,
}

/// A point in a cell, with the bases there.
struct InCell<const D: usize> {
    cell: usize,
    x: [f64; D],
    value: Vec<f64>,
    grad: Vec<[f64; D]>,
    pressure: Vec<f64>,
}

impl<const D: usize> AtPoint<D> {
    /// At the reference position `x` \[m\] in `place`; without it in the solid, if it reaches there.
    ///
    /// # Errors
    /// If `x` lies outside of the body, or of the mesh.
    pub fn new(
        space: &FsiSpace<D>,
        x: [f64; D],
        place: Option<Place>,
        quantity: Quantity,
    ) -> Result<Self, MeshError> {
        let (region, mut cells) = space.with_whole(|whole| AtPoint::find(whole, x, place))?;
        let number = cells.len();
        cells.retain_mut(|at| {
            let own = space.own_cell(at.cell);
            at.cell = own.unwrap_or(0);
            own.is_some()
        });
        Ok(AtPoint { quantity, region, cells, number })
    }

    /// The body and its cells that meet at `x` \[m\].
    fn find(
        space: &FsiSpace<D>,
        x: [f64; D],
        place: Option<Place>,
    ) -> Result<(Region, Vec<InCell<D>>), MeshError> {
        let locator = Locator::new(&space.mesh);
        let has = |place| meets(space, &locator, x, place);
        let found = match place {
            Some(place) => (place.body, has(place)),
            None => match has(Place::from(Region::Solid)) {
                cells if cells.is_empty() => (Region::Fluid, has(Place::from(Region::Fluid))),
                cells => (Region::Solid, cells),
            },
        };
        let (region, cells) = found;
        if cells.is_empty() {
            // Outside of the mesh, or of the body alone.
            locator.find(x)?;
            return Err(MeshError::OtherRegion { point: x.to_vec() });
        }
        Ok((region, cells))
    }
}

/// The cells of `place` in which `x` \[m\] lies, those whose side it lies on among them.
fn meets<const D: usize>(
    space: &FsiSpace<D>,
    locator: &Locator<'_, D>,
    x: [f64; D],
    place: Place,
) -> Vec<InCell<D>> {
    let mut found: Vec<InCell<D>> = vec![];
    let wanted = |found: &[InCell<D>], cell: usize| {
        place.has(space, cell) && found.iter().all(|other| other.cell != cell)
    };
    while let Ok(place) =
        locator.find_where(x, if found.is_empty() { NEAR } else { TOUCHING }, |cell| wanted(&found, cell))
    {
        found.push(in_cell(space, place.cell, place.xi));
    }
    found
}

/// A point may lie outside of a body by this part of the size of a cell: curved boundaries of coarse meshes.
const NEAR: f64 = 1e-3;
/// A cell further away than this part of its size does not meet the point.
const TOUCHING: f64 = 1e-8;

fn in_cell<const D: usize>(space: &FsiSpace<D>, cell: usize, xi: [f64; D]) -> InCell<D> {
    let FsiSpace { mesh, nodes, pressure, .. } = space;
    let mut point = [0.0; 3];
    point[..D].copy_from_slice(&xi);
    let table = nodes.table(mesh.shape, &Quadrature { points: vec![point], weights: vec![1.0] });
    let map = Tensor(mesh.map_gradient(cell, xi));
    let inverse_t = map.cofactor() * (1.0 / map.det());
    let along = |a: usize| (inverse_t * Vector(std::array::from_fn(|d| table.grad(0)[a * D + d]))).0;
    let x = mesh.map(cell, xi);
    InCell {
        cell,
        x,
        value: table.value(0).to_vec(),
        grad: (0..table.n_basis).map(along).collect(),
        pressure: pressure.basis(mesh, cell, &xi, &x),
    }
}

/// The pressure where its basis has the values `basis`; 0 without unknowns.
fn pressure_at(dofs: &[u32], basis: &[f64], state: &State) -> f64 {
    dofs.iter().zip(basis).map(|(&dof, b)| b * state.p[dof as usize]).sum()
}

impl<const D: usize> Functional<D> for AtPoint<D> {
    fn unit(&self) -> &'static str {
        self.quantity.unit(0)
    }

    fn at_force_time(&self) -> bool {
        self.quantity.at_force_time()
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        let state = state_of(self.quantity, at);
        let value = |InCell { cell, x, value, grad, pressure }: &InCell<D>| {
            let mut fields = fields_at(at.space.nodes.cell(*cell), value, grad, &state);
            fields.p = pressure_at(at.space.pressure.cell(*cell), pressure, &state);
            let physics = at.physics.of(at.space.material[*cell]);
            let fabric = fabric_at(at.space, *cell, x, (value, grad));
            let inside = match at.space.coordinates.radius(x) {
                None => self.quantity.inside(&physics, self.region, (&fabric, &fields)),
                Some(r) => {
                    let at = (&axisymmetric::fabric(&fabric), &axisymmetric::fields_at(&fields, r));
                    self.quantity.inside(&physics, self.region, at)
                }
            };
            inside.0
        };
        at.space.sum(self.cells.iter().map(value).sum::<f64>()) / self.number as f64
    }
}
