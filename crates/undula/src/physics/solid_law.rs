//! Names of the laws of solids, and what they have.

use super::Material;
use super::fibres::{Artery, Muscle};
use super::isochoric::IsochoricNeoHookean;
use crate::choice::{Choice, choice, name_of};

/// Constitutive law of the solid without its constants.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum SolidLaw {
    /// Σ = 2 μ E + λ tr(E) I.
    StVenantKirchhoff,
    /// P = 2 μ ε + λ tr(ε) I.
    Linear,
    /// W = ½ μ (I₁ − 3) − μ ln J + ½ λ (J − 1)².
    NeoHookean,
    /// W = ½ μ (J^(−2/3) I₁ − 3) + ¼ κ (J² − 1 − 2 ln J).
    IsochoricNeoHookean,
    /// W = c₁ (I₁ − 3) + c₂ (I₂ − 3) − 2 (c₁ + 2 c₂) ln J + ½ (λ − 4 c₂)(J − 1)².
    MooneyRivlin,
    /// Neo-Hookean with J = 1.
    IncompressibleNeoHookean,
    /// Mooney-Rivlin with J = 1.
    IncompressibleMooneyRivlin,
    /// W = Σ_p [μ_p/α_p (λ₁^α_p + λ₂^α_p + λ₃^α_p − 3) − μ_p ln J] + ½ λ (J − 1)².
    Ogden,
    /// Ogden with J = 1.
    IncompressibleOgden,
    /// Neo-Hookean with two families of fibres.
    HolzapfelGasserOgden,
    /// The same with J = 1.
    IncompressibleHolzapfelGasserOgden,
    /// W = ½ C (exp Q − 1) with J = 1.
    Guccione,
}

/// Their names in a case.
pub static LAWS: [Choice<SolidLaw>; 12] = [
    choice(
        "st-venant-kirchhoff",
        SolidLaw::StVenantKirchhoff,
        "Σ = 2 μ E + λ tr(E) I: large rotations, moderate strains",
    ),
    choice("linear", SolidLaw::Linear, "Hooke's law: small strains and rotations"),
    choice("neo-hookean", SolidLaw::NeoHookean, "W = μ/2 (I₁ − 3) − μ ln J + λ/2 (J − 1)²: large strains"),
    choice(
        "isochoric-neo-hookean",
        SolidLaw::IsochoricNeoHookean,
        "W = μ/2 (J^(-2/3) I₁ − 3) + κ/4 (J² − 1 − 2 ln J): change of shape and of volume apart",
    ),
    choice("mooney-rivlin", SolidLaw::MooneyRivlin, "neo-Hookean with a term c2 (I₂ − 3), mu = 2 (c1 + c2)"),
    choice(
        "incompressible-neo-hookean",
        SolidLaw::IncompressibleNeoHookean,
        "neo-Hookean with J = 1 and a pressure in the solid",
    ),
    choice(
        "incompressible-mooney-rivlin",
        SolidLaw::IncompressibleMooneyRivlin,
        "Mooney-Rivlin with J = 1 and a pressure in the solid",
    ),
    choice(
        "ogden",
        SolidLaw::Ogden,
        "W = Σ μ_p/α_p (λ₁^α_p + λ₂^α_p + λ₃^α_p − 3): powers of the principal stretches",
    ),
    choice(
        "incompressible-ogden",
        SolidLaw::IncompressibleOgden,
        "Ogden with J = 1 and a pressure in the solid",
    ),
    choice(
        "holzapfel-gasser-ogden",
        SolidLaw::HolzapfelGasserOgden,
        "neo-Hookean with two families of fibres that bear tension only: walls of arteries",
    ),
    choice(
        "incompressible-holzapfel-gasser-ogden",
        SolidLaw::IncompressibleHolzapfelGasserOgden,
        "the same with J = 1 and a pressure in the solid",
    ),
    choice(
        "guccione",
        SolidLaw::Guccione,
        "W = C/2 (exp Q − 1) with J = 1 and a pressure in the solid: heart muscle",
    ),
];

impl SolidLaw {
    /// The name in a case.
    pub fn name(self) -> &'static str {
        name_of(&LAWS, &self)
    }

    /// Whether the solid has a pressure of its own.
    pub fn is_incompressible(self) -> bool {
        matches!(
            self,
            SolidLaw::IncompressibleNeoHookean
                | SolidLaw::IncompressibleMooneyRivlin
                | SolidLaw::IncompressibleOgden
                | SolidLaw::IncompressibleHolzapfelGasserOgden
                | SolidLaw::Guccione
        )
    }

    /// Whether the law has the constants c₁ and c₂.
    pub fn is_mooney_rivlin(self) -> bool {
        matches!(self, SolidLaw::MooneyRivlin | SolidLaw::IncompressibleMooneyRivlin)
    }

    /// Whether the law is of principal stretches, by μ_p and α_p.
    pub fn is_ogden(self) -> bool {
        matches!(self, SolidLaw::Ogden | SolidLaw::IncompressibleOgden)
    }

    /// Whether the law is that of a matrix with two families of fibres.
    pub fn is_of_arteries(self) -> bool {
        matches!(self, SolidLaw::HolzapfelGasserOgden | SolidLaw::IncompressibleHolzapfelGasserOgden)
    }

    /// The law with the shear modulus `mu`, the first Lamé parameter `lambda` and `c2` \[Pa\]; c₁ = ½ μ − c₂.
    /// Laws with more constants take simple ones, so that they are isotropic: Ogden the term μ, α = 2, arteries no
    /// fibres, Guccione b = 1.
    pub fn material(self, mu: f64, lambda: f64, c2: f64) -> Material {
        let c1 = 0.5 * mu - c2;
        match self {
            SolidLaw::StVenantKirchhoff => Material::StVenantKirchhoff { mu, lambda },
            SolidLaw::Linear => Material::Linear { mu, lambda },
            SolidLaw::NeoHookean => Material::NeoHookean { mu, lambda },
            SolidLaw::IsochoricNeoHookean => {
                Material::Isochoric(IsochoricNeoHookean { mu, bulk: lambda + 2.0 / 3.0 * mu })
            }
            SolidLaw::MooneyRivlin => Material::MooneyRivlin { c1, c2, lambda },
            SolidLaw::IncompressibleNeoHookean | SolidLaw::IncompressibleMooneyRivlin => {
                Material::incompressible(c1, c2, lambda)
            }
            SolidLaw::Ogden => Material::ogden(&[[mu, 2.0]], lambda, false),
            SolidLaw::IncompressibleOgden => Material::ogden(&[[mu, 2.0]], lambda, true),
            SolidLaw::HolzapfelGasserOgden => Material::Artery(Artery::matrix(mu, lambda, None)),
            SolidLaw::IncompressibleHolzapfelGasserOgden => {
                Material::Artery(Artery::matrix(mu, 0.0, Some(1.0 / lambda)))
            }
            SolidLaw::Guccione => {
                let (stiffness, compliance) = (2.0 * mu, 1.0 / lambda);
                Material::Muscle(Muscle { stiffness, exponents: [1.0; 3], compliance, direction: [1.0, 0.0] })
            }
        }
    }
}
