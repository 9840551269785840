//! Meshes of hexahedra and tetrahedra from Gmsh: files that it wrote, in all formats, and what we write.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use undula::element::Shape;
use undula::math::Tensor;
use undula::mesh::generate::{hexahedra, rectangle, tube};
use undula::mesh::gmsh::{AnyMesh, parse, parse_any, read, read_any, shape, write};
use undula::mesh::{Curve, Mesh, MeshError};

const FORMATS: [&str; 4] = ["v2.2", "v2.2_binary", "v4.1", "v4.1_binary"];

fn file(order: usize, format: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/meshes/ring_{order}_{format}.msh"))
}

fn in_space(found: Result<AnyMesh, MeshError>) -> Mesh<3> {
    match found.unwrap_or_else(|e| panic!("{e}")) {
        AnyMesh::Space(mesh) => mesh,
        AnyMesh::Plane(_) => panic!("a plane mesh"),
    }
}

fn cylinder(name: &str, radius: f64) -> Curve<3> {
    Curve::Cylinder { boundaries: vec![name.into()], point: [0.0; 3], axis: [0.0, 0.0, 2.0], radius }
}

fn tetrahedra(order: usize, format: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/meshes/ring_tetrahedra_{order}_{format}.msh"))
}

/// A quarter of a ring with a wall around it, two layers of two cells round, one across each: all formats of Gmsh give
/// the same mesh.
#[test]
fn hexahedra_of_gmsh_are_read_in_all_formats() {
    for order in [1, 2] {
        let first = in_space(read_any(&file(order, "v2.2")));
        for format in FORMATS {
            let path = file(order, format);
            assert_eq!(shape(&path).unwrap(), Shape::Hexahedron);
            let mesh = in_space(read_any(&path));
            assert_eq!((mesh.shape, mesh.degree, mesh.n_cells()), (Shape::Hexahedron, order, 8), "{format}");
            assert_eq!(mesh.nodes.len(), [3 * 3 * 3, 5 * 5 * 5][order - 1]);
            mesh.check_matching(
                "fluid",
                "solid",
                &[0.5, 1.0, 1.2].map(|r| {
                    cylinder(
                        if r == 0.5 {
                            "inner"
                        } else if r == 1.0 {
                            "interface"
                        } else {
                            "outside"
                        },
                        r,
                    )
                }),
            )
            .unwrap();
            assert_eq!(mesh.regions, ["fluid", "solid"]);
            assert_eq!(mesh.boundaries, ["front", "back", "bottom", "left", "inner", "outside", "interface"]);
            assert_eq!((&mesh.regions, &mesh.cell_region), (&first.regions, &first.cell_region));
            assert_eq!(mesh.facets, first.facets);
            let sections = [0.75, 0.44].map(|square| 0.6 * 0.25 * PI * square);
            for (region, exact) in ["fluid", "solid"].into_iter().zip(sections) {
                let volume = mesh.restrict(&[region]).quality().total_volume();
                // Chords of 45 degrees, and parabolas through their ends and the middle of the arc.
                let (sin, cos) = (PI / 8.0).sin_cos();
                let bow = if order == 2 { 4.0 / 3.0 * sin * (1.0 - cos) } else { 0.0 };
                let kept = (sin * cos + bow) / (PI / 8.0);
                assert!((volume / (kept * exact) - 1.0).abs() < 1e-9, "{format}: {volume} {exact}");
            }
            assert!(mesh.quality().min_scaled_jacobian() > 0.7);
            for f in &mesh.facets {
                for node in mesh.facet_nodes(f.cell as usize, f.local as usize) {
                    let [x, y, z] = mesh.nodes[node as usize];
                    let off = [z, z - 0.6, y, x, x.hypot(y) - 0.5, x.hypot(y) - 1.2, x.hypot(y) - 1.0];
                    assert!(off[f.boundary as usize].abs() < 1e-9, "{format} {f:?} {x} {y} {z}");
                }
            }
        }
    }
}

/// Our own files come back to the last bit.
#[test]
fn hexahedra_survive_writing_and_reading() {
    let mut straight = hexahedra([0.0; 3], [1.0, 2.0, 3.0], [2, 1, 1], 1).unwrap();
    let vertices = (0..straight.n_cells()).flat_map(|c| straight.cell_vertices(c)).collect();
    (straight.degree, straight.cell_nodes) = (1, vertices);
    let straight = straight.restrict(&["fluid"]);
    for mesh in [tube([3.0, 0.5, 0.1], [2, 8, 1], 0).unwrap(), straight, in_space(read_any(&file(2, "v4.1")))]
    {
        let again = in_space(parse_any(write(&mesh), Path::new("own.msh")));
        let sorted = |mesh: &Mesh<3>| {
            let mut facets = mesh.facets.clone();
            facets.sort_by_key(|f| f.side());
            facets
        };
        assert_eq!(sorted(&again), sorted(&mesh));
        assert_eq!((&again.nodes, &again.cell_nodes), (&mesh.nodes, &mesh.cell_nodes));
        assert_eq!((&again.regions, &again.cell_region), (&mesh.regions, &mesh.cell_region));
        assert_eq!((again.boundaries, again.degree), (mesh.boundaries, mesh.degree));
    }
    let plane = rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], 0).unwrap();
    let again = parse_any(write(&plane), Path::new("own.msh")).unwrap();
    assert!(matches!(again, AnyMesh::Plane(mesh) if mesh.cell_nodes == plane.cell_nodes));
}

/// Cells of which the vertices are numbered against the right-hand rule are turned, with their facets.
#[test]
fn hexahedra_numbered_the_other_way_are_turned() {
    let mesh = hexahedra([0.0; 3], [1.0; 3], [1, 1, 1], 0).unwrap();
    let mut text = write(&mesh);
    let line = text.lines().find(|line| line.split(' ').nth(1) == Some("12")).unwrap().to_string();
    // The first two coordinates exchanged, in the order of Gmsh.
    let order =
        [0, 3, 2, 1, 4, 7, 6, 5, 9, 8, 10, 13, 15, 11, 14, 12, 17, 16, 19, 18, 20, 22, 21, 24, 23, 25, 26];
    let words: Vec<&str> = line.split(' ').collect();
    let turned: Vec<&str> = order.iter().map(|i| words[5 + i]).collect();
    text = text.replace(&line, &format!("{} {}", words[..5].join(" "), turned.join(" ")));
    let again = in_space(parse_any(text, Path::new("own.msh")));
    again.check().unwrap();
    assert!((again.quality().total_volume() - 1.0).abs() < 1e-14);
    for f in &again.facets {
        for node in again.facet_nodes(f.cell as usize, f.local as usize) {
            let [x, y, z] = again.nodes[node as usize];
            assert!([x == 0.0, x == 1.0, y == 0.0, y == 1.0, z == 0.0, z == 1.0][f.boundary as usize]);
        }
    }
}

/// What a file with volumes can have wrong: cells of other shapes, sides that are none, groups without a name.
#[test]
fn files_that_are_no_hexahedra_are_refused_with_advice() {
    let text = std::fs::read_to_string(file(1, "v2.2")).unwrap();
    let line = |kind: &str| text.lines().find(|l| l.split(' ').nth(1) == Some(kind) && l.len() > 12).unwrap();
    let number = |line: &str| 1 + text.lines().position(|l| l == line).unwrap();
    let (cell, side) = (line("5"), line("3"));
    let as_kind = |kind: usize, nodes: usize| {
        let words: Vec<&str> = cell.split(' ').collect();
        let nodes = (1..=nodes).map(|n| n.to_string()).collect::<Vec<_>>().join(" ");
        format!("{} {kind} {} {nodes}", words[0], words[2..5].join(" "))
    };
    for (from, to, expected) in [
        (cell, as_kind(29, 20), "elements of order above 2 are not supported"),
        (
            cell,
            as_kind(6, 6),
            "wedges are not supported in three dimensions, tetrahedra of 4 or 10 nodes and hexahedra of 8 or 27 are",
        ),
        (cell, as_kind(7, 5), "pyramids are not supported"),
        (cell, as_kind(7, 5), "`Mesh.SubdivisionAlgorithm = 2;`"),
        (cell, as_kind(17, 20), "hexahedra with 20 nodes are not supported: write 27 nodes"),
        (cell, as_kind(92, 64), "elements of order above 2 are not supported"),
        (
            cell,
            cell.replace(" 5 2 7 ", " 5 2 0 "),
            "a cell in no physical group: give its volume a named one",
        ),
        (cell, cell.replace(" 5 2 7 ", " 5 2 70 "), "Physical Volume(\"fluid\")"),
        (
            side,
            side.replace(" 3 2 1 ", " 3 2 70 "),
            "a facet in physical group 70, which has no name: give its surface",
        ),
        (side, side.replace(" 3 2 1 ", " 2 2 1 "), "a facet that is no side of a cell"),
    ] {
        assert!(from != to, "{from}");
        let broken = text.replacen(from, &to, 1);
        let message = parse_any(&broken, Path::new("own.msh")).expect_err(&to).to_string();
        assert!(message.contains(expected), "{to}: {message}");
        assert!(message.starts_with(&format!("own.msh:{}: ", number(from))), "{message}");
    }
    // One cell with 27 nodes among those with eight.
    let nodes = text.replacen(cell, &as_kind(12, 27), 1);
    let message = parse_any(nodes, Path::new("own.msh")).unwrap_err().to_string();
    assert!(
        message.contains("7 hexahedra with 8 nodes and 1 hexahedron with 27 nodes; all must be alike"),
        "{message}"
    );
    let message =
        parse_any(text.replacen(cell, &as_kind(4, 4), 1), Path::new("own.msh")).unwrap_err().to_string();
    assert!(
        message.contains(
            "1 tetrahedron and 7 hexahedra; all must be alike: `Mesh.SubdivisionAlgorithm = 2;` makes hexahedra"
        ),
        "{message}"
    );
    // A side between two cells of the fluid.
    let inner = text.replacen(side, &side.replace(" 3 2 1 ", " 3 2 9 "), 1);
    let mesh = in_space(parse_any(inner, Path::new("own.msh")));
    assert!(matches!(mesh.check_matching("fluid", "solid", &[]), Err(MeshError::StrayInterface { .. })));
    // The plane reader says what is wrong.
    let message = read(&file(2, "v4.1_binary")).unwrap_err().to_string();
    assert!(message.contains("a mesh of hexahedra, where a plane one is needed"), "{message}");
    assert!(parse(&text, Path::new("own.msh")).unwrap_err().to_string().starts_with("own.msh:"));
}

/// No part of a file and no change of a byte makes the reader panic.
#[test]
fn mutilated_files_of_hexahedra_do_not_panic() {
    for format in FORMATS {
        let (path, bytes) = (file(1, format), std::fs::read(file(1, format)).unwrap());
        for end in (0..bytes.len()).step_by(23) {
            let _ = parse_any(&bytes[..end], &path);
        }
        for at in (0..bytes.len()).step_by(11) {
            for value in [0, 1, 0x7f, 0xff, b'\n', b'$', b'9'] {
                let mut bytes = bytes.clone();
                bytes[at] = value;
                let _ = parse_any(&bytes, &path);
            }
        }
    }
}

/// The same ring in tetrahedra without structure: all formats give one mesh, whose second order follows the circles.
#[test]
fn tetrahedra_of_gmsh_are_read_in_all_formats() {
    for order in [1, 2] {
        let first = in_space(read_any(&tetrahedra(order, "v2.2")));
        for format in FORMATS {
            let path = tetrahedra(order, format);
            assert_eq!(shape(&path).unwrap(), Shape::Tetrahedron);
            let mesh = in_space(read_any(&path));
            assert_eq!(
                (mesh.shape, mesh.degree, mesh.n_cells()),
                (Shape::Tetrahedron, order, 78),
                "{format}"
            );
            let curves = [("inner", 0.5), ("interface", 1.0), ("outside", 1.2)];
            mesh.check_matching(
                "fluid",
                "solid",
                &curves.map(|(name, r)| cylinder(name, r))[..2 * order - 1],
            )
            .unwrap();
            assert_eq!(mesh.regions, ["fluid", "solid"]);
            assert_eq!(mesh.boundaries, ["front", "back", "bottom", "left", "inner", "outside", "interface"]);
            assert_eq!((&mesh.cell_region, &mesh.facets), (&first.cell_region, &first.facets));
            let exact = [0.75, 0.44].map(|square| 0.6 * 0.25 * PI * square);
            for (region, exact) in ["fluid", "solid"].into_iter().zip(exact) {
                let volume = mesh.restrict(&[region]).quality().total_volume();
                let within = [0.2, 0.01][order - 1];
                assert!((volume / exact - 1.0).abs() < within, "{order} {format}: {volume} {exact}");
            }
            // Refined, the new nodes are moved onto the circles.
            let fine = mesh.refine(&curves.map(|(name, r)| cylinder(name, r)));
            fine.check_matching("fluid", "solid", &curves.map(|(name, r)| cylinder(name, r))).unwrap();
        }
    }
}

/// Our own files come back to the last bit, and cells numbered the other way are turned, with their facets.
#[test]
fn tetrahedra_survive_writing_and_reading() {
    let mut mesh = in_space(read_any(&tetrahedra(2, "v4.1_binary")));
    for mirrored in [false, true] {
        let again = in_space(parse_any(write(&mesh), Path::new("own.msh")));
        let sorted = |mesh: &Mesh<3>| {
            let mut facets = mesh.facets.clone();
            facets.sort_by_key(|f| f.side());
            facets
        };
        again.check().unwrap();
        assert_eq!(
            (sorted(&again) == sorted(&mesh), again.cell_nodes == mesh.cell_nodes),
            (!mirrored, !mirrored)
        );
        for (f, x) in again.facets.iter().flat_map(|f| {
            let nodes = again.facet_nodes(f.cell as usize, f.local as usize);
            nodes.into_iter().map(|n| (f, again.nodes[n as usize])).collect::<Vec<_>>()
        }) {
            let y = if mirrored { -x[1] } else { x[1] };
            let r = x[0].hypot(y);
            let off = [x[2], x[2] - 0.6, y, x[0], r - 0.5, r - 1.2, r - 1.0];
            assert!(off[f.boundary as usize].abs() < 1e-9, "{f:?} {x:?}");
        }
        mesh.nodes.iter_mut().for_each(|x| x[1] = -x[1]);
    }
}

/// What a file of tetrahedra can have wrong is named: an interface with two sets of nodes, finer cells on one side, a
/// second order that folds, sides without a name, wedges among the cells.
#[test]
fn defects_of_tetrahedra_are_named() {
    let whole = in_space(read_any(&tetrahedra(2, "v2.2")));
    let with = |change: &dyn Fn(&mut Mesh<3>)| {
        let mut mesh = whole.clone();
        change(&mut mesh);
        let mesh = in_space(parse_any(write(&mesh), Path::new("own.msh")));
        mesh.check_matching("fluid", "solid", &[]).unwrap_err()
    };
    let n = whole.nodes.len() as u32;
    let open = |mesh: &mut Mesh<3>| {
        mesh.nodes.extend(mesh.nodes.clone());
        let solid: Vec<usize> = (0..mesh.n_cells()).filter(|&c| mesh.cell_region[c] == 1).collect();
        solid
            .iter()
            .for_each(|c| mesh.cell_nodes[10 * c..10 * (c + 1)].iter_mut().for_each(|node| *node += n));
    };
    assert!(matches!(with(&open), MeshError::DuplicatedNodes(cells) if cells.count > 2));
    let fine = |mesh: &mut Mesh<3>| {
        let part = whole.restrict(&["solid"]).refine(&[]);
        *mesh = whole.restrict(&["fluid"]);
        let (nodes, cells) = (mesh.nodes.len() as u32, mesh.n_cells() as u32);
        mesh.nodes.extend(&part.nodes);
        mesh.cell_nodes.extend(part.cell_nodes.iter().map(|node| node + nodes));
        mesh.cell_region.extend(part.cell_region.iter().map(|_| 1));
        mesh.regions.push("solid".into());
        for facet in &part.facets {
            let name = &part.boundaries[facet.boundary as usize];
            if name != "interface" {
                let boundary = mesh.boundary(name).unwrap_or_else(|| {
                    mesh.boundaries.push(name.clone());
                    mesh.boundaries.len() as u16 - 1
                });
                mesh.facets.push(undula::mesh::Facet {
                    cell: facet.cell + cells,
                    local: facet.local,
                    boundary,
                });
            }
        }
    };
    assert!(matches!(with(&fine), MeshError::HangingNodes(cells) if cells.count > 2));
    // The middle of an edge moved by more than a quarter of it towards one end.
    let fold = |mesh: &mut Mesh<3>| {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.cell(7)[i] as usize);
        mesh.nodes[b] = std::array::from_fn(|d| 0.8 * mesh.nodes[c][d] + 0.2 * mesh.nodes[a][d]);
    };
    let message = with(&fold);
    assert!(matches!(&message, MeshError::Inverted(_, least) if least.det < 0.0), "{message}");
    assert!(message.to_string().contains("folded"), "{message}");
    let unnamed = |mesh: &mut Mesh<3>| mesh.facets.retain(|f| f.boundary != 2);
    assert!(matches!(with(&unnamed), MeshError::UnnamedBoundary(_)));
    let text = write(&whole);
    let cell = text.lines().find(|l| l.split(' ').nth(1) == Some("11")).unwrap();
    let wedge = text.replacen(
        cell,
        &cell.split(' ').take(11).collect::<Vec<_>>().join(" ").replacen(" 11 ", " 6 ", 1),
        1,
    );
    let message = parse_any(wedge, Path::new("own.msh")).unwrap_err().to_string();
    assert!(
        message.contains("wedges are not supported in three dimensions, tetrahedra of 4 or 10"),
        "{message}"
    );
}

/// Random tetrahedra of second order: the bound of det says what dense samples do.
#[test]
fn folds_of_tetrahedra_are_found_between_their_nodes() {
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let (mut folded, mut sound, mut missed) = (0, 0, 0);
    let whole = hexahedra([0.0; 3], [1.0; 3], [1; 3], 0).unwrap().in_tetrahedra();
    for i in 0..200 {
        let mut mesh = whole.clone();
        let by = 0.9 * f64::from(i % 10 + 1) / 10.0;
        mesh.nodes.iter_mut().flatten().for_each(|x| *x += by * random());
        mesh.cell_nodes.truncate(10);
        mesh.cell_region.truncate(1);
        mesh.facets.clear();
        let nodes = (0..Shape::Tetrahedron.n_nodes(12)).map(|n| Shape::Tetrahedron.lattice(12, n));
        let dets = nodes.map(|at| Tensor(mesh.map_gradient(0, at.map(|i| i as f64 / 12.0))).det());
        let least = dets.fold(f64::MAX, f64::min);
        match mesh.check_orientation() {
            Ok(()) => {
                sound += 1;
                assert!(least > 0.0, "{least}");
            }
            Err(MeshError::Inverted(_, found)) => {
                folded += 1;
                missed += usize::from(mesh.quality().inverted.is_empty());
                assert!(least < 0.05 && found.det < least + 1e-3, "{least} {found}");
            }
            Err(other) => panic!("{other}"),
        }
    }
    println!("{sound} sound, {folded} folded, {missed} of them between nodes and points");
    assert!(sound > 20 && folded > 20 && missed > 0, "{sound} {folded} {missed}");
}
