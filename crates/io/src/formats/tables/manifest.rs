//! The tables of a study: its manifest, with a row for each subject, its input and the options that are its own, and the participants of BIDS.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::reader::{TableReader, is_missing};
use crate::formats::ensure;
use willis_core::{error::Fault, support::suggestions::did_you_mean};

/// The options that a subject may have of its own, by the names of the command line, with `_` for `-`.
const OPTIONS: &str = "units spacing radius_array radius default_radius loops level radius_from cavities box landmarks labels bc inlet outlet \
                       flow outlets mask image";
/// Those that name a file.
const FILES: [&str; 5] = ["loops", "landmarks", "bc", "mask", "image"];
/// The columns that name a subject.
const NAMES: [&str; 3] = ["subject", "participant_id", "subject_id"];
const INPUT: &str = "input";

/// What else is said of a subject, by column; empty where that is missing.
pub type Covariates = Vec<(String, String)>;

/// A row of a manifest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ManifestRow {
    /// Its line, from 1.
    pub line: usize,
    /// What the subject is called, where the table says so.
    pub subject: Option<String>,
    /// Its input.
    pub input: PathBuf,
    /// Its own options, by name and value.
    pub options: Vec<(String, String)>,
    /// What else is said of it: all columns that are no options.
    pub covariates: Covariates,
}

/// Reads the rows of a manifest, one at least, from a table of comma-, semicolon- or tab-separated values; `None` for a table without
/// a column `input`.
///
/// Further columns are `subject` (or `participant_id`, as in the `participants.tsv` of BIDS) and options of the command line under their
/// names; others are covariates. Paths are relative to `folder`, that of the table, but for those that begin with `{}` or `{dir}`. An empty value, or `n/a`, is
/// none.
///
/// # Errors
///
/// A row without an input or with more columns than the header, a subject or an option that comes twice, a column whose name is nearly that
/// of an option, no row.
pub fn read_manifest(bytes: &[u8], folder: &Path) -> Result<Option<Vec<ManifestRow>>, Fault> {
    let mut rows = TableReader::ragged(bytes)?;
    let Some(input) = rows.find(&[INPUT]) else { return Ok(None) };
    let name = rows.find(&NAMES);
    let (mut options, mut covariates) = (Vec::new(), Vec::new());
    for (at, column) in rows.header.iter().enumerate().filter(|(at, _)| *at != input && Some(*at) != name) {
        let plain = column.trim_start_matches('-').to_lowercase().replace('-', "_");
        if let Some(option) = OPTIONS.split_whitespace().find(|option| *option == plain) {
            let found = || format!("column \"{column}\": {option} comes twice");
            let twice = || Fault::line(rows.header_line, found(), "expected every option once");
            ensure(options.iter().all(|(_, known)| *known != option), twice)?;
            options.push((at, option));
            continue;
        }
        let meant = did_you_mean(&plain, OPTIONS.split_whitespace().chain(NAMES));
        // Of two columns with names of subjects the second says something of them.
        if !meant.is_empty() && !NAMES.contains(&&*plain) {
            let accepted = format!("{meant}options of a subject are {}", OPTIONS.replace(' ', ", "));
            return Err(Fault::line(rows.header_line, format!("column \"{column}\""), accepted));
        }
        covariates.push((at, column.clone()));
    }
    let placed = |text: &str| if text.starts_with('{') { PathBuf::from(text) } else { folder.join(text) };
    let value = |text: &str| Some(text.trim().to_owned()).filter(|text| !is_missing(text));
    let (mut found, mut lines) = (Vec::new(), HashMap::new());
    while let Some(row) = rows.row()? {
        if row.texts().next().is_none() || row.text(0).starts_with('#') {
            continue;
        }
        if let Some((_, text)) = row.texts().find(|(at, _)| *at >= row.header.len()) {
            let accepted = "expected as many as in the header at most; values with a delimiter in them need quotes";
            return Err(Fault::line(row.line, format!("\"{text}\" in a further column"), accepted));
        }
        let Some(path) = value(row.text(input)) else {
            return Err(Fault::line(row.line, "no input", "expected the file of the subject in the column input"));
        };
        let subject = name.and_then(|column| value(row.text(column)));
        subject.as_ref().map_or(Ok(()), |subject| once(&mut lines, subject, row.line))?;
        let own = options.iter().filter_map(|(at, option)| {
            let text = value(row.text(*at))?;
            Some(((*option).to_owned(), if FILES.contains(option) { placed(&text).display().to_string() } else { text }))
        });
        let said = covariates.iter().map(|(at, column)| (column.clone(), value(row.text(*at)).unwrap_or_default()));
        let (options, covariates) = (own.collect(), said.collect());
        found.push(ManifestRow { line: row.line, subject, input: placed(&path), options, covariates });
    }
    ensure(!found.is_empty(), || Fault::file("no subject", "expected a row for every subject")).map(|()| Some(found))
}

/// Refuses a subject that stands on a line before.
fn once(lines: &mut HashMap<String, usize>, subject: &str, line: usize) -> Result<(), Fault> {
    let twice = |first| Fault::line(line, format!("subject \"{subject}\", as on line {first}"), "expected every subject once");
    lines.insert(subject.to_lowercase(), line).map_or(Ok(()), |first| Err(twice(first)))
}

/// Reads `participants.tsv` of BIDS, or a table like it with a column `subject`: what is said of each participant.
///
/// # Errors
///
/// A table without the column `participant_id` or `subject`, a row of another length, a participant that comes twice.
pub fn read_participants(bytes: &[u8]) -> Result<Vec<(String, Covariates)>, Fault> {
    let mut rows = TableReader::open(bytes)?;
    let id = rows.column(&[NAMES[1], NAMES[0], NAMES[2]], "the participant of each row")?;
    let columns: Vec<(usize, String)> = rows.header.iter().cloned().enumerate().filter(|(at, _)| *at != id).collect();
    let (mut found, mut lines) = (Vec::new(), HashMap::new());
    while let Some(row) = rows.row()? {
        let name = row.text(id);
        if !is_missing(name) {
            once(&mut lines, name.strip_prefix("sub-").unwrap_or(name), row.line)?;
        }
        let covariates = columns.iter().map(|(at, column)| (column.clone(), row.text(*at).to_owned()));
        found.push((name.to_owned(), covariates.collect()));
    }
    Ok(found)
}
