//! The solution as fields at points.

use crate::case::OutputSpec;
use crate::choice::name_of;
use crate::element::Shape;
use crate::functional::fields::nodal_pressure;
use crate::functional::nodal::{FIELDS, NodalField, WallShear, in_body};
use crate::output::{CellKind, Field, FieldSnapshot};
use crate::parallel::Reduce;
use crate::simulation::Simulation;
use crate::space::{FsiSpace, Region, State};
use crate::system::Physics;

/// The fields that the case of `simulation` writes, with the cells that it wants.
pub fn written_fields<const D: usize>(simulation: &Simulation<D>) -> FieldSnapshot {
    let Simulation { case, stepper, .. } = simulation;
    let assembler = &stepper.assembler;
    let fields = fields(&assembler.space, &assembler.physics, &stepper.new, &case.output, &case.smooth());
    if case.output.curved { fields } else { fields.linear() }
}

/// The fields that `output` names, on the mesh that it wants.
///
/// Boundaries `smooth` are no walls. A derived field has an array for each body, `fluid-stress` and `solid-stress`, with NaN at the nodes of the other
/// one.
pub fn fields<const D: usize>(
    space: &FsiSpace<D>,
    physics: &Physics,
    state: &State,
    output: &OutputSpec,
    smooth: &[&str],
) -> FieldSnapshot {
    let mut snapshot = snapshot(space, state, output.deformed);
    let [velocity, displacement, pressure] =
        [NodalField::Velocity, NodalField::Displacement, NodalField::Pressure]
            .map(|field| output.fields.contains(&field));
    snapshot.point_data.retain(|field| match field.name.as_str() {
        VELOCITY => velocity,
        DEFORMATION => displacement,
        _ => pressure,
    });
    for &field in &output.fields {
        let name = name_of(&FIELDS, &field);
        for (body, region) in [("fluid", Region::Fluid), ("solid", Region::Solid)] {
            let without = field == NodalField::Jacobian && !space.deforms;
            let is_there = field.is_derived_in(region) && space.any(space.regions.contains(&region));
            if is_there && !without {
                let values = in_body(space, physics, state, field, region);
                let values = space.at_places(&values, field.components(D));
                snapshot.point_data.push(Field::new(format!("{body}-{name}"), field.components(D), values));
            }
        }
        if field == NodalField::WallShearStress && physics.fluid.is_some() {
            let values = space.at_places(&WallShear::new(space, smooth).at_nodes(space, physics, state), D);
            snapshot.point_data.push(Field::new(name, field.components(D), values));
        }
    }
    snapshot
}

/// Arrays that pictures look for.
const VELOCITY: &str = "velocity";
const DEFORMATION: &str = "deformation";

/// Fields at the nodes of v and u, on the deformed mesh or on the reference domain.
pub fn snapshot<const D: usize>(space: &FsiSpace<D>, state: &State, deformed: bool) -> FieldSnapshot {
    // Bubbles have no value of their own at a point.
    let n = space.places().n_lagrange;
    let u = |node: usize, i: usize| if state.u.is_empty() { 0.0 } else { state.u[D * node + i] };
    let point = |place: usize| {
        let (x, node) = (space.places().points[place], space.node_at(place));
        let move_by = |i| if deformed { u(node, i) } else { 0.0 };
        std::array::from_fn(|d| if d < D { x[d] + move_by(d) } else { 0.0 })
    };
    let mut point_data = vec![Field::new(VELOCITY, D, space.at_places(&state.v, D))];
    if space.deforms {
        point_data.push(Field::new(DEFORMATION, D, space.at_places(&state.u, D)));
    }
    for (name, region) in [("pressure", Region::Fluid), ("solid-pressure", Region::Solid)] {
        let values = nodal_pressure(space, state, region);
        if space.any(values.iter().any(Option::is_some)) {
            let values: Vec<f64> = values.into_iter().map(|value| value.unwrap_or(0.0)).collect();
            point_data.push(Field::new(name, 1, space.at_places(&values, 1)));
        }
    }
    let solid = space.regions.iter().map(|r| if *r == Region::Solid { 1.0 } else { 0.0 }).collect();
    FieldSnapshot {
        kind: match space.mesh.shape {
            Shape::Triangle => CellKind::Triangle,
            Shape::Quadrilateral => CellKind::Quadrilateral,
            Shape::Tetrahedron => CellKind::Tetrahedron,
            Shape::Hexahedron => CellKind::Hexahedron,
        },
        degree: space.nodes.degree,
        points: (0..n).map(point).collect(),
        cells: (0..space.mesh.n_cells()).flat_map(|cell| points_of(space, cell)).copied().collect(),
        point_data,
        cell_data: [Some(Field::new("solid", 1, solid)), material(space)].into_iter().flatten().collect(),
    }
}

/// The number of the body in each cell, fluids and then solids in the order of the case; `None` where `solid` tells it.
fn material<const D: usize>(space: &FsiSpace<D>) -> Option<Field> {
    let several = space.any(space.material.iter().any(|&material| material > 0));
    let last = |region: Region| {
        let of_region = space.regions.iter().zip(&space.material).filter(|(r, _)| **r == region);
        let here = of_region.map(|(_, &material)| material + 1).max().unwrap_or(0);
        space.over_all(Reduce::Max, f64::from(here)) as u16
    };
    let first = [(Region::Fluid, 0), (Region::Solid, last(Region::Fluid))];
    let number = |(region, material): (&Region, &u16)| {
        let first = first.iter().find(|(r, _)| r == region).map_or(0, |(_, first)| *first);
        f64::from(first + material)
    };
    let values = || space.regions.iter().zip(&space.material).map(number).collect();
    several.then(|| Field::new("material", 1, values()))
}

/// The points of `cell`.
fn points_of<const D: usize>(space: &FsiSpace<D>, cell: usize) -> &[u32] {
    &space.places().cell(cell)[..space.mesh.shape.n_nodes(space.nodes.degree)]
}
