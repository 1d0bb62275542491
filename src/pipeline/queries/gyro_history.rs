//! One gyro's whole course: every calibration, bench result and event, and the levels it was held against.

use super::agreement::compare_methods;
use super::fleet::{level, stated};
use crate::config::JudgedMethod;
use crate::core::bench::BenchItem;
use crate::core::correction::CorrectedResult;
use crate::core::gyro_event::GyroEvent;
use crate::core::judge::history::{baseline_of, seat_baseline_of};
use crate::core::judge::{BASELINE_RECORDS, Coefficient, Event, Limits, Mark, Sample};
use crate::pipeline::ingest::judge::gyro_window::{distinct, load_marks, mark_of, sample_of};
use crate::pipeline::prelude::*;
use crate::pipeline::{Comparison, Statuses};
use crate::store::StoredVerdict;

/// Everything about one gyro, oldest first.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroTimeline {
    pub figures: Vec<Figures>,
    pub benches: Vec<BenchItem>,
    pub events: Vec<GyroEvent>,
    /// What was said of results that do not count any more.
    pub corrections: Vec<CorrectedResult>,
    /// Records that do not count until somebody confirms their times.
    pub set_aside: Vec<(Id, UtcMicros)>,
    pub baselines: Vec<Baseline>,
    /// Environmental tests, with what the gyro was before and after.
    pub tests: Vec<Tested>,
    /// What its newest record is judged against.
    pub limits: Limits,
}

/// The level that the records from one reset to the next are compared with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Baseline {
    pub from: UtcMicros,
    pub until: UtcMicros,
    /// Whether nothing but a move to another IMU or slot began it: the levels of D_I and D_S go on.
    pub moved: bool,
    /// D_I, D_S and the closure; none where there are too few records.
    pub level: [Option<f64>; 3],
    /// First and last of the records that made each level; none where it is stated, or not made yet.
    pub made: [Option<(UtcMicros, UtcMicros)>; 3],
}

impl Baseline {
    /// Of one of D_I, D_S and D_O: D_I and D_S go on where the gyro has moved, D_O does not.
    pub fn stretches(all: &[Self], column: usize) -> Vec<Self> {
        let mut joined: Vec<Self> = Vec::new();
        for baseline in all {
            match joined.last_mut() {
                // A level that the records before the move were too few for is there after it.
                Some(before) if baseline.moved && column < 2 => {
                    *before = Self { from: before.from, moved: before.moved, ..*baseline };
                }
                _ => joined.push(*baseline),
            }
        }
        joined
    }
}

/// What the points of one coefficient are held against.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    /// When each level begins, oldest first; none while there are too few records.
    levels: Vec<(UtcMicros, Option<f64>)>,
    /// How far a point may be from its level; none where no rule says so.
    pub budget: Option<f64>,
}

impl std::hash::Hash for Levels {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        let levels = self.levels.iter().map(|(from, level)| (from.0, level.map(f64::to_bits)));
        (levels.collect::<Vec<_>>(), self.budget.map(f64::to_bits)).hash(state);
    }
}

impl Levels {
    /// The baseline at an instant.
    pub fn at(&self, at: UtcMicros) -> Option<f64> {
        let begun = self.levels.partition_point(|(from, _)| *from <= at);
        self.levels.get(begun.checked_sub(1)?)?.1
    }
}

/// An environmental test.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    pub event: GyroEvent,
    /// The last record before it, and the first after.
    pub before: Option<Figures>,
    pub after: Option<Figures>,
    /// What `before_after` says of D_I and D_S of the first record after it; none where another test or a reset lies
    /// between, and where the rule is off.
    pub verdicts: [Option<StoredVerdict>; 2],
}

impl Tested {
    /// When it was over.
    pub fn until(&self) -> UtcMicros {
        self.event.end()
    }
}

/// What was measured of one gyro, and what became of it. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Histories {
    pub(super) store: Store,
    pub(super) config: Arc<Config>,
    pub(super) clock: Clock,
}

impl Histories {
    /// A gyro's course, its baselines by `method`.
    pub async fn course(&self, gyro: u32, serial: &str, method: JudgedMethod) -> Result<GyroTimeline, StoreError> {
        let figures = store::history::oldest(&self.store, gyro, Span::EVER, usize::MAX).await?;
        let events = store::event::of_gyro(&self.store, gyro).await?;
        let events: Vec<GyroEvent> = events.into_iter().map(|row| row.told).collect();
        let marks: Vec<Mark> = events.iter().map(mark_of).collect();
        let benches = self.benches(gyro, Span::EVER).await?;
        let corrections = store::correction::of_gyro(&self.store, gyro).await?;
        let set_aside = store::set_aside::of_gyro(&self.store, gyro).await?;
        let limits = self.limits(serial, &figures);
        let samples = distinct(figures.iter().map(|figures| sample_of(figures, method)));
        let tests = self.tests(gyro, &events, &figures).await?;
        let baselines = baselines(&samples, &marks, &limits);
        Ok(GyroTimeline { baselines, figures, benches, events, corrections, set_aside, tests, limits })
    }

    /// The baselines of one of D_I, D_S and D_O by `method`, and the budget that its newest record is judged by.
    pub async fn levels(
        &self,
        gyro: u32,
        serial: &str,
        method: JudgedMethod,
        column: usize,
    ) -> Result<Levels, StoreError> {
        let figures = store::history::oldest(&self.store, gyro, Span::EVER, usize::MAX).await?;
        let marks = load_marks(&self.store, gyro).await?;
        let limits = self.limits(serial, &figures);
        let samples = distinct(figures.iter().map(|figures| sample_of(figures, method)));
        let stretches = Baseline::stretches(&baselines(&samples, &marks, &limits), column);
        let levels = stretches.iter().map(|stretch| (stretch.from, stretch.level[column])).collect();
        Ok(Levels { levels, budget: limits.budgets()[column] })
    }

    /// What the newest record of a gyro is judged against.
    pub(super) fn limits(&self, serial: &str, figures: &[Figures]) -> Limits {
        let imu = figures.last().and_then(|newest| self.store.names().read().imus.name(newest.imu).map(Arc::from));
        self.config.judging.limits(imu.as_deref().unwrap_or_default(), serial)
    }

    /// The results of a gyro by every method, within `span`; without one, those that were made to be compared.
    pub async fn compare_methods(&self, gyro: u32, span: Option<Span>) -> Result<Comparison, StoreError> {
        compare_methods(&self.store, &self.config.judging, gyro, span).await
    }

    /// Calibrations that count, oldest first.
    pub async fn oldest(&self, gyro: u32, span: Span, most: usize) -> Result<Vec<Figures>, StoreError> {
        store::history::oldest(&self.store, gyro, span, most).await
    }

    /// The newest calibrations that count, oldest first.
    pub async fn newest(&self, gyro: u32, span: Span, most: usize) -> Result<Vec<Figures>, StoreError> {
        store::history::newest(&self.store, gyro, span, most).await
    }

    /// Calibrations that count no more, oldest first.
    pub async fn voided(&self, gyro: u32, span: Span) -> Result<Vec<Figures>, StoreError> {
        store::history::voided(&self.store, gyro, span).await
    }

    /// Records that do not count until somebody confirms their times.
    pub async fn set_aside(&self, gyro: u32) -> Result<Vec<(Id, UtcMicros)>, StoreError> {
        store::set_aside::of_gyro(&self.store, gyro).await
    }

    /// How many calibrations of a gyro there are.
    pub async fn count(&self, gyro: u32) -> Result<usize, StoreError> {
        store::history::count(&self.store, gyro).await
    }

    /// What was done to a gyro, oldest first.
    pub async fn events(&self, gyro: u32) -> Result<Vec<(Id, GyroEvent)>, StoreError> {
        let events = store::event::of_gyro(&self.store, gyro).await?;
        Ok(events.into_iter().map(|row| (row.id, row.told)).collect())
    }

    /// Bench results that count, oldest first.
    pub async fn benches(&self, gyro: u32, span: Span) -> Result<Vec<BenchItem>, StoreError> {
        store::bench::of_gyro(&self.store, gyro, span).await
    }

    /// Bench results, those included that count no more.
    pub async fn all_benches(&self, gyro: u32, span: Span) -> Result<Vec<BenchItem>, StoreError> {
        store::bench::all_of_gyro(&self.store, gyro, span).await
    }

    /// What the rules say of these calibrations of one gyro, for these columns of D_I, D_S and D_O.
    pub async fn statuses(
        &self,
        gyro: u32,
        rows: impl Iterator<Item = &Figures>,
        columns: &[usize],
    ) -> Result<Statuses, StoreError> {
        Statuses::of(&self.store, gyro, rows, columns).await
    }

    async fn tests(&self, gyro: u32, events: &[GyroEvent], figures: &[Figures]) -> Result<Vec<Tested>, StoreError> {
        let mut tests = tested(events, figures);
        let after = tests.iter().filter_map(|test| Some(test.after?.record));
        let sheets = store::record::record_verdicts(&self.store, after).await?;
        let ends: Vec<UtcMicros> = tests.iter().map(Tested::until).collect();
        for test in &mut tests {
            let Some(after) = &test.after else { continue };
            // The rule judges by the test that was over last.
            let judged = ends.iter().all(|end| *end <= test.until() || *end > after.at);
            let sheet = sheets.get(&after.record).filter(|_| judged);
            let verdicts = sheet.map_or(&[][..], |sheet| sheet.of(gyro));
            test.verdicts = [Coefficient::DI, Coefficient::DS].map(|coefficient| {
                let of_test = |one: &&StoredVerdict| (one.rule, one.coefficient) == (Rule::BeforeAfter, coefficient);
                verdicts.iter().find(of_test).copied()
            });
        }
        Ok(tests)
    }
}

/// The environmental tests among `events`, oldest first, with the records before and after; not judged yet.
fn tested(events: &[GyroEvent], figures: &[Figures]) -> Vec<Tested> {
    let tests = events.iter().filter(|event| event.event == Event::EnvironmentalTest);
    let with_records = tests.map(|event| Tested {
        before: figures[..figures.partition_point(|row| row.at < event.at)].last().copied(),
        after: figures.get(figures.partition_point(|row| row.at < event.end())).copied(),
        event: event.clone(),
        verdicts: [None; 2],
    });
    with_records.collect()
}

/// One baseline for each stretch between the events that reset it, and between the moves from one IMU or slot to
/// another.
fn baselines(samples: &[Sample], marks: &[Mark], limits: &Limits) -> Vec<Baseline> {
    let Some((first, last)) = samples.first().zip(samples.last()) else { return Vec::new() };
    let resets = marks.iter().filter(|mark| mark.event.resets_baseline() && mark.at > first.at && mark.at <= last.at);
    let between = |pair: &[Sample]| resets.clone().any(|mark| pair[0].at < mark.at && mark.at <= pair[1].at);
    // Where an event has begun everything anew before it, a move begins nothing.
    let moves = samples.windows(2).filter(|pair| pair[0].seat != pair[1].seat && !between(pair)).map(|pair| pair[1].at);
    let own = std::iter::once(first.at).chain(resets.clone().map(|mark| mark.at)).map(|at| (at, false));
    let mut starts: Vec<(UtcMicros, bool)> = own.chain(moves.map(|at| (at, true))).collect();
    starts.sort_unstable();
    starts.dedup_by_key(|(at, _)| *at);
    let ends = starts[1..].iter().map(|(at, _)| *at).chain([last.at]);
    let stretch = |(&(from, moved), until): (&(UtcMicros, bool), UtcMicros)| {
        let end = samples.partition_point(|sample| sample.at < until || until == last.at);
        let newest = samples[..end].last().map_or(from, |sample| sample.at.max(from));
        let drift = baseline_of(&samples[..end], marks, newest);
        let records = [drift, drift, seat_baseline_of(&samples[..end], marks, newest)];
        let stated = |column: usize| stated(marks, newest, limits, column);
        let made = |column: usize| {
            let records = records[column].get(..BASELINE_RECORDS).filter(|_| stated(column).is_none())?;
            Some((records[0].at, records[BASELINE_RECORDS - 1].at))
        };
        let level = |column: usize| level(records[column], column, stated(column));
        Baseline { from, until, moved, level: [0, 1, 2].map(level), made: [0, 1, 2].map(made) }
    };
    starts.iter().zip(ends).map(stretch).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::{Measured, Seat};

    fn day(day: i64) -> UtcMicros {
        UtcMicros(day * UtcMicros::DAY)
    }

    fn samples(values: &[(i64, f64)]) -> Vec<Sample> {
        let sample = |&(d, value): &(i64, f64)| {
            let seat = Seat { imu: u32::from(d >= 500), ..Seat::default() };
            Sample { at: day(d), seat, station: 0, d: [Measured::exact(value); 3] }
        };
        values.iter().map(sample).collect()
    }

    #[test]
    fn every_reset_begins_a_level_of_its_own_and_too_few_records_give_none() {
        let all = samples(&[(0, 1.0), (10, 2.0), (20, 3.0), (30, 9.0), (40, 5.0), (50, 5.0), (60, 8.0), (70, 1.0)]);
        let mark = |at, event| Mark::of(day(at), event);
        let marks = [mark(5, Event::Transport), mark(35, Event::Repair), mark(65, Event::Baseline)];
        let found = baselines(&all, &marks, &Limits::from_budget(0.01));
        let seen: Vec<_> = found.iter().map(|b| (b.from, b.until, b.level[0])).collect();
        assert_eq!(
            seen,
            [(day(0), day(35), Some(2.0)), (day(35), day(65), Some(5.0)), (day(65), day(70), None)],
            "transport resets nothing; the last baseline has one record of three"
        );
    }

    #[test]
    fn a_move_begins_a_level_of_the_closure_alone() {
        let all = samples(&[(0, 1.0), (10, 1.0), (20, 1.0), (500, 4.0), (510, 5.0), (520, 6.0)]);
        let found = baselines(&all, &[], &Limits::from_budget(0.01));
        assert_eq!(found[1].made, [Some((day(0), day(20))), Some((day(0), day(20))), Some((day(500), day(520)))]);
        let seen: Vec<_> = found.iter().map(|b| (b.from, b.moved, b.level)).collect();
        assert_eq!(seen, [(day(0), false, [Some(1.0); 3]), (day(500), true, [Some(1.0), Some(1.0), Some(5.0)])]);
        // Moved before there were enough: the level of D_I is there from the first record on, that of D_O is not.
        let early = baselines(&all[1..], &[], &Limits::from_budget(0.01));
        assert_eq!(early[0].level, [None; 3]);
        let joined = |column| -> Vec<_> {
            Baseline::stretches(&early, column).iter().map(|b| (b.from, b.level[column])).collect()
        };
        assert_eq!(joined(0), [(day(10), Some(1.0))]);
        assert_eq!(joined(2), [(day(10), None), (day(500), Some(5.0))]);
        // Where an event resets the baseline before the record that moves, or with it, all levels begin.
        for at in [200, 500] {
            let found = baselines(&all, &[Mark::of(day(at), Event::Repair)], &Limits::from_budget(0.01));
            assert_eq!((found.len(), found[1].moved, found[1].level), (2, false, [Some(5.0); 3]), "{at}");
        }
        let marks = [Mark::of(day(500), Event::Reinstallation)];
        let found = baselines(&all, &marks, &Limits::from_budget(0.01));
        assert_eq!((found.len(), found[1].moved, found[1].level), (2, false, [Some(5.0); 3]));
    }
}
