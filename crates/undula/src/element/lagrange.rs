//! Nodal bases on equidistant nodes: Q_k on tensor-product cells, P_k on simplices; and their bubbles.

use super::Shape;

/// Values and derivatives of the 1D Lagrange basis of degree `k` at `x` in `[0, 1]`, each of length `k + 1`.
pub fn basis_1d(k: usize, x: f64) -> (Vec<f64>, Vec<f64>) {
    if k == 0 {
        return (vec![1.0], vec![0.0]);
    }
    let node = |i: usize| i as f64 / k as f64;
    let mut value = vec![1.0; k + 1];
    let mut slope = vec![0.0; k + 1];
    for i in 0..=k {
        for j in (0..=k).filter(|&j| j != i) {
            value[i] *= (x - node(j)) / (node(i) - node(j));
            let mut product = 1.0 / (node(i) - node(j));
            for l in (0..=k).filter(|&l| l != i && l != j) {
                product *= (x - node(l)) / (node(i) - node(l));
            }
            slope[i] += product;
        }
    }
    (value, slope)
}

/// Values `[a]` and gradients `[a][d]` of the basis of `shape` at `xi`, nodes in the order of [`Shape`].
pub fn basis(shape: Shape, k: usize, xi: &[f64]) -> (Vec<f64>, Vec<[f64; 3]>) {
    if shape == Shape::Triangle {
        return triangle(k, [xi[0], xi[1]]);
    }
    if shape == Shape::Tetrahedron {
        return tetrahedron(k, [xi[0], xi[1], xi[2]]);
    }
    let factors: Vec<_> = (0..shape.dim()).map(|d| basis_1d(k, xi[d])).collect();
    let n = shape.n_nodes(k);
    let (mut value, mut grad) = (vec![1.0; n], vec![[0.0; 3]; n]);
    for a in 0..n {
        let at = shape.lattice(k, a);
        for d in 0..shape.dim() {
            value[a] *= factors[d].0[at[d]];
            grad[a][d] = 1.0;
            for e in 0..shape.dim() {
                grad[a][d] *= if e == d { factors[e].1[at[e]] } else { factors[e].0[at[e]] };
            }
        }
    }
    (value, grad)
}

/// Π_{m<n} (k s − m)/(m + 1), which is 1 at s = n/k and 0 at the n nodes before it, and its derivative.
fn factor(k: usize, n: usize, s: f64) -> (f64, f64) {
    let (mut value, mut slope) = (1.0, 0.0);
    for m in 0..n {
        let (scale, next) = (k as f64 / (m + 1) as f64, (k as f64 * s - m as f64) / (m + 1) as f64);
        slope = slope * next + value * scale;
        value *= next;
    }
    (value, slope)
}

/// The P_k basis of a triangle at `xi`: products of one factor in each barycentric coordinate.
fn triangle(k: usize, [x, y]: [f64; 2]) -> (Vec<f64>, Vec<[f64; 3]>) {
    let node = |a: usize| {
        let [i, j, _] = Shape::Triangle.lattice(k, a);
        let [(u, u_x), (v, v_y), (w, w_s)] =
            [(i, x), (j, y), (k - i - j, 1.0 - x - y)].map(|(n, s)| factor(k, n, s));
        (u * v * w, [v * (u_x * w - u * w_s), u * (v_y * w - v * w_s), 0.0])
    };
    (0..Shape::Triangle.n_nodes(k)).map(node).unzip()
}

/// The P_k basis of a tetrahedron at `xi`, in the same way.
fn tetrahedron(k: usize, [x, y, z]: [f64; 3]) -> (Vec<f64>, Vec<[f64; 3]>) {
    let node = |a: usize| {
        let [i, j, l] = Shape::Tetrahedron.lattice(k, a);
        let last = (k - i - j - l, 1.0 - x - y - z);
        let [(s, s_x), (t, t_y), (u, u_z), (v, v_s)] =
            [(i, x), (j, y), (l, z), last].map(|(n, s)| factor(k, n, s));
        let slope = [t * u * (s_x * v - s * v_s), s * u * (t_y * v - t * v_s), s * t * (u_z * v - u * v_s)];
        (s * t * u * v, slope)
    };
    (0..Shape::Tetrahedron.n_nodes(k)).map(node).unzip()
}

/// Number of bubbles beside the quadratic basis of a simplex: that of a triangle; those of the faces of a tetrahedron
/// and of its inside.
pub const fn n_bubbles(shape: Shape) -> usize {
    match shape {
        Shape::Triangle => 1,
        Shape::Tetrahedron => 5,
        _ => 0,
    }
}

/// The bubbles of a simplex at `xi` with their gradients: the cubic one of a triangle; of a tetrahedron the cubic ones
/// 27 Π_{i≠l} λ_i of the faces l, which are 0 on the other faces, and 256 λ_0 λ_1 λ_2 λ_3.
pub fn bubbles(shape: Shape, xi: &[f64; 3]) -> Vec<(f64, [f64; 3])> {
    match shape {
        Shape::Triangle => {
            let (value, [x, y]) = bubble([xi[0], xi[1]]);
            vec![(value, [x, y, 0.0])]
        }
        Shape::Tetrahedron => (0..5).map(|l| product_of_barycentric(l, xi)).collect(),
        _ => vec![],
    }
}

/// Second derivatives of [`bubbles`].
pub fn bubble_hessians(shape: Shape, xi: &[f64; 3]) -> Vec<[[f64; 3]; 3]> {
    match shape {
        Shape::Triangle => vec![bubble_hessian([xi[0], xi[1]])],
        Shape::Tetrahedron => (0..5).map(|l| hessian_of_barycentric(l, xi)).collect(),
        _ => vec![],
    }
}

/// The barycentric coordinates that are factors of bubble `l` of a tetrahedron with their gradients, and its scale.
fn factors(l: usize, xi: &[f64; 3]) -> (Vec<(f64, [f64; 3])>, f64) {
    let first = (1.0 - xi.iter().sum::<f64>(), [-1.0; 3]);
    let unit = |d: usize| std::array::from_fn(|e| if d == e { 1.0 } else { 0.0 });
    let others = (0..3).map(|d| (xi[d], unit(d)));
    let list = std::iter::once(first).chain(others).enumerate().filter(|(i, _)| *i != l);
    (list.map(|(_, factor)| factor).collect(), if l < 4 { 27.0 } else { 256.0 })
}

fn product_of_barycentric(l: usize, xi: &[f64; 3]) -> (f64, [f64; 3]) {
    let (list, scale) = factors(l, xi);
    let mut found = (scale, [0.0; 3]);
    for (value, slope) in list {
        (0..3).for_each(|d| found.1[d] = found.1[d] * value + found.0 * slope[d]);
        found.0 *= value;
    }
    found
}

fn hessian_of_barycentric(l: usize, xi: &[f64; 3]) -> [[f64; 3]; 3] {
    let (list, scale) = factors(l, xi);
    let mut found = [[0.0; 3]; 3];
    for i in 0..list.len() {
        for j in (0..list.len()).filter(|&j| j != i) {
            let rest: f64 = (0..list.len()).filter(|&m| m != i && m != j).map(|m| list[m].0).product();
            for d in 0..3 {
                (0..3).for_each(|e| found[d][e] += scale * rest * list[i].1[d] * list[j].1[e]);
            }
        }
    }
    found
}

/// The cubic bubble 27 λ_0 λ_1 λ_2 of a triangle at `xi` and its gradient: 1 at the centre, 0 on all edges.
pub fn bubble([x, y]: [f64; 2]) -> (f64, [f64; 2]) {
    let z = 1.0 - x - y;
    (27.0 * x * y * z, [27.0 * y * (z - x), 27.0 * x * (z - y)])
}

/// Second derivatives of the bubble.
pub fn bubble_hessian([x, y]: [f64; 2]) -> [[f64; 3]; 3] {
    let mixed = 27.0 * (1.0 - 2.0 * x - 2.0 * y);
    [[-54.0 * y, mixed, 0.0], [mixed, -54.0 * x, 0.0], [0.0; 3]]
}

/// Reference coordinates of node `a` of degree `k`.
pub fn node(shape: Shape, k: usize, a: usize) -> [f64; 3] {
    if k == 0 {
        return shape.centre();
    }
    shape.lattice(k, a).map(|i| i as f64 / k as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bubble_vanishes_on_edges_and_is_one_in_the_middle() {
        for s in [0.0, 0.3, 1.0] {
            for at in [[s, 0.0], [0.0, s], [s, 1.0 - s]] {
                assert!(bubble(at).0.abs() < 1e-15);
            }
        }
        assert!((bubble([1.0 / 3.0; 2]).0 - 1.0).abs() < 1e-15);
        let (at, h) = ([0.3, 0.21], 1e-6);
        let along_x = (bubble([at[0] + h, at[1]]).0 - bubble([at[0] - h, at[1]]).0) / (2.0 * h);
        let along_y = (bubble([at[0], at[1] + h]).0 - bubble([at[0], at[1] - h]).0) / (2.0 * h);
        let [x, y] = bubble(at).1;
        assert!((x - along_x).abs() < 1e-8 && (y - along_y).abs() < 1e-8);
        for e in 0..2 {
            let slope = |s: f64| bubble(std::array::from_fn(|d| at[d] + if d == e { s } else { 0.0 })).1;
            let (plus, minus) = (slope(h), slope(-h));
            for d in 0..2 {
                let difference = (plus[d] - minus[d]) / (2.0 * h);
                assert!((bubble_hessian(at)[d][e] - difference).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn bubbles_of_tetrahedra_stand_on_their_faces_alone() {
        let shape = Shape::Tetrahedron;
        for node in 0..shape.n_nodes(5) {
            let at = shape.lattice(5, node).map(|i| i as f64 / 5.0);
            for (l, (value, _)) in bubbles(shape, &at).into_iter().enumerate() {
                let others = (0..4).filter(|f| *f != l).any(|f| shape.on_facet(5, node, f));
                assert!(!others || value.abs() < 1e-14, "{l} at {at:?}: {value}");
            }
        }
        let thirds = [[1.0 / 3.0; 3], [0.0, 1.0 / 3.0, 1.0 / 3.0]];
        assert!((bubbles(shape, &thirds[0])[0].0 - 1.0).abs() < 1e-14);
        assert!((bubbles(shape, &thirds[1])[1].0 - 1.0).abs() < 1e-14);
        assert!((bubbles(shape, &[0.25; 3])[4].0 - 1.0).abs() < 1e-14);
        let (at, h) = ([0.3, 0.21, 0.17], 1e-6);
        for e in 0..3 {
            let moved =
                |s: f64| bubbles(shape, &std::array::from_fn(|d| at[d] + if d == e { s } else { 0.0 }));
            let (plus, minus) = (moved(h), moved(-h));
            let here = bubbles(shape, &at);
            for (l, hessian) in bubble_hessians(shape, &at).into_iter().enumerate() {
                assert!((here[l].1[e] - (plus[l].0 - minus[l].0) / (2.0 * h)).abs() < 1e-7);
                for d in 0..3 {
                    assert!((hessian[d][e] - (plus[l].1[d] - minus[l].1[d]) / (2.0 * h)).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn nodality_partition_of_unity_and_gradients() {
        for shape in [Shape::Triangle, Shape::Quadrilateral, Shape::Tetrahedron, Shape::Hexahedron] {
            for k in 1..5 {
                for a in 0..shape.n_nodes(k) {
                    let (value, _) = basis(shape, k, &node(shape, k, a));
                    for (b, v) in value.iter().enumerate() {
                        assert!((v - if a == b { 1.0 } else { 0.0 }).abs() < 1e-13);
                    }
                }
                let xi = [0.3, 0.61, 0.44];
                let (value, grad) = basis(shape, k, &xi);
                assert!((value.iter().sum::<f64>() - 1.0).abs() < 1e-13);
                for d in 0..shape.dim() {
                    let moved = |h: f64| {
                        let mut at = xi;
                        at[d] += h;
                        basis(shape, k, &at).0
                    };
                    let (plus, minus) = (moved(1e-6), moved(-1e-6));
                    for a in 0..value.len() {
                        assert!((grad[a][d] - (plus[a] - minus[a]) / 2e-6).abs() < 1e-8);
                    }
                }
            }
        }
    }
}
