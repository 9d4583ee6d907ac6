//! What each column of the table of a cohort is, as BIDS has it.

use std::collections::HashMap;
use std::sync::LazyLock;

use serde_json::Value;

use willis_models::circle_of_willis::{Artery, FEEDERS, RING, TERRITORIES};

/// The columns by name; a word in braces stands for arteries of a kind.
const COLUMNS: &str = include_str!("descriptions.json");

/// What a column is; `None` for one that is not known.
pub fn describe(column: &str) -> Option<Value> {
    static KNOWN: LazyLock<HashMap<String, String>> = LazyLock::new(known);
    const FETAL: &str = "fetal_{artery}";
    let about = match column.strip_prefix("fetal_") {
        Some(artery) => KNOWN.get(FETAL)?.replace("{artery}", artery),
        None => KNOWN.get(column)?.clone(),
    };
    serde_json::from_str(&about).ok()
}

/// Each column and what it is, as JSON.
fn known() -> HashMap<String, String> {
    let columns: HashMap<String, Value> = serde_json::from_str(COLUMNS).unwrap_or_default();
    let names = |arteries: &[Artery]| arteries.iter().map(ToString::to_string).collect::<Vec<String>>();
    let pairs = names(&RING).iter().filter_map(|name| name.strip_prefix("L-").map(str::to_owned)).collect();
    let kinds =
        [("{segment}", names(&RING)), ("{pair}", pairs), ("{feeder}", names(&FEEDERS)), ("{territory}", names(&TERRITORIES))];
    let all = columns.into_iter().map(|(name, about)| (name, about.to_string())).collect();
    kinds.iter().fold(all, |all: HashMap<String, String>, (kind, arteries)| {
        let (general, mut each): (HashMap<_, _>, HashMap<_, _>) = all.into_iter().partition(|(name, _)| name.contains(kind));
        for (name, about) in general {
            each.extend(arteries.iter().map(|artery| (name.replace(kind, artery), about.replace(kind, artery))));
        }
        each
    })
}
