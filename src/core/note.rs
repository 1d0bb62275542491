//! Notes on an item that is accepted: what a reader should know before relying on its figures. Kinds and parameters
//! only; words are made at the edge ([`crate::wire::note`]).

use super::campaign::CampaignNote;
use super::effects::Effect;
use super::history_note::HistoryNote;
use super::mounting::Slot;

/// One thing worth knowing about an accepted item.
#[derive(Debug, Clone, PartialEq)]
pub enum Note {
    /// Specific force and rate were not checked against the attitude.
    NoAttitudes,
    /// The specific force of static dwells was checked against standard gravity.
    NoSite,
    /// Effects of temperature cannot be seen.
    NoTemperatures,
    /// The model of the IMU states D_I and D_S at one temperature, and this record states none.
    AnyTemperature,
    /// The model of the IMU states D_I and D_S at one temperature, but knows an effect of temperature of another gyro
    /// in this slot, or of all gyros in common: this record's stay as measured.
    NotRestated { slot: Slot, effect: Effect },
    /// The last line of its table has no end: where the file was cut, so was its last number.
    NoLineEnd { line: usize, value: String },
    /// It was stored before, and was voided, set aside or replaced since.
    Withdrawn,
    /// Of a campaign's dwells and their fit.
    Campaign(CampaignNote),
    /// Beside what is known of its IMU and gyros.
    History(HistoryNote),
}

impl Note {
    /// Its name in answers; never changes once it has been given out.
    pub fn code(&self) -> &'static str {
        match self {
            Note::NoAttitudes => "no_attitudes",
            Note::NoSite => "no_site",
            Note::NoTemperatures => "no_temperatures",
            Note::AnyTemperature => "any_temperature_of_record",
            Note::NotRestated { .. } => "not_restated",
            Note::NoLineEnd { .. } => "no_line_end",
            Note::Withdrawn => "withdrawn",
            Note::Campaign(note) => note.code(),
            Note::History(note) => note.code(),
        }
    }
}
