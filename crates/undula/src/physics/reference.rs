//! Solids whose reference domain is loaded: the measured shape is one under stress. `loaded` has their stress.

/// What the reference domain of a solid is.
///
/// If it is loaded, x + U(x) is where it would be without stress. With g = I + ∇U the deformation gradient from there is
/// F g⁻¹, and the stress is that of the law at F g⁻¹, carried to the reference domain: P = P(F g⁻¹) cof g. Hooke's law,
/// which does not distinguish the two domains, has P = P(∇u − ∇U).
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// Free of stress.
    #[default]
    Free,
    /// Loaded, with a known U.
    Loaded,
    /// Loaded, and U is sought in the place of u, which is 0: the inverse problem of Govindjee and Mihalic (1996).
    Sought,
}
