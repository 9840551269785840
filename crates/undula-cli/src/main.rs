//! The `undula` command.

fn main() -> std::process::ExitCode {
    let code = undula_cli::command(std::env::args_os());
    undula::algebra::petsc::finish();
    code
}
