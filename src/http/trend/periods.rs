//! A trend of years: the least, the largest, the mean and the last of each day, week or month.

use super::request::{PointMethod, Request};
use crate::config::JudgedMethod;
use crate::core::period::{Period, Summary, SummaryBuilder};
use crate::core::time::Span;
use crate::http::events::EventBody;
use crate::http::prelude::*;
use crate::pipeline::sample_of;
use crate::wire::body::bodies;
use crate::wire::csv_text::csv_text;

/// Rows that are read at a time: what a gyro has in decades goes through a few megabytes.
const ROWS: usize = 16_384;

/// The history of one coefficient by day, week or month, oldest first; periods without a measurement are left out.
#[derive(Serialize, ToSchema)]
pub(super) struct PeriodTrend<'a> {
    serial: &'a str,
    coefficient: &'static str,
    /// `deg/(h*g0)`.
    unit: &'static str,
    method: &'static str,
    /// `day`, `week` (from Monday) or `month`, UTC.
    every: &'static str,
    periods: Vec<PeriodBody>,
    /// What was done to the gyro in the stretch that was asked for, oldest first.
    #[schema(value_type = Vec<EventBody>)]
    events: &'a [EventBody],
    /// Cursor of the next page; null on the last.
    #[schema(required)]
    next: Option<String>,
}

#[derive(Serialize, ToSchema)]
struct PeriodBody {
    /// First instant of the period.
    begins: String,
    count: usize,
    min: f64,
    max: f64,
    /// Unweighted.
    mean: f64,
    last: f64,
}

impl Request {
    /// One page of periods, and where the next begins.
    pub(super) async fn periods(&self, app: &App, gyro: u32, period: Period) -> Answer<(Vec<Summary>, Option<String>)> {
        let mut gatherer = SummaryBuilder::new(period);
        match self.method {
            PointMethod::Separated(method) => self.gather(app, gyro, method, &mut gatherer).await?,
            PointMethod::Bench(method) => {
                let Some(column) = self.coefficient.column().filter(|&column| column < 2) else {
                    return Ok((Vec::new(), None));
                };
                let rows = app.pipeline.queries.histories.benches(gyro, self.span).await?;
                rows.iter()
                    .filter(|row| row.method == method)
                    .for_each(|row| gatherer.push(row.measured_at, row.d[column]));
            }
        }
        let mut summaries = gatherer.finish();
        // A page ends with a period; the next begins with whatever comes after it.
        let ends = |summary: &Summary| UtcMicros(period.next(summary.begins).0 - 1);
        let next = self.page(&mut summaries, ends);
        Ok((summaries, next))
    }

    async fn gather(&self, app: &App, gyro: u32, method: JudgedMethod, gatherer: &mut SummaryBuilder) -> Answer<()> {
        let column = self.coefficient.column().unwrap_or_default();
        let mut span = self.span;
        loop {
            let rows = app.pipeline.queries.histories.oldest(gyro, span, ROWS).await?;
            // Where the published method is not defined, a mean of both methods would be a figure of neither.
            let of_method = rows.iter().filter(|row| method == JudgedMethod::Rigid || row.published.is_some());
            of_method.for_each(|row| gatherer.push(row.at, sample_of(row, method).d[column].value));
            match rows.last() {
                Some(last) if rows.len() == ROWS && last.at < span.to => {
                    span = Span { from: UtcMicros(last.at.0 + 1), ..span };
                }
                _ => return Ok(()),
            }
        }
    }

    pub(super) fn written_by_period(
        &self,
        serial: &str,
        period: Period,
        summaries: &[Summary],
        events: &[EventBody],
        next: Option<String>,
    ) -> Option<Vec<u8>> {
        let trend = PeriodTrend {
            serial,
            coefficient: self.coefficient.name(),
            unit: "deg/(h*g0)",
            method: self.method.name(),
            every: period.name(),
            periods: summaries.iter().map(PeriodBody::from).collect(),
            events,
            next,
        };
        if self.csv { Some(csv(&trend).into_bytes()) } else { serde_json::to_vec(&trend).ok() }
    }
}

bodies! { PeriodBody of Summary: begins, count, min, max, mean, last; }

/// One header line, times in UTC, every figure at full precision.
fn csv(trend: &PeriodTrend<'_>) -> String {
    let of_all = [trend.serial, trend.coefficient, trend.unit, trend.method, trend.every];
    let line = |period: &PeriodBody| {
        let [serial, coefficient, unit, method, every] = of_all.map(str::to_owned);
        let [min, max, mean, last] = [period.min, period.max, period.mean, period.last].map(|x| x.to_string());
        let (begins, count) = (period.begins.clone(), period.count.to_string());
        [serial, coefficient, unit, method, every, begins, count, min, max, mean, last]
    };
    let header = "serial,coefficient,unit,method,every,begins,count,min,max,mean,last";
    csv_text(header, trend.periods.iter().map(line))
}

/// What an answer shows of a period, as it can be hashed.
pub(super) fn shown(summary: &Summary) -> (i64, usize, [u64; 4]) {
    let Summary { begins, count, min, max, mean, last } = *summary;
    (begins.0, count, [min, max, mean, last].map(f64::to_bits))
}
