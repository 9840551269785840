//! Profiles of a given flow, with the keys of their data.

use super::key::Key;
use crate::choice::{Choice, choice};

/// The velocity on a boundary through which a given flow Q goes.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// It is free; one pressure acts on all of the boundary, which is an unknown.
    #[default]
    Free,
    /// v = Q(t) w n, with the profile w of a steady flow that is fully developed:
    /// −Δ_Γ w = c on the boundary, w = 0 at its rim, ∫ w ds = 1.
    Parabolic,
    /// v = Σ_n Re((a_n − i b_n) w_n e^{inωt}) n, with the profiles w_n of a flow of period T that is fully developed
    /// (Womersley 1955): (inω/ν) w_n − Δ_Γ w_n = c_n, w_n = 0 at the rim, ∫ w_n ds = 1, ω = 2π/T. The flow is
    /// Q = a_0 + Σ_{n ≥ 1} (a_n cos(nωt) + b_n sin(nωt)).
    Womersley,
}

/// Their names in a case.
pub static PROFILES: [Choice<Profile>; 3] = [
    choice(
        "free",
        Profile::Free,
        "one pressure on all of the boundary, the one with which the flow goes through",
    ),
    choice(
        "parabolic",
        Profile::Parabolic,
        "prescribed velocity of steady flow, fully developed; any section",
    ),
    choice(
        "womersley",
        Profile::Womersley,
        "prescribed velocity of periodic flow, fully developed; any section",
    ),
];

/// Keys of their data.
pub(super) static PROFILE_KEYS: [Key; 3] = [
    Key {
        key: "boundary.NAME.profile",
        unit: "",
        default: "free",
        about: "velocity on a boundary of condition `flux`, which does not move unless it is free",
        choices: Some(&PROFILES),
    },
    Key::data(
        "boundary.NAME.fourier",
        "m²/s",
        "womersley: required",
        "[[a_0, 0], [a_1, b_1], ...]: flow a_0 + Σ a_n cos(2πnt/T) + b_n sin(2πnt/T) out of the fluid",
    ),
    Key::data("boundary.NAME.period", "s", "womersley: required", "T of the flow of a profile `womersley`"),
];
