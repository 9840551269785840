//! Finite elements by name, and which pairs of velocity and pressure can be used.

/// Space of velocity and deformation.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum VelocityElement {
    /// Continuous, of degree k in each coordinate of a quadrilateral.
    Q(usize),
}

/// Space of the pressure.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PressureElement {
    /// Continuous, of degree k in each coordinate of a quadrilateral.
    Q(usize),
    /// Discontinuous, of total degree k in the reference-domain coordinates of the cell.
    Pdc(usize),
}

/// Velocities by the names they have in a case.
pub const VELOCITIES: [(&str, VelocityElement); 4] = [
    ("Q1", VelocityElement::Q(1)),
    ("Q2", VelocityElement::Q(2)),
    ("Q3", VelocityElement::Q(3)),
    ("Q4", VelocityElement::Q(4)),
];

/// Pressures by the names they have in a case.
pub const PRESSURES: [(&str, PressureElement); 8] = [
    ("P0", PressureElement::Pdc(0)),
    ("P1dc", PressureElement::Pdc(1)),
    ("P2dc", PressureElement::Pdc(2)),
    ("P3dc", PressureElement::Pdc(3)),
    ("Q1", PressureElement::Q(1)),
    ("Q2", PressureElement::Q(2)),
    ("Q3", PressureElement::Q(3)),
    ("Q4", PressureElement::Q(4)),
];

/// What is known of the inf-sup condition (5.24) of a pair.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stability {
    /// It holds with a constant that does not depend on the mesh.
    Stable,
    /// Velocity and pressure are of equal order: it fails, and stabilisation is needed.
    Equal,
    /// The pair is of no use, and why.
    Refused(String),
}

impl VelocityElement {
    /// Name in a case.
    pub fn name(self) -> &'static str {
        VELOCITIES.iter().find(|(_, e)| *e == self).map_or("", |(name, _)| name)
    }

    /// Polynomial degree k.
    pub fn degree(self) -> usize {
        let VelocityElement::Q(k) = self;
        k
    }

    /// The pressure that goes with it unless one is asked for: P_{k−1} discontinuous, of equal order for k = 1.
    pub fn pressure(self) -> PressureElement {
        match self {
            VelocityElement::Q(1) => PressureElement::Q(1),
            VelocityElement::Q(k) => PressureElement::Pdc(k - 1),
        }
    }

    /// Gauss points per direction unless a number is asked for: products of two gradients on affine cells, and
    /// mass matrices, are then exact.
    pub fn quadrature(self) -> usize {
        self.degree() + 1
    }

    /// Whether it makes a useful pair with `pressure`.
    pub fn stability(self, pressure: PressureElement) -> Stability {
        use PressureElement::Pdc;
        let VelocityElement::Q(k) = self;
        match pressure {
            PressureElement::Q(m) if m < k => Stability::Stable,
            PressureElement::Q(m) if m == k => Stability::Equal,
            Pdc(m) if m < k && k > 1 => Stability::Stable,
            Pdc(0) => {
                Stability::Refused("has checkerboard modes with Q1: take Q2, or a stabilised Q1".into())
            }
            other => Stability::Refused(format!(
                "has too many unknowns for the velocity {} (inf-sup condition (5.24)); {} goes with it",
                self.name(),
                match (self.pressure(), other) {
                    (pressure, Pdc(_)) => pressure.name().to_string(),
                    (pressure, _) => format!("{} or a lower degree", pressure.name()),
                }
            )),
        }
    }
}

impl PressureElement {
    /// Name in a case.
    pub fn name(self) -> &'static str {
        PRESSURES.iter().find(|(_, e)| *e == self).map_or("", |(name, _)| name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_pairs_are_stable_or_of_equal_order() {
        for (name, velocity) in VELOCITIES {
            assert_eq!(velocity.name(), name);
            let expected = if velocity.degree() == 1 { Stability::Equal } else { Stability::Stable };
            assert_eq!(velocity.stability(velocity.pressure()), expected, "{name}");
        }
        for (name, pressure) in PRESSURES {
            assert_eq!(pressure.name(), name);
        }
        assert!(matches!(VelocityElement::Q(1).stability(PressureElement::Pdc(0)), Stability::Refused(_)));
        assert!(matches!(VelocityElement::Q(2).stability(PressureElement::Pdc(2)), Stability::Refused(_)));
        assert!(matches!(VelocityElement::Q(2).stability(PressureElement::Q(3)), Stability::Refused(_)));
    }
}
