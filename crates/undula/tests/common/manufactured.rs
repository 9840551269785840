//! Meshes and problems shared by the verification tests.
#![allow(dead_code)]

use std::sync::Arc;
use undula::element::Shape;
use undula::mesh::Mesh;
use undula::mesh::generate::rectangle;
use undula::physics::{Extension, Fluid, Material, Solid};
use undula::space::{Against, BoundaryCondition, FsiSpace, PressureKind, Region};
use undula::system::{Options, Physics};
use undula::verification::manufactured::{Exact, InTime, Manufactured};
pub use undula::verification::unit_square::{bubble, smooth, velocity};

/// Gauss points per direction in the solver.
pub const QUADRATURE: usize = 3;

pub const FLUID: Fluid = Fluid { rho: 1.3, nu: 0.4, thinning: None, extension: Extension::Harmonic };
pub const AUXETIC: Fluid =
    Fluid { rho: 1.3, nu: 0.4, thinning: None, extension: Extension::PseudoElastic { poisson: -0.2 } };
/// One of each kind.
pub const EXTENSIONS: [Extension; 6] = [
    Extension::Harmonic,
    Extension::PseudoElastic { poisson: -0.2 },
    Extension::JacobianStiffened { poisson: 0.1, lagged: true },
    Extension::JacobianStiffened { poisson: 0.1, lagged: false },
    Extension::Biharmonic { hinged: false },
    Extension::Biharmonic { hinged: true },
];
pub const SOLID: Solid = Solid::elastic(2.1, Material::StVenantKirchhoff { mu: 3.0, lambda: 4.0 });

pub const FSI: Physics = Physics::new(Some(AUXETIC), Some(SOLID));
pub const FLOW: Physics = Physics::new(Some(FLUID), None);
pub const BODY: Physics = Physics::new(None, Some(SOLID));

/// How the cells of the unit square are bent.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Cells {
    /// Equal squares.
    Square,
    /// Trapezia that stay trapezia under refinement.
    Trapezia,
    /// The same bent smoothly inside: no side is straight.
    Curved,
}

/// Where the solid is.
#[derive(Copy, Clone, PartialEq)]
pub enum Body {
    /// A block in the middle, surrounded by fluid: (¼, ¾)².
    Inclusion,
    /// A block on the lower wall: (¼, ¾) × (0, ½).
    Block,
    /// All but a hole (¼, ¾)² that is full of fluid.
    Frame,
    /// The lower half: neither part has a corner that points inwards, so that dual problems are regular.
    Half,
}

/// The unit square in `n` × `n` cells with a solid body and its interface; `n` a multiple of 4.
pub fn square(n: usize, cells: Cells, body: Body) -> Mesh<2> {
    let mut mesh = rectangle([0.0; 2], [1.0; 2], [n, n], 0).unwrap();
    let inside = |x: [f64; 2]| match body {
        Body::Inclusion => 0.25 - (x[0] - 0.5).abs().max((x[1] - 0.5).abs()),
        Body::Frame => (x[0] - 0.5).abs().max((x[1] - 0.5).abs()) - 0.25,
        Body::Half => 0.5 - x[1],
        Body::Block => (0.25 - (x[0] - 0.5).abs()).min(0.5 - x[1]),
    };
    mesh.assign_region("solid", inside).unwrap();
    mesh.mark_interface("fluid", "solid").unwrap();
    let (right, solid) = (mesh.boundary("right").unwrap(), mesh.region("solid").unwrap());
    mesh.boundaries.push("clamp".into());
    for facet in &mut mesh.facets {
        if facet.boundary == right && mesh.cell_region[facet.cell as usize] == solid {
            facet.boundary = mesh.boundaries.len() as u16 - 1;
        }
    }
    bend(&mut mesh, n, cells);
    mesh
}

/// Move the nodes of an `n` × `n` mesh of the unit square.
pub fn bend(mesh: &mut Mesh<2>, n: usize, cells: Cells) {
    if cells == Cells::Square {
        return;
    }
    let h = 1.0 / n as f64;
    let vertex = |i: usize, j: usize| {
        let (x, y) = (i as f64 * h, j as f64 * h);
        let sign = |m: usize| if m.is_multiple_of(2) { 1.0 } else { -1.0 };
        let inner = |m: usize| if m == 0 || m == n { 0.0 } else { 1.0 };
        [x + 0.15 * h * sign(j) * inner(i), y + 0.2 * h * sign(i) * inner(j)]
    };
    for x in &mut mesh.nodes {
        let [i, j] = x.map(|x| (2.0 * x / h).round() as usize);
        // Nodes between vertices stay between them: the cells are bilinear.
        let (i1, j1) = (i.div_ceil(2), j.div_ceil(2));
        let corners = [vertex(i / 2, j / 2), vertex(i1, j / 2), vertex(i / 2, j1), vertex(i1, j1)];
        *x = std::array::from_fn(|d| corners.iter().map(|c| 0.25 * c[d]).sum());
        if cells == Cells::Curved {
            let bump = (std::f64::consts::PI * x[0]).sin() * (std::f64::consts::PI * x[1]).sin();
            *x = [x[0] + 0.06 * bump, x[1] - 0.05 * bump];
        }
    }
}

/// Velocity and pressure.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Pair {
    pub cells: Shape,
    pub degree: usize,
    pub bubble: bool,
    pub pressure: PressureKind,
}

/// Q_k with a pressure.
pub const fn quadrilaterals(degree: usize, pressure: PressureKind) -> Pair {
    Pair { cells: Shape::Quadrilateral, degree, bubble: false, pressure }
}

/// P_k with a pressure.
pub const fn triangles(degree: usize, pressure: PressureKind) -> Pair {
    Pair { cells: Shape::Triangle, degree, bubble: false, pressure }
}

/// P2-bubble with P1dc.
pub const BUBBLE: Pair = Pair { bubble: true, ..triangles(2, PressureKind::Pdc(1)) };

impl Pair {
    /// The number of the quadrature rule that a case takes.
    pub fn quadrature(self) -> usize {
        self.degree + 1 + usize::from(self.bubble)
    }

    /// Spaces on those regions of `mesh` whose equations there are, in triangles if need be.
    pub fn space(self, mesh: &Mesh<2>, physics: &Physics) -> Arc<FsiSpace<2>> {
        match self.cells {
            Shape::Triangle => spaces(&mesh.triangulated(), physics, self),
            _ => spaces(mesh, physics, self),
        }
    }
}

/// Spaces of degree `degree` for v and u on those regions of `mesh` whose equations there are.
pub fn space(mesh: &Mesh<2>, physics: &Physics, degree: usize, pressure: PressureKind) -> Arc<FsiSpace<2>> {
    spaces(mesh, physics, quadrilaterals(degree, pressure))
}

fn spaces(mesh: &Mesh<2>, physics: &Physics, pair: Pair) -> Arc<FsiSpace<2>> {
    let mut keep = vec![];
    if physics.fluid.is_some() {
        keep.push("fluid");
    }
    if physics.solid.is_some() {
        keep.push("solid");
    }
    let mesh = mesh.restrict(&keep);
    let solid = mesh.region("solid");
    let region = |&r: &u16| if Some(r) == solid { Region::Solid } else { Region::Fluid };
    let regions = mesh.cell_region.iter().map(region).collect();
    let own = physics.solid.is_some_and(|s| s.material.compliance().is_some());
    let bodies = if own { &[Region::Fluid, Region::Solid][..] } else { &[Region::Fluid] };
    Arc::new(match pair.bubble {
        true => FsiSpace::with_bubbles(mesh, regions, pair.degree, pair.pressure),
        false => FsiSpace::with_pressure_in(mesh, regions, pair.degree, pair.pressure, bodies),
    })
}

/// `exact` on `mesh` with v and u of degree 2: its velocity given on all walls but the right one, which is a
/// do-nothing outflow.
pub fn problem(
    mesh: &Mesh<2>,
    physics: Physics,
    pressure: PressureKind,
    exact: Exact,
    in_time: InTime,
    quadrature: usize,
) -> Manufactured {
    problem_in(space(mesh, &physics, 2, pressure), physics, exact, in_time, quadrature)
}

/// The same in other spaces.
pub fn problem_in(
    space: Arc<FsiSpace<2>>,
    physics: Physics,
    exact: Exact,
    in_time: InTime,
    quadrature: usize,
) -> Manufactured {
    let coupled = physics.fluid.is_some() && physics.solid.is_some();
    let condition = |name: &String| match name.as_str() {
        "interface" if coupled || physics.fluid.is_none() => BoundaryCondition::Free,
        "right" if physics.fluid.is_some() => {
            BoundaryCondition::Outflow { do_nothing: true, backflow: Against::None }
        }
        _ => BoundaryCondition::Velocity(velocity(&exact)),
    };
    let conditions = space.mesh.boundaries.iter().map(condition).collect();
    Manufactured { space, physics, conditions, exact, in_time, fluid: true, quadrature }
}

/// The same with a traction-free outflow.
pub fn traction_free(mut problem: Manufactured) -> Manufactured {
    for condition in &mut problem.conditions {
        if let BoundaryCondition::Outflow { do_nothing, .. } = condition {
            *do_nothing = false;
        }
    }
    problem
}

/// One thread, the widest lanes, [`QUADRATURE`].
pub fn options() -> Options {
    Options::serial(QUADRATURE)
}

/// Deterministic random numbers in (−½, ½) (xorshift).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}
