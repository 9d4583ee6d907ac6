//! What each column of the table of a cohort is, as BIDS has it.

use std::collections::HashMap;
use std::sync::LazyLock;

use serde_json::Value;

use willis_models::circle_of_willis::{Artery, FEEDERS, RING, TERRITORIES};

/// The columns by name; a word in braces stands for arteries of a kind.
const COLUMNS: &str = include_str!("descriptions.json");

/// What a column is; `None` for one that is not known.
pub fn describe(column: &str) -> Option<Value> {
    static KNOWN: LazyLock<HashMap<String, Value>> = LazyLock::new(known);
    const FETAL: &str = "fetal_{artery}";
    let Some(artery) = column.strip_prefix("fetal_") else { return KNOWN.get(column).cloned() };
    let mut about = KNOWN.get(FETAL)?.clone();
    about["Description"] = about["Description"].as_str()?.replace("{artery}", artery).into();
    Some(about)
}

/// Each column and what it is.
fn known() -> HashMap<String, Value> {
    let read = |text: &str| {
        serde_json::from_str(text).expect("the descriptions are part of the program, with names of arteries in them")
    };
    let columns: HashMap<String, Value> = serde_json::from_value(read(COLUMNS)).expect("one object");
    let names = |arteries: &[Artery]| arteries.iter().map(ToString::to_string).collect::<Vec<String>>();
    let pairs = names(&RING).iter().filter_map(|name| name.strip_prefix("L-").map(str::to_owned)).collect();
    let kinds =
        [("{segment}", names(&RING)), ("{pair}", pairs), ("{feeder}", names(&FEEDERS)), ("{territory}", names(&TERRITORIES))];
    let all = columns.into_iter().map(|(name, about)| (name, about.to_string())).collect();
    let all = kinds.iter().fold(all, |all: HashMap<String, String>, (kind, arteries)| {
        let (general, mut each): (HashMap<_, _>, HashMap<_, _>) = all.into_iter().partition(|(name, _)| name.contains(kind));
        for (name, about) in general {
            each.extend(arteries.iter().map(|artery| (name.replace(kind, artery), about.replace(kind, artery))));
        }
        each
    });
    all.into_iter().map(|(name, about)| (name, read(&about))).collect()
}
