//! Alerts, in step with what is stored: every change of a group's verdicts becomes a step of an alert, written in the
//! transaction of the records that caused it.
//!
//! The book holds every alert in memory (there are as many as troubled gyros, not as records), so that a record whose
//! verdicts are all within costs one look into a map. Deciding is the core's ([`crate::core::alert_decision`]); this keeps the
//! states, finds what each verdict is about, and writes down what became of it.

mod body;
mod book;
mod orders;
mod silences;
mod sources;

pub use orders::{AlertChange, AlertOrder, AlertRecord, AlertStep};
pub use silences::SilenceOrder;

pub(super) use body::{Naming, Origin, finding_of, status_of};
pub(super) use book::{AlertBook, News, Pen};
pub(super) use sources::{Causes, follow_clock, follow_group};
