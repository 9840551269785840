//! Meshes from VTU files and from meshio's Gmsh files: what VTK and meshio wrote, every coding, and what is refused.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, write::ZlibEncoder};
use std::io::Write;
use std::path::{Path, PathBuf};
use undula::case::Case;
use undula::mesh::gmsh::{AnyMesh, parse_any, read_any, shape};
use undula::mesh::{Mesh, MeshError};
use undula::simulation::Simulation;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(name)
}

fn in_space(found: Result<AnyMesh, MeshError>) -> Mesh<3> {
    match found.unwrap_or_else(|e| panic!("{e}")) {
        AnyMesh::Space(mesh) => mesh,
        AnyMesh::Plane(_) => panic!("a plane mesh"),
    }
}

/// Facets with their names.
type Facets = Vec<(String, Vec<[i64; 3]>)>;

/// The facets of each name by the places of their nodes, and the volume of each region by name.
fn names_of(mesh: &Mesh<3>) -> (Facets, Vec<(String, f64)>) {
    let mut facets: Vec<_> = mesh
        .facets
        .iter()
        .map(|f| {
            let nodes = mesh.facet_nodes(f.cell as usize, f.local as usize);
            let place = |n: u32| mesh.nodes[n as usize].map(|x| (x * 1e9).round() as i64);
            let mut places: Vec<[i64; 3]> = nodes.into_iter().map(place).collect();
            places.sort_unstable();
            (mesh.boundaries[f.boundary as usize].clone(), places)
        })
        .collect();
    facets.sort_unstable();
    let volume = mesh.quality().volume;
    let of = |r: usize| {
        (0..mesh.n_cells()).filter(|&c| mesh.cell_region[c] as usize == r).map(|c| volume[c]).sum()
    };
    let mut regions: Vec<(String, f64)> =
        (0..mesh.regions.len()).map(|r| (mesh.regions[r].clone(), of(r))).collect();
    regions.sort_by(|a, b| a.0.cmp(&b.0));
    (facets, regions)
}

/// The ring of Gmsh after meshio and VTK: the same cells, names and curved nodes.
#[test]
fn files_of_meshio_and_vtk_are_the_mesh_of_gmsh() {
    for kind in ["ring_2", "ring_tetrahedra_2"] {
        let first = in_space(read_any(&file(&format!("{kind}_v4.1.msh"))));
        let (facets, regions) = names_of(&first);
        for name in ["meshio.vtu", "words.vtu", "marks.vtu", "meshio22.msh", "meshio41.msh"] {
            let path = file(&format!("{kind}_{name}"));
            assert_eq!(shape(&path).unwrap(), first.shape);
            let mesh = in_space(read_any(&path));
            mesh.check_matching("fluid", "solid", &[]).unwrap_or_else(|e| panic!("{name}: {e}"));
            let (same_facets, same_regions) = names_of(&mesh);
            assert!(same_facets == facets, "{name}: {:?}", mesh.boundaries);
            for (a, b) in regions.iter().zip(&same_regions) {
                assert!(a.0 == b.0 && (a.1 / b.1 - 1.0).abs() < 1e-13, "{name}: {a:?} {b:?}");
            }
        }
        // Without names groups have numbers: those of Gmsh, whose regions come last.
        let mesh = in_space(read_any(&file(&format!("{kind}_numbers22.msh"))));
        mesh.check().unwrap();
        assert_eq!(mesh.regions, ["7", "8"]);
        assert_eq!(mesh.boundaries, ["1", "2", "3", "4", "5", "6", "9"]);
        let (numbered, _) = names_of(&mesh);
        assert!(
            numbered.iter().map(|f| &f.1).collect::<std::collections::BTreeSet<_>>().len() == facets.len()
        );
    }
}

/// How a file is coded.
#[derive(Copy, Clone, Debug)]
struct Coding {
    format: &'static str,
    big: bool,
    wide: bool,
    zlib: bool,
}

/// A VTU file of arrays of `Float64` and `Int32`.
struct Vtu {
    coding: Coding,
    appended: Vec<u8>,
}

impl Vtu {
    fn number(&self, n: usize) -> Vec<u8> {
        let mut bytes = if self.coding.wide {
            (n as u64).to_le_bytes().to_vec()
        } else {
            (n as u32).to_le_bytes().to_vec()
        };
        if self.coding.big {
            bytes.reverse();
        }
        bytes
    }

    fn array(
        &mut self,
        kind: &str,
        name: &str,
        components: usize,
        words: &[String],
        raw: &[Vec<u8>],
    ) -> String {
        let head = format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" ");
        if self.coding.format == "ascii" {
            return format!("{head}format=\"ascii\">\n{}\n</DataArray>\n", words.join(" "));
        }
        let mut data = vec![];
        for word in raw {
            data.extend(if self.coding.big { word.iter().rev().copied().collect() } else { word.clone() });
        }
        let parts: Vec<Vec<u8>> = if self.coding.zlib {
            let blocks: Vec<Vec<u8>> = data
                .chunks(100)
                .map(|block| {
                    let mut encoder = ZlibEncoder::new(vec![], Compression::default());
                    encoder.write_all(block).unwrap();
                    encoder.finish().unwrap()
                })
                .collect();
            let mut header = [blocks.len(), 100, data.len() % 100].map(|n| self.number(n)).concat();
            blocks.iter().for_each(|block| header.extend(self.number(block.len())));
            vec![header, blocks.concat()]
        } else {
            vec![[self.number(data.len()), data].concat()]
        };
        let coded: Vec<u8> = match self.coding.format {
            "raw" => parts.concat(),
            _ => parts.iter().map(|part| STANDARD.encode(part)).collect::<String>().into_bytes(),
        };
        if self.coding.format == "binary" {
            return format!(
                "{head}format=\"binary\">\n  {}\n</DataArray>\n",
                String::from_utf8(coded).unwrap()
            );
        }
        let offset = self.appended.len();
        self.appended.extend(coded);
        format!("{head}format=\"appended\" offset=\"{offset}\"/>\n")
    }

    fn whole(&mut self, name: &str, x: &[i32]) -> String {
        let words: Vec<String> = x.iter().map(i32::to_string).collect();
        let raw: Vec<Vec<u8>> = x.iter().map(|x| x.to_le_bytes().to_vec()).collect();
        self.array("Int32", name, 1, &words, &raw)
    }

    fn real(&mut self, name: &str, x: &[f64]) -> String {
        let words: Vec<String> = x.iter().map(f64::to_string).collect();
        let raw: Vec<Vec<u8>> = x.iter().map(|x| x.to_le_bytes().to_vec()).collect();
        self.array("Float64", name, 3, &words, &raw)
    }

    /// Cells `(type, nodes)` at `points` with arrays of whole numbers.
    fn file(
        coding: Coding,
        points: &[[f64; 3]],
        cells: &[(i32, Vec<i32>)],
        data: &[(&str, Vec<i32>)],
    ) -> Vec<u8> {
        let mut vtu = Vtu { coding, appended: vec![] };
        let all: Vec<i32> = cells.iter().flat_map(|(_, nodes)| nodes.clone()).collect();
        let ends: Vec<i32> = cells
            .iter()
            .scan(0, |end, (_, nodes)| {
                *end += nodes.len() as i32;
                Some(*end)
            })
            .collect();
        let types: Vec<i32> = cells.iter().map(|(kind, _)| *kind).collect();
        let points_array = vtu.real("Points", points.as_flattened());
        let arrays = [("connectivity", all), ("offsets", ends), ("types", types)];
        let cell_arrays: String = arrays.iter().map(|(name, x)| vtu.whole(name, x)).collect();
        let data: String = data.iter().map(|(name, x)| vtu.whole(name, x)).collect();
        let (order, header) = (["LittleEndian", "BigEndian"][usize::from(coding.big)], ["UInt32", "UInt64"]);
        let zlib = if coding.zlib { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
        let mut text = format!(
            "<?xml version=\"1.0\"?>\n<!-- a > comment -->\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
             byte_order=\"{order}\" header_type=\"{}\"{zlib}>\n<UnstructuredGrid><Piece NumberOfPoints=\"{}\" \
             NumberOfCells=\"{}\">\n<PointData></PointData><CellData>{data}</CellData><Points>{points_array}</Points>\
             <Cells>{cell_arrays}</Cells></Piece></UnstructuredGrid>",
            header[usize::from(coding.wide)],
            points.len(),
            cells.len()
        )
        .into_bytes();
        if !vtu.appended.is_empty() {
            let encoding = if coding.format == "raw" { "raw" } else { "base64" };
            text.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").bytes());
            text.extend(vtu.appended);
            text.extend(b"\n</AppendedData>");
        }
        text.extend(b"</VTKFile>\n");
        text
    }
}

/// Cells of VTK: type and points.
type Cells = Vec<(i32, Vec<i32>)>;
type Change = dyn Fn(&mut Vec<[f64; 3]>, &mut Cells, &mut Vec<i32>);

/// Two squares with their sides.
fn squares() -> (Vec<[f64; 3]>, Cells, Vec<i32>) {
    let points = (0..6).map(|i| [f64::from(i % 3), f64::from(i / 3), 0.25]).collect();
    let mut cells = vec![(9, vec![0, 1, 4, 3]), (9, vec![1, 2, 5, 4])];
    let sides = [[0, 1], [1, 2], [2, 5], [5, 4], [4, 3], [3, 0]];
    cells.extend(sides.map(|side| (3, side.to_vec())));
    cells.push((1, vec![0]));
    (points, cells, vec![1, 2, 1, 1, 3, 1, 1, 2, 0])
}

const TEXT: Coding = Coding { format: "ascii", big: false, wide: false, zlib: false };

#[test]
fn every_coding_gives_the_same_mesh() {
    let (points, cells, region) = squares();
    let mut codings = vec![TEXT];
    for format in ["binary", "appended", "raw"] {
        for i in 0..8 {
            codings.push(Coding { format, big: i & 1 == 1, wide: i & 2 == 2, zlib: i & 4 == 4 });
        }
    }
    for coding in codings {
        let bytes = Vtu::file(coding, &points, &cells, &[("region", region.clone())]);
        let found = parse_any(&bytes, Path::new("own.vtu")).unwrap_or_else(|e| panic!("{coding:?}: {e}"));
        let AnyMesh::Plane(mesh) = found else { panic!("{coding:?}") };
        mesh.check().unwrap();
        assert_eq!((mesh.regions.join(" "), mesh.boundaries.join(" ")), ("1 2".into(), "1 3 2".into()));
        assert_eq!((mesh.n_cells(), mesh.facets.len()), (2, 6));
        // No part of a file makes the reader panic, and no change of a byte.
        for at in (0..bytes.len()).step_by(17) {
            let _ = parse_any(&bytes[..at], Path::new("own.vtu"));
            for value in [0, b'<', b'9', 0xff] {
                let mut bytes = bytes.clone();
                bytes[at] = value;
                let _ = parse_any(&bytes, Path::new("own.vtu"));
            }
        }
    }
}

/// Names of groups: arrays of 0 and 1, numbers that have the name of others, and the sets of meshio.
#[test]
fn groups_get_their_names() {
    let (points, cells, region) = squares();
    let named = |data: &[(&str, Vec<i32>)]| {
        let bytes = Vtu::file(TEXT, &points, &cells, data);
        match parse_any(bytes, Path::new("own.vtu")) {
            Ok(AnyMesh::Plane(mesh)) => Ok((mesh.regions, mesh.boundaries)),
            Ok(AnyMesh::Space(_)) => panic!("of space"),
            Err(e) => Err(e.to_string()),
        }
    };
    let marks = [
        ("water", vec![1, 0, 0, 0, 0, 0, 0, 0, 0]),
        ("beam", vec![0, 1, 0, 0, 0, 0, 0, 0, 0]),
        ("walls", vec![0, 0, 1, 1, 0, 1, 1, 0, 0]),
        ("outflow", vec![0, 0, 0, 0, 1, 0, 0, 0, 0]),
        ("inflow", vec![0, 0, 0, 0, 0, 0, 0, 1, 0]),
        ("vtkGhostType", vec![0; 9]),
    ];
    let (mut regions, mut boundaries) = named(&marks).unwrap();
    regions.sort_unstable();
    boundaries.sort_unstable();
    assert_eq!(
        (regions.join(" "), boundaries.join(" ")),
        ("beam water".into(), "inflow outflow walls".into())
    );
    // Numbers beside names: the side without a mark has the name of the others with its number.
    let mut some = marks.clone();
    some[2].1[2] = 0;
    let numbers = [&some[..], &[("gmsh:physical", region.clone())]].concat();
    assert_eq!(named(&numbers).unwrap().1.len(), 3);
    let sets = [("water-beam-walls-outflow-inflow", vec![0, 1, 2, 2, 3, 2, 2, 4, -1])];
    let (regions, boundaries) = named(&sets).unwrap();
    assert_eq!(
        (regions.join(" "), boundaries.join(" ")),
        ("water beam".into(), "walls outflow inflow".into())
    );
    // What is wrong with groups.
    let message = named(&[
        ("region", vec![1; 9]),
        ("wet", vec![1, 1, 0, 0, 0, 0, 0, 0, 0]),
        ("soft", vec![0, 1, 0, 0, 0, 0, 0, 0, 0]),
    ])
    .unwrap_err();
    assert_eq!(
        message,
        "own.vtu: cell 1: it is in the groups `wet` and `soft`; it can be in one only (at 1.5, 0.5, 0.25)"
    );
    let message = named(&[]).unwrap_err();
    assert!(message.starts_with("own.vtu: cell 0: a cell in no group: give it a number"), "{message}");
    assert!(message.ends_with("(at 0.5, 0.5, 0.25)"), "{message}");
}

/// What is wrong with cells is told with their number and place.
#[test]
fn files_that_are_no_mesh_are_refused_with_the_place() {
    let (points, cells, region) = squares();
    let with = |change: &Change| {
        let (mut points, mut cells, mut region) = (points.clone(), cells.clone(), region.clone());
        change(&mut points, &mut cells, &mut region);
        let bytes = Vtu::file(TEXT, &points, &cells, &[("region", region)]);
        parse_any(bytes, Path::new("own.vtu")).map(drop).unwrap_err().to_string()
    };
    for (message, expected) in [
        (
            with(&|_, cells, _| cells[1] = (13, vec![0; 6])),
            "own.vtu: cell 1: type 13: wedges are not supported",
        ),
        (with(&|_, cells, _| cells[0] = (23, vec![0; 8])), "own.vtu: cell 0: quadrilaterals with 8 nodes"),
        (with(&|_, cells, _| cells[0].1[2] = 6), "own.vtu: cell 0: it has point 6, but there are 6 points"),
        (with(&|_, cells, _| cells[0].1.truncate(3)), "own.vtu: cell 0: a cell of type 9 has 4 points"),
        (with(&|points, _, _| points[4][1] = f64::NAN), "own.vtu: point 4: it lies at (1, NaN, 0.25)"),
        (
            with(&|_, cells, _| cells[2].1[1] = 4),
            "own.vtu: cell 2: a line that is no edge of a cell (at 0.5, 0.5, 0.25)",
        ),
        (
            with(&|_, cells, region| {
                cells[2].1 = vec![1, 4];
                region[1] = 1;
            }),
            "own.vtu: cell 2: a line inside of region `1`; boundaries and interfaces only have names (at 1, 0.5, 0.25)",
        ),
        (with(&|points, _, _| points[4][2] = 1.0), "own.vtu: point 4: node 4 at z = 1"),
        (
            with(&|_, cells, region| {
                cells[1] = (5, vec![1, 2, 5]);
                cells.push((5, vec![1, 5, 4]));
                region.push(2);
            }),
            "own.vtu: cell 1: the mesh has 2 triangles and 1 quadrilateral; all must be alike",
        ),
    ] {
        assert!(message.starts_with(expected), "{message}\n{expected}");
    }
    for (text, expected) in [
        (
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\"></VTKFile>",
            "own.vtu: byte 0: no VTU file: expected",
        ),
        (
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid/></VTKFile>",
            "own.vtu: byte 0: the file has no points",
        ),
        (
            "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkLZ4DataCompressor\">",
            "own.vtu: byte 0: data compressed by `vtkLZ4DataCompressor`: write the file with zlib",
        ),
        ("<VTKFile type=", "own.vtu: byte 0: the XML is broken"),
        ("<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>", "own.vtu: byte 51: the file ends before"),
    ] {
        let message = parse_any(text, Path::new("own.vtu")).map(drop).unwrap_err().to_string();
        assert!(message.starts_with(expected), "{message}");
    }
}

/// Cells that an array lacks are not left out in silence, nor is the end of a file.
#[test]
fn a_part_of_a_mesh_is_refused() {
    let (points, cells, region) = squares();
    let bytes = Vtu::file(TEXT, &points, &cells, &[("region", region)]);
    let whole = String::from_utf8(bytes).unwrap();
    let refused = |text: &str| parse_any(text, Path::new("own.vtu")).map(drop).unwrap_err().to_string();
    for (from, to) in [("3 3 3 3 3 3 1", "3 3 3 3 3 3"), (" 18 20 21", " 18 20"), (" 18 20 21", " 18 20 22")]
    {
        assert_eq!(whole.matches(from).count(), 1, "{from}: {whole}");
        let message = refused(&whole.replace(from, to));
        assert!(message.contains("expected as many of each"), "{message}");
    }
    for end in (0..whole.len() - "</VTKFile>\n".len()).step_by(7) {
        refused(&whole[..end]);
    }
}

/// A case names a VTU file like one of Gmsh; its tetrahedra choose the elements.
#[test]
fn a_case_takes_a_vtu_file() {
    let mut text = String::from(
        "[mesh]\nfile = \"ring_tetrahedra_2_words.vtu\"\nscale = 2\n[fluid]\ndensity = 1\nkinematic-viscosity = 1\n\
         [solid]\ndensity = 1\nmu = 1\nlambda = 1\n",
    );
    text += "[boundary.inner]\ncondition = \"do-nothing\"\n";
    for name in ["front", "back", "left", "bottom", "outside"] {
        text += &format!("[boundary.{name}]\ncondition = \"no-slip\"\n");
    }
    let case = Case::from_toml(&text, &file("own.toml").to_string_lossy(), &[]).unwrap();
    assert_eq!(case.space.velocity.name(), "P2");
    let simulation = Simulation::in_space(case, 1).unwrap();
    let largest = simulation.fields().coordinates().iter().map(|x| x[0]).fold(0.0, f64::max);
    assert!((largest - 2.4).abs() < 1e-12, "{largest}");
}
