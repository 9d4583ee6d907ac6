//! Which experiments were made with answers that this version no longer gives, and that no page cites them.
//!
//! `experiments/depends.csv` says on which fingerprints each experiment rests, by the parts that can be run alone. `made-with.csv` beside
//! its results has the fingerprints that each part was made with. Where one has moved, the experiment is stale: the first line of its
//! README.md says so, and README.md and the book may not cite it. A page takes a table from `experiments/NAME/TABLE.md` between the
//! marks `<!-- experiments/NAME/TABLE.md:begin -->` and `:end`; while NAME is stale, a sentence stands there in its place.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// The fingerprints of a version: name and digest.
pub type Prints = [(String, String)];

/// How the first line of a stale experiment begins.
const STALE: &str = "> **Stale.**";

/// A part of an experiment that can be run alone (empty: there are none), and the fingerprints on which it rests.
pub struct Part {
    /// The folder.
    pub experiment: String,
    /// The part.
    pub name: String,
    /// The fingerprints by name.
    pub rests_on: Vec<String>,
}

/// The rows of a table without its heading, field by field.
fn rows(path: &Path) -> io::Result<Vec<Vec<String>>> {
    let text = fs::read_to_string(path)?;
    Ok(text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect())
}

/// The fingerprints as they were last written down.
pub fn known(root: &Path) -> io::Result<Vec<(String, String)>> {
    let rows = rows(&root.join("experiments/fingerprints.csv"))?;
    Ok(rows.into_iter().filter_map(|row| <[String; 2]>::try_from(row).ok()).map(|[name, digest]| (name, digest)).collect())
}

/// The table of what rests on what.
pub fn parts(root: &Path) -> io::Result<Vec<Part>> {
    let rows = rows(&root.join("experiments/depends.csv"))?;
    let part = |row: Vec<String>| {
        let [experiment, part, rests_on] = row.try_into().map_err(|_| io::Error::other("depends.csv: expected three fields"))?;
        Ok(Part { experiment, name: part, rests_on: rests_on.split_whitespace().map(str::to_owned).collect() })
    };
    rows.into_iter().map(part).collect()
}

/// Per experiment the fingerprints that have moved since a part of it was made; none where it stands.
pub fn moved(root: &Path, now: &Prints) -> io::Result<BTreeMap<String, Vec<String>>> {
    let mut all = BTreeMap::new();
    for Part { experiment, name: part, rests_on } in parts(root)? {
        let made = rows(&made_with(root, &experiment)).unwrap_or_default();
        let moved: &mut Vec<String> = all.entry(experiment).or_default();
        for name in rests_on {
            let (_, digest) =
                now.iter().find(|(known, _)| *known == name).ok_or_else(|| io::Error::other(format!("no fingerprint {name}")))?;
            let stands = made.iter().any(|row| row[..] == [part.clone(), name.clone(), digest.clone()]);
            if !stands && !moved.contains(&name) {
                moved.push(name);
            }
        }
    }
    Ok(all)
}

fn made_with(root: &Path, experiment: &str) -> PathBuf {
    root.join("experiments").join(experiment).join("made-with.csv")
}

/// Writes down that a part of an experiment was made with the answers of `now`; of all its parts, where none is named.
pub fn record(root: &Path, now: &Prints, experiment: &str, part: Option<&str>) -> io::Result<()> {
    let own: Vec<Part> = parts(root)?.into_iter().filter(|p| p.experiment == experiment).collect();
    if !own.iter().any(|p| part.is_none_or(|part| p.name == part)) {
        return Err(io::Error::other(format!("experiments/depends.csv has no {experiment} {}", part.unwrap_or_default())));
    }
    let before = rows(&made_with(root, experiment)).unwrap_or_default();
    let mut table = "part,fingerprint,digest\n".to_owned();
    for Part { name, rests_on, .. } in own {
        if part.is_some_and(|part| part != name) {
            before.iter().filter(|row| row[0] == name).for_each(|row| table += &(row.join(",") + "\n"));
            continue;
        }
        for (known, digest) in now.iter().filter(|(known, _)| rests_on.iter().any(|on| on == known)) {
            let _ = writeln!(table, "{name},{known},{digest}");
        }
    }
    fs::write(made_with(root, experiment), table)
}

/// The first line of the README of a stale experiment.
fn stale_line(moved: &[String]) -> String {
    let moved = moved.join("`, `");
    format!(
        "{STALE} Not recorded as made with the present answers: `{moved}`. README.md and the book do not cite it until it is run again."
    )
}

/// README.md of an experiment as it should be.
fn marked(text: &str, moved: &[String]) -> String {
    let bare = if text.starts_with(STALE) { text.split_once("\n\n").map_or("", |(_, rest)| rest) } else { text };
    if moved.is_empty() { bare.to_owned() } else { format!("{}\n\n{bare}", stale_line(moved)) }
}

/// A page with the tables that it takes from experiments, where these stand.
fn with_tables(root: &Path, text: &str, moved: &BTreeMap<String, Vec<String>>) -> io::Result<String> {
    const BEGIN: &str = "<!-- experiments/";
    let (mut out, mut inside) = (String::new(), None);
    for line in text.lines() {
        if inside.as_deref() == Some(line) {
            inside = None;
        }
        if inside.is_none() {
            out += line;
            out.push('\n');
        }
        let Some(table) = line.strip_prefix(BEGIN).and_then(|rest| rest.strip_suffix(":begin -->")) else { continue };
        let experiment = table.split('/').next().unwrap_or_default();
        let stands = moved.get(experiment).is_some_and(Vec::is_empty);
        if stands {
            out += &fs::read_to_string(root.join("experiments").join(table))?;
        } else {
            let _ = writeln!(
                out,
                "*`experiments/{experiment}` is to be run again with the present answers; its table stands here when it is.*"
            );
        }
        inside = Some(format!("{BEGIN}{table}:end -->"));
    }
    Ok(out)
}

/// README.md, the paper and the pages of the book.
fn pages(root: &Path) -> io::Result<Vec<PathBuf>> {
    let mut pages = vec![root.join("README.md"), root.join("docs/paper/paper.md")];
    for entry in fs::read_dir(root.join("docs/src"))? {
        pages.push(entry?.path());
    }
    pages.retain(|page| page.extension().is_some_and(|ending| ending == "md") && page.is_file());
    pages.sort();
    Ok(pages)
}

/// Writes the first line of every experiment, and the tables of every page.
pub fn mark(root: &Path, now: &Prints) -> io::Result<()> {
    let all = moved(root, now)?;
    for (experiment, moved) in &all {
        let page = root.join("experiments").join(experiment).join("README.md");
        replace(&page, |text| Ok(marked(text, moved)))?;
    }
    pages(root)?.iter().try_for_each(|page| replace(page, |text| with_tables(root, text, &all)))
}

fn replace(page: &Path, with: impl Fn(&str) -> io::Result<String>) -> io::Result<()> {
    let before = fs::read_to_string(page)?;
    let after = with(&before)?;
    if after == before { Ok(()) } else { fs::write(page, after) }
}

/// What is wrong: a stale experiment whose first line does not say so, and pages that cite it all the same.
pub fn faults(root: &Path, now: &Prints) -> io::Result<Vec<String>> {
    let all = moved(root, now)?;
    let mut faults = Vec::new();
    for (experiment, moved) in &all {
        let text = fs::read_to_string(root.join("experiments").join(experiment).join("README.md"))?;
        if text != marked(&text, moved) {
            let why = if moved.is_empty() {
                "is marked as stale, and is not".to_owned()
            } else {
                format!("is stale: moved {}", moved.join(", "))
            };
            faults.push(format!("experiments/{experiment} {why}; run it again, or mark it"));
        }
    }
    let overview = fs::read_to_string(root.join("experiments/README.md"))?;
    for experiment in all.iter().filter(|(_, moved)| !moved.is_empty()).map(|(name, _)| name) {
        let row = |line: &&str| line.starts_with(&format!("| `{experiment}` |")) && !line.ends_with("| stale |");
        let in_table = overview.split("<!-- overview:end -->").next().unwrap_or_default();
        faults.extend(
            in_table
                .lines()
                .find(row)
                .map(|_| format!("experiments/README.md cites {experiment}, which is stale; run experiments/overview.py")),
        );
    }
    for page in pages(root)? {
        let text = fs::read_to_string(&page)?;
        let name = page.strip_prefix(root).unwrap_or(&page).display();
        if text != with_tables(root, &text, &all)? {
            faults.push(format!("{name}: a table is not that of its experiment; mark"));
        }
        let cited = cited(&text, |experiment| all.get(experiment).is_some_and(|moved| !moved.is_empty()));
        faults.extend(
            cited.into_iter().map(|experiment| format!("{name} gives figures of experiments/{experiment}, which is stale")),
        );
    }
    Ok(faults)
}

/// The experiments of some kind whose figures a page gives: those that a paragraph with a digit names. What follows a colon at the end
/// of a paragraph, a table or a list, is part of it.
pub fn cited(page: &str, which: impl Fn(&str) -> bool) -> Vec<String> {
    let page = page.replace("\r\n", "\n");
    let mut paragraphs: Vec<String> = Vec::new();
    for paragraph in page.split("\n\n").filter(|paragraph| !paragraph.trim().is_empty()) {
        match paragraphs.last_mut().filter(|last| last.trim_end().ends_with(':')) {
            Some(introduction) => introduction.extend(["\n", paragraph]),
            None => paragraphs.push(paragraph.to_owned()),
        }
    }
    let mut all = Vec::new();
    for paragraph in paragraphs {
        let named = paragraph.split("experiments/").skip(1);
        let named = named.map(|rest| rest.split(|c: char| !c.is_ascii_alphanumeric() && c != '-').next().unwrap_or_default());
        // Digits in code are names of files and options.
        let prose: String = paragraph.split('`').step_by(2).collect();
        let figures = prose.contains(|c: char| c.is_ascii_digit());
        all.extend(named.filter(|experiment| figures && which(experiment)).map(str::to_owned));
    }
    all
}
