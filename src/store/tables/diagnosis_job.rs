//! Orders to diagnose many campaigns at once, and how far each has come.
//!
//! The tasks of an order are its queue: one is waiting until it is done, has failed or is canceled, so that nothing
//! is lost with whoever was at work on it. A diagnosis settles every task that waits for its campaign, in the
//! transaction that keeps it.

use super::*;

/// An order as it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobRow {
    pub id: Id,
    pub asked_at: UtcMicros,
    pub asked_by: String,
    /// Which campaigns, as clients read it (JSON).
    pub asked: String,
    pub canceled: bool,
    pub begun_at: Option<UtcMicros>,
    pub ended_at: Option<UtcMicros>,
}

/// Which stored campaigns; those that count no more are never meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CampaignFilter {
    pub imu: Option<u32>,
    pub station: Option<u32>,
    pub measured: Span,
}

/// An order that begins.
#[derive(Debug, PartialEq)]
pub struct NewJob {
    pub id: Id,
    pub asked_at: UtcMicros,
    pub asked_by: String,
    pub asked: String,
    pub which: CampaignFilter,
    /// Also those whose diagnosis is of this program and the model in force.
    pub again: bool,
    pub program: String,
}

/// A campaign whose diagnosis has come to its end.
#[derive(Debug, PartialEq)]
pub struct FinishedTask {
    pub record: Id,
    pub begun_at: UtcMicros,
    pub ended_at: UtcMicros,
    /// Why there is none.
    pub failed: Option<String>,
}

/// What changes about orders; see [`crate::store::Changes`].
#[derive(Debug, Default, PartialEq)]
pub struct JobChanges {
    pub started: Vec<NewJob>,
    /// Which, and when.
    pub canceled: Vec<(Id, UtcMicros)>,
    pub settled: Vec<FinishedTask>,
}

/// How many tasks of an order are in each state.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TaskCounts {
    pub waiting: u64,
    pub done: u64,
    pub failed: u64,
    pub canceled: u64,
}

/// A campaign of an order that could not be diagnosed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FailedTask {
    pub record: Id,
    pub imu: u32,
    pub measured_at: UtcMicros,
    pub reason: String,
}

columns! {
    FailedTask in "diagnosis_task" { record, imu, measured_at, reason }
}

/// Comes after diagnoses were kept in the same transaction.
pub(crate) fn apply(changes: &JobChanges, batch: &mut Batch) {
    start(&changes.started, batch);
    settle(&changes.settled, batch);
    cancel(&changes.canceled, batch);
}

fn start(jobs: &[NewJob], batch: &mut Batch) {
    let orders = Rows::each(jobs, |job, row| {
        row.put(&job.id).put(&job.asked_at).put(&job.asked_by).put(&job.asked).put(&false);
    });
    let tasks = Rows::each(jobs, |NewJob { id, which, again, program, .. }, row| {
        row.put(id).put(&which.imu).put(&which.station).put(&which.measured.from).put(&which.measured.to);
        row.put(again).put(program);
    });
    let ends = Rows::of(jobs.iter().map(|job| (job.id, job.asked_at)));
    batch.insert("diagnosis_job", "id, asked_at, asked_by, asked, canceled", OnConflict::Fail, orders);
    batch.change(
        "INSERT INTO diagnosis_task (job, record, state, reason)
         SELECT job, record, CASE WHEN NOT made THEN 'waiting' WHEN refused <> 0 THEN 'failed' ELSE 'done' END,
             CASE WHEN made AND refused <> 0 THEN (SELECT body FROM diagnosis WHERE diagnosis.record = chosen.record) END
         FROM (SELECT $C0 AS job, record.id AS record, diagnosis.refused AS refused,
                   $C5 = 0 AND diagnosis.program IS NOT DISTINCT FROM $C6 AND diagnosis.model IS NOT DISTINCT FROM
                       (SELECT max(id) FROM imu_model WHERE imu_model.imu = record.imu) AS made
               FROM record JOIN diagnosis ON diagnosis.record = record.id",
        "record.kind = 1 AND record.calibrated_at BETWEEN $C3 AND $C4
             AND ($C1 IS NULL OR record.imu = $C1) AND ($C2 IS NULL OR record.station = $C2)
             AND record.id NOT IN (SELECT item FROM correction)) AS chosen",
        tasks,
    );
    let at_end = format!("id = $C0 AND NOT {WAITS}");
    batch.change("UPDATE diagnosis_job SET begun_at = $C1, ended_at = $C1", at_end, ends);
}

const WAITS: &str = "EXISTS (SELECT 1 FROM diagnosis_task WHERE job = diagnosis_job.id AND state = 'waiting')";

fn settle(settled: &[FinishedTask], batch: &mut Batch) {
    let tasks = Rows::each(settled, |task, row| _ = row.put(&task.record).put(&task.failed));
    let orders = Rows::of(settled.iter().map(|task| (task.record, task.begun_at, task.ended_at)));
    batch.change(
        "UPDATE diagnosis_task SET state = CASE WHEN $C1 IS NULL THEN 'done' ELSE 'failed' END, reason = $C1",
        "record = $C0 AND state = 'waiting'",
        tasks,
    );
    batch.change(
        format!(
            "UPDATE diagnosis_job SET begun_at = coalesce(begun_at, $C1), ended_at = CASE WHEN NOT {WAITS} THEN $C2 END"
        ),
        "ended_at IS NULL AND EXISTS (SELECT 1 FROM diagnosis_task WHERE job = diagnosis_job.id AND record = $C0)",
        orders,
    );
}

fn cancel(canceled: &[(Id, UtcMicros)], batch: &mut Batch) {
    let (canceled_task, canceled_job) =
        ("UPDATE diagnosis_task SET state = 'canceled'", "UPDATE diagnosis_job SET canceled = 1, ended_at = $C1");
    batch.change(canceled_task, "job = $C0 AND state = 'waiting'", Rows::of(canceled.iter().copied()));
    batch.change(canceled_job, "id = $C0 AND ended_at IS NULL", Rows::of(canceled.iter().copied()));
}

columns! {
    JobRow in "diagnosis_job" { id, asked_at, asked_by, asked, canceled, begun_at, ended_at }
}

/// Orders, newest first, those before `before`.
pub async fn list(store: &Store, before: Option<Id>, limit: u32) -> Result<Vec<JobRow>> {
    let before = before.map_or(i64::MAX, |id| id.0);
    read!(store, all, JobRow::select("WHERE id < $1 ORDER BY id DESC LIMIT $2"), before, limit)
}

pub async fn get(store: &Store, id: Id) -> Result<Option<JobRow>> {
    read!(store, first, JobRow::select("WHERE id = $1"), id.0)
}

/// The order in the same words that has not ended yet.
pub async fn open_as_asked(store: &Store, asked: &str) -> Result<Option<Id>> {
    let sql = "SELECT id FROM diagnosis_job WHERE ended_at IS NULL AND asked = $1";
    read!(store, first, sql, asked)
}

pub async fn task_counts(store: &Store, job: Id) -> Result<TaskCounts> {
    let sql = "SELECT state, count(*) FROM diagnosis_task WHERE job = $1 GROUP BY state";
    let rows: Vec<(String, u64)> = read!(store, all, sql, job)?;
    let mut counts = TaskCounts::default();
    for (state, count) in rows {
        let of_state = match state.as_str() {
            "waiting" => &mut counts.waiting,
            "done" => &mut counts.done,
            "failed" => &mut counts.failed,
            _ => &mut counts.canceled,
        };
        *of_state += count;
    }
    Ok(counts)
}

/// What failed, in the order of storing, from after `after` on.
pub async fn failed_tasks(store: &Store, job: Id, after: Option<Id>, limit: u32) -> Result<Vec<FailedTask>> {
    let sql = "SELECT record.id AS record, record.imu, record.calibrated_at AS measured_at, reason FROM diagnosis_task
               JOIN record ON record.id = diagnosis_task.record
               WHERE job = $1 AND record > $2 AND state = 'failed' ORDER BY record LIMIT $3";
    read!(store, all, sql, job, after.map_or(i64::MIN, |id| id.0), limit)
}

/// Campaigns that orders wait for, of the oldest order first.
pub async fn tasks_waiting(store: &Store, limit: u32) -> Result<Vec<Id>> {
    let sql = "SELECT record FROM diagnosis_task WHERE state = 'waiting' ORDER BY job, record LIMIT $1";
    let mut found: Vec<Id> = read!(store, all, sql, limit)?;
    let mut seen = std::collections::HashSet::new();
    found.retain(|record| seen.insert(*record));
    Ok(found)
}

/// How many campaigns wait for their first diagnosis, and how many tasks of orders wait.
pub async fn diagnoses_waiting(store: &Store) -> Result<(u64, u64)> {
    let sql = "SELECT (SELECT count(*) FROM diagnosis WHERE body IS NULL),
                      (SELECT count(*) FROM diagnosis_task WHERE state = 'waiting')";
    read!(store, one, sql)
}
