//! Labels, ids and file names made to harm: they stay text in every page, table and XML file, and never reach a terminal raw.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::command::{data, folder, stderr, willis};
use crate::peers;
use willis::error::{Error, Fault};
use willis::internals::support::printable::{printable, printable_json};

const LABELS: [&str; 10] = [
    "</script><script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "a\u{2028}b\u{2029}c",
    "\u{202e}live\u{202c} \u{2066}x\u{2069}",
    "nul\0here",
    "\u{1b}]0;title\u{7}\u{1b}[31m",
    "\u{fffe}\u{ffff}\u{7f}\u{9b}31m",
    "]]><!-- {{data}} &amp; \"'",
    "=cmd|' /C calc'!A0",
    "tab\tline\nend",
];

/// What a reader of XML may find in place of a label: characters that XML 1.0 forbids cannot stand in any file.
fn in_xml(label: &str) -> String {
    let forbidden = |c: char| matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}');
    label.chars().map(|c| if forbidden(c) { '\u{fffd}' } else { c }).collect()
}

fn labels() -> Vec<String> {
    LABELS.iter().map(|label| (*label).to_owned()).chain(["x".repeat(1 << 20)]).collect()
}

/// A ladder of vessels with the labels, its nodes called by them too.
fn ladder(here: &Path, name: &str) {
    let (mut nodes, mut edges) =
        (String::from("node,id,x_mm,y_mm,z_mm,label\n"), String::from("node_a,node_b,radius_mm,origin,label\n"));
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let labels = labels();
    for (row, label) in labels.iter().enumerate() {
        let id = if row < LABELS.len() { quoted(label) } else { row.to_string() };
        writeln!(nodes, "{},{id},{row},0,0,{}", 2 * row, quoted(label)).unwrap();
        writeln!(nodes, "{},{},{row},1,0,", 2 * row + 1, 2 * row + 1).unwrap();
        writeln!(edges, "{},{},1,observed,{}", 2 * row, 2 * row + 1, quoted(label)).unwrap();
        if row > 0 {
            writeln!(edges, "{},{},1,observed,\n{},{},1,observed,", 2 * row - 2, 2 * row, 2 * row - 1, 2 * row + 1).unwrap();
        }
    }
    edges += "0,3,1,candidate,\n2,5,1,candidate,\n";
    fs::write(here.join("nodes.csv"), nodes).unwrap();
    fs::write(here.join(name), edges).unwrap();
}

/// The texts of an XML file's elements of a name, as an independent parser finds them.
fn texts(file: &Path, name: &str) -> Vec<String> {
    let text = fs::read_to_string(file).expect("UTF-8");
    let tree = roxmltree::Document::parse(&text).expect("well-formed");
    tree.descendants()
        .filter(|node| node.tag_name().name() == name)
        .map(|node| node.text().unwrap_or_default().to_owned())
        .collect()
}

fn is_harmless(page: &str) {
    assert!(!page.contains("<img") && !page.contains("alert(1)</script>") && !page.contains('\0'), "raw");
    assert!(!page.contains('\u{2028}') && !page.contains('\u{1b}'), "raw");
}

/// Control characters move the cursor of a terminal, rename its window, or hide what stands before.
fn is_plain(said: &str) {
    let control = |c: &char| c.is_control() && *c != '\n';
    assert_eq!(said.chars().find(control), None, "{said:?}");
}

#[test]
fn labels_and_ids_stay_text_in_every_output() {
    let here = folder();
    ladder(here.path(), "edges.csv");
    for (command, more) in [("infer", &["-n", "64", "--keep", "value=0"][..]), ("simulate", &[]), ("modulate", &["-n", "8"])] {
        let ends = ["--inlet", "1", "--outlet", "19"];
        let output = willis(here.path(), &[&[command, "edges.csv", "-o", command], &ends[..], more].concat());
        assert!(output.status.success(), "{command}: {}", stderr(&output));
        is_plain(&stderr(&output));
        is_harmless(&fs::read_to_string(here.path().join(command).join("report.html")).expect("a page"));
        let mut found = Vec::new();
        let mut table = csv::Reader::from_path(here.path().join(command).join("edges.csv")).expect("a table");
        let at = table.headers().expect("names").iter().position(|name| name == "label").expect("labels");
        for row in table.records().map(|row| row.expect("a row")) {
            let formula = |text: &str| text.starts_with(['=', '+', '@', '\t', '\r']);
            assert!(!row.iter().any(formula), "a formula");
            found.push(row[at].trim_start_matches('\'').to_owned());
        }
        for label in labels() {
            assert!(found.contains(&label), "{command}: {:?} is lost", &label[..label.len().min(40)]);
        }
    }
    let out = here.path().join("infer");
    let graph = texts(&out.join("topology.graphml"), "data");
    for label in labels() {
        assert!(graph.contains(&in_xml(&label)), "GraphML: {:?} is lost", &label[..label.len().min(40)]);
    }
    assert!(texts(&out.join("topology.vtp"), "DataArray").len() > 3);
    for name in ["topology.graphml", "topology.vtp"] {
        let output = willis(here.path(), &["simulate", &format!("infer/{name}"), "-o", name, "--inlet", "1", "--outlet", "19"]);
        is_plain(&stderr(&output));
        let ids = ["no node", "more than one node"];
        assert!(output.status.success() || ids.iter().any(|why| stderr(&output).contains(why)), "{}", stderr(&output));
    }
    let script = "import sys, networkx\ng = networkx.read_graphml(sys.argv[1])\nprint(max(len(str(d.get('label'))) for _, _, d in g.edges(data=True)))";
    if let Some(said) = peers::python(script, &[&out.join("topology.graphml")]) {
        assert_eq!(said, (1 << 20).to_string());
    }
}

#[test]
fn names_of_files_stay_text_in_the_page_of_a_cohort() {
    let here = folder();
    let circle = fs::read(data("broken-circle-of-willis.swc")).expect("a file");
    let names = ["<img src=x onerror=alert(1)>.swc", "=1+1.swc", "\u{202e}a\u{2028}\u{1b}[31m.swc"];
    for name in names {
        fs::write(here.path().join(name), &circle).unwrap();
    }
    let output = willis(here.path(), &[&["infer"], &names[..], &["-o", "out", "-n", "64"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    is_plain(&stderr(&output));
    is_harmless(&fs::read_to_string(here.path().join("out/cohort.html")).expect("a page"));
    let mut table = csv::Reader::from_path(here.path().join("out/cohort.csv")).expect("a table");
    let rows: Vec<_> = table.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), 3);
    assert!(rows.iter().flatten().all(|field| !field.starts_with(['=', '+', '@'])));
}

#[test]
fn what_acts_on_a_terminal_is_escaped_and_the_rest_stays() {
    assert_eq!(printable("A. cerebri média 中"), "A. cerebri média 中");
    assert_eq!(printable("a\u{1b}[2Jb\u{7}\u{9b}1m"), "a\\u{1b}[2Jb\\u{7}\\u{9b}1m");
    assert_eq!(printable("gnp\u{202e}exe.\n"), "gnp\\u{202e}exe.\\n");
    for c in (0..=0x10_ffff).filter_map(char::from_u32).filter(|c| c.is_control()) {
        assert!(!printable(&c.to_string()).contains(c), "{c:?}");
    }
}

#[test]
fn json_means_the_same() {
    let value = serde_json::json!({ "id": "a\u{202e}\u{e0041}\u{7f}\u{9b}b" });
    let shown = printable_json(&value.to_string()).into_owned();
    assert!(shown.is_ascii() && !shown.contains(char::is_control), "{shown}");
    assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).expect("JSON"), value);
}

#[test]
fn what_a_file_holds_cannot_break_a_message_into_lines() {
    let fault = Fault::item("a\nb", format!("x\r\u{1b}[31m{}", "y".repeat(400)), "z");
    let said = fault.in_file(Path::new("f")).to_string();
    assert!(said.starts_with("f: a\u{fffd}b: x\u{fffd}\u{fffd}[31myy") && said.ends_with("y\u{2026}; z"), "{said}");
    assert!(!said.chars().any(char::is_control));
    assert_eq!(Error::parameter("x", "1\n", "a number").to_string(), "x 1\u{fffd}: a number");
}
