//! What the mesh module claims: counts, shapes, names and areas of the benchmark meshes, refinement,
//! regions, location and distance.

use std::collections::HashSet;
use std::f64::consts::PI;
use undula::element::Shape;
use undula::mesh::generate::{
    annulus, circles, cook, cylinder, cylinder_of_dfg_3d, dfg_3d, rectangle, schaefer_turek, turek_hron,
    valve,
};
use undula::mesh::{Curve, Facet, FacetDistance, Locator, Mesh, MeshError};

const CYLINDER_AREA: f64 = PI * 0.05 * 0.05;

/// Area of the beam: 0.4 × 0.02 from the centre of the cylinder less what the circle cuts off.
fn beam_area() -> f64 {
    let (r, h) = (0.05_f64, 0.01_f64);
    0.4 * 2.0 * h - (h * (r * r - h * h).sqrt() + r * r * (h / r).asin())
}

fn unit_square(n: usize) -> Mesh<2> {
    rectangle([0.0, 0.0], [1.0, 1.0], [n, n], 0).unwrap()
}

/// Vertices − edges + cells of a plane mesh: 1 less the number of holes.
fn euler(mesh: &Mesh<2>) -> i64 {
    let facets = mesh.facets_of_cells();
    assert!(facets.bad.is_empty());
    vertices(mesh).len() as i64 - (facets.outer.len() + facets.inner.len()) as i64 + mesh.n_cells() as i64
}

fn vertices(mesh: &Mesh<2>) -> HashSet<u32> {
    (0..mesh.n_cells()).flat_map(|c| mesh.cell_vertices(c)).collect()
}

fn has_vertex(mesh: &Mesh<2>, x: [f64; 2]) -> bool {
    let (node, away) = mesh.nearest_node(x).unwrap();
    away < 1e-15 && vertices(mesh).contains(&node)
}

fn count(mesh: &Mesh<2>, boundary: &str) -> usize {
    let number = mesh.boundary(boundary).unwrap();
    mesh.facets.iter().filter(|f| f.boundary == number).count()
}

fn region_area(mesh: &Mesh<2>, region: &str) -> f64 {
    mesh.restrict(&[region]).quality().total_volume()
}

#[test]
fn turek_hron_has_the_promised_counts_and_names() {
    for (level, unknowns) in [(0, 4896), (1, 18944), (2, 74496)] {
        let mesh = turek_hron(level, 0);
        mesh.check_matching("fluid", "solid", &[cylinder()]).unwrap();
        assert_eq!(mesh.n_cells(), 244 << (2 * level));
        assert_eq!(mesh.regions, ["fluid", "solid"]);
        assert_eq!(mesh.boundaries, ["inflow", "outflow", "walls", "cylinder", "clamp", "interface"]);
        assert_eq!(count(&mesh, "cylinder"), 18 << level);
        assert_eq!(count(&mesh, "clamp"), 2 << level);
        assert_eq!(count(&mesh, "interface"), 22 << level);
        let fluid = mesh.cell_region.iter().filter(|&&r| r == 0).count();
        assert_eq!(4 * mesh.nodes.len() + 3 * fluid, unknowns, "Q2-Q2-P1dc at level {level}");
        assert_eq!(euler(&mesh), 0);
        for x in [[0.6, 0.2], [0.15, 0.2], [0.6, 0.19], [0.6, 0.21]] {
            assert!(has_vertex(&mesh, x), "{x:?}");
        }
        for f in mesh.facets.iter().filter(|f| mesh.boundaries[f.boundary as usize] == "interface") {
            assert_eq!(mesh.cell_region[f.cell as usize], 0, "interface is seen from the fluid");
        }
    }
}

#[test]
fn schaefer_turek_has_the_promised_counts_and_names() {
    for level in 0..3 {
        let mesh = schaefer_turek(level);
        mesh.check().unwrap();
        mesh.check_curves(&[cylinder()]).unwrap();
        assert_eq!(mesh.n_cells(), 222 << (2 * level));
        assert_eq!(mesh.regions, ["fluid"]);
        assert_eq!(mesh.boundaries, ["inflow", "outflow", "walls", "cylinder"]);
        assert_eq!(count(&mesh, "cylinder"), 22 << level);
        assert_eq!(euler(&mesh), 0);
        assert!(has_vertex(&mesh, [0.15, 0.2]) && has_vertex(&mesh, [0.25, 0.2]));
    }
}

/// Level 0 has no mesh of its own: it is the other channel with two more columns, moved.
#[test]
fn the_section_of_dfg_3d_has_the_promised_counts_and_names() {
    for level in 0..3 {
        let mesh = dfg_3d(level);
        mesh.check().unwrap();
        mesh.check_curves(&[cylinder_of_dfg_3d()]).unwrap();
        assert_eq!(mesh.n_cells(), 234 << (2 * level));
        assert_eq!(mesh.boundaries, ["inflow", "outflow", "walls", "cylinder"]);
        assert_eq!((count(&mesh, "inflow"), count(&mesh, "cylinder")), (6 << level, 22 << level));
        assert_eq!(euler(&mesh), 0);
        assert!(has_vertex(&mesh, [0.45, 0.2]) && has_vertex(&mesh, [0.55, 0.2]));
        let ends = mesh.nodes.iter().fold([1.0, 0.0], |[a, b]: [f64; 2], [x, _]| [a.min(*x), b.max(*x)]);
        assert!(ends[0] == 0.0 && (ends[1] - 2.5).abs() < 1e-15, "{ends:?}");
        assert!(mesh.quality().min_scaled_jacobian() > 0.7);
        let area = mesh.quality().total_volume() - (2.5 * 0.41 - CYLINDER_AREA);
        assert!(area.abs() < 1e-6 / f64::from(1 << (4 * level)), "{area:e}");
    }
}

#[test]
fn cooks_membrane_is_a_panel_of_four_corners() {
    for level in 0..3 {
        let mesh = cook(level);
        mesh.check().unwrap();
        assert_eq!((mesh.n_cells(), &mesh.regions[..]), (1 << (2 * level), &["solid".to_string()][..]));
        let counts = ["clamp", "load", "free"].map(|name| count(&mesh, name));
        assert_eq!(counts, [1, 1, 2].map(|n| n << level));
        assert!(has_vertex(&mesh, [0.048, 0.06]) && has_vertex(&mesh, [0.0, 0.0]));
        assert!((mesh.quality().total_volume() - 0.048 * 0.03).abs() < 1e-17);
    }
}

#[test]
fn outer_facets_lie_where_their_names_say() {
    for (mesh, length) in [(turek_hron(1, 1), 2.5), (schaefer_turek(1), 2.2)] {
        for f in &mesh.facets {
            for n in mesh.facet_nodes(f.cell as usize, f.local as usize) {
                let [x, y] = mesh.nodes[n as usize];
                let r = (x - 0.2).hypot(y - 0.2);
                let on_beam = (y - 0.2).abs() <= 0.01 + 1e-15 && x <= 0.6 + 1e-15 && r >= 0.05 - 1e-15;
                let at = |a: f64, b: f64| (a - b).abs() < 1e-15;
                assert!(match mesh.boundaries[f.boundary as usize].as_str() {
                    "inflow" => x == 0.0,
                    "outflow" => at(x, length),
                    "walls" => y == 0.0 || at(y, 0.41),
                    "cylinder" | "clamp" => at(r, 0.05),
                    "interface" => on_beam && (at(x, 0.6) || at((y - 0.2).abs(), 0.01)),
                    _ => false,
                });
            }
        }
    }
}

#[test]
fn cells_keep_their_shape_at_all_levels_and_gradings() {
    for grading in 0..=8 {
        for level in 0..3 {
            let least = turek_hron(level, grading).quality().min_scaled_jacobian();
            assert!(least > 0.7, "level {level}, grading {grading}: {least}");
        }
    }
    for level in 0..4 {
        assert!(schaefer_turek(level).quality().min_scaled_jacobian() > 0.8);
    }
}

#[test]
fn areas_converge_with_order_four() {
    let exact_fluid = 2.5 * 0.41 - CYLINDER_AREA - beam_area();
    let mut errors = vec![];
    for level in 0..4 {
        let mesh = turek_hron(level, 0);
        let circle = schaefer_turek(level).quality().total_volume() - (2.2 * 0.41 - CYLINDER_AREA);
        let (fluid, solid) = (region_area(&mesh, "fluid"), region_area(&mesh, "solid"));
        errors.push([circle.abs(), (fluid - exact_fluid).abs(), (solid - beam_area()).abs()]);
    }
    for pair in errors.windows(2) {
        for (coarse, fine) in pair[0].iter().zip(pair[1]) {
            // Order 4 is a factor of 16; errors of 1e-13 are rounding.
            assert!(fine < coarse / 14.0 || fine < 1e-13, "{errors:?}");
        }
    }
}

#[test]
fn grading_lays_rings_around_the_tip_corners() {
    let plain = turek_hron(0, 0);
    for grading in 1..=8 {
        let mesh = turek_hron(0, grading);
        mesh.check_matching("fluid", "solid", &[cylinder()]).unwrap();
        assert_eq!(mesh.n_cells(), plain.n_cells() + 16 * grading);
        assert_eq!(count(&mesh, "interface"), 22 + 4 * grading);
        assert_eq!(euler(&mesh), 0);
        let smallest = (0..mesh.n_cells()).map(|c| mesh.cell_diameter(c)).fold(f64::INFINITY, f64::min);
        let expected = 0.01 * 2.0_f64.sqrt() / f64::powi(2.0, grading as i32);
        assert!((smallest / expected - 1.0).abs() < 1e-9);
        assert!((region_area(&mesh, "solid") - region_area(&plain, "solid")).abs() < 1e-16);
        assert!(has_vertex(&mesh, [0.6, 0.2]));
    }
}

#[test]
fn levels_are_nested() {
    for (coarse, fine) in [(turek_hron(0, 2), turek_hron(1, 2)), (schaefer_turek(1), schaefer_turek(2))] {
        let key = |x: [f64; 2]| x.map(|c| (c * 1e12).round() as i64);
        let vertices: HashSet<_> = vertices(&fine).into_iter().map(|v| key(fine.nodes[v as usize])).collect();
        assert!(coarse.nodes.iter().all(|&x| vertices.contains(&key(x))));
    }
}

/// A square around a circular hole, in four straight cells.
fn straight_hole() -> Mesh<2> {
    let (c, mut nodes) = (0.5_f64.sqrt(), vec![]);
    for r in [1.0, 3.0] {
        nodes.extend([[-c * r, -c * r], [c * r, -c * r], [c * r, c * r], [-c * r, c * r]]);
    }
    let facet = |cell, local, boundary| Facet { cell, local, boundary };
    Mesh {
        shape: Shape::Quadrilateral,
        degree: 1,
        nodes,
        cell_nodes: (0..4).flat_map(|i| [4 + i, 4 + (i + 1) % 4, i, (i + 1) % 4]).collect(),
        cell_region: vec![0; 4],
        regions: vec!["fluid".into()],
        facets: (0..4).flat_map(|c| [facet(c, 3, 0), facet(c, 2, 1)]).collect(),
        boundaries: vec!["hole".into(), "outside".into()],
        parts: vec![],
    }
}

#[test]
fn straight_meshes_are_refined_on_curves() {
    let mesh = straight_hole();
    mesh.check().unwrap();
    let circle = Curve::Sphere { boundaries: vec!["hole".into()], centre: [0.0, 0.0], radius: 1.0 };
    let error = |mesh: &Mesh<2>| (mesh.quality().total_volume() - (18.0 - PI)).abs();
    let coarse = mesh.clone().refined(3, std::slice::from_ref(&circle));
    let fine = mesh.refined(4, std::slice::from_ref(&circle));
    fine.check_curves(&[circle]).unwrap();
    fine.check().unwrap();
    assert!(error(&fine) < error(&coarse) / 3.9 && fine.quality().min_scaled_jacobian() > 0.4);
}

/// Two unit cubes of geometry degree 2 that share a face; the second is numbered along other axes.
pub fn two_cubes() -> Mesh<3> {
    let at = |i: usize| [(i % 5) as f64 * 0.5, (i / 5 % 3) as f64 * 0.5, (i / 15) as f64 * 0.5];
    let first = (0..27).map(|i| (i % 3 + 5 * (i / 3 % 3) + 15 * (i / 9)) as u32);
    let second = (0..27).map(|i| (2 + i / 9 + 5 * (i % 3) + 15 * (i / 3 % 3)) as u32);
    Mesh {
        shape: Shape::Hexahedron,
        degree: 2,
        nodes: (0..45).map(at).collect(),
        cell_nodes: first.chain(second).collect(),
        cell_region: vec![0, 0],
        regions: vec!["solid".into()],
        facets: vec![Facet { cell: 0, local: 0, boundary: 0 }],
        boundaries: vec!["left".into()],
        parts: vec![],
    }
}

#[test]
fn hexahedra_are_refined_conformingly() {
    let mesh = two_cubes();
    mesh.check_orientation().unwrap();
    let fine = mesh.refine(&[]);
    assert_eq!((fine.n_cells(), fine.nodes.len(), fine.facets.len()), (16, 9 * 5 * 5, 4));
    let facets = fine.facets_of_cells();
    assert_eq!((facets.outer.len(), facets.inner.len(), facets.bad.len()), (40, 28, 0));
    assert!((fine.quality().total_volume() - 2.0).abs() < 1e-14);
    assert!((fine.quality().min_scaled_jacobian() - 1.0).abs() < 1e-14);
    let located = Locator::new(&fine).find([1.9, 0.3, 0.8]).unwrap();
    let x = fine.map(located.cell, located.xi);
    assert!((x[0] - 1.9).abs() + (x[1] - 0.3).abs() + (x[2] - 0.8).abs() < 1e-14);
    let left = FacetDistance::new(&fine, &["left"]).unwrap();
    assert!((left.distance([1.5, 0.3, 3.0]) - f64::hypot(1.5, 2.0)).abs() < 1e-14);
    assert!(matches!(fine.check(), Err(MeshError::UnnamedBoundary(_))));
}

#[test]
fn rectangles_are_checked_and_named() {
    let mesh = rectangle([-1.0, 2.0], [3.0, 3.0], [4, 2], 1).unwrap();
    mesh.check().unwrap();
    assert_eq!((mesh.n_cells(), mesh.nodes.len(), euler(&mesh)), (32, 17 * 9, 1));
    assert_eq!(mesh.boundaries, ["left", "right", "bottom", "top"]);
    assert_eq!((count(&mesh, "left"), count(&mesh, "top")), (4, 8));
    assert!((mesh.quality().total_volume() - 4.0).abs() < 1e-14);
    for f in &mesh.facets {
        let x = mesh.nodes[mesh.facet_nodes(f.cell as usize, f.local as usize)[1] as usize];
        assert!([x[0] == -1.0, x[0] == 3.0, x[1] == 2.0, x[1] == 3.0][f.boundary as usize]);
    }
    assert!(rectangle([0.0, 0.0], [1.0, 0.0], [1, 1], 0).is_err());
    assert!(rectangle([0.0, 0.0], [1.0, f64::NAN], [1, 1], 0).is_err());
    assert!(rectangle([0.0, 0.0], [1.0, 1.0], [0, 1], 0).is_err());
}

#[test]
fn restriction_to_the_solid_turns_its_facets_round() {
    let mesh = turek_hron(1, 2);
    let solid = mesh.restrict(&["solid"]);
    solid.check().unwrap();
    assert_eq!(solid.regions, ["solid"]);
    assert_eq!(solid.boundaries, ["clamp", "interface"]);
    assert_eq!(count(&solid, "interface"), count(&mesh, "interface"));
    assert_eq!(euler(&solid), 1);
    let fluid = mesh.restrict(&["fluid"]);
    fluid.check().unwrap();
    assert_eq!(fluid.boundaries, ["inflow", "outflow", "walls", "cylinder", "interface"]);
    assert_eq!(count(&fluid, "interface"), count(&mesh, "interface"));
    assert_eq!(fluid.n_cells() + solid.n_cells(), mesh.n_cells());
    let both = mesh.restrict(&["solid", "fluid"]);
    assert_eq!((both.nodes, both.facets, both.regions), (mesh.nodes, mesh.facets, mesh.regions));
    // Without a name before, the facets are called interface all the same.
    let mut halves = unit_square(4);
    halves.assign_region("solid", |[x, _]| x - 0.5).unwrap();
    let right = halves.restrict(&["solid"]);
    right.check().unwrap();
    assert_eq!((count(&right, "interface"), right.n_cells()), (4, 8));
    assert!(right.boundary("left").is_none());
}

#[test]
fn regions_are_assigned_by_a_function_unless_it_cuts_cells() {
    let mut mesh = unit_square(4);
    assert_eq!(mesh.assign_region("solid", |[_, y]| 0.25 - y).unwrap(), [0, 1, 2, 3]);
    assert!(matches!(mesh.check_matching("fluid", "solid", &[]), Err(MeshError::UnmarkedInterface { .. })));
    assert_eq!(mesh.mark_interface("fluid", "solid").unwrap(), 4);
    mesh.check_matching("fluid", "solid", &[]).unwrap();
    let before = mesh.cell_region.clone();
    match mesh.assign_region("solid", |[_, y]| 0.3 - y) {
        Err(MeshError::CutCells { cells, .. }) => {
            assert_eq!((cells.count, cells.first.len()), (4, 4));
            assert_eq!((cells.first[0].cell, &cells.first[0].centre[..]), (4, &[0.125, 0.375][..]));
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(mesh.cell_region, before);
    assert!(matches!(mesh.assign_region("none", |_| -1.0), Err(MeshError::NoCells { .. })));
    assert!(matches!(mesh.assign_region("none", |_| f64::NAN), Err(MeshError::NotANumber { .. })));
    // A facet that is straight where the interface is curved cuts cells, too.
    let mut chord = unit_square(2);
    let circle = |[x, y]: [f64; 2]| (x - 1.0).powi(2) + (y - 0.5).powi(2) - 0.5;
    assert!(chord.assign_region("solid", circle).is_err());
    assert!(matches!(mesh.mark_interface("fluid", "beam"), Err(MeshError::UnknownName { .. })));
    let mut apart = unit_square(4);
    apart.assign_region("solid", |[_, y]| 0.25 - y).unwrap();
    apart.assign_region("other", |[_, y]| y - 0.75).unwrap();
    assert!(matches!(apart.mark_interface("other", "solid"), Err(MeshError::NoInterface { .. })));
}

/// The names of facets at `x`, that of the facet first, and the cell from which it is seen.
fn names_at(mesh: &Mesh<2>, x: [f64; 2]) -> (Vec<&str>, u32) {
    let here = |f: &&Facet| {
        let nodes = mesh.facet_nodes(f.cell as usize, f.local as usize);
        let n = nodes.len() as f64;
        let middle = [0, 1].map(|d| nodes.iter().map(|&n| mesh.nodes[n as usize][d]).sum::<f64>() / n);
        (middle[0] - x[0]).hypot(middle[1] - x[1]) < 1e-9
    };
    let all: Vec<&Facet> = mesh.facets.iter().chain(&mesh.parts).filter(here).collect();
    (all.iter().map(|f| mesh.boundaries[f.boundary as usize].as_str()).collect(), all[0].cell)
}

/// Four by four cells: solid in the lower left quarter, whose top is called `tip` and whose right side `right`, as the
/// right side of the square; a rock in the upper right one.
fn parts() -> Mesh<2> {
    let mut mesh = unit_square(4);
    mesh.assign_region("solid", |[x, y]| 0.5 - x.max(y)).unwrap();
    mesh.assign_region("rock", |[x, y]| x.min(y) - 0.5).unwrap();
    mesh.boundaries.push("tip".into());
    let (right, tip) = (mesh.boundary("right").unwrap(), mesh.boundary("tip").unwrap());
    for (cell, local, boundary) in [(4, 3, tip), (5, 3, tip), (2, 0, right), (5, 1, right), (9, 1, tip)] {
        mesh.facets.push(Facet { cell, local, boundary });
    }
    mesh
}

#[test]
fn names_on_the_interface_become_parts_of_it() {
    let mut mesh = parts();
    let outer = mesh.facets.len() - 5;
    assert_eq!(mesh.mark_interface("fluid", "solid").unwrap(), 4);
    mesh.mark_sides("rock", &["fluid", "solid"]).unwrap();
    mesh.check_interface("fluid", "solid").unwrap();
    assert_eq!(mesh.facets.len(), outer + 4 + 4);
    let finer = mesh.refine(&[]);
    for (mesh, scale) in
        [(&mesh, 1.0), (&mesh.triangulated(), 1.0), (&finer, 0.5), (&finer.triangulated(), 0.5)]
    {
        let [first, second] = [0.5 - 0.125 * scale, 0.125 * scale];
        for (x, names) in [
            ([first, 0.5], &["interface", "tip"][..]),
            ([second, 0.5], &["interface", "tip"]),
            ([0.5, first], &["interface", "right"]),
            ([0.5, 1.0 - first], &["tip"]),
            ([0.5, 1.0 - second], &["rock"]),
            ([1.0, first], &["right"]),
        ] {
            let (found, cell) = names_at(mesh, x);
            assert_eq!(found, names, "{x:?}");
            assert_eq!(mesh.regions[mesh.cell_region[cell as usize] as usize], "fluid", "{x:?}");
        }
        let count = |names: &[&str]| mesh.facets_on(names).len() as f64 * scale;
        assert_eq!((count(&["interface"]), count(&["tip"]), count(&["right"])), (4.0, 3.0, 6.0));
        assert_eq!(count(&["interface", "tip", "right"]), 9.0);
        // Seen from the solid alone the names are the same.
        let solid = mesh.restrict(&["solid"]);
        solid.check().unwrap();
        assert_eq!(names_at(&solid, [first, 0.5]).0, ["interface", "tip"]);
        assert_eq!(solid.facets_on(&["tip"]).len() as f64 * scale, 2.0);
        let both = mesh.restrict(&["fluid", "solid"]);
        both.check_matching("fluid", "solid", &[]).unwrap();
        assert_eq!(both.facets_on(&["rock"]).len() as f64 * scale, 3.0);
    }
    // Regions that are not kept need no names.
    mesh.facets.retain(|f| f.cell != 15);
    assert!(matches!(mesh.check(), Err(MeshError::UnnamedBoundary(_))));
    mesh.check_kept(&["fluid", "solid"]).unwrap();
    assert_eq!(mesh.components().iter().max(), Some(&3), "the fluid is in two parts");
}

#[test]
fn points_are_located() {
    let mesh = turek_hron(1, 3);
    let locator = Locator::new(&mesh);
    for i in 0..2000 {
        // A low-discrepancy sequence over the channel.
        let [s, t] = [0.754_877_666, 0.569_840_290].map(|g| (0.5 + g * i as f64).fract());
        let x = [2.5 * s, 0.41 * t];
        let r = (x[0] - 0.2).hypot(x[1] - 0.2);
        match locator.find(x) {
            Ok(at) => {
                let [a, b] = mesh.map(at.cell, at.xi);
                assert!(r > 0.0499 && (a - x[0]).hypot(b - x[1]) < 1e-6);
            }
            Err(e) => assert!(r < 0.05 && matches!(e, MeshError::Outside { .. }), "{e}"),
        }
    }
    for x in [[0.0, 0.0], [2.5, 0.41], [0.6, 0.2], [0.15, 0.2], [0.2 + 0.05 * 0.6, 0.2 + 0.05 * 0.8]] {
        let at = locator.find(x).unwrap();
        let [a, b] = mesh.map(at.cell, at.xi);
        assert!((a - x[0]).hypot(b - x[1]) < 1e-7);
    }
    let tip = locator.find_in("solid", [0.6, 0.2]).unwrap();
    assert_eq!(mesh.cell_region[tip.cell], 1);
    assert!(locator.find_in("solid", [0.7, 0.2]).is_err() && locator.find_in("gas", [0.7, 0.2]).is_err());
    let (node, away) = mesh.nearest_node([0.61, 0.2]).unwrap();
    assert!(away < 0.01 && mesh.nodes[node as usize][0] > 0.6);
}

#[test]
fn distances_to_straight_and_curved_facets_are_exact() {
    let mesh = turek_hron(0, 2);
    let beam = FacetDistance::new(&mesh, &["interface"]).unwrap();
    for (x, expected) in [
        ([0.45, 0.3], 0.09),
        ([0.45, 0.2], 0.01),
        ([0.7, 0.2], 0.1),
        ([0.63, 0.25], 0.05),
        ([0.5, 0.19], 0.0),
    ] {
        assert!((beam.distance(x) - expected).abs() < 1e-14, "{x:?} {}", beam.distance(x));
    }
    let circle = FacetDistance::new(&turek_hron(3, 0), &["cylinder", "clamp"]).unwrap();
    for angle in 0..40 {
        let (sin, cos) = (angle as f64 * 0.17).sin_cos();
        for r in [0.02, 0.0501, 0.3] {
            let away = circle.distance([0.2 + r * cos, 0.2 + r * sin]);
            // The biquadratic facets leave the circle by 1e-9 at this level.
            assert!((away - (r - 0.05_f64).abs()).abs() < 2e-9, "{angle} {r} {away}");
        }
    }
    assert!(matches!(FacetDistance::new(&mesh, &["beam"]), Err(MeshError::UnknownName { .. })));
}

#[test]
fn generators_give_the_same_bits_every_time() {
    let (one, two) = (turek_hron(1, 2), turek_hron(1, 2));
    assert_eq!((one.nodes, one.cell_nodes, one.facets), (two.nodes, two.cell_nodes, two.facets));
}

/// The ring: counts, nodes on both circles at every level, refused sizes.
#[test]
fn a_ring_has_the_promised_counts_and_circles() {
    for level in [0, 1, 2] {
        let mesh = annulus([0.5, 2.0], [12, 3], level).unwrap();
        assert_eq!((mesh.n_cells(), euler(&mesh)), (36 << (2 * level), 0));
        assert_eq!(
            (&mesh.regions[..], &mesh.boundaries[..]),
            (&["fluid".into()][..], &["inner".into(), "outer".into()][..])
        );
        assert_eq!([count(&mesh, "inner"), count(&mesh, "outer")], [12 << level; 2]);
        mesh.check_curves(&circles([0.5, 2.0])).unwrap();
        assert!(has_vertex(&mesh, [0.5, 0.0]));
        let gap = region_area(&mesh, "fluid") / (3.75 * PI) - 1.0;
        assert!(gap.abs() < 3e-4 / f64::from(16 << (4 * level)) * 16.0, "{level}: {gap:e}");
    }
    for (radii, cells) in
        [([1.0, 1.0], [4, 1]), ([0.0, 1.0], [4, 1]), ([1.0, 2.0], [6, 1]), ([1.0, 2.0], [4, 0])]
    {
        assert!(annulus(radii, cells, 0).is_err(), "{radii:?} {cells:?}");
    }
}

/// The valve: counts, areas, names; mirrored to the axis.
#[test]
fn the_valve_has_the_promised_counts_and_names() {
    for level in [0, 1] {
        let mesh = valve(level, 0);
        mesh.check_matching("fluid", "solid", &[]).unwrap();
        assert_eq!((mesh.n_cells(), euler(&mesh)), (432 << (2 * level), 1));
        assert_eq!(mesh.boundaries, ["inflow", "outflow", "walls", "clamp", "interface"]);
        assert_eq!(count(&mesh, "clamp"), 2 << level);
        assert_eq!(count(&mesh, "interface"), 26 << level);
        assert!((region_area(&mesh, "solid") - 1.6e-5).abs() < 1e-15);
        assert!((region_area(&mesh, "fluid") - 2e-3 + 1.6e-5).abs() < 1e-15);
        for x in &mesh.nodes {
            assert!(mesh.nearest_node([x[0], -x[1]]).unwrap().1 < 1e-15, "{x:?}");
        }
    }
    assert_eq!(valve(0, 2).n_cells(), 432 + 2 * 32);
}
