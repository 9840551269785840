//! Keys of the materials.

use super::key::Key;
use crate::physics::viscosity::FLUID_LAWS;

/// Those of the viscosity of the fluid.
pub(super) static OF_FLUID: [Key; 7] = [
    Key {
        key: "fluid.law",
        unit: "",
        default: "newtonian",
        about: "how the viscosity depends on the rate of shear",
        choices: Some(&FLUID_LAWS),
    },
    Key::data(
        "fluid.kinematic-viscosity",
        "m²/s",
        "newtonian: required",
        "kinematic viscosity: dynamic viscosity divided by density",
    ),
    Key::data("fluid.viscosity-zero", "Pa s", "carreau-yasuda: required", "dynamic viscosity μ₀ at rest"),
    Key::data(
        "fluid.viscosity-infinity",
        "Pa s",
        "carreau-yasuda: required",
        "dynamic viscosity μ_∞ at high rates of shear",
    ),
    Key::data(
        "fluid.time-constant",
        "s",
        "carreau-yasuda: required",
        "λ, 1 over the rate at which the viscosity changes",
    ),
    Key::data("fluid.power-index", "", "carreau-yasuda: required", "n, below 1 if shear-thinning"),
    Key::data("fluid.yasuda-exponent", "", "2", "a, how sharp the transition is; 2 is the law of Carreau"),
];

/// Those of the solid besides mu and lambda.
pub(super) static OF_SOLID: [Key; 18] = [
    Key::data("solid.c1", "Pa", "mu/2 - c2", "Mooney-Rivlin: constant c₁, instead of `mu`"),
    Key::data("solid.c2", "Pa", "0", "Mooney-Rivlin: constant c₂"),
    Key::data("solid.ogden-mu", "Pa", "ogden: required", "Ogden: μ_p, one to three numbers, as [6e5, 1e3]"),
    Key::data(
        "solid.ogden-alpha",
        "",
        "ogden: required",
        "Ogden: α_p, as many, as [1.3, 5]; mu is half of Σ μ_p α_p",
    ),
    Key::data(
        "solid.fibre-direction",
        "rad",
        "0",
        "laws with fibres: angle to the x axis of the fibres, or of the middle; or two expressions as [\"-y\", \"x\"], in space three",
    ),
    Key::data("solid.fibre-angle", "rad", "fibres: required", "angle of each of two families to the middle"),
    Key::data("solid.k1", "Pa", "fibres: required", "Holzapfel-Gasser-Ogden: stiffness of the fibres"),
    Key::data("solid.k2", "", "fibres: required", "Holzapfel-Gasser-Ogden: exponent of the fibres"),
    Key::data("solid.dispersion", "", "0", "Holzapfel-Gasser-Ogden: κ, 0: aligned, 1/3: in all directions"),
    Key::data("solid.guccione-c", "Pa", "guccione: required", "Guccione: C of W = C/2 (exp Q − 1)"),
    Key::data("solid.b-f", "", "guccione: required", "Guccione: exponent along the fibres"),
    Key::data("solid.b-t", "", "guccione: required", "Guccione: exponent across the fibres"),
    Key::data("solid.b-fs", "", "guccione: required", "Guccione: exponent of shear along the fibres"),
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
    Key::data(
        "solid.prestress",
        "",
        "false",
        "true: the mesh is the shape under the loads of the start, which the stress balances at u = 0",
    ),
];
