//! The subcommands that need no solver, called as functions.

use crate::args::{CaseArgs, Cli, Command};
use crate::{cases, check, compare, new};
use clap::{CommandFactory, Parser};
use std::process::ExitCode;
use undula::case::Case;

fn parse(line: &str) -> Result<Command, String> {
    match Cli::try_parse_from(line.split_whitespace()) {
        Ok(cli) => Ok(cli.command),
        Err(e) => Err(e.to_string()),
    }
}

/// Runs a command line and gives its exit code.
fn exit(line: &str) -> ExitCode {
    match parse(line).unwrap() {
        Command::Check(args) => check::run(&args),
        Command::Cases => cases::run(),
        Command::New(args) => new::run(&args),
        Command::Compare(args) => compare::run(&args),
        other => panic!("{other:?} needs the solver"),
    }
    .unwrap()
}

fn bad() -> ExitCode {
    ExitCode::from(2)
}

#[test]
fn the_command_line_is_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn run_takes_everything_at_once() {
    let line =
        "undula run fsi3 -o out/x --set time.step=0.01 --set mesh.refine=2 --threads 4 --resume --quiet";
    let Command::Run(args) = parse(line).unwrap() else { panic!() };
    assert_eq!(args.case.case, "fsi3");
    assert_eq!(args.case.set, ["time.step=0.01", "mesh.refine=2"]);
    assert_eq!(args.output.unwrap().to_str(), Some("out/x"));
    assert_eq!((args.threads, args.resume, args.quiet, args.force), (Some(4), true, true, false));
    let Command::Run(args) = parse("undula run --set a=1 own.toml --set b=2 --force").unwrap() else {
        panic!()
    };
    assert_eq!((args.case.case.as_str(), args.case.set.len(), args.force), ("own.toml", 2, true));
    assert!(parse("undula run fsi3 --threads 0").is_err());
    assert!(parse("undula run fsi3 --resume --force").is_err());
    assert!(parse("undula run").is_err());
    // A value may start with a minus sign or hold blanks, as it is part of the same word as the key.
    let Command::Run(args) = parse("undula run csm1 --set solid.body-force=[0,-2]").unwrap() else {
        panic!()
    };
    assert_eq!(args.case.set, ["solid.body-force=[0,-2]"]);
}

#[test]
fn check_tells_good_from_bad() {
    assert_eq!(exit("undula check fsi3"), ExitCode::SUCCESS);
    assert_eq!(exit("undula check fsi3 --toml"), ExitCode::SUCCESS);
    assert_eq!(exit("undula check fsi3 --set fluid.density=-1 --set time.scheme=cn"), bad());
    assert_eq!(exit("undula check fsi33"), bad());
    // A directory is there, but cannot be read: this is not the user's input.
    let args = CaseArgs { case: "src".into(), set: vec![] };
    assert!(check::load(&args).is_err());
}

#[test]
fn the_summary_is_in_physical_terms() {
    let told = check::summary(&Case::builtin("fsi3", &[]).unwrap(), None).unwrap();
    let expected = "\
fsi3: Turek-Hron FSI3: oscillations of a light beam, Re 200

mesh      channel with cylinder and beam (turek-hron), refine 1, grading 0
space     Q2/P1dc
fluid     density 1000 kg/m³, viscosity 0.001 m²/s (1.000e0 Pa s)
          inflow: v = (1.5*2.0*y*(0.41-y)/(0.41/2)^2*ramp(t,2), 0) m/s
solid     density 1000 kg/m³, st-venant-kirchhoff
          mu 2.0000e6 Pa, lambda 8.0000e6 Pa (Young 5.6000e6 Pa, Poisson 0.4000)
          waves 44.7214 m/s (shear), 109.5445 m/s (pressure)
          density ratio solid/fluid 1.000
time      0 to 10 s, step 0.005 s, 2000 steps, theta 0.51
output    drag, lift, ux_A, uy_A
";
    assert_eq!(told, expected, "\n{told}");
    let told = check::summary(&Case::builtin("fsi3", &["solid=none".into()]).unwrap(), None).unwrap();
    assert!(told.contains("note      functional.ux_A is left out: there is no [solid]\n"), "{told}");
}

#[test]
fn new_writes_a_case_once() {
    let dir = std::env::temp_dir().join(format!("undula-new-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let file = dir.join("own.toml");
    let line = format!("undula new fsi3 {}", file.display());
    assert_eq!(exit(&line), ExitCode::SUCCESS);
    assert_eq!(exit(&line), bad());
    assert_eq!(exit(&format!("{line} --force")), ExitCode::SUCCESS);
    assert_eq!(exit(&format!("undula check {}", file.display())), ExitCode::SUCCESS);
    assert_eq!(exit("undula new fsi33"), bad());
    assert_eq!(exit("undula cases"), ExitCode::SUCCESS);
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn compare_reads_output_directories() {
    let dir = std::env::temp_dir().join(format!("undula-compare-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let shown = dir.display();
    assert_eq!(exit(&format!("undula compare {shown}")), bad());
    let summary = r#"{"status": "completed", "case": "CASE", "functionals":
        {"drag": {"last": 14.3, "mean": null, "amplitude": null, "frequency": null, "unit": "N/m"}}}"#;
    std::fs::write(dir.join("summary.json"), summary.replace("CASE", "fsi1")).unwrap();
    let case = |overrides: &[String]| {
        let case = Case::builtin("fsi1", overrides).unwrap().to_toml();
        std::fs::write(dir.join("case.toml"), case).unwrap();
    };
    assert_eq!(exit(&format!("undula compare {shown}")), bad(), "the name alone makes no reference");
    case(&["mesh.refine=0".into()]);
    assert_eq!(exit(&format!("undula compare {shown}")), ExitCode::SUCCESS);
    case(&["fluid.density=900".into()]);
    assert_eq!(exit(&format!("undula compare {shown}")), bad(), "another problem");
    assert_eq!(exit(&format!("undula compare {shown} {shown}")), ExitCode::SUCCESS);
    std::fs::write(dir.join("summary.json"), summary.replace("CASE", "own")).unwrap();
    case(&["reference=none".into()]);
    assert_eq!(exit(&format!("undula compare {shown}")), bad());
    std::fs::write(
        dir.join("own.reference.toml"),
        "case = \"own\"\n[reference.drag]\nvalue = 14\nsource = \"me\"\n",
    )
    .unwrap();
    assert_eq!(
        exit(&format!("undula compare {shown} --reference {shown}/own.reference.toml")),
        ExitCode::SUCCESS
    );
    std::fs::write(dir.join("summary.json"), "{").unwrap();
    assert_eq!(exit(&format!("undula compare {shown}")), bad());
    std::fs::remove_dir_all(&dir).unwrap();
}
