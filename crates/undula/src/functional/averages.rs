//! Weighted means and deviations of a list of numbers, one after another.

/// Means Σ w x / Σ w and sums of squared deviations, by the update of West (1979), which does not cancel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Averages {
    /// Σ w.
    pub weight: f64,
    /// Means.
    pub mean: Vec<f64>,
    /// Σ w (x − mean)².
    pub squares: Vec<f64>,
}

impl Averages {
    /// Of nothing, for lists of `n` numbers.
    pub fn new(n: usize) -> Averages {
        Averages { weight: 0.0, mean: vec![0.0; n], squares: vec![0.0; n] }
    }

    /// Take `values` into account with the weight `weight` above 0.
    pub fn add(&mut self, values: &[f64], weight: f64) {
        self.weight += weight;
        let part = weight / self.weight;
        for ((mean, squares), x) in self.mean.iter_mut().zip(&mut self.squares).zip(values) {
            let before = x - *mean;
            *mean += part * before;
            *squares += weight * before * (x - *mean);
        }
    }

    /// Root of the mean square of the deviation from the mean, of each number.
    pub fn rms(&self) -> Vec<f64> {
        let root = |squares: &f64| (squares.max(0.0) / self.weight).sqrt();
        if self.weight > 0.0 { self.squares.iter().map(root).collect() } else { vec![0.0; self.mean.len()] }
    }
}

/// Oscillatory shear index ½ (1 − |mean τ| / mean |τ|): 0 where the direction does not change, ½ where the mean
/// vanishes; 0 where there is no shear stress.
pub fn oscillatory_shear_index(mean: &[f64], mean_magnitude: f64) -> f64 {
    if mean_magnitude <= 0.0 {
        return 0.0;
    }
    let norm = mean.iter().map(|x| x * x).sum::<f64>().sqrt();
    (0.5 * (1.0 - norm / mean_magnitude)).max(0.0)
}
