//! What the pages and reports of a gyro show, read once.

use std::sync::Arc;

use super::history_plot::{self, Epochs, Seen};
use super::prelude::*;
use super::verdicts::SeenVerdict;
use super::view::View;
use super::{alerts, status};
use crate::config::JudgedMethod;
use crate::core::alert_filter::AlertFilter;
use crate::core::figures::Figures;
use crate::core::judge::State;
use crate::pipeline::{Comparison, Course, Standing, Statuses};
use crate::wire::note::NoteBody;

/// Records of a run that are told from what is only drifting; an older one began before.
const LONGEST_RUN: usize = 400;

/// Calibrations in one table, on the page and in a report.
pub(super) const ROWS: usize = 30;
pub(super) const MOST_ROWS: usize = 40;

/// All that is known of a gyro, by the method that is shown.
pub(super) struct Facts {
    pub now: UtcMicros,
    pub judged: JudgedMethod,
    pub course: Course,
    /// What its course is held against.
    pub epochs: Epochs,
    pub comparison: Comparison,
    /// How it stands; none for a gyro that has neither a calibration nor a bench result.
    pub standing: Option<Standing>,
    /// What the rules say of the records that are drawn and listed.
    pub statuses: Statuses,
    /// On its newest record.
    pub verdicts: Vec<SeenVerdict>,
    /// Why its figures in that record may not be its own.
    pub doubts: Vec<NoteBody>,
    /// Those that are not resolved.
    pub alerts: Vec<AlertBody>,
    /// That all gyros of its IMU have moved at once, or what its newest station does to all, where such an alert is not
    /// resolved.
    pub shared_shifts: Vec<AlertBody>,
    /// The gyro that has been calibrated in its slot since.
    pub successor: Option<Arc<str>>,
}

impl Facts {
    /// `skip`: how many of the newest records the table passes over.
    pub async fn of(pages: &Pages, number: u32, serial: &str, view: &View, skip: usize) -> Result<Self, Problem> {
        let pipeline = &pages.pipeline;
        let method = view.shown.separation();
        let course = pipeline.queries.histories.course(number, serial, method).await?;
        let comparison = pipeline.queries.histories.compare_methods(number, None).await?;
        let epochs = history_plot::epochs(&course, method);
        let standing = pipeline.queries.fleet.standings(vec![(number, course.figures.last().copied())]).await?.pop();
        let (mut verdicts, doubts) = of_newest(pages, serial, &course).await?;
        for violation in standing.iter().flat_map(|standing| &standing.violations) {
            verdicts.iter_mut().for_each(|said| said.is_known_to_be(violation));
        }
        let drawn = history_plot::drawn(&course, view).into_iter();
        let listed = course.figures.iter().rev().skip(first_row(skip, course.figures.len())).take(MOST_ROWS);
        let beyond = |row: &&Figures| row.states.worst() == Some(State::Exceeded);
        let run = course.figures.iter().rev().take_while(beyond).take(LONGEST_RUN);
        let asked = drawn.chain(listed).chain(run);
        let statuses = pipeline.queries.histories.statuses(number, asked, &[0, 1, 2]).await?;
        let alerts = alerts::open_ones(pages, number).await?;
        let imu = course.figures.last().map(|newest| pipeline.queries.names().imu(newest.imu).to_owned());
        let mut shared_shifts = match imu {
            Some(imu) => alerts::open_ones_of_imu(pages, &imu).await?,
            None => Vec::new(),
        };
        shared_shifts.retain(|alert| alert.rule == Rule::ImuShift.name());
        if let Some(newest) = course.figures.last() {
            let station = pipeline.queries.names().station(newest.station).to_owned();
            let told = pipeline.alerts.of_no_gyro(&AlertFilter::default()).await?;
            shared_shifts.extend(told.into_iter().filter(|alert| alerts::is_open_of(alert, &station)));
        }
        let successor = match course.figures.last() {
            Some(newest) => pipeline.queries.fleet.seated_in(newest.imu).await?.successor(number),
            None => None,
        };
        let (now, judged) = (pages.clock.now(), pages.config.judging.method);
        Ok(Self {
            now,
            judged,
            course,
            epochs,
            comparison,
            standing,
            statuses,
            verdicts,
            doubts,
            alerts,
            shared_shifts,
            successor,
        })
    }

    /// Its status, and that it is out of use where it is.
    pub fn badge(&self, t: &Text) -> Markup {
        let (status, ended) = self.standing.as_ref().map_or((None, None), |one| (one.status, one.out_of_use));
        html! { (status::badge(t, status)) " " (status::out_of_use(t, ended)) }
    }

    /// What its plot is made from.
    pub fn seen(&self) -> Seen<'_> {
        Seen { course: &self.course, epochs: &self.epochs, statuses: &self.statuses, verdicts: &self.verdicts }
    }
}

/// Where a page of the table begins; beyond the oldest there is the last page.
pub(super) fn first_row(skip: usize, count: usize) -> usize {
    if skip < count { skip } else { count.saturating_sub(1) / ROWS * ROWS }
}

/// What is said of a gyro in its newest record: verdicts, and notes that doubt its figures.
async fn of_newest(pages: &Pages, serial: &str, course: &Course) -> Result<(Vec<SeenVerdict>, Vec<NoteBody>), Problem> {
    let Some(newest) = course.figures.last() else { return Ok(Default::default()) };
    let stored = pages.pipeline.queries.records.record(newest.record).await?;
    Ok(stored.map_or_else(Default::default, |stored| {
        let verdicts = SeenVerdict::of_gyro(serial, &stored.answer.verdicts, &stored.seen);
        (verdicts, stored.answer.notes.into_iter().filter(|note| note.doubts_figures_of(serial)).collect())
    }))
}
