//! A network written as a file of any format.

use std::{fs::File, io, io::BufWriter, path::Path, path::PathBuf};

use crate::{Error, Network, Result};
use willis_io::formats::convert::{Target, losses, refusal, write_into};
use willis_io::formats::{Written, write_loops, write_openbf_inlet};
use willis_io::output::StagedFiles;

/// What came of writing a network.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WrittenFiles {
    /// The files.
    pub files: Vec<PathBuf>,
    /// What a person should know.
    pub notes: Vec<String>,
    /// What the format cannot hold.
    pub lost: Vec<String>,
    /// How many nodes and vessels were written.
    pub counts: [usize; 2],
}

/// Writes a network as `willis convert` does: its ending says the format, unless the word `to` does. Files that are there are replaced
/// with `force`.
///
/// # Errors
///
/// An ending or a word that means no format, a network that no file or not this format can hold, a file that stands already or cannot be written.
pub fn write(network: &Network, path: &Path, to: Option<&str>, force: bool) -> Result<WrittenFiles> {
    write_target(network, &Target::new(path, to)?, force)
}

/// As [`write()`], to a target.
///
/// # Errors
///
/// As [`write()`].
pub fn write_target(network: &Network, target: &Target, force: bool) -> Result<WrittenFiles> {
    network.validate()?;
    StagedFiles::check(&target.path, &target.nodes, force)?;
    let mut staged = StagedFiles::new(&target.path, force)?;
    let written = stage_target(network, target, &mut staged)?;
    Ok(WrittenFiles { files: staged.commit()?, ..written })
}

/// Writes the files of a target into a set of which it is the main file, beside others; no file is in its place yet.
///
/// # Errors
///
/// As [`write()`].
pub fn stage_target(network: &Network, target: &Target, staged: &mut StagedFiles) -> Result<WrittenFiles> {
    let (network, mut notes) = target.network(network)?;
    let network = &*network;
    let lost = losses(network, target);
    let nodes = target.nodes.as_ref().map(|path| staged.add(path)).transpose()?;
    let mut written = Written::default();
    let made = staged.write_main(|out| {
        let Some(nodes) = &nodes else {
            written = write_into(network, target, out, io::sink())?;
            return Ok(());
        };
        let mut table = BufWriter::new(File::create_new(nodes)?);
        written = write_into(network, target, out, &mut table)?;
        table.into_inner()?.sync_all()
    });
    made.map_err(|error| match error {
        Error::Write { source, .. } if source.kind() == io::ErrorKind::InvalidInput => refusal(target, &source),
        other => other,
    })?;
    if !written.loops.is_empty() {
        staged.write(&target.loops(), |out| write_loops(out, &written.loops))?;
    }
    for (number, id) in written.inlets.iter().enumerate() {
        if let Some(wave) = target.setting.courses.get(id) {
            staged
                .write(&target.path.with_file_name(format!("inlet-{}.dat", number + 1)), |out| write_openbf_inlet(out, wave))?;
        }
    }
    notes.append(&mut written.notes);
    Ok(WrittenFiles { files: Vec::new(), notes, lost, counts: [network.node_count(), network.vessel_count()] })
}
