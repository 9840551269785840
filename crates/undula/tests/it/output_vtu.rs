//! VTU files and their collection. The files stay in the scratch directory of the build, where a reader
//! that shares no code with this one checks them: `validation/read_vtu.py`.

use std::fs;
use std::path::PathBuf;
use undula::output::{CellKind, Collection, Field, FieldSnapshot, Precision, read_vtu, write_vtu};

/// An empty directory for the test `name`.
fn scratch(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// A quarter of the ring 1 < r < 2 in `n_r × n_phi` cells, with the fields x² − y² + x y, (−y, x, x y).
fn curved_mesh(degree: usize, n_r: usize, n_phi: usize) -> FieldSnapshot {
    let (row, column) = (degree * n_r + 1, degree * n_phi + 1);
    let mut mesh = FieldSnapshot { degree, ..FieldSnapshot::default() };
    for (i, j) in (0..column).flat_map(|j| (0..row).map(move |i| (i, j))) {
        let r = 1.0 + i as f64 / (row - 1) as f64;
        let phi = std::f64::consts::FRAC_PI_2 * j as f64 / (column - 1) as f64;
        mesh.points.push([r * phi.cos(), r * phi.sin(), 0.0]);
    }
    for (i, j) in (0..n_phi).flat_map(|j| (0..n_r).map(move |i| (degree * i, degree * j))) {
        let nodes = (0..=degree).flat_map(|b| (0..=degree).map(move |a| (i + a + row * (j + b)) as u32));
        mesh.cells.extend(nodes);
    }
    let scalar = |p: &[f64; 3]| p[0] * p[0] - p[1] * p[1] + p[0] * p[1];
    let vector = |p: &[f64; 3]| [-p[1], p[0], p[0] * p[1]];
    mesh.point_data = vec![
        Field::new("pressure", 1, mesh.points.iter().map(scalar).collect()),
        Field::new("velocity", 3, mesh.points.iter().flat_map(vector).collect()),
    ];
    mesh.cell_data = vec![Field::new("solid", 1, (0..n_r * n_phi).map(|c| (c % 2) as f64).collect())];
    mesh
}

#[test]
fn files_read_back_with_the_same_bits() {
    for degree in 1..=4 {
        let path = scratch("vtu-round").join("fields/a.vtu");
        let mut written = curved_mesh(degree, 40, 7);
        written.point_data.push(Field::new("a <strange> & \"name\"", 4, vec![0.1; 4 * written.points.len()]));
        write_vtu(&path, &written, 0.1 + 0.2, Precision::Double).unwrap();
        let (read, time) = read_vtu(&path).unwrap();
        assert_eq!(time, 0.1 + 0.2);
        assert_eq!(read, written);
    }
}

/// Two triangles with the long side in common.
fn two_triangles(degree: usize) -> FieldSnapshot {
    let n = degree + 1;
    let number = |i: usize, j: usize| (i + n * j) as u32;
    let inside = || (0..n).flat_map(|j| (0..n - j).map(move |i| (i, j)));
    let mut mesh = FieldSnapshot { kind: CellKind::Triangle, degree, ..FieldSnapshot::default() };
    mesh.points = (0..n * n).map(|p| [(p % n) as f64, (p / n) as f64, 0.0]).collect();
    mesh.cells.extend(inside().map(|(i, j)| number(i, j)));
    mesh.cells.extend(inside().map(|(i, j)| number(degree - i, degree - j)));
    mesh.cell_data = vec![Field::new("solid", 1, vec![0.0, 1.0])];
    mesh
}

#[test]
fn triangles_read_back_with_the_same_bits() {
    for degree in 1..=3 {
        let path = scratch(&format!("vtu-triangles-{degree}")).join("a.vtu");
        let written = two_triangles(degree);
        assert_eq!(written.n_cells(), 2);
        write_vtu(&path, &written, 0.5, Precision::Double).unwrap();
        assert_eq!(read_vtu(&path).unwrap(), (written, 0.5));
    }
}

/// `n` hexahedra of the image of the unit cube, with the fields x² − y z + x y, (−y, x z, z), grad of the latter.
fn hexahedra(degree: usize, n: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> FieldSnapshot {
    let nodes = n.map(|n| degree * n + 1);
    let mut mesh = FieldSnapshot { kind: CellKind::Hexahedron, degree, ..FieldSnapshot::default() };
    let of = |i: usize, n: [usize; 3]| [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])];
    for i in 0..nodes.iter().product() {
        let at = of(i, nodes);
        mesh.points.push(map([0, 1, 2].map(|d| at[d] as f64 / (nodes[d] - 1) as f64)));
    }
    let n_cells: usize = n.iter().product();
    for cell in 0..n_cells {
        let from = of(cell, n).map(|i| degree * i);
        mesh.cells.extend((0..(degree + 1).pow(3)).map(|i| {
            let at = of(i, [degree + 1; 3]);
            (from[0] + at[0] + nodes[0] * (from[1] + at[1] + nodes[1] * (from[2] + at[2]))) as u32
        }));
    }
    let scalar = |&[x, y, z]: &[f64; 3]| x * x - y * z + x * y;
    let vector = |&[x, y, z]: &[f64; 3]| [-y, x * z, z];
    let tensor = |&[x, _, z]: &[f64; 3]| [0.0, -1.0, 0.0, z, 0.0, x, 0.0, 0.0, 1.0];
    mesh.point_data = vec![
        Field::new("pressure", 1, mesh.points.iter().map(scalar).collect()),
        Field::new("velocity", 3, mesh.points.iter().flat_map(vector).collect()),
        Field::new("gradient", 9, mesh.points.iter().flat_map(tensor).collect()),
    ];
    mesh.cell_data = vec![Field::new("solid", 1, (0..n_cells).map(|c| (c % 2) as f64).collect())];
    mesh
}

/// A quarter of a hollow cylinder, 1 < r < 2, all of whose faces but two are curved; its volume is 0.7 · 3π/4.
fn shell([r, s, t]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = (std::f64::consts::FRAC_PI_2 * s).sin_cos();
    let [x, y] = [(1.0 + r) * cos, (1.0 + r) * sin];
    [x, y, 0.7 * t + 0.1 * x * y]
}

/// What `validation/read_vtu.py` and `trace_vtu.py` read in `.ci/run`: all types of hexahedra.
#[test]
fn hexahedra_read_back_with_the_same_bits() {
    let sheared = |[r, s, t]: [f64; 3]| [r + 0.3 * s, s + 0.2 * t, 0.5 * t - 0.1 * r];
    for degree in 1..=4 {
        for (name, mesh) in [
            ("curved", hexahedra(degree, [3, 6, 2], shell)),
            ("straight", hexahedra(degree, [2; 3], sheared)),
        ] {
            let straight = mesh.clone().linear();
            for (name, snapshot) in [(name.into(), mesh), (format!("{name}-pieces"), straight)] {
                let directory = scratch(&format!("vtu-hexahedra-{name}-{degree}"));
                write_vtu(directory.join("a.vtu"), &snapshot, 0.25, Precision::Double).unwrap();
                assert_eq!(read_vtu(directory.join("a.vtu")).unwrap(), (snapshot, 0.25));
                let mut collection = Collection::create(directory.join("fields.pvd")).unwrap();
                collection.add(0.25, "a.vtu").unwrap();
            }
        }
    }
}

/// The unit cube in 48 tetrahedra of degree 1 to 3, with a field of that degree; what `validation/read_vtu.py` reads.
fn tetrahedra(degree: usize) -> FieldSnapshot {
    let mesh = undula::mesh::generate::hexahedra([0.0; 3], [1.0; 3], [2; 3], 0).unwrap().in_tetrahedra();
    let nodes = undula::space::Nodes::new(&mesh, degree);
    let field = |&[x, y, z]: &[f64; 3]| (x + 2.0 * y - z).powi(degree as i32);
    let pressure = Field::new("pressure", 1, nodes.points.iter().map(field).collect());
    FieldSnapshot {
        kind: CellKind::Tetrahedron,
        degree,
        points: nodes.points,
        cells: nodes.cell_nodes,
        point_data: vec![pressure],
        cell_data: vec![Field::new("solid", 1, vec![0.0; mesh.n_cells()])],
    }
}

#[test]
fn tetrahedra_read_back_with_the_same_bits_and_their_pieces_fill_them() {
    for degree in 1..=3 {
        let mesh = tetrahedra(degree);
        let pieces = mesh.clone().linear();
        assert_eq!((mesh.n_cells(), pieces.n_cells()), (48, 48 * degree.pow(3)));
        for cell in pieces.cells.chunks_exact(4) {
            let at = |corner: usize| pieces.points[cell[corner] as usize];
            let [a, b, c] = [1, 2, 3].map(|i| [0, 1, 2].map(|d| at(i)[d] - at(0)[d]));
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let six = cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2];
            assert!((six * 8.0 * (degree as f64).powi(3) - 1.0).abs() < 1e-12, "{degree}: {six}");
        }
        for (name, snapshot) in [("curved", mesh), ("pieces", pieces)] {
            let directory = scratch(&format!("vtu-tetrahedra-{name}-{degree}"));
            write_vtu(directory.join("a.vtu"), &snapshot, 0.25, Precision::Double).unwrap();
            assert_eq!(read_vtu(directory.join("a.vtu")).unwrap(), (snapshot, 0.25));
            let mut collection = Collection::create(directory.join("fields.pvd")).unwrap();
            collection.add(0.25, "a.vtu").unwrap();
        }
    }
}

/// Six times the volume of a hexahedron of degree 1 with plane faces.
fn six_volumes(snapshot: &FieldSnapshot, cell: &[u32]) -> f64 {
    let at = |corner: usize| snapshot.points[cell[corner] as usize];
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    // Six tetrahedra around the diagonal.
    let paths = [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]];
    let [d, origin] = [minus(at(7), at(0)), at(0)];
    let of = |[i, j]: [usize; 2]| {
        let [a, b] = [minus(at(i), origin), minus(at(j), origin)];
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        cross[0] * d[0] + cross[1] * d[1] + cross[2] * d[2]
    };
    paths.into_iter().map(of).sum()
}

#[test]
fn straight_pieces_of_hexahedra_fill_every_cell_once() {
    let cuboid = |[r, s, t]: [f64; 3]| [2.0 * r, s, 0.5 * t + 0.1 * r];
    for degree in 1..=4_usize {
        let whole = hexahedra(degree, [2, 3, 1], cuboid);
        let pieces = whole.clone().linear();
        assert_eq!((pieces.degree, pieces.n_cells()), (1, 6 * degree.pow(3)));
        assert_eq!((&pieces.points, &pieces.point_data), (&whole.points, &whole.point_data));
        let sizes: Vec<f64> =
            pieces.cells.chunks_exact(8).map(|cell| six_volumes(&pieces, cell) / 6.0).collect();
        let right = 1.0 / sizes.len() as f64;
        assert!(sizes.iter().all(|size| (size - right).abs() < 1e-13), "degree {degree}: {sizes:?}");
        for (n, cell) in pieces.cells.chunks_exact(8).enumerate() {
            let parent = n / degree.pow(3);
            assert_eq!(pieces.in_cells("cell").unwrap().values[n], parent as f64);
            let nodes = &whole.cells[parent * whole.points_per_cell()..][..whole.points_per_cell()];
            assert!(cell.iter().all(|point| nodes.contains(point)));
        }
    }
}

#[test]
fn hexahedra_of_high_degree_need_a_new_version_of_the_format() {
    let path = scratch("vtu-version").join("a.vtu");
    // VTK calls a file of which the version is not said old, and old hexahedra have another order of nodes.
    let text = |degree: usize| {
        write_vtu(&path, &hexahedra(degree, [1; 3], shell), 0.0, Precision::Double).unwrap();
        String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned()
    };
    assert!(text(3).contains("\"UnstructuredGrid\" version=\"2.1\""));
    assert!(text(2).contains("\"UnstructuredGrid\" version=\"1.0\""));
}

#[test]
fn plane_vectors_get_a_third_component_and_single_precision_rounds() {
    let path = scratch("vtu-single").join("a.vtu");
    let mut snapshot = curved_mesh(2, 3, 2);
    let n = snapshot.points.len();
    snapshot.point_data = vec![Field::new("w", 2, (0..2 * n).map(|i| 1.0 / (1.0 + i as f64)).collect())];
    write_vtu(&path, &snapshot, 0.0, Precision::Single).unwrap();
    let (read, _) = read_vtu(&path).unwrap();
    assert_eq!(read.points, snapshot.points);
    assert_eq!(read.point_data[0].components, 3);
    for (read, x) in read.point_data[0].values.chunks(3).zip(snapshot.point_data[0].values.chunks(2)) {
        assert_eq!(read, [f64::from(x[0] as f32), f64::from(x[1] as f32), 0.0]);
    }
}

#[test]
fn an_empty_snapshot_is_a_file_too() {
    let path = scratch("vtu-empty").join("a.vtu");
    write_vtu(&path, &FieldSnapshot { degree: 1, ..Default::default() }, 1.0, Precision::Auto).unwrap();
    assert!(read_vtu(&path).unwrap().0.points.is_empty());
}

#[test]
fn damage_is_an_error_wherever_it_is() {
    let path = scratch("vtu-damage").join("a.vtu");
    write_vtu(&path, &curved_mesh(2, 8, 3), 1.0, Precision::Auto).unwrap();
    let good = fs::read(&path).unwrap();
    for cut in (0..good.len() - 40).step_by(97) {
        fs::write(&path, &good[..cut]).unwrap();
        assert!(read_vtu(&path).is_err(), "cut at {cut}");
    }
    for at in (0..good.len()).step_by(31) {
        let mut bad = good.clone();
        bad[at] ^= 0x55;
        fs::write(&path, bad).unwrap();
        // Any answer but a panic; the compressed blocks carry check sums of their own.
        let _ = read_vtu(&path);
    }
}

/// What `validation/read_vtu.py` reads: one cell type per collection, curved cells.
#[test]
fn collections_of_curved_cells() {
    for degree in [1, 2, 3] {
        let directory = scratch(&format!("vtu-degree-{degree}"));
        let mut collection = Collection::create(directory.join("fields.pvd")).unwrap();
        for (n, precision) in [Precision::Double, Precision::Single].into_iter().enumerate() {
            let name = format!("fields/fields_{n:06}.vtu");
            let time = 0.1 * n as f64;
            write_vtu(directory.join(&name), &curved_mesh(degree, 20, 12), time, precision).unwrap();
            collection.add(time, name).unwrap();
        }
        assert_eq!(Collection::read(directory.join("fields.pvd")).unwrap().entries().len(), 2);
    }
}

/// Twice the area of the polygon through the corners of a cell of degree 1.
fn twice_area(snapshot: &FieldSnapshot, cell: &[u32]) -> f64 {
    let round: &[usize] = if snapshot.kind == CellKind::Triangle { &[0, 1, 2] } else { &[0, 1, 3, 2] };
    let at = |i: usize| snapshot.points[cell[round[i % round.len()]] as usize];
    (0..round.len()).map(|i| at(i)[0] * at(i + 1)[1] - at(i + 1)[0] * at(i)[1]).sum()
}

#[test]
fn straight_pieces_keep_points_and_values_and_cover_every_cell_once() {
    for (whole, area) in (1..=4)
        .map(|degree| (curved_mesh(degree, 4, 3), None))
        .chain((1..=3).map(|degree| (two_triangles(degree), Some(degree as f64 * degree as f64))))
    {
        let (k, n) = (whole.degree, whole.n_cells());
        let pieces = whole.clone().linear();
        assert_eq!((&pieces.points, &pieces.point_data), (&whole.points, &whole.point_data));
        assert_eq!((pieces.degree, pieces.n_cells()), (1, n * k * k));
        let cells = || pieces.cells.chunks_exact(pieces.points_per_cell());
        assert!(cells().all(|cell| twice_area(&pieces, cell) > 0.0), "degree {k}");
        if let Some(area) = area {
            let sum: f64 = cells().map(|cell| 0.5 * twice_area(&pieces, cell)).sum();
            assert!((sum - area).abs() < 1e-12, "degree {k}: {sum}");
        }
        for (piece, cell) in cells().enumerate() {
            let parent = pieces.in_cells("cell").unwrap().values[piece] as usize;
            assert_eq!(parent, piece / (k * k));
            let nodes = &whole.cells[parent * whole.points_per_cell()..][..whole.points_per_cell()];
            assert!(cell.iter().all(|point| nodes.contains(point)));
            assert_eq!(
                pieces.in_cells("solid").unwrap().values[piece],
                whole.in_cells("solid").unwrap().values[parent]
            );
        }
        let path = scratch(&format!("vtu-linear-{:?}-{k}", whole.kind)).join("a.vtu");
        write_vtu(&path, &pieces, 0.5, Precision::Double).unwrap();
        assert_eq!(read_vtu(&path).unwrap(), (pieces, 0.5));
        assert!(!String::from_utf8_lossy(&fs::read(&path).unwrap()).contains("NumberOfComponents=\"1\""));
    }
}
