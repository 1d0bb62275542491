//! The writer's turn: one server writes at a time.
//!
//! A group is admitted, judged and answered by what is stored, so that nothing may come between reading and writing: numbers of
//! names, idempotency, the order of identifiers, what an alert was before. The turn is the lock of one row, held for one
//! transaction. Row locks or serialisable transactions would let two groups through that touch different gyros, and take a new
//! kind of care for each of these; a turn takes none, and costs a group one question more.

use std::time::{Duration, Instant};

use sqlx::postgres::PgConnectOptions;
use sqlx::{Connection, PgConnection, PgPool, Row as _};

use super::{BREATH, COMES_UP, names, reach};
use crate::store::commit::{Changes, batch_of};
use crate::store::diagnosis;
use crate::store::error::StoreError;
use crate::store::history::{self, HistoryRow};
use crate::store::id::Id;
use crate::store::names::Names;
use crate::store::open::Options;

/// The turn's row.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Standing {
    pub version: i64,
    pub last_id: i64,
    /// The version at which something of each kind was last written: see [`KINDS`].
    pub kinds: [i64; KINDS],
}

const KINDS: usize = 7;
pub(super) const RECORDS: usize = 0;
/// What counts no more, marks, bench results: what alters judging beyond new records.
pub(super) const MARKS: usize = 1;
pub(super) const ALERTS: usize = 2;
pub(super) const OUTBOX: usize = 3;
pub(super) const MODELS: usize = 4;
pub(super) const DIAGNOSES: usize = 5;
pub(super) const ACCESS: usize = 6;

pub(super) const LOOK: &str =
    "SELECT version, last_id, records, marks, alerts, outbox, models, diagnoses, access FROM turn WHERE id = 1";
const TAKE: &str = "BEGIN; SELECT version, last_id, records, marks, alerts, outbox, models, diagnoses, access \
                    FROM turn WHERE id = 1 FOR UPDATE";
const END: &str = "WITH mine AS (INSERT INTO writer (id, version, at) VALUES ($1, $2, now())
                       ON CONFLICT (id) DO UPDATE SET version = excluded.version, at = excluded.at)
                   UPDATE turn SET version = $2, last_id = $3, records = $4, marks = $5, alerts = $6, outbox = $7,
                       models = $8, diagnoses = $9, access = $10 WHERE id = 1";

impl Standing {
    pub fn of(row: &sqlx::postgres::PgRow) -> Result<Self, sqlx::Error> {
        let mut kinds = [0; KINDS];
        for (kind, place) in kinds.iter_mut().zip(2..) {
            *kind = row.try_get(place)?;
        }
        Ok(Self { version: row.try_get(0)?, last_id: row.try_get(1)?, kinds })
    }

    /// As it is after `changes`, of which the greatest identifier is `last_id`.
    fn after(&self, changes: &Changes, last_id: i64) -> Self {
        let mut next = Self { version: self.version + 1, last_id: last_id.max(self.last_id), kinds: self.kinds };
        let withdrawn = &changes.withdrawn;
        let outbox = &changes.outbox;
        let is_new = [
            !changes.records.is_empty(),
            [changes.events.len(), changes.benches.len(), withdrawn.records.len(), withdrawn.benches.len()] != [0; 4]
                || !changes.confirmed.is_empty(),
            !(changes.alerts.is_empty() && changes.alert_steps.is_empty() && changes.silences.is_empty()),
            [changes.hooks.len(), outbox.queued.len(), outbox.replayed.len()] != [0; 3]
                || [outbox.dropped.len(), outbox.hastened.len(), outbox.heard.len(), outbox.forgotten.len()] != [0; 4],
            !changes.models.is_empty(),
            !(changes.models.is_empty() && changes.diagnosis_jobs.started.is_empty())
                || changes.records.iter().any(|record| record.kind == crate::store::Kind::Campaign),
            !changes.access.tokens.is_empty()
                || !changes.access.sessions.is_empty()
                || !changes.access.ended.is_empty(),
        ];
        for (kind, is_new) in next.kinds.iter_mut().zip(is_new) {
            if is_new {
                *kind = next.version;
            }
        }
        next
    }

    /// Whether something of a kind was written since `seen`.
    pub fn has_moved(&self, kind: usize, seen: &Self) -> bool {
        self.kinds[kind] > seen.kinds[kind]
    }
}

/// What others have written since this server's last turn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Missed {
    /// Records with greater identifiers than this.
    pub records_after: Option<Id>,
    /// Something counts no more, was done to a gyro, or was measured on a bench.
    pub marks: bool,
    pub alerts: bool,
    pub outbox: bool,
    pub models: bool,
    pub diagnoses: bool,
    pub access: bool,
}

impl Missed {
    pub(super) fn between(seen: &Standing, now: &Standing) -> Self {
        let moved = |kind| now.has_moved(kind, seen);
        Self {
            records_after: moved(RECORDS).then_some(Id(seen.last_id)),
            marks: moved(MARKS),
            alerts: moved(ALERTS),
            outbox: moved(OUTBOX),
            models: moved(MODELS),
            diagnoses: moved(DIAGNOSES),
            access: moved(ACCESS),
        }
    }
}

/// The writing side of one server.
#[derive(Debug)]
pub(in crate::store) struct ServerWriter {
    connect: PgConnectOptions,
    patience: Duration,
    readers: PgPool,
    names: Names,
    /// Among those who write.
    number: i64,
    connection: Option<PgConnection>,
    /// As this server left it, or found it, last.
    seen: Standing,
    holds_turn: bool,
}

/// Of a statement that waits for another's turn. A server that vanishes within its own loses it sooner.
const LOCK_TIMEOUT_FACTOR: u32 = 2;
/// Writers that have not written for so long are forgotten.
const FORGET: &str = "DELETE FROM writer WHERE at < now() - INTERVAL '7 days'";

impl ServerWriter {
    pub async fn new(
        connect: PgConnectOptions,
        options: &Options,
        readers: PgPool,
        names: Names,
    ) -> Result<Self, StoreError> {
        let lease = options.lease;
        // A server that vanishes without a word gives its turn back.
        let connect = connect.options([
            ("idle_in_transaction_session_timeout", format!("{}ms", lease.as_millis())),
            ("lock_timeout", format!("{}ms", (lease * LOCK_TIMEOUT_FACTOR).as_millis())),
        ]);
        let row = sqlx::query(LOOK).fetch_one(&readers).await?;
        sqlx::query(FORGET).execute(&readers).await?;
        Ok(Self {
            connect,
            patience: options.busy_timeout,
            readers,
            names,
            number: rand::random_range(1..i64::MAX),
            connection: None,
            seen: Standing::of(&row)?,
            holds_turn: false,
        })
    }

    pub fn number(&self) -> i64 {
        self.number
    }

    /// The greatest identifier that was given out.
    pub fn last_id(&self) -> i64 {
        self.seen.last_id
    }

    /// See [`crate::store::Writer::take_turn`].
    pub async fn take_turn(&mut self) -> Result<Missed, StoreError> {
        if self.holds_turn {
            return Ok(Missed::default());
        }
        let found = self.begin().await?;
        self.holds_turn = true;
        let missed = Missed::between(&self.seen, &found);
        if found.version != self.seen.version {
            let learned = names::learn_new(&self.readers, &self.names).await;
            if learned.is_err() {
                self.give_back().await;
            }
            learned?;
        }
        self.seen = found;
        Ok(missed)
    }

    /// A connection that has lain idle may have broken unnoticed: then a fresh one is tried.
    async fn begin(&mut self) -> Result<Standing, StoreError> {
        if let Some(connection) = &mut self.connection {
            match lock(connection).await {
                Ok(found) => return Ok(found),
                Err(error) => {
                    self.connection = None;
                    if !matches!(error, StoreError::Unreachable(_)) {
                        return Err(error);
                    }
                }
            }
        }
        let mut connection = reach(&self.connect, self.patience).await?;
        let found = lock(&mut connection).await?;
        self.connection = Some(connection);
        Ok(found)
    }

    pub async fn give_back(&mut self) {
        if std::mem::take(&mut self.holds_turn)
            && let Some(connection) = &mut self.connection
            && sqlx::query("ROLLBACK").execute(connection).await.is_err()
        {
            self.connection = None;
        }
    }

    /// See [`crate::store::Writer::commit`].
    pub async fn commit(&mut self, changes: &Changes, last_id: i64) -> Result<(), StoreError> {
        if !self.holds_turn {
            return Err(StoreError::Unreachable("the turn to write was lost".to_owned()));
        }
        let next = self.seen.after(changes, last_id);
        let Some(connection) = &mut self.connection else {
            self.holds_turn = false;
            return Err(StoreError::Unreachable("the connection was lost".to_owned()));
        };
        if let Err(error) = write(connection, changes, self.number, &next).await {
            self.give_back().await;
            return Err(error);
        }
        self.holds_turn = false;
        if let Err(error) = sqlx::query("COMMIT").execute(connection).await {
            self.connection = None;
            self.find_out(next.version, error.into()).await?;
        }
        self.names.learn(changes);
        self.seen = next;
        Ok(())
    }

    /// The connection broke in the middle of a commit: whether it came about, the database knows.
    async fn find_out(&mut self, version: i64, error: StoreError) -> Result<(), StoreError> {
        tracing::warn!(%error, "a commit was not answered; finding out what became of it");
        let end = Instant::now() + COMES_UP;
        loop {
            match self.last_commit().await {
                Ok(found) if found == Some(version) => return Ok(()),
                Ok(_) => return Err(error),
                Err(unknown) if Instant::now() >= end => return Err(StoreError::Unanswered(unknown.to_string())),
                Err(_) => tokio::time::sleep(BREATH).await,
            }
        }
    }

    /// The version of this server's last commit, once whatever it had under way has come to its end.
    async fn last_commit(&self) -> Result<Option<i64>, StoreError> {
        let mut connection = reach(&self.connect, self.patience).await?;
        // Until then it holds the turn.
        lock(&mut connection).await?;
        let sql = "SELECT version FROM writer WHERE id = $1";
        let found = sqlx::query_scalar(sql).bind(self.number).fetch_optional(&mut connection).await?;
        sqlx::query("ROLLBACK").execute(&mut connection).await?;
        Ok(found)
    }

    /// Whether the turn can be had and the database takes a write.
    pub async fn probe(&mut self) -> Result<(), StoreError> {
        // What others have written meanwhile is still to be looked at by whoever takes the next turn.
        let seen = self.seen;
        self.take_turn().await?;
        self.seen = seen;
        let Some(connection) = &mut self.connection else { return Ok(()) };
        let written = sqlx::query("UPDATE turn SET version = version WHERE id = 1").execute(connection).await;
        self.give_back().await;
        written?;
        Ok(())
    }

    pub async fn close(mut self) -> Result<(), StoreError> {
        self.give_back().await;
        if let Some(connection) = self.connection.take() {
            connection.close().await?;
        }
        Ok(())
    }
}

/// Begins a transaction and waits for the turn.
async fn lock(connection: &mut PgConnection) -> Result<Standing, StoreError> {
    match sqlx::raw_sql(TAKE).fetch_one(&mut *connection).await {
        Ok(row) => Ok(Standing::of(&row)?),
        Err(error) => {
            let _nothing_may_be_open = sqlx::query("ROLLBACK").execute(connection).await;
            Err(error.into())
        }
    }
}

async fn write(
    connection: &mut PgConnection,
    changes: &Changes,
    number: i64,
    next: &Standing,
) -> Result<(), StoreError> {
    let mut batch = batch_of(changes);
    diagnosis::make_due(&changes.models, &mut batch);
    history::upsert(last_of_each(changes).into_iter(), &mut batch);
    batch.run(connection).await?;
    let mut end = sqlx::query(END).bind(number).bind(next.version).bind(next.last_id);
    for version in next.kinds {
        end = end.bind(version);
    }
    end.execute(connection).await?;
    Ok(())
}

/// One statement cannot put two rows into one place: of those of a gyro and instant the last holds.
fn last_of_each(changes: &Changes) -> Vec<&HistoryRow> {
    let mut rows: Vec<&HistoryRow> = changes.history_rows().collect();
    rows.sort_by_key(|row| (row.gyro, row.figures.at));
    rows.dedup_by(|later, earlier| {
        let same = (later.gyro, later.figures.at) == (earlier.gyro, earlier.figures.at);
        if same {
            *earlier = *later;
        }
        same
    });
    rows
}
