//! One point of a trend.

use super::body::Point;
use crate::config::JudgedMethod;
use crate::core::figures::Figures;
use crate::core::judge::{Coefficient, State as Judgement};
use crate::pipeline::{BenchItem, Names, Statuses, sample_of};

/// A record or an event that an answer holds, and the status of the record.
pub(super) type Seen = (i64, Option<&'static str>);

/// A record of the gyro; whether it does not count any more, where that is asked for.
pub(super) struct Row {
    pub figures: Figures,
    pub voided: Option<bool>,
    pub set_aside: bool,
}

impl Row {
    pub fn seen(&self, statuses: &Statuses, column: usize) -> Seen {
        let judged = statuses.get(&self.figures, column).name();
        (self.figures.record.0, Some(if self.voided == Some(true) { "voided" } else { judged }))
    }
}

pub(super) fn separated_point<'t>(
    Row { figures, voided, set_aside }: &Row,
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
        state: Some(figures.states.0[column].unwrap_or(Judgement::Indeterminate).name()),
        status: Some(statuses.get(figures, column).name()),
        voided: *voided,
        set_aside: set_aside.then_some(true),
    }
}

pub(super) fn bench_point<'t>(row: &'t BenchItem, voided: Option<bool>, coefficient: Coefficient) -> Option<Point<'t>> {
    let column = coefficient.column().filter(|&column| column < 2)?;
    Some(Point {
        calibrated_at: row.measured_at,
        value: row.d[column],
        sd: row.sd[column],
        method: row.method.name(),
        imu: None,
        slot: None,
        station: &row.station,
        record: row.id,
        state: None,
        status: None,
        voided,
        set_aside: None,
    })
}
