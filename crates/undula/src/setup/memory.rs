//! How much memory a case needs, before its mesh is made: a run that cannot fit is refused at once.

use crate::case::{
    Case, LinearSolverKind, Linearization, MeshSource, Precision, PressureElement, VelocityElement,
};
use crate::error::Error;
use crate::mesh::{Mesh, generate};
use std::fs;

/// Bytes of a run per cell at the largest size that was measured (4 000 to 31 000 cells of `fsi3`, steps with the
/// condensed system in single precision, which has the smallest factors): the need grows like N log N, so that this is
/// a lower bound for more cells.
const PER_CELL: [(VelocityElement, f64); 8] = [
    (VelocityElement::Q(1), 22.6e3),
    (VelocityElement::Q(2), 51.0e3),
    (VelocityElement::Q(3), 150.0e3),
    (VelocityElement::Q(4), 348.0e3),
    (VelocityElement::P(1), 18.9e3),
    (VelocityElement::P(2), 27.0e3),
    (VelocityElement::P2Bubble, 40.0e3),
    (VelocityElement::P(3), 78.8e3),
];

/// The same in space, per hexahedron N of Q2 (cubes of 512 and 1 728 cells, flow and body): factors grow like N^(4/3), those
/// of a thin layer more slowly.
pub(super) const IN_SPACE: [f64; 2] = [208.0e3, 37.4e3];

/// Cells in space from which on multigrid is taken if nothing is asked for: factors need 10 GB there.
pub(super) const MANY: usize = 12_000;

/// The same with multigrid, whose need grows like N.
const BY_MULTIGRID: f64 = 170.0e3;

/// Beside it the factors of a biharmonic extension, measured for `valve` in one and two layers (1 728 and 3 456 cells).
const EXTENSION: f64 = 60.0e3;

/// The whole Jacobian of a solid in space, measured for `fsi-box` with 462 to 2 470 cells.
const WHOLE_IN_SPACE: f64 = 3.5;

/// Bubbles of tetrahedra beside P2 alone, measured for `dfg-3d1z` and `tube` with 2 400 to 11 200 cells.
const BUBBLES: f64 = 1.6;

/// Flow alone in space with a continuous pressure of degree 1 and 2, measured for `dfg-3d1z` with 2 808 tetrahedra.
const CONTINUOUS: [f64; 2] = [5.0, 25.0];

/// What is safely needed of the measured bytes: other machines and libraries differ.
const SAFE: f64 = 0.85;
/// Flow alone beside both.
const FLUID_ALONE: f64 = 0.68;
/// Solid alone beside both.
const SOLID_ALONE: f64 = 0.55;
/// The whole Jacobian of a solid, and factors in double precision.
const WHOLE: f64 = 1.6;
const DOUBLE: f64 = 1.15;
/// Bytes of the mesh per cell, those included that are left out.
const MESH: f64 = 700.0;

/// Points per direction at which the share of regions of a box is taken.
const SAMPLES: u32 = 64;

#[doc(hidden)]
impl Case {
    /// Refuses a case that needs more memory than there is. `file` is the mesh that was read where there is a file.
    ///
    /// # Errors
    /// With the key to blame, and the gigabytes that are needed and at hand.
    pub(super) fn check_memory<const D: usize>(&self, file: Option<&Mesh<D>>) -> Result<(), Error> {
        let Some(at_hand) = available_memory() else { return Ok(()) };
        let is_file = matches!(self.mesh.source, MeshSource::File(_) | MeshSource::Own(_));
        if is_file != file.is_some() {
            return Ok(());
        }
        let coarse = self.coarse_cells(file);
        let refine = self.mesh.refine;
        if self.bytes(coarse, refine) <= at_hand {
            return Ok(());
        }
        let most = (0..refine).rev().find(|refine| self.bytes(coarse, *refine) <= at_hand);
        let key = match (&self.mesh.source, most) {
            (_, Some(_)) => "mesh.refine",
            (MeshSource::Box { .. } | MeshSource::Annulus { .. } | MeshSource::Tube { .. }, None) => {
                "mesh.cells"
            }
            (MeshSource::File(_), None) => "mesh.file",
            _ => "mesh",
        };
        let way_out = match most {
            Some(most) => {
                format!("{most} would need at least {}", size(self.bytes(coarse, most)))
            }
            None => "expected fewer cells".into(),
        };
        let cells = coarse.0 * self.per_refinement().powi(refine as i32);
        let [needed, at_hand] = [self.bytes(coarse, refine), at_hand].map(size);
        let message =
            format!("{cells:.0} cells need at least {needed} of memory, {at_hand} are at hand; {way_out}");
        Err(self.refuse(key, message))
    }

    /// Cells before refinement: all, and those of regions that take part.
    fn coarse_cells<const D: usize>(&self, file: Option<&Mesh<D>>) -> (f64, f64) {
        let of_mesh = |mesh: &Mesh<2>| self.cells_of(mesh);
        let layers = self.mesh.extrude.map_or(1.0, |extrude| extrude.all_layers() as f64);
        let simplices = self.space.velocity.is_simplicial();
        let grading = self.mesh.grading as usize;
        let (all, kept) = match &self.mesh.source {
            MeshSource::TurekHron => of_mesh(&generate::turek_hron(0, grading)),
            MeshSource::SchaeferTurek => of_mesh(&generate::schaefer_turek(0)),
            MeshSource::Dfg3d => of_mesh(&generate::dfg_3d(0)),
            MeshSource::Cook => of_mesh(&generate::cook(0)),
            MeshSource::Rotor => of_mesh(&generate::rotor(0, grading)),
            MeshSource::Flap => of_mesh(&generate::flap(0, grading)),
            MeshSource::Cavity => of_mesh(&generate::cavity(0)),
            MeshSource::Tube2d => of_mesh(&generate::tube_2d(0)),
            MeshSource::Valve => of_mesh(&generate::valve(0, grading)),
            MeshSource::Annulus { cells, .. } => {
                let all = cells[0] as f64 * cells[1] as f64;
                (all, all)
            }
            MeshSource::FsiBox => {
                let n = 1.0 + self.mesh.grading as f64;
                let all = (7.0 + 4.0 * n) * (4.0 + 3.0 * n) * (4.0 + 2.0 * n);
                let body = 2.0 * n * (2.0 + 2.0 * n) * (2.0 + n);
                let kept = [(self.fluids.is_empty(), all - body), (self.solids.is_empty(), body)];
                (all, kept.iter().map(|(absent, cells)| if *absent { 0.0 } else { *cells }).sum())
            }
            MeshSource::Tube { cells: [along, round, through], .. } => {
                let (n, along) = (*round as f64 / 4.0, *along as f64);
                let rings = (n / 2.0).ceil() + self.mesh.grading as f64;
                let [fluid, wall] = [n * n + 4.0 * n * rings, 4.0 * n * *through as f64];
                let kept = [(self.fluids.is_empty(), fluid), (self.solids.is_empty(), wall)];
                let kept = kept.iter().map(|(absent, cells)| if *absent { 0.0 } else { along * cells });
                (along * (fluid + wall), kept.sum())
            }
            MeshSource::Box { lower, upper, cells } => {
                let all: f64 = cells.iter().map(|n| *n as f64).product();
                (all, all * self.share_of_box(lower, upper))
            }
            MeshSource::File(_) | MeshSource::Own(_) => {
                let (all, kept) = file.map_or((0.0, 0.0), |mesh| self.cells_of(mesh));
                return (all * layers, kept * layers);
            }
        };
        let cut = if self.mesh.dimension == 3 { 6.0 * layers } else { 2.0 };
        let parts = if simplices { cut } else { layers };
        (parts * all, parts * kept)
    }

    /// All cells, and those of regions that take part.
    fn cells_of<const D: usize>(&self, mesh: &Mesh<D>) -> (f64, f64) {
        let regions: Vec<Option<u16>> = self.regions().iter().map(|name| mesh.region(name)).collect();
        let kept = mesh.cell_region.iter().filter(|region| regions.contains(&Some(**region))).count();
        (mesh.n_cells() as f64, kept as f64)
    }

    /// Cells that one becomes by a refinement; layers stay as they are.
    fn per_refinement(&self) -> f64 {
        if self.mesh.dimension == 3 && self.mesh.extrude.is_none() { 8.0 } else { 4.0 }
    }

    /// The part of a box that lies in regions that take part.
    fn share_of_box(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let regions = self.regions();
        let at =
            |d: usize, i: u32| lower[d] + (upper[d] - lower[d]) * (f64::from(i) + 0.5) / f64::from(SAMPLES);
        let layers = if lower.len() == 3 { SAMPLES } else { 1 };
        let along_z = |k: u32| if lower.len() == 3 { at(2, k) } else { 0.0 };
        let plane = move |z: f64| (0..SAMPLES * SAMPLES).map(move |i| (i % SAMPLES, i / SAMPLES, z));
        let points = (0..layers).flat_map(|k| plane(along_z(k))).map(|(i, j, z)| [at(0, i), at(1, j), z]);
        let is_kept = |x: &[f64; 3]| {
            let inside = self.mesh.region.iter().rfind(|(_, inside)| inside.eval(x, 0.0) > 0.0);
            regions.contains(&inside.map_or("fluid", |(name, _)| name.as_str()))
        };
        points.filter(is_kept).count() as f64 / f64::from(SAMPLES * SAMPLES * layers)
    }

    /// A lower bound of the bytes of a run with `coarse` cells (all, and those that take part), refined in four
    /// `refine` times.
    fn bytes(&self, coarse: (f64, f64), refine: u32) -> f64 {
        let cells = self.per_refinement().powi(refine as i32);
        let per_cell = match self.mesh.dimension {
            // Layers that are thin need hardly more.
            3 => self.in_space(1.0)[0] * self.factor(WHOLE),
            _ => self.per_plane_cell() * self.factor(WHOLE),
        };
        cells * (SAFE * per_cell * coarse.1 + MESH * coarse.0)
    }

    /// About as many bytes as a run needs at most at a time, with `all` cells of which `kept` take part.
    pub(super) fn expected_bytes(&self, all: usize, kept: usize) -> f64 {
        let run = match self.mesh.dimension {
            3 => {
                let sum = self.in_space(kept as f64).iter().sum::<f64>();
                sum * self.factor(WHOLE_IN_SPACE) * self.continuous()
            }
            _ => self.per_plane_cell() * self.factor(WHOLE) * kept as f64,
        };
        run + MESH * all as f64
    }

    /// How much more factors need on tetrahedra with a continuous pressure.
    fn continuous(&self) -> f64 {
        match self.space.pressure {
            PressureElement::P(k) if self.solids.is_empty() => CONTINUOUS[k.min(2) - 1],
            _ => 1.0,
        }
    }

    /// Hexahedra of degree 2 with as many nodes as so many cells have.
    pub(super) fn alike(&self, cells: f64) -> f64 {
        let velocity = self.space.velocity;
        let alike = cells * (velocity.degree() as f64 / 2.0).powi(3);
        match velocity {
            VelocityElement::Q(_) => alike,
            // Six tetrahedra have the nodes of one hexahedron, and bubbles beside them.
            VelocityElement::P2Bubble => alike / 6.0 * BUBBLES,
            VelocityElement::P(_) => alike / 6.0,
        }
    }

    /// Bytes of a run with so many cells in space: what grows like their number, and the factors. Other shapes and degrees
    /// count as so many hexahedra of degree 2 as they have nodes.
    fn in_space(&self, cells: f64) -> [f64; 2] {
        let alike = self.alike(cells);
        let many = self.linear.solver == LinearSolverKind::Automatic
            && self.mesh.refine > 0
            && self.time.is_some()
            && self.newton.linearization == Linearization::Condensed
            && !self.space.velocity.is_simplicial()
            && cells >= MANY as f64;
        if many || self.linear.solver == LinearSolverKind::Multigrid {
            let factors = if self.factorises_extension() { EXTENSION * alike.powf(4.0 / 3.0) } else { 0.0 };
            return [BY_MULTIGRID * alike, factors];
        }
        [IN_SPACE[0] * alike, IN_SPACE[1] * alike.powf(4.0 / 3.0)]
    }

    fn per_plane_cell(&self) -> f64 {
        let velocity = self.space.velocity;
        PER_CELL.iter().find(|(element, _)| *element == velocity).map_or(0.0, |(_, b)| *b)
    }

    /// What the equations and the solvers of the case need of the measured ones, a solid with its whole Jacobian `whole`.
    fn factor(&self, whole: f64) -> f64 {
        let condensed = self.newton.linearization == Linearization::Condensed;
        let factor = [
            (self.solids.is_empty() && !self.has_displacements(), FLUID_ALONE, 1.0),
            (self.fluids.is_empty(), SOLID_ALONE, 1.0),
            ((!self.solids.is_empty() || self.has_displacements()) && !condensed, whole, 1.0),
            (condensed && self.linear.precision == Precision::Double, DOUBLE, 1.0),
        ];
        factor.iter().map(|(holds, yes, no)| if *holds { yes } else { no }).product()
    }
}

/// Bytes in words: `120 MB`, `1.2 GB`, `34 GB`.
pub(super) fn size(bytes: f64) -> String {
    if bytes < 1e9 { format!("{:.0} MB", bytes / 1e6) } else { gigabytes(bytes) }
}

fn gigabytes(bytes: f64) -> String {
    let gigabytes = bytes / 1e9;
    if gigabytes < 10.0 { format!("{gigabytes:.1} GB") } else { format!("{gigabytes:.0} GB") }
}

/// Bytes that this process can still have, where the system tells (Linux): what is free or can be freed, swap
/// included, within the limits of its control group and of its address space.
pub fn available_memory() -> Option<f64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)).and_then(kibibytes);
    let free = line("MemAvailable:")? + line("SwapFree:").unwrap_or(0.0);
    Some([group_memory(), address_space()].into_iter().flatten().fold(free, f64::min))
}

/// Bytes of a number such as `  123 kB`.
fn kibibytes(text: &str) -> Option<f64> {
    text.trim().strip_suffix("kB")?.trim().parse().ok().map(|n: f64| 1024.0 * n)
}

/// What the limit of the control group leaves.
fn group_memory() -> Option<f64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let left = |folder: &str, limit: &str, used: &str| {
        let read = |file: &str| fs::read_to_string(format!("{folder}/{file}")).ok();
        let limit: f64 = read(limit)?.trim().parse().ok()?;
        let stat = read("memory.stat")?;
        let used = stat.lines().find_map(|line| line.strip_prefix(used)?.trim().parse::<f64>().ok())?;
        Some((limit - used).max(0.0))
    };
    let of_line = |line: &str| {
        let (number, rest) = line.split_once(':')?;
        let (kinds, path) = rest.split_once(':')?;
        // In a container the path can be that of the host: then the group is at the root.
        match (number, kinds) {
            ("0", "") => [path, ""]
                .iter()
                .find_map(|path| left(&format!("/sys/fs/cgroup{path}"), "memory.max", "anon ")),
            (_, "memory") => [path, ""].iter().find_map(|path| {
                left(&format!("/sys/fs/cgroup/memory{path}"), "memory.limit_in_bytes", "total_rss ")
            }),
            _ => None,
        }
    };
    groups.lines().filter_map(of_line).reduce(f64::min)
}

/// What the limit of the address space leaves.
fn address_space() -> Option<f64> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: f64 = line.split_whitespace().next()?.parse().ok()?;
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let used = status.lines().find_map(|line| line.strip_prefix("VmSize:")).and_then(kibibytes)?;
    Some((limit - used).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(sets: &[&str]) -> String {
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        let case = Case::builtin("fsi3", &sets).unwrap();
        case.check_memory::<2>(None).err().map_or(String::new(), |e| e.to_string())
    }

    /// Measured peaks of whole runs (bytes): the bound lies below, and not by much.
    #[test]
    fn the_bound_is_close_to_measured_peaks() {
        for (name, sets, peak) in [
            ("fsi3", &["mesh.refine=3"][..], 801.9e6),
            ("fsi3", &["mesh.refine=3", "linear.precision=double"], 960.3e6),
            ("fsi3", &["mesh.refine=3", "newton.linearization=newton"], 1672.3e6),
            ("cfd3", &["mesh.refine=3"], 501.2e6),
            ("cfd1", &["mesh.refine=3"], 503.9e6),
            ("fsi1", &["mesh.refine=3"], 2111.5e6),
            ("csm3", &["mesh.refine=4"], 182.1e6),
            ("csm1", &["mesh.refine=4"], 429.5e6),
            ("fsi3", &["mesh.refine=3", "space.velocity=Q1"], 353.4e6),
            ("fsi3", &["mesh.refine=2", "space.velocity=Q3"], 586.0e6),
            ("fsi3", &["mesh.refine=2", "space.velocity=Q4"], 1359.1e6),
            ("fsi3", &["mesh.refine=3", "space.velocity=P1"], 590.6e6),
            ("fsi3", &["mesh.refine=3", "space.velocity=P2"], 873.8e6),
            ("fsi3", &["mesh.refine=2", "space.velocity=P2-bubble"], 312.0e6),
            ("fsi3", &["mesh.refine=2", "space.velocity=P3"], 615.6e6),
        ] {
            let case = Case::builtin(name, &sets.iter().map(|s| s.to_string()).collect::<Vec<_>>()).unwrap();
            let share = case.bytes(case.coarse_cells::<2>(None), case.mesh.refine) / peak;
            assert!((0.5..1.0).contains(&share), "{name} {sets:?}: {share:.2} of the peak");
        }
    }

    const TWO: &str = "mesh.extrude.layers=2";
    const THIN: &str = "mesh.extrude.grading=0";

    /// Measured peaks of whole runs in space (bytes): expected up to a factor of two, and the bound lies below.
    #[test]
    fn peaks_in_space_are_expected() {
        for (name, sets, cells, peak) in [
            ("dfg-3d1z", &["mesh.extrude.layers=8", "mesh.extrude.grading=0"][..], 1872, 832e6),
            ("dfg-3d1z", &["mesh.extrude.layers=4", "mesh.extrude.grading=0"], 936, 306e6),
            ("fsi-box", &["mesh.grading=0"], 462, 702e6),
            ("fsi-box", &["mesh.grading=1"], 1200, 2.6e9),
            ("tube", &["mesh.cells=[40, 8, 1]", "mesh.grading=0"], 800, 417e6),
            ("tube", &[], 1800, 870e6),
            ("tube", &["mesh.cells=[20, 8, 1]", "mesh.grading=0", "space.velocity=P2"], 2400, 310e6),
            ("tube", &["mesh.cells=[20, 8, 1]", "mesh.grading=0", "space.velocity=P2-bubble"], 2400, 320e6),
            ("fsi-box", &["mesh.grading=0", "space.velocity=P2"], 2772, 708e6),
            ("dfg-3d1z", &[TWO, THIN, "space.velocity=P2"], 2808, 825e6),
            ("dfg-3d1z", &[TWO, THIN, "space.velocity=P2-bubble"], 2808, 180e6),
            ("dfg-3d1z", &["mesh.extrude.layers=8", THIN, "space.velocity=P2-bubble"], 11232, 1384e6),
        ] {
            let case = Case::builtin(name, &sets.iter().map(|s| s.to_string()).collect::<Vec<_>>()).unwrap();
            let share = case.expected_bytes(cells, cells) / peak;
            assert!((0.5..2.0).contains(&share), "{name} {sets:?}: {share:.2} of the peak");
            let bound = case.bytes(case.coarse_cells::<3>(None), case.mesh.refine) / peak;
            assert!(bound < 1.0, "{name} {sets:?}: {bound:.2} of the peak");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_cannot_fit_is_refused_with_key_and_gigabytes() {
        let at_hand = available_memory().unwrap();
        assert!(at_hand > 1e7 && at_hand < 1e14, "{at_hand}");
        let said = message(&["mesh.refine=10"]);
        for word in ["--set mesh.refine=10", "255852544 cells", "need at least", "GB are at hand"] {
            assert!(said.contains(word), "{said}");
        }
        let cells =
            ["mesh.generator=box", "mesh.lower=[0,0]", "mesh.upper=[1,1]", "mesh.cells=[100000,100000]"];
        let said = message(&[&cells[..], &["mesh.refine=0", "mesh.region.solid=x-0.5"]].concat());
        assert!(said.contains("--set mesh.cells") && said.contains("fewer cells"), "{said}");
        assert_eq!(message(&["mesh.refine=2"]), "");
    }
}
