//! The fields of one moment.

/// Values of one quantity at all points or in all cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name, such as `velocity`.
    pub name: String,
    /// Numbers per point or cell. Two are written as three, the last zero: ParaView's vectors have three.
    pub components: usize,
    /// `n × components`, the components of one point next to each other; SI units.
    pub values: Vec<f64>,
}

impl Field {
    /// The quantity `name` with `n × components` values.
    pub fn new(name: impl Into<String>, components: usize, values: Vec<f64>) -> Self {
        Field { name: name.into(), components, values }
    }
}

/// Shape of the cells.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Default)]
pub enum CellKind {
    /// `(degree + 1)²` points.
    #[default]
    Quadrilateral,
    /// `(degree + 1) (degree + 2) / 2` points.
    Triangle,
    /// `(degree + 1)³` points.
    Hexahedron,
    /// `(degree + 1) (degree + 2) (degree + 3) / 6` points.
    Tetrahedron,
}

impl CellKind {
    /// Space dimension.
    pub const fn dim(self) -> usize {
        match self {
            CellKind::Quadrilateral | CellKind::Triangle => 2,
            CellKind::Hexahedron | CellKind::Tetrahedron => 3,
        }
    }
}

/// The fields of one moment on cells of degree 1, 2 or higher, simplices up to 3.
///
/// Points lie where the material or the mesh is at that moment, so that pictures show the deformed domain
/// without further filters. The pictures of `undula plot` look for the point data `velocity` \[m/s\],
/// `pressure` \[Pa\], `deformation` \[m\] and `solid-von-mises` \[Pa\], and for the cell data `solid` (1 in cells of the
/// solid, else 0).
#[derive(Clone, Debug, PartialEq, Default)]
pub struct FieldSnapshot {
    /// Shape of the cells.
    pub kind: CellKind,
    /// Degree of the cells.
    pub degree: usize,
    /// Deformed positions \[m\], the third coordinate zero in 2D.
    pub points: Vec<[f64; 3]>,
    /// Points of each cell in lexicographic order, `n_cells × points_per_cell`.
    pub cells: Vec<u32>,
    /// Values at points, `n_points × components` each.
    pub point_data: Vec<Field>,
    /// Values in cells, `n_cells × components` each.
    pub cell_data: Vec<Field>,
}

impl FieldSnapshot {
    /// Points per cell.
    pub fn points_per_cell(&self) -> usize {
        match self.kind {
            CellKind::Quadrilateral => (self.degree + 1).pow(2),
            CellKind::Triangle => (self.degree + 1) * (self.degree + 2) / 2,
            CellKind::Hexahedron => (self.degree + 1).pow(3),
            CellKind::Tetrahedron => (self.degree + 1) * (self.degree + 2) * (self.degree + 3) / 6,
        }
    }

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.cells.len() / self.points_per_cell()
    }

    /// The same points and values with each cell of degree k cut into k^D cells of degree 1.
    ///
    /// The values at all points stay, and straight cells can be sampled and traced through. The cell data `cell` has the
    /// number of the curved cell that a straight one is part of.
    pub fn linear(self) -> FieldSnapshot {
        let k = self.degree;
        let n = self.points_per_cell();
        let pieces = self.pieces();
        let (per_cell, n_cells) = (k.pow(self.kind.dim() as u32), self.n_cells());
        let cells = self.cells.chunks_exact(n).flat_map(|cell| pieces.iter().map(|&i| cell[i])).collect();
        let repeated = |field: Field| {
            let tuples = field.values.chunks_exact(field.components);
            let values =
                tuples.flat_map(|tuple| std::iter::repeat_n(tuple, per_cell).flatten().copied()).collect();
            Field { values, ..field }
        };
        let mut cell_data: Vec<Field> = self.cell_data.into_iter().map(repeated).collect();
        let number = (0..n_cells).flat_map(|cell| std::iter::repeat_n(cell as f64, per_cell)).collect();
        cell_data.push(Field::new("cell", 1, number));
        FieldSnapshot { degree: 1, cells, cell_data, ..self }
    }

    /// The points of the k^D straight pieces of a cell, all pieces one after the other, each in lexicographic order.
    fn pieces(&self) -> Vec<usize> {
        let k = self.degree;
        let mut pieces = Vec::new();
        match self.kind {
            CellKind::Quadrilateral => {
                for (j, i) in (0..k).flat_map(|j| (0..k).map(move |i| (j, i))) {
                    let corner = i + (k + 1) * j;
                    pieces.extend([corner, corner + 1, corner + k + 1, corner + k + 2]);
                }
            }
            CellKind::Triangle => {
                let number = |i: usize, j: usize| i + (0..j).map(|row| k + 1 - row).sum::<usize>();
                for (j, i) in (0..k).flat_map(|j| (0..k - j).map(move |i| (j, i))) {
                    pieces.extend([number(i, j), number(i + 1, j), number(i, j + 1)]);
                    if i + j + 2 <= k {
                        pieces.extend([number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]);
                    }
                }
            }
            CellKind::Tetrahedron => pieces.extend(parts_of_tetrahedron(k)),
            CellKind::Hexahedron => {
                let [row, layer] = [k + 1, (k + 1).pow(2)];
                let corners = |n: usize| {
                    let from = n % k + row * (n / k % k) + layer * (n / (k * k));
                    (0..8).map(move |c| from + (c & 1) + row * (c >> 1 & 1) + layer * (c >> 2))
                };
                pieces.extend((0..k.pow(3)).flat_map(corners));
            }
        }
        pieces
    }

    /// The point data called `name`.
    pub fn at_points(&self, name: &str) -> Option<&Field> {
        self.point_data.iter().find(|field| field.name == name)
    }

    /// The cell data called `name`.
    pub fn in_cells(&self, name: &str) -> Option<&Field> {
        self.cell_data.iter().find(|field| field.name == name)
    }
}

/// The points of the k³ pieces of a tetrahedron of degree k.
///
/// At each point of the lattice stands a cube of it, cut along its diagonals from (1, 0, 0) to (0, 1, 1): a tetrahedron at
/// its first corner, an octahedron in four, one at the last. Of these, those inside of the cell are its pieces.
fn parts_of_tetrahedron(k: usize) -> Vec<usize> {
    type Corner = [usize; 3];
    const PARTS: [[Corner; 4]; 6] = [
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1]],
        [[1, 0, 0], [1, 0, 1], [1, 1, 0], [0, 1, 1]],
        [[1, 0, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]],
        [[1, 0, 1], [1, 1, 0], [0, 1, 1], [1, 1, 1]],
    ];
    let row = |n: usize| (n + 1) * (n + 2) / 2;
    let number = |[i, j, l]: Corner| {
        let n = k - l;
        (0..l).map(|l| row(k - l)).sum::<usize>() + (0..j).map(|j| n + 1 - j).sum::<usize>() + i
    };
    let mut pieces = vec![];
    for l in 0..k {
        for (j, i) in (0..k - l).flat_map(|j| (0..k - l - j).map(move |i| (j, i))) {
            let at = |c: &Corner| [i + c[0], j + c[1], l + c[2]];
            let inside = |part: &&[Corner; 4]| part.iter().all(|c| at(c).iter().sum::<usize>() <= k);
            for part in PARTS.iter().filter(inside) {
                pieces.extend(part.iter().map(|c| number(at(c))));
            }
        }
    }
    pieces
}
