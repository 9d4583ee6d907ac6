//! Fits boosted trees to rows of features.

use forust_ml::{GradientBooster, Matrix, gradientbooster::GrowPolicy};
use ndarray::Array2;

use willis_core::error::{Error, Result};
use willis_core::support::boosted_trees::{Boosted, RegressionTree, TreeNode};

/// Trees, leaves and depth of each, learning rate, penalty, least sum of p(1-p) in a leaf, share of the features a tree sees.
const TREES: usize = 300;
const LEAVES: usize = 16;
const DEPTH: usize = 12;
const RATE: f32 = 0.05;
const L2: f32 = 20.0;
const LEAST_LEAF: f32 = 1.5;
const FEATURE_SHARE: f64 = 0.5;

/// Boosted trees over rows of some tables, shape (rows, features) each: table, row, and whether it is right. The same rows give the same bits.
///
/// # Errors
///
/// Rows that no tree can be fitted to.
pub fn boost(tables: &[&Array2<f32>], rows: &[(usize, usize, bool)]) -> Result<Boosted> {
    let columns = tables.first().map_or(0, |table| table.ncols());
    let mut data = Vec::with_capacity(rows.len() * columns);
    for column in 0..columns {
        data.extend(rows.iter().map(|(table, row, _)| f64::from(tables[*table][[*row, column]])));
    }
    let right: Vec<f64> = rows.iter().map(|(.., right)| f64::from(u8::from(*right))).collect();
    let share = (right.iter().sum::<f64>() / rows.len().max(1) as f64).clamp(1e-6, 1.0 - 1e-6);
    let mut booster = GradientBooster::default()
        .set_iterations(TREES)
        .set_max_leaves(LEAVES)
        .set_max_depth(DEPTH)
        .set_learning_rate(RATE)
        .set_l2(L2)
        .set_min_leaf_weight(LEAST_LEAF)
        .set_colsample_bytree(FEATURE_SHARE)
        .set_base_score((share / (1.0 - share)).ln())
        .set_initialize_base_score(false);
    booster.grow_policy = GrowPolicy::LossGuide;
    let matrix = Matrix::new(&data, rows.len(), columns);
    let failed = |why: String| Error::parameter("cases", rows.len(), format!("the trees could not be fitted: {why}"));
    booster.fit_unweighted(&matrix, &right, None).map_err(|e| failed(e.to_string()))?;
    let trees: Option<Vec<RegressionTree>> = booster.trees.iter().map(of_booster).collect();
    let trees = trees.ok_or_else(|| failed("a tree that is none".into()))?;
    Ok(Boosted { start: booster.base_score, trees })
}

/// A tree of the booster in preorder.
fn of_booster(tree: &forust_ml::tree::Tree) -> Option<RegressionTree> {
    let (mut nodes, mut open) = (Vec::new(), vec![0]);
    while let Some(at) = open.pop() {
        let node = &tree.nodes[at];
        if node.is_leaf {
            nodes.push(TreeNode::Leaf(node.weight_value));
        } else {
            // Features have 24 bits, and the trees split between values that occur.
            nodes.push(TreeNode::Split { column: node.split_feature, least_right: node.split_value as f32, right: 0 });
            open.push(node.right_child);
            open.push(node.left_child);
        }
    }
    RegressionTree::new(nodes)
}
