//! How each gyro stands, a row a gyro: what lists are made of.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::core::id::Id;
use crate::core::judge::{Event, Measured, Severity, State, Status};
use crate::core::mounting::Slot;
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{AnyRow, LISTED, Sql, Whole, cell, insert, on};
use crate::store::error::StoreError;
use crate::store::open::Store;

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
#[derive(Debug, Default)]
pub struct HeadChanges {
    /// One a gyro.
    pub rows: Vec<HeadRow>,
    pub made: Option<HeadsMade>,
}

/// How far the rows of all gyros have been made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeadsMade {
    /// A checksum of the limits with which they were.
    pub limits: String,
    /// Up to this serial; none where all are.
    pub through: Option<String>,
}

pub(crate) fn upsert(heads: &HeadChanges, batch: &mut Batch) {
    let mut rows = Rows::default();
    for head in &heads.rows {
        let newest = head.newest.as_ref();
        let mut row = rows.row();
        row.integer(i64::from(head.gyro))
            .text(&head.serial)
            .text(&head.sought)
            .optional_integer(newest.map(|newest| newest.at.0))
            .optional_integer(newest.map(|newest| newest.record.0))
            .optional_integer(newest.map(|newest| i64::from(newest.imu)))
            .optional_integer(newest.map(|newest| i64::from(newest.station)))
            .optional_text(newest.map(|newest| newest.slot.name()));
        for column in 0..2 {
            let d = newest.map(|newest| newest.d[column]);
            row.real(d.map(|d| d.value)).real(d.and_then(|d| d.sd));
        }
        row.optional_text(head.state.map(State::name))
            .optional_text(head.status.map(Status::name))
            .integer(head.rank)
            .real(Some(head.load))
            .real(head.ahead[0])
            .real(head.ahead[1])
            .optional_integer(head.overdue_at.map(|at| at.0))
            .optional_text(head.out_of_use.map(Event::name))
            .integer(i64::from(head.firing))
            .optional_text(head.severity.map(Severity::name));
    }
    batch.add(
        insert!(
            "head (gyro, serial, sought, calibrated_at, record, imu, station, slot, d_i, d_i_sd, d_s, d_s_sd, state,
             status, rank, load, d_i_ahead, d_s_ahead, overdue_at, out_of_use, firing, severity)",
            [int 0, text 1, text 2, int 3, int 4, int 5, int 6, text 7, real 8, real 9, real 10, real 11, text 12,
             text 13, int 14, real 15, real 16, real 17, int 18, text 19, int 20, text 21],
            "ON CONFLICT (gyro) DO UPDATE SET version = head.version + 1, sought = excluded.sought,
             calibrated_at = excluded.calibrated_at, record = excluded.record, imu = excluded.imu,
             station = excluded.station, slot = excluded.slot, d_i = excluded.d_i, d_i_sd = excluded.d_i_sd,
             d_s = excluded.d_s, d_s_sd = excluded.d_s_sd, state = excluded.state, status = excluded.status,
             rank = excluded.rank, load = excluded.load, d_i_ahead = excluded.d_i_ahead, d_s_ahead = excluded.d_s_ahead,
             overdue_at = excluded.overdue_at, out_of_use = excluded.out_of_use, firing = excluded.firing,
             severity = excluded.severity"
        ),
        rows,
    );
    let mut rows = Rows::default();
    if let Some(HeadsMade { limits, through }) = &heads.made {
        rows.row().integer(1).text(limits).optional_text(through.as_deref());
    }
    batch.add(
        insert!(
            "head_made (id, limits, through)",
            [int 0, text 1, text 2],
            "ON CONFLICT (id) DO UPDATE SET limits = excluded.limits, through = excluded.through"
        ),
        rows,
    );
}

/// How far the rows of all gyros have been made.
pub async fn made(store: &Store) -> Result<HeadsMade, StoreError> {
    let sql = "SELECT limits, through FROM head_made WHERE id = 1";
    let row: Option<(String, Option<String>)> = on!(store.readers, db => sqlx::query_as(sql).fetch_optional(db).await?);
    let (limits, through) = row.ok_or_else(|| StoreError::Damaged("the table head_made is empty".to_owned()))?;
    Ok(HeadsMade { limits, through })
}

/// Gyros by serial, from the first after `serial` on, as many as `limit`; whether they have a row or not.
pub async fn gyros_after(store: &Store, serial: &str, limit: u32) -> Result<Vec<(u32, String)>, StoreError> {
    let sql = "SELECT id, serial FROM gyro WHERE serial > $1 ORDER BY serial LIMIT $2";
    let rows: Vec<(Whole<u32>, String)> =
        on!(store.readers, db => sqlx::query_as(sql).bind(serial).bind(Whole(limit)).fetch_all(db).await?);
    Ok(rows.into_iter().map(|(Whole(gyro), serial)| (gyro, serial)).collect())
}

/// IMUs by name, from the first after that of IMU number `after` (0: all) on, as many as `limit`.
pub async fn imus_after(store: &Store, after: u32, limit: u32) -> Result<Vec<(u32, String)>, StoreError> {
    let sql = "SELECT id, name FROM imu WHERE name > coalesce((SELECT name FROM imu WHERE id = $1), '')
               ORDER BY name LIMIT $2";
    let rows: Vec<(Whole<u32>, String)> =
        on!(store.readers, db => sqlx::query_as(sql).bind(Whole(after)).bind(Whole(limit)).fetch_all(db).await?);
    Ok(rows.into_iter().map(|(Whole(imu), name)| (imu, name)).collect())
}

/// What a list of gyros is narrowed down to.
#[derive(Debug, Clone, Copy, Default)]
pub struct Narrowed<'a> {
    /// Part of [`HeadRow::sought`].
    pub sought: Option<&'a str>,
    /// Number of the station of the newest calibration.
    pub station: Option<u32>,
}

/// How many gyros have a rank, and are overdue or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    pub rank: i64,
    pub is_overdue: bool,
    pub gyros: usize,
}

/// How many gyros of a rank a station calibrated last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StationTally {
    /// None for gyros that only a bench has seen.
    pub station: Option<u32>,
    pub rank: i64,
    pub gyros: usize,
    pub last_calibrated: Option<UtcMicros>,
}

/// Counts the whole fleet as it stands at `now`, in two indices from end to end.
pub async fn counts(store: &Store, now: UtcMicros) -> Result<(Vec<Tally>, Vec<StationTally>), StoreError> {
    let sql = "SELECT station, rank, CAST(0 AS BIGINT), count(*), max(calibrated_at) FROM head GROUP BY station, rank
               UNION ALL
               SELECT CAST(NULL AS BIGINT), rank, CAST(1 AS BIGINT), count(*), CAST(NULL AS BIGINT) FROM head
               WHERE overdue_at < $1 GROUP BY rank";
    type Row = (Option<Whole<u32>>, i64, i64, i64, Option<i64>);
    let rows: Vec<Row> = on!(store.readers, db => sqlx::query_as(sql).bind(now.0).fetch_all(db).await?);
    let (mut of_ranks, mut of_stations) = (BTreeMap::<i64, [usize; 2]>::new(), Vec::new());
    // In no order.
    for (station, rank, is_overdue, gyros, last) in rows {
        let gyros = gyros.unsigned_abs() as usize;
        let [all, overdue] = of_ranks.entry(rank).or_default();
        if is_overdue == 1 {
            *overdue += gyros;
        } else {
            *all += gyros;
            let station = station.map(|Whole(station)| station);
            of_stations.push(StationTally { station, rank, gyros, last_calibrated: last.map(UtcMicros) });
        }
    }
    let both = |(rank, [all, overdue]): (i64, [usize; 2])| {
        [(false, all.saturating_sub(overdue)), (true, overdue)].map(|(is_overdue, gyros)| Tally {
            rank,
            is_overdue,
            gyros,
        })
    };
    Ok((of_ranks.into_iter().flat_map(both).filter(|tally| tally.gyros > 0).collect(), of_stations))
}

/// Counts what is left of the fleet where it is narrowed down.
pub async fn tallies(store: &Store, narrowed: Narrowed<'_>, now: UtcMicros) -> Result<Vec<Tally>, StoreError> {
    let Words { rank, conditions } = Words::of(store, narrowed, "$2", "$3");
    let sql = sqlx::AssertSqlSafe(format!(
        "SELECT rank, CAST(CASE WHEN overdue_at < $1 THEN 1 ELSE 0 END AS BIGINT), count(*) FROM head
         WHERE {conditions} GROUP BY {rank}, 2"
    ));
    let rows: Vec<(i64, i64, i64)> = on!(store.readers, db => sqlx::query_as(sql)
        .bind(now.0)
        .bind(narrowed.sought)
        .bind(narrowed.station.map(Whole))
        .fetch_all(db)
        .await?);
    let tally = |(rank, is_overdue, gyros): (i64, i64, i64)| Tally {
        rank,
        is_overdue: is_overdue == 1,
        gyros: gyros.unsigned_abs() as usize,
    };
    Ok(rows.into_iter().map(tally).collect())
}

/// How a question is put about a fleet that is narrowed down.
struct Words {
    rank: &'static str,
    conditions: String,
}

impl Words {
    /// `sought` and `station` are the places of these parameters. Who narrows the fleet down reads it through: in the
    /// order of an index each row would be looked up by itself.
    fn of(store: &Store, narrowed: Narrowed<'_>, sought: &str, station: &str) -> Self {
        let all = narrowed.sought.is_none() && narrowed.station.is_none();
        let rank = if all { "rank" } else { store.readers.words(Sql { sqlite: "+rank", postgres: "rank" }) };
        let has = store.readers.words(Sql { sqlite: "instr", postgres: "strpos" });
        // Not one condition for both: each is to find its index.
        let of_sought = narrowed.sought.map_or(format!("{sought} IS NULL"), |_| format!("{has}(sought, {sought}) > 0"));
        let of_station = narrowed.station.map_or(format!("{station} IS NULL"), |_| format!("station = {station}"));
        Self { rank, conditions: format!("{of_sought} AND {of_station}") }
    }
}

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
    narrowed: Narrowed<'_>,
    now: UtcMicros,
    [skip, limit]: [usize; 2],
) -> Result<Vec<u32>, StoreError> {
    let Ranks { lowest, highest, is_overdue } = ranks;
    let Words { rank, conditions } = Words::of(store, narrowed, "$4", "$5");
    // Of one rank the index has the order.
    let ranks =
        if lowest == highest { format!("{rank} = $1 AND {rank} = $2") } else { format!("{rank} BETWEEN $1 AND $2") };
    let overdue = if is_overdue { "overdue_at < $3" } else { "(overdue_at IS NULL OR overdue_at >= $3)" };
    let sql = sqlx::AssertSqlSafe(format!(
        "SELECT gyro FROM head WHERE {ranks} AND {overdue} AND {conditions}
         ORDER BY load DESC, serial LIMIT $6 OFFSET $7"
    ));
    let rows: Vec<(Whole<u32>,)> = on!(store.readers, db => sqlx::query_as(sql)
        .bind(lowest)
        .bind(highest)
        .bind(now.0)
        .bind(narrowed.sought)
        .bind(narrowed.station.map(Whole))
        .bind(i64::try_from(limit).unwrap_or(i64::MAX))
        .bind(i64::try_from(skip).unwrap_or(i64::MAX))
        .fetch_all(db)
        .await?);
    Ok(rows.into_iter().map(|(Whole(gyro),)| gyro).collect())
}

/// What a list by serial is narrowed down to.
#[derive(Debug, Clone, Copy, Default)]
pub struct Standings {
    /// Of gyros that are not in use; those that are have ten more.
    pub rank: Option<i64>,
    pub is_overdue: Option<bool>,
    pub state: Option<State>,
}

/// Gyros by serial, from the first after that of gyro number `after` (0: all) on, as many as `limit`. By number would
/// be in no order at all: a database server's numbers are random.
pub async fn by_serial(
    store: &Store,
    after: u32,
    narrowed: Standings,
    now: UtcMicros,
    limit: u32,
) -> Result<Vec<u32>, StoreError> {
    let sql = "SELECT gyro FROM head WHERE serial > coalesce((SELECT serial FROM gyro WHERE id = $1), '')
                   AND ($2 IS NULL OR rank = $2 OR rank = $2 + 10)
                   AND ($3 IS NULL OR $3 = (overdue_at IS NOT NULL AND overdue_at < $4)) AND ($5 IS NULL OR state = $5)
               ORDER BY serial LIMIT $6";
    let rows: Vec<(Whole<u32>,)> = on!(store.readers, db => sqlx::query_as(sql)
        .bind(Whole(after))
        .bind(narrowed.rank)
        .bind(narrowed.is_overdue)
        .bind(now.0)
        .bind(narrowed.state.map(State::name))
        .bind(Whole(limit))
        .fetch_all(db)
        .await?);
    Ok(rows.into_iter().map(|(Whole(gyro),)| gyro).collect())
}

/// The gyros whose newest calibration was made in an IMU.
pub async fn of_imu(store: &Store, imu: u32) -> Result<Vec<u32>, StoreError> {
    let sql = "SELECT gyro FROM head WHERE imu = $1 ORDER BY serial";
    let rows: Vec<(Whole<u32>,)> = on!(store.readers, db => sqlx::query_as(sql).bind(Whole(imu)).fetch_all(db).await?);
    Ok(rows.into_iter().map(|(Whole(gyro),)| gyro).collect())
}

/// The gyros whose calibration is due no later than `now`.
pub async fn overdue(store: &Store, now: UtcMicros) -> Result<Vec<u32>, StoreError> {
    let sql = "SELECT gyro FROM head WHERE overdue_at <= $1";
    let rows: Vec<Whole<u32>> = on!(store.readers, db => sqlx::query_scalar(sql).bind(now.0).fetch_all(db).await?);
    Ok(rows.into_iter().map(|Whole(gyro)| gyro).collect())
}

/// The rows of some gyros, in no order.
pub async fn of_gyros(store: &Store, gyros: &[u32]) -> Result<Vec<HeadRow>, StoreError> {
    let those = store.readers.words(LISTED);
    let sql = sqlx::AssertSqlSafe(format!("SELECT * FROM head WHERE gyro IN ({those})"));
    let gyros = serde_json::json!(gyros).to_string();
    on!(store.readers, db => sqlx::query(sql).bind(gyros).fetch_all(db).await?.iter().map(head).collect())
}

fn head(row: &impl AnyRow) -> Result<HeadRow, StoreError> {
    let gyro = row.cell::<Whole<u32>>("gyro")?.0;
    let damaged = |what: &str| StoreError::Damaged(format!("the head of gyro number {gyro}: unknown {what}"));
    fn named<T>(
        row: &impl AnyRow,
        column: &str,
        from_name: impl Fn(&str) -> Option<T>,
        damaged: impl Fn(&str) -> StoreError,
    ) -> Result<Option<T>, StoreError> {
        let name: Option<String> = row.cell(column)?;
        name.map(|name| from_name(&name).ok_or_else(|| damaged(column))).transpose()
    }
    let number = |column: &str| Ok::<_, sqlx::Error>(row.cell::<Option<Whole<u32>>>(column)?.map(|Whole(n)| n));
    let instant = |column: &str| Ok::<_, sqlx::Error>(row.cell::<Option<i64>>(column)?.map(UtcMicros));
    let real = |column: &str| row.cell::<Option<f64>>(column);
    let slot = named(row, "slot", Slot::from_name, damaged)?;
    let measured = |value: Option<f64>, sd| value.map(|value| Measured { value, sd });
    let (d_i, d_s) = (measured(real("d_i")?, real("d_i_sd")?), measured(real("d_s")?, real("d_s_sd")?));
    let calibrated = instant("calibrated_at")?.zip(row.cell::<Option<i64>>("record")?.map(Id));
    let mounted = number("imu")?.zip(number("station")?).zip(slot);
    let newest =
        calibrated.zip(mounted).zip(d_i.zip(d_s)).map(|(((at, record), ((imu, station), slot)), (d_i, d_s))| {
            NewestRow { at, record, imu, station, slot, d: [d_i, d_s] }
        });
    Ok(HeadRow {
        gyro,
        serial: row.cell::<String>("serial")?.into(),
        sought: row.cell("sought")?,
        newest,
        state: named(row, "state", State::from_name, damaged)?,
        status: named(row, "status", Status::from_name, damaged)?,
        rank: row.cell("rank")?,
        load: row.cell("load")?,
        ahead: [real("d_i_ahead")?, real("d_s_ahead")?],
        overdue_at: instant("overdue_at")?,
        out_of_use: named(row, "out_of_use", Event::from_name, damaged)?,
        firing: row.cell::<Whole<u32>>("firing")?.0,
        severity: named(row, "severity", Severity::from_name, damaged)?,
    })
}
