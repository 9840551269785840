//! Finite elements by name, and which pairs of velocity and pressure can be used.

use crate::choice::{Choice, choice, name_of};
use crate::element::Shape;

/// Space of velocity and deformation.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum VelocityElement {
    /// Continuous, of degree k in each coordinate of a quadrilateral or hexahedron.
    Q(usize),
    /// Continuous, of total degree k on triangles or tetrahedra.
    P(usize),
    /// P2, the velocity with a cubic bubble on every triangle of the fluid; on tetrahedra one on every face, and one of
    /// degree 4 inside.
    P2Bubble,
}

/// Space of the pressure.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PressureElement {
    /// Continuous, of degree k in each coordinate of a quadrilateral or hexahedron.
    Q(usize),
    /// Continuous, of total degree k on triangles or tetrahedra.
    P(usize),
    /// Discontinuous, of total degree k in the reference-domain coordinates of the cell.
    Pdc(usize),
}

/// Velocities by the names they have in a case.
pub static VELOCITIES: [Choice<VelocityElement>; 8] = [
    choice("Q1", VelocityElement::Q(1), "continuous, bilinear on quadrilaterals"),
    choice("Q2", VelocityElement::Q(2), "continuous, biquadratic on quadrilaterals"),
    choice("Q3", VelocityElement::Q(3), "continuous, bicubic on quadrilaterals"),
    choice("Q4", VelocityElement::Q(4), "continuous, of degree 4 in each coordinate of a quadrilateral"),
    choice("P1", VelocityElement::P(1), "continuous, linear on triangles or tetrahedra"),
    choice("P2", VelocityElement::P(2), "continuous, quadratic on triangles or tetrahedra"),
    choice("P3", VelocityElement::P(3), "continuous, cubic on triangles or tetrahedra"),
    choice(
        "P2-bubble",
        VelocityElement::P2Bubble,
        "P2 with bubbles on the fluid: triangles, or tetrahedra and their faces",
    ),
];

/// Pressures by the names they have in a case.
pub static PRESSURES: [Choice<PressureElement>; 10] = [
    choice("P0", PressureElement::Pdc(0), "discontinuous, constant on each cell"),
    choice("P1dc", PressureElement::Pdc(1), "discontinuous, linear on each cell"),
    choice("P2dc", PressureElement::Pdc(2), "discontinuous, quadratic on each cell"),
    choice("P3dc", PressureElement::Pdc(3), "discontinuous, cubic on each cell"),
    choice("Q1", PressureElement::Q(1), "continuous, bilinear on quadrilaterals"),
    choice("Q2", PressureElement::Q(2), "continuous, biquadratic on quadrilaterals"),
    choice("Q3", PressureElement::Q(3), "continuous, bicubic on quadrilaterals"),
    choice("Q4", PressureElement::Q(4), "continuous, of degree 4 in each coordinate of a quadrilateral"),
    choice("P1", PressureElement::P(1), "continuous, linear on triangles or tetrahedra"),
    choice("P2", PressureElement::P(2), "continuous, quadratic on triangles or tetrahedra"),
];

/// What is known of the inf-sup condition (5.24) of a pair.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stability {
    /// It holds with a constant that does not depend on the mesh.
    Stable,
    /// Velocity and pressure are continuous and of equal order: it fails, and stabilisation is needed.
    Equal,
    /// The pair is of no use, and why.
    Refused(String),
}

impl VelocityElement {
    /// Name in a case.
    pub fn name(self) -> &'static str {
        name_of(&VELOCITIES, &self)
    }

    /// Polynomial degree k, bubbles aside.
    pub fn degree(self) -> usize {
        match self {
            VelocityElement::Q(k) | VelocityElement::P(k) => k,
            VelocityElement::P2Bubble => 2,
        }
    }

    /// Whether the cells are simplices.
    pub fn is_simplicial(self) -> bool {
        !matches!(self, VelocityElement::Q(_))
    }

    /// Shape of the cells in `dim` dimensions.
    pub fn shape(self, dim: usize) -> Shape {
        match (self.is_simplicial(), dim) {
            (false, 3) => Shape::Hexahedron,
            (false, _) => Shape::Quadrilateral,
            (true, 3) => Shape::Tetrahedron,
            (true, _) => Shape::Triangle,
        }
    }

    /// The pressure that goes with it unless one is asked for: discontinuous P_{k−1} with Q_k and bubbles, continuous
    /// P_{k−1} with P_k, of equal order for k = 1.
    pub fn pressure(self) -> PressureElement {
        match self {
            VelocityElement::Q(1) => PressureElement::Q(1),
            VelocityElement::Q(k) => PressureElement::Pdc(k - 1),
            VelocityElement::P(1) => PressureElement::P(1),
            VelocityElement::P(k) => PressureElement::P(k - 1),
            VelocityElement::P2Bubble => PressureElement::Pdc(1),
        }
    }

    /// Number of the quadrature rule unless one is asked for: mass matrices, and products of two gradients with a
    /// field on affine cells, are then exact.
    pub fn quadrature(self) -> usize {
        match self {
            VelocityElement::P2Bubble => 4,
            _ => self.degree() + 1,
        }
    }

    /// Whether it makes a useful pair with `pressure` in `dim` dimensions: on tetrahedra some do not that do on triangles,
    /// for want of functions on the faces (P2) and inside (P3).
    pub fn stability_in(self, dim: usize, pressure: PressureElement) -> Stability {
        match (self, pressure) {
            (VelocityElement::P(k @ (2 | 3)), PressureElement::Pdc(m))
                if dim == 3 && (m, k) == (k - 2, k) =>
            {
                Stability::Refused(format!(
                    "is not stable with the velocity {} on tetrahedra: take P2-bubble with it, or {} with {}",
                    self.name(),
                    self.name(),
                    self.pressure().name()
                ))
            }
            _ => self.stability(pressure),
        }
    }

    /// Whether it makes a useful pair with `pressure` in the plane.
    pub fn stability(self, pressure: PressureElement) -> Stability {
        use PressureElement::{P, Pdc, Q};
        use VelocityElement as V;
        let too_many = || {
            Stability::Refused(format!(
                "has too many unknowns for the velocity {} (inf-sup condition (5.24)); {} goes with it",
                self.name(),
                self.pressure().name(),
            ))
        };
        match (self, pressure) {
            (V::Q(_), P(_)) | (V::P(_) | V::P2Bubble, Q(_)) => Stability::Refused(format!(
                "lives on other cells than the velocity {}, which needs {}; {} goes with it",
                self.name(),
                if self.is_simplicial() { "triangles or tetrahedra" } else { "quadrilaterals or hexahedra" },
                self.pressure().name()
            )),
            (V::Q(k), Q(m)) | (V::P(k), P(m)) if m < k => Stability::Stable,
            (V::Q(k), Q(m)) | (V::P(k), P(m)) if m == k => Stability::Equal,
            (V::Q(1) | V::P(1), Pdc(0)) => Stability::Refused(format!(
                "is not stable with the velocity {0} (checkerboards, locking): take the degree 2, or {0} with a stabilised {0}",
                self.name()
            )),
            (V::Q(k), Pdc(m)) if m < k => Stability::Stable,
            // P2-P1dc lacks a bubble, and P3-P2dc is stable on special meshes only.
            (V::P(2), Pdc(1)) => Stability::Refused(
                "is not stable with the velocity P2: take P2-bubble with P1dc, or P2 with P1".into(),
            ),
            (V::P(k), Pdc(m)) if m + 2 <= k => Stability::Stable,
            (V::P2Bubble, Pdc(0 | 1) | P(1)) => Stability::Stable,
            _ => too_many(),
        }
    }
}

impl PressureElement {
    /// Name in a case.
    pub fn name(self) -> &'static str {
        name_of(&PRESSURES, &self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_pairs_are_stable_or_of_equal_order() {
        for Choice { name, value: velocity, .. } in VELOCITIES {
            assert_eq!(velocity.name(), name);
            let expected = if velocity.degree() == 1 { Stability::Equal } else { Stability::Stable };
            assert_eq!(velocity.stability(velocity.pressure()), expected, "{name}");
        }
        for Choice { name, value: pressure, .. } in PRESSURES {
            assert_eq!(pressure.name(), name);
        }
    }

    #[test]
    fn pairs_without_a_stable_pressure_are_refused() {
        use PressureElement::{P, Pdc, Q};
        use VelocityElement as V;
        for (velocity, pressure) in [
            (V::Q(1), Pdc(0)),
            (V::Q(2), Pdc(2)),
            (V::Q(2), Q(3)),
            (V::Q(2), P(1)),
            (V::P(1), Pdc(0)),
            (V::P(2), Pdc(1)),
            (V::P(3), Pdc(2)),
            (V::P(2), Q(1)),
            (V::P2Bubble, P(2)),
            (V::P2Bubble, Pdc(2)),
        ] {
            let stability = velocity.stability(pressure);
            assert!(matches!(stability, Stability::Refused(_)), "{velocity:?} {pressure:?}: {stability:?}");
        }
        for (velocity, pressure) in
            [(V::P(2), Pdc(0)), (V::P(3), Pdc(1)), (V::P(2), Pdc(1)), (V::P(3), Pdc(2))]
        {
            assert!(matches!(velocity.stability_in(3, pressure), Stability::Refused(_)), "{velocity:?}");
        }
        assert_eq!(V::P(3).stability_in(3, Pdc(0)), Stability::Stable);
        assert_eq!(V::P2Bubble.stability_in(3, Pdc(1)), Stability::Stable);
        assert_eq!(V::P(3).stability(Pdc(1)), Stability::Stable);
        assert_eq!(V::P(2).stability(Pdc(0)), Stability::Stable);
        assert_eq!(V::P(2).stability(P(2)), Stability::Equal);
    }
}
