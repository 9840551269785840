//! Numbers in single and in double precision, and what adds to entries that are such.

/// `f32` or `f64`.
pub trait Value: Copy + Default + std::fmt::Debug + Send + Sync + 'static {
    /// Rounds.
    fn of(x: f64) -> Self;

    /// The same number in double precision.
    fn double(self) -> f64;

    /// Entries to add to.
    fn sink(values: &mut [Self]) -> Sink<'_>;
}

impl Value for f32 {
    #[inline(always)]
    fn of(x: f64) -> f32 {
        x as f32
    }

    #[inline(always)]
    fn double(self) -> f64 {
        f64::from(self)
    }

    fn sink(values: &mut [f32]) -> Sink<'_> {
        Sink::Single(values)
    }
}

impl Value for f64 {
    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn double(self) -> f64 {
        self
    }

    fn sink(values: &mut [f64]) -> Sink<'_> {
        Sink::Double(values)
    }
}

/// The entries of a matrix, to which operators add.
#[derive(Debug)]
pub enum Sink<'a> {
    /// In double precision.
    Double(&'a mut [f64]),
    /// In single precision.
    Single(&'a mut [f32]),
}

impl Sink<'_> {
    /// The same entries, for a shorter time.
    pub fn again(&mut self) -> Sink<'_> {
        match self {
            Sink::Double(values) => Sink::Double(values),
            Sink::Single(values) => Sink::Single(values),
        }
    }

    /// Add `x` to an entry.
    ///
    /// # Panics
    /// If there is none with this number.
    #[inline]
    pub fn add(&mut self, entry: usize, x: f64) {
        match self {
            Sink::Double(values) => values[entry] += x,
            Sink::Single(values) => values[entry] += x as f32,
        }
    }
}
