//! Which results of a gyro are put side by side, and how far they are apart.

use crate::config::{JudgedMethod, Judging};
use crate::core::bench::{BenchItem, BenchMethod};
use crate::core::judge::{Coefficient, Event, FigureSource, Mark, Measured, SourcedResult, agreement};
use crate::core::mounting::Slot;
use crate::pipeline::alerts::{NameLookup, Origin};
use crate::pipeline::ingest::judge::gyro_window::{load_marks, mark_of, sample_of};
use crate::pipeline::prelude::*;
use crate::store::{HistoryRow, Tables};

/// Results side by side, oldest first; ranges and verdicts of D_I and D_S.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    pub results: Vec<Compared>,
    /// max - min, deg/(h g0); none with fewer than two results.
    pub range: [Option<f64>; 2],
    pub verdicts: Vec<Verdict>,
}

/// One result.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    pub method: &'static str,
    pub source: FigureSource,
    pub at: UtcMicros,
    pub station: String,
    /// IMU and slot of a separation.
    pub seat: Option<(String, Slot)>,
    pub id: Id,
    /// D_I and D_S.
    pub d: [Measured; 2],
    /// In the ranges and the verdicts on them.
    pub counts: bool,
}

/// The results of a gyro within `span`; without one, those that were made to be compared: the separation nearest to
/// the newest bench result, and the bench results around it, as in the paper's Table 5 (before mounting and after).
/// Nothing from before the last repair; and of them those count that are not too old beside the newest. Within `span`
/// all do: whoever names it has said what is to be compared.
pub(super) async fn compare_methods(
    store: &Store,
    judging: &Judging,
    gyro: u32,
    span: Option<Span>,
) -> Result<Comparison, StoreError> {
    let (benches, separations) = match span {
        Some(span) => (
            store::bench::of_gyro(store, gyro, span).await?,
            store::history::oldest(store, gyro, span, usize::MAX).await?,
        ),
        None => made_to_be_compared(store, gyro, &Changes::default()).await?,
    };
    let naming = NameLookup { tables: &store.names().read(), new: None };
    let within_days = span.is_none().then_some(judging.agreement_days);
    Ok(compare(gyro, (&benches, &separations), within_days, judging, &naming))
}

/// How the methods agree on a gyro, and which result is the newest of them.
#[derive(Debug)]
pub(crate) struct Agreement {
    pub gyro: u32,
    pub origin: Origin,
    pub verdicts: Vec<Verdict>,
}

/// How the methods agree on a gyro once `changes` are stored; none where nothing is there to compare.
pub(crate) async fn agreement_after(
    store: &Store,
    judging: &Judging,
    gyro: u32,
    changes: &Changes,
) -> Result<Option<Agreement>, StoreError> {
    let (benches, separations) = made_to_be_compared(store, gyro, changes).await?;
    let naming = NameLookup { tables: &store.names().read(), new: Some(changes) };
    let compared = compare(gyro, (&benches, &separations), Some(judging.agreement_days), judging, &naming);
    let seat = separations.last().map(Origin::from);
    let of_seat = seat.as_ref();
    let of_bench = benches.iter().max_by_key(|bench| bench.measured_at).map(|bench| Origin {
        item: Some(bench.id),
        imu: of_seat.and_then(|seat| seat.imu),
        slot: of_seat.and_then(|seat| seat.slot),
        station: Some(bench.station),
        ..Origin::at(bench.measured_at)
    });
    let newest = seat.into_iter().chain(of_bench).max_by_key(|origin| origin.at);
    Ok(newest.map(|origin| Agreement { gyro, origin, verdicts: compared.verdicts }))
}

/// `within_days`: how much older than the newest a result may be and count.
fn compare(
    gyro: u32,
    (benches, separations): (&[BenchItem], &[Figures]),
    within_days: Option<f64>,
    judging: &Judging,
    naming: &NameLookup<'_>,
) -> Comparison {
    let mut results: Vec<Compared> = benches.iter().map(|bench| of_bench(bench, naming.tables)).collect();
    for figures in separations {
        results.push(of_separation(figures, JudgedMethod::Rigid, judging.method, naming.tables));
        if figures.published.is_some() {
            results.push(of_separation(figures, JudgedMethod::Published, judging.method, naming.tables));
        }
    }
    let imu = separations.last().map(|figures| naming.imu(figures.imu)).unwrap_or_default();
    let limits = judging.limits(&imu, &naming.gyro(gyro));
    results.sort_by_key(|result| (result.at, result.id, result.method));
    if let (Some(days), Some(newest)) = (within_days, results.last().map(|result| result.at)) {
        results.iter_mut().for_each(|result| result.counts &= newest.days_since(result.at) <= days);
    }
    let range = [0, 1].map(|column| range(&results, column));
    let drifts = [(Coefficient::DI, &limits.d_i), (Coefficient::DS, &limits.d_s)];
    let verdicts = drifts.into_iter().enumerate().filter_map(|(column, (coefficient, drift))| {
        let of = |r: &Compared| SourcedResult { source: r.source, at: r.at, measured: r.d[column] };
        let sourced: Vec<SourcedResult> = results.iter().filter(|r| r.counts).map(of).collect();
        drift.of(Rule::Agreement).map(|limit| agreement(coefficient, &sourced, within_days, limit, limits.confidence))
    });
    Comparison { range, verdicts: verdicts.collect(), results }
}

/// What is stored, with what `changes` add.
async fn made_to_be_compared(
    store: &Store,
    gyro: u32,
    changes: &Changes,
) -> Result<(Vec<BenchItem>, Vec<Figures>), StoreError> {
    let mut benches = store::bench::of_gyro(store, gyro, Span::EVER).await?;
    benches.retain(|bench| !changes.withdrawn.benches.contains(&(bench.id, gyro)));
    benches.extend(changes.benches.iter().filter(|bench| bench.gyro == gyro).cloned());
    benches.sort_by_key(|bench| (bench.measured_at, bench.method.name()));
    let newest_bench = benches.last().map(|bench| bench.measured_at);
    let stored = match newest_bench {
        _ if changes.withdrawn.gyros().contains(&gyro) => {
            let mut left = store::history::oldest(store, gyro, Span::EVER, usize::MAX).await?;
            left.retain(|figures| !changes.withdrawn.records.contains(&figures.record));
            left.into_iter().min_by_key(|figures| nearness(figures, newest_bench))
        }
        Some(at) => nearest(store, gyro, at).await?,
        None => store::history::newest(store, gyro, Span::EVER, 1).await?.pop(),
    };
    let stored = stored.map(|figures| {
        let again = |row: &&HistoryRow| row.gyro == gyro && row.figures.record == figures.record;
        changes.rejudged.history.iter().rfind(again).map_or(figures, |row| row.figures)
    });
    let new_rows = changes.history.iter().filter(|row| row.gyro == gyro).map(|row| row.figures);
    let separation = new_rows.chain(stored).min_by_key(|figures| nearness(figures, newest_bench));
    let mut marks = load_marks(store, gyro).await?;
    let new_marks = changes.events.iter().filter(|event| event.gyro == gyro);
    marks.extend(new_marks.map(|row| mark_of(&row.told)));
    let since = last_repair(&marks, newest_bench.max(separation.as_ref().map(|figures| figures.at)));
    let separation = separation.filter(|figures| figures.at >= since);
    let benches: Vec<BenchItem> = benches.into_iter().filter(|bench| bench.measured_at >= since).collect();
    let around = separation.as_ref().map(|figures| figures.at);
    let benches = BenchMethod::ALL.into_iter().flat_map(|method| {
        let of_method = benches.iter().filter(|bench| bench.method == method).cloned().collect();
        around_it(of_method, around)
    });
    Ok((benches.collect(), separation.into_iter().collect()))
}

/// How far from an instant, and of two as near the later first; without one, the newest first.
fn nearness(figures: &Figures, to: Option<UtcMicros>) -> (i64, i64) {
    (to.map_or(0, |at| (figures.at.0 - at.0).abs()), -figures.at.0)
}

/// The last repair up to `at`: what was before belongs, in effect, to another gyro.
fn last_repair(marks: &[Mark], at: Option<UtcMicros>) -> UtcMicros {
    let repairs = marks.iter().filter(|mark| mark.event == Event::Repair && Some(mark.at) <= at);
    repairs.map(|mark| mark.at).max().unwrap_or(Span::EVER.from)
}

/// The record nearest in time; of two as near, the later.
async fn nearest(store: &Store, gyro: u32, at: UtcMicros) -> Result<Option<Figures>, StoreError> {
    let before = store::history::newest(store, gyro, Span { to: at, ..Span::EVER }, 1).await?.pop();
    let after = store::history::oldest(store, gyro, Span { from: at, ..Span::EVER }, 1).await?.pop();
    Ok(match (before, after) {
        (Some(before), Some(after)) if at.0 - before.at.0 < after.at.0 - at.0 => Some(before),
        (before, after) => after.or(before),
    })
}

/// The nearest results before and after `at`, or the two nearest where all lie on one side; the newest three
/// where there is nothing to be near to. `benches` oldest first.
fn around_it(benches: Vec<BenchItem>, at: Option<UtcMicros>) -> Vec<BenchItem> {
    let end = benches.len();
    let kept = match at {
        None => end.saturating_sub(3)..end,
        Some(at) => match benches.partition_point(|bench| bench.measured_at <= at) {
            0 => 0..end.min(2),
            split if split == end => end.saturating_sub(2)..end,
            split => split - 1..split + 1,
        },
    };
    benches[kept].to_vec()
}

fn of_bench(bench: &BenchItem, tables: &Tables) -> Compared {
    Compared {
        method: bench.method.name(),
        source: FigureSource::Bench(bench.method),
        at: bench.measured_at,
        station: tables.stations.text(bench.station).to_owned(),
        seat: None,
        id: bench.id,
        d: [0, 1].map(|i| Measured { value: bench.d[i], sd: bench.sd[i] }),
        counts: true,
    }
}

fn of_separation(figures: &Figures, method: JudgedMethod, judged: JudgedMethod, tables: &Tables) -> Compared {
    let [d_i, d_s, _] = sample_of(figures, method).d;
    Compared {
        method: method.name(),
        source: FigureSource::Separation,
        at: figures.at,
        station: tables.stations.text(figures.station).to_owned(),
        seat: Some((tables.imus.text(figures.imu).to_owned(), figures.slot)),
        id: figures.record,
        d: [d_i, d_s],
        counts: method == judged || figures.published.is_none(),
    }
}

/// max - min of those that count.
fn range(results: &[Compared], column: usize) -> Option<f64> {
    let values: Vec<f64> = results.iter().filter(|r| r.counts).map(|r| r.d[column].value).collect();
    let highest = values.iter().copied().reduce(f64::max)?;
    let lowest = values.iter().copied().reduce(f64::min)?;
    (values.len() > 1).then_some(highest - lowest)
}
