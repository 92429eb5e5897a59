//! Scales of axes: ranges, places of labels, and their texts.

use super::description::Axis;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// Labels an axis has at the most.
const MOST: usize = 8;
/// Space that a logarithmic range has beyond its values on each side, as a share of it.
const MARGIN: f64 = 0.06;

/// Multiples of a power of ten that get a label, from dense to sparse.
const STEPS: [&[f64]; 5] = [
    &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
    &[1.0, 1.5, 2.0, 3.0, 4.0, 6.0],
    &[1.0, 2.0, 5.0],
    &[1.0, 3.0],
    &[1.0],
];

/// An axis with a range.
#[derive(Clone)]
pub(super) struct Scale {
    is_log: bool,
    /// Values from end to end.
    ends: Range<f64>,
    /// Values that have labels.
    ticks: Vec<f64>,
}

impl Scale {
    /// A scale that has all values inside that have a place.
    pub(super) fn new(axis: Axis, values: impl Iterator<Item = f64>) -> Scale {
        let is_log = axis.is_log;
        if is_log {
            let ends = log_range(values);
            let ticks = log_ticks(&ends);
            return Scale {
                is_log,
                ends,
                ticks,
            };
        }
        let end = values.filter(|x| x.is_finite()).fold(1.0, f64::max);
        let decade = 10f64.powf(end.log10().floor());
        let steps = [0.2, 0.5, 1.0, 2.0].map(|step| step * decade);
        let few = |step: &f64| end / step < MOST as f64;
        let step = steps.into_iter().find(few).unwrap_or(2.0 * decade);
        let ticks = (0..MOST).map(|k| k as f64 * step);
        Scale {
            is_log,
            ticks: ticks.filter(|x| *x <= end).collect(),
            ends: 0.0..end,
        }
    }

    /// Whether a value has a place.
    pub(super) fn has(&self, value: f64) -> bool {
        value.is_finite() && (value > 0.0 || !self.is_log)
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (low, high): (i32, i32)) -> i32 {
        let place = |x: f64| if self.is_log { x.log10() } else { x };
        let (start, end) = (place(self.ends.start), place(self.ends.end));
        let share = (place(*value) - start) / (end - start);
        low + (share * f64::from(high - low)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.ends.clone()
    }
}

impl ValueFormatter<f64> for Scale {
    fn format(value: &f64) -> String {
        label(*value)
    }
}

/// A range that has all values inside, with a margin.
fn log_range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for x in values.filter(|x| *x > 0.0 && x.is_finite()) {
        (low, high) = (low.min(x), high.max(x));
    }
    if low > high {
        return 0.1..1.0;
    }
    // a single value still gets half a decade
    let spread = (high / low).log10().max(0.5);
    let margin = 10f64.powf(MARGIN * spread);
    let middle = (low * high).sqrt();
    let half = 10f64.powf(0.5 * spread);
    (low.min(middle / half) / margin)..(high.max(middle * half) * margin)
}

/// Values of a range's labels: the densest choice of at most [`MOST`].
fn log_ticks(range: &Range<f64>) -> Vec<f64> {
    let first = range.start.log10().floor() as i32;
    let last = range.end.log10().ceil() as i32;
    // then whole powers of ten, ever fewer of them
    let sparser = (2..).map(|decades| (decades, [1.0].as_slice()));
    let choices = STEPS.into_iter().map(|steps| (1, steps)).chain(sparser);
    let mut labels = choices.map(|(decades, steps)| -> Vec<f64> {
        (first..=last)
            .filter(|e| e.rem_euclid(decades) == 0)
            .flat_map(|e| steps.iter().map(move |m| m * 10f64.powi(e)))
            .filter(|x| range.contains(x))
            .collect()
    });
    labels.find(|l| l.len() <= MOST).unwrap_or_default()
}

/// 2000000 as 2M, 0.0300 as 0.03.
fn label(x: f64) -> String {
    let (x, unit) = match x {
        _ if x >= 1e6 => (x / 1e6, "M"),
        _ if x >= 1e3 => (x / 1e3, "k"),
        _ => (x, ""),
    };
    let digits = 1 - x.abs().max(1e-9).log10().floor() as i32;
    let text = format!("{x:.0$}", digits.clamp(0, 9) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string() + unit,
        false => text + unit,
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
            assert_eq!(label(x), wanted);
        }
    }

    /// Whatever the values: all inside, some labels and not too many.
    #[test]
    fn every_range_has_labels() {
        let is_log = |is_log| Axis { title: "", is_log };
        for low in [1e-9, 0.07, 1.0, 9.99, 3e4, 1e12] {
            for times in [1.0, 1.0001, 1.7, 9.0, 120.0, 1e5, 1e30] {
                for axis in [is_log(true), is_log(false)] {
                    let scale = Scale::new(axis, [low, low * times].into_iter());
                    let Range { start, end } = scale.ends;
                    assert!(start <= low && low * times <= end);
                    assert!((2..=MOST).contains(&scale.ticks.len()), "{start} to {end}");
                    assert!(scale.ticks.iter().all(|x| start <= *x && *x <= end));
                    assert!(scale.ticks.windows(2).all(|pair| pair[0] < pair[1]));
                }
            }
        }
    }

    #[test]
    fn what_has_no_place_is_passed_over() {
        let odd = [2.0, -1.0, 0.0, f64::NAN, f64::INFINITY, 3.0];
        assert_eq!(
            log_range(odd.into_iter()),
            log_range([2.0, 3.0].into_iter())
        );
        assert_eq!(log_range(std::iter::empty()), 0.1..1.0);
    }
}
