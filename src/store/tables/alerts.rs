//! Alerts, and the steps by which they came to be what they are.

use crate::core::alert_decision::{Alert, Hushed, Standing, Status, Told};
use crate::core::alert_filter::AlertFilter;
use crate::core::id::Id;
use crate::core::judge::{Coefficient, Rule, Severity};
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{AnyRow, LISTED, Sql, Whole, cell, each, insert, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

/// Who said so, why and when.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    pub by: String,
    pub reason: String,
    pub at: UtcMicros,
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

pub(crate) fn upsert(alerts: &[AlertRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for AlertRow { id, of, coefficient, rule, alert, acknowledged, silenced, muted, inhibited_by, finding } in alerts {
        let mut row = rows.row();
        row.integer(id.0)
            .optional_integer(of.gyro().or(of.batch()).map(i64::from))
            .text(coefficient.name())
            .text(rule.name())
            .text(alert.status.name())
            .text(alert.severity.name())
            .integer(alert.fired_at.0)
            .optional_integer(alert.resolved_at.map(|at| at.0))
            .integer(alert.record_at.0)
            .integer(i64::from(alert.within))
            .optional_integer(alert.told.map(|told| told.at.0))
            .optional_text(alert.told.map(|told| told.severity.name()));
        for remark in [acknowledged, silenced] {
            row.optional_text(remark.as_ref().map(|remark| remark.by.as_str()))
                .optional_text(remark.as_ref().map(|remark| remark.reason.as_str()))
                .optional_integer(remark.as_ref().map(|remark| remark.at.0));
        }
        row.optional_integer(alert.silenced_until.map(|until| until.0))
            .bytes(finding.as_bytes())
            .integer(alert.since.0)
            .optional_integer(alert.hushed.map(|hushed| hushed.at.0))
            .integer(i64::from(alert.hushed.is_some_and(|hushed| hushed.digest)))
            .optional_integer(muted.as_ref().map(|(silence, _)| silence.0))
            .optional_integer(alert.muted_until.map(|until| until.0))
            .optional_integer(of.station().map(i64::from))
            .optional_integer(inhibited_by.map(|id| id.0))
            .optional_integer(of.imu().map(i64::from));
    }
    batch.add(
        insert!(
            "alert (id, gyro, coefficient, rule, status, severity, fired_at, resolved_at, record_at, within,
             told_at, told_severity, acknowledged_by, acknowledged_reason, acknowledged_at,
             silenced_by, silenced_reason, silenced_at, silenced_until, finding, since, hushed_at, digest, muted_by, muted_until,
             station, inhibited_by, imu)",
            [int 0, int 1, text 2, text 3, text 4, text 5, int 6, int 7, int 8, int 9, int 10, text 11, text 12, text 13,
             int 14, text 15, text 16, int 17, int 18, words 19 20, int 21, int 22, int 23, int 24, int 25,
             int 26, int 27, int 28],
            "ON CONFLICT (id) DO UPDATE SET (status, severity, fired_at, resolved_at, record_at, within, told_at,
             told_severity, acknowledged_by, acknowledged_reason, acknowledged_at, silenced_by, silenced_reason,
             silenced_at, silenced_until, finding, since, hushed_at, digest, muted_by, muted_until, inhibited_by) =
            (excluded.status, excluded.severity, excluded.fired_at, excluded.resolved_at, excluded.record_at,
             excluded.within, excluded.told_at, excluded.told_severity, excluded.acknowledged_by,
             excluded.acknowledged_reason, excluded.acknowledged_at, excluded.silenced_by, excluded.silenced_reason,
             excluded.silenced_at, excluded.silenced_until, excluded.finding, excluded.since,
             excluded.hushed_at, excluded.digest, excluded.muted_by, excluded.muted_until, excluded.inhibited_by)"
        ),
        rows,
    );
}

pub(crate) fn insert_steps(steps: &[StepRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for step in steps {
        rows.row()
            .integer(step.id.0)
            .integer(step.alert.0)
            .integer(step.at.0)
            .text(&step.action)
            .integer(i64::from(step.told))
            .optional_text(step.author.as_deref())
            .optional_text(step.reason.as_deref())
            .bytes(step.body.as_bytes());
    }
    batch.add(
        insert!(
            "alert_step (id, alert, at, action, told, author, reason, body)",
            [int 0, int 1, int 2, text 3, int 4, text 5, text 6, words 7 8]
        ),
        rows,
    );
}

const COLUMNS: &str = "SELECT alert.id, gyro, alert.station, alert.imu, inhibited_by, coefficient, alert.rule, status, severity, fired_at, resolved_at, record_at, within, \
     told_at, told_severity, acknowledged_by, acknowledged_reason, acknowledged_at, \
     silenced_by, silenced_reason, silenced_at, silenced_until, finding, coalesce(since, fired_at) AS since, hushed_at, digest, \
     muted_by, muted_until, silence.author AS muted_author, silence.reason AS muted_reason, silence.at AS muted_at \
     FROM alert LEFT JOIN silence ON silence.id = alert.muted_by";

fn alert(row: &impl AnyRow) -> Result<AlertRow, StoreError> {
    let id = Id(row.cell("id")?);
    let damaged = |what: &str| StoreError::Damaged(format!("alert {id}: unknown {what}"));
    let text = |column: &str| row.cell::<String>(column);
    let instant = |column: &str| Ok::<_, sqlx::Error>(row.cell::<Option<i64>>(column)?.map(UtcMicros));
    let severity = |column: &str| {
        let name: Option<String> = row.cell(column)?;
        name.map(|name| Severity::from_name(&name).ok_or_else(|| damaged("severity"))).transpose()
    };
    let remark = |by: &str, reason: &str, at: &str| {
        let (by, reason): (Option<String>, Option<String>) = (row.cell(by)?, row.cell(reason)?);
        let known = by.zip(reason).zip(instant(at)?);
        Ok::<_, sqlx::Error>(known.map(|((by, reason), at)| Remark { by, reason, at }))
    };
    let told_at = instant("told_at")?;
    let digest = row.cell::<i64>("digest")? != 0;
    let muted_by: Option<i64> = row.cell("muted_by")?;
    let inhibited_by = row.cell::<Option<i64>>("inhibited_by")?.map(Id);
    let gyro: Option<Whole<u32>> = row.cell("gyro")?;
    let station: Option<Whole<u32>> = row.cell("station")?;
    let imu: Option<Whole<u32>> = row.cell("imu")?;
    let rule = Rule::from_name(&text("rule")?).ok_or_else(|| damaged("rule"))?;
    let of_gyro = if rule == Rule::BatchShift { AlertOf::Batch } else { AlertOf::Gyro };
    let of = gyro.map(|gyro| of_gyro(gyro.0)).or(station.map(|station| AlertOf::Station(station.0)));
    let of = of.or(imu.map(|imu| AlertOf::Imu(imu.0)));
    let acknowledged = remark("acknowledged_by", "acknowledged_reason", "acknowledged_at")?;
    Ok(AlertRow {
        id,
        of: of.ok_or_else(|| damaged("subject"))?,
        coefficient: Coefficient::from_name(&text("coefficient")?).ok_or_else(|| damaged("coefficient"))?,
        rule,
        alert: Alert {
            status: Status::from_name(&text("status")?).ok_or_else(|| damaged("status"))?,
            severity: severity("severity")?.ok_or_else(|| damaged("severity"))?,
            since: UtcMicros(row.cell("since")?),
            fired_at: UtcMicros(row.cell("fired_at")?),
            resolved_at: instant("resolved_at")?,
            record_at: UtcMicros(row.cell("record_at")?),
            within: row.cell::<Whole<u32>>("within")?.0,
            acknowledged: acknowledged.is_some(),
            silenced_until: instant("silenced_until")?,
            muted_until: instant("muted_until")?,
            inhibited: inhibited_by.is_some(),
            hushed: instant("hushed_at")?.map(|at| Hushed { at, digest }),
            told: told_at.zip(severity("told_severity")?).map(|(at, severity)| Told { at, severity }),
        },
        acknowledged,
        silenced: remark("silenced_by", "silenced_reason", "silenced_at")?,
        muted: muted_by.map(Id).zip(remark("muted_author", "muted_reason", "muted_at")?),
        inhibited_by,
        finding: text("finding")?,
    })
}

/// That it is no alert of the batch of its gyro.
const OF_ITSELF: &str = "alert.rule <> 'batch_shift'";

/// How an alert stands for whoever looks at it.
const STANDING: &str = "CASE WHEN alert.status = 'resolved' THEN 'resolved'
                             WHEN alert.silenced_until > $7 OR alert.muted_until > $7 THEN 'silenced'
                             WHEN alert.inhibited_by IS NOT NULL THEN 'inhibited'
                             WHEN alert.acknowledged_at IS NOT NULL THEN 'acknowledged'
                             ELSE 'firing' END";

/// What a filter lets through: seven parameters, see the macro `bound`. Each condition by itself, so that it finds its
/// index; one that is not asked for is no condition.
fn conditions(store: &Store, filter: &AlertFilter) -> String {
    let imu =
        store.readers.words(Sql { sqlite: "alert.finding->>'imu'", postgres: "CAST(alert.finding AS JSONB)->>'imu'" });
    let asked = [
        (filter.gyro.is_some(), format!("alert.gyro = $1 AND {OF_ITSELF}")),
        (filter.coefficient.is_some(), "alert.coefficient = $2".to_owned()),
        (filter.rule.is_some(), "alert.rule = $3".to_owned()),
        (filter.severity.is_some(), "alert.severity = $4".to_owned()),
        (filter.imu.is_some(), format!("{imu} = $5")),
        (filter.standing.is_some(), format!("$6 = {STANDING}")),
    ];
    let condition = |(place, (is_asked, words)): (usize, (bool, String))| match is_asked {
        true => words,
        false => format!("${} IS NULL", place + 1),
    };
    // The time is a parameter even where no standing is asked for.
    asked.into_iter().enumerate().map(condition).chain(["$7 = $7".to_owned()]).collect::<Vec<_>>().join(" AND ")
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
) -> Result<Vec<AlertRow>, StoreError> {
    let conditions = conditions(store, filter);
    let sql =
        sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE {conditions} AND alert.id < $8 ORDER BY alert.id DESC LIMIT $9"));
    on!(store.readers, db => bound!(sqlx::query(sql), filter, now)
        .bind(before.map_or(i64::MAX, |id| id.0))
        .bind(Whole(limit))
        .fetch_all(db)
        .await?.iter().map(alert).collect())
}

/// Gyros with alerts that a filter lets through: those that stand worst first, or with `newest`, those whose newest
/// alert is the newest; from place `skip` on, as many as `limit`.
pub async fn gyros_found(
    store: &Store,
    filter: &AlertFilter,
    now: UtcMicros,
    newest: bool,
    [skip, limit]: [usize; 2],
) -> Result<Vec<u32>, StoreError> {
    let conditions = conditions(store, filter);
    let order = match newest {
        true => "max(alert.id) DESC",
        false => "max(head.rank) DESC, max(head.load) DESC, max(head.serial)",
    };
    let sql = sqlx::AssertSqlSafe(format!(
        "SELECT alert.gyro FROM alert JOIN head ON head.gyro = alert.gyro WHERE {conditions} AND {OF_ITSELF}
         GROUP BY alert.gyro ORDER BY {order} LIMIT $8 OFFSET $9"
    ));
    let rows: Vec<Whole<u32>> = on!(store.readers, db => bound!(sqlx::query_scalar(sql), filter, now)
        .bind(i64::try_from(limit).unwrap_or(i64::MAX))
        .bind(i64::try_from(skip).unwrap_or(i64::MAX))
        .fetch_all(db)
        .await?);
    Ok(rows.into_iter().map(|Whole(gyro)| gyro).collect())
}

/// Alerts of some gyros that a filter lets through, in the order in which they first fired.
pub async fn found_of(
    store: &Store,
    filter: &AlertFilter,
    now: UtcMicros,
    gyros: &[u32],
) -> Result<Vec<AlertRow>, StoreError> {
    let conditions = conditions(store, filter);
    let those = store.readers.words(LISTED).replace("$1", "$8");
    let sql =
        sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE {conditions} AND alert.gyro IN ({those}) ORDER BY alert.id"));
    let gyros = serde_json::json!(gyros).to_string();
    on!(store.readers, db => bound!(sqlx::query(sql), filter, now)
        .bind(gyros)
        .fetch_all(db)
        .await?.iter().map(alert).collect())
}

/// How many alerts of how many gyros stand how, among those that a filter lets through.
pub async fn standings(
    store: &Store,
    filter: &AlertFilter,
    now: UtcMicros,
) -> Result<Vec<(Standing, [usize; 2])>, StoreError> {
    let conditions = conditions(store, filter);
    let sql = sqlx::AssertSqlSafe(format!(
        "SELECT {STANDING}, count(*), count(DISTINCT alert.gyro) FILTER (WHERE {OF_ITSELF}) FROM alert WHERE {conditions}
         GROUP BY 1"
    ));
    let rows: Vec<(String, i64, i64)> =
        on!(store.readers, db => bound!(sqlx::query_as(sql), filter, now).fetch_all(db).await?);
    let count = |count: i64| count.unsigned_abs() as usize;
    let known =
        |(name, alerts, gyros): (String, i64, i64)| Some((Standing::from_name(&name)?, [count(alerts), count(gyros)]));
    Ok(rows.into_iter().filter_map(known).collect())
}

/// Alerts that may change at `now` with the clock alone: of which somebody is to be told, that are silenced, or that were
/// told no later than `repeated`. Each part stands as its index has it.
pub async fn due(store: &Store, now: UtcMicros, repeated: UtcMicros) -> Result<Vec<AlertRow>, StoreError> {
    let sql = "SELECT id FROM alert WHERE status = 'firing' AND acknowledged_at IS NULL AND told_at <= $2
               UNION ALL SELECT id FROM alert WHERE status = 'firing' AND acknowledged_at IS NULL AND told_at > $1
               UNION ALL SELECT id FROM alert WHERE (silenced_until IS NOT NULL OR muted_until IS NOT NULL)
                   AND (silenced_until <= $1 OR muted_until <= $1)
               UNION ALL SELECT id FROM alert WHERE hushed_at IS NULL AND inhibited_by IS NULL AND CASE
                   WHEN status = 'firing' THEN told_at IS NULL OR severity <> told_severity ELSE told_at IS NOT NULL END";
    let ids: Vec<i64> =
        on!(store.readers, db => sqlx::query_scalar(sql).bind(now.0).bind(repeated.0).fetch_all(db).await?);
    if ids.is_empty() {
        return Ok(Vec::new());
    }
    of_ids(store, &ids.into_iter().map(Id).collect::<Vec<_>>()).await
}

/// Alerts that wait for the digest of an import.
pub async fn for_digest(store: &Store) -> Result<Vec<AlertRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE digest <> 0 ORDER BY alert.id"));
    on!(store.readers, db => each(sqlx::query(sql).fetch(db), alert).await)
}

/// When the last of them began to wait.
pub async fn digest_began(store: &Store) -> Result<Option<UtcMicros>, StoreError> {
    let sql = "SELECT max(hushed_at) FROM alert WHERE digest <> 0";
    let at: Option<i64> = on!(store.readers, db => sqlx::query_scalar(sql).fetch_one(db).await?);
    Ok(at.map(UtcMicros))
}

/// Alerts that fire by rules of which a station or an IMU can be the cause.
pub async fn firing_that_may_be_shared(store: &Store) -> Result<Vec<AlertRow>, StoreError> {
    let rules = Rule::ALL.into_iter().filter(|rule| rule.can_be_shared());
    let rules: Vec<String> = rules.map(|rule| format!("'{}'", rule.name())).collect();
    let sql = sqlx::AssertSqlSafe(format!(
        "{COLUMNS} WHERE status = 'firing' AND alert.rule IN ({}) ORDER BY alert.id",
        rules.join(", ")
    ));
    on!(store.readers, db => each(sqlx::query(sql).fetch(db), alert).await)
}

/// Every alert, in the order in which they first fired: as many as there are troubled gyros, not records.
pub async fn all(store: &Store) -> Result<Vec<AlertRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} ORDER BY alert.id"));
    on!(store.readers, db => each(sqlx::query(sql).fetch(db), alert).await)
}

/// Every alert of a station, a batch or an IMU that there has been: few.
pub async fn of_no_gyro(store: &Store) -> Result<Vec<AlertRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE alert.gyro IS NULL OR NOT {OF_ITSELF} ORDER BY alert.id"));
    on!(store.readers, db => sqlx::query(sql).fetch_all(db).await?.iter().map(alert).collect())
}

/// Alerts of gyros that this one explains.
pub async fn inhibited_by(store: &Store, by: Id) -> Result<Vec<AlertRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE alert.inhibited_by = $1 ORDER BY alert.id"));
    on!(store.readers, db => sqlx::query(sql).bind(by.0).fetch_all(db).await?.iter().map(alert).collect())
}

/// Every alert of several gyros, in the order in which they first fired.
pub async fn of_gyros(store: &Store, gyros: &[u32]) -> Result<Vec<AlertRow>, StoreError> {
    let those = store.readers.words(LISTED);
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE alert.gyro IN ({those}) AND {OF_ITSELF} ORDER BY alert.id"));
    let gyros = serde_json::json!(gyros).to_string();
    on!(store.readers, db => sqlx::query(sql).bind(gyros).fetch_all(db).await?.iter().map(alert).collect())
}

/// The alerts of several gyros that fire, acknowledged or silenced as they may be, in the order in which they first
/// did.
pub async fn firing(store: &Store, gyros: &[u32]) -> Result<Vec<AlertRow>, StoreError> {
    let those = store.readers.words(LISTED);
    let sql = sqlx::AssertSqlSafe(format!(
        "{COLUMNS} WHERE alert.gyro IN ({those}) AND {OF_ITSELF} AND status = $2 ORDER BY alert.id"
    ));
    let gyros = serde_json::json!(gyros).to_string();
    on!(store.readers, db => sqlx::query(sql)
        .bind(gyros)
        .bind(Status::Firing.name())
        .fetch_all(db)
        .await?.iter().map(alert).collect())
}

/// How many alerts fire, by severity; of a severity without any there is no entry.
pub async fn firing_by_severity(store: &Store) -> Result<Vec<(String, i64)>, StoreError> {
    let sql = "SELECT severity, count(*) FROM alert WHERE status = 'firing' GROUP BY severity";
    on!(store.readers, db => Ok(sqlx::query_as(sql).fetch_all(db).await?))
}

pub async fn get(store: &Store, id: Id) -> Result<Option<AlertRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE alert.id = $1"));
    on!(store.readers, db => sqlx::query(sql).bind(id.0).fetch_optional(db).await?.as_ref().map(alert).transpose())
}

/// Those of these alerts that there are, in the order in which they first fired.
pub async fn of_ids(store: &Store, ids: &[Id]) -> Result<Vec<AlertRow>, StoreError> {
    let those = store.readers.words(LISTED);
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE alert.id IN ({those}) ORDER BY alert.id"));
    let ids: Vec<i64> = ids.iter().map(|id| id.0).collect();
    let ids = serde_json::json!(ids).to_string();
    on!(store.readers, db => sqlx::query(sql).bind(ids).fetch_all(db).await?.iter().map(alert).collect())
}

/// The newest `limit` steps of an alert, oldest first.
pub async fn steps(store: &Store, alert: Id, limit: u32) -> Result<Vec<StepRow>, StoreError> {
    let sql = "SELECT id, alert, at, action, told <> 0, author, reason, body FROM alert_step
               WHERE alert = $1 ORDER BY id DESC LIMIT $2";
    let rows = on!(store.readers, db => sqlx::query_as(sql).bind(alert.0).bind(Whole(limit)).fetch_all(db).await?);
    Ok(rows.into_iter().rev().map(step).collect())
}

/// The alerts that a hook has heard fire, as they were last told (JSON), each with the severity that it has heard.
pub async fn heard_firing(store: &Store, hook: Id) -> Result<Vec<(String, String)>, StoreError> {
    let sql = "SELECT heard.severity, step.body FROM hook_heard AS heard JOIN alert_step AS step
               ON step.id = coalesce((SELECT max(id) FROM alert_step WHERE alert_step.alert = heard.alert AND told = 1),
                                     (SELECT max(id) FROM alert_step WHERE alert_step.alert = heard.alert))
               WHERE heard.hook = $1 ORDER BY heard.alert";
    Ok(on!(store.readers, db => sqlx::query_as(sql).bind(hook.0).fetch_all(db).await?))
}

type Step = (i64, i64, i64, String, bool, Option<String>, Option<String>, String);

fn step((id, alert, at, action, told, author, reason, body): Step) -> StepRow {
    StepRow { id: Id(id), alert: Id(alert), at: UtcMicros(at), action, told, author, reason, body }
}
