//! Sum factorisation: a tensor-product basis at tensor-product points, one coordinate after the other.
//!
//! With φ_a(ξ_q) = Π_d φ_{a_d}(ξ_{q_d}) a sum over the n^D basis functions of a cell is D sums over n each,
//! ```text
//!     Σ_a c_a φ_a(ξ_q) = Σ_{a_2} φ_{a_2}(ξ_{q_2}) Σ_{a_1} φ_{a_1}(ξ_{q_1}) c_{a_1 a_2},
//! ```
//! so that with n points per coordinate a value and its gradient take (D² + 3 D)/2 · n^{D+1} products instead of
//! (D + 1) n^{2D}, and a matrix 2 n^5 + 10 n^4 + 9 n^3 instead of 3 n^6 + 9 n^4 in two dimensions
//! (Orszag, J. Comput. Phys. 37, 1980; Melenk, Gerdes and Schwab, Comput. Methods Appl. Mech. Engrg. 190, 2001;
//! for vector lanes over cells Kronbichler and Kormann, Comput. Fluids 63, 2012).
//!
//! Used in the plane from degree 3 on: with eight lanes a residual takes 0.75 (Q3) and 0.6 (Q4) of the time with whole
//! tables, the condensed matrix 0.9 and 0.75, the whole Jacobian 0.8 and 0.65. In space from degree 2 on: 0.46, 0.63 and
//! 0.67 (Q2). Blocks with the pressure have whole tables: 5 to
//! 10 % of a Jacobian, of which a third could be saved.

pub mod matrices;
pub mod vectors;

use super::evaluate::AtPoint;
use crate::element::{LineTable, Shape};
use crate::math::{Lanes, Scalar, Tensor, Vector};

/// The basis of a tensor-product cell as products of one-dimensional ones.
#[derive(Clone, Debug)]
pub struct TensorBasis {
    /// The basis in one coordinate.
    pub line: LineTable,
    /// Where the entry of each pair of basis functions, `[a_1, b_1]…[a_D, b_D]` with the last fastest, stands in
    /// the element matrix.
    places: Vec<u32>,
}

impl TensorBasis {
    /// Degree `degree` with `points` Gauss points per coordinate, for cells of `shape`; `None` where the whole
    /// tables are to be used.
    pub fn new(shape: Shape, degree: usize, points: usize) -> Option<TensorBasis> {
        // Those that are not compiled have whole tables.
        let degrees = match shape {
            Shape::Triangle | Shape::Tetrahedron => return None,
            Shape::Quadrilateral => 3..=4,
            Shape::Hexahedron => 2..=3,
        };
        if !degrees.contains(&degree) {
            return None;
        }
        let (n, dim, n_basis) = (degree + 1, shape.dim(), shape.n_nodes(degree));
        let place = |at: usize| {
            // Digits to the base n², those of the first coordinate first.
            let (mut row, mut column) = (0, 0);
            for d in (0..dim).rev() {
                let pair = at / (n * n).pow((dim - 1 - d) as u32) % (n * n);
                (row, column) = (row * n + pair / n, column * n + pair % n);
            }
            (row * n_basis + column) as u32
        };
        let places = (0..n_basis * n_basis).map(place).collect();
        Some(TensorBasis { line: LineTable::lagrange(degree, points), places })
    }

    /// Points of a cell.
    pub fn n_points(&self, dim: usize) -> usize {
        self.line.n_points.pow(dim as u32)
    }
}

/// Fields at all points of a batch, and work space of the sums. Empty where whole tables are used.
pub struct TensorScratch<const D: usize, const L: usize> {
    /// v, u, v_old, u_old and a direction of v and u at the points; then what stands before φ and ψ in the places of v
    /// and u.
    pub at: [Vec<AtPoint<D, L>>; 6],
    /// For [`vectors`].
    pub vectors: Vec<Vector<Lanes<L>, D>>,
    /// For [`matrices`].
    pub matrices: Vec<Lanes<L>>,
}

impl<const D: usize, const L: usize> TensorScratch<D, L> {
    /// Room for `basis`.
    pub fn new(basis: Option<&TensorBasis>) -> Self {
        let zero = AtPoint { value: Vector::zero(), grad: Tensor::zero() };
        let points = basis.map_or(0, |b| b.n_points(D));
        let line = basis.map(|b| &b.line);
        TensorScratch {
            at: [(); 6].map(|()| vec![zero; points]),
            vectors: vec![Vector::zero(); line.map_or(0, |line| vectors::work(line, D))],
            matrices: vec![Lanes::zero(); line.map_or(0, |line| matrices::work(line, D))],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::batch::interleave;
    use super::super::evaluate::{interpolate, test};
    use super::super::test_functions::{Piece, Tangents, Test, Trial};
    use super::super::width::{self, Width};
    use super::vectors::{InterpolateTask, TestTask};
    use super::*;
    use crate::element::{BasisTable, Quadrature};
    use crate::physics::Fields;
    use crate::physics::form::Block;

    /// Numbers in [−1, 1] by xorshift.
    struct Random(u64);

    impl Random {
        fn lanes<const L: usize>(&mut self) -> Lanes<L> {
            Lanes(std::array::from_fn(|_| {
                self.0 ^= self.0 << 13;
                self.0 ^= self.0 >> 7;
                self.0 ^= self.0 << 17;
                (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
            }))
        }

        fn vectors<const D: usize, const L: usize>(&mut self, n: usize) -> Vec<Vector<Lanes<L>, D>> {
            (0..n).map(|_| Vector(std::array::from_fn(|_| self.lanes()))).collect()
        }

        fn points<const D: usize, const L: usize>(&mut self, n: usize) -> Vec<AtPoint<D, L>> {
            let grad = |r: &mut Self| Tensor(std::array::from_fn(|_| std::array::from_fn(|_| r.lanes())));
            (0..n).map(|_| AtPoint { value: self.vectors(1)[0], grad: grad(self) }).collect()
        }
    }

    /// Both ways of a tensor-product element.
    struct Both<const D: usize, const L: usize> {
        tensor: TensorBasis,
        scratch: TensorScratch<D, L>,
        /// `[point][basis][1 + D]`.
        basis: Vec<f64>,
        n: usize,
        m: usize,
    }

    impl<const D: usize, const L: usize> Both<D, L>
    where
        Lanes<L>: Width,
    {
        fn new(degree: usize, points: usize) -> Self {
            let shape = if D == 2 { Shape::Quadrilateral } else { Shape::Hexahedron };
            let tensor = TensorBasis::new(shape, degree, points).unwrap();
            let table = BasisTable::lagrange(shape, degree, &Quadrature::cell(shape, points));
            let scratch = TensorScratch::new(Some(&tensor));
            Both { tensor, scratch, basis: interleave(&table), n: table.n_basis, m: table.n_points }
        }

        fn at(&self, q: usize) -> &[f64] {
            &self.basis[q * self.n * (1 + D)..(q + 1) * self.n * (1 + D)]
        }

        fn interpolates(&mut self) {
            let c = Random(1).vectors::<D, L>(self.n);
            let TensorScratch { at: [at, ..], vectors: work, .. } = &mut self.scratch;
            Lanes::<L>::dispatch(InterpolateTask { line: &self.tensor.line, c: &c, at, work });
            let plain: Vec<AtPoint<D, L>> = (0..self.m)
                .map(|q| {
                    let (value, grad) = interpolate(self.at(q), &c, &Tensor::identity());
                    AtPoint { value, grad }
                })
                .collect();
            near(self.scratch.at[0].iter().map(|at| at.value), plain.iter().map(|at| at.value));
            for i in 0..D {
                let row = |at: &AtPoint<D, L>| Vector(at.grad.0[i]);
                near(self.scratch.at[0].iter().map(row), plain.iter().map(row));
            }
        }

        fn tests(&mut self) {
            let at = Random(2).points::<D, L>(self.m);
            let (mut found, mut r) = (vec![Vector::zero(); self.n], vec![Vector::zero(); self.n]);
            let work = &mut self.scratch.vectors;
            Lanes::<L>::dispatch(TestTask { line: &self.tensor.line, at: &at, r: &mut found, work });
            (0..self.m).for_each(|q| test(self.at(q), &at[q].value, &at[q].grad, &mut r));
            near(found.into_iter(), r.into_iter());
        }

        fn contracts(&mut self, piece: &Piece) {
            let components = Fields::<f64, D>::COMPONENTS;
            let mut random = Random(3);
            let tangent: Vec<Lanes<L>> =
                (0..self.m * components * components).map(|_| random.lanes()).collect();
            let mut tangents: Tangents<'_, D, L> = Tangents {
                tangent: &tangent,
                basis: &self.basis,
                pressure: &[],
                n_basis: self.n,
                n_pressure: 0,
                n_points: self.m,
                tensor: None,
                nodal: None,
            };
            let mut blocks = [(); 2].map(|()| vec![Lanes::zero(); self.n * self.n]);
            tangents.contract(piece, &mut blocks[0], &mut []);
            tangents.tensor = Some(&self.tensor);
            tangents.contract(piece, &mut blocks[1], &mut self.scratch.matrices);
            let [plain, found] = blocks.map(|block| block.into_iter().map(|x| Vector([x])));
            near(found, plain);
        }
    }

    /// Equal to 1e-13 of the largest number.
    fn near<const D: usize, const L: usize>(
        found: impl Iterator<Item = Vector<Lanes<L>, D>>,
        plain: impl Iterator<Item = Vector<Lanes<L>, D>>,
    ) {
        let (mut gap, mut largest) = (0.0f64, 0.0f64);
        for (found, plain) in found.zip(plain) {
            for (found, plain) in found.0.iter().flat_map(|x| x.0).zip(plain.0.iter().flat_map(|x| x.0)) {
                gap = gap.max((found - plain).abs());
                largest = largest.max(plain.abs());
            }
        }
        assert!(largest > 0.1 && gap < 1e-13 * largest, "{L} lanes: {gap:e} of {largest:e}");
    }

    fn check<const D: usize, const L: usize>()
    where
        Lanes<L>: Width,
    {
        if !width::available(L) {
            return;
        }
        for degree in if D == 2 { 3..=4 } else { 2..=3 } {
            for points in [degree, degree + 1, degree + 3] {
                let mut both = Both::<D, L>::new(degree, points);
                both.interpolates();
                both.tests();
                if D == 2 || (points == degree + 1 && L == 1) {
                    for block in [Block::Mass, Block::Stiffness, Block::Full] {
                        both.contracts(&Piece { test: Test::Phi(1), trial: Trial::V(0), block });
                        both.contracts(&Piece { test: Test::Psi(0), trial: Trial::U(D - 1), block });
                    }
                }
            }
        }
    }

    #[test]
    fn sums_by_coordinates_are_those_by_whole_tables() {
        check::<2, 1>();
        check::<3, 1>();
        check::<2, 4>();
        check::<2, 8>();
        check::<3, 8>();
    }

    #[test]
    fn other_elements_have_whole_tables() {
        assert!(TensorBasis::new(Shape::Triangle, 3, 4).is_none());
        assert!(TensorBasis::new(Shape::Tetrahedron, 2, 3).is_none());
        for (quadrilateral, hexahedron) in [(1, 1), (2, 4), (5, 5)] {
            assert!(TensorBasis::new(Shape::Quadrilateral, quadrilateral, quadrilateral + 1).is_none());
            assert!(TensorBasis::new(Shape::Hexahedron, hexahedron, hexahedron + 1).is_none());
        }
    }
}
