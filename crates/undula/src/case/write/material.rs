//! The tables of the fluid and the solid.

use super::{Lines, OWN, expressions};
use crate::case::choices::BODY_FORCE_AT;
use crate::case::literal::{number, string};
use crate::case::schema::{FibreDirection, FibreSpec, FluidSpec, SolidLaw, SolidSpec, ThinningSpec};
use crate::physics::Reference;
use crate::physics::viscosity::{FLUID_LAWS, FluidLaw};

impl FluidSpec {
    pub(super) fn write(&self, out: &mut Lines) {
        out.table(&self.table());
        out.regions(&self.regions);
        out.key("density", number(self.density));
        let law = if self.thinning.is_some() { FluidLaw::CarreauYasuda } else { FluidLaw::Newtonian };
        out.choice("law", &FLUID_LAWS, &law);
        match self.thinning {
            None => out.key("kinematic-viscosity", number(self.kinematic_viscosity)),
            Some(law) => write_thinning(&law, out),
        }
        out.key("body-force", expressions(&self.body_force));
        out.choice("body-force-at", &BODY_FORCE_AT, &self.force_at_current);
    }
}

impl SolidSpec {
    pub(super) fn write(&self, out: &mut Lines) {
        out.table(&self.table());
        out.regions(&self.regions);
        match self.own {
            // The stored energy of a program: give it one to read this.
            Some(_) => out.key("law", string(OWN)),
            None => out.word("law", self.law.name()),
        }
        out.key("density", number(self.density));
        if let Some(fibres) = &self.fibres {
            write_fibres(self.law, fibres, out);
        }
        if self.law.is_ogden() {
            let column = |n: usize| self.ogden.iter().map(|term| number(term[n])).collect::<Vec<_>>();
            out.key("ogden-mu", format!("[{}]", column(0).join(", ")));
            out.key("ogden-alpha", format!("[{}]", column(1).join(", ")));
        } else if self.law != SolidLaw::Guccione {
            out.key("mu", number(self.mu));
        }
        if self.law.is_mooney_rivlin() {
            out.key("c2", number(self.c2));
        }
        if !self.law.is_incompressible() {
            out.key("lambda", number(self.lambda));
        } else if let Some(bulk) = self.bulk {
            out.key("bulk", number(bulk));
        }
        let damping = [
            ("viscosity", self.viscosity),
            ("damping-mass", self.damping_mass),
            ("damping-stiffness", self.damping_stiffness),
        ];
        for (key, value) in damping.into_iter().filter(|(_, value)| *value != 0.0) {
            out.key(key, number(value));
        }
        out.key("body-force", expressions(&self.body_force));
        if self.reference != Reference::Free {
            out.key("prestress", "true");
        }
    }
}

/// Constants of the fibres of `law`.
fn write_fibres(law: SolidLaw, fibres: &FibreSpec, out: &mut Lines) {
    match &fibres.direction {
        FibreDirection::Angle(angle) => out.key("fibre-direction", number(*angle)),
        FibreDirection::Field(field) => out.key("fibre-direction", expressions(field)),
    }
    let ([b_f, b_t, b_fs], artery) = (fibres.exponents, law.is_of_arteries());
    let of_arteries = [
        ("fibre-angle", fibres.angle),
        ("k1", fibres.k1),
        ("k2", fibres.k2),
        ("dispersion", fibres.dispersion),
    ];
    let of_muscle = [("guccione-c", fibres.stiffness), ("b-f", b_f), ("b-t", b_t), ("b-fs", b_fs)];
    for (key, value) in if artery { of_arteries } else { of_muscle } {
        out.key(key, number(value));
    }
}

/// The law of Carreau and Yasuda.
fn write_thinning(law: &ThinningSpec, out: &mut Lines) {
    out.key("viscosity-zero", number(law.zero));
    out.key("viscosity-infinity", number(law.infinity));
    out.key("time-constant", number(law.time));
    out.key("power-index", number(law.index));
    out.key("yasuda-exponent", number(law.transition));
}
