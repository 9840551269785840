//! The same problem turned in space: what is a vector turns, what is a number stays. This finds mistakes in indices that
//! extruded planes hide, and takes slip along planes that are no planes of coordinates.

use super::Place;
use super::in_space::{Row, TIGHT};
use std::fmt::Write;

type Matrix = [[f64; 3]; 3];

const AXES: [&str; 3] = ["x", "y", "z"];
const STRAIGHT: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A rotation about all axes, one after the other.
fn rotation() -> Matrix {
    let about = |axis: usize, angle: f64| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut turn = STRAIGHT;
        (turn[i][i], turn[i][j], turn[j][i], turn[j][j]) =
            (angle.cos(), -angle.sin(), angle.sin(), angle.cos());
        turn
    };
    let product = |a: Matrix, b: Matrix| -> Matrix {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
    };
    product(about(2, -0.5), product(about(1, 0.7), about(0, 0.4)))
}

fn turned(turn: &Matrix, x: [f64; 3]) -> [f64; 3] {
    turn.map(|row| (0..3).map(|j| row[j] * x[j]).sum())
}

/// The vector of three expressions of the coordinates X, Y, Z of the straight problem.
fn expressions(turn: &Matrix, components: [&str; 3]) -> String {
    let sum = |factors: [f64; 3], terms: [&str; 3]| {
        (0..3).map(|i| format!("({:?})*({})", factors[i], terms[i])).collect::<Vec<_>>().join(" + ")
    };
    let straight = |text: &str| {
        (0..3).fold(text.to_string(), |text, i| {
            let at = sum([turn[0][i], turn[1][i], turn[2][i]], AXES);
            text.replace(["X", "Y", "Z"][i], &format!("({at})"))
        })
    };
    let all = components.map(straight);
    let row = |i: usize| format!("\"{}\"", sum(turn[i], [&all[0], &all[1], &all[2]]));
    format!("[{}, {}, {}]", row(0), row(1), row(2))
}

/// A Gmsh file of a box in cells, the solid where `is_solid` is true of their middles.
fn hexahedra(turn: &Matrix, size: [f64; 3], n: [usize; 3], is_solid: impl Fn([f64; 3]) -> bool) -> String {
    let node = |at: [usize; 3]| 1 + at[0] + (n[0] + 1) * (at[1] + (n[1] + 1) * at[2]);
    let place = |at: [f64; 3]| -> [f64; 3] { std::array::from_fn(|d| size[d] * at[d] / n[d] as f64) };
    let grid =
        |n: [usize; 3]| (0..n[0] * n[1] * n[2]).map(move |i| [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])]);
    let (mut nodes, mut elements, mut has) = (String::new(), vec![], [false; 2]);
    for at in grid(n.map(|n| n + 1)) {
        let [x, y, z] = turned(turn, place(at.map(|i| i as f64)));
        writeln!(nodes, "{} {x:?} {y:?} {z:?}", node(at)).unwrap();
    }
    for at in grid(n) {
        let corner = |i: usize| {
            let [a, b, c] =
                [[0, 0], [1, 0], [1, 1], [0, 1]][i % 4].into_iter().chain([i / 4]).collect::<Vec<_>>()[..]
            else {
                unreachable!()
            };
            node([at[0] + a, at[1] + b, at[2] + c])
        };
        let solid = is_solid(place(at.map(|i| i as f64 + 0.5)));
        has[usize::from(solid)] = true;
        elements.push((5, 1 + usize::from(solid), (0..8).map(corner).collect::<Vec<_>>()));
        for (side, corners) in
            [[0, 3, 7, 4], [1, 2, 6, 5], [0, 1, 5, 4], [3, 2, 6, 7], [0, 1, 2, 3], [4, 5, 6, 7]]
                .into_iter()
                .enumerate()
        {
            let end = if side % 2 == 0 { 0 } else { n[side / 2] - 1 };
            if at[side / 2] == end {
                elements.push((3, 3 + side, corners.map(corner).to_vec()));
            }
        }
    }
    let names = ["fluid", "solid", "left", "right", "bottom", "top", "front", "back"];
    let present: Vec<usize> = (0..8).filter(|&i| i > 1 || has[i]).collect();
    let mut text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{}\n", present.len());
    for i in present {
        writeln!(text, "{} {} \"{}\"", if i < 2 { 3 } else { 2 }, i + 1, names[i]).unwrap();
    }
    let count = nodes.lines().count();
    write!(text, "$EndPhysicalNames\n$Nodes\n{count}\n{nodes}$EndNodes\n$Elements\n{}\n", elements.len())
        .unwrap();
    for (number, (kind, group, nodes)) in (1..).zip(&elements) {
        let nodes: Vec<String> = nodes.iter().map(usize::to_string).collect();
        writeln!(text, "{number} {kind} 2 {group} {group} {}", nodes.join(" ")).unwrap();
    }
    text + "$EndElements\n"
}

/// Functionals that are vectors, tensors and numbers.
fn functionals(turn: &Matrix) -> String {
    let at = |x: [f64; 3]| format!("{:?}", turned(turn, x));
    let mut text = String::from("[functional]\n");
    let (corner, inside, centre) = (at([0.6, 0.2, 0.15]), at([0.8, 0.13, 0.11]), at([0.4, 0.1, 0.2]));
    for c in AXES {
        for (name, rest) in [
            ("F", "kind = \"force\", on = [\"interface\"]".to_string()),
            ("B", "kind = \"force\", on = [\"bottom\"]".into()),
            ("S", "kind = \"force\", on = [\"front\"]".into()),
            ("G", "kind = \"force\", on = [\"interface\"], method = \"surface-integral\"".into()),
            ("M", format!("kind = \"moment\", on = [\"interface\", \"bottom\"], point = {centre}")),
            ("u", format!("kind = \"displacement\", point = {corner}")),
            ("v", format!("kind = \"velocity\", point = {inside}")),
            ("W", "kind = \"wall-shear-stress\", on = [\"bottom\"], take = \"mean\"".into()),
        ] {
            writeln!(text, "{name}_{c} = {{ {rest}, component = \"{c}\" }}").unwrap();
        }
    }
    for c in ["xx", "xy", "xz", "yy", "yz", "zz"] {
        writeln!(
            text,
            "s_{c} = {{ kind = \"stress\", region = \"solid\", take = \"mean\", component = \"{c}\" }}"
        )
        .unwrap();
    }
    for (name, rest) in [
        ("pressure", format!("kind = \"pressure\", point = {inside}")),
        ("mises", "kind = \"stress\", region = \"solid\", component = \"von-mises\", take = \"max\"".into()),
        (
            "principal",
            "kind = \"stress\", region = \"solid\", component = \"principal-max\", take = \"max\"".into(),
        ),
        ("flux", "kind = \"flux\", on = [\"right\"]".into()),
        ("power", "kind = \"power\", on = [\"interface\"]".into()),
        ("kinetic", "kind = \"energy\", term = \"fluid-kinetic\"".into()),
        ("dissipation", "kind = \"energy\", term = \"dissipation\"".into()),
        ("volume", "kind = \"volume\", region = \"solid\"".into()),
    ] {
        writeln!(text, "{name} = {{ {rest} }}").unwrap();
    }
    text
}

/// A flap in a channel.
fn channel(turn: &Matrix, profile: &str, [front, back]: [&str; 2]) -> String {
    let inflow = expressions(turn, [profile, "0", "0"]);
    let force = expressions(turn, ["0.2", "-1", "0.1 + X"]);
    format!(
        "mesh = {{ file = \"box.msh\" }}\nfluid = {{ density = 1000, kinematic-viscosity = 1e-3 }}\n\
         motion = {{ offset = 0.02 }}\ntime = {{ step = 0.01, end = 0.01 }}\n\
         solid = {{ density = 1500, mu = 2e3, lambda = 4e3, body-force = {force} }}\n[boundary]\n\
         left = {{ condition = \"velocity\", velocity = {inflow} }}\nright = {{ condition = \"do-nothing\" }}\n\
         top = {{ condition = \"no-slip\" }}\nbottom = {{ condition = \"no-slip\" }}\n\
         front = {{ condition = \"{front}\" }}\nback = {{ condition = \"{back}\" }}\n{}",
        functionals(turn)
    )
}

/// Asserts that the vectors and tensors in `other` are those of `one` turned, and that numbers are equal, to 1e-9.
#[track_caller]
fn assert_turned(turn: &Matrix, one: &Row, other: &Row) {
    let vector = |row: &Row, name: &str| AXES.map(|c| row[&format!("{name}_{c}")]);
    for name in one.keys().filter_map(|name| name.strip_suffix("_x")) {
        let expected = turned(turn, vector(one, name));
        let size = expected.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let found = vector(other, name);
        assert!(
            (0..3).all(|i| (expected[i] - found[i]).abs() < 1e-9 * size),
            "{name}: {expected:?} {found:?}"
        );
    }
    if one.contains_key("s_xx") {
        let tensor = |row: &Row| -> Matrix {
            std::array::from_fn(|i| {
                std::array::from_fn(|j| row[&format!("s_{}{}", AXES[i.min(j)], AXES[i.max(j)])])
            })
        };
        let (a, b) = (tensor(one), tensor(other));
        // R A = B R.
        for i in 0..3 {
            let expected: [f64; 3] = std::array::from_fn(|j| (0..3).map(|k| turn[i][k] * a[k][j]).sum());
            let found: [f64; 3] = std::array::from_fn(|j| (0..3).map(|k| b[i][k] * turn[k][j]).sum());
            assert!(
                (0..3).all(|j| (expected[j] - found[j]).abs() < 1e-9 * a[0][0].abs()),
                "{expected:?} {found:?}"
            );
        }
    }
    let skipped = |name: &str| name.contains('_') || ["step", "jacobians", "time"].contains(&name);
    for name in one.keys().filter(|name| !skipped(name)) {
        assert!(
            (one[name] - other[name]).abs() < 1e-9 * one[name].abs(),
            "{name}: {} {}",
            one[name],
            other[name]
        );
    }
}

/// The last rows of the straight and of the turned problem.
fn last_rows(here: &Place, sets: &[&str], case: impl Fn(&Matrix) -> (String, String)) -> [Row; 2] {
    [STRAIGHT, rotation()].map(|turn| {
        let (mesh, case) = case(&turn);
        here.write("box.msh", &mesh);
        here.write("own.toml", &case);
        here.rows("own.toml", &[&TIGHT, sets].concat()).pop().unwrap()
    })
}

#[test]
fn a_problem_turned_in_space_has_the_same_solution_turned() {
    let here = Place::new("space-turned");
    let is_flap = |[x, y, _]: [f64; 3]| 0.4 < x && x < 0.6 && y < 0.2;
    let flat = "6*Y*(0.4 - Y)*ramp(t, 0.02)";
    let half = "6*Y*(0.4 - Y)*(0.09 - Z*Z)/0.09*ramp(t, 0.02)";
    for (profile, sides, sets) in [
        (flat, ["symmetry", "slip"], &["motion.walls=sliding"][..]),
        (half, ["symmetry", "no-slip"], &["time.scheme=cg1", "motion.model=jacobian-stiffened"]),
        (half, ["do-nothing", "no-slip"], &["solid.law=incompressible-neo-hookean", "solid.lambda=none"]),
        (half, ["symmetry", "no-slip"], &["space.velocity=Q1", "newton.linearization=fixed-point"]),
    ] {
        let [one, other] = last_rows(&here, sets, |turn| {
            (hexahedra(turn, [1.2, 0.4, 0.3], [6, 2, 2], is_flap), channel(turn, profile, sides))
        });
        assert_turned(&rotation(), &one, &other);
        // Nothing acts along a plane without friction, and some of it across.
        if sides[0] == "symmetry" {
            let force = AXES.map(|c| one[&format!("S_{c}")].abs());
            assert!(force[0].max(force[1]) < 1e-9 * force[2], "{force:?}");
        }
    }
}

#[test]
#[ignore = "long"]
fn fibres_turn_with_the_body() {
    let here = Place::new("space-fibres");
    let bar = |turn: &Matrix, law: &str, fibre: [f64; 3]| {
        let (force, tip) = (turned(turn, [0.03, -0.1, 0.05]), turned(turn, [1.0, 0.3, 0.2]));
        let mut text = format!(
            "mesh = {{ file = \"box.msh\" }}\n[boundary]\nleft = {{ condition = \"clamped\" }}\n[solid]\ndensity = 1000\n\
             body-force = {force:?}\nfibre-direction = {:?}\n{law}\n[functional]\n",
            turned(turn, fibre)
        );
        for c in AXES {
            writeln!(text, "u_{c} = {{ kind = \"displacement\", point = {tip:?}, component = \"{c}\" }}")
                .unwrap();
        }
        for side in ["right", "top", "bottom", "front", "back"] {
            writeln!(text, "[boundary.{side}]\ncondition = \"traction-free\"").unwrap();
        }
        (hexahedra(turn, [1.0, 0.3, 0.2], [2, 1, 1], |_| true), text)
    };
    let muscle = "law = \"guccione\"\nguccione-c = 8e3\nb-f = 8\nb-t = 2\nb-fs = 4";
    let artery =
        "law = \"holzapfel-gasser-ogden\"\nmu = 5e3\nlambda = 1e4\nk1 = 1e4\nk2 = 2\nfibre-angle = 0";
    for law in [muscle, artery] {
        let [one, other] = last_rows(&here, &[], |turn| bar(turn, law, [1.0, 2.0, 0.5]));
        assert_turned(&rotation(), &one, &other);
    }
    let (_, text) = bar(&STRAIGHT, artery, [1.0, 2.0, 0.5]);
    here.write("own.toml", &text);
    here.run("check own.toml", &["solid.fibre-angle=\"30 deg\""])
        .expect(2, &["solid.fibre-direction", "around the z axis", "or fibre-angle = 0; its z is 0.5"]);
}
