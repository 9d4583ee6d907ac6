//! Suggests names near to one that is unknown.

use super::distinct;

/// The names from the nearest to the furthest, each once.
///
/// Near is by edit distance (insertions, deletions, substitutions and swaps of neighbours), without regard to case, with or without
/// what separates words, whichever is nearer; equally near names are in alphabetical order, and of those with the same letters the one with nearer separators comes first.
pub fn nearest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names = distinct(names.into_iter().filter(|name| !name.is_empty()));
    let raw = |name: &str| strsim::osa_distance(&wanted.to_lowercase(), &name.to_lowercase());
    names.sort_by_cached_key(|name| (distance(wanted, name).0, plain(name), raw(name)));
    names
}

/// `did you mean "mmHg"? `, with a blank after it, for the nearest name; empty when no name is so near that no more than a third
/// of the longer one differs.
pub fn did_you_mean<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let wanted = wanted.trim();
    let is_near = |name: &&str| {
        let (distance, longer) = distance(wanted, name);
        3 * distance <= longer
    };
    match nearest(wanted, names).first().filter(|name| is_near(name)) {
        Some(name) if !wanted.is_empty() => format!("did you mean \"{name}\"? "),
        _ => String::new(),
    }
}

/// Letters and digits alone, in lower case.
fn plain(text: &str) -> String {
    text.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_lowercase()
}

/// The edit distance, and the length of the longer text, with separators or without, whichever is nearer.
fn distance(wanted: &str, name: &str) -> (usize, usize) {
    let of = |a: &str, b: &str| (strsim::osa_distance(a, b), a.chars().count().max(b.chars().count()));
    let as_given = of(&wanted.to_lowercase(), &name.to_lowercase());
    let (a, b) = (plain(wanted), plain(name));
    let squeezed = if a.is_empty() || b.is_empty() { as_given } else { of(&a, &b) };
    if squeezed.0 < as_given.0 { squeezed } else { as_given }
}
