//! The dataset that `willis bids` writes: what describes it, where its runs are, and the files of a run under names of BIDS.

use std::{fs, io::Write, path::Path, path::PathBuf};

use serde_json::{Value, json};

use super::dataset::{DESCRIPTION, Dataset, DatasetMask, PARTICIPANTS, PARTICIPANTS_COLUMNS, anatomy, is_of_willis};
use crate::internals::formats::{Column, Covariates, open_regular, regular_bytes_of};
use crate::internals::output::names::{PAGE, TOPOLOGY, TOPOLOGY_ENDINGS};
use crate::internals::output::{StagedFiles, is_in_progress, relative, replace_file, write_error};
use crate::internals::report::cohort::{sidecar, write_tsv};
use crate::{Result, internals::pipeline::require_in};

/// The version of BIDS that the names follow.
const BIDS: &str = "1.10.0";
/// The files that are no part of BIDS, for its validator. A table in `phenotype` could have only one session of a participant.
const IGNORED: &str = "*.html\nruns\ngroup\ngroup_willis.*\n*_desc-willis_topology.*\n";
/// The end of the names of the topology of a run.
const TOPOLOGY_NAME: &str = "_desc-willis_topology";
const README: &str = "\
# Vessel topology by willis

Made by `willis bids` of masks of vessels. Every participant (and session) has one run of `willis infer`.

- `sub-*.html`: the report of each run; open it in a browser.
- `sub-*/[ses-*/]anat/*_desc-willis_topology.*`: the plausible topology as GraphML, VTP and, without cycles, SWC, in mm, in the frame of the scanner (RAS).
- `runs/`: all files of each run, with `edges.csv`, the likelihood matrix and `run.json`, which says how it was made.
- `group_willis.tsv`: a row for each run, made by the level `group`; `group_willis.json` says what the columns are.
- `participants.tsv`, where the dataset of the masks has one: its rows of the participants with a run. `group_willis.tsv` has its columns too.
- `group/cohort.html`: the same as a page, the most uncertain first.

Candidate connections between vessels are kept or cut by their probability. `runs/*/candidates.graphml` has all of them.
";

/// The dataset to write.
pub struct Derivative {
    pub folder: PathBuf,
}

impl Derivative {
    /// The dataset in a folder that is absent, empty, or of willis.
    ///
    /// # Errors
    ///
    /// A folder with something else in it, or one that is the dataset of the masks.
    pub fn new(folder: &Path, source: &Path) -> Result<Self> {
        let same = fs::canonicalize(folder).ok().zip(fs::canonicalize(source).ok()).is_some_and(|(a, b)| a == b);
        require_in(folder, !same, "is BIDS_DIR", "expected another folder, such as BIDS_DIR/derivatives/willis")?;
        // Another process may be writing what says that it is of willis.
        let is_vacant = |entries: fs::ReadDir| entries.flatten().all(|entry| is_in_progress(&entry.path()));
        let is_vacant = !folder.exists() || fs::read_dir(folder).is_ok_and(is_vacant);
        let accepted = "expected a new folder, or a dataset of willis bids to go on with";
        require_in(folder, is_vacant || is_of_willis(folder), "holds something else", accepted)?;
        Ok(Self { folder: folder.to_owned() })
    }

    /// The folder of all runs.
    pub fn runs(&self) -> PathBuf {
        self.folder.join("runs")
    }

    /// The folder of the run of a mask.
    pub fn run(&self, mask: &DatasetMask) -> PathBuf {
        self.runs().join(mask.run())
    }

    /// Writes what describes the dataset, first what says that it is of willis, and makes the folder of runs.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn describe(&self, dataset: &Dataset, source: &Path) -> Result<()> {
        let of = dataset.name().map_or_else(String::new, |name| format!(" of {name}"));
        let maker = json!({
            "Name": "willis",
            "Version": env!("CARGO_PKG_VERSION"),
            "Description": "Candidate connections between the vessels of a mask, kept or cut by their probability.",
        });
        let mut record = json!({
            "Name": format!("Vessel topology{of} by willis"),
            "BIDSVersion": BIDS,
            "DatasetType": "derivative",
            "GeneratedBy": [maker],
        });
        // An absolute path would say on whose machine it was made.
        if let Some(way) = relative(source, &self.folder) {
            record["SourceDatasets"] = json!([{ "URL": way }]);
            record["DatasetLinks"] = json!({ "source": way });
        }
        self.put(DESCRIPTION, &text_of(&record))?;
        self.put("README.md", README.as_bytes())?;
        self.put(".bidsignore", IGNORED.as_bytes())?;
        let runs = self.runs();
        fs::create_dir_all(&runs).map_err(write_error(&runs))
    }

    /// Writes what is known of participants, and what the columns are, as the dataset of the masks says it.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or written.
    pub fn keep<'a>(&self, dataset: &Dataset, participants: impl Iterator<Item = &'a (String, Covariates)>) -> Result<()> {
        let (names, known): (Vec<String>, Vec<&Covariates>) = participants.map(|(name, known)| (name.clone(), known)).unzip();
        let Some(first) = known.first() else { return Ok(()) };
        let mut columns = vec![Column::text("participant_id", names.into_iter())];
        let cells = |at: usize| known.iter().map(move |known| known[at].1.clone());
        columns.extend(first.iter().enumerate().map(|(at, (name, _))| Column::text(name.clone(), cells(at))));
        self.put_table(PARTICIPANTS, &columns)?;
        dataset.file(PARTICIPANTS_COLUMNS)?.map_or(Ok(()), |about| self.put(PARTICIPANTS_COLUMNS, &about))
    }

    /// The page of a run at the top.
    fn page(&self, mask: &DatasetMask) -> PathBuf {
        self.folder.join(format!("{}.html", mask.run()))
    }

    /// The beginning of the path of the topology of a run.
    fn topology(&self, mask: &DatasetMask) -> PathBuf {
        let folder = anatomy(&self.folder, &mask.participant, mask.session.as_deref());
        folder.join(format!("{}{TOPOLOGY_NAME}", mask.entities()))
    }

    /// The files of a run under names of BIDS: in the run, and in the dataset.
    fn files(&self, mask: &DatasetMask) -> Vec<(String, PathBuf)> {
        let topology = self.topology(mask).display().to_string();
        let named = |end| (format!("{TOPOLOGY}.{end}"), format!("{topology}.{end}").into());
        TOPOLOGY_ENDINGS.map(named).into_iter().chain([(PAGE.to_owned(), self.page(mask))]).collect()
    }

    /// Whether the files of a run stand under names of BIDS.
    pub fn has(&self, mask: &DatasetMask) -> bool {
        let run = self.run(mask);
        self.files(mask).iter().all(|(name, path)| path.exists() == run.join(name).exists())
    }

    /// Puts the files of a run under names of BIDS.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or written.
    pub fn export(&self, mask: &DatasetMask, dataset: &Dataset) -> Result<()> {
        let run = self.run(mask);
        let sidecar = PathBuf::from(format!("{}.json", self.topology(mask).display()));
        let folder = sidecar.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder).map_err(write_error(folder))?;
        let record = json!({
            "Description": "The plausible topology of the vessels: those of the mask, and the candidate connections that are kept; in mm, in the frame of the scanner (RAS).",
            "Sources": [format!("bids:source:{}", dataset.place_of(&mask.path))],
        });
        // First, for it is the others that say whether all are there.
        replace_file(&sidecar, |out| out.write_all(&text_of(&record)))?;
        self.files(mask).into_iter().filter(|(name, _)| run.join(name).exists()).try_for_each(|(name, path)| {
            let mut file = open_regular(&run.join(name))?;
            replace_file(&path, |out| std::io::copy(&mut file, out).map(drop))
        })
    }

    /// Takes away the files of an earlier run under names of BIDS, of whatever mask of the session it was.
    ///
    /// # Errors
    ///
    /// The system refuses.
    pub fn clear(&self, mask: &DatasetMask) -> Result<()> {
        let topology = self.topology(mask);
        let there = fs::read_dir(topology.parent().unwrap_or(&self.folder)).into_iter().flatten().flatten();
        let is_ours = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().contains(TOPOLOGY_NAME));
        let paths = there.map(|entry| entry.path()).filter(is_ours).chain([self.page(mask)]);
        paths.filter(|path| path.exists()).try_for_each(|path| fs::remove_file(&path).map_err(write_error(&path)))
    }

    /// Writes the table of all runs and its sidecar.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write_table(&self, columns: &[Column]) -> Result<PathBuf> {
        self.put_table("group_willis.tsv", columns)?;
        self.put("group_willis.json", &text_of(&sidecar(columns)))?;
        Ok(self.folder.join("group_willis.tsv"))
    }

    fn put_table(&self, name: &str, columns: &[Column]) -> Result<()> {
        let mut table = Vec::new();
        write_tsv(&mut table, columns).map_err(write_error(&self.folder.join(name)))?;
        self.put(name, &table)
    }

    /// Writes a file, which another process that works on other participants may write at the same time.
    fn put(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.folder.join(name);
        let stands = || regular_bytes_of(&path).is_ok_and(|there| there == bytes);
        if stands() {
            // What a command left that was killed once this was whole; one at work clears its own.
            let _ = StagedFiles::check(&path, [], true);
            return Ok(());
        }
        let written = StagedFiles::write_one(&path, true, |out| out.write_all(bytes));
        written.or_else(|error| if stands() { Ok(()) } else { Err(error) })
    }
}

/// JSON for people to read.
fn text_of(record: &Value) -> Vec<u8> {
    format!("{record:#}\n").into_bytes()
}
