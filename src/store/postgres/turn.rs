//! The writer's turn: one server writes at a time.
//!
//! A group is admitted, judged and answered by what is stored, so that nothing may come between reading and writing:
//! numbers of names, idempotency, the order of identifiers, what an alert was before. The turn is the lock of one
//! row, held for one transaction. Row locks or serialisable transactions would let two groups through that touch
//! different gyros, and take a new kind of care for each of these; a turn takes none, and costs a group one question
//! more.

use std::time::{Duration, Instant};

use sqlx::{AssertSqlSafe, Connection, PgConnection};

use super::hosts::Hosts;
use super::standing::{Found, Missed, Standing, look, touched};
use super::{BREATH, COMES_UP, PgReaders, names, within};
use crate::store::commit::{Changes, batch_of};
use crate::store::error::StoreError;
use crate::store::open::Options;
use crate::store::tables::diagnosis;
use crate::store::tables::history;
use crate::store::tables::history::HistoryRow;
use crate::store::tables::names::{Commit, Names};

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

/// The writing side of one server.
#[derive(Debug)]
pub(crate) struct ServerWriter {
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

/// Begins a transaction and waits for the turn. A server that vanishes within its own loses it after its lease:
/// nobody has to wait for longer, and a server that has not heard by then never will.
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
