//! Constants of materials.

use crate::case::read::{ANY, NOT_NEGATIVE, POSITIVE, Range, Section};
use crate::case::schema::{FibreSpec, FluidSpec, SolidLaw, ThinningSpec};
use crate::physics::viscosity::{FLUID_LAWS, FluidLaw};
use crate::physics::{PressureTerm, Stabilization, TransportTerm};

pub(super) const POISSON: Range =
    Range { holds: |x| x > -1.0 && x < 0.5, text: "a number above -1 and below 0.5" };

const KEPT: Range = Range {
    text: "a number above -1 and below 0.5; 0.5 means that the volume is kept: take law = \"incompressible-neo-hookean\" \
           or \"incompressible-mooney-rivlin\", with `mu` or `young` alone",
    ..POISSON
};

const FINITE: Range = Range {
    text: "a finite number; where the volume is kept, take law = \"incompressible-neo-hookean\" or \
           \"incompressible-mooney-rivlin\", with `mu` or `young` alone",
    ..ANY
};

const NOT_ZERO: Range = Range { holds: |x| x != 0.0 && x.is_finite(), text: "numbers other than 0" };

const HALF: Range = Range { holds: |x| x > -1.0 && x <= 0.5, text: "a number above -1, at most 0.5" };

/// Constants of a law \[Pa\].
pub(super) struct Moduli {
    pub mu: f64,
    /// Infinite if the law is incompressible and there is no `bulk`.
    pub lambda: f64,
    pub c2: f64,
    /// μ_p and α_p.
    pub ogden: Vec<[f64; 2]>,
    pub fibres: Option<FibreSpec>,
    pub bulk: Option<f64>,
}

/// The constants of `law`.
pub(super) fn law_constants(s: &mut Section<'_, '_>, law: SolidLaw) -> Moduli {
    let c1 = s.optional_number("c1", POSITIVE);
    let c2 = s.optional_number("c2", NOT_NEGATIVE);
    let bulk = s.optional_number("bulk", POSITIVE);
    for key in ["c1", "c2"].into_iter().filter(|key| s.has(key) && !law.is_mooney_rivlin()) {
        s.wrong(key, "only for the laws `mooney-rivlin` and `incompressible-mooney-rivlin`");
    }
    let (ogden, fibres) = (ogden_terms(s, law), fibres(s, law));
    let (mu, lambda) = match law.is_incompressible() {
        _ if law.is_ogden() => beside_ogden(s, law, &ogden),
        _ if law == SolidLaw::Guccione => (beside_guccione(s, fibres.as_ref()), f64::INFINITY),
        true => (shear_modulus(s), f64::INFINITY),
        false => moduli(s),
    };
    let mu = mu.or_else(|| Some(2.0 * (c1? + c2?))).unwrap_or(1.0);
    let mut moduli =
        Moduli { mu, lambda, c2: 0.0, ogden, fibres, bulk: bulk.filter(|_| law.is_incompressible()) };
    if s.has("bulk") && !law.is_incompressible() {
        s.wrong("bulk", "only for incompressible laws; the others take `lambda` or `poisson`");
    } else if let Some(bulk) = bulk {
        moduli.lambda = bulk - 2.0 / 3.0 * mu;
        if moduli.lambda <= 0.0 {
            let least = 2.0 / 3.0 * mu;
            s.wrong("bulk", format!("expected a number above 2/3 mu = {least} Pa, lambda = bulk - 2/3 mu"));
        }
    }
    if law.is_mooney_rivlin() {
        moduli.c2 = c2.unwrap_or(0.0);
        check_split(s, &moduli);
    }
    moduli
}

const DISPERSION: Range = Range {
    holds: |x| (0.0..=1.0 / 3.0).contains(&x),
    text: "a number from 0, aligned, to 1/3, in all directions",
};

/// The constants of the fibres of laws that have them.
fn fibres(s: &mut Section<'_, '_>, law: SolidLaw) -> Option<FibreSpec> {
    let (artery, muscle) = (law.is_of_arteries(), law == SolidLaw::Guccione);
    let direction = s.direction("fibre-direction");
    let [angle, k1, k2] = [("fibre-angle", ANY), ("k1", NOT_NEGATIVE), ("k2", POSITIVE)]
        .map(|(key, range)| s.optional_number(key, range));
    let dispersion = s.optional_number("dispersion", DISPERSION);
    let muscles = ["guccione-c", "b-f", "b-t", "b-fs"].map(|key| s.optional_number(key, POSITIVE));
    let of = [
        (
            &["fibre-direction"][..],
            artery || muscle,
            "laws with fibres: `holzapfel-gasser-ogden`, `guccione`",
        ),
        (&["fibre-angle", "k1", "k2", "dispersion"], artery, "the laws `holzapfel-gasser-ogden`"),
        (&["guccione-c", "b-f", "b-t", "b-fs"], muscle, "the law `guccione`"),
    ];
    for (key, laws) in
        of.iter().filter(|row| !row.1).flat_map(|(keys, _, laws)| keys.iter().map(move |key| (key, laws)))
    {
        if s.has(key) {
            s.wrong(key, format!("only for {laws}"));
        }
    }
    let needed: &[(&str, &str)] = match () {
        () if artery => &[
            ("fibre-angle", "the angle of each family of fibres to `fibre-direction`, as \"40 deg\""),
            ("k1", "the stiffness of the fibres [Pa]"),
            ("k2", "the exponent of the fibres"),
        ],
        () if muscle => {
            &[("guccione-c", "the stiffness C [Pa]"), ("b-f", "as 8"), ("b-t", "as 2"), ("b-fs", "as 4")]
        }
        () => return None,
    };
    for (key, meaning) in needed.iter().filter(|(key, _)| !s.has(key)) {
        s.missing(key, meaning);
    }
    let [stiffness, b_f, b_t, b_fs] = muscles.map(|x| x.unwrap_or(1.0));
    Some(FibreSpec {
        direction: direction.unwrap_or_default(),
        angle: angle.unwrap_or(0.0),
        k1: k1.unwrap_or(1.0),
        k2: k2.unwrap_or(1.0),
        dispersion: dispersion.unwrap_or(0.0),
        stiffness,
        exponents: [b_f, b_t, b_fs],
    })
}

/// μ = ½ C b_fs \[Pa\] of Guccione, that of a shear along the fibres.
fn beside_guccione(s: &mut Section<'_, '_>, fibres: Option<&FibreSpec>) -> Option<f64> {
    for key in ["mu", "lambda", "young", "poisson"] {
        if s.optional_number(key, ANY).is_some() {
            s.wrong(key, "not for the law of Guccione; expected `guccione-c`, `b-f`, `b-t` and `b-fs`");
        }
    }
    fibres.map(|fibres| 0.5 * fibres.stiffness * fibres.exponents[2])
}

/// μ_p and α_p of Ogden, whose products are above 0, or rest would not be stable.
fn ogden_terms(s: &mut Section<'_, '_>, law: SolidLaw) -> Vec<[f64; 2]> {
    let keys = ["ogden-mu", "ogden-alpha"];
    let [mu, alpha] = keys.map(|key| s.numbers(key, NOT_ZERO));
    for key in keys {
        if s.has(key) && !law.is_ogden() {
            s.wrong(key, "only for the laws `ogden` and `incompressible-ogden`");
        } else if !s.has(key) && law.is_ogden() {
            s.missing(key, "`ogden-mu` [Pa] and `ogden-alpha`, as [6.3e5, 1.2e3, -1e4] and [1.3, 5, -2]");
        }
    }
    let (Some(mu), Some(alpha)) = (mu, alpha) else { return vec![] };
    if mu.is_empty() || mu.len() > 3 {
        s.wrong("ogden-mu", "expected one to three numbers");
    } else if alpha.len() != mu.len() {
        s.wrong("ogden-alpha", format!("expected {} numbers, as many as `ogden-mu`", mu.len()));
    } else if mu.iter().zip(&alpha).any(|(mu, alpha)| mu * alpha < 0.0) {
        s.wrong(
            "ogden-alpha",
            "expected numbers with the signs of those of `ogden-mu`, or rest would not be stable",
        );
    }
    mu.into_iter().zip(alpha).map(|(mu, alpha)| [mu, alpha]).collect()
}

/// μ = ½ Σ μ_p α_p and λ \[Pa\] of Ogden, λ given as such or by the Poisson ratio.
fn beside_ogden(s: &mut Section<'_, '_>, law: SolidLaw, terms: &[[f64; 2]]) -> (Option<f64>, f64) {
    let mu: f64 = terms.iter().map(|[mu, alpha]| 0.5 * mu * alpha).sum();
    let (lambda, poisson) = (s.optional_number("lambda", ANY), s.optional_number("poisson", POISSON));
    for key in ["mu", "young"] {
        if s.optional_number(key, POSITIVE).is_some() {
            s.wrong(
                key,
                "not for the laws of Ogden, whose mu is half of the sum of ogden-mu times ogden-alpha",
            );
        }
    }
    if law.is_incompressible() {
        for key in ["lambda", "poisson"].into_iter().filter(|key| s.has(key)) {
            s.wrong(key, "the law is incompressible; expected `bulk` [Pa] or nothing");
        }
        return (Some(mu), f64::INFINITY);
    }
    match (lambda, poisson) {
        (Some(_), Some(_)) => s.wrong("poisson", "give either `lambda` or `poisson`"),
        (Some(lambda), None) if 3.0 * lambda + 2.0 * mu <= 0.0 => {
            s.wrong("lambda", format!("expected a number above -2/3 mu = {} Pa", -2.0 / 3.0 * mu));
        }
        (None, None) if !s.has("lambda") && !s.has("poisson") => {
            s.missing("lambda", "`lambda` [Pa] or `poisson`");
        }
        _ => {}
    }
    let of_poisson = |poisson: f64| 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    (Some(mu), lambda.or(poisson.map(of_poisson)).unwrap_or(1.0))
}

/// Whether Mooney-Rivlin is polyconvex.
fn check_split(s: &Section<'_, '_>, &Moduli { mu, lambda, c2, .. }: &Moduli) {
    if s.has("c1") && !s.has("c2") {
        s.missing("c2", "`c1` and `c2` [Pa] belong together; or give `mu` = 2 (c1 + c2) and `c2`");
    } else if !s.has("c2") {
        let table = &s.path;
        let note =
            format!("{table}.law: without {table}.c2 [Pa] Mooney-Rivlin is neo-Hookean (mu = 2 (c1 + c2))");
        s.note(note);
    } else if c2 >= 0.5 * mu {
        s.wrong(
            "c2",
            format!("expected a number below mu/2 = {} Pa, for c1 = mu/2 - c2 is above 0", 0.5 * mu),
        );
    } else if lambda <= 4.0 * c2 {
        let most = 0.25 * lambda;
        s.wrong(
            "c2",
            format!(
                "expected a number below lambda/4 = {most} Pa, or a strong compression would release energy"
            ),
        );
    }
}

/// μ \[Pa\] of an incompressible law, from `mu` or `young`; `None` if from `c1` and `c2`.
fn shear_modulus(s: &mut Section<'_, '_>) -> Option<f64> {
    let (mu, lambda) = (s.optional_number("mu", POSITIVE), s.optional_number("lambda", ANY));
    let (young, poisson) = (s.optional_number("young", POSITIVE), s.optional_number("poisson", HALF));
    let ways = ["mu", "young", "c1"].into_iter().filter(|key| s.has(key)).collect::<Vec<_>>();
    match ways[..] {
        [] if s.means("young") => {}
        [] => s.missing("mu", "the modulus `mu` [Pa], or `young` [Pa], which is 3 mu"),
        [_] => {}
        [_, other, ..] => s.wrong(other, "give one of `mu`, `young`, and `c1` with `c2`"),
    }
    if lambda.is_some() || poisson.is_some_and(|poisson| poisson < 0.5) {
        let key = if lambda.is_some() { "lambda" } else { "poisson" };
        let table = &s.path;
        let note = format!(
            "{table}.{key} says nothing of the volume: the law is incompressible, but for {table}.bulk [Pa]"
        );
        s.note(note);
    }
    mu.or_else(|| young.map(|young| young / (2.0 * (1.0 + poisson.unwrap_or(0.5)))))
}

/// μ and λ \[Pa\], given as such or as Young's modulus and Poisson ratio.
fn moduli(s: &mut Section<'_, '_>) -> (Option<f64>, f64) {
    let is = |key: &str, x: f64| s.look_at_number(key) == Some(x);
    let (finite, below) = (
        if is("lambda", f64::INFINITY) { FINITE } else { ANY },
        if is("poisson", 0.5) { KEPT } else { POISSON },
    );
    let mu = s.optional_number("mu", POSITIVE);
    let lambda = s.optional_number("lambda", finite);
    let young = s.optional_number("young", POSITIVE);
    let poisson = s.optional_number("poisson", below);
    let given = |key: &str| s.has(key) || s.means(key);
    let lame = given("mu") || given("lambda");
    let engineering = given("young") || given("poisson");
    for key in ["young", "poisson"] {
        if lame && s.has(key) {
            s.wrong(key, "give either `mu` and `lambda` or `young` and `poisson`");
        } else if engineering && !lame && !s.has(key) {
            s.missing(key, "`young` [Pa] and `poisson` belong together");
        }
    }
    let constants = s.has("c1");
    if constants && (s.has("mu") || engineering) {
        s.wrong("c1", "give either `c1` and `c2` or `mu` and `c2`, mu = 2 (c1 + c2)");
    }
    for key in ["mu", "lambda"] {
        if constants && key == "mu" {
            continue;
        } else if !engineering && !s.has(key) {
            s.missing(key, "the moduli `mu` and `lambda` [Pa], or `young` [Pa] and `poisson`");
        } else if engineering && lame && !s.has(key) {
            s.missing(key, "`mu` and `lambda` [Pa] belong together");
        }
    }
    if let (Some(young), Some(poisson)) = (young, poisson) {
        let mu = young / (2.0 * (1.0 + poisson));
        return (Some(mu), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
    }
    if let (Some(mu), Some(lambda)) = (mu, lambda)
        && 3.0 * lambda + 2.0 * mu <= 0.0
    {
        s.wrong("lambda", format!("expected a number above -2/3 mu = {} Pa", -2.0 / 3.0 * mu));
    }
    (mu, lambda.unwrap_or(1.0))
}

/// η \[Pa s\], α \[1/s\] and β \[s\] of the damping.
pub(super) fn damping(s: &mut Section<'_, '_>) -> [f64; 3] {
    ["viscosity", "damping-mass", "damping-stiffness"].map(|key| s.number(key, 0.0, NOT_NEGATIVE))
}

/// What the damping of a stationary solid does.
pub(super) fn note_still(s: &Section<'_, '_>) {
    for key in ["viscosity", "damping-mass", "damping-stiffness"].into_iter().filter(|key| s.has(key)) {
        let note = format!("{}.{key} has no effect: the case is stationary", s.path);
        s.note(note);
    }
}

const BELOW_ZERO: &str = "expected a number from 0 to viscosity-zero";

/// ν \[m²/s\] at rest, and how it depends on the rate of shear.
pub(super) fn viscosity(s: &mut Section<'_, '_>, density: f64) -> (f64, Option<ThinningSpec>) {
    let law = s.choice("law", &FLUID_LAWS, &[]).unwrap_or(FluidLaw::Newtonian);
    if law == FluidLaw::Newtonian {
        for key in ["viscosity-zero", "viscosity-infinity", "time-constant", "power-index", "yasuda-exponent"]
        {
            if s.optional_number(key, ANY).is_some() {
                s.wrong(key, "only for law = \"carreau-yasuda\"");
            }
        }
        let meaning = "the kinematic viscosity [m²/s]";
        return (s.required_number("kinematic-viscosity", POSITIVE, meaning), None);
    }
    if s.optional_number("kinematic-viscosity", POSITIVE).is_some() {
        s.wrong("kinematic-viscosity", "only for law = \"newtonian\"; expected `viscosity-zero` [Pa s]");
    }
    let law = ThinningSpec {
        zero: s.required_number("viscosity-zero", POSITIVE, "the dynamic viscosity at rest [Pa s]"),
        infinity: s.required_number(
            "viscosity-infinity",
            NOT_NEGATIVE,
            "the dynamic viscosity at high rates of shear [Pa s]",
        ),
        time: s.required_number(
            "time-constant",
            POSITIVE,
            "λ [s], 1 over the rate of shear at which the viscosity changes",
        ),
        index: s.required_number(
            "power-index",
            POSITIVE,
            "the index n of the power law, below 1 if shear-thinning",
        ),
        transition: s.number("yasuda-exponent", 2.0, POSITIVE),
    };
    if law.infinity > law.zero && s.has("viscosity-zero") {
        s.wrong("viscosity-infinity", BELOW_ZERO);
    }
    (law.zero / density, Some(law))
}

/// Residuals in which the viscosity is constant.
pub(super) fn refuse_residuals(s: &Section<'_, '_>, fluids: &[FluidSpec], how: &Stabilization) {
    if fluids.iter().all(|fluid| fluid.thinning.is_none()) {
        return;
    }
    let message =
        "its residual is that of a constant viscosity; with fluid.law = \"carreau-yasuda\" expected `lps`";
    if how.pressure == PressureTerm::Pspg {
        s.wrong("pressure", message);
    }
    if how.transport == TransportTerm::Supg {
        s.wrong("transport", message);
    }
}
