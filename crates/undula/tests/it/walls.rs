//! Walls that are grown from a surface: their volume, their ends, and what is refused.

use std::f64::consts::PI;
use std::path::Path;
use undula::mesh::generate::{bend, hexahedra, tube};
use undula::mesh::gmsh::{AnyMesh, read_any};
use undula::mesh::{Facet, Mesh, MeshError, Wall};

const MESHES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/meshes");

fn file(name: &str) -> Mesh<3> {
    match read_any(&Path::new(MESHES).join(name)).unwrap_or_else(|e| panic!("{e}")) {
        AnyMesh::Space(mesh) => mesh,
        AnyMesh::Plane(_) => panic!("a plane mesh"),
    }
}

/// The fluid 0 < z < 2 in a tube of radius 1, `round` cells round it.
fn lumen(round: usize) -> Mesh<3> {
    tube([2.0, 1.0, 0.1], [round / 4, round, 1], 0).unwrap().restrict(&["fluid"])
}

/// The same with straight edges.
fn straight(mut mesh: Mesh<3>) -> Mesh<3> {
    mesh.cell_nodes = (0..mesh.n_cells()).flat_map(|c| mesh.cell_vertices(c)).collect();
    mesh.degree = 1;
    mesh.restrict(&["fluid"])
}

fn grown(mesh: &Mesh<3>, surface: &[&str], thickness: f64, layers: usize) -> Result<Mesh<3>, MeshError> {
    let surface: Vec<String> = surface.iter().map(|name| name.to_string()).collect();
    mesh.with_wall(&Wall { surface: &surface, thickness: &|_| thickness, layers })
}

fn wall_volume(mesh: &Mesh<3>) -> f64 {
    mesh.restrict(&["wall"]).quality().total_volume()
}

/// The nodes of a boundary.
fn nodes_on(mesh: &Mesh<3>, name: &str) -> Vec<[f64; 3]> {
    let facets = mesh.facets_on(&[name]);
    assert!(!facets.is_empty(), "{name}");
    let nodes = facets.iter().flat_map(|f| mesh.facet_nodes(f.cell as usize, f.local as usize));
    nodes.map(|n| mesh.nodes[n as usize]).collect()
}

/// The ends lie in the planes of the openings, names and neighbours fit, the outer nodes have their distance.
fn sound(mesh: &Mesh<3>, off: [fn([f64; 3]) -> f64; 2]) {
    mesh.check().unwrap_or_else(|e| panic!("{e}"));
    mesh.sides_are("wall", &["wall-inflow", "wall-outflow", "outer"]);
    for (name, off) in ["wall-inflow", "wall-outflow"].into_iter().zip(off) {
        let worst = nodes_on(mesh, name).into_iter().map(|x| off(x).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-14, "{name}: {worst:e}");
    }
}

trait Sides {
    /// Asserts that the outer facets of `region` have exactly these names.
    fn sides_are(&self, region: &str, names: &[&str]);
}

impl Sides for Mesh<3> {
    fn sides_are(&self, region: &str, names: &[&str]) {
        let number = self.region(region).unwrap();
        let outer: std::collections::HashSet<_> = self.facets_of_cells().outer.into_iter().collect();
        let facets = self.facets.iter();
        let mut found: Vec<&str> = facets
            .filter(|f| self.cell_region[f.cell as usize] == number && outer.contains(&f.side()))
            .map(|f| self.boundaries[f.boundary as usize].as_str())
            .collect();
        found.sort_unstable();
        found.dedup();
        let mut names = names.to_vec();
        names.sort_unstable();
        assert_eq!(found, names);
    }
}

/// Order 4 in h on curved cells and 2 on straight ones, in tetrahedra and hexahedra, through one layer and several.
#[test]
fn the_volume_of_a_straight_wall_converges() {
    let exact = PI * (1.3f64.powi(2) - 1.0) * 2.0;
    for (simplices, curved, order) in
        [(false, true, 3.8), (true, true, 3.8), (false, false, 1.9), (true, false, 1.9)]
    {
        let errors = [(8, 1), (16, 3)].map(|(round, layers)| {
            let mesh = lumen(round);
            let mesh = if curved { mesh } else { straight(mesh) };
            let mesh = if simplices { mesh.in_tetrahedra() } else { mesh };
            let facets = mesh.facets_on(&["interface"]).len();
            let whole = grown(&mesh, &["interface"], 0.3, layers).unwrap();
            assert_eq!(whole.n_cells(), mesh.n_cells() + facets * layers * if simplices { 3 } else { 1 });
            sound(&whole, [|x| x[2], |x| x[2] - 2.0]);
            let outer = nodes_on(&whole, "outer").into_iter();
            let off = outer.map(|x| (x[0].hypot(x[1]) - 1.3).abs()).fold(0.0, f64::max);
            ((wall_volume(&whole) / exact - 1.0).abs(), off)
        });
        let [(coarse, _), (fine, off)] = errors;
        println!("simplices {simplices} curved {curved}: {errors:?}, order {}", (coarse / fine).log2());
        assert!((coarse / fine).log2() > order, "{simplices} {curved}: {errors:?}");
        assert!(off < if curved { 1e-4 } else { 2e-2 }, "{off:e}");
    }
}

/// Lumina that Gmsh has made, with 4 and 10 nodes.
#[test]
fn a_lumen_of_gmsh_gets_a_wall() {
    let exact = PI * (1.2f64.powi(2) - 1.0) * 2.0;
    for (order, within) in [(1, 0.15), (2, 3e-3)] {
        let mesh = grown(&file(&format!("lumen_{order}.msh")), &["lumen"], 0.2, 1).unwrap();
        sound(&mesh, [|x| x[2], |x| x[2] - 2.0]);
        assert_eq!(mesh.regions, ["fluid", "wall"]);
        let volume = wall_volume(&mesh);
        println!("{order}: {:e}", volume / exact - 1.0);
        assert!((volume / exact - 1.0).abs() < within, "{volume} {exact}");
        let quality = mesh.restrict(&["wall"]).quality().min_scaled_jacobian();
        assert!(quality > 0.1, "{quality}");
    }
}

/// At an oblique opening the end lies in its plane, nodes near it lean with it, and the wall keeps its thickness.
#[test]
fn oblique_openings_have_plane_ends() {
    for simplices in [false, true] {
        let mut mesh = lumen(16);
        mesh.nodes.iter_mut().for_each(|x| x[2] += 0.6 * x[0]);
        let mesh = if simplices { mesh.in_tetrahedra() } else { mesh };
        let whole = grown(&mesh, &["interface"], 0.4, 2).unwrap();
        sound(&whole, [|x| x[2] - 0.6 * x[0], |x| x[2] - 0.6 * x[0] - 2.0]);
        let exact = PI * (1.4f64.powi(2) - 1.0) * 2.0;
        let volume = wall_volume(&whole);
        assert!((volume / exact - 1.0).abs() < 5e-3, "{volume} {exact}");
        let outer = nodes_on(&whole, "outer").into_iter().map(|x| x[0].hypot(x[1]) - 1.4);
        let (least, most) = outer.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        assert!(least > -1e-3 && most < 0.01, "{least:e} {most:e}");
    }
}

/// Where two openings meet at the surface, the wall ends on the line in both planes.
#[test]
fn corners_of_a_quarter_lie_in_both_planes() {
    for name in ["ring_tetrahedra_2_v4.1_binary.msh", "ring_2_v2.2.msh", "ring_tetrahedra_1_v2.2.msh"] {
        let mesh = grown(&file(name), &["outside"], 0.1, 1).unwrap();
        mesh.check().unwrap_or_else(|e| panic!("{e}"));
        mesh.sides_are("wall", &["wall-front", "wall-back", "wall-bottom", "wall-left", "outer"]);
        for (side, axis, at) in
            [("wall-front", 2, 0.0), ("wall-back", 2, 0.6), ("wall-bottom", 1, 0.0), ("wall-left", 0, 0.0)]
        {
            assert!(nodes_on(&mesh, side).iter().all(|x| (x[axis] - at).abs() < 1e-14), "{side}");
        }
        let exact = 0.6 * 0.25 * PI * (1.3f64.powi(2) - 1.2 * 1.2);
        let within = if name.contains("_1_") { 0.1 } else { 5e-3 };
        assert!((wall_volume(&mesh) / exact - 1.0).abs() < within, "{name}");
    }
}

/// Flat sides have their thickness up to the edge between them, and a body without openings gets a closed shell.
#[test]
fn edges_are_mitred() {
    let cube = hexahedra([0.0; 3], [1.0; 3], [2, 3, 1], 0).unwrap();
    for mesh in [cube.clone(), cube.in_tetrahedra(), straight(cube)] {
        let corner = grown(&mesh, &["top", "right"], 0.25, 2).unwrap();
        corner.check().unwrap();
        corner.sides_are("wall", &["wall-left", "wall-bottom", "wall-front", "wall-back", "outer"]);
        assert!((wall_volume(&corner) - 0.25 * 2.25).abs() < 1e-14);
        let all = ["left", "right", "bottom", "top", "front", "back"];
        let shell = grown(&mesh, &all, 0.25, 1).unwrap();
        shell.check().unwrap();
        shell.sides_are("wall", &["outer"]);
        assert!((wall_volume(&shell) - (1.5f64.powi(3) - 1.0)).abs() < 1e-13);
    }
}

/// A tube round a circle of radius 2.
fn bent() -> Mesh<3> {
    let mut mesh = lumen(16);
    bend(&mut mesh, |z| {
        let (sin, cos) = (0.5 * z).sin_cos();
        [[2.0 - 2.0 * cos, 0.0, 2.0 * sin], [sin, 0.0, cos]]
    });
    mesh
}

/// Inside of a bend there is room up to the axis of the bend, here for a thickness of 1.
#[test]
fn walls_that_fold_or_meet_are_refused_with_the_place() {
    for mesh in [bent(), bent().in_tetrahedra()] {
        sound(
            &grown(&mesh, &["interface"], 0.8, 2).unwrap(),
            [|x| x[2], |x| (x[0] - 2.0) * 1f64.sin() + x[2] * 1f64.cos()],
        );
        let message = grown(&mesh, &["interface"], 1.6, 2).unwrap_err().to_string();
        let part: f64 = message.split("beside an oblique opening; ").nth(1).unwrap()[..4].parse().unwrap();
        assert!(message.starts_with("the wall folds in ") && (0.55..0.7).contains(&part), "{message}");
        // The place is on the inside, beyond the axis of the bend.
        let at = message.split("most at (").nth(1).unwrap().split(')').next().unwrap();
        let at: Vec<f64> = at.split(", ").map(|x| x.parse().unwrap()).collect();
        assert!(at[0] > 1.95, "{message}");
    }
    // Two cubes with a gap of 1 between them.
    let mut cubes = hexahedra([0.0; 3], [3.0, 1.0, 1.0], [3, 1, 1], 0).unwrap();
    cubes.assign_region("gap", |x| (x[0] - 1.0) * (2.0 - x[0])).unwrap();
    let cubes = cubes.restrict(&["fluid"]);
    assert!((wall_volume(&grown(&cubes, &["interface"], 0.4, 1).unwrap()) - 0.8).abs() < 1e-14);
    let message = grown(&cubes, &["interface"], 0.6, 1).unwrap_err().to_string();
    assert!(message.starts_with("the wall meets region `wall` at ("), "{message}");
    let message = grown(&cubes, &["interface"], 1.2, 1).unwrap_err().to_string();
    assert!(message.starts_with("the wall meets region `fluid` at ("), "{message}");
}

#[test]
fn surfaces_without_a_wall_are_refused() {
    let cube = hexahedra([0.0; 3], [1.0; 3], [2, 2, 2], 0).unwrap();
    let wrong = |mesh: &Mesh<3>, surface: &[&str], thickness: f64, expected: &str| {
        let message = grown(mesh, surface, thickness, 1).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    wrong(&cube, &["lumen"], 0.1, "the mesh has no boundary `lumen`; it has `left`, `right`");
    wrong(&cube, &["top"], -0.1, "it is -0.1 at (1, 1, 0): expected a number above 0 everywhere");
    wrong(&cube, &["top"], f64::NAN, "it is NaN at (1, 1, 0)");
    let once = grown(&cube, &["top"], 0.1, 1).unwrap();
    wrong(&once, &["bottom"], 0.1, "the mesh has a region `wall` already");
    wrong(&once, &["outer"], 0.1, "the mesh has a region `wall` already");
    let mut taken = cube.clone();
    taken.boundaries[4] = "outer".into();
    wrong(&taken, &["top"], 0.1, "the mesh has a boundary `outer` already");
    let whole = tube([2.0, 1.0, 0.1], [2, 8, 1], 0).unwrap();
    wrong(&whole, &["interface"], 0.1, "expected an outer boundary: there are cells on both sides of it");
    let with = |change: fn(&mut [f64; 3])| {
        let mut mesh = cube.clone();
        mesh.nodes.iter_mut().for_each(change);
        mesh
    };
    wrong(&with(|x| x[1] += 6.0 * x[0]), &["right"], 0.1, "is nearly tangential to the surface at (1, ");
    let bowed = with(|x| x[2] += 0.2 * x[0] * (1.0 - x[0]));
    wrong(&bowed, &["top"], 0.1, "which is not plane (at (");
    // A needle: the facets at its tip look to all sides.
    let mut needle = cube.in_tetrahedra();
    needle.degree = 1;
    needle.nodes = vec![[0.0; 3], [1.0, 0.02, 0.0], [1.0, -0.01, 0.0173], [1.0, -0.01, -0.0173]];
    (needle.cell_nodes, needle.cell_region) = (vec![0, 1, 2, 3], vec![0]);
    (needle.boundaries, needle.parts) = (vec!["base".into(), "side".into()], vec![]);
    needle.facets = (0..4).map(|local| Facet { cell: 0, local, boundary: u16::from(local > 0) }).collect();
    needle.check().unwrap();
    wrong(&needle, &["side"], 0.1, "it has a tip at (0, 0, 0), where a wall has no direction");
}
