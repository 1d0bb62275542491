//! The model of the very IMU: all its coefficients with their joint covariance, and what it says of campaigns to come.
//!
//! Reading order: [`identified`] (what the model is), [`effects`] (which effects it holds), [`fit`] (from campaigns to
//! it), [`programme`] (what a campaign asks of it), [`mod@forecast`] (what it foretells), [`comparison`] (how far that
//! came true, and how much of the error the adopted effects take away), [`mod@changed`] (coefficients that are others
//! now), [`draw`] (one IMU of all that the model allows), [`informative_dwells`] (which dwells to measure next).

mod changed;
mod columns;
mod comparison;
mod draw;
mod effects;
mod fit;
mod forecast;
mod identified;
mod informative_dwells;
mod programme;

pub use changed::{Changed, ChangedEffect, DriftShift, changed, changed_since};
pub use comparison::{
    ErrorReduction, ForecastComparison, GyroComparison, ModelStep, OutlyingDwell, compare, ladder, promised,
};
pub use draw::drawn;
pub use effects::{Chosen, asked_for, named};
pub use fit::{CampaignSample, NotIdentified, identify, of_one_imu};
pub use forecast::{Forecast, GyroForecast, forecast};
pub use identified::{FittedCampaign, Identified, ModelCoefficient, ModelGyro, NoiseLaw, Of, Validity};
pub use informative_dwells::{InformativeDwell, most_telling};
pub use programme::NoForecast;
