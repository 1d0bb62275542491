//! The writer's part in alerts of stations, batches and IMUs: what the newest calibrations of the fleet say that their
//! gyros share.
//!
//! A file's writer asks with every group in which a gyro begins to exceed a limit, so that the group's other gyros are
//! told of as one; the clock asks at every tick. Among several servers only the clock does, which holds every cell.

use crate::core::alert_decision::{Alert, Status};
use crate::core::judge::{
    BudgetProjection, Coefficient, Finding, Group, GroupShiftCriteria, ImuShiftCriteria, LATELY, LimitKind, Measured,
    Need, NewestCalibration, Older, Severity, State, group_shift, imu_shift, in_common, shift_began,
};
use crate::pipeline::alerts::{AlertCache, NameLookup, Origin, SharedVerdict};
use crate::pipeline::ingest::judge::Judged;
use crate::pipeline::ingest::judge::gyro_window::{GyroWindow, sample_of};
use crate::pipeline::prelude::*;
use crate::store::{AlertOf, AlertRow, ExcessRow, HistoryRow};

/// Those that gyros may share, by column.
const COEFFICIENTS: [Coefficient; 2] = [Coefficient::DI, Coefficient::DS];

/// Gyros by which a shift is dated, the newest calibrated, and so many of the newest records of each.
const DATED_GYROS: usize = 200;
const DATED_RECORDS: usize = 64;

/// IMUs of one look of which an earlier calibration is judged, at most.
const BEGUN_BEFORE: usize = 32;

/// Of the alert of a gyro, what tells whether others exceed the limit too; none where none can by its rule.
fn excess(row: &AlertRow) -> Option<ExcessRow> {
    let AlertRow { coefficient, rule, alert: Alert { severity, since, .. }, inhibited_by, .. } = *row;
    let gyro = row.of.gyro().filter(|_| rule.can_be_shared())?;
    Some(ExcessRow { gyro, coefficient, rule, severity, since, inhibited_by })
}

/// Who only drifts keeps its budget.
fn exceeds(row: &&ExcessRow) -> bool {
    row.rule.limit_kind() == LimitKind::Specification
}

/// Beside what an IMU is judged: what its gyros exceed, and what they have moved by with others.
struct Evidence<'a> {
    exceeding: HashMap<(u32, Coefficient), Vec<&'a ExcessRow>>,
    shifts: Vec<Shift>,
}

impl<'a> Evidence<'a> {
    fn of(of_groups: &[SharedVerdict], exceed: &'a [ExcessRow]) -> Self {
        let mut exceeding: HashMap<_, Vec<&ExcessRow>> = HashMap::new();
        exceed.iter().for_each(|row| exceeding.entry((row.gyro, row.coefficient)).or_default().push(row));
        Self { exceeding, shifts: shifts(of_groups) }
    }
}

/// What gyros share, by station, by batch and by IMU.
pub(super) struct SharedShifts<'a> {
    pub store: &'a Store,
    pub config: &'a Config,
    pub alerts: &'a AlertCache,
    pub now: UtcMicros,
}

impl SharedShifts<'_> {
    /// What the gyros of a group share, where one of them begins to exceed a limit, or exceeds it more gravely, or an
    /// IMU of it may show that its station has shifted.
    pub async fn of_arrivals(&self, found: &Judged, changes: &Changes) -> Result<Vec<SharedVerdict>, StoreError> {
        let is_news = |newest: &HistoryRow, verdict: &Verdict| {
            let is_known = |row: &AlertRow| {
                (row.coefficient, row.rule) == (verdict.coefficient, verdict.rule)
                    && Some(row.alert.severity) >= verdict.severity()
            };
            verdict.severity().is_some()
                && verdict.rule.can_be_shared()
                && !self.alerts.firing(newest.gyro).any(is_known)
        };
        let verdicts = |newest: &HistoryRow| found.verdicts.get(&(newest.figures.record, newest.gyro));
        let has_news =
            |newest: &&HistoryRow| verdicts(newest).into_iter().flatten().any(|verdict| is_news(newest, verdict));
        let exceeding: Vec<&HistoryRow> = found.newest.iter().filter(has_news).collect();
        let mut stations = self.may_have_shifted(found);
        if exceeding.is_empty() && stations.is_empty() {
            return Ok(Vec::new());
        }
        stations.extend(exceeding.iter().map(|newest| newest.figures.station));
        let imus: BTreeSet<u32> = exceeding.iter().map(|newest| newest.figures.imu).collect();
        let mut exceed: Vec<ExcessRow> = Vec::new();
        for newest in &found.newest {
            let firing = || self.alerts.firing(newest.gyro);
            exceed.extend(firing().filter_map(excess));
            for verdict in verdicts(newest).into_iter().flatten().filter(|verdict| verdict.rule.can_be_shared()) {
                let is_its = |row: &&AlertRow| (row.coefficient, row.rule) == (verdict.coefficient, verdict.rule);
                let Verdict { coefficient, rule, .. } = *verdict;
                let known = firing().find(is_its);
                let in_order = found.in_order(newest.gyro).and_then(|fires| fires.get(&(coefficient, rule)));
                let began = || in_order.map_or(newest.figures.at, |left| left.since);
                let since = known.map_or_else(began, |row| row.alert.since);
                let (gyro, inhibited_by) = (newest.gyro, known.and_then(|row| row.inhibited_by));
                let of = |severity| ExcessRow { gyro, coefficient, rule, severity, since, inhibited_by };
                exceed.extend(verdict.severity().map(of));
            }
        }
        let gyros: Vec<u32> = found.newest.iter().map(|newest| newest.gyro).collect();
        let mut attributes = store::gyro_attribute::of(self.store, &gyros).await?;
        attributes.extend(changes.attributes.iter().map(|row| (row.gyro, row.attributes.clone())));
        let batches: HashMap<u32, Arc<str>> =
            attributes.into_iter().filter_map(|(gyro, of)| Some((gyro, of.batch?.into()))).collect();
        let of_exceeding: BTreeSet<Arc<str>> =
            exceeding.iter().filter_map(|newest| batches.get(&newest.gyro).cloned()).collect();
        // Whether a station has shifted its own newest calibrations tell; the fleet's are only asked whether it alone has.
        let mut near = Vec::new();
        for station in stations.iter().filter(|_| of_exceeding.is_empty()) {
            near.extend(self.calibrated(self.lately_from(), Some(*station)).await?);
        }
        let mut calibrated = self.with_group(near, found, changes, &batches);
        let mut judged = self.of_stations(&self.lately(&calibrated), &stations);
        if !of_exceeding.is_empty() || judged.iter().any(|one| one.verdict.state == State::Exceeded) {
            calibrated = self.with_group(self.calibrated(self.lately_from(), None).await?, found, changes, &batches);
            let lately = self.lately(&calibrated);
            judged = self.of_stations(&lately, &stations);
            judged.extend(self.of_batches(&lately, Some(&of_exceeding)));
        }
        // Of what is over the clock judges, which knows every gyro of an IMU.
        let of_imus = self.of_imus(&calibrated, &imus, &Evidence::of(&judged, &exceed));
        judged.extend(of_imus.into_iter().filter(|one| one.verdict.severity().is_some()));
        self.date(&mut judged, &calibrated, &changes.history).await?;
        Ok(judged)
    }

    /// Stations of which nothing is told and where an IMU of the group has stepped lately, by as much as a shift of theirs
    /// would make it. To ask wherever one lies off would read a station with every record of a fleet that drifts.
    fn may_have_shifted(&self, found: &Judged) -> BTreeSet<u32> {
        let recent = self.now.plus_days(-self.config.alerts.backfill_days);
        let mut steps: BTreeMap<[u32; 2], [Vec<f64>; 2]> = BTreeMap::new();
        for HistoryRow { gyro, figures } in found.newest.iter().filter(|newest| newest.figures.at >= recent) {
            let verdicts = found.verdicts.get(&(figures.record, *gyro)).into_iter().flatten();
            for verdict in verdicts.filter(|verdict| verdict.rule == Rule::Step) {
                let column = COEFFICIENTS.iter().position(|one| *one == verdict.coefficient);
                let Some((column, step)) = column.zip(verdict.value) else { continue };
                steps.entry([figures.station, figures.imu]).or_default()[column].push(step);
            }
        }
        let limits = self.config.judging.limits("", "");
        let has_moved = |station: u32, column: usize, steps: &[f64]| {
            let least = [&limits.d_i, &limits.d_s][column].of(Rule::StationShift);
            let moved = in_common(steps, 1, 0.0).zip(least).is_some_and(|(step, least)| step.value > least.value);
            moved && self.alerts.shared().since(AlertOf::Station(station), COEFFICIENTS[column]).is_none()
        };
        let moved = steps.iter().filter(|([station, _], steps)| (0..2).any(|k| has_moved(*station, k, &steps[k])));
        moved.map(|([station, _], _)| *station).collect()
    }

    /// Dates what is found of stations and batches of which nothing was told: since the first calibration that shows it,
    /// whenever it is looked at. `new`: what is not stored yet.
    async fn date(
        &self,
        found: &mut [SharedVerdict],
        newest: &[NewestCalibration],
        new: &[HistoryRow],
    ) -> Result<(), StoreError> {
        let newest: HashMap<u32, &NewestCalibration> = newest.iter().map(|one| (one.gyro, one)).collect();
        for SharedVerdict { of, verdict, gyros, .. } in found {
            let Finding::GroupShift { since, shift, .. } = &mut verdict.finding else { continue };
            let is_told = self.alerts.shared().since(*of, verdict.coefficient).is_some();
            if verdict.state != State::Exceeded || is_told {
                continue;
            }
            let Some(column) = COEFFICIENTS.iter().position(|one| *one == verdict.coefficient) else { continue };
            let counts = |one: &&&NewestCalibration| one.deviation[column].is_some();
            let mut its: Vec<&NewestCalibration> =
                gyros.iter().filter_map(|gyro| newest.get(gyro)).filter(counts).copied().collect();
            its.sort_by_key(|one| std::cmp::Reverse(one.at));
            its.truncate(DATED_GYROS);
            let numbers: Vec<u32> = its.iter().map(|one| one.gyro).collect();
            let stored = store::histories::newest_ever(self.store, &numbers, DATED_RECORDS).await?;
            let mut calibrated: Vec<(UtcMicros, u32, f64)> = Vec::new();
            for (one, mut rows) in its.iter().zip(stored) {
                rows.extend(new.iter().filter(|row| row.gyro == one.gyro).map(|row| row.figures));
                let value = |row: &Figures| sample_of(row, self.config.judging.method).d[column].value;
                let (Some(last), Some(now)) = (rows.iter().find(|row| row.at == one.at), one.deviation[column]) else {
                    continue;
                };
                let level = value(last) - now.value;
                // Another station says nothing of this one.
                let is_its = |row: &&Figures| of.station().is_none_or(|station| row.station == station);
                let of_it = rows.iter().filter(|row| row.at <= one.at).filter(is_its);
                calibrated.extend(of_it.map(|row| (row.at, row.imu, value(row) - level)));
            }
            let began = shift_began(calibrated, *shift);
            *since = began.map_or(*since, |began| began.min(*since));
        }
        Ok(())
    }

    /// Stored calibrations with those of a group in their place.
    fn with_group(
        &self,
        stored: Vec<NewestCalibration>,
        found: &Judged,
        changes: &Changes,
        batches: &HashMap<u32, Arc<str>>,
    ) -> Vec<NewestCalibration> {
        let mut newest: HashMap<u32, NewestCalibration> = stored.into_iter().map(|row| (row.gyro, row)).collect();
        let tables = self.store.names().read();
        let naming = NameLookup { tables: &tables, new: Some(changes) };
        for HistoryRow { gyro, figures } in &found.newest {
            let loads =
                changes.heads.projections.get(&(figures.record, *gyro)).map_or([None; 3], |projection| projection.load);
            let budgets = self.budgets(&naming.imu(figures.imu), &naming.gyro(*gyro));
            let deviation = [0, 1].map(|column| times(loads[column], budgets[column]));
            let batch = batches.get(gyro).cloned();
            let (imu, station, at) = (figures.imu, figures.station, figures.at);
            newest.insert(*gyro, NewestCalibration { gyro: *gyro, imu, station, at, deviation, batch });
        }
        newest.into_values().collect()
    }

    /// What the gyros of every station, batch and IMU have done lately, of those that have an alert, and of IMUs with a
    /// gyro that has one, whenever that was calibrated. `firing`: those of gyros that may be shared.
    pub async fn all(&self, firing: &[ExcessRow]) -> Result<Vec<SharedVerdict>, StoreError> {
        let newest = self.calibrated(Span::EVER.from, None).await?;
        let exceeding: BTreeSet<u32> = firing.iter().map(|row| row.gyro).collect();
        let recent = self.now.plus_days(-self.config.alerts.backfill_days);
        let told = || self.alerts.shared().firing().map(|row| row.of);
        let of_recent = newest.iter().filter(|one| one.at >= recent).map(|one| one.station);
        let stations = of_recent.chain(told().filter_map(AlertOf::station)).collect();
        let asked = newest.iter().filter(|one| one.at >= recent || exceeding.contains(&one.gyro));
        let imus = asked.map(|one| one.imu).chain(told().filter_map(AlertOf::imu)).collect();
        let lately = self.lately(&newest);
        let mut judged = self.of_stations(&lately, &stations);
        judged.extend(self.of_batches(&lately, None));
        let evidence = Evidence::of(&judged, firing);
        let of_imus = self.of_imus(&newest, &imus, &evidence);
        let begun = self.begun_before(&newest, &evidence).await?;
        judged.extend(begun.into_iter().chain(of_imus));
        self.date(&mut judged, &newest, &[]).await?;
        Ok(judged)
    }

    /// Those that tell what stations and batches do; where a shared alert fires, those since it does.
    fn lately(&self, newest: &[NewestCalibration]) -> Vec<NewestCalibration> {
        let from = self.lately_from();
        newest.iter().filter(|one| one.at >= from).cloned().collect()
    }

    fn lately_from(&self) -> UtcMicros {
        let began = self.alerts.shared().firing().map(|row| row.alert.since).min().unwrap_or(self.now);
        self.now.plus_days(-LATELY).min(began)
    }

    fn of_stations(&self, newest: &[NewestCalibration], stations: &BTreeSet<u32>) -> Vec<SharedVerdict> {
        let of = |station: &u32| self.of_group(newest, AlertOf::Station(*station), &Group::Station(*station));
        stations.iter().flat_map(of).collect()
    }

    /// Of these batches, or of all. A batch goes by one of its gyros, and by that for good once it has had an alert,
    /// whatever becomes of that gyro.
    fn of_batches(&self, newest: &[NewestCalibration], asked: Option<&BTreeSet<Arc<str>>>) -> Vec<SharedVerdict> {
        let mut batches = self.alerts.shared().batches();
        let mut taken: BTreeSet<u32> = batches.values().copied().collect();
        let mut gyros: Vec<(u32, &Arc<str>)> =
            newest.iter().filter_map(|one| Some((one.gyro, one.batch.as_ref()?))).collect();
        gyros.sort_unstable();
        for (gyro, batch) in gyros {
            if !batches.contains_key(&**batch) && taken.insert(gyro) {
                batches.insert(batch.to_string(), gyro);
            }
        }
        let is_asked = |batch: &String| asked.is_none_or(|asked| asked.contains(batch.as_str()));
        let of =
            |(batch, gyro): (String, u32)| self.of_group(newest, AlertOf::Batch(gyro), &Group::Batch(batch.into()));
        batches.into_iter().filter(|(batch, _)| is_asked(batch)).flat_map(of).collect()
    }

    fn of_group(&self, newest: &[NewestCalibration], of: AlertOf, group: &Group) -> Vec<SharedVerdict> {
        let (limits, budgets) = (self.config.judging.limits("", ""), self.budgets("", ""));
        let mut found = Vec::new();
        for (column, coefficient) in COEFFICIENTS.into_iter().enumerate() {
            let limit = [&limits.d_i, &limits.d_s][column].of(group.rule());
            let Some((limit, budget)) = limit.zip(budgets[column]) else { continue };
            let fires_since = self.alerts.shared().since(of, coefficient);
            let asked = GroupShiftCriteria { limit, budget, confidence: limits.confidence, fires_since };
            let verdict = group_shift(newest, group, column, &asked);
            let its = || newest.iter().filter(|one| group.holds(one));
            let (at, gyros) = (its().map(|one| one.at).max().unwrap_or(self.now), its().map(|one| one.gyro).collect());
            let batch = if let Group::Batch(batch) = group { Some(batch.clone()) } else { None };
            let origin = Origin { station: of.station(), batch, ..Origin::at(at) };
            found.push(SharedVerdict { of, verdict, origin, since: None, gyros });
        }
        found
    }

    /// What the gyros of IMUs have done beside what their stations and batches have.
    fn of_imus(
        &self,
        newest: &[NewestCalibration],
        imus: &BTreeSet<u32>,
        evidence: &Evidence<'_>,
    ) -> Vec<SharedVerdict> {
        let mut gyros: BTreeMap<u32, Vec<&NewestCalibration>> = imus.iter().map(|imu| (*imu, Vec::new())).collect();
        newest.iter().for_each(|one| gyros.get_mut(&one.imu).into_iter().for_each(|gyros| gyros.push(one)));
        let mut found = Vec::new();
        for (imu, gyros) in gyros {
            for (column, coefficient) in COEFFICIENTS.into_iter().enumerate() {
                let shared = self.alerts.shared();
                let told = shared.since(AlertOf::Imu(imu), coefficient);
                let judged = self.of_imu((imu, column), &gyros, told, evidence);
                // Nearly every IMU says nothing, and never has.
                let says = |one: &SharedVerdict| one.verdict.severity().is_some() || shared.knows(one.of, coefficient);
                found.extend(judged.filter(says));
            }
        }
        found
    }

    /// What the gyros of one IMU have done by these calibrations of theirs; `told`: since when, where that is known.
    fn of_imu(
        &self,
        (imu, column): (u32, usize),
        gyros: &[&NewestCalibration],
        told: Option<UtcMicros>,
        evidence: &Evidence<'_>,
    ) -> Option<SharedVerdict> {
        let coefficient = COEFFICIENTS[column];
        let limits = self.config.judging.limits(self.store.names().read().imus.text(imu), "");
        let limit = [&limits.d_i, &limits.d_s][column].of(Rule::ImuShift)?;
        let last = gyros.iter().max_by_key(|one| one.at);
        let (at, station) = last.map_or((self.now, None), |one| (one.at, Some(one.station)));
        let its = || gyros.iter().filter_map(|one| evidence.exceeding.get(&(one.gyro, coefficient))).flatten();
        let since = told.unwrap_or(at);
        let alert = self.shift_of((imu, column)).map(|row| row.id);
        // What is explained may be dated otherwise since: by a late record.
        let is_told_of =
            |one: &&ExcessRow| one.since == since || one.inhibited_by.is_some() && one.inhibited_by == alert;
        let shared = |one: &NewestCalibration| {
            let is_its = |(of, gyros, _): &&Shift| *of == coefficient && gyros.contains(&one.gyro);
            evidence.shifts.iter().filter(is_its).map(|(.., shift)| *shift).collect()
        };
        let asked = ImuShiftCriteria {
            limit,
            confidence: limits.confidence,
            shared: &shared,
            one_did_before: told.is_none() && its().copied().filter(exceeds).any(|one| one.since < at),
            confirmed: its().any(|one| is_told_of(one) && one.severity == Severity::Critical),
        };
        let verdict = imu_shift(gyros, column, &asked);
        let origin = Origin { imu: Some(imu), station, ..Origin::at(at) };
        Some(SharedVerdict { of: AlertOf::Imu(imu), verdict, origin, since: None, gyros: Vec::new() })
    }

    /// IMUs that were calibrated again before anybody looked, by the calibration with which all that exceed their budgets
    /// began to: where that shows that the IMU has shifted, and it is not back since, its alert begins with it. So does
    /// one that fires, where a late record has told that what it explains began at another time.
    async fn begun_before(
        &self,
        newest: &[NewestCalibration],
        evidence: &Evidence<'_>,
    ) -> Result<Vec<SharedVerdict>, StoreError> {
        // Of each gyro that exceeds its budget since when it does, by IMU.
        let mut began: BTreeMap<(u32, usize), BTreeSet<UtcMicros>> = BTreeMap::new();
        for one in newest {
            for (column, coefficient) in COEFFICIENTS.into_iter().enumerate() {
                let rows = evidence.exceeding.get(&(one.gyro, coefficient)).into_iter().flatten().copied();
                let since = rows.filter(exceeds).map(|row| row.since).min();
                since.map(|since| began.entry((one.imu, column)).or_default().insert(since));
            }
        }
        let at_once = |(of, all): ((u32, usize), BTreeSet<UtcMicros>)| {
            let since = all.first().copied().filter(|_| all.len() == 1)?;
            // Not one that was told of before, and is over.
            let is_new = self.shift_of(of).is_none_or(|row| row.alert.since != since);
            is_new.then_some((since, of))
        };
        let mut began: Vec<(UtcMicros, (u32, usize))> = began.into_iter().filter_map(at_once).collect();
        let imus: BTreeSet<u32> = began.iter().map(|(_, (imu, _))| *imu).collect();
        let mut gyros: HashMap<u32, Vec<&NewestCalibration>> = HashMap::new();
        let its = newest.iter().filter(|one| imus.contains(&one.imu));
        its.for_each(|one| gyros.entry(one.imu).or_default().push(one));
        began.retain(|(since, of)| {
            let its = &gyros[&of.0];
            let told = self.shift_of(*of).filter(|row| row.alert.status == Status::Firing);
            let explains = |row: &AlertRow| {
                let rows = its.iter().filter_map(|one| evidence.exceeding.get(&(one.gyro, row.coefficient))).flatten();
                rows.into_iter().any(|excess| excess.inhibited_by == Some(row.id))
            };
            let is_back = |one: SharedVerdict| one.verdict.value.is_none() || one.verdict.state == State::Within;
            let stays = || self.of_imu(*of, its, Some(*since), evidence).is_some_and(|one| !is_back(one));
            // What a station or batch does now says nothing of what it did then.
            let (coefficient, gyros) = (COEFFICIENTS[of.1], || its.iter().map(|one| one.gyro));
            let is_shared =
                evidence.shifts.iter().any(|(c, all, _)| *c == coefficient && gyros().any(|g| all.contains(&g)));
            !is_shared && told.is_none_or(explains) && its.iter().any(|one| one.at > *since) && stays()
        });
        began.sort_unstable_by_key(|(since, _)| std::cmp::Reverse(*since));
        if began.len() > BEGUN_BEFORE {
            // Others at each look: none is to wait behind those that are always judged the same.
            let looks = usize::try_from(self.now.0 / 60_000_000).unwrap_or(0);
            let length = began.len();
            began.rotate_left(looks.wrapping_mul(BEGUN_BEFORE) % length);
            began.truncate(BEGUN_BEFORE);
        }
        let mut found = Vec::new();
        for (since, of) in began {
            let then = self.calibrated_at(since, of.0, &gyros[&of.0]).await?;
            let judged = self.of_imu(of, &then.iter().collect::<Vec<_>>(), Some(since), evidence);
            let judged = judged.filter(|one| one.verdict.severity().is_some());
            found.extend(judged.map(|one| SharedVerdict { since: Some(since), ..one }));
        }
        Ok(found)
    }

    /// The alert that an IMU shifts, whether it fires or not.
    fn shift_of(&self, (imu, column): (u32, usize)) -> Option<&AlertRow> {
        self.alerts.shared().of_imu(imu, COEFFICIENTS[column])
    }

    /// How gyros of an IMU lay when that was calibrated at `at`, in the place of their newest calibrations.
    async fn calibrated_at(
        &self,
        at: UtcMicros,
        imu: u32,
        gyros: &[&NewestCalibration],
    ) -> Result<Vec<NewestCalibration>, StoreError> {
        let then: Vec<_> = gyros.iter().map(|one| (one.gyro, Span { from: at, to: at })).collect();
        let rows = store::histories::oldest(self.store, &then, 1).await?;
        let mut calibrated = Vec::with_capacity(gyros.len());
        for (one, figures) in gyros.iter().zip(rows.into_iter().map(|mut rows| rows.pop())) {
            let Some(figures) = figures.filter(|figures| figures.imu == imu) else { continue };
            let limits = {
                let tables = self.store.names().read();
                self.config.judging.limits(tables.imus.text(imu), tables.gyros.text(one.gyro))
            };
            let (need, method) = (Need::of(&limits), self.config.judging.method);
            let line = GyroWindow::load(self.store, one.gyro, at, need, method).await?;
            let load = BudgetProjection::of(&line.judge_newest(&limits, Older::NONE)).load;
            let budgets = limits.budgets();
            let deviation = [0, 1].map(|column| times(load[column], budgets[column]));
            calibrated.push(NewestCalibration { station: figures.station, at, deviation, ..(*one).clone() });
        }
        Ok(calibrated)
    }

    /// The newest calibrations of the fleet, or of one station, made no earlier than `from`.
    async fn calibrated(&self, from: UtcMicros, station: Option<u32>) -> Result<Vec<NewestCalibration>, StoreError> {
        let rows = store::head::calibrated_since(self.store, from, station).await?;
        // Without overrides all have the same.
        let of_all = self.config.judging.overrides.is_empty().then(|| self.budgets("", ""));
        let tables = self.store.names().read();
        let calibrated = rows.into_iter().map(|row| {
            let budgets =
                of_all.unwrap_or_else(|| self.budgets(tables.imus.text(row.imu), tables.gyros.text(row.gyro)));
            let deviation = [0, 1].map(|column| times(row.load[column], budgets[column]));
            let store::head::CalibratedRow { gyro, imu, station, at, batch, .. } = row;
            NewestCalibration { gyro, imu, station, at, deviation, batch }
        });
        Ok(calibrated.collect())
    }

    /// What loads are shares of, deg/(h g0).
    fn budgets(&self, imu: &str, serial: &str) -> [Option<f64>; 3] {
        self.config.judging.limits(imu, serial).budgets()
    }
}

/// What gyros share is looked at again after so many days, though nothing was written: an hour.
const LOOKED_AGAIN: f64 = 1.0 / 24.0;

/// A look at what gyros share, beside the writer: of a large fleet it takes a second, for which nobody is to wait.
pub(super) struct SharedLook {
    pub store: Store,
    pub config: Arc<Config>,
    pub now: UtcMicros,
    /// As the look before it found.
    pub nothing: Option<NothingShared>,
}

/// Since when nothing new is found that gyros share, and by which heads.
pub(super) type NothingShared = (UtcMicros, [i64; 2]);

impl SharedLook {
    /// None where an alert has to follow what it has found. Where nothing is written of gyros, time alone changes what
    /// they share, slowly: by what is no longer recent.
    pub async fn nothing(self) -> Result<Option<NothingShared>, StoreError> {
        let Self { store, config, now, nothing } = self;
        let version = store::head::version(&store).await?;
        let is_known = |(since, of): &NothingShared| *of == version && now.days_since(*since).abs() < LOOKED_AGAIN;
        if let Some(nothing) = nothing.filter(is_known) {
            return Ok(Some(nothing));
        }
        let mut alerts = AlertCache::new(config.alerts.policy(), config.judging.confidence);
        let (found, rows) = shared_and_explicable(&store, &config, &mut alerts, now).await?;
        let tables = store.names().read();
        let naming = NameLookup { tables: &tables, new: None };
        let shared = alerts.shared();
        let is_anything = shared.not_judged(&found).next().is_some()
            || found.iter().any(|one| shared.is_moved_by(one, &naming))
            || !shared.explained_anew(&rows, &naming).is_empty();
        Ok((!is_anything).then_some((now, version)))
    }
}

/// What is shared, and the alerts of gyros that it explains, or did.
pub(super) async fn shared_and_explicable(
    store: &Store,
    config: &Config,
    alerts: &mut AlertCache,
    now: UtcMicros,
) -> Result<(Vec<SharedVerdict>, Vec<AlertRow>), StoreError> {
    alerts.recall(store, [], now).await?;
    let excesses = store::alerts::excesses(store).await?;
    let found = SharedShifts { store, config, alerts, now }.all(&excesses).await?;
    alerts.learn_mates(&found);
    let (subjects, gyros) = alerts.shared().that_explain(&found);
    let rows = store::alerts::explicable(store, &subjects, &gyros).await?;
    Ok((found, rows))
}

/// What the gyros of a station or batch have moved by together.
type Shift = (Coefficient, BTreeSet<u32>, Measured);

fn shifts(found: &[SharedVerdict]) -> Vec<Shift> {
    let of = |one: &SharedVerdict| {
        Some((one.verdict.coefficient, one.gyros.iter().copied().collect(), one.verdict.group_shift()?))
    };
    found.iter().filter_map(of).collect()
}

fn times(load: Option<Measured>, budget: Option<f64>) -> Option<Measured> {
    let (load, budget) = load.zip(budget)?;
    Some(Measured { value: load.value * budget, sd: load.sd.map(|sd| sd * budget) })
}
