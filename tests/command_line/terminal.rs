//! What a person or a script meets at the terminal: suggestions, summaries as JSON, progress, completions and manual pages.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::command::{data, folder, stderr, willis};
use crate::refused::{contents, refused};
use serde_json::Value;
use willis::cli::internals::counted;

const LINE: &[u8] = b"1 0 0 0 0 1 -1\n2 0 1 0 0 1 1\n3 0 2 0 0 1 2\n";
const GRAPH: &[u8] = br#"<graphml><key id="label" for="node" attr.name="label" attr.type="string"/>
<key id="name" for="edge" attr.name="label" attr.type="string"/><key id="length_mm" for="edge" attr.name="length_mm" attr.type="double"/>
<key id="radius_mm" for="edge" attr.name="radius_mm" attr.type="double"/><graph><node id="a"><data key="label">heart</data></node>
<node id="b"/><node id="c"><data key="label">left hand</data></node>
<edge source="a" target="b"><data key="name">L-arm</data><data key="length_mm">10</data><data key="radius_mm">1</data></edge>
<edge source="b" target="c"><data key="name">L-hand</data><data key="length_mm">20</data><data key="radius_mm">1</data></edge>
</graph></graphml>"#;

#[test]
fn a_graph_without_anything_uncertain_is_told_what_may_be() {
    let at = folder();
    assert!(willis(at.path(), &["convert", &data("broken-circle-of-willis.swc"), "graph.graphml"]).status.success());
    let said = |name: &str, more: &[&str]| {
        let ran = willis(at.path(), &[&["infer", "graph.graphml", "-o", name, "-n", "4", "--dpi", "36"], more].concat());
        assert!(ran.status.success(), "{}", stderr(&ran));
        (stderr(&ran).contains("no vessel is uncertain"), stderr(&ran).contains("--observed looks for candidates"))
    };
    assert_eq!(said("as-it-is", &[]), (true, true));
    assert_eq!(said("candidates", &["--observed"]), (false, false));
    assert_eq!(said("all", &["--uncertain", "all"]), (false, false));
}

#[test]
fn how_many_observed_vessels_go_is_said() {
    let at = folder();
    let pruned = |name: &str, more: &[&str]| {
        let scan = data("broken-circle-of-willis.swc");
        let ran = willis(at.path(), &[&["infer", &scan, "-o", name, "-n", "64", "--dpi", "36", "--json"], more].concat());
        assert!(ran.status.success(), "{}", stderr(&ran));
        let summary: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
        // The table is the truth: rows by origin and what is kept of them.
        let table = fs::read_to_string(at.path().join(name).join("edges.csv")).expect("a table");
        let rows: Vec<&str> = table.lines().skip(1).filter(|row| row.contains(",observed,")).collect();
        let gone = rows.iter().filter(|row| row.ends_with(",0")).count();
        assert_eq!(summary["counts"]["topology"]["pruned_observed"], gone);
        (gone, rows.len(), stderr(&ran).contains(&format!("{gone} of {} observed vessels pruned", rows.len())))
    };
    assert!(matches!(pruned("candidates", &[]), (0, 1.., false)));
    assert!(matches!(pruned("all", &["--uncertain", "all"]), (0, 1.., true)));
    assert!(matches!(pruned("paper", &["--preset", "paper"]), (1.., 1.., true)));
}

/// Every field in which the choices of the paper differ from the default stands in the help with its value; where that says of an option that it
/// keeps resistances, a run does, and says so.
#[test]
fn the_help_lists_every_effect_of_the_preset_of_the_paper() {
    fn differing(paper: &Value, usual: &Value, all: &mut Vec<String>) {
        for (name, value) in paper.as_object().expect("an object") {
            match value {
                Value::Object(_) if usual[name].is_object() => differing(value, &usual[name], all),
                _ if *value == usual[name] || name == "preset" => {}
                Value::String(value) => all.push(format!("--{} {value}", name.replace("found_", "").replace('_', "-"))),
                _ => panic!("{name}: {value}"),
            }
        }
    }
    let at = folder();
    let json = |options| serde_json::to_value(options).expect("JSON");
    let mut all = Vec::new();
    differing(&json(willis::InferOptions::paper()), &json(willis::InferOptions::default()), &mut all);
    assert!(all.len() >= 7, "{all:?}");
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let help = words(&String::from_utf8(willis(at.path(), &["infer", "--help"]).stdout).expect("UTF-8"));
    let page = words(&fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/src/infer.md")).expect("the page"));
    for effect in &all {
        assert!(help.contains(effect), "{effect}: {help}");
        assert!(page.contains(&format!("`{effect}`")), "{effect}");
    }
    assert!(help.contains("Resistances that a file or an option states at outlets stay"), "{help}");
    // Six outlets of the file state their resistance (data/circle-of-willis/complete.graphml).
    let (circle, ground) = (data("circle-of-willis/complete.graphml"), data("outlets-at-ground.csv"));
    let said = |name: &str, more: &[&str]| {
        let ran = willis(at.path(), &[&["infer", &circle, "-o", name, "-n", "64", "--dpi", "36", "--json"], more].concat());
        assert!(ran.status.success(), "{}", stderr(&ran));
        let record: Value = serde_json::from_slice(&ran.stdout).expect("JSON");
        let noted = record["notes"].to_string().contains("6 outlets keep their resistances");
        assert_eq!(noted, stderr(&ran).contains("6 outlets keep their resistances"));
        noted
    };
    assert!(said("paper", &["--preset", "paper"]));
    assert!(!said("ground", &["--preset", "paper", "--bc", &ground]));
    assert!(!said("usual", &["--uncertain", "all"]));
}

#[test]
fn what_is_mistyped_is_answered_with_what_was_meant() {
    let cases: [(&[&str], &str); 17] = [
        (&["infr"], "'infer'"),
        (&["infer", "g.graphml", "-o", "out", "--espilon", "0.3"], "'--epsilon'"),
        (&["infer", "g.graphml", "-o", "out", "--solver", "lane"], "'lanes'"),
        (&["infer", "g.graphml", "-o", "out", "--keep", "medain"], "did you mean \"median\"?"),
        (&["infer", "g.graphml", "-o", "out", "--outlets", "murry"], "did you mean \"murray\"?"),
        (&["infer", "g.graphml", "-o", "out", "--inlet", "Haert=90"], "did you mean \"heart\"?"),
        (&["infer", "g.graphml", "-o", "out", "--outlet", "left hnd"], "did you mean \"left hand\"?"),
        (&["infer", "g.graphml", "-o", "out", "--flow", "leff hand=3"], "did you mean \"left hand\"?"),
        (&["infer", "g.graphml", "-o", "out", "--bc", "bc.csv"], "did you mean \"left hand\"?"),
        (&["infer", "g.graphml", "-o", "out", "--inlet", "a=90mmhg"], "did you mean \"mmHg\"?"),
        (&["infer", "g.graphml", "-o", "out", "--outlet", "c=20mmHg.s/ml"], "did you mean \"mmHg.s/mL\"?"),
        (&["infer", "g.graphml", "-o", "out", "--outlet", "c=groud"], "did you mean \"ground\"?"),
        (&["simulate", "g.graphml", "-o", "out", "--occlude", "L-had"], "\"L-hand\""),
        (&["simulate", "g.graphml", "-o", "out", "--stenosis", "L-amr=50%"], "\"L-arm\""),
        (&["modulate", "g.graphml", "-o", "out", "--vessels", "l-hand"], "\"L-hand\""),
        (&["phantom", "cerebrall", "-o", "a.swc"], "did you mean \"cerebral\"?"),
        (&["phantom", "cerebral", "-o", "a.swc", "--without", "AComn"], "did you mean \"AComm\"?"),
    ];
    let files = [("g.graphml", GRAPH), ("bc.csv", b"node,kind\na,inlet\nleft hadn,ground\n")];
    for (arguments, meant) in cases {
        refused(&files, arguments, &[meant]);
    }
}

#[test]
fn an_array_mistyped_is_answered_with_the_nearest_one() {
    let here = folder();
    assert!(willis(here.path(), &["phantom", "cerebral", "-o", "c.vtp", "-q"]).status.success());
    let output = willis(here.path(), &["infer", "c.vtp", "-o", "out", "--radius-array", "MaximumInscribedSpereRadius"]);
    let said = stderr(&output);
    assert!(output.status.code() == Some(2) && said.contains("did you mean \"MaximumInscribedSphereRadius\"?"), "{said}");
}

/// Nothing is offered that is not near, and no number for a number.
#[test]
fn what_is_far_off_is_answered_without_a_guess() {
    let here = folder();
    fs::write(here.path().join("a.swc"), LINE).expect("written");
    for (option, value) in [("--inlet", "basilar"), ("--inlet", "31"), ("--keep", "everything"), ("--outlets", "sea")] {
        let said = stderr(&willis(here.path(), &["infer", "a.swc", "-o", "out", option, value]));
        assert!(said.starts_with("willis: --") || said.contains("\nwillis: --"), "{said}");
        assert!(!said.contains("did you mean"), "{said}");
    }
}

/// The JSON on standard output, a line each.
fn printed(folder: &Path, arguments: &[&str]) -> Vec<Value> {
    let output = willis(folder, arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    text.lines().map(|line| serde_json::from_str(line).expect("JSON alone")).collect()
}

#[test]
fn json_on_standard_output_is_the_record_of_the_folder() {
    let here = folder();
    let circle = data("circle-of-willis/complete.graphml");
    for command in ["infer", "simulate", "modulate"] {
        let said = printed(here.path(), &[command, &circle, "-o", command, "--json"]);
        let file = fs::read(here.path().join(command).join("run.json")).expect("a record");
        assert_eq!(said, [serde_json::from_slice::<Value>(&file).expect("JSON")], "{command}");
    }
    let two = printed(here.path(), &["infer", &circle, "-o", "two", "--epsilon", "0.2,0.3", "--json", "-q"]);
    assert_eq!(two.iter().map(|r| r["parameters"]["epsilon"].as_f64()).collect::<Vec<_>>(), [Some(0.2), Some(0.3)]);
}

#[test]
fn json_of_a_graph_or_phantom_counts_what_is_in_the_file() {
    let here = folder();
    let count = |file: &str, word: &str| fs::read_to_string(here.path().join(file)).expect("a file").matches(word).count();
    for arguments in [
        &["candidates", &data("broken-circle-of-willis.swc"), "-o", "g.graphml", "--json"][..],
        &["phantom", "cerebral", "-o", "g.graphml", "--json", "--force"],
    ] {
        let said = printed(here.path(), arguments);
        assert_eq!(said.len(), 1);
        assert_eq!(said[0]["counts"]["nodes"], count("g.graphml", "<node "), "{arguments:?}");
        assert_eq!(said[0]["counts"]["vessels"], count("g.graphml", "<edge "), "{arguments:?}");
        assert_eq!(said[0]["output"], "g.graphml");
    }
    let said = printed(here.path(), &["phantom", "cerebral", "--break", "-o", "b.swc", "--json"]);
    let points = fs::read_to_string(here.path().join("b.swc")).expect("a file").lines().filter(|l| !l.starts_with('#')).count();
    assert_eq!(said[0]["counts"]["points"], points);
    assert_eq!(said[0]["truth"], "b.truth.json");
}

/// The commands that the help lists.
fn commands(here: &Path) -> Vec<String> {
    let help = String::from_utf8(willis(here, &["--help"]).stdout).expect("UTF-8");
    let commands = help.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
    commands
        .filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next().filter(|_| !line.starts_with("   ")))
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

/// The first example of each command is run where its files are.
#[cfg(unix)]
#[test]
fn the_help_of_every_command_has_an_example_that_works() {
    let at = crate::bids::dataset(&[crate::bids::A]);
    let here = at.path();
    let script = |script: &str| {
        let binary = Path::new(env!("CARGO_BIN_EXE_willis")).parent().expect("a folder").display().to_string();
        let path = format!("{binary}:{}", std::env::var("PATH").unwrap_or_default());
        let done = Command::new("sh").current_dir(here).env("PATH", path).env("HOME", here).args(["-ec", script]).output();
        let done = done.expect("a shell");
        assert!(done.status.success(), "{script}: {}", stderr(&done));
    };
    for (from, to) in [("circle-of-willis/complete.graphml", "circle.graphml"), ("scan.nii.gz", "scan.nii.gz")] {
        fs::copy(data(from), here.join(to)).expect("copied");
    }
    fs::copy(here.join("study").join(crate::bids::A), here.join("vessels.nii")).expect("copied");
    script(&format!("willis convert {} extraction.vtp; gzip vessels.nii", data("broken-circle-of-willis.swc")));
    for seed in 1..=4 {
        script(&format!("willis phantom tree --break --seed {seed} -o cases/{seed}/fragments.swc"));
        script(&format!("willis infer cases/{seed}/fragments.swc -o runs/{seed} -n 64 --dpi 36"));
        fs::rename(here.join(format!("cases/{seed}/fragments.truth.json")), here.join(format!("cases/{seed}/truth.json")))
            .expect("renamed");
    }
    fs::create_dir_all(here.join(".local/share/bash-completion/completions")).expect("made");
    for command in commands(here) {
        for asked in [&["help", &command][..], &[&command, "-h"]] {
            let help = String::from_utf8(willis(here, asked).stdout).expect("UTF-8");
            let examples: Vec<&str> =
                help.lines().skip_while(|line| *line != "Examples:").skip(1).take_while(|line| !line.is_empty()).collect();
            let first = examples.first().unwrap_or_else(|| panic!("{command}: no example: {help}")).trim();
            assert!(first.starts_with(&format!("willis {command} ")), "{command}: {first}");
            if asked[0] == "help" {
                script(first);
            }
        }
    }
}

#[test]
fn there_is_a_manual_page_for_every_command() {
    let here = folder();
    let output = willis(here.path(), &["man", "-o", "pages", "-q"]);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", stderr(&output));
    let mut names: Vec<String> = commands(here.path()).iter().map(|name| format!("willis-{name}.1")).collect();
    names.push("willis.1".to_owned());
    names.sort();
    assert!(names.len() >= 8, "{names:?}");
    let pages = contents(&here.path().join("pages"));
    assert_eq!(pages.iter().map(|(name, _)| name.display().to_string()).collect::<Vec<_>>(), names);
    for (name, text) in &pages {
        let title = format!(".TH {} 1", name.with_extension("").display());
        assert!(String::from_utf8_lossy(text).contains(&title), "{title}");
    }
    let whole = willis(here.path(), &["man"]).stdout;
    assert_eq!(whole.len(), pages.iter().map(|(_, text)| text.len()).sum::<usize>());
    // Pages that are there are not replaced unasked.
    fs::write(here.path().join("pages/willis.1"), "mine").expect("written");
    fs::remove_file(here.path().join("pages/willis-infer.1")).expect("removed");
    let before = contents(&here.path().join("pages"));
    assert_eq!(willis(here.path(), &["man", "-o", "pages"]).status.code(), Some(2));
    assert_eq!(contents(&here.path().join("pages")), before);
    assert!(willis(here.path(), &["man", "-o", "pages", "--force"]).status.success());
    assert_eq!(contents(&here.path().join("pages")), pages);
}

/// What bash completes with the words so far, the last of them unfinished.
fn completed(folder: &Path, words: &str) -> Option<String> {
    let script = format!(
        "source willis.bash; COMP_WORDS=(willis {words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); \
         _willis willis \"${{COMP_WORDS[COMP_CWORD]}}\" \"${{COMP_WORDS[COMP_CWORD-1]}}\"; echo \"${{COMPREPLY[*]}}\""
    );
    let output = Command::new("bash").current_dir(folder).args(["--norc", "-c", &script]).output().ok()?;
    assert!(output.status.success() && output.stderr.is_empty(), "{}", stderr(&output));
    Some(String::from_utf8(output.stdout).expect("UTF-8").trim().to_owned())
}

#[test]
fn bash_completes_commands_options_and_values() {
    let here = folder();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = willis(here.path(), &["completions", shell]);
        assert!(String::from_utf8_lossy(&output.stdout).contains("radius-array"), "{shell}");
        fs::write(here.path().join(format!("willis.{shell}")), output.stdout).expect("written");
    }
    for (words, last) in [("inf", "infer"), ("infer --radius-a", "--radius-array"), ("infer --solver r", "reference")] {
        let Some(found) = completed(here.path(), words) else {
            eprintln!("skipped: no bash");
            return;
        };
        assert_eq!(found, last);
    }
}

/// On a terminal, which script(1) pretends to be: a bar with count, rate and time left; bold headings unless `NO_COLOR`; nothing when
/// quiet. Elsewhere no escape at all.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_sees_a_bar_and_colours_only_when_it_wants_them() {
    let here = folder();
    let circle = data("circle-of-willis/complete.graphml");
    let seen = |before: &str, what: &str, more: &str| {
        let run = format!("{before} {} {what} {circle} -o out --force -n 2000 {more}", env!("CARGO_BIN_EXE_willis"));
        let output = Command::new("script")
            .current_dir(here.path())
            .args(["-qec", &run, "/dev/null"])
            .env("TERM", "xterm")
            .env_remove("NO_COLOR")
            .output();
        output.ok().map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let Some(plain) = seen("", "infer", "") else {
        eprintln!("skipped: no script(1)");
        return;
    };
    assert!(plain.contains("2,000 samples  ") && plain.contains("/s  ") && plain.contains(" left"), "{plain}");
    assert!(plain.contains("\x1b[1m"), "{plain}");
    let modulated = seen("", "modulate", "--classes 0:0.2").unwrap_or_default();
    assert!(modulated.contains("2,000 instances  ") && modulated.contains("   solving  "), "{modulated}");
    let grey = seen("NO_COLOR=1", "infer", "").unwrap_or_default();
    assert!(grey.contains("written") && !grey.contains("\x1b[1m"), "{grey}");
    assert_eq!(seen("", "infer", "-q").unwrap_or_default(), "");
    let piped = willis(here.path(), &["infer", &circle, "-o", "out", "--force"]);
    assert!(!piped.stderr.contains(&0x1b) && piped.stdout.is_empty());
}

/// Names from files that others wrote, in everything that is printed: notes, conditions, errors, JSON. The truth is that no byte is printed
/// that a terminal acts on.
#[test]
fn nothing_that_a_terminal_acts_on_is_printed() {
    let hostile = "a\u{1b}[2J\u{1b}]0;owned\u{7}\u{202e}\u{9b}1m\u{7f}";
    let at = folder();
    let nodes = format!("node,id,x_mm,y_mm,z_mm,label\n0,{hostile},0,0,0,{hostile}\n1,b,10,0,0,\n2,c,20,0,0,\n");
    let edges = "node_a,node_b,length_mm,radius_mm,label\n0,1,10,1,\u{1b}[31mred\n1,2,10,1,x\n";
    fs::write(at.path().join("nodes.csv"), nodes).expect("written");
    fs::write(at.path().join("edges.csv"), edges).expect("written");
    fs::write(at.path().join("bad.csv"), format!("node_a,node_b,length_mm,radius_mm\n{hostile},{hostile},x,1\n"))
        .expect("written");
    let swc = format!("1 0 {hostile} 0 0 1 -1\n");
    fs::write(at.path().join("bad.swc"), swc).expect("written");
    let inlet = format!("{hostile}=95mmHg");
    let runs: [&[&str]; 9] = [
        &["simulate", "edges.csv", "-o", "s", "-v", "--json", "--inlet", &inlet],
        &["simulate", "edges.csv", "-o", "s2", "-v", "--json", "--occlude", "\u{1b}[31mred"],
        &["infer", "edges.csv", "-o", "i", "-v", "-n", "4", "--json", "--dpi", "36"],
        &["modulate", "edges.csv", "-o", "m", "-v", "-n", "4", "--json", "--dpi", "36"],
        &["convert", "edges.csv", "out.vtp", "-v", "--json"],
        &["simulate", "edges.csv", "-o", "t", "--inlet", "\u{1b}[2J\u{7}=1"],
        &["convert", "bad.csv", "out2.vtp"],
        &["convert", "bad.swc", "out3.vtp"],
        &["\u{1b}[2Jinfer\u{7}"],
    ];
    for run in runs {
        let output = willis(at.path(), run);
        for bytes in [&output.stdout, &output.stderr] {
            let text = String::from_utf8_lossy(bytes);
            let acts = |c: char| c.is_control() && c != '\n' || c == '\u{202e}';
            assert!(!text.contains(acts), "{run:?}: {text:?}");
        }
    }
}

#[test]
fn notes_that_differ_in_their_figures_are_one() {
    let all = [
        "1 point coinciding: one",
        "23 points coinciding: one",
        "as it is (5 mm)",
        "as it is (5 mm)",
        "alone 7",
        "the radius of 1 edge is d",
        "the radius of 2 edges is d",
    ];
    let found: Vec<(String, usize)> = counted(all).into_iter().collect();
    let expected = [("alone 7", 1), ("as it is (5 mm)", 2), ("the radius of … edges is d", 2), ("… points coinciding: one", 2)];
    assert_eq!(found, expected.map(|(note, of)| (note.to_owned(), of)));
}
