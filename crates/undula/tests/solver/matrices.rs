//! Matrices like those of the coupled problem: linearised flow and elasticity on a box of
//! rectangular cells, Q2 velocity and deformation, P1dc or Q1 pressure.

use std::sync::Arc;
use undula::algebra::{Csr, Kind, Pattern, Unknown};

const RHO: f64 = 1000.0;
const NU: f64 = 1e-3;
const K: f64 = 0.005;
const MU: f64 = 2e6;
const LAMBDA: f64 = 8e6;

#[derive(Clone, Copy, PartialEq)]
pub enum Pressure {
    P1dc,
    Q1,
}

pub struct System {
    pub a: Csr,
    pub unknowns: Vec<Unknown>,
}

/// What is put on the grid.
#[derive(Clone, Copy)]
pub struct Setup {
    /// Cells in each direction; the last is 0 in two dimensions.
    pub cells: [usize; 3],
    pub pressure: Pressure,
    /// Whether there are deformations, and a solid block in the middle of the lower wall.
    pub solid: bool,
    pub outflow: bool,
    /// Multiplies the convection; other values on the same pattern.
    pub wind: f64,
}

impl Setup {
    pub fn flow(nx: usize, ny: usize, pressure: Pressure) -> Self {
        Self { cells: [nx, ny, 0], pressure, solid: false, outflow: true, wind: 1.0 }
    }

    pub fn fsi(nx: usize, ny: usize, pressure: Pressure) -> Self {
        Self { solid: true, ..Self::flow(nx, ny, pressure) }
    }

    pub fn system(&self) -> System {
        let space = Space::new(self);
        let mut a = Csr::zeros(&space.pattern());
        for cell in 0..space.n_cells() {
            space.add(cell, &mut a);
        }
        for row in 0..space.unknowns.len() {
            if space.is_fixed(row) {
                let at = a.pattern.row(row);
                a.values[at].fill(0.0);
                let diagonal = a.pattern.find(row, row).expect("diagonal");
                a.values[diagonal] = 1.0;
            }
        }
        System { a, unknowns: space.unknowns }
    }
}

impl Setup {
    /// The flow without what belongs to one cell alone, the velocity in its middle and the slopes of its
    /// pressure: a Schur complement with one pressure per cell, of zero diagonal.
    pub fn condensed(&self) -> System {
        let space = Space::new(self);
        let inner = |cell: usize| -> Vec<u32> {
            let nodes = space.nodes(cell);
            let (v, p) = (space.v[nodes[nodes.len() / 2]], space.p[cell]);
            let d = space.d as u32;
            (v..v + d).chain(p + 1..p + 1 + d).collect()
        };
        let System { mut a, unknowns } = self.system();
        let mut keep = vec![true; unknowns.len()];
        for cell in 0..space.n_cells() {
            let inner = inner(cell);
            eliminate(&inner, &mut a);
            inner.iter().for_each(|&i| keep[i as usize] = false);
        }
        restrict(&System { a, unknowns }, &keep)
    }

    /// The velocities alone: as an extension, two components per node and no zero on the diagonal.
    pub fn velocities(&self) -> System {
        let system = self.system();
        let keep: Vec<bool> = system.unknowns.iter().map(|u| u.kind == Kind::Velocity).collect();
        restrict(&system, &keep)
    }
}

/// Subtracts from the rows of the neighbours what makes the columns of a few unknowns zero there.
fn eliminate(inner: &[u32], a: &mut Csr) {
    let pattern = Arc::clone(&a.pattern);
    let mut all: Vec<u32> = inner.iter().flat_map(|&i| pattern.columns(i as usize).to_vec()).collect();
    all.sort_unstable();
    all.dedup();
    let entry = |a: &Csr, i: u32, j: u32| pattern.find(i as usize, j as usize).map_or(0.0, |k| a.values[k]);
    let mut rows: Vec<Vec<f64>> =
        inner.iter().map(|&i| all.iter().map(|&j| entry(a, i, j)).collect()).collect();
    let place = |j: u32| all.binary_search(&j).expect("column of its own row");
    for (p, &i) in inner.iter().enumerate() {
        let at = place(i);
        let best = (p..rows.len()).max_by(|&s, &t| rows[s][at].abs().total_cmp(&rows[t][at].abs())).unwrap();
        rows.swap(p, best);
        let pivot = rows[p].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(s, _)| *s != p) {
            let factor = row[at] / pivot[at];
            row.iter_mut().zip(&pivot).for_each(|(v, w)| *v -= factor * w);
        }
        rows[p].iter_mut().for_each(|v| *v /= pivot[at]);
    }
    for &i in all.iter().filter(|i| !inner.contains(i)) {
        let factors: Vec<f64> = inner.iter().map(|&g| entry(a, i, g)).collect();
        for (&j, at) in all.iter().zip(0..) {
            if let Some(k) = pattern.find(i as usize, j as usize) {
                a.values[k] -= factors.iter().zip(&rows).map(|(f, row)| f * row[at]).sum::<f64>();
            }
        }
    }
}

/// Rows and columns of some unknowns; diagonals stay even if they are zero.
fn restrict(System { a, unknowns }: &System, keep: &[bool]) -> System {
    let mut new = vec![0; keep.len()];
    let kept: Vec<usize> = (0..keep.len()).filter(|&i| keep[i]).collect();
    kept.iter().zip(0..).for_each(|(&i, k)| new[i] = k);
    let columns = |i: usize| a.pattern.row(i).filter(move |&k| keep[a.pattern.column(i, k) as usize]);
    let rows: Vec<Vec<u32>> = kept
        .iter()
        .map(|&i| columns(i).map(|k| new[a.pattern.column(i, k) as usize]).chain([new[i]]).collect())
        .collect();
    let mut small = Csr::zeros(&Arc::new(Pattern::from_rows(&rows)));
    for &i in &kept {
        for k in columns(i) {
            add(&mut small, new[i], 0, new[a.pattern.column(i, k) as usize], 0, a.values[k]);
        }
    }
    System { a: small, unknowns: kept.iter().map(|&i| unknowns[i]).collect() }
}

/// Q2 shape functions and derivatives at the Gauss points of [0, 1]: `[point][function]`.
fn q2() -> ([f64; 3], [[f64; 3]; 3], [[f64; 3]; 3]) {
    let g = 0.5 * 0.6_f64.sqrt();
    let x = [0.5 - g, 0.5, 0.5 + g];
    let shape = x.map(|x| [(1.0 - x) * (1.0 - 2.0 * x), 4.0 * x * (1.0 - x), x * (2.0 * x - 1.0)]);
    let slope = x.map(|x| [4.0 * x - 3.0, 4.0 - 8.0 * x, 4.0 * x - 1.0]);
    (x, shape, slope)
}

struct Space {
    setup: Setup,
    d: usize,
    h: [f64; 3],
    unknowns: Vec<Unknown>,
    /// First unknown of each kind at a Q2 node or (P1dc) cell; `u32::MAX` where there is none.
    v: Vec<u32>,
    u: Vec<u32>,
    p: Vec<u32>,
    in_solid: Vec<bool>,
}

impl Space {
    fn new(setup: &Setup) -> Self {
        let d = if setup.cells[2] == 0 { 2 } else { 3 };
        let length = [2.0, 1.0, 1.0];
        let h = [0, 1, 2].map(|i| if i < d { length[i] / setup.cells[i] as f64 } else { 0.0 });
        let mut space =
            Self { setup: *setup, d, h, unknowns: vec![], v: vec![], u: vec![], p: vec![], in_solid: vec![] };
        space.number();
        space
    }

    fn n_cells(&self) -> usize {
        self.setup.cells[..self.d].iter().product()
    }

    fn split(&self, mut index: usize, sizes: impl Fn(usize) -> usize) -> [usize; 3] {
        let mut at = [0; 3];
        for i in 0..self.d {
            at[i] = index % sizes(i);
            index /= sizes(i);
        }
        at
    }

    fn nodes_along(&self, i: usize) -> usize {
        2 * self.setup.cells[i] + 1
    }

    fn cell_at(&self, cell: usize) -> [usize; 3] {
        self.split(cell, |i| self.setup.cells[i])
    }

    fn is_solid(&self, cell: usize) -> bool {
        let ([x, y, _], [nx, ny, _]) = (self.cell_at(cell), self.setup.cells);
        self.setup.solid && (2 * nx..3 * nx).contains(&(5 * x)) && 2 * y < ny
    }

    /// Q2 nodes of a cell, first direction fastest.
    fn nodes(&self, cell: usize) -> Vec<usize> {
        let at = self.cell_at(cell);
        let local = |k: usize| {
            let (mut node, mut stride) = (0, 1);
            for i in 0..self.d {
                node += stride * (2 * at[i] + k / 3_usize.pow(i as u32) % 3);
                stride *= self.nodes_along(i);
            }
            node
        };
        (0..3_usize.pow(self.d as u32)).map(local).collect()
    }

    fn number(&mut self) {
        let n_nodes: usize = (0..self.d).map(|i| self.nodes_along(i)).product();
        let (mut fluid, mut solid) = (vec![false; n_nodes], vec![false; n_nodes]);
        for cell in 0..self.n_cells() {
            let side = if self.is_solid(cell) { &mut solid } else { &mut fluid };
            self.nodes(cell).into_iter().for_each(|k| side[k] = true);
        }
        let p1dc = self.setup.pressure == Pressure::P1dc;
        (self.v, self.u) = (vec![u32::MAX; n_nodes], vec![u32::MAX; n_nodes]);
        self.p = vec![u32::MAX; if p1dc { self.n_cells() } else { n_nodes }];
        for node in 0..n_nodes {
            let grid = self.split(node, |i| self.nodes_along(i));
            let at = [0, 1, 2].map(|i| grid[i] as f64 * 0.5 * self.h[i]);
            self.v[node] = self.unknowns.len() as u32;
            self.push(node, Kind::Velocity, at, self.d);
            if self.setup.solid {
                self.u[node] = self.unknowns.len() as u32;
                self.push(node, Kind::Deformation, at, self.d);
            }
            if !p1dc && fluid[node] && grid.iter().all(|g| g % 2 == 0) {
                self.p[node] = self.unknowns.len() as u32;
                self.push(node, Kind::Pressure, at, 1);
            }
        }
        for cell in 0..if p1dc { self.n_cells() } else { 0 } {
            if !self.is_solid(cell) {
                self.p[cell] = self.unknowns.len() as u32;
                let at = self.cell_at(cell);
                let centre = [0, 1, 2].map(|i| (at[i] as f64 + 0.5) * self.h[i]);
                self.push(n_nodes + cell, Kind::Pressure, centre, self.d + 1);
            }
        }
        self.in_solid = solid;
    }

    fn push(&mut self, node: usize, kind: Kind, at: [f64; 3], times: usize) {
        self.unknowns.extend(vec![Unknown { node: node as u32, kind, at }; times]);
    }

    fn pressures(&self, cell: usize) -> Vec<u32> {
        if self.setup.pressure == Pressure::P1dc {
            return (0..=self.d as u32).map(|k| self.p[cell] + k).collect();
        }
        let nodes = self.nodes(cell);
        let corner = |k: &usize| (0..self.d).all(|i| k / 3_usize.pow(i as u32) % 3 != 1);
        (0..nodes.len()).filter(corner).map(|k| self.p[nodes[k]]).collect()
    }

    fn pattern(&self) -> Arc<Pattern> {
        let d = self.d as u32;
        let mut rows = vec![Vec::new(); self.unknowns.len()];
        let mut couple = |rows_of: &[u32], cols: &[u32]| {
            for &row in rows_of {
                rows[row as usize].extend_from_slice(cols);
            }
        };
        for cell in 0..self.n_cells() {
            let nodes = self.nodes(cell);
            let all = |first: &[u32]| -> Vec<u32> {
                nodes.iter().flat_map(|&k| (0..d).map(move |c| (k, c))).map(|(k, c)| first[k] + c).collect()
            };
            let v = all(&self.v);
            couple(&v, &v);
            if self.setup.solid {
                let u = all(&self.u);
                couple(&v, &u);
                couple(&u, &u);
                if self.is_solid(cell) {
                    couple(&u, &v);
                } else {
                    couple(&self.pressures(cell), &u);
                }
            }
            if !self.is_solid(cell) {
                let p = self.pressures(cell);
                couple(&v, &p);
                couple(&p, &v);
            }
        }
        Arc::new(Pattern::from_rows(&rows))
    }

    fn is_fixed(&self, row: usize) -> bool {
        let Unknown { kind, at, .. } = self.unknowns[row];
        let end = at[0] > 2.0 - 1e-9;
        let wall = at[0] < 1e-9 || (1..self.d).any(|i| at[i] < 1e-9 || at[i] > 1.0 - 1e-9);
        match kind {
            Kind::Velocity => wall || end && !self.setup.outflow,
            Kind::Deformation => wall || end,
            Kind::Pressure => false,
        }
    }

    /// Adds the cell's integrals, by Gauss points.
    fn add(&self, cell: usize, a: &mut Csr) {
        let d = self.d;
        let (gauss, shape, slope) = q2();
        let weights = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];
        let nodes = self.nodes(cell);
        let at = self.cell_at(cell);
        for q in 0..3_usize.pow(d as u32) {
            let q = [q % 3, q / 3 % 3, q / 9];
            let dx: f64 = (0..d).map(|i| weights[q[i]] * self.h[i]).product();
            let local = [0, 1, 2].map(|i| gauss[q[i]]);
            let x = [0, 1, 2].map(|i| (at[i] as f64 + local[i]) * self.h[i]);
            let value = |k: usize| (0..d).map(|i| shape[q[i]][k / 3_usize.pow(i as u32) % 3]).product();
            let phi: Vec<f64> = (0..nodes.len()).map(value).collect();
            let partial = |k: usize, j: usize| -> f64 {
                let of = |i: usize| {
                    let m = k / 3_usize.pow(i as u32) % 3;
                    if i == j { slope[q[i]][m] / self.h[i] } else { shape[q[i]][m] }
                };
                (0..d).map(of).product()
            };
            let grad: Vec<[f64; 3]> = (0..nodes.len())
                .map(|k| [0, 1, 2].map(|j| if j < d { partial(k, j) } else { 0.0 }))
                .collect();
            let point = Point { dx, x, local, phi, grad };
            if self.is_solid(cell) {
                self.add_solid(&nodes, &point, a);
            } else {
                self.add_fluid(cell, &nodes, &point, a);
            }
        }
    }

    fn add_fluid(&self, cell: usize, nodes: &[usize], p: &Point, a: &mut Csr) {
        let d = self.d;
        let wave = (6.0 * p.x[0]).sin();
        let wind = [p.x[1] * (1.0 - p.x[1]), 0.3 * wave, 0.1 * wave].map(|w| self.setup.wind * w);
        let pressures = self.pressures(cell);
        let xi = |k: usize| match self.setup.pressure {
            Pressure::P1dc => {
                [1.0, 2.0 * p.local[0] - 1.0, 2.0 * p.local[1] - 1.0, 2.0 * p.local[2] - 1.0][k]
            }
            Pressure::Q1 => {
                (0..d).map(|i| if k >> i & 1 == 0 { 1.0 - p.local[i] } else { p.local[i] }).product()
            }
        };
        for (m, &node) in nodes.iter().enumerate() {
            for (l, &other) in nodes.iter().enumerate() {
                let (g, h) = (p.grad[m], p.grad[l]);
                let laplace: f64 = (0..d).map(|i| g[i] * h[i]).sum();
                let along: f64 = (0..d).map(|i| wind[i] * h[i]).sum();
                let rate = p.dx * RHO * (p.phi[m] * p.phi[l] / K + NU * laplace + p.phi[m] * along);
                for i in 0..d {
                    add(a, self.v[node], i, self.v[other], i, rate);
                    for j in 0..d {
                        add(a, self.v[node], i, self.v[other], j, p.dx * RHO * NU * g[j] * h[i]);
                    }
                }
                if self.setup.solid {
                    for i in 0..d {
                        let ale = p.dx * RHO * p.phi[m] * along;
                        add(a, self.v[node], i, self.u[other], i, -ale / K);
                        add(a, self.v[node], i, self.u[other], (i + 1) % d, 0.3 * ale);
                        if !self.in_solid[node] {
                            add(a, self.u[node], i, self.u[other], i, p.dx * laplace);
                        }
                    }
                }
            }
            for (k, &pressure) in pressures.iter().enumerate() {
                for i in 0..d {
                    let div = p.dx * xi(k) * p.grad[m][i];
                    add(a, self.v[node], i, pressure, 0, -div);
                    add(a, pressure, 0, self.v[node], i, div);
                    if self.setup.solid {
                        add(a, pressure, 0, self.u[node], (i + 1) % d, 0.2 * div);
                    }
                }
            }
        }
    }

    fn add_solid(&self, nodes: &[usize], p: &Point, a: &mut Csr) {
        let d = self.d;
        for (m, &node) in nodes.iter().enumerate() {
            for (l, &other) in nodes.iter().enumerate() {
                let (g, h) = (p.grad[m], p.grad[l]);
                let mass = p.dx * p.phi[m] * p.phi[l];
                let laplace: f64 = (0..d).map(|i| g[i] * h[i]).sum();
                for i in 0..d {
                    add(a, self.v[node], i, self.v[other], i, RHO / K * mass);
                    add(a, self.v[node], i, self.u[other], i, p.dx * MU * laplace);
                    for j in 0..d {
                        let elastic = MU * g[j] * h[i] + LAMBDA * g[i] * h[j];
                        add(a, self.v[node], i, self.u[other], j, p.dx * elastic);
                    }
                    add(a, self.u[node], i, self.u[other], i, mass / K);
                    add(a, self.u[node], i, self.v[other], i, -mass);
                }
            }
        }
    }
}

struct Point {
    dx: f64,
    x: [f64; 3],
    local: [f64; 3],
    phi: Vec<f64>,
    grad: Vec<[f64; 3]>,
}

fn add(a: &mut Csr, row: u32, i: usize, col: u32, j: usize, value: f64) {
    let at = a.pattern.find(row as usize + i, col as usize + j).expect("entry of the pattern");
    a.values[at] += value;
}
