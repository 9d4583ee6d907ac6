//! The model of skeletons as a person fits it.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;

use crate::command::{folder, stderr, willis};
use crate::refused::contents;
use willis::internals::candidates::joins::model::JoinModel;

#[test]
fn a_model_of_skeletons_is_fitted_and_the_threads_do_not_matter() {
    let here = folder();
    for seed in 0..6 {
        let case = here.path().join(format!("cases/t{seed}"));
        fs::create_dir_all(&case).expect("a folder");
        let (output, seed) = (case.join("fragments.swc").display().to_string(), seed.to_string());
        let made = willis(here.path(), &["phantom", "tree", "--break", "--seed", &seed, "-o", &output]);
        assert!(made.status.success(), "{}", stderr(&made));
        // The truth as a table of places.
        let truth = fs::read_to_string(case.join("fragments.truth.json")).expect("a truth");
        let truth: serde_json::Value = serde_json::from_str(&truth).expect("JSON");
        let swc = fs::read_to_string(case.join("fragments.swc")).expect("a file");
        let place = |id: &serde_json::Value| {
            let is = |line: &&str| line.split_whitespace().next() == Some(&id.to_string());
            swc.lines().find(is).expect("a point").split_whitespace().skip(2).take(3).collect::<Vec<_>>().join(",")
        };
        let mut links = String::from("ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm\n");
        for gap in truth["breaks"].as_array().expect("breaks") {
            writeln!(links, "{},{}", place(&gap["ids"][0]), place(&gap["ids"][1])).expect("memory");
        }
        fs::write(case.join("links.csv"), links).expect("a file");
        fs::remove_file(case.join("fragments.truth.json")).expect("a file");
    }
    let train = |threads: &str, output: &str| {
        let arguments = ["train", "cases", "-o", output, "--model", "skeleton", "--folds", "0", "--threads", threads];
        let done = willis(here.path(), &arguments);
        assert!(done.status.success(), "{}", stderr(&done));
    };
    train("1", "one/m.toml");
    train("2", "two/m.toml");
    assert_eq!(contents(&here.path().join("one")), contents(&here.path().join("two")));
    let model = JoinModel::read(&fs::read_to_string(here.path().join("one/m.toml")).expect("a file")).expect("a model");
    assert_eq!((model.provenance.cases, model.provenance.subjects), (6, 6));
    let infer = ["infer", "cases/t0/fragments.swc", "-o", "out", "--prior", "one/m.toml", "-n", "1"];
    let done = willis(here.path(), &infer);
    assert!(done.status.success(), "{}", stderr(&done));
    // Fitted to this very case, it finds most of its gaps.
    let links = fs::read_to_string(here.path().join("cases/t0/links.csv")).expect("a table").lines().count() - 1;
    let mut table = csv::Reader::from_path(here.path().join("out/edges.csv")).expect("a table");
    let rows = table.deserialize::<HashMap<String, String>>().map(|row| row.expect("a row"));
    let kept = rows.filter(|row| row["origin"] == "candidate" && row["kept"] == "1").count();
    assert!(2 * kept >= links, "{kept} of {links}");
}
