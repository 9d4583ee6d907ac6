//! The inputs of a cohort: patterns are expanded, and every subject has a name for its folder.

use std::{collections::HashMap, collections::HashSet, fs, path::Component, path::Path, path::PathBuf};

use glob::Pattern;

use super::command_line::{LinePart, is_option, line_of, parts_at_work, row_parts, shared_parts, words_of};
use crate::internals::formats::{Covariates, Format, ManifestRow, bytes_of, is_there, read_manifest, read_participants};
use crate::internals::output::names::{ACCURACY, COHORT, COHORT_PAGE, COHORT_TABLE, RECORD};
use crate::{
    Error, Result, error::Fault, error::ensure, internals::output::StagedFolder, internals::output::is_cohort_file,
    internals::support::endings::stem,
};

/// The longest name of a folder, in characters.
pub const LONGEST: usize = 80;

/// One input of a cohort.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The name of its folder: unique without regard to case, of letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// Its path, as given or as a pattern found it.
    pub input: PathBuf,
    /// The command line for it alone.
    pub parts: Vec<LinePart>,
    /// The manifest with its row, where it has one.
    pub row: Option<(PathBuf, ManifestRow)>,
}

impl Subject {
    /// An error of its options, with their place.
    pub fn fault(&self, error: Error) -> Error {
        match (error, &self.row) {
            (Error::Parameter { name, value, accepted }, Some((path, row))) => {
                Fault::line(row.line, format!("{name} {value}").trim_end().to_owned(), accepted).in_file(path)
            }
            (other, _) => other,
        }
    }

    /// The command line that repeats its run, with an output that is called `again`.
    pub fn line(&self, again: &str) -> String {
        line_of(self.parts.clone(), again)
    }

    /// The words of the command for it alone, where it has options of its own.
    pub fn own_words(&self) -> Option<Vec<String>> {
        (!self.options().is_empty()).then(|| words_of(self.parts.clone()))
    }

    /// What else a manifest says of it.
    pub fn covariates(&self) -> &[(String, String)] {
        self.row.as_ref().map_or(&[], |(_, row)| &row.covariates)
    }

    /// Its own options, by name and value.
    fn options(&self) -> &[(String, String)] {
        self.row.as_ref().map_or(&[], |(_, row)| &row.options)
    }

    /// Its own options, as they would be typed.
    pub fn own(&self) -> Vec<String> {
        self.options().iter().map(|(name, value)| format!("--{}={value}", name.replace('_', "-"))).collect()
    }
}

/// What was given as input.
pub enum Inputs {
    /// One file.
    One(PathBuf),
    /// Several, or a pattern.
    Many(Vec<Subject>),
}

/// The files that the arguments mean, each once: a name with `*`, `?` or `[...]` that no file has is a pattern. Where runs are taken, the
/// folder of a cohort means its subjects.
///
/// # Errors
///
/// A pattern that nothing matches, or that is none; a folder that is no run of infer; a word that is an option without its dashes.
pub fn expand(given: &[PathBuf], takes_runs: bool) -> Result<Inputs> {
    let means_subjects = |path: &Path| takes_runs && is_there(&path.join(COHORT));
    let check = |path: &PathBuf| if means_subjects(path) { Ok(()) } else { check_folder(path).and_then(|()| check_word(path)) };
    given.iter().try_for_each(check)?;
    let meant: Vec<PathBuf> = given.iter().map(|path| if means_subjects(path) { path.join("*") } else { path.clone() }).collect();
    if let [path] = given
        && let Some(manifest) = manifest_in(path)?
    {
        return Ok(Inputs::Many(subjects_of(manifest, path, given)));
    }
    if let [input] = &*meant
        && !is_pattern(input)
    {
        return Ok(Inputs::One(input.clone()));
    }
    let mut known = HashSet::new();
    // `cohort/*` means the subjects of a cohort. What is no folder and cannot be read, such as a link to nothing, is a row that failed.
    let is_input = |path: &Path| !path.is_dir() && !is_cohort_file(path);
    // A shell that expands the pattern itself gives these too.
    let inputs: Vec<PathBuf> = meant.iter().filter(|path| !is_cohort_file(path)).cloned().collect();
    let found = paths(&inputs, "file", |path| is_input(path) || is_there(&path.join(RECORD)))?;
    let found: Vec<PathBuf> = found.into_iter().filter(|path| known.insert(path.clone())).collect();
    let shared = shared_parts(parts_at_work(), given);
    let subject = |(name, input): (String, PathBuf)| Subject { name, parts: row_parts(&shared, &input, &[]), input, row: None };
    Ok(Inputs::Many(named(&found).into_iter().zip(found).map(subject).collect()))
}

/// The manifest that a file is; `None` for a file that is none.
fn manifest_in(path: &Path) -> Result<Option<Vec<ManifestRow>>> {
    let is_table = path.extension().is_some_and(|e| ["csv", "tsv"].iter().any(|ending| e.eq_ignore_ascii_case(ending)));
    if !is_table || is_cohort_file(path) || !path.is_file() {
        return Ok(None);
    }
    let bytes = bytes_of(path)?;
    // A table that is no manifest is read again, and its faults are told then.
    match read_manifest(&bytes, path.parent().unwrap_or(Path::new(""))) {
        Ok(manifest) => Ok(manifest),
        Err(fault) if has_inputs(&bytes) => Err(fault.in_file(path)),
        Err(_) => Ok(None),
    }
}

/// Whether the first line of a table that is no comment names a column `input`.
fn has_inputs(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 16)]);
    let header = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or_default();
    header.split([',', ';', '\t']).any(|name| name.trim().trim_matches('"').eq_ignore_ascii_case("input"))
}

/// The subjects of a manifest, each with its own options.
fn subjects_of(manifest: Vec<ManifestRow>, path: &Path, given: &[PathBuf]) -> Vec<Subject> {
    let names = named_as(&manifest.iter().map(|row| (&*row.input, row.subject.as_deref())).collect::<Vec<_>>());
    let shared = shared_parts(parts_at_work(), given);
    let with_row = |(name, row): (String, ManifestRow)| {
        let parts = row_parts(&shared, &row.input, &row.options);
        Subject { name, input: row.input.clone(), parts, row: Some((path.to_owned(), row)) }
    };
    names.into_iter().zip(manifest).map(with_row).collect()
}

/// Refuses a folder that is no run, with what in it may be meant.
fn check_folder(path: &Path) -> Result<()> {
    if !path.is_dir() || is_there(&path.join(RECORD)) {
        return Ok(());
    }
    let refused = |found: &str, accepted: String| Err(Fault::file(found, accepted).in_file(path));
    let place = path.display().to_string();
    let place = place.trim_end_matches('/');
    if is_there(&path.join(COHORT)) {
        return refused("a cohort", format!("give its subjects, as '{place}/*'"));
    }
    let files: Vec<PathBuf> = fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    let has = |ending: &str| files.iter().any(|file| file.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending)));
    let ending = Format::clearest_ending(has);
    let found = if ending.is_some() { "a folder" } else { "a folder without run.json" };
    refused(found, format!("expected a file, or a pattern such as '{place}/*.{}'", ending.unwrap_or("vtp")))
}

/// Refuses a word that is no file but an option that lacks its dashes, or a number after a blank in the place of a comma.
fn check_word(path: &Path) -> Result<()> {
    let Some(word) = path.to_str().filter(|_| !path.exists()) else { return Ok(()) };
    let refused = |accepted: String| Err(Error::parameter("INPUT", format!("\"{word}\""), accepted));
    if is_option(word, None) {
        return refused(format!("no such file; did you mean --{word}?"));
    }
    let with_commas = "no such file; several values of an option go with commas, as in --epsilon 0.2,0.5";
    word.parse::<f64>().map_or(Ok(()), |_| refused(with_commas.into()))
}

/// The paths that the arguments mean, as often as they do; of what a pattern matches those that fit, a `kind` of file.
///
/// # Errors
///
/// As [`expand`].
pub fn paths(given: &[PathBuf], kind: &str, fits: impl Fn(&Path) -> bool) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for path in given {
        found.extend(if is_pattern(path) { matches(path, kind, &fits)? } else { vec![path.clone()] });
    }
    Ok(found)
}

/// Refuses a folder to write that has in it what is read for it, which would be lost with the earlier folder.
///
/// # Errors
///
/// As [`StagedFolder::check`]; the first path that is in it.
pub fn check_output<'a>(output: &Path, force: bool, read: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    StagedFolder::check(output, force)?;
    let Ok(folder) = fs::canonicalize(output) else { return Ok(()) };
    let is_in_it = |path: &&Path| fs::canonicalize(path).is_ok_and(|path| path.starts_with(&folder));
    let lost = |path: &Path| {
        let accepted = format!("would be replaced, and {} in it is read; expected another folder", path.display());
        Err(Error::parameter("output", output.display(), accepted))
    };
    read.into_iter().find(is_in_it).map_or(Ok(()), lost)
}

fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '[']) && !path.exists()
}

/// The files that a pattern matches, sorted; as in a shell, `*` takes neither `/` nor a leading dot, and `**` is any number of folders.
fn matches(pattern: &Path, kind: &str, fits: impl Fn(&Path) -> bool) -> Result<Vec<PathBuf>> {
    let text = pattern.to_string_lossy();
    let refused = |why: String| Error::parameter("INPUT", format!("\"{text}\""), why);
    let pattern_of = |text: &str| Pattern::new(text).map_err(|e| refused(format!("no pattern of file names: {e}")));
    pattern_of(&text)?;
    let steps = pattern.components().filter(|step| *step != Component::CurDir);
    let steps = steps.map(|step| Ok((step, pattern_of(&step.as_os_str().to_string_lossy())?)));
    let (mut steps, mut files) = (steps.collect::<Result<Vec<_>>>()?, Vec::new());
    // Any number of folders below any number of folders are any number of folders.
    steps.dedup_by(|(a, _), (b, _)| a == b && a.as_os_str() == "**");
    find(Path::new(""), &steps, &mut files)?;
    files.retain(|path| fits(path) && (path.is_dir() || !text.ends_with('/')));
    let why = || refused(format!("matches no {kind}; expected a {kind}, or a pattern of *, ? and [...]"));
    ensure(!files.is_empty(), why)?;
    files.sort();
    Ok(files)
}

/// Adds to what is found the paths to which the steps of a pattern lead from a folder, be their names UTF-8 or not.
fn find(folder: &Path, steps: &[(Component<'_>, Pattern)], found: &mut Vec<PathBuf>) -> Result<()> {
    let Some(((step, pattern), rest)) = steps.split_first() else {
        found.push(folder.to_owned());
        return Ok(());
    };
    if !pattern.as_str().contains(['*', '?', '[']) {
        let path = folder.join(step);
        return if is_there(&path) { find(&path, rest, found) } else { Ok(()) };
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    if !here.is_dir() {
        return Ok(());
    }
    let is_any = pattern.as_str() == "**";
    if is_any && !rest.is_empty() {
        find(folder, rest, found)?;
    }
    let cannot_be_read = |source| Error::Read { path: here.to_owned(), source };
    for entry in fs::read_dir(here).map_err(cannot_be_read)? {
        let name = entry.map_err(cannot_be_read)?.file_name();
        let (path, name) = (folder.join(&name), name.to_string_lossy());
        if name.starts_with('.') && !pattern.as_str().starts_with('.') {
            continue;
        }
        if !is_any && pattern.matches(&name) {
            find(&path, rest, found)?;
        } else if is_any && path.is_dir() {
            find(&path, steps, found)?;
            found.extend(rest.is_empty().then_some(path));
        }
    }
    Ok(())
}

/// A name for each input: that of the folder, or of the file without its ending; where all files are called the same, that of their
/// folder; where some are, `folder-file`; and a number behind what is still the same.
pub fn named(inputs: &[PathBuf]) -> Vec<String> {
    named_as(&inputs.iter().map(|input| (&**input, None)).collect::<Vec<_>>())
}

/// The same where a person may have said what an input is called.
fn named_as(inputs: &[(&Path, Option<&str>)]) -> Vec<String> {
    let mut times: HashMap<String, usize> = HashMap::new();
    for (path, _) in inputs {
        *times.entry(name_of(path).to_lowercase()).or_default() += 1;
    }
    let word = |path: &Path| {
        let folder = path.parent().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        match (times[&name_of(path).to_lowercase()], folder) {
            (n, Some(folder)) if n > 1 && n == inputs.len() => folder,
            (n, Some(folder)) if n > 1 => format!("{folder}-{}", name_of(path)),
            _ => name_of(path),
        }
    };
    let words = inputs.iter().map(|(path, name)| safe(&name.map_or_else(|| word(path), str::to_owned)));
    let mut taken: HashSet<String> = [COHORT, COHORT_TABLE, COHORT_PAGE, ACCURACY].map(str::to_owned).into();
    let unique = |word: String| {
        let mut numbered = std::iter::once(word.clone()).chain((2_u64..).map(|n| format!("{word}-{n}")));
        numbered.find(|name| taken.insert(name.to_lowercase())).unwrap_or_default()
    };
    words.map(unique).collect()
}

/// A word as the name of a folder on every system.
fn safe(word: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let name: String = word.chars().take(LONGEST).map(plain).collect();
    let name = name.trim_matches('.');
    if name.is_empty() { "subject".to_owned() } else { name.to_owned() }
}

/// The row of each subject in a table of participants: its number, and what it says of the participant. A subject has the name of its participant, with
/// or without `sub-`, or one that goes on with `_`, as in BIDS.
///
/// # Errors
///
/// A table that cannot be read or has no row of a subject.
pub fn rows_of_participants(subjects: &[Subject], path: &Path) -> Result<Vec<(usize, Covariates)>> {
    let rows = read_participants(&bytes_of(path)?).map_err(|fault| fault.in_file(path))?;
    let plain = |name: &str| safe(name.strip_prefix("sub-").unwrap_or(name)).to_lowercase();
    let known: Vec<String> = rows.iter().map(|(participant, _)| plain(participant)).collect();
    let of = |subject: &Subject| {
        let name = plain(&subject.name);
        let is_of = |known: &String| name.strip_prefix(&**known).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'));
        // Of `p` and `p_1` the subject `p_1_a` is of the second.
        let found = (0..known.len()).filter(|row| is_of(&known[*row])).max_by_key(|row| known[*row].len());
        let missing = || {
            let accepted = "expected a row for every subject, named in participant_id, subject or subject_id";
            Fault::file(format!("no row of subject \"{}\"", subject.name), accepted).in_file(path)
        };
        found.map(|row| (row, rows[row].1.clone())).ok_or_else(missing)
    };
    subjects.iter().map(of).collect()
}

/// What to call the subject of an input, file or folder.
pub fn name_of(input: &Path) -> String {
    if !input.is_dir() {
        return stem(input);
    }
    // The folder in which one is has its name elsewhere.
    let whole = if input.file_name().is_none() { fs::canonicalize(input).ok() } else { None };
    whole.as_deref().unwrap_or(input).file_name().unwrap_or_default().to_string_lossy().into_owned()
}
