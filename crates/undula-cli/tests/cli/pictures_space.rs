//! Pictures of a made-up run in three dimensions: a flap that bends in a channel, and a curved tube that swells. The
//! pictures stay in the scratch directory of the build, to be looked at.

use crate::Place;
use crate::args::{Plane, SurfaceField};
use crate::pictures::{decoded, fields, names, run, scratch};
use crate::sources::plot::{Views, plot_directory, plot_views};
use std::f64::consts::PI;
use undula::output::{CellKind, Field, FieldSnapshot, HistoryWriter, RunDirectory};

/// `n` hexahedra of degree 2 of the unit cube, `cells` of them, at places that `map` gives with their displacements.
fn hexahedra(
    n: [usize; 3],
    is_solid: impl Fn([usize; 3]) -> bool,
    map: impl Fn([f64; 3]) -> ([f64; 3], [f64; 3]),
) -> FieldSnapshot {
    let nodes = n.map(|n| 2 * n + 1);
    let of = |i: usize, n: [usize; 3]| [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])];
    let mut mesh = FieldSnapshot { kind: CellKind::Hexahedron, degree: 2, ..FieldSnapshot::default() };
    let mut u = vec![];
    for i in 0..nodes.iter().product() {
        let at = of(i, nodes);
        let (x, moved) = map([0, 1, 2].map(|d| at[d] as f64 / (nodes[d] - 1) as f64));
        mesh.points.push([0, 1, 2].map(|d| x[d] + moved[d]));
        u.extend(moved);
    }
    let mut solid = vec![];
    for cell in 0..n.iter().product() {
        let place = of(cell, n);
        solid.push(f64::from(u8::from(is_solid(place))));
        mesh.cells.extend((0..27).map(|i| {
            let at = of(i, [3; 3]);
            let [i, j, k] = [0, 1, 2].map(|d| 2 * place[d] + at[d]);
            (i + nodes[0] * (j + nodes[1] * k)) as u32
        }));
    }
    mesh.point_data.push(Field::new("deformation", 3, u));
    mesh.cell_data.push(Field::new("solid", 1, solid));
    mesh
}

/// A flap, 0.9 < x < 1 and y < 0.4 and 0.15 < z < 0.45, in a channel of 2.5 m by 0.8 m by 0.6 m.
fn flap() -> FieldSnapshot {
    let is_solid = |[i, j, k]: [usize; 3]| i == 9 && j < 4 && (1..3).contains(&k);
    let mut mesh = hexahedra([25, 8, 4], is_solid, |[r, s, t]| {
        let [x, y, z] = [2.5 * r, 0.8 * s, 0.6 * t];
        let near = (-(x - 0.95_f64).powi(2) / 0.3).exp() * (PI * t).sin() * x * (2.5 - x) / 1.5;
        let bent = if y < 0.4 { y * y } else { 0.16 * (0.8 - y) / 0.4 };
        ([x, y, z], [1.1 * bent * near, -0.9 * bent * bent * near, 0.0])
    });
    let flow = |&[x, y, z]: &[f64; 3]| {
        let wall = 16.0 * y * (0.8 - y) / 0.64 * z * (0.6 - z) / 0.36;
        let wake =
            1.0 - 0.8 * (-((x - 1.3) / 0.3).powi(2) - (y / 0.4).powi(4) - ((z - 0.3) / 0.2).powi(4)).exp();
        [wall * wake, 0.3 * wall * (1.0 - wake) * (x - 1.3), 0.0]
    };
    let pressure = |&[x, y, _]: &[f64; 3]| 40.0 * (2.5 - x) + 30.0 * (0.9 - x).tanh() * (1.0 - y);
    mesh.point_data.push(Field::new("velocity", 3, mesh.points.iter().flat_map(flow).collect()));
    mesh.point_data.push(Field::new("pressure", 1, mesh.points.iter().map(pressure).collect()));
    let stress = |&[_, y, z]: &[f64; 3]| 1e4 * (0.45 - y).max(0.0) * (1.0 + 0.3 * (z - 0.3).abs());
    mesh.point_data.push(Field::new("solid-von-mises", 1, mesh.points.iter().map(stress).collect()));
    mesh
}

/// A quarter of a bend of an elastic tube, without fluid.
fn bend() -> FieldSnapshot {
    hexahedra(
        [2, 16, 10],
        |_| true,
        |[r, s, t]| {
            let (angle, along) = (2.0 * PI * s, 0.5 * PI * t);
            let place = |radius: f64| {
                let out = 4.0 + radius * angle.cos();
                [out * along.cos(), radius * angle.sin(), out * along.sin()].map(|x| 1e-2 * x)
            };
            let radius = 1.0 + 0.2 * r;
            let (from, to) = (place(radius), place(radius + 0.25 * (PI * t).sin()));
            (from, [0, 1, 2].map(|d| to[d] - from[d]))
        },
    )
}

/// A run with these fields as its last.
fn of(name: &str, snapshot: &FieldSnapshot) -> RunDirectory {
    let run = run(&scratch(name), "flap", &[]);
    let columns: Vec<String> = ["step", "time"].map(String::from).to_vec();
    HistoryWriter::create(run.history(), &columns).unwrap().append(&[1.0, 0.5]).unwrap();
    fields(&run, 1, 0.5, snapshot);
    run
}

/// Part of the pixels of a picture that `is` so.
fn part(path: &std::path::Path, is: impl Fn(&[u8; 3]) -> bool) -> f64 {
    let (width, height, pixels) = decoded(path);
    pixels.as_chunks::<3>().0.iter().filter(|p| is(p)).count() as f64 / (width * height) as f64
}

#[test]
#[ignore = "long"]
fn a_flap_in_space_is_cut_and_its_surface_is_seen() {
    let run = of("plot-flap-pieces", &flap().linear());
    let written = plot_directory(run.path(), None).unwrap();
    assert_eq!(names(&written), ["speed.png", "pressure.png", "surface-displacement.png"]);
    // Bright yellow and dark violet of viridis, and grey of the body.
    assert!(part(&written[0], |p| p[0] > 200 && p[1] > 200 && p[2] < 90) > 0.01);
    assert!(part(&written[0], |p| p[0] < 75 && p[1] < 20 && p[2] > 70) > 0.001);
    assert!(part(&written[1], |p| *p == [205; 3]) > 0.01);
}

#[test]
#[ignore = "long"]
fn curved_cells_are_cut_where_it_is_asked_for() {
    let run = of("plot-flap", &flap());
    let plane = Plane { axis: 0, at: Some(0.97) };
    let views = Views { cuts: vec![plane], surfaces: vec![SurfaceField::Pressure] };
    let written = plot_views(run.path(), None, &views).unwrap();
    assert_eq!(names(&written), ["speed-x=0.97.png", "pressure-x=0.97.png", "surface-pressure.png"]);
    assert!(part(&written[1], |p| *p == [205; 3]) > 0.01);
    // The bottom of the flap is the wall: no fluid, no value.
    assert!(part(&written[2], |p| p[0] > 150 && p[1] < 130) > 0.01);
}

#[test]
fn a_bent_tube_of_two_centimetres() {
    let run = of("plot-bend", &bend().linear());
    let written = plot_directory(run.path(), None).unwrap();
    assert_eq!(names(&written), ["deformation.png", "surface-displacement.png"]);
    // The middle swells most; there is no white but around the tube.
    assert!(part(&written[1], |p| p[1] > 150 && p[2] < 130) > 0.02);
}

#[test]
fn pictures_that_cannot_be_drawn_say_what_to_do() {
    let here = Place::new("plot-space");
    let run = run(&here.file("space"), "flap", &[]);
    here.run("plot space --cut z", &[]).expect(2, &["space has no field files"]);
    fields(&run, 1, 0.5, &bend());
    let wrong = [
        ("--cut w=1", "`w` is no coordinate: expected x, y or z, such as x=0.2"),
        ("--cut x=wide", "`wide` is no number: expected a place in m, such as x=0.2"),
        ("--cut x=inf", "`inf` is no number"),
        (
            "--cut y=0.1",
            "--cut y=0.1: the plane is outside of the domain; the domain reaches from y = -0.0145",
        ),
        ("--surface=drag", "[possible values: displacement, stress, pressure]"),
        (
            "--surface=stress",
            "no `solid-von-mises`: add \"von-mises\" to output.fields and run the case again",
        ),
    ];
    for (arguments, message) in wrong {
        here.run(&format!("plot space {arguments}"), &[]).expect(2, &[message]);
    }
    here.run("plot space --surface=stress", &[]).expect(2, &["ParaView shows all of", ".vtu"]);
    assert!(!here.file("space/plots").exists());
    here.run("plot space --surface --cut z=0.02", &[])
        .expect(0, &["plots/deformation-z=0.02.png", "plots/surface-displacement.png"]);
}

#[test]
fn plane_fields_are_not_cut() {
    let here = Place::new("plot-plane");
    let run = run(&here.file("plane"), "box", &[]);
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let pressure = vec![Field::new("pressure", 1, vec![0.0, 1.0, 2.0, 3.0])];
    let plane = FieldSnapshot {
        degree: 1,
        points,
        cells: vec![0, 1, 2, 3],
        point_data: pressure,
        ..Default::default()
    };
    fields(&run, 1, 0.5, &plane);
    here.run("plot plane --cut z=0", &[]).expect(
        0,
        &["note: --cut and --surface have no effect: the run is one of two dimensions", "pressure.png"],
    );
}
