//! Judging a group in its end state: each gyro that it touches, once.

mod undoing;

use std::collections::{BTreeMap, HashMap, HashSet};

use super::alerting::Naming;
use super::line::{Line, baseline_of, load_marks, mark_of, sample_of};
use crate::config::Judging;
use crate::core::judge::history::{BASELINE_RECORDS, History, Mark, Need, Sample, baseline_since};
use crate::core::judge::{Coefficient, Finding, Limits, Rule, Series, Verdict, judge};
use crate::core::notify::Policy;
use crate::core::time::UtcMicros;
use crate::store::{Changes, Figures, HistoryRow, Id, Span, States, Store, StoreError, StoredVerdict, VerdictSheet};

/// Most records that are kept in memory, over all gyros (about 60 bytes each).
const MAX_SAMPLES: usize = 400_000;

/// Judges; remembers the newest stretch of the gyros that it has seen.
#[derive(Debug)]
pub(super) struct Judge {
    store: Store,
    judging: Judging,
    policy: Policy,
    lines: HashMap<u32, Line>,
}

/// Verdicts by record and gyro number.
pub(super) type Verdicts = HashMap<(Id, u32), Vec<Verdict>>;

/// What judging a group has found.
#[derive(Debug, Default)]
pub(super) struct Judged {
    /// On every new record, and on the newest of a gyro where that was judged again.
    pub verdicts: Verdicts,
    /// What was the newest of its gyro, in the order of time: each new record that came in order, else the newest after all.
    pub newest: Vec<Newest>,
    /// Gyros of which something counts no more.
    pub undone: BTreeMap<u32, Undone>,
}

/// What has become of a gyro's alerts now that something counts no more, and who said so, and why.
#[derive(Debug)]
pub(super) struct Undone {
    /// What would fire if nothing but what counts now had ever come; none where only a bench result was voided.
    pub fires: Option<HashSet<(Coefficient, Rule)>>,
    pub author: String,
    pub reason: String,
}

/// A gyro's newest calibration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Newest {
    pub gyro: u32,
    pub figures: Figures,
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
        let shrunk = changes.withdrawn.gyros();
        for gyro in &shrunk {
            rows.entry(*gyro).or_default();
        }
        for (gyro, mut indices) in rows {
            indices.sort_by_key(|&i| changes.history[i].figures.at);
            let oldest = indices.first().map(|&i| changes.history[i].figures.at);
            let has_events = changes.events.iter().any(|event| event.gyro == gyro);
            self.load(gyro, changes).await?;
            let newest = self.lines.get(&gyro).and_then(Line::newest);
            let in_order = !has_events && !shrunk.contains(&gyro);
            if in_order && oldest.zip(newest).is_none_or(|(oldest, newest)| oldest > newest) {
                self.append(gyro, &indices, changes, &mut judged);
            } else {
                self.insert(gyro, &indices, changes, &mut judged, &mut sheets).await?;
            }
        }
        changes.rejudged.sheets = sheets.into_iter().collect();
        enter(&judged.verdicts, changes);
        self.undo(changes, &mut judged).await?;
        Self::mark(changes);
        Ok(judged)
    }

    /// Forgets everything: what was remembered is not what was committed.
    pub fn forget(&mut self) {
        self.lines.clear();
    }

    /// Forgets some gyros: others have written to their histories.
    pub fn forget_of(&mut self, gyros: &[u32]) {
        gyros.iter().for_each(|gyro| drop(self.lines.remove(gyro)));
    }

    /// Keeps the memory within its bounds; when all that was judged is stored.
    pub fn tidy(&mut self) {
        if self.is_full() {
            self.forget();
        }
    }

    pub fn is_full(&self) -> bool {
        self.lines.values().map(Line::len).sum::<usize>() > MAX_SAMPLES
    }

    async fn load(&mut self, gyro: u32, changes: &Changes) -> Result<(), StoreError> {
        if self.lines.contains_key(&gyro) {
            return Ok(());
        }
        let is_new = changes.gyros.iter().any(|(number, _)| *number == gyro);
        let line = if is_new {
            Line::default()
        } else {
            let need = Need::of(&self.limits(None));
            Line::load(&self.store, gyro, Span::EVER.to, need, self.judging.method).await?
        };
        self.lines.insert(gyro, line);
        Ok(())
    }

    /// Records newer than all: the usual case, without a look at the database.
    fn append(&mut self, gyro: u32, indices: &[usize], changes: &mut Changes, found: &mut Judged) {
        for &i in indices {
            let limits = self.limits(Some((gyro, changes.history[i].figures.imu, changes)));
            let line = self.lines.entry(gyro).or_default();
            let figures = &mut changes.history[i].figures;
            line.append(sample_of(figures, self.judging.method));
            let judged = line.judge_newest(&limits);
            figures.states = states(&judged);
            found.newest.push(Newest { gyro, figures: *figures });
            found.verdicts.insert((figures.record, gyro), judged);
            line.trim(Need::of(&limits));
        }
    }

    /// Records that arrive late, and events: put in their place, and what they alter is judged again.
    async fn insert(
        &mut self,
        gyro: u32,
        indices: &[usize],
        changes: &mut Changes,
        found: &mut Judged,
        sheets: &mut HashMap<Id, VerdictSheet>,
    ) -> Result<(), StoreError> {
        let method = self.judging.method;
        let mut stored = self.store.history(gyro, Span::EVER, usize::MAX).await?;
        let mut marks = load_marks(&self.store, gyro).await?;
        let new_events = changes.events.iter().filter(|event| event.gyro == gyro);
        let new_marks: Vec<Mark> = new_events.map(mark_of).collect();
        marks.extend(&new_marks);
        marks.sort_by_key(|mark| mark.at);
        let mut altered = withdrawn_from(gyro, &mut stored, &marks, changes);
        let shrunk = !altered.is_empty();
        altered.extend(indices.iter().map(|&i| Altered::Inserted { at: changes.history[i].figures.at }));
        altered.extend(
            new_marks.iter().map(|mark| Altered::Marked { at: mark.at, baseline: mark.event.resets_baseline() }),
        );
        let mut samples: Vec<Sample> = stored.iter().map(|figures| sample_of(figures, method)).collect();
        samples.extend(indices.iter().map(|&i| sample_of(&changes.history[i].figures, method)));
        samples.sort_by_key(|sample| sample.at);
        let samples = Series::from(samples);

        let need = Need::of(&self.limits(None));
        let mut again = affected(&samples, &marks, &altered, need);
        // What is the newest now is what alerts follow.
        again.extend(samples.len().checked_sub(1).filter(|last| shrunk && again.last() != Some(last)));
        for k in again {
            let at = samples[k].at;
            let mut judged = Vec::with_capacity(16);
            let history = History { samples: &samples, baseline: baseline_of(&samples, &marks, at), marks: &marks };
            let new_row = indices.iter().copied().find(|&i| changes.history[i].figures.at == at);
            if let Some(i) = new_row {
                let limits = self.limits(Some((gyro, changes.history[i].figures.imu, changes)));
                judge(&history, k, &limits, &mut judged);
                let figures = &mut changes.history[i].figures;
                figures.states = states(&judged);
                found.verdicts.insert((figures.record, gyro), judged);
            } else if let Ok(i) = stored.binary_search_by_key(&at, |figures| figures.at) {
                let mut figures = stored[i];
                judge(&history, k, &self.limits(Some((gyro, figures.imu, changes))), &mut judged);
                self.correct_sheet(gyro, figures.record, &judged, sheets).await?;
                figures.states = states(&judged);
                if figures.states != stored[i].states {
                    changes.rejudged.history.push(HistoryRow { gyro, figures });
                }
                if k + 1 == samples.len() {
                    found.verdicts.insert((figures.record, gyro), judged);
                }
            }
        }
        let new_rows = indices.iter().map(|&i| changes.history[i].figures);
        let newest = stored.iter().copied().chain(new_rows).max_by_key(|figures| figures.at);
        found.newest.extend(newest.map(|figures| Newest { gyro, figures }));
        let mut line = Line::of_all(samples.to_vec(), marks);
        line.trim(need);
        self.lines.insert(gyro, line);
        Ok(())
    }

    /// Puts the new verdicts of one gyro into a stored record's sheet; those that need no history stay.
    async fn correct_sheet(
        &self,
        gyro: u32,
        record: Id,
        judged: &[Verdict],
        sheets: &mut HashMap<Id, VerdictSheet>,
    ) -> Result<(), StoreError> {
        let sheet = match sheets.remove(&record) {
            Some(sheet) => Some(sheet),
            None => self.store.verdict_sheet(record).await?,
        };
        let Some(mut sheet) = sheet else {
            return Err(StoreError::Damaged(format!("record {record} of gyro number {gyro} is missing")));
        };
        let old = sheet.0.iter().find(|(number, _)| *number == gyro).map(|(_, verdicts)| verdicts.as_slice());
        let stays = old.unwrap_or_default().iter().filter(|verdict| verdict.rule == Rule::Requirement).copied();
        let new = judged.iter().map(StoredVerdict::from).chain(stays).collect();
        sheet.replace(gyro, new);
        sheets.insert(record, sheet);
        Ok(())
    }

    /// Whether an event after `at` parts the record of that time from what comes, as far as a rule goes. Of a gyro that has just
    /// been judged.
    pub fn is_reset_since(&self, gyro: u32, at: UtcMicros, rule: Rule) -> bool {
        self.lines.get(&gyro).is_some_and(|line| line.marks().iter().any(|m| m.at > at && m.event.resets(rule)))
    }

    /// After how many days without a calibration a gyro is overdue.
    pub fn interval_days(&self, gyro: u32, imu: u32, naming: &Naming<'_>) -> Option<f64> {
        if self.judging.overrides.is_empty() {
            return self.judging.fleet_interval_days();
        }
        self.judging.limits(&naming.imu(imu), &naming.gyro(gyro)).interval_days
    }

    /// Whether any gyro may become overdue.
    pub fn has_intervals(&self) -> bool {
        let of_overrides = self.judging.overrides.iter().any(|change| change.interval_days.is_some());
        of_overrides || self.judging.fleet_interval_days().is_some()
    }

    /// The limits of a gyro in its IMU, or of the fleet.
    fn limits(&self, of: Option<(u32, u32, &Changes)>) -> Limits {
        let Some((gyro, imu, changes)) = of.filter(|_| !self.judging.overrides.is_empty()) else {
            return self.judging.limits("", "");
        };
        let naming = Naming { tables: &self.store.names().read(), new: Some(changes) };
        self.judging.limits(&naming.imu(imu), &naming.gyro(gyro))
    }
}

/// Something that alters verdicts.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Altered {
    /// A record came in.
    Inserted { at: UtcMicros },
    /// A record was taken out; it may have been one of its baseline's.
    Removed { at: UtcMicros, baseline: bool },
    /// Something was done to the gyro; a new baseline may begin.
    Marked { at: UtcMicros, baseline: bool },
}

/// Takes the records that count no more out of what is stored of a gyro, and tells what that alters.
fn withdrawn_from(gyro: u32, stored: &mut Vec<Figures>, marks: &[Mark], changes: &Changes) -> Vec<Altered> {
    let of_gyro = changes.withdrawn.history.iter().filter(|row| row.gyro == gyro);
    let gone: HashSet<Id> = of_gyro.map(|row| row.figures.record).collect();
    if gone.is_empty() {
        return Vec::new();
    }
    let at: Vec<UtcMicros> = stored.iter().map(|figures| figures.at).collect();
    let removed = stored.iter().enumerate().filter(|(_, figures)| gone.contains(&figures.record));
    let altered = removed.map(|(k, figures)| {
        let start = baseline_since(marks, figures.at).map_or(0, |since| at.partition_point(|at| *at < since));
        Altered::Removed { at: figures.at, baseline: k < start + BASELINE_RECORDS }
    });
    let altered = altered.collect();
    stored.retain(|figures| !gone.contains(&figures.record));
    altered
}

/// Indices of the records whose verdicts change by what is `altered`: what came in, those whose rules look back to
/// it, and, where a baseline's records change, all that are compared with it. `samples` are those that count now.
fn affected(samples: &[Sample], marks: &[Mark], altered: &[Altered], need: Need) -> Vec<usize> {
    let mut found = HashSet::new();
    for &change in altered {
        let (Altered::Inserted { at } | Altered::Removed { at, .. } | Altered::Marked { at, .. }) = change;
        let start = samples.partition_point(|sample| sample.at < at);
        let (itself, in_baseline) = match change {
            Altered::Inserted { at } => (1, baseline_of(samples, marks, at).iter().any(|sample| sample.at == at)),
            Altered::Removed { baseline, .. } | Altered::Marked { baseline, .. } => (0, baseline),
        };
        let later: Vec<UtcMicros> = samples[start + itself..].iter().map(|sample| sample.at).collect();
        found.extend(start..start + itself + need.reach(at, &later));
        if in_baseline {
            let since = baseline_since(marks, at);
            let same_baseline = |k: &usize| baseline_since(marks, samples[*k].at) == since;
            found.extend((start..samples.len()).take_while(same_baseline));
        }
    }
    let mut found: Vec<usize> = found.into_iter().collect();
    found.sort_unstable();
    found
}

/// The worst of the rules that could judge, for D_I, D_S and the closure.
pub(super) fn states(verdicts: &[Verdict]) -> States {
    let worst = |coefficient| {
        let of_it = verdicts.iter().filter(|verdict| verdict.coefficient == coefficient);
        of_it.filter(|verdict| !matches!(verdict.finding, Finding::TooFew { .. })).map(|verdict| verdict.state).max()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::Event;
    use crate::core::judge::history::Measured;

    fn day(day: i64) -> UtcMicros {
        UtcMicros(day * UtcMicros::DAY)
    }

    fn samples(days: &[i64]) -> Vec<Sample> {
        days.iter().map(|&d| Sample { at: day(d), d: [Measured::exact(0.0); 3] }).collect()
    }

    const NEED: Need = Need { records: 2, days: 10.0 };

    #[test]
    fn a_late_record_alters_those_that_look_back_to_it() {
        let all = samples(&[0, 100, 200, 300, 305, 311, 400, 500, 600]);
        assert_eq!(BASELINE_RECORDS, 3);
        let late = |at| affected(&all, &[], &[Altered::Inserted { at: day(at) }], NEED);
        assert_eq!(late(300), [3, 4, 5], "two records on");
        assert_eq!(late(400), [6, 7, 8]);
        assert_eq!(late(600), [8]);
        assert_eq!(late(200), [2, 3, 4, 5, 6, 7, 8], "it is one of the baseline's");
        let dense = samples(&[0, 100, 200, 300, 301, 302, 303, 309, 311]);
        let late = |at| affected(&dense, &[], &[Altered::Inserted { at: day(at) }], NEED);
        assert_eq!(late(300), [3, 4, 5, 6, 7], "ten days on");
    }

    #[test]
    fn a_record_that_is_taken_out_alters_those_that_looked_back_to_it() {
        let left = samples(&[0, 100, 200, 305, 311, 400, 500, 600]);
        let gone = |at, baseline| affected(&left, &[], &[Altered::Removed { at: day(at), baseline }], NEED);
        assert_eq!(gone(300, false), [3, 4]);
        assert_eq!(gone(700, false), [] as [usize; 0]);
        assert_eq!(gone(250, true), [3, 4, 5, 6, 7]);
    }

    #[test]
    fn a_new_baseline_alters_all_up_to_the_next_one() {
        let all = samples(&[0, 100, 200, 300, 400, 500]);
        let mark = |at, event| Mark::of(day(at), event);
        let marks = [mark(150, Event::Baseline), mark(450, Event::Repair)];
        assert_eq!(affected(&all, &marks, &[Altered::Marked { at: day(150), baseline: true }], NEED), [2, 3, 4]);
        let note = [mark(150, Event::Note)];
        assert_eq!(affected(&all, &note, &[Altered::Marked { at: day(150), baseline: false }], NEED), [2, 3]);
    }
}
