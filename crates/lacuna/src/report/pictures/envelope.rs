//! Fewer numbers that hide nothing: the smallest and largest value of every stretch.

/// A series in stretches of equal length, the last one possibly shorter.
#[derive(Debug, Clone, PartialEq)]
pub struct Envelope {
    /// Samples per stretch.
    pub every: usize,
    /// Smallest value of each stretch.
    pub low: Vec<f64>,
    /// Largest value of each stretch.
    pub high: Vec<f64>,
}

/// The envelope of `values` with at most `most` stretches (at least one): no spike is lost, as it would be
/// by keeping every so-many-th value or by averaging. Values that are not numbers are passed over; a
/// stretch of nothing else is `NaN`.
pub fn envelope(values: &[f64], most: usize) -> Envelope {
    let every = values.len().div_ceil(most.max(1)).max(1);
    let least = |part: &[f64]| part.iter().copied().fold(f64::NAN, f64::min);
    let largest = |part: &[f64]| part.iter().copied().fold(f64::NAN, f64::max);
    Envelope {
        every,
        low: values.chunks(every).map(least).collect(),
        high: values.chunks(every).map(largest).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn one_spike_in_a_million_is_still_there() {
        let mut values = vec![0.0; 1_000_000];
        values[765_432] = -3.0;
        let small = envelope(&values, 1000);
        assert_eq!((small.every, small.low.len()), (1000, 1000));
        assert!((small.low[765] + 3.0).abs() < 1e-15 && small.high[765].abs() < 1e-15);
    }

    #[test]
    fn few_values_stay_as_they_are() {
        let small = envelope(&[1.0, -2.0, 3.0], 10);
        assert_eq!(small.every, 1);
        assert_eq!(small.low, small.high);
        assert_eq!(small.low, vec![1.0, -2.0, 3.0]);
        assert!(envelope(&[], 10).low.is_empty());
    }

    proptest! {
        #[test]
        fn every_value_lies_in_its_stretch(
            values in proptest::collection::vec(-1e6..1e6f64, 1..400),
            most in 1usize..50,
        ) {
            let small = envelope(&values, most);
            prop_assert!(small.low.len() <= most);
            prop_assert_eq!(small.low.len(), values.len().div_ceil(small.every));
            for (k, value) in values.iter().enumerate() {
                let at = k / small.every;
                prop_assert!(small.low[at] <= *value && *value <= small.high[at]);
            }
            for (at, part) in values.chunks(small.every).enumerate() {
                prop_assert!(part.contains(&small.low[at]) && part.contains(&small.high[at]));
            }
        }
    }
}
