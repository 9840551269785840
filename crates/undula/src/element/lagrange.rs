//! Nodal bases Q_k on tensor-product cells, equidistant nodes.

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

/// Values `[a]` and gradients `[a][d]` of the Q_k basis of `shape` at `xi`, nodes in the order of [`Shape`].
pub fn basis(shape: Shape, k: usize, xi: &[f64]) -> (Vec<f64>, Vec<[f64; 3]>) {
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

/// Reference coordinates of node `a` of degree `k`.
pub fn node(shape: Shape, k: usize, a: usize) -> [f64; 3] {
    let at = shape.lattice(k, a);
    at.map(|i| if k == 0 { 0.5 } else { i as f64 / k as f64 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodality_partition_of_unity_and_gradients() {
        for shape in [Shape::Quadrilateral, Shape::Hexahedron] {
            for k in 1..5 {
                for a in 0..shape.n_nodes(k) {
                    let (value, _) = basis(shape, k, &node(shape, k, a));
                    for (b, v) in value.iter().enumerate() {
                        assert!((v - if a == b { 1.0 } else { 0.0 }).abs() < 1e-13);
                    }
                }
                let xi = [0.3, 0.71, 0.44];
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
