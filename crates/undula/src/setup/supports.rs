//! Rigid motions that the supports of a solid leave free, and boundaries that mirror the domain.

use super::bodies::extent;
use crate::case::{Case, Condition, MotionModel};
use crate::error::Error;
use crate::space::normals::normals;
use crate::space::{Constraints, Directions, FsiSpace, PsiOwner, Region};

/// What of the sum of squares counts as 0.
const NOTHING: f64 = 1e-12;

/// Axes of the rotations in three dimensions, by the coordinates that they turn into each other; in the plane the first.
const TURNS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

#[doc(hidden)]
impl Case {
    /// Refuses a stationary solid that can move like a rigid body: planes of symmetry and displacements with free
    /// components hold it in some directions only.
    ///
    /// # Errors
    /// [`Error::Case`] with the motion.
    pub(super) fn check_supports<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(), Error> {
        if self.time.is_some() || self.solids.is_empty() {
            return Ok(());
        }
        let constraints = Constraints::new(space, &self.conditions(&space.mesh));
        let component = space.components_by(&space.inner_facets());
        let mut parts: Vec<u32> = vec![];
        for cell in (0..space.mesh.n_cells()).filter(|&cell| space.regions[cell] == Region::Solid) {
            if !parts.contains(&component[cell]) {
                parts.push(component[cell]);
            }
        }
        let springs = self.springs(space);
        for &part in &parts {
            let cells = (0..space.mesh.n_cells()).filter(|&cell| component[cell] == part);
            let mut nodes: Vec<u32> = cells.flat_map(|cell| space.nodes.cell(cell).iter().copied()).collect();
            nodes.sort_unstable();
            nodes.dedup();
            let springs: Vec<_> =
                springs.iter().filter(|(node, _)| nodes.binary_search(node).is_ok()).copied().collect();
            let turns = !space.seams.iter().any(|seam| component[seam.sides[0].cell as usize] == part);
            let free = free_motion(space, &constraints, &nodes, (&springs, turns));
            let Some((motion, lower, upper)) = free else { continue };
            let subject = match parts.len() {
                1 => "the solid".to_string(),
                _ => format!("the part of the solid in {}", extent(&lower, &upper)),
            };
            let message = format!(
                "nothing holds {subject} against {motion}, so it has no stationary state: expected a boundary with \
                 condition = `clamped`, or another plane of symmetry or spring"
            );
            return Err(self.refuse("solid", message));
        }
        Ok(())
    }
}

#[doc(hidden)]
impl Case {
    /// Refuses the biharmonic extension beside inclined or curved boundaries with `slip` or `symmetry`: its second unknown
    /// is mirrored along axes only.
    ///
    /// # Errors
    /// [`Error::Case`] if there is such a boundary of a fluid that deforms.
    pub(super) fn check_mirrors<const D: usize>(&self, space: &FsiSpace<D>) -> Result<(), Error> {
        if self.motion.model != MotionModel::Biharmonic || !space.deforms || self.fluids.is_empty() {
            return Ok(());
        }
        let constraints = Constraints::new(space, &self.conditions(&space.mesh));
        let inclined = |at: &Directions<D>| at.v && space.owner[at.node as usize] == PsiOwner::Extension;
        if constraints.directions.iter().any(inclined) {
            let message = "a boundary of the fluid with `slip` or `symmetry` is inclined or curved, and this extension is \
                           mirrored along axes only; take `pseudo-elastic`";
            return Err(self.refuse("motion.model", message.into()));
        }
        Ok(())
    }
}

impl Case {
    /// Nodes on springs with the directions in which they act.
    fn springs<const D: usize>(&self, space: &FsiSpace<D>) -> Vec<(u32, [f64; D])> {
        let mut springs = vec![];
        for (name, condition) in self.boundary.iter().filter(|(_, condition)| condition.is_elastic()) {
            let facets = space.boundary_facets(name);
            let normal = matches!(condition, Condition::Spring { normal: true, .. });
            for (node, normals) in normals(space, facets.iter()) {
                let own = normals.iter().map(|n| (node, n.0));
                let all = axes().into_iter().map(|n| (node, n));
                if normal { springs.extend(own) } else { springs.extend(all) }
            }
        }
        springs
    }
}

/// Unit vectors along the coordinates.
fn axes<const D: usize>() -> [[f64; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
}

/// A rigid motion that all constraints at `nodes` let pass, in words, and the box around them. What repeats does not turn.
fn free_motion<const D: usize>(
    space: &FsiSpace<D>,
    constraints: &Constraints<D>,
    nodes: &[u32],
    (springs, turns): (&[(u32, [f64; D])], bool),
) -> Option<(String, [f64; D], [f64; D])> {
    let points = || nodes.iter().map(|&node| space.nodes.points[node as usize]);
    let lower: [f64; D] = std::array::from_fn(|d| points().map(|x| x[d]).fold(f64::INFINITY, f64::min));
    let upper: [f64; D] = std::array::from_fn(|d| points().map(|x| x[d]).fold(f64::NEG_INFINITY, f64::max));
    let centre: [f64; D] = std::array::from_fn(|d| 0.5 * (lower[d] + upper[d]));
    let size = (0..D).fold(0.0, |size: f64, d| size.hypot(upper[d] - lower[d]));
    let rotations = &TURNS[..D * (D - 1) / 2];
    let all = D + rotations.len();
    let mut squares = vec![vec![0.0; all]; all];
    for turn in D..all {
        squares[turn][turn] = if turns { 0.0 } else { 1.0 };
    }
    if space.coordinates.is_axisymmetric() {
        // What moves along r is stretched around the axis, and so is what turns.
        (squares[0][0], squares[2][2]) = (1.0, 1.0);
    }
    let mut held = |node: u32, n: [f64; D]| {
        let x = space.nodes.points[node as usize];
        let turn = |[i, j]: [usize; 2]| (n[j] * (x[i] - centre[i]) - n[i] * (x[j] - centre[j])) / size;
        let turned = rotations.iter().map(|axis| if turns { turn(*axis) } else { 0.0 });
        let row: Vec<f64> = n.iter().copied().chain(turned).collect();
        for (i, squares) in squares.iter_mut().enumerate() {
            (0..all).for_each(|j| squares[j] += row[i] * row[j]);
        }
    };
    for &node in nodes {
        let given = constraints.u[node as usize];
        axes()
            .into_iter()
            .zip(given)
            .filter(|(_, given)| *given)
            .for_each(|(n, _)| held(node, n));
    }
    springs.iter().for_each(|(node, n)| held(*node, *n));
    for at in constraints.directions.iter().filter(|at| at.u && nodes.binary_search(&at.node).is_ok()) {
        at.normals.iter().for_each(|n| held(at.node, n.0));
    }
    let motion = kernel(squares)?;
    let (moved, turned) = motion.split_at(D);
    let length = |part: &[f64]| part.iter().fold(0.0, |length: f64, x| length.hypot(*x));
    let along = length(moved);
    let words = if length(turned) < 1e-6 * along {
        // Up to rounding, with the first component that is not 0 positive.
        let first = moved.iter().find(|x| x.abs() >= 1e-9 * along).copied().unwrap_or(1.0);
        let shown = |c: &f64| ((first.signum() * c / along * 1e6).round() / 1e6 + 0.0).to_string();
        format!("moving along ({})", moved.iter().map(shown).collect::<Vec<_>>().join(", "))
    } else {
        "turning".to_string()
    };
    Some((words, lower, upper))
}

/// A vector that the symmetric matrix maps to 0, if there is one: elimination with the largest diagonal entry first.
fn kernel(mut a: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = a.len();
    let largest = (0..n).map(|i| a[i][i]).fold(0.0, f64::max);
    let mut done: Vec<usize> = vec![];
    for _ in 0..n {
        let rest = (0..n).filter(|i| !done.contains(i));
        let pivot = rest.max_by(|&i, &j| a[i][i].total_cmp(&a[j][j]))?;
        if a[pivot][pivot] <= NOTHING * largest {
            // The column of this unknown in terms of those that are eliminated.
            let mut motion = vec![0.0; n];
            motion[pivot] = 1.0;
            for &i in &done {
                motion[i] = -a[i][pivot] / a[i][i];
            }
            return Some(motion);
        }
        for i in (0..n).filter(|&i| i != pivot) {
            let factor = a[i][pivot] / a[pivot][pivot];
            for j in 0..n {
                a[i][j] -= factor * a[pivot][j];
            }
        }
        done.push(pivot);
    }
    None
}
