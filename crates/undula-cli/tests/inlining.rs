//! That vector instructions are instructions.
//!
//! The build is for the baseline processor; wider vectors live below entry functions compiled for them, and
//! everything there must be inlined. What is not, such as a closure that is called twice, is compiled for the
//! baseline, and each of its vector instructions becomes a call: right, but several times slower (closures in the
//! stress and in the time difference once cost a step of `fsi3` 14 %).
#![cfg(all(target_arch = "x86_64", target_os = "linux"))]

use object::{Object, ObjectSymbol};

/// Arithmetic of the kernels; numbers are loaded and broadcast in set-up code, too.
const ARITHMETIC: [&str; 5] = ["mul_pd", "add_pd", "sub_pd", "div_pd", "fmadd_pd"];

#[test]
fn no_vector_instruction_is_a_call() {
    let binary = std::fs::read(env!("CARGO_BIN_EXE_undula")).unwrap();
    let file = object::File::parse(&*binary).unwrap();
    let is_vector = |name: &&str| {
        let of = |width: &str| ARITHMETIC.iter().any(|a| name.contains(&format!("{width}{a}")));
        name.contains("core_arch") && (of("_mm256_") || of("_mm512_"))
    };
    assert!(file.symbols().count() > 1000, "no symbols to look at");
    let calls: Vec<&str> = file.symbols().filter_map(|s| s.name().ok()).filter(is_vector).collect();
    assert!(calls.is_empty(), "called, not inlined; `objdump -d` tells by what: {calls:#?}");
}
