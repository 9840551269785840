//! Chooses the instruction sets that kernels are compiled for; links the system's MUMPS where the feature of that name
//! asks for it.

use std::env::{var, var_os};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if var_os("CARGO_FEATURE_MUMPS").is_some() {
        for library in ["dmumps_seq", "openblas"] {
            println!("cargo::rustc-link-lib=dylib={library}");
        }
    }
    let x86 = var("CARGO_CFG_TARGET_ARCH").is_ok_and(|arch| arch == "x86_64");
    let narrow = var_os("CARGO_FEATURE_NARROW").is_some();
    // Builds to be shipped have all; others, tests above all, only what is best on this machine, and what all have.
    let all = var("PROFILE").is_ok_and(|profile| profile == "release");
    let avx512 = x86 && has_avx512();
    // Lanes of assembly; architectures other than x86-64 have four without instructions of their own.
    choose("lanes_4", !narrow && (all || !avx512));
    choose("lanes_8", !narrow && x86 && (all || avx512));
    // The same in space, where builds that stay here have one width alone.
    let four = !x86 || has_avx2();
    choose("space_8", !narrow && x86 && (all || avx512));
    choose("space_4", !narrow && (all || (four && !avx512)));
    choose("space_1", narrow || all || !(four || avx512));
    // Vectors of the linear solver.
    choose("solver_avx2", all || !avx512);
    choose("solver_avx512", all || avx512);
}

fn choose(name: &str, there: bool) {
    println!("cargo::rustc-check-cfg=cfg({name})");
    if there {
        println!("cargo::rustc-cfg={name}");
    }
}

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx512() -> bool {
    false
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}
