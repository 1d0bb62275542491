//! Judging a group in its end state: each gyro that it touches, once.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::alerting::Naming;
use super::line::{Line, baseline_of, load_marks, sample_of};
use crate::config::Judging;
use crate::core::judge::history::{History, Mark, Need, Sample, baseline_since};
use crate::core::judge::{Coefficient, Finding, Limits, Rule, Verdict, judge};
use crate::core::time::UtcMicros;
use crate::store::{Changes, Figures, HistoryRow, Id, Span, States, Store, StoreError, StoredVerdict, VerdictSheet};

/// Most records that are kept in memory, over all gyros (about 60 bytes each).
const MAX_SAMPLES: usize = 400_000;

/// Judges; remembers the newest stretch of the gyros that it has seen.
#[derive(Debug)]
pub(super) struct Judge {
    store: Store,
    judging: Judging,
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
}

/// A gyro's newest calibration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Newest {
    pub gyro: u32,
    pub figures: Figures,
}

impl Judge {
    pub fn new(store: Store, judging: Judging) -> Self {
        Self { store, judging, lines: HashMap::new() }
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
        for (gyro, mut indices) in rows {
            indices.sort_by_key(|&i| changes.history[i].figures.at);
            let oldest = indices.first().map(|&i| changes.history[i].figures.at);
            let has_events = changes.events.iter().any(|event| event.gyro == gyro);
            self.load(gyro, changes).await?;
            let newest = self.lines.get(&gyro).and_then(Line::newest);
            if !has_events && oldest.zip(newest).is_none_or(|(oldest, newest)| oldest > newest) {
                self.append(gyro, &indices, changes, &mut judged);
            } else {
                self.insert(gyro, &indices, changes, &mut judged, &mut sheets).await?;
            }
        }
        changes.rejudged.sheets = sheets.into_iter().collect();
        enter(&judged.verdicts, changes);
        Ok(judged)
    }

    /// Forgets everything: what was remembered is not what was committed.
    pub fn forget(&mut self) {
        self.lines.clear();
    }

    /// Keeps the memory within its bounds.
    pub fn tidy(&mut self) {
        if self.lines.values().map(Line::len).sum::<usize>() > MAX_SAMPLES {
            self.forget();
        }
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
        let stored = self.store.history(gyro, Span::EVER, usize::MAX).await?;
        let mut marks = load_marks(&self.store, gyro).await?;
        let new_events = changes.events.iter().filter(|event| event.gyro == gyro);
        let new_marks: Vec<Mark> = new_events.map(|event| Mark { at: event.at, event: event.event }).collect();
        marks.extend(&new_marks);
        marks.sort_by_key(|mark| mark.at);
        let arrived: Vec<UtcMicros> = indices.iter().map(|&i| changes.history[i].figures.at).collect();
        let mut samples: Vec<Sample> = stored.iter().map(|figures| sample_of(figures, method)).collect();
        samples.extend(indices.iter().map(|&i| sample_of(&changes.history[i].figures, method)));
        samples.sort_by_key(|sample| sample.at);

        let need = Need::of(&self.limits(None));
        for k in affected(&samples, &marks, &arrived, &new_marks, need) {
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
        let mut line = Line::of_all(samples, marks);
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

/// Indices of the records whose verdicts change when records at `arrived` and `new_marks` come in: themselves, those
/// whose rules look back to them, and, where a baseline's records change, all that are compared with it.
fn affected(samples: &[Sample], marks: &[Mark], arrived: &[UtcMicros], new_marks: &[Mark], need: Need) -> Vec<usize> {
    let mut found = HashSet::new();
    let changes = arrived.iter().map(|at| (*at, false));
    let resets = new_marks.iter().map(|mark| (mark.at, mark.event.resets_baseline()));
    for (at, starts_baseline) in changes.chain(resets) {
        let start = samples.partition_point(|sample| sample.at < at);
        let later: Vec<UtcMicros> = samples[start..].iter().map(|sample| sample.at).collect();
        found.extend(start..start + need.reach(at, &later).max(1).min(later.len()));
        let in_baseline = baseline_of(samples, marks, at).iter().any(|sample| sample.at == at);
        if starts_baseline || in_baseline {
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
    use crate::core::judge::history::{BASELINE_RECORDS, Measured};

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
        assert_eq!(affected(&all, &[], &[day(300)], &[], NEED), [3, 4], "two records on, or ten days");
        assert_eq!(affected(&all, &[], &[day(600)], &[], NEED), [8]);
        assert_eq!(affected(&all, &[], &[day(200)], &[], NEED), [2, 3, 4, 5, 6, 7, 8], "it is one of the baseline's");
    }

    #[test]
    fn a_new_baseline_alters_all_up_to_the_next_one() {
        let all = samples(&[0, 100, 200, 300, 400, 500]);
        let mark = |at, event| Mark { at: day(at), event };
        let marks = [mark(150, Event::Baseline), mark(450, Event::Repair)];
        assert_eq!(affected(&all, &marks, &[], &marks[..1], NEED), [2, 3, 4]);
        let note = [mark(150, Event::Note)];
        assert_eq!(affected(&all, &note, &[], &note, NEED), [2, 3]);
    }
}
