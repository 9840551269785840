//! Normals at the nodes of tetrahedra: the functions of corners have no integral over a facet of degree 2.

use crate::common::sets;
use undula::case::Case;
use undula::simulation::Simulation;

const TUBE: &str = r#"
[mesh]
generator = "tube"
length = 1
radii = [1, 1.1]
cells = [1, 8, 1]
leave-out = ["solid"]
[fluid]
density = 1
kinematic-viscosity = 0.1
[newton]
tolerance = 1e-11
"#;

fn simulation(conditions: &str, more: &[&str]) -> Simulation<3> {
    let case = Case::from_toml(&format!("{TUBE}{conditions}"), "tube.toml", &sets(more));
    let mut simulation = Simulation::in_space(case.unwrap_or_else(|e| panic!("{e}")), 1).unwrap();
    simulation.step().unwrap();
    simulation
}

/// A given flow with a parabolic profile enters at every node, and is that of Poiseuille.
#[test]
fn the_profile_of_a_flow_points_inwards_at_all_nodes() {
    let conditions = r#"
[boundary.inflow]
condition = "flux"
flow-rate = -1.5707963267948966
profile = "parabolic"
[boundary.outflow]
condition = "do-nothing"
[boundary.solid]
condition = "no-slip"
"#;
    for element in ["Q2", "P2", "P2-bubble", "P3"] {
        let pair = format!("space.velocity={element}");
        let simulation = simulation(conditions, &[&pair, "mesh.cells=[1,8,1]"]);
        let fields = simulation.fields();
        let mut inflow = 0;
        for (x, v) in fields.coordinates().iter().zip(fields.velocity()).filter(|(x, _)| x[2] == 0.0) {
            let exact = 1.0 - x[0] * x[0] - x[1] * x[1];
            assert!(
                (v[2] - exact).abs() < 0.02 && v[0] == 0.0 && v[1] == 0.0,
                "{element}: {v:?} at {x:?}, {exact}"
            );
            inflow += 1;
        }
        assert!(inflow > 30, "{inflow}");
    }
}

/// A flow that turns like a rigid body in a tube with a slip wall, of which all normals are radial.
#[test]
fn a_flow_turns_in_a_round_tube_with_a_slip_wall() {
    let conditions = r#"
[boundary.inflow]
condition = "velocity"
velocity = ["-y", "x", 0]
[boundary.outflow]
condition = "traction"
traction = [0, 0, "-0.5*(x^2 + y^2)"]
[boundary.solid]
condition = "slip"
"#;
    for (element, most) in [("Q2", 2e-3), ("P2", 5e-3), ("P2-bubble", 5e-3), ("P3", 5e-3)] {
        let pair = format!("space.velocity={element}");
        let errors = ["mesh.cells=[1,8,1]", "mesh.cells=[2,16,1]"].map(|cells| {
            let simulation = simulation(conditions, &[&pair, cells]);
            let gap = |at: &undula::PointFields<3>| {
                (at.velocity[0] + at.x[1]).powi(2)
                    + (at.velocity[1] - at.x[0]).powi(2)
                    + at.velocity[2].powi(2)
            };
            simulation.fields().integrate(gap).sqrt()
        });
        println!("{element}: {errors:?}");
        assert!(errors[1] < most && (errors[0] / errors[1]).log2() > 2.3, "{element}: {errors:?}");
    }
}
