//! The table `[stabilization]`.

use crate::case::element::{PressureElement, Stability};
use crate::case::read::{POSITIVE, Section};
use crate::case::schema::SpaceSpec;
use crate::physics::stabilization::{MAPPINGS, Mapping, PRESSURE_TERMS, PROJECTIONS, TRANSPORT_TERMS};
use crate::physics::{PressureTerm, Projection, Stabilization, TransportTerm};

/// Pairs of equal order get local projections unless another term is asked for, stable ones nothing.
pub(super) fn stabilization(mut s: Section<'_, '_>, space: &SpaceSpec, fluid: bool) -> Stabilization {
    let equal = space.velocity.stability(space.pressure) == Stability::Equal;
    let default = if equal && fluid { PressureTerm::LocalProjection } else { PressureTerm::None };
    let how = Stabilization {
        pressure: s.choice("pressure", &PRESSURE_TERMS, &[]).unwrap_or(default),
        transport: s.choice("transport", &TRANSPORT_TERMS, &[]).unwrap_or(TransportTerm::None),
        alpha: s.number("alpha", 0.1, POSITIVE),
        delta: s.number("delta", 0.1, POSITIVE),
        projection: s.choice("projection", &PROJECTIONS, &[]).unwrap_or(Projection::Cell),
        directional: s.boolean("directional", false),
        map: s.choice("map", &MAPPINGS, &[]).unwrap_or(Mapping::Full),
    };
    if fluid {
        refuse_pressure(&s, &how, space, equal);
        refuse_without_effect(&s, &how);
    }
    s.finish();
    how
}

/// Terms that the pair needs, or that do it no good.
fn refuse_pressure(s: &Section<'_, '_>, how: &Stabilization, space: &SpaceSpec, equal: bool) {
    let (v, p) = (space.velocity.name(), space.pressure.name());
    let discontinuous = matches!(space.pressure, PressureElement::Pdc(_));
    if how.pressure == PressureTerm::None && equal {
        s.wrong(
            "pressure",
            format!(
                "the pair {v}/{p} is of equal order: its inf-sup constants (5.24) and (5.25) are 0 or go to 0, and \
                 the pressure is not determined; expected `lps`, `pspg` or `brezzi-pitkaranta`"
            ),
        );
    } else if how.pressure != PressureTerm::None && discontinuous {
        s.wrong(
            "pressure",
            format!("works on continuous pressures only, and the pair {v}/{p} needs none; expected `off`"),
        );
    } else if !equal && matches!(how.pressure, PressureTerm::LocalProjection | PressureTerm::BrezziPitkaranta)
    {
        s.wrong(
            "pressure",
            format!("the pair {v}/{p} is stable, and would only lose accuracy; expected `off` or `pspg`"),
        );
    }
}

/// Keys that nothing depends on.
fn refuse_without_effect(s: &Section<'_, '_>, how: &Stabilization) {
    let pressure = how.pressure != PressureTerm::None;
    let transport = how.transport != TransportTerm::None;
    for (key, matters, needs) in [
        ("alpha", pressure, "a `pressure` term"),
        ("directional", pressure, "a `pressure` term"),
        ("delta", transport, "a `transport` term"),
        ("map", pressure || transport, "a `pressure` or a `transport` term"),
        ("projection", how.projects(), "`pressure` or `transport` = `lps`"),
    ] {
        if s.has(key) && !matters {
            s.wrong(key, format!("without effect: it belongs to {needs}"));
        }
    }
}
