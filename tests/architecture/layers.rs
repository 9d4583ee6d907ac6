//! The layers of the modules inside of a crate: no `crate::` path points sideways or up. Between crates the compiler sees to that. Each
//! outside library stays where it belongs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Crates of several modules, from the bottom: a module may use those of earlier rows, and itself.
const LAYERS: &[(&str, &[&[&str]])] = &[
    (
        "core",
        &[
            &["error"],
            &["support"],
            &["network"],
            &["forest_posterior", "flow"],
            &["perturbation"],
            &["sampling", "simulation"],
            &["decision", "modulation"],
        ],
    ),
    ("io", &[&["masks"], &["formats"], &["output"]]),
    ("models", &[&["candidates", "contacts"], &["circle_of_willis"], &["naming"]]),
    ("willis", &[&["pipeline"], &["internals"], &["cli"]]),
];

/// What the command line may name behind the front door: words, units, formats, files and pictures, and what it prints of; no step of
/// the method.
const FOR_THE_COMMAND_LINE: &[&str] = &[
    "candidates",
    "circle_of_willis",
    "flow",
    "formats",
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

/// Outside libraries that only some files of a crate may name: files or folders, after the name of the crate.
const CONFINED: &[(&str, &[&str])] = &[
    ("clap", &["willis/main.rs", "willis/cli/", "willis/pipeline/boundary_options.rs", "willis/pipeline/options.rs"]),
    ("libc", &["willis/cli/signals.rs", "io/output/lock.rs", "io/formats/regular.rs"]),
    ("signal_hook", &["willis/cli/signals.rs"]),
    ("indicatif", &["willis/main.rs", "willis/cli/"]),
    (
        "rayon",
        &[
            "core/sampling/run.rs",
            "core/modulation/run.rs",
            "core/support/mod.rs",
            "core/support/parallel.rs",
            "willis/pipeline/prepared.rs",
            "willis/cli/mod.rs",
            "willis/cli/cohort.rs",
            "willis/cli/print/mod.rs",
        ],
    ),
    ("tiny_skia", &["report/figures/"]),
    ("plotters", &["report/figures/axis.rs"]),
    ("faer", &["core/sampling/reference.rs", "models/contacts/sections.rs", "models/naming/pose.rs"]),
    ("pulp", &["core/support/simd.rs"]),
    ("rand_chacha", &["core/support/random.rs"]),
    ("hdf5_reader", &["io/formats/vendors/vtrails.rs"]),
    ("quick_xml", &["io/formats/xml.rs"]),
    ("argmin", &["training/minimise.rs"]),
    ("statrs", &["core/support/gamma.rs"]),
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

/// The top-level modules that a file of a crate names, given its path below `src`: by `crate::` or by enough `super::`.
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

fn layer(crate_name: &str, module: &str) -> Option<usize> {
    let (_, layers) = LAYERS.iter().find(|(name, _)| *name == crate_name)?;
    layers.iter().position(|layer| layer.contains(&module))
}

/// What is wrong with a source file, given the name of its crate and its path below `src`.
fn violations(of: &str, source: &str) -> Vec<String> {
    let (crate_name, file) = of.split_once('/').expect("a crate and a file");
    let mut wrong = Vec::new();
    if !source.starts_with("//! ") {
        wrong.push(format!("{of}: the first line does not say what the file is for"));
    }
    let lines = source.lines().count();
    if lines > MOST_LINES {
        wrong.push(format!("{of}: {lines} lines, more than {MOST_LINES}"));
    }
    let code = code(source);
    let tokens = tokens(&code);
    let words: BTreeSet<&str> = tokens.iter().map(String::as_str).collect();
    if words.contains("test") {
        wrong.push(format!("{of}: tests belong to tests/"));
    }
    for (library, homes) in CONFINED {
        let home = homes.iter().any(|home| of == *home || (home.ends_with('/') && of.starts_with(home)));
        if words.contains(library) && !home {
            wrong.push(format!("{of}: names {library}, which belongs to {}", homes.join(", ")));
        }
    }
    let module = file.split('/').next().unwrap_or(file).trim_end_matches(".rs");
    let is_single = !LAYERS.iter().any(|(name, _)| *name == crate_name);
    if is_single || ["lib", "main"].contains(&module) {
        return wrong;
    }
    if of.starts_with("willis/cli/") {
        for pair in tokens.windows(3).filter(|pair| pair[0] == "internals" && pair[1] == "::") {
            if !FOR_THE_COMMAND_LINE.contains(&&*pair[2]) {
                wrong.push(format!("{of}: internals::{} is a step of the method, behind the front door", pair[2]));
            }
        }
        wrong.extend(
            words.iter().filter(|word| word.starts_with("willis_")).map(|word| format!("{of}: {word} is behind the front door")),
        );
    }
    let Some(own) = layer(crate_name, module) else {
        wrong.push(format!("{of}: module {module} has no layer"));
        return wrong;
    };
    for other in used(file, &code).into_iter().filter(|other| other != module) {
        match layer(crate_name, &other) {
            // The front door, where the crate has one.
            None if crate_name == "willis" => {}
            None => wrong.push(format!("{of}: crate::{other} has no layer")),
            Some(_) if module == "cli" && other == "pipeline" => {
                wrong.push(format!("{of}: crate::pipeline is behind the front door"));
            }
            Some(there) if there == own => wrong.push(format!("{of}: crate::{other} points sideways")),
            Some(there) if there > own => wrong.push(format!("{of}: crate::{other} points up")),
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

/// The crates with their folders.
fn crates() -> Vec<(String, PathBuf)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let inner = std::fs::read_dir(root.join("crates")).unwrap().map(|entry| entry.unwrap());
    let inner = inner.map(|entry| (entry.file_name().into_string().unwrap(), entry.path()));
    inner.chain([("willis".to_owned(), root.to_owned())]).collect()
}

#[test]
fn the_sources_keep_to_their_layers() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for (name, folder) in crates() {
        let src = folder.join("src");
        let mut files = Vec::new();
        sources(&src, &mut files);
        files.sort();
        count += files.len();
        for path in files {
            let file = path.strip_prefix(&src).unwrap().to_str().unwrap().replace('\\', "/");
            wrong.extend(violations(&format!("{name}/{file}"), &std::fs::read_to_string(&path).unwrap()));
        }
    }
    assert!(count > 40);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Each dependency has a row in the book that says why it is there, and no row is for one that is gone.
#[test]
fn every_library_has_its_reason() {
    let read = |path: &Path| std::fs::read_to_string(path).expect("read");
    let mut wanted: BTreeSet<String> = BTreeSet::new();
    for (_, folder) in crates() {
        let manifest: toml::Table = read(&folder.join("Cargo.toml")).parse().expect("TOML");
        let targets = manifest.get("target").and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::values);
        let tables = [manifest.get("dependencies"), manifest.get("dev-dependencies")].into_iter();
        for table in tables.chain(targets.map(|target| target.get("dependencies"))).flatten() {
            wanted.extend(table.as_table().into_iter().flat_map(|table| table.keys().cloned()));
        }
    }
    wanted.retain(|name| !name.starts_with("willis-"));
    let page = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/libraries.md"));
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
    one("core/flow/pressures.rs", "use crate::forest_posterior::Forests;", "points sideways");
    one("core/flow/batch/order.rs", "use super::super::super::sampling::Sampling;", "points up");
    one("models/candidates/mod.rs", "use super::contacts::Branches;", "points sideways");
    one("core/network/mod.rs", "use crate::{support::{Point, resilience}, flow::Circuit};", "flow points up");
    one("core/network/mod.rs", "fn f() -> crate :: sampling\n::Options { made_up() }", "points up");
    one("io/masks/mod.rs", "use super::formats::Column;", "points up");
    one("willis/cli/infer.rs", "use crate::internals::decision::decide;", "front door");
    one("willis/cli/infer.rs", "use crate::pipeline::infer;", "front door");
    one("willis/cli/infer.rs", "use willis_core::decision::decide;", "front door");
    one("willis/pipeline/mod.rs", "use crate::cli::words;", "points up");
    one("core/error.rs", "use crate::support::pascals;", "points up");
    one("io/formats/mod.rs", "#[cfg(test)]\nmod tests { fn f() {} }", "tests belong to tests/");
    one("io/formats/mod.rs", "#[cfg(all(test, unix))]\nmod tests { fn f() {} }", "tests belong to tests/");
    one("io/formats/mod.rs", "const S: &str = \"// not a comment\"; use crate::output::Target;", "points up");
    one("io/formats/mod.rs", "const Q: char = '\"'; use crate::output::Target; const R: char = '\"';", "points up");
    one("io/formats/mod.rs", "const R: &str = r#\"a \" quote\"#; use crate::output::Target;", "points up");
    one("io/formats/mod.rs", "/* /* nested */ */ use crate::output::Target;", "points up");
    one("io/formats/mod.rs", "fn f<'a>(x: &'a str) {} use crate::output::Target;", "points up");
    one("core/novelty.rs", "", "has no layer");
    one("core/network/mod.rs", "use crate::novelty::X;", "has no layer");
    one("core/sampling/sampler.rs", "use rayon::prelude::*;", "names rayon");
    one("willis/cli/candidates.rs", "fn f() { rayon::join(a, b); }", "names rayon");
    one("models/candidates/mod.rs", "use faer::Mat;", "names faer");
    one("report/html.rs", "use tiny_skia::Path;", "names tiny_skia");
    one("core/support/random.rs", &"\n".repeat(MOST_LINES), "lines");
    assert_eq!(violations("core/support/random.rs", "// no purpose\n").len(), 1);
}

#[test]
fn what_is_allowed_is_not_caught() {
    let fine = [
        ("core/support/units.rs", "use crate::error::Error;"),
        ("core/network/quantity.rs", "use crate::network::units::pascals;"),
        ("core/flow/pressures.rs", "use super::circuit::Circuit; use crate::flow::Boundary; use crate::network::Network;"),
        ("core/flow/batch/order.rs", "use super::super::boundary::Boundary;"),
        ("core/flow/pressures.rs", "// use crate::sampling::Page;\n/// [`crate::sampling::infer`]\nfn f() {}"),
        ("core/flow/pressures.rs", "/* crate::sampling::Page */ const S: &str = \"crate::sampling::Page \\\" clap\";"),
        ("willis/cli/cohort.rs", "use clap::Args; fn f() { rayon::current_num_threads(); crate::cli::run() }"),
        ("willis/cli/cohort.rs", "use crate::{InferOptions, read}; use crate::internals::report::Page;"),
        ("models/naming/pose.rs", "use faer::Mat; fn faer_like() {}"),
        ("report/figures/figure.rs", "use tiny_skia::Path; use willis_core::decision::Decision; use crate::page::Page;"),
    ];
    for (file, body) in fine {
        assert_eq!(violations(file, &format!("//! Made up.\n{body}")), [""; 0], "{file}: {body}");
    }
}
