//! Where a model of boosted trees comes from.

use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use super::toml_text::{list, text};

/// Where a model of boosted trees comes from and how well it did on subjects that it was not fitted to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, bound = "S: Default")]
pub struct TreeProvenance<S> {
    /// How many cases it was fitted to.
    pub cases: usize,
    /// Of how many subjects.
    pub subjects: usize,
    /// Program and command.
    pub made_by: String,
    /// Subjects that were held out, where this is the model of a fold.
    pub held_out: Vec<String>,
    /// Scores over all folds, each case by the model of the fold that held its subject out.
    #[serde(skip)]
    pub figures: Vec<S>,
}

impl<S> TreeProvenance<S> {
    /// That of a model fitted to so many cases of so many subjects.
    pub fn of(cases: usize, subjects: usize) -> Self {
        Self { cases, subjects, made_by: String::new(), held_out: Vec::new(), figures: Vec::new() }
    }

    /// Writes it as TOML, the figures (each by `figure`) after a comment of what they are.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write<W: Write>(&self, out: &mut W, about: &str, figure: impl Fn(&S, &mut W) -> io::Result<()>) -> io::Result<()> {
        let Self { cases, subjects, made_by, held_out, figures } = self;
        writeln!(out, "\n# What it was fitted to.\n[provenance]\ncases = {cases}\nsubjects = {subjects}")?;
        writeln!(out, "made_by = {}", text(made_by))?;
        if !held_out.is_empty() {
            writeln!(out, "held_out = {}", list(held_out))?;
        }
        if !figures.is_empty() {
            writeln!(out, "\n{about}")?;
        }
        figures.iter().try_for_each(|of| {
            writeln!(out, "\n[[figures]]")?;
            figure(of, out)
        })
    }
}
