//! What is kept, on SQLite or PostgreSQL: opening and migrating, writing in groups, reading.
//!
//! One connection writes ([`Writer`]), a pool reads ([`Store`]). Rows are plain types of this module; converting
//! them to and from the core's types and the wire's is the pipeline's and the edge's work.

mod access;
mod alerts;
mod batch;
mod bench;
mod commit;
mod copy;
mod correction;
mod db;
mod delivery;
mod delivery_line;
mod diagnosis;
mod diagnosis_job;
mod error;
mod event;
mod gist;
mod gyro;
mod histories;
mod history;
mod hook;
mod id;
mod keys;
mod model;
mod names;
mod open;
mod outbox;
mod packed;
mod postgres;
mod record;
mod secrets;
mod set_aside;
mod silence;
mod sqlite;

pub use crate::store::packed::history_row::{Figures, PublishedFigures, States};
pub use crate::store::packed::verdicts::{StoredVerdict, VerdictSheet};
pub use crate::store::sqlite::backup::{
    Holdings, backup, check, check_all_but_records, check_checksums, open_to_read, restore,
};
pub use access::{AccessChanges, AuditFilter, AuditRow, Beside, SessionRow, TokenRow};
pub use alerts::{AlertFilter, AlertRow, Remark, StepRow};
pub use bench::BenchRow;
pub use commit::{Changes, Committer, Rejudged, Writer, Written};
pub use copy::{Copied, copy};
pub use correction::{CorrectionRow, GyroCorrection, Withdrawn};
pub use delivery::{
    AttemptRow, DeliveryRow, DeliveryState, DueDelivery, NewDelivery, OutboxChanges, Part, Progress, QueueState,
    Subject,
};
pub use diagnosis::{DiagnosisRow, NewDiagnosis};
pub use diagnosis_job::{CampaignFilter, FailedTask, JobChanges, JobRow, NewJob, SettledTask, TaskCounts};
pub use error::StoreError;
pub use event::EventRow;
pub use gist::GistRow;
pub use histories::Stretch;
pub use history::{HistoryRow, Span};
pub use hook::HookRow;
pub use id::{Id, IdSource};
pub use keys::KeyRow;
pub use model::ModelRow;
pub use names::{Names, Table, Tables};
pub use open::{Options, Store, open};
pub use postgres::{Duty, Missed, Moves};
pub use record::{Kind, RecordAt, RecordHead, RecordRow};
pub use secrets::Secrets;
pub use set_aside::{ConfirmationRow, SetAside};
pub use silence::{Matchers, SilenceRow};

#[cfg(test)]
mod calendar_tests;
#[cfg(test)]
mod outbox_tests;
#[cfg(test)]
mod tail_tests;
#[cfg(test)]
mod tests;
