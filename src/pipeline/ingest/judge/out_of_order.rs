//! Records that arrive late, events, and what counts no more: put in their place in a gyro's history, and what they
//! alter judged again.

use std::ops::Range;

use super::{Judge, Judged, Verdicts, states};
use crate::core::judge::history::{Need, baseline_of, seat_baseline_of};
use crate::core::judge::{BASELINE_RECORDS, Mark, Sample, Seat, baseline_since, judge};
use crate::pipeline::ingest::judge::gyro_window::{GyroWindow, Source, load_marks, mark_of, sample_of};
use crate::pipeline::prelude::*;
use crate::store::{HistoryRow, RejudgedVerdicts, RestatedRow, StoredVerdict};

/// A gyro's history as it now is, before what has been altered in it is judged again.
#[derive(Debug)]
struct Reopened {
    line: GyroWindow,
    /// Stored rows, oldest first: those at and after the first change at least.
    stored: Vec<Figures>,
    altered: Vec<HistoryChange>,
    /// Whether something was taken out or stated anew.
    shrunk: bool,
}

/// Something that alters verdicts.
#[derive(Debug, Clone, Copy, PartialEq)]
enum HistoryChange {
    /// A record came in.
    Inserted { at: UtcMicros },
    /// A record was taken out; it may have been one of its baseline's.
    Removed { at: UtcMicros, baseline: bool },
    /// Something was done to the gyro; a new baseline may begin.
    Marked { at: UtcMicros, baseline: bool },
    /// Records from here on are stated anew.
    Restated { at: UtcMicros },
}

fn inserted(indices: &[usize], changes: &Changes) -> impl Iterator<Item = HistoryChange> {
    indices.iter().map(|&i| HistoryChange::Inserted { at: changes.history[i].figures.at })
}

/// Takes the records that count no more out of what is stored of a gyro, and tells what that alters.
fn withdrawn_from(gyro: u32, stored: &mut Vec<Figures>, marks: &[Mark], changes: &Changes) -> Vec<HistoryChange> {
    let of_gyro = changes.withdrawn.history.iter().filter(|row| row.gyro == gyro);
    let gone: HashSet<Id> = of_gyro.map(|row| row.figures.record).collect();
    if gone.is_empty() {
        return Vec::new();
    }
    // Of the first few some may repeat others.
    let few = 4 * BASELINE_RECORDS;
    let seat = |k: usize| stored.get(k).map(|figures| Seat { imu: figures.imu, slot: figures.slot });
    let removed = stored.iter().enumerate().filter(|(_, figures)| gone.contains(&figures.record));
    let altered = removed.map(|(k, figures)| {
        let since = baseline_since(marks, figures.at);
        let same = |k: &usize| since.is_none_or(|since| stored[*k].at >= since);
        let in_baseline = (0..k).rev().take_while(same).count() < few;
        let stays = (0..k).rev().take_while(|other| seat(*other) == seat(k)).count();
        let at_a_move = stays < few || seat(k + 1).is_some_and(|next| Some(next) != seat(k));
        HistoryChange::Removed { at: figures.at, baseline: in_baseline || at_a_move }
    });
    let altered: Vec<HistoryChange> = altered.collect();
    stored.retain(|figures| !gone.contains(&figures.record));
    altered
}

/// Puts what is stated anew in the place of what is stored of a gyro, and tells what that alters.
fn restated_in(gyro: u32, stored: &mut [Figures], changes: &Changes) -> Option<HistoryChange> {
    let mut first = None;
    for RestatedRow { row, .. } in changes.rejudged.restated.iter().filter(|restated| restated.row.gyro == gyro) {
        if let Some(old) = stored.iter_mut().find(|old| old.record == row.figures.record) {
            *old = Figures { states: old.states, ..row.figures };
            first = Some(first.map_or(old.at, |first: UtcMicros| first.min(old.at)));
        }
    }
    first.map(|at| HistoryChange::Restated { at })
}

/// Indices of the records whose verdicts change by what is `altered`: what came in, those whose rules look back to
/// it, and, where a baseline's records change, all that are compared with it. `samples` are those that count now.
fn affected(samples: &[Sample], marks: &[Mark], altered: &[HistoryChange], need: Need) -> Vec<usize> {
    let mut stretches = Vec::new();
    for &change in altered {
        let (HistoryChange::Inserted { at }
        | HistoryChange::Removed { at, .. }
        | HistoryChange::Marked { at, .. }
        | HistoryChange::Restated { at }) = change;
        let start = samples.partition_point(|sample| sample.at < at);
        let (itself, in_baseline) = match change {
            HistoryChange::Inserted { at } if samples.get(start).is_none_or(|sample| sample.at != at) => {
                // It repeats the one before, and is judged as that is.
                stretches.push(start.saturating_sub(1)..start);
                continue;
            }
            HistoryChange::Inserted { at } => (1, is_in_baseline(samples, marks, start, at)),
            HistoryChange::Removed { baseline, .. } | HistoryChange::Marked { baseline, .. } => (0, baseline),
            HistoryChange::Restated { .. } => {
                // The first may repeat the one before, and is judged as that is.
                stretches.push(start.saturating_sub(1)..samples.len());
                continue;
            }
        };
        stretches.push(start..start + itself + need.reach(at, &samples[start + itself..]));
        if in_baseline {
            let since = baseline_since(marks, at);
            let of_baseline = samples[start..].iter().take_while(|sample| baseline_since(marks, sample.at) == since);
            stretches.push(start..start + of_baseline.count());
        }
    }
    stretches.sort_unstable_by_key(|stretch| stretch.start);
    let mut next = 0;
    let each_once = stretches.into_iter().flat_map(|Range { start, end }| {
        let new = start.max(next)..end;
        next = next.max(end);
        new
    });
    each_once.collect()
}

/// Whether a record, at its place, is one of those that make a baseline, or parts two stays in one seat.
fn is_in_baseline(samples: &[Sample], marks: &[Mark], place: usize, at: UtcMicros) -> bool {
    let makes = |baseline: &[Sample]| baseline.iter().any(|sample| sample.at == at);
    let parts = samples.get(place + 1).is_some_and(|next| next.seat != samples[place].seat);
    parts || makes(baseline_of(samples, marks, at)) || makes(seat_baseline_of(samples, marks, at))
}

impl Judge {
    /// Puts what is new and what counts no more into its place, and judges again what that alters; `remembered` as of
    /// [`Judge::remembered`].
    pub(super) async fn insert(
        &mut self,
        gyro: u32,
        indices: &[usize],
        remembered: Option<(GyroWindow, UtcMicros)>,
        changes: &mut Changes,
        found: &mut Judged,
        sheets: &mut HashMap<Id, RejudgedVerdicts>,
    ) -> Result<(), StoreError> {
        let need = Need::of(&self.limits(None));
        let Reopened { mut line, stored, altered, shrunk } = match remembered {
            Some((line, from)) => self.reopen_late(gyro, indices, changes, line, from).await?,
            None => self.reopen_all(gyro, indices, changes).await?,
        };
        let source = Source { store: &self.store, gyro, method: self.judging.method };
        let count = line.len();
        let mut again = affected(line.samples(), line.marks(), &altered, need);
        // What is the newest now is what alerts follow.
        again.extend(count.checked_sub(1).filter(|last| (shrunk || !indices.is_empty()) && again.last() != Some(last)));
        for k in again {
            let at = line.samples()[k].at;
            let mut judged = Vec::with_capacity(16);
            let older = line.older(source, at, need.days).await?;
            let history = line.history_at(k, older);
            // A record that repeats it is judged as it is.
            for at in std::iter::once(at).chain(line.repeats_of(at)) {
                judged.clear();
                let new_row = indices.binary_search_by_key(&at, |&i| changes.history[i].figures.at);
                if let Ok(i) = new_row.map(|place| indices[place]) {
                    let limits = self.limits(Some((gyro, changes.history[i].figures.imu, changes)));
                    judge(&history, k, &limits, &mut judged);
                    let figures = &mut changes.history[i].figures;
                    figures.states = states(&judged);
                    found.verdicts.insert((figures.record, gyro), judged.clone());
                } else if let Ok(i) = stored.binary_search_by_key(&at, |figures| figures.at) {
                    let mut figures = stored[i];
                    judge(&history, k, &self.limits(Some((gyro, figures.imu, changes))), &mut judged);
                    let restated = changes.rejudged.requirements_of(gyro, figures.record);
                    self.correct_verdicts((gyro, figures.record), &judged, restated, sheets).await?;
                    figures.states = states(&judged);
                    if figures.states != stored[i].states || restated.is_some() {
                        changes.rejudged.history.push(HistoryRow { gyro, figures });
                    }
                    if k + 1 == count {
                        found.verdicts.insert((figures.record, gyro), judged.clone());
                    }
                }
            }
        }
        let new_rows = indices.iter().map(|&i| changes.history[i].figures);
        let counted = |figures: &Figures| line.samples().binary_search_by_key(&figures.at, |sample| sample.at).is_ok();
        let newest = stored.iter().copied().chain(new_rows).filter(counted).max_by_key(|figures| figures.at);
        found.newest.extend(newest.map(|figures| HistoryRow { gyro, figures }));
        if !shrunk && !indices.is_empty() {
            found.late.insert(gyro, None);
        }
        line.trim(need);
        self.lines.insert(gyro, line);
        Ok(())
    }

    /// A gyro's line, where what is remembered is enough to judge new records (`indices`, oldest first), if they are
    /// all that comes to it, and when the oldest of them was made. What is taken is forgotten here until it is put
    /// back.
    pub(super) fn remembered(
        &mut self,
        gyro: u32,
        indices: &[usize],
        changes: &Changes,
    ) -> Option<(GyroWindow, UtcMicros)> {
        let oldest = changes.history[*indices.first()?].figures.at;
        let need = Need::of(&self.limits(None));
        let new: Vec<Sample> = self.samples_of(indices, changes).collect();
        let enough = self.lines.get(&gyro).is_some_and(|line| line.reaches_back(&new, need));
        let line = enough.then(|| self.lines.remove(&gyro)).flatten();
        line.map(|line| (line, oldest))
    }

    /// A remembered line with new records from `from` on put in their places.
    async fn reopen_late(
        &self,
        gyro: u32,
        indices: &[usize],
        changes: &Changes,
        mut line: GyroWindow,
        from: UtcMicros,
    ) -> Result<Reopened, StoreError> {
        let stored = store::history::oldest(&self.store, gyro, Span { from, ..Span::EVER }, usize::MAX).await?;
        line.insert(self.samples_of(indices, changes));
        Ok(Reopened { line, stored, altered: inserted(indices, changes).collect(), shrunk: false })
    }

    /// Everything of a gyro, with what is new, and without what counts no more.
    async fn reopen_all(&self, gyro: u32, indices: &[usize], changes: &Changes) -> Result<Reopened, StoreError> {
        let mut stored = store::history::oldest(&self.store, gyro, Span::EVER, usize::MAX).await?;
        let mut marks = load_marks(&self.store, gyro).await?;
        let new_events = changes.events.iter().filter(|event| event.gyro == gyro);
        let new_marks: Vec<Mark> = new_events.map(|row| mark_of(&row.told)).collect();
        marks.extend(&new_marks);
        marks.sort_by_key(|mark| mark.at);
        let mut altered = withdrawn_from(gyro, &mut stored, &marks, changes);
        altered.extend(restated_in(gyro, &mut stored, changes));
        let shrunk = !altered.is_empty();
        altered.extend(inserted(indices, changes));
        altered.extend(
            new_marks.iter().map(|mark| HistoryChange::Marked { at: mark.at, baseline: mark.event.resets_baseline() }),
        );
        let mut samples: Vec<Sample> = stored.iter().map(|figures| sample_of(figures, self.judging.method)).collect();
        samples.extend(self.samples_of(indices, changes));
        Ok(Reopened { line: GyroWindow::of_all(samples, marks), stored, altered, shrunk })
    }

    fn samples_of(&self, indices: &[usize], changes: &Changes) -> impl Iterator<Item = Sample> {
        indices.iter().map(|&i| sample_of(&changes.history[i].figures, self.judging.method))
    }

    /// Puts the verdicts on records whose time was confirmed into their sheets.
    pub(super) async fn enter_confirmed(
        &self,
        verdicts: &Verdicts,
        changes: &Changes,
        sheets: &mut HashMap<Id, RejudgedVerdicts>,
    ) -> Result<(), StoreError> {
        let is_confirmed = |id: Id| changes.confirmed.iter().any(|confirmed| confirmed.record == id);
        for HistoryRow { gyro, figures } in changes.history.iter().filter(|row| is_confirmed(row.figures.record)) {
            if let Some(judged) = verdicts.get(&(figures.record, *gyro)) {
                let requirements = changes.rejudged.requirements_of(*gyro, figures.record);
                self.correct_verdicts((*gyro, figures.record), judged, requirements, sheets).await?;
            }
        }
        Ok(())
    }

    /// Puts the new verdicts of one gyro into a stored record; those that need no history stay where there are
    /// no new ones.
    async fn correct_verdicts(
        &self,
        (gyro, record): (u32, Id),
        judged: &[Verdict],
        requirements: Option<&[StoredVerdict]>,
        sheets: &mut HashMap<Id, RejudgedVerdicts>,
    ) -> Result<(), StoreError> {
        let sheet = match sheets.remove(&record) {
            Some(sheet) => Some(sheet),
            None => store::record::verdicts_to_rejudge(&self.store, record).await?,
        };
        let Some(mut sheet) = sheet else {
            return Err(StoreError::damaged(format_args!("record {record} of gyro number {gyro} is missing")));
        };
        let without_history = requirements.unwrap_or(sheet.sheet.of(gyro)).iter();
        let stays = without_history.filter(|verdict| verdict.rule == Rule::Requirement).copied();
        let new = judged.iter().map(StoredVerdict::from).chain(stays).collect();
        sheet.sheet.replace(gyro, new);
        sheets.insert(record, sheet);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::Event;
    use crate::core::judge::Measured;

    fn day(day: i64) -> UtcMicros {
        UtcMicros(day * UtcMicros::DAY)
    }

    fn samples(days: &[i64]) -> Vec<Sample> {
        let sample =
            |&d: &i64| Sample { at: day(d), seat: Seat::default(), station: 0, d: [Measured::exact(d as f64); 3] };
        days.iter().map(sample).collect()
    }

    const NEED: Need = Need { records: 2, days: 10.0 };

    /// Days apart, so that every record is a cell of its own and 550 days hold fewer than the twelve cells that the
    /// control rules look at.
    fn sparse(count: i64) -> Vec<Sample> {
        samples(&(0..count).map(|k| 100 * k).collect::<Vec<_>>())
    }

    #[test]
    fn a_late_record_alters_those_that_look_back_to_it() {
        let all = sparse(30);
        assert_eq!(BASELINE_RECORDS, 3);
        let late = |at| affected(&all, &[], &[HistoryChange::Inserted { at: day(at) }], NEED);
        assert_eq!(late(500), (5..17).collect::<Vec<_>>(), "eleven cells on");
        assert_eq!(late(2900), [29]);
        assert_eq!(late(200), (2..30).collect::<Vec<_>>(), "it is one of the baseline's");
        assert_eq!(late(550), [5], "it repeats the one before");
        let daily = samples(&(0..700).collect::<Vec<_>>());
        let late = affected(&daily, &[], &[HistoryChange::Inserted { at: day(20) }], NEED);
        assert_eq!(late, (20..571).collect::<Vec<_>>(), "550 days on");
    }

    #[test]
    fn a_record_of_another_seat_alters_all_that_follow_in_theirs() {
        let mut all = sparse(30);
        all[7].seat.imu = 3;
        let late = |at| affected(&all, &[], &[HistoryChange::Inserted { at: day(at) }], NEED);
        assert_eq!(late(700), (7..30).collect::<Vec<_>>(), "it parts two stays");
        assert_eq!(late(900), (9..30).collect::<Vec<_>>(), "one of the first since the gyro is back");
        assert_eq!(late(1100), (11..23).collect::<Vec<_>>());
    }

    #[test]
    fn a_record_that_is_taken_out_alters_those_that_looked_back_to_it() {
        let mut left = sparse(30);
        left.remove(5);
        let gone = |at, baseline| affected(&left, &[], &[HistoryChange::Removed { at: day(at), baseline }], NEED);
        assert_eq!(gone(500, false), (5..16).collect::<Vec<_>>());
        assert_eq!(gone(9000, false), [] as [usize; 0]);
        assert_eq!(gone(250, true), (3..29).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_stated_anew_alters_all_from_there_on() {
        let again = affected(&sparse(9), &[], &[HistoryChange::Restated { at: day(400) }], NEED);
        assert_eq!(again, (3..9).collect::<Vec<_>>());
    }

    #[test]
    fn a_new_baseline_alters_all_up_to_the_next_one() {
        let all = sparse(40);
        let mark = |at, event| Mark::of(day(at), event);
        let marks = [mark(150, Event::Baseline), mark(2450, Event::Repair)];
        let set = affected(&all, &marks, &[HistoryChange::Marked { at: day(150), baseline: true }], NEED);
        assert_eq!(set, (2..25).collect::<Vec<_>>());
        let note = [mark(150, Event::Note)];
        let noted = affected(&all, &note, &[HistoryChange::Marked { at: day(150), baseline: false }], NEED);
        assert_eq!(noted, (2..13).collect::<Vec<_>>());
    }
}
