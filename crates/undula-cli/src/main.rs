//! The `undula` command.
fn main() {}
