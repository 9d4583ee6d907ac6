//! cohort.json: with what a cohort was made, so that the same command can go on with it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use willis::error::{Error, Result};
use willis::internals::io::{checksum_of_file, companion_files};
use willis::internals::output::names::COHORT;
use willis::internals::output::{StagedFile, read_json, write_json};

use super::run::Run;
use super::subjects::Subject;

/// With what a cohort was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// The version.
    pub willis: String,
    /// The subcommand.
    pub command: String,
    /// What all subjects share: every option that changes a result.
    pub parameters: Value,
    /// The subjects in order.
    pub subjects: Vec<Entry>,
}

/// With what a subject was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The name of its folder.
    pub subject: String,
    /// Its input.
    pub input: String,
    /// The SHA-256 of all files that go into it; null for one that cannot be read.
    pub files: BTreeMap<String, Option<String>>,
}

impl Entry {
    /// The entry of a subject as the files are now: its input, those that are read beside it, and `others`.
    pub fn of(subject: &Subject, others: Vec<PathBuf>) -> Self {
        let input = &Run::source(&subject.input);
        let mut files = BTreeMap::new();
        for path in std::iter::once(input.clone()).chain(companion_files(input)).chain(others) {
            let sum = || checksum_of_file(&path).ok();
            files.entry(path.display().to_string()).or_insert_with(sum);
        }
        Self { subject: subject.name.clone(), input: input.display().to_string(), files }
    }

    /// The SHA-256 of the input, if it can be read.
    pub fn sha256(&self) -> Option<&str> {
        self.files.get(&self.input)?.as_deref()
    }
}

/// The first option in which two sets of them differ, and in words what it is in the one and in the other.
pub fn differing(one: &Value, other: &Value) -> Option<(String, [String; 2])> {
    let (one, other) = one.as_object().zip(other.as_object())?;
    let name = one.keys().chain(other.keys()).find(|name| one.get(*name) != other.get(*name))?;
    let said = |value: Option<&Value>| value.filter(|v| !v.is_null()).map_or("not given".into(), Value::to_string);
    Some((name.replace('_', "-"), [said(one.get(name)), said(other.get(name))]))
}

impl Ledger {
    /// The ledger of a cohort's folder; `None` where there is none.
    pub fn read(folder: &Path) -> Option<Self> {
        read_json(&folder.join(COHORT), "").ok()
    }

    /// Writes it into the folder of a cohort, in place of an earlier one.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let file = StagedFile::new(&folder.join(COHORT), true)?;
        write_json(&file.path(), self)?;
        file.commit()
    }

    /// Refuses to go on with a cohort of other parameters, or one with a subject that is not among these.
    pub fn goes_on(&self, earlier: &Self, folder: &Path) -> Result<()> {
        const MEND: &str = "choose another --output, or give --force to start anew";
        let refused = |why: String| Err(Error::parameter("--output", folder.display(), format!("{why}; {MEND}")));
        if self.command != earlier.command {
            return refused(format!("holds a cohort of willis {}", earlier.command));
        }
        if self.willis == earlier.willis
            && let Some((option, [now, before])) = differing(&self.parameters, &earlier.parameters)
        {
            return refused(format!("holds a cohort made with other parameters ({option} was {before}, now {now})"));
        }
        let stays = |old: &&Entry| self.subjects.iter().any(|new| new.subject == old.subject && new.input == old.input);
        match earlier.subjects.iter().find(|old| !stays(old)) {
            Some(old) => refused(format!("holds subject {} of {}, which is not among these inputs", old.subject, old.input)),
            None => Ok(()),
        }
    }

    /// Whether a subject stands as the files are now; `earlier` is the ledger that was found.
    pub fn stands(&self, at: usize, earlier: &Self) -> bool {
        let entry = &self.subjects[at];
        self.willis == earlier.willis && entry.sha256().is_some() && earlier.subjects.contains(entry)
    }
}
