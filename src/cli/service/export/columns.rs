//! The columns of an exported history, once for every form that it is written in.

use std::sync::Arc;

use crate::core::figures::Figures;
use crate::core::judge::{State, Status};
use crate::core::time::UtcMicros;

/// One gyro in one calibration.
#[derive(Debug, Clone)]
pub struct ExportRow {
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
pub enum CellValue {
    Text(fn(&ExportRow) -> String),
    /// None where nothing was said.
    Word(fn(&ExportRow) -> Option<&'static str>),
    Instant(fn(&ExportRow) -> UtcMicros),
    /// None where it is not known.
    Number(fn(&ExportRow) -> Option<f64>),
    Count(fn(&ExportRow) -> Option<i32>),
    Flag(fn(&ExportRow) -> bool),
}

pub struct ExportColumn {
    pub name: &'static str,
    pub cells: CellValue,
}

/// Drifts, closures and standard deviations are in deg/(h g0).
pub const COLUMNS: [ExportColumn; 27] = [
    column("serial", CellValue::Text(|row| row.serial.to_string())),
    column("calibrated_at", CellValue::Instant(|row| row.figures.at)),
    column("imu", CellValue::Text(|row| row.imu.to_string())),
    column("slot", CellValue::Word(|row| Some(row.figures.slot.name()))),
    column("station", CellValue::Text(|row| row.station.to_string())),
    column("record", CellValue::Text(|row| row.figures.record.to_string())),
    column("rigid_D_I", CellValue::Number(|row| Some(row.figures.rigid[0]))),
    column("rigid_D_S", CellValue::Number(|row| Some(row.figures.rigid[1]))),
    column("rigid_D_O", CellValue::Number(|row| Some(row.figures.rigid[2]))),
    column("rigid_D_I_sd", CellValue::Number(|row| row.figures.rigid_sd.map(|sd| sd[0]))),
    column("rigid_D_S_sd", CellValue::Number(|row| row.figures.rigid_sd.map(|sd| sd[1]))),
    column("rigid_D_O_sd", CellValue::Number(|row| row.figures.rigid_sd.map(|sd| sd[2]))),
    column("published_D_I", CellValue::Number(|row| row.figures.published.map(|it| it.d[0]))),
    column("published_D_S", CellValue::Number(|row| row.figures.published.map(|it| it.d[1]))),
    column("published_D_I_sd", CellValue::Number(|row| row.figures.published?.sd.map(|sd| sd[0]))),
    column("published_D_S_sd", CellValue::Number(|row| row.figures.published?.sd.map(|sd| sd[1]))),
    column("published_closure_rms", CellValue::Number(|row| row.figures.published.map(|it| it.closure_rms))),
    column("published_equation", CellValue::Count(|row| row.figures.published.map(|it| it.branch.into()))),
    column("D_I_state", CellValue::Word(|row| state(row.figures.states.0[0]))),
    column("D_S_state", CellValue::Word(|row| state(row.figures.states.0[1]))),
    column("D_O_state", CellValue::Word(|row| state(row.figures.states.0[2]))),
    column("state", CellValue::Word(|row| state(row.figures.states.worst()))),
    column("voided", CellValue::Flag(|row| row.voided)),
    column("D_I_status", CellValue::Word(|row| Some(row.statuses[0].name()))),
    column("D_S_status", CellValue::Word(|row| Some(row.statuses[1].name()))),
    column("D_O_status", CellValue::Word(|row| Some(row.statuses[2].name()))),
    column("status", CellValue::Word(|row| Some(row.status.name()))),
];

const fn column(name: &'static str, cells: CellValue) -> ExportColumn {
    ExportColumn { name, cells }
}

/// As trends have it: what no rule could judge is indeterminate.
fn state(judged: Option<State>) -> Option<&'static str> {
    Some(judged.unwrap_or(State::Indeterminate).name())
}
