//! Boosted trees as a table: a tree is a line of splits and leaves, and its value is a few comparisons and one number.

use ndarray::{Array2, Axis};
use serde::{Deserialize, Serialize};

use super::{suggestions::did_you_mean, ties::in_steps, toml_text::finite};
use crate::error::{Fault, ensure};

/// A sum of trees.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Boosted {
    /// The score of no tree.
    #[serde(deserialize_with = "finite")]
    pub start: f64,
    /// The trees.
    pub trees: Vec<RegressionTree>,
}

impl Boosted {
    /// The score (log-odds) of each row.
    pub fn scores(&self, features: &Array2<f32>) -> Vec<f64> {
        let score = |row: &[f32]| self.trees.iter().fold(self.start, |sum, tree| sum + tree.value(row));
        let rows = features.axis_iter(Axis(0));
        rows.map(|row| row.as_slice().map_or_else(|| score(&row.to_vec()), score)).collect()
    }

    /// Checks that rows of so many columns have all that the trees look at; `place` names the sum in errors.
    ///
    /// # Errors
    ///
    /// A column beyond the last.
    pub fn check(&self, place: &str, columns: usize) -> Result<(), Fault> {
        let column = |node: &TreeNode| if let TreeNode::Split { column, .. } = node { Some(*column) } else { None };
        let beyond = |tree: &RegressionTree| tree.nodes.iter().filter_map(column).max().filter(|column| *column >= columns);
        let wrong = self.trees.iter().enumerate().find_map(|(at, tree)| Some((at, beyond(tree)?)));
        wrong.map_or(Ok(()), |(at, column)| {
            let (place, accepted) = (format!("{place} tree {}", at + 1), format!("expected features 0 to {}", columns - 1));
            Err(Fault::item(place, format!("feature {column}"), accepted))
        })
    }
}

/// Checks that the features of a file are those that this program measures.
///
/// # Errors
///
/// Another one, with what may be meant, or another number of them.
pub fn check_features(place: &str, found: &[String], names: &[impl AsRef<str>]) -> Result<(), Fault> {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    if let Some((have, expected)) = found.iter().zip(&names).find(|(have, expected)| have != *expected) {
        let is_known = names.contains(&have.as_str());
        let meant = if is_known { String::new() } else { did_you_mean(have, names.iter().copied()) };
        return Err(Fault::item(place, format!("\"{have}\""), format!("{meant}expected {expected} in this place")));
    }
    ensure(found.len() == names.len(), || Fault::item(place, found.len().to_string(), format!("expected {}", names.len())))
}

/// Features beyond this say no more.
const MOST: f64 = 1e6;

/// A feature as a tree compares it: with 24 bits, and zero where it is zero but for rounding, so that rounding does not decide; never without a value.
pub fn stored(x: f64) -> f32 {
    // Steps of 10⁻¹², as some features are as small as 10⁻¹⁰ and mean it.
    if x.is_nan() { 0.0 } else { in_steps(x.clamp(-MOST, MOST), 40) as f32 }
}

/// A binary tree over the columns of a row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct RegressionTree {
    /// The nodes in preorder: of a split the left subtree follows at once.
    nodes: Vec<TreeNode>,
}

/// A node of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TreeNode {
    /// Rows whose value in `column` is below `least_right` go left.
    Split {
        /// The column.
        column: usize,
        /// The least value that goes right.
        least_right: f32,
        /// Where the right subtree begins; set by [`RegressionTree::new`].
        right: usize,
    },
    /// The value of the tree.
    Leaf(f32),
}

/// No tree is deeper, so that a file cannot exhaust the stack.
const DEEPEST: usize = 64;

impl RegressionTree {
    /// The tree whose nodes in preorder these are; `None` where they are none.
    pub fn new(mut nodes: Vec<TreeNode>) -> Option<Self> {
        let end = subtree(&mut nodes, 0, 0)?;
        (end == nodes.len()).then_some(Self { nodes })
    }

    /// Its value for a row.
    pub fn value(&self, row: &[f32]) -> f64 {
        let mut at = 0;
        loop {
            match self.nodes[at] {
                TreeNode::Split { column, least_right, right } => at = if row[column] < least_right { at + 1 } else { right },
                TreeNode::Leaf(value) => return f64::from(value),
            }
        }
    }
}

/// Finds the ends of the subtrees from a node on; the place behind it.
fn subtree(nodes: &mut [TreeNode], at: usize, depth: usize) -> Option<usize> {
    match *nodes.get(at)? {
        TreeNode::Leaf(_) => Some(at + 1),
        TreeNode::Split { column, least_right, .. } => {
            let right = if depth < DEEPEST { subtree(nodes, at + 1, depth + 1)? } else { return None };
            nodes[at] = TreeNode::Split { column, least_right, right };
            subtree(nodes, right, depth + 1)
        }
    }
}

/// `3<0.25 -0.1 0.2`: below 0.25 in column 3 the value is -0.1, else 0.2.
impl From<RegressionTree> for String {
    fn from(tree: RegressionTree) -> Self {
        let word = |node: &TreeNode| match node {
            TreeNode::Split { column, least_right, .. } => format!("{column}<{least_right}"),
            TreeNode::Leaf(value) => value.to_string(),
        };
        tree.nodes.iter().map(word).collect::<Vec<String>>().join(" ")
    }
}

impl TryFrom<String> for RegressionTree {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let refused = |found: String| format!("{found}; expected splits and leaves, as in `3<0.25 -0.1 0.2`");
        let number = |word: &str| word.parse::<f32>().ok().filter(|x| x.is_finite());
        let node = |word: &str| {
            let split = |(column, least_right)| TreeNode::Split { column, least_right, right: 0 };
            let read = match word.split_once('<') {
                Some((column, least)) => column.parse().ok().zip(number(least)).map(split),
                None => number(word).map(TreeNode::Leaf),
            };
            read.ok_or_else(|| refused(format!("\"{word}\" in a tree")))
        };
        let nodes = text.split_whitespace().map(node).collect::<Result<_, _>>()?;
        Self::new(nodes).ok_or_else(|| refused("a tree whose splits and leaves do not match".to_owned()))
    }
}
