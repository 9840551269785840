//! Regions, interfaces and enclosed parts of the fluid.

use super::*;
use std::collections::BTreeMap;
use std::fmt::Write;

const LEAVE_ROCK: &str = "mesh.leave-out=[\"rock\"]";
const RUN: &str = "run case.toml --threads 1 --quiet -o out";

/// A Gmsh file of the rectangle `size` in `n` times `m` cells with the names of the region at the middle of a cell and
/// of the boundary at the middle of an edge. Names are numbered forwards or backwards.
fn grid(
    size: [f64; 2],
    [n, m]: [usize; 2],
    forwards: bool,
    region: impl Fn(f64, f64) -> &'static str,
    name: impl Fn(f64, f64) -> Option<&'static str>,
) -> String {
    let x = |i2: usize| size[0] * i2 as f64 / (2 * n) as f64;
    let y = |j2: usize| size[1] * j2 as f64 / (2 * m) as f64;
    let node = |i: usize, j: usize| 1 + i + (n + 1) * j;
    let (mut cells, mut lines) = (vec![], vec![]);
    for j in 0..=m {
        for i in 0..=n {
            if i < n && j < m {
                let nodes = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
                cells.push((region(x(2 * i + 1), y(2 * j + 1)), nodes));
            }
            if i < n
                && let Some(name) = name(x(2 * i + 1), y(2 * j))
            {
                lines.push((name, [node(i, j), node(i + 1, j)]));
            }
            if j < m
                && let Some(name) = name(x(2 * i), y(2 * j + 1))
            {
                lines.push((name, [node(i, j), node(i, j + 1)]));
            }
        }
    }
    let numbered = |names: Vec<&'static str>| -> BTreeMap<&'static str, usize> {
        let count = names.len() + 20;
        let number = |(i, name)| (name, if forwards { i + 1 } else { count - i });
        names.into_iter().enumerate().map(number).collect()
    };
    let (of_cells, of_lines) = (
        numbered(cells.iter().map(|(name, _)| *name).collect()),
        numbered(lines.iter().map(|(name, _)| *name).collect()),
    );
    let mut text = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n");
    let mut names: Vec<(usize, usize, &str)> = of_lines.iter().map(|(name, tag)| (1, *tag, *name)).collect();
    names.extend(of_cells.iter().map(|(name, tag)| (2, *tag, *name)));
    names.sort_unstable();
    writeln!(text, "{}", names.len()).unwrap();
    names.iter().for_each(|(dim, tag, name)| writeln!(text, "{dim} {tag} \"{name}\"").unwrap());
    writeln!(text, "$EndPhysicalNames\n$Nodes\n{}", (n + 1) * (m + 1)).unwrap();
    for j in 0..=m {
        (0..=n).for_each(|i| writeln!(text, "{} {} {} 0", node(i, j), x(2 * i), y(2 * j)).unwrap());
    }
    writeln!(text, "$EndNodes\n$Elements\n{}", cells.len() + lines.len()).unwrap();
    for (number, (name, [a, b])) in lines.iter().enumerate() {
        writeln!(text, "{} 1 2 {tag} {tag} {a} {b}", number + 1, tag = of_lines[name]).unwrap();
    }
    for (number, (name, [a, b, c, d])) in cells.iter().enumerate() {
        let number = number + lines.len() + 1;
        writeln!(text, "{number} 3 2 {tag} {tag} {a} {b} {c} {d}", tag = of_cells[name]).unwrap();
    }
    text + "$EndElements\n"
}

/// The name of the side of the channel of [`grid`] at a point, if it is on one.
fn channel(size: [f64; 2], x: f64, y: f64) -> Option<&'static str> {
    let at = |a: f64, b: f64| (a - b).abs() < 1e-9;
    match () {
        () if at(x, 0.0) => Some("left"),
        () if at(x, size[0]) => Some("right"),
        () if at(y, 0.0) => Some("bottom"),
        () if at(y, size[1]) => Some("top"),
        () => None,
    }
}

#[test]
fn a_region_that_no_table_uses_is_refused() {
    let place = place("unused-region", &["third-region/case.toml", "newcomer/leak_box.toml"]);
    let words = [
        "case.toml:9:",
        "region `rock` of the mesh is used by no table",
        "mesh.leave-out = [\"rock\"]",
        "solid.region",
    ];
    undula(&place, "check case.toml", &[]).expect(2, &words);
    undula(&place, RUN, &[]).expect(2, &words);
    assert!(!place.file("out").exists());
    undula(&place, "run leak_box.toml", &[]).expect(2, &["region `extra`", "mesh.leave-out = [\"extra\"]"]);
    // Both ways of leaving too much out, and names that are not there.
    undula(&place, "check case.toml", &["mesh.leave-out=[\"rock\", \"solid\"]"])
        .expect(2, &["region `solid` is that of [solid]"]);
    undula(&place, "check case.toml", &["mesh.leave-out=[\"rocks\"]"])
        .expect(2, &["no region `rocks`; did you mean `rock`?"]);
    undula(&place, "check case.toml", &["mesh.leave-out=7"]).expect(2, &["expected an array of names"]);
    // Without [solid] its default region is left out, the other one is not.
    undula(&place, "check case.toml", &["solid=none"])
        .expect(2, &["region `rock`", "add [solid] with region = \"rock\""]);
    undula(&place, "check case.toml", &["solid=none", LEAVE_ROCK]).expect(
        0,
        &[
            "region `solid` of the mesh is left out, as there is no [solid]",
            "rock: 8 cells, 0.125 m², left out",
        ],
    );
    undula(&place, "check case.toml", &[LEAVE_ROCK, "fluid.region=water"]).expect(2, &["no region `water`"]);
    let kept = undula(&place, "check case.toml --toml", &[LEAVE_ROCK]).expect(0, &["leave-out = [\"rock\"]"]);
    place.write("again.toml", &kept.out);
    assert_eq!(undula(&place, "check again.toml --toml", &[]).expect(0, &[]).out, kept.out);
}

#[test]
fn a_region_left_out_is_a_wall_that_bears_its_name() {
    let place = place("left-out", &["third-region/case.toml"]);
    let both = [
        "functional.drag.on=[\"interface\", \"rock\"]",
        "functional.fy.on=[\"interface\", \"rock\"]",
        LEAVE_ROCK,
    ];
    undula(&place, RUN, &both).expect(0, &[]);
    close(last(&place, "out", "drag"), 7.0958, 1e-5);
    // The sides of bodies alone: on refined meshes both ways to compute it come near -1.21.
    close(last(&place, "out", "fy"), -1.22047, 1e-5);
    // A condition may name its sides; that of a boundary of the same name holds there, too.
    let slides = ["boundary.rock.condition=velocity", "boundary.rock.velocity=[1, 0]"];
    undula(&place, "check case.toml", &[&both[..], &slides].concat()).expect(0, &["rock: v = (1, 0) m/s"]);
    undula(&place, "check case.toml", &[LEAVE_ROCK, "boundary.rock.condition=clamped"])
        .expect(2, &["`clamped` is for a solid"]);
}

#[test]
fn regions_of_files_are_left_out_whatever_their_order() {
    let size = [4.0, 1.0];
    let region = |x: f64, y: f64| match () {
        () if (1.0..1.25).contains(&x) && y < 0.5 => "beam",
        () if (2.0..2.5).contains(&x) && (0.25..0.5).contains(&y) => "rock",
        () => "water",
    };
    let top = |x: f64, y: f64| ((2.0..2.5).contains(&x) && (y - 0.5).abs() < 1e-9).then_some("roof");
    let case = |file: &str| {
        let text = std::fs::read_to_string(input("third-region/case.toml")).unwrap();
        let (_, tables) = text.split_once("[fluid]").unwrap();
        let tables = tables
            .replace("[solid]\n", "[solid]\nregion = \"beam\"\n")
            .replace("[\"interface\"]", "[\"interface\", \"rock\", \"roof\"]");
        format!("[mesh]\nfile = \"{file}\"\nleave-out = [\"rock\"]\n[fluid]\nregion = \"water\"\n{tables}")
    };
    let place = place("left-out-file", &[]);
    for (file, forwards) in [("forwards.msh", true), ("backwards.msh", false)] {
        place.write(file, &grid(size, [32, 8], forwards, region, |x, y| channel(size, x, y).or(top(x, y))));
        place.write("case.toml", &case(file));
        undula(&place, &format!("{RUN} --force"), &["boundary.roof.condition=no-slip"]).expect(0, &[]);
        close(last(&place, "out", "drag"), 7.0958, 1e-5);
        // Without a condition it is a wall all the same, the other body being left out does not matter.
        undula(
            &place,
            &format!("{RUN} --force"),
            &[
                "solid=none",
                "mesh.leave-out=[\"beam\", \"rock\"]",
                "functional.drag.on=[\"beam\", \"rock\", \"roof\"]",
                "functional.fy=none",
            ],
        )
        .expect(0, &[]);
        close(last(&place, "out", "drag"), 7.0958, 1e-5);
        // Only the default region goes without being told.
        undula(&place, "check case.toml", &["solid=none"])
            .expect(2, &["region `beam` of the mesh is used by no table"]);
        undula(&place, "check case.toml", &["functional.drag.on=beam"]).expect(2, &["no boundary `beam`"]);
        undula(&place, "check case.toml", &["boundary.roof.condition=traction-free"]).expect(0, &[]);
    }
}

#[test]
fn a_base_left_out_holds_the_body_on_it() {
    let place = place("base", &["third-region/base.toml"]);
    undula(&place, "check base.toml", &[]).expect(2, &["region `base` of the mesh is used by no table"]);
    let run = |name: &str, more: &[&str]| {
        let sets = ["mesh.leave-out=base", "time.end=0.03", "functional.ux.point=[1.125, 0.625]"];
        undula(&place, &format!("run base.toml --threads 1 --quiet -o {name}"), &[&sets[..], more].concat())
            .expect(0, &[]);
        last(&place, name, "ux")
    };
    let held = run("held", &[]);
    assert!(held != 0.0 && held.abs() < 1e-3, "{held}");
    assert_eq!(run("clamped", &["boundary.base.condition=no-slip"]), held);
    assert_eq!(run("foot", &["functional.ux.point=[1.125, 0.125]"]), 0.0);
    // At rest it is held, too; where its sides are free nothing holds it.
    let at_rest = ["time=none", "boundary.left.velocity=[\"4*y*(1-y)\", 0]", "mesh.leave-out=base"];
    undula(&place, "check base.toml", &at_rest).expect(0, &[]);
    undula(&place, "check base.toml", &[&at_rest[..], &["boundary.base.condition=traction-free"]].concat())
        .expect(2, &["nothing holds the solid"]);
}

/// A plate under its own weight that hangs on a bolt inside of it, which is no part of the mesh that is computed on.
#[test]
fn a_region_left_out_inside_of_the_solid_holds_it() {
    let place = place("bolt", &[]);
    place.write(
        "case.toml",
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 1]\ncells = [8, 8]\nleave-out = [\"bolt\"]\n\
         region = { bolt = \"min(min(x-0.375, 0.625-x), min(y-0.375, 0.625-y))\", solid = \"max(abs(x-0.5), abs(y-0.5)) > 0.125\" }\n\
         [solid]\ndensity = 1\nyoung = 1e3\npoisson = 0.3\nbody-force = [0, -10]\n\
         [boundary]\nleft = { condition = \"traction-free\" }\nright = { condition = \"traction-free\" }\n\
         top = { condition = \"traction-free\" }\nbottom = { condition = \"traction-free\" }\n\
         [functional.uy]\nkind = \"displacement\"\npoint = [0, 0.5]\ncomponent = \"y\"\n\
         [functional.bolt]\nkind = \"displacement\"\npoint = [0.375, 0.5]\ncomponent = \"y\"\n",
    );
    undula(&place, RUN, &[]).expect(0, &[]);
    assert_eq!(last(&place, "out", "bolt"), 0.0);
    let uy = last(&place, "out", "uy");
    assert!(uy < -1e-3 && uy > -1e-1, "{uy}");
    undula(&place, "check case.toml", &["boundary.bolt.condition=traction-free"])
        .expect(2, &["nothing holds the solid"]);
}

/// Fluid below, solid above, and between them a liner that is left out, on all of the length or on half of it.
#[test]
fn a_region_between_fluid_and_solid_can_be_left_out() {
    let place = place("liner", &["interface-name/ok.toml"]);
    let size = [4.0, 1.2];
    for (whole, notes) in [(true, "fluid and solid touch nowhere"), (false, "liner: 8 cells")] {
        let region = move |x: f64, y: f64| match () {
            () if y < 0.8 => "fluid",
            () if y > 1.0 || (!whole && x > 2.0) => "solid",
            () => "liner",
        };
        let name = |x: f64, y: f64| match channel(size, x, y)? {
            "left" if y < 0.8 => Some("inlet"),
            "left" => Some("wall_in"),
            "right" if y < 0.8 => Some("outlet"),
            "right" => Some("wall_out"),
            other => Some(other),
        };
        place.write("tube.msh", &grid(size, [16, 6], true, region, name));
        let functionals = ["functional.lift.on=bottom", "functional.uy_mid=none", "functional.uy_end=none"];
        let sets = [&functionals[..], &["mesh.leave-out=[\"liner\"]", "time.end=0.02"]].concat();
        undula(&place, "check ok.toml", &sets).expect(0, &[notes]);
        undula(&place, "run ok.toml --threads 1 --quiet --force -o out", &sets).expect(0, &[]);
    }
}

#[test]
fn regions_are_decided_inside_of_the_cells() {
    let place = place("region-condition", &["region-condition/case.toml"]);
    undula(&place, "check case.toml", &[]).expect(0, &["solid: 8 cells, 0.125 m²", "fluid: 248 cells"]);
    undula(&place, RUN, &[]).expect(0, &[]);
    close(last(&place, "out", "drag"), 3.89659, 2e-6);
    for same in [
        "min(min(x-1, 1.25-x), 0.5-y)",
        "(x > 1)*(x < 1.25)*(y < 0.5)",
        "(abs(x-1.125) <= 0.125)*(y < 0.5)",
        "1e9*min(0.125-abs(x-1.125), 0.5-y)",
    ] {
        let set = format!("mesh.region.solid={same}");
        undula(&place, "check case.toml", &[&set]).expect(0, &["solid: 8 cells, 0.125 m²"]);
    }
    for cut in
        ["hypot(x-1.5,y-0.5) < 0.2", "0.2-hypot(x-1.5,y-0.5)", "x < 1.01", "1.0001-x", "(x>1)*(x<1.24)"]
    {
        let set = format!("mesh.region.solid={cut}");
        undula(&place, "check case.toml", &[&set]).expect(2, &["mesh.region.solid", "cells cut by", "at ("]);
    }
    for nothing in ["-1", "x > 5", "(x>1)*(x<1)"] {
        let set = format!("mesh.region.solid={nothing}");
        undula(&place, "check case.toml", &[&set]).expect(2, &["no cell lies in region `solid`"]);
    }
    undula(&place, "check case.toml", &["mesh.region.solid=sqrt(x-1)"])
        .expect(2, &["not a number", "cells 0 at"]);
    // Thirds are no lines of binary numbers.
    let thirds = ["mesh.lower=[0.1, 0]", "mesh.upper=[0.4, 0.1]", "mesh.cells=[9, 3]", "functional.ux=none"];
    for third in ["min(min(x-0.2, 0.3-x), 0.1-0.1/3-y)", "(x>=0.2)*(x<=0.3)*(y<=0.2/3)"] {
        let set = format!("mesh.region.solid={third}");
        undula(&place, "check case.toml", &[&thirds[..], &[&set]].concat()).expect(0, &["solid: 6 cells"]);
    }
    let twice = ["mesh.region.base=0.25-y", "mesh.leave-out=base"];
    undula(&place, "check case.toml", &twice).expect(0, &["4 cells are in regions `base` and `solid`"]);
}

#[test]
fn names_on_the_interface_are_parts_of_it() {
    let place = place(
        "interface-name",
        &["interface-name/case.toml", "interface-name/ok.toml", "interface-name/tube.msh"],
    );
    undula(&place, "check case.toml", &[]).expect(0, &["lift"]);
    for method in ["residual", "surface-integral"] {
        let method = format!("functional.lift.method={method}");
        let [named, whole] = ["case", "ok"].map(|case| {
            let run = format!("run {case}.toml --threads 1 --quiet --force -o {case}");
            undula(&place, &run, &["time.end=0.02", &method]).expect(0, &[]);
            last(&place, case, "lift")
        });
        assert_eq!(named, whole);
        assert!(whole != 0.0);
    }
    for condition in ["clamped", "no-slip", "traction-free"] {
        let set = format!("boundary.fsi.condition={condition}");
        undula(&place, "check case.toml", &[&set])
            .expect(2, &["boundary.fsi", "nothing can be imposed on the interface", "`fsi` is a part"]);
    }
    // Without the solid the interface is a wall, and its parts can still be asked for.
    undula(&place, "check case.toml", &["solid=none", "functional.uy_mid=none", "functional.uy_end=none"])
        .expect(0, &["region `solid` of the mesh is left out"]);
    undula(&place, "check case.toml", &["solid=none", "boundary.fsi.condition=no-slip"])
        .expect(2, &["`fsi` is a part of the interface with region `solid`", "mesh.leave-out = [\"solid\"]"]);
    undula(
        &place,
        "check case.toml",
        &["solid=none", "mesh.leave-out=solid", "boundary.fsi.condition=no-slip"],
    )
    .expect(0, &[]);
}

#[test]
fn parts_of_an_interface_may_overlap_the_outer_boundary_and_are_refined() {
    let size = [4.0, 1.0];
    let place = place("interface-parts", &["third-region/case.toml"]);
    let region = |x: f64, y: f64| if (1.0..1.5).contains(&x) && y < 0.5 { "solid" } else { "fluid" };
    let at = |a: f64, b: f64| (a - b).abs() < 1e-9;
    let name = move |x: f64, y: f64| match () {
        () if (1.0..1.5).contains(&x) && at(y, 0.5) => Some("tip"),
        () if at(x, 1.5) && y < 0.5 => Some("top"),
        () => channel(size, x, y),
    };
    place.write("case.msh", &grid(size, [16, 4], false, region, name));
    let text = place.read("case.toml");
    let (_, tables) = text.split_once("[fluid]").unwrap();
    place.write("case.toml", &format!("[mesh]\nfile = \"case.msh\"\n[fluid]{tables}"));
    for refine in ["mesh.refine=0", "mesh.refine=1"] {
        let [whole, tip, back, both] = ["interface", "tip", "top", "tip\", \"interface"].map(|on| {
            let on = format!("functional.drag.on=[\"{on}\"]");
            let sets = [&on, refine, "functional.drag.method=surface-integral", "functional.fy=none"];
            undula(&place, &format!("{RUN} --force"), &sets).expect(0, &[]);
            last(&place, "out", "drag")
        });
        assert_eq!(whole, both);
        // The upper wall bears the name of the back of the body, too.
        assert!(tip.abs() < whole.abs() && back.abs() < 2.0 * whole.abs(), "{whole} {tip} {back}");
        assert!(tip != 0.0 && back != 0.0);
    }
}

#[test]
fn a_condition_on_the_interface_of_a_file_is_refused() {
    let place = place("fsi-condition", &["newcomer/g.toml", "newcomer/g_fsi.msh"]);
    let sets = ["mesh.file=g_fsi.msh", "boundary.fsi.condition=clamped"];
    undula(&place, "check g.toml", &sets)
        .expect(2, &["nothing can be imposed on the interface", "`fsi` is a part"]);
    undula(&place, "check g.toml", &sets[..1]).expect(0, &["fluid:"]);
}

#[test]
#[ignore = "long"]
fn the_pressure_of_a_closed_part_of_the_fluid_has_mean_zero() {
    let place = place("two-parts", &["discovery/two.toml", "discovery/g4.msh"]);
    let note = "the part of the fluid in [2, 3] x [0, 1] m is closed in on all sides, so its pressure is determined up to \
                a constant only: its mean is set to 0";
    undula(&place, "check two.toml", &[]).expect(0, &[note]);
    let run = "run two.toml --threads 1 --force -o out";
    let values =
        [&[][..], &["linear.solver=faer"], &["linear.precision=double"], &["newton.tolerance=1e-12"]].map(
            |sets| {
                undula(&place, run, sets).expect(0, &[note]);
                [last(&place, "out", "drag"), last(&place, "out", "dragy")]
            },
        );
    for [drag, dragy] in values {
        close(drag, values[3][0], 1e-6);
        assert!((dragy - values[3][1]).abs() < 1e-6 * values[3][0].abs(), "{values:?}");
    }
}

const CAVITY: &str = "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 1]\ncells = [8, 8]\n\
    [fluid]\ndensity = 1\nkinematic-viscosity = 0.1\n\
    [boundary]\nleft = { condition = \"no-slip\" }\nright = { condition = \"no-slip\" }\nbottom = { condition = \"no-slip\" }\n\
    top = { condition = \"velocity\", velocity = [\"16*x^2*(1-x)^2\", 0] }\n\
    [functional]\nlift = { kind = \"force\", on = [\"top\"], component = \"y\", method = \"surface-integral\" }\n\
    down = { kind = \"force\", on = [\"bottom\"], component = \"y\", method = \"surface-integral\" }\n\
    p = { kind = \"pressure-difference\", a = [0.1, 0.9], b = [0.9, 0.9] }\n";

/// Every element, at rest and in time; the vertical forces on the lid and on the bottom tell the level of the pressure.
#[test]
#[ignore = "long"]
fn a_cavity_is_computed_with_every_element() {
    let place = place("cavity", &[]);
    place.write("case.toml", CAVITY);
    let mut levels = vec![];
    for sets in [
        &["mesh.refine=1"][..],
        &["space.velocity=Q2", "space.pressure=Q1", "mesh.refine=1"],
        &["space.velocity=Q3", "mesh.refine=1"],
        &["space.velocity=P2", "mesh.refine=1"],
        &["space.velocity=P2-bubble", "mesh.refine=1"],
        &["space.velocity=Q1", "mesh.refine=2"],
    ] {
        undula(&place, "run case.toml --threads 1 --force -o out", sets).expect(0, &["its mean is set to 0"]);
        levels.push(["lift", "down", "p"].map(|name| last(&place, "out", name)));
    }
    for (n, level) in levels.iter().enumerate() {
        for (value, right) in level.iter().zip(&levels[2]) {
            assert!((value - right).abs() < 0.05 * levels[2][2].abs(), "{n}: {level:?} {:?}", levels[2]);
        }
    }
    // In time to the same state.
    let sets = ["mesh.refine=1", "time.scheme=bdf2", "time.step=0.2", "time.end=6"];
    undula(&place, &format!("{RUN} --force"), &sets).expect(0, &[]);
    for (name, right) in ["lift", "down", "p"].iter().zip(levels[0]) {
        let value = last(&place, "out", name);
        assert!((value - right).abs() < 1e-4 * levels[0][2].abs(), "{name}: {value} {right}");
    }
    undula(&place, "check case.toml --jacobian", &["mesh.cells=[2, 2]"]).expect(0, &[]);
}

#[test]
fn data_that_do_not_balance_in_a_closed_part_are_refused() {
    let place = place("unbalanced", &["newcomer/g.toml", "newcomer/g_ok.msh"]);
    place.write("case.toml", CAVITY);
    let flows = |y: &str| format!("boundary.top.velocity=[0, \"{y}\"]");
    undula(&place, "check case.toml", &[&flows("x*(1-x)")]).expect(
        2,
        &[
            "fluid: the fluid is closed in on all sides",
            "1.6667e-1 m²/s more flow out than in",
            "`do-nothing`",
        ],
    );
    undula(&place, "check case.toml", &[&flows("x*(1-x)*(x-0.5)")]).expect(0, &["its mean is set to 0"]);
    let in_time = ["time.step=0.1", "time.end=10", "time.scheme=bdf2"];
    undula(&place, "check case.toml", &[&in_time[..], &[&flows("x*(1-x)*sin(t)")]].concat())
        .expect(2, &["m²/s more flow", "at t = "]);
    // A body that gives way makes room for a while.
    let closed = ["boundary.outflow.condition=no-slip"];
    undula(&place, "check g.toml", &closed).expect(
        0,
        &["closed in on all sides", "m²/s more flow in than out at t = 0.1 s", "only the body can make room"],
    );
    undula(&place, "check g.toml", &[&closed[..], &["solid=none"]].concat())
        .expect(2, &["closed in on all sides"]);
    let sets = [&closed[..], &["time.end=5", "time.step=0.1"]].concat();
    let said =
        undula(&place, "run g.toml --threads 1 --quiet -o out", &sets).expect(3, &["closed in on all sides"]);
    assert!(said.err.contains("more flow in than out"));
    assert!(place.json("out/summary.json")["breakdown"]["reason"].as_str().unwrap().contains("closed in"));
}

#[test]
fn a_pressure_that_nothing_fixes_at_rest_is_refused() {
    let place = place("closed-stationary", &["closed-stationary/case.toml"]);
    let words = [
        "fluid: the fluid is closed in on all sides",
        "determined up to a constant only",
        "`do-nothing`",
        "[time]",
    ];
    undula(&place, "check case.toml", &[]).expect(2, &words);
    undula(&place, RUN, &[]).expect(2, &words);
    let in_time = ["time.step=0.1", "time.end=0.2", "time.scheme=bdf2"];
    undula(&place, "check case.toml", &in_time).expect(0, &[]);
    undula(&place, RUN, &in_time).expect(0, &[]);
    // With a volume that cannot change time does not help.
    let incompressible = ["solid.law=incompressible-neo-hookean", "solid.lambda=none"];
    undula(&place, "check case.toml", &[&in_time[..], &incompressible].concat())
        .expect(2, &["solid.law", "cannot change and no boundary gives way"]);
    undula(
        &place,
        "check case.toml",
        &[&in_time[..], &incompressible, &["boundary.bottom.condition=traction-free"]].concat(),
    )
    .expect(0, &[]);
}

#[test]
fn every_part_of_a_solid_must_be_held() {
    let place = place("two-solids", &["region-condition/case.toml"]);
    // One block on the floor, one that floats.
    let two = "mesh.region.solid=max(min(min(x-1, 1.25-x), 0.5-y), min(min(x-2, 2.5-x), min(y-0.25, 0.5-y)))";
    undula(&place, "check case.toml", &[two])
        .expect(2, &["nothing holds the part of the solid in [2, 2.5] x [0.25, 0.5] m"]);
    undula(&place, "check case.toml", &[two, "time.step=0.1", "time.end=1"]).expect(0, &["solid: 16 cells"]);
}
