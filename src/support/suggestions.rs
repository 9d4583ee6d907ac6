//! Suggests names near to one that is unknown.

/// The names from the nearest to the furthest, each once.
///
/// Near is by edit distance (insertions, deletions, substitutions and swaps of neighbours), without regard to case; equally
/// near names are in alphabetical order.
pub fn nearest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names: Vec<&str> = names.into_iter().filter(|name| !name.is_empty()).collect();
    names.sort_unstable();
    names.dedup();
    let wanted = wanted.to_lowercase();
    names.sort_by_cached_key(|name| distance(&wanted, name));
    names
}

/// `did you mean "mmHg"? `, with a blank after it, for the nearest name; empty when no name is so near that no more than a third
/// of the longer one differs.
pub fn did_you_mean<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let wanted = wanted.trim();
    let is_near = |name: &&str| {
        let longer = wanted.chars().count().max(name.chars().count());
        3 * distance(&wanted.to_lowercase(), name) <= longer
    };
    match nearest(wanted, names).first().filter(|name| is_near(name)) {
        Some(name) if !wanted.is_empty() => format!("did you mean \"{name}\"? "),
        _ => String::new(),
    }
}

fn distance(wanted: &str, name: &str) -> usize {
    strsim::osa_distance(wanted, &name.to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::{did_you_mean, nearest};

    #[test]
    fn the_nearest_name_comes_first_and_only_a_near_one_is_offered() {
        let labels = ["R-M1", "L-M1", "BA", "L-A1", "L-M1"];
        assert_eq!(nearest("L-MM1", labels)[..2], ["L-M1", "L-A1"]);
        assert_eq!(did_you_mean("l-m1", labels), "did you mean \"L-M1\"? ");
        assert_eq!(did_you_mean("mmhg", ["Pa", "mmHg"]), "did you mean \"mmHg\"? ");
        // One of two letters is half of the name, and nothing is near to nothing.
        for far in ["VA", "basilar", "", " "] {
            assert_eq!(did_you_mean(far, labels), "", "{far}");
        }
        assert_eq!(did_you_mean("x", []), "");
    }
}
