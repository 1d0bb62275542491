//! Why a campaign cannot be held against the model, or shows nothing of an effect.

use crate::core::message::Message;
use crate::message;

/// Why a campaign cannot be diagnosed at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", self.message())]
pub enum Refusal {
    TooFewDwells {
        dwells: usize,
        parameters: usize,
    },
    /// Of so many gyros: the search would take more memory than a service has to spare.
    TooManyDwells {
        dwells: usize,
        most: usize,
    },
    NoOutput(&'static str),
    NoAxes(&'static str),
    NoTerms,
}

impl Refusal {
    /// The refusal as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::TooFewDwells { dwells, parameters } => {
                message!("no_degrees_of_freedom", dwells = *dwells, parameters = *parameters)
            }
            Self::TooManyDwells { dwells, most } => message!("too_many_dwells", dwells = *dwells, most = *most),
            Self::NoOutput(slot) => message!("output_is_constant", slot = *slot),
            Self::NoAxes(slot) => message!("no_axes_for", slot = *slot),
            Self::NoTerms => message!("model_without_terms"),
        }
    }
}

/// What a campaign lacks to hold the regressors of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.message())]
pub enum MissingInput {
    Temperature,
    TemperatureChange,
    Attitude,
    Rate,
    NotFinite { dwell: usize },
}

impl MissingInput {
    /// What is lacking, as a code with parameters.
    pub fn message(self) -> Message {
        match self {
            Self::Temperature => message!("dwells_without_temperature"),
            Self::TemperatureChange => message!("temperature_is_constant"),
            Self::Attitude => message!("dwells_without_attitude"),
            Self::Rate => message!("every_rate_is_zero"),
            Self::NotFinite { dwell } => message!("equation_not_finite", dwell),
        }
    }
}
