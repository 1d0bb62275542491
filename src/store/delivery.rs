//! The outbox: what hooks are still to be told, and what became of what they were told.
//!
//! Deliveries of one hook and alert form a line: the first that is not done is `waiting`, those after it are `behind`.
//! Whatever ends one moves the next up, in the same transaction.

use super::batch::{Batch, Rows};
use super::db::{Sql, cell, insert};
use super::id::Id;
use crate::core::time::UtcMicros;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeliveryState {
    /// An earlier one of the same hook and alert is not done.
    Behind,
    /// To be sent when it is due.
    Waiting,
    Delivered,
    /// Given up after the whole ladder, or because the target is gone.
    Dead,
    /// Its hook was deleted.
    Dropped,
}

impl DeliveryState {
    pub const ALL: [DeliveryState; 5] = [
        DeliveryState::Behind,
        DeliveryState::Waiting,
        DeliveryState::Delivered,
        DeliveryState::Dead,
        DeliveryState::Dropped,
    ];

    pub fn name(self) -> &'static str {
        match self {
            DeliveryState::Behind => "behind",
            DeliveryState::Waiting => "waiting",
            DeliveryState::Delivered => "delivered",
            DeliveryState::Dead => "dead",
            DeliveryState::Dropped => "dropped",
        }
    }

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }
}

/// What a delivery tells of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    Step { step: Id, alert: Id },
    Test,
}

impl Subject {
    fn columns(self) -> [Option<i64>; 2] {
        match self {
            Subject::Step { step, alert } => [Some(step.0), Some(alert.0)],
            Subject::Test => [None, None],
        }
    }
}

/// A delivery as it is queued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NewDelivery {
    pub id: Id,
    pub hook: Id,
    pub subject: Subject,
    pub queued_at: UtcMicros,
}

/// A delivery that is due: its step with the message's content, none for a test.
#[derive(Debug, Clone, PartialEq)]
pub struct DueDelivery {
    pub id: Id,
    pub hook: Id,
    pub subject: Subject,
    pub queued_at: UtcMicros,
    pub attempts: u32,
    pub first_attempt_at: Option<UtcMicros>,
    /// Instant, action and body of the step.
    pub content: Option<(UtcMicros, String, String)>,
}

/// An attempt was made.
#[derive(Debug, Clone, PartialEq)]
pub struct AttemptRow {
    pub id: Id,
    pub delivery: Id,
    pub at: UtcMicros,
    pub status: Option<u16>,
    pub detail: String,
    pub took_us: i64,
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
    pub subject: Subject,
    pub action: Option<String>,
    pub queued_at: UtcMicros,
    pub state: DeliveryState,
    pub due_at: UtcMicros,
    pub finished_at: Option<UtcMicros>,
    /// All that were made, oldest first.
    pub attempts: Vec<AttemptRow>,
}

/// How the queue of a hook stands, or the queues of all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QueueState {
    pub open: i64,
    pub dead: i64,
    pub oldest_open: Option<UtcMicros>,
}

/// What a transaction changes in the outbox.
#[derive(Debug, Default)]
pub struct OutboxChanges {
    pub queued: Vec<NewDelivery>,
    pub attempts: Vec<(AttemptRow, Progress)>,
    /// Sent again from the start of the ladder, at an instant.
    pub replayed: Vec<(Id, UtcMicros)>,
    /// Hooks whose queue is thrown away, at an instant.
    pub dropped: Vec<(Id, UtcMicros)>,
    /// Hooks whose waiting deliveries are due now: their target is back.
    pub hastened: Vec<(Id, UtcMicros)>,
}

impl OutboxChanges {
    pub fn is_empty(&self) -> bool {
        let Self { queued, attempts, replayed, dropped, hastened } = self;
        queued.is_empty() && attempts.is_empty() && replayed.is_empty() && dropped.is_empty() && hastened.is_empty()
    }
}

pub(super) fn apply(changes: &OutboxChanges, batch: &mut Batch) {
    insert(&changes.queued, batch);
    attempted(&changes.attempts, batch);
    instants(
        Sql {
            sqlite: "UPDATE delivery SET state = 'waiting', due_at = $C1, attempts = 0, first_attempt_at = NULL, finished_at = NULL
                     WHERE id = $C0 AND state IN ('waiting', 'delivered', 'dead')",
            postgres: "UPDATE delivery SET state = 'waiting', due_at = CAST(j.value->>1 AS BIGINT), attempts = 0,
                           first_attempt_at = NULL, finished_at = NULL
                       FROM jsonb_array_elements(CAST($1 AS JSONB)) AS j(value)
                       WHERE delivery.id = CAST(j.value->>0 AS BIGINT) AND state IN ('waiting', 'delivered', 'dead')",
        },
        &changes.replayed,
        batch,
    );
    instants(
        Sql {
            sqlite: "UPDATE delivery SET state = 'dropped', finished_at = $C1
                     WHERE hook = $C0 AND state IN ('behind', 'waiting')",
            postgres: "UPDATE delivery SET state = 'dropped', finished_at = CAST(j.value->>1 AS BIGINT)
                       FROM jsonb_array_elements(CAST($1 AS JSONB)) AS j(value)
                       WHERE delivery.hook = CAST(j.value->>0 AS BIGINT) AND state IN ('behind', 'waiting')",
        },
        &changes.dropped,
        batch,
    );
    instants(
        Sql {
            sqlite: "UPDATE delivery SET due_at = $C1 WHERE hook = $C0 AND state = 'waiting' AND due_at > $C1",
            postgres: "UPDATE delivery SET due_at = CAST(j.value->>1 AS BIGINT)
                       FROM jsonb_array_elements(CAST($1 AS JSONB)) AS j(value)
                       WHERE delivery.hook = CAST(j.value->>0 AS BIGINT) AND state = 'waiting'
                           AND due_at > CAST(j.value->>1 AS BIGINT)",
        },
        &changes.hastened,
        batch,
    );
}

/// A test is due before whatever waits: somebody looks at it.
fn insert(queued: &[NewDelivery], batch: &mut Batch) {
    let mut rows = Rows::default();
    for NewDelivery { id, hook, subject, queued_at } in queued {
        let [step, alert] = subject.columns();
        let state = if alert.is_some() { DeliveryState::Behind } else { DeliveryState::Waiting };
        rows.row()
            .integer(id.0)
            .integer(hook.0)
            .optional_integer(step)
            .optional_integer(alert)
            .integer(queued_at.0)
            .text(state.name())
            .integer(if alert.is_some() { queued_at.0 } else { 0 })
            .integer(0);
    }
    batch.add(
        insert!(
            "delivery (id, hook, step, alert, queued_at, state, due_at, attempts)",
            [int 0, int 1, int 2, int 3, int 4, text 5, int 6, int 7]
        ),
        rows,
    );
    let lines = queued.iter().map(|new| (new.id, new.queued_at));
    move_up(lines, batch);
}

fn attempted(attempts: &[(AttemptRow, Progress)], batch: &mut Batch) {
    let (mut history, mut rows) = (Rows::default(), Rows::default());
    for (attempt, progress) in attempts {
        history
            .row()
            .integer(attempt.delivery.0)
            .integer(attempt.id.0)
            .integer(attempt.at.0)
            .optional_integer(attempt.status.map(i64::from))
            .text(&attempt.detail)
            .integer(attempt.took_us);
        let (state, due_at, finished_at) = match *progress {
            Progress::RetryAt(due) => (DeliveryState::Waiting, Some(due.0), None),
            Progress::Done(state) => (state, None, Some(attempt.at.0)),
        };
        rows.row()
            .integer(attempt.delivery.0)
            .text(state.name())
            .optional_integer(due_at)
            .optional_integer(finished_at)
            .integer(attempt.at.0);
    }
    batch.add(
        insert!(
            "delivery_attempt (delivery, id, at, status, detail, took_us)",
            [int 0, int 1, int 2, int 3, text 4, int 5]
        ),
        history,
    );
    // A delivery that was dropped meanwhile stays dropped.
    batch.add(
        Sql {
            sqlite: "UPDATE delivery SET state = $C1, due_at = coalesce($C2, due_at), finished_at = $C3,
                         attempts = attempts + 1, first_attempt_at = coalesce(first_attempt_at, $C4)
                     WHERE id = $C0 AND state = 'waiting'",
            postgres: "UPDATE delivery SET state = j.value->>1,
                           due_at = coalesce(CAST(j.value->>2 AS BIGINT), due_at),
                           finished_at = CAST(j.value->>3 AS BIGINT), attempts = attempts + 1,
                           first_attempt_at = coalesce(first_attempt_at, CAST(j.value->>4 AS BIGINT))
                       FROM jsonb_array_elements(CAST($1 AS JSONB)) AS j(value)
                       WHERE delivery.id = CAST(j.value->>0 AS BIGINT) AND delivery.state = 'waiting'",
        },
        rows,
    );
    let done = attempts.iter().filter(|(_, progress)| matches!(progress, Progress::Done(_)));
    move_up(done.map(|(attempt, _)| (attempt.delivery, attempt.at)), batch);
}

/// For each delivery, the first of its line that is not done waits, due at the instant; where that waits already, nothing.
fn move_up(lines: impl Iterator<Item = (Id, UtcMicros)>, batch: &mut Batch) {
    let lines: Vec<_> = lines.collect();
    instants(
        Sql {
            sqlite: "UPDATE delivery SET state = 'waiting', due_at = $C1
                     WHERE state = 'behind' AND id = (SELECT (SELECT min(open.id) FROM delivery AS open
                                                              WHERE open.hook = line.hook AND open.alert = line.alert
                                                                  AND open.state IN ('behind', 'waiting'))
                                                      FROM delivery AS line WHERE line.id = $C0)",
            postgres: "UPDATE delivery SET state = 'waiting', due_at = head.at
                       FROM (SELECT CAST(j.value->>1 AS BIGINT) AS at,
                                    (SELECT min(open.id) FROM delivery AS open
                                     WHERE open.hook = line.hook AND open.alert = line.alert
                                         AND open.state IN ('behind', 'waiting')) AS id
                             FROM jsonb_array_elements(CAST($1 AS JSONB)) AS j(value)
                             JOIN delivery AS line ON line.id = CAST(j.value->>0 AS BIGINT)) AS head
                       WHERE delivery.id = head.id AND delivery.state = 'behind'",
        },
        &lines,
        batch,
    );
}

fn instants(sql: Sql, pairs: &[(Id, UtcMicros)], batch: &mut Batch) {
    let mut rows = Rows::default();
    for (id, at) in pairs {
        rows.row().integer(id.0).integer(at.0);
    }
    batch.add(sql, rows);
}
