//! The fingerprints of this version, and which experiments were made with others.
//!
//! - `fingerprints check` fails where `experiments/fingerprints.csv` is not this version's, where a stale experiment is not marked, and where a page cites one.
//! - `fingerprints mark` writes `experiments/fingerprints.csv`, the first lines of stale experiments, and the tables that pages take.
//! - `fingerprints record NAME [PART...]` says that an experiment was just made with this version; then as `mark`.

mod panel;
mod stale;

use std::fmt::Write as _;
use std::path::Path;
use std::{fs, process};

fn main() -> panel::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table = root.join("experiments/fingerprints.csv");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let now = panel::fingerprints(&panel::Made::default(), |_| true)?;
    let mut text = "fingerprint,digest\n".to_owned();
    for (name, digest) in &now {
        writeln!(text, "{name},{digest}")?;
    }
    match words[..] {
        ["check"] => {
            let mut faults = stale::faults(root, &now)?;
            if fs::read_to_string(&table)? != text {
                faults.push("experiments/fingerprints.csv is not this version's".to_owned());
            }
            if !faults.is_empty() {
                eprintln!("{}\n(`cargo run --release --example fingerprints -- mark` marks what is stale)", faults.join("\n"));
                process::exit(1);
            }
            return Ok(());
        }
        ["mark"] => {}
        ["record", experiment] => stale::record(root, &now, experiment, None)?,
        ["record", experiment, ref parts @ ..] => {
            parts.iter().try_for_each(|part| stale::record(root, &now, experiment, Some(part)))?;
        }
        _ => {
            eprintln!("expected check, mark, or record NAME [PART...]");
            process::exit(2);
        }
    }
    fs::write(table, text)?;
    stale::mark(root, &now)?;
    Ok(())
}
