//! How one gyro stands: what follows from its newest calibration, the verdicts on it, its alerts and what was done to
//! it, for a page of now and for the row that lists are made of.

use crate::config::Judging;
use crate::core::gyro_attributes::GyroAttributes;
use crate::core::judge::{BudgetProjection, Coefficient, Event, LimitKind, Limits, Severity, State, Status, overdue};
use crate::pipeline::alerts::{finding_of, status_of};
use crate::pipeline::ingest::judge::gyro_window::sample_of;
use crate::pipeline::prelude::*;
use crate::pipeline::queries::status;
use crate::store::{AlertRow, HeadRow, NewestRow, RecordVerdicts, StoredVerdict};

/// How one gyro stands.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroStatus {
    pub number: u32,
    pub serial: Arc<str>,
    /// Its newest calibration; none for a gyro that only a bench has seen.
    pub newest: Option<Figures>,
    /// The worst of what the rules that could judge say of its newest calibration, requirements on E and G included;
    /// indeterminate while none could judge its drift, none before the first calibration. While an alert of
    /// `agreement` fires, exceeded whatever they say.
    pub state: Option<State>,
    /// What all of that comes to, and whether its calibration is overdue: the worst of it. Every gyro has one.
    pub status: Option<Status>,
    /// What the verdicts on D_I, D_S and D_O of its newest calibration come to.
    pub drift: [Status; 3],
    pub violations: Vec<Violation>,
    /// The largest figure over its limit, of the rules of D_I, D_S and the closure, `agreement` among them where it
    /// fires.
    pub load: f64,
    /// Days since its last calibration, where that is longer than its interval.
    pub overdue_days: Option<f64>,
    /// That it was retired or put into storage, and not calibrated since.
    pub out_of_use: Option<Event>,
    /// Since when it is beyond its limits; where it is not, since when it drifts.
    pub since: Option<UtcMicros>,
    /// How it lies to its budget and where it goes, by its row of the table `head`.
    pub projection: BudgetProjection,
    pub attributes: GyroAttributes,
}

/// A rule that says that a gyro is beyond a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Violation {
    pub coefficient: Coefficient,
    pub rule: Rule,
    pub status: Status,
    /// The figure over its limit, where it is a measure.
    pub load: Option<f64>,
}

/// A gyro's alerts that fire.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Alerted {
    /// What they know that the verdicts on its newest record do not: that the methods disagree, or that a second record
    /// has confirmed that a requirement is not met.
    told: Vec<Violation>,
    firing: u32,
    severity: Option<Severity>,
    /// When the first that is beyond a specification began, and the first that drifts.
    since: [Option<UtcMicros>; 2],
    /// When the newest of both began.
    changed_at: Option<UtcMicros>,
}

impl Alerted {
    pub fn of<'a>(firing: impl Iterator<Item = &'a AlertRow>) -> Result<Self, StoreError> {
        let mut alerted = Self::default();
        // As if they were asked for rule by rule.
        let mut of_requirements = Vec::new();
        for row in firing {
            alerted.firing += 1;
            alerted.severity = alerted.severity.max(Some(row.alert.severity));
            alerted.learn_when(row);
            let told = match row.rule {
                Rule::Agreement => &mut alerted.told,
                Rule::Requirement => &mut of_requirements,
                _ => continue,
            };
            let finding = finding_of(row)?;
            let load = Some(finding.value.map_or(0.0, |value| value / finding.limit));
            let status = status_of(row, &finding);
            told.push(Violation { coefficient: row.coefficient, rule: row.rule, status, load });
        }
        alerted.told.append(&mut of_requirements);
        Ok(alerted)
    }

    fn learn_when(&mut self, row: &AlertRow) {
        // Being overdue is a matter of the calendar.
        if row.rule == Rule::Overdue {
            return;
        }
        let began = row.alert.since;
        let of_kind = &mut self.since[usize::from(row.rule.limit_kind() == LimitKind::Control)];
        *of_kind = Some(of_kind.map_or(began, |known| known.min(began)));
        self.changed_at = self.changed_at.max(Some(began));
    }

    fn since(&self) -> Option<UtcMicros> {
        self.since[0].or(self.since[1])
    }
}

/// What a gyro's standing follows from.
#[derive(Debug)]
pub(crate) struct Facts<'a> {
    pub number: u32,
    pub serial: Arc<str>,
    pub newest: Option<Figures>,
    /// On its newest calibration.
    pub verdicts: &'a [StoredVerdict],
    pub alerted: &'a Alerted,
    /// When it was retired or put into storage last, and which.
    pub out_of_use: Option<(UtcMicros, Event)>,
    /// By the verdicts on its newest calibration when they were decided.
    pub projection: BudgetProjection,
}

impl Facts<'_> {
    /// Out of use since its newest calibration.
    fn out_of_use(&self) -> Option<Event> {
        let since = self.out_of_use.filter(|(at, _)| self.newest.is_none_or(|figures| *at >= figures.at));
        since.map(|(_, event)| event)
    }

    pub fn standing(&self, limits: &Limits, now: UtcMicros) -> GyroStatus {
        let Self { verdicts, newest, .. } = *self;
        let told = self.alerted.told.as_slice();
        let out_of_use = self.out_of_use();
        let in_use = newest.filter(|_| out_of_use.is_none());
        let late = in_use.zip(limits.interval_days).map(|(figures, days)| overdue(figures.at, now, days));
        let overdue_days = late.filter(|verdict| verdict.state == State::Exceeded).and_then(|verdict| verdict.value);
        let of_newest = newest.map(|figures| worst(&figures, verdicts));
        // The alert of a rule that has been switched off since stands until the gyro's next item.
        let asked = |told: &&Violation| told.rule == Rule::Agreement && limits.agreement(told.coefficient).is_some();
        let disagreements: Vec<Violation> = told.iter().filter(asked).copied().collect();
        let of_methods = (!disagreements.is_empty()).then_some(State::Exceeded);
        let loads = verdicts.iter().filter_map(load).chain(disagreements.iter().filter_map(|found| found.load));
        let violations: Vec<Violation> = violations(verdicts, told).chain(disagreements.iter().copied()).collect();
        let worst_of = violations.iter().map(|violation| violation.status).chain(overdue_days.map(|_| Status::Overdue));
        GyroStatus {
            number: self.number,
            serial: self.serial.clone(),
            state: of_newest.max(of_methods),
            // Without a calibration that counts there are too few records to judge it by.
            status: worst_of.max().max(Some(status::of_gyro(verdicts))),
            drift: status::of_drift(verdicts),
            violations,
            load: loads.fold(0.0, f64::max),
            overdue_days,
            out_of_use,
            newest,
            since: self.alerted.since(),
            projection: self.projection,
            attributes: GyroAttributes::default(),
        }
    }

    /// As it stands whatever the time is, for lists; `imu` and `station` are the names of those of its newest
    /// calibration.
    pub fn head(&self, judging: &Judging, imu: &str, station: &str) -> HeadRow {
        let limits = judging.limits(imu, &self.serial);
        // Nothing is overdue at the instant of its calibration.
        let standing = self.standing(&limits, self.newest.map_or(UtcMicros(0), |figures| figures.at));
        let GyroStatus { number: gyro, serial, newest, state, status, load, out_of_use, .. } = standing;
        let in_use = newest.filter(|_| out_of_use.is_none());
        let overdue_at = in_use.zip(limits.interval_days).map(|(figures, days)| figures.at.plus_days(days.value));
        let ahead = [Coefficient::DI, Coefficient::DS].map(|coefficient| {
            let is_it = |verdict: &&StoredVerdict| (verdict.rule, verdict.coefficient) == (Rule::Trend, coefficient);
            self.verdicts.iter().find(is_it).and_then(|verdict| verdict.value)
        });
        HeadRow {
            gyro,
            // Small letters, a line each: what is searched for stands within one of them.
            sought: format!("{serial}\n{imu}\n{station}").to_lowercase(),
            serial,
            newest: newest.map(|figures| {
                let [d_i, d_s, _] = sample_of(&figures, judging.method).d;
                let Figures { at, record, imu, station, slot, .. } = figures;
                NewestRow { at, record, imu, station, slot, d: [d_i, d_s] }
            }),
            state,
            status,
            rank: rank(out_of_use.is_none(), status),
            load: load.min(f64::MAX),
            ahead,
            overdue_at,
            out_of_use,
            firing: self.alerted.firing,
            severity: self.alerted.severity,
            projection: self.projection,
            since: self.alerted.since(),
            changed_at: self.alerted.changed_at,
        }
    }
}

/// By how much gyros in use come before others.
pub(crate) const IN_USE: i64 = 10;

/// What comes first in lists has the greater one: what is in use, then the worst status.
pub(crate) fn rank(in_use: bool, status: Option<Status>) -> i64 {
    i64::from(in_use) * IN_USE + status.map_or(0, |status| status as i64 + 1)
}

/// What a [`rank`] was made of.
pub(crate) fn of_rank(rank: i64) -> (bool, Option<Status>) {
    let place = usize::try_from(rank % IN_USE - 1).ok();
    (rank >= IN_USE, place.and_then(|place| Status::ALL.get(place)).copied())
}

/// Of the rules that could judge; of the drift none may have, however well E and G keep to their requirements.
fn worst(figures: &Figures, verdicts: &[StoredVerdict]) -> State {
    let of_drift = figures.states.worst().unwrap_or(State::Indeterminate);
    let judged = verdicts.iter().filter(|verdict| verdict.value.is_some());
    judged.map(|verdict| verdict.state).fold(of_drift, State::max)
}

pub(super) fn violations(verdicts: &[StoredVerdict], told: &[Violation]) -> impl Iterator<Item = Violation> {
    let beyond = verdicts.iter().filter(|verdict| verdict.state == State::Exceeded);
    beyond.map(|verdict| {
        let StoredVerdict { coefficient, rule, .. } = *verdict;
        let same = told.iter().find(|told| (told.coefficient, told.rule) == (coefficient, rule));
        let status = same.map_or(verdict.status(), |told| told.status.max(verdict.status()));
        Violation { coefficient, rule, status, load: load(verdict) }
    })
}

/// How much of its limit a figure takes up. E and G against their requirements lie between two limits: that is no
/// measure.
fn load(verdict: &StoredVerdict) -> Option<f64> {
    let of_history = verdict.rule != Rule::Requirement && verdict.limit > 0.0;
    verdict.value.filter(|_| of_history).map(|value| value / verdict.limit)
}

/// What is stored of some gyros that their standing follows from, besides their newest figures.
#[derive(Debug)]
pub(crate) struct StoredFacts {
    sheets: HashMap<Id, RecordVerdicts>,
    alerted: HashMap<u32, Alerted>,
    out_of_use: HashMap<u32, (UtcMicros, Event)>,
    projections: HashMap<u32, BudgetProjection>,
}

impl StoredFacts {
    /// Of gyros with these newest calibrations, in three queries for all; their projections are known elsewhere.
    pub async fn of(
        store: &Store,
        newest: &[(u32, Option<Figures>)],
        projections: HashMap<u32, BudgetProjection>,
    ) -> Result<Self, StoreError> {
        let gyros: Vec<u32> = newest.iter().map(|(gyro, _)| *gyro).collect();
        let records: HashSet<Id> = newest.iter().filter_map(|(_, figures)| Some(figures.as_ref()?.record)).collect();
        let sheets = store::record::record_verdicts(store, records.into_iter()).await?;
        let mut rows: HashMap<u32, Vec<AlertRow>> = HashMap::new();
        for row in store::alerts::firing(store, &gyros).await? {
            rows.entry(row.of.gyro().unwrap_or_default()).or_default().push(row);
        }
        let alerted = rows.iter().map(|(gyro, rows)| Ok((*gyro, Alerted::of(rows.iter())?)));
        let alerted = alerted.collect::<Result<_, StoreError>>()?;
        let out_of_use = store::event::out_of_use_of(store, &gyros).await?;
        Ok(Self { sheets, alerted, out_of_use, projections })
    }

    /// Of one gyro.
    pub fn facts(&self, number: u32, serial: Arc<str>, newest: Option<Figures>) -> Facts<'_> {
        static NONE: Alerted =
            Alerted { told: Vec::new(), firing: 0, severity: None, since: [None; 2], changed_at: None };
        Facts {
            number,
            serial,
            newest,
            verdicts: newest.and_then(|figures| self.sheets.get(&figures.record)).map_or(&[], |sheet| sheet.of(number)),
            alerted: self.alerted.get(&number).unwrap_or(&NONE),
            out_of_use: self.out_of_use.get(&number).copied(),
            projection: self.projections.get(&number).copied().unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl GyroStatus {
        /// A gyro in tolerance of which nothing but its projection is known.
        pub fn made_for_tests(number: u32, projection: BudgetProjection) -> Self {
            Self {
                number,
                serial: format!("GYRO-{number}").into(),
                newest: None,
                state: None,
                status: Some(Status::InTolerance),
                drift: [Status::InTolerance; 3],
                violations: Vec::new(),
                load: 0.0,
                overdue_days: None,
                out_of_use: None,
                since: None,
                projection,
                attributes: Default::default(),
            }
        }
    }

    #[test]
    fn a_rank_is_read_as_it_was_made_and_the_worst_in_use_has_the_greatest() {
        let all = || std::iter::once(None).chain(Status::ALL.into_iter().map(Some));
        let ranks: Vec<i64> = [false, true].into_iter().flat_map(|used| all().map(move |of| rank(used, of))).collect();
        assert!(ranks.is_sorted() && ranks.len() == 20, "{ranks:?}");
        for used in [false, true] {
            for status in all() {
                assert_eq!(of_rank(rank(used, status)), (used, status));
            }
        }
        assert_eq!((rank(true, Some(Status::Confirmed)), rank(false, Some(Status::InTolerance))), (19, 1));
    }
}
