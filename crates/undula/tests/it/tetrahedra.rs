//! Tetrahedra: refinement, numbering, orders of convergence, patch tests, constants, and agreement with hexahedra.
#![allow(non_snake_case)]

use crate::common::{builtin, sets};
use crate::manufactured::*;
use undula::case::Case;
use undula::element::{Quadrature, Shape};
use undula::math::{Tensor, Vector};
use undula::mesh::generate::{cylinders, hexahedra, tube};
use undula::mesh::{FacetDistance, Hierarchy, Mesh};
use undula::sampling::for_each_point;
use undula::simulation::{Row, Simulation};
use undula::space::PressureKind::{Continuous, Pdc};
use undula::space::{Against, BoundaryCondition, Constraints, FsiSpace, Nodes, Region, State};
use undula::verification::jacobians::{At, compare};
use undula::verification::stability::inf_sup;
use undula::verification::unit_square::errors;

/// P2 with the bubbles of faces and cells, and P1dc.
const BUBBLES: Pair = Pair { bubble: true, ..tetrahedra(2, Pdc(1)) };

/// The unit cube in 6 n³ tetrahedra.
fn grid(n: usize) -> Mesh<3> {
    hexahedra([0.0; 3], [1.0; 3], [n; 3], 0).unwrap().in_tetrahedra()
}

/// The same cells with their vertices in other orders that are no reflections, the facets with them.
fn shuffled(mesh: &Mesh<3>) -> Mesh<3> {
    const EVEN: [[usize; 4]; 6] =
        [[0, 1, 2, 3], [1, 2, 0, 3], [3, 2, 1, 0], [1, 0, 3, 2], [2, 3, 0, 1], [0, 2, 3, 1]];
    let shape = Shape::Tetrahedron;
    let mut other = mesh.clone();
    let n = shape.n_nodes(mesh.degree);
    for cell in 0..mesh.n_cells() {
        let order = EVEN[(7 * cell + cell / 5) % 6];
        for node in 0..n {
            let weights = shape.vertex_weights(mesh.degree, node);
            let mut old = [0; 4];
            (0..4).for_each(|v| old[order[v]] = weights[v] as usize);
            let from = shape.number(mesh.degree, [old[1], old[2], old[3]]);
            other.cell_nodes[cell * n + node] = mesh.cell_nodes[cell * n + from];
        }
        let place = |v: u8| order.iter().position(|&old| old == v as usize).unwrap() as u8;
        for facet in other.facets.iter_mut().filter(|f| f.cell as usize == cell) {
            facet.local = place(facet.local);
        }
    }
    other
}

/// All cells that share a node have it at one place, whichever vertex of them comes first, on bent cells.
#[test]
fn nodes_of_every_degree_meet_on_faces_and_edges() {
    let mut mesh = shuffled(&grid(2));
    bend(&mut mesh, 2, Cells::Curved);
    mesh.check().unwrap();
    for degree in 1..=4 {
        let nodes = Nodes::new(&mesh, degree);
        // Euler: lattice points of the cube at this degree.
        assert_eq!(nodes.len(), (2 * degree + 1).pow(3));
        for cell in 0..mesh.n_cells() {
            for (a, &node) in nodes.cell(cell).iter().enumerate() {
                let at = Shape::Tetrahedron.lattice(degree, a).map(|i| i as f64 / degree as f64);
                let (x, y) = (mesh.map(cell, at), nodes.points[node as usize]);
                assert!((0..3).all(|d| (x[d] - y[d]).abs() < 1e-13), "degree {degree}: {x:?} {y:?}");
            }
        }
    }
    let bubbles = Nodes::new(&mesh, 2).with_bubbles(&mesh, |_| true);
    // A face of 48 cells is one of 2 · 24 outer ones or shared.
    let faces = (4 * mesh.n_cells() + mesh.facets.len()) / 2;
    assert_eq!(bubbles.len() - bubbles.n_lagrange, faces + mesh.n_cells());
}

/// Refined three times, cells do not become flatter than twice, grids of Kuhn not at all; neighbours fit, and names stay.
#[test]
fn refined_tetrahedra_keep_their_angles_and_fit() {
    let mut bent = shuffled(&grid(1));
    bent.nodes.iter_mut().for_each(|x| *x = [x[0] + 0.3 * x[1], x[1] - 0.2 * x[2], x[2] + 0.5 * x[0]]);
    for (mesh, kept) in [(grid(1), 1.0), (shuffled(&grid(1)), 1.0), (bent, 0.5)] {
        let worst = |mesh: &Mesh<3>| mesh.quality().min_scaled_jacobian();
        let finest = mesh.clone().refined(3, &[]);
        println!("{:.4} becomes {:.4}", worst(&mesh), worst(&finest));
        assert!(worst(&finest) > (kept - 1e-9) * worst(&mesh));
        finest.check().unwrap();
        let facets = finest.facets_of_cells();
        assert_eq!((finest.n_cells(), facets.bad.len()), (512 * mesh.n_cells(), 0));
        assert_eq!(facets.outer.len(), finest.facets.len());
        let volumes = [&mesh, &finest].map(|m| m.quality().total_volume());
        assert!((volumes[0] / volumes[1] - 1.0).abs() < 1e-12);
        for boundary in 0..mesh.boundaries.len() as u16 {
            let count = |m: &Mesh<3>| m.facets.iter().filter(|f| f.boundary == boundary).count();
            assert_eq!(count(&finest), 64 * count(&mesh));
        }
    }
}

/// The volume of a tube with its wall: order 4 with quadratic cells whose boundaries follow the circles.
#[test]
fn curved_tetrahedra_have_the_volume_of_the_tube() {
    let size = [0.02, 0.01, 0.002];
    let exact = std::f64::consts::PI * 0.012f64.powi(2) * 0.02;
    let curves = cylinders(size);
    let mut mesh = tube(size, [2, 8, 1], 0).unwrap().in_tetrahedra();
    mesh.project_boundaries(&curves);
    let mut errors = vec![];
    for _ in 0..3 {
        mesh.check().unwrap();
        mesh.check_curves(&curves).unwrap();
        errors.push((mesh.quality().total_volume() / exact - 1.0).abs());
        mesh = mesh.refine(&curves);
    }
    let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    println!("{errors:?} {orders:.2?}");
    assert!(orders.iter().all(|order| *order > 3.8) && errors[0] < 1e-3, "{errors:?} {orders:?}");
}

/// Distances to flat triangles by their formula, to curved ones above points of them.
#[test]
fn distances_to_triangular_facets_are_exact() {
    let mut flat = grid(2);
    let vertices = (0..flat.n_cells()).flat_map(|cell| flat.cell_vertices(cell)).collect();
    (flat.degree, flat.cell_nodes) = (1, vertices);
    let flat = flat.restrict(&["fluid"]);
    let top = FacetDistance::new(&flat, &["top"]).unwrap();
    let mut random = Random(7);
    for _ in 0..200 {
        let x = [0; 3].map(|_| 0.5 + 4.0 * random.next());
        let gap = [x[0].clamp(0.0, 1.0), 1.0, x[2].clamp(0.0, 1.0)];
        let exact = (0..3).map(|d| (x[d] - gap[d]).powi(2)).sum::<f64>().sqrt();
        assert!((top.distance(x) - exact).abs() < 1e-13, "{x:?}");
    }
    let mut bent = grid(2);
    bent.nodes
        .iter_mut()
        .for_each(|x| *x = [x[0] + 0.1 * x[1] * x[2], x[1] + 0.1 * x[0] * x[0], x[2] - 0.1 * x[0] * x[1]]);
    for name in ["top", "right", "back"] {
        let facets = FacetDistance::new(&bent, &[name]).unwrap();
        for f in bent.facets_on(&[name]) {
            let rule = Quadrature::facet(bent.shape, f.local as usize, 3);
            for (i, xi) in rule.points.iter().enumerate() {
                let (x, gradient) = (bent.map(f.cell as usize, *xi), bent.map_gradient(f.cell as usize, *xi));
                let normal = Tensor(gradient).cofactor() * Vector(bent.shape.facet_normal(f.local as usize));
                let height = [0.1, -0.07][i % 2];
                let above = Vector(x) + normal * (height / normal.dot(normal).sqrt());
                let found = facets.distance(above.0);
                assert!((found - height.abs()).abs() < 1e-12, "{name} {f:?} {xi:?}: {found}");
            }
        }
    }
}

/// Coarser meshes know along which diagonals they were split, also those of one region alone.
#[test]
fn diagonals_stay_with_the_cells() {
    let mut mesh = shuffled(&grid(2));
    mesh.nodes.iter_mut().for_each(|x| *x = [x[0] + 0.3 * x[1], x[1] - 0.2 * x[2], x[2] + 0.5 * x[0]]);
    mesh.regions.push("solid".into());
    mesh.cell_region.iter_mut().skip(1).step_by(3).for_each(|region| *region = 1);
    let (finest, hierarchy) = Hierarchy::refine(mesh, 1, &[]);
    let (whole, part) = (finest.restrict(&["solid"]), hierarchy.restrict(&["solid"]));
    let coarse = &part.coarser()[0];
    let mut seen = std::collections::BTreeSet::new();
    for cell in 0..whole.n_cells() {
        let child = part.child(0, cell);
        let number = part.child_number(0, child);
        seen.insert(number);
        let at = coarse.map(child.parent, Shape::Tetrahedron.to_parent(number, [0.1, 0.2, 0.3]));
        let here = whole.map(cell, [0.1, 0.2, 0.3]);
        assert!((0..3).all(|d| (at[d] - here[d]).abs() < 1e-13));
    }
    assert!(seen.len() > 8, "several diagonals: {seen:?}");
}

/// The unit cube, its lower half solid, in `n` cells per direction, cut in six.
fn case(n: usize, more: &[&str]) -> Case {
    let mesh = format!(
        "generator = \"box\"\nlower = [0, 0, 0]\nupper = [1, 1, 1]\ncells = [{n}, {n}, {n}]\nregion.solid = \"0.5 - y\""
    );
    super::convergence_in_space::case(&mesh, more)
}

/// Orders of v, u and p between the two numbers `n` of cubes per direction at least `least`, on bent cells.
#[track_caller]
fn orders(n: [usize; 2], least: [f64; 3], more: &[&str]) {
    let [coarse, fine] = n.map(|n| {
        let found = errors(&case(n, more)).unwrap();
        [found.v, found.u, found.p]
    });
    let finer = (n[1] as f64 / n[0] as f64).ln();
    let orders = [0, 1, 2].map(|i| (coarse[i] / fine[i]).ln() / finer);
    println!("{more:?}: {coarse:?} {fine:?} orders {orders:.2?}");
    assert!(
        (0..3).all(|i| fine[i] == 0.0 || orders[i] >= least[i]),
        "{more:?}: {orders:.2?}, expected {least:?}"
    );
}

#[test]
fn taylor_hood_and_bubbles_of_tetrahedra_have_order_3_and_2() {
    orders([2, 4], [2.6, 2.6, 1.8], &["space.velocity=P2"]);
    orders([2, 4], [2.6, 2.6, 1.8], &["space.velocity=P2-bubble"]);
}

/// Of the flow alone: on cells so large the body would fold.
#[test]
fn cubic_tetrahedra_have_order_4_and_their_pressure_3() {
    orders(
        [3, 4],
        [3.6, f64::NEG_INFINITY, 2.6],
        &["space.velocity=P3", "solid=none", "mesh.region=none", "boundary.bottom.condition=no-slip"],
    );
}

/// Coarse: `validation/orders-of-tetrahedra.toml` has 2.0 of v and u and 1.4 of p on finer cells.
#[test]
fn stabilised_linear_tetrahedra_converge() {
    orders([2, 4], [1.0, 0.8, 0.8], &["space.velocity=P1"]);
}

/// Inf-sup constants of the cube with one open side, on `n` cubes per direction cut in six.
fn constant(n: usize, pair: Pair) -> f64 {
    let mesh = grid(n);
    let regions = vec![Region::Fluid; mesh.n_cells()];
    let space = match pair.bubble {
        true => FsiSpace::with_bubbles(mesh, regions, pair.degree, pair.pressure),
        false => FsiSpace::new(mesh, regions, pair.degree, pair.pressure),
    };
    let condition = |name: &String| match name.as_str() {
        "right" => BoundaryCondition::Outflow { do_nothing: true, backflow: Against::None },
        _ => BoundaryCondition::Fixed,
    };
    let conditions: Vec<_> = space.mesh.boundaries.iter().map(condition).collect();
    let constraints = Constraints::new(&space, &conditions);
    inf_sup(&space, &constraints, &[], pair.quadrature()).unwrap().constant
}

#[test]
fn pairs_of_tetrahedra_keep_their_constants() {
    for (name, pair) in [("P2-P1", tetrahedra(2, Continuous(1))), ("P2-bubble-P1dc", BUBBLES)] {
        let found = [2, 4].map(|n| constant(n, pair));
        println!("{name}: {found:.5?}");
        assert!(found[1] > 0.9 * found[0] && found[1] > 0.1, "{name}: {found:?}");
    }
}

/// The last row of `case` with `threads` threads, and its state.
fn run(name: &str, more: &[&str], threads: usize) -> (Row, State) {
    let mut simulation = Simulation::in_space(builtin(name, more), threads).unwrap();
    let mut row = simulation.step().unwrap();
    while !simulation.finished() {
        row = simulation.step().unwrap();
    }
    (row, simulation.stepper.new)
}

/// A pressure wave in a short tube, in few cells.
const TUBE: [&str; 6] = [
    "mesh.cells=[3,8,1]",
    "mesh.grading=0",
    "mesh.length=0.006",
    "time.step=2e-4",
    "time.end=6e-4",
    "functional=none",
];

fn tube_with(more: &[&str], threads: usize) -> State {
    run("tube", &[&TUBE[..], more].concat(), threads).1
}

fn far(a: &[f64], b: &[f64]) -> f64 {
    let size = largest(b.iter().copied());
    largest(a.iter().zip(b).map(|(a, b)| a - b)) / size
}

#[test]
fn all_jacobians_of_tetrahedra_agree() {
    for velocity in ["P2", "P2-bubble", "P1"] {
        let velocity = format!("space.velocity={velocity}");
        let more = [&TUBE[..], &[&velocity, "mesh.cells=[1,4,1]"]].concat();
        let mut simulation = Simulation::in_space(builtin("tube", &more), 1).unwrap();
        let report = compare(&mut simulation, At::Random { seed: 3 }).unwrap();
        assert!(report.agrees(), "{velocity}: {report}");
    }
}

/// Threads change no bit, and the condensed system arrives where the whole one does.
#[test]
#[ignore = "long"]
fn condensed_is_whole_and_threads_change_no_bit() {
    for velocity in ["P2", "P2-bubble"] {
        let velocity = format!("space.velocity={velocity}");
        let one = tube_with(&[&velocity, "newton.tolerance=1e-11"], 1);
        let two = tube_with(&[&velocity, "newton.tolerance=1e-11"], 2);
        assert!(one.v == two.v && one.u == two.u && one.p == two.p, "{velocity}");
        let whole = tube_with(&[&velocity, "newton.tolerance=1e-11", "newton.linearization=newton"], 2);
        let gaps = [far(&one.v, &whole.v), far(&one.u, &whole.u), far(&one.p, &whole.p)];
        assert!(gaps.iter().all(|gap| *gap < 1e-7), "{velocity}: {gaps:?}");
    }
}

/// With discontinuous pressures nothing is lost in any cell, and bubbles stay out of the deformation and of the interface.
#[test]
fn bubbles_conserve_mass_in_every_cell() {
    let text = r#"
[mesh]
generator = "box"
lower = [0, 0, 0]
upper = [2, 1, 1]
cells = [2, 2, 2]
[fluid]
density = 1
kinematic-viscosity = 0.05
[boundary]
left = { condition = "velocity", velocity = ["16*y*(1-y)*z*(1-z)", 0, 0] }
right.condition = "do-nothing"
bottom.condition = "no-slip"
top.condition = "no-slip"
front.condition = "no-slip"
back.condition = "no-slip"
"#;
    let flux = |velocity: &str| {
        let case = Case::from_toml(text, "duct.toml", &sets(&[velocity])).unwrap();
        let mut simulation = Simulation::in_space(case, 1).unwrap();
        simulation.step().unwrap();
        let space = &simulation.stepper.assembler.space;
        let mut lost = vec![0.0; space.mesh.n_cells()];
        for_each_point(space, &simulation.stepper.new, 4, |point| {
            lost[point.cell] += point.weight * point.fields.grad_v.trace();
        });
        largest(lost)
    };
    let [bubbles, taylor_hood] = ["P2-bubble", "P2"].map(|v| flux(&format!("space.velocity={v}")));
    println!("lost in one cell: {bubbles:e} and {taylor_hood:e} with Taylor-Hood");
    assert!(bubbles < 1e-9 && taylor_hood > 1e-5, "{bubbles:e} {taylor_hood:e}");
    let mut simulation =
        Simulation::in_space(builtin("tube", &[&TUBE[..], &["space.velocity=P2-bubble"]].concat()), 1)
            .unwrap();
    simulation.step().unwrap();
    let (space, state) = (&simulation.stepper.assembler.space, &simulation.stepper.new);
    let bubbles = 3 * space.nodes.n_lagrange;
    assert!(
        largest(state.u[bubbles..].iter().copied()) == 0.0
            && largest(state.v[bubbles..].iter().copied()) > 0.0
    );
    let between = space.interface_bubbles();
    assert!(!between.is_empty());
    assert!(between.iter().all(|&node| state.v[3 * node as usize..][..3] == [0.0; 3]));
}

/// Deflection and forces of built-in cases, computed on hexahedra and on tetrahedra.
#[test]
fn tetrahedra_and_hexahedra_agree() {
    let few = ["mesh.refine=2", "newton.tolerance=1e-9"];
    let tip = |more: &[&str]| run("cook", &[&few[..], more].concat(), 2).0.values[0];
    let hexahedra = tip(&[]);
    for velocity in ["P2", "P3"] {
        let found = tip(&[&format!("space.velocity={velocity}")]);
        println!("cook: {hexahedra} and {found} with {velocity}");
        assert!((found / hexahedra - 1.0).abs() < 0.01, "{velocity}: {found} and {hexahedra}");
    }
}

/// What needs coarser meshes, similar children or positive integrals is refused with the key.
#[test]
fn what_tetrahedra_do_not_have_is_refused() {
    let refused = |more: &[&str]| {
        let more = [&TUBE[..], &["space.velocity=P2"], more].concat();
        match Case::builtin("tube", &sets(&more)) {
            Err(e) => e.to_string(),
            Ok(case) => Simulation::in_space(case, 1).err().unwrap().to_string(),
        }
    };
    for (more, expected) in [
        (&["linear.solver=multigrid", "mesh.refine=1"][..], "multigrid on tetrahedra is not yet available"),
        (&["motion.model=biharmonic"], "on tetrahedra it is not yet available"),
        (
            &["space.pressure=P2", "stabilization.projection=patch", "mesh.refine=1"],
            "patches need children that are alike",
        ),
        (&["space.pressure=P1dc"], "is not stable with the velocity P2"),
        (&["space.pressure=P0"], "is not stable with the velocity P2 on tetrahedra: take P2-bubble with it"),
        (&["space.pressure=Q1"], "which needs triangles or tetrahedra"),
    ] {
        let message = refused(more);
        assert!(message.contains(expected), "{more:?}: {message}");
    }
}
