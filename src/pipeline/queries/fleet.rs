//! The fleet at a glance: every gyro's newest figures, how it stands, and its last few values.

use std::cmp::Reverse;
use std::sync::{Mutex, PoisonError};

use futures::{StreamExt, TryStreamExt, stream};
use tokio::time::Instant;

use super::entries::fleet_histories;
use super::gyro_status::{StoredFacts, of_rank, rank};
use super::record::Records;
use crate::core::changes::{self, FleetStations};
use crate::core::first_of::{DueImu, FirstOf};
use crate::core::fleet_order::FleetOrder;
use crate::core::judge::{
    BASELINE_RECORDS, FleetNoise, Limits, Mark, Measured, Sample, Series, State, Status, baseline_since, fit_fleet,
    stated_level,
};
use crate::core::kind::RecordEntry;
use crate::core::mounting::Slot;
use crate::pipeline::GyroStatus;
use crate::pipeline::cached_answer::{CachedAnswer, found_until};
use crate::pipeline::ingest::judge::gyro_window::{GyroWindow, distinct, marks_of, sample_of};
use crate::pipeline::prelude::*;
use crate::store::head::{CalibratedRow, HeadFilter, HeadStatusFilter, Ranks, SerialSearch, StationTally, Tally};
use crate::store::{Stretch, Table};
use crate::wire::answer::VerdictBody;

/// IMUs of a list whose gyros are read at once.
const IMUS_AT_ONCE: usize = 4;

/// The gyros whose newest calibration was made in one IMU.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Seats {
    /// In it, in the order of their slots: nothing has been calibrated in their slot since.
    pub now: Vec<GyroStatus>,
    /// Another gyro has been calibrated in their slot since; the last to leave first.
    pub before: Vec<GyroStatus>,
    /// Whether a calibration that counts separated any gyro in it, wherever that gyro is now.
    pub used: bool,
}

impl Seats {
    /// The gyro that has been calibrated in the slot of another since.
    pub fn successor(&self, number: u32) -> Option<Arc<str>> {
        let left = self.before.iter().find(|standing| standing.number == number)?.newest?.slot;
        let holds = |standing: &&GyroStatus| standing.newest.is_some_and(|newest| newest.slot == left);
        self.now.iter().find(holds).map(|standing| standing.serial.clone())
    }
}

/// An IMU among others.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedImu {
    pub number: u32,
    pub name: String,
    pub seats: Seats,
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
    pub(super) known: Arc<KnownOfFleet>,
}

/// What is found by a look at many gyros.
#[derive(Debug, Default)]
pub(super) struct KnownOfFleet {
    counts: CachedAnswer<(Vec<Tally>, Vec<StationTally>)>,
    imus: CachedAnswer<usize>,
    pub dues: CachedAnswer<[FirstOf<DueImu>; 2]>,
    /// Since an instant.
    pub calibrated: CachedAnswer<Vec<CalibratedRow>>,
    /// What the stations do.
    stations: CachedAnswer<Option<Arc<FleetStations>>>,
    /// As it was found last, and how long that took.
    last_stations: Mutex<(Option<Arc<FleetStations>>, Duration)>,
    totals: tokio::sync::Mutex<Option<KnownTotals>>,
}

/// All that stations have calibrated, when that was counted, and how long it took.
#[derive(Debug)]
struct KnownTotals {
    of: Arc<HashMap<u32, store::StationTotals>>,
    at: Instant,
    took: Duration,
}

impl KnownTotals {
    /// Counting takes no more than a twentieth of the time.
    fn is_recent(&self) -> bool {
        self.took > QUICK && self.at.elapsed() < 20 * self.took
    }
}

/// Bytes of a text that is sought, at most.
const LONGEST_SOUGHT: usize = 1_000;
/// What takes no longer is counted again whenever it is asked for.
const QUICK: Duration = Duration::from_millis(200);

/// Gyros whose whole histories are read at once.
const HISTORIES_AT_ONCE: usize = 64;

/// What a list of the fleet is narrowed down to, and its order.
#[derive(Debug, Clone, Copy, Default)]
pub struct FleetFilter<'a> {
    /// Part of a serial, IMU or station, in whatever letters; empty where all are wanted.
    pub text: &'a str,
    /// Name of the station of the newest calibration; empty as above.
    pub station: &'a str,
    /// Name of a station that has ever calibrated it.
    pub ever: &'a str,
    /// Name of the IMU of the newest calibration.
    pub imu: &'a str,
    /// A rule of which an alert is not resolved.
    pub rule: Option<Rule>,
    /// Calibrated no earlier than this.
    pub calibrated_since: Option<UtcMicros>,
    /// Something began to be worse, or it became overdue, no earlier than this.
    pub changed_since: Option<UtcMicros>,
    /// Batch of production; empty where all are wanted.
    pub batch: &'a str,
    /// Any of these; none where all are wanted. Who wants `overdue` wants those as well whose status is worse.
    pub statuses: Option<&'a [Status]>,
    /// None: the worst status first.
    pub order: Option<FleetOrder>,
}

/// IMUs with their gyros, the worst first.
#[derive(Debug, Clone, Default)]
pub struct WallPage {
    /// Each with the gyros that were calibrated in it last, by slot.
    pub imus: Vec<(String, Vec<GyroStatus>)>,
    /// IMUs that the filter finds.
    pub found: usize,
    /// The page, counted from 0: that which was asked for, or the last.
    pub number: usize,
    pub last: usize,
}

#[derive(Debug, Clone, Default)]
pub struct FleetPage {
    /// Gyros of each status, by its place, and of any, among those that the other filters find.
    pub of_status: [usize; Status::ALL.len()],
    pub of_any: usize,
    /// Gyros of the whole fleet.
    pub total: usize,
    /// By the station that calibrated them last.
    pub of_station: BTreeMap<String, StationGyros>,
    /// Gyros that the filter finds.
    pub found: usize,
    /// The page, counted from 0: that which was asked for, or the last.
    pub number: usize,
    pub last: usize,
    /// What comes first: what is in use, by its status, then what is overdue, then by how near the nearest limit is.
    pub gyros: Vec<GyroStatus>,
}

/// Of the gyros that a station calibrated last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StationGyros {
    /// What was not calibrated in its interval.
    pub overdue: usize,
    pub last_calibrated: UtcMicros,
}

/// Beyond a specification limit.
pub const BEYOND: [Status; 3] = [Status::Confirmed, Status::OutOfTolerance, Status::Unconfirmed];

/// What a list by serial is narrowed down to.
#[derive(Debug, Clone, Copy, Default)]
pub struct StatusFilter {
    /// `overdue` finds those as well whose status is worse.
    pub status: Option<Status>,
    pub state: Option<State>,
}

impl Fleet {
    pub async fn page(&self, filter: &FleetFilter<'_>, number: usize, rows: usize) -> Result<FleetPage, StoreError> {
        let now = self.clock.now();
        let counted = self.counted(now).await?;
        let Some(narrowed) = self.narrowed(filter, now).await? else { return Ok(self.counts(&[], &counted)) };
        let of_filter = match narrowed.is_whole() {
            true => counted.0.clone(),
            false => store::head::tallies(&self.store, &narrowed).await?,
        };
        let mut page = self.counts(&of_filter, &counted);
        let size = |ranks: &Ranks| -> usize {
            of_filter.iter().filter(|tally| is_of(tally, ranks)).map(|tally| tally.gyros).sum()
        };
        let wanted = in_order().into_iter().filter(|ranks| is_wanted(ranks, filter.statuses));
        let sizes: Vec<(Ranks, usize)> = wanted.map(|ranks| (ranks, size(&ranks))).collect();
        page.found = sizes.iter().map(|(_, size)| size).sum();
        page.last = page.found.saturating_sub(1) / rows;
        page.number = number.min(page.last);
        let (mut skip, mut gyros) = (page.number * rows, Vec::with_capacity(rows));
        if let Some(order) = filter.order.filter(|_| page.found > 0) {
            let ranks = ranks_of(filter.statuses);
            gyros = store::head::in_order(&self.store, order, ranks.as_deref(), &narrowed, [skip, rows]).await?;
        } else {
            for (ranks, size) in sizes {
                if skip < size && gyros.len() < rows {
                    let part = [skip, rows - gyros.len()];
                    gyros.extend(store::head::of_ranks(&self.store, ranks, &narrowed, part).await?);
                }
                skip = skip.saturating_sub(size);
            }
        }
        page.gyros = self.standings_of(&gyros).await?;
        Ok(page)
    }

    /// IMUs with the gyros in them, the worst first.
    pub async fn wall(&self, filter: &FleetFilter<'_>, number: usize, imus: usize) -> Result<WallPage, StoreError> {
        let Some(narrowed) = self.narrowed(filter, self.clock.now()).await? else { return Ok(WallPage::default()) };
        let ranks = ranks_of(filter.statuses);
        let part = async |number: usize| {
            let overdue = rank(true, Some(Status::Overdue));
            let part = [number.saturating_mul(imus), imus];
            store::head::imus(&self.store, ranks.as_deref(), &narrowed, overdue, part).await
        };
        let count = store::head::imus_found(&self.store, ranks.as_deref(), &narrowed);
        let found = match ranks.is_none() && narrowed.is_whole() {
            true => {
                let count = async { Ok::<_, StoreError>((count.await?, Span::EVER.to)) };
                *self.known.imus.at(store::head::version(&self.store), Span::EVER.from, count).await?
            }
            false => count.await?,
        };
        let last = found.saturating_sub(1) / imus;
        let shown = part(number.min(last)).await?;
        let gyros = store::head::of_imus(&self.store, &shown).await?;
        let mut of_imu: HashMap<u32, BTreeMap<Slot, GyroStatus>> = HashMap::new();
        for standing in self.standings_of(&gyros).await? {
            let Some(newest) = standing.newest else { continue };
            let in_slot = of_imu.entry(newest.imu).or_default();
            let known = in_slot.get(&newest.slot).and_then(|known| known.newest);
            if known.is_none_or(|known| known.at < newest.at) {
                in_slot.insert(newest.slot, standing);
            }
        }
        let tables = self.store.names().read();
        let named = shown.into_iter().filter_map(|imu| {
            let gyros = of_imu.remove(&imu)?.into_values().collect();
            Some((tables.imus.name(imu)?.to_string(), gyros))
        });
        Ok(WallPage { imus: named.collect(), found, number: number.min(last), last })
    }

    /// The gyros of some ranks, the worst first, as many as `most`.
    pub async fn worst_of(&self, statuses: &[Status], most: usize) -> Result<Vec<GyroStatus>, StoreError> {
        let (whole, mut gyros) = (HeadFilter { now: self.clock.now(), ..HeadFilter::default() }, Vec::new());
        for ranks in in_order().into_iter().filter(|ranks| is_wanted(ranks, Some(statuses))) {
            let part = [0, most - gyros.len()];
            gyros.extend(store::head::of_ranks(&self.store, ranks, &whole, part).await?);
            if gyros.len() >= most {
                break;
            }
        }
        self.standings_of(&gyros).await
    }

    /// None where nothing can be found, for a name is unknown.
    async fn narrowed(&self, filter: &FleetFilter<'_>, now: UtcMicros) -> Result<Option<HeadFilter>, StoreError> {
        let Some(mut narrowed) = self.named(filter, now) else { return Ok(None) };
        if narrowed.sought.is_some()
            && let Some(found) = store::head::search(&self.store, &narrowed).await?
        {
            narrowed.sought = Some(found);
        }
        Ok(Some(narrowed))
    }

    fn named(&self, filter: &FleetFilter<'_>, now: UtcMicros) -> Option<HeadFilter> {
        let tables = self.store.names().read();
        let number = |name: &str, of: &Table| match name {
            "" => Some(None),
            name => of.number(name).map(Some),
        };
        let text = filter.text.trim().to_lowercase();
        // No name holds these, and not every database takes them as a pattern.
        if text.len() > LONGEST_SOUGHT || text.contains('\0') {
            return None;
        }
        Some(HeadFilter {
            now,
            sought: (!text.is_empty()).then(|| SerialSearch::text(&text)),
            station: number(filter.station, &tables.stations)?,
            ever: number(filter.ever, &tables.stations)?,
            imu: number(filter.imu, &tables.imus)?,
            rule: filter.rule,
            calibrated_since: filter.calibrated_since,
            changed_since: filter.changed_since,
            batch: Some(filter.batch.to_owned()).filter(|batch| !batch.is_empty()),
        })
    }

    /// How many gyros have each status, and are overdue, and when each station calibrated last; no gyro by itself.
    pub async fn totals(&self) -> Result<FleetPage, StoreError> {
        let counted = self.counted(self.clock.now()).await?;
        Ok(self.counts(&counted.0, &counted))
    }

    async fn counted(&self, now: UtcMicros) -> Result<Arc<(Vec<Tally>, Vec<StationTally>)>, StoreError> {
        let count = async {
            let counts = store::head::counts(&self.store, now).await?;
            Ok::<_, StoreError>((counts, store::head::next_overdue(&self.store, now).await?))
        };
        self.known.counts.at(store::head::version(&self.store), now, count).await
    }

    fn counts(&self, found: &[Tally], (all, of_stations): &(Vec<Tally>, Vec<StationTally>)) -> FleetPage {
        let mut page = FleetPage { total: all.iter().map(|tally| tally.gyros).sum(), ..FleetPage::default() };
        for tally in found {
            page.of_any += tally.gyros;
            let (status, overdue) = (status_of(tally), tally.is_overdue.then_some(Status::Overdue));
            for status in status.into_iter().chain(overdue.filter(|_| status != overdue)) {
                page.of_status[status as usize] += tally.gyros;
            }
        }
        let tables = self.store.names().read();
        for tally in of_stations {
            let station = tally.station.and_then(|station| tables.stations.name(station));
            let Some((station, last_calibrated)) = station.zip(tally.last_calibrated) else { continue };
            let none = StationGyros { overdue: 0, last_calibrated };
            let of_station = page.of_station.entry(station.to_string()).or_insert(none);
            of_station.overdue += tally.overdue;
            of_station.last_calibrated = of_station.last_calibrated.max(last_calibrated);
        }
        page
    }

    /// Gyros in the order of the filter, by serial where it says none, after gyro number `after` (0: all), as many as
    /// `limit`.
    pub async fn listed(
        &self,
        after: u32,
        limit: u32,
        filter: StatusFilter,
        of_fleet: &FleetFilter<'_>,
    ) -> Result<Vec<GyroStatus>, StoreError> {
        let Some(narrowed) = self.narrowed(of_fleet, self.clock.now()).await? else { return Ok(Vec::new()) };
        let standings = HeadStatusFilter {
            rank: filter.status.filter(|status| *status != Status::Overdue).map(|status| rank(false, Some(status))),
            // Time makes worse only what is better than overdue.
            is_overdue: filter.status.filter(|status| *status <= Status::Overdue).map(|of| of == Status::Overdue),
            state: filter.state,
        };
        let order = of_fleet.order.unwrap_or(FleetOrder::Serial);
        self.standings_of(&store::head::listed(&self.store, after, order, standings, &narrowed, limit).await?).await
    }

    /// How these gyros stand, in their order.
    pub async fn standings_of(&self, gyros: &[u32]) -> Result<Vec<GyroStatus>, StoreError> {
        self.standings(store::histories::last(&self.store, gyros).await?).await
    }

    /// Gyros that each station calibrated last and that are overdue.
    pub async fn overdue_of_stations(&self) -> Result<BTreeMap<String, usize>, StoreError> {
        let of_station = self.totals().await?.of_station.into_iter();
        Ok(of_station.map(|(station, gyros)| (station, gyros.overdue)).collect())
    }

    /// What every station does to the gyros that it measured lately; none without records. Computes for a second of
    /// many gyros, on a thread for that: once, until something is written of a gyro.
    pub async fn station_figures(&self) -> Result<Option<Arc<FleetStations>>, StoreError> {
        let version = store::head::version(&self.store);
        let found = self.known.stations.at(version, Span::EVER.from, self.find_stations()).await?;
        Ok((*found).clone())
    }

    async fn find_stations(&self) -> Result<(Option<Arc<FleetStations>>, UtcMicros), StoreError> {
        let began = Instant::now();
        let histories = fleet_histories(&self.store, self.config.judging.method).await?;
        let failed = "the stations could not be compared".to_owned();
        let mut figures = computed(failed, move || changes::stations(&histories)).await?;
        if let Some(figures) = &mut figures {
            self.count_all(figures).await?;
        }
        let figures = figures.map(Arc::new);
        *self.last_stations() = (figures.clone(), began.elapsed());
        Ok((figures, Span::EVER.to))
    }

    /// The same; where that takes longer than `patience`, as they were found last: none before they first were. Who
    /// would wait in vain, as the last one did, does not wait.
    pub async fn station_figures_within(&self, patience: Duration) -> Result<Option<Arc<FleetStations>>, StoreError> {
        if !self.known.stations.is_computing() {
            let (fleet, took) = (self.clone(), self.last_stations().1);
            let patience = if took > patience { Duration::ZERO } else { patience };
            let found = found_until(Instant::now() + patience, async move { fleet.station_figures().await });
            if let Some(found) = found.await {
                return found;
            }
        }
        Ok(self.last_stations().0.clone())
    }

    fn last_stations(&self) -> std::sync::MutexGuard<'_, (Option<Arc<FleetStations>>, Duration)> {
        self.known.last_stations.lock().unwrap_or_else(PoisonError::into_inner)
    }

    async fn station_totals(&self) -> Result<Arc<HashMap<u32, store::StationTotals>>, StoreError> {
        let mut known = self.known.totals.lock().await;
        if let Some(known) = known.as_ref().filter(|known| known.is_recent()) {
            return Ok(known.of.clone());
        }
        let began = Instant::now();
        let of = Arc::new(store::record::of_stations(&self.store).await?);
        *known = Some(KnownTotals { of: of.clone(), at: Instant::now(), took: began.elapsed() });
        Ok(of)
    }

    /// What stations have calibrated is all of it, and not only what they are compared by.
    async fn count_all(&self, figures: &mut FleetStations) -> Result<(), StoreError> {
        let totals = self.station_totals().await?;
        let tables = self.store.names().read();
        for station in &mut figures.stations {
            let number = tables.stations.number(&station.name);
            if let Some(all) = number.and_then(|number| totals.get(&number)) {
                let store::StationTotals { records, gyros, imus, first, last } = *all;
                (station.records, station.gyros, station.imus) = (records, gyros, imus);
                (station.first, station.last) = (first, last);
            }
        }
        Ok(())
    }

    /// IMUs by name with their gyros, after IMU number `after` (0: all), as many as `limit`.
    pub async fn imus(&self, after: u32, limit: u32) -> Result<Vec<ListedImu>, StoreError> {
        let imus = store::head::imus_after(&self.store, after, limit).await?;
        let listed =
            |(number, name)| async move { Ok(ListedImu { number, name, seats: self.seated_in(number).await? }) };
        stream::iter(imus).map(listed).buffered(IMUS_AT_ONCE).try_collect().await
    }

    /// The gyros whose newest calibration was made in this IMU: a slot holds one of them.
    pub async fn seated_in(&self, imu: u32) -> Result<Seats, StoreError> {
        let gyros = store::head::of_imus(&self.store, &[imu]).await?;
        let mut newest = store::histories::last(&self.store, &gyros).await?;
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
    async fn rows_of(&self, heads: &[RecordEntry]) -> Result<Vec<Figures>, StoreError> {
        let sheets = store::record::record_verdicts(&self.store, heads.iter().map(|head| head.id)).await?;
        let of = |head: &RecordEntry| {
            let then = Span { from: head.calibrated_at, to: head.calibrated_at };
            let gyros = sheets.get(&head.id).map_or(&[][..], |sheet| &sheet.0);
            gyros.iter().map(move |(gyro, _)| (*gyro, then)).collect::<Vec<Stretch>>()
        };
        let stretches: Vec<Stretch> = heads.iter().flat_map(of).collect();
        Ok(store::histories::oldest(&self.store, &stretches, 1).await?.concat())
    }

    /// How gyros stand with these newest calibrations.
    pub async fn standings(&self, newest: Vec<(u32, Option<Figures>)>) -> Result<Vec<GyroStatus>, StoreError> {
        let gyros: Vec<u32> = newest.iter().map(|(gyro, _)| *gyro).collect();
        let heads = store::head::of_gyros(&self.store, &gyros).await?;
        let projections = heads.into_iter().map(|row| (row.gyro, row.projection)).collect();
        let stored = StoredFacts::of(&self.store, &newest, projections).await?;
        let mut attributes = store::gyro_attribute::of(&self.store, &gyros).await?;
        let (tables, now) = (self.store.names().read(), self.clock.now());
        let mut standing = |(number, newest): (u32, Option<Figures>)| {
            let serial = Arc::from(tables.gyros.name(number)?);
            let imu = newest.map_or("", |figures| tables.imus.text(figures.imu));
            let limits = self.config.judging.limits(imu, &serial);
            let attributes = attributes.remove(&number).unwrap_or_default();
            Some(GyroStatus { attributes, ..stored.facts(number, serial, newest).standing(&limits, now) })
        };
        Ok(newest.into_iter().filter_map(&mut standing).collect())
    }

    /// How one gyro stands, and the verdicts on its newest record in words; none where there is no such gyro.
    pub async fn standing_in_words(&self, number: u32) -> Result<Option<(GyroStatus, Vec<VerdictBody>)>, StoreError> {
        let newest = store::history::newest(&self.store, number, Span::EVER, 1).await?.pop();
        let stored = match &newest {
            Some(figures) => self.records.reread(figures.record).await?,
            None => None,
        };
        let said = match &stored {
            Some(stored) => self.records.verdicts_in_words(&stored.row, &stored.calibration).await?.0,
            None => Vec::new(),
        };
        let Some(standing) = self.standings(vec![(number, newest)]).await?.pop() else { return Ok(None) };
        let said = said.into_iter().filter(|verdict| *verdict.serial == *standing.serial).collect();
        Ok(Some((standing, said)))
    }

    /// The last `count` values of each of these gyros, in three queries however many they are.
    pub async fn recent_values(&self, of: &[&GyroStatus], count: usize) -> Result<Vec<RecentValues>, StoreError> {
        let gyros: Vec<u32> = of.iter().map(|standing| standing.number).collect();
        let marks = marks_of(&self.store, &gyros).await?;
        let marks: Vec<&[Mark]> = gyros.iter().map(|gyro| marks.get(gyro).map_or(&[][..], Vec::as_slice)).collect();
        let rows = store::histories::newest_ever(&self.store, &gyros, count).await?;
        let newest_baseline = |k: usize| {
            let last = last_of(&rows[k]);
            (gyros[k], Span { from: baseline_since(marks[k], last).unwrap_or(Span::EVER.from), to: last })
        };
        let of_baselines: Vec<Stretch> = (0..of.len()).map(newest_baseline).collect();
        // Some of the first may repeat one another.
        let baselines = store::histories::oldest(&self.store, &of_baselines, 4 * BASELINE_RECORDS).await?;
        Ok((0..of.len()).map(|k| self.recent(of[k], marks[k], &rows[k], &baselines[k])).collect())
    }

    /// The noise constants of the whole fleet: correlation and walk, fitted to every gyro's stored history. Reads all
    /// of it.
    pub async fn noise(&self) -> Result<FleetNoise, StoreError> {
        let gyros: Vec<u32> = self.store.names().read().gyros.numbers();
        let method = self.config.judging.method;
        let mut all: Vec<Series> = Vec::with_capacity(gyros.len());
        for some in gyros.chunks(HISTORIES_AT_ONCE) {
            let mut marks = marks_of(&self.store, some).await?;
            let ever: Vec<Stretch> = some.iter().map(|gyro| (*gyro, Span::EVER)).collect();
            for (gyro, rows) in some.iter().zip(store::histories::oldest(&self.store, &ever, i32::MAX as usize).await?)
            {
                let samples = rows.iter().map(|figures| sample_of(figures, method)).collect();
                all.push(GyroWindow::of_all(samples, marks.remove(gyro).unwrap_or_default()).samples().clone());
            }
        }
        Ok(fit_fleet(&all))
    }

    fn recent(&self, standing: &GyroStatus, marks: &[Mark], rows: &[Figures], baseline: &[Figures]) -> RecentValues {
        let method = self.config.judging.method;
        let samples = |rows: &[Figures]| -> Vec<Sample> { rows.iter().map(|row| sample_of(row, method)).collect() };
        let last = last_of(rows);
        let imu = rows.last().and_then(|figures| self.store.names().read().imus.name(figures.imu).map(Arc::from));
        let limits = self.config.judging.limits(imu.as_deref().unwrap_or_default(), &standing.serial);
        let baseline = distinct(samples(baseline));
        let [d_i, d_s, _] = limits.budgets();
        RecentValues {
            samples: samples(rows),
            level: [0, 1].map(|column| level(&baseline, column, stated(marks, last, &limits, column))),
            budget: [d_i, d_s],
        }
    }
}

/// What is overdue, and better besides, is that above all.
fn status_of(tally: &Tally) -> Option<Status> {
    of_rank(tally.rank).1.max(tally.is_overdue.then_some(Status::Overdue))
}

/// The fleet from its first gyro to its last. What is not in use is never overdue.
fn in_order() -> Vec<Ranks> {
    let one = |rank, is_overdue| Ranks { lowest: rank, highest: rank, is_overdue };
    let overdue = rank(true, Some(Status::Overdue));
    let worse = (overdue + 1..=rank(true, Status::ALL.last().copied())).rev();
    let mut all: Vec<Ranks> = worse.flat_map(|rank| [one(rank, true), one(rank, false)]).collect();
    all.push(Ranks { lowest: rank(true, None), highest: overdue, is_overdue: true });
    all.extend((0..overdue).rev().map(|rank| one(rank, false)));
    all
}

fn is_of(tally: &Tally, ranks: &Ranks) -> bool {
    (ranks.lowest..=ranks.highest).contains(&tally.rank) && tally.is_overdue == ranks.is_overdue
}

fn is_wanted(ranks: &Ranks, statuses: Option<&[Status]>) -> bool {
    let status = of_rank(ranks.highest).1;
    let is_it = |wanted: &Status| status == Some(*wanted) || ranks.is_overdue && *wanted == Status::Overdue;
    statuses.is_none_or(|wanted| wanted.iter().any(is_it))
}

/// None where all are wanted.
fn ranks_of(statuses: Option<&[Status]>) -> Option<Vec<Ranks>> {
    statuses?;
    Some(in_order().into_iter().filter(|ranks| is_wanted(ranks, statuses)).collect())
}

fn last_of(rows: &[Figures]) -> UtcMicros {
    rows.last().map_or(UtcMicros(0), |figures| figures.at)
}

/// The level of D_I or D_S that a baseline mark states at an instant, or the configuration; of D_O none does.
pub(super) fn stated(marks: &[Mark], at: UtcMicros, limits: &Limits, column: usize) -> Option<Measured> {
    let fixed = [limits.d_i.fixed_baseline, limits.d_s.fixed_baseline];
    stated_level(marks, at, column).or(fixed.get(column).copied().flatten())
}

/// The median of a complete baseline, or the level that is stated.
pub(super) fn level(baseline: &[Sample], column: usize, stated: Option<Measured>) -> Option<f64> {
    if let Some(stated) = stated {
        return Some(stated.value);
    }
    let first: Vec<Measured> = baseline.get(..BASELINE_RECORDS)?.iter().map(|sample| sample.d[column]).collect();
    Measured::median(&first).map(|median| median.value)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::core::alert_decision::{self, Alert, AlertState};
    use crate::core::alert_filter::AlertFilter;
    use crate::core::id::Id;
    use crate::core::judge::{BudgetProjection, Coefficient, Severity};
    use crate::pipeline::Pipeline;
    use crate::store::{AlertRow, Changes, HeadChanges, HeadRow, NewName, NewestRow, Remark};

    #[test]
    fn the_order_of_the_fleet_holds_every_gyro_once() {
        for place in 0..2 * 10 {
            for is_overdue in [false, true] {
                let tally = Tally { rank: place, is_overdue, gyros: 1 };
                let held = in_order().iter().filter(|ranks| is_of(&tally, ranks)).count();
                // No verdict says so, and what is not in use never is.
                let never = is_overdue && place < 10 || place == 15 && !is_overdue;
                assert_eq!(held, usize::from(!never), "{place}, {is_overdue}");
            }
        }
    }

    fn drawn(gyro: u32, rng: &mut ChaCha8Rng, now: UtcMicros) -> HeadRow {
        let statuses: Vec<Status> = Status::ALL.into_iter().filter(|status| *status != Status::Overdue).collect();
        let status = Some(statuses[rng.random_range(0..statuses.len())]).filter(|_| rng.random_bool(0.95));
        let in_use = rng.random_bool(0.8);
        let overdue_at = UtcMicros(now.0 + rng.random_range(-3..3));
        let serial = format!("S-{:03}", gyro * 37 % 251);
        HeadRow {
            gyro,
            sought: format!("{}\nimu-{}\nst-1", serial.to_lowercase(), gyro % 13),
            serial: serial.into(),
            newest: None,
            state: Some(State::Within),
            status,
            rank: rank(in_use, status),
            // Many are alike.
            load: f64::from(rng.random_range(0..4_u8)),
            ahead: [None; 2],
            overdue_at: Some(overdue_at).filter(|_| in_use && rng.random_bool(0.7)),
            out_of_use: None,
            firing: 0,
            severity: None,
            projection: BudgetProjection {
                load: [drawn_load(rng), drawn_load(rng), None],
                ..BudgetProjection::default()
            },
            since: None,
            changed_at: rng.random_bool(0.3).then(|| UtcMicros(now.0 - rng.random_range(0..5))),
        }
    }

    fn drawn_load(rng: &mut ChaCha8Rng) -> Option<Measured> {
        rng.random_bool(0.9).then(|| Measured::exact(f64::from(rng.random_range(-3..4_i8))))
    }

    /// The gyros of all pages, of which there are as many as `expected` gyros fill.
    async fn of_all_pages(fleet: &Fleet, filter: &FleetFilter<'_>, expected: usize) -> Vec<u32> {
        let mut found = Vec::new();
        for number in 0..=expected.saturating_sub(1) / 17 {
            let page = fleet.page(filter, number, 17).await.unwrap();
            assert_eq!((page.number, page.found, page.total), (number, expected, 250), "{filter:?}");
            found.extend(page.gyros.iter().map(|standing| standing.number));
        }
        found
    }

    /// Against the order of the whole fleet, sorted at once.
    #[tokio::test]
    async fn pages_are_cut_out_of_the_fleet_as_if_it_had_been_sorted_whole() {
        let (dir, now) = (tempfile::tempdir().unwrap(), UtcMicros(1_000_000_000_000));
        let mut config = Config::defaults();
        config.database.url = format!("sqlite://{}", dir.path().join("fleet.db").display());
        let (store, mut writer) = store::open(&config.database.options()).await.unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let rows: Vec<HeadRow> = (1..=250).map(|gyro| drawn(gyro, &mut rng, now)).collect();
        let gyros =
            rows.iter().map(|row| NewName { number: row.gyro, cell: 0, name: row.serial.to_string() }).collect();
        let heads = HeadChanges { rows: rows.clone(), ..HeadChanges::default() };
        writer.commit(&Changes { gyros, heads, ..Changes::default() }).await.unwrap();
        let pipeline = Pipeline::to_read(store, Arc::new(config), Clock::manual(now)).await.unwrap();
        let fleet = &pipeline.queries.fleet;

        let is_overdue = |row: &HeadRow| row.overdue_at.is_some_and(|at| at < now);
        let changed_since_then = |row: &HeadRow, since: UtcMicros| {
            row.changed_at.is_some_and(|at| at >= since) || is_overdue(row) && row.overdue_at >= Some(since)
        };
        let status = |row: &HeadRow| row.status.max(is_overdue(row).then_some(Status::Overdue));
        let is = |row: &HeadRow, of: Status| status(row) == Some(of) || of == Status::Overdue && is_overdue(row);
        let is_any = |row: &HeadRow, statuses: Option<&[Status]>| {
            statuses.is_none_or(|statuses| statuses.iter().any(|of| is(row, *of)))
        };
        let urgency = |row: &HeadRow| (row.rank >= 10, status(row), is_overdue(row));
        let mut sorted: Vec<&HeadRow> = rows.iter().collect();
        sorted.sort_by(|a, b| a.serial.cmp(&b.serial));
        sorted.sort_by(|a, b| urgency(b).cmp(&urgency(a)).then(b.load.total_cmp(&a.load)));
        let all: [Option<&[Status]>; 5] =
            [None, Some(&[Status::Overdue]), Some(&[Status::Drifting]), Some(&[Status::InTolerance]), Some(&BEYOND)];
        let mut cut = 0;
        for statuses in all {
            for text in ["", " S-1", "IMU-12\n", "nobody", "s_1", "%"] {
                let wanted = text.trim().to_lowercase();
                let fits = |row: &&&HeadRow| row.sought.contains(&wanted) && is_any(row, statuses);
                let expected: Vec<u32> = sorted.iter().filter(fits).map(|row| row.gyro).collect();
                let filter = FleetFilter { text, statuses, ..FleetFilter::default() };
                cut += expected.len().saturating_sub(1) / 17 + 1;
                assert_eq!(of_all_pages(fleet, &filter, expected.len()).await, expected, "{filter:?}");
            }
        }
        assert!(cut > 40, "{cut}");
        let by_load = |a: &&HeadRow, b: &&HeadRow| {
            let extreme = |row: &HeadRow| row.projection.extreme().unwrap_or(-1.0);
            extreme(b).total_cmp(&extreme(a)).then(a.serial.cmp(&b.serial))
        };
        for statuses in all {
            for changed_since in [None, Some(UtcMicros(now.0 - 2))] {
                let fits = |row: &&&HeadRow| {
                    is_any(row, statuses) && changed_since.is_none_or(|since| changed_since_then(row, since))
                };
                let mut expected: Vec<&HeadRow> = sorted.iter().filter(fits).copied().collect();
                for order in [FleetOrder::Load, FleetOrder::Serial] {
                    match order {
                        FleetOrder::Load => expected.sort_by(by_load),
                        _ => expected.sort_by(|a, b| a.serial.cmp(&b.serial)),
                    }
                    let filter = FleetFilter { statuses, changed_since, order: Some(order), ..FleetFilter::default() };
                    let found = of_all_pages(fleet, &filter, expected.len()).await;
                    assert!(found.iter().eq(expected.iter().map(|row| &row.gyro)), "{filter:?}");
                }
            }
        }
        let counts = fleet.page(&FleetFilter::default(), 0, 1).await.unwrap().of_status;
        for (of, count) in Status::ALL.into_iter().zip(counts) {
            assert_eq!(count, rows.iter().filter(|row| is(row, of)).count(), "{of:?}");
        }
        for of in Status::ALL {
            let filter = StatusFilter { status: Some(of), state: None };
            let found = fleet.listed(0, 1000, filter, &FleetFilter::default()).await.unwrap();
            let mut expected: Vec<&HeadRow> = sorted.iter().filter(|row| is(row, of)).copied().collect();
            expected.sort_by(|a, b| a.serial.cmp(&b.serial));
            let expected: Vec<u32> = expected.iter().map(|row| row.gyro).collect();
            assert!(found.iter().map(|standing| standing.number).eq(expected), "{of:?}");
        }
    }

    fn fired(id: i64, gyro: u32, rule: Rule, rng: &mut ChaCha8Rng, now: UtcMicros) -> AlertRow {
        let handled = |rng: &mut ChaCha8Rng| rng.random_bool(0.1);
        let alert = Alert {
            status: if rng.random_bool(0.2) {
                alert_decision::Status::Resolved
            } else {
                alert_decision::Status::Firing
            },
            severity: Severity::Warning,
            since: now,
            fired_at: now,
            resolved_at: None,
            record_at: now,
            within: 0,
            acknowledged: handled(rng),
            silenced_until: handled(rng).then(|| UtcMicros(now.0 + rng.random_range(-1..2))),
            muted_until: None,
            inhibited: handled(rng),
            suppressed: None,
            last_notification: None,
        };
        let remark = Remark { by: "A".into(), reason: "B".into(), at: now };
        AlertRow {
            id: Id(id),
            of: gyro.into(),
            coefficient: Coefficient::DI,
            rule,
            alert,
            acknowledged: alert.acknowledged.then(|| remark.clone()),
            silenced: alert.silenced_until.map(|_| remark),
            muted: None,
            inhibited_by: alert.inhibited.then_some(Id(1)),
            finding: "{}".into(),
        }
    }

    /// Few of one rule and many of another, so that both ways to them are gone.
    #[tokio::test]
    async fn alerts_and_what_is_due_are_listed_as_if_all_had_been_sorted() {
        let (dir, now) = (tempfile::tempdir().unwrap(), UtcMicros(1_000_000_000_000));
        let mut config = Config::defaults();
        config.database.url = format!("sqlite://{}", dir.path().join("fleet.db").display());
        let (store, mut writer) = store::open(&config.database.options()).await.unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut rows: Vec<HeadRow> = (1..=250).map(|gyro| drawn(gyro, &mut rng, now)).collect();
        for row in &mut rows {
            // One IMU has most of them.
            let imu = if row.gyro % 3 == 0 { 1 + row.gyro % 13 } else { 1 };
            let d = [Measured::exact(1.0); 2];
            row.newest = Some(NewestRow { at: now, record: Id(7), imu, station: 1, slot: Slot::G1, d });
            row.overdue_at = Some(UtcMicros(now.0 + i64::from(imu) - 5 + rng.random_range(0..3)));
        }
        let gyros =
            rows.iter().map(|row| NewName { number: row.gyro, cell: 0, name: row.serial.to_string() }).collect();
        let mut alerts = Vec::new();
        for row in &rows {
            let rules =
                [Rule::Baseline, Rule::Step].into_iter().filter(|rule| *rule == Rule::Baseline || row.gyro < 40);
            alerts.extend(rules.enumerate().map(|(k, rule)| {
                fired(1000 + i64::from(row.gyro * 71 % 251) * 2 + k as i64, row.gyro, rule, &mut rng, now)
            }));
        }
        let heads = HeadChanges { rows: rows.clone(), ..HeadChanges::default() };
        writer.commit(&Changes { gyros, heads, alerts: alerts.clone(), ..Changes::default() }).await.unwrap();

        let mut sorted: Vec<&HeadRow> = rows.iter().collect();
        sorted.sort_by(|a, b| b.rank.cmp(&a.rank).then(b.load.total_cmp(&a.load)).then(a.serial.cmp(&b.serial)));
        for rule in [None, Some(Rule::Baseline), Some(Rule::Step)] {
            let any = AlertFilter { rule, ..AlertFilter::default() };
            let counts = store::alerts::counts_by_state(&store, &any, now).await.unwrap();
            for standing in AlertState::ALL {
                let filter = AlertFilter { standing: Some(standing), ..any.clone() };
                let fits =
                    |row: &&AlertRow| rule.is_none_or(|rule| row.rule == rule) && row.alert.standing(now) == standing;
                assert_eq!(counts.get(&standing).copied().unwrap_or(0), alerts.iter().filter(fits).count());
                let newest = |gyro: u32| {
                    alerts.iter().filter(fits).filter(|row| row.of.gyro() == Some(gyro)).map(|row| row.id).max()
                };
                let mut expected: Vec<u32> =
                    sorted.iter().map(|row| row.gyro).filter(|gyro| newest(*gyro).is_some()).collect();
                for newest_first in [false, true] {
                    if newest_first {
                        expected.sort_by_key(|gyro| Reverse(newest(*gyro)));
                    }
                    let part = [3, 20];
                    let found = store::alerts::gyros_found(&store, &filter, now, newest_first, part).await.unwrap();
                    let expected: Vec<u32> = expected.iter().copied().skip(3).take(20).collect();
                    assert_eq!(found, expected, "{filter:?}, {newest_first}");
                }
            }
        }

        for (from, until) in [(i64::MIN, now.0), (now.0, now.0 + 4), (i64::MIN, i64::MAX), (now.0 + 99, i64::MAX)] {
            let mut of_imus: BTreeMap<u32, (UtcMicros, usize)> = BTreeMap::new();
            let due = rows.iter().filter_map(|row| Some((row.newest?.imu, row.overdue_at?)));
            for (imu, at) in due.filter(|(_, at)| (from..until).contains(&at.0)) {
                let (first, gyros) = of_imus.entry(imu).or_insert((at, 0));
                (*first, *gyros) = (at.min(*first), *gyros + 1);
            }
            let row = |(&imu, &(at, gyros)): (&u32, &(UtcMicros, usize))| DueImu { imu, at, gyros };
            let mut first: Vec<DueImu> = of_imus.iter().map(row).collect();
            first.sort_by_key(|due| (due.at, due.imu));
            first.truncate(4);
            let found = store::head::due(&store, [from, until].map(UtcMicros), 4).await.unwrap();
            assert_eq!(found, FirstOf { first, of: of_imus.len() }, "{from} to {until}");
        }
    }
}
