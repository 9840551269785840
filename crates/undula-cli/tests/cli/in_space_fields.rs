//! Fields in space: those of the plane, and a flow with a closed form.

use super::Place;
use super::in_space::{FLAP, TIGHT, TWO_LAYERS};
use std::f64::consts::PI;
use undula::output::{Field, read_vtu};

#[test]
fn fields_of_an_extruded_plane_are_those_of_the_plane() {
    let here = Place::new("space-fields");
    here.write("flap.toml", FLAP);
    let fields = "output.fields=[\"velocity\", \"displacement\", \"pressure\", \"stress\", \"von-mises\", \"strain\", \
                  \"jacobian\", \"vorticity\", \"wall-shear-stress\"]";
    let [plane, space] = [&[][..], &[TWO_LAYERS]].map(|own| {
        here.rows(
            "flap.toml",
            &[&TIGHT[..], &[fields, "output.mesh=reference", "time.end=0.01"], own].concat(),
        );
        read_vtu(here.file("out/fields/fields_000001.vtu")).unwrap().0
    });
    let near = |x: &[f64; 3], y: &[f64; 3]| (x[0] - y[0]).hypot(x[1] - y[1]) < 1e-9;
    let partner = |x| plane.points.iter().position(|y| near(x, y)).unwrap();
    let partners: Vec<usize> = space.points.iter().map(partner).collect();
    assert!(plane.point_data.len() > 9, "{}", plane.point_data.len());
    for field in &plane.point_data {
        let other = space.at_points(&field.name).unwrap();
        let of = |field: &Field, point: usize| {
            field.values[point * field.components..][..field.components].to_vec()
        };
        let size = field.values.iter().filter(|x| x.is_finite()).fold(0.0, |size: f64, x| size.max(x.abs()));
        for (point, &partner) in partners.iter().enumerate() {
            let (one, two) = (of(field, partner), of(other, point));
            // The curl of a plane flow points along z.
            let two = if one.len() == 1 { vec![two[two.len() - 1]] } else { two };
            let same = |(a, b): (&f64, &f64)| a.is_nan() && b.is_nan() || (a - b).abs() < 1e-9 * size;
            assert!(one.iter().zip(&two).all(same), "{}: {one:?} {two:?}", field.name);
        }
    }
}

/// v at the middle of a rectangle with the sides a and b by the mean of v, −Δw = 1 by Fourier series.
fn duct([a, b]: [f64; 2]) -> f64 {
    let (mut w, mut flow, mut sign) = (0.0, 0.0, 1.0);
    for n in (1..200).step_by(2) {
        let k = f64::from(n) * PI / a;
        w += sign * 4.0 / (a * k.powi(3)) * (1.0 - 1.0 / (k * b / 2.0).cosh());
        flow += 8.0 / (a * k.powi(4)) * (b - 2.0 / k * (k * b / 2.0).tanh());
        sign = -sign;
    }
    w * a * b / flow
}

#[test]
fn flow_through_a_rectangular_duct_has_the_profile_of_the_series() {
    let here = Place::new("space-duct");
    here.write(
        "duct.toml",
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0, 0]\nupper = [1, 1, 0.6]\ncells = [1, 4, 4]\n[fluid]\ndensity = 1\n\
         kinematic-viscosity = 0.1\n[boundary]\nleft = { condition = \"flux\", flow-rate = -0.6, profile = \"parabolic\" }\n\
         right = { condition = \"do-nothing\" }\ntop = { condition = \"no-slip\" }\nbottom = { condition = \"no-slip\" }\n\
         front = { condition = \"no-slip\" }\nback = { condition = \"no-slip\" }\n[functional]\n\
         v = { kind = \"velocity\", point = [0.5, 0.5, 0.3], component = \"x\" }\n\
         flow = { kind = \"flux\", on = [\"right\"] }\n",
    );
    let exact = duct([1.0, 0.6]);
    for (cells, bound) in [("mesh.cells=[1, 4, 4]", 6e-4), ("mesh.cells=[1, 8, 8]", 8e-5)] {
        let rows = here.rows("duct.toml", &[cells]);
        let (v, flow) = (rows[0]["v"], rows[0]["flow"]);
        assert!((v / exact - 1.0).abs() < bound && (flow - 0.6).abs() < 1e-12, "{v} {exact} {flow}");
    }
}
