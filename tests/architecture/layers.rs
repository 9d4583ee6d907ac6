//! The layers of the modules inside of a crate: no `crate::` path points sideways or up, and no files import each other in a circle. Between
//! crates the compiler sees to that. Each outside library stays where it belongs, and each name of a type means one thing.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Crates of several modules, from the bottom: a module may use those of earlier rows, and itself.
const LAYERS: &[(&str, &[&[&str]])] = &[
    (
        "core",
        &[
            &["error"],
            &["support"],
            &["network"],
            &["forest_posterior", "flow", "morphometry"],
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
    ("clap", &["willis/main.rs", "willis/cli/", "willis/pipeline/options.rs", "willis/pipeline/boundary_options.rs"]),
    ("libc", &["willis/cli/signals.rs", "io/output/lock.rs", "io/formats/regular.rs"]),
    ("signal_hook", &["willis/cli/signals.rs"]),
    ("indicatif", &["willis/main.rs", "willis/cli/"]),
    (
        "rayon",
        &[
            "core/sampling/run.rs",
            "core/modulation/run.rs",
            "core/support/mod.rs",
            "willis/pipeline/inference.rs",
            "willis/cli/mod.rs",
            "willis/cli/cohort.rs",
            "willis/cli/print/mod.rs",
        ],
    ),
    ("kiddo", &["models/candidates/search/point_index.rs"]),
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

/// A path as it is written, and the name by which its end is known where it is imported.
type Named = (Vec<String>, String);

/// Adds the paths of a use tree, or the one of an expression, that starts at `at`, behind the segments `before`; returns where it ends.
fn paths(tokens: &[String], mut at: usize, before: &[String], out: &mut Vec<Named>) -> usize {
    let is = |at: usize, mark: &str| tokens.get(at).is_some_and(|token| token == mark);
    let mut path = before.to_vec();
    while !is(at, "{") {
        path.extend(tokens.get(at).cloned());
        at += 1;
        if !is(at, "::") {
            path.pop_if(|last| last == "self" && !before.is_empty());
            let name = if is(at, "as") { tokens.get(at + 1) } else { path.last() };
            out.push((path.clone(), name.cloned().unwrap_or_default()));
            return if is(at, "as") { at + 2 } else { at };
        }
        at += 1;
    }
    while at < tokens.len() && !is(at, "}") {
        at = if is(at + 1, "}") { at + 1 } else { paths(tokens, at + 1, &path, out) };
    }
    at + 1
}

/// The first segments named by a use tree that starts at `at`: one name, or those of a group.
fn heads(tokens: &[String], at: usize) -> Vec<String> {
    let mut all = Vec::new();
    paths(tokens, at, &[], &mut all);
    all.into_iter().filter_map(|(path, _)| path.into_iter().next()).collect()
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

/// A source file of a crate.
struct Source {
    file: String,
    tokens: Vec<String>,
    /// The names that it defines outside of all braces.
    defined: BTreeSet<String>,
    /// The paths that it imports, by the name that they get.
    imported: BTreeMap<String, Vec<String>>,
}

/// The source files of a crate by their module, from paths below `src` and contents.
type Crate = BTreeMap<Vec<String>, Source>;

/// The definitions of `kinds` in some code: their names, and whether they lie outside of all braces.
fn definitions<'a>(tokens: &'a [String], kinds: &'a [&str]) -> impl Iterator<Item = (&'a String, bool)> {
    let mut depth = 0;
    tokens.windows(2).filter_map(move |pair| {
        depth += i32::from(pair[0] == "{") - i32::from(pair[0] == "}");
        kinds.contains(&&*pair[0]).then_some((&pair[1], depth == 0))
    })
}

fn parsed(files: &[(String, String)]) -> Crate {
    let parse = |(file, source): &(String, String)| {
        let mut module: Vec<String> = file.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
        module.pop_if(|last| ["mod", "lib"].contains(&&**last));
        let tokens = tokens(&code(source));
        let kinds = ["fn", "struct", "enum", "trait", "type", "const", "static", "macro_rules"];
        let defined = definitions(&tokens, &kinds).filter(|(_, outside)| *outside).map(|(name, _)| name.clone()).collect();
        let mut imported = Vec::new();
        for at in (0..tokens.len()).filter(|at| tokens[*at] == "use") {
            paths(&tokens, at + 1, &[], &mut imported);
        }
        let imported = imported.into_iter().map(|(path, name)| (name, path)).collect();
        (module, Source { file: file.clone(), tokens, defined, imported })
    };
    files.iter().map(parse).collect()
}

/// The module whose file defines what a path names that is written in the module `from`; none of another crate, or where it names a module.
/// Of a name that a file imports, the import is followed.
fn home(all: &Crate, from: &[String], path: &[String], most: usize) -> Option<Vec<String>> {
    let (first, mut rest) = path.split_first()?;
    let mut module = from.to_vec();
    match first.as_str() {
        "crate" => module.clear(),
        "self" => {}
        "super" => drop(module.pop()),
        _ if all.contains_key(&[from, &path[..1]].concat()) => rest = path,
        _ => return home(all, from, &[&all[from].imported.get(first)?[..], rest].concat(), most.checked_sub(1)?),
    }
    while let Some((name, after)) = rest.split_first() {
        if name == "super" {
            module.pop();
        } else if all.contains_key(&[&module[..], &rest[..1]].concat()) {
            module.push(name.clone());
        } else {
            let source = all.get(&module)?;
            let import = source.imported.get(name).filter(|_| !source.defined.contains(name));
            return import.and_then(|import| home(all, &module, import, most.checked_sub(1)?)).or(Some(module));
        }
        rest = after;
    }
    None
}

/// The imports of a crate that close a circle of files. What a mod.rs or lib.rs hands on by `pub use` is no import of it.
fn circles(files: &[(String, String)]) -> Vec<String> {
    let all = parsed(files);
    let mut arrows: BTreeMap<&[String], BTreeSet<Vec<String>>> = BTreeMap::new();
    for (module, Source { file, tokens, .. }) in &all {
        let is = |at: Option<usize>, marks: &[&str]| at.and_then(|at| tokens.get(at)).is_some_and(|t| marks.contains(&&**t));
        for at in (0..tokens.len()).filter(|at| is(at.checked_add(1), &["::"]) && !is(at.checked_sub(1), &["::"])) {
            let handed_on = is(at.checked_sub(1), &["use"]) && is(at.checked_sub(2), &["pub", ")"]);
            if handed_on && (file.ends_with("mod.rs") || file.ends_with("lib.rs")) {
                continue;
            }
            let mut named = Vec::new();
            paths(tokens, at, &[], &mut named);
            let homes = named.iter().filter_map(|(path, _)| home(&all, module, path, 8)).filter(|home| home != module);
            arrows.entry(module).or_default().extend(homes);
        }
    }
    let reaches = |from: &Vec<String>, goal: &[String]| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(at) = open.pop().filter(|at| *at != goal) {
            open.extend(arrows.get(&at[..]).into_iter().flatten().filter(|next| seen.insert(*next)));
        }
        seen.contains(&goal.to_vec())
    };
    let each = arrows.iter().flat_map(|(from, to)| to.iter().map(|to| (*from, to)));
    let closing = each.filter(|(from, to)| reaches(to, from));
    closing.map(|(from, to)| format!("{} imports {}", all[from].file, all[to].file)).collect()
}

/// The names of types, aliases and traits that are defined more than once among the files of all crates; types of an `impl` do not count.
fn repeated<'a>(sources: impl Iterator<Item = &'a String>) -> BTreeSet<String> {
    let (mut once, mut again) = (BTreeSet::new(), BTreeSet::new());
    for source in sources {
        let tokens = tokens(&code(source));
        let types = definitions(&tokens, &["struct", "enum", "trait"]).map(|(name, _)| name);
        let aliases = definitions(&tokens, &["type"]).filter(|(_, outside)| *outside).map(|(name, _)| name);
        again.extend(types.chain(aliases).filter(|name| !once.insert((*name).clone())).cloned());
    }
    again
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

/// The source files of a crate: paths below `src`, and contents.
fn files(folder: &Path) -> Vec<(String, String)> {
    let src = folder.join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    files.sort();
    let read = |path: &PathBuf| {
        let file = path.strip_prefix(&src).unwrap().to_str().unwrap().replace('\\', "/");
        (file, std::fs::read_to_string(path).unwrap())
    };
    files.iter().map(read).collect()
}

#[test]
fn the_sources_keep_to_their_layers() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for (name, folder) in crates() {
        let files = files(&folder);
        count += files.len();
        wrong.extend(files.iter().flat_map(|(file, source)| violations(&format!("{name}/{file}"), source)));
    }
    assert!(count > 40);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Who reads a file never has to have read another first that in turn rests on it.
#[test]
fn no_file_imports_another_in_a_circle() {
    for (name, folder) in crates() {
        let found = circles(&files(&folder));
        assert!(found.is_empty(), "{name}:\n{}", found.join("\n"));
    }
}

#[test]
fn a_name_of_a_type_means_one_thing() {
    let all: Vec<(String, String)> = crates().iter().flat_map(|(_, folder)| files(folder)).collect();
    assert_eq!(repeated(all.iter().map(|(_, source)| source)), BTreeSet::new());
}

#[test]
fn circles_and_repeated_names_are_caught() {
    let files =
        |of: &[(&str, &str)]| of.iter().map(|(file, source)| (String::from(*file), String::from(*source))).collect::<Vec<_>>();
    let base =
        [("lib.rs", "pub mod a; mod c;"), ("a/b.rs", "use super::d::{D as E, self}; struct B;"), ("a/d.rs", "pub struct D;")];
    let with = |a: &'static str, c: &'static str| circles(&files(&[&base[..], &[("a/mod.rs", a), ("c.rs", c)]].concat()));
    assert_eq!(with("mod b; mod d; pub use b::B; pub use d::D;", "use crate::a::B;"), [""; 0]);
    assert_eq!(with("mod b; mod d; pub use b::B; use crate::c::C;", "use crate::a::B; struct C;"), [""; 0]);
    // A file and the part of a mod.rs that it uses; through a module that was imported, and through what a mod.rs hands on.
    let both = ["a/mod.rs imports c.rs", "c.rs imports a/mod.rs"];
    assert_eq!(with("use crate::c::C; struct A;", "use crate::a::{self as other, B}; struct C(other::A);"), both);
    let three = circles(&files(&[
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "fn a() { crate::b::b(); }"),
        ("b/mod.rs", "mod d; pub use d::b;"),
        ("b/d.rs", "use crate::c; fn b() { c::c() }"),
        ("c.rs", "use super::a::a; fn c() { a() }"),
    ]));
    assert_eq!(three, ["a.rs imports b/d.rs", "b/d.rs imports c.rs", "c.rs imports a.rs"]);

    let types = [
        "struct One; impl Iterator for One { type Item = u8; }",
        "fn f() { enum Two {} } type Three = u8;",
        "trait Two { type Item; }",
    ];
    assert_eq!(repeated(types.map(String::from).iter()), BTreeSet::from(["Two".to_owned()]));
}

/// Each dependency has a row in the book that says why it is there, and no row is for one that is gone.
#[test]
fn every_library_has_its_reason() {
    let read = |path: &Path| std::fs::read_to_string(path).expect("read");
    let mut wanted: BTreeSet<String> = BTreeSet::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in crates().into_iter().map(|(_, folder)| folder).chain([root.join("python")]) {
        let manifest: toml::Table = read(&folder.join("Cargo.toml")).parse().expect("TOML");
        let targets = manifest.get("target").and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::values);
        let tables = ["dependencies", "build-dependencies", "dev-dependencies"].map(|kind| manifest.get(kind)).into_iter();
        for table in tables.chain(targets.map(|target| target.get("dependencies"))).flatten() {
            wanted.extend(table.as_table().into_iter().flat_map(|table| table.keys().cloned()));
        }
    }
    wanted.retain(|name| !name.starts_with("willis"));
    let page = read(&root.join("docs/src/libraries.md"));
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
    one("models/candidates/mod.rs", "use kiddo::ImmutableKdTree;", "names kiddo");
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
        ("models/candidates/search/point_index.rs", "use kiddo::ImmutableKdTree; fn kiddo_like() {}"),
        ("report/figures/figure.rs", "use tiny_skia::Path; use willis_core::decision::Decision; use crate::page::Page;"),
    ];
    for (file, body) in fine {
        assert_eq!(violations(file, &format!("//! Made up.\n{body}")), [""; 0], "{file}: {body}");
    }
}

/// A text of the library may reach the command line or Python: it has a field in backticks (`frame`, `units=voxel`), which each shows as it
/// is typed there. A command in backticks is one on both sides.
#[test]
fn texts_of_the_library_name_fields_not_options() {
    let option =
        |line: &str| line.match_indices("--").any(|(at, _)| line[at + 2..].starts_with(|c: char| c.is_ascii_lowercase()));
    let (root, mut files) = (Path::new(env!("CARGO_MANIFEST_DIR")), Vec::new());
    for folder in ["crates", "src/pipeline", "src/cli/print"] {
        sources(&root.join(folder), &mut files);
    }
    let mut found = Vec::new();
    for path in files {
        let text = std::fs::read_to_string(&path).unwrap();
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let wrong = code.filter(|line| line.contains('"') && option(line) && !line.contains("`willis "));
        found.extend(wrong.map(|line| format!("{}: {}", path.display(), line.trim())));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
