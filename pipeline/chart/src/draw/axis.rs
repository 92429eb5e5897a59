//! Logarithmic axes: ranges, places of labels, and their texts.

use std::ops::Range;

/// Labels an axis has at the most.
const MOST: usize = 8;

/// Multiples of a power of ten that get a label, from dense to sparse.
const STEPS: [&[f64]; 5] = [
    &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
    &[1.0, 1.5, 2.0, 3.0, 4.0, 6.0],
    &[1.0, 2.0, 5.0],
    &[1.0, 3.0],
    &[1.0],
];

/// A range that has all values inside, with a margin of `share` of its logarithm on each side.
/// Values that are not above zero have no place and are passed over.
pub(super) fn range(values: impl Iterator<Item = f64>, share: f64) -> Range<f64> {
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for x in values.filter(|x| *x > 0.0 && x.is_finite()) {
        (low, high) = (low.min(x), high.max(x));
    }
    if low > high {
        return 0.1..1.0;
    }
    // a single value still gets half a decade
    let spread = (high / low).log10().max(0.5);
    let margin = 10f64.powf(share * spread);
    let middle = (low * high).sqrt();
    let half = 10f64.powf(0.5 * spread);
    (low.min(middle / half) / margin)..(high.max(middle * half) * margin)
}

/// Where the labels of a range stand: the densest choice of at most [`MOST`].
pub(super) fn ticks(range: &Range<f64>) -> Vec<f64> {
    let first = range.start.log10().floor() as i32;
    let last = range.end.log10().ceil() as i32;
    // then whole powers of ten, ever fewer of them
    let sparser = (2..).map(|decades| (decades, [1.0].as_slice()));
    let choices = STEPS.into_iter().map(|steps| (1, steps)).chain(sparser);
    let labels = choices.map(|(decades, steps)| -> Vec<f64> {
        (first..=last)
            .filter(|e| e.rem_euclid(decades) == 0)
            .flat_map(|e| steps.iter().map(move |m| m * 10f64.powi(e)))
            .filter(|x| range.contains(x))
            .collect()
    });
    labels
        .into_iter()
        .find(|l| l.len() <= MOST)
        .unwrap_or_default()
}

/// 2000000 as 2M, 0.0300 as 0.03.
pub(super) fn tidy(x: f64) -> String {
    if x >= 1e6 {
        format!("{}M", round(x / 1e6))
    } else if x >= 1e3 {
        format!("{}k", round(x / 1e3))
    } else {
        round(x)
    }
}

/// Two digits that count.
fn round(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let digits = (1 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short() {
        for (x, wanted) in [
            (0.0, "0"),
            (0.03, "0.03"),
            (1.0, "1"),
            (2.5, "2.5"),
            (30.0, "30"),
            (20_000.0, "20k"),
            (1.5e6, "1.5M"),
        ] {
            assert_eq!(tidy(x), wanted);
        }
    }

    /// Whatever the values: all inside, some labels and not too many.
    #[test]
    fn every_range_has_labels() {
        for low in [1e-9, 0.07, 1.0, 9.99, 3e4, 1e12] {
            for times in [1.0, 1.0001, 1.7, 9.0, 120.0, 1e5, 1e30] {
                let range = range([low, low * times].into_iter(), 0.05);
                assert!(range.contains(&low) && range.contains(&(low * times)));
                let ticks = ticks(&range);
                assert!((2..=MOST).contains(&ticks.len()), "{range:?}: {ticks:?}");
                assert!(ticks.windows(2).all(|pair| pair[0] < pair[1]));
                assert!(ticks.iter().all(|x| range.contains(x)));
            }
        }
    }

    #[test]
    fn what_has_no_place_is_passed_over() {
        let wanted = range([2.0, 3.0].into_iter(), 0.1);
        assert_eq!(
            range(
                [2.0, -1.0, 0.0, f64::NAN, f64::INFINITY, 3.0].into_iter(),
                0.1
            ),
            wanted
        );
        assert_eq!(range(std::iter::empty(), 0.1), 0.1..1.0);
    }
}
