//! Reading the outbox: what is due, how a hook's queue stands, what became of each delivery.

use super::*;
use crate::core::delivery::{DeliveryState, QueueState};
use crate::store::{AttemptRow, DeliveryRow, DeliverySubject, DueDelivery};

/// Of the step and the alert that a delivery tells of, if it is one, and of whether it `tells` of any.
fn subject([step, alert]: [Option<Id>; 2], tells: bool) -> DeliverySubject {
    match step.zip(alert) {
        Some((step, alert)) => DeliverySubject::Step { step, alert },
        None if tells => DeliverySubject::Many,
        None => DeliverySubject::Test,
    }
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
) -> Result<Vec<DueDelivery>> {
    let sql = "SELECT d.id, d.hook, d.step, d.alert, d.queued_at, d.attempts, d.first_attempt_at,
                      s.at, coalesce(d.action, s.action), s.body, d.digest
               FROM delivery AS d LEFT JOIN alert_step AS s ON s.id = d.step
               WHERE d.hook = $1 AND d.state = 'waiting' AND (d.due_at <= $2 OR d.due_at > $3)
               ORDER BY d.due_at, d.id LIMIT $4";
    on!(store.readers, db => {
        let query = sqlx::query(sql).bind(hook.0).bind(now.0).bind(horizon.0).bind(limit.bound());
        let mut found: Vec<DueDelivery> = each(query.fetch(db)).await?.into_iter().map(due).collect();
        for due in found.iter_mut().filter(|due| due.subject == DeliverySubject::Many) {
            due.content = sqlx::query_as(PARTS).bind(due.id.0).fetch_all(db).await?;
        }
        Ok(found)
    })
}

/// When the next delivery of a hook is due after `now`; none where nothing waits that is not due already.
pub async fn next_due(store: &Store, hook: Id, now: UtcMicros) -> Result<Option<UtcMicros>> {
    let sql = "SELECT min(due_at) FROM delivery WHERE hook = $1 AND state = 'waiting' AND due_at > $2";
    read!(store, one, sql, hook, now)
}

const PARTS: &str = "SELECT part.action, coalesce(part.body, step.body)
                     FROM delivery_part AS part LEFT JOIN alert_step AS step ON step.id = part.step
                     WHERE part.delivery = $1 ORDER BY part.place";

type Due = ((Id, Id, [Option<Id>; 2]), (UtcMicros, u32, Option<UtcMicros>, Option<UtcMicros>), [Option<String>; 3]);

fn due(((id, hook, of), (queued_at, attempts, first_attempt_at, at), [action, body, digest]): Due) -> DueDelivery {
    let (subject, content) = (subject(of, action.is_some()), action.zip(body).into_iter().collect());
    DueDelivery { id, hook, subject, queued_at, attempts, first_attempt_at, at, content, digest }
}

const COLUMNS: &str = "SELECT d.id, d.hook, d.step, d.alert, d.queued_at, d.state, d.due_at, d.finished_at,
                              coalesce(d.action, s.action),
                              coalesce(d.alert, (SELECT p.alert FROM delivery_part AS p
                                                WHERE p.delivery = d.id AND p.place = 0))
                       FROM delivery AS d LEFT JOIN alert_step AS s ON s.id = d.step";

part! {
    QueueState { open, dead, oldest_open }
}

pub async fn queue_state(store: &Store, hook: Id) -> Result<QueueState> {
    let sql = "SELECT (SELECT count(*) FROM delivery WHERE hook = $1 AND state IN ('behind', 'waiting')),
                      (SELECT count(*) FROM delivery WHERE hook = $1 AND state = 'dead'),
                      (SELECT min(queued_at) FROM delivery WHERE hook = $1 AND state IN ('behind', 'waiting'))";
    read!(store, one, sql, hook)
}

/// The queues of all hooks together. A queue whose hook is disabled ages by intent, so its age does not count.
pub async fn outbox_totals(store: &Store) -> Result<QueueState> {
    let sql = "SELECT (SELECT count(*) FROM delivery WHERE state IN ('behind', 'waiting')),
                      (SELECT count(*) FROM delivery WHERE state = 'dead'),
                      (SELECT min((SELECT min(queued_at) FROM delivery
                                   WHERE delivery.hook = hook.id AND state IN ('behind', 'waiting')))
                       FROM hook WHERE deleted_at IS NULL AND enabled = 1)";
    read!(store, one, sql)
}

/// Deliveries of a hook older than `before`, newest first, with their attempts.
pub async fn of_hook(
    store: &Store,
    hook: Id,
    state: Option<DeliveryState>,
    before: Option<Id>,
    limit: u32,
) -> Result<Vec<DeliveryRow>> {
    let sql = AssertSqlSafe(format!(
        "{COLUMNS} WHERE d.hook = $1 AND d.id < $2 AND ($3 IS NULL OR d.state = $3) ORDER BY d.id DESC LIMIT $4"
    ));
    let (before, state) = (before.map_or(i64::MAX, |id| id.0), state.map(DeliveryState::name));
    let read = async {
        on!(store.readers, db => {
            let mut snapshot = db.begin_with(store.readers.words(SNAPSHOT)).await?;
            let query = sqlx::query(sql).bind(hook.0).bind(before).bind(state).bind(limit.bound());
            let found: Vec<Delivery> = each(query.fetch(&mut *snapshot)).await.map_err(of_delivery)?;
            let mut deliveries: Vec<DeliveryRow> = found.into_iter().map(delivery).collect();
            for delivery in &mut deliveries {
                delivery.attempts = each(sqlx::query(attempts()).bind(delivery.id.0).fetch(&mut *snapshot)).await?;
            }
            Ok(deliveries)
        })
    };
    store.readers.within_limit(read).await
}

/// A delivery with its attempts, both as of one moment: an attempt that is written meanwhile is in neither.
pub async fn get(store: &Store, id: Id) -> Result<Option<DeliveryRow>> {
    let sql = AssertSqlSafe(format!("{COLUMNS} WHERE d.id = $1"));
    let read = async {
        on!(store.readers, db => {
            let mut snapshot = db.begin_with(store.readers.words(SNAPSHOT)).await?;
            let query = sqlx::query(sql).bind(id.0);
            let Some(row) = query.fetch_optional(&mut *snapshot).await? else { return Ok(None) };
            let attempts = each(sqlx::query(attempts()).bind(id.0).fetch(&mut *snapshot)).await?;
            Ok(Some(DeliveryRow { attempts, ..delivery(row.whole().map_err(of_delivery)?) }))
        })
    };
    store.readers.within_limit(read).await
}

/// What several queries see is of one moment.
const SNAPSHOT: Sql = Sql { sqlite: "BEGIN", postgres: "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY" };

fn attempts() -> AssertSqlSafe<String> {
    AttemptRow::select("WHERE delivery = $1 ORDER BY id")
}

fn of_delivery(error: StoreError) -> StoreError {
    error.of("delivery")
}

type Delivery =
    ((Id, Id, [Option<Id>; 2]), (UtcMicros, DeliveryState, UtcMicros, Option<UtcMicros>), (Option<String>, Option<Id>));

fn delivery(((id, hook, of), (queued_at, state, due_at, finished_at), (action, alert)): Delivery) -> DeliveryRow {
    let (subject, attempts) = (subject(of, action.is_some()), Vec::new());
    DeliveryRow { id, hook, subject, action, alert, queued_at, state, due_at, finished_at, attempts }
}

/// The gyros of whose alerts these deliveries tell.
pub async fn gyros_of(store: &Store, deliveries: &[Id]) -> Result<Vec<u32>> {
    let those = store.readers.list("$1");
    let sql = AssertSqlSafe(format!(
        "SELECT DISTINCT gyro FROM alert WHERE gyro IS NOT NULL AND id IN
             (SELECT alert FROM delivery WHERE id IN {those}
              UNION ALL SELECT alert FROM delivery_part WHERE delivery IN {those})"
    ));
    read!(store, all, sql, deliveries)
}
