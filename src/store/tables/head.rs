//! How each gyro stands, one row per gyro: what lists are made of.

use super::*;
use crate::core::first_of::{DueImu, FirstOf, MovedImu};
use crate::core::fleet_order::FleetOrder;
use crate::core::judge::{
    BudgetCrossing, BudgetProjection, Coefficient, Event, Measured, Rule, Severity, State, Status,
};
use crate::core::mounting::Slot;

/// How a gyro stands, whatever the time is.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadRow {
    pub gyro: u32,
    pub serial: Arc<str>,
    /// What a search looks in.
    pub sought: String,
    pub newest: Option<NewestRow>,
    pub state: Option<State>,
    pub status: Option<Status>,
    /// What comes first in lists is greater.
    pub rank: i64,
    pub load: f64,
    /// Where the rule `trend` sees D_I and D_S at its horizon: how far from their baselines, deg/(h g0).
    pub ahead: [Option<f64>; 2],
    /// After this it is overdue.
    pub overdue_at: Option<UtcMicros>,
    pub out_of_use: Option<Event>,
    /// Alerts that are not resolved, and the gravest of them.
    pub firing: u32,
    pub severity: Option<Severity>,
    pub projection: BudgetProjection,
    /// Since when it is beyond its limits; where it is not, since when it drifts.
    pub since: Option<UtcMicros>,
    /// When the newest of its alerts that fire began, what is overdue left out.
    pub changed_at: Option<UtcMicros>,
}

impl HeadRow {
    /// Whether another row says the same: figures that were computed twice may differ in their last digits.
    pub fn agrees(&self, other: &Self) -> bool {
        let figures = |row: &Self| {
            let of_drift = row.projection.load.into_iter().chain(row.projection.per_year);
            of_drift.flat_map(|one| [one.map(|it| it.value), one.and_then(|it| it.sd)])
        };
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(1.0);
        // A date lies a year ahead: its last digits are a minute.
        let near_date = |a: UtcMicros, b: UtcMicros| (a.0 - b.0).abs() <= 60_000_000;
        let same_reach = |a: BudgetCrossing, b: BudgetCrossing| {
            let between = a.between.into_iter().zip(b.between).all(|(a, b)| both_or_neither(a, b, near_date));
            (a.coefficient, a.provisional) == (b.coefficient, b.provisional) && near_date(a.at, b.at) && between
        };
        Self { projection: other.projection, ..self.clone() } == *other
            && figures(self).zip(figures(other)).all(|(a, b)| both_or_neither(a, b, near))
            && both_or_neither(self.projection.reach, other.projection.reach, same_reach)
    }
}

fn both_or_neither<T: Copy>(a: Option<T>, b: Option<T>, same: impl Fn(T, T) -> bool) -> bool {
    a.zip(b).map_or(a.is_none() && b.is_none(), |(a, b)| same(a, b))
}

/// A gyro's newest calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewestRow {
    pub at: UtcMicros,
    pub record: Id,
    pub imu: u32,
    pub station: u32,
    pub slot: Slot,
    /// D_I and D_S by the judged method.
    pub d: [Measured; 2],
}

/// Rows to be written, and how far all are made.
#[derive(Debug, Default, PartialEq)]
pub struct HeadChanges {
    /// One a gyro.
    pub rows: Vec<HeadRow>,
    pub made: Option<HeadsMade>,
    /// Stations (first) that have calibrated gyros.
    pub seen: Vec<[u32; 2]>,
    /// What the verdicts on records of this transaction say of where their gyros go.
    pub projections: HashMap<(Id, u32), BudgetProjection>,
}

/// How far the rows of all gyros have been made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeadsMade {
    /// A checksum of the limits with which they were.
    pub limits: String,
    /// Up to this serial; none where all are.
    pub through: Option<String>,
}

part! {
    HeadsMade { limits, through }
}

columns! {
    HeadRow in "head" {
        gyro, serial, sought,
        newest: ["calibrated_at", "record", "imu", "station", "slot", "d_i", "d_i_sd", "d_s", "d_s_sd"],
        state, status, rank, load, ahead: ["d_i_ahead", "d_s_ahead"], overdue_at, out_of_use, firing, severity,
        projection: [
            "d_i_load", "d_i_load_sd", "d_s_load", "d_s_load_sd", "d_o_load", "d_o_load_sd", "d_i_year", "d_i_year_sd",
            "d_s_year", "d_s_year_sd", "extreme", "reach_of", "reach_at", "reach_from", "reach_until", "reach_provisional"
        ],
        since, changed_at,
    }
}

impl Part for Option<NewestRow> {
    fn put(&self, row: &mut Row<'_>) {
        let of = self.as_ref();
        row.put(&of.map(|it| it.at)).put(&of.map(|it| it.record)).put(&of.map(|it| it.imu));
        row.put(&of.map(|it| it.station)).put(&of.map(|it| it.slot));
        row.put(&[0, 1].map(|column| of.map(|it| it.d[column])));
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        let at: Option<UtcMicros> = found.part()?;
        let of: (Option<Id>, Option<u32>, Option<u32>, Option<Slot>) = found.part()?;
        let figures: [Option<Measured>; 2] = found.part()?;
        let (Some(at), (Some(record), Some(imu), Some(station), Some(slot)), [Some(d_i), Some(d_s)]) =
            (at, of, figures)
        else {
            return Ok(None);
        };
        Ok(Some(NewestRow { at, record, imu, station, slot, d: [d_i, d_s] }))
    }
}

impl Part for BudgetProjection {
    fn put(&self, row: &mut Row<'_>) {
        let Self { load, per_year, reach } = self;
        row.put(load).put(per_year).real(self.extreme().map_or(-1.0, |extreme| extreme.min(f64::MAX)));
        row.put(&reach.map(|reach| reach.coefficient)).put(&reach.map(|reach| reach.at));
        row.put(&[0, 1].map(|edge| reach.and_then(|reach| reach.between[edge])));
        row.put(&reach.is_some_and(|reach| reach.provisional));
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        let (load, per_year) = found.part()?;
        let _extreme: f64 = found.part()?;
        let (of, at): (Option<Coefficient>, Option<UtcMicros>) = found.part()?;
        let (between, provisional) = found.part()?;
        let reach = of.zip(at).map(|(coefficient, at)| BudgetCrossing { coefficient, at, between, provisional });
        Ok(Self { load, per_year, reach })
    }
}

pub(crate) fn upsert(heads: &HeadChanges, batch: &mut Batch) {
    batch.enter(&heads.rows, OnConflict::SetAllBut("gyro", &["serial"]));
    let made = Rows::each(&heads.made, |made, row| _ = row.integer(1).put(made));
    batch.insert("head_made", "id, limits, through", OnConflict::SetAllBut("id", &[]), made);
    batch.insert("gyro_station", "station, gyro", OnConflict::Keep, Rows::of(heads.seen.iter().copied()));
}

/// How far the rows of all gyros have been made.
pub async fn made(store: &Store) -> Result<HeadsMade> {
    let sql = "SELECT limits, through FROM head_made WHERE id = 1";
    let made: Option<HeadsMade> = read!(store, first, sql)?;
    made.ok_or_else(|| StoreError::damaged("the table head_made is empty"))
}

/// Gyros by serial, from the first after `serial` on, as many as `limit`; whether they have a row or not.
pub async fn gyros_after(store: &Store, serial: &str, limit: u32) -> Result<Vec<(u32, String)>> {
    let sql = "SELECT id, serial FROM gyro WHERE serial > $1 ORDER BY serial LIMIT $2";
    read!(store, all, sql, serial, limit)
}

/// IMUs by name, from the first after that of IMU number `after` (0: all) on, as many as `limit`.
pub async fn imus_after(store: &Store, after: u32, limit: u32) -> Result<Vec<(u32, String)>> {
    let sql = "SELECT id, name FROM imu WHERE name > coalesce((SELECT name FROM imu WHERE id = $1), '')
               ORDER BY name LIMIT $2";
    read!(store, all, sql, after, limit)
}

/// The fleet at an instant, or what it is narrowed down to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeadFilter {
    pub now: UtcMicros,
    pub sought: Option<SerialSearch>,
    /// Number of the station of the newest calibration.
    pub station: Option<u32>,
    /// Number of a station that has ever calibrated it.
    pub ever: Option<u32>,
    /// Number of the IMU of the newest calibration.
    pub imu: Option<u32>,
    /// A rule of which an alert is not resolved.
    pub rule: Option<Rule>,
    /// Calibrated no earlier than this.
    pub calibrated_since: Option<UtcMicros>,
    /// New, worse or overdue no earlier than this.
    pub changed_since: Option<UtcMicros>,
    /// Of production, as the laboratory says.
    pub batch: Option<String>,
}

impl HeadFilter {
    pub fn is_whole(&self) -> bool {
        *self == Self { now: self.now, ..Self::default() }
    }
}

/// What was searched for.
#[derive(Debug, Clone, PartialEq)]
pub enum SerialSearch {
    /// Part of [`HeadRow::sought`], as a pattern.
    Text(String),
    /// The gyros that were found, in JSON, where they are few.
    Found(String),
}

impl SerialSearch {
    pub fn text(part: &str) -> Self {
        let mut pattern = String::from("%");
        for letter in part.chars() {
            pattern.extend(['%', '_', '\\'].contains(&letter).then_some('\\').into_iter().chain([letter]));
        }
        Self::Text(pattern + "%")
    }

    fn words(&self) -> &str {
        let (Self::Text(words) | Self::Found(words)) = self;
        words
    }
}

/// Asks of the fleet: its time is `$1`, what it is narrowed down to stands from `$2` on, what else is bound from `$10` on.
macro_rules! of_fleet {
    ($store:expr, $rows:ident, $sql:expr, $narrowed:expr $(, $bound:expr)* $(,)?) => {{
        let HeadFilter { now, sought, station, ever, imu, rule, calibrated_since, changed_since, batch } = $narrowed;
        let (sought, batch) = (sought.as_ref().map(SerialSearch::words), batch.as_deref());
        read!(
            $store, $rows, AssertSqlSafe($sql),
            *now, sought, *station, *ever, *imu, *rule, *calibrated_since, *changed_since, batch $(, $bound)*
        )
    }};
}

/// How many gyros have a rank, and are overdue or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    pub rank: i64,
    pub is_overdue: bool,
    pub gyros: usize,
}

/// How many gyros of a rank a station calibrated last, and how many of those are overdue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StationTally {
    /// None for gyros that only a bench has seen.
    pub station: Option<u32>,
    pub overdue: usize,
    pub last_calibrated: Option<UtcMicros>,
}

/// Of a server's database, another one after every commit.
pub(super) const STAMPS: &str =
    "SELECT CAST(sum(stamp / 4294967296) AS BIGINT), CAST(sum(stamp % 4294967296) AS BIGINT) FROM cell";

/// Another one after every record, correction or attribute of a gyro: of a file by the checksums of their tables, of a
/// server's database by the stamps of its cells.
pub async fn version(store: &Store) -> Result<[i64; 2]> {
    let sql = store.readers.words(Sql {
        sqlite: "SELECT sum(rows), sum(sum % 1000000000000000) FROM checksum
                 WHERE name IN ('head', 'history', 'history_log', 'voided_history', 'record', 'correction', 'gyro_attribute')",
        postgres: STAMPS,
    });
    read!(store, one, sql)
}

/// When the first gyro becomes overdue that is not at an instant: until then what is counted of them stays.
pub async fn next_overdue(store: &Store, at: UtcMicros) -> Result<UtcMicros> {
    let sql = "SELECT min(overdue_at) FROM head WHERE overdue_at IS NOT NULL AND overdue_at >= $1";
    let next: Option<UtcMicros> = read!(store, one, sql, at)?;
    Ok(next.unwrap_or(Span::EVER.to))
}

/// Counts the whole fleet as it stands at `now`, in one index from end to end.
pub async fn counts(store: &Store, now: UtcMicros) -> Result<(Vec<Tally>, Vec<StationTally>)> {
    let sql = "SELECT station, rank, count(*), count(*) FILTER (WHERE overdue_at < $1), max(calibrated_at) FROM head
               GROUP BY station, rank";
    let rows: Vec<(Option<u32>, i64, [usize; 2], Option<UtcMicros>)> = read!(store, all, sql, now)?;
    let (mut of_ranks, mut of_stations) = (BTreeMap::<i64, [usize; 2]>::new(), Vec::new());
    for (station, rank, [gyros, overdue], last_calibrated) in rows {
        let [all, of_them] = of_ranks.entry(rank).or_default();
        (*all, *of_them) = (*all + gyros, *of_them + overdue);
        of_stations.push(StationTally { station, overdue, last_calibrated });
    }
    Ok((of_ranks.into_iter().flat_map(tallies_of).collect(), of_stations))
}

/// Of all gyros of a rank and those of them that are overdue.
fn tallies_of((rank, [all, overdue]): (i64, [usize; 2])) -> impl Iterator<Item = Tally> {
    let both = [(false, all - overdue), (true, overdue)].map(|(is_overdue, gyros)| Tally { rank, is_overdue, gyros });
    both.into_iter().filter(|tally| tally.gyros > 0)
}

/// Counts what is left of the fleet where it is narrowed down.
pub async fn tallies(store: &Store, narrowed: &HeadFilter) -> Result<Vec<Tally>> {
    let conditions = conditions(store, narrowed);
    let sql = format!(
        "SELECT rank + 0, count(*), count(*) FILTER (WHERE overdue_at < $1) FROM head WHERE {conditions} GROUP BY 1"
    );
    let rows: Vec<(i64, [usize; 2])> = of_fleet!(store, all, sql, narrowed)?;
    Ok(rows.into_iter().flat_map(tallies_of).collect())
}

/// How a fleet is narrowed down, by the parameters of `of_fleet`.
fn conditions(store: &Store, narrowed: &HeadFilter) -> String {
    let sought = match narrowed.sought {
        Some(SerialSearch::Found(_)) => &format!("gyro IN {}", store.readers.list("$2")),
        _ => r"sought LIKE $2 ESCAPE '\'",
    };
    let conditions = [
        (narrowed.sought.is_some(), sought),
        (narrowed.station.is_some(), "station = $3"),
        (narrowed.ever.is_some(), "gyro IN (SELECT gyro FROM gyro_station WHERE station = $4)"),
        (narrowed.imu.is_some(), "imu = $5"),
        (
            narrowed.rule.is_some(),
            "gyro IN (SELECT gyro FROM alert WHERE status = 'firing' AND rule = $6 AND rule <> 'batch_shift')",
        ),
        (
            narrowed.calibrated_since.is_some(),
            // As the index has it; who was never calibrated has the last instant of all.
            "coalesce(calibrated_at, 9223372036854775807) BETWEEN $7 AND 9223372036854775806",
        ),
        (narrowed.changed_since.is_some(), "(changed_at >= $8 OR overdue_at >= $8 AND overdue_at < $1)"),
        (narrowed.batch.is_some(), "gyro IN (SELECT gyro FROM gyro_attribute WHERE batch = $9)"),
    ];
    // The time is a parameter even where nothing asks for it.
    where_conditions(2, conditions) + " AND $1 = $1"
}

/// Gyros that a search finds among those of the other filters, where it finds few: what is asked next then need not
/// look through the fleet.
pub async fn search(store: &Store, narrowed: &HeadFilter) -> Result<Option<SerialSearch>> {
    let sql = format!("SELECT gyro FROM head WHERE {} LIMIT {}", conditions(store, narrowed), FEW + 1);
    let gyros: Vec<u32> = of_fleet!(store, all, sql, narrowed)?;
    Ok((gyros.len() <= FEW).then(|| SerialSearch::Found(gyros.as_slice().bound())))
}

/// Gyros up to which what was found is named one by one.
const FEW: usize = if cfg!(test) { 25 } else { 1000 };

/// Gyros that stand beside one another in the order of the fleet: those of some ranks that are overdue, or are not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ranks {
    pub lowest: i64,
    pub highest: i64,
    pub is_overdue: bool,
}

/// The gyros of some ranks from place `skip` on, as many as `limit`: the greater load first, then by serial.
pub async fn of_ranks(
    store: &Store,
    ranks: Ranks,
    narrowed: &HeadFilter,
    [skip, limit]: [usize; 2],
) -> Result<Vec<u32>> {
    let Ranks { lowest, highest, is_overdue } = ranks;
    let (conditions, overdue) = (conditions(store, narrowed), overdue(is_overdue));
    // Of one rank the index has the order, and what is found often is soon found in it. Who narrows the fleet down
    // further reads it through: in the order of an index each row would be looked up by itself.
    let is_often = match narrowed.sought {
        Some(SerialSearch::Text(_)) => true,
        Some(SerialSearch::Found(_)) => false,
        None => narrowed.is_whole(),
    };
    let parts: Vec<String> = match is_often {
        true => (lowest..=highest).map(|rank| format!("rank = {rank}")).collect(),
        false => vec![format!("rank + 0 BETWEEN {lowest} AND {highest}")],
    };
    let part = |ranks: &String| {
        format!(
            "SELECT * FROM (SELECT gyro, load, serial FROM head WHERE {ranks} AND {overdue} AND {conditions}
             ORDER BY load DESC, serial LIMIT $10 + $11) AS part"
        )
    };
    let sql = format!(
        "SELECT gyro FROM ({}) AS parts ORDER BY load DESC, serial LIMIT $10 OFFSET $11",
        parts.iter().map(part).collect::<Vec<_>>().join(" UNION ALL ")
    );
    of_fleet!(store, all, sql, narrowed, limit, skip)
}

/// What a list by serial is narrowed down to besides.
#[derive(Debug, Clone, Copy, Default)]
pub struct HeadStatusFilter {
    /// Of gyros that are not in use; those that are have ten more.
    pub rank: Option<i64>,
    pub is_overdue: Option<bool>,
    pub state: Option<State>,
}

/// What an order goes by before the serial, the least first.
fn key(order: FleetOrder) -> &'static str {
    match order {
        FleetOrder::Load => "-extreme",
        FleetOrder::Reach => "coalesce(reach_at, 9223372036854775807)",
        FleetOrder::Age => "coalesce(calibrated_at, 9223372036854775807)",
        FleetOrder::Serial => "0",
    }
}

/// Gyros in an order, from the first after gyro number `after` (0: all) on, as many as `limit`. By number would be in no
/// order at all: a database server's numbers are random.
pub async fn listed(
    store: &Store,
    after: u32,
    order: FleetOrder,
    standings: HeadStatusFilter,
    narrowed: &HeadFilter,
    limit: u32,
) -> Result<Vec<u32>> {
    let (conditions, key, by_serial) = (conditions(store, narrowed), key(order), order == FleetOrder::Serial);
    let after_it = match by_serial {
        true => "serial > coalesce((SELECT serial FROM gyro WHERE id = $10), '')".to_owned(),
        false => format!(
            "(CAST($10 AS BIGINT) = 0 OR ({key}, serial) > (SELECT {key}, serial FROM head AS last WHERE last.gyro = $10))"
        ),
    };
    let by = if by_serial { "serial".to_owned() } else { format!("{key}, serial") };
    let sql = format!(
        "SELECT gyro FROM head WHERE {after_it}
             AND ($11 IS NULL OR rank = $11 OR rank = $11 + 10)
             AND ($12 IS NULL OR $12 = (overdue_at IS NOT NULL AND overdue_at < $1)) AND ($13 IS NULL OR state = $13)
             AND {conditions}
         ORDER BY {by} LIMIT $14"
    );
    let HeadStatusFilter { rank, is_overdue, state } = standings;
    of_fleet!(store, all, sql, narrowed, after, rank, is_overdue, state, limit)
}

/// `$1` is the time.
fn overdue(is_overdue: bool) -> &'static str {
    if is_overdue { "overdue_at < $1" } else { "(overdue_at IS NULL OR overdue_at >= $1)" }
}

fn among_ranks(of_ranks: Option<&[Ranks]>) -> String {
    let one = |Ranks { lowest, highest, is_overdue }: &Ranks| {
        format!("(rank BETWEEN {lowest} AND {highest} AND {})", overdue(*is_overdue))
    };
    match of_ranks {
        None => "true".to_owned(),
        Some([]) => "false".to_owned(),
        Some(ranks) => format!("({})", ranks.iter().map(one).collect::<Vec<_>>().join(" OR ")),
    }
}

/// Gyros of some ranks, or of all, in an order, from place `skip` on, as many as `limit`.
pub async fn in_order(
    store: &Store,
    order: FleetOrder,
    of_ranks: Option<&[Ranks]>,
    narrowed: &HeadFilter,
    [skip, limit]: [usize; 2],
) -> Result<Vec<u32>> {
    let (conditions, ranks) = (conditions(store, narrowed), among_ranks(of_ranks));
    // As the indices have them.
    let by = match order {
        FleetOrder::Load => "extreme DESC, serial".to_owned(),
        FleetOrder::Reach | FleetOrder::Age => format!("{}, serial", key(order)),
        FleetOrder::Serial => "serial".to_owned(),
    };
    let sql = format!("SELECT gyro FROM head WHERE {ranks} AND {conditions} ORDER BY {by} LIMIT $10 OFFSET $11");
    of_fleet!(store, all, sql, narrowed, limit, skip)
}

/// Gyros of which something began to be worse no earlier than `since`, the newest first: as many as `limit`, of all.
pub async fn changed(store: &Store, since: UtcMicros, limit: usize) -> Result<FirstOf<u32>> {
    first_and_count(store, "changed_at >= $1 AND rank > 10", "changed_at DESC", since, limit).await
}

/// Gyros in use that are not beyond a limit and that their trends carry to the budget, or have carried there, the first
/// to reach it first: as many as `limit`, of all.
pub async fn approaching(store: &Store, limit: usize) -> Result<FirstOf<u32>> {
    // The rank is no way to find them: nearly all gyros have one of these.
    let by = key(FleetOrder::Reach);
    let those = format!("{by} BETWEEN $1 AND 9223372036854775806 AND rank + 0 BETWEEN 10 AND 16");
    first_and_count(store, &those, by, UtcMicros(i64::MIN), limit).await
}

/// `$1` is an instant.
async fn first_and_count(store: &Store, those: &str, by: &str, at: UtcMicros, limit: usize) -> Result<FirstOf<u32>> {
    let first = AssertSqlSafe(format!("SELECT gyro FROM head WHERE {those} ORDER BY {by}, serial LIMIT $2"));
    let count = AssertSqlSafe(format!("SELECT count(*) FROM head WHERE {those}"));
    Ok(FirstOf { first: read!(store, all, first, at, limit)?, of: read!(store, one, count, at)? })
}

/// IMUs with gyros that are due from one instant until before another, those whose first is due the longest ago first:
/// as many as `limit`, of all.
pub async fn due(store: &Store, [from, until]: [UtcMicros; 2], limit: usize) -> Result<FirstOf<DueImu>> {
    let sql = "SELECT imu, overdue_at FROM head
               WHERE overdue_at IS NOT NULL AND overdue_at >= $1 AND overdue_at < $2 AND imu IS NOT NULL
               ORDER BY overdue_at, imu LIMIT $3";
    // An IMU has a few gyros; where it has more, more are read.
    let mut read: usize = 4;
    let first: Vec<(u32, UtcMicros)> = loop {
        read = read.saturating_mul(limit.max(2));
        let rows: Vec<(u32, UtcMicros)> = read!(store, all, sql, from, until, read)?;
        let mut seen = HashSet::new();
        let first = rows.iter().filter(|(imu, _)| seen.insert(*imu)).copied().take(limit).collect::<Vec<_>>();
        if first.len() == limit || rows.len() < read {
            break first;
        }
    };
    let imus: Vec<u32> = first.iter().map(|(imu, _)| *imu).collect();
    let of_imus = AssertSqlSafe(format!(
        "SELECT imu, count(*) FROM head WHERE imu IN {} AND overdue_at + 0 >= $2 AND overdue_at + 0 < $3 GROUP BY imu",
        store.readers.list("$1")
    ));
    let gyros: Vec<(u32, usize)> = read!(store, all, of_imus, &imus, from, until)?;
    let gyros: HashMap<u32, usize> = gyros.into_iter().collect();
    let all = "SELECT count(*) FROM (
                       SELECT DISTINCT imu FROM head
                       WHERE overdue_at IS NOT NULL AND overdue_at >= $1 AND overdue_at < $2 AND imu IS NOT NULL) AS due";
    let all = read!(store, one, all, from, until)?;
    let row = |(imu, at): (u32, UtcMicros)| DueImu { imu, at, gyros: gyros.get(&imu).copied().unwrap_or_default() };
    Ok(FirstOf { first: first.into_iter().map(row).collect(), of: all })
}

/// A gyro's newest calibration, for what its station has done to others too.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedRow {
    pub gyro: u32,
    pub imu: u32,
    pub station: u32,
    pub at: UtcMicros,
    /// Of D_I and D_S.
    pub load: [Option<Measured>; 2],
    pub batch: Option<Arc<str>>,
}

columns! {
    CalibratedRow in "head" {
        gyro, imu, station, at: ["calibrated_at"],
        load: ["d_i_load", "d_i_load_sd", "d_s_load", "d_s_load_sd"], batch,
    }
}

/// Newest calibrations that were made no earlier than `from`, of as many gyros as tell what a fleet does; by one station,
/// of as many as tell what it does.
pub async fn calibrated_since(store: &Store, from: UtcMicros, station: Option<u32>) -> Result<Vec<CalibratedRow>> {
    // Nothing that the index does not have.
    let sql = "SELECT head.gyro, imu, station, calibrated_at, d_i_load, d_i_load_sd, d_s_load, d_s_load_sd, batch
               FROM head LEFT JOIN gyro_attribute ON gyro_attribute.gyro = head.gyro
               WHERE coalesce(calibrated_at, 9223372036854775807) BETWEEN $1 AND 9223372036854775806
                     AND station IS NOT NULL AND imu IS NOT NULL AND ($2 < 0 OR station = $2)
               ORDER BY coalesce(calibrated_at, 9223372036854775807) DESC LIMIT $3";
    let limit: i64 = if station.is_some() { 100 } else { 20_000 };
    read!(store, all, sql, from, station.map_or(-1, i64::from), limit)
}

/// Gyros that a station has ever calibrated, without `gyro`: as many as `most`, the nearest numbers first.
pub async fn near(store: &Store, station: u32, gyro: u32, most: usize) -> Result<Vec<u32>> {
    let below = "SELECT gyro FROM gyro_station WHERE station = $1 AND gyro < $2 ORDER BY gyro DESC LIMIT $3";
    let above = "SELECT gyro FROM gyro_station WHERE station = $1 AND gyro > $2 ORDER BY gyro LIMIT $3";
    let mut found: Vec<u32> = Vec::new();
    for sql in [below, above] {
        let those: Vec<u32> = read!(store, all, sql, station, gyro, most)?;
        found.extend(those);
    }
    found.sort_by_key(|other| other.abs_diff(gyro));
    found.truncate(most);
    Ok(found)
}

columns! {
    MovedImu in "head" { record, imu, at, gyros, least }
}

/// Records with three gyros or more that began to be worse no earlier than `since` and lie `loads` budgets or more
/// from their baselines, the farthest first.
pub async fn moved(store: &Store, since: UtcMicros, loads: f64, limit: usize) -> Result<Vec<MovedImu>> {
    let sql = "SELECT record, imu, max(calibrated_at) AS at, count(*) AS gyros, min(extreme) AS least FROM head
               WHERE changed_at >= $1 AND extreme >= $2 GROUP BY record, imu HAVING count(*) >= 3
               ORDER BY 5 DESC, 1 LIMIT $3";
    read!(store, all, sql, since, loads, limit)
}

/// IMUs by their worst gyro, then by the largest load. `overdue`: the rank that a gyro has at the least that is overdue.
pub async fn imus(
    store: &Store,
    of_ranks: Option<&[Ranks]>,
    narrowed: &HeadFilter,
    overdue: i64,
    [skip, limit]: [usize; 2],
) -> Result<Vec<u32>> {
    let (conditions, ranks) = (conditions(store, narrowed), among_ranks(of_ranks));
    let sql = format!(
        "SELECT imu FROM head WHERE imu IS NOT NULL AND {ranks} AND {conditions}
         GROUP BY imu
         ORDER BY max(CASE WHEN overdue_at < $1 AND rank < {overdue} THEN {overdue} ELSE rank END) DESC, max(extreme) DESC, imu LIMIT $10 OFFSET $11"
    );
    of_fleet!(store, all, sql, narrowed, limit, skip)
}

/// How many IMUs [`imus`] finds in all.
pub async fn imus_found(store: &Store, of_ranks: Option<&[Ranks]>, narrowed: &HeadFilter) -> Result<usize> {
    let (conditions, ranks) = (conditions(store, narrowed), among_ranks(of_ranks));
    let sql = format!("SELECT count(DISTINCT imu) FROM head WHERE imu IS NOT NULL AND {ranks} AND {conditions}");
    of_fleet!(store, one, sql, narrowed)
}

/// The gyros whose newest calibration was made in any of these IMUs, by serial.
pub async fn of_imus(store: &Store, imus: &[u32]) -> Result<Vec<u32>> {
    let those = store.readers.list("$1");
    let sql = AssertSqlSafe(format!("SELECT gyro FROM head WHERE imu IN {those} ORDER BY serial"));
    read!(store, all, sql, imus)
}

/// The gyros whose calibration is due no later than `now` and of which no alert says so, or of which an alert says so
/// and it is not.
pub async fn newly_overdue_or_not(store: &Store, now: UtcMicros) -> Result<Vec<u32>> {
    let sql = "SELECT gyro FROM head WHERE overdue_at <= $1 AND NOT EXISTS (
                   SELECT 1 FROM alert WHERE status = 'firing' AND rule = 'overdue' AND alert.gyro = head.gyro)
               UNION ALL SELECT gyro FROM alert WHERE status = 'firing' AND rule = 'overdue' AND NOT EXISTS (
                   SELECT 1 FROM head WHERE head.gyro = alert.gyro AND overdue_at <= $1)";
    read!(store, all, sql, now)
}

/// The rows of some gyros, in no order.
pub async fn of_gyros(store: &Store, gyros: &[u32]) -> Result<Vec<HeadRow>> {
    let sql = HeadRow::select(&format!("WHERE gyro IN {}", store.readers.list("$1")));
    read!(store, all, sql, gyros)
}
