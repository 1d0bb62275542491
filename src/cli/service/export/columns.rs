//! The columns of an exported history, once for every form that it is written in.

use std::sync::Arc;

use crate::core::figures::Figures;
use crate::core::judge::{State, Status};
use crate::core::time::UtcMicros;

/// One gyro in one calibration.
#[derive(Debug, Clone)]
pub struct Row {
    pub serial: Arc<str>,
    pub imu: Arc<str>,
    pub station: Arc<str>,
    pub figures: Figures,
    /// Of D_I, D_S and D_O.
    pub statuses: [Status; 3],
    /// The worst of those that could be judged.
    pub status: Status,
    /// It does not count any more.
    pub voided: bool,
}

/// What a column holds of each row.
#[derive(Clone, Copy)]
pub enum Cells {
    Text(fn(&Row) -> String),
    /// None where nothing was said.
    Word(fn(&Row) -> Option<&'static str>),
    Instant(fn(&Row) -> UtcMicros),
    /// None where it is not known.
    Number(fn(&Row) -> Option<f64>),
    Count(fn(&Row) -> Option<i32>),
    Flag(fn(&Row) -> bool),
}

pub struct Column {
    pub name: &'static str,
    pub cells: Cells,
}

/// Drifts, closures and standard deviations are in deg/(h g0).
pub const COLUMNS: [Column; 27] = [
    column("serial", Cells::Text(|row| row.serial.to_string())),
    column("calibrated_at", Cells::Instant(|row| row.figures.at)),
    column("imu", Cells::Text(|row| row.imu.to_string())),
    column("slot", Cells::Word(|row| Some(row.figures.slot.name()))),
    column("station", Cells::Text(|row| row.station.to_string())),
    column("record", Cells::Text(|row| row.figures.record.to_string())),
    column("rigid_D_I", Cells::Number(|row| Some(row.figures.rigid[0]))),
    column("rigid_D_S", Cells::Number(|row| Some(row.figures.rigid[1]))),
    column("rigid_D_O", Cells::Number(|row| Some(row.figures.rigid[2]))),
    column("rigid_D_I_sd", Cells::Number(|row| row.figures.rigid_sd.map(|sd| sd[0]))),
    column("rigid_D_S_sd", Cells::Number(|row| row.figures.rigid_sd.map(|sd| sd[1]))),
    column("rigid_D_O_sd", Cells::Number(|row| row.figures.rigid_sd.map(|sd| sd[2]))),
    column("published_D_I", Cells::Number(|row| row.figures.published.map(|it| it.d[0]))),
    column("published_D_S", Cells::Number(|row| row.figures.published.map(|it| it.d[1]))),
    column("published_D_I_sd", Cells::Number(|row| row.figures.published?.sd.map(|sd| sd[0]))),
    column("published_D_S_sd", Cells::Number(|row| row.figures.published?.sd.map(|sd| sd[1]))),
    column("published_closure_rms", Cells::Number(|row| row.figures.published.map(|it| it.closure_rms))),
    column("published_equation", Cells::Count(|row| row.figures.published.map(|it| it.branch.into()))),
    column("D_I_state", Cells::Word(|row| state(row.figures.states.0[0]))),
    column("D_S_state", Cells::Word(|row| state(row.figures.states.0[1]))),
    column("D_O_state", Cells::Word(|row| state(row.figures.states.0[2]))),
    column("state", Cells::Word(|row| state(row.figures.states.worst()))),
    column("voided", Cells::Flag(|row| row.voided)),
    column("D_I_status", Cells::Word(|row| Some(row.statuses[0].name()))),
    column("D_S_status", Cells::Word(|row| Some(row.statuses[1].name()))),
    column("D_O_status", Cells::Word(|row| Some(row.statuses[2].name()))),
    column("status", Cells::Word(|row| Some(row.status.name()))),
];

const fn column(name: &'static str, cells: Cells) -> Column {
    Column { name, cells }
}

/// As trends have it: what no rule could judge is indeterminate.
fn state(judged: Option<State>) -> Option<&'static str> {
    Some(judged.unwrap_or(State::Indeterminate).name())
}
