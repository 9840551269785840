//! The built-in cases of space on their coarsest meshes, beside what is published. `validation/space.md` has finer ones.

use super::Place;

/// The values that a run of `case` ends with.
fn last<const N: usize>(case: &str, sets: &[&str], names: [&str; N]) -> [f64; N] {
    let here = Place::new(&format!("space-{case}-{}", sets.join("-").replace(['/', '[', ']', ' '], "_")));
    let quiet = ["output.fields-every=0", "newton.tolerance=1e-10"];
    here.run(&format!("run {case} -o out"), &[sets, &quiet].concat()).expect(0, &[]);
    let summary = here.json("out/summary.json");
    names.map(|name| summary["functionals"][name]["last"].as_f64().unwrap())
}

/// The table in the code gallery of deal.II for 1, 2, 4 and 8 cells of degree 2 along an edge; it has two decimals.
#[test]
fn cook_is_that_of_deal_ii() {
    for (refine, published) in ["0", "1", "2", "3"].into_iter().zip([12.19, 13.83, 14.22, 14.30]) {
        let [tip] = last("cook", &[&format!("mesh.refine={refine}")], ["uy_tip"]);
        assert!((1e3 * tip - published).abs() < 0.0051, "{refine}: {tip}, published {published} mm");
    }
}

/// The law of deal.II makes 1 % of the deflection, and plane strain 4 %: the program of these numbers holds no face across
/// z. The plane case is the discrete solution of the extruded one whose faces are held.
#[test]
fn cook_in_plane_strain_is_another_problem() {
    let [plane] = last(
        "cook",
        &[
            "mesh.extrude=none",
            "mesh.refine=2",
            "boundary.front=none",
            "boundary.back=none",
            "boundary.load.traction=[0,62500]",
            "functional.uy_tip.point=[0.048,0.06]",
        ],
        ["uy_tip"],
    );
    let held = ["mesh.refine=2", "boundary.front.condition=symmetry", "boundary.back.condition=symmetry"];
    let [space] = last("cook", &held, ["uy_tip"]);
    assert!((space / plane - 1.0).abs() < 1e-8, "{space} and {plane}");
    // Computed independently with NGSolve, 4 x 4 cells of degree 2.
    assert!((plane / 13.681162e-3 - 1.0).abs() < 1e-6, "{plane}");
}
