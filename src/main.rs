//! The `willis` command: parse, set the threads, dispatch, and print the error chain.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match cli::Cli::read() {
        Ok(cli) => cli,
        Err(status) => return ExitCode::from(status),
    };
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let status = if error.is_usage() { 2 } else { 1 };
            cli::say_error(&error);
            ExitCode::from(status)
        }
    }
}
