//! Silences of every alert that matches.

use super::alerts::Remark;
use crate::core::alert_filter::Matchers;
use crate::core::id::Id;
use crate::core::judge::Rule;
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, Rows};
use crate::store::db::{AnyRow, cell, insert, on};
use crate::store::error::StoreError;
use crate::store::handle::Store;

/// Nobody is told of the alerts that match, before a time or until somebody ends it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SilenceRow {
    pub id: Id,
    pub matchers: Matchers,
    pub until: UtcMicros,
    pub said: Remark,
    pub ended: Option<Remark>,
}

pub(crate) fn upsert(silences: &[SilenceRow], batch: &mut Batch) {
    let mut rows = Rows::default();
    for SilenceRow { id, matchers, until, said, ended } in silences {
        let ended = ended.as_ref();
        rows.row()
            .integer(id.0)
            .optional_text(matchers.serial.as_deref())
            .optional_text(matchers.imu.as_deref())
            .optional_text(matchers.station.as_deref())
            .optional_text(matchers.rule.map(Rule::name))
            .integer(until.0)
            .text(&said.by)
            .text(&said.reason)
            .integer(said.at.0)
            .optional_integer(ended.map(|ended| ended.at.0))
            .optional_text(ended.map(|ended| ended.by.as_str()))
            .optional_text(ended.map(|ended| ended.reason.as_str()));
    }
    batch.add(
        insert!(
            "silence (id, serial, imu, station, rule, until, author, reason, at, ended_at, ended_by, ended_reason)",
            [int 0, text 1, text 2, text 3, text 4, int 5, text 6, text 7, int 8, int 9, text 10, text 11],
            "ON CONFLICT (id) DO UPDATE SET (ended_at, ended_by, ended_reason) =
             (excluded.ended_at, excluded.ended_by, excluded.ended_reason)"
        ),
        rows,
    );
}

fn silence(row: &impl AnyRow) -> Result<SilenceRow, StoreError> {
    let id = Id(row.cell("id")?);
    let rule: Option<String> = row.cell("rule")?;
    let unknown = || StoreError::Damaged(format!("silence {id}: unknown rule"));
    let rule = rule.map(|name| Rule::from_name(&name).ok_or_else(unknown)).transpose()?;
    let ended: Option<i64> = row.cell("ended_at")?;
    let (by, reason): (Option<String>, Option<String>) = (row.cell("ended_by")?, row.cell("ended_reason")?);
    Ok(SilenceRow {
        id,
        matchers: Matchers { serial: row.cell("serial")?, imu: row.cell("imu")?, station: row.cell("station")?, rule },
        until: UtcMicros(row.cell("until")?),
        said: Remark { by: row.cell("author")?, reason: row.cell("reason")?, at: UtcMicros(row.cell("at")?) },
        ended: ended.zip(by).zip(reason).map(|((at, by), reason)| Remark { by, reason, at: UtcMicros(at) }),
    })
}

const COLUMNS: &str =
    "SELECT id, serial, imu, station, rule, until, author, reason, at, ended_at, ended_by, ended_reason FROM silence";

/// Silences in force at `now`, or all that there ever were; the newest first.
pub async fn list(store: &Store, in_force_at: Option<UtcMicros>, limit: u32) -> Result<Vec<SilenceRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!(
        "{COLUMNS} WHERE ($1 IS NULL OR (until > $1 AND ended_at IS NULL)) ORDER BY id DESC LIMIT $2"
    ));
    on!(store.readers, db => sqlx::query(sql)
        .bind(in_force_at.map(|at| at.0))
        .bind(crate::store::db::Whole(limit))
        .fetch_all(db)
        .await?.iter().map(silence).collect())
}

pub async fn get(store: &Store, id: Id) -> Result<Option<SilenceRow>, StoreError> {
    let sql = sqlx::AssertSqlSafe(format!("{COLUMNS} WHERE id = $1"));
    on!(store.readers, db => sqlx::query(sql).bind(id.0).fetch_optional(db).await?.as_ref().map(silence).transpose())
}
