//! From a checked case to spaces, equations and solvers.

use super::dimension::Dimension;
use super::functions::{body_force, current_force, function, motion};
use super::mesh::Marked;
use super::overview::Overview;
use super::share::Shared;
use super::terms::has_correction;
use crate::algebra::LinearSolverKind;
use crate::case::{
    Case, Condition, FluidSpec, FunctionalSpec, Load, PressureElement, SolidSpec, VelocityElement,
    WITH_MULTIGRID,
};
use crate::element::Shape;
use crate::error::Error;
use crate::functional::Functional;
use crate::functional::force::Surfaces;
use crate::functional::spatial::Spatial;
use crate::linear::{KrylovSettings, Linear};
use crate::mesh::{Facet, FacetDistance, INTERFACE, Mesh, MeshError};
use crate::nonlinear::Newton;
use crate::output::peak_memory;
use crate::parallel::Crew;
use crate::physics::Projection;
use crate::space::{
    BoundaryCondition, ClosedPressure, FibreField, FsiSpace, PressureKind, PsiOwner, Region, State, Walls,
    enclosed,
};
use crate::system::{self, Assembler, Dim, Physics};
use crate::time::{MaterialForce, Scheme, Stepper, StepperSettings};
use std::sync::Arc;

/// Functionals by name, in the order of the columns of `history.csv`.
pub type Functionals<const D: usize> = Vec<(String, Box<dyn Functional<D>>)>;

#[doc(hidden)]
impl Case {
    /// Spaces of the plane on the regions that take part.
    ///
    /// # Errors
    /// As [`Case::build_mesh`].
    pub fn build_space(&self) -> Result<FsiSpace<2>, Error> {
        self.space_in()
    }

    /// Everything that computes in the plane: assembly, Newton, linear solver and the initial state at rest.
    ///
    /// # Errors
    /// As [`Case::build_mesh`], and if the linear solver cannot be prepared.
    pub fn build_stepper(&self, threads: usize) -> Result<Stepper<2>, Error> {
        Ok(self.build_with_notes(threads, None)?.0)
    }

    /// Spaces with the hierarchy of their mesh.
    fn space_of<const D: usize>(&self, marked: &Marked<D>) -> Result<FsiSpace<D>, Error>
    where
        Dim<D>: Dimension<D>,
    {
        let mut space = self.space_on(&marked.mesh)?;
        space.hierarchy = marked.hierarchy.restrict(&self.regions());
        self.check_multigrid(&space)?;
        Ok(space)
    }

    /// Spaces on the regions of the complete `mesh` that take part; coarser meshes are not known.
    pub(crate) fn space_on<const D: usize>(&self, mesh: &Mesh<D>) -> Result<FsiSpace<D>, Error>
    where
        Dim<D>: Dimension<D>,
    {
        let mesh = mesh.restrict(&self.regions());
        let bodies = mesh.regions.iter().map(|name| self.body_in(name).unwrap_or((Region::Fluid, 0)));
        let bodies: Vec<(Region, u16)> = bodies.collect();
        let of_cells = || mesh.cell_region.iter().map(|&region| bodies[usize::from(region)]);
        let (regions, material) = of_cells().unzip();
        let pressure = match self.space.pressure {
            PressureElement::Pdc(m) => PressureKind::Pdc(m),
            PressureElement::Q(m) | PressureElement::P(m) => PressureKind::Continuous(m),
        };
        let solids = (0..).zip(&self.solids);
        let with_pressure: Vec<u16> =
            solids.filter(|(_, solid)| solid.law.is_incompressible()).map(|(n, _)| n).collect();
        let own = !with_pressure.is_empty();
        let bodies = if own { &[Region::Fluid, Region::Solid][..] } else { &[Region::Fluid] };
        let degree = self.space.velocity.degree();
        let mut space = match self.space.velocity {
            VelocityElement::P2Bubble if own => {
                let message = "bubbles are of the fluid alone, and the pressure of an incompressible solid needs them, too; take `P3`";
                return Err(self.refuse("space.velocity", message.into()));
            }
            VelocityElement::P2Bubble => FsiSpace::with_bubbles(mesh, regions, degree, pressure),
            _ => FsiSpace::with_pressure_in(mesh, regions, degree, pressure, bodies),
        };
        if self.fluids.len() > 1 || self.solids.len() > 1 {
            space = space.with_materials(material, &with_pressure);
        }
        let seams = self.seams(&space.mesh)?;
        space = space.joined(seams);
        (space.walls, space.coordinates) = (self.motion.walls, self.mesh.coordinates);
        space.fabrics.fibres = self.solids.iter().map(fibres).collect();
        // A solid deforms the domain, and so does a wall of the fluid that moves.
        let displaced = self.displaced(&space.mesh);
        let in_fluid = |facet: &Facet| space.regions[facet.cell as usize] == Region::Fluid;
        space.deforms |= space.mesh.facets_on(&displaced).iter().any(in_fluid);
        let message =
            "no node of the boundary of the fluid lies on one smooth boundary, so that nothing can slide";
        let slides = |space: &FsiSpace<D>| space.slides(&self.conditions(&space.mesh));
        if space.walls == Walls::Sliding && space.deforms && !self.fluids.is_empty() && !slides(&space) {
            return Err(self.refuse("motion.walls", message.into()));
        }
        Dim::<D>::check_axis(self, &space.mesh)?;
        self.check_patches(&space)?;
        self.check_ends(&space).map_err(Error::Case)?;
        self.check_supports(&space)?;
        self.check_mirrors(&space)?;
        self.check_drift(&space)?;
        self.check_profiles(&space)?;
        Ok(space)
    }

    /// Projections on patches need a mesh that has them.
    fn check_patches<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(), Error> {
        if !self.needs_patches() || system::patches(space).is_some() {
            return Ok(());
        }
        if space.mesh.shape == Shape::Tetrahedron {
            let message =
                "patches need children that are alike, and those of tetrahedra are not; expected `cell`";
            return Err(self.refuse("stabilization.projection", message.into()));
        }
        let parts = if D == 3 { "eight" } else { "four" };
        let message = format!(
            "the fluid does not consist of cells refined in {parts}: give mesh.refine of at least 1, or `cell`"
        );
        Err(self.refuse("stabilization.projection", message))
    }

    /// Whether the stabilisation projects on patches of cells.
    pub(super) fn needs_patches(&self) -> bool {
        self.stabilization.projects() && self.stabilization.projection == Projection::Patch
    }

    /// Parameters of the equations.
    pub fn physics(&self) -> Physics {
        let extension = self.motion.model.extension(&self.motion.numbers());
        let fluids: Vec<_> = self.fluids.iter().map(|fluid| fluid.physics(extension)).collect();
        let solids: Vec<_> = self.solids.iter().map(SolidSpec::physics).collect();
        Physics::of_several(&fluids, &solids)
    }
}

#[doc(hidden)]
impl Case {
    /// Spaces in `D` dimensions on the regions that take part.
    ///
    /// # Errors
    /// As [`Case::build_mesh`].
    pub(crate) fn space_in<const D: usize>(&self) -> Result<FsiSpace<D>, Error>
    where
        Dim<D>: Dimension<D>,
    {
        self.space_of(&self.marked_mesh()?)
    }

    /// Everything that computes in `D` dimensions, with what should be known of it: regions that are left out, parts of the
    /// fluid that are closed in. The processes of `crew` share the spaces if they can.
    ///
    /// # Errors
    /// As [`Case::build_stepper`].
    pub(crate) fn build_with_notes<const D: usize>(
        &self,
        threads: usize,
        crew: Option<&Crew>,
    ) -> Result<(Stepper<D>, Vec<String>), Error>
    where
        Dim<D>: Dimension<D>,
    {
        let engine = self.check_engine()?;
        let before = peak_memory().unwrap_or(0);
        let marked = self.marked_mesh()?;
        let space = Arc::new(self.space_of(&marked)?);
        let Marked { mut notes, .. } = marked;
        self.check_data(&space)?;
        notes.extend(self.check_enclosed(&space)?);
        let conditions = self.conditions(&space.mesh);
        let Shared { space: here, note } =
            self.share(Arc::clone(&space), &conditions, crew.map(|crew| (crew, before)));
        let mut case = self.clone();
        let apart = here.part.is_none() && crew.is_some_and(|crew| crew.size() > 1);
        if apart && case.linear.solver == LinearSolverKind::Automatic {
            // Each process would do all of it, where PETSc distributes its factors.
            case.linear.solver = LinearSolverKind::Multifrontal;
        }
        notes.extend(case.note_on_solver(&space).into_iter().chain(engine));
        notes.extend(self.notes_on_functionals());
        notes.extend(note);
        drop(space);
        Ok((case.stepper_on(here, threads)?, notes))
    }

    pub(super) fn stepper_on<const D: usize>(
        &self,
        space: Arc<FsiSpace<D>>,
        threads: usize,
    ) -> Result<Stepper<D>, Error>
    where
        Dim<D>: Dimension<D>,
    {
        let conditions = space.with_whole(|whole| self.conditions(&whole.mesh));
        let (stiffness, largest) = space.with_whole(|whole| self.stiffness(whole))?;
        let mut options = system::Options::serial(self.space.quadrature);
        options.threads = threads;
        let mut assembler =
            Assembler::try_new(space.clone(), self.physics(), &conditions, &*stiffness, &options)?;
        // Without deformation the current position is the reference position.
        let follows = |fluid: &FluidSpec| fluid.force_at_current && space.deforms;
        for (material, fluid) in (0..).zip(&self.fluids).filter(|(_, fluid)| follows(fluid)) {
            if let Some(force) = current_force(&fluid.body_force) {
                assembler.follow(material, force);
            }
        }
        assembler.stabilize(&self.stabilization, &options)?;
        self.terms(&space).into_iter().for_each(|term| assembler.add(term));
        assembler.close(closed(&space, &conditions));
        // What is left of data on the solid is rounding, see `check_ends`.
        assembler.constraints.data.retain(|(node, _)| space.owner[*node as usize] != PsiOwner::Relation);
        let make = self.make_solver(space.part.is_some());
        let scales = space.with_whole(|whole| self.scales(whole, largest));
        let krylov = |gmres| KrylovSettings { gmres, scales };
        let levels = space.with_whole(|whole| self.levels(whole));
        // Memory is that of each machine, and the decision that of all processes.
        let fits = space.with_whole(|whole| self.direct_fits(whole)).map(|fits| !space.any(!fits));
        let gmres = self.linear.krylov.or(levels.map(|_| WITH_MULTIGRID));
        let linear = Linear::new(self.newton.linearization, make)
            .with_krylov(gmres.map(krylov))
            .with_multigrid(levels, fits);
        let newton = self.build_newton(&assembler);
        let settings = StepperSettings {
            scheme: self.scheme(),
            domain_motion: self.time.as_ref().map_or_else(Default::default, |t| t.domain_motion),
            tangent: self.newton.jacobian,
            extrapolate: self.newton.extrapolate,
            max_halvings: self.time.as_ref().map_or(0, |t| t.max_halvings),
            scales,
        };
        let start = self.time.as_ref().map_or(self.at_time, |t| t.start);
        let mut initial = assembler.zero();
        let State { v, u, .. } = &mut initial;
        if self.time.is_some() {
            assembler.constraints.apply(&space, start, v, u);
        }
        let given = |load: &Load<'_>| {
            load.body == Region::Solid || !follows(&self.fluids[usize::from(load.material)])
        };
        let forces = self.loads().into_iter().filter(given).filter_map(|load| {
            let Load { body, material, .. } = load;
            Some(MaterialForce { body, material, force: body_force(load.force)? })
        });
        Ok(Stepper::new(assembler, newton, linear, settings, start, initial, forces.collect()))
    }

    /// Newton's method for `assembler`, with nothing kept.
    pub fn build_newton<const D: usize>(&self, assembler: &Assembler<D>) -> Newton {
        Newton::new(self.newton.settings, assembler.n_unknowns(), assembler.space.n_v())
    }

    fn scheme(&self) -> Scheme {
        self.time.as_ref().map_or(Scheme::BackwardEuler, |t| t.scheme)
    }

    /// Names of the boundaries along which nothing is exerted.
    pub(crate) fn smooth(&self) -> Vec<&str> {
        let smooth = self.boundary.iter().filter(|(_, c)| matches!(c, Condition::Slip | Condition::Symmetry));
        smooth.map(|(name, _)| name.as_str()).collect()
    }

    /// One condition per boundary of `mesh`.
    pub(crate) fn conditions<const D: usize>(&self, mesh: &Mesh<D>) -> Vec<BoundaryCondition<D>> {
        let both = !self.fluids.is_empty() && !self.solids.is_empty();
        let inside = mesh.boundaries_between_regions();
        let of = |name: &String| match self.boundary.get(name) {
            Some(Condition::Velocity(v)) => BoundaryCondition::Velocity(Arc::from(function(v))),
            Some(Condition::NoSlip | Condition::Clamped) => BoundaryCondition::Fixed,
            Some(Condition::Displacement(u)) => BoundaryCondition::Displacement(motion(u)),
            Some(Condition::Slip | Condition::Symmetry) => BoundaryCondition::Slip,
            Some(flux) if flux.has_profile() => BoundaryCondition::Velocity(self.profile_or_rest(mesh, name)),
            // The domain goes on: the space knows it.
            Some(Condition::Periodic(_)) => BoundaryCondition::Free,
            Some(condition) if condition.is_lumped() || has_correction(condition) => {
                BoundaryCondition::Outflow { do_nothing: true, backflow: self.against(name) }
            }
            // The load, if there is one, is among the terms of the equations. The solid is free.
            Some(_) => BoundaryCondition::Outflow { do_nothing: false, backflow: self.against(name) },
            // The interface: inside the domain, or the surface of the region that is left.
            None if name == INTERFACE && (both || self.fluids.is_empty()) => BoundaryCondition::Free,
            // Between two regions of bodies that hang together.
            None if inside.contains(&name.as_str()) => BoundaryCondition::Free,
            // Sides of regions that are left out. Names of parts of the interface are on no facet of the mesh.
            None => BoundaryCondition::Fixed,
        };
        mesh.boundaries.iter().map(of).collect()
    }

    /// Whether a displacement is given somewhere, so that there is one without a solid, too.
    pub(super) fn has_displacements(&self) -> bool {
        self.boundary.values().any(|condition| matches!(condition, Condition::Displacement(_)))
    }

    /// Boundaries of `mesh` whose displacement is given.
    fn displaced<'a, const D: usize>(&self, mesh: &'a Mesh<D>) -> Vec<&'a str> {
        let moves = |name: &&str| matches!(self.boundary.get(*name), Some(Condition::Displacement(_)));
        mesh.boundaries.iter().map(String::as_str).filter(moves).collect()
    }

    /// E_e(x) with the distance to the interface and to boundaries that are moved, and its largest value.
    #[allow(clippy::type_complexity)]
    fn stiffness<const D: usize>(
        &self,
        space: &FsiSpace<D>,
    ) -> Result<(Box<dyn Fn(&[f64; D]) -> f64>, f64), MeshError> {
        let (model, numbers) = (self.motion.model, self.motion_on(space).numbers());
        let mut moving = self.displaced(&space.mesh);
        moving.extend(space.mesh.boundary(INTERFACE).map(|_| INTERFACE));
        if !model.is_stiffened(&numbers) || !space.deforms || moving.is_empty() {
            return Ok((Box::new(|_| 1.0), 1.0));
        }
        let distance = super::periodic::nearest(space, FacetDistance::new(&space.mesh, &moving)?);
        let value = move |x: &[f64; D]| model.stiffness_at(&numbers, distance(x));
        Ok((Box::new(value), model.stiffness_at(&numbers, 0.0)))
    }

    /// The functionals of the case.
    ///
    /// # Errors
    /// Points outside of the mesh.
    pub fn build_functionals<const D: usize>(&self, space: &FsiSpace<D>) -> Result<Functionals<D>, Error> {
        let mut list: Functionals<D> = vec![];
        let conditions = space.with_whole(|whole| self.conditions(&whole.mesh));
        let surfaces = Surfaces::new(space, &conditions, self.space.quadrature + 1);
        for (name, spec) in self.functional.iter().filter(|(_, spec)| self.has_body_of(spec)) {
            let blame = |e| self.blame(&format!("functional.{name}.{}", spec.key_of(&e)), e);
            let functional = spec.build(self, space, &surfaces).map_err(blame)?;
            let spatial = D == 3 || space.coordinates.is_axisymmetric();
            let spatial = spatial && !matches!(spec, FunctionalSpec::Rotation { .. });
            let functional = if spatial { Box::new(Spatial(functional)) } else { functional };
            list.push((name.clone(), functional));
        }
        Ok(list)
    }
}

/// Pressures that are determined up to a constant.
fn closed<const D: usize>(space: &FsiSpace<D>, conditions: &[BoundaryCondition<D>]) -> Vec<ClosedPressure> {
    space.with_whole(|whole| {
        let closed = enclosed(whole, conditions).into_iter().filter(|part| !part.touches_solid);
        closed.map(|part| part.pressure(whole).part(space)).collect()
    })
}

/// The directions of the fibres of a solid, if they are a field.
fn fibres<const D: usize>(solid: &SolidSpec) -> Option<FibreField<D>> {
    solid.fibres.as_ref()?.direction.directions()
}

#[doc(hidden)]
impl Case {
    /// Builds mesh, spaces and functionals without computing anything, and says what they are.
    ///
    /// # Errors
    /// As [`Case::build_mesh`].
    pub fn check_mesh_and_measure(&self) -> Result<Overview, Error> {
        if self.mesh.dimension == 3 { self.measure::<3>() } else { self.measure::<2>() }
    }

    fn measure<const D: usize>(&self) -> Result<Overview, Error>
    where
        Dim<D>: Dimension<D>,
    {
        let marked = self.marked_mesh()?;
        let space = self.space_of::<D>(&marked)?;
        let Marked { mesh, mut notes, .. } = marked;
        self.check_data(&space)?;
        self.check_equilibrium::<D>()?;
        self.build_functionals(&space)?;
        notes.extend(self.check_enclosed(&space)?);
        notes.extend(self.note_on_solver(&space).into_iter().chain(self.note_on_engine()?));
        notes.extend(self.notes_on(&space));
        notes.extend(self.notes_on_functionals());
        let memory = self.expected_bytes(mesh.n_cells(), space.mesh.n_cells());
        Ok(Overview { left_out: self.left_out_of(&mesh), memory, notes, ..self.overview(&space) })
    }
}
