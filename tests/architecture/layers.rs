//! The layers in which lib.rs declares the modules: no `crate::` path points sideways or up, and each outside library stays where it
//! belongs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// From the bottom: a module may use those of earlier rows, and itself.
const LAYERS: &[&[&str]] = &[
    &["error"],
    &["support"],
    &["network"],
    &["masks"],
    &["forest_posterior", "flow"],
    &["io"],
    &["candidates", "perturbation", "contacts"],
    &["sampling", "simulation"],
    &["decision", "modulation"],
    &["circle_of_willis", "phantom"],
    &["naming"],
    &["training"],
    &["output"],
    &["report"],
    &["pipeline"],
    &["internals"],
    &["cli"],
];

/// What the command line may name behind the front door: words, units, formats, files and pictures, and what it prints of; no step of
/// the method.
const FOR_THE_COMMAND_LINE: &[&str] = &[
    "candidates",
    "circle_of_willis",
    "flow",
    "io",
    "modulation",
    "network",
    "output",
    "phantom",
    "pipeline",
    "report",
    "sampling",
    "simulation",
    "support",
    "training",
];

/// Outside libraries with the files or folders that may name them.
const CONFINED: &[(&str, &[&str])] = &[
    ("clap", &["main.rs", "cli/"]),
    ("clap_complete", &["cli/"]),
    ("clap_mangen", &["cli/"]),
    ("ctrlc", &["cli/signals.rs"]),
    ("signal_hook", &["cli/signals.rs"]),
    ("libc", &["cli/signals.rs", "output/lock.rs"]),
    ("indicatif", &["main.rs", "cli/"]),
    (
        "rayon",
        &[
            "sampling/run.rs",
            "modulation/run.rs",
            "support/mod.rs",
            "support/parallel.rs",
            "pipeline/mod.rs",
            "cli/mod.rs",
            "cli/cohort.rs",
            "cli/print/mod.rs",
        ],
    ),
    ("kiddo", &["candidates/search/point_index.rs"]),
    ("plotters", &["report/figures/"]),
    ("ab_glyph", &["report/figures/font.rs"]),
    ("strsim", &["support/suggestions.rs"]),
    ("faer", &["sampling/reference.rs", "contacts/sections.rs", "naming/pose.rs"]),
    ("pulp", &["support/simd.rs"]),
    ("rand_chacha", &["support/random.rs"]),
    ("hdf5_reader", &["io/vendors/vtrails.rs"]),
    ("quick_xml", &["io/xml.rs"]),
    ("argmin", &["training/minimise.rs"]),
    ("statrs", &["support/gamma.rs"]),
];

const MOST_LINES: usize = 600;

/// The code of a source file: comments and the contents of strings and characters left out, lines kept.
fn code(source: &str) -> String {
    let s: Vec<char> = source.chars().collect();
    let (mut out, mut i) = (String::new(), 0);
    let at = |i: usize| s.get(i).copied().unwrap_or('\0');
    let ident = |c: char| c.is_alphanumeric() || c == '_';
    while i < s.len() {
        let before = i.checked_sub(1).map_or(' ', at);
        let hashes = (i + 1..s.len()).take_while(|j| at(*j) == '#').count();
        let end = if at(i) == '/' && at(i + 1) == '/' {
            (i..s.len()).find(|j| s[*j] == '\n').unwrap_or(s.len())
        } else if at(i) == '/' && at(i + 1) == '*' {
            let (mut depth, mut j) = (1, i + 2);
            while depth > 0 && j < s.len() {
                match (at(j), at(j + 1)) {
                    ('/', '*') => (depth, j) = (depth + 1, j + 2),
                    ('*', '/') => (depth, j) = (depth - 1, j + 2),
                    _ => j += 1,
                }
            }
            j
        } else if at(i) == 'r' && !ident(before) && at(i + 1 + hashes) == '"' {
            let close: String = std::iter::once('"').chain(std::iter::repeat_n('#', hashes)).collect();
            let from = i + 2 + hashes;
            (from..s.len()).find(|j| s[*j..].iter().take(close.len()).eq(&close.chars().collect::<Vec<_>>())).unwrap_or(s.len())
                + close.len()
        } else if at(i) == '"' {
            let mut j = i + 1;
            while j < s.len() && s[j] != '"' {
                j += if s[j] == '\\' { 2 } else { 1 };
            }
            j + 1
        } else if at(i) == '\'' && at(i + 1) == '\\' {
            (i + 3..s.len()).find(|j| s[*j] == '\'').unwrap_or(s.len()) + 1
        } else if at(i) == '\'' && at(i + 2) == '\'' {
            i + 3
        } else {
            out.push(s[i]);
            i += 1;
            continue;
        };
        out.extend(s[i..end.min(s.len())].iter().filter(|c| **c == '\n'));
        out.push(' ');
        i = end;
    }
    out
}

/// The identifiers and other marks of some code; `::` is one mark.
fn tokens(code: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut inside = false;
    for c in code.chars() {
        let ident = c.is_alphanumeric() || c == '_';
        match out.last_mut() {
            Some(last) if ident && inside => last.push(c),
            Some(last) if c == ':' && last == ":" => last.push(c),
            _ if c.is_whitespace() => {}
            _ => out.push(c.to_string()),
        }
        inside = ident;
    }
    out
}

/// The first segments named by a use tree that starts at `at`: one name, or those of a group.
fn heads(tokens: &[String], at: usize) -> Vec<String> {
    match tokens.get(at).map(String::as_str) {
        Some("{") => {
            let (mut depth, mut names, mut fresh) = (0, Vec::new(), true);
            for token in &tokens[at..] {
                match token.as_str() {
                    "{" => depth += 1,
                    "}" => depth -= 1,
                    "," if depth == 1 => fresh = true,
                    name if depth == 1 && fresh => {
                        names.push(name.to_owned());
                        fresh = false;
                    }
                    _ => {}
                }
                if depth == 0 {
                    break;
                }
            }
            names
        }
        Some(name) => vec![name.to_owned()],
        None => Vec::new(),
    }
}

/// The top-level modules that a file of the library names, by `crate::` or by enough `super::`.
fn used(file: &str, code: &str) -> BTreeSet<String> {
    let depth = file.split('/').count() - usize::from(file.ends_with("mod.rs"));
    let tokens = tokens(code);
    let mut found = BTreeSet::new();
    let mut at = 0;
    while at < tokens.len() {
        let follows =
            |i: usize, word: &str| tokens.get(i).is_some_and(|t| t == word) && tokens.get(i + 1).is_some_and(|t| t == "::");
        if follows(at, "crate") {
            found.extend(heads(&tokens, at + 2));
            at += 2;
            continue;
        }
        let supers = (0..tokens.len()).take_while(|n| follows(at + 2 * n, "super")).count();
        if supers >= depth {
            found.extend(heads(&tokens, at + 2 * supers));
        }
        at += (2 * supers).max(1);
    }
    found
}

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

/// What is wrong with a source file, given its path below src.
fn violations(file: &str, source: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    if !source.starts_with("//! ") {
        wrong.push(format!("{file}: the first line does not say what the file is for"));
    }
    let lines = source.lines().count();
    if lines > MOST_LINES {
        wrong.push(format!("{file}: {lines} lines, more than {MOST_LINES}"));
    }
    let code = code(source);
    let words: BTreeSet<String> = tokens(&code).into_iter().collect();
    if words.contains("test") {
        wrong.push(format!("{file}: tests belong to tests/"));
    }
    for (library, homes) in CONFINED {
        let home = homes.iter().any(|home| file == *home || (home.ends_with('/') && file.starts_with(home)));
        if words.contains(*library) && !home {
            wrong.push(format!("{file}: names {library}, which belongs to {}", homes.join(", ")));
        }
    }
    let module = file.split('/').next().unwrap_or(file).trim_end_matches(".rs");
    if module == "cli" {
        for pair in tokens(&code).windows(3).filter(|pair| pair[0] == "internals" && pair[1] == "::") {
            if !FOR_THE_COMMAND_LINE.contains(&&*pair[2]) {
                wrong.push(format!("{file}: internals::{} is a step of the method, behind the front door", pair[2]));
            }
        }
        let own = ["cli", "error", "internals"];
        for other in used(file, &code).into_iter().filter(|other| layer(other).is_some() && !own.contains(&other.as_str())) {
            wrong.push(format!("{file}: crate::{other} is behind the front door"));
        }
        return wrong;
    }
    if ["lib", "main"].contains(&module) {
        return wrong;
    }
    let Some(own) = layer(module) else {
        wrong.push(format!("{file}: module {module} has no layer"));
        return wrong;
    };
    for other in used(file, &code).into_iter().filter(|other| other != module) {
        match layer(&other) {
            None => wrong.push(format!("{file}: crate::{other} has no layer")),
            Some(there) if there == own => wrong.push(format!("{file}: crate::{other} points sideways")),
            Some(there) if there > own => wrong.push(format!("{file}: crate::{other} points up")),
            Some(_) => {}
        }
    }
    wrong
}

fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

#[test]
fn the_sources_keep_to_their_layers() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    files.sort();
    assert!(files.len() > 40);
    let mut wrong = Vec::new();
    for path in files {
        let file = path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
        wrong.extend(violations(&file, &std::fs::read_to_string(&path).unwrap()));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_module_has_a_layer() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs");
    let tokens = tokens(&code(&std::fs::read_to_string(root).unwrap()));
    for declared in tokens.windows(2).filter(|w| w[0] == "mod") {
        assert!(layer(&declared[1]).is_some(), "module {} has no layer", declared[1]);
    }
}

/// Each dependency has a row in the book that says why it is there, and no row is for one that is gone.
#[test]
fn every_library_has_its_reason() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |name: &str| std::fs::read_to_string(root.join(name)).expect("read");
    let manifest: toml::Table = read("Cargo.toml").parse().expect("TOML");
    let mut wanted: BTreeSet<String> = BTreeSet::new();
    let mut add = |table: Option<&toml::Value>| {
        wanted.extend(table.and_then(toml::Value::as_table).into_iter().flat_map(|t| t.keys().cloned()));
    };
    add(manifest.get("dependencies"));
    add(manifest.get("dev-dependencies"));
    for target in manifest["target"].as_table().expect("targets").values() {
        add(target.get("dependencies"));
    }
    let page = read("docs/src/libraries.md");
    let rows = page.lines().filter(|line| line.starts_with("| `")).filter_map(|line| line.split('|').nth(1));
    let said: BTreeSet<String> =
        rows.flat_map(|cell| cell.split(", ").map(|name| name.trim().trim_matches('`').to_owned())).collect();
    assert_eq!(said, wanted);
}

/// The checker itself, on sources made up to break each rule.
#[test]
fn every_kind_of_violation_is_caught() {
    let caught = |file: &str, body: &str| violations(file, &format!("//! Made up.\n{body}"));
    let one = |file: &str, body: &str, what: &str| {
        let wrong = caught(file, body);
        assert!(wrong.len() == 1 && wrong[0].contains(what), "{file}: {body}: {wrong:?}");
    };
    one("flow/pressures.rs", "use crate::forest_posterior::Forests;", "points sideways");
    one("flow/batch/order.rs", "use super::super::super::io::Column;", "points up");
    one("candidates/mod.rs", "use super::perturbation::Occlusion;", "points sideways");
    one("network/mod.rs", "use crate::{support::{Point, resilience}, flow::Circuit};", "flow points up");
    one("network/mod.rs", "fn f() -> crate :: sampling\n::Options { made_up() }", "points up");
    one("io/mod.rs", "use super::candidates::Candidates;", "points up");
    one("cli/infer.rs", "use crate::internals::decision::decide;", "front door");
    one("cli/infer.rs", "use crate::decision::decide;", "front door");
    one("pipeline/mod.rs", "use crate::cli::words;", "points up");
    one("error.rs", "use crate::support::pascals;", "points up");
    one("io/mod.rs", "#[cfg(test)]\nmod tests { fn f() {} }", "tests belong to tests/");
    one("io/mod.rs", "#[cfg(all(test, unix))]\nmod tests { fn f() {} }", "tests belong to tests/");
    one("io/mod.rs", "const S: &str = \"// not a comment\"; use crate::report::Page;", "points up");
    one("io/mod.rs", "const Q: char = '\"'; use crate::report::Page; const R: char = '\"';", "points up");
    one("io/mod.rs", "const R: &str = r#\"a \" quote\"#; use crate::report::Page;", "points up");
    one("io/mod.rs", "/* /* nested */ */ use crate::report::Page;", "points up");
    one("io/mod.rs", "fn f<'a>(x: &'a str) {} use crate::report::Page;", "points up");
    one("novelty.rs", "", "has no layer");
    one("network/mod.rs", "use crate::novelty::X;", "has no layer");
    one("sampling/sampler.rs", "use rayon::prelude::*;", "names rayon");
    one("cli/candidates.rs", "fn f() { rayon::join(a, b); }", "names rayon");
    one("sampling/run.rs", "#[derive(clap::Args)] struct A;", "names clap");
    one("candidates/mod.rs", "use kiddo::ImmutableKdTree;", "names kiddo");
    one("report/html.rs", "use plotters::prelude::*;", "names plotters");
    one("support/random.rs", &"\n".repeat(MOST_LINES), "lines");
    assert_eq!(violations("support/random.rs", "// no purpose\n").len(), 1);
}

#[test]
fn what_is_allowed_is_not_caught() {
    let fine = [
        ("support/units.rs", "use crate::error::Error;"),
        ("network/quantity.rs", "use crate::network::units::pascals;"),
        ("flow/pressures.rs", "use super::circuit::Circuit; use crate::flow::Boundary; use crate::network::Network;"),
        ("flow/batch/order.rs", "use super::super::boundary::Boundary;"),
        ("flow/pressures.rs", "// use crate::report::Page;\n/// [`crate::sampling::infer`]\nfn f() {}"),
        ("flow/pressures.rs", "/* crate::report::Page */ const S: &str = \"crate::report::Page \\\" clap\";"),
        ("cli/cohort.rs", "use clap::Args; fn f() { rayon::current_num_threads(); crate::cli::run() }"),
        ("candidates/search/point_index.rs", "use kiddo::ImmutableKdTree; fn kiddo_like() {}"),
        ("report/figures/figure.rs", "use plotters::prelude::*; use crate::decision::Decision; use crate::phantom::Kind;"),
    ];
    for (file, body) in fine {
        assert_eq!(violations(file, &format!("//! Made up.\n{body}")), [""; 0], "{file}: {body}");
    }
}
