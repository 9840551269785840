//! Boundaries that are one by the condition `periodic`.

use super::data::values;
use crate::case::error::{CaseError, CaseErrors};
use crate::case::expression::Expression;
use crate::case::{Case, Condition, Initial};
use crate::error::Error;
use crate::math::{Tensor, rounded, shortest};
use crate::mesh::{FacetDistance, Mesh, Seam};
use crate::space::{Constraints, FsiSpace, Region};

/// Data at two places of one node may differ by this part of their largest value.
const EQUAL: f64 = 1e-9;

/// The distance \[m\] from a place to the nearest of the facets, those beyond seams among them.
pub(super) fn nearest<const D: usize>(space: &FsiSpace<D>, facets: FacetDistance<D>) -> impl Fn(&[f64; D]) -> f64 + use<D> {
    let shifts = space.shifts();
    move |x| {
        let to = |shift: &[f64; D]| facets.distance(std::array::from_fn(|d| x[d] + shift[d]));
        shifts.iter().map(to).fold(f64::INFINITY, f64::min)
    }
}

impl Case {
    /// The facets of `mesh` that are one, those of each pair of boundaries once.
    ///
    /// # Errors
    /// [`Error::Case`] with the key of the partner if the facets of a pair do not match, or if different bodies meet.
    pub(super) fn seams<const D: usize>(&self, mesh: &Mesh<D>) -> Result<Vec<Seam<D>>, Error> {
        let mut seams = vec![];
        for (name, condition) in &self.boundary {
            let Condition::Periodic(with) = condition else { continue };
            let there = [name, with].map(|name| !mesh.facets_on(&[name]).is_empty());
            // Each pair once; sides of regions that are left out are not there.
            if name >= with || there == [false, false] {
                continue;
            }
            let key = self.partner_key(name, with);
            let found = mesh.seams([name, with]).map_err(|message| self.refuse(&key, message))?;
            let along_r = |seam: &Seam<D>| seam.shift[0].abs() > seam.shift[1].abs() * 1e-6;
            if self.mesh.coordinates.is_axisymmetric() && found.iter().any(along_r) {
                let message =
                    "a body of revolution repeats along its axis only: expected boundaries that differ in z";
                return Err(self.refuse(&key, message.into()));
            }
            for Seam { sides, .. } in &found {
                let body =
                    |cell: u32| self.body_in(&mesh.regions[usize::from(mesh.cell_region[cell as usize])]);
                let [one, two] = sides.map(|side| body(side.cell));
                if one != two {
                    let nodes = mesh.facet_nodes(sides[0].cell as usize, sides[0].local as usize);
                    let at = mesh.shown(&mesh.nodes[nodes[0] as usize]);
                    let message = format!(
                        "`{name}` and `{with}` bound different bodies at {at}: expected the same fluid or solid on both"
                    );
                    return Err(self.refuse(&key, message));
                }
            }
            seams.extend(found);
        }
        Ok(seams)
    }

    /// The key with which the case says that two boundaries are one.
    pub(super) fn partner_key(&self, name: &str, with: &str) -> String {
        let key = |name: &str| format!("boundary.{name}.with");
        let given = |name: &&str| self.record.places.contains_key(&key(name));
        key([name, with].into_iter().find(given).unwrap_or(name))
    }

    /// The mistakes of data at nodes that have different values at the places of one node.
    pub(super) fn check_repeated<const D: usize>(&self, space: &FsiSpace<D>) -> Vec<CaseError> {
        if space.seams.is_empty() {
            return vec![];
        }
        let mut errors = vec![];
        for (name, condition) in &self.boundary {
            if !matches!(condition, Condition::Velocity(_) | Condition::Displacement(_)) {
                continue;
            }
            let facets = space.boundary_facets(name);
            let on = |facet: &crate::mesh::Facet| {
                let local = space.mesh.shape.facet_nodes(space.nodes.degree, facet.local as usize);
                let cell = space.places().cell(facet.cell as usize);
                local.into_iter().map(|a| cell[a] as usize).collect::<Vec<_>>()
            };
            let mut places: Vec<usize> = facets.iter().flat_map(on).collect();
            places.sort_unstable();
            places.dedup();
            for (key, data) in condition.expressions() {
                let times = self.times(&data, true);
                errors.extend(self.differing(
                    space,
                    &format!("boundary.{name}.{key}"),
                    &data,
                    &places,
                    &times,
                ));
            }
        }
        let start = self.time.as_ref().map_or(self.at_time, |time| time.start);
        let all: Vec<usize> = (0..space.places().n_lagrange).collect();
        for (key, data) in self.initial.iter().flat_map(Initial::fields) {
            errors.extend(self.differing(space, key, data, &all, &[start]));
        }
        errors
    }

    /// The mistake that `data` differ at two of the `places` that are one node.
    fn differing<const D: usize>(
        &self,
        space: &FsiSpace<D>,
        key: &str,
        data: &[Expression],
        places: &[usize],
        times: &[f64],
    ) -> Option<CaseError> {
        let points = &space.places().points;
        let mut first = vec![usize::MAX; space.nodes.len()];
        let mut pairs = vec![];
        for &place in places {
            let other = &mut first[space.node_at(place)];
            if *other == usize::MAX { *other = place } else { pairs.push([*other, place]) }
        }
        times.iter().find_map(|&t| {
            let at = |place: usize| values(data, &points[place], t);
            let size = places.iter().flat_map(|&place| at(place)).fold(0.0, |max: f64, x| max.max(x.abs()));
            let [one, two] = *pairs.iter().find(|[one, two]| {
                at(*one).iter().zip(at(*two)).any(|(a, b)| (a - b).abs() > EQUAL * size)
            })?;
            let shown = |place: usize| {
                let value =
                    at(place).iter().map(|x| shortest(rounded(*x, size, 4))).collect::<Vec<_>>().join(", ");
                format!("({value}) at {}", space.mesh.shown(&points[place]))
            };
            let message = format!(
                "it is {} and {}, which are one point by `periodic`: expected data that repeat",
                shown(one),
                shown(two)
            );
            Some(CaseError { place: self.place_of(key), key: key.into(), value: None, message })
        })
    }

    /// Refuses a stationary flow without end or wall that holds it: any velocity may be added to it.
    pub(super) fn check_drift<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(), Error> {
        if self.time.is_some() || space.seams.is_empty() {
            return Ok(());
        }
        let constraints = Constraints::new(space, &self.conditions(&space.mesh));
        let component = space.components_by(&space.inner_facets());
        let mut parts: Vec<u32> =
            space.seams.iter().map(|seam| component[seam.sides[0].cell as usize]).collect();
        parts.sort_unstable();
        parts.dedup();
        for part in parts {
            let of_part = |&cell: &usize| component[cell] == part && space.regions[cell] == Region::Fluid;
            let mut nodes: Vec<usize> = (0..space.mesh.n_cells())
                .filter(of_part)
                .flat_map(|cell| space.nodes.cell(cell).iter().map(|&node| node as usize))
                .collect();
            nodes.sort_unstable();
            let solid = |node: &usize| space.owner[*node] == crate::space::PsiOwner::Relation;
            if nodes.is_empty() || nodes.iter().any(solid) {
                continue;
            }
            let mut squares = [[0.0; D]; D];
            let mut held =
                |n: [f64; D]| (0..D).for_each(|i| (0..D).for_each(|j| squares[i][j] += n[i] * n[j]));
            for &node in &nodes {
                let given = constraints.v[node];
                (0..D).filter(|&i| given[i]).for_each(|i| held(std::array::from_fn(|j| f64::from(i == j))));
            }
            let inclined = constraints.directions.iter().filter(|at| at.v);
            for at in inclined.filter(|at| nodes.binary_search(&(at.node as usize)).is_ok()) {
                at.normals.iter().for_each(|n| held(n.0));
            }
            let trace: f64 = (0..D).map(|i| squares[i][i]).sum();
            if Tensor(squares).det() <= 1e-12 * trace.powi(D as i32) {
                let message = "nothing holds the fluid between its periodic boundaries, so that any constant velocity along \
                               them may be added to a stationary one: expected a wall, or a case with [time]";
                return Err(Error::Case(CaseErrors(vec![CaseError {
                    place: self.place_of("boundary"),
                    key: "boundary".into(),
                    value: None,
                    message: message.into(),
                }])));
            }
        }
        Ok(())
    }
}
