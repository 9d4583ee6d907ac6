//! The type column of SWC as anatomical labels: whole numbers stand for themselves, `# label 16 L-PComm` names the others.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};

use crate::network::centerlines::Centerlines;

/// The first code for a label that is no whole number; the specification and its users have meanings for those below.
const FIRST_FREE: u64 = 16;
/// Whole numbers above are not exact in every reader.
const LARGEST: f64 = 9e15;

/// The labels that the comments of a file give to its types.
#[derive(Debug, Default)]
pub(crate) struct TypeNames(BTreeMap<u64, String>);

impl TypeNames {
    /// Takes note of a comment line `# label CODE NAME`; others say nothing.
    pub fn read(&mut self, line: &str) {
        let Some(words) = line.trim().strip_prefix('#').and_then(|l| l.trim_start().strip_prefix("label ")) else { return };
        if let Some((code, name)) = words.trim().split_once(char::is_whitespace)
            && let Ok(code) = code.parse()
        {
            self.0.insert(code, name.trim().to_owned());
        }
    }
}

/// The label code that a type column holds; 0 is none.
pub(crate) fn code(kind: f64) -> u64 {
    if kind.fract() == 0.0 && (1.0..LARGEST).contains(&kind) { kind as u64 } else { 0 }
}

/// Gives every link (parent, child) the label that the type of its child stands for.
pub(crate) fn name_links(lines: &mut Centerlines, types: &[u64], names: &TypeNames) {
    if names.0.is_empty() && !are_labels(lines, types) {
        return;
    }
    for row in 0..lines.links.len() {
        match types[lines.links[row][1] as usize] {
            0 => {}
            code => match names.0.get(&code) {
                Some(name) => lines.labels.set(row, name),
                None => lines.labels.set(row, &code.to_string()),
            },
        }
    }
}

/// Whether types that no comment names tell vessels apart: not where all are the same, nor where only the first and last points of
/// trees have one, which are landmarks then (iCafe).
fn are_labels(lines: &Centerlines, types: &[u64]) -> bool {
    let child = |link: &[u32; 2]| types[link[1] as usize];
    let Some(first) = lines.links.first().map(child) else { return false };
    if lines.links.iter().all(|link| child(link) == first) {
        return false;
    }
    let mut sides = vec![[false; 2]; types.len()];
    for [parent, child] in &lines.links {
        sides[*parent as usize][1] = true;
        sides[*child as usize][0] = true;
    }
    let mut inner = sides.iter().zip(types).filter(|(sides, _)| **sides == [true, true]).peekable();
    inner.peek().is_none() || inner.any(|(_, code)| *code != 0)
}

/// The types that stand for labels in a file.
pub(crate) struct TypeCodes(BTreeMap<String, u64>);

impl TypeCodes {
    /// Codes for labels: whole numbers as they are, the others from 16 on in order of appearance.
    pub fn of<'a>(labels: impl Iterator<Item = &'a str>) -> Self {
        let mut codes: BTreeMap<String, u64> = BTreeMap::new();
        let mut words = Vec::new();
        let mut taken = BTreeSet::new();
        for label in labels.map(clean).filter(|label| !label.is_empty()) {
            match label.parse::<u64>() {
                Ok(whole) if code(whole as f64) == whole && whole > 0 && whole.to_string() == label => {
                    taken.insert(whole);
                    codes.insert(label, whole);
                }
                _ => {
                    if codes.insert(label.clone(), 0).is_none() {
                        words.push(label);
                    }
                }
            }
        }
        let mut free = (FIRST_FREE..).filter(|code| !taken.contains(code));
        for (word, code) in words.into_iter().zip(&mut free) {
            codes.insert(word, code);
        }
        Self(codes)
    }

    /// The type for a label; 0 for none.
    pub fn code(&self, label: &str) -> u64 {
        self.0.get(&clean(label)).copied().unwrap_or(0)
    }

    /// Writes what the types stand for, in their order.
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        let by_code: BTreeMap<u64, &String> = self.0.iter().map(|(label, code)| (*code, label)).collect();
        by_code.iter().try_for_each(|(code, label)| writeln!(out, "# label {code} {label}"))
    }
}

/// A label on one line, without blanks around it.
pub(crate) fn clean(label: &str) -> String {
    label.replace(char::is_control, " ").trim().to_owned()
}
