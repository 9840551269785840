//! Scalars made of the solution at one point, and what is taken of them on a boundary or in a region.

use crate::choice::{Choice, choice};
use crate::math::{Tensor, Vector};
use crate::physics::kinematics::cofactor;
use crate::physics::stress::{principal, von_mises};
use crate::physics::{Fabric, Fields, Kinematics};
use crate::space::Region;
use crate::system::Physics;

/// Scalar made of a vector or of a stress.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Component {
    /// Component of a vector, from 0.
    Along(usize),
    /// Euclidean norm of a vector.
    Magnitude,
    /// Along t = (−n_y, n_x), n the normal that points out of the fluid.
    Tangential,
    /// σ_ij.
    Entry(usize, usize),
    /// √(3/2 s : s), s the deviator of σ.
    VonMises,
    /// The largest eigenvalue of σ in the plane.
    PrincipalMax,
    /// The smallest eigenvalue of σ in the plane.
    PrincipalMin,
}

/// Name of the equivalent stress, as a component and as a field.
pub const VON_MISES: &str = "von-mises";
/// Name of the wall shear stress, as a kind of functional and as a field.
pub const WALL_SHEAR_STRESS: &str = "wall-shear-stress";

/// Their names in a case; each kind of functional takes some that stand side by side.
pub static COMPONENTS: [Choice<Component>; 14] = [
    choice("x", Component::Along(0), "first component of a vector"),
    choice("y", Component::Along(1), "second component of a vector"),
    choice("z", Component::Along(2), "third component of a vector, in space"),
    choice("magnitude", Component::Magnitude, "Euclidean norm of a vector"),
    choice(
        "tangential",
        Component::Tangential,
        "wall shear stress along t = (−n_y, n_x), n out of the fluid",
    ),
    choice("xx", Component::Entry(0, 0), "normal stress along x"),
    choice("xy", Component::Entry(0, 1), "shear stress"),
    choice("xz", Component::Entry(0, 2), "shear stress, in space"),
    choice("yy", Component::Entry(1, 1), "normal stress along y"),
    choice("yz", Component::Entry(1, 2), "shear stress, in space"),
    choice("zz", Component::Entry(2, 2), "normal stress along z: across the plane; hoop stress around an axis"),
    choice(
        VON_MISES,
        Component::VonMises,
        "equivalent stress after von Mises, with the stress across the plane",
    ),
    choice(
        "principal-max",
        Component::PrincipalMax,
        "largest principal stress in the plane; around an axis and in space of all three",
    ),
    choice(
        "principal-min",
        Component::PrincipalMin,
        "smallest principal stress in the plane; around an axis and in space of all three",
    ),
];

impl Component {
    /// Whether vectors of `dim` components, and stresses beside them, have it.
    fn is_in(self, dim: usize) -> bool {
        match self {
            Component::Along(i) => i < dim,
            Component::Entry(i, j) => i == j || i.max(j) < dim,
            Component::Tangential => dim == 2,
            _ => true,
        }
    }

    fn those(dim: usize, here: impl Fn(Component) -> bool) -> Vec<Choice<Component>> {
        COMPONENTS.iter().filter(|row| row.value.is_in(dim) && here(row.value)).cloned().collect()
    }

    /// Components of a force or a displacement in `dim` dimensions.
    pub fn of_vector(dim: usize) -> Vec<Choice<Component>> {
        Self::those(dim, |component| matches!(component, Component::Along(_)))
    }

    /// Components of a velocity.
    pub fn of_velocity(dim: usize) -> Vec<Choice<Component>> {
        Self::those(dim, |component| matches!(component, Component::Along(_) | Component::Magnitude))
    }

    /// Components of a wall shear stress.
    pub fn of_shear(dim: usize) -> Vec<Choice<Component>> {
        let of_wall = |component| match component {
            Component::Along(_) => dim == 3,
            _ => matches!(component, Component::Magnitude | Component::Tangential),
        };
        Self::those(dim, of_wall)
    }

    /// Components of a stress.
    pub fn of_stress(dim: usize) -> Vec<Choice<Component>> {
        let of_vector = |component| {
            matches!(component, Component::Along(_) | Component::Magnitude | Component::Tangential)
        };
        Self::those(dim, |component| !of_vector(component))
    }

    fn of<const D: usize>(self, vector: Vector<f64, D>) -> f64 {
        match self {
            Component::Along(i) => vector.0[i],
            _ => vector.dot(vector).sqrt(),
        }
    }

    fn of_tensor<const D: usize>(self, sigma: &Tensor<f64, 3>) -> f64 {
        match self {
            Component::Entry(i, j) => sigma.0[i][j],
            Component::VonMises => von_mises(sigma),
            Component::PrincipalMin => principal::<D>(sigma)[0],
            _ => principal::<D>(sigma)[D - 1],
        }
    }
}

/// A scalar field.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// 1.
    One,
    /// p \[Pa\].
    Pressure,
    /// A component of v \[m/s\].
    Velocity(Component),
    /// v · n \[m/s\], n the current normal that points out of the fluid.
    NormalVelocity,
    /// A component of the Cauchy stress σ of the body that is there \[Pa\].
    Stress(Component),
    /// The tangential part of −σ n \[Pa\]: what the fluid exerts on the boundary along it.
    WallShear(Component),
}

/// What is taken of a field.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Take {
    /// Integral over the current boundary or region, divided by its size.
    Mean,
    /// Largest value at the nodes.
    Max,
    /// Smallest value at the nodes.
    Min,
    /// Integral over the current boundary or region.
    Integral,
}

/// Their names in a case.
pub static TAKES: [Choice<Take>; 4] = [
    choice("mean", Take::Mean, "integral divided by the current length or area"),
    choice("max", Take::Max, "largest value at the nodes of the velocity"),
    choice("min", Take::Min, "smallest value at the nodes of the velocity"),
    choice("integral", Take::Integral, "integral over the current boundary or region"),
];

impl Take {
    /// Whether it is a value at a node.
    pub fn is_extreme(self) -> bool {
        matches!(self, Take::Max | Take::Min)
    }
}

impl Quantity {
    /// Whether it belongs to the time t⁻ + θ k of the pressure.
    pub fn at_force_time(self) -> bool {
        matches!(self, Quantity::Pressure | Quantity::Stress(_))
    }

    /// SI unit of its integral over `d` directions; of its values for `d` = 0.
    pub fn unit(self, d: usize) -> &'static str {
        let units = match self {
            Quantity::One => ["", "m", "m²", "m³"],
            Quantity::Velocity(_) | Quantity::NormalVelocity => ["m/s", "m²/s", "m³/s", "m⁴/s"],
            Quantity::Pressure | Quantity::Stress(_) | Quantity::WallShear(_) => ["Pa", "N/m", "N", "N m"],
        };
        units[d]
    }

    /// The value at a point of a boundary of the fluid with the reference normal `normal`, and |J F⁻ᵀ n|.
    pub fn on_facet<const D: usize>(
        self,
        physics: &Physics,
        fields: &Fields<f64, D>,
        normal: Vector<f64, D>,
    ) -> (f64, f64) {
        let area = cofactor(&fields.grad_u) * normal;
        let stretch = area.dot(area).sqrt();
        (self.at(physics, Region::Fluid, (&Fabric::plain(), fields), Some(area * (1.0 / stretch))), stretch)
    }

    /// The value inside of `region`, and J.
    pub fn inside<const D: usize>(
        self,
        physics: &Physics,
        region: Region,
        (fabric, fields): (&Fabric<f64, D>, &Fields<f64, D>),
    ) -> (f64, f64) {
        (self.at(physics, region, (fabric, fields), None), (Tensor::identity() + fields.grad_u).det())
    }

    /// The value at a point of `region`, by the equations of its material; 0 of a body that is not there. `normal` is the current normal that points out
    /// of the fluid; without it what needs one is 0.
    pub fn at<const D: usize>(
        self,
        physics: &Physics,
        region: Region,
        (fabric, fields): (&Fabric<f64, D>, &Fields<f64, D>),
        normal: Option<Vector<f64, D>>,
    ) -> f64 {
        match self {
            Quantity::One => 1.0,
            Quantity::Pressure => fields.p,
            Quantity::Velocity(component) => component.of(fields.v),
            Quantity::NormalVelocity => normal.map_or(0.0, |n| fields.v.dot(n)),
            Quantity::Stress(component) => {
                let sigma = match region {
                    Region::Fluid => physics.fluid.map(|fluid| fluid.cauchy(fields)),
                    Region::Solid => physics.solid.map(|solid| solid.cauchy(fabric, fields)),
                };
                sigma.map_or(0.0, |sigma| component.of_tensor::<D>(&sigma))
            }
            Quantity::WallShear(component) => {
                normal.map_or(0.0, |n| component.of_shear_stress(&wall_shear(physics, fields, n), &n))
            }
        }
    }
}

impl Component {
    fn of_shear_stress<const D: usize>(self, tau: &Vector<f64, D>, n: &Vector<f64, D>) -> f64 {
        match self {
            // Along a wall in the plane, or in a section through an axis.
            Component::Tangential => n.0[0] * tau.0[1] - n.0[1] * tau.0[0],
            _ => self.of(*tau),
        }
    }
}

/// −(I − n ⊗ n) σ n \[Pa\]: what the fluid exerts along a boundary, `n` the current unit normal out of the fluid.
pub fn wall_shear<const D: usize>(
    physics: &Physics,
    fields: &Fields<f64, D>,
    n: Vector<f64, D>,
) -> Vector<f64, D> {
    let grad_v = fields.grad_v * Kinematics::of(&fields.grad_u).F_inv;
    let friction = physics.fluid.map_or(Tensor::zero(), |fluid| fluid.friction(grad_v, grad_v));
    let traction = friction * n;
    n * traction.dot(n) - traction
}
