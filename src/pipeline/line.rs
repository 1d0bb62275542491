//! One gyro's history as judging needs it: the newest stretch, in memory.

use std::collections::HashMap;

use crate::config::JudgedMethod;
use crate::core::judge::history::{BASELINE_RECORDS, History, Mark, Measured, Need, Sample, baseline_since};
use crate::core::judge::{Limits, Series, Verdict, judge};
use crate::core::time::UtcMicros;
use crate::store::{CorrectionRow, EventRow, Figures, Span, Store, StoreError};

/// The newest records of one gyro, its newest baseline, and what was done to it.
#[derive(Debug, Clone, Default)]
pub(super) struct Line {
    samples: Series,
    baseline: Vec<Sample>,
    /// Where that baseline begins.
    since: Option<UtcMicros>,
    marks: Vec<Mark>,
    /// Whether there are older records that are not here.
    cut: bool,
}

/// Records read at once; nearly always all that the rules look back over.
const READ_AHEAD: usize = 128;

impl Line {
    /// The line up to and with `until`, as it is stored.
    pub async fn load(
        store: &Store,
        gyro: u32,
        until: UtcMicros,
        need: Need,
        method: JudgedMethod,
    ) -> Result<Self, StoreError> {
        let marks = load_marks(store, gyro).await?;
        let upto = Span { to: until, ..Span::EVER };
        let ahead = READ_AHEAD.max(need.records + 1);
        let mut newest = store.newest_history(gyro, upto, ahead).await?;
        let Some(last) = newest.last().map(|figures| figures.at) else {
            return Ok(Self { marks, ..Self::default() });
        };
        let (from, cut) = (last.plus_days(-need.days), newest.len() >= ahead);
        if newest.len() >= READ_AHEAD && newest[0].at > from {
            newest = store.history(gyro, Span { from, to: until }, usize::MAX).await?;
        }
        let since = baseline_since(&marks, last);
        let of_baseline = Span { from: since.unwrap_or(Span::EVER.from), to: until };
        let baseline = store.history(gyro, of_baseline, BASELINE_RECORDS).await?;
        let samples = |figures: &[Figures]| figures.iter().map(|f| sample_of(f, method)).collect::<Vec<_>>();
        Ok(Self { samples: samples(&newest).into(), baseline: samples(&baseline), since, marks, cut })
    }

    /// The line up to a record that does not count any more, of what counted when that was said of it.
    pub async fn load_as_it_was(
        store: &Store,
        gyro: u32,
        voided: Figures,
        method: JudgedMethod,
    ) -> Result<Self, StoreError> {
        let (mut left, mut entered) = (HashMap::new(), HashMap::new());
        for correction in store.corrections_of_gyro(gyro).await? {
            let CorrectionRow { item, replaced_by, at, .. } = correction.said;
            left.entry(item).or_insert(at);
            replaced_by.map(|new| entered.entry(new).or_insert(at));
        }
        let then = left.get(&voided.record).copied().unwrap_or(UtcMicros(i64::MAX));
        let counted = |row: &Figures| {
            row.at < voided.at
                && left.get(&row.record).is_none_or(|at| *at >= then)
                && entered.get(&row.record).is_none_or(|at| *at < then)
        };
        let until = Span { to: voided.at, ..Span::EVER };
        let mut rows = store.history(gyro, until, usize::MAX).await?;
        rows.extend(store.voided_history(gyro, until).await?);
        rows.retain(counted);
        rows.push(voided);
        let samples = rows.iter().map(|row| sample_of(row, method)).collect();
        Ok(Self::of_all(samples, load_marks(store, gyro).await?))
    }

    /// Everything stored of a gyro, with new rows put in their places: for records that arrive late.
    pub fn of_all(mut samples: Vec<Sample>, marks: Vec<Mark>) -> Self {
        samples.sort_by_key(|sample| sample.at);
        let mut line = Self { marks, ..Self::default() };
        for sample in samples {
            line.append(sample);
        }
        line
    }

    pub fn newest(&self) -> Option<UtcMicros> {
        self.samples.last().map(|sample| sample.at)
    }

    pub fn marks(&self) -> &[Mark] {
        &self.marks
    }

    pub fn samples(&self) -> &Series {
        &self.samples
    }

    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Adds a record that is newer than all.
    pub fn append(&mut self, sample: Sample) {
        let since = baseline_since(&self.marks, sample.at);
        if since != self.since {
            self.since = since;
            self.baseline.clear();
        }
        if self.baseline.len() < BASELINE_RECORDS {
            self.baseline.push(sample);
        }
        self.samples.push(sample);
    }

    /// Whether new records of the time from `from` to `to`, and all after the first of them, can be judged by what is here: everything
    /// that the rules look back to, and a baseline to which none of them belongs.
    pub fn reaches_back(&self, [from, to]: [UtcMicros; 2], need: Need) -> bool {
        let [.., last_of_baseline] = self.baseline[..] else { return false };
        let complete = self.baseline.len() == BASELINE_RECORDS && from > last_of_baseline.at;
        let same = [from, to].into_iter().all(|at| baseline_since(&self.marks, at) == self.since);
        let before = self.samples.partition_point(|sample| sample.at < from);
        let far = self.samples.first().is_some_and(|first| first.at < from.plus_days(-need.days));
        complete && same && (!self.cut || far && before >= need.records)
    }

    /// Puts records in their places to which the line [reaches back](Line::reaches_back).
    pub fn insert(&mut self, late: impl IntoIterator<Item = Sample>) {
        self.samples.insert(late);
    }

    /// The history in which the records of a line that is not cut, or to which it reaches back, are judged.
    pub fn history_at(&self, at: UtcMicros) -> History<'_> {
        let baseline = if self.cut { &self.baseline } else { baseline_of(&self.samples, &self.marks, at) };
        History { samples: &self.samples, baseline, marks: &self.marks }
    }

    pub fn judge_newest(&self, limits: &Limits) -> Vec<Verdict> {
        let Some(k) = self.samples.len().checked_sub(1) else { return Vec::new() };
        let mut verdicts = Vec::with_capacity(16);
        let history = History { samples: &self.samples, baseline: &self.baseline, marks: &self.marks };
        judge(&history, k, limits, &mut verdicts);
        verdicts
    }

    /// Forgets what no rule looks back to. Done by halves, so that it costs nothing in the long run.
    pub fn trim(&mut self, need: Need) {
        let Some(last) = self.newest() else { return };
        let from = last.plus_days(-need.days);
        let by_time = self.samples.partition_point(|sample| sample.at < from);
        let excess = by_time.min(self.samples.len().saturating_sub(need.records + 1));
        if excess > READ_AHEAD {
            self.samples.forget(excess);
            self.cut = true;
        }
    }
}

/// The records of one baseline: the first few at or after its beginning.
pub(super) fn baseline_of<'a>(samples: &'a [Sample], marks: &[Mark], at: UtcMicros) -> &'a [Sample] {
    let start = baseline_since(marks, at).map_or(0, |since| samples.partition_point(|sample| sample.at < since));
    &samples[start..samples.len().min(start + BASELINE_RECORDS)]
}

pub(super) async fn load_marks(store: &Store, gyro: u32) -> Result<Vec<Mark>, StoreError> {
    let events = store.events(gyro).await?;
    Ok(events.iter().map(mark_of).collect())
}

/// What was done to each of several gyros; those to which nothing was are left out.
pub(super) async fn marks_of(store: &Store, gyros: &[u32]) -> Result<HashMap<u32, Vec<Mark>>, StoreError> {
    let mut marks = HashMap::<u32, Vec<Mark>>::new();
    for event in store.events_of(gyros).await? {
        marks.entry(event.gyro).or_default().push(mark_of(&event));
    }
    Ok(marks)
}

pub(super) fn mark_of(event: &EventRow) -> Mark {
    Mark { at: event.at, event: event.event, fixed: event.fixed }
}

/// The figures of the method that is judged. Where the published method is not defined, the rigid ones stand in.
pub fn sample_of(figures: &Figures, method: JudgedMethod) -> Sample {
    let measured = |value, sd| Measured { value, sd };
    let d = match (method, &figures.published) {
        (JudgedMethod::Published, Some(published)) => {
            let [i_sd, s_sd] = published.sd.map_or([None; 2], |sd| sd.map(Some));
            let [d_i, d_s] = published.d;
            [measured(d_i, i_sd), measured(d_s, s_sd), Measured::exact(published.closure_rms)]
        }
        _ => {
            let sd = figures.rigid_sd.map_or([None; 3], |sd| sd.map(Some));
            [0, 1, 2].map(|i| measured(figures.rigid[i], sd[i]))
        }
    };
    Sample { at: figures.at, d }
}
