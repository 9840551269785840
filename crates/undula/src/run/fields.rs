//! The solution as fields at points.

use crate::element::Shape;
use crate::output::{CellKind, Field, FieldSnapshot};
use crate::space::{FsiSpace, Region, State};

/// Fields at the nodes of v and u, on the deformed mesh or on the reference domain.
pub fn snapshot(space: &FsiSpace<2>, state: &State, deformed: bool) -> FieldSnapshot {
    // Bubbles have no value of their own at a point.
    let n = space.nodes.n_lagrange;
    let u = |node: usize, i: usize| if state.u.is_empty() { 0.0 } else { state.u[2 * node + i] };
    let point = |node: usize| {
        let x = space.nodes.points[node];
        let move_by = |i| if deformed { u(node, i) } else { 0.0 };
        [x[0] + move_by(0), x[1] + move_by(1), 0.0]
    };
    let mut point_data = vec![Field::new("velocity", 2, state.v[..2 * n].to_vec())];
    if space.deforms {
        point_data.push(Field::new("deformation", 2, state.u[..2 * n].to_vec()));
    }
    for (name, region) in [("pressure", Region::Fluid), ("solid-pressure", Region::Solid)] {
        if let Some(values) = nodal_pressure(space, state, region) {
            point_data.push(Field::new(name, 1, values));
        }
    }
    let solid = space.regions.iter().map(|r| if *r == Region::Solid { 1.0 } else { 0.0 }).collect();
    FieldSnapshot {
        kind: match space.mesh.shape {
            Shape::Triangle => CellKind::Triangle,
            _ => CellKind::Quadrilateral,
        },
        degree: space.nodes.degree,
        points: (0..n).map(point).collect(),
        cells: (0..space.mesh.n_cells()).flat_map(|cell| points_of(space, cell)).copied().collect(),
        point_data,
        cell_data: vec![Field::new("solid", 1, solid)],
    }
}

/// The nodes of `cell` that are points.
fn points_of(space: &FsiSpace<2>, cell: usize) -> &[u32] {
    &space.nodes.cell(cell)[..space.mesh.shape.n_nodes(space.nodes.degree)]
}

/// Pressure of a region at the nodes, the mean over its cells; 0 outside. `None` if the region has none.
fn nodal_pressure(space: &FsiSpace<2>, state: &State, region: Region) -> Option<Vec<f64>> {
    let n = space.nodes.n_lagrange;
    let (mut sum, mut count) = (vec![0.0; n], vec![0.0; n]);
    for cell in 0..space.mesh.n_cells() {
        let dofs = space.pressure.cell(cell);
        if dofs.is_empty() || space.regions[cell] != region {
            continue;
        }
        for (a, &node) in points_of(space, cell).iter().enumerate() {
            let xi = crate::element::lagrange::node(space.mesh.shape, space.nodes.degree, a);
            let x = space.nodes.points[node as usize];
            let basis = space.pressure.basis(&space.mesh, cell, &xi, &x);
            sum[node as usize] += dofs.iter().zip(&basis).map(|(&d, b)| b * state.p[d as usize]).sum::<f64>();
            count[node as usize] += 1.0;
        }
    }
    let mean = sum.iter().zip(&count).map(|(s, c)| if *c > 0.0 { s / c } else { 0.0 });
    count.iter().any(|c| *c > 0.0).then(|| mean.collect())
}
