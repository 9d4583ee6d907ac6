//! The README and the book: their commands run, say what they are said to say, and name what there is.
//!
//! `console` blocks are run as they stand, in order, in a folder of the page's own with `data` in it. The lines of a `text` block are
//! among what the block before it said (`…` stands for anything). `python` blocks are run there too (needs `WILLIS_PYTHON`), and a
//! picture that one saves must show something. `sh` blocks are for files that the reader has: their options must be known.

#![cfg(unix)]

use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use willis::internals::output::foreign_file;

use crate::pages::{Block, Page, book, page, readme, root};

/// `cargo run --release --` is the binary under test; other commands of cargo would build again.
const CARGO: &str = r#"cargo() { if [ "$1 $2 $3" = "run --release --" ]; then shift 3; willis "$@"; fi; }"#;

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("made");
    for entry in fs::read_dir(from).expect("a folder").map(|e| e.expect("an entry").path()) {
        let target = to.join(entry.file_name().expect("a name"));
        if entry.is_dir() {
            copy(&entry, &target);
        } else {
            fs::copy(&entry, &target).expect("copied");
        }
    }
}

fn shell(here: &Path, script: &str) -> Output {
    let binary = Path::new(env!("CARGO_BIN_EXE_willis")).parent().expect("a folder");
    let path = std::env::join_paths(
        std::iter::once(binary.to_owned()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    );
    let mut shell = Command::new("sh");
    shell.current_dir(here).env("PATH", path.expect("a path")).env("HOME", here).args(["-ec", script]);
    shell.output().expect("a shell")
}

/// What a reader does with one page.
struct Reader<'a> {
    page: &'a Page,
    here: &'a Path,
    python: Option<String>,
    said: String,
}

impl Reader<'_> {
    fn take(&mut self, block: &Block) {
        let place = format!("{}:{}", self.page.name, block.line);
        match block.kind.as_str() {
            "console" if block.body.contains("willis train") && !cfg!(feature = "train") => {
                println!("{place}: skipped: this build is without `--features train`");
            }
            "console" => {
                let done = shell(self.here, &format!("{CARGO}\nexec 2>&1\n{}", block.body));
                self.said = String::from_utf8_lossy(&done.stdout).into_owned();
                assert!(done.status.success(), "{place}: {}", self.said);
            }
            "text" => self.compare(&place, &block.body),
            "sh" => {
                for line in block.body.lines().filter(|line| line.starts_with("willis ")) {
                    let command = line.split([';', '|', '#', '>', '&']).next().unwrap_or_default();
                    let asked = shell(self.here, &format!("{command} --help"));
                    assert!(asked.status.success(), "{place}: {line}: {}", String::from_utf8_lossy(&asked.stderr));
                }
            }
            // Those that use the module are run where it is installed, by python/tests.
            "python" if block.body.contains("willis.") => {}
            "python" => self.draw(&place, &block.body),
            "" | "csv" | "toml" | "rust" | "bibtex" | "math" => {}
            other => panic!("{place}: a block of {other}, which nothing checks"),
        }
    }

    /// The lines of a block in their order among those that were said.
    fn compare(&self, place: &str, body: &str) {
        let mut said = self.said.lines();
        for line in body.lines().map(str::trim).filter(|line| !line.is_empty()) {
            assert!(said.any(|s| is_like(s.trim(), line)), "{place}: not said: {line}\n{}", self.said);
        }
    }

    fn draw(&self, place: &str, body: &str) {
        let Some(python) = &self.python else { return };
        let mut drawing = Command::new(python);
        let drawn = drawing.current_dir(self.here).env("MPLBACKEND", "Agg").args(["-c", body]).output().expect("runs");
        assert!(drawn.status.success(), "{place}: {}", String::from_utf8_lossy(&drawn.stderr));
        for saved in body.split("savefig(\"").skip(1).filter_map(|rest| rest.split_once('"')) {
            let coloured = coloured(&self.here.join(saved.0));
            assert!(coloured > 500, "{place}: {}: {coloured} coloured pixels", saved.0);
        }
    }
}

/// Whether `said` is `line`, in which `…` stands for anything.
fn is_like(said: &str, line: &str) -> bool {
    let mut parts = line.split('…');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = said.strip_prefix(first) else { return false };
    for part in parts.clone() {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    parts.next_back().map_or(rest.is_empty(), |last| last.is_empty() || said.ends_with(last))
}

#[test]
fn lines_are_compared_with_gaps() {
    assert!(is_like("written  out in 0.4 s", "written  out in … s"));
    assert!(is_like("a b", "a b") && is_like("a b c", "a…c") && is_like("a b c", "a…"));
    assert!(!is_like("a b c", "a b") && !is_like("a b c", "b…c") && !is_like("a b c", "a…b"));
}

/// Pixels of a picture that are no grey.
fn coloured(picture: &Path) -> usize {
    let file = fs::File::open(picture).expect("a picture");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG header");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("an image");
    pixels.chunks_exact(info.color_type.samples()).filter(|p| p[0].abs_diff(p[2]) > 60).count()
}

/// Does everything that a page says, and hands over what came of it.
fn read(page: &Page, and: impl FnOnce(&Path)) {
    let here = tempfile::tempdir().expect("a temporary folder");
    copy(&root().join("data"), &here.path().join("data"));
    // The file of a reader who has one that takes long.
    fs::copy(root().join("data/broken-circle-of-willis.swc"), here.path().join("brain.swc")).expect("copied");
    let python = std::env::var("WILLIS_PYTHON").ok();
    let mut reader = Reader { page, here: here.path(), python, said: String::new() };
    for block in page.blocks() {
        reader.take(&block);
    }
    and(here.path());
}

#[test]
fn the_readme_does_what_it_says() {
    let page = readme();
    assert_eq!(
        page.blocks().iter().filter(|block| block.kind == "python" && !block.body.contains("willis.")).count(),
        3,
        "one for each of the three uses"
    );
    read(&page, |here| assert_eq!(here.join("kept.png").exists(), std::env::var("WILLIS_PYTHON").is_ok()));
}

#[test]
fn the_pages_of_the_book_do_what_they_say() {
    if std::env::var("WILLIS_PYTHON").is_err() {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt; commands alone are run");
    }
    let pages = book();
    assert!(pages.iter().map(|page| page.blocks().len()).sum::<usize>() > 20);
    let pages: Vec<&Page> = pages.iter().filter(|page| page.name != "docs/src/outputs.md").collect();
    // Each page has a folder of its own, so that several are read at once.
    pages.par_iter().for_each(|page| read(page, |_| ()));
}

/// The guides lead to their end in fewer than five commands.
#[test]
fn the_guides_are_short() {
    for name in ["guide-extraction.md", "guide-cohort.md", "guide-groups.md", "guide-matrix.md", "guide-waveforms.md"] {
        let blocks = page(name).blocks();
        let commands = blocks.iter().filter(|block| block.kind == "console").flat_map(|block| block.body.lines());
        let commands = commands.filter(|line| line.starts_with("willis ")).count();
        assert!((1..5).contains(&commands), "{name}: {commands} commands");
    }
}

fn files(below: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(below).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// The page of outputs makes one of each kind: every file that is there, and every column of its tables, is on it, and `--force` may replace
/// every folder of a run or a cohort.
#[test]
fn every_file_and_every_column_is_described() {
    let page = page("outputs.md");
    let words: BTreeSet<String> = page.words().iter().flat_map(|word| word.split(',').map(str::to_owned)).collect();
    let mut missing = BTreeSet::new();
    read(&page, |here| {
        let made: Vec<PathBuf> = files(here).into_iter().filter(|path| !path.starts_with(here.join("data"))).collect();
        assert!(made.len() > 60, "{made:?}");
        for path in made {
            let name = path.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
            if path.extension().is_some_and(|e| e == "csv") {
                let text = fs::read_to_string(&path).expect("a table");
                let columns = text.lines().next().unwrap_or_default().split(',');
                missing.extend(columns.filter(|c| !words.contains(*c)).map(|c| format!("{name}: {c}")));
            }
            let folder = path.parent().filter(|folder| *folder != here);
            if name == "run.json" || name == "cohort.json" {
                assert_eq!(folder.and_then(foreign_file), None, "names.rs does not list it");
            }
            if folder.is_some() && !words.contains(&name) {
                missing.insert(name);
            }
        }
    });
    assert!(missing.is_empty(), "docs/src/outputs.md does not have: {missing:?}");
}

fn sources(below: &Path) -> String {
    files(below).iter().filter(|path| path.extension().is_some_and(|e| e == "rs")).fold(String::new(), |mut all, path| {
        all += &fs::read_to_string(path).expect("a source").replace("\\\n", "");
        all
    })
}

/// A message of the program as the library words it: options are fields in backticks there, and with `valued` their values beside them.
fn of_library(message: &str, valued: bool) -> String {
    let mut out = Vec::new();
    let mut words = message.split(' ');
    while let Some(word) = words.next() {
        out.push(match word.strip_prefix("--") {
            Some(rest) => {
                let (flag, after) = rest.split_at(rest.find([',', ';', ':']).unwrap_or(rest.len()));
                let value = words.clone().next().filter(|_| valued && after.is_empty()).map(|_| words.next());
                let value = value.flatten().map_or_else(String::new, |value| format!("={value}"));
                format!("`{}{value}`{after}", flag.replace('-', "_"))
            }
            None => word.to_owned(),
        });
    }
    out.join(" ")
}

/// Each message in the first column of the page on trouble is one of the program's: its parts between `…` stand in the sources.
#[test]
fn the_messages_that_are_explained_are_the_programs_own() {
    let page = page("troubleshooting.md");
    let sources = ["src", "crates"].map(|folder| sources(&root().join(folder))).concat();
    let rows = page.text.lines().filter_map(|line| line.strip_prefix("| `"));
    let messages: Vec<&str> = rows.filter_map(|row| Some(row.split_once('`')?.0)).collect();
    assert!(messages.len() > 25, "{} messages", messages.len());
    let mut missing = Vec::new();
    for message in messages {
        for part in message.split('…').map(|part| part.trim_matches([' ', ':', ';', ','])).filter(|part| !part.is_empty()) {
            missing.extend(
                (!sources.contains(part) && [false, true].iter().all(|valued| !sources.contains(&of_library(part, *valued))))
                    .then_some(part),
            );
        }
    }
    assert!(missing.is_empty(), "no source says {missing:#?}");
}

/// Every page is in the summary, every link leads to a file and a heading that are there, and the book needs nothing outside itself.
#[test]
fn links_lead_somewhere() {
    let summary = page("SUMMARY.md").links();
    let book = book();
    for page in book.iter().filter(|page| !page.name.ends_with("SUMMARY.md")) {
        let file = page.path.file_name().and_then(|name| name.to_str()).expect("a name");
        assert!(summary.iter().any(|link| link == file), "{} is not in the summary", page.name);
    }
    let others = ["benches", "data", "experiments", "fuzz", "workflow"].map(|folder| format!("{folder}/README.md"));
    let others = others
        .into_iter()
        .chain(["CHANGELOG.md".to_owned(), "CONTRIBUTING.md".to_owned()])
        .map(|name| Page::read(root().join(name)));
    for page in book.into_iter().chain([readme()]).chain(others) {
        for link in page.links().iter().filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let path = if file.is_empty() { page.path.clone() } else { page.path.parent().expect("a folder").join(file) };
            assert!(path.exists(), "{}: {link} is not there", page.name);
            assert!(!page.name.starts_with("docs/") || !file.contains('/'), "{}: {link} is not in the book", page.name);
            if !anchor.is_empty() {
                assert!(Page::read(path).anchors().iter().any(|a| a == anchor), "{}: no heading {link}", page.name);
            }
        }
    }
}

/// The performance page and the table in `benches/README.md` are made from the figures in `benches`. Needs `WILLIS_PYTHON`.
#[test]
fn the_performance_page_is_that_of_the_figures() {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python");
        return;
    };
    let checked = Command::new(python).arg(root().join("benches/page.py")).arg("--check").output().expect("runs");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
}

/// Formulas become MathML without any library, so that no TeX is left on a page; a fraction, a root and a sum are as they are written by hand. Every
/// picture of a page is one that the script makes. Needs `WILLIS_PYTHON`.
#[test]
fn formulas_are_set_and_pictures_are_made() {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python");
        return;
    };
    let run = |arguments: &[&str]| {
        let run = Command::new(&python).current_dir(root().join("docs")).args(["-B"]).args(arguments).output().expect("runs");
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        String::from_utf8_lossy(&run.stdout).into_owned()
    };
    let set = "import sys, formulas; print(formulas.set_page(sys.argv[1]), end='')";
    let by_hand = "<math><mrow><mi>R</mi><mo>=</mo><mfrac><mrow><mn>8</mn><mi>µ</mi><mi>l</mi></mrow><mrow><mi>π</mi>\
                   <msup><mi>r</mi><mn>4</mn></msup></mrow></mfrac></mrow></math>";
    assert_eq!(run(&["-c", set, r"so $`R = \frac{8 \mu l}{\pi r^4}`$."]), format!("so {by_hand}."));
    let by_hand = "<math display=\"block\"><mrow><munder><mo largeop=\"true\" movablelimits=\"false\">∑</mo><mi>n</mi></munder>\
                   <msqrt><mrow><msubsup><mi>q</mi><mi>n</mi><mo>′</mo></msubsup></mrow></msqrt></mrow></math>";
    assert_eq!(run(&["-c", set, "```math\n\\sum_n \\sqrt{q_n'}\n```"]), format!("<div class=\"formula\">{by_hand}</div>"));
    let theory = run(&["-c", set, &page("theory.md").text]);
    assert!(theory.matches("<math").count() > 40);
    for formula in theory.split("<math").skip(1).filter_map(|rest| rest.split_once("</math>")) {
        let text = format!("<math{}</math>", formula.0);
        let tree = roxmltree::Document::parse(&text).expect("well-formed");
        assert!(tree.descendants().filter(roxmltree::Node::is_text).all(|n| !n.text().unwrap_or("\\").contains('\\')), "{text}");
    }
    run(&["formulas.py", "--check"]);
    let refused = Command::new(&python).current_dir(root().join("docs")).args(["-Bc", set, "$`\\binom{a}{b}`$"]).output();
    assert!(!refused.expect("runs").status.success(), "what is not known is refused");
    let made = fs::read_to_string(root().join("docs/pictures.py")).expect("a script");
    let wanted: Vec<String> = book()
        .iter()
        .flat_map(|page| {
            page.text
                .split("<!-- picture ")
                .skip(1)
                .map(|rest| rest.split(':').next().unwrap_or_default().to_owned())
                .collect::<Vec<_>>()
        })
        .collect();
    assert!(wanted.len() > 10);
    assert!(wanted.iter().all(|name| made.contains(&format!("    \"{name}\": ("))), "{wanted:?}");
}

#[test]
fn the_citation_and_the_recipe_name_this_version() {
    let version = format!("version: {}", env!("CARGO_PKG_VERSION"));
    for file in ["CITATION.cff", "workflow/conda/meta.yaml"] {
        let text = fs::read_to_string(root().join(file)).expect("a file");
        assert!(text.lines().any(|line| line.trim() == version), "{file} has no \"{version}\"");
    }
}

/// The picture of the README and what is said of it are those of this version. Needs `WILLIS_PYTHON`.
#[test]
fn the_picture_of_the_readme_is_that_of_this_version() {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python");
        return;
    };
    let script = root().join("docs/answer.py");
    let checked =
        Command::new(python).arg(script).arg("--check").env("WILLIS", env!("CARGO_BIN_EXE_willis")).output().expect("runs");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
}
