//! The `willis` command: parse, set the threads, dispatch, and print the error chain.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let cli = cli::Cli::parse();
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("willis: {error}");
            ExitCode::from(if error.is_usage() { 2 } else { 1 })
        }
    }
}
