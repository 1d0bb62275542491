//! Reading the outbox: what is due, how a hook's queue stands, what became of each delivery.

use sqlx::Row as _;
use sqlx::sqlite::{SqliteConnection, SqliteRow};

use super::delivery::{AttemptRow, DeliveryRow, DeliveryState, DueDelivery, QueueState, Subject};
use super::error::StoreError;
use super::id::Id;
use super::open::Store;
use crate::core::time::UtcMicros;

fn subject(row: &SqliteRow) -> Result<Subject, sqlx::Error> {
    let (step, alert): (Option<i64>, Option<i64>) = (row.try_get("step")?, row.try_get("alert")?);
    Ok(step.zip(alert).map_or(Subject::Test, |(step, alert)| Subject::Step { step: Id(step), alert: Id(alert) }))
}

impl Store {
    /// At most `limit` deliveries of a hook that are due, the longest due first.
    ///
    /// A time beyond `horizon` was written by a clock gone wrong: what waits until then is due.
    pub async fn due_deliveries(
        &self,
        hook: Id,
        now: UtcMicros,
        horizon: UtcMicros,
        limit: u32,
    ) -> Result<Vec<DueDelivery>, StoreError> {
        let sql = "SELECT d.id, d.hook, d.step, d.alert, d.queued_at, d.attempts, d.first_attempt_at,
                          s.at, s.action, s.body
                   FROM delivery AS d LEFT JOIN alert_step AS s ON s.id = d.step
                   WHERE d.hook = $1 AND d.state = 'waiting' AND (d.due_at <= $2 OR d.due_at > $3)
                   ORDER BY d.due_at, d.id LIMIT $4";
        let rows =
            sqlx::query(sql).bind(hook.0).bind(now.0).bind(horizon.0).bind(limit).fetch_all(&self.readers).await?;
        rows.iter().map(|row| Ok(due(row)?)).collect()
    }

    /// When the next delivery of a hook is due after `now`; none where nothing waits that is not due already.
    pub async fn next_due(&self, hook: Id, now: UtcMicros) -> Result<Option<UtcMicros>, StoreError> {
        let sql = "SELECT min(due_at) FROM delivery WHERE hook = $1 AND state = 'waiting' AND due_at > $2";
        let at: Option<i64> = sqlx::query_scalar(sql).bind(hook.0).bind(now.0).fetch_one(&self.readers).await?;
        Ok(at.map(UtcMicros))
    }
}

fn due(row: &SqliteRow) -> Result<DueDelivery, sqlx::Error> {
    let at: Option<i64> = row.try_get("at")?;
    let (action, body): (Option<String>, Option<String>) = (row.try_get("action")?, row.try_get("body")?);
    Ok(DueDelivery {
        id: Id(row.try_get("id")?),
        hook: Id(row.try_get("hook")?),
        subject: subject(row)?,
        queued_at: UtcMicros(row.try_get("queued_at")?),
        attempts: row.try_get("attempts")?,
        first_attempt_at: row.try_get::<Option<i64>, _>("first_attempt_at")?.map(UtcMicros),
        content: at.zip(action).zip(body).map(|((at, action), body)| (UtcMicros(at), action, body)),
    })
}

const COLUMNS: &str = "SELECT d.id, d.hook, d.step, d.alert, d.queued_at, d.state, d.due_at, d.finished_at, s.action
                       FROM delivery AS d LEFT JOIN alert_step AS s ON s.id = d.step";

impl Store {
    pub async fn queue_state(&self, hook: Id) -> Result<QueueState, StoreError> {
        let sql = "SELECT (SELECT count(*) FROM delivery WHERE hook = $1 AND state IN ('behind', 'waiting')),
                          (SELECT count(*) FROM delivery WHERE hook = $1 AND state = 'dead'),
                          (SELECT min(queued_at) FROM delivery WHERE hook = $1 AND state IN ('behind', 'waiting'))";
        let (open, dead, oldest): (i64, i64, Option<i64>) =
            sqlx::query_as(sql).bind(hook.0).fetch_one(&self.readers).await?;
        Ok(QueueState { open, dead, oldest_open: oldest.map(UtcMicros) })
    }

    /// The queues of all hooks together. A queue whose hook is disabled ages by intent, so its age does not count.
    pub async fn outbox_totals(&self) -> Result<QueueState, StoreError> {
        let sql = "SELECT (SELECT count(*) FROM delivery WHERE state IN ('behind', 'waiting')),
                          (SELECT count(*) FROM delivery WHERE state = 'dead'),
                          (SELECT min((SELECT min(queued_at) FROM delivery
                                       WHERE delivery.hook = hook.id AND state IN ('behind', 'waiting')))
                           FROM hook WHERE deleted_at IS NULL AND enabled = 1)";
        let (open, dead, oldest): (i64, i64, Option<i64>) = sqlx::query_as(sql).fetch_one(&self.readers).await?;
        Ok(QueueState { open, dead, oldest_open: oldest.map(UtcMicros) })
    }

    /// Deliveries of a hook older than `before`, newest first, with their attempts.
    pub async fn deliveries(
        &self,
        hook: Id,
        state: Option<DeliveryState>,
        before: Option<Id>,
        limit: u32,
    ) -> Result<Vec<DeliveryRow>, StoreError> {
        let sql = sqlx::AssertSqlSafe(format!(
            "{COLUMNS} WHERE d.hook = $1 AND d.id < $2 AND ($3 IS NULL OR d.state = $3) ORDER BY d.id DESC LIMIT $4"
        ));
        let mut snapshot = self.readers.begin().await?;
        let rows = sqlx::query(sql)
            .bind(hook.0)
            .bind(before.map_or(i64::MAX, |id| id.0))
            .bind(state.map(DeliveryState::name))
            .bind(limit)
            .fetch_all(&mut *snapshot)
            .await?;
        let mut deliveries: Vec<DeliveryRow> = rows.iter().map(delivery).collect::<Result<_, _>>()?;
        for delivery in &mut deliveries {
            delivery.attempts = attempts(&mut snapshot, delivery.id).await?;
        }
        Ok(deliveries)
    }

    /// A delivery with its attempts, both as of one moment: an attempt that is written meanwhile is in neither.
    pub async fn delivery(&self, id: Id) -> Result<Option<DeliveryRow>, StoreError> {
        let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE d.id = $1"));
        let mut snapshot = self.readers.begin().await?;
        let Some(row) = sqlx::query(sql).bind(id.0).fetch_optional(&mut *snapshot).await? else { return Ok(None) };
        Ok(Some(DeliveryRow { attempts: attempts(&mut snapshot, id).await?, ..delivery(&row)? }))
    }
}

async fn attempts(snapshot: &mut SqliteConnection, delivery: Id) -> Result<Vec<AttemptRow>, StoreError> {
    let sql = "SELECT id, at, status, detail, took_us FROM delivery_attempt WHERE delivery = $1 ORDER BY id";
    let rows: Vec<(i64, i64, Option<u16>, String, i64)> =
        sqlx::query_as(sql).bind(delivery.0).fetch_all(snapshot).await?;
    let attempt = |(id, at, status, detail, took_us)| AttemptRow {
        id: Id(id),
        delivery,
        at: UtcMicros(at),
        status,
        detail,
        took_us,
    };
    Ok(rows.into_iter().map(attempt).collect())
}

fn delivery(row: &SqliteRow) -> Result<DeliveryRow, StoreError> {
    let id = Id(row.try_get("id")?);
    let state: String = row.try_get("state")?;
    Ok(DeliveryRow {
        id,
        hook: Id(row.try_get("hook")?),
        subject: subject(row)?,
        action: row.try_get("action")?,
        queued_at: UtcMicros(row.try_get("queued_at")?),
        state: DeliveryState::from_name(&state)
            .ok_or_else(|| StoreError::Damaged(format!("delivery {id}: unknown state")))?,
        due_at: UtcMicros(row.try_get("due_at")?),
        finished_at: row.try_get::<Option<i64>, _>("finished_at")?.map(UtcMicros),
        attempts: Vec::new(),
    })
}
