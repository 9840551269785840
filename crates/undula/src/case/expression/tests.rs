use super::*;

fn at(source: &str, x: f64, y: f64, t: f64) -> f64 {
    match Expression::parse(source) {
        Ok(e) => e.eval(&[x, y, 7.0], t),
        Err(e) => panic!("{source}: {e}"),
    }
}

fn value(source: &str) -> f64 {
    at(source, 0.3, 0.2, 1.5)
}

fn wrong(source: &str) -> String {
    match Expression::parse(source) {
        Ok(_) => panic!("{source} should be refused"),
        Err(e) => e.to_string(),
    }
}

#[test]
fn operators_bind_as_in_mathematics() {
    for (source, expected) in [
        ("1/2", 0.5),
        ("1+2*3", 7.0),
        ("(1+2)*3", 9.0),
        ("8-3-2", 3.0),
        ("8/4/2", 1.0),
        ("2^3^2", 512.0),
        ("-2^2", -4.0),
        ("2^-1", 0.5),
        ("(-2)^2", 4.0),
        ("-x^2", -0.09),
        ("2*-3", -6.0),
        ("--1", 1.0),
        ("+1.5e-3*1E3", 1.5),
        (".5 + 1.", 1.5),
        ("-2^2 + 1", -3.0),
        ("1 < 2", 1.0),
        ("2 <= 1", 0.0),
        ("1 + 1 > 1", 1.0),
        ("(1 < 2) >= 1", 1.0),
        ("x + y*z - t", 0.3 + 1.4 - 1.5),
        ("2*pi", std::f64::consts::TAU),
    ] {
        assert!((value(source) - expected).abs() < 1e-15, "{source} = {}", value(source));
    }
}

#[test]
fn functions_have_their_values() {
    for (source, expected) in [
        ("sin(pi/6)", 0.5),
        ("cos(0)+tan(0)", 1.0),
        ("asin(1)-acos(0)+atan(0)", 0.0),
        ("atan2(1, -1)", 0.75 * std::f64::consts::PI),
        ("cosh(1)^2-sinh(1)^2", 1.0),
        ("tanh(100)", 1.0),
        ("ln(exp(2))", 2.0),
        ("log10(1000)", 3.0),
        ("sqrt(x^2)", 0.3),
        ("abs(-3)+sign(-2)+sign(0)", 2.0),
        ("floor(1.5)+ceil(1.5)", 3.0),
        ("min(3,1,2)+max(3,1,2)", 4.0),
        ("pow(2,10)", 1024.0),
        ("hypot(3,4)", 5.0),
        ("step(-1e-9)+step(0)+step(1)", 2.0),
        ("if(x<y, 1/0, 5)", 5.0),
        ("if(1, x, 1/0)", 0.3),
        ("clamp(5,0,1)+clamp(-5,0,1)+clamp(t,0,2)", 2.5),
        ("ramp(-1,2)", 0.0),
        ("ramp(t-0.5,2)", 0.5),
        ("ramp(2,2)+ramp(9,2)", 2.0),
    ] {
        assert!((value(source) - expected).abs() < 1e-14, "{source} = {}", value(source));
    }
    assert!(value("ramp(0, 2)") == 0.0);
}

#[test]
fn inflow_of_the_benchmark() {
    let source = "1.5*2.0*y*(0.41-y)/(0.41/2)^2*ramp(t,2)";
    assert!((at(source, 0.0, 0.205, 5.0) - 3.0).abs() < 1e-14);
    assert!((at(source, 0.0, 0.205, 1.0) - 1.5).abs() < 1e-14);
    assert!(at(source, 0.0, 0.0, 1.0) == 0.0);
}

#[test]
fn mistakes_are_named_with_their_position() {
    for (source, expected) in [
        ("sinn(y)", "unknown function `sinn`; did you mean `sin`? (at byte 0)"),
        ("1 + foobar(y)", "unknown function `foobar` (at byte 4)"),
        ("2*w", "unknown name `w`; there are `x`, `y`, `z`, `t` and `pi` (at byte 2)"),
        ("2*pie", "unknown name `pie`; did you mean `pi`? (at byte 2)"),
        ("2*sin", "expected `(` after the function `sin` (at byte 2)"),
        ("2x", "expected an operator before `x` (at byte 1)"),
        ("2 (x)", "expected an operator before `(` (at byte 2)"),
        ("x**2", "unknown operator `**`; did you mean `^`? (at byte 1)"),
        ("", "empty expression (at byte 0)"),
        ("1 +", "ends where a number, a name or `(` is expected (at byte 3)"),
        ("1 + *", "expected a number, a name or `(` before `*` (at byte 4)"),
        ("(1 + 2", "expected `)` to close the parenthesis (at byte 6)"),
        ("1 + 2)", "`)` without `(` (at byte 5)"),
        ("1, 2", "`,` outside of a function's arguments (at byte 1)"),
        ("sin(1, 2)", "`sin` takes 1 argument, not 2 (at byte 0)"),
        ("sin()", "`sin` takes 1 argument, not 0 (at byte 0)"),
        ("ramp(t)", "`ramp` takes 2 arguments, not 1 (at byte 0)"),
        ("max(1)", "`max` takes 2 or more arguments, not 1 (at byte 0)"),
        ("if(x, y)", "`if` takes 3 arguments (condition, then, else), not 2 (at byte 0)"),
        ("sin(1", "expected `)` to close `sin(` (at byte 5)"),
        ("1 < 2 < 3", "comparisons cannot be chained (at byte 6)"),
        ("1 # 2", "unexpected character `#` (at byte 2)"),
        ("1 − 2", "unexpected character `−` (at byte 2)"),
        (".", "`.` is not a number (at byte 0)"),
    ] {
        assert_eq!(wrong(source), expected, "{source}");
    }
}

#[test]
fn size_is_bounded() {
    assert!(wrong(&"(".repeat(1000)).contains("nested more than 64 deep"));
    assert!(wrong(&"-".repeat(4000)).contains("nested more than 64 deep"));
    assert!(wrong(&"x+".repeat(5000)).contains("longer than 4096 bytes"));
    assert!(wrong(&format!("{}x{}", "max(x,".repeat(40), ")".repeat(40))).contains("more than 32 numbers"));
    assert!((value(&format!("0{}", "+x".repeat(2000))) - 600.0).abs() < 1e-9);
    // Depth is counted by nesting, not by length.
    assert!((value(&vec!["(x)"; 500].join("+")) - 150.0).abs() < 1e-9);
}

/// Branches that a constant condition leaves out are not looked at, let alone twice in every level.
#[test]
fn nested_conditions_compile_in_linear_time() {
    for (left, right) in [("if(1,", ",0)"), ("if(0,7,", ")"), ("if(", ",x,7)")] {
        let source = format!("{}x{}", left.repeat(60), right.repeat(60));
        assert_eq!(value(&source), 0.3, "{source}");
        if left.ends_with(',') {
            assert_eq!(Expression::parse(&source).unwrap(), Expression::parse("x").unwrap());
        }
    }
    let begun = std::time::Instant::now();
    for condition in ["1", "0", "x"] {
        let source = format!("{}y{}", format!("if({condition},").repeat(30), ",y)".repeat(30));
        let expression = Expression::parse(&source).unwrap();
        assert_eq!(expression.eval_with_gradient(&[0.3, 0.2, 0.0], 0.0), (0.2, [0.0, 1.0, 0.0]));
    }
    assert!(begun.elapsed().as_secs() < 10);
}

#[test]
fn dependence_is_known() {
    let parse = |s: &str| Expression::parse(s).unwrap();
    assert_eq!(parse("2*pi/2").constant_value(), Some(std::f64::consts::PI));
    assert!(!parse("x").is_constant() && parse("x").depends_on_space() && !parse("x").depends_on_time());
    assert!(parse("t").depends_on_time() && !parse("t").depends_on_space());
    assert!(parse("if(0, t, 3)").is_constant());
    assert_eq!(parse("1/2"), Expression::constant(0.5));
    assert_eq!(parse(" x + 1 ").source(), "x + 1");
    assert_eq!(Expression::constant(1e-3).source(), "0.001");
}

#[test]
fn serialises_as_number_or_source() {
    let json = |e: &Expression| serde_json::to_string(e).unwrap();
    assert_eq!(json(&Expression::constant(2.0)), "2.0");
    assert_eq!(json(&Expression::parse("2.5").unwrap()), "2.5");
    assert_eq!(json(&Expression::parse("2*y").unwrap()), "\"2*y\"");
}

/// Partial derivatives are the limits of central differences, for every function.
#[test]
fn gradients_are_those_of_differences() {
    for source in [
        "x*y - y/x + z - 2",
        "sin(x*y) + cos(x - y) * tan(y)",
        "asin(x) + acos(y) + atan(x*y)",
        "sinh(x) - cosh(y) * tanh(x*y)",
        "exp(-x) * ln(y) + log10(x*y) + sqrt(x + y)",
        "abs(x - 1) + sign(x) + floor(x) + ceil(y) + step(y)",
        "x^2 + y^3 + (x - 1)^3 + x^y + 2^x + pow(y, -1)",
        "atan2(x, y) + hypot(x, 2*y) + min(x, y) - max(x*x, y)",
        "ramp(x, 1) + ramp(t, 2) * x + ramp(y, x) + ramp(x, 0.1)",
        "if(x < y, x*x, y*y) + clamp(x, 0, 1) + (x > 0.1) * y",
    ] {
        let expression = Expression::parse(source).unwrap();
        for (x, y) in [(0.3, 0.2), (0.2, 0.7)] {
            let (value, gradient) = expression.eval_with_gradient(&[x, y, 7.0], 1.5);
            assert_eq!(value, expression.eval(&[x, y, 7.0], 1.5), "{source}");
            for d in 0..3 {
                let moved = |h: f64| {
                    let mut at = [x, y, 7.0];
                    at[d] += h;
                    expression.eval(&at, 1.5)
                };
                let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!(
                    (gradient[d] - difference).abs() < 1e-8 * (1.0 + difference.abs()),
                    "{source} at {x}, {y}: {} is not {difference}",
                    gradient[d]
                );
            }
        }
    }
}
