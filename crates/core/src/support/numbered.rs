//! Lists with an entry per numbered item, such as a node or a vessel, made of what is said of some of the numbers.

/// Of each of `count` numbers what is given with it, in the order in which it is given.
pub fn grouped<T: Clone>(count: usize, given: impl IntoIterator<Item = (usize, T)>) -> Vec<Vec<T>> {
    let mut groups = vec![Vec::new(); count];
    for (number, item) in given {
        groups[number].push(item);
    }
    groups
}

/// How often each of `count` numbers is given.
pub fn counted(count: usize, given: impl IntoIterator<Item = usize>) -> Vec<usize> {
    let mut times = vec![0; count];
    given.into_iter().for_each(|number| times[number] += 1);
    times
}

/// Which of `count` numbers are given.
pub fn marked(count: usize, given: impl IntoIterator<Item = usize>) -> Vec<bool> {
    let mut marks = vec![false; count];
    given.into_iter().for_each(|number| marks[number] = true);
    marks
}

/// The place of each of `count` numbers among those given; `usize::MAX` for one that is not.
pub fn placed(count: usize, given: impl IntoIterator<Item = usize>) -> Vec<usize> {
    let mut places = vec![usize::MAX; count];
    given.into_iter().enumerate().for_each(|(place, number)| places[number] = place);
    places
}

/// In which of some lists each of `count` numbers is; `None` for one that is in none.
pub fn list_of(count: usize, lists: &[Vec<usize>]) -> Vec<Option<usize>> {
    let mut found = vec![None; count];
    for (list, numbers) in lists.iter().enumerate() {
        for number in numbers {
            found[*number] = Some(list);
        }
    }
    found
}
