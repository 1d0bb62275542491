//! The outbox: what hooks are still to be told, and what became of what they were told.
//!
//! Deliveries of one hook and alert form a line: the first that is not done is `waiting`, those after it are
//! `behind`. One that tells of many alerts stands in the line of each, and waits when it is the first in all of them.
//! Whatever ends one moves the next up, in the same transaction.

use super::*;
use crate::core::delivery::{DeliveryState, QueueState};
use crate::core::judge::Severity;

/// What a delivery tells of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeliverySubject {
    Step {
        step: Id,
        alert: Id,
    },
    /// What its [parts](Part) say.
    Many,
    Test,
}

impl DeliverySubject {
    fn columns(self) -> [Option<Id>; 2] {
        match self {
            DeliverySubject::Step { step, alert } => [Some(step), Some(alert)],
            DeliverySubject::Many | DeliverySubject::Test => [None, None],
        }
    }

    /// Of the step and the alert that a delivery tells of, if it is one, and of whether it `tells` of any.
    fn of([step, alert]: [Option<Id>; 2], tells: bool) -> Self {
        match step.zip(alert) {
            Some((step, alert)) => DeliverySubject::Step { step, alert },
            None if tells => DeliverySubject::Many,
            None => DeliverySubject::Test,
        }
    }
}

/// One alert of a delivery of many.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    pub alert: Id,
    /// Name of an action of `core::notify`.
    pub action: &'static str,
    pub step: Option<Id>,
    /// The alert as it is told (JSON), where no step says so.
    pub body: Option<String>,
}

/// A delivery as it is queued.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewDelivery {
    pub id: Id,
    pub hook: Id,
    pub subject: DeliverySubject,
    pub queued_at: UtcMicros,
    /// What is told, where that is not what the step says; of many, of the gravest.
    pub action: Option<&'static str>,
    pub parts: Vec<Part>,
    /// What an import has left firing, counted (JSON).
    pub digest: Option<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct DueDelivery {
    pub id: Id,
    pub hook: Id,
    pub subject: DeliverySubject,
    pub queued_at: UtcMicros,
    pub attempts: u32,
    pub first_attempt_at: Option<UtcMicros>,
    /// Instant of the step; none for what tells of none.
    pub at: Option<UtcMicros>,
    /// Action and body of each alert; none for a test.
    pub content: Vec<(String, String)>,
    pub digest: Option<String>,
}

/// An attempt was made.
#[derive(Debug, Clone, PartialEq)]
pub struct AttemptRow {
    pub id: Id,
    pub delivery: Id,
    pub at: UtcMicros,
    pub status: Option<u16>,
    pub detail: String,
    /// What the target said.
    pub answer: Option<String>,
    pub took_us: i64,
}

columns! {
    AttemptRow in "delivery_attempt" { delivery, id, at, status, detail, took_us, answer }
}

/// What comes of a delivery after an attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    RetryAt(UtcMicros),
    /// [`DeliveryState::Delivered`] or [`DeliveryState::Dead`].
    Done(DeliveryState),
}

/// A delivery as people look at it.
#[derive(Debug, Clone, PartialEq)]
pub struct DeliveryRow {
    pub id: Id,
    pub hook: Id,
    pub subject: DeliverySubject,
    /// Of a delivery of many, the gravest; `digest` of one that ends an import.
    pub action: Option<String>,
    /// The first of many.
    pub alert: Option<Id>,
    pub queued_at: UtcMicros,
    pub state: DeliveryState,
    pub due_at: UtcMicros,
    pub finished_at: Option<UtcMicros>,
    /// All that were made, oldest first.
    pub attempts: Vec<AttemptRow>,
}

#[derive(Debug, Default, PartialEq)]
pub struct OutboxChanges {
    pub queued: Vec<NewDelivery>,
    pub attempts: Vec<(AttemptRow, Progress)>,
    /// Sent again from the start of the ladder, at an instant.
    pub replayed: Vec<(Id, UtcMicros)>,
    /// Hooks whose queue is thrown away, at an instant.
    pub dropped: Vec<(Id, UtcMicros)>,
    /// Hooks whose waiting deliveries are due now: their target is back.
    pub hastened: Vec<(Id, UtcMicros)>,
    /// What a hook (first) has heard of an alert, in order: that it fires with a severity, or that all is well.
    pub heard: Vec<(Id, Id, Option<Severity>)>,
    /// Hooks that have heard nothing but what [`OutboxChanges::heard`] says.
    pub forgotten: Vec<Id>,
}

pub(crate) fn apply(changes: &OutboxChanges, batch: &mut Batch) {
    // What comes in place of what is dropped comes after it.
    batch.change(
        "UPDATE delivery SET state = 'dropped', finished_at = $C1",
        "hook = $C0 AND state IN ('behind', 'waiting')",
        Rows::of(changes.dropped.iter().copied()),
    );
    hear(changes, batch);
    insert(&changes.queued, batch);
    attempted(&changes.attempts, batch);
    batch.change(
        "UPDATE delivery SET state = 'waiting', due_at = $C1, attempts = 0, first_attempt_at = NULL, finished_at = NULL",
        "id = $C0 AND state IN ('waiting', 'delivered', 'dead')",
        Rows::of(changes.replayed.iter().copied()),
    );
    fall_back(&changes.replayed, batch);
    batch.change(
        "UPDATE delivery SET due_at = $C1",
        "hook = $C0 AND state = 'waiting' AND due_at > $C1",
        Rows::of(changes.hastened.iter().copied()),
    );
}

fn hear(changes: &OutboxChanges, batch: &mut Batch) {
    batch.change("DELETE FROM hook_heard", "hook = $C0", Rows::of(changes.forgotten.iter().copied()));
    let last: BTreeMap<(Id, Id), Option<Severity>> =
        changes.heard.iter().map(|(hook, alert, severity)| ((*hook, *alert), *severity)).collect();
    let (mut fires, mut is_well) = (Rows::default(), Rows::default());
    for ((hook, alert), severity) in last {
        match severity {
            Some(severity) => _ = fires.row().put(&hook).put(&alert).put(&severity),
            None => _ = is_well.row().put(&hook).put(&alert),
        }
    }
    batch.insert("hook_heard", "hook, alert, severity", OnConflict::Set("hook, alert", &["severity"]), fires);
    batch.change("DELETE FROM hook_heard", "hook = $C0 AND alert = $C1", is_well);
}

/// A test is due before whatever waits: somebody looks at it.
fn insert(queued: &[NewDelivery], batch: &mut Batch) {
    let (mut rows, mut parts) = (Rows::default(), Rows::default());
    for new in queued {
        let [step, alert] = new.subject.columns();
        let is_test = new.subject == DeliverySubject::Test;
        let state = if is_test { DeliveryState::Waiting } else { DeliveryState::Behind };
        let mut row = rows.row();
        row.put(&new.id).put(&new.hook).put(&step).put(&alert).put(&new.queued_at).put(&state);
        row.integer(if is_test { 0 } else { new.queued_at.0 }).integer(0);
        row.put(&new.action.map(str::to_owned)).put(&new.digest);
        for (place, part) in (0..).zip(&new.parts) {
            let mut row = parts.row();
            row.put(&new.id).integer(place).put(&new.hook).put(&part.alert).text(part.action);
            row.put(&part.step).optional_words(part.body.as_deref());
        }
    }
    let columns = "id, hook, step, alert, queued_at, state, due_at, attempts, action, digest";
    batch.insert("delivery", columns, OnConflict::Fail, rows);
    batch.insert("delivery_part", "delivery, place, hook, alert, action, step, body", OnConflict::Fail, parts);
    let lines = queued.iter().map(|new| (new.id, new.queued_at));
    move_up(lines, batch);
}

fn attempted(attempts: &[(AttemptRow, Progress)], batch: &mut Batch) {
    let rows = Rows::each(attempts, |(attempt, progress), row| {
        let (state, due_at, finished_at) = match *progress {
            Progress::RetryAt(due) => (DeliveryState::Waiting, Some(due), None),
            Progress::Done(state) => (state, None, Some(attempt.at)),
        };
        row.put(&attempt.delivery).put(&state).put(&due_at).put(&finished_at).put(&attempt.at);
    });
    batch.enter(attempts.iter().map(|(attempt, _)| attempt), OnConflict::Fail);
    // A delivery that was dropped meanwhile stays dropped; one that fell back is done all the same.
    batch.change(
        "UPDATE delivery SET state = $C1, due_at = coalesce($C2, due_at), finished_at = $C3, attempts = attempts + 1,
             first_attempt_at = coalesce(first_attempt_at, $C4)",
        "id = $C0 AND state IN ('behind', 'waiting')",
        rows,
    );
    let done = attempts.iter().filter(|(_, progress)| matches!(progress, Progress::Done(_)));
    move_up(done.map(|(attempt, _)| (attempt.delivery, attempt.at)), batch);
}

/// The lines (hook and alert) that a delivery stands in.
fn lines_of(delivery: &str) -> String {
    format!(
        "(SELECT self.hook, self.alert FROM delivery AS self WHERE self.id = {delivery} AND self.alert IS NOT NULL
          UNION ALL SELECT each.hook, each.alert FROM delivery_part AS each WHERE each.delivery = {delivery})"
    )
}

/// The first of a line that is not done.
fn first_open(line: &str) -> String {
    format!(
        "(SELECT min(id) FROM (SELECT min(open.id) AS id FROM delivery AS open WHERE open.hook = {line}.hook
              AND open.alert = {line}.alert AND open.state IN ('behind', 'waiting')
          UNION ALL SELECT min(part.delivery) FROM delivery_part AS part JOIN delivery AS open ON open.id = part.delivery
              WHERE part.hook = {line}.hook AND part.alert = {line}.alert AND open.state IN ('behind', 'waiting')) AS firsts)"
    )
}

/// Whether in one of a delivery's lines another is before it.
fn stands_behind() -> String {
    format!(
        "EXISTS (SELECT 1 FROM (SELECT {} AS first FROM {} AS own) AS heads WHERE heads.first < delivery.id)",
        first_open("own"),
        lines_of("delivery.id")
    )
}

/// For each delivery, the first of each of its lines that is not done waits, due at the instant, where it is the
/// first of all its own lines; where that waits already, nothing.
fn move_up(lines: impl Iterator<Item = (Id, UtcMicros)>, batch: &mut Batch) {
    let (first, lines_of, stands_behind) = (first_open("line"), lines_of("$C0"), stands_behind());
    let sql = Sql {
        sqlite: format!(
            "UPDATE delivery SET state = 'waiting', due_at = $C1 WHERE state = 'behind'
                 AND id IN (SELECT {first} FROM {lines_of} AS line) AND NOT {stands_behind}"
        ),
        postgres: format!(
            "UPDATE delivery SET state = 'waiting', due_at = head.at
             FROM (SELECT min(at) AS at, first AS id
                   FROM (SELECT $C1 AS at, {first} AS first FROM $ROWS JOIN LATERAL {lines_of} AS line ON true) AS firsts
                   GROUP BY first) AS head
             WHERE delivery.id = head.id AND delivery.state = 'behind' AND NOT {stands_behind}"
        ),
    };
    batch.add(sql, Rows::of(lines));
}

/// After deliveries that are sent again, what waits of their hooks and stands behind another waits for its turn.
fn fall_back(again: &[(Id, UtcMicros)], batch: &mut Batch) {
    let stands_behind = stands_behind();
    let sql = Sql {
        sqlite: format!(
            "UPDATE delivery SET state = 'behind' WHERE state = 'waiting'
                 AND hook = (SELECT again.hook FROM delivery AS again WHERE again.id = $C0) AND {stands_behind}"
        ),
        postgres: format!(
            "UPDATE delivery SET state = 'behind' WHERE state = 'waiting'
                 AND hook IN (SELECT again.hook FROM delivery AS again WHERE again.id IN (SELECT $C0 FROM $ROWS))
                 AND {stands_behind}"
        ),
    };
    batch.add(sql, Rows::of(again.iter().map(|(id, _)| *id)));
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
    let (subject, content) = (DeliverySubject::of(of, action.is_some()), action.zip(body).into_iter().collect());
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
pub async fn totals(store: &Store) -> Result<QueueState> {
    let sql = "SELECT (SELECT count(*) FROM delivery WHERE state IN ('behind', 'waiting')),
                      (SELECT count(*) FROM delivery WHERE state = 'dead'),
                      (SELECT min((SELECT min(queued_at) FROM delivery
                                   WHERE delivery.hook = hook.id AND state IN ('behind', 'waiting')))
                       FROM hook WHERE deleted_at IS NULL AND enabled = 1)";
    read!(store, one, sql)
}

/// Deliveries with their attempts, in one statement: all as of one moment.
macro_rules! with_attempts {
    ($store:expr, $which:expr, $($bound:expr),+) => {{
        let sql = AssertSqlSafe(format!(
            "SELECT found.*, made.id, made.at, made.status, made.detail, made.took_us, made.answer
             FROM ({COLUMNS} WHERE {}) AS found LEFT JOIN delivery_attempt AS made ON made.delivery = found.id
             ORDER BY found.id DESC, made.id",
            $which
        ));
        let rows: Result<Vec<(Delivery, Made)>> = read!($store, all, sql, $($bound),+);
        rows.map(together).map_err(|error| error.of("delivery"))
    }};
}

/// Deliveries of a hook older than `before`, newest first, with their attempts.
pub async fn of_hook(
    store: &Store,
    hook: Id,
    state: Option<DeliveryState>,
    before: Option<Id>,
    limit: u32,
) -> Result<Vec<DeliveryRow>> {
    let which = "d.hook = $1 AND d.id < $2 AND ($3 IS NULL OR d.state = $3) ORDER BY d.id DESC LIMIT $4";
    with_attempts!(store, which, hook, before.unwrap_or(Id(i64::MAX)), state, limit)
}

/// A delivery with its attempts.
pub async fn get(store: &Store, id: Id) -> Result<Option<DeliveryRow>> {
    let found: Result<Vec<DeliveryRow>> = with_attempts!(store, "d.id = $1", id);
    Ok(found?.pop())
}

type Delivery =
    ((Id, Id, [Option<Id>; 2]), (UtcMicros, DeliveryState, UtcMicros, Option<UtcMicros>), (Option<String>, Option<Id>));

/// An attempt, if there was one.
type Made = ((Option<Id>, Option<UtcMicros>, Option<u16>), (Option<String>, Option<i64>, Option<String>));

fn delivery(((id, hook, of), (queued_at, state, due_at, finished_at), (action, alert)): Delivery) -> DeliveryRow {
    let (subject, attempts) = (DeliverySubject::of(of, action.is_some()), Vec::new());
    DeliveryRow { id, hook, subject, action, alert, queued_at, state, due_at, finished_at, attempts }
}

/// A row for each attempt, those of a delivery beside one another.
fn together(rows: Vec<(Delivery, Made)>) -> Vec<DeliveryRow> {
    let mut deliveries: Vec<DeliveryRow> = Vec::new();
    for (found, ((id, at, status), (detail, took_us, answer))) in rows {
        let mut delivery = delivery(found);
        let made = id.zip(at).zip(detail.zip(took_us));
        let made = made.map(|((id, at), (detail, took_us))| AttemptRow {
            id,
            delivery: delivery.id,
            at,
            status,
            detail,
            answer,
            took_us,
        });
        match deliveries.last_mut().filter(|last| last.id == delivery.id) {
            Some(last) => last.attempts.extend(made),
            None => {
                delivery.attempts.extend(made);
                deliveries.push(delivery);
            }
        }
    }
    deliveries
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
