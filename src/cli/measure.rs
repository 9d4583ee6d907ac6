//! `willis measure`: lengths, widths, bends, angles and orders of vessels, and of whole networks, as tables.

use std::{collections::BTreeMap, collections::BTreeSet, path::Path, path::PathBuf};

use serde_json::{Value, json};

use super::args::{boundary_for, file_of, length, whole};
use super::cohort::{check_files, failed, make_each};
use super::print::{TextTerminal, plural};
use super::subjects::{Inputs, Subject, check_output, expand, name_of, rows_of_participants};
use super::{
    args::reading::RunsArgs, checkpoint::Follower, command_line::command_line, command_line::parts_at_work, shell::print_json,
    signals::listen,
};
use crate::internals::formats::{Column, Covariates, check_name, checksum_of_file, write_csv, write_stacked};
use crate::internals::output::names::{BIFURCATIONS, COMPARISON, DIFFERENCES, ENDS, INTERVALS, PAGE, READERS, SUBJECTS, VESSELS};
use crate::internals::output::{StagedFolder, write_file, write_record};
use crate::internals::report::cohort::{CohortRow, cohort_columns, row_records};
use crate::internals::report::{TwiceRead, difference_columns, kappa_of, reader_columns};
use crate::{
    BoundaryOptions, ComparisonOptions, Error, MeasureOptions, Measurement, Result, compare_groups, error::Fault,
    internals::network::units::millimetres, internals::pipeline::require, internals::report::write_comparison_page,
    internals::support::suggestions::did_you_mean, measure, twice_read, two_groups,
};

/// Measure vessels: lengths, radii, bends, bifurcations, orders, and whole networks
///
/// Tables with a row for each vessel, bifurcation, end and subject, units in their names. Of the folder of willis infer the plausible topology is
/// measured, and the figures of a whole network have their mean and 95 % interval over the topologies that are plausible.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis measure circle.graphml -o measured
  willis measure 'cohort/*' -o measured
  willis measure cohort -o measured --participants participants.tsv --compare group")]
pub struct MeasureArgs {
    #[command(flatten)]
    runs: RunsArgs,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Over which length the course of a vessel is smoothed before its bends are measured, in mm unless it says otherwise [default: six
    /// of its radii]
    #[arg(long, value_name = "LENGTH", value_parser = length("smoothing"), hide_short_help = true)]
    smoothing: Option<f64>,
    /// A mask of the brain, in which densities are told too; in its name {} is INPUT without its ending and {dir} the folder of INPUT
    #[arg(long, value_name = "MASK", value_hint = clap::ValueHint::FilePath)]
    brain: Option<PathBuf>,
    /// The diameter below which a segment of the circle is hypoplastic [default: 1mm]
    #[arg(long, value_name = "DIAMETER", value_parser = length("hypoplastic"), hide_short_help = true)]
    hypoplastic: Option<f64>,
    /// What is known of the subjects: a table (CSV or TSV) with a row for each, named in participant_id or subject, as participants.tsv of BIDS; its columns
    /// go into subjects.csv
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath, help_heading = "Comparison")]
    participants: Option<PathBuf>,
    /// Compare the two groups that a column of the participants, or of a manifest, makes: comparison.csv, and report.html with the points of both
    #[arg(long, value_name = "COLUMN", help_heading = "Comparison")]
    compare: Option<String>,
    /// Only compare these columns of subjects.csv, so that p is corrected for fewer [default: all]
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', requires = "compare", help_heading = "Comparison")]
    measures: Vec<String>,
    /// The seed of permutations and of the topologies that stand for those that are plausible
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u64>, allow_negative_numbers = true,
        help_heading = "Comparison", hide_short_help = true)]
    seed: u64,
    /// What a reader decided on the connections of a run (decisions.csv of its page), given once for each of two readers: readers.csv has Cohen's kappa, differences.csv
    /// where they differ; in its name {} is INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath, help_heading = "Comparison")]
    reader: Vec<PathBuf>,
    /// Print the row of each subject on standard output too, as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    boundary: BoundaryOptions,
}

impl MeasureArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        self.runs.reading.refuse_candidates("measure")?;
        self.runs.reading.shared()?;
        let named = [&self.brain, &self.boundary.conditions, &self.participants];
        named.into_iter().flatten().try_for_each(|file| check_name(file))?;
        let (subjects, were_found) = match expand(&self.runs.inputs, true)? {
            Inputs::Many(subjects) => (subjects, true),
            Inputs::One(input) => (vec![Subject { name: name_of(&input), input, parts: parts_at_work(), row: None }], false),
        };
        check_output(&self.output, force, subjects.iter().map(|subject| &*subject.input))?;
        if let Some(subject) = subjects.iter().find(|subject| !subject.own().is_empty()) {
            let own = subject.own().join(" ");
            return Err(subject.fault(Error::parameter("manifest", own, "measure takes no options from a manifest")));
        }
        let given: Vec<String> = self.reader.iter().map(|path| path.display().to_string()).collect();
        let accepted = "expected two of them, one for each reader";
        require(matches!(given.len(), 0 | 2), "reader", given.join(", "), accepted)?;
        let known = self.covariates(&subjects)?;
        let groups = self.compare.as_ref().map(|column| groups(column, &known)).transpose()?;
        let measure = |subject: &Subject, terminal: TextTerminal| {
            let path = &subject.input;
            let named = [&self.brain, &self.boundary.conditions].into_iter().flatten().chain(&self.reader);
            if were_found {
                check_files(subject, named.map(|name| file_of(name, path)).chain(self.runs.reading.loops(path)).collect())?;
            }
            self.measure(subject, terminal)
        };
        let measured = if let [subject] = &*subjects {
            vec![Ok(measure(subject, terminal)?)]
        } else {
            listen(2);
            let done = vec![false; subjects.len()];
            let make = |at: usize| measure(&subjects[at], terminal.of_many());
            let made = make_each(&subjects, &done, ["measured", "subject"], None, make, terminal)?;
            made.into_iter().flatten().collect()
        };
        let apart = |made: Result<_, String>| made.map_or_else(|why| (Err(why), Vec::new()), |(found, read)| (Ok(found), read));
        let (measured, read): (Vec<Result<Measurement, String>>, Vec<Vec<TwiceRead>>) = measured.into_iter().map(apart).unzip();
        let read = (!self.reader.is_empty()).then(|| read.concat());
        let rows = subjects.iter().zip(&known).zip(&measured);
        let rows: Vec<CohortRow> = rows.map(|((subject, known), made)| row_of(subject, known, made)).collect();
        let compared = |(names, first): ([String; 2], Vec<Option<bool>>)| -> Result<_> {
            Ok((self.comparison(&names, &first, &measured, terminal)?, first))
        };
        let comparison = groups.map(compared).transpose()?;
        if let Some(read) = &read {
            let found = kappa_of(read);
            let kappa = if found.kappa.is_nan() { "no kappa".to_owned() } else { format!("kappa {:.2}", found.kappa) };
            terminal.say("readers", format!("{} of {} alike, {kappa}", found.alike, plural(found.count, "decision")));
        }
        self.write(&rows, measured.iter().flatten(), comparison, read.as_deref(), force)?;
        if self.json {
            row_records(&rows).iter().try_for_each(print_json)?;
        }
        terminal.say("written", format!("{}: {}", self.output.display(), plural(rows.len(), "subject")));
        failed(rows.iter().filter(|row| row.figures.is_err()).count(), rows.len())
    }

    fn measure(&self, subject: &Subject, terminal: TextTerminal) -> Result<(Measurement, Vec<TwiceRead>)> {
        let path = &subject.input;
        let input = self.runs.reading.read_run(path, subject.line("again"), terminal)?;
        let files: Vec<PathBuf> = self.reader.iter().map(|name| file_of(name, path)).collect();
        let read = if let [a, b] = &*files { twice_read(&subject.name, &input, [a, b])? } else { Vec::new() };
        let found = measure(&subject.name, &input, &self.options(path), &mut Follower::new(terminal))?;
        terminal.notes(&found.notes);
        Ok((found, read))
    }

    fn options(&self, input: &Path) -> MeasureOptions {
        let (boundary, brain) = (boundary_for(&self.boundary, input), self.brain.as_ref().map(|name| file_of(name, input)));
        MeasureOptions { boundary, smoothing: self.smoothing, brain, hypoplastic: self.hypoplastic }
    }

    /// What is known of each subject: what its manifest says, then its participant.
    fn covariates(&self, subjects: &[Subject]) -> Result<Vec<Covariates>> {
        let mut known: Vec<Covariates> = subjects.iter().map(|subject| subject.covariates().to_vec()).collect();
        let Some(path) = &self.participants else { return Ok(known) };
        let rows = rows_of_participants(subjects, path)?;
        let mut of = BTreeMap::new();
        for (subject, (row, _)) in subjects.iter().zip(&rows) {
            if let Some(first) = of.insert(*row, &subject.name).filter(|_| self.compare.is_some()) {
                let found = format!("subjects \"{first}\" and \"{}\" of one participant", subject.name);
                return Err(Fault::file(found, "expected one subject of each, since groups are compared").in_file(path));
            }
        }
        for (known, (_, said)) in known.iter_mut().zip(rows) {
            let new: Covariates = said.into_iter().filter(|(name, _)| known.iter().all(|(other, _)| other != name)).collect();
            known.extend(new);
        }
        Ok(known)
    }

    /// The columns of comparison.csv.
    fn comparison(
        &self,
        names: &[String; 2],
        first: &[Option<bool>],
        measured: &[Result<Measurement, String>],
        terminal: TextTerminal,
    ) -> Result<Vec<Column>> {
        let subjects: Vec<(&Measurement, bool)> =
            measured.iter().zip(first).filter_map(|(made, first)| Some((made.as_ref().ok()?, (*first)?))).collect();
        let options = ComparisonOptions { measures: self.measures.clone(), seed: self.seed };
        let columns = compare_groups(names, &subjects, &options)?;
        let is_compared = |name: &String| (0..columns[0].values.rows()).any(|row| columns[0].values.text(row) == name.as_str());
        for name in self.measures.iter().filter(|name| !is_compared(name)) {
            terminal.say(
                "note",
                format!("{name} is not compared: it is equal in all subjects, or known of fewer than two of a group"),
            );
        }
        let left_out = measured.len() - subjects.len();
        let [a, b] = [true, false].map(|group| subjects.iter().filter(|(_, first)| *first == group).count());
        let ([first, second], compared) = (names, plural(columns[0].values.rows(), "measure"));
        terminal.say("compared", format!("{compared}: {a} of {first}, {b} of {second}, {left_out} left out"));
        Ok(columns)
    }

    /// Writes the tables of all subjects, one below the other, the comparison, and the record.
    fn write<'a>(
        &self,
        rows: &[CohortRow],
        measured: impl Iterator<Item = &'a Measurement>,
        comparison: Option<(Vec<Column>, Vec<Option<bool>>)>,
        read: Option<&[TwiceRead]>,
        force: bool,
    ) -> Result<()> {
        let tables: Vec<[Vec<Column>; 4]> = measured.map(Measurement::tables).collect();
        let folder = StagedFolder::new(&self.output, force)?;
        for (at, name) in [VESSELS, BIFURCATIONS, ENDS, INTERVALS].into_iter().enumerate() {
            let own: Vec<&[Column]> = tables.iter().map(|tables| &*tables[at]).collect();
            write_file(&folder.path().join(name), |out| write_stacked(out, &own))?;
        }
        write_file(&folder.path().join(SUBJECTS), |out| write_csv(out, &cohort_columns(rows)))?;
        let record = self.record(rows);
        if let Some((columns, first)) = comparison {
            write_file(&folder.path().join(COMPARISON), |out| write_csv(out, &columns))?;
            write_file(&folder.path().join(PAGE), |out| write_comparison_page(out, &record, columns, rows, &first))?;
        }
        if let Some(read) = read {
            write_file(&folder.path().join(READERS), |out| write_csv(out, &reader_columns(read)))?;
            write_file(&folder.path().join(DIFFERENCES), |out| write_csv(out, &difference_columns(read)))?;
        }
        write_record(&folder.path(), &record)?;
        folder.commit()
    }

    fn record(&self, rows: &[CohortRow]) -> Value {
        json!({
            "willis": env!("CARGO_PKG_VERSION"),
            "command": command_line("again"),
            "parameters": {
                "smoothing_mm": self.smoothing.map(millimetres),
                "brain": self.brain,
                "hypoplastic_mm": self.hypoplastic.map(millimetres),
                "boundary": self.boundary,
                "participants": self.participants,
                "compare": self.compare,
                "measures": self.measures,
                "seed": self.seed,
                "reader": self.reader,
            },
            "subjects": row_records(rows),
        })
    }
}

/// The two groups that a column makes, and of each subject whether it is in the first.
fn groups(column: &str, known: &[Covariates]) -> Result<([String; 2], Vec<Option<bool>>)> {
    let names: BTreeSet<&str> = known.iter().flatten().map(|(name, _)| &**name).collect();
    if !names.contains(column) {
        let meant = did_you_mean(column, names.iter().copied());
        let accepted = match names.len() {
            0 => "goes with `participants`, or a manifest that has the column".to_owned(),
            _ => format!("{meant}expected one of {}", names.into_iter().collect::<Vec<_>>().join(", ")),
        };
        return Err(Error::parameter("compare", column, accepted));
    }
    let value = |of: &Covariates| of.iter().find(|(name, _)| name == column).map(|(_, value)| value.clone()).unwrap_or_default();
    let values: Vec<String> = known.iter().map(value).collect();
    two_groups(column, &values.iter().map(String::as_str).collect::<Vec<_>>())
}

/// The row of a subject.
fn row_of(subject: &Subject, known: &Covariates, made: &Result<Measurement, String>) -> CohortRow {
    let sha256 = made.as_ref().map_or_else(|_| checksum_of_file(&subject.input).unwrap_or_default(), |of| of.sha256.clone());
    let (name, input) = (subject.name.clone(), subject.input.display().to_string());
    let figures = made.as_ref().map(Measurement::row).map_err(String::clone);
    CohortRow { subject: name, input, sha256, covariates: known.clone(), page: None, figures }
}
