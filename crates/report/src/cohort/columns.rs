//! What each column of the table of a cohort is, as BIDS has it, and where records have its figure.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::LazyLock;

use serde_json::{Map, Value, json};

use willis_models::circle_of_willis::{Artery, FEEDERS, RING, TERRITORIES};

/// The columns in their order: the name, in which a word in braces stands for arteries of a kind; by the name of a command the place of the figure in
/// its record, and of what it is divided by; and what BIDS says of a column.
static COLUMNS: LazyLock<Vec<Map<String, Value>>> = LazyLock::new(|| read(include_str!("columns.json")));

fn read<T: serde::de::DeserializeOwned>(text: &str) -> T {
    serde_json::from_str(text).expect("the columns are part of the program, with names of arteries in them")
}

/// The figures that the record of a command states, by column; null where one is missing.
pub(super) fn stated(command: &str, record: &Value) -> impl Iterator<Item = (Cow<'static, str>, Value)> {
    let number = |pointer: &Value| record.pointer(pointer.as_str()?)?.as_f64();
    COLUMNS.iter().filter_map(move |column| {
        let mut figure = number(column.get(command)?);
        if let Some(all) = column.get("over") {
            figure = figure.zip(number(all)).filter(|(_, all)| *all > 0.0).map(|(part, all)| part / all);
        }
        Some((column["column"].as_str()?.into(), json!(figure)))
    })
}

/// What a column is; `None` for one that is not known.
pub fn describe(column: &str) -> Option<Value> {
    static KNOWN: LazyLock<HashMap<String, Value>> = LazyLock::new(known);
    KNOWN.get(column).cloned()
}

/// Each column and what it is.
fn known() -> HashMap<String, Value> {
    let names = |arteries: &[Artery]| arteries.iter().map(ToString::to_string).collect::<Vec<String>>();
    let pairs = names(&RING).iter().filter_map(|name| name.strip_prefix("L-").map(str::to_owned)).collect();
    let kinds =
        [("{segment}", names(&RING)), ("{pair}", pairs), ("{feeder}", names(&FEEDERS)), ("{territory}", names(&TERRITORIES))];
    let about = |column: &Map<String, Value>| {
        let mut about = column.clone();
        about.retain(|key, _| key.starts_with(char::is_uppercase));
        Some((column["column"].as_str()?.to_owned(), json!(about).to_string()))
    };
    let mut all: HashMap<String, String> = COLUMNS.iter().filter_map(about).collect();
    for (kind, arteries) in &kinds {
        // A column of another kind stays as it is with each of them.
        let of = |(name, about): (String, String)| arteries.iter().map(move |a| (name.replace(kind, a), about.replace(kind, a)));
        all = all.into_iter().flat_map(of).collect();
    }
    all.into_iter().map(|(name, about)| (name, read(&about))).collect()
}
