//! Meshes of hexahedra: what is drawn out of plane ones, cuboids and tubes; checks, location, distance and refinement.

use std::collections::HashSet;
use undula::math::Tensor;
use undula::mesh::generate::{
    annulus, bend, circles, cylinders, fsi_box, hexahedra, rectangle, tube, tube_graded, turek_hron,
};
use undula::mesh::{Curve, Extrusion, Facet, FacetDistance, Hierarchy, Locator, Mesh, MeshError};

fn count(mesh: &Mesh<3>, boundary: &str) -> usize {
    let number = mesh.boundary(boundary).unwrap();
    mesh.facets.iter().filter(|f| f.boundary == number).count()
}

fn volume(mesh: &Mesh<3>, region: &str) -> f64 {
    mesh.restrict(&[region]).quality().total_volume()
}

/// Euclidean distance.
fn away(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()
}

/// The mesh with its nodes at `f(x)`.
fn moved(mesh: &Mesh<3>, f: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh<3> {
    Mesh { nodes: mesh.nodes.iter().map(|&x| f(x)).collect(), ..mesh.clone() }
}

/// Both cells of every inner facet have the same points there, at their nodes of degree 4.
fn neighbours_meet(mesh: &Mesh<3>) {
    let facets = mesh.facets_of_cells();
    assert!(facets.bad.is_empty());
    assert_eq!(facets.outer.len() + 2 * facets.inner.len(), 6 * mesh.n_cells());
    let points = |cell: u32, local: u8| {
        let at = |i: usize, j: usize| {
            let (axis, side) = (local as usize / 2, f64::from(local % 2));
            let mut xi = [side; 3];
            (xi[(axis + 1) % 3], xi[(axis + 2) % 3]) = (i as f64 / 4.0, j as f64 / 4.0);
            mesh.map(cell as usize, xi)
        };
        (0..25).map(|i| at(i % 5, i / 5)).collect::<Vec<_>>()
    };
    for [one, two] in &facets.inner {
        let [one, two] = [one, two].map(|side| points(side.cell, side.local));
        let size = away(one[0], one[24]);
        assert!(one.iter().all(|x| two.iter().any(|y| away(*x, *y) < 1e-12 * size)));
    }
}

/// Regions, names and areas of the plane mesh times the depth.
#[test]
fn extruded_meshes_are_plane_ones_times_the_depth() {
    let plane = turek_hron(0, 1);
    let mesh = plane.extruded(0.41, 3).unwrap();
    mesh.check_matching("fluid", "solid", &[]).unwrap();
    neighbours_meet(&mesh);
    assert_eq!((mesh.n_cells(), mesh.nodes.len()), (3 * plane.n_cells(), 7 * plane.nodes.len()));
    assert_eq!(mesh.regions, plane.regions);
    assert_eq!(mesh.boundaries, [&plane.boundaries[..], &["front".into(), "back".into()]].concat());
    for (number, name) in plane.boundaries.iter().enumerate() {
        let edges = plane.facets.iter().filter(|f| f.boundary as usize == number).count();
        assert_eq!(count(&mesh, name), 3 * edges, "{name}");
    }
    assert_eq!([count(&mesh, "front"), count(&mesh, "back")], [plane.n_cells(); 2]);
    for region in ["fluid", "solid"] {
        let area = plane.restrict(&[region]).quality().total_volume();
        assert!((volume(&mesh, region) / (0.41 * area) - 1.0).abs() < 1e-13, "{region}");
    }
    let least = plane.quality().min_scaled_jacobian();
    assert!((mesh.quality().min_scaled_jacobian() / least - 1.0).abs() < 1e-12);
    for f in &mesh.facets {
        let at =
            mesh.facet_nodes(f.cell as usize, f.local as usize).into_iter().map(|n| mesh.nodes[n as usize]);
        let [r, z]: [Vec<f64>; 2] =
            [at.clone().map(|x| (x[0] - 0.2).hypot(x[1] - 0.2)).collect(), at.map(|x| x[2]).collect()];
        match mesh.boundaries[f.boundary as usize].as_str() {
            "front" => assert!(z.iter().all(|z| *z == 0.0)),
            "back" => assert!(z.iter().all(|z| *z == 0.41)),
            "cylinder" => assert!(r.iter().all(|r| (r - 0.05).abs() < 1e-15)),
            "interface" => assert_eq!(mesh.cell_region[f.cell as usize], 0, "seen from the fluid"),
            _ => {}
        }
    }
    let solid = mesh.restrict(&["solid"]);
    solid.check().unwrap();
    assert_eq!(solid.boundaries, ["clamp", "interface", "front", "back"]);
    // The order of cells and nodes that the documentation promises.
    let c = mesh.centre(3 * 17 + 2);
    let [x, y] = plane.centre(17);
    assert!(away(c, [x, y, 0.41 * 5.0 / 6.0]) < 1e-14);
    assert_eq!(mesh.nodes[7 * 100 + 3], [plane.nodes[100][0], plane.nodes[100][1], 0.205]);
}

/// Further names of facets go with them.
#[test]
fn parts_of_the_interface_are_extruded() {
    let mut plane = rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], 0).unwrap();
    plane.assign_region("solid", |[_, y]| 0.5 - y).unwrap();
    plane.boundaries.push("tip".into());
    plane.facets.push(Facet { cell: 1, local: 3, boundary: 4 });
    plane.mark_interface("fluid", "solid").unwrap();
    let mesh = plane.extruded(1.0, 2).unwrap();
    mesh.check_matching("fluid", "solid", &[]).unwrap();
    assert_eq!((mesh.facets_on(&["interface"]).len(), mesh.facets_on(&["tip"]).len()), (4, 2));
    for f in mesh.facets_on(&["tip"]) {
        assert!(mesh.centre(f.cell as usize)[0] > 0.5 && mesh.cell_region[f.cell as usize] == 0);
    }
    // Regions can be named in space as well.
    let mut other = rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], 0).unwrap().extruded(1.0, 2).unwrap();
    assert_eq!(other.assign_region("solid", |[_, y, _]| 0.5 - y).unwrap().len(), 4);
    assert_eq!(other.mark_interface("fluid", "solid").unwrap(), 4);
    other.check_matching("fluid", "solid", &[]).unwrap();
    assert_eq!(other.components(), [0, 0, 0, 0, 1, 1, 1, 1]);
    assert!(matches!(other.assign_region("solid", |[.., z]| 0.6 - z), Err(MeshError::CutCells { .. })));
}

#[test]
fn what_cannot_be_extruded_is_refused() {
    let plane = rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], 0).unwrap();
    let message = |mesh: &Mesh<2>, depth, layers| mesh.extruded(depth, layers).unwrap_err().to_string();
    for depth in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(message(&plane, depth, 1).ends_with(&format!("depth = {depth}: expected a number above 0")));
    }
    assert!(message(&plane, 1.0, 0).ends_with("layers = 0: at least one is needed"));
    assert!(message(&plane, 1.0, usize::MAX).contains("more nodes than 32 bits can number"));
    let expected = "mesh generator `extrude`: the mesh has triangles: expected quadrilaterals";
    assert_eq!(message(&plane.triangulated(), 1.0, 1), expected);
    for name in ["front", "back"] {
        let mut plane = plane.clone();
        plane.boundaries[2] = name.into();
        assert!(message(&plane, 1.0, 1).contains(&format!("the mesh has the name `{name}` already")));
    }
}

/// The levels of a plane mesh times those of the depth: the cells are refined ones of each other.
#[test]
fn hierarchies_are_extruded() {
    let ring = annulus([0.5, 1.0], [8, 1], 0).unwrap();
    let (plane, planes) = Hierarchy::refine(ring, 2, &circles([0.5, 1.0]));
    let how = |depth: f64, layers| Extrusion { depth, layers, grading: 0, halved: true };
    for layers in [4, 8, 12] {
        let (finest, hierarchy) = planes.extruded(&plane, how(0.3, layers)).unwrap();
        finest.check().unwrap();
        let levels = 2;
        assert_eq!((finest.n_cells(), hierarchy.coarser().len()), (layers * plane.n_cells(), levels));
        // Names that the finest mesh has are those of all levels.
        let named = hierarchy.clone().named_as(&finest);
        assert_eq!(named.coarser().len(), levels);
        for (one, two) in named.coarser().iter().zip(hierarchy.coarser()) {
            let sides =
                |mesh: &Mesh<3>| mesh.facets.iter().map(|f| (f.side(), f.boundary)).collect::<HashSet<_>>();
            assert_eq!(sides(one), sides(two));
        }
        let volume = 0.3 * plane.quality().total_volume();
        assert!((finest.quality().total_volume() / volume - 1.0).abs() < 1e-13);
        let meshes: Vec<_> = hierarchy.levels(&finest).collect();
        for pair in meshes.windows(2) {
            let same = pair[0].refine(&[]);
            assert_eq!((&same.cell_region, &same.boundaries), (&pair[1].cell_region, &pair[1].boundaries));
            for cell in 0..same.n_cells() {
                // Nodes at the circle are moved onto it, and those behind by less.
                let gap = away(same.centre(cell), pair[1].centre(cell));
                assert!(gap < 1e-2 * same.cell_diameter(cell), "{gap}");
            }
            let sides =
                |mesh: &Mesh<3>| mesh.facets.iter().map(|f| (f.side(), f.boundary)).collect::<HashSet<_>>();
            assert_eq!(sides(&same), sides(pair[1]));
        }
    }
    assert!(planes.extruded(&plane, how(-1.0, 2)).is_err());
}

#[test]
fn cuboids_are_checked_and_named() {
    let mesh = hexahedra([-1.0, 2.0, 0.5], [3.0, 3.0, 1.1], [4, 2, 1], 1).unwrap();
    mesh.check().unwrap();
    neighbours_meet(&mesh);
    assert_eq!((mesh.n_cells(), mesh.nodes.len()), (64, 17 * 9 * 5));
    assert_eq!(mesh.boundaries, ["left", "right", "bottom", "top", "front", "back"]);
    assert!((mesh.quality().total_volume() - 2.4).abs() < 1e-14);
    for f in &mesh.facets {
        for node in mesh.facet_nodes(f.cell as usize, f.local as usize) {
            let [x, y, z] = mesh.nodes[node as usize];
            let off = [x + 1.0, x - 3.0, y - 2.0, y - 3.0, z - 0.5, z - 1.1];
            assert!(off[f.boundary as usize].abs() < 1e-15, "{x} {y} {z}");
        }
    }
    assert_eq!([count(&mesh, "left"), count(&mesh, "top"), count(&mesh, "back")], [8, 16, 32]);
    let (finest, hierarchy) = Hierarchy::refine(hexahedra([0.0; 3], [1.0; 3], [2, 1, 1], 0).unwrap(), 1, &[]);
    let same = hexahedra([0.0; 3], [1.0; 3], [2, 1, 1], 1).unwrap();
    assert_eq!(
        (&same.nodes, &same.cell_nodes, &same.facets),
        (&finest.nodes, &finest.cell_nodes, &finest.facets)
    );
    assert_eq!(hierarchy.coarser()[0].n_cells(), 2);
    for (lower, upper, cells, refine, expected) in [
        ([0.0; 3], [1.0, 1.0, 0.0], [1; 3], 0, "must be below upper"),
        ([0.0; 3], [1.0, f64::NAN, 1.0], [1; 3], 0, "must be below upper"),
        ([0.0; 3], [1.0, f64::INFINITY, 1.0], [1; 3], 0, "must be below upper"),
        ([0.0; 3], [1.0; 3], [1, 0, 1], 0, "at least one in each direction"),
        ([0.0; 3], [1.0; 3], [1; 3], 10, "more nodes than 32 bits"),
        ([0.0; 3], [1.0; 3], [usize::MAX; 3], 0, "more nodes than 32 bits"),
        ([0.0; 3], [1.0; 3], [1; 3], 100, "more nodes than 32 bits"),
    ] {
        let message = hexahedra(lower, upper, cells, refine).unwrap_err().to_string();
        assert!(
            message.starts_with("mesh generator `hexahedra`: ") && message.contains(expected),
            "{message}"
        );
    }
}

/// A quarter of a ring turned about the y axis: x = (2 + r) (cos φ, sin φ) with φ along z. Its volume is that of the
/// section times the way of its centre.
fn bent(cells: usize) -> Mesh<3> {
    let plane = rectangle([0.0, 0.0], [1.0, 0.5], [cells, cells], 0).unwrap();
    let mesh = plane.extruded(1.0, 2 * cells).unwrap();
    moved(&mesh, |[x, y, z]| {
        let (sin, cos) = (z * std::f64::consts::FRAC_PI_2).sin_cos();
        [(2.0 + x) * cos, y + 0.1 * x * x, (2.0 + x) * sin]
    })
}

#[test]
fn bent_meshes_have_the_volume_of_the_body_with_order_four() {
    let errors = [1, 2, 4].map(|cells| {
        let mesh = bent(cells);
        mesh.check_orientation().unwrap();
        neighbours_meet(&mesh);
        // π/2 ∫ (2 + x) dx dy over the section.
        (mesh.quality().total_volume() / (0.5 * std::f64::consts::PI * 1.25) - 1.0).abs()
    });
    assert!(errors[2] < 1e-5 && errors[1] < errors[0] / 14.0 && errors[2] < errors[1] / 14.0, "{errors:?}");
}

/// A sequence that fills the unit cube evenly.
fn points(n: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..n).map(|i| [0.819_172_513, 0.671_043_607, 0.549_700_478].map(|g| (0.5 + g * i as f64).fract()))
}

#[test]
fn points_of_curved_hexahedra_are_located() {
    let mesh = bent(3);
    let locator = Locator::new(&mesh);
    for (i, xi) in points(500).enumerate() {
        let cell = i * 37 % mesh.n_cells();
        let x = mesh.map(cell, xi);
        let at = locator.find(x).unwrap();
        assert!(at.cell == cell && away(at.xi, xi) < 1e-9, "{i}: {at:?} {xi:?}");
        // On the side of two cells it is the first of them.
        let on_side = mesh.map(cell, [1.0, xi[1], xi[2]]);
        let at = locator.find(on_side).unwrap();
        assert!(at.cell <= cell && away(mesh.map(at.cell, at.xi), on_side) < 1e-12);
    }
    for x in [[0.0, 0.2, 0.0], [2.5, 0.7, 0.0], [2.5, 0.2, -0.1]] {
        assert!(matches!(locator.find(x), Err(MeshError::Outside { .. })), "{x:?}");
    }
}

/// Moves the plane at height z onto the sphere of that radius.
fn blown_up([x, y, z]: [f64; 3]) -> [f64; 3] {
    let [x, y] = [x, y].map(|x| (x * std::f64::consts::FRAC_PI_4).tan());
    let scale = z / (1.0 + x * x + y * y).sqrt();
    [x * scale, y * scale, scale]
}

/// The distance to surfaces of known shape: a plane with its edges and corners, a cylinder, a sphere.
#[test]
fn distances_to_surfaces_are_those_of_their_formulas() {
    let cuboid = hexahedra([0.0; 3], [2.0, 1.0, 1.0], [3, 2, 2], 0).unwrap();
    let top = FacetDistance::new(&cuboid, &["top"]).unwrap();
    for x in points(200).map(|x| x.map(|x| 6.0 * x - 2.0)) {
        let gap = [x[0].clamp(0.0, 2.0), 1.0, x[2].clamp(0.0, 1.0)];
        assert!((top.distance(x) - away(x, gap)).abs() < 1e-14, "{x:?}");
    }
    // Facets of which the sides are not at right angles.
    let skew = moved(&cuboid, |[x, y, z]| [x + 0.9 * z + 0.3 * x * z, y + 0.5 * z - x, z]);
    let back = FacetDistance::new(&skew, &["back"]).unwrap();
    for x in points(200) {
        // Above the middle of the parallelogram.
        let (s, t) = (0.4 + 1.2 * x[0], 0.2 + 0.6 * x[1]);
        let above = [1.3 * s + 0.9, t + 0.5 - s, 1.0 + 0.2 * x[2]];
        assert!((back.distance(above) - 0.2 * x[2]).abs() < 1e-14, "{x:?}");
    }
    let ring = annulus([0.5, 1.0], [16, 2], 1).unwrap().extruded(1.0, 3).unwrap();
    let inner = FacetDistance::new(&ring, &["inner"]).unwrap();
    // A part of a cube, blown up: |x| = 2 at its back.
    let cube = hexahedra([-1.0, -1.0, 1.0], [1.0, 1.0, 2.0], [16, 16, 1], 0).unwrap();
    let sphere = moved(&cube, blown_up);
    let outer = FacetDistance::new(&sphere, &["back"]).unwrap();
    for [s, t, u] in points(300) {
        let (sin, cos) = (s * std::f64::consts::TAU).sin_cos();
        let r = 0.1 + 1.2 * u;
        // The sides leave the circle by 1e-6 at 32 of them.
        let gap = inner.distance([r * cos, r * sin, t]) - (r - 0.5).abs();
        assert!(gap.abs() < 2e-6, "{gap:e}");
        let beyond = inner.distance([r * cos, r * sin, 1.0 + t]) - (r - 0.5).hypot(t);
        assert!(beyond.abs() < 2e-6, "{beyond:e}");
        let direction = [1.4 * s - 0.7, 1.4 * t - 0.7, 1.0];
        let length = away(direction, [0.0; 3]);
        let x = direction.map(|d| d / length * (1.0 + 2.0 * u));
        assert!((outer.distance(x) - (2.0 * u - 1.0).abs()).abs() < 6e-5, "{}", outer.distance(x));
    }
}

/// A point straight above a curved facet is as far from it as it is high, to rounding.
#[test]
fn distances_to_curved_facets_are_exact() {
    let mesh = bent(2);
    for (name, local) in [("top", 3), ("bottom", 2), ("right", 1)] {
        let facets = FacetDistance::new(&mesh, &[name]).unwrap();
        let cells: Vec<_> = mesh.facets_on(&[name]).iter().map(|f| f.cell as usize).collect();
        for (i, [s, t, height]) in points(200).enumerate() {
            let (axis, mut xi) = (local / 2, [(local % 2) as f64; 3]);
            (xi[(axis + 1) % 3], xi[(axis + 2) % 3]) = (s, t);
            let cell = cells[i % cells.len()];
            let (x, a) = (mesh.map(cell, xi), mesh.map_gradient(cell, xi));
            let column = |j: usize| [0, 1, 2].map(|i| a[i][j]);
            let (a, b) = (column((axis + 1) % 3), column((axis + 2) % 3));
            let normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let length = away(normal, [0.0; 3]);
            let height = 0.6 * height - 0.3;
            let above = std::array::from_fn(|d| x[d] + height * normal[d] / length);
            assert!((facets.distance(above) - height.abs()).abs() < 1e-13, "{name} {i} {height}");
        }
    }
}

/// One cell of degree 1 or 2 with its nodes moved by up to `by`.
fn shaken(degree: usize, by: f64, random: &mut impl FnMut() -> f64) -> Mesh<3> {
    let mut mesh = hexahedra([0.0; 3], [1.0; 3], [1; 3], 0).unwrap();
    if degree == 1 {
        let vertices = mesh.cell_vertices(0);
        mesh = Mesh { degree: 1, cell_nodes: vertices, ..mesh };
    }
    moved(&mesh, |x| x)
        .nodes
        .iter()
        .enumerate()
        .for_each(|(n, x)| mesh.nodes[n] = x.map(|x| x + by * random()));
    mesh
}

/// Random cells: the check says what dense samples do, and what a few points of a cell do not see.
#[test]
fn folds_of_hexahedra_are_found_between_their_nodes() {
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    for degree in [1, 2] {
        let (mut folded, mut sound, mut missed) = (0, 0, 0);
        for i in 0..150 {
            let by = if degree == 1 { 1.5 } else { 0.4 } * f64::from(i % 10 + 1) / 10.0;
            let mesh = shaken(degree, by, &mut random);
            let at = |i: usize| [i % 13, i / 13 % 13, i / 169].map(|i| i as f64 / 12.0);
            let least =
                (0..13 * 13 * 13).map(|i| Tensor(mesh.map_gradient(0, at(i))).det()).fold(f64::MAX, f64::min);
            match mesh.check_orientation() {
                Ok(()) => {
                    sound += 1;
                    assert!(least > 0.0, "{least}");
                }
                Err(MeshError::Inverted(_, found)) => {
                    folded += 1;
                    missed += usize::from(mesh.quality().inverted.is_empty());
                    assert!(least < 0.05 && found.det < least + 1e-3, "{least} {found}");
                    assert!(found.to_string().contains("m^3 in cell 0 at ("));
                    let message = mesh.check_orientation().unwrap_err().to_string();
                    assert!(message.contains("(folded or numbered against the right-hand rule): 0 at ("));
                }
                Err(other) => panic!("{other}"),
            }
        }
        // Of straight ones the points see nearly all.
        assert!(
            sound > 20 && folded > 20 && (missed > 0 || degree == 1),
            "{degree}: {sound} {folded} {missed}"
        );
    }
}

/// The lumen and the wall: names, counts, shape, volume with order four, nodes on both cylinders on every level.
#[test]
fn a_tube_has_the_promised_names_and_volumes() {
    let (size, pi) = ([0.05, 0.005, 0.001], std::f64::consts::PI);
    let mut errors = vec![];
    for level in 0..3 {
        let mesh = tube(size, [2, 8, 1], level).unwrap();
        let n = 1 << level;
        mesh.check_matching("fluid", "solid", &cylinders(size)).unwrap();
        neighbours_meet(&mesh);
        assert_eq!(
            (&mesh.regions[..], mesh.n_cells()),
            (&["fluid".into(), "solid".into()][..], 40 * n * n * n)
        );
        assert_eq!(mesh.boundaries, ["inflow", "outflow", "clamp", "outside", "interface"]);
        let counts = ["inflow", "outflow", "clamp", "outside", "interface"].map(|name| count(&mesh, name));
        assert_eq!(counts, [12, 12, 16, 16, 16].map(|count| count * n * n));
        let least = mesh.quality().min_scaled_jacobian();
        assert!(least > 0.7, "{least}");
        for f in &mesh.facets {
            for node in mesh.facet_nodes(f.cell as usize, f.local as usize) {
                let [x, y, z] = mesh.nodes[node as usize];
                let (r, at) = (x.hypot(y), |a: f64, b: f64| (a - b).abs() < 1e-16);
                assert!(match f.boundary {
                    0 => z == 0.0 && r < 0.005 + 1e-16,
                    1 => at(z, 0.05) && r < 0.005 + 1e-16,
                    2 => (z == 0.0 || at(z, 0.05)) && r > 0.005 - 1e-16,
                    3 => at(r, 0.006),
                    _ => at(r, 0.005) && mesh.cell_region[f.cell as usize] == 0,
                });
            }
        }
        // There are vertices on the axes.
        assert!(mesh.nearest_node([0.005, 0.0, 0.025]).unwrap().1 < 1e-16);
        let [fluid, solid] = [25e-6, 11e-6].map(|area| 0.05 * pi * area);
        errors
            .push([volume(&mesh, "fluid") / fluid - 1.0, volume(&mesh, "solid") / solid - 1.0].map(f64::abs));
    }
    for (coarse, fine) in errors.iter().zip(&errors[1..]) {
        assert!(coarse.iter().zip(fine).all(|(coarse, fine)| *fine < coarse / 14.0), "{errors:?}");
    }
    assert!(errors[2][0] < 1e-5, "{errors:?}");
    for (size, cells) in
        [([1.0; 3], [1, 4, 1]), ([1.0, 1.0, 0.01], [2, 16, 2]), ([1.0, 1.0, 9.0], [1, 20, 4])]
    {
        let mesh = tube(size, cells, 0).unwrap();
        mesh.check_matching("fluid", "solid", &cylinders(size)).unwrap();
        assert!(mesh.quality().min_scaled_jacobian() > 0.7);
    }
    for (size, cells) in [
        ([0.0, 1.0, 1.0], [1, 8, 1]),
        ([1.0, 1.0, 0.0], [1, 8, 1]),
        ([1.0, f64::NAN, 1.0], [1, 8, 1]),
        ([1.0; 3], [1, 6, 1]),
        ([1.0; 3], [0, 8, 1]),
        ([1.0; 3], [1, 0, 1]),
        ([1.0; 3], [1, 8, 0]),
    ] {
        assert!(tube(size, cells, 0).unwrap_err().to_string().starts_with("mesh generator `tube`: "));
    }
}

#[test]
fn layers_at_both_ends_are_halved() {
    let plane = rectangle([0.0, 0.0], [2.0, 1.0], [2, 1], 0).unwrap();
    let mesh = plane.extruded_graded(1.0, 2, 2).unwrap();
    neighbours_meet(&mesh);
    let mut levels: Vec<f64> = mesh.nodes.iter().map(|x| x[2]).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let vertices: Vec<f64> = levels.into_iter().step_by(2).collect();
    assert_eq!(vertices, [0.0, 0.125, 0.25, 0.5, 0.75, 0.875, 1.0]);
    assert!((volume(&mesh, "fluid") - 2.0).abs() < 1e-14);
    assert!(plane.extruded_graded(1.0, 1, 1).is_err());
}

/// Names, counts and places of the sides of the box and of the channel; halved layers stay at its sides.
#[test]
fn an_elastic_box_has_the_promised_names() {
    for (level, grading) in [(0, 0), (1, 0), (0, 1), (0, 2)] {
        let mesh = fsi_box(level, grading).unwrap();
        mesh.check_matching("fluid", "solid", &[]).unwrap();
        let n = 1 + grading;
        let cells = (7 + 4 * n) * (4 + 3 * n) * (4 + 2 * n);
        assert_eq!(mesh.n_cells(), cells << (3 * level));
        let volumes = [volume(&mesh, "solid") / 0.004 - 1.0, volume(&mesh, "fluid") / 0.236 - 1.0];
        assert!(volumes.iter().all(|error| error.abs() < 1e-13), "{volumes:?}");
        assert_eq!(mesh.boundaries, ["inflow", "outflow", "walls", "symmetry", "clamp", "interface"]);
        for f in &mesh.facets {
            let nodes = mesh.facet_nodes(f.cell as usize, f.local as usize);
            let points: Vec<[f64; 3]> = nodes.iter().map(|&node| mesh.nodes[node as usize]).collect();
            let on = |d: usize, x: f64| points.iter().all(|p| (p[d] - x).abs() < 1e-15);
            let at_body = points.iter().all(|p| {
                p[0] > 0.4 - 1e-12 && p[0] < 0.5 + 1e-12 && p[1] < 0.2 + 1e-12 && p[2] < 0.2 + 1e-12
            });
            assert!(match f.boundary {
                0 => on(0, 0.0),
                1 => on(0, 1.5),
                2 => (on(1, 0.0) && !at_body) || on(1, 0.4) || on(2, 0.4),
                3 => on(2, 0.0),
                4 => on(1, 0.0) && at_body,
                _ =>
                    at_body
                        && (on(0, 0.4) || on(0, 0.5) || on(1, 0.2) || on(2, 0.2))
                        && mesh.cell_region[f.cell as usize] == 0,
            });
        }
        // All facets are rectangles along the axes.
        let area_of = |f: &Facet| {
            let nodes = mesh.facet_nodes(f.cell as usize, f.local as usize);
            let points: Vec<[f64; 3]> = nodes.iter().map(|&node| mesh.nodes[node as usize]).collect();
            let extent = |d: usize| points.iter().map(|p| (p[d] - points[0][d]).abs()).fold(0.0, f64::max);
            let extents = [extent(0), extent(1), extent(2)];
            extents.iter().filter(|x| **x > 1e-12).product::<f64>()
        };
        let area = |name: &str| -> f64 {
            let boundary = mesh.boundary(name);
            mesh.facets.iter().filter(|f| Some(f.boundary) == boundary).map(area_of).sum()
        };
        let areas =
            [("walls", 1.5 * 0.4 * 3.0 - 0.02), ("symmetry", 0.6), ("clamp", 0.02), ("interface", 0.12)];
        for (name, expected) in areas {
            assert!((area(name) - expected).abs() < 1e-13, "{name}: {}", area(name));
        }
    }
}

/// Sides on spheres and cylinders are refined onto them: order four in the volume.
#[test]
fn boundaries_follow_spheres_and_cylinders_under_refinement() {
    let spheres = [("front", 1.0), ("back", 2.0)].map(|(name, radius)| Curve::Sphere {
        boundaries: vec![name.into()],
        centre: [0.0; 3],
        radius,
    });
    // A sixth of a hollow ball.
    let cube = hexahedra([-1.0, -1.0, 1.0], [1.0, 1.0, 2.0], [2, 2, 1], 0).unwrap();
    let hollow = moved(&cube, blown_up);
    // Half of a cylinder about an axis that is none of the coordinates.
    let (axis, pi) = ([1.0, 2.0, 2.0].map(|x| x / 3.0), std::f64::consts::PI);
    let (e, f) = ([2.0, 1.0, -2.0].map(|x| x / 3.0), [-2.0, 2.0, -1.0].map(|x| x / 3.0));
    let plate = hexahedra([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], [1, 2, 1], 0).unwrap();
    let shell = moved(&plate, |[r, t, z]| {
        let (sin, cos) = (pi * t).sin_cos();
        std::array::from_fn(|d| 0.3 + r * (cos * e[d] + sin * f[d]) + z * axis[d])
    });
    let cylinders = [("left", 1.0), ("right", 2.0)].map(|(name, radius)| {
        let (point, axis) = (axis.map(|a| 0.3 - 7.0 * a), axis.map(|a| 5.0 * a));
        Curve::Cylinder { boundaries: vec![name.into()], point, axis, radius }
    });
    for (mesh, curves, exact) in
        [(hollow, spheres.to_vec(), 14.0 / 9.0 * pi), (shell, cylinders.to_vec(), 1.5 * pi)]
    {
        let levels: Vec<Mesh<3>> = (0..3).map(|level| mesh.clone().refined(level, &curves)).collect();
        let errors: Vec<f64> = levels
            .iter()
            .map(|mesh| {
                mesh.check().unwrap();
                mesh.check_curves(&curves).unwrap();
                neighbours_meet(mesh);
                (mesh.quality().total_volume() / exact - 1.0).abs()
            })
            .collect();
        assert!(errors.windows(2).all(|e| e[1] < e[0] / 10.0) && errors[2] < 2e-4, "{errors:?}");
        let least = levels[2].quality().min_scaled_jacobian();
        assert!(least > 0.3, "{least}");
    }
}

/// Faces of two boundaries of which one is a translation of the other, curved ones, too.
#[test]
fn seams_match_curved_sides() {
    let cube = hexahedra([0.0; 3], [2.0, 1.0, 1.0], [2, 3, 2], 0).unwrap();
    let wavy = moved(&cube, |[x, y, z]| [x + 0.2 * y * (1.0 - y) + 0.1 * z, y + 0.1 * x, z + 0.05 * x]);
    let seams = wavy.seams(["left", "right"]).unwrap();
    assert_eq!(seams.len(), 6);
    for seam in &seams {
        assert!(away(seam.shift, [2.0, 0.2, 0.1]) < 1e-15);
        for k in [1, 2, 3] {
            let twins = seam.twins(&wavy, k);
            assert_eq!(twins.len(), (k + 1) * (k + 1));
            for [a, b] in twins {
                let at = |side: usize, node: usize| {
                    let xi = wavy.shape.lattice(k, node).map(|i| i as f64 / k as f64);
                    wavy.map(seam.sides[side].cell as usize, xi)
                };
                let there = std::array::from_fn(|d| at(0, a)[d] + seam.shift[d]);
                assert!(away(there, at(1, b)) < 1e-14);
            }
        }
    }
    let bulged = moved(&cube, |[x, y, z]| [x + 0.2 * x * y * (1.0 - y), y, z]);
    assert!(bulged.seams(["left", "right"]).is_err());
    assert_eq!(bulged.seams(["front", "back"]).unwrap().len(), 6);
}

/// A mesh that is cut open, or finer on one side, is refused; so is a name that is missing.
#[test]
fn gaps_between_hexahedra_are_refused() {
    let mut mesh = hexahedra([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1], 0).unwrap();
    let mut open = mesh.clone();
    let n = open.nodes.len() as u32;
    open.nodes.extend(mesh.nodes.clone());
    open.cell_nodes[27..].iter_mut().for_each(|node| *node += n);
    assert!(matches!(open.check(), Err(MeshError::DuplicatedNodes(cells)) if cells.count == 2));
    let finer = hexahedra([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], [1, 2, 1], 0).unwrap();
    let mut hanging = hexahedra([0.0; 3], [1.0; 3], [1; 3], 0).unwrap();
    let n = hanging.nodes.len() as u32;
    hanging.nodes.extend(&finer.nodes);
    hanging.cell_nodes.extend(finer.cell_nodes.iter().map(|node| node + n));
    hanging.cell_region.extend(&finer.cell_region);
    assert!(matches!(hanging.check(), Err(MeshError::HangingNodes(cells)) if cells.count == 3));
    mesh.facets.retain(|f| f.boundary != 5);
    assert!(matches!(mesh.check(), Err(MeshError::UnnamedBoundary(cells)) if cells.count == 2));
    // One face with other nodes in the middle.
    let mut misfit = hexahedra([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1], 0).unwrap();
    let between = misfit.facets_of_cells().inner[0];
    let middle = misfit.facet_nodes(between[1].cell as usize, between[1].local as usize)[4];
    misfit.nodes.push(misfit.nodes[middle as usize]);
    let new = misfit.nodes.len() as u32 - 1;
    misfit.cell_nodes[27..].iter_mut().filter(|node| **node == middle).for_each(|node| *node = new);
    assert!(matches!(misfit.check(), Err(MeshError::NotConforming(_))));
}

/// Rings that are halved towards the wall change neither the volume nor the names, and nothing but the rings.
#[test]
fn tubes_are_graded_towards_the_wall() {
    let (size, cells) = ([0.4, 0.5, 0.1], [1, 16, 1]);
    let even = tube(size, cells, 0).unwrap();
    for grading in [1, 3] {
        let mesh = tube_graded(size, cells, grading, 0).unwrap();
        mesh.check_matching("fluid", "solid", &cylinders(size)).unwrap();
        neighbours_meet(&mesh);
        assert_eq!((mesh.n_cells(), &mesh.boundaries), (even.n_cells() + 16 * grading, &even.boundaries));
        for region in ["fluid", "solid"] {
            // The circle is one of degree 2 pieces, the same in both.
            assert!((volume(&mesh, region) / volume(&even, region) - 1.0).abs() < 1e-13, "{region}");
        }
        let radii: Vec<f64> =
            mesh.nodes.iter().filter(|x| x[1] == 0.0 && x[2] == 0.0).map(|x| x[0]).collect();
        // The core ends at 0.3 on the diagonals, further in than on the axes.
        let ring = radii.iter().filter(|r| **r > 0.45 && **r < 0.5 - 1e-9).fold(0.0f64, |a, r| a.max(*r));
        // Its middle; both rings together are 0.26 on the axes.
        let half = (0.5 - ring) * 2.0_f64.powi(grading as i32);
        assert!((0.06..0.07).contains(&half), "{half}");
    }
}

/// Pappus: a tube along a curve has the volume of its section times the length of the axis, whose nodes follow it.
#[test]
fn bent_tubes_have_the_volume_of_their_axis() {
    let (length, radius) = (1.5, 0.9_f64);
    let size = [length, 0.3, 0.06];
    let (sin, cos) = (|s: f64| (s / radius).sin(), |s: f64| (s / radius).cos());
    // An arc in a plane that is none of the coordinates, beginning along z.
    let (c, d) = (0.6, 0.8);
    let arc = |s: f64| {
        let out = radius * (1.0 - cos(s));
        [[c * out, d * out, radius * sin(s)], [c * sin(s), d * sin(s), cos(s)]]
    };
    let errors = [4, 8].map(|along| {
        let straight = tube(size, [along, 16, 1], 0).unwrap();
        let mut mesh = straight.clone();
        bend(&mut mesh, arc);
        mesh.check_matching("fluid", "solid", &[]).unwrap();
        neighbours_meet(&mesh);
        let quality = mesh.quality();
        assert!(quality.min_scaled_jacobian() > 0.5, "{}", quality.min_scaled_jacobian());
        let wall = mesh.boundary("interface").unwrap();
        for f in mesh.facets.iter().filter(|f| f.boundary == wall) {
            for node in mesh.facet_nodes(f.cell as usize, f.local as usize) {
                let [x, y, z] = mesh.nodes[node as usize];
                let (across, along) = (d * x - c * y, c * x + d * y);
                let from_axis = across.hypot((along - radius).hypot(z) - radius);
                assert!((from_axis - 0.3).abs() < 1e-14);
            }
        }
        ["fluid", "solid"].map(|region| (volume(&mesh, region) / volume(&straight, region) - 1.0).abs())
    });
    for i in 0..2 {
        assert!(errors[1][i] < 2e-5 && errors[1][i] < errors[0][i] / 12.0, "{errors:?}");
    }
}

/// The mesh with every cell numbered along other axes, right-handed ones.
fn turned(mesh: &Mesh<3>) -> Mesh<3> {
    let mut seed = 7_usize;
    let (n, k, mut new) = (mesh.shape.n_nodes(mesh.degree), mesh.degree, mesh.clone());
    for cell in 0..mesh.n_cells() {
        seed = (seed * 1_103_515_245 + 12_345) % (1 << 31);
        let choice = seed >> 12;
        let even = choice & 1 == 0;
        let first = choice / 2 % 3;
        let axes = [first, (first + if even { 1 } else { 2 }) % 3, (first + if even { 2 } else { 1 }) % 3];
        let mut flipped = [(choice / 6) & 1 == 0, (choice / 12) & 1 == 0, false];
        flipped[2] = (flipped[0] != flipped[1]) == even;
        for node in 0..n {
            let (at, mut old) = (mesh.shape.lattice(k, node), [0; 3]);
            (0..3).for_each(|d| old[axes[d]] = if flipped[d] { k - at[d] } else { at[d] });
            new.cell_nodes[cell * n + node] = mesh.cell(cell)[mesh.shape.number(k, old)];
        }
        for facet in new.facets.iter_mut().filter(|f| f.cell as usize == cell) {
            let d = (0..3).find(|&d| axes[d] == facet.local as usize / 2).unwrap();
            facet.local = 2 * d as u8 + if flipped[d] { 1 - facet.local % 2 } else { facet.local % 2 };
        }
    }
    new
}

/// Nothing depends on how cells are numbered, nor on how a face looks from its two cells.
#[test]
fn cells_may_be_numbered_along_any_axes() {
    let size = [2.0, 0.5, 0.1];
    let mesh = tube(size, [2, 8, 1], 0).unwrap();
    let other = turned(&mesh);
    assert!(mesh.cell_nodes != other.cell_nodes);
    let curves = cylinders(size);
    let (fine, fine_other) = (mesh.refine(&curves), other.refine(&curves));
    for (mesh, other) in [(&mesh, &other), (&fine, &fine_other)] {
        other.check_matching("fluid", "solid", &curves).unwrap();
        neighbours_meet(other);
        assert_eq!((mesh.nodes.len(), mesh.facets.len()), (other.nodes.len(), other.facets.len()));
        let [a, b] = [mesh, other].map(Mesh::quality);
        assert!((a.total_volume() - b.total_volume()).abs() < 1e-14);
        assert!((a.min_scaled_jacobian() - b.min_scaled_jacobian()).abs() < 1e-12);
        for name in ["interface", "clamp"] {
            let [one, two] = [mesh, other].map(|mesh| FacetDistance::new(mesh, &[name]).unwrap());
            // On the axis all points of the facets are nearly as near.
            let beside = |x: &[f64; 3]| x[0].hypot(x[1]) > 0.01;
            for x in points(80).map(|[s, t, u]| [1.4 * s - 0.7, 1.4 * t - 0.7, 2.0 * u]).filter(beside) {
                assert!((one.distance(x) - two.distance(x)).abs() < 1e-12);
            }
        }
        let locator = Locator::new(other);
        for (i, xi) in points(100).enumerate() {
            let x = mesh.map(i % mesh.n_cells(), xi);
            let at = locator.find(x).unwrap();
            assert!(away(other.map(at.cell, at.xi), x) < 1e-12);
        }
    }
    assert!(fine.nodes.iter().all(|x| fine_other.nearest_node(*x).unwrap().1 < 1e-14));
    assert_eq!(other.seams(["inflow", "outflow"]).unwrap().len(), 12);
}
