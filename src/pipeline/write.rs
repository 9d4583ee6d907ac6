//! A network written as a file of any format.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use willis_core::error::{Error, Result};
use willis_core::network::Network;
use willis_io::formats::convert::{Target, Written, losses, refusal, write_into};
use willis_io::formats::write_loops;
use willis_io::output::StagedFile;
use willis_io::output::atomic::write_file;

/// What came of writing a network.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WrittenFiles {
    /// The files.
    pub files: Vec<PathBuf>,
    /// What a person should know.
    pub notes: Vec<String>,
    /// What the format cannot hold.
    pub lost: Vec<String>,
}

/// Writes a network as `willis convert` does: its ending says the format, unless the word `to` does. Files that are there are replaced
/// with `force`.
///
/// # Errors
///
/// An ending or a word that means no format, a network that the format cannot hold, a file that stands already or cannot be written.
pub fn write(network: &Network, path: &Path, to: Option<&str>, force: bool) -> Result<WrittenFiles> {
    let target = Target::new(path, to)?;
    [&target.path].into_iter().chain(&target.nodes).try_for_each(|path| StagedFile::check(path, force))?;
    write_target(network, &target, force)
}

/// As [`write()`], to a target that was checked.
///
/// # Errors
///
/// As [`write()`].
pub fn write_target(network: &Network, target: &Target, force: bool) -> Result<WrittenFiles> {
    let lost = losses(network, target.format);
    let file = StagedFile::new(&target.path, force)?;
    let nodes = target.nodes.as_ref().map(|path| StagedFile::new(path, force)).transpose()?;
    let mut written = Written::default();
    let made = write_file(&file.path(), |out| {
        let Some(nodes) = &nodes else {
            written = write_into(network, target, out, io::sink())?;
            return Ok(());
        };
        let mut table = BufWriter::new(File::create_new(nodes.path())?);
        written = write_into(network, target, out, &mut table)?;
        table.into_inner()?.sync_all()
    });
    made.map_err(|error| match error {
        Error::Write { source, .. } if source.kind() == io::ErrorKind::InvalidInput => refusal(target, &source),
        other => other,
    })?;
    let mut staged = vec![(target.path.clone(), file)];
    staged.extend(target.nodes.clone().zip(nodes));
    if !written.loops.is_empty() {
        let file = StagedFile::new(&target.loops(), force)?;
        write_file(&file.path(), |out| write_loops(out, &written.loops))?;
        staged.push((target.loops(), file));
    }
    let mut files = Vec::new();
    for (path, file) in staged {
        file.commit()?;
        files.push(path);
    }
    Ok(WrittenFiles { files, notes: written.notes, lost })
}
