//! Meshes and problems shared by the verification tests.
#![allow(dead_code)]

use std::sync::Arc;
use undula::element::Shape;
use undula::mesh::Mesh;
use undula::mesh::generate::rectangle;
use undula::physics::{Extension, Fluid, Material, Solid, StepRule};
use undula::space::{Against, BoundaryCondition, FsiSpace, PressureKind, Region, State};
use undula::system::{Assembler, Options, Physics, StepView};
use undula::verification::manufactured::{Exact, InTime, Manufactured, Values, number};
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

/// The unit cube in `n` × `n` × `n` cells, the solid as in [`square`] at all z.
pub fn cube(n: usize, cells: Cells, body: Body) -> Mesh<3> {
    let mut mesh = square(n, Cells::Square, body).extruded(1.0, n).unwrap();
    bend(&mut mesh, n, cells);
    mesh
}

/// Move the nodes of a mesh of the unit square or cube with `n` cells per direction.
pub fn bend<const D: usize>(mesh: &mut Mesh<D>, n: usize, cells: Cells) {
    if cells == Cells::Square {
        return;
    }
    let h = 1.0 / n as f64;
    let vertex = |at: [usize; D]| -> [f64; D] {
        let sum: usize = at.iter().sum();
        std::array::from_fn(|d| {
            let sign = if (sum - at[d]).is_multiple_of(2) { 1.0 } else { -1.0 };
            let inner = if at[d] == 0 || at[d] == n { 0.0 } else { 1.0 };
            at[d] as f64 * h + [0.15, 0.2, 0.18][d] * h * sign * inner
        })
    };
    for x in &mut mesh.nodes {
        let at = x.map(|x| (2.0 * x / h).round() as usize);
        // Nodes between vertices stay between them: the cells are bilinear or trilinear.
        let corner = |i: usize| -> [usize; D] {
            std::array::from_fn(|d| if i >> d & 1 == 0 { at[d] / 2 } else { at[d].div_ceil(2) })
        };
        let corners: Vec<[f64; D]> = (0..1 << D).map(|i| vertex(corner(i))).collect();
        *x = std::array::from_fn(|d| corners.iter().map(|c| c[d]).sum::<f64>() / corners.len() as f64);
        if cells == Cells::Curved {
            let bump: f64 = x.iter().map(|x| (std::f64::consts::PI * x).sin()).product();
            *x = std::array::from_fn(|d| x[d] + [0.06, -0.05, 0.04][d] * bump);
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

/// P_k of tetrahedra with a pressure.
pub const fn tetrahedra(degree: usize, pressure: PressureKind) -> Pair {
    Pair { cells: Shape::Tetrahedron, degree, bubble: false, pressure }
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

    /// The same on hexahedra, in tetrahedra if need be.
    pub fn in_space(self, mesh: &Mesh<3>, physics: &Physics) -> Arc<FsiSpace<3>> {
        match self.cells {
            Shape::Tetrahedron => spaces(&mesh.in_tetrahedra(), physics, self),
            _ => spaces(mesh, physics, self),
        }
    }
}

/// Spaces of degree `degree` for v and u on those regions of `mesh` whose equations there are.
pub fn space(mesh: &Mesh<2>, physics: &Physics, degree: usize, pressure: PressureKind) -> Arc<FsiSpace<2>> {
    spaces(mesh, physics, quadrilaterals(degree, pressure))
}

fn spaces<const D: usize>(mesh: &Mesh<D>, physics: &Physics, pair: Pair) -> Arc<FsiSpace<D>> {
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
pub fn problem_in<const D: usize>(
    space: Arc<FsiSpace<D>>,
    physics: Physics,
    exact: Exact<D>,
    in_time: InTime,
    quadrature: usize,
) -> Manufactured<D> {
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

/// Fields that are zero.
pub fn nothing<const D: usize>() -> Exact<D> {
    let zero = number(0.0);
    Arc::new(move |_, _| Values { v: [zero; D], u: [zero; D], p: zero })
}

/// At every node `f(x)`; nothing of bubbles.
pub fn nodal<const D: usize>(space: &FsiSpace<D>, f: impl Fn([f64; D]) -> [f64; D]) -> Vec<f64> {
    let nodes = &space.nodes;
    let of = |(node, x): (usize, &[f64; D])| if node < nodes.n_lagrange { f(*x) } else { [0.0; D] };
    nodes.points.iter().enumerate().flat_map(of).collect()
}

/// v = `v` at every node, u random, p = `p`.
pub fn state<const D: usize>(space: &FsiSpace<D>, seed: u64, v: [f64; D], p: f64) -> State {
    let mut random = Random(seed);
    let mut state = State::zero(space.n_v(), space.n_u(), space.n_p());
    // Beside the nodal basis bubbles add nothing to a constant, and there are none for u.
    let nodal = D * space.nodes.n_lagrange;
    state.v[..nodal].chunks_exact_mut(D).for_each(|x| x.copy_from_slice(&v));
    state.u.iter_mut().take(nodal).for_each(|u| *u = 0.02 * random.next());
    let constant = |dof: usize| match space.pressure.kind {
        PressureKind::Pdc(_) if !dof.is_multiple_of(space.pressure.per_cell) => 0.0,
        _ => p,
    };
    state.p = (0..space.n_p()).map(constant).collect();
    state
}

/// The residual of one region in a step.
pub fn region<const D: usize>(
    assembler: &mut Assembler<D>,
    region: Region,
    rule: StepRule,
    new: &State,
    old: &State,
) -> Vec<f64> {
    let mut out = vec![0.0; assembler.space.n_field_unknowns()];
    assembler.region_residual(&StepView { rule, new, old }, region, &mut out);
    out
}

/// The largest absolute value.
pub fn largest(x: impl IntoIterator<Item = f64>) -> f64 {
    x.into_iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Nodes on a named boundary or the interface.
pub fn on_boundaries<const D: usize>(space: &FsiSpace<D>) -> Vec<bool> {
    let mut on = vec![false; space.nodes.len()];
    for facet in &space.mesh.facets {
        space.facet_functions(facet).iter().for_each(|&(_, node)| on[node as usize] = true);
    }
    on
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
