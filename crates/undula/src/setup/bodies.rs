//! Whether each connected part of fluid and solid is held, and its pressure determined.
//!
//! A pressure is determined up to a constant only in parts of constant volume (fluids, and solids with J = 1) that
//! touch each other and nothing that gives way. In time gives way: a boundary without traction, and a compressible
//! solid. At rest v = 0 in the solid, so that no solid gives way to a fluid; a solid gives way to itself where its
//! surface is free, at the interface, too.

use super::names::{Component, MeshNames};
use crate::case::{Case, Condition};
use crate::mesh::INTERFACE;
use crate::space::Region;

/// Mistakes by the key that they belong to.
pub(super) fn check(case: &Case, names: &MeshNames) -> Vec<(String, String)> {
    let bodies = Bodies { case, names };
    let mut errors = vec![];
    bodies.check_volumes(&mut errors);
    bodies.check_held(&mut errors);
    errors
}

struct Bodies<'a> {
    case: &'a Case,
    names: &'a MeshNames,
}

impl Bodies<'_> {
    fn part(&self, number: usize) -> &Component {
        &self.names.components[number]
    }

    /// Numbers of the connected parts that are computed on.
    fn parts(&self, body: Region) -> impl Iterator<Item = usize> + '_ {
        (0..self.names.components.len()).filter(move |&n| self.body(n) == Some(body))
    }

    fn body(&self, number: usize) -> Option<Region> {
        self.case.body_in(&self.part(number).region).map(|(body, _)| body)
    }

    /// The table of the body of a part.
    fn table(&self, number: usize) -> String {
        let found = self.case.body_in(&self.part(number).region);
        found.map_or(String::new(), |(body, material)| match body {
            Region::Fluid => self.case.fluids[usize::from(material)].table(),
            Region::Solid => self.case.solids[usize::from(material)].table(),
        })
    }

    /// Parts that a part touches, those beyond its periodic boundaries among them.
    fn touched(&self, number: usize) -> Vec<usize> {
        let mut touched = self.part(number).touches.clone();
        for name in &self.part(number).boundaries {
            let Some(Condition::Periodic(with)) = self.case.boundary.get(name) else { continue };
            let beyond = |&other: &usize| {
                other != number
                    && self.body(other) == self.body(number)
                    && self.part(other).boundaries.contains(with)
            };
            touched.extend((0..self.names.components.len()).filter(beyond));
        }
        touched
    }

    /// Whether two parts that touch each other are of bodies of one kind, so that they move alike.
    fn are_bonded(&self, one: usize, other: usize) -> bool {
        self.body(one).is_some() && self.body(one) == self.body(other)
    }

    /// The parts that hang together with a part, itself among them.
    fn bonded(&self, number: usize) -> Vec<usize> {
        let mut group = vec![number];
        let mut next = 0;
        while next < group.len() {
            for other in self.touched(group[next]) {
                if self.are_bonded(group[next], other) && !group.contains(&other) {
                    group.push(other);
                }
            }
            next += 1;
        }
        group
    }

    /// Whether a boundary of the part determines its pressure.
    fn is_open(&self, number: usize) -> bool {
        let open = |c: Option<&Condition>| c.is_some_and(Condition::gives_pressure);
        self.part(number).boundaries.iter().any(|name| open(self.case.boundary.get(name)))
    }

    /// A boundary of the part whose flow is given.
    fn given_flow(&self, number: usize) -> Option<&String> {
        let given = |name: &&String| {
            self.case.boundary.get(*name).is_some_and(|c| c.is_lumped() && !c.gives_pressure())
        };
        self.part(number).boundaries.iter().find(given)
    }

    /// Whether a boundary of the part is given; sides of regions that are left out are, unless a condition says else.
    fn is_held(&self, number: usize) -> bool {
        self.part(number).boundaries.iter().any(|name| match self.case.boundary.get(name) {
            Some(condition) => condition.is_given() || condition.is_elastic(),
            None => {
                let kept = self.case.regions();
                let inside = self.names.is_inside(name, &kept) && !self.names.is_between(name, &kept);
                name != INTERFACE && inside
            }
        })
    }

    fn touches(&self, number: usize, body: Region) -> bool {
        self.part(number).touches.iter().any(|&other| self.body(other) == Some(body))
    }

    /// Whether the part has a surface towards a fluid that an absent table leaves out.
    fn has_surface(&self, number: usize) -> bool {
        let absent = if self.case.fluids.is_empty() { self.case.absent_regions() } else { vec![] };
        self.part(number).touches.iter().any(|&other| absent.contains(&&*self.part(other).region))
    }

    /// Whether the part keeps its volume exactly.
    fn is_constant(&self, number: usize) -> bool {
        self.case.body_in(&self.part(number).region).is_some_and(|(body, material)| match body {
            Region::Fluid => true,
            Region::Solid => self.case.solids[usize::from(material)].keeps_volume(),
        })
    }

    /// Whether the part touches something that gives way, not counting other parts of constant volume.
    fn gives_way(&self, number: usize) -> bool {
        let in_time = self.case.time.is_some();
        let softer = |&other: &usize| self.body(other).is_some() && !self.is_constant(other);
        self.is_open(number)
            || self
                .part(number)
                .touches
                .iter()
                .filter(|other| softer(other))
                .any(|&other| in_time || self.are_bonded(number, other))
            || (self.body(number) == Some(Region::Solid)
                && (self.has_surface(number) || (!in_time && self.touches(number, Region::Fluid))))
    }

    /// The parts of constant volume that pass on their pressures to each other: at rest those of one kind only.
    fn group(&self, number: usize) -> Vec<usize> {
        let mut group = vec![number];
        let mut next = 0;
        while next < group.len() {
            for other in self.touched(group[next]) {
                let passes = self.case.time.is_some() || self.are_bonded(group[next], other);
                if passes && self.is_constant(other) && !group.contains(&other) {
                    group.push(other);
                }
            }
            next += 1;
        }
        group
    }

    fn check_volumes(&self, errors: &mut Vec<(String, String)>) {
        let mut seen = vec![];
        for first in (0..self.names.components.len()).filter(|&n| self.is_constant(n)) {
            if seen.contains(&first) {
                continue;
            }
            let group = self.group(first);
            seen.extend(&group);
            if group.iter().any(|&n| self.gives_way(n)) {
                continue;
            }
            if let Some(&solid) = group.iter().find(|&&n| self.body(n) == Some(Region::Solid)) {
                let subject =
                    self.subject(solid, Region::Solid, "its volume", "the volume of the part of the solid");
                let message = format!(
                    "{subject} cannot change and no boundary gives way, so that pressures are determined up to a \
                     constant only: one boundary needs condition = `traction-free` or `do-nothing`, or give `bulk`"
                );
                errors.push((format!("{}.law", self.table(solid)), message));
            } else if let Some(name) = group.iter().find_map(|&n| self.given_flow(n)) {
                let message = format!(
                    "`flux` on `{name}` gives a flow, and nothing determines the pressure but for a constant: one boundary \
                     needs `pressure`, `do-nothing`, `traction-free`, `traction`, `resistance` or `windkessel`"
                );
                errors.push(("boundary".into(), message));
            } else if self.touches(first, Region::Solid) {
                let subject = self.subject(first, Region::Fluid, "the fluid", "the part of the fluid");
                let message = format!(
                    "{subject} is closed in on all sides, so its pressure is determined up to a constant only (at rest \
                     the solid does not give way): one boundary needs condition = `do-nothing` or `traction-free`, or \
                     give the case a [time] to begin in"
                );
                errors.push((self.table(first), message));
            }
        }
    }

    fn check_held(&self, errors: &mut Vec<(String, String)>) {
        let stationary = self.case.time.is_none();
        let loose = |n: &usize| {
            let group = self.bonded(*n);
            // Told of the first of those that hang together.
            group.iter().min() == Some(n) && !group.iter().any(|&n| self.is_held(n))
        };
        for number in self.parts(Region::Solid).filter(|n| stationary && loose(n)) {
            let subject = self.subject(number, Region::Solid, "the solid", "the part of the solid");
            let message = format!(
                "nothing holds {subject}, so it has no stationary state: add a boundary with condition = `clamped`"
            );
            errors.push((self.table(number), message));
        }
    }

    /// `whole` if the body is in one piece, else `part` with its extent.
    fn subject(&self, number: usize, body: Region, whole: &str, part: &str) -> String {
        if self.parts(body).count() == 1 {
            return whole.into();
        }
        let Component { lower, upper, .. } = self.part(number);
        format!("{part} in {}", extent(lower, upper))
    }
}

/// A box in words: `[0, 1] x [0, 0.41] m`.
pub(super) fn extent(lower: &[f64], upper: &[f64]) -> String {
    let sides: Vec<String> = lower
        .iter()
        .zip(upper)
        .map(|(a, b)| {
            let size = a.abs().max(b.abs());
            format!("[{}, {}]", short(*a, size), short(*b, size))
        })
        .collect();
    format!("{} m", sides.join(" x "))
}

/// `x` with five digits of the size that it goes with.
pub(super) fn short(x: f64, size: f64) -> f64 {
    let unit = 10f64.powf((size.log10() - 4.0).ceil());
    let digits = if size > 0.0 { (x / unit).round() } else { 0.0 };
    // Through text: products with powers of ten have digits of their own.
    format!("{digits}e{}", unit.log10().round()).parse().unwrap_or(x)
}
