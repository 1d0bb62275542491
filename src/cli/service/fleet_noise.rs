//! `fleet-noise`: the noise constants that the control rules use, fitted to the history of every gyro.

use std::sync::Arc;

use super::settings::ConfigArgs;
use crate::cli::common::block_on;
use crate::cli::prelude::*;
use crate::core::judge::{FleetNoise as Found, NoiseParameters, Spacing};
use crate::core::message::figure;
use crate::pipeline::Pipeline;
use crate::store;
use crate::system::Clock;

/// Fit the fleet's noise constants (correlation, random walk, what stations differ by) to the stored history, and print
/// the lines for the configuration
#[derive(Debug, Args)]
pub struct FleetNoiseArgs {
    #[command(flatten)]
    config: ConfigArgs,
}

impl FleetNoiseArgs {
    pub fn run(self) -> anyhow::Result<()> {
        let config = self.config.load()?;
        let url = config.database.options().shown();
        let work = async {
            let store = store::open_to_read(&config.database.options()).await?;
            let reading = Pipeline::to_read(store, Arc::new(config), Clock::System).await?;
            let fleet = &reading.queries.fleet;
            Ok((fleet.noise().await?, fleet.station_figures().await?.map_or([0.0; 2], |found| found.between())))
        };
        let (found, between) = block_on(work).with_context(|| said(message!("terminal_database", url)))?;
        document::print(&report(&found, between, &time::format(Clock::System.now())[..10]))
    }
}

fn report(found: &Found, between: [f64; 2], today: &str) -> String {
    let Found { noise, fitted, scatter, cells, coefficients, moving, spacings } = found;
    let means = message!(
        "terminal_noise_means",
        cells = cells.to_string(),
        coefficients = coefficients.to_string(),
        moving = moving.to_string()
    );
    let spacing = |&Spacing { lag, years, half_square, differences }: &Spacing| {
        message!(
            "terminal_noise_spacing",
            weeks = format!("{lag:>3}"),
            days = figure(years * 365.25, 0),
            spread = figure(half_square.sqrt(), 6),
            differences = differences.to_string()
        )
    };
    let mut lines: Vec<String> = [means].into_iter().chain(spacings.iter().map(spacing)).map(said).collect();
    match (fitted, scatter) {
        (Some(NoiseParameters { phi, walk, .. }), Some(scatter)) => {
            let (scatter, phi, walk) = (figure(*scatter, 6), figure(*phi, 2), figure(*walk, 6));
            lines.push(said(message!("terminal_noise_fitted", scatter, phi, walk)));
            lines.push(format!(
                "\n[judging]\nnoise = {{ phi = {:.3}, walk = {:.3e}, fitted = \"{today}\" }}",
                noise.phi, noise.walk
            ));
        }
        _ => lines.push(word("terminal_noise_unfitted").to_owned()),
    }
    lines.push(match between {
        [0.0, 0.0] => word("terminal_noise_stations_alike").to_owned(),
        [d_i, d_s] => format!("between_stations = {{ d_i = {d_i:.3e}, d_s = {d_s:.3e} }}"),
    });
    lines.join("\n")
}
