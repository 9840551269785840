//! Keys of the materials.

use super::key::Key;

/// Those of the solid besides mu and lambda.
pub(super) static OF_SOLID: [Key; 6] = [
    Key::data("solid.c1", "Pa", "mu/2 - c2", "Mooney-Rivlin: constant c₁, instead of `mu`"),
    Key::data("solid.c2", "Pa", "0", "Mooney-Rivlin: constant c₂"),
    Key::data("solid.bulk", "Pa", "none", "nearly incompressible laws: bulk modulus, lambda + 2/3 mu"),
    Key::data(
        "solid.viscosity",
        "Pa s",
        "none",
        "Kelvin-Voigt: eta of the viscous stress eta dE/dt, with every law",
    ),
    Key::data("solid.damping-mass", "1/s", "none", "Rayleigh damping: alpha of the force -alpha rho v"),
    Key::data(
        "solid.damping-stiffness",
        "s",
        "none",
        "Rayleigh damping: beta, times the rate of the stress of the moduli at rest",
    ),
];
