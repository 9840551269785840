//! A mesh of one's own: an elastic flap in a channel, bent by the flow.
//!
//! `cargo run --release --features examples --example own_mesh`

use undula::{CaseBuilder, Error, Mesh, Row, Simulation};

// The channel is 3 m long and 1 m high; the flap stands on the bottom from x = 1 m to x = 1.25 m and is 0.5 m high.

fn region(x: [f64; 2]) -> &'static str {
    if x[0] > 1.0 && x[0] < 1.25 && x[1] < 0.5 { "solid" } else { "fluid" }
}

fn boundary(x: [f64; 2]) -> &'static str {
    match x[0] {
        0.0 => "inflow",
        3.0 => "outflow",
        along if x[1] == 0.0 && along > 1.0 && along < 1.25 => "foot",
        _ => "walls",
    }
}

/// The channel in squares whose sides are 1/`n` \[m\], `n` a multiple of 4.
pub fn channel(n: u32) -> Result<Mesh<2>, Error> {
    let (columns, rows) = (3 * n, n);
    let at = |i: u32, j: u32| [i, j].map(|m| f64::from(m) / f64::from(n));
    let nodes = (0..=rows).flat_map(|j| (0..=columns).map(move |i| at(i, j)));
    let node = |i: u32, j: u32| i + (columns + 1) * j;
    let square = |i: u32, j: u32| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
    let cells: Vec<[u32; 4]> = (0..rows).flat_map(|j| (0..columns).map(move |i| square(i, j))).collect();
    Ok(Mesh::from_cells(nodes.collect(), &cells, region, boundary)?)
}

/// The case without a mesh: a slow flow, stationary.
pub fn case() -> CaseBuilder {
    CaseBuilder::new("flap")
        .set("fluid.density", 1.0)
        .set("fluid.kinematic-viscosity", 0.1)
        .set("solid.density", 1.0)
        .set("solid.mu", 100.0)
        .set("solid.lambda", 200.0)
        .set("boundary.inflow.condition", "velocity")
        .set("boundary.inflow.velocity", ["4*y*(1 - y)", "0"])
        .set("boundary.outflow.condition", "do-nothing")
        .set("boundary.walls.condition", "no-slip")
        .set("boundary.foot.condition", "clamped")
        .set("functional.bend.kind", "displacement")
        .set("functional.bend.point", [1.125, 0.5])
        .set("functional.bend.component", "x")
        .set("functional.drag.kind", "force")
        .set("functional.drag.on", "interface")
        .set("functional.drag.component", "x")
}

/// Solves `case` with its mesh refined `refine` times.
pub fn solve(case: CaseBuilder, refine: u32) -> Result<Row, Error> {
    Simulation::new(case.set("mesh.refine", refine).build()?, 2)?.step()
}

fn main() -> Result<(), Error> {
    let row = solve(case().mesh(channel(8)?), 1)?;
    println!("the flap bends by {:.3} mm; drag {:.4} N/m", 1e3 * row["bend"], row["drag"]);
    Ok(())
}
