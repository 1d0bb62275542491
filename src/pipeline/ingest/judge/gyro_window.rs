//! One gyro's history as judging needs it: the newest stretch, in memory.

use crate::config::JudgedMethod;
use crate::core::correction::CorrectionItem;
use crate::core::gyro_event::GyroEvent;
use crate::core::judge::history::{History, Need};
use crate::core::judge::{
    BASELINE_RECORDS, Limits, Mark, Measured, Older, Sample, Seat, Series, baseline_since, judge, reset_before,
};
use crate::pipeline::ingest::judge::older_summary::{OlderSummary, RUN};
use crate::pipeline::prelude::*;

/// The newest records of one gyro, its newest baselines, and what was done to it.
#[derive(Debug, Clone, Default)]
pub(crate) struct GyroWindow {
    samples: Series,
    /// The first records since the last event that begins a baseline.
    baseline: Vec<Sample>,
    /// Where that baseline begins.
    since: Option<UtcMicros>,
    /// The first of those since the gyro came to where it is mounted.
    seat_baseline: Vec<Sample>,
    /// Records that [repeat](Sample::repeats) an earlier one: when they and when that was made. They count for nothing.
    repeats: Vec<[UtcMicros; 2]>,
    /// Every record since then is here; none where there are no older ones at all.
    from: Option<UtcMicros>,
    /// Before `samples`.
    past: OlderSummary,
}

/// Where a gyro's history is read, and by which method.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    pub store: &'a Store,
    pub gyro: u32,
    pub method: JudgedMethod,
}

/// Records read at once; nearly always all that the rules look back over.
const READ_AHEAD: usize = 128;
/// First records that are read for a baseline: some may repeat one another.
const FIRST_FEW: usize = 4 * BASELINE_RECORDS;
/// By so much a record may be late and still find what it is compared with.
const LATE_DAYS: f64 = 1.0;

impl GyroWindow {
    /// The line up to and with `until`, as it is stored.
    pub async fn load(
        store: &Store,
        gyro: u32,
        until: UtcMicros,
        need: Need,
        method: JudgedMethod,
    ) -> Result<Self, StoreError> {
        let marks = load_marks(store, gyro).await?;
        let ahead = read_ahead(need);
        let mut stored = Vec::new();
        loop {
            let first = stored.first().map(|figures: &Figures| figures.at);
            let before = first.map_or(until, |first| UtcMicros(first.0 - 1));
            let count = ahead.max(2 * stored.len());
            let older = store::history::newest(store, gyro, Span { to: before, ..Span::EVER }, count).await?;
            let is_whole = older.len() < count;
            stored.splice(0..0, older);
            if let Some(mut line) = Self::of_newest(&stored, is_whole, marks.clone(), need, method) {
                if !is_whole {
                    let first = store::history::oldest(store, gyro, line.of_baseline(until), FIRST_FEW).await?;
                    line.set_baseline(&first, method);
                }
                line.trim(need);
                return Ok(line);
            }
        }
    }

    /// The lines of several gyros, of which the newest rows have been read (as many as [`read_ahead`], or fewer where
    /// there are no others), in two questions for all; those that need more are left out.
    pub async fn load_many(
        store: &Store,
        newest: &[(u32, Vec<Figures>)],
        need: Need,
        method: JudgedMethod,
    ) -> Result<Vec<(u32, Self)>, StoreError> {
        let gyros: Vec<u32> = newest.iter().map(|(gyro, _)| *gyro).collect();
        let mut marks = marks_of(store, &gyros).await?;
        let mut lines: Vec<(u32, Self, bool)> = Vec::with_capacity(newest.len());
        for (gyro, stored) in newest {
            let is_whole = stored.len() < read_ahead(need);
            let marks = marks.remove(gyro).unwrap_or_default();
            lines.extend(Self::of_newest(stored, is_whole, marks, need, method).map(|line| (*gyro, line, is_whole)));
        }
        let begun = lines.iter().filter(|(.., is_whole)| !is_whole);
        let baselines: Vec<(u32, Span)> =
            begun.map(|(gyro, line, _)| (*gyro, line.of_baseline(Span::EVER.to))).collect();
        let mut first = store::histories::oldest(store, &baselines, FIRST_FEW).await?.into_iter();
        for (_, line, is_whole) in &mut lines {
            if !*is_whole {
                line.set_baseline(&first.next().unwrap_or_default(), method);
            }
            line.trim(need);
        }
        Ok(lines.into_iter().map(|(gyro, line, _)| (gyro, line)).collect())
    }

    /// The line of a gyro's newest rows, which may be the whole of them, where the rules find everything in it; then
    /// only the baseline may have begun before.
    fn of_newest(
        stored: &[Figures],
        is_whole: bool,
        marks: Vec<Mark>,
        need: Need,
        method: JudgedMethod,
    ) -> Option<Self> {
        let samples = stored.iter().map(|figures| sample_of(figures, method)).collect();
        let mut line = Self::of_all(samples, marks);
        if !is_whole {
            if !line.is_enough(need) {
                return None;
            }
            line.begin_at(stored.first().map(|figures| figures.at));
        }
        Some(line)
    }

    /// Whether the rules find everything that they look back to, if there are older records than these.
    fn is_enough(&self, need: Need) -> bool {
        let Some((first, last)) = self.samples.first().zip(self.samples.last()) else { return false };
        let moved = |sample: &Sample| sample.seat != last.seat || self.since.is_some_and(|since| sample.at < since);
        self.samples.len() > need.records
            && first.at <= looked_back_to(last.at, need)
            && self.samples.reaches_all_cells()
            && self.samples.iter().any(moved)
    }

    /// There are older records than the first of these.
    fn begin_at(&mut self, first: Option<UtcMicros>) {
        self.from = first;
        self.samples.forget_first_cell();
    }

    /// Where the first records of the baseline stand, which may have begun before what was read.
    fn of_baseline(&self, until: UtcMicros) -> Span {
        Span { from: self.since.unwrap_or(Span::EVER.from), to: until }
    }

    fn set_baseline(&mut self, first: &[Figures], method: JudgedMethod) {
        self.baseline = distinct(first.iter().map(|figures| sample_of(figures, method)));
        self.baseline.truncate(BASELINE_RECORDS);
    }

    /// The line up to a record that does not count any more, of what counted when that was said of it.
    pub async fn load_as_it_was(
        store: &Store,
        gyro: u32,
        voided: Figures,
        method: JudgedMethod,
    ) -> Result<Self, StoreError> {
        let (mut left, mut entered) = (HashMap::new(), HashMap::new());
        for correction in store::correction::of_gyro(store, gyro).await? {
            let CorrectionItem { item, replaced_by, at, .. } = correction.correction;
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
        let mut rows = store::history::oldest(store, gyro, until, usize::MAX).await?;
        let withdrawn = store::history::voided(store, gyro, until).await?.into_iter();
        // What is set aside has never counted.
        rows.extend(withdrawn.filter(|row| left.contains_key(&row.record)));
        rows.retain(counted);
        rows.push(voided);
        let samples = rows.iter().map(|row| sample_of(row, method)).collect();
        Ok(Self::of_all(samples, load_marks(store, gyro).await?))
    }

    /// Everything stored of a gyro, with new rows put in their places: for records that arrive late.
    pub fn of_all(mut samples: Vec<Sample>, marks: Vec<Mark>) -> Self {
        samples.sort_by_key(|sample| sample.at);
        let mut line = Self { samples: Series::new(Vec::new(), marks), ..Self::default() };
        for sample in samples {
            line.append(sample);
        }
        line
    }

    /// When the newest record was made, whether it counts or repeats an earlier one.
    pub fn newest(&self) -> Option<UtcMicros> {
        let repeat = self.repeats.last().map(|[at, _]| *at);
        self.samples.last().map(|sample| sample.at).max(repeat)
    }

    pub fn marks(&self) -> &[Mark] {
        self.samples.marks()
    }

    pub fn samples(&self) -> &Series {
        &self.samples
    }

    /// When the records were made that repeat the one of `at`.
    pub fn repeats_of(&self, at: UtcMicros) -> impl Iterator<Item = UtcMicros> {
        self.repeats.iter().filter(move |[_, of]| *of == at).map(|[repeat, _]| *repeat)
    }

    /// Whether the record of `at` repeats another.
    pub fn is_repeat(&self, at: UtcMicros) -> bool {
        self.repeats.iter().any(|[repeat, _]| *repeat == at)
    }

    /// Records that are kept one by one.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether every record of the gyro is here, one by one.
    fn is_whole(&self) -> bool {
        self.from.is_none() && self.past.is_empty()
    }

    /// Adds a record that is newer than all.
    pub fn append(&mut self, sample: Sample) {
        if let Some(last) = self.samples.last()
            && sample.repeats(last)
        {
            self.repeats.push([sample.at, last.at]);
            return;
        }
        let since = baseline_since(self.marks(), sample.at);
        let stays = self.samples.last().is_some_and(|last| last.seat == sample.seat);
        if since != self.since {
            self.since = since;
            self.baseline.clear();
        }
        if self.baseline.is_empty() || !stays {
            self.seat_baseline.clear();
        }
        for baseline in [&mut self.baseline, &mut self.seat_baseline] {
            if baseline.len() < BASELINE_RECORDS {
                baseline.push(sample);
            }
        }
        self.samples.push(sample);
    }

    /// Whether new records (`samples`, oldest first), and all after the first of them, can be judged by what is here:
    /// everything that the rules look back to, and baselines to which none of them belongs.
    pub fn reaches_back(&self, samples: &[Sample], need: Need) -> bool {
        let [from, .., to] = samples else {
            return samples.first().is_none_or(|one| self.reaches_back(&[*one; 2], need));
        };
        let ([.., last_of_baseline], [.., last_of_seat]) = (&self.baseline[..], &self.seat_baseline[..]) else {
            return false;
        };
        let complete = [&self.baseline, &self.seat_baseline].iter().all(|of| of.len() == BASELINE_RECORDS)
            && from.at > last_of_baseline.at.max(last_of_seat.at);
        let same = [from, to].into_iter().all(|sample| baseline_since(self.marks(), sample.at) == self.since);
        let stays = self.samples.last().is_some_and(|last| samples.iter().all(|sample| sample.seat == last.seat));
        let before = self.samples.partition_point(|sample| sample.at < from.at);
        let repeats = samples.iter().any(|new| {
            let place = self.samples.partition_point(|sample| sample.at < new.at);
            let around = &self.samples[place.saturating_sub(1)..self.samples.len().min(place + 1)];
            around.iter().chain(samples).any(|other| other.at != new.at && new.repeats(other))
        });
        let far = self.from.is_none_or(|here| here <= days_before(from.at, need.days));
        complete && same && stays && !repeats && (self.is_whole() || far && before >= need.records)
    }

    /// Puts records in their places to which the line [reaches back](GyroWindow::reaches_back).
    pub fn insert(&mut self, late: impl IntoIterator<Item = Sample>) {
        self.samples.insert(late);
    }

    /// The history in which record `k` of a whole line, or of one to which it reaches back, is judged; `older` as of
    /// [`GyroWindow::older`].
    pub fn history_at(&self, k: usize, older: Older) -> History<'_> {
        if self.is_whole() {
            return History { older, ..History::whole(&self.samples, k) };
        }
        self.newest_history(older)
    }

    fn newest_history(&self, older: Older) -> History<'_> {
        History { samples: &self.samples, baseline: &self.baseline, seat_baseline: &self.seat_baseline, older }
    }

    /// What `range` compares with a record at `at` and is not kept one by one. The database is asked once in many
    /// records.
    pub async fn older(&mut self, source: Source<'_>, at: UtcMicros, days: f64) -> Result<Older, StoreError> {
        if self.past.is_empty() {
            return Ok(Older::NONE);
        }
        let window = days_before(at, days);
        let from = reset_before(self.marks(), at, Rule::Range).map_or(window, |reset| reset.max(window));
        if let Some(span) = self.past.wanted(from) {
            let rows = store::history::oldest(source.store, source.gyro, span, usize::MAX).await?;
            self.past.keep(rows.iter().map(|figures| sample_of(figures, source.method)).collect());
        }
        Ok(self.past.since(from))
    }

    /// Judges the newest record; `older` as of [`GyroWindow::older`]: nothing for a line that was never
    /// [shortened](GyroWindow::shorten).
    pub fn judge_newest(&self, limits: &Limits, older: Older) -> Vec<Verdict> {
        let Some(k) = self.samples.len().checked_sub(1) else { return Vec::new() };
        let mut verdicts = Vec::with_capacity(16);
        judge(&self.newest_history(older), k, limits, &mut verdicts);
        verdicts
    }

    /// Forgets what no rule looks back to. Done by eighths, so that it costs next to nothing in the long run.
    pub fn trim(&mut self, need: Need) {
        let Some(last) = self.newest() else { return };
        let wanted = looked_back_to(last, need);
        let mut gone = self.past.forget_before(wanted);
        let by_time = self.samples.partition_point(|sample| sample.at < wanted);
        let excess = by_time.min(self.samples.len().saturating_sub(need.records + 1));
        if excess > READ_AHEAD.max(self.samples.len() / 8) {
            gone = self.samples.get(excess - 1).map(|sample| sample.at);
            self.samples.forget(excess);
        }
        if let Some(gone) = gone {
            self.from = Some(UtcMicros(gone.0 + 1));
        }
    }

    /// Keeps one by one only the newest records: `keep`, or as many as the rules need. All must be stored: older ones
    /// may have to be read again.
    pub fn shorten(&mut self, keep: usize, need: Need) {
        let keep = keep.max(READ_AHEAD).max(need.records + 1);
        let runs = self.samples.len().saturating_sub(keep) / RUN;
        if runs == 0 {
            return;
        }
        for run in self.samples[..runs * RUN].chunks(RUN) {
            self.past.push(run);
        }
        self.samples.forget(runs * RUN);
    }
}

/// How many of a gyro's newest rows are read at once.
pub(crate) fn read_ahead(need: Need) -> usize {
    READ_AHEAD.max(need.records + 1)
}

/// Since when every record may still be asked for, where `last` is the newest.
fn looked_back_to(last: UtcMicros, need: Need) -> UtcMicros {
    days_before(last, need.days + LATE_DAYS)
}

/// The earliest instant from which [`UtcMicros::days_since`] counts no more than `days` up to `at`.
fn days_before(at: UtcMicros, days: f64) -> UtcMicros {
    UtcMicros(at.0.saturating_sub((days * UtcMicros::DAY as f64).round() as i64))
}

/// Records, oldest first, without those that repeat the one before.
pub(crate) fn distinct(samples: impl IntoIterator<Item = Sample>) -> Vec<Sample> {
    let mut kept: Vec<Sample> = Vec::new();
    for sample in samples {
        if kept.last().is_none_or(|last| !sample.repeats(last)) {
            kept.push(sample);
        }
    }
    kept
}

pub(crate) async fn load_marks(store: &Store, gyro: u32) -> Result<Vec<Mark>, StoreError> {
    let events = store::event::of_gyro(store, gyro).await?;
    Ok(events.iter().map(|row| mark_of(&row.told)).collect())
}

/// What was done to each of several gyros; those to which nothing was are left out.
pub(crate) async fn marks_of(store: &Store, gyros: &[u32]) -> Result<HashMap<u32, Vec<Mark>>, StoreError> {
    let mut marks = HashMap::<u32, Vec<Mark>>::new();
    for event in store::event::of_gyros(store, gyros).await? {
        marks.entry(event.gyro).or_default().push(mark_of(&event.told));
    }
    Ok(marks)
}

pub(crate) fn mark_of(event: &GyroEvent) -> Mark {
    Mark { at: event.at, event: event.event, until: event.until, fixed: event.fixed }
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
    Sample { at: figures.at, seat: Seat { imu: figures.imu, slot: figures.slot }, station: figures.station, d }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_begins_where_days_are_counted_to_begin() {
        let at = UtcMicros(1_700_000_000_123_456);
        for hundredths in 1..5_000 {
            let days = f64::from(hundredths) / 100.0;
            let from = days_before(at, days);
            assert!(at.days_since(from) <= days, "{days}");
            assert!(at.days_since(UtcMicros(from.0 - 1)) > days, "{days}");
        }
    }
}
