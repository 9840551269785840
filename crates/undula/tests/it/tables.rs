//! Tables of values in expressions, and values with units.

use crate::common::{FLUID, sets};
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use undula::Simulation;
use undula::case::expression::Expression;
use undula::case::{Case, Condition};

/// A directory of one test.
fn place(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("tables-{name}"));
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// The expression `table(FILE, t` + `rest` of a file with this `text`.
fn table(folder: &Path, text: &str, rest: &str) -> Result<Expression, String> {
    let file = folder.join("table.csv");
    fs::write(&file, text).unwrap();
    Expression::parse(&format!("table('{}', {rest}", file.display())).map_err(|e| e.to_string())
}

fn rows(arguments: impl IntoIterator<Item = f64>, f: impl Fn(f64) -> f64) -> String {
    arguments.into_iter().map(|a| format!("{a:?},{:?}\n", f(a))).collect()
}

/// `n` intervals on \[0, 1\] that are not of one length, the same ones smaller and smaller as n grows.
fn points(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).map(|s| s + 0.1 * (TAU * s).sin() / TAU).collect()
}

/// Largest error and mean error of `table` on \[0, 1\].
fn errors(table: &Expression, exact: impl Fn(f64) -> f64) -> [f64; 2] {
    const N: usize = 20_000;
    let error = |i: usize| (table.eval(&[0.0; 3], i as f64 / N as f64) - exact(i as f64 / N as f64)).abs();
    let all: Vec<f64> = (0..=N).map(error).collect();
    [all.iter().copied().fold(0.0, f64::max), all.iter().sum::<f64>() / N as f64]
}

/// Orders of the largest and of the mean error of a table of `f`, over four refinements from `n` intervals on.
fn orders(folder: &Path, n: usize, how: &str, f: fn(f64) -> f64) -> [f64; 2] {
    let error = |n: usize| {
        let table = table(folder, &rows(points(n), f), &format!("t, '{how}')")).unwrap();
        errors(&table, f)
    };
    let (coarse, fine) = (error(n), error(16 * n));
    [0, 1].map(|i| (coarse[i] / fine[i]).log2() / 4.0)
}

#[test]
fn tables_of_smooth_functions_have_their_orders() {
    let folder = place("orders");
    let sine = |a: f64| (TAU * a).sin();
    for n in [16, 19] {
        let [largest, mean] = orders(&folder, n, "linear", sine);
        assert!((largest - 2.0).abs() < 0.1 && (mean - 2.0).abs() < 0.05, "linear, {n}: {largest} {mean}");
    }
    // Rises everywhere: no slope is cut.
    let [largest, mean] = orders(&folder, 16, "cubic", |a| (1.3 * a - 0.4).exp());
    assert!(largest >= 2.95 && mean >= 2.95, "{largest} {mean}");
    for how in ["cubic", "cubic periodic"] {
        // Extrema that are no rows: monotony costs an order there, in two intervals of all.
        let [_, mean] = orders(&folder, 19, how, sine);
        assert!(mean >= 2.95, "{how}: {mean}");
        // Extrema at rows.
        let even = |n: usize| {
            let text = rows((0..=n).map(|i| i as f64 / n as f64), sine);
            errors(&table(&folder, &text, &format!("t, '{how}')")).unwrap(), sine)[0]
        };
        let largest = (even(16) / even(128)).log2() / 3.0;
        assert!(largest >= 2.95, "{how}: {largest}");
    }
}

#[test]
fn cubic_tables_keep_to_their_values() {
    let folder = place("monotone");
    // Steps, a plateau and a spike, on intervals of all lengths.
    let data =
        [(0.0, 0.0), (1.0, 0.0), (1.1, 1.0), (3.0, 1.0), (3.2, 0.9), (5.0, 7.0), (5.5, 0.0), (8.0, 0.0)];
    let text: String = data.iter().map(|(a, v)| format!("{a} {v}\n")).collect();
    for how in ["cubic", "cubic periodic"] {
        let table = table(&folder, &text, &format!("x, '{how}')")).unwrap();
        for pair in data.windows(2) {
            let ((a, v), (b, w)) = (pair[0], pair[1]);
            let mut before = v;
            for i in 0..=200 {
                let value = table.eval(&[a + (b - a) * f64::from(i) / 200.0, 0.0, 0.0], 0.0);
                assert!((value - before) * (w - v) >= 0.0, "{how}: between {a} and {b}: {before}, {value}");
                assert!(value >= v.min(w) && value <= v.max(w), "{how}: {value}");
                before = value;
            }
        }
    }
}

/// Values at rows are exact, values and (cubic) slopes are continuous across rows and across the seam of a period.
#[test]
fn tables_are_smooth_across_rows_and_periods() {
    let folder = place("smooth");
    let f = |a: f64| (TAU * a).sin() + 0.5 * (2.0 * TAU * a).cos();
    let mut text = rows(points(23).into_iter().take(23), f);
    text += &format!("1.0,{:?}\n", f(0.0));
    let at = |e: &Expression, a: f64| e.eval_with_gradient(&[a, 0.0, 0.0], 0.0);
    for (how, smooth) in [("linear periodic", false), ("cubic periodic", true)] {
        let table = table(&folder, &text, &format!("x, '{how}')")).unwrap();
        for (i, a) in points(23).into_iter().enumerate().take(23) {
            assert_eq!(at(&table, a).0, f(a), "row {i}");
            // Periods later and before, up to the rounding of the argument.
            for k in [-3.0, 1.0, 2.0] {
                assert!((at(&table, a + k).0 - f(a)).abs() < 1e-12, "row {i} moved by {k}");
            }
            for period in [0.0, 1.0] {
                let (left, right) = (at(&table, a + period - 1e-9), at(&table, a + period + 1e-9));
                assert!((left.0 - right.0).abs() < 1e-7, "{how}: a jump at row {i}");
                let jump = (left.1[0] - right.1[0]).abs();
                assert!((jump < 1e-4) == smooth, "{how}: the slope jumps by {jump} at row {i}");
            }
        }
    }
}

#[test]
fn derivatives_go_through_tables() {
    let folder = place("derivatives");
    let text = rows(points(12), |a| (3.0 * a).sin());
    for how in ["linear", "cubic", "cubic periodic"] {
        let text = if how.ends_with('c') && how.contains(' ') {
            rows(points(12), |a| (TAU * a).sin())
        } else {
            text.clone()
        };
        let expression = table(&folder, &text, &format!("0.3 + 0.5*x*y + 0.1*t, '{how}') * y + x")).unwrap();
        assert!(expression.depends_on_space() && expression.depends_on_time() && !expression.is_constant());
        for (x, y) in [(0.31, 0.77), (0.83, 0.42), (-0.2, 0.9)] {
            let (value, gradient) = expression.eval_with_gradient(&[x, y, 0.0], 0.4);
            assert_eq!(value, expression.eval(&[x, y, 0.0], 0.4));
            let moved = |dx: f64, dy: f64| expression.eval(&[x + dx, y + dy, 0.0], 0.4);
            let h = 1e-6;
            for (d, difference) in
                [moved(h, 0.0) - moved(-h, 0.0), moved(0.0, h) - moved(0.0, -h)].iter().enumerate()
            {
                let difference = difference / (2.0 * h);
                assert!(
                    (gradient[d] - difference).abs() < 1e-7,
                    "{how}: {} is not {difference}",
                    gradient[d]
                );
            }
        }
    }
}

#[test]
fn all_forms_of_a_file_are_read() {
    let folder = place("forms");
    let expected = table(&folder, "0,1\n2,5\n", "t)").unwrap();
    for text in [
        "t,p\n0,1\n2,5",
        "\u{feff}time [s];pressure [Pa]\r\n0;1\r\n2;5\r\n",
        "# measured\n\n 0 \t 1 \n2\t5\n",
        "t p\n0   1\n\n2.0 5e0\n# end\n",
        "\"t\", \"p\"\n0.0 , 1.0\n2.0 , 5.0\n",
    ] {
        let read = table(&folder, text, "t)").unwrap_or_else(|e| panic!("{text}: {e}"));
        for t in [0.0, 0.3, 1.0, 2.0] {
            assert_eq!(read.eval(&[0.0; 3], t), expected.eval(&[0.0; 3], t), "{text}");
        }
    }
    let file = folder.join("table.csv");
    fs::write(&file, "0,1\n2,5\n").unwrap();
    let value = |source: &str| {
        let source = source.replace("FILE", &file.display().to_string());
        Expression::parse(&source).unwrap().eval(&[0.0; 3], 0.5)
    };
    assert_eq!(value("2*table(\"FILE\", t) + 1"), 5.0);
    assert_eq!(value("table('FILE', table('FILE', t)/2)"), 3.0);
    // Constant arguments are folded; what is not taken need not have a value; the ends are kept where it is asked for.
    assert_eq!(value("table('FILE', 1)"), 3.0);
    assert_eq!(value("if(t < 3, 7, table('FILE', 9))"), 7.0);
    assert_eq!(value("table('FILE', clamp(9*t, 0, 2))"), 5.0);
    assert!(value("table('FILE', 5*t)").is_nan());
    assert!(value("table('FILE', -t)").is_nan());
    // An end that rounding has moved.
    assert_eq!(value("table('FILE', 4*t*(1 + 1e-12))"), 5.0);
    let constant = Expression::parse(&format!("table('{}', 1)", file.display())).unwrap();
    assert_eq!(constant.constant_value(), Some(3.0));
}

#[test]
fn wrong_files_are_told_with_their_line() {
    let folder = place("wrong");
    for (text, rest, expected) in [
        ("t,p\n0,1\n0.5,2\n0.4,3\n", "t)", "table.csv:4: the argument 0.4 is not above 0.5"),
        ("0,1\n0,2\n", "t)", "table.csv:2: the argument 0 is not above 0"),
        ("0,1\n1,nan\n", "t)", "table.csv:2: expected finite numbers, not `nan`"),
        ("0,1\n1,1e999\n", "t)", "table.csv:2: expected finite numbers, not `1e999`"),
        (
            "t,p\n0,1\n",
            "t)",
            "table.csv:2: expected at least two rows of two numbers, argument and value, not 1",
        ),
        ("", "t)", "table.csv: expected at least two rows"),
        ("0,1\n1,2,3\n", "t)", "table.csv:2: expected two columns, argument and value, as `0.1, 2.5`, not 3"),
        (
            "0,1\n1,x\n",
            "t)",
            "table.csv:2: expected two numbers, argument and value, as `0.1, 2.5`; `x` is none",
        ),
        ("t,p\nt,p\n0,1\n1,1\n", "t)", "table.csv:2: expected two numbers"),
        ("0,1\n\n1,1.5\n", "t, 'periodic')", "table.csv:3: the last value, 1.5, is not the first one, 1"),
        (
            "0,1\n1,2\n",
            "t, 'cubik')",
            "`cubik` is no way to join the values of a table; did you mean `cubic`?",
        ),
        ("0,1\n1,2\n", "t, 'linear cubic')", "a table is either `linear` or `cubic`"),
        ("0,1\n1,2\n", "t, 3)", "expected words in quotes, as in `table(\"file.csv\", t)`"),
        ("0,1\n1,2\n", "t, 'cubic', 3)", "expected `)` to close `table(`"),
        ("0,1\n1,2\n", "t", "expected `)` to close `table(`"),
    ] {
        let message = table(&folder, text, rest).err().unwrap_or_else(|| panic!("{text} should be refused"));
        assert!(message.contains(expected), "{text}: {message}");
    }
    for (source, expected) in [
        ("table('nowhere.csv', t)", "table nowhere.csv: No such file or directory (os error 2) (at byte 6)"),
        ("table(t)", "expected the name of a file in quotes, as in"),
        ("table('a.csv')", "expected `,` and the argument"),
        ("tabel('a.csv', t)", "unknown function `tabel`; did you mean `table`?"),
        ("2*table", "expected `(` after the function `table`"),
        ("1 + 'a'", "a text stands only in `table"),
        ("table('a.csv, t)", "`'` without a second one"),
    ] {
        let message = Expression::parse(source).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(expected), "{source}: {message}");
    }
    // A period whose ends differ by the rounding of decimals is closed.
    assert!(table(&folder, &rows(points(9), |a| (TAU * a).sin()), "t, 'periodic')").is_ok());
}

/// A channel whose inflow is `inflow`, at rest at t = 0.
fn channel(inflow: &str) -> String {
    format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [3, 1]\ncells = [3, 2]\n[fluid]\ndensity = 1\n\
         kinematic-viscosity = 0.1\n[boundary.left]\ncondition = \"velocity\"\nvelocity = ['{inflow}', 0]\n\
         [boundary.right]\ncondition = \"do-nothing\"\n[boundary.bottom]\ncondition = \"no-slip\"\n\
         [boundary.top]\ncondition = \"no-slip\"\n[time]\nscheme = \"bdf2\"\nstep = 0.05\nend = 1\n\
         [functional.dp]\nkind = \"pressure-difference\"\na = [0, 0.5]\nb = [3, 0.5]\n"
    )
}

/// Velocities \[m/s\] at all times of a case in the file `own.toml` of `folder`.
fn velocities(folder: &Path, text: &str, threads: usize) -> Vec<f64> {
    let file = folder.join("own.toml");
    let case = Case::from_toml(text, &file.display().to_string(), &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = Simulation::new(case, threads).unwrap();
    let mut velocities = vec![];
    while !simulation.finished() {
        simulation.step().unwrap();
        velocities.extend_from_slice(&simulation.stepper.new.v);
    }
    assert_eq!(simulation.history.len(), 20);
    velocities
}

#[test]
fn a_tabulated_pulse_drives_the_channel_like_its_formula() {
    let folder = place("channel");
    let exact = velocities(&folder, &channel("4*y*(1 - y)*sin(2*pi*t)^2"), 1);
    for (how, least) in [("linear", 1.95), ("cubic periodic", 2.95)] {
        let error = |n: usize| {
            // Rows beside the times of the steps.
            let arguments = (0..=n).map(|i| 0.5 * i as f64 / n as f64);
            fs::write(folder.join("pulse.csv"), rows(arguments, |t| (TAU * t).sin().powi(2))).unwrap();
            let argument = if how == "linear" { "if(t < 0.5, t, t - 0.5)" } else { "t" };
            let inflow = format!("4*y*(1 - y)*table(\"pulse.csv\", {argument}, \"{how}\")");
            let computed = velocities(&folder, &channel(&inflow), 1);
            computed.iter().zip(&exact).map(|(v, w)| (v - w).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(24), error(96));
        let order = (coarse / fine).log2() / 2.0;
        println!("{how}: {coarse:e} {fine:e}, order {order}");
        assert!(order >= least && fine < 2e-3, "{how}: {coarse:e} {fine:e}, order {order}");
    }
    let inflow = "4*y*(1 - y)*table(\"pulse.csv\", t, \"cubic periodic\")";
    let bits = |threads| {
        let velocities = velocities(&folder, &channel(inflow), threads);
        velocities.iter().map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(1), bits(2));
}

/// Where `set` says so, paths are those of the working directory.
#[test]
fn tables_are_found_beside_the_case_and_written_back() {
    let folder = place("back");
    fs::create_dir_all(folder.join("data")).unwrap();
    fs::create_dir_all(folder.join("out/run")).unwrap();
    fs::write(folder.join("data/in.csv"), "0,0\n1,1\n").unwrap();
    let name = folder.join("own.toml").display().to_string();
    let text = channel("80 [mm/s] * table(\"data/in.csv\", table(\"data/in.csv\", t))*y");
    let case = Case::from_toml(&text, &name, &[]).unwrap();
    let Some(Condition::Velocity(vector)) = case.boundary.get("left") else { panic!() };
    let [x, _] = &vector[..] else { panic!() };
    assert_eq!(x.source(), "0.08 * table(\"data/in.csv\", table(\"data/in.csv\", t))*y");
    assert_eq!(x.eval(&[0.0, 2.0, 0.0], 0.25), 0.04);
    let again = Case::from_toml(&case.to_toml(), "elsewhere/case.toml", &[]);
    assert_eq!(again.as_ref(), Ok(&case), "{}", case.to_toml());
    let moved = case.to_toml_in(&folder.join("out/run"));
    assert_eq!(moved.matches("table(\"../../data/in.csv\", ").count(), 2, "{moved}");
    let file = folder.join("out/run/case.toml").display().to_string();
    assert_eq!(Case::from_toml(&moved, &file, &[]).as_ref(), Ok(&case));
    // Other values are another case.
    fs::write(folder.join("data/in.csv"), "0,0\n1,2\n").unwrap();
    assert_ne!(Case::from_toml(&text, &name, &[]).as_ref(), Ok(&case));
    let refused = Case::from_toml(&text, "elsewhere.toml", &[]).unwrap_err().to_string();
    assert!(
        refused.contains("elsewhere.toml:11:") && refused.contains("data/in.csv: No such file"),
        "{refused}"
    );
    let set = sets(&["boundary.left.velocity=[\"table('data/in.csv', t)\", 0]"]);
    let refused = Case::from_toml(&text, &name, &set).unwrap_err().to_string();
    assert!(refused.contains("table data/in.csv: No such file"), "{refused}");
}

#[test]
fn a_table_that_ends_too_early_is_told_before_the_run() {
    let folder = place("early");
    fs::write(folder.join("in.csv"), "0,0\n0.5,1\n").unwrap();
    let name = folder.join("own.toml").display().to_string();
    let refusal = |text: &str| {
        let case = Case::from_toml(text, &name, &[]).unwrap_or_else(|e| panic!("{e}"));
        Simulation::new(case, 1).err().unwrap_or_else(|| panic!("should be refused:\n{text}")).to_string()
    };
    let message = refusal(&channel("table(\"in.csv\", 2*t)*y*(1 - y)"));
    for word in [
        "own.toml:11:",
        "boundary.left.velocity",
        "in.csv has arguments from 0 to 0.5, `2*t` is",
        "clamp(2*t, 0, 0.5)",
    ] {
        assert!(message.contains(word), "{message}");
    }
    let message = refusal(
        &(channel("y*(1 - y)") + "[fluid]\n")
            .replace("[fluid]\ndensity", "[fluid]\nbody-force = [0, 'table(\"in.csv\", x)']\ndensity")
            .replace("b = [3, 0.5]\n[fluid]\n", "b = [3, 0.5]\n"),
    );
    assert!(message.contains("fluid.body-force") && message.contains("`x` is"), "{message}");
    let message = refusal(
        &channel("y*(1 - y)").replace("[fluid]", "region.fluid = 'table(\"in.csv\", y) + 1'\n[fluid]"),
    );
    assert!(message.contains("mesh.region.fluid") && message.contains("`y` is"), "{message}");
    let text = channel("y*(1 - y)").replace("step = 0.05", "step = '0.1 + table(\"in.csv\", t)'");
    let message = Case::from_toml(&text, &name, &[]).unwrap_err().to_string();
    assert!(message.contains("time.step") && message.contains("from 0 to 0.5, `t` is"), "{message}");
}

/// Bit for bit: a case with units is the case in SI units.
#[test]
fn values_with_units_are_those_in_si_units() {
    let si = channel("y*(1 - y)");
    let text = si
        .replace("lower = [0, 0]", "lower = [\"0 m\", 0]")
        .replace("upper = [3, 1]", "upper = [\"300 cm\", \"1000 mm\"]")
        .replace("density = 1\n", "density = \"1 g/l\"\n")
        .replace("viscosity = 0.1\n", "viscosity = \"1000 cSt\"\n")
        .replace("viscosity = \"1000 cSt\"", "viscosity = \"1e5 mm^2/s\"")
        .replace("step = 0.05", "step = \"50 ms\"")
        .replace("end = 1\n", "end = \"1 s\"\n")
        .replace("a = [0, 0.5]", "a = [0, \"0.5 m\"]");
    let (si, case) = (Case::from_toml(&si, "own.toml", &[]), Case::from_toml(&text, "own.toml", &[]));
    assert_eq!(case, si);
    assert_eq!(case.unwrap().to_toml(), si.unwrap().to_toml());
    let set = |sets_: &[&str]| Case::from_toml(FLUID, "own.toml", &sets(sets_)).map_err(|e| e.to_string());
    let case = set(&[
        "fluid.kinematic-viscosity=1 mm²/s",
        "fluid.body-force=[\"9.81 m/s^2\", \"-1 [cm/s^2] + 2*x\"]",
        "boundary.outflow.condition=traction",
        "boundary.outflow.traction=[\"-120 mmHg\", \"10 [kPa]*sin(2*pi*t/0.8 [s])\"]",
        "time.step=2 ms",
        "time.end=0.1 min",
    ])
    .unwrap();
    let fluid = case.fluids[0].clone();
    assert_eq!((fluid.kinematic_viscosity, fluid.body_force[0].constant_value()), (1e-6, Some(9.81)));
    assert_eq!(fluid.body_force[1].source(), "-0.01 + 2*x");
    let Some(Condition::Traction(vector)) = case.boundary.get("outflow") else { panic!() };
    let [x, y] = &vector[..] else { panic!() };
    assert_eq!((x.constant_value(), y.source()), (Some(-15998.6864898), "10000.0*sin(2*pi*t/0.8)"));
    let time = case.time.clone().unwrap();
    assert_eq!((time.step.constant_value(), time.end), (Some(2e-3), 6.0));
    assert!(
        case.to_toml().contains("traction = [-15998.6864898, \"10000.0*sin(2*pi*t/0.8)\"]"),
        "{}",
        case.to_toml()
    );
}

#[test]
fn wrong_units_are_told_with_their_place() {
    let told = |set: &str| match Case::from_toml(FLUID, "own.toml", &sets(&[set])) {
        Ok(_) => panic!("{set} should be refused"),
        Err(e) => e.to_string(),
    };
    for (set, expected) in [
        ("fluid.density=1 mm", "this is a length [m]; expected a density [kg/m³], such as \"1.06 g/cm^3\""),
        ("fluid.density=1 kg/m^2", "this is a value in kg m^-2; expected a density"),
        ("fluid.density=-1 g/l", "expected a number above 0"),
        ("fluid.kinematic-viscosity=4 mPa s", "this is a dynamic viscosity"),
        ("fluid.kinematic-viscosity=5 l/min", "in the plane a flux is an area per time"),
        ("fluid.density=1 kgm", "unknown unit `kgm`"),
        ("fluid.density=1000", ""),
        ("motion.poisson=0.3 m", "expected a pure number, without a unit"),
        ("fluid.body-force=[\"1 m/s\", 0]", "this is a velocity [m s^-1]; expected an acceleration [m/s²]"),
        ("fluid.body-force=[\"2x\", 0]", "expected an operator before `x`"),
        ("fluid.body-force=[\"2 min(x, y)\", 0]", "expected an operator before `min`"),
        (
            "fluid.body-force=[\"1 mm/s^2 + x\", 0]",
            "expected an operator before `mm`; a unit in a formula stands in brackets",
        ),
        ("fluid.body-force=[\"1 [mmm] + x\", 0]", "unknown unit `mmm`; did you mean"),
        ("fluid.body-force=[\"1 [mm + x\", 0]", "`[` without `]`"),
        ("fluid.body-force=[\"1 [] + x\", 0]", "expected a unit"),
        ("fluid.body-force=[\"1 m/s^2/\", 0]", "expected a unit in `m/s^2/`"),
        ("mesh.refine=2 m", "an integer"),
    ] {
        if expected.is_empty() {
            assert!(Case::from_toml(FLUID, "own.toml", &sets(&[set])).is_ok(), "{set}");
            continue;
        }
        let message = told(set);
        assert!(message.contains(expected), "{set}: {message}");
    }
    let text = FLUID.replace("density = 1", "density = \"1 mmHg\"");
    let message = Case::from_toml(&text, "own.toml", &[]).unwrap_err().to_string();
    assert!(
        message.starts_with("own.toml:4:11: fluid.density = \"1 mmHg\": this is a pressure"),
        "{message}"
    );
}
