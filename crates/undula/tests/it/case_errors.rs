//! Case files that are refused, and in which words.

use crate::common::{FLUID, builtin, turek_hron, wrong, wrong_builtin};
use undula::case::Case;
use undula::case::builtin::builtin_cases;
use undula::case::conditions::{CONDITIONS, Condition};

/// `expected` with the names of conditions: all, those for the fluid, those for the solid.
fn with_conditions(expected: &str) -> String {
    let names = |suits: &dyn Fn(&Condition) -> bool| {
        let rows = CONDITIONS.iter().filter(|row| suits(&row.value));
        rows.map(|row| format!("`{}`", row.name)).collect::<Vec<_>>().join(", ")
    };
    expected
        .replace("<conditions>", &names(&|_| true))
        .replace("<fluid>", &names(&|condition| condition.suits(true, false)))
        .replace("<solid>", &names(&|condition| condition.suits(false, true)))
}

#[test]
fn mistakes_of_a_whole_file_are_told_at_once() {
    let text = r#"name = "a/b"
colour = 1

[mesh]
generator = "turek-horn"
refine = 1.5
grading = -1

[space]
velocity = "Q5"
pressure = "P1d"

[fluid]
density = -1000
kinematic-viscosity = "thin"
densty = 1

[solid]
law = "hooke"
mu = 1e6
young = 1e6
body-force = [0]

[motion]
model = "bi-harmonic"
poisson = 0.5
walls = "slide"

[boundary.inflow]
condition = "velocity"
velocity = ["1.5*sinn(y)", true]

[boundary.outflow]
condition = "donothing"

[boundary.walls]
velocity = [0, 0]

[boundary.interface]
condition = "no-slip"

[time]
scheme = "cn"
step = "t-1"
end = 0
theta = 0.4

[newton]
rate-max = 1
jacobian = "numeric"
max-steps = 0
tolerance = 2

[linear]
solver = "gmres"

[functional.drag]
kind = "force"
on = []
component = "z"

[functional.tip]
kind = "displacement"
point = [0.6, "right"]

[functional.other]
kind = "forces"

[output]
fields-every = -1
mesh = "moved"
leading = "lft"
"#;
    let expected = r#"own.toml:1:8: name = "a/b": expected letters, digits, `-`, `_` and `.` only (it names the output directory)
own.toml:2:1: colour: unknown key; a case takes `name`, `title`, `reference`, `mesh`, `space`, `fluid`, `stabilization`, `solid`, `motion`, `boundary`, `time`, `initial`, `newton`, `linear`, `functional`, `output`
own.toml:5:13: mesh.generator = "turek-horn": expected one of `turek-hron`, `schaefer-turek`, `dfg-3d`, `rotor`, `flap`, `cavity`, `tube-2d`, `valve`, `cook`, `fsi-box`, `tube`, `annulus`, `box`; did you mean `turek-hron`?
own.toml:6:10: mesh.refine = 1.5: expected an integer from 0 to 10
own.toml:7:11: mesh.grading = -1: expected an integer from 0 to 30
own.toml:10:12: space.velocity = "Q5": expected one of `Q1`, `Q2`, `Q3`, `Q4`, `P1`, `P2`, `P3`, `P2-bubble`
own.toml:11:12: space.pressure = "P1d": expected one of `P0`, `P1dc`, `P2dc`, `P3dc`, `Q1`, `Q2`, `Q3`, `Q4`, `P1`, `P2`; did you mean `P1dc`?
own.toml:14:11: fluid.density = -1000: expected a number above 0
own.toml:15:23: fluid.kinematic-viscosity = "thin": expected a number above 0
own.toml:16:1: fluid.densty: unknown key; did you mean `density`? [fluid] takes `region`, `density`, `law`, `kinematic-viscosity`, `viscosity-zero`, `viscosity-infinity`, `time-constant`, `power-index`, `yasuda-exponent`, `body-force`, `body-force-at`
own.toml:18:2: solid.density: missing: the density [kg/m³]
own.toml:18:2: solid.lambda: missing: `mu` and `lambda` [Pa] belong together
own.toml:19:7: solid.law = "hooke": expected one of `st-venant-kirchhoff`, `linear`, `neo-hookean`, `isochoric-neo-hookean`, `mooney-rivlin`, `incompressible-neo-hookean`, `incompressible-mooney-rivlin`, `ogden`, `incompressible-ogden`, `holzapfel-gasser-ogden`, `incompressible-holzapfel-gasser-ogden`, `guccione`
own.toml:21:9: solid.young = 1e6: give either `mu` and `lambda` or `young` and `poisson`
own.toml:22:14: solid.body-force = [0]: expected two expressions, as ["x component", "y component"], not 1 values
own.toml:25:9: motion.model = "bi-harmonic": expected one of `harmonic`, `stiffened-harmonic`, `pseudo-elastic`, `jacobian-stiffened`, `biharmonic`; did you mean `biharmonic`?
own.toml:26:11: motion.poisson = 0.5: expected a number above -1 and below 0.5
own.toml:27:9: motion.walls = "slide": expected one of `fixed`, `sliding`
own.toml:31:18: boundary.inflow.velocity[0] = "1.5*sinn(y)": unknown function `sinn`; did you mean `sin`? (at byte 4)
own.toml:31:28: boundary.inflow.velocity[1] = true: expected a number or an expression in quotes, not true or false
own.toml:34:13: boundary.outflow.condition = "donothing": expected one of <conditions>; did you mean `do-nothing`?
own.toml:36:11: boundary.walls.condition: missing: one of <conditions>
own.toml:39:11: boundary.interface: nothing can be imposed on the interface between fluid and solid; remove this table
own.toml:43:10: time.scheme = "cn": expected one of `backward-euler`, `theta`, `crank-nicolson`, `shifted-crank-nicolson`, `rannacher`, `fractional-step-theta`, `cg1`, `bdf2`, `esdirk3`, `esdirk4`, `stationary`
own.toml:44:8: time.step = "t-1": expected a value above 0 at all times, it is -1 at t = 0
own.toml:45:7: time.end = 0: expected a time after the start, 0 s
own.toml:46:9: time.theta = 0.4: expected a number from 0.5 to 1
own.toml:49:12: newton.rate-max = 1: expected a number from 0 to below 1
own.toml:50:12: newton.jacobian = "numeric": expected one of `automatic`, `analytic`, `finite-difference`
own.toml:51:13: newton.max-steps = 0: expected an integer from 1 to 1000
own.toml:52:13: newton.tolerance = 2: expected a number above 0 and below 1
own.toml:55:10: linear.solver = "gmres": it is preconditioned by factors: expected one of `multifrontal`, `faer`, which make them, and linear.krylov = "gmres"
own.toml:59:6: functional.drag.on = []: expected an array of names, such as ["cylinder", "interface"]
own.toml:60:13: functional.drag.component = "z": expected one of `x`, `y`
own.toml:62:13: functional.tip.component: missing: "x" or "y"
own.toml:64:15: functional.tip.point[1] = "right": expected a finite number
own.toml:67:8: functional.other.kind = "forces": expected one of `force`, `moment`, `displacement`, `pressure-difference`, `energy`, `rotation`, `flux`, `power`, `pressure`, `velocity`, `stress`, `wall-shear-stress`, `balance`, `volume`; did you mean `force`?
own.toml:70:16: output.fields-every = -1: expected an integer, 0 or above
own.toml:71:8: output.mesh = "moved": expected one of `deformed`, `reference`
own.toml:72:11: output.leading = "lft": expected the name of a functional; there are `drag`, `tip`, `other`"#;
    let told = wrong(text, &[]);
    for (told, expected) in told.lines().zip(expected.lines()) {
        assert_eq!(told, with_conditions(expected));
    }
    assert_eq!(told.lines().count(), expected.lines().count(), "{told}");
}

#[test]
fn further_mistakes() {
    for (tail, expected) in [
        (
            "[solid]\nregion = \"fluid\"\ndensity = 1\nmu = 1\nlambda = 1\n",
            "own.toml:7:10: solid.region = \"fluid\": the fluid fills the region `fluid` already",
        ),
        (
            "[solid]\ndensity = 1\nmu = 3\nlambda = -2\n",
            "own.toml:9:10: solid.lambda = -2: expected a number above -2/3 mu = -2 Pa",
        ),
        (
            "[time]\nscheme = \"bdf2\"\ndomain-motion = \"secant\"\nstep = 1\nend = 2\n",
            "own.toml:8:17: time.domain-motion = \"secant\": `bdf2` takes all terms at the new time, elsewhere it \
          would lose its order: leave the key out",
        ),
        (
            "[time]\nscheme = \"cg1\"\ndomain-motion = \"midpoint\"\nstep = 1\nend = 2\n",
            "own.toml:8:17: time.domain-motion = \"midpoint\": `cg1` integrates all terms over the step: expected \
          `galerkin`, or leave the key out",
        ),
        (
            "[time]\nscheme = \"rannacher\"\nrannacher-interval = 1\nstep = 1\nend = 2\n",
            "own.toml:8:22: time.rannacher-interval = 1: 2 steps of backward Euler take 2 s of every 1 s: none is left",
        ),
        (
            "[time]\nstep = \"0.1+t\"\nend = 0.2\n[time.adaptive]\ntolerance = 2\n",
            "own.toml:7:8: time.step = \"0.1+t\": expected a number, the first step: [time.adaptive] chooses the others\n\
          own.toml:10:13: time.adaptive.tolerance = 2: expected a number above 0 and below 1",
        ),
        (
            "[time]\nstep = 0.1\nend = 2\n[time.adaptive]\nmin-step = 0.2\nmax-step = 0.05\n",
            "own.toml:10:12: time.adaptive.min-step = 0.2: expected at most time.step, 0.1 s\n\
          own.toml:11:12: time.adaptive.max-step = 0.05: expected at least time.step, 0.1 s",
        ),
        (
            "[time]\nstep = 1.0\nshift = 1\nend = 2\n",
            "own.toml:7:8: time.step = 1.0: theta = 1/2 + shift * step = 1.5 is above 1; reduce `step` or `shift`",
        ),
        (
            "[time]\nscheme = \"theta\"\nstep = \"0.1*x\"\nend = 2\n",
            "own.toml:6:2: time.theta: missing: the weight of the new time, from 0.5 to 1\n\
          own.toml:8:8: time.step = \"0.1*x\": expected a number or an expression of t alone",
        ),
        (
            "[time]\nscheme = \"crank-nicolson\"\nstep = 0\nend = 2\n",
            "own.toml:8:8: time.step = 0: expected a number above 0",
        ),
        (
            "[boundary]\ninflow = \"velocity\"\n",
            "own.toml:7:10: boundary.inflow = \"velocity\": expected a table [boundary.inflow]",
        ),
        (
            "[boundary.inflow]\ncondition = \"velocity\"\nvelocity = [\"1/0\", 0]\n",
            "own.toml:8:13: boundary.inflow.velocity[0] = \"1/0\": expected a finite value",
        ),
        (
            "[functional.time]\nkind = \"rotation\"\n",
            "own.toml:6:13: functional.time: expected a name of letters, digits, `-` and `_`; `step`, `time`, `force_time`, `min_J`, `newton_steps`, `jacobians`, `linear_iterations` are other columns of history.csv",
        ),
        ("[newton]\nrate-max = 0.1\nrate-max = 0.2\n", "own.toml:8:1: not TOML: duplicate key"),
        ("[newton\n", "own.toml:6:8: not TOML: unclosed table, expected `]`"),
    ] {
        assert_eq!(wrong(&format!("{FLUID}{tail}"), &[]), expected, "{tail}");
    }
    assert_eq!(
        wrong("title = \"nothing\"\n", &[]),
        "own.toml:1:1: mesh: missing: add [mesh] with generator = \"turek-hron\" or file = \"own.msh\"\n\
         own.toml:1:1: the case has neither [fluid] nor [solid]"
    );
}

#[test]
fn mistakes_in_meshes() {
    for (mesh, expected) in [
        (
            "refine = 1",
            "own.toml:1:2: mesh.generator: missing: give `generator` (`turek-hron`, `schaefer-turek`, `dfg-3d`, `rotor`, `flap`, `cavity`, `tube-2d`, `valve`, `cook`, `fsi-box`, `tube`, `annulus`, `box`) or `file`",
        ),
        (
            "generator = \"box\"\nlower = [0, 0]\nupper = [1, 0]\ncells = [4, 0]",
            "own.toml:4:9: mesh.upper = [1, 0]: expected a corner right of and above `lower` = [0, 0]\n\
          own.toml:5:13: mesh.cells[1] = 0: expected an integer from 1 to 100000",
        ),
        (
            "generator = \"box\"\nlower = [0, 0]\nupper = [1, 1]",
            "own.toml:1:2: mesh.cells: missing: a box needs `lower` and `upper` corner [m] and `cells` per direction",
        ),
        (
            "generator = \"turek-hron\"\ncells = [4, 4]",
            "own.toml:3:9: mesh.cells = [4, 4]: only for generator = \"box\", \"annulus\" or \"tube\"",
        ),
        (
            "generator = \"tube\"\nradii = [2, 1]\ncells = [4, 6, 1]",
            "own.toml:1:2: mesh.length: missing: a tube needs `length` and `radii` [m], as [1, 2], and `cells` along, round \
             and through the wall, as [20, 16, 1]\n\
             own.toml:3:9: mesh.radii = [2, 1]: expected the radius of the inner circle, then the larger one of the outer \
             circle\n\
             own.toml:4:9: mesh.cells = [4, 6, 1]: expected a multiple of 4 round, as [20, 16, 1]",
        ),
        (
            "generator = \"turek-hron\"\nfile = \"a.msh\"",
            "own.toml:3:8: mesh.file = \"a.msh\": give either `generator` or `file`",
        ),
    ] {
        let text = format!("[mesh]\n{mesh}\n[fluid]\ndensity = 1\nkinematic-viscosity = 1\n");
        assert_eq!(wrong(&text, &[]), expected, "{mesh}");
    }
}

#[test]
fn mistakes_in_overrides_name_the_override() {
    for (overrides, expected) in [
        (
            &["time.scheme=cn"][..],
            "--set time.scheme=cn: expected one of `backward-euler`, `theta`, `crank-nicolson`, `shifted-crank-nicolson`, `rannacher`, `fractional-step-theta`, `cg1`, `bdf2`, `esdirk3`, `esdirk4`, `stationary`",
        ),
        (
            &["time.scheme=crank-nicholson"],
            "--set time.scheme=crank-nicholson: expected one of `backward-euler`, `theta`, `crank-nicolson`, `shifted-crank-nicolson`, `rannacher`, `fractional-step-theta`, `cg1`, `bdf2`, `esdirk3`, `esdirk4`, `stationary`; did you mean `crank-nicolson`?",
        ),
        (
            &["time.setp=0.1"],
            "--set time.setp=0.1: unknown key; did you mean `step`? [time] takes `scheme`, `step`, `start`, `end`, `theta`, `shift`, `max-halvings`, `rannacher-steps`, `rannacher-interval`, `domain-motion`, `adaptive`",
        ),
        (
            &["mesh.lengt=4"],
            "--set mesh.lengt=4: unknown key; did you mean `length`? [mesh] takes `generator`, `file`, `scale`, `coordinates`, `refine`, `grading`, `lower`, `upper`, `radii`, `cells`, `axis`, `leave-out`, `extrude`, `wall`, `region`",
        ),
        (
            &["boundary.inlfow.velocity=[1,0]"],
            "--set boundary.inlfow.velocity=[1,0]: boundary.inlfow.condition: missing: the case has no boundary `inlfow`; did you mean `inflow`? A boundary of its own needs a condition",
        ),
        (
            &["fluid.density=-1", "mesh.refine=x"],
            "--set fluid.density=-1: expected a number above 0\n--set mesh.refine=x: expected an integer from 0 to 10",
        ),
        (
            &["boundary.inflow.velocity=[\"sin(\", 0]"],
            "--set boundary.inflow.velocity=[\"sin(\", 0]: boundary.inflow.velocity[0] = \"sin(\": ends where a number, a name or `(` is expected (at byte 4)",
        ),
        (
            &["boundary.inflow.velocity=[1, 0"],
            "--set boundary.inflow.velocity=[1, 0: `[1, 0` is not a TOML value",
        ),
        (&["time.step"], "--set time.step: expected key=value, such as `time.step=0.01`"),
        (&["time.step="], "--set time.step=: expected a value after `=` (`none` removes the key)"),
        (&["time..step=1"], "--set time..step=1: expected a dotted key before `=`, such as `time.step`"),
        (&["time.step.size=1"], "--set time.step.size=1: `time.step` is a number, it has no keys"),
        (&["fluid=7"], "--set fluid=7: expected a table [fluid]"),
        (&["fluid.density=none"], "fsi3.toml:12:2: fluid.density: missing: the density [kg/m³]"),
    ] {
        assert_eq!(wrong_builtin("fsi3", overrides), expected, "{overrides:?}");
    }
}

#[test]
fn names_are_checked_against_the_mesh() {
    let fits = |name: &str, overrides: &[&str]| match builtin(name, overrides).check_mesh(&turek_hron()) {
        Ok(()) => String::new(),
        Err(e) => e.to_string(),
    };
    for (overrides, expected) in [
        (
            &["boundary.outflw.condition=do-nothing"][..],
            "--set boundary.outflw.condition=do-nothing: boundary.outflw: the mesh has no boundary `outflw`; did you mean `outflow`? There are `inflow`, `outflow`, `walls`, `cylinder`, `clamp`, `interface`",
        ),
        (
            &["boundary.clamp=none"],
            "fsi1.toml:26:2: boundary: boundary `clamp` of the mesh has no condition: add [boundary.clamp] with condition = one of <solid>\n\
          fsi1.toml:17:2: solid: nothing holds the solid, so it has no stationary state: add a boundary with condition = `clamped`",
        ),
        (
            &["boundary.walls=none", "boundary.inflow.condition=clamped"],
            "--set boundary.inflow.condition=clamped: `clamped` is for a solid, and only the fluid is here; use `no-slip`\n\
          fsi1.toml:26:2: boundary: boundary `walls` of the mesh has no condition: add [boundary.walls] with condition = one of <fluid>",
        ),
        (
            &["functional.drag.on=[\"cylindre\", \"clamp\"]"],
            "--set functional.drag.on=[\"cylindre\", \"clamp\"]: the mesh has no boundary `cylindre`; did you mean `cylinder`? There are `inflow`, `outflow`, `walls`, `cylinder`, `clamp`, `interface`\n\
          --set functional.drag.on=[\"cylindre\", \"clamp\"]: the fluid does not touch the boundary `clamp`",
        ),
        (
            &["boundary.clamp.condition=do-nothing"],
            "--set boundary.clamp.condition=do-nothing: only the solid is here; use one of <solid>\n\
          fsi1.toml:17:2: solid: nothing holds the solid, so it has no stationary state: add a boundary with condition = `clamped`",
        ),
        (
            &["solid.region=beam"],
            "--set solid.region=beam: the mesh has no region `beam`; there are `fluid`, `solid`\n\
          fsi1.toml:8:2: mesh: region `solid` of the mesh is used by no table: leave it out with mesh.leave-out = [\"solid\"], which makes walls of the sides, or name one as fluid.region or solid.region",
        ),
        (
            &["boundary.outflow.condition=no-slip"],
            "fsi1.toml:13:2: fluid: the fluid is closed in on all sides, so its pressure is determined up to a constant only (at rest the solid does not give way): one boundary needs condition = `do-nothing` or `traction-free`, or give the case a [time] to begin in",
        ),
        // The data decide, see `undula-cli/tests/cli`.
        (&["solid=none", "boundary.outflow.condition=no-slip"], ""),
        (
            &["mesh.leave-out=[\"rock\", \"fluid\"]"],
            "--set mesh.leave-out=[\"rock\", \"fluid\"]: the mesh has no region `rock`; there are `fluid`, `solid`\n\
          --set mesh.leave-out=[\"rock\", \"fluid\"]: region `fluid` is that of [fluid]; it cannot be left out",
        ),
    ] {
        assert_eq!(fits("fsi1", overrides), with_conditions(expected), "{overrides:?}");
    }
}

#[test]
fn a_case_that_is_not_there() {
    let told = |name: &str| match Case::load(name, &[]) {
        Ok(_) => panic!("{name}"),
        Err(e) => (e.to_string(), e.is_bad_input()),
    };
    assert_eq!(told("fsi33"), ("no such case or file: `fsi33`; did you mean `fsi3`?".into(), true));
    assert_eq!(told("fs3.toml"), ("no such case or file: `fs3.toml`; did you mean `fsi3`?".into(), true));
    assert_eq!(
        told("missing/own.toml").0,
        "no such case or file: `missing/own.toml`; built-in cases are `cfd1`, `cfd2`, `cfd3`, `csm1`, `csm2`, `csm3`, \
         `fsi1`, `fsi2`, `fsi3`, `dfg-2d1`, `dfg-2d2`, `dfg-2d3`, `rotor`, `flap`, `cavity`, `tube-2d`, `cylinder`, `pump`, `valve`, \
         `dfg-3d1z`, `dfg-3d3z`, `cook`, `fsi-box`, `tube`, `land`"
    );
    // A directory exists, but it cannot be read as a file.
    assert!(!told("src").1);
}

/// Damaged files are refused or accepted, but never end the program.
#[test]
fn damaged_files_do_no_harm() {
    let mut seed = 1u64;
    let mut random = |n: usize| {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as usize % n
    };
    let pieces =
        ["[", "]", "\"", "=", "\n", "-", "{", "}", "1e999", "ü", ".", "(", "^", "none", "0x", "\\u00", ","];
    let mut accepted = 0;
    for round in 0..3000 {
        let shipped = &builtin_cases()[round % builtin_cases().len()];
        let mut text: Vec<char> = shipped.toml.chars().collect();
        for _ in 0..1 + random(3) {
            let at = random(text.len());
            match random(3) {
                0 => drop(text.drain(at..(at + 1 + random(8)).min(text.len()))),
                1 => drop(text.splice(at..at, pieces[random(pieces.len())].chars())),
                _ => text.swap(at, round % 50),
            }
        }
        let text: String = text.into_iter().collect();
        match Case::from_toml(&text, "own.toml", &[]) {
            Ok(case) => {
                accepted += 1;
                assert_eq!(Case::from_toml(&case.to_toml(), "own.toml", &[]).as_ref(), Ok(&case), "{text}");
                let _ = case.check_mesh(&turek_hron());
            }
            Err(e) => assert!(!e.0.is_empty() && !e.to_string().is_empty(), "{text}"),
        }
    }
    assert!(accepted > 100, "{accepted}");
}

/// Pairs for which the pressure is not determined; a solid alone has none.
#[test]
fn unstable_pairs_are_refused_with_the_reason() {
    let refused = |set: &[&str]| wrong_builtin("fsi1", set);
    assert_eq!(
        refused(&["space.velocity=Q1", "stabilization.pressure=off"]),
        "--set stabilization.pressure=off: the pair Q1/Q1 is of equal order: its inf-sup constants (5.24) and (5.25) \
         are 0 or go to 0, and the pressure is not determined; expected `lps`, `pspg` or `brezzi-pitkaranta`"
    );
    assert_eq!(
        refused(&["space.velocity=Q3", "space.pressure=P3dc"]),
        "--set space.pressure=P3dc: has too many unknowns for the velocity Q3 (inf-sup \
         condition (5.24)); P2dc goes with it"
    );
    assert!(refused(&["space.velocity=Q1", "space.pressure=P0"]).contains("checkerboard"));
    assert_eq!(
        refused(&["space.velocity=P2", "space.pressure=Q1"]),
        "--set space.pressure=Q1: lives on other cells than the velocity P2, which needs triangles or tetrahedra; P1 goes with it"
    );
    for set in [&["space.velocity=Q3", "space.pressure=Q1"][..], &["solid=none", "space.pressure=P0"]] {
        builtin("fsi1", set);
    }
    for velocity in ["Q2", "Q3", "Q4", "P2", "P3", "P2-bubble"] {
        builtin("fsi1", &[&format!("space.velocity={velocity}")]);
    }
    builtin("csm1", &["space.velocity=Q1"]);
}

#[test]
fn a_mesh_file_must_have_the_cells_of_the_velocity() {
    let file = std::env::temp_dir().join(format!("undula-cells-{}.msh", std::process::id()));
    let triangles = undula::mesh::generate::schaefer_turek(0).triangulated();
    std::fs::write(&file, undula::mesh::gmsh::write(&triangles)).unwrap();
    let mesh = format!("mesh.file={}", file.display());
    let set =
        |velocity: &'static str| ["mesh.generator=none", "mesh.refine=0", &mesh, velocity].map(String::from);
    let case = Case::builtin("dfg-2d1", &set("space.velocity=P2")).unwrap();
    assert_eq!(case.check_mesh_and_measure().unwrap().cells, triangles.n_cells());
    let refused =
        Case::builtin("dfg-2d1", &set("space.velocity=Q2")).unwrap().check_mesh_and_measure().err().unwrap();
    std::fs::remove_file(&file).unwrap();
    assert_eq!(
        refused.to_string(),
        "--set space.velocity=Q2: space.velocity = Q2 needs quadrilaterals, the mesh has triangles: take P2, or a mesh \
         of quadrilaterals"
    );
}

#[test]
fn senseless_motions_are_refused() {
    for (name, overrides, expected) in [
        (
            "fsi1",
            &["motion.model=jacobian-stiffened", "motion.jacobian=lagged"][..],
            "--set motion.jacobian=lagged: a stationary case has no last step to take J from; use `implicit`",
        ),
        (
            "fsi3",
            &["motion.model=biharmonic", "space.velocity=Q1", "space.pressure=P0"],
            "the mixed form does not converge with elements of degree 1; take `Q2` or higher as space.velocity",
        ),
        (
            "fsi3",
            &["motion.model=biharmonic", "space.velocity=P1"],
            "--set motion.model=biharmonic: the mixed form does not converge with elements of degree 1; take `P2` or higher",
        ),
    ] {
        let message = wrong_builtin(name, overrides);
        assert!(message.contains(expected), "{message}");
    }
    let case = builtin("fsi3", &["motion.scale=0.1", "motion.outer=hinged"]);
    assert_eq!(
        case.notes(),
        [
            "motion.scale has no effect with this motion.model",
            "motion.outer has no effect with this motion.model"
        ]
    );
}

#[test]
fn senseless_settings_of_gmres_are_refused() {
    for (set, words) in [
        ("linear.krylov=bicg", "expected one of `none`, `gmres`"),
        ("linear.krylov-tolerance=1", "expected a number above 0 and below 1"),
        ("linear.krylov-size=0", "expected an integer from 1 to 200"),
        ("linear.solver=gmres", "linear.krylov = \"gmres\""),
    ] {
        let message = wrong_builtin("fsi3", &["linear.krylov=gmres", set]);
        assert!(message.contains(words), "{message}");
    }
    let case = builtin("fsi3", &["linear.krylov-size=5"]);
    assert_eq!(case.notes(), ["linear.krylov-size has no effect: linear.krylov is not `gmres`"]);
}

/// Terms that a pair does not need, keys without effect, and patches that are not there.
#[test]
fn senseless_stabilisation_is_refused_with_the_reason() {
    for (set, words) in [
        (
            &["stabilization.pressure=lps"][..],
            "works on continuous pressures only, and the pair Q2/P1dc needs none",
        ),
        (
            &["space.pressure=Q1", "stabilization.pressure=lps"],
            "the pair Q2/Q1 is stable, and would only lose",
        ),
        (&["stabilization.alpha=0.2"], "without effect: it belongs to a `pressure` term"),
        (&["stabilization.delta=0.2"], "without effect: it belongs to a `transport` term"),
        (&["stabilization.projection=patch"], "without effect"),
        (&["stabilization.map=none"], "without effect: it belongs to a `pressure` or a `transport` term"),
        (&["space.pressure=Q2", "stabilization.map=half"], "expected one of `none`, `size`, `full`"),
        (&["space.pressure=Q2", "stabilization.directional=1"], "expected true or false"),
        (&["space.pressure=Q2", "stabilization.alpha=0"], "expected a number above 0"),
        (&["stabilization.transport=gls"], "expected one of `off`, `lps`, `supg`"),
        (
            &["space.velocity=P2-bubble", "stabilization.pressure=pspg"],
            "--set stabilization.pressure=pspg: works on continuous pressures only, and the pair P2-bubble/P1dc needs \
             none; expected `off`",
        ),
        (
            &["space.velocity=P2-bubble", "space.pressure=P1", "stabilization.pressure=lps"],
            "--set stabilization.pressure=lps: the pair P2-bubble/P1 is stable, and would only lose accuracy; expected \
             `off` or `pspg`",
        ),
    ] {
        let said = wrong_builtin("fsi1", set);
        assert!(said.contains(words), "{set:?}: {said}");
    }
    for pressure in ["space.pressure=Q2", "space.velocity=P1"] {
        let case = builtin("fsi1", &[pressure, "stabilization.projection=patch", "mesh.refine=0"]);
        let said = case.check_mesh_and_measure().err().map_or(String::new(), |e| e.to_string());
        assert!(
            said.contains(
                "stabilization.projection=patch: the fluid does not consist of cells refined in four"
            ),
            "{said}"
        );
        builtin("fsi1", &[pressure, "stabilization.projection=patch", "mesh.refine=1"])
            .check_mesh_and_measure()
            .unwrap();
    }
}

/// A pair of equal order is stabilised unless something else is asked for.
#[test]
fn pairs_of_equal_order_are_stabilised() {
    use undula::physics::PressureTerm;
    for set in
        [&["space.velocity=Q1"][..], &["space.pressure=Q2"], &["space.velocity=Q3", "space.pressure=Q3"]]
    {
        assert_eq!(builtin("fsi1", set).stabilization.pressure, PressureTerm::LocalProjection, "{set:?}");
    }
    assert!(!builtin("fsi1", &[]).stabilization.acts());
}

#[test]
fn forces_at_the_current_position_need_a_method_that_knows_it() {
    let force = ["fluid.body-force=[\"x\", 0]", "fluid.body-force-at=current"];
    for (other, expected) in
        [("time.scheme=cg1", "middle of a step"), ("stabilization.transport=supg", "supg")]
    {
        let message = wrong_builtin("fsi3", &[&force[..], &[other]].concat());
        assert!(message.contains(expected), "{message}");
    }
    builtin("fsi3", &[&force[..], &["time.scheme=bdf2"]].concat());
}
