//! Where the entries of a region go in both matrices, in two and three dimensions.

use super::*;
use crate::algebra::{Pattern, Sink};
use crate::element::Shape;
use crate::loops::batch::Batches;
use crate::loops::scatter::DROP;
use crate::loops::test_functions::{Test, Trial};
use crate::math::Scalar;
use crate::mesh::{Facet, Mesh, generate};
use crate::physics::{Extension, Fluid};
use crate::space::PressureKind;

/// The unit cube in 4 × 4 × 4 cells.
fn cube() -> Mesh<3> {
    let cube = Mesh {
        shape: Shape::Hexahedron,
        degree: 1,
        nodes: (0..8).map(|i| [i % 2, i / 2 % 2, i / 4].map(f64::from)).collect(),
        cell_nodes: (0..8).collect(),
        cell_region: vec![0],
        regions: vec!["fluid".into()],
        facets: vec![Facet { cell: 0, local: 0, boundary: 0 }],
        boundaries: vec!["left".into()],
        parts: vec![],
    };
    cube.refine(&[]).refine(&[])
}

/// The fluid where x > 1/4 with Q2 and P1dc, elsewhere a solid.
fn kernel<const D: usize>(mesh: Mesh<D>) -> (FsiSpace<D>, Kernel<Fluid, D, 1>) {
    let of = |cell| {
        let centre = mesh.map(cell, mesh.reference_centre());
        if centre[0] > 0.25 { Region::Fluid } else { Region::Solid }
    };
    let regions: Vec<Region> = (0..mesh.n_cells()).map(of).collect();
    let space = FsiSpace::new(mesh, regions, 2, PressureKind::Pdc(1));
    let list: Vec<usize> = (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == Region::Fluid).collect();
    let batches = Batches::new(&space, &list, true, 2, &|_| 1.0);
    assert!(batches.chunks.len() > 1, "entries at which chunks meet have copies");
    let fluid = Fluid { rho: 1.0, nu: 1.0, thinning: None, extension: Extension::Harmonic };
    let mut kernel = Kernel::new(fluid, &space, (Region::Fluid, 0), true, batches, 1).unwrap();
    kernel.prepare_interior(&space, &[], true);
    (space, kernel)
}

/// Adds a number for each entry of each cell by its place, and by a search in the pattern. Returns the bytes per cell of
/// the places, and those of a place for each entry.
fn fill<const D: usize>(
    kernel: &mut Kernel<Fluid, D, 1>,
    matrix: Matrix,
    number: &[u32],
    slots: impl Fn(&mut Kernel<Fluid, D, 1>) -> &mut Slots<D, 1>,
) -> [usize; 2] {
    let mut rows: Vec<Vec<u32>> = vec![vec![]; number.len()];
    kernel.entries(matrix, number, &mut |row, column| rows[row as usize].push(column));
    let pattern = Pattern::from_rows(&rows);
    let find =
        |row: u32, column: u32| pattern.find(row as usize, column as usize).map_or(DROP, |at| at as u32);
    kernel.place(matrix, number, &Entries { n: pattern.nnz(), find: &find }).unwrap();
    let (pairs, cells) = (kernel.pairs(matrix), kernel.batches.len());
    let (mut expected, mut found) = (vec![0.0; pattern.nnz()], vec![0.0; pattern.nnz()]);
    let mut entries = 0;
    let numbering: Vec<_> = (0..cells).map(|cell| kernel.numbering_of(matrix, cell, number)).collect();
    slots(kernel).fill(Sink::Double(&mut found), |slots, out| {
        for (cell, numbering) in numbering.iter().enumerate() {
            for &Pair { test, trial, .. } in &pairs {
                let (rows, columns) = (&numbering.rows[test.split().0], &numbering.columns[trial.split().0]);
                let (r, c) = (if test == Test::Xi { 1 } else { D }, if trial == Trial::P { 1 } else { D });
                entries += rows.len() * r * columns.len() * c;
                let places = slots.of(test, trial, cell);
                for (a, b) in (0..rows.len()).flat_map(|a| (0..columns.len()).map(move |b| (a, b))) {
                    for (i, j) in (0..r).flat_map(|i| (0..c).map(move |j| (i, j))) {
                        let value = (1 + cell % 7 + 10 * (a + i) + 1000 * (b + j)) as f64;
                        places.add(out, (a, b), (i, j), &Lanes::constant(value));
                        let (row, column) = (rows[a][0][i], columns[b][0][j]);
                        if row != DROP && column != DROP {
                            expected[find(row, column) as usize] += value;
                        }
                    }
                }
            }
        }
    });
    assert!(found == expected, "{matrix:?} in {D} dimensions");
    [slots(kernel).bytes() / cells, 4 * entries / cells]
}

/// Bytes in both matrices, without given unknowns and with some: `given` by component if it says so.
fn bytes<const D: usize>(mesh: Mesh<D>, given: impl Fn(usize) -> bool) -> [[usize; 2]; 2] {
    let (space, mut kernel) = kernel(mesh);
    let n_v = space.n_v();
    let mut number: Vec<u32> = (0..space.n_field_unknowns() as u32).collect();
    (0..n_v + space.n_u()).filter(|&at| given(at)).for_each(|at| number[at] = DROP);
    let whole = fill(&mut kernel, Matrix::Whole, &number, |kernel| &mut kernel.slots);
    kernel.visit_inner(&mut |place| number[place as usize] = DROP);
    number[n_v..n_v + space.n_u()].fill(DROP);
    let condensed =
        fill(&mut kernel, Matrix::Condensed, &number, |kernel| &mut kernel.interior.as_mut().unwrap().slots);
    [whole, condensed]
}

fn square() -> Mesh<2> {
    generate::rectangle([0.0; 2], [1.0; 2], [8, 8], 0).unwrap()
}

/// A place for each pair of nodes, and the strides of the rows, beside a place for each entry. (One for D columns would
/// take 612 and 8532 bytes in the condensed matrix.)
#[test]
fn blocks_of_nodes_have_one_place() {
    assert_eq!(bytes(square(), |_| false), [[1368, 4536], [356, 1156]]);
    assert_eq!(bytes(cube(), |_| false), [[10_260, 82_620], [3020, 24_964]]);
}

/// Where one component of a node is given, all entries are still found.
#[test]
fn components_may_be_given_alone() {
    for every in [2, 3, 10, 37] {
        bytes(square(), |at| at % every == 1);
        bytes(cube(), |at| at % (20 * every) == 1);
    }
    // Nodes as a whole need no places of single entries.
    assert_eq!(bytes(square(), |at| at / 2 % 5 == 0)[1][0], 356);
}
