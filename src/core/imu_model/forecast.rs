//! What the model foretells of a campaign: every output with its standard deviation, nothing of the campaign's own
//! outputs taken.

use super::identified::Identified;
use super::programme::{CoefficientEstimate, NoForecast, StackedDesign};
use crate::core::campaign::Campaign;
use crate::core::message::Message;
use crate::core::mounting::Slot;
use crate::core::record::Name;

/// Times the noise by which the model's own standard deviation may exceed it: beyond, nothing is foretold.
const FORETOLD: f64 = 1e3;

/// The forecast of one campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct Forecast {
    pub gyros: Vec<GyroForecast>,
    /// What is left out, and what lies outside the model's validity.
    pub notes: Vec<Message>,
}

/// By dwell.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroForecast {
    pub slot: Slot,
    pub serial: Name,
    /// |E|, pulse/arcsec: pulse/s over it are deg/h.
    pub scale: f64,
    /// pulse/s.
    pub predicted: Vec<f64>,
    /// Of the output: model, campaign to campaign, and noise.
    pub sd: Vec<f64>,
    /// Of the noise alone.
    pub noise: Vec<f64>,
    /// Whether the model's campaigns say anything of the dwell.
    pub foretold: Vec<bool>,
}

/// Foretells the outputs of a campaign from what it commands: y = x.theta, sd^2 = x'Cx + noise^2, with x the columns
/// of model (6) and of the adopted effects.
///
/// # Errors
/// [`NoForecast`], where the model is of something else.
pub fn forecast(model: &Identified, campaign: &Campaign) -> Result<Forecast, NoForecast> {
    let programme = StackedDesign::of(model, campaign)?;
    Ok(predict(&programme, &CoefficientEstimate::of(model, campaign, &programme, model.effects.len())))
}

pub(super) fn predict(programme: &StackedDesign, estimate: &CoefficientEstimate) -> Forecast {
    let n = programme.dwells;
    let predicted = &programme.columns * &estimate.values + &programme.held;
    let spread = &programme.columns * &estimate.covariance;
    let own: Vec<f64> = (0..predicted.len()).map(|i| spread.row(i).dot(&programme.columns.row(i)).max(0.0)).collect();
    let gyros = programme.gyros.iter().enumerate().map(|(j, gyro)| {
        let rows = j * n..(j + 1) * n;
        GyroForecast {
            slot: gyro.slot,
            serial: gyro.serial.clone(),
            scale: gyro.scale,
            predicted: rows.clone().map(|i| predicted[i]).collect(),
            sd: rows.clone().map(|i| (own[i] + programme.noise[i].powi(2)).sqrt()).collect(),
            noise: rows.clone().map(|i| programme.noise[i]).collect(),
            foretold: rows.map(|i| own[i].sqrt() <= FORETOLD * programme.noise[i]).collect(),
        }
    });
    Forecast { gyros: gyros.collect(), notes: programme.notes.clone() }
}
