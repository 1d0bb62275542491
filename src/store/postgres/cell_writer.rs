//! One writer among many: a transaction holds the cells that it is about, and no others.
//!
//! A group is admitted, judged and answered by what is stored, so that nothing may come between reading and writing
//! of the same gyros: whoever holds a cell alone reads and writes what is at home in it. Cells are locked in their
//! order, one a statement, so that writers never wait for one another in a ring. Names are kept unique by the
//! database; two that bring the same new name at once hinder each other, and the second tries again. So does who hears
//! of a name, and with it of a cell, only after the cells were chosen.

use std::collections::HashSet;
use std::time::{Duration, Instant};

use sqlx::{AssertSqlSafe, Connection, PgConnection};

use super::bounded::{BREATH, COMES_UP, PgReaders, within};
use super::cell_rows::{AllCells, COLUMNS, CellRow};
use super::hosts::Hosts;
use super::names;
use crate::message;
use crate::store::changes::batch_of;
use crate::store::name_tables::Names;
use crate::store::packed::history_row;
use crate::store::tables::diagnosis;
use crate::store::{Cells, ChangeTopic, Changes, HistoryRow, IdSource, Options, RemoteChanges, Result, StoreError};

/// How long it is kept which commits there were: longer than anybody waits to find out.
const COMMITS_KEPT_S: i64 = 600;

/// The writing side of one writer.
#[derive(Debug)]
pub(crate) struct CellWriter {
    hosts: Hosts,
    patience: Duration,
    lease: Duration,
    readers: PgReaders,
    names: Names,
    connection: Option<PgConnection>,
    opened: Instant,
    /// As this writer left them, or found them, last.
    seen: AllCells,
    /// What it holds.
    held: Vec<CellRow>,
}

impl CellWriter {
    pub async fn new(hosts: Hosts, options: &Options, readers: PgReaders, names: Names) -> Result<Self> {
        let (patience, lease) = (options.busy_timeout, options.lease);
        let seen = AllCells::look(&readers).await?;
        let opened = Instant::now();
        Ok(Self { hosts, patience, lease, readers, names, connection: None, opened, seen, held: Vec::new() })
    }

    /// Another writer on the same database.
    pub fn another(&self) -> Self {
        Self {
            hosts: self.hosts.clone(),
            patience: self.patience,
            lease: self.lease,
            readers: self.readers.clone(),
            names: self.names.clone(),
            connection: None,
            opened: self.opened,
            seen: self.seen,
            held: Vec::new(),
        }
    }

    /// See [`crate::store::Writer::lock_cells`]. Also where identifiers come from meanwhile.
    pub async fn lock_cells(&mut self, cells: &Cells) -> Result<(RemoteChanges, IdSource)> {
        debug_assert!(self.held.is_empty(), "what was held before has been given back");
        self.held = self.begin(cells).await?;
        let learned = names::learn_cells(&self.readers, &self.names, &self.held).await;
        if learned.is_err() {
            self.give_back().await;
        }
        learned?;
        let remote_changes = self.seen.learn(&self.held);
        let last = self.held.iter().map(|row| row.last_id).max().unwrap_or(0);
        Ok((remote_changes, IdSource::in_cell(self.held.first().map_or(0, |row| row.cell), last)))
    }

    /// A connection that has lain idle may have broken unnoticed: then a fresh one is tried.
    async fn begin(&mut self, cells: &Cells) -> Result<Vec<CellRow>> {
        let idle = self.connection.take().filter(|_| self.hosts.silence.is_before(self.opened.elapsed()));
        if let Some(mut connection) = idle {
            match lock(&mut connection, cells, self.lease).await {
                Ok(found) => {
                    self.connection = Some(connection);
                    return Ok(found);
                }
                Err(error) if !matches!(error, StoreError::Unreachable(_)) => return Err(error),
                Err(_) => self.hosts.silence.is_now(),
            }
        }
        self.opened = Instant::now();
        let mut connection = self.hosts.reach(self.patience).await?;
        let found = lock(&mut connection, cells, self.lease).await?;
        self.connection = Some(connection);
        Ok(found)
    }

    pub async fn give_back(&mut self) {
        if std::mem::take(&mut self.held).is_empty() {
            return;
        }
        if let Some(mut connection) = self.connection.take()
            && within(self.patience, sqlx::query("ROLLBACK").execute(&mut connection)).await.is_ok()
        {
            self.connection = Some(connection);
        }
    }

    /// See [`crate::store::Writer::commit`]. `last_id`: the greatest identifier that was given out.
    pub async fn commit(&mut self, changes: &Changes, last_id: i64) -> Result<()> {
        if self.held.is_empty() {
            return Err(StoreError::Unreachable(message!("server_cells_lost")));
        }
        if let Some(gyro) = self.not_held(changes) {
            self.give_back().await;
            return Err(StoreError::Overtaken(format!("gyro number {gyro} was heard of after the cells were chosen")));
        }
        // Back in its place only when all has gone well: one on which an answer is still due is of no use.
        let Some(mut connection) = self.connection.take() else {
            self.held.clear();
            return Err(StoreError::Unreachable(message!("server_connection_lost")));
        };
        let next = self.after(changes, last_id);
        if let Err(error) = write(&mut connection, changes, &next, self.lease).await {
            match error {
                StoreError::Unreachable(_) => self.hosts.silence.is_now(),
                _ => self.connection = Some(connection),
            }
            self.give_back().await;
            if matches!(error, StoreError::Overtaken(_)) {
                // A name may have been lost with a commit, and what it stood for with it.
                names::learn_all(&self.readers, &self.names).await?;
            }
            return Err(error);
        }
        self.held.clear();
        match within(self.lease, sqlx::query("COMMIT").execute(&mut connection)).await {
            Ok(_) => self.connection = Some(connection),
            Err(error) => {
                drop(connection);
                self.find_out(&next[0], error.into()).await?;
            }
        }
        if changes.brings(ChangeTopic::Names) {
            let stamps = next.iter().map(|row| (usize::from(row.cell), row.stamp_of(ChangeTopic::Names)));
            self.names.change(|tables| {
                tables.enter(changes.new_names());
                stamps.for_each(|(place, stamp)| tables.seen[place] = stamp);
            });
        }
        self.seen.learn(&next);
        Ok(())
    }

    /// A gyro that `changes` touch and that is at home in no cell that is held: what was read of it need not hold any
    /// more. Its name has come from another writer after the cells were chosen.
    fn not_held(&self, changes: &Changes) -> Option<u32> {
        let tables = self.names.read();
        let new: HashSet<u32> = changes.gyros.iter().map(|new| new.number).collect();
        let is_held = |cell: u8| self.held.iter().any(|row| row.cell == cell);
        let touched = changes.heads.rows.iter().map(|row| row.gyro);
        touched.filter(|gyro| !new.contains(gyro)).find(|gyro| !tables.gyros.cell(*gyro).is_some_and(is_held))
    }

    fn after(&self, changes: &Changes, last_id: i64) -> Vec<CellRow> {
        let stamp = rand::random_range(1..i64::MAX);
        let after = |row: &CellRow| {
            let mut next = CellRow { stamp, last_id: last_id.max(row.last_id), ..*row };
            for topic in ChangeTopic::ALL.into_iter().filter(|topic| changes.brings(*topic)) {
                next.topics[topic as usize] = stamp;
            }
            next
        };
        self.held.iter().map(after).collect()
    }

    /// The connection broke in the middle of a commit: whether it came about, the database knows.
    async fn find_out(&mut self, commit: &CellRow, error: StoreError) -> Result<()> {
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

    /// Whether the database has a commit of this writer's, once whatever it had under way has come to its end.
    async fn has(&self, commit: &CellRow) -> Result<bool> {
        let mut connection = self.hosts.reach(self.patience).await?;
        // Until then it holds the cell.
        lock(&mut connection, &Cells::from([commit.cell]), self.lease).await?;
        let sql = "SELECT count(*) > 0 FROM cell_commit WHERE cell = $1 AND stamp = $2";
        let found = sqlx::query_scalar(sql).bind(i64::from(commit.cell)).bind(commit.stamp).fetch_one(&mut connection);
        let found = within(self.patience, found).await?;
        within(self.patience, sqlx::query("ROLLBACK").execute(&mut connection)).await?;
        Ok(found)
    }

    /// Whether a cell can be had and the database takes a write.
    pub async fn probe(&mut self) -> Result<()> {
        if !self.held.is_empty() {
            return Ok(());
        }
        // What others have written meanwhile is still to be looked at by whoever holds the cell next.
        self.held = self.begin(&Cells::from([0])).await?;
        let Some(connection) = &mut self.connection else { return Ok(()) };
        let write = sqlx::query("UPDATE cell SET stamp = stamp WHERE cell = 0");
        let written = within(self.lease, write.execute(connection)).await;
        if written.is_err() {
            self.connection = None;
        }
        self.give_back().await;
        written?;
        Ok(())
    }

    pub async fn close(mut self) -> Result<()> {
        self.give_back().await;
        if let Some(connection) = self.connection.take() {
            within(self.patience, connection.close()).await?;
        }
        Ok(())
    }
}

/// Begins a transaction and waits for its cells. A server that vanishes within its own loses them after its lease:
/// nobody has to wait for longer, and a server that has not heard by then never will.
async fn lock(connection: &mut PgConnection, cells: &Cells, lease: Duration) -> Result<Vec<CellRow>> {
    let ms = lease.as_millis();
    let mut take = format!(
        "BEGIN; SET LOCAL idle_in_transaction_session_timeout = {ms}; SET LOCAL statement_timeout = {}",
        ms + ms / 4
    );
    for cell in cells {
        take.push_str(&format!("; {COLUMNS} WHERE cell = {cell} FOR UPDATE"));
    }
    let limit = lease + lease / 2;
    let locked = within(limit, sqlx::raw_sql(AssertSqlSafe(take)).fetch_all(&mut *connection)).await;
    let rows = locked.map_err(StoreError::from).and_then(|rows| rows.iter().map(CellRow::of).collect());
    if rows.is_err() {
        let _nothing_may_be_open = within(BREATH, sqlx::query("ROLLBACK").execute(connection)).await;
    }
    rows
}

/// Everything that a transaction comes to, within a lease.
async fn write(connection: &mut PgConnection, changes: &Changes, next: &[CellRow], lease: Duration) -> Result<()> {
    let mut batch = batch_of(changes);
    diagnosis::make_due(&changes.models, &mut batch);
    history_row::upsert(last_of_each(changes), &mut batch);
    let (first, cells) = (next[0], next.iter().map(|row| i64::from(row.cell)).collect::<Vec<_>>());
    let is_new =
        |topic: ChangeTopic| if changes.brings(topic) { format!(", {} = $2", topic.name()) } else { String::new() };
    let set = ChangeTopic::ALL.map(is_new).concat();
    let end = format!(
        "WITH made AS (INSERT INTO cell_commit (cell, at, stamp) VALUES ($1, now(), $2)),
              forgotten AS (DELETE FROM cell_commit WHERE cell = $1 AND at < now() - $5 * INTERVAL '1 second')
         UPDATE cell SET stamp = $2, last_id = $3{set} WHERE cell = ANY($4)"
    );
    let work = async {
        batch.run(connection).await?;
        let end = sqlx::query(AssertSqlSafe(end)).bind(i64::from(first.cell)).bind(first.stamp).bind(first.last_id);
        end.bind(cells).bind(COMMITS_KEPT_S).execute(connection).await?;
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
