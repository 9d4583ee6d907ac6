//! The pages of the documentation as tests read them: the README and the book, cut into fenced blocks and links.

use std::fs;
use std::path::{Path, PathBuf};

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A page of text.
pub struct Page {
    /// From the root of the project.
    pub name: String,
    pub path: PathBuf,
    pub text: String,
}

/// A fenced block.
pub struct Block {
    /// The first word after the fence: `console`, `sh`, `text`, `python`, ...
    pub kind: String,
    /// Line of the fence, from 1.
    pub line: usize,
    pub body: String,
}

impl Page {
    pub fn read(path: PathBuf) -> Self {
        let name = path.strip_prefix(root()).expect("below the root").display().to_string();
        let text = fs::read_to_string(&path).expect("a page");
        Self { name, path, text }
    }

    /// The fenced blocks in their order; every fence must close.
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = Vec::new();
        let mut open = false;
        for (at, line) in self.text.lines().enumerate() {
            match line.strip_prefix("```") {
                Some(_) if open => open = false,
                Some(info) => {
                    let kind = info.split_whitespace().next().unwrap_or_default().to_owned();
                    blocks.push(Block { kind, line: at + 1, body: String::new() });
                    open = true;
                }
                None if open => {
                    let body = &mut blocks.last_mut().expect("opened").body;
                    body.push_str(line);
                    body.push('\n');
                }
                None => {}
            }
        }
        assert!(!open, "{}: a fence is open at the end", self.name);
        blocks
    }

    /// The text without fenced blocks.
    pub fn prose(&self) -> String {
        let mut open = false;
        let lines = self.text.lines().filter(|line| {
            let fence = line.starts_with("```");
            open ^= fence;
            !open && !fence
        });
        lines.flat_map(|line| [line, "\n"]).collect()
    }

    /// What stands between backticks in the text.
    pub fn words(&self) -> Vec<String> {
        self.prose().split('`').skip(1).step_by(2).map(str::to_owned).collect()
    }

    /// The targets of links and pictures.
    pub fn links(&self) -> Vec<String> {
        let prose = self.prose();
        prose.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0.to_owned())).collect()
    }

    /// The anchors of the headings, as mdBook and the forges make them: letters, digits, `-`, `_`; spaces to `-`.
    pub fn anchors(&self) -> Vec<String> {
        let headings = self.prose();
        let heading = |line: &str| {
            let text = line.trim_start_matches('#').trim().to_lowercase();
            let kept = text.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>()
        };
        headings.lines().filter(|line| line.starts_with('#')).map(heading).collect()
    }
}

fn markdown_in(folder: &Path) -> Vec<Page> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut paths: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "md")).collect();
    paths.sort();
    paths.into_iter().map(Page::read).collect()
}

/// The pages of the book.
pub fn book() -> Vec<Page> {
    markdown_in(&root().join("docs/src"))
}

/// A page of the book by its file name.
pub fn page(name: &str) -> Page {
    Page::read(root().join("docs/src").join(name))
}

/// The README.
pub fn readme() -> Page {
    Page::read(root().join("README.md"))
}
