//! Files as Gmsh writes them, and broken ones.

use super::{parse, read, write};
use crate::mesh::generate::{cylinder, schaefer_turek, turek_hron};
use crate::mesh::{Mesh, MeshError};
use std::path::Path;

/// Two cells, the second numbered clockwise; node tags with gaps, a node without a cell, a point.
const V2: &str = r#"$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
1 7 "walls"
1 9 "interface"
2 1 "fluid"
2 4 "the solid"
$EndPhysicalNames
$Nodes
8
10 0 0 0
20 1 0 0
30 2 0 0
40 0 1 0
50 1 1 0
60 2 1 0
70 5 5 0
80 1 2 0
$EndNodes
$Elements
10
1 15 2 0 1 10
2 1 2 7 1 10 20
3 1 2 7 2 20 30
4 1 2 7 3 30 60
5 1 2 7 4 50 60
6 1 2 7 5 40 50
7 1 2 7 6 40 10
8 1 2 9 7 50 20
9 3 2 4 2 20 50 60 30
10 3 2 1 1 10 20 50 40
$EndElements
"#;

/// One cell with nine nodes on the upper half of a ring.
const V4: &str = r#"$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
1 2 "outside"
2 1 "fluid"
$EndPhysicalNames
$Entities
1 1 1 0
1 0 0 0 0
1 -1 0 0 1 1 0 1 -2 2 1 -2
1 -1 0 0 1 1 0 1 1 1 1
$EndEntities
$Comments
anything
$EndComments
$Nodes
2 9 1 9
1 1 0 4
1
2
3
4
2 0 0
-2 0 0
-1 0 0
1 0 0
2 1 0 5
5
6
7
8
9
0 2 0
-1.5 0 0
0 1 0
1.5 0 0
0 1.5 0
$EndNodes
$Elements
3 6 1 6
0 1 15 1
1 1
1 1 8 4
2 1 2 5
3 2 3 6
4 3 4 7
5 4 1 8
2 1 10 1
6 1 2 3 4 5 6 7 8 9
$EndElements
"#;

fn parsed(text: &str) -> Result<Mesh<2>, MeshError> {
    parse(text, Path::new("own.msh"))
}

/// The message for `text` with `from` replaced.
fn message(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    parsed(&text.replacen(from, to, 1)).expect_err(to).to_string()
}

#[test]
fn version_2_is_read() {
    let mesh = parsed(V2).unwrap();
    mesh.check_matching("fluid", "the solid", &[]).unwrap();
    assert_eq!((mesh.degree, mesh.n_cells(), mesh.nodes.len(), mesh.facets.len()), (1, 2, 6, 7));
    assert_eq!(mesh.regions, ["fluid", "the solid"]);
    assert_eq!(mesh.boundaries, ["walls", "interface"]);
    let interface = mesh.facets.iter().find(|f| f.boundary == 1).unwrap();
    assert_eq!(mesh.cell_region[interface.cell as usize], 0, "seen from the region named first");
    assert_eq!(mesh.quality().total_volume(), 2.0);
}

#[test]
fn version_4_is_read() {
    let mesh = parsed(V4).unwrap();
    mesh.check().unwrap();
    assert_eq!((mesh.degree, mesh.n_cells(), mesh.nodes.len(), mesh.facets.len()), (2, 1, 9, 4));
    assert_eq!((mesh.regions, mesh.boundaries), (vec!["fluid".to_string()], vec!["outside".to_string()]));
}

#[test]
fn meshes_survive_writing_and_reading() {
    for mesh in [turek_hron(1, 2), schaefer_turek(0), parsed(V2).unwrap()] {
        let again = parsed(&write(&mesh)).unwrap();
        let sorted = |mesh: &Mesh<2>| {
            let mut facets = mesh.facets.clone();
            facets.sort_by_key(|f| f.side());
            facets
        };
        assert_eq!(sorted(&again), sorted(&mesh));
        assert_eq!((again.nodes, again.cell_nodes), (mesh.nodes, mesh.cell_nodes));
        assert_eq!((again.regions, again.cell_region), (mesh.regions, mesh.cell_region));
        assert_eq!(again.boundaries, mesh.boundaries);
    }
    parsed(&write(&turek_hron(0, 1))).unwrap().check_matching("fluid", "solid", &[cylinder()]).unwrap();
}

#[test]
fn broken_files_are_refused_with_line_and_advice() {
    for (from, to, expected) in [
        ("2.2 0 8", "2.2 1 8", "the binary file is damaged, perhaps by a transfer as text"),
        ("2.2 0 8", "4.1 1 2", "own.msh:2: numbers of 2 bytes, 4 or 8 are known"),
        ("2.2 0 8", "4.0 0 8", "own.msh:2: version 4 of the format, 2.2 or 4.1 is needed"),
        ("$MeshFormat", "$Format", "own.msh:1: not a Gmsh mesh"),
        ("20 1 0 0", "20 1 zero 0", "own.msh:14: expected y, found `zero`"),
        ("20 1 0 0", "20 1", "own.msh:14: y is missing"),
        ("20 1 0 0", "20 1 inf 0", "own.msh:14: y is inf, not a finite number"),
        ("20 1 0 0", "20 1 0 0.5", "own.msh:14: node 20 at z = 0.5, others at z = 0"),
        ("20 1 0 0", "10 1 0 0", "own.msh:14: node 10 is in line 13 already, at another place"),
        ("20 1 0 0", "21 1 0 0", "node 20 is not in section `$Nodes`"),
        ("$Nodes\n8", "$Nodes\n9", "own.msh:21: expected the tag of a node, found `$EndNodes`"),
        ("$EndElements\n", "", "own.msh:33: the file ends where `$EndElements` should follow"),
        ("$Elements\n10", "$Elements\n9", "own.msh:33: expected `$EndElements`, found `10 3 2 1 1"),
        (
            "10 3 2 1 1 10 20 50 40",
            "10 2 2 1 1 10 20 50",
            "own.msh:33: the mesh has 1 triangle and 1 quadrilateral; all must be alike: `Mesh.SubdivisionAlgorithm = 1;`",
        ),
        ("10 3 2 1 1 10 20 50 40", "10 16 2 1 1 10 20 50 40 1 2 3 4", "Mesh.SecondOrderIncomplete = 0"),
        ("10 3 2 1 1", "10 3 2 0 1", "own.msh:33: a cell in no physical group: give its surface a named one"),
        ("10 3 2 1 1", "10 3 2 3 1", "own.msh:33: a cell in physical group 3, which has no name"),
        ("2 1 2 7 1 10 20", "2 1 2 8 1 10 20", "Physical Curve(\"walls\")"),
        ("2 1 2 7 1 10 20", "2 1 2 7 1 10 50", "own.msh:25: a line that is no edge of a cell"),
        (
            "3 1 2 7 2 20 30",
            "3 1 2 9 2 10 20",
            "own.msh:26: a line in physical groups `walls` and `interface` (it is in line 25 already)",
        ),
        ("9 3 2 4 2", "9 3 2 1 2", "own.msh:31: a line inside of region `fluid`"),
        ("1 7 \"walls\"", "1 7 walls", "own.msh:6: expected a name in double quotes"),
        ("9 3 2 4 2 20 50 60 30", "9 10 2 4 2 20 50 60 30 10 10 10 10 10", "all must be alike"),
    ] {
        let found = message(V2, from, to);
        assert!(found.contains(expected), "{to}: {found}");
    }
    assert!(
        message(V4, "1 1 1 1\n$End", "2 1 3 1 1\n$End")
            .contains("surface 1 is in physical groups `fluid` and 3; it can be in one only")
    );
    assert!(message(V4, "2 1 10 1", "2 1 200 1").contains("elements of type 200"));
    assert!(parsed("").is_err() && parsed("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n").is_err());
    assert!(matches!(read(Path::new("no such file.msh")), Err(MeshError::Unreadable { .. })));
}

/// No prefix of a file and no file with one line left out makes the reader panic.
#[test]
fn mutilated_files_do_not_panic() {
    for text in [V2, V4] {
        for end in 0..text.len() {
            let _ = parsed(&text[..end]);
        }
        let lines: Vec<&str> = text.lines().collect();
        for out in 0..lines.len() {
            let _ = parsed(&[&lines[..out], &lines[out + 1..]].concat().join("\n"));
        }
        for word in ["-1", "0", "99999999999", "nan", "$", "\""] {
            for at in 0..lines.len() {
                let mut lines = lines.clone();
                lines[at] = word;
                let _ = parsed(&lines.join("\n"));
            }
        }
    }
}

/// Binary files of either version, cut off or with changed bytes, are read or refused.
#[test]
fn mutilated_binary_files_do_not_panic() {
    let inputs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../undula-cli/tests/cli/faults/inputs/newcomer");
    for name in ["fmt_v2.2_bin_o2.msh", "fmt_v4.1_bin_o1.msh"] {
        let bytes = std::fs::read(inputs.join(name)).unwrap();
        let mesh = parse(&bytes, Path::new(name)).unwrap();
        mesh.check_orientation().unwrap();
        for end in (0..bytes.len()).step_by(bytes.len() / 60).chain(bytes.len() - 40..bytes.len() - 14) {
            assert!(parse(&bytes[..end], Path::new(name)).is_err(), "{name}: {end} bytes");
        }
        for at in (0..bytes.len()).step_by(bytes.len() / 150) {
            for value in [0, 1, 0x7f, 0xff, b'\n', b'$'] {
                let mut bytes = bytes.clone();
                bytes[at] = value;
                let _ = parse(&bytes, Path::new(name));
            }
        }
    }
}

/// What other writers and transfers do to a file changes nothing.
#[test]
fn harmless_changes_of_a_file_are_read() {
    for (text, ends) in [(V2, "$EndElements\n"), (V4, "$EndElements\n")] {
        let plain = parsed(text).unwrap();
        let moved = {
            let (names, rest) =
                (text.find("$PhysicalNames").unwrap(), text.find("$EndPhysicalNames\n").unwrap() + 18);
            format!("{}{}{}", &text[..names], &text[rest..], &text[names..rest])
        };
        for other in [
            text.replace('\n', "\r\n"),
            format!("\u{feff}{text}"),
            format!("$Comments\n$Nodes\n1 2 3\n$EndComments\n{text}"),
            text.replace(ends, "$EndElements\n$Periodic\n0\n$EndPeriodic\nthe end\n$ 3\n"),
            text.replace(ends, "$EndElements\nno line more"),
            format!("{text}{text}"),
            moved,
        ] {
            let mesh = parsed(&other).unwrap_or_else(|e| panic!("{e}:\n{other}"));
            assert!(mesh.nodes == plain.nodes && mesh.cell_nodes == plain.cell_nodes, "{other}");
            assert!(mesh.regions == plain.regions && mesh.facets == plain.facets, "{other}");
        }
    }
    let latin: Vec<u8> =
        V2.replace("walls", "W@nde").bytes().map(|b| if b == b'@' { 0xe4 } else { b }).collect();
    assert_eq!(parse(latin, Path::new("own.msh")).unwrap().boundaries[0], "Wände");
}

/// Triangles of both degrees survive the way to a file and back; those numbered clockwise are turned.
#[test]
fn triangles_are_written_and_read() {
    let curved = turek_hron(0, 0).triangulated();
    let same = parse(write(&curved), Path::new("own.msh")).unwrap();
    assert_eq!((same.shape, same.degree), (curved.shape, 2));
    assert!(same.nodes == curved.nodes && same.cell_nodes == curved.cell_nodes);
    assert_eq!(same.facets.len(), curved.facets.len());
    same.check_matching("fluid", "solid", &[cylinder()]).unwrap();
    let straight = V2
        .replace("9 3 2 4 2 20 50 60 30\n10 3 2 1 1 10 20 50 40", "9 2 2 1 1 10 50 20\n10 2 2 1 1 10 50 40");
    let straight = straight
        .replace("3 1 2 7 2 20 30\n4 1 2 7 3 30 60\n5 1 2 7 4 50 60\n", "")
        .replace("$Elements\n10", "$Elements\n7");
    let mesh = parse(&straight, Path::new("own.msh")).unwrap();
    assert_eq!((mesh.n_cells(), mesh.degree), (2, 1));
    assert!((mesh.quality().total_volume() - 1.0).abs() < 1e-15);
    assert!(mesh.quality().inverted.is_empty());
    assert_eq!(mesh.facets.len(), 4);
}
