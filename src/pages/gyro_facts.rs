//! What the pages and reports of a gyro show, read once.

use std::sync::Arc;

use super::history_plot::{self, Epochs, PlotData};
use super::prelude::*;
use super::verdicts::SeenVerdict;
use super::view::View;
use super::{alerts, status};
use crate::config::JudgedMethod;
use crate::core::alert_filter::AlertFilter;
use crate::core::figures::Figures;
use crate::core::judge::State;
use crate::pipeline::{Comparison, FEW_RECORDS, GyroStatus, GyroTimeline, Statuses};
use crate::wire::note::NoteBody;

/// Records of a run that are told from what is only drifting; an older one began before.
const LONGEST_RUN: usize = 400;

/// Records before the newest that are looked at for what only they show.
const BEFORE: usize = 4;

/// Calibrations in one table, on the page and in a report.
pub(super) const ROWS: usize = 30;
pub(super) const MOST_ROWS: usize = 40;

/// A record, and the notes that doubt its figures.
type Doubted<R> = (R, Vec<NoteBody>);

/// All that is known of a gyro, by the method that is shown.
pub(super) struct Facts {
    pub now: UtcMicros,
    pub judged: JudgedMethod,
    pub course: GyroTimeline,
    /// What its course is held against.
    pub epochs: Epochs,
    pub comparison: Comparison,
    /// How it stands; none for a gyro that has neither a calibration nor a bench result.
    pub standing: Option<GyroStatus>,
    /// What the rules say of the records that are drawn and listed.
    pub statuses: Statuses,
    /// On its newest record.
    pub verdicts: Vec<SeenVerdict>,
    /// Why its figures in that record, or in its first, may not be its own.
    pub doubted: Option<Doubted<Id>>,
    /// The last of the few records before that was out of tolerance, where the newest is not; why its figures may not be
    /// its own.
    pub odd_before: Option<Doubted<Figures>>,
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
        let (mut verdicts, doubted) = of_newest(pages, serial, &course).await?;
        for violation in standing.iter().flat_map(|standing| &standing.violations) {
            verdicts.iter_mut().for_each(|said| said.is_known_to_be(violation));
        }
        let drawn = history_plot::drawn(&course, view).into_iter();
        let listed = course.figures.iter().rev().skip(first_row(skip, course.figures.len())).take(MOST_ROWS);
        let beyond = |row: &&Figures| row.states.worst() == Some(State::Exceeded);
        let run = course.figures.iter().rev().take_while(beyond).take(LONGEST_RUN);
        let asked = drawn.chain(listed).chain(run);
        let statuses = pipeline.queries.histories.statuses(number, asked, &[0, 1, 2]).await?;
        let odd_before = odd_before(pages, serial, &course, &statuses).await?;
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
            doubted,
            odd_before,
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
    pub fn seen(&self) -> PlotData<'_> {
        PlotData { course: &self.course, epochs: &self.epochs, statuses: &self.statuses, verdicts: &self.verdicts }
    }
}

/// Where a page of the table begins; beyond the oldest there is the last page.
pub(super) fn first_row(skip: usize, count: usize) -> usize {
    if skip < count { skip } else { count.saturating_sub(1) / ROWS * ROWS }
}

/// What is said of a gyro in its newest record: verdicts, and notes that doubt its figures.
async fn of_newest(
    pages: &Pages,
    serial: &str,
    course: &GyroTimeline,
) -> Result<(Vec<SeenVerdict>, Option<Doubted<Id>>), Problem> {
    let Some(newest) = course.figures.last() else { return Ok(Default::default()) };
    let Some(stored) = pages.pipeline.queries.records.record(newest.record).await? else {
        return Ok(Default::default());
    };
    let verdicts = SeenVerdict::of_gyro(serial, &stored.answer.verdicts, &stored.seen);
    let mut doubted = (newest.record, doubting(serial, stored.answer.notes));
    // The name was new in the first record: the few of a misspelt name are all another gyro's.
    if let Some(first) = course.figures.first().filter(|_| doubted.1.is_empty() && course.figures.len() <= FEW_RECORDS)
    {
        let mut notes = notes_of(pages, serial, first.record).await?;
        notes.retain(|note| note.code == "look_alike");
        doubted = (first.record, notes);
    }
    Ok((verdicts, Some(doubted).filter(|(_, notes)| !notes.is_empty())))
}

/// The last of the few records before the newest in which a drift was out of tolerance that is not now.
async fn odd_before(
    pages: &Pages,
    serial: &str,
    course: &GyroTimeline,
    statuses: &Statuses,
) -> Result<Option<Doubted<Figures>>, Problem> {
    let Some((newest, earlier)) = course.figures.split_last() else { return Ok(None) };
    let is_odd = |before: &Figures| {
        let mut columns = 0..2;
        columns.any(|column| {
            statuses.get(before, column) > Status::Drifting && statuses.get(newest, column) < Status::Drifting
        })
    };
    // Further back only one record by itself: where several were, something was done to the gyro since.
    let mut back = earlier.iter().rev().take(BEFORE).enumerate();
    let odd = back.find(|(_, before)| is_odd(before)).filter(|(k, _)| {
        let before = earlier.iter().rev().nth(k + 1);
        *k == 0 || !before.is_some_and(is_odd)
    });
    Ok(match odd {
        Some((_, before)) => Some((*before, notes_of(pages, serial, before.record).await?)),
        None => None,
    })
}

fn doubting(serial: &str, mut notes: Vec<NoteBody>) -> Vec<NoteBody> {
    notes.retain(|note| note.doubts_figures_of(serial));
    notes
}

/// The notes that doubt the gyro's figures in a record.
async fn notes_of(pages: &Pages, serial: &str, record: Id) -> Result<Vec<NoteBody>, Problem> {
    let stored = pages.pipeline.queries.records.record(record).await?;
    Ok(stored.map_or_else(Vec::new, |stored| doubting(serial, stored.answer.notes)))
}
