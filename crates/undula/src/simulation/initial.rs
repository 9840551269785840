//! How a simulation begins: with the last state of another run, with given fields, or in equilibrium.

use super::{Memory, Simulation};
use crate::case::{Case, Initial};
use crate::error::Error;
use crate::functional::transfer::transfer;
use crate::output::{Checkpoint, RunDirectory};
use crate::parallel::Crew;
use crate::setup::dimension::Dimension;
use crate::setup::initial::scalars;
use crate::setup::prestress::Prestress;
use crate::space::{FsiSpace, State};
use crate::system::Dim;
use crate::time::{self, Clock, Damping};
use std::path::PathBuf;

/// What a directory must be.
const EXPECTED: &str = "expected the output directory of a run in time";

/// What a simulation begins with.
enum Start {
    Rest,
    Former(Box<Former>),
    Fields,
    Static,
    Prestress,
}

/// The newest checkpoint of another run.
struct Former {
    directory: PathBuf,
    case: Case,
    checkpoint: Checkpoint,
    step: u64,
    /// Time of the checkpoint, and length of the step before it \[s\].
    clock: [f64; 2],
}

impl Simulation {
    /// Set up `case`, a case of the plane, on `threads` threads.
    ///
    /// # Errors
    /// If the case does not fit its mesh, if there is no state as it begins with, or if the linear solver cannot be
    /// prepared.
    pub fn new(case: Case, threads: usize) -> Result<Simulation, Error> {
        Dim::<2>::set_up(case, threads)
    }

    /// [`Simulation::new`] at rest, whatever the case begins with: its state comes from elsewhere.
    ///
    /// # Errors
    /// If the case does not fit its mesh, or if the linear solver cannot be prepared.
    #[doc(hidden)]
    pub fn at_rest(case: Case, threads: usize) -> Result<Simulation, Error> {
        Dim::<2>::at_rest(case, threads)
    }
}

/// Sets up simulations in a dimension. Not generic: whoever called something generic would compile all of them once more.
#[doc(hidden)]
pub trait SetUp<const D: usize>: Dimension<D> {
    /// [`Simulation::new`] in this dimension.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    fn set_up(case: Case, threads: usize) -> Result<Simulation<D>, Error> {
        Self::set_up_by(case, threads, None)
    }

    /// The same by the processes of `crew`, which share it if they can.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    fn set_up_by(case: Case, threads: usize, crew: Option<&Crew>) -> Result<Simulation<D>, Error>;

    /// The same at rest, whatever the case begins with: its state comes from elsewhere.
    ///
    /// # Errors
    /// If the case does not fit its mesh, or if the linear solver cannot be prepared.
    fn at_rest(case: Case, threads: usize) -> Result<Simulation<D>, Error> {
        Self::at_rest_by(case, threads, None)
    }

    /// The same by the processes of `crew`, which share it if they can.
    ///
    /// # Errors
    /// As [`SetUp::at_rest`].
    fn at_rest_by(case: Case, threads: usize, crew: Option<&Crew>) -> Result<Simulation<D>, Error>;
}

impl SetUp<2> for Dim<2> {
    fn set_up_by(case: Case, threads: usize, crew: Option<&Crew>) -> Result<Simulation<2>, Error> {
        Simulation::set_up(case, threads, crew)
    }

    fn at_rest_by(case: Case, threads: usize, crew: Option<&Crew>) -> Result<Simulation<2>, Error> {
        Simulation::rest(case, threads, crew)
    }
}

impl SetUp<3> for Dim<3> {
    fn set_up_by(case: Case, threads: usize, crew: Option<&Crew>) -> Result<Simulation<3>, Error> {
        Simulation::set_up(case, threads, crew)
    }

    fn at_rest_by(case: Case, threads: usize, crew: Option<&Crew>) -> Result<Simulation<3>, Error> {
        Simulation::rest(case, threads, crew)
    }
}

impl Simulation<3> {
    /// [`Simulation::new`] of a case in space.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn in_space(case: Case, threads: usize) -> Result<Simulation<3>, Error> {
        Dim::<3>::set_up(case, threads)
    }
}

impl<const D: usize> Simulation<D>
where
    Dim<D>: Dimension<D>,
{
    /// Set up `case`, whose mesh has the dimension D.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub(crate) fn set_up(
        mut case: Case,
        threads: usize,
        crew: Option<&Crew>,
    ) -> Result<Simulation<D>, Error> {
        let start = Start::of(&mut case)?;
        let mut simulation = Simulation::rest(case, threads, crew)?;
        start.begin(&mut simulation)?;
        Ok(simulation)
    }
}

/// `case` with the first time that it has: that of the checkpoint from which it starts, unless it gives one.
///
/// # Errors
/// [`Error::Case`] if there is no such checkpoint, or if the case ends before it.
pub fn with_start(mut case: Case) -> Result<Case, Error> {
    Start::of(&mut case)?;
    Ok(case)
}

impl Start {
    /// That of `case`; sets the first time of the case if another run gives it.
    ///
    /// # Errors
    /// As [`with_start`].
    fn of(case: &mut Case) -> Result<Start, Error> {
        Ok(match case.initial.clone() {
            None | Some(Initial::Static) if case.is_prestressed() => Start::Prestress,
            None => Start::Rest,
            Some(Initial::From(directory)) => Start::Former(Box::new(former(case, directory)?)),
            Some(Initial::Fields { .. }) => Start::Fields,
            Some(Initial::Static) => Start::Static,
        })
    }

    /// Takes `simulation`, which is at rest, to its start.
    ///
    /// # Errors
    /// [`Error::Case`] if there is no such state, [`Error::Breakdown`] if there is no equilibrium.
    fn begin<const D: usize>(self, simulation: &mut Simulation<D>) -> Result<(), Error>
    where
        Dim<D>: Dimension<D>,
    {
        let (space, threads) = (simulation.stepper.assembler.space.clone(), simulation.threads);
        match self {
            Start::Rest => Ok(()),
            Start::Former(former) => begin(simulation, &former),
            Start::Fields => {
                let (state, wrong) =
                    simulation.install(|simulation| simulation.case.initial_fields(&space, threads))?;
                simulation.case.record.notes.extend(wrong);
                let keys = simulation.case.initial.iter().flat_map(Initial::fields).map(|(key, _)| key);
                let note = format!(
                    "{}: the run starts with the fields of the case",
                    keys.collect::<Vec<_>>().join(", ")
                );
                at(simulation, (state, vec![]), note)
            }
            Start::Prestress => {
                let found = simulation.install(|simulation| simulation.case.prestress(&space, threads))?;
                let Prestress { state, unloading, largest, parts } = found;
                let note = match (largest == 0.0, parts) {
                    (true, _) => {
                        "solid.prestress: nothing loads the solid at the start, so that it has no stress"
                            .into()
                    }
                    (_, 1) => {
                        "solid.prestress: the run starts with the stress that balances the loads".into()
                    }
                    _ => format!(
                        "solid.prestress: the run starts with the stress that balances the loads, found in {parts} parts"
                    ),
                };
                at(simulation, (state, unloading), note)
            }
            Start::Static => {
                let found =
                    simulation.install(|simulation| simulation.case.initial_equilibrium::<D>(threads));
                let (state, parts) = found?;
                let load =
                    if parts == 1 { String::new() } else { format!(", found in {parts} parts of the load") };
                let note = format!("initial.static: the run starts with the stationary solution{load}");
                at(simulation, (state, vec![]), note)
            }
        }
    }
}

/// The simulation with `new` as its first state, with the boundary values of its first time, and with its prestress.
fn at<const D: usize>(
    simulation: &mut Simulation<D>,
    (mut new, unloading): (State, Vec<f64>),
    note: String,
) -> Result<(), Error> {
    let assembler = &simulation.stepper.assembler;
    let time = simulation.stepper.time;
    assembler.constraints.apply(&assembler.space, time, &mut new.v, &mut new.u);
    if new.s.len() < assembler.zero().s.len() {
        new.s = scalars(assembler, &new.s);
    }
    simulation.case.record.notes.push(note);
    let clock = Clock { time, last_step: 0.0, damping: Damping::default() };
    let stepper = time::Memory::of(clock, new.clone(), new);
    simulation.restore(Memory { steps: 0, stepper, adaptive: None, balance: None, unloading })
}

/// The run from which `case` starts; sets the first time of the case.
///
/// # Errors
/// As [`with_start`].
fn former(case: &mut Case, directory: PathBuf) -> Result<Former, Error> {
    let former = match Former::read(directory) {
        Ok(former) => former,
        Err(message) => return Err(case.refuse("initial.from", message)),
    };
    let given = case.record.places.contains_key("time.start");
    let now = former.clock[0];
    let ends = match &mut case.time {
        Some(time) => {
            time.start = if given { time.start } else { now };
            (time.end <= time.start).then_some(time.end)
        }
        None => None,
    };
    if let Some(end) = ends {
        let shown = former.directory.display();
        let message = format!("{end} s is not after {now} s, the time of the last checkpoint in {shown}");
        return Err(case.refuse("time.end", message));
    }
    Ok(former)
}

impl Former {
    /// The newest checkpoint that is sound, or what is wrong with the directory.
    fn read(directory: PathBuf) -> Result<Former, String> {
        let shown = directory.display();
        let run = RunDirectory::open(&directory).map_err(|error| format!("{error}; {EXPECTED}"))?;
        let latest =
            Checkpoint::load_latest(run.checkpoints()).map_err(|error| format!("{error}; {EXPECTED}"))?;
        let Some(latest) = latest else {
            return Err(format!("{shown}: there is no checkpoint; {EXPECTED} (a stationary run keeps none)"));
        };
        let name = Checkpoint::path(run.checkpoints(), latest.step).display().to_string();
        let clock = clock(&latest.checkpoint.metadata)
            .ok_or_else(|| format!("{name}: not a checkpoint of this program: its metadata have no time"))?;
        let case = Case::load(&run.case().to_string_lossy(), &[])
            .map_err(|error| format!("the case of the run cannot be read: {error}"))?;
        let (checkpoint, step) = (latest.checkpoint, latest.step);
        Ok(Former { directory, case, checkpoint, step, clock })
    }

    /// The state `name` on `space`, the space of the run.
    fn state<const D: usize>(&self, name: &str, space: &FsiSpace<D>) -> Result<State, String> {
        let field = |field: &str, n: usize| {
            let key = format!("{name}_{field}");
            let array = self.checkpoint.f64s(&key).filter(|array| array.len() == n);
            array.map(<[f64]>::to_vec).ok_or_else(|| {
                format!(
                    "{}: array {key} of its checkpoint should have {n} numbers, as its case.toml and mesh do",
                    self.directory.display()
                )
            })
        };
        Ok(State {
            v: field("v", space.n_v())?,
            u: field("u", space.n_u())?,
            p: field("p", space.n_p())?,
            s: self.checkpoint.f64s(&format!("{name}_s")).map_or(vec![], <[f64]>::to_vec),
        })
    }

    /// Solution, the solution before it, and the length of the step between them; 0 if there is none before.
    fn solution<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(State, State, f64), String>
    where
        Dim<D>: Dimension<D>,
    {
        let own: FsiSpace<D> =
            self.case.space_in().map_err(|error| format!("the case of the run: {error}"))?;
        let new = self.state("new", &own)?;
        if same(&own, space) {
            return Ok((new, self.state("old", &own)?, self.clock[1]));
        }
        let s = new.s.clone();
        let mut new = transfer(&own, &new, space).map_err(|error| {
            format!(
                "{}: {error}; expected a run on the same geometry, whose mesh and elements may be others",
                self.directory.display()
            )
        })?;
        new.s = s;
        Ok((new.clone(), new, 0.0))
    }
}

/// Time and length of the last step in the metadata of a checkpoint.
fn clock(metadata: &str) -> Option<[f64; 2]> {
    let metadata: serde_json::Value = serde_json::from_str(metadata).ok()?;
    let clock = metadata.get("clock")?;
    let number = |n: usize| clock.get(n)?.as_f64().filter(|x| x.is_finite());
    Some([number(0)?, number(1)?])
}

/// Whether unknowns mean the same.
fn same<const D: usize>(a: &FsiSpace<D>, b: &FsiSpace<D>) -> bool {
    let (one, two) = (&a.mesh, &b.mesh);
    (one.shape, one.degree) == (two.shape, two.degree)
        && one.nodes == two.nodes
        && one.cell_nodes == two.cell_nodes
        && (&a.regions, a.deforms, a.pressure.kind) == (&b.regions, b.deforms, b.pressure.kind)
        && (a.nodes.degree, a.nodes.n_lagrange) == (b.nodes.degree, b.nodes.n_lagrange)
        && a.nodes.cell_nodes == b.nodes.cell_nodes
        && a.pressure.cell_dofs == b.pressure.cell_dofs
}

/// Takes `simulation` to the state of `former`, with the boundary values of its own case at its first time.
///
/// # Errors
/// [`Error::Case`] if the run is on another geometry, or its files do not belong together.
fn begin<const D: usize>(simulation: &mut Simulation<D>, former: &Former) -> Result<(), Error>
where
    Dim<D>: Dimension<D>,
{
    let assembler = &simulation.stepper.assembler;
    let (mut new, mut old, last_step) = match former.solution(&assembler.space) {
        Ok(solution) => solution,
        Err(message) => return Err(simulation.case.refuse("initial.from", message)),
    };
    let unloading = former.checkpoint.f64s("unloading").map_or(vec![], <[f64]>::to_vec);
    let wrong = match (simulation.case.is_prestressed(), unloading.is_empty()) {
        (true, true) => Some("the run has no prestress: expected a case without solid.prestress, too"),
        (false, false) => {
            Some("the run has a prestress: expected solid.prestress = true, which takes it over")
        }
        (true, false) if last_step == 0.0 => {
            Some("a prestress is taken over on the same mesh and elements only")
        }
        _ => None,
    };
    if let Some(message) = wrong {
        return Err(simulation.case.refuse("initial.from", message.into()));
    }
    let start = assembler.zero().s;
    let others = new.s.len() != start.len();
    if others {
        (new.s, old.s) = (start.clone(), start);
    }
    let time = simulation.stepper.time;
    assembler.constraints.apply(&assembler.space, time, &mut new.v, &mut new.u);
    let how = if last_step > 0.0 { "copied" } else { "interpolated" };
    simulation.case.record.notes.push(format!(
        "initial.from: the run starts at t = {time} s with the solution of {} at t = {} s, step {}, {how}",
        former.directory.display(),
        former.clock[0],
        former.step
    ));
    if others {
        let note = "initial.from: the run has other outlets with a pressure of their own: these begin with `initial`";
        simulation.case.record.notes.push(note.into());
    }
    let clock = Clock { time, last_step, damping: Damping::default() };
    let stepper = time::Memory::of(clock, new, old);
    simulation.restore(Memory { steps: 0, stepper, adaptive: None, balance: None, unloading })
}
