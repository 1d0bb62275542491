//! Rows of many figures packed into one column.

pub(super) mod history_row;
pub(super) mod verdicts;
