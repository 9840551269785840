//! The `undula` command.

fn main() -> std::process::ExitCode {
    undula_cli::command(std::env::args_os())
}
