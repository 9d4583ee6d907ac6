//! The fingerprints of this version, and which experiments were made with others.
//!
//! - `fingerprints check` fails where `experiments/fingerprints.csv` is not this version's, where a stale experiment is not marked, and
//!   where a page cites one.
//! - `fingerprints mark` writes `experiments/fingerprints.csv`, the first lines of stale experiments, and the tables that pages take.
//! - `fingerprints record NAME [PART...]` says that an experiment was just made with this version; then as `mark`, with the fingerprints
//!   of others as they were last written.

mod panel;
mod stale;

use std::fmt::Write as _;
use std::path::Path;
use std::{fs, process};

use panel::{Made, fingerprints};

fn main() -> panel::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let now = match words[..] {
        ["check"] => {
            let now = fingerprints(&Made::default(), |_| true)?;
            let mut faults = stale::faults(root, &now)?;
            if stale::known(root)? != now {
                faults.push("experiments/fingerprints.csv is not this version's".to_owned());
            }
            if !faults.is_empty() {
                eprintln!("{}\n(`cargo run --release --example fingerprints -- mark` marks what is stale)", faults.join("\n"));
                process::exit(1);
            }
            return Ok(());
        }
        ["mark"] => fingerprints(&Made::default(), |_| true)?,
        ["record", experiment, ref parts @ ..] => {
            let own = stale::parts(root)?.into_iter().filter(|part| part.experiment == experiment);
            let wanted: Vec<String> = own.flat_map(|part| part.rests_on).collect();
            let fresh = fingerprints(&Made::default(), |name| wanted.iter().any(|on| on == name))?;
            let mut now = stale::known(root)?;
            for (name, digest) in &mut now {
                if let Some((_, found)) = fresh.iter().find(|(of, _)| of == name) {
                    digest.clone_from(found);
                }
            }
            if parts.is_empty() {
                stale::record(root, &now, experiment, None)?;
            }
            parts.iter().try_for_each(|part| stale::record(root, &now, experiment, Some(part)))?;
            now
        }
        _ => {
            eprintln!("expected check, mark, or record NAME [PART...]");
            process::exit(2);
        }
    };
    let mut table = "fingerprint,digest\n".to_owned();
    for (name, digest) in &now {
        writeln!(table, "{name},{digest}")?;
    }
    fs::write(root.join("experiments/fingerprints.csv"), table)?;
    stale::mark(root, &now)?;
    Ok(())
}
