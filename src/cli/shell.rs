//! `willis completions` and `willis man`.

use std::{io::Write, path::PathBuf};

use super::print::{TextTerminal, plural};
use crate::{Error, Result, internals::output::StagedFiles, internals::support::printable::printable_json};

/// Print shell completions
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis completions bash > ~/.local/share/bash-completion/completions/willis")]
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
    pub fn run(self, mut parser: clap::Command) -> Result<()> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut parser, "willis", &mut text);
        print(&text)
    }
}

/// Print the manual pages, or write one a file
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis man -o ~/.local/share/man/man1")]
pub struct ManArgs {
    /// The folder to write willis.1, willis-infer.1 and so on into
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: Option<PathBuf>,
}

impl ManArgs {
    pub fn run(self, mut parser: clap::Command, terminal: TextTerminal, force: bool) -> Result<()> {
        parser.build();
        // The overview, then a page for each subcommand.
        let mut pages = Vec::new();
        for page in std::iter::once(&parser).chain(parser.get_subcommands().filter(|c| c.get_name() != "help")) {
            let name = page.get_display_name().unwrap_or(page.get_name()).to_owned();
            let mut text = Vec::new();
            let rendered = clap_mangen::Man::new(page.clone()).render(&mut text);
            rendered.map_err(|source| Error::Write { path: "manual page".into(), source })?;
            pages.push((format!("{name}.1"), text));
        }
        let Some(folder) = self.output else { return pages.iter().try_for_each(|(_, text)| print(text)) };
        // All are looked at before the first is written.
        let paths: Vec<PathBuf> = pages.iter().map(|(name, _)| folder.join(name)).collect();
        StagedFiles::check(&paths[0], &paths[1..], force)?;
        let mut staged = StagedFiles::new(&paths[0], force)?;
        staged.write_main(|out| out.write_all(&pages[0].1))?;
        for (path, (_, text)) in paths.iter().zip(&pages).skip(1) {
            staged.write(path, |out| out.write_all(text))?;
        }
        staged.commit()?;
        terminal.say("written", format!("{}: {}", folder.display(), plural(pages.len(), "page")));
        Ok(())
    }
}

/// Prints a record on standard output, in one line of JSON.
pub fn print_json(record: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string(record).map_err(|e| Error::Write { path: "standard output".into(), source: e.into() })?;
    print(format!("{}\n", printable_json(&text)).as_bytes())
}
