//! A gyro's history as numbers for the script that draws it, in a block of JSON that is no script.

use std::collections::HashMap;

use maud::{Markup, PreEscaped, html};
use serde::Serialize;

use super::text::Text;
use crate::core::judge::Measured;
use crate::core::judge::Status;
use crate::core::time::UtcMicros;
use crate::pages::downsample;

/// Points of one coefficient at the most: more would weigh more than a page should and show no more.
const MOST_POINTS: usize = 1000;

/// One measured value with what is said when the pointer is over it.
#[derive(Clone)]
pub(super) struct Point {
    pub at: UtcMicros,
    pub measured: Measured,
    /// None for what is not judged.
    pub status: Option<Status>,
    /// Where and by whom it was measured.
    pub place: String,
}

/// Values of one coefficient by one method.
#[derive(Serialize)]
pub(super) struct Series {
    name: String,
    /// Drawn as diamonds beside the main series.
    pub bench: bool,
    /// Milliseconds since 1970.
    pub t: Vec<i64>,
    pub v: Vec<f64>,
    pub sd: Option<Vec<Option<f64>>>,
    /// Place in [`Status::ALL`]; 0, the first, for what is not judged.
    pub status: Vec<u8>,
    /// Index into `places`.
    place: Vec<u32>,
    places: Vec<String>,
    /// How many there were before thinning.
    of: usize,
}

/// From, to, level, budget, and how far from the level its control limits lie.
pub(super) type Band = (i64, i64, f64, Option<f64>, Option<f64>);

/// One coefficient's strip.
#[derive(Serialize)]
pub(super) struct Strip {
    pub symbol: &'static str,
    pub series: Vec<Series>,
    pub bands: Vec<Band>,
    /// How far its axis reaches on either side of a value that stands alone: the budget.
    pub around: f64,
}

#[derive(Serialize)]
pub(super) struct Mark {
    pub t: i64,
    /// When it was over, of what took time.
    pub until: Option<i64>,
    pub label: String,
    pub event: bool,
}

/// What the script needs to draw one gyro.
#[derive(Serialize)]
pub(super) struct Plot {
    pub name: String,
    pub unit: &'static str,
    pub strips: Vec<Strip>,
    pub marks: Vec<Mark>,
    /// Names and words, as `Series::status` counts them.
    pub statuses: [(&'static str, &'static str); 9],
    /// Where the newest baseline begins.
    pub since: Option<i64>,
    /// [`ALONE`].
    pub alone: i64,
}

impl Series {
    /// Of all `rows`, in order of time, those that make the picture; only those become points.
    pub fn new<T>(name: &str, bench: bool, rows: &[T], value: impl Fn(&T) -> f64, point: impl Fn(&T) -> Point) -> Self {
        let kept: Vec<Point> = shown(rows, value).into_iter().map(point).collect();
        let mut places = Vec::new();
        let mut known = HashMap::<&str, u32>::new();
        let place = kept.iter().map(|point| {
            *known.entry(&point.place).or_insert_with(|| {
                places.push(point.place.clone());
                places.len() as u32 - 1
            })
        });
        let place = place.collect();
        let any_sd = kept.iter().any(|point| point.measured.sd.is_some());
        Self {
            name: name.to_owned(),
            bench,
            t: kept.iter().map(|point| millis(point.at)).collect(),
            v: kept.iter().map(|point| rounded(point.measured.value)).collect(),
            sd: any_sd.then(|| kept.iter().map(|point| point.measured.sd.map(rounded)).collect()),
            status: kept.iter().map(code).collect(),
            place,
            places,
            of: rows.len(),
        }
    }

    /// Whether points were left out, and how many there were.
    pub fn thinned(&self) -> Option<usize> {
        (self.of > self.t.len()).then_some(self.of)
    }
}

/// The rows that make the picture.
pub(super) fn shown<T>(rows: &[T], value: impl Fn(&T) -> f64) -> Vec<&T> {
    let values: Vec<f64> = rows.iter().map(value).collect();
    downsample::indices(&values, MOST_POINTS).into_iter().map(|i| &rows[i]).collect()
}

impl Plot {
    /// Where the script puts the plot, and the numbers for it.
    pub fn markup(&self, t: &Text) -> Markup {
        let numbers = serde_json::to_string(self).expect("numbers and text can always be written to memory");
        // The only thing that could end the block early.
        let numbers = numbers.replace('<', "\\u003c");
        html! {
            div.plot-tools hidden {
                @if self.since.is_some() { button type="button" data-zoom="since" aria-pressed="false" { (t.since_baseline) } }
                button type="button" data-zoom="all" aria-pressed="true" { (t.whole_history) }
                button type="button" data-zoom="picture" { (t.save_picture) }
            }
            div.plot data-plot="history" {}
            script type="application/json" { (PreEscaped(numbers)) }
        }
    }
}

/// How far the axis of time reaches on either side of an instant that stands alone, ms.
pub(super) const ALONE: i64 = 15 * 86_400_000;

pub(super) fn millis(at: UtcMicros) -> i64 {
    at.0.div_euclid(1000)
}

fn code(point: &Point) -> u8 {
    let place = Status::ALL.iter().position(|status| Some(*status) == point.status);
    place.unwrap_or(0) as u8
}

/// To 1e-9 deg/(h g0): a millionth of what is judged, and half the weight.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_points(points: &[Point]) -> Series {
        Series::new("rigid", false, points, |point| point.measured.value, Point::clone)
    }

    #[test]
    fn what_a_station_calls_itself_cannot_end_the_block() {
        let point =
            Point { at: UtcMicros(1_000), measured: Measured::exact(1.0), status: None, place: "</script><b>".into() };
        let strips = vec![Strip { symbol: "D_I", series: vec![of_points(&[point])], bands: vec![], around: 0.01 }];
        let plot = Plot {
            name: "</script>".into(),
            unit: "",
            strips,
            marks: vec![],
            statuses: [("", ""); 9],
            since: None,
            alone: ALONE,
        };
        let markup = plot.markup(super::super::text::Language::English.text()).into_string();
        assert_eq!(markup.matches("</script>").count(), 1, "{markup}");
    }

    #[test]
    fn a_long_history_is_thinned_and_says_so() {
        let point = |i: i64| Point {
            at: UtcMicros(i * UtcMicros::DAY),
            measured: Measured::exact(if i == 7_777 { 9.0 } else { (i as f64).sin() }),
            status: None,
            place: String::new(),
        };
        let points: Vec<Point> = (0..20_000).map(point).collect();
        let series = of_points(&points);
        assert_eq!(series.thinned(), Some(20_000));
        assert!(series.v.contains(&9.0) && series.v.len() <= MOST_POINTS && series.places.len() == 1);
    }
}
