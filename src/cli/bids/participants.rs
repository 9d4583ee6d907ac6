//! `participants.tsv` of a BIDS dataset: what is known of each participant, such as age.

use std::path::Path;

use crate::error::{Fault, Result};
use crate::internals::formats::{is_there, regular_bytes_of};

/// The file.
pub const PARTICIPANTS: &str = "participants.tsv";
/// The file that says what its columns are.
pub const ABOUT: &str = "participants.json";
const ID: &str = "participant_id";

/// The table of participants; no column where the dataset has none.
#[derive(Debug, Default)]
pub struct Participants {
    /// The columns, that of the participant first.
    pub header: Vec<String>,
    /// The cells of each participant.
    pub rows: Vec<Vec<String>>,
    /// What the columns are, as the dataset says it.
    pub about: Option<Vec<u8>>,
}

impl Participants {
    /// The table of the dataset in a folder.
    ///
    /// # Errors
    ///
    /// A file that is there and cannot be read, or whose first column is not that of participants; a row of another length.
    pub fn read(dataset: &Path) -> Result<Self> {
        let path = dataset.join(PARTICIPANTS);
        if !is_there(&path) {
            return Ok(Self::default());
        }
        let bytes = regular_bytes_of(&path)?;
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_start_matches('\u{feff}');
        let cells = |line: &str| line.trim_end_matches('\r').split('\t').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
        let mut lines = (1..).zip(text.split('\n')).filter(|(_, line)| !line.trim().is_empty());
        let header = lines.next().map(|(_, line)| cells(line)).unwrap_or_default();
        if header.first().is_none_or(|name| name != ID) {
            let found = format!("the first column is \"{}\"", header.first().map_or("", String::as_str));
            return Err(Fault::line(1, found, "expected participant_id, as BIDS has it").in_file(&path));
        }
        let mut rows = Vec::new();
        for (at, line) in lines {
            let row = cells(line);
            if row.len() != header.len() {
                let found = format!("{} cells", row.len());
                return Err(
                    Fault::line(at, found, format!("expected {}, as the header, between tabs", header.len())).in_file(&path)
                );
            }
            rows.push(row);
        }
        let about = dataset.join(ABOUT);
        let about = if is_there(&about) { Some(regular_bytes_of(&about)?) } else { None };
        Ok(Self { header, rows, about })
    }

    /// What is known of a participant, by column; empty where that is missing.
    pub fn covariates(&self, participant: &str) -> Vec<(String, String)> {
        let row = self.rows.iter().find(|row| row[0] == participant);
        let text = |at: usize| row.map_or("", |row| &row[at]);
        let known = |text: &str| if text == "n/a" { String::new() } else { text.to_owned() };
        self.header.iter().enumerate().skip(1).map(|(at, name)| (name.clone(), known(text(at)))).collect()
    }

    /// The table as BIDS has it.
    pub fn bytes(&self) -> Vec<u8> {
        let lines = [&self.header].into_iter().chain(&self.rows).map(|cells| cells.join("\t") + "\n");
        lines.collect::<String>().into_bytes()
    }
}
