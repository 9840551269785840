//! The coarser meshes of a refined mesh: children lie in their parents, and all levels have the same names.

use crate::common::builtin;
use crate::mesh::two_cubes;
use std::collections::BTreeSet;
use undula::mesh::generate::{cylinder, rectangle, schaefer_turek, tube, turek_hron};
use undula::mesh::{Child, Curve, Extrusion, Facet, Hierarchy, Mesh, Split};

/// Two refinements of `mesh`.
fn twice<const D: usize>(mesh: Mesh<D>, curves: &[Curve<D>]) -> (Vec<Mesh<D>>, Hierarchy<D>) {
    let (finest, hierarchy) = Hierarchy::refine(mesh.clone(), 2, curves);
    assert_eq!((&hierarchy.coarser()[0].nodes, hierarchy.coarser().len()), (&mesh.nodes, 2));
    let same = mesh.refined(2, curves);
    assert_eq!(
        (&same.nodes, &same.cell_nodes, &same.facets),
        (&finest.nodes, &finest.cell_nodes, &finest.facets)
    );
    (hierarchy.levels(&finest).cloned().collect(), hierarchy)
}

/// The largest distance of two coordinates.
fn away<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (0..D).map(|d| (a[d] - b[d]).abs()).fold(0.0, f64::max)
}

/// Parents and children name each other, and regions are inherited.
fn relatives_agree<const D: usize>(hierarchy: &Hierarchy<D>, level: usize, fine: &Mesh<D>) {
    let coarse = &hierarchy.coarser()[level];
    let mut seen = 0;
    for parent in 0..coarse.n_cells() {
        for (number, cell) in hierarchy.children(level, parent).enumerate() {
            assert_eq!(hierarchy.child(level, cell), Child { parent, number });
            assert_eq!((cell, fine.cell_region[cell]), (seen, coarse.cell_region[parent]));
            seen += 1;
        }
    }
    assert_eq!((seen, &fine.regions), (fine.n_cells(), &coarse.regions));
}

/// Points of the child are points of the parent, and the children fill it.
fn children_fill_their_parents<const D: usize>(hierarchy: &Hierarchy<D>, level: usize, fine: &Mesh<D>) {
    let (coarse, split) = (&hierarchy.coarser()[level], hierarchy.split(level));
    let (whole, part) = (coarse.quality().volume, fine.quality().volume);
    for parent in 0..coarse.n_cells() {
        let size = coarse.cell_diameter(parent);
        for cell in hierarchy.children(level, parent) {
            let number = hierarchy.child_number(level, hierarchy.child(level, cell));
            for i in 0..7 {
                let xi: [f64; D] = std::array::from_fn(|d| (0.1 + 0.37 * (i * (d + 1)) as f64).fract());
                let xi = coarse.shape.clamp(xi);
                let in_parent = split.to_parent(coarse.shape, number, xi);
                assert!(coarse.shape.outside(&in_parent) < 1e-15, "{in_parent:?}");
                assert!(away(fine.map(cell, xi), coarse.map(parent, in_parent)) < 1e-13 * size.max(1.0));
            }
        }
        let sum: f64 = hierarchy.children(level, parent).map(|cell| part[cell]).sum();
        assert!((sum / whole[parent] - 1.0).abs() < 1e-11, "{sum} {}", whole[parent]);
    }
}

/// The nodes of a parent are nodes of its children.
fn nodes_stay<const D: usize>(hierarchy: &Hierarchy<D>, level: usize, fine: &Mesh<D>) {
    let (coarse, split) = (&hierarchy.coarser()[level], hierarchy.split(level));
    let (shape, degree) = (coarse.shape, coarse.degree);
    for parent in 0..coarse.n_cells() {
        let mut met = BTreeSet::new();
        for cell in hierarchy.children(level, parent) {
            let number = hierarchy.child_number(level, hierarchy.child(level, cell));
            for (local, &node) in fine.cell(cell).iter().enumerate() {
                let at = split.in_parent(shape, degree, number, shape.lattice(degree, local));
                if at.iter().all(|i| i % 2 == 0) {
                    let known = shape.number(degree, at.map(|i| i / 2));
                    let same = coarse.nodes[coarse.cell(parent)[known] as usize];
                    assert!(away(fine.nodes[node as usize], same) < 1e-14);
                    met.insert(known);
                }
            }
        }
        assert_eq!(met.len(), shape.n_nodes(degree));
    }
}

fn check_levels<const D: usize>((levels, hierarchy): &(Vec<Mesh<D>>, Hierarchy<D>), filled: bool) {
    for (level, fine) in levels[1..].iter().enumerate() {
        relatives_agree(hierarchy, level, fine);
        nodes_stay(hierarchy, level, fine);
        if filled {
            children_fill_their_parents(hierarchy, level, fine);
        }
    }
}

#[test]
fn every_child_lies_in_its_parent_and_has_its_region() {
    for mesh in [turek_hron(0, 1), schaefer_turek(0), turek_hron(0, 1).triangulated()] {
        check_levels(&twice(mesh, &[]), true);
    }
    check_levels(&twice(two_cubes(), &[]), true);
    check_levels(&twice(two_cubes().in_tetrahedra(), &[]), true);
    check_levels(&twice(tube([0.03, 0.01, 0.002], [2, 8, 1], 0).unwrap().in_tetrahedra(), &[]), true);
}

/// Thick layers stay, so do an odd number of them and those that are not alike, unless patches need it otherwise.
#[test]
fn layers_of_extruded_meshes_are_halved_where_they_are_thin() {
    // Cells of 1/4, 1/8 and 1/16.
    let square = rectangle([0.0; 2], [1.0; 2], [4, 4], 0).unwrap();
    let (plane, planes) = Hierarchy::refine(square, 2, &[]);
    let (whole, section) = (Split::Whole, Split::Section);
    for (layers, grading, halved, splits) in [
        (16, 0, false, [whole, whole]),
        (4, 0, false, [section, section]),
        (12, 0, false, [whole, whole]),
        (10, 0, false, [whole, section]),
        (11, 0, false, [section, section]),
        (22, 0, false, [section, whole]),
        (8, 0, false, [whole, section]),
        (4, 0, true, [whole, whole]),
        (14, 1, true, [section, section]),
    ] {
        let how = Extrusion { depth: 1.0, layers, grading, halved };
        let (finest, hierarchy) = planes.extruded(&plane, how).unwrap();
        finest.check().unwrap();
        let named = hierarchy.named_as(&finest);
        assert_eq!([named.split(0), named.split(1)], splits, "{layers} {grading}");
        check_levels(&(named.levels(&finest).cloned().collect(), named), true);
    }
}

#[test]
fn nodes_of_parents_stay_where_boundaries_follow_a_curve() {
    for mesh in [turek_hron(0, 1), turek_hron(0, 1).triangulated()] {
        check_levels(&twice(mesh, &[cylinder()]), false);
    }
}

/// Facets with their names, without their order.
fn named(mesh: &Mesh<2>) -> [BTreeSet<(u32, u8, u16)>; 2] {
    let set = |list: &[Facet]| list.iter().map(|f| (f.cell, f.local, f.boundary)).collect();
    [set(&mesh.facets), set(&mesh.parts)]
}

#[test]
fn coarser_meshes_of_a_case_are_those_with_less_refinement() {
    for sets in [
        &["mesh.grading=1"][..],
        &["mesh.grading=1", "space.velocity=P2", "space.pressure=P1"],
        &["solid=none", "mesh.grading=1"],
    ] {
        let at = |refine: usize| {
            let refine = format!("mesh.refine={refine}");
            let sets: Vec<&str> = sets.iter().copied().chain([refine.as_str()]).collect();
            builtin("fsi3", &sets).build_space().unwrap()
        };
        let space = at(2);
        let levels: Vec<&Mesh<2>> = space.hierarchy.levels(&space.mesh).collect();
        assert_eq!((levels.len(), at(0).hierarchy.coarser().len()), (3, 0), "{sets:?}");
        for (refine, &mesh) in levels.iter().enumerate() {
            let same = at(refine).mesh;
            mesh.check().unwrap();
            assert_eq!((&mesh.nodes, &mesh.cell_nodes), (&same.nodes, &same.cell_nodes));
            assert_eq!((&mesh.regions, &mesh.cell_region), (&same.regions, &same.cell_region));
            assert_eq!((&mesh.boundaries, named(mesh)), (&same.boundaries, named(&same)));
        }
        let levels: Vec<Mesh<2>> = levels.into_iter().cloned().collect();
        check_levels(&(levels, space.hierarchy.clone()), false);
    }
}

#[test]
fn the_hierarchy_begins_where_regions_fit_the_cells() {
    // Cells of 1/2, 1/4 and 1/8.
    let square = rectangle([0.0; 2], [1.0; 2], [2, 2], 0).unwrap();
    for (side, n_coarser) in [(0.5, 2), (0.25, 1), (0.125, 0)] {
        let (mut finest, hierarchy) = Hierarchy::refine(square.clone(), 2, &[]);
        finest.assign_region("solid", |[x, y]| side - x.max(y)).unwrap();
        finest.mark_interface("fluid", "solid").unwrap();
        let hierarchy = hierarchy.named_as(&finest);
        assert_eq!(hierarchy.coarser().len(), n_coarser, "{side}");
        for keep in [&["fluid", "solid"][..], &["fluid"], &["solid"]] {
            let mesh = finest.restrict(keep);
            let hierarchy = hierarchy.restrict(keep);
            let levels: Vec<Mesh<2>> = hierarchy.levels(&mesh).cloned().collect();
            check_levels(&(levels.clone(), hierarchy), true);
            for mesh in levels {
                mesh.check().unwrap();
                assert!(mesh.boundary("interface").is_some());
            }
        }
    }
    // A mesh of other cells has no coarser ones.
    let (finest, hierarchy) = Hierarchy::refine(square, 1, &[]);
    assert!(hierarchy.named_as(&finest.triangulated()).coarser().is_empty());
}

#[test]
fn lengths_of_a_case_come_from_its_mesh_before_refinement() {
    let space = builtin("fsi3", &["mesh.refine=2"]).build_space().unwrap();
    let case = builtin("fsi3", &["motion.model=stiffened-harmonic", "mesh.refine=2"]);
    let coarse = builtin("fsi3", &["motion.model=stiffened-harmonic", "mesh.refine=0"]);
    let same = coarse.motion_on(&coarse.build_space().unwrap());
    assert_eq!(case.motion_on(&space).scale, same.scale);
    assert!(same.scale.is_some());
}
