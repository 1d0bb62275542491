//! One point of a trend.

use super::body::Point;
use crate::config::JudgedMethod;
use crate::core::bench::BenchItem;
use crate::core::figures::Figures;
use crate::core::judge::{Coefficient, State};
use crate::pipeline::{Names, Statuses, sample_of};

/// A record or an event that an answer holds, and what is shown of the record: another model in force restates it.
pub(super) type Seen = (i64, Option<PointContent>);

/// Value and standard deviation, bit by bit; state and status; whether it is set aside.
pub(super) type PointContent = ([Option<u64>; 2], [&'static str; 2], bool);

/// A record of the gyro; whether it does not count any more, where that is asked for.
pub(super) struct TrendRow {
    pub figures: Figures,
    pub voided: Option<bool>,
    pub set_aside: bool,
}

impl TrendRow {
    pub fn seen(&self, statuses: &Statuses, column: usize, method: JudgedMethod) -> Seen {
        let measured = sample_of(&self.figures, method).d[column];
        let judged = statuses.get(&self.figures, column).name();
        let status = if self.voided == Some(true) { "voided" } else { judged };
        let shown = [Some(measured.value), measured.sd].map(|figure| figure.map(f64::to_bits));
        (self.figures.record.0, Some((shown, [state_of(&self.figures, column), status], self.set_aside)))
    }
}

/// A bench result: its figures never change.
pub(super) fn seen_bench(row: &BenchItem) -> Seen {
    (row.id.0, row.voided.then_some(([None; 2], ["", "voided"], false)))
}

fn state_of(figures: &Figures, column: usize) -> &'static str {
    figures.states.0[column].unwrap_or(State::Indeterminate).name()
}

pub(super) fn separated_point<'t>(
    TrendRow { figures, voided, set_aside }: &TrendRow,
    (column, statuses): (usize, &Statuses),
    method: JudgedMethod,
    names: &'t Names<'_>,
) -> Point<'t> {
    let measured = sample_of(figures, method).d[column];
    Point {
        calibrated_at: figures.at,
        value: measured.value,
        sd: measured.sd,
        method: if figures.published.is_some() { method } else { JudgedMethod::Rigid }.name(),
        imu: Some(names.imu(figures.imu)).filter(|imu| !imu.is_empty()),
        slot: Some(figures.slot.name()),
        station: names.station(figures.station),
        record: figures.record,
        state: Some(state_of(figures, column)),
        status: Some(statuses.get(figures, column).name()),
        voided: *voided,
        set_aside: set_aside.then_some(true),
        level: None,
    }
}

pub(super) fn bench_point<'t>(
    row: &BenchItem,
    voided: Option<bool>,
    coefficient: Coefficient,
    names: &'t Names<'_>,
) -> Option<Point<'t>> {
    let column = coefficient.column().filter(|&column| column < 2)?;
    Some(Point {
        calibrated_at: row.measured_at,
        value: row.d[column],
        sd: row.sd[column],
        method: row.method.name(),
        imu: None,
        slot: None,
        station: names.station(row.station),
        record: row.id,
        state: None,
        status: None,
        voided,
        set_aside: None,
        level: None,
    })
}
