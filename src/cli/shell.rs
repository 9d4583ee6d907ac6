//! `willis completions` and `willis man`.

use std::io::Write;

use clap::{Args, CommandFactory};
use willis::error::{Error, Result};

use super::Cli;

/// Print shell completions
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell
    shell: clap_complete::Shell,
}

/// Prints and takes a closed pipe for what it is.
fn print(text: &[u8]) -> Result<()> {
    match std::io::stdout().write_all(text) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Write { path: "standard output".into(), source: e }),
        _ => Ok(()),
    }
}

impl CompletionsArgs {
    pub fn run(self) -> Result<()> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "willis", &mut text);
        print(&text)
    }
}

/// `willis man`.
pub fn man() -> Result<()> {
    let mut text = Vec::new();
    let mut command = Cli::command();
    command.build();
    // The overview, then a page for each subcommand.
    for page in std::iter::once(&command).chain(command.get_subcommands()) {
        let page = clap_mangen::Man::new(page.clone());
        page.render(&mut text).map_err(|source| Error::Write { path: "standard output".into(), source })?;
    }
    print(&text)
}

/// Prints a line of data on standard output.
pub fn print_line(text: &str) -> Result<()> {
    print(format!("{text}\n").as_bytes())
}
