//! What is kept, on SQLite or PostgreSQL: opening and migrating, writing in groups, reading.
//!
//! One connection writes ([`Writer`]), a pool reads ([`Store`]). Rows are plain types of this module; converting
//! them to and from the core's types and the wire's is the pipeline's and the edge's work.

mod batch;
mod cells;
mod changes;
mod columns;
mod copy;
mod db;
mod error;
mod handle;
mod id;
mod name_tables;
mod open;
mod packed;
mod postgres;
mod rows;
mod secrets;
mod shared;
mod sqlite;
mod tables;
mod token_database;
mod writer;

pub use crate::store::name_tables::{NamesOf, NewName, Table, Tables};
pub use crate::store::packed::history_row::HistoryRow;
pub use crate::store::packed::verdicts::{RecordVerdicts, StoredVerdict};
pub(crate) use crate::store::postgres::hosts::without_password;
pub use crate::store::sqlite::backup::{
    BackupContents, backup, check, check_all_but_records, check_checksums, open_to_read, restore,
};
pub use crate::store::tables::access::{AccessChanges, SessionRow};
pub use crate::store::tables::alerts::{AlertOf, AlertRow, ExcessRow, Remark, StepRow};
pub use crate::store::tables::delivery::{
    AttemptRow, DeliveryRow, DeliverySubject, DueDelivery, NewDelivery, OutboxChanges, Part, Progress,
};
pub use crate::store::tables::diagnosis::{DiagnosisRow, NewDiagnosis};
pub use crate::store::tables::diagnosis_digest::DigestRow;
pub use crate::store::tables::diagnosis_job::{
    CampaignFilter, FailedTask, FinishedTask, JobChanges, JobRow, NewJob, TaskCounts,
};
pub use crate::store::tables::event::EventRow;
pub use crate::store::tables::gyro_attribute::GyroAttributeRow;
pub use crate::store::tables::head::{HeadChanges, HeadRow, HeadsMade, NewestRow};
pub use crate::store::tables::histories::Stretch;
pub use crate::store::tables::hook::{DeadLetters, HookRow};
pub use crate::store::tables::hypothesis::HypothesisRow;
pub use crate::store::tables::keys::KeyRow;
pub use crate::store::tables::model::ModelRow;
pub use crate::store::tables::record::{
    LongText, PackedText, RecordAt, RecordFilter, RecordRow, RejudgedVerdicts, StationTotals,
};
pub use crate::store::tables::set_aside::{ConfirmationRow, SetAsideRecord};
pub use crate::store::tables::silence::SilenceRow;
pub use crate::store::tables::suspect_window::WindowMarkRow;
pub use cells::{Cells, all_cells};
pub use changes::{Changes, RestatedRow};
pub use copy::{Copied, copy};
pub use error::{Result, StoreError};
pub use handle::{Options, Store};
pub use id::IdSource;
pub use open::{hide_stored_secrets, open};
pub use postgres::{ChangeFeed, ChangeTopic, LeasedTask, RemoteChanges, claim};
pub use secrets::Secrets;
pub use token_database::TokenDatabase;
pub use writer::{Committer, Writer, Written};

pub use tables::{
    access, alerts, bench, correction, delivery, diagnosis, diagnosis_digest, diagnosis_job, event, gyro_attribute,
    head, histories, history, hook, hypothesis, keys, model, names, record, set_aside, silence, suspect_window,
};

#[cfg(test)]
mod tests;
