//! Reading the outbox: what is due, how a hook's queue stands, what became of each delivery.

use super::delivery::{AttemptRow, DeliveryRow, DueDelivery, Subject};
use crate::core::delivery::{DeliveryState, QueueState};
use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::db::{AnyRow, Readers, Sql, Whole, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

fn subject(row: &impl AnyRow) -> Result<Subject, sqlx::Error> {
    let (step, alert): (Option<i64>, Option<i64>) = (row.cell("step")?, row.cell("alert")?);
    Ok(match (step.zip(alert), row.cell::<Option<String>>("action")?) {
        (Some((step, alert)), _) => Subject::Step { step: Id(step), alert: Id(alert) },
        (None, Some(_)) => Subject::Many,
        (None, None) => Subject::Test,
    })
}

/// At most `limit` deliveries of a hook that are due, the longest due first.
///
/// A time beyond `horizon` was written by a clock gone wrong: what waits until then is due.
pub async fn due_of_hook(
    store: &Store,
    hook: Id,
    now: UtcMicros,
    horizon: UtcMicros,
    limit: u32,
) -> Result<Vec<DueDelivery>, StoreError> {
    let sql = "SELECT d.id, d.hook, d.step, d.alert, d.queued_at, d.attempts, d.first_attempt_at,
                      s.at, coalesce(d.action, s.action) AS action, s.body, d.digest
               FROM delivery AS d LEFT JOIN alert_step AS s ON s.id = d.step
               WHERE d.hook = $1 AND d.state = 'waiting' AND (d.due_at <= $2 OR d.due_at > $3)
               ORDER BY d.due_at, d.id LIMIT $4";
    on!(store.readers, db => {
        let query = sqlx::query(sql).bind(hook.0).bind(now.0).bind(horizon.0).bind(Whole(limit));
        let rows = query.fetch_all(db).await?;
        let mut found: Vec<DueDelivery> = rows.iter().map(|row| Ok(due(row)?)).collect::<Result<_, StoreError>>()?;
        for due in found.iter_mut().filter(|due| due.subject == Subject::Many) {
            due.content = sqlx::query_as(PARTS).bind(due.id.0).fetch_all(db).await?;
        }
        Ok(found)
    })
}

/// When the next delivery of a hook is due after `now`; none where nothing waits that is not due already.
pub async fn next_due(store: &Store, hook: Id, now: UtcMicros) -> Result<Option<UtcMicros>, StoreError> {
    let sql = "SELECT min(due_at) FROM delivery WHERE hook = $1 AND state = 'waiting' AND due_at > $2";
    let at: Option<i64> =
        on!(store.readers, db => sqlx::query_scalar(sql).bind(hook.0).bind(now.0).fetch_one(db).await?);
    Ok(at.map(UtcMicros))
}

const PARTS: &str = "SELECT part.action, coalesce(part.body, step.body)
                     FROM delivery_part AS part LEFT JOIN alert_step AS step ON step.id = part.step
                     WHERE part.delivery = $1 ORDER BY part.place";

fn due(row: &impl AnyRow) -> Result<DueDelivery, sqlx::Error> {
    let at: Option<i64> = row.cell("at")?;
    let (action, body): (Option<String>, Option<String>) = (row.cell("action")?, row.cell("body")?);
    Ok(DueDelivery {
        id: Id(row.cell("id")?),
        hook: Id(row.cell("hook")?),
        subject: subject(row)?,
        queued_at: UtcMicros(row.cell("queued_at")?),
        attempts: row.cell::<Whole<u32>>("attempts")?.0,
        first_attempt_at: row.cell::<Option<i64>>("first_attempt_at")?.map(UtcMicros),
        at: at.map(UtcMicros),
        content: action.zip(body).into_iter().collect(),
        digest: row.cell("digest")?,
    })
}

const COLUMNS: &str = "SELECT d.id, d.hook, d.step, d.alert, d.queued_at, d.state, d.due_at, d.finished_at,
                              coalesce(d.action, s.action) AS action,
                              coalesce(d.alert, (SELECT p.alert FROM delivery_part AS p WHERE p.delivery = d.id AND p.place = 0)) AS first
                       FROM delivery AS d LEFT JOIN alert_step AS s ON s.id = d.step";

pub async fn queue_state(store: &Store, hook: Id) -> Result<QueueState, StoreError> {
    let sql = "SELECT (SELECT count(*) FROM delivery WHERE hook = $1 AND state IN ('behind', 'waiting')),
                      (SELECT count(*) FROM delivery WHERE hook = $1 AND state = 'dead'),
                      (SELECT min(queued_at) FROM delivery WHERE hook = $1 AND state IN ('behind', 'waiting'))";
    let (open, dead, oldest): (i64, i64, Option<i64>) =
        on!(store.readers, db => sqlx::query_as(sql).bind(hook.0).fetch_one(db).await?);
    Ok(QueueState { open, dead, oldest_open: oldest.map(UtcMicros) })
}

/// The queues of all hooks together. A queue whose hook is disabled ages by intent, so its age does not count.
pub async fn outbox_totals(store: &Store) -> Result<QueueState, StoreError> {
    let sql = "SELECT (SELECT count(*) FROM delivery WHERE state IN ('behind', 'waiting')),
                      (SELECT count(*) FROM delivery WHERE state = 'dead'),
                      (SELECT min((SELECT min(queued_at) FROM delivery
                                   WHERE delivery.hook = hook.id AND state IN ('behind', 'waiting')))
                       FROM hook WHERE deleted_at IS NULL AND enabled = 1)";
    let (open, dead, oldest): (i64, i64, Option<i64>) =
        on!(store.readers, db => sqlx::query_as(sql).fetch_one(db).await?);
    Ok(QueueState { open, dead, oldest_open: oldest.map(UtcMicros) })
}

/// Deliveries of a hook older than `before`, newest first, with their attempts.
pub async fn of_hook(
    store: &Store,
    hook: Id,
    state: Option<DeliveryState>,
    before: Option<Id>,
    limit: u32,
) -> Result<Vec<DeliveryRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!(
        "{COLUMNS} WHERE d.hook = $1 AND d.id < $2 AND ($3 IS NULL OR d.state = $3) ORDER BY d.id DESC LIMIT $4"
    ));
    let (before, state) = (before.map_or(i64::MAX, |id| id.0), state.map(DeliveryState::name));
    let read = async {
        on!(store.readers, db => {
            let mut snapshot = db.begin_with(store.readers.words(SNAPSHOT)).await?;
            let query = sqlx::query(sql).bind(hook.0).bind(before).bind(state).bind(Whole(limit));
            let rows = query.fetch_all(&mut *snapshot).await?;
            let mut deliveries: Vec<DeliveryRow> = rows.iter().map(delivery).collect::<Result<_, _>>()?;
            for delivery in &mut deliveries {
                let made = sqlx::query_as(ATTEMPTS).bind(delivery.id.0).fetch_all(&mut *snapshot).await?;
                delivery.attempts = attempts(delivery.id, made);
            }
            Ok(deliveries)
        })
    };
    store.readers.within_limit(read).await
}

/// A delivery with its attempts, both as of one moment: an attempt that is written meanwhile is in neither.
pub async fn get(store: &Store, id: Id) -> Result<Option<DeliveryRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE d.id = $1"));
    let read = async {
        on!(store.readers, db => {
            let mut snapshot = db.begin_with(store.readers.words(SNAPSHOT)).await?;
            let query = sqlx::query(sql).bind(id.0);
            let Some(row) = query.fetch_optional(&mut *snapshot).await? else { return Ok(None) };
            let made = sqlx::query_as(ATTEMPTS).bind(id.0).fetch_all(&mut *snapshot).await?;
            Ok(Some(DeliveryRow { attempts: attempts(id, made), ..delivery(&row)? }))
        })
    };
    store.readers.within_limit(read).await
}

/// What several queries see is of one moment.
const SNAPSHOT: Sql = Sql { sqlite: "BEGIN", postgres: "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY" };

const ATTEMPTS: &str =
    "SELECT id, at, status, detail, took_us, answer FROM delivery_attempt WHERE delivery = $1 ORDER BY id";

type Attempt = (i64, i64, Option<Whole<u16>>, String, i64, Option<String>);

fn attempts(delivery: Id, made: Vec<Attempt>) -> Vec<AttemptRow> {
    let attempt = |(id, at, status, detail, took_us, answer): Attempt| AttemptRow {
        id: Id(id),
        delivery,
        at: UtcMicros(at),
        status: status.map(|status| status.0),
        detail,
        answer,
        took_us,
    };
    made.into_iter().map(attempt).collect()
}

fn delivery(row: &impl AnyRow) -> Result<DeliveryRow, StoreError> {
    let id = Id(row.cell("id")?);
    let state: String = row.cell("state")?;
    Ok(DeliveryRow {
        id,
        hook: Id(row.cell("hook")?),
        subject: subject(row)?,
        action: row.cell("action")?,
        alert: row.cell::<Option<i64>>("first")?.map(Id),
        queued_at: UtcMicros(row.cell("queued_at")?),
        state: DeliveryState::from_name(&state)
            .ok_or_else(|| StoreError::Damaged(format!("delivery {id}: unknown state")))?,
        due_at: UtcMicros(row.cell("due_at")?),
        finished_at: row.cell::<Option<i64>>("finished_at")?.map(UtcMicros),
        attempts: Vec::new(),
    })
}

/// The gyros of whose alerts these deliveries tell.
pub async fn gyros_of(store: &Store, deliveries: &[Id]) -> Result<Vec<u32>, StoreError> {
    let sql = store.readers.words(Sql {
        sqlite: "SELECT DISTINCT alert.gyro FROM json_each($1) AS j JOIN alert ON alert.id IN
                     (SELECT alert FROM delivery WHERE id = j.value UNION ALL SELECT alert FROM delivery_part WHERE delivery = j.value)
                 WHERE alert.gyro IS NOT NULL",
        postgres: "SELECT DISTINCT alert.gyro FROM alert WHERE alert.gyro IS NOT NULL AND alert.id IN
                       (SELECT delivery.alert FROM delivery WHERE delivery.id = ANY(CAST($1 AS BIGINT[])) UNION ALL
                        SELECT delivery_part.alert FROM delivery_part WHERE delivery_part.delivery = ANY(CAST($1 AS BIGINT[])))",
    });
    let ids: Vec<String> = deliveries.iter().map(|id| id.0.to_string()).collect();
    let array = match &store.readers {
        Readers::Sqlite(_) => format!("[{}]", ids.join(",")),
        Readers::Postgres(_) => format!("{{{}}}", ids.join(",")),
    };
    let found: Vec<Whole<u32>> = on!(store.readers, db => sqlx::query_scalar(sql).bind(array).fetch_all(db).await?);
    Ok(found.into_iter().map(|gyro| gyro.0).collect())
}
