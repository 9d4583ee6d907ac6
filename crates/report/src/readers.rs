//! readers.csv and differences.csv: how far two readers agree on the connections of runs, and where they differ.

use willis_core::support::comparison::{CohenKappa, cohen_kappa};
use willis_io::formats::{Column, POSITION_COLUMNS, coordinate_columns};

/// What a reader says of a connection.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadBy {
    /// Whether it is there; none where the reader is unsure.
    pub accepted: Option<bool>,
    /// Who decided; may be empty.
    pub who: String,
    /// What was said of it; may be empty.
    pub comment: String,
}

/// The answers that a reader may give.
const ANSWERS: [(Option<bool>, &str); 3] = [(Some(true), "accept"), (Some(false), "reject"), (None, "unsure")];

impl ReadBy {
    fn answer(&self) -> usize {
        ANSWERS.iter().position(|(accepted, _)| *accepted == self.accepted).unwrap_or_default()
    }
}

/// A connection that one of two readers decided on at least.
#[derive(Debug, Clone, PartialEq)]
pub struct TwiceRead {
    /// The subject.
    pub subject: String,
    /// The kind of question: `candidate` or `contact`.
    pub kind: &'static str,
    /// Its row in edges.csv.
    pub edge: usize,
    /// The ids of its two nodes.
    pub ids: [String; 2],
    /// Where it is, mm.
    pub middle: [f64; 3],
    /// What the run says; not a number without evidence.
    pub probability: f64,
    /// What the readers say; none of one who did not decide.
    pub read: [Option<ReadBy>; 2],
}

impl TwiceRead {
    /// The answers of both, where both decided.
    fn answers(&self) -> Option<[usize; 2]> {
        let [a, b] = &self.read;
        Some([a.as_ref()?.answer(), b.as_ref()?.answer()])
    }
}

/// Kappa over all connections.
pub fn kappa_of(read: &[TwiceRead]) -> CohenKappa {
    cohen_kappa(&read.iter().filter_map(TwiceRead::answers).collect::<Vec<_>>(), ANSWERS.len())
}

/// The columns of readers.csv: a row for each kind of question, and one for all.
pub fn reader_columns(read: &[TwiceRead]) -> Vec<Column> {
    let mut kinds: Vec<&str> = read.iter().map(|row| row.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let of = |kind: &str| read.iter().filter(|row| row.kind == kind).cloned().collect::<Vec<_>>();
    let mut rows: Vec<(&str, Vec<TwiceRead>)> = kinds.into_iter().map(|kind| (kind, of(kind))).collect();
    rows.push(("all", read.to_vec()));
    let found: Vec<CohenKappa> = rows.iter().map(|(_, read)| kappa_of(read)).collect();
    let counted = |name: String, counts: &dyn Fn(&TwiceRead) -> bool| {
        Column::whole(name, rows.iter().map(|(_, read)| read.iter().filter(|row| counts(row)).count()))
    };
    let real = |name, of: fn(&CohenKappa) -> f64| Column::real(name, found.iter().map(of));
    let mut columns = vec![
        Column::text("kind", rows.iter().map(|(kind, _)| (*kind).to_owned())),
        Column::whole("decided", found.iter().map(|found| found.count)),
        Column::whole("alike", found.iter().map(|found| found.alike)),
        real("kappa", |found| found.kappa),
        real("kappa_low", |found| found.interval[0]),
        real("kappa_high", |found| found.interval[1]),
    ];
    for (a, (_, first)) in ANSWERS.iter().enumerate() {
        for (b, (_, second)) in ANSWERS.iter().enumerate() {
            columns.push(counted(format!("{first}_{second}"), &|row| row.answers() == Some([a, b])));
        }
    }
    columns.push(counted("only_a".to_owned(), &|row| row.read[1].is_none()));
    columns.push(counted("only_b".to_owned(), &|row| row.read[0].is_none()));
    columns
}

/// A column of each reader: its name, and what it says.
type ReaderColumn = (&'static str, fn(&ReadBy) -> String);

/// The columns of differences.csv: the connections that both decided otherwise, or only one.
pub fn difference_columns(read: &[TwiceRead]) -> Vec<Column> {
    let rows: Vec<&TwiceRead> = read.iter().filter(|row| row.answers().is_none_or(|[a, b]| a != b)).collect();
    let text = |name: String, of: &dyn Fn(&TwiceRead) -> String| Column::text(name, rows.iter().map(|row| of(row)));
    let mut columns = vec![
        text("subject".to_owned(), &|row| row.subject.clone()),
        text("kind".to_owned(), &|row| row.kind.to_owned()),
        Column::whole("edge", rows.iter().map(|row| row.edge)),
        text("id_a".to_owned(), &|row| row.ids[0].clone()),
        text("id_b".to_owned(), &|row| row.ids[1].clone()),
    ];
    columns.extend(coordinate_columns(POSITION_COLUMNS, || rows.iter().map(|row| row.middle)));
    columns.push(Column::real("probability", rows.iter().map(|row| row.probability)));
    let of_reader: [ReaderColumn; 3] = [
        ("decision", |read| ANSWERS[read.answer()].1.to_owned()),
        ("who", |read| read.who.clone()),
        ("comment", |read| read.comment.clone()),
    ];
    for (name, of) in of_reader {
        for (reader, letter) in ["a", "b"].into_iter().enumerate() {
            columns.push(text(format!("{name}_{letter}"), &|row| row.read[reader].as_ref().map_or_else(String::new, of)));
        }
    }
    columns
}
