//! Alerts, and the steps by which they came to be what they are.

use super::*;
use crate::core::alert_decision::{Alert, AlertState, LastNotification, Suppressed};
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

part! {
    Remark { by, reason, at }
}

impl Part for Option<Remark> {
    fn put(&self, row: &mut Row<'_>) {
        let said = self.as_ref();
        row.put(&said.map(|remark| remark.by.clone())).put(&said.map(|remark| remark.reason.clone()));
        row.put(&said.map(|remark| remark.at));
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        let (by, reason, at): (Option<_>, Option<_>, Option<_>) = found.part()?;
        Ok(by.zip(reason).zip(at).map(|((by, reason), at)| Remark { by, reason, at }))
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
    /// The alert that explains it.
    pub inhibited_by: Option<Id>,
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
    ExcessRow in "alert" { gyro, coefficient, rule, severity, since, inhibited_by }
}

columns! {
    StepRow in "alert_step" { id, alert, at, action, told, author, reason, body }
}

impl Columns for AlertRow {
    const TABLE: &'static str = "alert";
    const COLUMNS: &'static str = "id, rule, gyro, station, imu, coefficient, status, severity, since, fired_at, \
        resolved_at, record_at, within, told_at, told_severity, acknowledged_by, acknowledged_reason, acknowledged_at, \
        silenced_by, silenced_reason, silenced_at, silenced_until, finding, hushed_at, digest, muted_by, muted_until, \
        inhibited_by";
}

impl Part for AlertRow {
    fn put(&self, row: &mut Row<'_>) {
        let Self { id, of, coefficient, rule, alert, acknowledged, silenced, muted, inhibited_by, finding } = self;
        row.put(id).put(rule).put(&of.gyro().or(of.batch())).put(&of.station()).put(&of.imu()).put(coefficient);
        row.put(&alert.status).put(&alert.severity).put(&alert.since).put(&alert.fired_at).put(&alert.resolved_at);
        row.put(&alert.record_at).put(&alert.within);
        row.put(&alert.last_notification.map(|told| told.at)).put(&alert.last_notification.map(|told| told.severity));
        row.put(acknowledged).put(silenced).put(&alert.silenced_until).words(finding);
        row.put(&alert.suppressed.map(|suppressed| suppressed.at))
            .put(&alert.suppressed.is_some_and(|suppressed| suppressed.digest));
        row.put(&muted.as_ref().map(|(silence, _)| *silence)).put(&alert.muted_until).put(inhibited_by);
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        alert(found).map_err(|error| error.of(Self::TABLE))
    }
}

pub(crate) fn upsert(alerts: &[AlertRow], batch: &mut Batch) {
    batch.enter(alerts, OnConflict::SetAllBut("id", &["gyro", "station", "imu", "coefficient", "rule"]));
}

/// Alerts, each with the silence that mutes it, in the order in which they first fired.
fn select(conditions: &str) -> AssertSqlSafe<String> {
    AssertSqlSafe(format!("{SELECT} WHERE {conditions} ORDER BY alert.id"))
}

const SELECT: &str = "SELECT alert.id, alert.rule, gyro, alert.station, alert.imu, coefficient, status, severity, \
     coalesce(since, fired_at) AS since, fired_at, resolved_at, record_at, within, told_at, told_severity, \
     acknowledged_by, acknowledged_reason, acknowledged_at, silenced_by, silenced_reason, silenced_at, silenced_until, \
     finding, hushed_at, digest, muted_by, muted_until, inhibited_by, \
     silence.author AS muted_author, silence.reason AS muted_reason, silence.at AS muted_at \
     FROM alert LEFT JOIN silence ON silence.id = alert.muted_by";

/// Of what [`SELECT`] finds.
fn alert(found: &mut Found<'_, impl AnyRow>) -> Result<AlertRow> {
    let (id, rule) = found.part()?;
    let of = match found.part::<[Option<u32>; 3]>()? {
        [Some(gyro), ..] if rule == Rule::BatchShift => AlertOf::Batch(gyro),
        [Some(gyro), ..] => AlertOf::Gyro(gyro),
        [_, Some(station), _] => AlertOf::Station(station),
        [.., Some(imu)] => AlertOf::Imu(imu),
        [None, None, None] => return Err(StoreError::damaged("unknown subject")),
    };
    let (coefficient, status, severity) = found.part()?;
    let ([since, fired_at], resolved_at, record_at, within) = found.part()?;
    let (told_at, told_severity): (Option<UtcMicros>, Option<Severity>) = found.part()?;
    let (acknowledged, silenced, silenced_until): (Option<Remark>, _, _) = found.part()?;
    let (finding, hushed_at, digest): (_, Option<UtcMicros>, _) = found.part()?;
    let (muted_by, muted_until): (Option<Id>, _) = found.part()?;
    let (inhibited_by, muted): (Option<Id>, Option<Remark>) = found.part()?;
    let alert = Alert {
        status,
        severity,
        since,
        fired_at,
        resolved_at,
        record_at,
        within,
        acknowledged: acknowledged.is_some(),
        silenced_until,
        muted_until,
        inhibited: inhibited_by.is_some(),
        suppressed: hushed_at.map(|at| Suppressed { at, digest }),
        last_notification: told_at.zip(told_severity).map(|(at, severity)| LastNotification { at, severity }),
    };
    let muted = muted_by.zip(muted);
    Ok(AlertRow { id, of, coefficient, rule, alert, acknowledged, silenced, muted, inhibited_by, finding })
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

/// What a filter lets through: seven parameters, see the macro `filtered`.
fn conditions(store: &Store, filter: &AlertFilter, lookup: Lookup) -> String {
    let imu =
        store.readers.words(Sql { sqlite: "alert.finding->>'imu'", postgres: "CAST(alert.finding AS JSONB)->>'imu'" });
    // Follows from the standing.
    let status = match filter.standing {
        Some(AlertState::Resolved) => "alert.status = 'resolved'",
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
    where_conditions(1, conditions) + " AND $7 = $7"
}

macro_rules! filtered {
    ($store:expr, $rows:ident, $sql:expr, $filter:expr, $now:expr $(, $bound:expr)* $(,)?) => {{
        let AlertFilter { gyro, coefficient, rule, severity, imu, standing } = $filter;
        let imu = imu.as_deref();
        read!($store, $rows, $sql, *gyro, *coefficient, *rule, *severity, imu, *standing, $now $(, $bound)*)
    }};
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
    filtered!(store, all, sql, filter, now, before.map_or(i64::MAX, |id| id.0), limit)
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
    let found: i64 = filtered!(store, one, few, filter, now)?;
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
    filtered!(store, all, sql, filter, now, limit, skip)
}

/// Alerts below which their gyros are looked up and sorted.
const FEW: i64 = if cfg!(test) { 60 } else { 4000 };

/// Alerts of some gyros that a filter lets through, in the order in which they first fired.
pub async fn found_of(store: &Store, filter: &AlertFilter, now: UtcMicros, gyros: &[u32]) -> Result<Vec<AlertRow>> {
    let conditions = conditions(store, filter, Lookup::Other);
    let sql = select(&format!("{conditions} AND alert.gyro IN {}", store.readers.list("$8")));
    filtered!(store, all, sql, filter, now, gyros)
}

/// How many alerts stand how, among those that a filter lets through. Most of those that fire are handled by nobody:
/// they are what is left.
pub async fn counts_by_state(
    store: &Store,
    filter: &AlertFilter,
    now: UtcMicros,
) -> Result<HashMap<AlertState, usize>> {
    let conditions = conditions(store, filter, Lookup::Status);
    let by_status = AssertSqlSafe(format!("SELECT status, count(*) FROM alert WHERE {conditions} GROUP BY status"));
    let handled = AssertSqlSafe(format!(
        "SELECT {STANDING}, count(*) FROM alert WHERE {conditions} AND status = 'firing'
             AND (silenced_until > $7 OR muted_until > $7 OR inhibited_by IS NOT NULL OR acknowledged_at IS NOT NULL)
         GROUP BY 1"
    ));
    let mut counts: HashMap<AlertState, usize> = HashMap::new();
    for sql in [by_status, handled] {
        let rows: Vec<(AlertState, usize)> = filtered!(store, all, sql, filter, now)?;
        if let Some(firing) = counts.get_mut(&AlertState::Firing) {
            *firing = firing.saturating_sub(rows.iter().map(|(_, count)| count).sum());
        }
        counts.extend(rows);
    }
    Ok(counts)
}

/// Another one after every change of an alert.
pub async fn version(store: &Store) -> Result<[i64; 2]> {
    let sqlite = "SELECT rows, sum FROM checksum WHERE name = 'alert'";
    read!(store, one, store.readers.words(Sql { sqlite, postgres: STAMPS }))
}

/// Until when the clock alone changes how no alert stands.
pub async fn same_until(store: &Store, now: UtcMicros) -> Result<UtcMicros> {
    let sql = "SELECT min(silenced_until) FROM alert
               WHERE (silenced_until IS NOT NULL OR muted_until IS NOT NULL) AND silenced_until > $1
               UNION ALL SELECT min(muted_until) FROM alert
               WHERE (silenced_until IS NOT NULL OR muted_until IS NOT NULL) AND muted_until > $1";
    let ends: Vec<Option<i64>> = read!(store, all, sql, now)?;
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
    let ids: Vec<Id> = read!(store, all, AssertSqlSafe(sql), now, repeated)?;
    if ids.is_empty() { Ok(Vec::new()) } else { of_ids(store, &ids).await }
}

/// Alerts that wait for the digest of an import.
pub async fn for_digest(store: &Store) -> Result<Vec<AlertRow>> {
    read!(store, all, select("digest <> 0"))
}

/// When the last of them began to wait.
pub async fn digest_began(store: &Store) -> Result<Option<UtcMicros>> {
    let sql = "SELECT max(hushed_at) FROM alert WHERE digest <> 0";
    read!(store, one, sql)
}

/// Alerts that fire, of gyros, by rules of which a station, a batch or an IMU can be the cause.
pub async fn excesses(store: &Store) -> Result<Vec<ExcessRow>> {
    read!(
        store,
        all,
        AssertSqlSafe(format!(
            "SELECT gyro, coefficient, rule, severity, coalesce(since, fired_at) AS since, inhibited_by
             FROM alert WHERE {}",
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
    let stations: Vec<u32> = by.iter().filter_map(|of| of.station()).collect();
    let imus: Vec<u32> = by.iter().filter_map(|of| of.imu()).collect();
    read!(store, all, sql, gyros, &stations, &imus)
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
    read!(store, all, select("alert.inhibited_by = $1"), by)
}

/// Every alert of several gyros, in the order in which they first fired.
pub async fn of_gyros(store: &Store, gyros: &[u32]) -> Result<Vec<AlertRow>> {
    let sql = select(&format!("alert.gyro IN {} AND {OF_ITSELF}", store.readers.list("$1")));
    read!(store, all, sql, gyros)
}

/// The alerts of several gyros that fire, acknowledged or silenced as they may be, in the order in which they first
/// did.
pub async fn firing(store: &Store, gyros: &[u32]) -> Result<Vec<AlertRow>> {
    let sql = select(&format!("alert.gyro IN {} AND {OF_ITSELF} AND status <> 'resolved'", store.readers.list("$1")));
    read!(store, all, sql, gyros)
}

/// How many alerts fire that no other explains, by severity; of a severity without any there is no entry.
pub async fn firing_by_severity(store: &Store) -> Result<Vec<(Severity, u64)>> {
    let sql = "SELECT severity, count(*) FROM alert WHERE status = 'firing' AND inhibited_by IS NULL GROUP BY severity";
    read!(store, all, sql)
}

pub async fn get(store: &Store, id: Id) -> Result<Option<AlertRow>> {
    read!(store, first, select("alert.id = $1"), id)
}

/// Those of these alerts that there are, in the order in which they first fired.
pub async fn of_ids(store: &Store, ids: &[Id]) -> Result<Vec<AlertRow>> {
    let sql = select(&format!("alert.id IN {}", store.readers.list("$1")));
    read!(store, all, sql, ids)
}

/// The newest `limit` steps of an alert, oldest first.
pub async fn steps(store: &Store, alert: Id, limit: u32) -> Result<Vec<StepRow>> {
    let sql = StepRow::select("WHERE alert = $1 ORDER BY id DESC LIMIT $2");
    let mut steps: Vec<StepRow> = read!(store, all, sql, alert, limit)?;
    steps.reverse();
    Ok(steps)
}

/// The alerts that a hook has heard fire, as they were last told (JSON), each with the severity that it has heard.
pub async fn heard_firing(store: &Store, hook: Id) -> Result<Vec<(String, String)>> {
    let sql = "SELECT heard.severity, step.body FROM hook_heard AS heard JOIN alert_step AS step
               ON step.id = coalesce((SELECT max(id) FROM alert_step WHERE alert_step.alert = heard.alert AND told = 1),
                                     (SELECT max(id) FROM alert_step WHERE alert_step.alert = heard.alert))
               WHERE heard.hook = $1 ORDER BY heard.alert";
    read!(store, all, sql, hook)
}
