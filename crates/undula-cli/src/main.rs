//! The `undula` command.

mod memory;

#[global_allocator]
static MEMORY: memory::Told = memory::Told;

fn main() -> std::process::ExitCode {
    let code = undula_cli::command(std::env::args_os());
    undula::algebra::petsc::finish();
    code
}
