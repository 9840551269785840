use super::*;

fn value(text: &str) -> f64 {
    match quantity(text) {
        Some(Ok((value, _))) => value,
        other => panic!("{text}: {other:?}"),
    }
}

fn wrong(text: &str) -> String {
    match quantity(text) {
        Some(Err(message)) => message,
        other => panic!("{text} should be refused: {other:?}"),
    }
}

fn dimension(text: &str) -> [i32; 4] {
    quantity(text).unwrap().unwrap().1.0
}

/// Bit for bit: what is a decimal number in SI units is the one that is written there.
#[test]
fn values_are_those_in_si_units_to_the_last_bit() {
    for (text, expected) in [
        ("1 mm", 1e-3),
        ("1.5 mm", 1.5e-3),
        ("0.3 mm", 0.3e-3),
        ("-2.7cm", -0.027),
        ("+7 µm", 7e-6),
        ("7 μm", 7e-6),
        ("7 um", 7e-6),
        ("120 mmHg", 15998.6864898),
        ("80 mmHg", 10665.7909932),
        ("10 cmH2O", 980.665),
        ("760 Torr", 101325.0),
        ("1.01325 bar", 101325.0),
        ("10 kPa", 1e4),
        ("1e-6 m^2/s", 1e-6),
        ("1 mm²/s", 1e-6),
        ("1 cSt", 1e-6),
        ("3.5 cP", 3.5e-3),
        ("1.06 g/cm^3", 1060.0),
        ("1.06 g/cm3", 1060.0),
        ("1.06 kg/l", 1060.0),
        ("90 km/h", 25.0),
        ("1.1 ms", 1.1e-3),
        ("0.1 h", 360.0),
        ("9.81 m/s^2", 9.81),
        ("9.81 m s^-2", 9.81),
        ("9.81 m·s⁻²", 9.81),
        ("50 Hz", 50.0),
        ("4 mPa s", 4e-3),
        ("4 mPa*s", 4e-3),
        ("2 kg/(m s^2)", 2.0),
        ("2 kg/m/s^2", 2.0),
        ("12.e3 N/mm²", 12e9),
        (".5 dyn/cm^2", 0.05),
        ("0.1234567890123456789012345 nm", 1.234_567_890_123_456_8e-10),
        ("5e-324 m", 5e-324),
    ] {
        assert_eq!(
            value(text).to_bits(),
            f64::to_bits(expected),
            "{text} = {:e}, not {expected:e}",
            value(text)
        );
    }
    // Every decimal with a prefix is the literal with its exponent.
    for n in 1..2000 {
        let literal: f64 = format!("{n}.{n}e-3").parse().unwrap();
        assert_eq!(value(&format!("{n}.{n} mm")).to_bits(), literal.to_bits(), "{n}");
    }
}

/// Quotients that no decimal is: the nearest number, which twice the precision confirms.
#[test]
fn quotients_are_rounded_once() {
    assert_eq!(value("5 l/min"), 5.0 / 60000.0);
    assert_eq!(value("3 m/min"), 0.05);
    assert_eq!(value("1 m/h"), 1.0 / 3600.0);
    for n in 1..500u64 {
        // n/60 of whole numbers is rounded correctly by the processor.
        assert_eq!(value(&format!("{n} m/min")), n as f64 / 60.0, "{n}");
        assert_eq!(value(&format!("{n} m/h")), n as f64 / 3600.0, "{n}");
    }
    assert!((value("180 deg") - std::f64::consts::PI).abs() < 1e-15);
    // π is rounded, and the product once more: within one unit in the last place.
    assert!((value("30 °") - std::f64::consts::FRAC_PI_6).abs() <= f64::EPSILON / 2.0);
}

#[test]
fn dimensions_follow_from_the_units() {
    assert_eq!(dimension("1 mmHg"), [-1, 1, -2, 0]);
    assert_eq!(dimension("1 N/m^2"), dimension("1 Pa"));
    assert_eq!(dimension("1 J/m³"), dimension("1 Pa"));
    assert_eq!(dimension("1 P"), dimension("1 Pa s"));
    assert_eq!(dimension("1 l/min"), [3, 0, -1, 0]);
    assert_eq!(dimension("1 kg (m/s)^2"), dimension("1 J"));
    assert_eq!(dimension("1 deg"), [0, 0, 0, 1]);
    assert_eq!(Dimension::of("N/m²"), Dimension::of("Pa"));
    assert_eq!(Dimension::of("1/s"), Some(Dimension([0, 0, -1, 0])));
}

/// Every unit of the table of keys is one.
#[test]
fn units_of_all_keys_are_known() {
    for key in crate::case::keys::KEYS.iter() {
        for unit in key.unit.split(", ") {
            assert!(Dimension::of(unit).is_some(), "{}: {unit}", key.key);
        }
    }
}

#[test]
fn units_that_are_none_are_told() {
    for (text, expected) in [
        ("120 mmhg", "unknown unit `mmhg`; did you mean `mmHg`?"),
        ("1 pascal", "unknown unit `pascal`; there are `m`, `s`"),
        ("1 mpa", "unknown unit `mpa`; did you mean one of `MPa`, `mPa`?"),
        ("1 mmHq", "did you mean `mmHg`?"),
        ("1 kg/m s", "`kg/m s` has two meanings: write `a/(b c)`"),
        ("1 kg/(m s", "a `(` without `)`"),
        ("1 m/", "expected a unit in `m/`"),
        ("1 m//s", "`//` is not expected"),
        ("1 m/2", "expected a unit in `m/2`"),
        ("1 m^0", "expected an exponent from 1 to 9"),
        ("1 m^x", "expected an exponent"),
        ("1 m^99", "expected an exponent"),
        ("1e308 km", "expected a finite value"),
        ("1 m/h^9", "too large"),
    ] {
        let message = wrong(text);
        assert!(message.contains(expected), "{text}: {message}");
    }
    for text in
        ["1", "m", "1/s", "2*x", "1 + 2", "1 2", "", "mm 1", "--1 m", "1 m, 2 m", "1 m + x", "1 m - 2"]
    {
        assert!(quantity(text).is_none(), "{text}");
    }
}

#[test]
fn other_dimensions_are_told_with_what_would_be_right() {
    let told = |text: &str, unit: &str| mismatch(quantity(text).unwrap().unwrap().1, unit);
    assert_eq!(told("1 mmHg", "Pa"), None);
    assert_eq!(
        told("1 mm", "N/m²").unwrap(),
        "this is a length [m]; expected a pressure [N/m²], such as \"120 mmHg\""
    );
    assert_eq!(told("1 m", "").unwrap(), "expected a pure number, without a unit; this is a length [m]");
    let flux = told("5 l/min", "m²/s").unwrap();
    assert!(flux.contains("in the plane a flux is an area per time; divide by the length behind"), "{flux}");
    assert!(told("1 N", "N/m").unwrap().contains("in the plane a force is one per length"));
    assert!(told("1 Pa s/m^3", "Pa s/m²").unwrap().contains("multiply by the length"));
    assert!(
        told("1 m^5", "kg s")
            .unwrap()
            .contains("this is a value in m^5; expected a value in kg s, such as \"1 kg s\"")
    );
}
