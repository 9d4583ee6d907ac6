//! What a person hesitates at: a refusal says what to type, a node is known by every name it may have, a note reaches the reader.

use std::fs;
use std::path::Path;

use crate::command::{builder, data, folder, stderr, willis};
use crate::refused::refused;
use serde_json::Value;
use willis::InferOptions;
use willis::cli::words::infer;
use willis::internals::support::suggestions::{did_you_mean, nearest};

const LINE: &[u8] = b"1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n3 0 2 0 0 1 2\n";

fn record(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("run.json")).expect("a record")).expect("JSON")
}

fn ids(record: &Value, role: &str) -> Vec<String> {
    let all = record["boundary_conditions"].as_array().expect("conditions");
    all.iter().filter(|c| c["role"] == role).map(|c| c["id"].as_str().expect("an id").to_owned()).collect()
}

#[test]
fn a_figure_that_cannot_be_read_is_answered_with_one_that_can() {
    let infer = |more: &[&'static str]| [&["infer", "a.swc", "-o", "out"], more].concat();
    let cases: [(&[&str], &[&str]); 16] = [
        (&["--seed", "-1"], &["'-1' for '--seed <SEED>'", "expected a whole number", "see willis help infer"]),
        (&["-n", "many"], &["'many'", "such as 1000 or 1e6"]),
        (&["-n", "1.5"], &["'1.5'", "expected a whole number"]),
        (&["-n", "1e16"], &["'1e16'", "is too large"]),
        (&["--epsilon", "50%"], &["'50%'", "such as 0.5"]),
        (&["--inlte", "5"], &["'--inlte' found; did you mean '--inlet'?"]),
        (&["--keep", "quantile"], &["--keep \"quantile\": needs a figure, as in quantile=0.8"]),
        (&["--keep", "quantile=80"], &["--keep \"quantile=80\": expected a number from 0 to 1, such as quantile=0.8"]),
        (&["--keep", "frequency=10%"], &["such as frequency=0.1"]),
        (&["--spacing", "15mm"], &["--spacing 15: goes with --units voxel"]),
        (&["--units", "voxel", "--spacing", "-2"], &["--spacing -2: expected one or three positive numbers"]),
        (&["--units", "voxel", "--spacing", "1,2"], &["--spacing 1,2: expected one or three"]),
        (&["spacing", "15mm"], &["\"spacing\": no such file; did you mean --spacing?"]),
        (&["--epsilon", "0.5", "0.3"], &["\"0.3\": no such file", "commas"]),
        (&["--outlets", "murray=x"], &["murray=700mL/min"]),
        (&["--threads", "-2"], &["'-2'", "expected a whole number"]),
    ];
    for (more, words) in cases {
        refused(&[("a.swc", LINE)], &infer(more), words);
    }
    refused(&[], &["help", "clasify"], &["did you mean \"classify\"?"]);
    refused(&[], &["clasify"], &["did you mean 'classify'?"]);
    let here = folder();
    for words in [&["--outlets", "murray=x"][..], &["--seed", "-1"], &["--keep", "quantile"]] {
        let said = stderr(&willis(here.path(), &infer(words)));
        assert!(!said.contains("did you mean") && !said.contains("tip:"), "{said}");
    }
}

#[test]
fn a_whole_number_and_a_spacing_may_be_typed_in_two_ways() {
    let here = folder();
    let input = data("broken-circle-of-willis.swc");
    let edges = |more: &[&str]| {
        let output = willis(here.path(), &[&["infer", &input, "-o", "out", "--force", "-q"], more].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        fs::read(here.path().join("out/edges.csv")).expect("edges")
    };
    assert!(edges(&["-n", "1e2"]) == edges(&["-n", "100"]));
    let voxel = |spacing| edges(&["-n", "64", "--units", "voxel", "--spacing", spacing]);
    assert!(voxel("500um") == voxel("0.5") && voxel("0.5") != voxel("0.25"));
}

#[test]
fn the_command_alone_shows_its_help() {
    let here = folder();
    let output = builder(here.path()).output().expect("runs");
    let said = stderr(&output);
    assert!(output.status.code() == Some(2) && output.stdout.is_empty(), "{said}");
    assert!(said.contains("Usage: willis") && said.contains("classify"), "{said}");
}

#[test]
fn help_names_no_option_that_the_command_refuses() {
    let here = folder();
    for (name, shown) in [("infer", true), ("candidates", true), ("simulate", false), ("classify", false), ("convert", false)] {
        let help = String::from_utf8(willis(here.path(), &["help", name]).stdout).expect("UTF-8");
        assert_eq!(help.contains("--observed"), shown, "{name}");
        let (arguments, options) = (help.find("Arguments:"), help.find("Options:"));
        assert!(arguments.is_some() && arguments < options, "{name}: {help}");
    }
}

#[test]
fn a_folder_is_answered_with_a_pattern() {
    let here = folder();
    let scans = here.path().join("scans");
    fs::create_dir(&scans).expect("made");
    fs::write(scans.join("a.swc"), fs::read(data("broken-circle-of-willis.swc")).expect("data")).expect("written");
    let no = |arguments: &[&str], word: &str| {
        let output = willis(here.path(), arguments);
        assert!(output.status.code() == Some(2) && stderr(&output).contains(word), "{word}: {}", stderr(&output));
    };
    no(&["infer", "scans/", "-o", "out"], "a folder; expected a file, or a pattern such as 'scans/*.swc'");
    assert!(willis(here.path(), &["infer", "scans/*", "-o", "cohort", "-q", "-n", "64"]).status.success());
    no(&["simulate", "cohort", "-o", "out"], "cohort");
    no(&["infer", "cohort", "-o", "out"], "cohort: a cohort; give its subjects, as 'cohort/*'");
    no(&["convert", "cohort", "out.csv"], "cohort: a cohort; give one of its subjects, which are folders in it");
    no(&["infer", "cohort/a", "-o", "out"], "topology.graphml");
    // As a shell hands it over that expands the pattern itself: what stands beside the subjects is none.
    let all = ["infer", "scans/a.swc", "cohort/cohort.csv", "cohort/cohort.html", "cohort/cohort.json"];
    let output = willis(here.path(), &[&all[..], &["-o", "again", "-n", "64"]].concat());
    assert!(output.status.success() && stderr(&output).contains("again: 1 subject"), "{}", stderr(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn a_place_that_takes_no_folder_is_said_to_be_one() {
    refused(&[("a.swc", LINE)], &["infer", "a.swc", "-o", "/proc/out"], &["nothing can be written into /proc"]);
    let here = folder();
    let said = stderr(&willis(here.path(), &["infer", "a.swc", "-o", "/proc/out"]));
    assert!(!said.contains("not found"), "{said}");
}

#[test]
fn a_node_that_is_none_is_answered_with_those_that_are() {
    let infer = |spec: &'static str| ["infer", "a.swc", "-o", "out", "--inlet", spec];
    let input: [(&str, &[u8]); 1] = [("a.swc", LINE)];
    refused(&input, &infer("2"), &["--inlet \"2\": no node, but a point inside the vessel from 1 to 3"]);
    refused(&input, &infer("1,3"), &["looks like 2 nodes; give one at a time: --inlet 1 --inlet 3"]);
    refused(&input, &infer("0,0,30"), &["the nearest node, 1, is 30.0 mm away; expected a position within 20 mm"]);
    // Three numbers are a position, and only one far from every node may be three nodes.
    let far: [(&str, &[u8]); 1] = [("a.swc", b"1 0 90 0 0 1 -1\n2 0 91 0 0 1 1\n3 0 92 0 0 1 2\n4 0 91 5 0 1 2\n")];
    refused(&far, &infer("1,3,4"), &["looks like 3 nodes", "--inlet 1 --inlet 3 --inlet 4"]);
    let here = folder();
    fs::write(here.path().join("a.swc"), LINE).expect("written");
    let output = willis(here.path(), &["infer", "a.swc", "-o", "out", "--inlet", "0,0,19"]);
    assert!(output.status.success() && stderr(&output).contains("is node 1 (19.000 mm"), "{}", stderr(&output));
    let twice: [(&str, &[u8]); 2] = [("a.swc", LINE), ("bc.csv", b"node,kind\n1,inlet\n1,ground\n")];
    refused(&twice, &["infer", "a.swc", "-o", "out", "--bc", "bc.csv"], &["bc.csv:3:", "is node 1, as line 2 is"]);
}

/// Three lines of a VTK file: a trunk, one that runs along it from the same source and leaves, and one that begins where the trunk ends.
fn traced() -> String {
    let trunk = (0..=10).map(|x| [f64::from(x), 0.0]);
    let second = (0..=5).map(|x| [f64::from(x), 0.0]).chain((1..=6).map(|y| [5.0 + f64::from(y), 2.0 * f64::from(y)]));
    let third = (10..=14).map(|x| [f64::from(x), 0.0]);
    let lines: Vec<Vec<[f64; 2]>> = vec![trunk.collect(), second.collect(), third.collect()];
    let points: Vec<[f64; 2]> = lines.concat();
    let n = points.len();
    let mut first = 0;
    let cell = |line: &Vec<[f64; 2]>| {
        let rows: Vec<String> = (first..first + line.len()).map(|row| row.to_string()).collect();
        first += line.len();
        format!("{} {}\n", line.len(), rows.join(" "))
    };
    let cells: String = lines.iter().map(cell).collect();
    let places: Vec<String> = points.iter().map(|[x, y]| format!("{x} {y} 0")).collect();
    format!(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS {n} double\n{}\nLINES {} {}\n{cells}\
         POINT_DATA {n}\nSCALARS Radius double 1\nLOOKUP_TABLE default\n{}",
        places.join("\n"),
        lines.len(),
        n + lines.len(),
        "1\n".repeat(n)
    )
}

#[test]
fn every_point_that_was_made_one_with_a_node_names_it() {
    let here = folder();
    fs::write(here.path().join("a.vtk"), traced()).expect("written");
    // Row 11 is the source of the second line, which lies on row 0; row 16 lies where it leaves the trunk, on row 5.
    for (row, node) in [("0", "0"), ("11", "0"), ("16", "5")] {
        let output = willis(here.path(), &["infer", "a.vtk", "-o", "out", "--force", "--inlet", row]);
        assert!(output.status.success(), "{row}: {}", stderr(&output));
        assert_eq!(ids(&record(&here.path().join("out")), "inlet"), [node], "{row}: {}", stderr(&output));
        let said = stderr(&output).contains(&format!("{row} is node {node} (merged with it)"));
        assert_eq!(said, row != node, "{}", stderr(&output));
    }
    // Welded: two lines that end in one place, and a third from there.
    let swc = "1 0 0 0 0 1 -1\n2 0 9 0 0 1 1\n3 0 9 0 0 1 -1\n4 0 9 9 0 1 3\n5 0 9 0 0 1 -1\n6 0 9 0 9 1 5\n";
    fs::write(here.path().join("b.swc"), swc).expect("written");
    let output = willis(here.path(), &["simulate", "b.swc", "-o", "flow", "--inlet", "5"]);
    assert!(output.status.success() && stderr(&output).contains("5 is node 2 (merged with it)"), "{}", stderr(&output));
}

#[test]
fn a_default_radius_goes_with_graphs_and_is_told() {
    let table: &[u8] = b"node_a,node_b,length_mm\na,b,10\nb,c,20\n";
    refused(&[("e.csv", table)], &["infer", "e.csv", "-o", "out"], &["e.csv:2", "no radius_mm", "--default-radius"]);
    let here = folder();
    fs::write(here.path().join("e.csv"), table).expect("written");
    let output = willis(here.path(), &["infer", "e.csv", "-o", "out", "--default-radius", "500um"]);
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("2 candidate vessels, radius 0.500 mm"), "{said}");
    let notes = record(&here.path().join("out"))["notes"].to_string();
    assert!(notes.contains("2 vessels without any radius: took `default_radius`, 0.5 mm"), "{notes}");
    assert!(!notes.contains("NaN"), "{notes}");
    // Nothing is interpolated where no vessel has a radius.
    fs::write(here.path().join("a.swc"), "1 0 0 0 0 0 -1\n2 0 1 0 0 0 1\n3 0 2 0 0 0 2\n").expect("written");
    let output = willis(here.path(), &["simulate", "a.swc", "-o", "flow", "--default-radius", "1"]);
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("took --default-radius, 1 mm") && !said.contains("interpolated"), "{said}");
}

#[test]
fn a_cohort_tells_each_note_once() {
    let here = folder();
    for (name, more) in [("a", ""), ("b", "7 0 20 0 0 1 -1\n8 0 20 9 0 1 7\n9 0 20 9 0 1 -1\n10 0 30 9 0 1 9\n")] {
        let swc = "1 0 0 0 0 1 -1\n2 0 9 0 0 1 1\n3 0 9 0 0 1 -1\n4 0 9 9 0 1 3\n5 0 9 0 0 1 -1\n6 0 9 0 9 1 5\n";
        fs::write(here.path().join(format!("{name}.swc")), format!("{swc}{more}")).expect("written");
    }
    let output = willis(here.path(), &["infer", "a.swc", "b.swc", "-o", "out", "-n", "64"]);
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("… points coinciding with another: merged with it (2 subjects)"), "{said}");
}

#[test]
fn convert_names_the_results_that_are_lost() {
    let here = folder();
    assert!(willis(here.path(), &["infer", &data("broken-circle-of-willis.swc"), "-o", "out", "-q"]).status.success());
    for input in ["out/topology.graphml", "out/topology.vtp", "out/edges.csv"] {
        let output = willis(here.path(), &["convert", input, "a.swc", "--force"]);
        let said = stderr(&output);
        let line = said.lines().find(|line| line.contains("lost") && line.contains("the columns ")).unwrap_or_default();
        assert!(output.status.success() && line.contains("likelihood") && line.contains("frequency"), "{input}: {said}");
        assert!(!line.contains("radius") && !line.contains("x_mm") && !line.contains("node_a"), "{line}");
    }
    let output = willis(here.path(), &["convert", &data("broken-circle-of-willis.swc"), "b.vtp"]);
    assert!(!stderr(&output).contains("the columns"), "{}", stderr(&output));
}

#[test]
fn the_nearest_name_comes_first_and_only_a_near_one_is_offered() {
    let labels = ["R-M1", "L-M1", "BA", "L-A1", "L-M1"];
    assert_eq!(nearest("L-MM1", labels)[..2], ["L-M1", "L-A1"]);
    assert_eq!(did_you_mean("l-m1", labels), "did you mean \"L-M1\"? ");
    assert_eq!(did_you_mean("mmhg", ["Pa", "mmHg"]), "did you mean \"mmHg\"? ");
    // One of two letters is half of the name, and nothing is near to nothing.
    for far in ["VA", "basilar", "", " "] {
        assert_eq!(did_you_mean(far, labels), "", "{far}");
    }
    assert_eq!(did_you_mean("x", []), "");
    // A separator that is left out is no difference.
    let carotids = ["L-VA", "BA", "L-A1", "L-ICA II", "L-ICA I", "R-ICA I"];
    assert_eq!(nearest("LICA", carotids)[..2], ["L-ICA I", "L-ICA II"]);
    assert_eq!(did_you_mean("LICA", carotids), "did you mean \"L-ICA I\"? ");
    assert_eq!(did_you_mean("found_outlets", ["found-outlets"]), "did you mean \"found-outlets\"? ");
}

fn words_of(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

#[test]
fn words_mean_what_the_command_means() {
    let (options, line) = infer(Path::new("a b.swc"), &words_of("--epsilon 0.25 -n 64 --max-gap 5mm --inlet 1=90")).unwrap();
    assert_eq!((options.sampling.epsilon, options.sampling.samples), (0.25, 64));
    assert_eq!(options.candidates.max_gap, Some(0.005));
    assert_eq!(options.boundary.inlet, ["1=90"]);
    assert_eq!(line, "willis infer 'a b.swc' --epsilon 0.25 -n 64 --max-gap 5mm --inlet 1=90 -o again");
    assert_eq!(infer(Path::new("x"), &[]).unwrap().0, InferOptions::default());
}

#[test]
fn errors_name_the_field() {
    let said = |line: &str| infer(Path::new("x.swc"), &words_of(line)).unwrap_err().to_string();
    assert_eq!(said("--epsilon much"), "epsilon \"much\": expected a number from 0 to 1, such as 0.5");
    assert_eq!(said("--max-gap=-3mm"), "max_gap \"-3mm\": expected a positive length");
    assert!(
        said("--uncertain some").starts_with("uncertain \"some\": expected one of candidates, all"),
        "{}",
        said("--uncertain some")
    );
    assert!(said("--until stable -n 5").contains("does not go with"), "{}", said("--until stable -n 5"));
}

#[cfg(not(feature = "train"))]
#[test]
fn a_build_without_training_says_how_to_get_it() {
    refused(&[], &["train", "cases", "-o", "w.toml"], &["train", "--features train"]);
}

/// What a text of the library has in backticks is an option here, with its value where it has one; in Python it is an argument
/// (python/tests/test_module.py has the same cases).
#[test]
fn texts_name_options_as_they_are_typed() {
    // Thirty points, 348.3 mm from end to end, at no whole numbers.
    let lines = (1..31).map(|i| format!("{i} 3 0.1 0.2 {} 2 {}", 12.01 * f64::from(i), if i == 1 { -1 } else { i - 1 }));
    let far = lines.collect::<Vec<_>>().join("\n");
    refused(&[("a.csv", b"fragment,x,y,z\n1,0,0,0\n1,1,0,0\n")], &["convert", "a.csv", "a.swc"], &["or give --default-radius"]);
    let here = folder();
    fs::write(here.path().join("far.swc"), far).expect("written");
    let done = willis(here.path(), &["convert", "far.swc", "far.vtp"]);
    assert!(stderr(&done).contains("if lengths are in voxels, give --units voxel --spacing S"), "{}", stderr(&done));
    let done =
        willis(here.path(), &["simulate", "far.swc", "-o", "out", "--inlet", "1", "--outlet", "30", "--outlets", "ground"]);
    let wanted = "--outlets changes nothing: every outlet is stated; --outlet NODE=ground or --bc replaces it";
    assert!(stderr(&done).contains(wanted), "{}", stderr(&done));
}
