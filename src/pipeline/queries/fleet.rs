//! The fleet at a glance: every gyro's newest figures, how it stands, and its last few values.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use super::agreement::{AlertFinding, told};
use super::entries::fleet_histories;
use super::record::Records;
use super::stations::{StationEffect, station_effects};
use super::status;
use crate::config::Config;
use crate::core::changes::{self, FleetStations};
use crate::core::figures::Figures;
use crate::core::judge::{BASELINE_RECORDS, Mark, Measured, Sample, baseline_since, stated_level};
use crate::core::judge::{Coefficient, Event, Rule, State, Status, overdue};
use crate::core::mounting::Slot;
use crate::core::time::Span;
use crate::core::time::UtcMicros;
use crate::pipeline::error::StorageError;
use crate::pipeline::ingest::judge::gyro_window::{distinct, marks_of, sample_of};
use crate::store;
use crate::store::{RecordHead, Store, StoreError, StoredVerdict, Stretch, Tables};
use crate::system::Clock;
use crate::wire::answer::VerdictBody;
use crate::words;

/// How one gyro stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    pub number: u32,
    pub serial: Arc<str>,
    /// Its newest calibration; none for a gyro that only a bench has seen.
    pub newest: Option<Figures>,
    /// The worst of what the rules that could judge say of its newest calibration, requirements on E and G included;
    /// indeterminate while none could judge its drift, none before the first calibration. While an alert of
    /// `agreement` fires, exceeded whatever they say.
    pub state: Option<State>,
    /// What all of that comes to, and whether its calibration is overdue: the worst of it.
    pub status: Option<Status>,
    /// What the verdicts on D_I, D_S and D_O of its newest calibration come to.
    pub drift: [Status; 3],
    /// What it violates.
    pub violations: Vec<Violation>,
    /// The largest figure over its limit, of the rules of D_I, D_S and the closure, `agreement` among them where it
    /// fires.
    pub load: f64,
    /// Days since its last calibration, where that is longer than its interval.
    pub overdue_days: Option<f64>,
    /// That it was retired or put into storage, and not calibrated since.
    pub out_of_use: Option<Event>,
}

/// A rule that says that a gyro is beyond a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Violation {
    pub coefficient: Coefficient,
    pub rule: Rule,
    pub status: Status,
}

impl Standing {
    /// Whether a filter by status finds it: one that is overdue is, whatever else is the matter with it.
    pub fn is(&self, status: Status) -> bool {
        self.status == Some(status) || status == Status::Overdue && self.overdue_days.is_some()
    }
}

/// The gyros whose newest calibration was made in one IMU.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Seats {
    /// In it, in the order of their slots: nothing has been calibrated in their slot since.
    pub now: Vec<Standing>,
    /// Another gyro has been calibrated in their slot since; the last to leave first.
    pub before: Vec<Standing>,
    /// Whether a calibration that counts separated any gyro in it, wherever that gyro is now.
    pub used: bool,
}

/// A gyro's last few values, and what they are held against.
#[derive(Debug, Clone, PartialEq)]
pub struct RecentValues {
    /// Oldest first, by the judged method.
    pub samples: Vec<Sample>,
    /// Level of D_I and D_S that the newest is compared with; none before the baseline is complete.
    pub level: [Option<f64>; 2],
    /// How far D_I and D_S may lie from it, deg/(h g0).
    pub budget: [Option<f64>; 2],
}

/// Every gyro. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Fleet {
    pub(super) store: Store,
    pub(super) config: Arc<Config>,
    pub(super) clock: Clock,
    pub(super) records: Records,
}

impl Fleet {
    /// Every gyro, by serial.
    pub async fn all(&self) -> Result<Vec<Standing>, StorageError> {
        self.standings(store::gyro::newest_of_gyros(&self.store, 0, u32::MAX).await?).await
    }

    /// Gyros with numbers above `after`, and the last number looked at where there are more than `most`: one more is
    /// looked at.
    pub async fn page(&self, after: u32, most: u32) -> Result<(Vec<Standing>, Option<u32>), StorageError> {
        let rows = store::gyro::newest_of_gyros(&self.store, after, most + 1).await?;
        let last = rows.last().filter(|_| rows.len() > most as usize).map(|(number, _)| *number);
        Ok((self.standings(rows).await?, last))
    }

    /// Every station that calibrated a gyro lately, by name.
    pub async fn stations(&self) -> Result<Vec<StationEffect>, StorageError> {
        Ok(station_effects(&self.store, self.config.judging.method).await?)
    }

    /// What every station does to the gyros that it measured lately; none without records. Computes for a second of
    /// many gyros, on a thread for that.
    ///
    /// # Errors
    /// [`StorageError`].
    pub async fn station_figures(&self) -> Result<Option<FleetStations>, StorageError> {
        let histories = fleet_histories(&self.store, self.config.judging.method).await?;
        let figures = words::spawn_blocking(move || changes::stations(&histories)).await;
        let failed = |error| StoreError::Damaged(format!("the stations could not be compared: {error}"));
        Ok(figures.map_err(failed)?)
    }

    /// The gyros whose newest calibration was made in this IMU: a slot holds one of them.
    pub async fn seated_in(&self, imu: u32) -> Result<Seats, StorageError> {
        let mut newest = store::gyro::newest_of_gyros(&self.store, 0, u32::MAX).await?;
        newest.retain(|(_, figures)| figures.is_some_and(|figures| figures.imu == imu));
        let slots = newest.iter().filter_map(|(_, figures)| Some(figures.as_ref()?.slot)).collect();
        let last = self.last_uses(imu, slots).await?;
        let is_last = |figures: Figures| last.get(&figures.slot) == Some(&figures.at);
        let standings = self.standings(newest).await?.into_iter();
        let (mut now, mut before): (Vec<_>, Vec<_>) =
            standings.partition(|standing| standing.newest.is_some_and(is_last));
        now.sort_by_key(|standing| standing.newest.map(|newest| newest.slot));
        before.sort_by_key(|standing| standing.newest.map(|newest| (Reverse(newest.at), newest.slot)));
        Ok(Seats { now, before, used: !last.is_empty() })
    }

    /// When each of these slots of an IMU was last calibrated: a gyro that has gone on to another IMU since has left
    /// its slot all the same. A record need not hold every slot, so earlier ones are looked at until each was seen;
    /// without slots, until any was.
    async fn last_uses(&self, imu: u32, slots: BTreeSet<Slot>) -> Result<BTreeMap<Slot, UtcMicros>, StoreError> {
        let (mut last, mut seen, mut many) = (BTreeMap::new(), 0, 4);
        loop {
            let heads = store::record::of_imu(&self.store, imu, many).await?;
            for figures in self.rows_of(&heads[seen.min(heads.len())..]).await? {
                let used = last.entry(figures.slot).or_insert(figures.at);
                *used = figures.at.max(*used);
            }
            let found = !last.is_empty() && slots.iter().all(|slot| last.contains_key(slot));
            if found || heads.len() < many as usize {
                return Ok(last);
            }
            (seen, many) = (heads.len(), many.saturating_mul(4));
        }
    }

    /// What these records found of their gyros.
    async fn rows_of(&self, heads: &[RecordHead]) -> Result<Vec<Figures>, StoreError> {
        let sheets: HashMap<_, _> =
            store::record::verdict_sheets(&self.store, heads.iter().map(|head| head.id)).await?.into_iter().collect();
        let of = |head: &RecordHead| {
            let then = Span { from: head.calibrated_at, to: head.calibrated_at };
            let gyros = sheets.get(&head.id).map_or(&[][..], |sheet| &sheet.0);
            gyros.iter().map(move |(gyro, _)| (*gyro, then)).collect::<Vec<Stretch>>()
        };
        let stretches: Vec<Stretch> = heads.iter().flat_map(of).collect();
        Ok(store::histories::oldest(&self.store, &stretches, 1).await?.concat())
    }

    /// How gyros stand with these newest calibrations.
    pub async fn standings(&self, newest: Vec<(u32, Option<Figures>)>) -> Result<Vec<Standing>, StorageError> {
        let records: HashSet<_> = newest.iter().filter_map(|(_, figures)| Some(figures.as_ref()?.record)).collect();
        let sheets = store::record::verdict_sheets(&self.store, records.into_iter()).await?;
        let verdicts: HashMap<_, _> = sheets
            .iter()
            .flat_map(|(record, sheet)| sheet.0.iter().map(|(gyro, verdicts)| ((*record, *gyro), verdicts.as_slice())))
            .collect();
        let only = if let [(one, _)] = newest.as_slice() { Some(*one) } else { None };
        let told = told(&self.store, only).await?;
        let out_of_use = store::event::out_of_use(&self.store).await?;
        let tables = self.store.names().read();
        let standing = |(number, newest): (u32, Option<Figures>)| {
            let of_newest = newest.as_ref().and_then(|figures| verdicts.get(&(figures.record, number)));
            let told = told.get(&number).map_or(&[][..], Vec::as_slice);
            let verdicts = (of_newest.copied().unwrap_or_default(), told);
            self.standing(&tables, number, newest, verdicts, out_of_use.get(&number).copied())
        };
        Ok(newest.into_iter().filter_map(standing).collect())
    }

    /// How one gyro stands, and the verdicts on its newest record in words; none where there is no such gyro.
    pub async fn standing_in_words(&self, number: u32) -> Result<Option<(Standing, Vec<VerdictBody>)>, StorageError> {
        let newest = store::history::newest(&self.store, number, Span::EVER, 1).await?.pop();
        let stored = match &newest {
            Some(figures) => self.records.reread(figures.record).await?,
            None => None,
        };
        let said = match &stored {
            Some(stored) => self.records.verdicts_in_words(&stored.row, &stored.calibration).await?.0,
            None => Vec::new(),
        };
        let sheet = stored.as_ref().map_or(&[][..], |stored| &stored.row.verdicts.0);
        let verdicts = sheet.iter().find(|(gyro, _)| *gyro == number).map_or(&[][..], |(_, verdicts)| verdicts);
        let told = told(&self.store, Some(number)).await?.remove(&number).unwrap_or_default();
        let out_of_use = store::event::out_of_use(&self.store).await?.get(&number).copied();
        let (verdicts, tables) = ((verdicts, told.as_slice()), self.store.names().read());
        let Some(standing) = self.standing(&tables, number, newest, verdicts, out_of_use) else {
            return Ok(None);
        };
        let said = said.into_iter().filter(|verdict| *verdict.serial == *standing.serial).collect();
        Ok(Some((standing, said)))
    }

    /// How a gyro stands with this newest calibration, the verdicts on it, and what alerts know besides.
    fn standing(
        &self,
        tables: &Tables,
        number: u32,
        newest: Option<Figures>,
        (verdicts, told): (&[StoredVerdict], &[AlertFinding]),
        out_of_use: Option<(UtcMicros, Event)>,
    ) -> Option<Standing> {
        let serial = tables.gyros.name(number)?.clone();
        let imu = newest.as_ref().and_then(|figures| tables.imus.name(figures.imu)).map_or("", |name| &**name);
        let limits = self.config.judging.limits(imu, &serial);
        let interval = limits.interval_days;
        let out_of_use = out_of_use.filter(|(at, _)| newest.as_ref().is_none_or(|figures| *at >= figures.at));
        let in_use = newest.as_ref().filter(|_| out_of_use.is_none());
        let late = in_use.zip(interval).map(|(figures, days)| overdue(figures.at, self.clock.now(), days));
        let overdue_days = late.filter(|verdict| verdict.state == State::Exceeded).and_then(|verdict| verdict.value);
        let of_newest = newest.as_ref().map(|figures| worst(figures, verdicts));
        // The alert of a rule that has been switched off since stands until the gyro's next item.
        let asked = |told: &&AlertFinding| told.rule == Rule::Agreement && limits.agreement(told.coefficient).is_some();
        let disagreements: Vec<&AlertFinding> = told.iter().filter(asked).collect();
        let of_methods = (!disagreements.is_empty()).then_some(State::Exceeded);
        let loads = verdicts.iter().filter_map(load).chain(disagreements.iter().map(|found| found.load));
        let violations: Vec<Violation> =
            violations(verdicts, told).chain(disagreements.iter().map(|told| Violation::of(told))).collect();
        let worst_of = violations.iter().map(|violation| violation.status).chain(overdue_days.map(|_| Status::Overdue));
        let of_verdicts = newest.as_ref().map(|_| status::of_gyro(verdicts));
        Some(Standing {
            number,
            serial,
            state: of_newest.max(of_methods),
            status: worst_of.max().max(of_verdicts),
            drift: status::of_drift(verdicts),
            violations,
            load: loads.fold(0.0, f64::max),
            overdue_days,
            out_of_use: out_of_use.map(|(_, event)| event),
            newest,
        })
    }

    /// The last `count` values of each of these gyros, in three queries however many they are.
    pub async fn recent_values(&self, of: &[&Standing], count: usize) -> Result<Vec<RecentValues>, StorageError> {
        let gyros: Vec<u32> = of.iter().map(|standing| standing.number).collect();
        let marks = marks_of(&self.store, &gyros).await?;
        let marks: Vec<&[Mark]> = gyros.iter().map(|gyro| marks.get(gyro).map_or(&[][..], Vec::as_slice)).collect();
        let ever: Vec<Stretch> = gyros.iter().map(|gyro| (*gyro, Span::EVER)).collect();
        let rows = store::histories::newest(&self.store, &ever, count).await?;
        let newest_baseline = |k: usize| {
            let last = last_of(&rows[k]);
            (gyros[k], Span { from: baseline_since(marks[k], last).unwrap_or(Span::EVER.from), to: last })
        };
        let of_baselines: Vec<Stretch> = (0..of.len()).map(newest_baseline).collect();
        // Some of the first may repeat one another.
        let baselines = store::histories::oldest(&self.store, &of_baselines, 4 * BASELINE_RECORDS).await?;
        Ok((0..of.len()).map(|k| self.recent(of[k], marks[k], &rows[k], &baselines[k])).collect())
    }

    fn recent(&self, standing: &Standing, marks: &[Mark], rows: &[Figures], baseline: &[Figures]) -> RecentValues {
        let method = self.config.judging.method;
        let samples = |rows: &[Figures]| -> Vec<Sample> { rows.iter().map(|row| sample_of(row, method)).collect() };
        let last = last_of(rows);
        let imu = rows.last().and_then(|figures| self.store.names().read().imus.name(figures.imu).cloned());
        let limits = self.config.judging.limits(imu.as_deref().unwrap_or_default(), &standing.serial);
        let drifts = [limits.d_i, limits.d_s];
        let baseline = distinct(samples(baseline));
        RecentValues {
            samples: samples(rows),
            level: [0, 1].map(|column| {
                let fixed = stated_level(marks, last, column).or(drifts[column].fixed_baseline);
                level(&baseline, column, fixed)
            }),
            budget: drifts.map(|drift| drift.of(Rule::Baseline).map(|limit| limit.value)),
        }
    }
}

fn last_of(rows: &[Figures]) -> UtcMicros {
    rows.last().map_or(UtcMicros(0), |figures| figures.at)
}

/// The median of a complete baseline, or the one that is fixed.
pub(crate) fn level(baseline: &[Sample], column: usize, fixed: Option<Measured>) -> Option<f64> {
    if let Some(fixed) = fixed {
        return Some(fixed.value);
    }
    let first: Vec<Measured> = baseline.get(..BASELINE_RECORDS)?.iter().map(|sample| sample.d[column]).collect();
    Measured::median(&first).map(|median| median.value)
}

/// Of the rules that could judge; of the drift none may have, however well E and G keep to their requirements.
fn worst(figures: &Figures, verdicts: &[StoredVerdict]) -> State {
    let of_drift = figures.states.worst().unwrap_or(State::Indeterminate);
    let judged = verdicts.iter().filter(|verdict| verdict.value.is_some());
    judged.map(|verdict| verdict.state).fold(of_drift, State::max)
}

fn violations(verdicts: &[StoredVerdict], told: &[AlertFinding]) -> impl Iterator<Item = Violation> {
    let beyond = verdicts.iter().filter(|verdict| verdict.state == State::Exceeded);
    beyond.map(|verdict| {
        let StoredVerdict { coefficient, rule, .. } = *verdict;
        let same = told.iter().find(|told| (told.coefficient, told.rule) == (coefficient, rule));
        let status = same.map_or(verdict.status(), |told| told.status.max(verdict.status()));
        Violation { coefficient, rule, status }
    })
}

impl Violation {
    fn of(told: &AlertFinding) -> Self {
        let AlertFinding { coefficient, rule, status, .. } = *told;
        Self { coefficient, rule, status }
    }
}

/// How much of its limit a figure takes up. E and G against their requirements lie between two limits: that is no
/// measure.
fn load(verdict: &StoredVerdict) -> Option<f64> {
    let of_history = verdict.rule != Rule::Requirement && verdict.limit > 0.0;
    verdict.value.filter(|_| of_history).map(|value| value / verdict.limit)
}
