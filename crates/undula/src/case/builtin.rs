//! The cases shipped with the program, and how a case is found by name.

use super::error::{CaseError, CaseErrors, LoadError, Place, did_you_mean, quoted};
use super::schema::Case;
use std::path::Path;

/// A case shipped with the program.
#[derive(Copy, Clone, Debug)]
pub struct BuiltinCase {
    /// Name on the command line.
    pub name: &'static str,
    /// The case file.
    pub toml: &'static str,
    /// Its published results.
    pub reference: &'static str,
}

macro_rules! cases {
    ($($name:literal),* $(,)?) => {
        &[$(BuiltinCase {
            name: $name,
            toml: include_str!(concat!("../../cases/", $name, ".toml")),
            reference: include_str!(concat!("../../cases/", $name, ".reference.toml")),
        }),*]
    };
}

static CASES: &[BuiltinCase] = cases![
    "cfd1", "cfd2", "cfd3", "csm1", "csm2", "csm3", "fsi1", "fsi2", "fsi3", "dfg-2d1", "dfg-2d2", "dfg-2d3",
    "rotor", "flap", "cavity", "tube-2d", "cylinder", "pump", "valve", "dfg-3d1z", "dfg-3d3z", "cook",
    "fsi-box", "tube", "land",
];

/// All built-in cases.
pub fn builtin_cases() -> &'static [BuiltinCase] {
    CASES
}

/// The built-in case `name`.
pub fn builtin_case(name: &str) -> Option<&'static BuiltinCase> {
    CASES.iter().find(|case| case.name == name)
}

impl Case {
    /// The built-in case `name` with `overrides`; its messages call the file `NAME.toml`.
    ///
    /// # Errors
    /// An unknown name, or mistakes in the overrides.
    pub fn builtin(name: &str, overrides: &[String]) -> Result<Self, LoadError> {
        let case = builtin_case(name).ok_or_else(|| no_such_case(name))?;
        Ok(Self::from_toml(case.toml, &format!("{name}.toml"), overrides)?)
    }

    /// The built-in case of that name, else the case file at that path.
    ///
    /// # Errors
    /// Neither exists, the file cannot be read, or it has mistakes.
    pub fn load(path_or_builtin: &str, overrides: &[String]) -> Result<Self, LoadError> {
        let (text, name) = text_and_name(path_or_builtin)?;
        Ok(Self::from_toml(&text, &name, overrides)?)
    }
}

/// The case file at a path.
///
/// # Errors
/// There is none, it cannot be read, or it is no text.
fn text_of(path_or_builtin: &str) -> Result<String, LoadError> {
    let path = Path::new(path_or_builtin);
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Err(no_such_case(path_or_builtin)),
        Err(source) => return Err(LoadError::Unreadable { path: path.into(), source }),
    };
    if let Some(what) = no_case(path, &bytes) {
        return Err(mistake(path_or_builtin, what).into());
    }
    Ok(String::from_utf8(bytes).map_err(|e| not_text(path_or_builtin, e.utf8_error().valid_up_to()))?)
}

/// Text and name of the built-in case of that name, else of the case file at that path.
///
/// # Errors
/// Neither exists, or the file cannot be read.
pub(crate) fn text_and_name(path_or_builtin: &str) -> Result<(String, String), LoadError> {
    match builtin_case(path_or_builtin) {
        Some(case) => Ok((case.toml.into(), format!("{path_or_builtin}.toml"))),
        None => Ok((text_of(path_or_builtin)?, path_or_builtin.into())),
    }
}

fn not_text(name: &str, position: usize) -> CaseErrors {
    mistake(name, format!("not a text file: byte {position} is not UTF-8"))
}

/// A mistake of the whole file.
fn mistake(name: &str, message: String) -> CaseErrors {
    let place = Place::File { name: name.into(), line: 1, column: 1 };
    CaseErrors(vec![CaseError { place, key: String::new(), value: None, message }])
}

/// Endings of files that programs for meshes and fields write.
const MESHES: [&str; 14] =
    ["msh", "msh2", "msh4", "mesh", "vtk", "vtu", "stl", "inp", "med", "unv", "cgns", "xdmf", "bdf", "su2"];

/// Endings of files that geometries are in.
const GEOMETRIES: [&str; 7] = ["geo", "geo_unrolled", "step", "stp", "brep", "iges", "igs"];

/// What to do with a file that is a mesh or a geometry; `None` if it may be a case.
fn no_case(path: &Path, bytes: &[u8]) -> Option<String> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let name = path.to_string_lossy();
    let line = format!("[mesh] with file = {:?}", path.file_name().unwrap_or_default().to_string_lossy());
    let gmsh = bytes.split(|b| *b == b'\n').take(100).any(|line| line.trim_ascii() == b"$MeshFormat");
    if gmsh || ending == "msh" {
        return Some(format!(
            "a mesh, not a case: write a case beside it, a TOML file that has {line} (`undula new fsi3 own.toml` makes \
             one to change), and take that"
        ));
    }
    let (mesh, geometry) = (MESHES.contains(&&*ending), GEOMETRIES.contains(&&*ending));
    (mesh || geometry).then(|| {
        let what = if mesh { "a mesh" } else { "a geometry" };
        format!(
            "{what}, not a case: make a Gmsh mesh of it (`gmsh -2 {name} -o own.msh`) and write a case, a TOML file \
             that has [mesh] with file = \"own.msh\""
        )
    })
}

fn no_such_case(name: &str) -> LoadError {
    let stem = name.strip_suffix(".toml").unwrap_or(name);
    let mut hint = did_you_mean(stem, CASES.iter().map(|case| case.name));
    if hint.is_empty() {
        hint = format!("; built-in cases are {}", quoted(CASES.iter().map(|case| case.name)));
    }
    LoadError::NoSuchCase { name: name.into(), hint }
}
