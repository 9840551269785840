//! Forces on parts of boundaries.

use super::{close, last, place, undula};
use crate::Place;
use std::fs;
use std::path::Path;
use undula::mesh::generate::rectangle;
use undula::mesh::{Mesh, gmsh};

/// Plane Poiseuille flow in the channel (0, 4) × (0, 1), p = 8 ρν (4 − x), as in `poiseuille.toml`.
const FLOW: &str = r#"
[mesh]
file = "channel.msh"
[fluid]
density = 1
kinematic-viscosity = 0.1
[boundary.left]
condition = "velocity"
velocity = ["4*y*(1-y)", 0]
[boundary.right]
condition = "do-nothing"
[boundary.top]
condition = "no-slip"
[boundary.bottom]
condition = "no-slip"
[boundary.bottom-end]
condition = "no-slip"
"#;

/// A functional for each boundary or list of them, name and component, by both methods.
fn forces(list: &[(&str, &[&str])]) -> String {
    let mut text = String::new();
    for (name, on) in list {
        for component in ["x", "y"] {
            for (method, ending) in [("residual", ""), ("surface-integral", "_surface")] {
                text += &format!(
                    "[functional.{name}_{component}{ending}]\nkind = \"force\"\non = {on:?}\n\
                     component = \"{component}\"\nmethod = \"{method}\"\n"
                );
            }
        }
    }
    text
}

/// The channel whose bottom has another name from x = `split` on, its lines moved by `bend`.
fn channel(place: &Place, triangles: bool, split: f64, bend: impl Fn([f64; 2]) -> [f64; 2]) {
    let mut mesh: Mesh<2> = rectangle([0.0, 0.0], [4.0, 1.0], [8, 2], 0).unwrap();
    if triangles {
        mesh = mesh.triangulated();
    }
    let (bottom, end) = (mesh.boundary("bottom").unwrap(), mesh.boundaries.len() as u16);
    mesh.boundaries.push("bottom-end".into());
    for n in 0..mesh.facets.len() {
        let facet = mesh.facets[n];
        let nodes = mesh.facet_nodes(facet.cell as usize, facet.local as usize);
        if facet.boundary == bottom && nodes.iter().all(|&node| mesh.nodes[node as usize][0] > split - 1e-9) {
            mesh.facets[n].boundary = end;
        }
    }
    mesh.nodes.iter_mut().for_each(|x| *x = bend(*x));
    fs::write(place.file("channel.msh"), gmsh::write(&mesh)).unwrap();
}

#[test]
fn poiseuille_forces_are_exact_on_every_mesh() {
    let place = place("poiseuille", &["wall-force/poiseuille.toml"]);
    let elements = ["Q2", "Q3", "Q4", "P2", "P3", "P2-bubble"];
    for (element, refine) in elements.iter().flat_map(|e| [(e, 0), (e, 1)]) {
        let sets = [format!("space.velocity={element}"), format!("mesh.refine={refine}")];
        let sets: Vec<&str> = sets.iter().map(String::as_str).chain(["newton.tolerance=1e-12"]).collect();
        undula(&place, "run poiseuille.toml --threads 1 -o out --force --quiet", &sets).expect(0, &[]);
        for ending in ["", "_surface"] {
            for (name, right) in [("fx", 1.6), ("fy", -6.4), ("fin", -3.2)] {
                close(last(&place, "out", &format!("{name}{ending}")), right, 1e-9);
            }
        }
    }
}

/// The first metre of the bottom bears 0.4 and −2.8 N/m; the outflow, where ∇v n = 0, ρν ∂_y v_x in its mean.
#[test]
fn a_wall_of_two_names_is_split_exactly() {
    let place = place("split", &[]);
    let list: [(&str, &[&str]); 6] = [
        ("start", &["bottom"]),
        ("end", &["bottom-end"]),
        ("floor", &["bottom", "bottom-end"]),
        ("in", &["left"]),
        ("out", &["right"]),
        ("top", &["top"]),
    ];
    place.write("split.toml", &format!("{FLOW}{}", forces(&list)));
    let right = [
        ("start_x", 0.4),
        ("start_y", -2.8),
        ("end_x", 1.2),
        ("end_y", -3.6),
        ("floor_x", 1.6),
        ("floor_y", -6.4),
        ("in_x", -3.2),
        ("top_x", 1.6),
        ("top_y", 6.4),
    ];
    for (element, triangles) in [("Q2", false), ("P2", true), ("Q3", false)] {
        channel(&place, triangles, 1.0, |x| x);
        let element = format!("space.velocity={element}");
        let sets = [element.as_str(), "newton.tolerance=1e-12"];
        undula(&place, "run split.toml --threads 1 -o out --force --quiet", &sets).expect(0, &[]);
        for (name, right) in right {
            close(last(&place, "out", name), right, 1e-9);
            close(last(&place, "out", &format!("{name}_surface")), right, 1e-9);
        }
        let of = |name: &str| last(&place, "out", name);
        assert!(of("out_x").abs() < 1e-10 && of("out_y").abs() < 1e-10, "{} {}", of("out_x"), of("out_y"));
        // All that the fluid exerts: what flows out has the momentum that has flown in.
        let all: f64 = ["floor_x", "in_x", "out_x", "top_x"].map(of).iter().sum();
        assert!(all.abs() < 1e-9, "{all:e}");
    }
}

/// On bent cells, where nothing is exact: parts add up, and come closer as fast as the surface integral at least.
#[test]
fn parts_of_a_wall_converge() {
    let place = place("parts", &[]);
    let list: [(&str, &[&str]); 3] =
        [("start", &["bottom"]), ("end", &["bottom-end"]), ("floor", &["bottom", "bottom-end"])];
    place.write("parts.toml", &format!("{FLOW}{}", forces(&list)));
    // The narrow middle accelerates the flow.
    let bend = |[x, y]: [f64; 2]| [x, y * (1.0 - 0.3 * (x * (4.0 - x) / 4.0).powi(2))];
    for (element, triangles) in [("Q2", false), ("P2", true)] {
        channel(&place, triangles, 1.0, bend);
        let element = format!("space.velocity={element}");
        let mut values = vec![];
        for refine in 0..4 {
            let refine = format!("mesh.refine={refine}");
            let sets = [element.as_str(), refine.as_str(), "newton.tolerance=1e-11"];
            undula(&place, "run parts.toml --threads 1 -o out --force --quiet", &sets).expect(0, &[]);
            let of = |name: &str| last(&place, "out", name);
            for axis in ["x", "y"] {
                let [start, end, floor] = ["start", "end", "floor"].map(|n| of(&format!("{n}_{axis}")));
                close(start + end, floor, 1e-12);
            }
            let names = ["start_x", "start_y", "end_x", "end_y"];
            values.push(names.map(|n| [of(n), of(&format!("{n}_surface"))]));
        }
        // By the residual on the finest mesh the error is far below that of the surface integral on all. One force may
        // pass through its value on the way, so that the largest of the four errors counts.
        let error = |refine: usize, method: usize| {
            let of = |n: usize| (values[refine][n][method] - values[3][n][0]).abs();
            (0..4).map(of).fold(0.0, f64::max)
        };
        let [residual, surface] = [0, 1].map(|method| [0, 1, 2].map(|refine| error(refine, method)));
        println!("{element}: residual {residual:?}, surface {surface:?}");
        // Of order 3 with P2 and above with Q2; the surface integral has 2.
        assert!(residual[0] / residual[2] > 64.0 && residual[2] < surface[2] / 8.0, "{element}");
    }
}

/// Cylinder and beam of the benchmark, stationary.
#[test]
fn beam_and_cylinder_make_the_whole() {
    let place = place("beam", &[]);
    let parts = |component: &str| {
        [("beam", "interface"), ("cylinder", "cylinder")].map(|(name, on)| {
            format!(
                "functional.{name}_{component}={{kind=\"force\", on=[\"{on}\"], component=\"{component}\"}}"
            )
        })
    };
    let sets = [parts("x"), parts("y")].concat();
    let sets: Vec<&str> = sets.iter().map(String::as_str).chain(["newton.tolerance=1e-11"]).collect();
    undula(&place, "run fsi1 --threads 1 -o out --quiet", &sets).expect(0, &[]);
    let of = |name: &str| last(&place, "out", name);
    close(of("beam_x") + of("cylinder_x"), of("drag"), 1e-12);
    close(of("beam_y") + of("cylinder_y"), of("lift"), 1e-12);
    // 2.597 on fine meshes.
    close(of("beam_x"), 2.597, 4e-3);
}

/// A moving beam, all schemes: at every step the parts make the whole.
#[test]
fn parts_add_up_at_every_step_of_every_scheme() {
    let place = place("schemes", &[]);
    let part = |name: &str, on: &str| {
        format!("functional.{name}={{kind=\"force\", on=[\"{on}\"], component=\"y\"}}")
    };
    let (beam, cylinder) = (part("beam", "interface"), part("round", "cylinder"));
    let schemes = ["backward-euler", "crank-nicolson", "bdf2", "fractional-step-theta", "cg1"];
    for scheme in schemes {
        let scheme = format!("time.scheme={scheme}");
        let sets = [
            "mesh.refine=0",
            "time.step=0.01",
            "time.end=0.04",
            "time.shift=none",
            "solid.body-force=[0,-2]",
            &scheme,
            &beam,
            &cylinder,
        ];
        undula(&place, "run fsi3 --threads 1 -o out --force --quiet", &sets).expect(0, &[]);
        let columns = history(&place.file("out/history.csv"), &["beam", "round", "lift"]);
        assert_eq!(columns.len(), 4);
        for [beam, round, lift] in columns {
            let size = beam.abs().max(round.abs());
            assert!(
                size > 1e-3 && (beam + round - lift).abs() < 1e-12 * size,
                "{scheme}: {beam} {round} {lift}"
            );
        }
    }
}

/// Rows of a history with the given columns.
fn history<const N: usize>(path: &Path, names: &[&str; N]) -> Vec<[f64; N]> {
    let history = undula::output::History::read(path).unwrap();
    let columns = names.map(|name| history.column(name).unwrap());
    (0..history.rows.len()).map(|row| std::array::from_fn(|n| columns[n][row])).collect()
}
