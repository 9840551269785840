//! What `undula check` tells of a case on its mesh: extents, cells, regions, boundaries, flow.

use super::functions::padded;
use super::memory::size;
use crate::case::expression::Expression;
use crate::case::{Case, Condition, MeshSource};
use crate::mesh::INTERFACE;
use crate::mesh::{Facet, Mesh};
use crate::sampling::{FacetPoint, facet_points};
use crate::space::{FsiSpace, Region};
use std::fmt;

/// A case on its mesh, in numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Overview {
    /// Corners of the box around the mesh \[m\].
    pub extents: [Vec<f64>; 2],
    /// Whether the coordinates are (r, z).
    pub around_axis: bool,
    /// Number of cells.
    pub cells: usize,
    /// Sizes of the smallest and of the largest cell \[m\], the roots of their areas, in space the third roots of their volumes.
    pub sizes: [f64; 2],
    /// Regions in use: name, number of cells, area \[m²\], in space volume \[m³\].
    pub regions: Vec<(String, usize, f64)>,
    /// The same of regions that are left out.
    pub left_out: Vec<(String, usize, f64)>,
    /// Boundaries of what is in use.
    pub boundaries: Vec<Boundary>,
    /// The flow through boundaries with given velocity; `None` if there is none.
    pub inflow: Option<Inflow>,
    /// Velocity, deformation and pressure unknowns, given ones counted.
    pub unknowns: [usize; 3],
    /// About as many bytes as a run needs.
    pub memory: f64,
    /// About as many seconds of a processor as a step takes; `None` where there are no steps.
    pub seconds: Option<f64>,
    /// What looks wrong but can be computed.
    pub warnings: Vec<String>,
    /// What should be known: regions that are left out, parts of the fluid that are closed in.
    pub notes: Vec<String>,
}

/// One digit: no more is known.
fn rounded(seconds: f64) -> f64 {
    let unit = 10f64.powf(seconds.max(1e-6).log10().floor());
    let parts = (seconds / unit).round();
    // Units of 0.1, 0.01 and so on have no exact number, their inverses do.
    if unit < 1.0 { parts / (1.0 / unit).round() } else { parts * unit }
}

/// A boundary by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Name.
    pub name: String,
    /// Length \[m\], in space area \[m²\].
    pub length: f64,
    /// Bodies that it belongs to: `fluid`, `solid`, or both.
    pub bodies: String,
    /// Its condition, as in the case.
    pub condition: String,
}

/// Flow into the domain through boundaries with given velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct Inflow {
    /// The boundary with the largest flow into the domain.
    pub name: String,
    /// Its length \[m\], in space its area \[m²\].
    pub length: f64,
    /// Largest mean over time of the normal velocity into the domain \[m/s\].
    pub mean: f64,
    /// Largest speed over time and over all boundaries \[m/s\].
    pub largest: f64,
    /// Length in the Reynolds number \[m\] and what it is.
    pub scale: (f64, &'static str),
    /// Re = mean · scale / ν_f.
    pub reynolds: f64,
    /// Largest speed · k / size of the smallest cell: at the end of the first step, and over all times with that k.
    pub cfl: Option<[f64; 2]>,
}

/// Times at which data are looked at.
const TIMES: u32 = 200;

/// A mesh file larger than this \[m\] with densities as in SI is taken for one in millimetres.
const LARGE: f64 = 10.0;
/// Density \[kg/m³\] above which the unit of length is taken for the metre: 1 in g/cm³, 1e-3 in g/mm³.
const DENSE: f64 = 100.0;

#[doc(hidden)]
impl Case {
    /// What the case is on its mesh, but for what only the complete mesh knows.
    pub fn overview<const D: usize>(&self, space: &FsiSpace<D>) -> Overview {
        let mesh = &space.mesh;
        let volume = mesh.quality().volume;
        let size = |pick: fn(f64, f64) -> f64, from: f64| root::<D>(volume.iter().copied().fold(from, pick));
        let regions = (0..mesh.regions.len()).map(|r| {
            let cells = || volume.iter().zip(&mesh.cell_region).filter(|(_, of)| usize::from(**of) == r);
            (mesh.regions[r].clone(), cells().count(), cells().map(|(area, _)| area).sum())
        });
        let extents = extents(mesh).map(|x| x.to_vec());
        Overview {
            extents: extents.clone(),
            around_axis: space.coordinates.is_axisymmetric(),
            cells: mesh.n_cells(),
            sizes: [size(f64::min, f64::INFINITY), size(f64::max, 0.0)],
            regions: regions.collect(),
            left_out: vec![],
            boundaries: self.boundaries(space),
            inflow: self.inflow(space, size(f64::min, f64::INFINITY)),
            unknowns: [space.n_v(), space.n_u(), space.n_p()],
            memory: self.expected_bytes(mesh.n_cells(), mesh.n_cells()),
            seconds: self.expected_seconds(space),
            warnings: self.looks_like_millimetres(&extents).into_iter().collect(),
            notes: vec![],
        }
    }

    fn boundaries<const D: usize>(&self, space: &FsiSpace<D>) -> Vec<Boundary> {
        let between = space.mesh.boundaries_between_regions();
        let of = |(number, name): (usize, &String)| {
            let facets = || space.mesh.facets_on(&[name]).into_iter();
            let own = space.mesh.facets.iter().any(|f| usize::from(f.boundary) == number);
            let inside = name == INTERFACE && !self.fluids.is_empty() && !self.solids.is_empty();
            let between = !inside && between.contains(&name.as_str());
            let has = |body| facets().any(|f| space.regions[f.cell as usize] == body);
            let bodies = match (inside || has(Region::Fluid), inside || has(Region::Solid)) {
                (true, true) => "fluid and solid",
                (true, false) => "fluid",
                _ => "solid",
            };
            Boundary {
                name: name.clone(),
                length: facets().map(|f| length(space, &f)).sum(),
                bodies: bodies.into(),
                condition: match self.boundary.get(name) {
                    Some(condition) => condition.name().into(),
                    None if !own => "part of the interface".into(),
                    None if inside => "coupling".into(),
                    None if between => "none, inside a body".into(),
                    None if name == INTERFACE && self.fluids.is_empty() => {
                        Condition::TractionFree.name().into()
                    }
                    // Sides of regions that are left out.
                    None if has(Region::Fluid) => Condition::NoSlip.name().into(),
                    None => Condition::Clamped.name().into(),
                },
            }
        };
        space.mesh.boundaries.iter().enumerate().map(of).collect()
    }

    /// Where most of the fluid comes in, and how fast.
    fn inflow<const D: usize>(&self, space: &FsiSpace<D>, smallest: f64) -> Option<Inflow> {
        self.fluids.first()?;
        let (mut found, mut largest, mut first) = (None::<(f64, String, [f64; 2])>, 0.0f64, 0.0f64);
        let step = self.time.as_ref().map(|time| time.step.eval(&[0.0; 3], time.start));
        for (number, name) in space.mesh.boundaries.iter().enumerate() {
            let Some(Condition::Velocity(data)) = self.boundary.get(name) else { continue };
            let facets = space.mesh.facets.iter().filter(|f| usize::from(f.boundary) == number);
            let points: Vec<_> = facets.flat_map(|facet| facet_points(space, facet, 3)).collect();
            let whole = points.iter().map(|point| point.weight).sum::<f64>();
            let length = points.iter().map(|point| point.length).sum::<f64>();
            let nodes: Vec<[f64; D]> =
                space.boundary_nodes(name).iter().map(|&node| space.nodes.points[node as usize]).collect();
            let at = |t: f64| (flow(&points, data, t), largest_speed(&nodes, data, t));
            for (flow, speed) in self.looked_at().into_iter().map(at) {
                largest = largest.max(speed);
                if found.as_ref().is_none_or(|(most, ..)| flow > *most) && flow > 0.0 {
                    found = Some((flow, name.clone(), [whole, length]));
                }
            }
            if let (Some(time), Some(k)) = (&self.time, step) {
                first = first.max(at(time.start + k).1);
            }
        }
        let (flow, name, [whole, length]) = found?;
        let mean = flow / whole;
        let scale = match self.mesh.source {
            MeshSource::TurekHron | MeshSource::SchaeferTurek | MeshSource::Dfg3d => {
                (DIAMETER, "the diameter of the cylinder")
            }
            _ if D == 3 => (length.sqrt(), "the root of the area of that boundary"),
            _ => (length, "the length of that boundary"),
        };
        Some(Inflow {
            reynolds: mean * scale.0 / self.fluid_at(space, &[&name])?.kinematic_viscosity,
            cfl: step.map(|k| [first, largest].map(|speed| speed * k / smallest)),
            name,
            length,
            mean,
            largest,
            scale,
        })
    }

    /// Times between the start and the end of the case.
    fn looked_at(&self) -> Vec<f64> {
        let Some(time) = &self.time else { return vec![self.at_time] };
        let at = |i: u32| time.start + (time.end - time.start) * f64::from(i) / f64::from(TIMES);
        (0..=TIMES).map(at).collect()
    }

    fn looks_like_millimetres(&self, [lower, upper]: &[Vec<f64>; 2]) -> Option<String> {
        let size = lower.iter().zip(upper).fold(0.0, |size: f64, (a, b)| size.max(b - a));
        let density = self.largest_density()?;
        let large = matches!(self.mesh.source, MeshSource::File(_)) && size >= LARGE && density >= DENSE;
        large.then(|| {
            format!(
                "the mesh is {} m long: if its coordinates are millimetres, give mesh.scale = 1e-3",
                short(size)
            )
        })
    }
}

/// Diameter of the cylinder in the built-in channels \[m\].
const DIAMETER: f64 = 0.1;

/// Corners of the box around a mesh.
fn extents<const D: usize>(mesh: &Mesh<D>) -> [[f64; D]; 2] {
    let along =
        |d: usize, pick: fn(f64, f64) -> f64, from: f64| mesh.nodes.iter().map(|x| x[d]).fold(from, pick);
    [
        std::array::from_fn(|d| along(d, f64::min, f64::INFINITY)),
        std::array::from_fn(|d| along(d, f64::max, f64::NEG_INFINITY)),
    ]
}

fn length<const D: usize>(space: &FsiSpace<D>, facet: &Facet) -> f64 {
    facet_points(space, facet, 3).iter().map(|point| point.length).sum()
}

/// The velocity at one place.
fn velocity<const D: usize>(data: &[Expression], x: [f64; D], t: f64) -> [f64; D] {
    std::array::from_fn(|i| data[i].eval(&padded(&x), t))
}

/// The size of something of a volume \[m^D\].
fn root<const D: usize>(volume: f64) -> f64 {
    if D == 3 { volume.cbrt() } else { volume.sqrt() }
}

/// −∫ v·n over the facets of `points` at time `t` \[m²/s\].
fn flow<const D: usize>(points: &[FacetPoint<D>], data: &[Expression], t: f64) -> f64 {
    let flow = |point: &FacetPoint<D>| {
        let v = velocity(data, point.x, t);
        -point.weight * v.iter().zip(&point.normal.0).map(|(v, n)| v * n).sum::<f64>()
    };
    points.iter().map(flow).sum()
}

/// Largest |v| at `nodes` at time `t` \[m/s\].
fn largest_speed<const D: usize>(nodes: &[[f64; D]], data: &[Expression], t: f64) -> f64 {
    let speed = |&x: &[f64; D]| velocity(data, x, t).map(|v| v * v).iter().sum::<f64>().sqrt();
    nodes.iter().map(speed).fold(0.0, f64::max)
}

/// A number with four significant digits, without zeros at its end.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

impl fmt::Display for Overview {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [lower, upper] = &self.extents;
        let [v, u, p] = self.unknowns;
        let (names, about) = if self.around_axis {
            (["r", "z", ""], ", around the axis r = 0")
        } else {
            (["x", "y", "z"], "")
        };
        let sides = names.iter().zip(lower).zip(upper);
        let sides: Vec<String> =
            sides.map(|((x, a), b)| format!("{x} from {} to {} m", short(*a), short(*b))).collect();
        writeln!(f, "          {}{about}", sides.join(", "))?;
        let [of_region, of_boundary] = if lower.len() == 3 { ["m³", "m²"] } else { ["m²", "m"] };
        let [smallest, largest] = self.sizes.map(short);
        writeln!(f, "          {} cells, sizes from {smallest} to {largest} m", self.cells)?;
        writeln!(f, "          {} unknowns: velocity {v}, deformation {u}, pressure {p}", v + u + p)?;
        let seconds =
            self.seconds.map(|seconds| format!(", about {} s of a processor for a step", rounded(seconds)));
        let memory = size(self.memory);
        writeln!(f, "          about {memory} of memory for a run{}", seconds.unwrap_or_default())?;
        for (name, cells, area) in &self.regions {
            writeln!(f, "region    {name}: {cells} cells, {} {of_region}", short(*area))?;
        }
        for (name, cells, area) in &self.left_out {
            writeln!(f, "region    {name}: {cells} cells, {} {of_region}, left out", short(*area))?;
        }
        for Boundary { name, length, bodies, condition } in &self.boundaries {
            writeln!(f, "boundary  {name}: {condition}, {} {of_boundary} ({bodies})", short(*length))?;
        }
        if let Some(inflow) = &self.inflow {
            let Inflow { name, mean, largest, scale: (scale, what), reynolds, cfl, .. } = inflow;
            writeln!(
                f,
                "inflow    {name}: mean velocity up to {} m/s, largest {} m/s",
                short(*mean),
                short(*largest)
            )?;
            writeln!(
                f,
                "          Re = {} with that mean and {} m, {what}",
                short(*reynolds),
                short(*scale)
            )?;
            if let Some([first, all]) = cfl {
                let [first, all] = [first, all].map(|x| short(*x));
                writeln!(
                    f,
                    "          CFL = {first} in the first step, {all} at the largest velocity (smallest cell)"
                )?;
            }
        }
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning   {warning}"))
    }
}
