//! The experiments against the program: which were made with answers that it no longer gives, and that no page cites those.

#[path = "../../experiments/fingerprints/panel.rs"]
mod panel;
#[path = "../../experiments/fingerprints/stale.rs"]
mod stale;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use panel::{Made, fingerprints};
use stale::{cited, faults, mark, record};
use willis::{Cut, Prior};

use crate::pages::root;

/// The gate itself. After a change of answers: `cargo run --release --example fingerprints -- mark`, or run the experiments again.
#[test]
fn stale_experiments_say_so_and_no_page_cites_them() {
    let now = fingerprints(&Made::default(), |_| true).expect("answers");
    assert_eq!(stale::known(root()).expect("a table"), now, "answers have moved; see CONTRIBUTING.md, \"Experiments\"");
    assert_eq!(faults(root(), &now).expect("read"), Vec::<String>::new());
}

/// Every folder of an experiment is in the table, and every fingerprint serves one.
#[test]
fn every_experiment_says_what_it_rests_on() {
    let parts = stale::parts(root()).expect("a table");
    let listed: BTreeSet<String> = parts.iter().map(|part| part.experiment.clone()).collect();
    let folders = fs::read_dir(root().join("experiments")).expect("a folder").map(|entry| entry.expect("an entry"));
    let folders = folders.filter(|entry| entry.path().join("README.md").is_file());
    assert_eq!(listed, folders.map(|entry| entry.file_name().into_string().expect("a name")).collect());
    let served: BTreeSet<&str> = parts.iter().flat_map(|part| part.rests_on.iter().map(String::as_str)).collect();
    let known = stale::known(root()).expect("a table");
    assert_eq!(served, known.iter().map(|(name, _)| name.as_str()).collect());
}

/// One number of a file that ships, changed by a tenth of itself and a tenth.
fn one_weight_more(source: &str, before: &str, folder: &Path) -> PathBuf {
    let text = fs::read_to_string(root().join(source)).expect("weights");
    let (head, rest) = text.rsplit_once(before).expect("the weight");
    let end = rest.find([',', ' ', '\n', '"', ']']).expect("an end");
    let value: f64 = rest[..end].parse().expect("a number");
    let path = folder.join(format!("{}.toml", checked_name(source)));
    fs::write(&path, format!("{head}{before}{}{}", value * 1.1 + 0.1, &rest[end..])).expect("written");
    path
}

fn checked_name(source: &str) -> String {
    source.rsplit('/').next().expect("a name").trim_end_matches(".toml").to_owned()
}

/// What moved of `before`.
fn moved<'a>(before: &[(String, String)], after: &'a [(String, String)]) -> Vec<&'a str> {
    after.iter().filter(|print| !before.contains(print)).map(|(name, _)| name.as_str()).collect()
}

/// A weight that is changed moves the fingerprints of the answers that are made with it, and none of the others.
#[test]
fn one_weight_moves_what_rests_on_it_and_nothing_else() {
    let here = tempfile::tempdir().expect("a folder");
    let shipped = Made::default();
    // Variants take longer than all others together; the test below asks them.
    let answers = |made: &Made| fingerprints(made, |name| name != "variants").expect("answers");
    let before = answers(&shipped);
    let weights = |source, number| one_weight_more(source, number, here.path());
    let joins = weights("crates/models/src/candidates/model/weights.toml", "calibration = [");
    let tubes = weights("crates/models/src/candidates/model/tubes.toml", "calibration = [");
    let skeletons = weights("crates/models/src/candidates/joins/skeleton.toml", "kind = \"skeleton\"\ncalibration = [\n    ");
    let contacts = weights("crates/models/src/contacts/contacts.toml", "\nweights = [\n    [\n    ");
    // What must move, and what may, for a decision need not flip.
    let cases: [(&str, Made, &[&str], &[&str]); 5] = [
        ("joins", Made { joins: Prior::File(joins), ..shipped.clone() }, &["joins"], &["kept"]),
        ("tubes", Made { tubes: Prior::File(tubes), ..shipped.clone() }, &["tubes"], &[]),
        ("skeletons", Made { skeletons: Prior::File(skeletons), ..shipped.clone() }, &["skeletons"], &["images", "repaired"]),
        ("contacts", Made { contacts: Cut::File(contacts), ..shipped.clone() }, &["contacts"], &["repaired"]),
        (
            "viscosity",
            Made { viscosity: 1.01 * shipped.viscosity, ..shipped.clone() },
            &["flow", "sampling"],
            &["paper", "modulation"],
        ),
    ];
    for (what, made, must, may) in cases {
        let after = answers(&made);
        let moved = moved(&before, &after);
        assert!(must.iter().all(|name| moved.contains(name)), "{what}: {moved:?}");
        assert!(moved.iter().all(|name| must.contains(name) || may.contains(name)), "{what}: {moved:?}");
    }
}

#[test]
fn one_weight_of_names_moves_the_variants() {
    let here = tempfile::tempdir().expect("a folder");
    let source = "crates/models/src/naming/arteries.toml";
    let answer =
        |path: PathBuf| fingerprints(&Made { names: Some(path), ..Made::default() }, |name| name == "variants").expect("answers");
    let changed = one_weight_more(source, "other_radius = [", here.path());
    let (before, after) = std::thread::scope(|scope| {
        let before = scope.spawn(|| answer(root().join(source)));
        let after = answer(changed);
        (before.join().expect("an answer"), after)
    });
    assert_eq!(moved(&before, &after), ["variants"]);
}

/// A project of two experiments and two pages.
fn project() -> tempfile::TempDir {
    let here = tempfile::tempdir().expect("a folder");
    let put = |name: &str, text: &str| {
        let path = here.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, text).expect("written");
    };
    put("experiments/depends.csv", "experiment,part,fingerprints\nyield,early,joins\nyield,late,joins flow\nspeed,,flow\n");
    put("experiments/README.md", "# Experiments\n\n<!-- overview:begin -->\n<!-- overview:end -->\n");
    put("experiments/yield/README.md", "# Yield\n\nText.\n");
    put("experiments/yield/short.md", "| found |\n|---|\n| 7 of 9 |\n");
    put("experiments/speed/README.md", "# Speed\n");
    put("README.md", "# Project\n\n`experiments/yield` counts.\n");
    put(
        "docs/src/page.md",
        "# Page\n\nOf `experiments/yield`:\n\n<!-- experiments/yield/short.md:begin -->\n<!-- experiments/yield/short.md:end -->\n\nIn 2026 we wrote.\n",
    );
    here
}

fn prints(joins: &str, flow: &str) -> [(String, String); 2] {
    [("joins", joins), ("flow", flow)].map(|(name, digest)| (name.to_owned(), digest.to_owned()))
}

#[test]
fn what_moved_is_named_until_it_is_marked_or_run_again() {
    let (here, old, new) = (project(), prints("a", "b"), prints("A", "b"));
    let here = here.path();
    let page = || fs::read_to_string(here.join("docs/src/page.md")).expect("a page");
    for experiment in ["yield", "speed"] {
        record(here, &old, experiment, None).expect("recorded");
    }
    mark(here, &old).expect("marked");
    assert_eq!(faults(here, &old).expect("read"), [""; 0]);
    assert!(page().contains("| 7 of 9 |"));

    // Another answer of joins: the experiment that rests on it is named, with what moved, and so is the page.
    let said = faults(here, &new).expect("read").join("\n");
    assert!(said.contains("experiments/yield is stale: moved joins") && !said.contains("speed"), "{said}");
    assert!(said.contains("docs/src/page.md gives figures of experiments/yield"), "{said}");

    // Marked, the first line says so, and the table is gone from the page.
    mark(here, &new).expect("marked");
    assert_eq!(faults(here, &new).expect("read"), [""; 0]);
    let readme = || fs::read_to_string(here.join("experiments/yield/README.md")).expect("a page");
    assert!(readme().starts_with("> **Stale.** Not recorded as made with the present answers: `joins`."), "{}", readme());
    assert!(!page().contains("7 of 9"));
    // A figure that a person types beside its name is found.
    fs::write(here.join("README.md"), "# Project\n\n`experiments/yield` finds\n7 of 9.\n").expect("written");
    assert_eq!(faults(here, &new).expect("read"), ["README.md gives figures of experiments/yield, which is stale"]);

    // One part run again is not all of it; both are, and every byte is back.
    record(here, &new, "yield", Some("late")).expect("recorded");
    mark(here, &new).expect("marked");
    assert!(readme().starts_with("> **Stale.**"));
    record(here, &new, "yield", Some("early")).expect("recorded");
    assert!(faults(here, &new).expect("read").join("\n").contains("experiments/yield is marked as stale, and is not"));
    mark(here, &new).expect("marked");
    assert_eq!(readme(), "# Yield\n\nText.\n");
    assert!(page().contains("| 7 of 9 |"));
    assert_eq!(faults(here, &new).expect("read"), [""; 0]);
    assert!(record(here, &new, "yield", Some("never")).is_err());
}

#[test]
fn a_page_cites_where_one_paragraph_has_the_name_and_a_figure() {
    let found = |page| cited(page, |name| name == "yield");
    assert_eq!(found("`experiments/yield` finds 7."), ["yield"]);
    assert_eq!(found("We find:\n\n| 7 |\n\n`experiments/yield` says more."), [""; 0]);
    assert_eq!(found("By `experiments/yield`:\n\n| 7 |"), ["yield"]);
    assert_eq!(found("`experiments/yield/7.py` counts.\n\n7 is another thing."), [""; 0]);
    assert_eq!(found("`experiments/other` finds 7."), [""; 0]);
}
