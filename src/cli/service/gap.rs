//! `gyrowatch gap`: the forecast error of an IMU's campaigns, step by step from the paper's model to the noise.

use serde::Serialize;

use super::predict::{identified, noise_floor, state, step};
use super::settings;
use crate::cli::client::Connection;
use crate::cli::common::{Usage, block_on};
use crate::cli::prelude::*;
use crate::core::imu_model::{compare, ladder};
use crate::core::judge::Limits;
use crate::wire::forecast::{ClosingBody, ComparedBody, ForecastBody, ForecastPointBody, ForecastSeriesBody, RungBody};
use crate::wire::text::encoded;

/// Show the gap between the model of an IMU and its later campaigns: model (6), each effect, the noise floor
///
/// Every figure is of a forecast: nothing is fitted to the campaigns.
#[derive(Debug, Args)]
pub struct Gap {
    /// A model file with the coefficients of an IMU (gyrowatch model fit); without campaigns, the name of an IMU in a
    /// running service
    #[arg(value_name = "MODEL|IMU")]
    model: PathBuf,

    /// Campaigns that the model was not fitted to, in JSON or CSV
    campaigns: Vec<PathBuf>,

    #[command(flatten)]
    connection: Connection,

    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// The nested models of one campaign.
#[derive(Debug, Serialize)]
struct ModelSteps {
    measured_at: String,
    station: String,
    rungs: Vec<RungBody>,
    noise_deg_per_h: f64,
    closing: Option<ClosingBody>,
    state: String,
}

impl Gap {
    pub fn run(self) -> anyhow::Result<()> {
        let (name, mut ladders) = if self.campaigns.is_empty() { self.of_service()? } else { self.of_files()? };
        ladders.sort_by(|a, b| a.measured_at.cmp(&b.measured_at));
        self.format.show(&ladders, || tables(&name, &ladders))
    }

    /// The campaigns of an IMU that a service stores, each from the model in force when it came in.
    fn of_service(&self) -> anyhow::Result<(String, Vec<ModelSteps>)> {
        if self.model.is_file() {
            return Err(Usage(word("terminal_gap_needs_campaigns").to_owned()).into());
        }
        let imu = self.model.to_string_lossy().into_owned();
        let service = self.connection.service()?;
        let route = format!("/v1/imus/{}/forecast", encoded(&imu));
        let series: ForecastSeriesBody = block_on(async { service.get(&route).await })?;
        for point in &series.points {
            if let Some(why) = &point.why_not {
                eprintln!("{}: {why}", point.measured_at);
            }
        }
        let ladder = |point: ForecastPointBody| Some(ModelSteps::of(point.measured_at, point.station, point.compared?));
        Ok((imu, series.points.into_iter().filter_map(ladder).collect()))
    }

    fn of_files(&self) -> anyhow::Result<(String, Vec<ModelSteps>)> {
        let model = identified(&self.model)?;
        let mut ladders = Vec::new();
        for path in &self.campaigns {
            let campaign = settings::campaign(path, &document::read(path)?)?;
            let file = || document::name(path);
            let comparison = compare(&model, &campaign).with_context(file)?;
            let steps = ladder(&model, &campaign).with_context(file)?;
            let body = ForecastBody::of(&model, &campaign, &comparison.forecast, None);
            let judged = (&*model, Limits::default().forecast());
            let Some(compared) = body.compared(&comparison, &steps, None, judged).compared else { continue };
            ladders.push(ModelSteps::of(time::format(campaign.measured_at), campaign.station.to_string(), compared));
        }
        Ok((model.imu.to_string(), ladders))
    }
}

impl ModelSteps {
    fn of(measured_at: String, station: String, compared: ComparedBody) -> Self {
        let ComparedBody { ladder, noise_deg_per_h, closing, state, .. } = compared;
        Self { measured_at, station, rungs: ladder, noise_deg_per_h, closing, state }
    }
}

fn tables(imu: &str, ladders: &[ModelSteps]) -> String {
    if ladders.is_empty() {
        return format!("{}\n", said(message!("terminal_gap_none", imu = imu.to_owned())));
    }
    let mut rows = table_of("terminal_gap_head", 2..4);
    for one in ladders {
        let mut left = [one.measured_at.as_str(), state(&one.state)].into_iter();
        let mut left = || left.next().unwrap_or_default().to_owned();
        for (k, rung) in one.rungs.iter().enumerate() {
            let last = k + 1 == one.rungs.len();
            let closes = one.closing.filter(|_| last && k > 0).map_or(String::new(), |c| match c.interval {
                Some(interval) => {
                    let [closure, low, high] =
                        [c.closure, interval[0], interval[1]].map(|x| format!("{:.0}", 100.0 * x));
                    let interval = said(message!("terminal_to", from = low, to = high));
                    format!("{closure} % ({interval})")
                }
                None => word("terminal_nothing_to_close").to_owned(),
            });
            let [name, error, in_sd] = step(rung);
            rows.add_row([left(), name, error, in_sd, closes]);
        }
        let [name, error, in_sd] = noise_floor(one.noise_deg_per_h);
        rows.add_row([left(), name, error, in_sd, String::new()]);
    }
    let plain = ladders.iter().all(|one| one.rungs.len() == 1);
    let hint = if plain { format!("\n{}", word("terminal_gap_plain")) } else { String::new() };
    format!("{}\n{rows}{hint}", said(message!("terminal_gap_of", imu = imu.to_owned())))
}
