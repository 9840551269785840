//! Links the system's MUMPS where the feature of that name asks for it.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_MUMPS").is_some() {
        for library in ["dmumps_seq", "openblas"] {
            println!("cargo::rustc-link-lib=dylib={library}");
        }
    }
}
