//! Judging a group in its end state: each gyro that it touches, once.

pub(crate) mod gyro_window;
mod judged;
pub(crate) mod older_summary;
pub(crate) mod out_of_order;
mod withdrawal;

use crate::config::Judging;
use crate::core::alert_decision::Policy;
use crate::core::figures::States;
use crate::core::judge::history::Need;
use crate::core::judge::{BudgetProjection, Coefficient, Limit, Limits, Mark, Older, State};
use crate::pipeline::alerts::NameLookup;
use crate::pipeline::ingest::judge::gyro_window::{GyroWindow, Source, read_ahead, sample_of};
use crate::pipeline::ingest::judge::withdrawal::Replay;
use crate::pipeline::prelude::*;
use crate::store::{HistoryRow, StoredVerdict};

pub(crate) use judged::{Firing, Judged, Undone, Verdicts};

/// A gyro with more than this part of the records that are remembered is remembered shortened from the first.
const LARGE_PART: usize = 100;

/// What a gyro takes in memory beside its records, in records: its baselines, weekly means and marks.
const BESIDE_RECORDS: usize = 16;
/// Records of a gyro, about, that are read anew for one that came late, at most.
const READ_OF_LATE: usize = 4096;

/// Judges; remembers the newest stretch of the gyros that it has seen.
#[derive(Debug)]
pub(crate) struct Judge {
    store: Store,
    judging: Judging,
    policy: Policy,
    lines: HashMap<u32, GyroWindow>,
}

impl Judge {
    pub fn new(store: Store, judging: Judging, policy: Policy) -> Self {
        Self { store, judging, policy, lines: HashMap::new() }
    }

    /// Judges the new rows of `changes` and what they alter, and enters states and verdict sheets.
    pub async fn judge(&mut self, changes: &mut Changes) -> Result<Judged, StoreError> {
        let mut judged = Judged::default();
        let mut sheets = HashMap::new();
        let mut rows: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (i, row) in changes.history.iter().enumerate() {
            rows.entry(row.gyro).or_default().push(i);
        }
        for event in &changes.events {
            rows.entry(event.gyro).or_default();
        }
        let (shrunk, restated) = (changes.withdrawn.gyros(), changes.rejudged.gyros_restated());
        for gyro in shrunk.iter().chain(&restated) {
            rows.entry(*gyro).or_default();
        }
        for (gyro, mut indices) in rows {
            indices.sort_by_key(|&i| changes.history[i].figures.at);
            let oldest = indices.first().map(|&i| changes.history[i].figures.at);
            let has_events = changes.events.iter().any(|event| event.gyro == gyro);
            self.load(gyro, changes).await?;
            let newest = self.lines.get(&gyro).and_then(GyroWindow::newest);
            let records_alone = !has_events && !shrunk.contains(&gyro) && !restated.contains(&gyro);
            if records_alone && oldest.zip(newest).is_none_or(|(oldest, newest)| oldest > newest) {
                self.append(gyro, &indices, changes, &mut judged).await?;
            } else {
                let remembered = if records_alone { self.remembered(gyro, &indices, changes) } else { None };
                self.insert(gyro, &indices, remembered, changes, &mut judged, &mut sheets).await?;
            }
        }
        self.enter_confirmed(&judged.verdicts, changes, &mut sheets).await?;
        changes.rejudged.sheets = sheets.into_iter().collect();
        enter(&judged.verdicts, changes);
        changes.heads.projections =
            judged.verdicts.iter().map(|(of, verdicts)| (*of, BudgetProjection::of(verdicts))).collect();
        self.replay().undo(changes, &mut judged).await?;
        withdrawal::mark(changes);
        Ok(judged)
    }

    /// Notes what fires of the gyros of which records have come late, where an alert fires or is to. Alerts stand as they
    /// are where too many records would tell.
    pub async fn follow_late(
        &self,
        changes: &Changes,
        judged: &mut Judged,
        fires: impl Fn(u32) -> bool,
    ) -> Result<(), StoreError> {
        let Judged { late, newest, verdicts, .. } = judged;
        let exceeds = |verdict: &StoredVerdict| (verdict.rule, verdict.state) == (Rule::Requirement, State::Exceeded);
        let sheets = changes.records.iter().flat_map(|record| &record.verdicts.0);
        let by_requirement = sheets.filter(|(_, sheet)| sheet.iter().any(exceeds)).map(|(gyro, _)| *gyro);
        let by_requirement: HashSet<u32> = if late.is_empty() { HashSet::new() } else { by_requirement.collect() };
        for (gyro, firing) in late {
            let mut of_newest = newest.iter().filter(|row| row.gyro == *gyro).map(|row| row.figures);
            let may_fire = of_newest.any(|Figures { at, record, .. }| {
                let verdicts = verdicts.get(&(record, *gyro)).into_iter().flatten();
                verdicts.into_iter().any(|verdict| withdrawal::leaves_firing(verdict, at, &self.policy))
            });
            if fires(*gyro) || may_fire || by_requirement.contains(gyro) {
                *firing = self.replay().replay(*gyro, changes, READ_OF_LATE).await?;
            }
        }
        Ok(())
    }

    fn replay(&self) -> Replay<'_> {
        Replay { store: &self.store, policy: &self.policy, lines: &self.lines }
    }

    /// Forgets everything: what was remembered is not what was committed.
    pub fn forget(&mut self) {
        self.lines.clear();
    }

    /// Forgets those gyros that `lost` names: others have written to their histories.
    pub fn forget_where(&mut self, lost: impl Fn(u32) -> bool) {
        self.lines.retain(|gyro, _| !lost(*gyro));
    }

    /// Keeps the memory within its bounds; when all that was judged is stored.
    pub fn tidy(&mut self) {
        if self.is_full() {
            let need = Need::of(&self.limits(None));
            let keep = self.judging.remembered_records / (2 * self.lines.len());
            let keep = keep.saturating_sub(BESIDE_RECORDS);
            self.lines.values_mut().for_each(|line| line.shorten(keep, need));
        }
        if self.is_full() {
            self.forget();
        }
    }

    pub fn is_full(&self) -> bool {
        let records: usize = self.lines.values().map(GyroWindow::len).sum();
        records + BESIDE_RECORDS * self.lines.len() > self.judging.remembered_records
    }

    async fn load(&mut self, gyro: u32, changes: &Changes) -> Result<(), StoreError> {
        if self.lines.contains_key(&gyro) {
            return Ok(());
        }
        let is_new = changes.gyros.iter().any(|new| new.number == gyro);
        let need = Need::of(&self.limits(None));
        let line = if is_new {
            GyroWindow::default()
        } else {
            GyroWindow::load(&self.store, gyro, Span::EVER.to, need, self.judging.method).await?
        };
        self.remember(gyro, line, need);
        Ok(())
    }

    fn remember(&mut self, gyro: u32, mut line: GyroWindow, need: Need) {
        let large = self.judging.remembered_records / LARGE_PART;
        if line.len() > large {
            line.shorten(large / 2, need);
        }
        self.lines.insert(gyro, line);
    }

    /// What is remembered of a gyro.
    pub fn window(&self, gyro: u32) -> Option<&GyroWindow> {
        self.lines.get(&gyro)
    }

    /// How a gyro that is remembered lies to its budget in its IMU, and where it goes.
    pub fn projection(&self, gyro: u32, imu: u32, changes: &Changes) -> Option<BudgetProjection> {
        let window = self.window(gyro)?;
        Some(BudgetProjection::of(&window.judge_newest(&self.limits(Some((gyro, imu, changes))), Older::NONE)))
    }

    pub fn knows(&self, gyro: u32) -> bool {
        self.lines.contains_key(&gyro)
    }

    /// How many of a gyro's newest rows [`Judge::take_in`] wants.
    pub fn read_ahead(&self) -> usize {
        read_ahead(Need::of(&self.limits(None)))
    }

    /// Remembers gyros of which the newest rows have been read, as many as [`Judge::read_ahead`] or all.
    pub async fn take_in(&mut self, newest: &[(u32, Vec<Figures>)]) -> Result<(), StoreError> {
        let need = Need::of(&self.limits(None));
        for (gyro, line) in GyroWindow::load_many(&self.store, newest, need, self.judging.method).await? {
            self.remember(gyro, line, need);
        }
        Ok(())
    }

    /// Records newer than all: the usual case, nearly always without a look at the database.
    async fn append(
        &mut self,
        gyro: u32,
        indices: &[usize],
        changes: &mut Changes,
        found: &mut Judged,
    ) -> Result<(), StoreError> {
        let method = self.judging.method;
        for &i in indices {
            let limits = self.limits(Some((gyro, changes.history[i].figures.imu, changes)));
            let line = self.lines.entry(gyro).or_default();
            let figures = &mut changes.history[i].figures;
            line.append(sample_of(figures, method));
            // What repeats the record before is judged as that is, and is no news.
            let at = line.samples().last().map_or(figures.at, |last| last.at);
            let older = line.older(Source { store: &self.store, gyro, method }, at, limits.range_days).await?;
            let judged = line.judge_newest(&limits, older);
            figures.states = states(&judged);
            if at == figures.at {
                found.newest.push(HistoryRow { gyro, figures: *figures });
            }
            found.verdicts.insert((figures.record, gyro), judged);
            line.trim(Need::of(&limits));
        }
        Ok(())
    }

    /// Whether an event after `at` parts the record of that time from what comes, as far as a rule goes. Of a gyro
    /// that has just been judged.
    pub fn is_reset_since(&self, gyro: u32, at: UtcMicros, rule: Rule) -> bool {
        self.lines.get(&gyro).is_some_and(|line| line.marks().iter().any(|m| m.at > at && m.event.resets(rule)))
    }

    /// After how many days without a calibration a gyro is overdue; none after an event since its last one, at
    /// `last`, that says that none is to come.
    pub fn interval_days(&self, gyro: u32, last: UtcMicros, imu: u32, naming: &NameLookup<'_>) -> Option<Limit> {
        if self.lines.get(&gyro).is_some_and(|line| ends_calibrations(line.marks(), last)) {
            return None;
        }
        if self.judging.overrides.is_empty() {
            return self.judging.fleet_interval_days();
        }
        self.judging.limits(&naming.imu(imu), &naming.gyro(gyro)).interval_days
    }

    /// The limits of a gyro in its IMU, or of the fleet.
    fn limits(&self, of: Option<(u32, u32, &Changes)>) -> Limits {
        let Some((gyro, imu, changes)) = of.filter(|_| !self.judging.overrides.is_empty()) else {
            return self.judging.limits("", "");
        };
        let naming = NameLookup { tables: &self.store.names().read(), new: Some(changes) };
        self.judging.limits(&naming.imu(imu), &naming.gyro(gyro))
    }
}

/// Whether a gyro that was calibrated last at `last` was taken out of use since.
pub(crate) fn ends_calibrations(marks: &[Mark], last: UtcMicros) -> bool {
    marks.iter().any(|mark| mark.at >= last && mark.event.ends_calibrations())
}

/// The worst of the rules that could judge, for D_I, D_S and the closure.
pub(crate) fn states(verdicts: &[Verdict]) -> States {
    let worst = |coefficient| {
        let of_it = verdicts.iter().filter(|verdict| verdict.coefficient == coefficient);
        of_it.filter(|verdict| verdict.value.is_some()).map(|verdict| verdict.state).max()
    };
    States([Coefficient::DI, Coefficient::DS, Coefficient::DO].map(worst))
}

/// Enters the verdicts on new records into their sheets, before those that need no history.
fn enter(verdicts: &Verdicts, changes: &mut Changes) {
    for record in &mut changes.records {
        for (gyro, sheet) in &mut record.verdicts.0 {
            if let Some(judged) = verdicts.get(&(record.id, *gyro)) {
                sheet.splice(0..0, judged.iter().map(StoredVerdict::from));
            }
        }
    }
}
