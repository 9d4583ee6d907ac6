//! `willis bids`: a dataset of masks drawn here, through both levels; what stands there is held against the rules of BIDS, and by its
//! validator where `WILLIS_PYTHON` has one.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Map, Value, json};
use tempfile::TempDir;

use crate::command::{builder, folder, stderr, willis};
use std::borrow::Cow;
use willis::cli::internals::{BidsName, Filter, parse_filter};
use willis::internals::circle_of_willis::{FEEDERS, TERRITORIES};
use willis::internals::report::cohort::{CohortRow, bids_columns, describe, infer_figures, sidecar, write_tsv};

/// A mask of 36 x 14 x 7 voxels of half a millimetre as NIfTI-1: a tube of radius 2 along x with a gap of 4 voxels.
fn draw(path: &Path) {
    let mut bytes = vec![0_u8; 352];
    bytes[..4].copy_from_slice(&348_i32.to_le_bytes());
    let mut put = |at: usize, values: &[u8]| bytes[at..at + values.len()].copy_from_slice(values);
    let shape: Vec<u8> = [3_i16, 36, 14, 7, 1, 1, 1, 1].iter().flat_map(|n| n.to_le_bytes()).collect();
    put(40, &shape);
    // Eight bits without a sign.
    put(70, &[2, 0, 8, 0]);
    let spacing: Vec<u8> = [1_f32, 0.5, 0.5, 0.5].iter().flat_map(|x| x.to_le_bytes()).collect();
    put(76, &spacing);
    put(108, &352_f32.to_le_bytes());
    put(112, &1_f32.to_le_bytes());
    // Millimetres; an sform of half a millimetre along each axis.
    put(123, &[2]);
    put(254, &[1, 0]);
    for row in 0..3 {
        put(280 + 20 * row, &0.5_f32.to_le_bytes());
    }
    put(344, b"n+1\0");
    for n in 0..36 * 14 * 7 {
        let [x, y, z] = [n % 36, n / 36 % 14, n / (36 * 14)].map(f64::from);
        let tube = (4.0..=31.0).contains(&x) && (y - 6.0).hypot(z - 3.0) <= 2.0;
        bytes.push(u8::from(tube && !(16.0..20.0).contains(&x)));
    }
    fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    fs::write(path, bytes).expect("written");
}

/// A dataset with these files; those of `derivatives` are masks.
pub fn dataset(files: &[&str]) -> TempDir {
    let here = folder();
    let root = here.path().join("study");
    fs::create_dir_all(&root).expect("made");
    fs::write(root.join("dataset_description.json"), r#"{"Name": "Study", "BIDSVersion": "1.10.0"}"#).expect("written");
    for file in files {
        let path = root.join(file);
        if file.ends_with('/') {
            fs::create_dir_all(path).expect("made");
        } else {
            draw(&path);
        }
    }
    here
}

pub const A: &str = "derivatives/net/sub-01/ses-a/anat/sub-01_ses-a_acq-tof_desc-vessels_mask.nii";
const B: &str = "derivatives/net/sub-01/ses-b/anat/sub-01_ses-b_acq-tof_desc-vessels_mask.nii";
const TWO: &str = "derivatives/net/sub-02/anat/sub-02_label-Artery_dseg.nii";
const BRAIN: &str = "derivatives/net/sub-02/anat/sub-02_desc-brain_mask.nii";
const OUT: &str = "study/derivatives/willis";

/// The status, and what was said on standard error.
fn bids(here: &TempDir, arguments: &[&str]) -> (Option<i32>, String) {
    let output = willis(here.path(), &[&["bids", "study", OUT], arguments].concat());
    (output.status.code(), stderr(&output))
}

fn participant(here: &TempDir, more: &[&str]) -> String {
    let (status, said) = bids(here, &[&["participant", "-n", "64"], more].concat());
    assert_eq!(status, Some(0), "{said}");
    said
}

fn refused(here: &TempDir, arguments: &[&str], wanted: &[&str]) {
    let (status, said) = bids(here, arguments);
    let is_said = wanted.iter().all(|word| said.contains(word));
    assert!(status == Some(2) && said.lines().count() == 1 && is_said, "{arguments:?}: {status:?} {said}");
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a file")).expect("JSON")
}

/// The table of the group, by rows of cells, the header first.
fn table(here: &TempDir) -> Vec<Vec<String>> {
    let text = fs::read_to_string(here.path().join(OUT).join("group_willis.tsv")).expect("a table");
    text.lines().map(|line| line.split('\t').map(str::to_owned).collect()).collect()
}

/// What the validator of BIDS calls an error in a dataset; `None` without it.
fn faults(dataset: &Path) -> Option<String> {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
        return None;
    };
    let validator = Path::new(&python).with_file_name("bids-validator-deno");
    let Ok(output) = Command::new(&validator).args(["--format", "json"]).arg(dataset).output() else {
        eprintln!("skipped: no {}", validator.display());
        return None;
    };
    let report: Value = serde_json::from_slice(&output.stdout).expect("a report");
    let issues = report["issues"]["issues"].as_array().expect("issues");
    let faults = issues.iter().filter(|issue| issue["severity"] == "error").map(Value::to_string);
    Some(faults.collect::<Vec<_>>().join("\n"))
}

#[test]
fn both_levels_make_a_dataset_of_bids() {
    let here = dataset(&[A, B, TWO, BRAIN, "sub-03/anat/"]);
    let said = participant(&here, &[]);
    assert!(
        said.contains("3 masks of 2 participants, in derivatives/net: desc-vessels_mask, derivatives/net: label-Artery_dseg"),
        "{said}"
    );
    assert!(said.contains("no mask of vessels of sub-03") && said.contains("3 runs"), "{said}");
    let out = here.path().join(OUT);
    for (run, stem) in [
        ("sub-01_ses-a", "sub-01/ses-a/anat/sub-01_ses-a_acq-tof"),
        ("sub-01_ses-b", "sub-01/ses-b/anat/sub-01_ses-b_acq-tof"),
        ("sub-02", "sub-02/anat/sub-02_label-Artery"),
    ] {
        let same = |name: &str, of_run: &str| {
            let [one, two] =
                [out.join(name), out.join("runs").join(run).join(of_run)].map(|path| fs::read(path).expect("a file"));
            assert!(one == two && !one.is_empty(), "{name}");
        };
        for ending in ["graphml", "swc", "vtp"] {
            same(&format!("{stem}_desc-willis_topology.{ending}"), &format!("topology.{ending}"));
        }
        same(&format!("{run}.html"), "report.html");
        // What BIDS calls its sources are files of the dataset that the link leads to.
        let sidecar = json(&out.join(format!("{stem}_desc-willis_topology.json")));
        let source = sidecar["Sources"][0].as_str().and_then(|uri| uri.strip_prefix("bids:source:")).expect("a URI");
        let link = json(&out.join("dataset_description.json"))["DatasetLinks"]["source"].as_str().expect("a link").to_owned();
        assert!(out.join(link).join(source).is_file(), "{source}");
    }
    let about = json(&out.join("dataset_description.json"));
    assert_eq!((&about["DatasetType"], &about["GeneratedBy"][0]["Name"]), (&"derivative".into(), &"willis".into()));
    assert!(about["BIDSVersion"].is_string() && about["Name"].as_str().is_some_and(|name| name.contains("Study")));

    // Participants keep what is known of them, those without a run are left out.
    let known = "participant_id\tage\tinput\nsub-01\t61\tx\nsub-03\t44\ty\nsub-02\tn/a\tz\n";
    fs::write(here.path().join("study/participants.tsv"), known).expect("written");
    let (status, said) = bids(&here, &["group", "--n-cpus", "1", "--skip-bids-validator"]);
    assert!(status == Some(0) && said.contains("no run of sub-03"), "{said}");
    let kept = fs::read_to_string(out.join("participants.tsv")).expect("a table");
    assert_eq!(kept, known.replace("sub-03\t44\ty\n", ""));
    let rows = table(&here);
    let names: Vec<&[String]> = rows.iter().map(|row| &row[..2]).collect();
    assert_eq!(names, [["participant_id", "session_id"], ["sub-01", "ses-a"], ["sub-01", "ses-b"], ["sub-02", "n/a"]]);
    let sidecar = json(&out.join("group_willis.json"));
    for (at, column) in rows[0].iter().enumerate() {
        assert!(sidecar[column]["Description"].as_str().is_some_and(|about| !about.is_empty()), "{column}");
        assert!(rows.iter().all(|row| row.len() == rows[0].len() && !row[at].is_empty()), "{column}");
    }
    // The same figures as the run of the mask alone has.
    let at = |column: &str| rows[0].iter().position(|name| name == column).expect("a column");
    let record = json(&out.join("runs/sub-02/run.json"));
    assert_eq!(rows[3][at("candidates")], record["counts"]["candidates"].to_string());
    assert_eq!(rows[3][at("sha256")], record["input"]["sha256"].as_str().expect("a sum"));
    assert_eq!(rows[3][at("input")], TWO);
    let given = |column: &str| rows[1..].iter().map(|row| row[at(column)].as_str()).collect::<Vec<_>>();
    assert_eq!((given("age"), given("given_input")), (vec!["61", "61", "n/a"], vec!["x", "x", "z"]));
    let cohort = fs::read_to_string(out.join("group/cohort.csv")).expect("a table");
    assert!(cohort.lines().next().is_some_and(|header| header.contains(",age,given_input,")), "{cohort}");
    let page = fs::read_to_string(out.join("group/cohort.html")).expect("a page");
    assert!(page.contains("../runs/sub-02/report.html"));
    assert!(faults(&out).is_none_or(|faults| faults.is_empty()), "{:?}", faults(&out));
}

/// A table of one session each is one that the validator knows, as `phenotype/NAME.tsv`.
#[test]
fn the_table_is_one_of_bids() {
    let here = dataset(&[TWO, "derivatives/net/sub-01/anat/sub-01_desc-vessels_mask.nii"]);
    participant(&here, &[]);
    assert_eq!(bids(&here, &["group"]).0, Some(0));
    assert_eq!(table(&here)[0][..2], ["participant_id", "input"]);
    let out = here.path().join(OUT);
    fs::create_dir(out.join("phenotype")).expect("made");
    for ending in ["tsv", "json"] {
        fs::copy(out.join(format!("group_willis.{ending}")), out.join(format!("phenotype/willis.{ending}"))).expect("copied");
    }
    // What a group leaves that is killed when its table is whole, the next clears, which has nothing to write.
    let left = out.join(".willis-group_willis.tsv");
    fs::create_dir(&left).and_then(|()| fs::write(left.join("lock"), "")).expect("made");
    assert_eq!(bids(&here, &["group"]).0, Some(0));
    assert!(!left.exists());
    assert!(faults(&out).is_none_or(|faults| faults.is_empty()), "{:?}", faults(&out));
    // A test of the test: the validator sees a fault.
    fs::write(out.join("phenotype/willis.tsv"), "kept\n1\n").expect("written");
    assert!(faults(&out).is_none_or(|faults| faults.contains("TSV_COLUMN_MISSING")), "{:?}", faults(&out));
}

#[test]
fn participants_are_made_one_by_one_and_never_twice() {
    let here = dataset(&[A, B, TWO]);
    let out = here.path().join(OUT);
    let said = participant(&here, &["--participant-label", "sub-02"]);
    assert!(said.contains("1 mask of 1 participant") && !out.join("sub-01").exists(), "{said}");
    let of_two = fs::read(out.join("runs/sub-02/run.json")).expect("a run");
    let said = participant(&here, &["--participant_label", "01", "02", "--session-label", "b"]);
    assert!(said.contains("1 mask of 1 participant") && !out.join("runs/sub-01_ses-a").exists(), "{said}");
    // By another way to the same files.
    let arguments = ["bids", ".", "derivatives/willis", "participant", "-n", "64"];
    let output = willis(&here.path().join("study"), &arguments);
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("2 of 3 runs done already"), "{said}");
    assert_eq!(fs::read(out.join("runs/sub-02/run.json")).expect("a run"), of_two);
    // The line of a run makes its files again.
    let command = json(&out.join("runs/sub-02/run.json"))["command"].as_str().expect("a command").to_owned();
    assert_eq!(command, format!("willis infer study/{TWO} -n 64 -o again"));
    let again: Vec<&str> = command.split(' ').skip(1).collect();
    assert!(willis(here.path(), &again).status.success());
    let [one, two] = ["again", "study/derivatives/willis/runs/sub-02"].map(|run| here.path().join(run).join("edges.csv"));
    assert_eq!(fs::read(one).expect("a table"), fs::read(two).expect("a table"));

    // Names of BIDS that are lost come back without a run.
    fs::remove_file(out.join("sub-02.html")).expect("removed");
    participant(&here, &[]);
    assert!(out.join("sub-02.html").exists());
    refused(&here, &["participant", "-n", "128"], &["sub-01_ses-a", "samples was 64, now 128", "--force"]);
    refused(&here, &["participant", "-n", "64", "--landmarks", "auto"], &["landmarks was not given, now \"auto\""]);
    assert_eq!(fs::read(out.join("runs/sub-02/run.json")).expect("a run"), of_two);
    // One that lacks a table is not done.
    fs::remove_file(out.join("runs/sub-02/edges.csv")).expect("removed");
    let said = participant(&here, &["--participant-label", "02"]);
    assert!(!said.contains("done already") && out.join("runs/sub-02/edges.csv").is_file(), "{said}");
    let (status, said) = bids(&here, &["participant", "-n", "128", "--participant-label", "02", "--force"]);
    assert!(status == Some(0), "{said}");
    refused(&here, &["group"], &["samples 128, where", "has 64"]);
    let (status, said) = bids(&here, &["group", "--participant-label", "02"]);
    assert!(status == Some(0) && table(&here).len() == 2, "{said}");
}

/// Jobs of a cluster begin at once. One that is killed before it wrote what says whose the dataset is leaves none in the way.
#[test]
fn participants_may_begin_at_the_same_time() {
    let here = dataset(&[A, B, TWO]);
    for round in 0..4 {
        let out = format!("{OUT}{round}");
        let begin = |session: &&[&str]| {
            let words = [&["bids", "study", &out, "participant", "-n", "64", "-q"], *session].concat();
            builder(here.path()).args(words).stderr(Stdio::piped()).spawn().expect("the binary runs")
        };
        let jobs: [&[&str]; 3] = [&["--participant-label", "02"], &["--session-label", "a"], &["--session-label", "b"]];
        let jobs: Vec<_> = jobs.iter().map(begin).collect();
        for job in jobs {
            let output = job.wait_with_output().expect("ended");
            assert!(output.status.success(), "{}", stderr(&output));
        }
    }
    fs::create_dir_all(here.path().join(OUT).join(".willis-dataset_description.json")).expect("made");
    participant(&here, &[]);
}

#[test]
fn a_mask_without_an_answer_is_a_row() {
    let here = dataset(&[A, TWO]);
    fs::write(here.path().join("study").join(A), b"no image").expect("written");
    let (status, said) = bids(&here, &["participant", "-n", "64"]);
    assert!(status == Some(1) && said.contains("1 of 2 subjects failed"), "{said}");
    assert_eq!(bids(&here, &["group"]).0, Some(0));
    let rows = table(&here);
    let at = |column: &str| rows[0].iter().position(|name| name == column).expect("a column");
    assert_eq!([&rows[1][at("status")], &rows[2][at("status")]], ["failed", "ok"]);
    assert!(rows[1][at("error")].contains("sub-01_ses-a") && rows[1][at("kept")] == "n/a" && rows[2][at("error")] == "n/a");
    // Mended, it is made; the other is not made again.
    draw(&here.path().join("study").join(A));
    let said = participant(&here, &[]);
    assert!(said.contains("1 of 2 runs done already") && here.path().join(OUT).join("sub-01_ses-a.html").exists(), "{said}");
}

#[test]
fn a_run_whose_files_find_no_place_has_failed_and_is_completed() {
    let here = dataset(&[TWO]);
    let out = here.path().join(OUT);
    let [page, about] = ["sub-02.html", "sub-02/anat/sub-02_label-Artery_desc-willis_topology.json"].map(|name| out.join(name));
    participant(&here, &[]);
    fs::remove_file(&page).and(fs::create_dir(&page)).expect("made");
    let (status, said) = bids(&here, &["participant", "-n", "64", "--force"]);
    assert!(status == Some(1) && said.contains("sub-02.html") && said.contains("1 of 1"), "{status:?} {said}");
    fs::remove_dir(&page).expect("removed");
    let said = participant(&here, &[]);
    assert!(said.contains("1 of 1 run done already") && page.is_file() && about.is_file(), "{said}");
    // What says that all is there is put last.
    fs::remove_file(&page).and(fs::remove_file(&about)).expect("removed");
    fs::create_dir(&about).expect("made");
    assert_ne!(bids(&here, &["participant", "-n", "64"]).0, Some(0));
    assert!(!page.exists());
}

#[test]
fn masks_are_found_by_what_their_names_say() {
    // The entities of an angiogram alone are enough, those of two images are not.
    let plain = "derivatives/net/sub-01/anat/sub-01_acq-tof_mask.nii";
    let angiogram = "sub-01/anat/sub-01_acq-tof_angio.nii";
    participant(&dataset(&[plain, angiogram]), &[]);
    let none = ["study: no mask of vessels", "derivatives/net/sub-01/anat/sub-01_acq-tof_mask.nii does not say so"];
    refused(&dataset(&[plain, angiogram, "sub-01/anat/sub-01_acq-tof_T1w.nii"]), &["participant"], &none);
    refused(&dataset(&[plain]), &["participant"], &none);
    // A mask of a brain is one only for a person who says so.
    let here = dataset(&[BRAIN, A]);
    refused(&here, &["participant", "--participant-label", "02"], &["no mask of vessels of sub-02", "--filter desc=brain"]);
    assert!(participant(&here, &["--filter", "desc=brain"]).contains("desc-brain_mask"));
    // Masks of the dataset itself.
    let here = dataset(&["sub-01/anat/sub-01_desc-arteries_mask.nii"]);
    assert!(participant(&here, &[]).contains("BIDS_DIR: desc-arteries_mask"));
    // Nothing that willis wrote is read as a mask, wherever it lies.
    let output = willis(here.path(), &["bids", "study", "study/derivatives/second", "participant", "-n", "64", "-q"]);
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn one_of_several_masks_is_chosen() {
    let one = "derivatives/net/sub-01/anat/sub-01_run-1_desc-vessels_mask.nii";
    let two = "derivatives/net/sub-01/anat/sub-01_run-2_desc-vessels_mask.nii";
    let here = dataset(&[one, two]);
    refused(&here, &["participant"], &["2 masks could be meant for sub-01", one, two, "--filter run=1"]);
    assert!(!here.path().join(OUT).exists());
    participant(&here, &["--filter", "run=1"]);
    refused(&here, &["participant", "--filter", "run=2", "-n", "64"], &["the run of another mask", one, "--force"]);
    participant(&here, &["--filter", "run=2", "--force"]);
    let anatomy = here.path().join(OUT).join("sub-01/anat");
    assert!(anatomy.join("sub-01_run-2_desc-willis_topology.vtp").exists());
    assert!(!anatomy.join("sub-01_run-1_desc-willis_topology.vtp").exists());
    let copy = "derivatives/other/sub-01/anat/sub-01_desc-vessels_mask.nii";
    let here = dataset(&[copy, "derivatives/net/sub-01/anat/sub-01_desc-vessels_mask.nii"]);
    refused(&here, &["participant"], &["--filter pipeline=net"]);
    assert!(participant(&here, &["--filter", "pipeline=other"]).contains("derivatives/other"));
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let here = dataset(&[TWO]);
    participant(&here, &[]);
    for (table, wanted) in [
        ("age\n61\n", ["participants.tsv:1: ", "participant_id"]),
        ("participant_id\tage\nsub-02\n", ["participants.tsv:2: ", "expected 2, as in the header"]),
    ] {
        fs::write(here.path().join("study/participants.tsv"), table).expect("written");
        refused(&here, &["group"], &wanted);
    }
    let here = dataset(&[A, TWO]);
    let no_such = ["--participant-label sub-07: no such folder; there are sub-01, sub-02"];
    refused(&here, &["participant", "--participant-label", "07"], &no_such);
    refused(&here, &["participant", "--session-label", "c"], &["--session-label ses-c: no such folder; there are ses-a"]);
    refused(&here, &["participant", "--filter", "vessels"], &["--filter", "desc=vessels"]);
    refused(&here, &["participant", "--epsilon", "0.2,0.5"], &["--epsilon 0.2,0.5"]);
    refused(&here, &["group"], &["no run of a participant", "participant first"]);
    refused(&here, &["both"], &["both", "participant, group"]);
    assert!(!here.path().join(OUT).exists());
    let with = |source: &str, out: &str, wanted: &str| {
        let output = willis(here.path(), &["bids", source, out, "participant"]);
        let said = stderr(&output);
        assert!(output.status.code() == Some(2) && said.lines().count() == 1 && said.contains(wanted), "{said}");
    };
    with("absent", "out", "absent: no such folder");
    with("study/derivatives/net/sub-01", "out", "no participant");
    with("study", "study", "is BIDS_DIR");
    with("study", "study/derivatives", "holds something else");
    participant(&here, &["--participant-label", "02"]);
    refused(&here, &["group", "--participant-label", "01"], &["--participant-label sub-01: no such folder; there are sub-02"]);
}

fn row(figures: Result<Vec<(Cow<'static, str>, Value)>, String>) -> CohortRow {
    CohortRow {
        subject: "sub-01".into(),
        input: "a\tb".into(),
        sha256: String::new(),
        covariates: Vec::new(),
        page: None,
        figures,
    }
}

/// A record with everything that makes columns: a circle with probabilities, and what is lost with each feeder.
#[test]
fn every_column_is_described() {
    let feeders = FEEDERS.map(|feeder| (feeder.to_string(), json!({ "takes_over": "AComm", "residual": {} })));
    let fed = TERRITORIES.map(|territory| (territory.to_string(), json!({ "shares": {}, "arrival_ms": {} })));
    let record =
        json!({ "phenotype": { "probabilities": {} }, "collateral": Map::from_iter(feeders), "supply": Map::from_iter(fed) });
    let columns = bids_columns(&[row(Ok(infer_figures(&record)))], &[("sub-01".into(), Some("ses-a".into()))]);
    assert!(columns.len() > 50, "{}", columns.len());
    let sidecar = sidecar(&columns);
    for column in &columns {
        let about = sidecar[&*column.name]["Description"].as_str().unwrap_or_default();
        assert!(about.ends_with('.'), "{} is not described", column.name);
    }
    assert_eq!(describe("p_L-M1"), None);
    assert_eq!(describe("L-A1_without_L-M1"), None);
}

#[test]
fn a_table_has_no_tab_in_a_cell_and_no_empty_cell() {
    let rows = [row(Ok(vec![("kept".into(), json!(f64::NAN)), ("margin".into(), json!(-0.5))])), row(Err("no".into()))];
    let columns = bids_columns(&rows, &[("sub-01".into(), None), ("sub-02".into(), None)]);
    let mut table = Vec::new();
    write_tsv(&mut table, &columns).expect("written");
    let wanted = "participant_id\tinput\tsha256\tstatus\terror\tkept\tmargin\n\
        sub-01\ta b\tn/a\tok\tn/a\tn/a\t-0.5\n\
        sub-02\ta b\tn/a\tfailed\tno\tn/a\tn/a\n";
    assert_eq!(String::from_utf8(table).expect("text"), wanted);
}

#[test]
fn a_name_is_entities_and_a_suffix() {
    let named = BidsName::parse("sub-01_ses-a_acq-tof_desc-CoWVessels_mask.nii.gz").expect("a name");
    assert_eq!((named.value("acq"), named.value("run"), &*named.suffix), (Some("tof"), None, "mask"));
    assert!(named.says_vessels());
    assert!(!BidsName::parse("sub-01_acq-angio_desc-brain_mask.nii").expect("a name").says_vessels());
    for name in ["sub-01_mask.json", "mask.nii.gz", "sub01_mask.nii.gz"] {
        assert_eq!(BidsName::parse(name), None, "{name}");
    }
}

#[test]
fn a_filter_is_a_pair() {
    assert_eq!(parse_filter("space="), Ok(Filter { key: "space".into(), value: String::new() }));
    for text in ["desc", "=a", "desc=a/b", "desc=a=b"] {
        assert!(parse_filter(text).is_err(), "{text}");
    }
}
