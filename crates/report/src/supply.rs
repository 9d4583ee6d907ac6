//! supply.csv: who feeds each territory and outlet of a circle, and how late, over the plausible topologies.

use serde_json::{Map, Value, json};

use super::simulation::transport::end_name;
use willis_core::network::Network;
use willis_core::network::units::milliseconds;
use willis_io::formats::Column;
use willis_models::circle_of_willis::{Destination, FEEDERS, Spread, Supply};

fn name(network: &Network, destination: Destination) -> String {
    match destination {
        Destination::Territory(artery) => artery.to_string(),
        Destination::Outlet(node) => end_name(network, node),
    }
}

/// The columns of supply.csv: a row for every territory and outlet and every feeder.
pub fn supply_columns(network: &Network, supplies: &[Supply]) -> Vec<Column> {
    let rows = || supplies.iter().flat_map(|supply| (0..FEEDERS.len()).map(move |feeder| (supply, feeder)));
    let text = |name: &'static str, of: &dyn Fn(&Supply, usize) -> String| Column::text(name, rows().map(|(s, f)| of(s, f)));
    let real = |name: &'static str, of: &dyn Fn(&Supply, usize) -> f64| Column::real(name, rows().map(|(s, f)| of(s, f)));
    let spread = |names: [&'static str; 3], of: &dyn Fn(&Supply, usize) -> Spread| {
        [
            real(names[0], &|s, f| of(s, f).middle),
            real(names[1], &|s, f| of(s, f).interval[0]),
            real(names[2], &|s, f| of(s, f).interval[1]),
        ]
    };
    let arrival = |supply: &Supply, _: usize| {
        let Spread { middle, interval } = supply.arrival;
        Spread { middle: milliseconds(middle), interval: interval.map(milliseconds) }
    };
    let mut columns = vec![
        text("kind", &|s, _| if matches!(s.destination, Destination::Outlet(_)) { "outlet" } else { "territory" }.to_owned()),
        text("name", &|s, _| name(network, s.destination)),
        text("feeder", &|_, f| FEEDERS[f].to_string()),
        real("p_fed", &|s, _| s.fed),
    ];
    columns.extend(spread(["supply", "supply_low", "supply_high"], &|s, f| s.shares[f]));
    columns.extend(spread(["arrival_ms", "arrival_low_ms", "arrival_high_ms"], &arrival));
    columns
}

/// For each territory the shares of its blood by feeder, with their means, and the mean time since it entered in ms, with its median; each with its interval.
pub fn supply_json(network: &Network, supplies: &[Supply]) -> Value {
    let spread = |middle: &str, spread: &Spread, unit: fn(f64) -> f64| json!({ middle: unit(spread.middle), "interval_90": spread.interval.map(unit) });
    let each = |supply: &Supply| {
        let shares = FEEDERS.iter().zip(&supply.shares).map(|(feeder, share)| (feeder.to_string(), spread("mean", share, |x| x)));
        let shares: Map<String, Value> = shares.collect();
        let arrival = spread("median", &supply.arrival, milliseconds);
        (name(network, supply.destination), json!({ "p_fed": supply.fed, "shares": shares, "arrival_ms": arrival }))
    };
    let territories = supplies.iter().filter(|supply| matches!(supply.destination, Destination::Territory(_)));
    Value::Object(territories.map(each).collect())
}
