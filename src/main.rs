//! The `willis` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(willis::cli::main(std::env::args_os()))
}
