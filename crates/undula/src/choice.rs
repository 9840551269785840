//! Tables of choices: the values of a setting, with the names that they have in a case.
//!
//! Each table stands beside the type that it names. Reading, messages, writing and `undula keys` use the same table.

use std::mem::discriminant;

/// A value of a setting.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Choice<T> {
    /// The name in a case.
    pub name: &'static str,
    /// The value; parameters of its own are those that hold unless a case gives others.
    pub value: T,
    /// What it is, in one line.
    pub about: &'static str,
}

/// A row of a table.
pub const fn choice<T>(name: &'static str, value: T, about: &'static str) -> Choice<T> {
    Choice { name, value, about }
}

/// The value with this name; `None` if the table has no such name.
pub fn parse<'a, T>(table: &'a [Choice<T>], name: &str) -> Option<&'a T> {
    table.iter().find(|row| row.name == name).map(|row| &row.value)
}

/// The name of `value`, empty if it is not in the table.
pub fn name_of<T: PartialEq>(table: &[Choice<T>], value: &T) -> &'static str {
    table.iter().find(|row| row.value == *value).map_or("", |row| row.name)
}

/// The row with the variant of `value`, whatever its parameters are; `None` if the table has no such row.
pub fn row_of<'a, T>(table: &'a [Choice<T>], value: &T) -> Option<&'a Choice<T>> {
    table.iter().find(|row| discriminant(&row.value) == discriminant(value))
}

/// All names in the order of the table.
pub fn names<T>(table: &[Choice<T>]) -> impl Iterator<Item = &'static str> + Clone + '_ {
    table.iter().map(|row| row.name)
}

/// A table of values of any type.
pub trait Table: Sync {
    /// Name and line of every row.
    fn rows(&self) -> Vec<(&'static str, &'static str)>;
}

impl<T: Sync, const N: usize> Table for [Choice<T>; N] {
    fn rows(&self) -> Vec<(&'static str, &'static str)> {
        self.iter().map(|row| (row.name, row.about)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_name_and_names_by_value() {
        let table = [choice("none", None, ""), choice("some", Some(3), "")];
        assert_eq!(parse(&table, "some"), Some(&Some(3)));
        assert_eq!(parse(&table, "other"), None);
        assert_eq!((name_of(&table, &Some(3)), name_of(&table, &Some(4))), ("some", ""));
        assert_eq!(row_of(&table, &Some(4)).map(|row| row.name), Some("some"));
        assert_eq!(names(&table).collect::<Vec<_>>(), ["none", "some"]);
    }
}
