//! What other programs call the keys of a case.

/// Table, the key here, and its other names.
const SYNONYMS: &[(&str, &str, &[&str])] = &[
    ("", "mesh", &["geometry", "domain", "grid"]),
    ("", "fluid", &["flow", "liquid", "fluid-properties"]),
    ("", "solid", &["structure", "solid-properties", "body", "material"]),
    ("", "boundary", &["boundaries", "boundary-conditions", "bc", "bcs"]),
    ("", "functional", &["functionals", "quantities", "probes"]),
    ("", "newton", &["solver", "nonlinear"]),
    ("mesh", "file", &["filename", "file-name", "path", "mesh-file", "msh"]),
    (
        "mesh",
        "refine",
        &["refinement", "refinements", "levels", "level", "refine-level", "global-refinements"],
    ),
    ("mesh", "scale", &["unit", "units", "scaling", "factor", "scale-factor", "length-scale"]),
    ("mesh", "generator", &["type", "kind"]),
    ("space", "velocity", &["element", "elements", "velocity-element", "velocity-space", "order", "degree"]),
    ("space", "pressure", &["pressure-element", "pressure-space"]),
    ("fluid", "density", &["rho", "rho-f", "mass-density", "fluid-density"]),
    ("fluid", "kinematic-viscosity", &["nu", "nu-f", "kinematic", "viscosity-kinematic"]),
    (
        "fluid",
        "kinematic-viscosity",
        &["viscosity", "dynamic-viscosity", "mu", "mu-f", "eta", "viscosity-dynamic"],
    ),
    ("fluid", "body-force", &["gravity", "force", "g", "acceleration", "volume-force"]),
    ("solid", "density", &["rho", "rho-s", "mass-density", "solid-density"]),
    (
        "solid",
        "young",
        &["e", "youngs-modulus", "young-modulus", "youngs", "elastic-modulus", "elasticity", "e-modulus"],
    ),
    ("solid", "young", &["modulus-of-elasticity", "modulus"]),
    ("solid", "poisson", &["nu", "nu-s", "poisson-ratio", "poissons-ratio", "poissons"]),
    ("solid", "mu", &["shear-modulus", "mu-s", "lame-mu", "shear", "g"]),
    ("solid", "lambda", &["lame-lambda", "lambda-s", "first-lame", "lame"]),
    ("solid", "bulk", &["bulk-modulus", "kappa", "k"]),
    ("solid", "law", &["material", "model", "material-law", "constitutive-law", "type"]),
    ("solid", "body-force", &["gravity", "force", "acceleration", "volume-force"]),
    ("motion", "model", &["type", "method", "extension"]),
    ("boundary", "condition", &["type", "kind", "bc"]),
    ("boundary", "velocity", &["value", "values", "v", "u"]),
    ("time", "step", &["dt", "time-step", "timestep", "delta-t", "step-size", "k"]),
    ("time", "end", &["t-end", "end-time", "final-time", "t-final", "tmax", "t-max", "final", "stop"]),
    ("time", "start", &["t-start", "start-time", "t0", "begin", "initial-time"]),
    ("time", "scheme", &["method", "integrator", "time-scheme", "integration"]),
    ("newton", "tolerance", &["tol", "rtol", "relative-tolerance"]),
    ("newton", "floor", &["atol", "absolute-tolerance"]),
    ("newton", "max-steps", &["max-iterations", "max-iter", "maxiter", "iterations"]),
    ("functional", "kind", &["type", "quantity"]),
    ("functional", "on", &["boundary", "boundaries", "where"]),
    ("functional", "component", &["direction", "axis"]),
    ("functional", "point", &["at", "position", "location", "x"]),
    ("functional", "take", &["operation", "reduction", "statistic"]),
    ("functional", "region", &["body", "domain", "in"]),
    ("output", "fields-every", &["every", "interval", "write-every", "frequency"]),
    ("output", "fields-times", &["times", "at-times", "write-times"]),
    ("output", "fields", &["variables", "arrays", "quantities"]),
    ("output", "window", &["average", "averages", "means", "averaging-window"]),
    ("output", "checkpoint-every", &["checkpoint", "checkpoints", "checkpoint-interval"]),
];

/// The key that `word` means in the table `path`, if it is the name that other programs have for it.
pub(super) fn meant(path: &str, word: &str) -> Option<&'static str> {
    let table = path.split('.').next().unwrap_or(path);
    let letter = |c: char| if c == '_' || c == ' ' { '-' } else { c.to_ascii_lowercase() };
    let word: String = word.chars().filter(|c| *c != '\'').map(letter).collect();
    let found = SYNONYMS.iter().find(|(t, _, names)| *t == table && names.contains(&word.as_str()));
    found.map(|(_, key, _)| *key)
}
