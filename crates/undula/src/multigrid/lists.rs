//! Lists of numbers, one behind the other.

/// Lists of different lengths in one vector.
#[derive(Clone, Debug)]
pub struct Lists<T> {
    ends: Vec<usize>,
    items: Vec<T>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Lists { ends: vec![], items: vec![] }
    }
}

impl<T> Lists<T> {
    /// Adds a list.
    pub fn push(&mut self, list: impl IntoIterator<Item = T>) {
        self.items.extend(list);
        self.ends.push(self.items.len());
    }

    /// Number of lists.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Where list `n` begins among all items.
    pub fn start(&self, n: usize) -> usize {
        if n == 0 { 0 } else { self.ends[n - 1] }
    }

    /// List `n`.
    pub fn get(&self, n: usize) -> &[T] {
        &self.items[self.start(n)..self.ends[n]]
    }

    /// All lists.
    pub fn iter(&self) -> impl Iterator<Item = &[T]> {
        (0..self.len()).map(|n| self.get(n))
    }

    /// All items.
    pub fn items(&self) -> &[T] {
        &self.items
    }
}

impl Lists<u32> {
    /// For each of `n` numbers the places among all items at which it stands.
    pub fn places(&self, n: usize) -> Lists<u32> {
        let mut ends = vec![0; n + 1];
        self.items.iter().for_each(|&item| ends[item as usize + 1] += 1);
        (0..n).for_each(|item| ends[item + 1] += ends[item]);
        let mut places = vec![0; self.items.len()];
        for (place, &item) in self.items.iter().enumerate() {
            places[ends[item as usize]] = place as u32;
            ends[item as usize] += 1;
        }
        ends.pop();
        Lists { ends, items: places }
    }
}
