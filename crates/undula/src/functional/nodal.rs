//! Fields at the nodes that are derived from the solution.
#![allow(non_snake_case)]

use super::quantity::{VON_MISES, WALL_SHEAR_STRESS, wall_shear};
use crate::choice::{Choice, choice};
use crate::element::{Quadrature, lagrange};
use crate::math::{Tensor, Vector};
use crate::physics::kinematics::cofactor;
use crate::physics::stress::{green_lagrange, in_space, principal, von_mises};
use crate::physics::{Fabric, Fields, Kinematics, axisymmetric};
use crate::sampling::{FacetPoint, facet_points_of, fields_at, for_each_point_of};
use crate::space::{FluidBoundary, FluidFacet, FsiSpace, Region, State};
use crate::system::Physics;

/// A field of the output.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum NodalField {
    /// v.
    Velocity,
    /// u.
    Displacement,
    /// p.
    Pressure,
    /// Cauchy stress, all nine components.
    Stress,
    /// Equivalent stress after von Mises.
    VonMises,
    /// The larger and the smaller principal stress in the plane, and the stress across it; in space all by size.
    PrincipalStress,
    /// Green-Lagrange strain of the solid, all nine components.
    Strain,
    /// J.
    Jacobian,
    /// Curl of v of the fluid in the current coordinates.
    Vorticity,
    /// What the fluid exerts along its walls, per area.
    WallShearStress,
}

/// Their names in a case.
pub static FIELDS: [Choice<NodalField>; 10] = [
    choice("velocity", NodalField::Velocity, "velocity [m/s]"),
    choice("displacement", NodalField::Displacement, "displacement [m]; its array is `deformation`"),
    choice("pressure", NodalField::Pressure, "pressure [Pa]; 0 in a compressible solid"),
    choice("stress", NodalField::Stress, "Cauchy stress of each body [Pa], 9 components"),
    choice(VON_MISES, NodalField::VonMises, "equivalent stress of each body after von Mises [Pa]"),
    choice(
        "principal-stress",
        NodalField::PrincipalStress,
        "principal stresses of each body [Pa]: larger, smaller, across the plane; in space by size",
    ),
    choice("strain", NodalField::Strain, "Green-Lagrange strain of the solid, 9 components"),
    choice("jacobian", NodalField::Jacobian, "J of each body"),
    choice("vorticity", NodalField::Vorticity, "curl of the velocity of the fluid [1/s]"),
    choice(WALL_SHEAR_STRESS, NodalField::WallShearStress, "wall shear stress [Pa], 0 off the walls"),
];

/// What is written unless a case says else.
pub const DEFAULT_FIELDS: [NodalField; 3] =
    [NodalField::Velocity, NodalField::Displacement, NodalField::Pressure];

impl NodalField {
    /// Whether it has values of their own in `region`: an array for each body that has some.
    pub fn is_derived_in(self, region: Region) -> bool {
        use NodalField::*;
        match self {
            Stress | VonMises | PrincipalStress | Jacobian => true,
            Strain => region == Region::Solid,
            Vorticity => region == Region::Fluid,
            Velocity | Displacement | Pressure | WallShearStress => false,
        }
    }

    /// Numbers per node in `dim` dimensions.
    pub fn components(self, dim: usize) -> usize {
        use NodalField::*;
        match self {
            Stress | Strain => 9,
            PrincipalStress => 3,
            Velocity | Displacement | WallShearStress => dim,
            Vorticity if dim == 3 => 3,
            Pressure | VonMises | Jacobian | Vorticity => 1,
        }
    }

    /// Add the value at a point of `region` to `sum`.
    fn add<const D: usize>(
        self,
        physics: &Physics,
        region: Region,
        (fabric, at): (&Fabric<f64, D>, &Fields<f64, D>),
        sum: &mut [f64],
    ) {
        let sigma = || match region {
            Region::Fluid => physics.fluid.map_or(Tensor::zero(), |fluid| fluid.cauchy(at)),
            Region::Solid => physics.solid.map_or(Tensor::zero(), |solid| solid.cauchy(fabric, at)),
        };
        let mut add = |values: &[f64]| sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        match self {
            NodalField::Stress => add(sigma().0.as_flattened()),
            NodalField::VonMises => add(&[von_mises(&sigma())]),
            NodalField::PrincipalStress => {
                let sigma = sigma();
                if D == 3 {
                    let [least, middle, largest] = principal::<3>(&sigma);
                    add(&[largest, middle, least]);
                } else {
                    let [less, more] = principal::<2>(&sigma);
                    add(&[more, less, sigma.0[2][2]]);
                }
            }
            NodalField::Strain => add(green_lagrange(&in_space(&at.grad_u)).0.as_flattened()),
            NodalField::Jacobian => add(&[(Tensor::identity() + at.grad_u).det()]),
            NodalField::Vorticity => {
                let grad_v = at.grad_v * Kinematics::of(&at.grad_u).F_inv;
                let about = |i: usize, j: usize| grad_v.0[j][i] - grad_v.0[i][j];
                if D == 3 { add(&[about(1, 2), about(2, 0), about(0, 1)]) } else { add(&[about(0, 1)]) }
            }
            _ => {}
        }
    }
}

/// A derived field in `region` at the nodes, `n_nodes × components`: the mean over the cells of the region that meet
/// at a node, NaN at nodes where there is none.
pub fn in_body<const D: usize>(
    space: &FsiSpace<D>,
    physics: &Physics,
    state: &State,
    field: NodalField,
    region: Region,
) -> Vec<f64> {
    let (shape, degree, n) = (space.mesh.shape, space.nodes.degree, field.components(D));
    let per_cell = shape.n_nodes(degree);
    let points: Vec<[f64; 3]> = (0..per_cell).map(|a| lagrange::node(shape, degree, a)).collect();
    let rule = Quadrature { weights: vec![1.0; per_cell], points };
    let mut values = vec![0.0; space.nodes.n_lagrange * n];
    let (mut count, mut visited) = (vec![0.0; space.nodes.n_lagrange], 0);
    for_each_point_of(
        space,
        state,
        &rule,
        |cell| space.regions[cell] == region,
        |point| {
            let node = space.nodes.cell(point.cell)[visited % per_cell] as usize;
            visited += 1;
            let physics = physics.of(space.material[point.cell]);
            let (sum, fabric) = (&mut values[node * n..(node + 1) * n], &point.fabric);
            match space.coordinates.radius(&point.x) {
                None => field.add(&physics, region, (fabric, &point.fields), sum),
                Some(r) => {
                    let at = (&axisymmetric::fabric(fabric), &axisymmetric::fields_at(&point.fields, r));
                    field.add(&physics, region, at, sum);
                }
            }
            count[node] += 1.0;
        },
    );
    for (values, count) in values.chunks_exact_mut(n).zip(count) {
        // 0/0 is NaN.
        values.iter_mut().for_each(|value| *value /= count);
    }
    values
}

/// The wall shear stress at the nodes of the walls.
///
/// Walls are the facets of the fluid at a solid, and those through which nothing flows: |v · n| is at most 1e-9 of the
/// largest velocity at all of their nodes. Boundaries with `slip` or `symmetry` are none.
pub struct WallShear<const D: usize> {
    facets: Vec<Facet<D>>,
}

struct Facet<const D: usize> {
    cell: usize,
    nodes: Vec<u32>,
    points: Vec<FacetPoint<D>>,
    at_solid: bool,
}

/// A flow across a wall below this part of the largest velocity is none.
const NO_FLOW: f64 = 1e-9;

impl<const D: usize> WallShear<D> {
    /// On the boundary of the fluid of `space`, but for the boundaries `smooth`, along which nothing is exerted.
    pub fn new(space: &FsiSpace<D>, smooth: &[&str]) -> Self {
        let (shape, degree) = (space.mesh.shape, space.nodes.degree);
        let of = |facet: &FluidFacet| {
            let on_cell = shape.facet_nodes(degree, facet.side.local as usize);
            let points: Vec<[f64; 3]> = on_cell.iter().map(|&a| lagrange::node(shape, degree, a)).collect();
            let rule = Quadrature { weights: vec![1.0; points.len()], points };
            Facet {
                cell: facet.side.cell as usize,
                nodes: space.facet_nodes(&facet.facet()),
                points: facet_points_of(space, &facet.facet(), &rule),
                at_solid: facet.at_solid,
            }
        };
        let boundary = FluidBoundary::new(space);
        let name = |facet: &FluidFacet| Some(space.mesh.boundaries[usize::from(facet.boundary?)].as_str());
        let is_smooth =
            |facet: &FluidFacet| !facet.at_solid && name(facet).is_some_and(|n| smooth.contains(&n));
        let may_be_wall = |facet: &&FluidFacet| !facet.at_seam && !is_smooth(facet);
        let mut facets: Vec<Facet<D>> = boundary.facets.iter().filter(may_be_wall).map(of).collect();
        // The axis is no wall.
        facets.retain(|facet| {
            let near = 1e-9 * space.mesh.cell_diameter(facet.cell);
            !facet.points.iter().all(|point| point.radius.is_some_and(|r| r.abs() <= near))
        });
        WallShear { facets }
    }

    /// −(I − n ⊗ n) σ n \[Pa\] at the nodes, `n_nodes × D`, n pointing out of the fluid: the mean over the facets of
    /// walls that meet at a node, 0 off the walls.
    pub fn at_nodes(&self, space: &FsiSpace<D>, physics: &Physics, state: &State) -> Vec<f64> {
        let mut values = vec![0.0; space.nodes.n_lagrange * D];
        let mut count = vec![0.0; space.nodes.n_lagrange];
        let least = NO_FLOW * state.v.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
        for facet in &self.facets {
            let at = facet.points.iter().map(|point| {
                let nodes = space.nodes.cell(facet.cell);
                let fields = fields_at(nodes, &point.value, &point.grad, state);
                let area = cofactor(&fields.grad_u) * point.normal;
                (fields, area * (1.0 / area.dot(area).sqrt()), point.radius)
            });
            let at: Vec<(Fields<f64, D>, Vector<f64, D>, Option<f64>)> = at.collect();
            if !facet.at_solid && at.iter().any(|(fields, n, _)| fields.v.dot(*n).abs() > least) {
                continue;
            }
            let physics = physics.of(space.material[facet.cell]);
            for (&node, (fields, n, radius)) in facet.nodes.iter().zip(&at) {
                let tau = match radius {
                    None => wall_shear(&physics, fields, *n),
                    Some(r) => {
                        let fields = axisymmetric::fields_at(fields, *r);
                        axisymmetric::plane(&wall_shear(&physics, &fields, axisymmetric::vector(n)))
                    }
                };
                (0..D).for_each(|i| values[node as usize * D + i] += tau.0[i]);
                count[node as usize] += 1.0;
            }
        }
        for (values, count) in values.chunks_exact_mut(D).zip(count) {
            values.iter_mut().for_each(|value| *value /= f64::max(count, 1.0));
        }
        values
    }
}
