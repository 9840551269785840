//! Which group each cell of a VTU file is in: names are made of its arrays.

use super::data::{Array, Values};
use std::collections::BTreeMap;

/// Arrays of numbers that are taken for those of groups, in this order.
const NUMBERED: [&str; 10] = [
    "region",
    "boundary",
    "group",
    "gmsh:physical",
    "physical",
    "CellEntityIds",
    "medit:ref",
    "cell_tags",
    "MaterialID",
    "material",
];

/// Between the names of the sets of meshio, as it chooses them.
const SEPARATORS: [char; 10] = ['-', '_', '#', '+', '/', '|', ':', ';', '.', ','];

/// The names of the groups of a cell: none, one, or several, which is a mistake.
pub(super) type Names = Vec<String>;

/// Names for `n` cells of the dimensions `dims`, by the first of these that names a cell:
///
/// 1. an array of words;
/// 2. an array of whole numbers called as all sets together, such as `fluid-solid-walls`, as meshio writes its cell sets;
/// 3. arrays of 0 and 1 with the name of a group, 1 in its cells;
/// 4. an array of whole numbers called `region`, `gmsh:physical` or alike: the name is the number, but that which other
///    cells of this number and dimension have by 1 to 3 if they agree.
pub(super) fn names(arrays: &[Array], dims: &[usize]) -> Vec<Names> {
    let n = dims.len();
    let fit = || arrays.iter().filter(|a| a.components == 1 && a.len() == n);
    let mut names: Vec<Names> = vec![vec![]; n];
    let words = fit().filter_map(|a| match &a.values {
        Values::Words(words) => Some(words),
        _ => None,
    });
    if let Some(words) = words.into_iter().next() {
        names.iter_mut().zip(words).filter(|(_, word)| !word.trim().is_empty()).for_each(|(n, word)| {
            n.push(word.clone());
        });
    }
    let numbers = || fit().filter_map(|a| Some((a.name.as_str(), a.whole()?)));
    for (name, numbers) in numbers() {
        let Some(sets) = sets(name, &numbers) else { continue };
        for (names, &number) in names.iter_mut().zip(&numbers).filter(|(names, _)| names.is_empty()) {
            let set = usize::try_from(number).ok().and_then(|i| sets.get(i));
            names.extend(set.filter(|set| !set.contains(':')).map(|set| set.to_string()));
        }
    }
    let unnamed: Vec<bool> = names.iter().map(Vec::is_empty).collect();
    let is_mark = |name: &str, numbers: &[i64]| {
        let own = !NUMBERED.contains(&name) && !name.contains(':') && !name.starts_with("vtk");
        own && !name.trim().is_empty() && numbers.iter().all(|x| [0, 1].contains(x))
    };
    for (name, numbers) in numbers().filter(|(name, numbers)| is_mark(name, numbers)) {
        let marked = (0..n).filter(|&i| numbers[i] == 1 && unnamed[i]);
        marked.for_each(|i| names[i].push(name.to_string()));
    }
    let numbered = NUMBERED.iter().find_map(|wanted| numbers().find(|(name, _)| name == wanted));
    if let Some((_, numbers)) = numbered {
        by_number(&mut names, &numbers, dims);
    }
    names
}

/// Names of cells that have none by their numbers.
fn by_number(names: &mut [Names], numbers: &[i64], dims: &[usize]) {
    let mut known: BTreeMap<(usize, i64), Option<String>> = BTreeMap::new();
    for (i, names) in names.iter().enumerate() {
        if let [name] = &names[..] {
            let entry = known.entry((dims[i], numbers[i])).or_insert_with(|| Some(name.clone()));
            if entry.as_ref() != Some(name) {
                *entry = None;
            }
        }
    }
    for (i, names) in names.iter_mut().enumerate().filter(|(_, names)| names.is_empty()) {
        let name = known.get(&(dims[i], numbers[i])).cloned().flatten();
        names.push(name.unwrap_or_else(|| numbers[i].to_string()));
    }
}

/// The sets that an array of meshio is called after, if it is one.
fn sets<'a>(name: &'a str, numbers: &[i64]) -> Option<Vec<&'a str>> {
    let most = usize::try_from(*numbers.iter().max()?).ok()?;
    let parts = |c: &char| name.split(*c).collect::<Vec<_>>();
    let sets = SEPARATORS.iter().map(parts).find(|parts| parts.len() > 1)?;
    let is_index = numbers.iter().all(|&x| x >= -1);
    (is_index && most < sets.len() && most > 0 && !NUMBERED.contains(&name)).then_some(sets)
}
