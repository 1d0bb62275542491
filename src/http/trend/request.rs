//! What is asked of a trend, checked, and the rows that answer it.

use super::body::PointColumn;
use super::point::TrendRow;
use crate::config::JudgedMethod;
use crate::core::bench::{BenchItem, BenchMethod};
use crate::core::figures::Figures;
use crate::core::judge::Coefficient;
use crate::core::period::Period;
use crate::core::time::Span;
use crate::http::prelude::*;
use crate::http::query::{bad, not_one_of};
use crate::pipeline::Levels;
use crate::wire::cursor;

/// Points of one JSON answer unless `limit` says otherwise, and at the most.
const DEFAULT_POINTS: usize = 1000;
const MOST_POINTS: usize = 100_000;

#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct TrendQuery {
    /// `D_I` (the default), `D_S` or `D_O`, the closure.
    coefficient: Option<String>,
    /// `rigid`, `published`, `torque_feedback` or `turntable_servo`; the judged method, where it is left out.
    method: Option<String>,
    /// Oldest instant, a day (UTC) or an RFC 3339 time, itself included.
    from: Option<String>,
    /// Newest instant, itself included.
    to: Option<String>,
    /// At most so many points, oldest first; 1000 in JSON, all in CSV unless it is given.
    limit: Option<usize>,
    /// Instead of `limit`: the newest so many points, still oldest first.
    last: Option<usize>,
    /// `next` of the page before.
    cursor: Option<String>,
    /// `json` or `csv`; without it, `Accept` decides.
    format: Option<String>,
    /// Members of a point, as `calibrated_at,value,sd`, or `all`: the answer has `columns`, a list per member, in the
    /// place of `points`. A third of the size, and what a table of pandas or Grafana is made of.
    columns: Option<String>,
    /// `day`, `week` or `month`: the least, largest, mean and last of each period instead of points.
    every: Option<String>,
    /// `include` shows what was voided or revised as well, each point flagged; such points are left out otherwise.
    voided: Option<String>,
    /// `include` adds what each point is held against: its baseline, and the limits on either side.
    levels: Option<String>,
}

/// `include` or `exclude`, which is the default.
fn included(name: &'static str, asked: Option<&str>) -> Answer<bool> {
    match asked {
        None | Some("exclude") => Ok(false),
        Some("include") => Ok(true),
        Some(other) => Err(not_one_of(name, ["include", "exclude"], other)),
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PointMethod {
    Separated(JudgedMethod),
    Bench(BenchMethod),
}

impl PointMethod {
    pub fn name(self) -> &'static str {
        match self {
            Self::Separated(method) => method.name(),
            Self::Bench(method) => method.name(),
        }
    }
}

/// The query, checked.
#[derive(Debug)]
pub(super) struct Request {
    pub coefficient: Coefficient,
    pub method: PointMethod,
    pub span: Span,
    pub limit: usize,
    pub newest: bool,
    pub voided: bool,
    pub levels: bool,
    pub every: Option<Period>,
    pub csv: bool,
    /// Asked for in the place of points.
    pub columns: Option<Vec<PointColumn>>,
}

impl Request {
    pub fn read(app: &App, asked: &TrendQuery, headers: &HeaderMap) -> Answer<Self> {
        let coefficient = asked.coefficient.as_deref().unwrap_or("D_I");
        let coefficient = Coefficient::from_name(coefficient)
            .filter(|c| c.column().is_some())
            .ok_or_else(|| not_one_of("coefficient", ["D_I", "D_S", "D_O"], coefficient))?;
        let method = match asked.method.as_deref() {
            None => PointMethod::Separated(app.config.judging.method),
            Some(name) => {
                let separated = JudgedMethod::from_name(name).map(PointMethod::Separated);
                let known = JudgedMethod::ALL.map(JudgedMethod::name).into_iter();
                let known = known.chain(BenchMethod::ALL.map(BenchMethod::name));
                separated
                    .or_else(|| BenchMethod::from_name(name).map(PointMethod::Bench))
                    .ok_or_else(|| not_one_of("method", known, name))?
            }
        };
        let csv = query::wants_csv(asked.format.as_deref(), headers)?;
        let voided = included("voided", asked.voided.as_deref())?;
        let levels = included("levels", asked.levels.as_deref())?;
        if asked.last.is_some() && (asked.limit.is_some() || asked.cursor.is_some()) {
            return Err(bad(message!("last_alone")));
        }
        let default = if csv { MOST_POINTS } else { DEFAULT_POINTS };
        let limit = query::limit(asked.last.or(asked.limit), default, MOST_POINTS)?;
        let mut span = query::span(asked.from.as_deref(), asked.to.as_deref())?;
        let every = Self::period(asked.every.as_deref(), voided || levels)?;
        if let Some(last) = query::position(List::Trend(every), asked.cursor.as_deref())? {
            span.from = span.from.max(UtcMicros(last.saturating_add(1)));
        }
        let columns = asked.columns.as_deref().map(PointColumn::read).transpose()?;
        if columns.is_some() && (csv || every.is_some()) {
            return Err(bad(message!("columns_of_json")));
        }
        Ok(Self { coefficient, method, span, limit, newest: asked.last.is_some(), voided, levels, every, csv, columns })
    }

    /// Of the coefficient, among D_I, D_S and D_O.
    pub fn column(&self) -> usize {
        self.coefficient.column().unwrap_or_default()
    }

    /// `every`, which goes with what counts only, and with nothing that is of a point.
    fn period(name: Option<&str>, of_points: bool) -> Answer<Option<Period>> {
        let period = query::named("every", name)?;
        if period.is_some() && of_points {
            return Err(bad(message!("every_counts_only")));
        }
        Ok(period)
    }

    /// What points are held against, where that is asked for; those of a bench by the judged method.
    pub async fn levels(&self, app: &App, gyro: u32, serial: &str) -> Answer<Option<Levels>> {
        if !self.levels {
            return Ok(None);
        }
        let method = match self.method {
            PointMethod::Separated(method) => method,
            PointMethod::Bench(_) => app.config.judging.method,
        };
        Ok(Some(app.pipeline.queries.histories.levels(gyro, serial, method, self.column()).await?))
    }

    /// One page of rows, and where the next begins.
    pub async fn history(&self, app: &App, gyro: u32) -> Answer<(Vec<TrendRow>, Option<String>)> {
        let histories = &app.pipeline.queries.histories;
        let counting = match self.newest {
            true => histories.newest(gyro, self.span, self.limit).await?,
            false => histories.oldest(gyro, self.span, self.limit + 1).await?,
        };
        let flag = |voided: bool| self.voided.then_some(voided);
        let row = |figures, voided, set_aside| TrendRow { figures, voided: flag(voided), set_aside };
        let mut rows: Vec<TrendRow> = counting.into_iter().map(|figures| row(figures, false, false)).collect();
        if self.voided {
            // What lies beyond the last row of a page that is full belongs to a later page.
            let full = !self.newest && rows.len() > self.limit;
            let end = rows.last().filter(|_| full).map_or(self.span.to, |last| last.figures.at);
            let voided = histories.voided(gyro, Span { to: end, ..self.span }).await?;
            let aside = histories.set_aside(gyro).await?;
            let is_aside = |figures: &Figures| aside.iter().any(|(id, _)| *id == figures.record);
            rows.extend(voided.into_iter().map(|figures| row(figures, true, is_aside(&figures))));
            rows.sort_by_key(|row| (row.figures.at, row.figures.record));
        }
        let next = self.page(&mut rows, |row| row.figures.at);
        Ok((rows, next))
    }

    pub async fn benches(&self, app: &App, gyro: u32, method: BenchMethod) -> Answer<(Vec<BenchItem>, Option<String>)> {
        let mut rows = app.pipeline.queries.histories.all_benches(gyro, self.span).await?;
        rows.retain(|row| row.method == method && (self.voided || !row.voided));
        let next = self.page(&mut rows, |row| row.measured_at);
        Ok((rows, next))
    }

    /// Leaves one page; the cursor of the next, where something is left.
    pub(super) fn page<T>(&self, rows: &mut Vec<T>, at: impl Fn(&T) -> UtcMicros) -> Option<String> {
        let limit = self.limit;
        if self.newest {
            rows.drain(..rows.len().saturating_sub(limit));
            return None;
        }
        let (last, first_left) = (rows.get(limit.checked_sub(1)?)?, rows.get(limit)?);
        // The next page begins after an instant: what is of the same instant stays together.
        let end = match at(last) == at(first_left) {
            true => rows.iter().skip(limit).position(|row| at(row) != at(last)).map_or(rows.len(), |more| limit + more),
            false => limit,
        };
        let next = (end < rows.len()).then(|| cursor::encode(List::Trend(self.every), at(last).0));
        rows.truncate(end);
        next
    }
}
