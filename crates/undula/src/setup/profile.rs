//! Profiles of given flows: the fully developed velocity on the section that a boundary is.
//!
//! On the facets Γ of the fluid, with the trace of the velocity space, φ = 0 at the rim:
//! ```text
//!     (∇_Γ w, ∇_Γ φ) + i (nω/ν) (w, φ) = c (1, φ),
//! ```
//! with the weight 2π r around an axis, and c such that w N brings the flow 1 through Γ. The rim is where other boundaries meet, but for those that the flow
//! does not feel: planes of symmetry, slip walls and periodic boundaries.

use crate::algebra::{Csr, Kind, LinearSolver, MultifrontalLu, Options, Pattern, SolverError, Unknown};
use crate::case::{Case, Condition, Profile};
use crate::element::Quadrature;
use crate::error::Error;
use crate::math::Vector;
use crate::mesh::{Facet, Mesh};
use crate::sampling::facet_points_on;
use crate::space::{Coordinates, FsiSpace, Nodes, Region, VelocityData, Walls};
use std::collections::{BTreeSet, HashSet};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A section with its matrices.
pub struct Section<const D: usize> {
    /// Places of its nodes \[m\].
    pub points: Vec<[f64; D]>,
    /// ∫ φ n ds of each \[m^(D−1)\].
    areas: Vec<Vector<f64, D>>,
    /// ∫ φ² n ds of the facets themselves, along the axis at nodes on one: ∫ φ is 0 at corners of quadratic triangles.
    directions: Vec<Vector<f64, D>>,
    /// Number of each among those that are not at the rim.
    free: Vec<Option<u32>>,
    /// Entries of (∇_Γ φ_j, ∇_Γ φ_i) and (φ_j, φ_i).
    entries: Vec<(u32, u32, [f64; 2])>,
    /// (1, φ_i).
    load: Vec<f64>,
}

impl<const D: usize> Section<D> {
    /// The trace of continuous elements of `degree` on `facets`; the rim is where facets lie that `holds` is true of.
    pub fn new(
        (mesh, coordinates): (&Mesh<D>, Coordinates),
        degree: usize,
        facets: &[Facet],
        holds: impl Fn(&Facet) -> bool,
    ) -> Section<D> {
        let corners = |cell: usize| mesh.cell_vertices(cell);
        let near: HashSet<u32> = facets.iter().flat_map(|f| corners(f.cell as usize)).collect();
        let nodes = Nodes::on_cells(mesh, degree, |cell| corners(cell).iter().any(|v| near.contains(v)));
        let on_facet = |facet: &Facet| mesh.shape.facet_nodes(degree, facet.local as usize);
        let of = |facet: &Facet| {
            let cell = nodes.cell(facet.cell as usize);
            on_facet(facet).into_iter().filter_map(|a| cell.get(a).copied()).collect::<Vec<u32>>()
        };
        let own: BTreeSet<u32> = facets.iter().flat_map(of).collect();
        let own: Vec<u32> = own.into_iter().collect();
        let sides: HashSet<_> = facets.iter().map(Facet::side).collect();
        let others = mesh.facets.iter().filter(|f| !sides.contains(&f.side()) && holds(f));
        let rim: HashSet<u32> = others.flat_map(of).filter(|&node| node != u32::MAX).collect();
        let mut count = 0;
        let free = own.iter().map(|node| {
            let number = (!rim.contains(node)).then_some(count);
            count += u32::from(number.is_some());
            number
        });
        let free = free.collect();
        let (zero, load) = (vec![Vector::zero(); own.len()], vec![0.0; own.len()]);
        let points = own.iter().map(|&node| nodes.points[node as usize]).collect();
        let mut section =
            Section { points, areas: zero.clone(), directions: zero, free, entries: vec![], load };
        for facet in facets {
            let numbers: Vec<usize> =
                of(facet).iter().map(|node| own.partition_point(|n| n < node)).collect();
            section.add((mesh, coordinates), &nodes, facet, (&on_facet(facet), &numbers));
        }
        let on_axis =
            |x: &[f64; D]| coordinates.radius(x).is_some_and(|r| r.abs() <= 1e-9 * extent(&section.points));
        let on_axis: Vec<bool> = section.points.iter().map(on_axis).collect();
        for (direction, _) in section.directions.iter_mut().zip(on_axis).filter(|(_, on_axis)| *on_axis) {
            direction.0[0] = 0.0;
        }
        section
    }

    fn add(
        &mut self,
        (mesh, coordinates): (&Mesh<D>, Coordinates),
        nodes: &Nodes<D>,
        facet: &Facet,
        (local, numbers): (&[usize], &[usize]),
    ) {
        let rule = Quadrature::facet(mesh.shape, facet.local as usize, nodes.degree + D * mesh.degree);
        for point in facet_points_on((mesh, coordinates), nodes, facet, &rule) {
            let n = point.normal;
            let along = |a: usize| {
                let grad = Vector(point.grad[a]);
                grad - n * grad.dot(n)
            };
            for (&a, &i) in local.iter().zip(numbers) {
                let value = point.weight * point.value[a];
                self.areas[i] += n * value;
                self.directions[i] += n * (point.length * point.value[a] * point.value[a]);
                self.load[i] += value;
                for (&b, &j) in local.iter().zip(numbers) {
                    let stiffness = point.weight * along(a).dot(along(b));
                    self.entries.push((i as u32, j as u32, [stiffness, value * point.value[b]]));
                }
            }
        }
    }

    /// Whether a wall holds the flow.
    pub fn is_held(&self) -> bool {
        self.free.contains(&None)
    }

    /// Unit normals at the nodes.
    pub fn normals(&self) -> Vec<Vector<f64, D>> {
        let unit = |area: &Vector<f64, D>| {
            let size = area.dot(*area).sqrt();
            if size > 0.0 { *area * (1.0 / size) } else { *area }
        };
        self.directions.iter().map(unit).collect()
    }

    /// w at the nodes, real and imaginary part, for `rate` = nω/ν \[1/m²\]; \[1/m^(D−1)\].
    ///
    /// # Errors
    /// If the matrix cannot be factorised.
    pub fn profile(&self, rate: f64) -> Result<Vec<[f64; 2]>, SolverError> {
        let n = self.free.iter().flatten().count();
        let parts = if rate == 0.0 { 1 } else { 2 };
        let mut rows: Vec<Vec<u32>> = vec![vec![]; parts * n];
        let pairs = || {
            self.entries
                .iter()
                .filter_map(|&(i, j, values)| Some((self.free[i as usize]?, self.free[j as usize]?, values)))
        };
        for (i, j, _) in pairs() {
            for part in 0..parts as u32 {
                rows[(part * n as u32 + i) as usize]
                    .extend((0..parts as u32).map(|other| other * n as u32 + j));
            }
        }
        let mut matrix = Csr::zeros(&Arc::new(Pattern::from_rows(&rows)));
        // Real part: K w′ − r M w″ = c (1, φ), imaginary part: r M w′ + K w″ = 0.
        for (i, j, [stiffness, mass]) in pairs() {
            for part in 0..parts {
                for other in 0..parts {
                    let sign = if part > other { 1.0 } else { -1.0 };
                    let value = if part == other { stiffness } else { sign * rate * mass };
                    if let Some(at) = matrix.pattern.find(part * n + i as usize, other * n + j as usize) {
                        matrix.values[at] += value;
                    }
                }
            }
        }
        let mut b = vec![0.0; parts * n];
        let mut unknowns = vec![];
        for (node, (number, x)) in self.free.iter().zip(&self.points).enumerate() {
            let Some(number) = number else { continue };
            b[*number as usize] = self.load[node];
            let at = std::array::from_fn(|d| x.get(d).copied().unwrap_or(0.0));
            unknowns.push(Unknown { node: *number, kind: Kind::Velocity, at });
        }
        unknowns.extend(unknowns.clone().into_iter().filter(|_| parts == 2));
        let mut x = vec![0.0; parts * n];
        let mut solver = MultifrontalLu::multifrontal(Options::default());
        solver.analyse(&matrix.pattern, &unknowns)?;
        solver.factor(&matrix)?;
        solver.solve(&matrix, &b, &mut x)?;
        let at = |number: u32, part: usize| if part < parts { x[part * n + number as usize] } else { 0.0 };
        let w: Vec<[f64; 2]> =
            self.free.iter().map(|free| free.map_or([0.0; 2], |i| [at(i, 0), at(i, 1)])).collect();
        Ok(self.scaled(&w))
    }

    /// The same profile with the flow 1: divided by a complex number.
    fn scaled(&self, w: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let normals = self.normals();
        let through = |part: usize| -> f64 {
            let each = w.iter().zip(&normals).zip(&self.areas);
            each.map(|((w, n), area)| w[part] * n.dot(*area)).sum()
        };
        let (re, im) = (through(0), through(1));
        let size = re * re + im * im;
        w.iter().map(|[a, b]| [(a * re + b * im) / size, (b * re - a * im) / size]).collect()
    }
}

/// The velocity \[m/s\] of each frequency at a node, real and imaginary part.
type Waves<const D: usize> = Vec<[[f64; D]; 2]>;

/// The largest coordinate \[m\].
fn extent<const D: usize>(points: &[[f64; D]]) -> f64 {
    points.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// Values at nodes that are found by their places.
struct AtNodes<const D: usize> {
    /// Sorted by the coordinate `axis`.
    nodes: Vec<([f64; D], Waves<D>)>,
    axis: usize,
    close: f64,
}

impl<const D: usize> AtNodes<D> {
    fn new(points: &[[f64; D]], values: Vec<Waves<D>>) -> AtNodes<D> {
        let extent = |d: usize| {
            let along = points.iter().map(|x| x[d]);
            along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
        };
        let axis = (0..D).rev().max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        let mut nodes: Vec<_> = points.iter().copied().zip(values).collect();
        nodes.sort_by(|a, b| a.0[axis].total_cmp(&b.0[axis]));
        AtNodes { nodes, axis, close: 1e-9 * extent(axis) }
    }

    fn find(&self, x: &[f64; D]) -> Option<&Waves<D>> {
        let along = x[self.axis];
        let first = self.nodes.partition_point(|(at, _)| at[self.axis] < along - self.close);
        let near = self.nodes[first..].iter().take_while(|(at, _)| at[self.axis] <= along + self.close);
        let away = |at: &[f64; D]| at.iter().zip(x).fold(0.0, |length: f64, (a, b)| length.hypot(a - b));
        let found = near.min_by(|a, b| away(&a.0).total_cmp(&away(&b.0)));
        found.filter(|(at, _)| away(at) <= self.close).map(|(_, values)| values)
    }
}

impl Case {
    /// The facets of the fluid on the boundary `name`, with their section.
    fn section<const D: usize>(&self, mesh: &Mesh<D>, name: &str) -> Section<D> {
        let of_fluid = |facet: &Facet| {
            let region = &mesh.regions[usize::from(mesh.cell_region[facet.cell as usize])];
            self.body_in(region).is_some_and(|(body, _)| body == Region::Fluid)
        };
        let facets: Vec<Facet> = mesh.facets_on(&[name]).into_iter().filter(of_fluid).collect();
        let holds = |facet: &Facet| {
            let condition = self.boundary.get(&mesh.boundaries[usize::from(facet.boundary)]);
            !matches!(condition, Some(Condition::Slip | Condition::Symmetry | Condition::Periodic(_)))
        };
        Section::new((mesh, self.mesh.coordinates), self.space.velocity.degree(), &facets, holds)
    }

    /// ν \[m²/s\] of the fluids at the boundary `name`.
    fn viscosities<const D: usize>(&self, mesh: &Mesh<D>, name: &str) -> Vec<f64> {
        let of = |facet: &Facet| {
            let region = &mesh.regions[usize::from(mesh.cell_region[facet.cell as usize])];
            let (body, material) = self.body_in(region)?;
            (body == Region::Fluid).then(|| self.fluids[usize::from(material)].kinematic_viscosity)
        };
        let mut list: Vec<f64> = mesh.facets_on(&[name]).iter().filter_map(of).collect();
        list.dedup();
        list
    }

    /// The velocity of a given flow with a profile on the boundary `name`.
    ///
    /// # Errors
    /// If its profile cannot be computed.
    fn profile<const D: usize>(&self, mesh: &Mesh<D>, name: &str) -> Result<VelocityData<D>, SolverError> {
        let Some(Condition::Flux { flow, profile, fourier, period }) = self.boundary.get(name) else {
            return Ok(Arc::new(|_, _| [0.0; D]));
        };
        let section = self.section(mesh, name);
        let normals = section.normals();
        let steady = *profile == Profile::Parabolic;
        let terms = if steady { &[[1.0, 0.0]][..] } else { fourier };
        let nu = self.viscosities(mesh, name).first().copied().unwrap_or(1.0);
        let mut values = vec![vec![]; section.points.len()];
        for (n, [a, b]) in terms.iter().enumerate() {
            let rate = if steady { 0.0 } else { n as f64 * TAU / (period * nu) };
            for ((list, w), normal) in values.iter_mut().zip(section.profile(rate)?).zip(&normals) {
                // (a − i b) w.
                let amplitude = [a * w[0] + b * w[1], a * w[1] - b * w[0]];
                list.push(amplitude.map(|part| normal.0.map(|n| part * n)));
            }
        }
        let (at, flow, omega) = (AtNodes::new(&section.points, values), flow.clone(), TAU / period);
        Ok(Arc::new(move |x: &[f64; D], t: f64| {
            // The profile is 0 on the solid.
            let Some(terms) = at.find(x) else { return [0.0; D] };
            if steady {
                return terms[0][0].map(|v| v * flow.eval(&[0.0; 3], t));
            }
            let mut sum = [0.0; D];
            for (n, [re, im]) in terms.iter().enumerate() {
                let (sin, cos) = (n as f64 * omega * t).sin_cos();
                (0..D).for_each(|i| sum[i] += re[i] * cos - im[i] * sin);
            }
            sum
        }))
    }

    /// The same; at rest where it cannot be computed, which [`Case::check_profiles`] refuses.
    pub(super) fn profile_or_rest<const D: usize>(&self, mesh: &Mesh<D>, name: &str) -> VelocityData<D> {
        self.profile(mesh, name).unwrap_or_else(|_| Arc::new(|_, _| [0.0; D]))
    }

    /// Refuses profiles that do not exist.
    ///
    /// # Errors
    /// [`Error::Case`] for a section that no wall holds, for viscosities that are not constant, for a mesh that slides.
    pub(super) fn check_profiles<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(), Error> {
        for (name, condition) in &self.boundary {
            let Condition::Flux { profile, .. } = condition else { continue };
            if *profile == Profile::Free || space.mesh.facets_on(&[name]).is_empty() {
                continue;
            }
            let refuse =
                |message: &str| Err(self.refuse(&format!("boundary.{name}.profile"), message.into()));
            if !self.section(&space.mesh, name).is_held() {
                return refuse(
                    "no wall meets this boundary, so that there is no profile that vanishes at its rim: expected a \
                     boundary with `no-slip` at one end at least, or profile = `free`",
                );
            }
            if space.walls == Walls::Sliding && space.deforms {
                return refuse(
                    "with motion.walls = `sliding` nodes leave their places on the section, which is not yet available: \
                     expected `fixed`, or profile = `free`",
                );
            }
            let viscosities = self.viscosities(&space.mesh, name);
            let thins = self.fluids.iter().any(|fluid| fluid.thinning.is_some());
            if *profile == Profile::Womersley && (thins || viscosities.len() > 1) {
                return refuse(
                    "the profile is that of one fluid with a constant viscosity: expected fluid.law = `newtonian`, or \
                     profile = `parabolic`",
                );
            }
            let failed = self.profile(&space.mesh, name).err();
            if let Some(error) = failed {
                return refuse(&format!("its profile cannot be computed: {error}"));
            }
        }
        Ok(())
    }
}
