//! Rows of many figures packed into one column; long texts.

pub(super) mod history_row;
pub(super) mod text;
pub(super) mod verdicts;
