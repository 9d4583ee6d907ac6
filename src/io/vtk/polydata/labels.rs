//! The anatomical names of lines: arrays of texts or numbers that a person or a program named vessels by.
//!
//! VMTK's `GroupIds`, SimVascular's `BranchId` and `BifurcationId` and BraVa's `Vessel Ids` number the pieces of a tree. They
//! say how it hangs together, which the lines say already, and not which vessel it is: they make no names.

use std::collections::HashMap;

use super::{Array, PolyData, Values};

/// The usual names of such arrays, letters only, the first one first.
const NAMES: [&str; 8] =
    ["label", "labels", "vesselname", "vessellabel", "segmentname", "anatomicallabel", "anatomicalname", "name"];
/// What CoW_Centerline_Extraction means by its numbers (`extract_cow_variant_from_graph.py`).
const CIRCLE: [(i64, &str); 13] = [
    (1, "BA"),
    (2, "R-PCA"),
    (3, "L-PCA"),
    (4, "R-ICA"),
    (5, "R-MCA"),
    (6, "L-ICA"),
    (7, "L-MCA"),
    (8, "R-Pcom"),
    (9, "L-Pcom"),
    (10, "Acom"),
    (11, "R-ACA"),
    (12, "L-ACA"),
    (15, "3rd-A2"),
];
/// Arrays that show a file to be of that program.
const CIRCLE_RADII: [&str; 2] = ["ce_radius", "mis_radius"];

fn plain(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

pub(crate) fn is_wanted(name: &str) -> bool {
    NAMES.contains(&plain(name).as_str())
}

/// Per line the row of its name among `names`, which grow; empty without names. Whole numbers are names by their digits.
pub(crate) fn of_lines(piece: &PolyData, names: &mut Vec<String>) -> Vec<u32> {
    let has = |name: &str| piece.line_data.iter().chain(&piece.point_data).any(|array| array.name == name);
    let circle = CIRCLE_RADII.iter().any(|name| has(name));
    let texts = NAMES.iter().find_map(|usual| {
        let mut arrays = piece.line_data.iter().filter(|array| plain(&array.name) == *usual);
        arrays.find_map(|array| texts(array, circle))
    });
    let mut row_of: HashMap<String, u32> = names.iter().cloned().zip(0..).collect();
    let mut row = |text: String| {
        *row_of.entry(text).or_insert_with_key(|text| {
            names.push(text.clone());
            names.len() as u32 - 1
        })
    };
    texts.into_iter().flatten().map(|text| row(text.trim().to_owned())).collect()
}

fn texts(array: &Array, circle: bool) -> Option<Vec<String>> {
    let name = |number: &f64| {
        let number = *number as i64;
        let known = CIRCLE.iter().find(|(n, _)| *n == number).filter(|_| circle);
        match known {
            Some((_, name)) => (*name).to_owned(),
            None if circle && number == 0 => String::new(),
            None => number.to_string(),
        }
    };
    match &array.values {
        Values::Texts(texts) => Some(texts.clone()),
        Values::Numbers(numbers) if numbers.iter().all(|x| x.fract() == 0.0) => Some(numbers.iter().map(name).collect()),
        _ => None,
    }
}
