//! Alerts, and the steps by which they came to be what they are.

use std::collections::{BTreeSet, HashMap};

use super::{
    AnyRow, AssertSqlSafe, Batch, Columns, Id, OnConflict, Part, Result, Row, Sql, Store, StoreError, UtcMicros, Whole,
    asked, at_most, columns, counted, list_of, numbers, on, read,
};
use crate::core::alert_decision::{Alert, Hushed, LastNotification, Standing};
use crate::core::alert_filter::AlertFilter;
use crate::core::judge::{Coefficient, Rule, Severity};
use crate::store::tables::head::STAMPS;

/// Who said so, why and when.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    pub by: String,
    pub reason: String,
    pub at: UtcMicros,
}

impl Part for Remark {
    fn put(&self, row: &mut Row<'_>) {
        row.put(&self.by).put(&self.reason).put(&self.at);
    }

    fn get(row: &impl AnyRow, columns: &[&'static str]) -> Result<Self> {
        let (by, reason, at) = row.part(columns)?;
        Ok(Self { by, reason, at })
    }
}

impl Part for Option<Remark> {
    fn put(&self, row: &mut Row<'_>) {
        let said = self.as_ref();
        row.put(&said.map(|remark| remark.by.clone())).put(&said.map(|remark| remark.reason.clone()));
        row.put(&said.map(|remark| remark.at));
    }

    fn get(row: &impl AnyRow, columns: &[&'static str]) -> Result<Self> {
        let is_there = row.part::<Option<UtcMicros>>(&columns[2..])?.is_some();
        is_there.then(|| row.part(columns)).transpose()
    }
}

/// What an alert is about, by its number; a batch of production by that of one of its gyros.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AlertOf {
    Gyro(u32),
    Station(u32),
    Imu(u32),
    Batch(u32),
}

impl AlertOf {
    pub fn gyro(self) -> Option<u32> {
        if let Self::Gyro(gyro) = self { Some(gyro) } else { None }
    }

    pub fn station(self) -> Option<u32> {
        if let Self::Station(station) = self { Some(station) } else { None }
    }

    pub fn imu(self) -> Option<u32> {
        if let Self::Imu(imu) = self { Some(imu) } else { None }
    }

    pub fn batch(self) -> Option<u32> {
        if let Self::Batch(gyro) = self { Some(gyro) } else { None }
    }
}

impl From<u32> for AlertOf {
    fn from(gyro: u32) -> Self {
        Self::Gyro(gyro)
    }
}

/// The alert of one gyro, station, IMU or batch, coefficient and rule.
#[derive(Debug, Clone, PartialEq)]
pub struct AlertRow {
    pub id: Id,
    pub of: AlertOf,
    pub coefficient: Coefficient,
    pub rule: Rule,
    pub alert: Alert,
    /// Of [`Alert::acknowledged`].
    pub acknowledged: Option<Remark>,
    /// Of [`Alert::silenced_until`].
    pub silenced: Option<Remark>,
    /// Of [`Alert::muted_until`]: the silence, and what was said of it.
    pub muted: Option<(Id, Remark)>,
    /// Of [`Alert::inhibited`]: the alert of the station, batch or IMU that explains it.
    pub inhibited_by: Option<Id>,
    /// The last verdict as clients read it, JSON.
    pub finding: String,
}

/// A gyro exceeds a limit: of its alert, what tells whether others do too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExcessRow {
    pub gyro: u32,
    pub coefficient: Coefficient,
    pub rule: Rule,
    pub severity: Severity,
    pub since: UtcMicros,
}

/// Something became of an alert.
#[derive(Debug, Clone, PartialEq)]
pub struct StepRow {
    pub id: Id,
    pub alert: Id,
    pub at: UtcMicros,
    /// Name of an action of `core::notify`, or what a person did: `acknowledge`, `silence`.
    pub action: String,
    pub told: bool,
    pub author: Option<String>,
    pub reason: Option<String>,
    /// The alert as it then was, as clients read it, JSON.
    pub body: String,
}

columns! {
    ExcessRow in "alert" { gyro, coefficient, rule, severity, since }
}

columns! {
    StepRow in "alert_step" { id, alert, at, action, told, author, reason, body }
}

impl Columns for AlertRow {
    const TABLE: &'static str = "alert";
    const COLUMNS: &'static str = "id, gyro, station, imu, coefficient, rule, status, severity, since, fired_at, \
        resolved_at, record_at, within, told_at, told_severity, acknowledged_by, acknowledged_reason, acknowledged_at, \
        silenced_by, silenced_reason, silenced_at, silenced_until, finding, hushed_at, digest, muted_by, muted_until, \
        inhibited_by";

    fn put_all(&self, row: &mut Row<'_>) {
        let Self { id, of, coefficient, rule, alert, acknowledged, silenced, muted, inhibited_by, finding } = self;
        row.put(id).put(&of.gyro().or(of.batch())).put(&of.station()).put(&of.imu()).put(coefficient).put(rule);
        row.put(&alert.status).put(&alert.severity).put(&alert.since).put(&alert.fired_at).put(&alert.resolved_at);
        row.put(&alert.record_at).put(&alert.within);
        row.put(&alert.told.map(|told| told.at)).put(&alert.told.map(|told| told.severity));
        row.put(acknowledged).put(silenced).put(&alert.silenced_until).words(finding);
        row.put(&alert.hushed.map(|hushed| hushed.at)).put(&alert.hushed.is_some_and(|hushed| hushed.digest));
        row.put(&muted.as_ref().map(|(silence, _)| *silence)).put(&alert.muted_until).put(inhibited_by);
    }

    fn get_all(row: &impl AnyRow) -> Result<Self> {
        alert(row).map_err(|error| error.of(Self::TABLE))
    }
}

pub(crate) fn upsert(alerts: &[AlertRow], batch: &mut Batch) {
    batch.enter(alerts, OnConflict::SetAllBut("id", &["gyro", "station", "imu", "coefficient", "rule"]));
}

/// Alerts, each with the silence that mutes it, in the order in which they first fired.
fn select(conditions: &str) -> AssertSqlSafe<String> {
    AssertSqlSafe(format!("{SELECT} WHERE {conditions} ORDER BY alert.id"))
}

const SELECT: &str = "SELECT alert.id, gyro, alert.station, alert.imu, inhibited_by, coefficient, alert.rule, status, severity, fired_at, resolved_at, record_at, within, \
     told_at, told_severity, acknowledged_by, acknowledged_reason, acknowledged_at, \
     silenced_by, silenced_reason, silenced_at, silenced_until, finding, coalesce(since, fired_at) AS since, hushed_at, digest, \
     muted_by, muted_until, silence.author AS muted_author, silence.reason AS muted_reason, silence.at AS muted_at \
     FROM alert LEFT JOIN silence ON silence.id = alert.muted_by";

fn alert(row: &impl AnyRow) -> Result<AlertRow> {
    let instant = |column: &'static str| row.part::<Option<UtcMicros>>(&[column]);
    let rule: Rule = row.part(&["rule"])?;
    let of: [Option<u32>; 3] = row.part(&["gyro", "station", "imu"])?;
    let of = match of {
        [Some(gyro), ..] if rule == Rule::BatchShift => AlertOf::Batch(gyro),
        [Some(gyro), ..] => AlertOf::Gyro(gyro),
        [_, Some(station), _] => AlertOf::Station(station),
        [.., Some(imu)] => AlertOf::Imu(imu),
        [None, None, None] => return Err(StoreError::Damaged("unknown subject".to_owned())),
    };
    let digest: bool = row.part(&["digest"])?;
    let muted_by: Option<Id> = row.part(&["muted_by"])?;
    let muted: Option<Remark> = row.part(&["muted_author", "muted_reason", "muted_at"])?;
    let inhibited_by: Option<Id> = row.part(&["inhibited_by"])?;
    let acknowledged: Option<Remark> = row.part(&["acknowledged_by", "acknowledged_reason", "acknowledged_at"])?;
    let told = instant("told_at")?.zip(row.part::<Option<Severity>>(&["told_severity"])?);
    Ok(AlertRow {
        id: row.part(&["id"])?,
        of,
        coefficient: row.part(&["coefficient"])?,
        rule,
        alert: Alert {
            status: row.part(&["status"])?,
            severity: row.part(&["severity"])?,
            since: row.part(&["since"])?,
            fired_at: row.part(&["fired_at"])?,
            resolved_at: instant("resolved_at")?,
            record_at: row.part(&["record_at"])?,
            within: row.part(&["within"])?,
            acknowledged: acknowledged.is_some(),
            silenced_until: instant("silenced_until")?,
            muted_until: instant("muted_until")?,
            inhibited: inhibited_by.is_some(),
            hushed: instant("hushed_at")?.map(|at| Hushed { at, digest }),
            told: told.map(|(at, severity)| LastNotification { at, severity }),
        },
        acknowledged,
        silenced: row.part(&["silenced_by", "silenced_reason", "silenced_at"])?,
        muted: muted_by.zip(muted),
        inhibited_by,
        finding: row.part(&["finding"])?,
    })
}

/// That it is no alert of the batch of its gyro.
const OF_ITSELF: &str = "alert.rule <> 'batch_shift'";

/// That it is an alert of a station, a batch or an IMU, as its index has it.
const OF_NO_GYRO: &str = "(alert.gyro IS NULL OR alert.rule = 'batch_shift')";

/// How an alert stands for whoever looks at it.
const STANDING: &str = "CASE WHEN alert.status = 'resolved' THEN 'resolved'
                             WHEN alert.silenced_until > $7 OR alert.muted_until > $7 THEN 'silenced'
                             WHEN alert.inhibited_by IS NOT NULL THEN 'inhibited'
                             WHEN alert.acknowledged_at IS NOT NULL THEN 'acknowledged'
                             ELSE 'firing' END";

/// What leads to alerts: their status, which has an index; or their gyro or an order, where that index would read every
/// alert that fires, so that the status is asked for in a form that has none.
#[derive(Clone, Copy, PartialEq)]
enum Lookup {
    Status,
    Other,
}

/// What a filter lets through: seven parameters, see the macro `bound`.
fn conditions(store: &Store, filter: &AlertFilter, lookup: Lookup) -> String {
    let imu =
        store.readers.words(Sql { sqlite: "alert.finding->>'imu'", postgres: "CAST(alert.finding AS JSONB)->>'imu'" });
    // Follows from the standing.
    let status = match filter.standing {
        Some(Standing::Resolved) => "alert.status = 'resolved'",
        _ if lookup == Lookup::Status => "alert.status = 'firing'",
        _ => "alert.status <> 'resolved'",
    };
    let conditions = [
        (filter.gyro.is_some(), &*format!("alert.gyro = $1 AND {OF_ITSELF}")),
        (filter.coefficient.is_some(), "alert.coefficient = $2"),
        (filter.rule.is_some(), "alert.rule = $3"),
        (filter.severity.is_some(), "alert.severity = $4"),
        (filter.imu.is_some(), &format!("{imu} = $5")),
        (filter.standing.is_some(), &format!("$6 = {STANDING} AND {status}")),
    ];
    // The time is a parameter even where no standing is asked for.
    asked(1, conditions) + " AND $7 = $7"
}

macro_rules! bound {
    ($query:expr, $filter:expr, $now:expr) => {
        $query
            .bind($filter.gyro.map(Whole))
            .bind($filter.coefficient.map(Coefficient::name))
            .bind($filter.rule.map(Rule::name))
            .bind($filter.severity.map(Severity::name))
            .bind($filter.imu.as_deref())
            .bind($filter.standing.map(Standing::name))
            .bind($now.0)
    };
}

/// Alerts that a filter lets through at `now`, with identifiers below `before`, newest first.
pub async fn find(
    store: &Store,
    filter: &AlertFilter,
    now: UtcMicros,
    before: Option<Id>,
    limit: u32,
) -> Result<Vec<AlertRow>> {
    let conditions = conditions(store, filter, Lookup::Other);
    let sql = AssertSqlSafe(format!("{SELECT} WHERE {conditions} AND alert.id < $8 ORDER BY alert.id DESC LIMIT $9"));
    on!(store.readers, db => bound!(sqlx::query(sql), filter, now)
        .bind(before.map_or(i64::MAX, |id| id.0))
        .bind(Whole(limit))
        .fetch_all(db)
        .await?.iter().map(Columns::get_all).collect())
}

/// Gyros with alerts that a filter lets through: those that stand worst first, or with `newest`, those whose newest
/// alert is the newest; from place `skip` on, as many as `limit`.
pub async fn gyros_found(
    store: &Store,
    filter: &AlertFilter,
    now: UtcMicros,
    newest: bool,
    [skip, limit]: [usize; 2],
) -> Result<Vec<u32>> {
    let [conditions, of_gyro] = [Lookup::Status, Lookup::Other].map(|lookup| conditions(store, filter, lookup));
    let few = AssertSqlSafe(format!(
        "SELECT count(*) FROM (SELECT 1 FROM alert WHERE {conditions} AND {OF_ITSELF} LIMIT {FEW}) AS found"
    ));
    let found: i64 = on!(store.readers, db => bound!(sqlx::query_scalar(few), filter, now).fetch_one(db).await?);
    // What many gyros have is soon found in the order of the fleet; what few have would be long in coming.
    let sql = AssertSqlSafe(match (newest, found < FEW) {
        (true, _) => format!(
            "SELECT alert.gyro FROM alert WHERE {conditions} AND {OF_ITSELF} AND gyro IS NOT NULL
             GROUP BY alert.gyro ORDER BY max(alert.id) DESC LIMIT $8 OFFSET $9"
        ),
        (false, true) => format!(
            "SELECT head.gyro FROM head
             WHERE head.gyro IN (SELECT alert.gyro FROM alert WHERE {conditions} AND {OF_ITSELF})
             ORDER BY head.rank DESC, head.load DESC, head.serial LIMIT $8 OFFSET $9"
        ),
        (false, false) => format!(
            "SELECT head.gyro FROM head
             WHERE EXISTS (SELECT 1 FROM alert WHERE alert.gyro = head.gyro AND {of_gyro} AND {OF_ITSELF})
             ORDER BY head.rank DESC, head.load DESC, head.serial LIMIT $8 OFFSET $9"
        ),
    });
    Ok(numbers(on!(store.readers, db => bound!(sqlx::query_scalar(sql), filter, now)
        .bind(at_most(limit))
        .bind(at_most(skip))
        .fetch_all(db)
        .await?)))
}

/// Alerts below which their gyros are looked up and sorted.
const FEW: i64 = if cfg!(test) { 60 } else { 4000 };

/// Alerts of some gyros that a filter lets through, in the order in which they first fired.
pub async fn found_of(store: &Store, filter: &AlertFilter, now: UtcMicros, gyros: &[u32]) -> Result<Vec<AlertRow>> {
    let conditions = conditions(store, filter, Lookup::Other);
    let sql = select(&format!("{conditions} AND alert.gyro IN {}", store.readers.list("$8")));
    let gyros = serde_json::json!(gyros).to_string();
    on!(store.readers, db => bound!(sqlx::query(sql), filter, now)
        .bind(gyros)
        .fetch_all(db)
        .await?.iter().map(Columns::get_all).collect())
}

/// How many alerts stand how, among those that a filter lets through. Most of those that fire are handled by nobody:
/// they are what is left.
pub async fn standings(store: &Store, filter: &AlertFilter, now: UtcMicros) -> Result<HashMap<Standing, usize>> {
    let conditions = conditions(store, filter, Lookup::Status);
    let by_status = AssertSqlSafe(format!("SELECT status, count(*) FROM alert WHERE {conditions} GROUP BY status"));
    let handled = AssertSqlSafe(format!(
        "SELECT {STANDING}, count(*) FROM alert WHERE {conditions} AND status = 'firing'
             AND (silenced_until > $7 OR muted_until > $7 OR inhibited_by IS NOT NULL OR acknowledged_at IS NOT NULL)
         GROUP BY 1"
    ));
    let mut counts: HashMap<Standing, usize> = HashMap::new();
    for sql in [by_status, handled] {
        let rows: Vec<(String, i64)> =
            on!(store.readers, db => bound!(sqlx::query_as(sql), filter, now).fetch_all(db).await?);
        let known = |(name, count): (String, i64)| Some((Standing::from_name(&name)?, counted(count)));
        let rows: Vec<(Standing, usize)> = rows.into_iter().filter_map(known).collect();
        if let Some(firing) = counts.get_mut(&Standing::Firing) {
            *firing = firing.saturating_sub(rows.iter().map(|(_, count)| count).sum());
        }
        counts.extend(rows);
    }
    Ok(counts)
}

/// Another one after every change of an alert.
pub async fn version(store: &Store) -> Result<[i64; 2]> {
    let sqlite = "SELECT rows, sum FROM checksum WHERE name = 'alert'";
    let (of_rows, of_sums) = read!(store, query_as.fetch_one, store.readers.words(Sql { sqlite, postgres: STAMPS }));
    Ok([of_rows, of_sums])
}

/// Until when the clock alone changes how no alert stands.
pub async fn same_until(store: &Store, now: UtcMicros) -> Result<UtcMicros> {
    let sql = "SELECT min(silenced_until) FROM alert
               WHERE (silenced_until IS NOT NULL OR muted_until IS NOT NULL) AND silenced_until > $1
               UNION ALL SELECT min(muted_until) FROM alert
               WHERE (silenced_until IS NOT NULL OR muted_until IS NOT NULL) AND muted_until > $1";
    let ends: Vec<Option<i64>> = read!(store, query_scalar.fetch_all, sql, now.0);
    Ok(UtcMicros(ends.into_iter().flatten().min().map_or(i64::MAX, |end| end - 1)))
}

/// Alerts that may change at `now` with the clock alone: of which somebody is to be told, that are silenced, or that were
/// told no later than `repeated`. Each part stands as its index has it.
pub async fn due(store: &Store, now: UtcMicros, repeated: UtcMicros) -> Result<Vec<AlertRow>> {
    let sql = format!(
        "SELECT id FROM alert {by_time} WHERE status = 'firing' AND acknowledged_at IS NULL AND told_at <= $2
         UNION ALL SELECT id FROM alert {by_time} WHERE status = 'firing' AND acknowledged_at IS NULL AND told_at > $1
         UNION ALL SELECT id FROM alert WHERE (silenced_until IS NOT NULL OR muted_until IS NOT NULL)
             AND (silenced_until <= $1 OR muted_until <= $1)
         UNION ALL SELECT id FROM alert WHERE hushed_at IS NULL AND inhibited_by IS NULL AND CASE
             WHEN status = 'firing' THEN told_at IS NULL OR severity <> told_severity ELSE told_at IS NOT NULL END",
        // SQLite takes every firing alert otherwise: it does not know how few of them are due.
        by_time = store.readers.words(Sql { sqlite: "INDEXED BY alert_repeated", postgres: "" })
    );
    let sql = AssertSqlSafe(sql);
    let ids: Vec<i64> = read!(store, query_scalar.fetch_all, sql, now.0, repeated.0);
    if ids.is_empty() {
        return Ok(Vec::new());
    }
    of_ids(store, &ids.into_iter().map(Id).collect::<Vec<_>>()).await
}

/// Alerts that wait for the digest of an import.
pub async fn for_digest(store: &Store) -> Result<Vec<AlertRow>> {
    read!(store, all, select("digest <> 0"))
}

/// When the last of them began to wait.
pub async fn digest_began(store: &Store) -> Result<Option<UtcMicros>> {
    let sql = "SELECT max(hushed_at) FROM alert WHERE digest <> 0";
    let at: Option<i64> = read!(store, query_scalar.fetch_one, sql);
    Ok(at.map(UtcMicros))
}

/// Alerts that fire, of gyros, by rules of which a station, a batch or an IMU can be the cause.
pub async fn excesses(store: &Store) -> Result<Vec<ExcessRow>> {
    read!(
        store,
        all,
        AssertSqlSafe(format!(
            "SELECT gyro, coefficient, rule, severity, coalesce(since, fired_at) AS since FROM alert WHERE {}",
            may_be_shared()
        ))
    )
}

/// Those of them that another alert explains, and those of gyros that one of these subjects may be the cause of: gyros
/// that they calibrated last, or hold, or that are among `gyros`, or whose newest calibration is not the one that their
/// alert tells of.
pub async fn explicable(store: &Store, by: &BTreeSet<AlertOf>, gyros: &[u32]) -> Result<Vec<AlertRow>> {
    let sql = select(&format!(
        "{} AND (inhibited_by IS NOT NULL OR alert.gyro IN {} OR alert.gyro IN (SELECT gyro FROM head WHERE station IN {})
                 OR alert.gyro IN (SELECT gyro FROM head WHERE imu IN {})
                 OR NOT EXISTS (SELECT 1 FROM head WHERE head.gyro = alert.gyro AND head.calibrated_at = alert.record_at))",
        may_be_shared(),
        store.readers.list("$1"),
        store.readers.list("$2"),
        store.readers.list("$3")
    ));
    let json = |numbers: &[u32]| serde_json::json!(numbers).to_string();
    let stations: Vec<u32> = by.iter().filter_map(|of| of.station()).collect();
    let imus: Vec<u32> = by.iter().filter_map(|of| of.imu()).collect();
    read!(store, all, sql, json(gyros), json(&stations), json(&imus))
}

fn may_be_shared() -> String {
    let rules = Rule::ALL.into_iter().filter(|rule| rule.can_be_shared());
    let rules: Vec<String> = rules.map(|rule| format!("'{}'", rule.name())).collect();
    format!("status = 'firing' AND alert.rule IN ({})", rules.join(", "))
}

/// Every alert, in the order in which they first fired: as many as there are troubled gyros, not records.
pub async fn all(store: &Store) -> Result<Vec<AlertRow>> {
    read!(store, all, select("true"))
}

/// Every alert of a station, a batch or an IMU that there has been: few.
pub async fn of_no_gyro(store: &Store) -> Result<Vec<AlertRow>> {
    read!(store, all, select(OF_NO_GYRO))
}

/// Alerts of gyros that this one explains.
pub async fn inhibited_by(store: &Store, by: Id) -> Result<Vec<AlertRow>> {
    read!(store, all, select("alert.inhibited_by = $1"), by.0)
}

/// Every alert of several gyros, in the order in which they first fired.
pub async fn of_gyros(store: &Store, gyros: &[u32]) -> Result<Vec<AlertRow>> {
    let sql = select(&format!("alert.gyro IN {} AND {OF_ITSELF}", store.readers.list("$1")));
    read!(store, all, sql, serde_json::json!(gyros).to_string())
}

/// The alerts of several gyros that fire, acknowledged or silenced as they may be, in the order in which they first
/// did.
pub async fn firing(store: &Store, gyros: &[u32]) -> Result<Vec<AlertRow>> {
    let sql = select(&format!("alert.gyro IN {} AND {OF_ITSELF} AND status <> 'resolved'", store.readers.list("$1")));
    read!(store, all, sql, serde_json::json!(gyros).to_string())
}

/// How many alerts fire, by severity; of a severity without any there is no entry.
pub async fn firing_by_severity(store: &Store) -> Result<Vec<(String, i64)>> {
    let sql = "SELECT severity, count(*) FROM alert WHERE status = 'firing' GROUP BY severity";
    Ok(read!(store, query_as.fetch_all, sql))
}

pub async fn get(store: &Store, id: Id) -> Result<Option<AlertRow>> {
    read!(store, first, select("alert.id = $1"), id.0)
}

/// Those of these alerts that there are, in the order in which they first fired.
pub async fn of_ids(store: &Store, ids: &[Id]) -> Result<Vec<AlertRow>> {
    let sql = select(&format!("alert.id IN {}", store.readers.list("$1")));
    read!(store, all, sql, list_of(ids))
}

/// The newest `limit` steps of an alert, oldest first.
pub async fn steps(store: &Store, alert: Id, limit: u32) -> Result<Vec<StepRow>> {
    let sql = StepRow::select("WHERE alert = $1 ORDER BY id DESC LIMIT $2");
    on!(store.readers, db => {
        let rows = sqlx::query(sql).bind(alert.0).bind(Whole(limit)).fetch_all(db).await?;
        rows.iter().rev().map(Columns::get_all).collect()
    })
}

/// The alerts that a hook has heard fire, as they were last told (JSON), each with the severity that it has heard.
pub async fn heard_firing(store: &Store, hook: Id) -> Result<Vec<(String, String)>> {
    let sql = "SELECT heard.severity, step.body FROM hook_heard AS heard JOIN alert_step AS step
               ON step.id = coalesce((SELECT max(id) FROM alert_step WHERE alert_step.alert = heard.alert AND told = 1),
                                     (SELECT max(id) FROM alert_step WHERE alert_step.alert = heard.alert))
               WHERE heard.hook = $1 ORDER BY heard.alert";
    Ok(read!(store, query_as.fetch_all, sql, hook.0))
}
