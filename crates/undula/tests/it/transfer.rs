//! A solution on the spaces of another mesh.

use undula::functional::transfer::transfer;
use undula::mesh::Mesh;
use undula::mesh::MeshError;
use undula::mesh::generate::rectangle;
use undula::sampling::for_each_point;
use undula::space::PressureKind::{self, Continuous, Pdc};
use undula::space::{FsiSpace, Region, State};

/// The square (0, 1)², solid where x < ½.
fn square(n: usize, triangles: bool) -> Mesh<2> {
    let mut mesh = rectangle([0.0; 2], [1.0; 2], [n, n], 0).unwrap();
    mesh.assign_region("solid", |x| 0.5 - x[0]).unwrap();
    mesh.mark_interface("fluid", "solid").unwrap();
    if triangles { mesh.triangulated() } else { mesh }
}

fn space(mesh: Mesh<2>, degree: usize, pressure: PressureKind, bubbles: bool) -> FsiSpace<2> {
    let solid = mesh.region("solid");
    let region = |&r: &u16| if Some(r) == solid { Region::Solid } else { Region::Fluid };
    let regions = mesh.cell_region.iter().map(region).collect();
    match bubbles {
        true => FsiSpace::with_bubbles(mesh, regions, degree, pressure),
        false => FsiSpace::new(mesh, regions, degree, pressure),
    }
}

/// v at the nodes, u = 2 v, and the pressure p projected, which is no more than a transfer from a fine space needs
/// here.
fn state(space: &FsiSpace<2>, v: impl Fn(&[f64; 2]) -> [f64; 2], p: impl Fn(&[f64; 2]) -> f64) -> State {
    let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
    for (node, x) in space.nodes.points.iter().enumerate().take(space.nodes.n_lagrange) {
        let value = v(x);
        for i in 0..2 {
            (state.v[2 * node + i], state.u[2 * node + i]) = (value[i], 2.0 * value[i]);
        }
    }
    assert!(matches!(space.pressure.kind, Continuous(_)), "nodal values");
    for (value, x) in state.p.iter_mut().zip(&space.pressure.points) {
        *value = p(x);
    }
    state
}

/// Largest errors of v, u and p at the quadrature points.
fn errors(
    space: &FsiSpace<2>,
    state: &State,
    v: impl Fn(&[f64; 2]) -> [f64; 2],
    p: impl Fn(&[f64; 2]) -> f64,
) -> [f64; 3] {
    let mut errors = [0.0f64; 3];
    for_each_point(space, state, 4, |point| {
        let exact = v(&point.x);
        for i in 0..2 {
            errors[0] = errors[0].max((point.fields.v.0[i] - exact[i]).abs());
            errors[1] = errors[1].max((point.fields.u.0[i] - 2.0 * exact[i]).abs());
        }
        if point.region == Region::Fluid {
            errors[2] = errors[2].max((point.fields.p - p(&point.x)).abs());
        }
    });
    errors
}

/// Polynomials of the degree of both spaces stay what they are, whatever the cells, and where the solid begins v and
/// u are those of the solid.
#[test]
fn polynomials_of_the_elements_are_kept() {
    let v = |x: &[f64; 2]| [1.0 + x[0] * x[0] - x[1], x[0] * x[1] + 0.5 * x[1] * x[1]];
    let p = |x: &[f64; 2]| 3.0 + 2.0 * x[0] - x[1];
    for from in
        [space(square(4, false), 2, Continuous(1), false), space(square(6, true), 2, Continuous(1), false)]
    {
        let old = state(&from, v, p);
        for to in [
            space(square(6, false), 2, Pdc(1), false),
            space(square(8, false), 3, Continuous(2), false),
            space(square(2, true), 2, Continuous(1), false),
            space(square(6, true), 2, Pdc(1), true),
        ] {
            let new = transfer(&from, &old, &to).unwrap();
            let found = errors(&to, &new, v, p);
            assert!(found.iter().all(|error| *error < 1e-10), "{found:?}");
            // And from a pressure with several values at a node.
            let back = transfer(&to, &new, &from).unwrap();
            let found = errors(&from, &back, v, p);
            assert!(found[0] < 1e-9 && found[1] < 1e-9 && found[2] < 1e-5, "{found:?}");
        }
    }
}

/// Smooth functions are kept to the order of the elements: 3 for v and u of degree 2, 2 for p of degree 1.
#[test]
fn smooth_functions_are_kept_to_the_order_of_the_elements() {
    let v = |x: &[f64; 2]| [(3.0 * x[0] + x[1]).sin(), (2.0 * x[1]).cos() * x[0]];
    let p = |x: &[f64; 2]| (2.0 * x[0] - x[1]).sin();
    let found = [8, 16].map(|n| {
        let from = space(square(n, false), 2, Continuous(1), false);
        let to = space(square(3 * n / 2, true), 2, Pdc(1), false);
        let new = transfer(&from, &state(&from, v, p), &to).unwrap();
        errors(&to, &new, v, p)
    });
    let orders: Vec<f64> = (0..3).map(|i| (found[0][i] / found[1][i]).log2()).collect();
    println!("{found:?}, orders {orders:.2?}");
    assert!(orders[0] > 2.7 && orders[1] > 2.7 && orders[2] > 1.7, "{orders:?}");
}

/// A point beyond the old mesh takes the value of its side if it is close, else it is named.
#[test]
fn points_outside_are_close_or_refused() {
    let (v, p) = (|x: &[f64; 2]| [x[0], x[1]], |_: &[f64; 2]| 1.0);
    let from = space(square(4, false), 2, Continuous(1), false);
    let old = state(&from, v, p);
    let stretched = |by: f64| {
        let mut mesh = square(4, false);
        mesh.nodes.iter_mut().for_each(|x| x[1] *= 1.0 + by);
        space(mesh, 2, Pdc(1), false)
    };
    let close = stretched(0.02);
    let new = transfer(&from, &old, &close).unwrap();
    assert!(errors(&close, &new, v, p)[0] < 0.021);
    match transfer(&from, &old, &stretched(0.2)) {
        Err(MeshError::Outside { point, .. }) => assert!(point[1] > 1.02, "{point:?}"),
        other => panic!("{other:?}"),
    }
}
