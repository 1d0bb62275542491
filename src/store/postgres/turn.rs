//! The writer's turn: one server writes at a time.
//!
//! A group is admitted, judged and answered by what is stored, so that nothing may come between reading and writing: numbers of
//! names, idempotency, the order of identifiers, what an alert was before. The turn is the lock of one row, held for one
//! transaction. Row locks or serialisable transactions would let two groups through that touch different gyros, and take a new
//! kind of care for each of these; a turn takes none, and costs a group one question more.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use sqlx::{AssertSqlSafe, Connection, PgConnection, Row as _};

use super::hosts::Hosts;
use super::{BREATH, COMES_UP, PgReaders, names, within};
use crate::store::commit::{Changes, batch_of};
use crate::store::db::Readers;
use crate::store::diagnosis;
use crate::store::error::StoreError;
use crate::store::history::{self, HistoryRow};
use crate::store::id::Id;
use crate::store::names::{Commit, Names};
use crate::store::open::{Options, Store};

/// The turn's row.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Standing {
    /// The newest.
    pub commit: Commit,
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

/// The turn's row, and the stamp that the commit had which this server has seen: none where the database has lost it.
fn look(seen: Commit) -> String {
    format!(
        "SELECT version, stamp, last_id, records, marks, alerts, outbox, models, diagnoses, access,
             (SELECT stamp FROM turn_commit WHERE turn_commit.version = {})
         FROM turn WHERE id = 1",
        seen.version
    )
}

/// Commits that are kept: a server that has missed more reads everything again.
const KEPT: i64 = 100_000;
const END: &str = "WITH made AS (INSERT INTO turn_commit (version, stamp, gyros) VALUES ($1, $2, $12)),
                       forgotten AS (DELETE FROM turn_commit WHERE version = $1 - $3)
                   UPDATE turn SET version = $1, stamp = $2, last_id = $4, records = $5, marks = $6, alerts = $7,
                       outbox = $8, models = $9, diagnoses = $10, access = $11 WHERE id = 1";
/// Names that a commit has brought.
const NAMED: [&str; 3] = [
    "UPDATE imu SET since = $1 WHERE id = ANY($2)",
    "UPDATE station SET since = $1 WHERE id = ANY($2)",
    "UPDATE gyro SET since = $1 WHERE id = ANY($2)",
];

/// The turn's row, and whether what was seen of the database before is still part of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub standing: Standing,
    pub is_continued: bool,
}

impl Found {
    fn of(row: &sqlx::postgres::PgRow, seen: Commit) -> Result<Self, sqlx::Error> {
        let mut kinds = [0; KINDS];
        for (kind, place) in kinds.iter_mut().zip(3..) {
            *kind = row.try_get(place)?;
        }
        let commit = Commit { version: row.try_get(0)?, stamp: row.try_get(1)? };
        let stamp: Option<i64> = row.try_get(3 + KINDS)?;
        Ok(Self {
            standing: Standing { commit, last_id: row.try_get(2)?, kinds },
            is_continued: stamp == Some(seen.stamp) || seen == Commit::default(),
        })
    }

    /// Without taking the turn.
    pub async fn look(readers: &PgReaders, seen: Commit) -> Result<Self, StoreError> {
        let row = sqlx::query(AssertSqlSafe(look(seen))).fetch_one(readers).await?;
        Ok(Self::of(&row, seen)?)
    }

    /// What others have written since `seen`.
    pub fn missed(&self, seen: &Standing) -> Missed {
        if self.is_continued { Missed::between(seen, &self.standing) } else { Missed::EVERYTHING }
    }
}

impl Standing {
    /// As it is after `changes`, of which the greatest identifier is `last_id`.
    fn after(&self, changes: &Changes, last_id: i64) -> Self {
        let commit = Commit { version: self.commit.version + 1, stamp: rand::random_range(1..i64::MAX) };
        let mut next = Self { commit, last_id: last_id.max(self.last_id), kinds: self.kinds };
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
                *kind = next.commit.version;
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
    /// Commits have been lost: nothing of what was seen is known to hold.
    pub everything: bool,
    /// Records with greater identifiers than this.
    pub records_after: Option<Id>,
    /// Something counts no more, was done to a gyro, or was measured on a bench, or an alert has changed: in commits after this.
    pub touched_after: Option<i64>,
    pub outbox: bool,
    pub models: bool,
    pub diagnoses: bool,
    pub access: bool,
}

impl Missed {
    /// Nothing of what was seen before is known to hold.
    pub const EVERYTHING: Self = Self {
        everything: true,
        records_after: None,
        touched_after: None,
        outbox: true,
        models: true,
        diagnoses: true,
        access: true,
    };

    pub(super) fn between(seen: &Standing, now: &Standing) -> Self {
        let moved = |kind| now.has_moved(kind, seen);
        Self {
            everything: false,
            records_after: moved(RECORDS).then_some(Id(seen.last_id)),
            touched_after: (moved(MARKS) || moved(ALERTS)).then_some(seen.commit.version),
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
    hosts: Hosts,
    patience: Duration,
    lease: Duration,
    readers: PgReaders,
    names: Names,
    /// Among those who work in the background.
    number: i64,
    connection: Option<PgConnection>,
    /// As this server left it, or found it, last.
    seen: Standing,
    holds_turn: bool,
}

impl ServerWriter {
    pub async fn new(hosts: Hosts, options: &Options, readers: PgReaders, names: Names) -> Result<Self, StoreError> {
        let seen = Found::look(&readers, Commit::default()).await?.standing;
        Ok(Self {
            hosts,
            patience: options.busy_timeout,
            lease: options.lease,
            readers,
            names,
            number: rand::random_range(1..i64::MAX),
            connection: None,
            seen,
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
        let missed = found.missed(&self.seen);
        if found.standing.commit != self.names.read().seen {
            let learned = names::learn_new(&self.readers, &self.names).await;
            if learned.is_err() {
                self.give_back().await;
            }
            learned?;
        }
        self.seen = found.standing;
        Ok(missed)
    }

    /// A connection that has lain idle may have broken unnoticed: then a fresh one is tried.
    async fn begin(&mut self) -> Result<Found, StoreError> {
        if let Some(mut connection) = self.connection.take() {
            match lock(&mut connection, self.seen.commit, self.lease).await {
                Ok(found) => {
                    self.connection = Some(connection);
                    return Ok(found);
                }
                Err(error) if !matches!(error, StoreError::Unreachable(_)) => return Err(error),
                Err(_) => {}
            }
        }
        let mut connection = self.hosts.reach(self.patience).await?;
        let found = lock(&mut connection, self.seen.commit, self.lease).await?;
        self.connection = Some(connection);
        Ok(found)
    }

    pub async fn give_back(&mut self) {
        if !std::mem::take(&mut self.holds_turn) {
            return;
        }
        if let Some(mut connection) = self.connection.take()
            && within(self.patience, sqlx::query("ROLLBACK").execute(&mut connection)).await.is_ok()
        {
            self.connection = Some(connection);
        }
    }

    /// See [`crate::store::Writer::commit`].
    pub async fn commit(&mut self, changes: &Changes, last_id: i64) -> Result<(), StoreError> {
        if !self.holds_turn {
            return Err(StoreError::Unreachable("the turn to write was lost".to_owned()));
        }
        let next = self.seen.after(changes, last_id);
        // Back in its place only when all has gone well: one on which an answer is still due is of no use.
        let Some(mut connection) = self.connection.take() else {
            self.holds_turn = false;
            return Err(StoreError::Unreachable("the connection was lost".to_owned()));
        };
        if let Err(error) = write(&mut connection, changes, &next, self.lease).await {
            if !matches!(error, StoreError::Unreachable(_)) {
                self.connection = Some(connection);
            }
            self.give_back().await;
            return Err(error);
        }
        self.holds_turn = false;
        match within(self.lease, sqlx::query("COMMIT").execute(&mut connection)).await {
            Ok(_) => self.connection = Some(connection),
            Err(error) => {
                drop(connection);
                self.find_out(next.commit, error.into()).await?;
            }
        }
        self.names.learn(changes);
        self.names.change(|tables| tables.seen = next.commit);
        self.seen = next;
        Ok(())
    }

    /// The connection broke in the middle of a commit: whether it came about, the database knows.
    async fn find_out(&mut self, commit: Commit, error: StoreError) -> Result<(), StoreError> {
        tracing::warn!(%error, "a commit was not answered; finding out what became of it");
        let end = Instant::now() + COMES_UP.max(self.lease);
        loop {
            match self.has(commit).await {
                Ok(true) => return Ok(()),
                Ok(false) => return Err(error),
                Err(unknown) if Instant::now() >= end => return Err(StoreError::Unanswered(unknown.to_string())),
                Err(_) => tokio::time::sleep(BREATH).await,
            }
        }
    }

    /// Whether the database has a commit of this server's, once whatever it had under way has come to its end.
    async fn has(&self, commit: Commit) -> Result<bool, StoreError> {
        let mut connection = self.hosts.reach(self.patience).await?;
        // Until then it holds the turn.
        let found = lock(&mut connection, commit, self.lease).await?;
        within(self.patience, sqlx::query("ROLLBACK").execute(&mut connection)).await?;
        Ok(found.is_continued)
    }

    /// Whether the turn can be had and the database takes a write.
    pub async fn probe(&mut self) -> Result<(), StoreError> {
        // What others have written meanwhile is still to be looked at by whoever takes the next turn.
        let seen = self.seen;
        self.take_turn().await?;
        self.seen = seen;
        let Some(connection) = &mut self.connection else { return Ok(()) };
        let write = sqlx::query("UPDATE turn SET version = version WHERE id = 1");
        let written = within(self.lease, write.execute(connection)).await;
        if written.is_err() {
            self.connection = None;
        }
        self.give_back().await;
        written?;
        Ok(())
    }

    pub async fn close(mut self) -> Result<(), StoreError> {
        self.give_back().await;
        if let Some(connection) = self.connection.take() {
            within(self.patience, connection.close()).await?;
        }
        Ok(())
    }
}

/// Begins a transaction and waits for the turn. A server that vanishes within its own loses it after its lease: nobody has to wait for
/// longer, and whoever has not heard by then never will.
async fn lock(connection: &mut PgConnection, seen: Commit, lease: Duration) -> Result<Found, StoreError> {
    let ms = lease.as_millis();
    let take = format!(
        "BEGIN; SET LOCAL idle_in_transaction_session_timeout = {ms}; SET LOCAL statement_timeout = {}; {} FOR UPDATE",
        ms + ms / 4,
        look(seen)
    );
    let limit = lease + lease / 2;
    match within(limit, sqlx::raw_sql(AssertSqlSafe(take)).fetch_one(&mut *connection)).await {
        Ok(row) => Ok(Found::of(&row, seen)?),
        Err(error) => {
            let _nothing_may_be_open = within(BREATH, sqlx::query("ROLLBACK").execute(connection)).await;
            Err(error.into())
        }
    }
}

/// Everything that a turn comes to, within a lease.
async fn write(
    connection: &mut PgConnection,
    changes: &Changes,
    next: &Standing,
    lease: Duration,
) -> Result<(), StoreError> {
    let mut batch = batch_of(changes);
    diagnosis::make_due(&changes.models, &mut batch);
    history::upsert(last_of_each(changes).into_iter(), &mut batch);
    let Commit { version, stamp } = next.commit;
    let work = async {
        batch.run(connection).await?;
        for (sql, names) in NAMED.into_iter().zip([&changes.imus, &changes.stations, &changes.gyros]) {
            let numbers: Vec<i64> = names.iter().map(|(number, _)| i64::from(*number)).collect();
            if !numbers.is_empty() {
                sqlx::query(sql).bind(version).bind(numbers).execute(&mut *connection).await?;
            }
        }
        let mut end = sqlx::query(END).bind(version).bind(stamp).bind(KEPT).bind(next.last_id);
        for version in next.kinds {
            end = end.bind(version);
        }
        end.bind(touched(changes)).execute(connection).await?;
        Ok(())
    };
    within(lease, work).await
}

/// The gyros to which something is done besides a new record.
fn touched(changes: &Changes) -> Option<String> {
    let withdrawn = &changes.withdrawn;
    let is_confirmed = |row: &&HistoryRow| changes.confirmed.iter().any(|it| it.record == row.figures.record);
    let confirmed = changes.history.iter().filter(is_confirmed).map(|row| row.gyro);
    let marked = changes.events.iter().map(|event| event.gyro).chain(changes.benches.iter().map(|bench| bench.gyro));
    let gone = withdrawn.history.iter().map(|row| row.gyro).chain(withdrawn.benches.iter().map(|(_, gyro)| *gyro));
    let alerted = changes.alerts.iter().map(|row| row.gyro);
    let gyros: BTreeSet<u32> = marked.chain(gone).chain(confirmed).chain(alerted).collect();
    (!gyros.is_empty()).then(|| serde_json::json!(gyros).to_string())
}

impl Store {
    /// The gyros to which something was done in commits after `version`, besides new records.
    ///
    /// # Errors
    /// [`StoreError`].
    pub async fn touched_since(&self, version: i64) -> Result<Vec<u32>, StoreError> {
        let Readers::Postgres(readers) = &self.readers else { return Ok(Vec::new()) };
        let sql = "SELECT gyros FROM turn_commit WHERE version > $1 AND gyros IS NOT NULL";
        let lists: Vec<String> = sqlx::query_scalar(sql).bind(version).fetch_all(readers).await?;
        let mut gyros = BTreeSet::new();
        for list in lists {
            let list: Vec<u32> = serde_json::from_str(&list).map_err(|error| StoreError::Damaged(error.to_string()))?;
            gyros.extend(list);
        }
        Ok(gyros.into_iter().collect())
    }
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
