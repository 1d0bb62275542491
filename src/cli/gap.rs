//! `gyrowatch gap`: the forecast error of an IMU's campaigns, step by step from the paper's model to the noise.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use serde::Serialize;

use super::document::{self, Format, table};
use super::predict::{identified, measured};
use crate::core::imu_model::{compare, ladder};
use crate::wire::forecast::{ForecastBody, RungBody};
use crate::wire::time;

/// Show the gap between the model of an IMU and its later campaigns: model (6), each effect, the noise floor
///
/// Every figure is of a forecast: nothing is fitted to the campaigns.
#[derive(Debug, Args)]
pub struct Gap {
    /// A model file with the coefficients of an IMU (gyrowatch model fit)
    model: PathBuf,

    /// Campaigns that the model was not fitted to, in JSON or CSV
    #[arg(required = true)]
    campaigns: Vec<PathBuf>,

    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The ladder of one campaign.
#[derive(Debug, Serialize)]
struct Ladder {
    measured_at: String,
    station: String,
    rungs: Vec<RungBody>,
    noise_deg_per_h: f64,
    closing: Option<crate::wire::forecast::ClosingBody>,
    state: String,
}

impl Gap {
    pub fn run(self) -> anyhow::Result<()> {
        let model = identified(&self.model)?;
        let mut ladders = Vec::new();
        for path in &self.campaigns {
            let campaign = measured(path)?;
            let file = || document::name(path);
            let comparison = compare(&model, &campaign).with_context(file)?;
            let steps = ladder(&model, &campaign).with_context(file)?;
            let body = ForecastBody::of(&model, &campaign, &comparison.forecast, None);
            let Some(compared) = body.compared(&comparison, &steps, None).compared else { continue };
            ladders.push(Ladder {
                measured_at: time::format(campaign.measured_at),
                station: campaign.station.to_string(),
                rungs: compared.ladder,
                noise_deg_per_h: compared.noise_deg_per_h,
                closing: compared.closing,
                state: compared.state,
            });
        }
        ladders.sort_by(|a, b| a.measured_at.cmp(&b.measured_at));
        match self.format {
            Format::Table => document::print(&tables(&model.imu.to_string(), &ladders)),
            Format::Json => document::print_json(&ladders),
        }
    }
}

fn tables(imu: &str, ladders: &[Ladder]) -> String {
    let mut rows = table(["campaign", "model", "forecast error, deg/h", "in sd", "closes"], 2..4);
    for one in ladders {
        for (k, rung) in one.rungs.iter().enumerate() {
            let last = k + 1 == one.rungs.len();
            let closes = one.closing.filter(|_| last && k > 0).map_or(String::new(), |c| match c.interval {
                Some([low, high]) => {
                    format!("{:.0} % ({:.0} to {:.0})", 100.0 * c.closure, 100.0 * low, 100.0 * high)
                }
                None => "nothing to close".to_owned(),
            });
            rows.add_row([
                if k == 0 { one.measured_at.clone() } else { String::new() },
                rung.effect.as_ref().map_or("model (6)".to_owned(), |effect| format!("+ {effect}")),
                format!("{:.3e}", rung.rms_deg_per_h),
                format!("{:.2}", rung.rms_over_sd),
                closes,
            ]);
        }
        let floor = format!("{:.3e}", one.noise_deg_per_h);
        rows.add_row([String::new(), "noise floor".to_owned(), floor, "1.00".to_owned(), String::new()]);
    }
    format!("{imu}: forecast error of each campaign\n{rows}")
}
