//! Meshes as Gmsh writes them.

use super::{Place, close, input, last, place, undula};
use std::fs;

/// Drag and displacement on the mesh `base22.msh`, which all its variants must give.
const RIGHT: [f64; 2] = [3.410295, 0.1098747];

/// Runs `case.toml` with the mesh file and compares the functionals.
#[track_caller]
fn gives_the_right_values(here: &Place, mesh: &str) {
    let directory = format!("out-{mesh}");
    let run = format!(
        "run case.toml --threads 1 -q -o {directory} --set motion.offset=0.01 --set mesh.file={mesh}"
    );
    undula(here, &run, &[]).expect(0, &[]);
    for (name, right) in ["drag", "ux"].into_iter().zip(RIGHT) {
        close(last(here, &directory, name), right, 2e-6);
    }
}

#[test]
fn sections_in_other_places_and_parameters_of_nodes_are_read() {
    let here = place("sections", &["formats/case.toml", "formats/base22.msh", "formats/param22.msh"]);
    let text = here.read("base22.msh");
    for (name, file) in [("comments.msh", "formats/comfirst.msh"), ("trail.msh", "formats/trail.msh")] {
        fs::copy(input(file), here.file(name)).unwrap();
    }
    here.write("crlf.msh", &text.replace('\n', "\r\n"));
    let (begin, end) = (text.find("$PhysicalNames").unwrap(), text.find("$Nodes").unwrap());
    here.write("last.msh", &format!("{}{}{}", &text[..begin], &text[end..], &text[begin..end]));
    let (nodes, elements) = (text.find("$Nodes").unwrap(), text.find("$Elements").unwrap());
    let swapped = [&text[..nodes], &text[elements..], &text[nodes..elements]].concat();
    here.write("swapped.msh", &format!("{swapped}$Periodic\n0\n$EndPeriodic\n$Unknown\n1 2\n$EndUnknown\n"));
    for mesh in
        ["base22.msh", "param22.msh", "comments.msh", "trail.msh", "crlf.msh", "last.msh", "swapped.msh"]
    {
        gives_the_right_values(&here, mesh);
    }
}

#[test]
fn binary_files_of_either_order_of_bytes_are_read() {
    let here = place("binary", &["formats/case.toml"]);
    let base = Base::read();
    for (name, file) in [
        ("2.msh", base.version_2(Out::binary(false), false)),
        ("2-big-parametric.msh", base.version_2(Out::binary(true), true)),
        ("4-parametric.msh", base.version_4(Out::binary(false), true, false)),
        ("4-big.msh", base.version_4(Out::binary(true), false, false)),
    ] {
        fs::write(here.file(name), file).unwrap();
        gives_the_right_values(&here, name);
    }
}

/// Parts are in the groups of what was divided, whether the file repeats them or not.
#[test]
fn partitions_are_read() {
    let here = place("partitions", &["formats/case.toml"]);
    let base = Base::read();
    for (name, file) in [
        ("text.msh", base.version_4(Out::text(), true, true)),
        ("binary.msh", base.version_4(Out::binary(false), false, true)),
    ] {
        fs::write(here.file(name), file).unwrap();
        gives_the_right_values(&here, name);
    }
    // In version 2.2 partitions are further tags, negative ones of ghost cells.
    let tags = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        if words.len() > 6 && words[2] == "2" {
            format!("{} {} 5 {} 2 1 -2 {}", words[0], words[1], words[3..5].join(" "), words[5..].join(" "))
        } else {
            line.to_string()
        }
    };
    let text = fs::read_to_string(input("formats/base22.msh")).unwrap();
    here.write("tags.msh", &text.lines().map(tags).collect::<Vec<_>>().join("\n"));
    gives_the_right_values(&here, "tags.msh");
}

/// The binary files of Gmsh itself: the text of the same mesh is not here, their sizes are known.
#[test]
fn binary_files_of_gmsh_are_checked() {
    let files = ["newcomer/flap.toml", "newcomer/fmt_v2.2_bin_o2.msh", "newcomer/fmt_v4.1_bin_o1.msh"];
    let here = place("gmsh-binary", &files);
    for file in ["fmt_v2.2_bin_o2.msh", "fmt_v4.1_bin_o1.msh"] {
        undula(&here, "check flap.toml", &[&format!("mesh.file={file}")])
            .expect(0, &["space     P2/P1", file]);
    }
}

#[test]
fn names_with_spaces_and_dots_are_named_by_quoted_keys() {
    let here = place("names", &["formats/names.toml", "formats/names22.msh"]);
    undula(&here, "run names.toml --threads 1 -q -o out", &[]).expect(0, &[]);
    undula(&here, "check out/case.toml", &[]).expect(0, &["P2/P1", "Einströmung"]);
    let quoted = [
        "boundary.\"out let\"=none",
        "boundary.'out let'.condition=no-slip",
        "fluid.region=\"Fluid domain\"",
    ];
    undula(&here, "check names.toml --toml", &quoted)
        .expect(0, &["[boundary.\"out let\"]\ncondition = \"no-slip\"", "region = \"solid.flap\""]);
    undula(&here, "check names.toml", &["boundary.\"out let\"=none"])
        .expect(2, &["add [boundary.\"out let\"] with condition"]);
    undula(&here, "check names.toml", &["boundary.\"walls/rigid\".condition=clamped"])
        .expect(2, &["--set boundary.\"walls/rigid\".condition=clamped: `clamped` is for a solid"]);
    undula(&here, "check names.toml", &["boundary.out let.condition=no-slip"])
        .expect(2, &["'boundary.\"in let\".condition=no-slip'"]);
}

#[test]
fn groups_that_the_file_lost_or_has_twice_are_told() {
    let here = place("groups", &["formats/case.toml", "formats/all22.msh", "formats/twosurf22.msh"]);
    undula(&here, "check case.toml", &["mesh.file=all22.msh"])
        .expect(2, &["all22.msh:", "Mesh.SaveAll = 0", "Mesh.MshFileVersion = 4.1"]);
    undula(&here, "check case.toml", &["mesh.file=twosurf22.msh"])
        .expect(2, &["twosurf22.msh:", "a cell in physical groups `", "it can be in one only"]);
    let base = Base::read();
    let text = String::from_utf8(base.version_4(Out::text(), false, false)).unwrap();
    let line = text.lines().find(|l| l.ends_with(" 1 11 0 ")).unwrap();
    here.write("two4.msh", &text.replace(line, &line.replace(" 1 11 0 ", " 2 11 12 0 ")));
    undula(&here, "check case.toml", &["mesh.file=two4.msh"])
        .expect(2, &["is in physical groups `fluid` and `solid`; it can be in one only"]);
}

#[test]
fn mixed_cells_are_counted_and_the_remedy_named() {
    let here = place("mixed", &["newcomer/flap.toml", "newcomer/mixed.msh"]);
    undula(&here, "check flap.toml", &["mesh.file=mixed.msh"]).expect(
        2,
        &[
            "mixed.msh:",
            "48 triangles and 155 quadrilaterals",
            "Mesh.SubdivisionAlgorithm = 1",
            "Mesh.RecombineAll",
        ],
    );
}

#[test]
fn the_element_follows_the_cells_of_the_file() {
    let here = place("element", &["newcomer/flap.toml", "newcomer/flap_tri2.msh", "formats/base22.msh"]);
    undula(&here, "check flap.toml --toml", &[]).expect(0, &["velocity = \"P2\"", "pressure = \"P1\""]);
    undula(&here, "check flap.toml", &[]).expect(0, &["space     P2/P1"]);
    undula(&here, "check flap.toml", &["space.velocity=Q2"]).expect(2, &["triangles", "take P2"]);
    undula(&here, "check flap.toml", &["space.velocity=P2-bubble"]).expect(0, &["space     P2-bubble/P1dc"]);
    // What depends on the element is resolved after it.
    undula(&here, "check flap.toml", &["space.pressure=P2"]).expect(0, &["space     P2/P2", "stabilisation"]);
    undula(&here, "check flap.toml", &["space.pressure=P1dc"]).expect(2, &["P2-bubble with P1dc"]);
    // A file that is not there is the only thing to be told.
    let said = undula(&here, "check flap.toml", &["mesh.file=none.msh", "space.pressure=P1"])
        .expect(2, &["none.msh"]);
    assert_eq!(said.err.lines().count(), 1, "{}", said.err);
}

#[test]
fn meshes_in_other_units_are_scaled() {
    let here = place("scaled", &["formats/case.toml", "formats/base22.msh"]);
    let text = here.read("base22.msh");
    let (begin, end) = (text.find("$Nodes").unwrap() + 7, text.find("$EndNodes").unwrap());
    let millimetres = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        let x: Vec<String> =
            words[1..].iter().map(|w| (1e3 * w.parse::<f64>().unwrap()).to_string()).collect();
        format!("{} {}\n", words[0], x.join(" "))
    };
    let nodes: String = text[begin..end]
        .lines()
        .map(|l| if l.contains(' ') { millimetres(l) } else { format!("{l}\n") })
        .collect();
    here.write("mm.msh", &format!("{}{nodes}{}", &text[..begin], &text[end..]));
    let sets = ["mesh.file=mm.msh", "mesh.scale=1e-3", "motion.offset=0.01"];
    undula(&here, "run case.toml --threads 1 -q -o out", &sets).expect(0, &[]);
    for (name, right) in ["drag", "ux"].into_iter().zip(RIGHT) {
        close(last(&here, "out", name), right, 2e-6);
    }
    // It is kept with the case.
    assert!(here.read("out/case.toml").contains("scale = 0.001"));
    undula(&here, "check fsi1", &["mesh.scale=2"]).expect(2, &["mesh.scale=2", "only for `file`"]);
    undula(&here, "check case.toml", &["mesh.scale=0"]).expect(2, &["a number above 0"]);
}

#[test]
fn meshes_given_as_cases_are_told_in_one_line() {
    let here = place("as-case", &["formats/base22.msh", "newcomer/fmt_v4.1_bin_o1.msh"]);
    here.write("own.geo", "Point(1) = {0, 0, 0, 1};\n");
    for command in ["run", "check", "bench"] {
        for (file, words) in [
            ("base22.msh", "a mesh, not a case"),
            ("fmt_v4.1_bin_o1.msh", "a mesh, not a case"),
            ("own.geo", "gmsh -2 own.geo"),
        ] {
            let said =
                undula(&here, &format!("{command} {file}"), &[]).expect(2, &[words, "[mesh] with file"]);
            assert_eq!(said.err.lines().count(), 1, "{}", said.err);
        }
    }
    here.write("words.toml", &"this is no case\n".repeat(5000));
    let said = undula(&here, "check words.toml", &[]).expect(2, &["not TOML", "more places"]);
    assert!(said.err.lines().count() < 15, "{}", said.err);
}

#[test]
fn keys_of_other_programs_are_understood() {
    let here = place("keys", &["formats/case.toml", "formats/base22.msh"]);
    let case = here.read("case.toml");
    for (from, to, words) in [
        (
            "density = 1\nkinematic-viscosity = 0.1",
            "density = 1000\ndynamic-viscosity = 1e-3",
            &["fluid.dynamic-viscosity", "write kinematic-viscosity = 1.0e-6 [m²/s], which is mu/density"][..],
        ),
        (
            "kinematic-viscosity",
            "viscosity",
            &["`kinematic-viscosity` [m²/s] is needed", "kinematic-viscosity = 0.1"],
        ),
        ("kinematic-viscosity", "nu", &["fluid.nu: unknown key; did you mean `kinematic-viscosity`?"]),
        ("poisson = 0.3", "poisson = 0.5", &["incompressible-neo-hookean", "incompressible-mooney-rivlin"]),
        ("poisson = 0.3", "nu = 0.3", &["solid.nu: unknown key; did you mean `poisson`?"]),
        ("young = 1e3", "youngs-modulus = 1e3", &["did you mean `young`?"]),
        ("young = 1e3", "E = 1e3", &["solid.E: unknown key; did you mean `young`?"]),
        (
            "condition = \"clamped\"",
            "type = \"clamped\"",
            &["boundary.foot.type", "did you mean `condition`?"],
        ),
        ("file = ", "filename = ", &["mesh.filename", "did you mean `file`?"]),
    ] {
        assert!(case.contains(from), "{from}");
        here.write("own.toml", &case.replace(from, to));
        let said = undula(&here, "check own.toml", &[]).expect(2, words);
        let only = said.err.lines().filter(|line| line.starts_with("own.toml:")).count();
        assert_eq!(only, 1, "one mistake, told once:\n{}", said.err);
    }
    here.write("own.toml", &case.replace("young = 1e3\npoisson = 0.3", "E = 1e3\nnu = 0.3"));
    undula(&here, "check own.toml", &[]).expect(2, &["`young`", "`poisson`", "2 mistakes"]);
}

/// det DX is above 0 at the nodes and Gauss points of the cell, and below 0 between them.
#[test]
fn curved_cells_that_fold_between_their_nodes_are_refused() {
    let here = place("folded", &["discovery/q9b.msh"]);
    let case = "[mesh]\nfile = \"q9b.msh\"\n[fluid]\ndensity = 1\nkinematic-viscosity = 1\n\
        [boundary.in]\ncondition = \"no-slip\"\n[boundary.out]\ncondition = \"do-nothing\"\n";
    here.write("own.toml", case);
    for refine in 0..4 {
        undula(&here, "check own.toml", &[&format!("mesh.refine={refine}")])
            .expect(2, &["mesh.file", "det(DX) <= 0 somewhere", "the smallest det(DX) is -"]);
    }
    undula(&here, "check own.toml", &[]).expect(2, &["the smallest det(DX) is -1.4", "m^2 in cell 0 at ("]);
    // A mesh that is curved and does not fold.
    let text = here.read("q9b.msh");
    let (begin, end) = (text.find("$Nodes").unwrap(), text.find("$EndNodes").unwrap());
    let nodes = "$Nodes\n9\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0.5 0.1 0\n6 1.1 0.5 0\n7 0.5 1 0\n8 0 0.5 0\n\
        9 0.5 0.5 0\n";
    here.write("q9b.msh", &format!("{}{nodes}{}", &text[..begin], &text[end..]));
    undula(&here, "check own.toml", &["mesh.refine=2"]).expect(0, &["16 cells"]);
}

#[test]
fn elements_that_are_not_there_are_refused_with_a_way_out() {
    let here = place("elements", &["formats/case.toml", "formats/base22.msh"]);
    let text = here.read("base22.msh");
    let line = text.lines().rfind(|line| line.split(' ').nth(1) == Some("2")).unwrap();
    let words: Vec<&str> = line.split(' ').collect();
    for (kind, n, advice) in [
        (6, 6, "three dimensions"),
        (16, 8, "Mesh.SecondOrderIncomplete = 0"),
        (21, 10, "Mesh.ElementOrder = 2"),
        (39, 12, "Mesh.ElementOrder = 2"),
        (1000, 3, "elements of type 1000"),
    ] {
        let nodes: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
        let other = format!("{} {kind} {} {}", words[0], words[2..5].join(" "), nodes.join(" "));
        here.write("other.msh", &text.replace(line, &other));
        undula(&here, "check case.toml", &["mesh.file=other.msh"]).expect(2, &["other.msh:", advice]);
    }
    here.write("none.msh", &text.replace(" 2 2 11 ", " 15 2 11 ").replace(" 2 2 12 ", " 15 2 12 "));
    undula(&here, "check case.toml", &["mesh.file=none.msh"]).expect(2, &["no triangles or quadrilaterals"]);
    here.write("own.geo", "Point(1) = {0, 0, 0, 1};\n");
    undula(&here, "check case.toml", &["mesh.file=own.geo"]).expect(2, &["not a Gmsh mesh", "gmsh -2"]);
}

/// The mesh `base22.msh`, to be written in other ways.
struct Base {
    names: String,
    nodes: Vec<(i32, [f64; 3])>,
    /// Type, physical group, entity, nodes.
    elements: Vec<(i32, i32, i32, Vec<i32>)>,
}

impl Base {
    fn read() -> Base {
        let text = fs::read_to_string(input("formats/base22.msh")).unwrap();
        let section = |name: &str| {
            let (begin, end) =
                (text.find(&format!("${name}")).unwrap(), text.find(&format!("$End{name}")).unwrap());
            text[begin..end].lines().skip(2).map(|l| l.split(' ').collect::<Vec<_>>()).collect::<Vec<_>>()
        };
        let ints = |words: &[&str]| words.iter().map(|w| w.parse().unwrap()).collect::<Vec<i32>>();
        let (begin, end) = (text.find("$Phys").unwrap(), text.find("$Nodes").unwrap());
        let node = |words: Vec<&str>| {
            (words[0].parse::<i32>().unwrap(), [1, 2, 3].map(|i: usize| words[i].parse::<f64>().unwrap()))
        };
        let element = |words: Vec<&str>| {
            let numbers = ints(&words);
            (numbers[1], numbers[3], numbers[4], numbers[5..].to_vec())
        };
        Base {
            names: text[begin..end].to_string(),
            nodes: section("Nodes").into_iter().map(node).collect(),
            elements: section("Elements").into_iter().map(element).collect(),
        }
    }

    fn version_2(&self, mut out: Out, parametric: bool) -> Vec<u8> {
        out.header("2.2", &self.names);
        let section = if parametric { "ParametricNodes" } else { "Nodes" };
        out.line(&format!("${section}\n{}", self.nodes.len()));
        for (n, (tag, x)) in self.nodes.iter().enumerate() {
            out.int(*tag);
            x.iter().for_each(|x| out.real(*x));
            // Nodes on points, curves and surfaces have 0, 1 and 2 parameters.
            let dim = n % 3;
            if parametric {
                [dim as i32, 1].into_iter().for_each(|i| out.int(i));
                (0..dim).for_each(|_| out.real(0.5));
            }
            out.next();
        }
        out.line(&format!("\n$End{section}\n$Elements\n{}", self.elements.len()));
        for (k, (kind, group, entity, nodes)) in self.elements.iter().enumerate() {
            [*kind, 1, 2, k as i32 + 1, *group, *entity].into_iter().for_each(|i| out.int(i));
            nodes.iter().for_each(|n| out.int(*n));
        }
        out.line("\n$EndElements");
        out.bytes
    }

    fn version_4(&self, mut out: Out, parametric: bool, parts: bool) -> Vec<u8> {
        out.header("4.1", &self.names);
        let dim = |kind: i32| if kind == 1 { 1 } else { 2 };
        let mut entities: Vec<(i32, i32, i32)> =
            self.elements.iter().map(|(kind, group, entity, _)| (dim(*kind), *entity, *group)).collect();
        entities.sort_unstable();
        entities.dedup();
        out.entities(&entities, false);
        if parts {
            out.entities(&entities, true);
        }
        out.line("$Nodes");
        out.sizes(&[1, self.nodes.len(), 1, self.nodes.len()]);
        [2, 1, i32::from(parametric)].into_iter().for_each(|i| out.int(i));
        out.sizes(&[self.nodes.len()]);
        self.nodes.iter().for_each(|(tag, _)| out.sizes(&[*tag as usize]));
        for (_, x) in &self.nodes {
            x.iter().for_each(|x| out.real(*x));
            (0..if parametric { 2 } else { 0 }).for_each(|_| out.real(0.5));
            out.next();
        }
        out.line("\n$EndNodes\n$Elements");
        out.sizes(&[entities.len(), self.elements.len(), 1, self.elements.len()]);
        let mut tag = 0;
        for (d, entity, _) in entities {
            let here = self.elements.iter().filter(|e| (dim(e.0), e.2) == (d, entity));
            [d, entity + if parts { 100 } else { 0 }, here.clone().next().unwrap().0]
                .into_iter()
                .for_each(|i| out.int(i));
            out.sizes(&[here.clone().count()]);
            for (_, _, _, nodes) in here {
                tag += 1;
                out.sizes(&[&[tag][..], &nodes.iter().map(|n| *n as usize).collect::<Vec<_>>()[..]].concat());
            }
        }
        out.line("\n$EndElements");
        out.bytes
    }
}

/// Numbers as text or as bytes.
struct Out {
    bytes: Vec<u8>,
    binary: bool,
    big: bool,
}

impl Out {
    fn text() -> Out {
        Out { bytes: vec![], binary: false, big: false }
    }

    fn binary(big: bool) -> Out {
        Out { bytes: vec![], binary: true, big }
    }

    fn header(&mut self, version: &str, names: &str) {
        self.line(&format!("$MeshFormat\n{version} {} 8", u8::from(self.binary)));
        if self.binary {
            self.int(1);
            self.line("");
        }
        self.line(&format!("$EndMeshFormat\n{}", names.trim_end()));
    }

    fn line(&mut self, text: &str) {
        self.bytes.extend(text.bytes().chain([b'\n']));
    }

    fn put(&mut self, text: String, mut bytes: Vec<u8>) {
        if !self.binary {
            return self.bytes.extend(format!("{text} ").bytes());
        }
        if self.big {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    fn int(&mut self, i: i32) {
        self.put(i.to_string(), i.to_le_bytes().to_vec());
    }

    fn real(&mut self, x: f64) {
        self.put(format!("{x:?}"), x.to_le_bytes().to_vec());
    }

    /// Ends a line of a text.
    fn sizes(&mut self, sizes: &[usize]) {
        sizes.iter().for_each(|s| self.put(s.to_string(), (*s as u64).to_le_bytes().to_vec()));
        self.next();
    }

    fn next(&mut self) {
        if !self.binary {
            self.bytes.push(b'\n');
        }
    }

    /// Dimension, tag and group of each; of partitions every second has no group of its own.
    fn entities(&mut self, entities: &[(i32, i32, i32)], parts: bool) {
        let name = if parts { "PartitionedEntities" } else { "Entities" };
        self.line(&format!("${name}"));
        if parts {
            self.sizes(&[2]);
            self.sizes(&[1]);
            [77, 1].into_iter().for_each(|i| self.int(i));
            self.next();
        }
        let count = |dim: i32| entities.iter().filter(|e| e.0 == dim).count();
        self.sizes(&[0, count(1), count(2), 0]);
        for (n, (dim, tag, group)) in entities.iter().enumerate() {
            self.int(tag + if parts { 100 } else { 0 });
            if parts {
                [*dim, *tag].into_iter().for_each(|i| self.int(i));
                self.put("1".into(), 1_u64.to_le_bytes().to_vec());
                self.int(1);
            }
            (0..6).for_each(|_| self.real(0.0));
            let groups: Vec<i32> = if parts && n % 2 == 0 { vec![] } else { vec![*group] };
            self.put(groups.len().to_string(), (groups.len() as u64).to_le_bytes().to_vec());
            groups.iter().for_each(|g| self.int(*g));
            self.put("0".into(), 0_u64.to_le_bytes().to_vec());
            self.next();
        }
        self.line(&format!("\n$End{name}"));
    }
}
