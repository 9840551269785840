//! Rigid motions that the supports of a solid leave free, and boundaries that mirror the domain.

use super::bodies::extent;
use crate::case::{Case, Condition, MotionModel};
use crate::error::Error;
use crate::space::normals::normals;
use crate::space::{Constraints, Directions, FsiSpace, PsiOwner, Region};

/// What of the sum of squares counts as 0.
const NOTHING: f64 = 1e-12;

/// Translations along x and y, and the rotation.
type Motion = [f64; 3];

#[doc(hidden)]
impl Case {
    /// Refuses a stationary solid that can move like a rigid body: planes of symmetry and displacements with free
    /// components hold it in some directions only.
    ///
    /// # Errors
    /// [`Error::Case`] with the motion.
    pub(super) fn check_supports(&self, space: &FsiSpace<2>) -> Result<(), Error> {
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
    pub(super) fn check_mirrors(&self, space: &FsiSpace<2>) -> Result<(), Error> {
        if self.motion.model != MotionModel::Biharmonic || !space.deforms || self.fluids.is_empty() {
            return Ok(());
        }
        let constraints = Constraints::new(space, &self.conditions(&space.mesh));
        let inclined = |at: &Directions<2>| at.v && space.owner[at.node as usize] == PsiOwner::Extension;
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
    fn springs(&self, space: &FsiSpace<2>) -> Vec<(u32, [f64; 2])> {
        let mut springs = vec![];
        for (name, condition) in self.boundary.iter().filter(|(_, condition)| condition.is_elastic()) {
            let facets = space.boundary_facets(name);
            let normal = matches!(condition, Condition::Spring { normal: true, .. });
            for (node, normals) in normals(space, facets.iter()) {
                let own = normals.iter().map(|n| (node, n.0));
                let all = [[1.0, 0.0], [0.0, 1.0]].map(|n| (node, n));
                if normal { springs.extend(own) } else { springs.extend(all) }
            }
        }
        springs
    }
}

/// A rigid motion that all constraints at `nodes` let pass, in words, and the box around them. What repeats does not turn.
fn free_motion(
    space: &FsiSpace<2>,
    constraints: &Constraints<2>,
    nodes: &[u32],
    (springs, turns): (&[(u32, [f64; 2])], bool),
) -> Option<(String, [f64; 2], [f64; 2])> {
    let points = || nodes.iter().map(|&node| space.nodes.points[node as usize]);
    let lower = [0, 1].map(|d| points().map(|x| x[d]).fold(f64::INFINITY, f64::min));
    let upper = [0, 1].map(|d| points().map(|x| x[d]).fold(f64::NEG_INFINITY, f64::max));
    let centre = [0, 1].map(|d| 0.5 * (lower[d] + upper[d]));
    let size = (upper[0] - lower[0]).hypot(upper[1] - lower[1]);
    let mut squares = [[0.0; 3]; 3];
    squares[2][2] = if turns { 0.0 } else { 1.0 };
    if space.coordinates.is_axisymmetric() {
        // What moves along r is stretched around the axis, and so is what turns.
        (squares[0][0], squares[2][2]) = (1.0, 1.0);
    }
    let mut held = |node: u32, n: [f64; 2]| {
        let x = space.nodes.points[node as usize];
        let turn = (n[1] * (x[0] - centre[0]) - n[0] * (x[1] - centre[1])) / size;
        let row = [n[0], n[1], if turns { turn } else { 0.0 }];
        for (i, squares) in squares.iter_mut().enumerate() {
            (0..3).for_each(|j| squares[j] += row[i] * row[j]);
        }
    };
    for &node in nodes {
        let given = constraints.u[node as usize];
        [[1.0, 0.0], [0.0, 1.0]]
            .into_iter()
            .zip(given)
            .filter(|(_, given)| *given)
            .for_each(|(n, _)| held(node, n));
    }
    springs.iter().for_each(|(node, n)| held(*node, *n));
    for at in constraints.directions.iter().filter(|at| at.u && nodes.binary_search(&at.node).is_ok()) {
        at.normals.iter().for_each(|n| held(at.node, n.0));
    }
    let [x, y, turn] = kernel(squares)?;
    let along = x.hypot(y);
    let words = if turn.abs() < 1e-6 * along {
        // Up to rounding, with the first component that is not 0 positive.
        let sign = if x < -1e-9 * along || (x.abs() < 1e-9 * along && y < 0.0) { -1.0 } else { 1.0 };
        let [x, y] = [x, y].map(|c| (sign * c / along * 1e6).round() / 1e6 + 0.0);
        format!("moving along ({x}, {y})")
    } else {
        "turning".to_string()
    };
    Some((words, lower, upper))
}

/// A vector that the symmetric matrix maps to 0, if there is one: elimination with the largest diagonal entry first.
fn kernel(mut a: [[f64; 3]; 3]) -> Option<Motion> {
    let largest = (0..3).map(|i| a[i][i]).fold(0.0, f64::max);
    let mut done: Vec<usize> = vec![];
    for _ in 0..3 {
        let rest = (0..3).filter(|i| !done.contains(i));
        let pivot = rest.max_by(|&i, &j| a[i][i].total_cmp(&a[j][j]))?;
        if a[pivot][pivot] <= NOTHING * largest {
            // The column of this unknown in terms of those that are eliminated.
            let mut motion = [0.0; 3];
            motion[pivot] = 1.0;
            for &i in &done {
                motion[i] = -a[i][pivot] / a[i][i];
            }
            return Some(motion);
        }
        for i in (0..3).filter(|&i| i != pivot) {
            let factor = a[i][pivot] / a[pivot][pivot];
            for j in 0..3 {
                a[i][j] -= factor * a[pivot][j];
            }
        }
        done.push(pivot);
    }
    None
}
