//! The way of a record, a campaign or a bench result: read, admitted, judged, stored with its alerts, answered.

pub(super) mod admit;
pub(super) mod campaign;
pub(super) mod document;
pub(super) mod judge;
pub(super) mod preview;
pub(super) mod reply;
pub(super) mod same_content;
pub(super) mod submission;
pub(super) mod writer;
