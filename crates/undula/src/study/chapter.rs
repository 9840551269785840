//! The studies of chapter 5, shipped with the program.

/// Names and files of the studies, in the order of the chapter.
pub fn chapter() -> &'static [(&'static str, &'static str)] {
    macro_rules! studies {
        ($($name:literal),*) => { &[$(($name, include_str!(concat!("../../studies/", $name, ".toml")))),*] };
    }
    studies![
        "dynamics",
        "spectrum",
        "variants",
        "stability",
        "damping",
        "linearization",
        "elements",
        "mesh-motion"
    ]
}
