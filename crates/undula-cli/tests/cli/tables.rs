//! Tables of values and units through the program.

use super::*;

/// A channel in the units of blood flow, with an inflow from a table.
const CASE: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = ["30 mm", "1 cm"]
cells = [3, 2]
[fluid]
density = "1.06 g/cm^3"
kinematic-viscosity = "3.3 mm^2/s"
[boundary.left]
condition = "velocity"
velocity = ['40000 [1/m^2]*y*(1 [cm] - y)*1 [mm/s]*table("data/pulse.csv", t, "cubic periodic")', 0]
[boundary.right]
condition = "traction"
traction = ["-80 mmHg", 0]
[boundary.bottom]
condition = "no-slip"
[boundary.top]
condition = "no-slip"
[time]
step = "10 ms"
end = "0.1 s"
[functional.p]
kind = "pressure-difference"
a = [0, "5 mm"]
b = ["3 cm", 0.005]
"#;

const PULSE: &str = "t [s],v [mm/s]\n0,0\n0.02,1\n0.05,3\n0.08,1\n0.1,0\n";

#[test]
#[ignore = "long"]
fn a_run_keeps_its_table_and_is_in_si_units() {
    let here = Place::new("tables");
    here.write("own.toml", CASE);
    here.write("data/pulse.csv", PULSE);
    here.run("check own.toml", &[]).expect(0, &[]);
    here.run("run own.toml -o out", &["time.end=50 ms"]).expect(0, &[]);
    let written = here.read("out/case.toml");
    for line in [
        "upper = [0.03, 0.01]",
        "density = 1060.0",
        "kinematic-viscosity = 3.3e-6",
        "40000.0*y*(0.01 - y)*0.001*table(\"../data/pulse.csv\", t, \"cubic periodic\")",
        "traction = [-10665.7909932, 0.0]",
        "step = 0.01",
        "end = 0.05",
    ] {
        assert!(written.contains(line), "{line} is not in\n{written}");
    }
    let hashes = here.json("out/summary.json")["table_hashes"].clone();
    let (file, hash) = hashes.as_object().unwrap().iter().next().unwrap();
    assert!(file.ends_with("data/pulse.csv") && hash.as_str().unwrap().len() == 32, "{hashes}");
    // The same case in SI units, its table too, computes the same bits.
    here.write("si.toml", &written.replace("../data", "data"));
    here.run("run si.toml -o si", &[]).expect(0, &[]);
    assert_eq!(here.read("out/history.csv"), here.read("si/history.csv"));
    // A run goes on with its table wherever that is, and not with another one.
    let longer = "time.end=0.1";
    here.run("run own.toml -o out --resume", &[longer]).expect(0, &[]);
    here.run("run own.toml -o whole", &[]).expect(0, &[]);
    assert_eq!(here.read("out/history.csv"), here.read("whole/history.csv"));
    here.write("data/pulse.csv", &PULSE.replace("0.05,3", "0.05,4"));
    here.run("run own.toml -o out --resume", &["time.end=0.2"])
        .expect(2, &["boundary.left.velocity: the content of the file pulse.csv is another", "--force"]);
    here.write("moved/data/pulse.csv", PULSE);
    here.write("moved/own.toml", CASE);
    here.run("run moved/own.toml -o out --resume", &["time.end=0.12"]).expect(0, &[]);
    // Results are read without it.
    fs::remove_dir_all(here.file("data")).unwrap();
    here.run("compare out whole", &[]).expect(0, &["p"]);
}

#[test]
fn mistakes_in_tables_and_units_are_told() {
    let here = Place::new("wrong-tables");
    here.write("own.toml", CASE);
    here.run("check own.toml", &[])
        .expect(2, &["own.toml:12:", "boundary.left.velocity[0]", "pulse.csv: No such"]);
    here.write("data/pulse.csv", &PULSE.replace("0.05,3", "0.02,3"));
    here.run("check own.toml", &[])
        .expect(2, &["own.toml:12:", "data/pulse.csv:4: the argument 0.02 is not above"]);
    here.write("data/pulse.csv", &PULSE.replace("0.1,0", "0.1,0.5"));
    here.run("check own.toml", &[])
        .expect(2, &["data/pulse.csv:6: the last value, 0.5, is not the first one, 0"]);
    here.write("data/pulse.csv", PULSE);
    let velocity = "boundary.left.velocity=[\"y*(0.01 - y)*table('data/pulse.csv', t)\", 0]";
    here.run("check own.toml", &[velocity]).expect(0, &[]);
    let told = ["boundary.left.velocity", "pulse.csv has arguments from 0 to 0.1, `t` is 0.10196"];
    here.run("check own.toml", &[velocity, "time.end=0.2"]).expect(2, &told);
    here.run("run own.toml -o out", &[velocity, "time.end=0.2"]).expect(2, &told);
    assert!(!here.file("out").exists());
    for (set, words) in [
        (
            "boundary.right.traction=[\"1 mm\", 0]",
            "this is a length [m]; expected a pressure [N/m²], such as \"120 mmHg\"",
        ),
        ("boundary.right.traction=[\"1 mmhg\", 0]", "unknown unit `mmhg`; did you mean `mmHg`?"),
        ("fluid.density=1 kg/l m", "has two meanings"),
        ("time.end=1 m", "expected a time [s], such as \"1 ms\""),
    ] {
        here.run("check own.toml", &[set]).expect(2, &[words, "--set"]);
    }
}
