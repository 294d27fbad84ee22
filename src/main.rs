//! The `modiolus` program: exit code 0 solved, 1 not solved, 2 bad input.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
