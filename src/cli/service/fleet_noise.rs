//! `fleet-noise`: the noise constants that the control rules use, fitted to the history of every gyro.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use clap::Args;

use crate::cli::common::block_on;
use crate::cli::document;
use crate::config::Config;
use crate::core::judge::{FleetNoise as Found, NoiseParameters, Spacing};
use crate::pipeline::Pipeline;
use crate::store;
use crate::system::Clock;
use crate::wire::time;

/// Fit the fleet's noise constants (correlation, random walk, what stations differ by) to the stored history, and print
/// the lines for the configuration
#[derive(Debug, Args)]
pub struct FleetNoiseArgs {
    /// Configuration file that names the database; repeat for several, later ones win [default: config/*.toml]
    #[arg(long = "config", value_name = "FILE")]
    config: Vec<PathBuf>,
}

impl FleetNoiseArgs {
    pub fn run(self) -> anyhow::Result<()> {
        let config = Config::load(&self.config, std::env::vars())?;
        let url = config.database.options().shown();
        let work = async {
            let store = store::open_to_read(&config.database.options()).await?;
            let reading = Pipeline::to_read(store, Arc::new(config), Clock::System).await?;
            let fleet = &reading.queries.fleet;
            Ok((fleet.noise().await?, fleet.station_figures().await?.map_or([0.0; 2], |found| found.between())))
        };
        let (found, between) = block_on(work).with_context(|| format!("the database {url}"))?;
        document::print(&report(&found, between, &time::format(Clock::System.now())[..10]))
    }
}

fn report(found: &Found, between: [f64; 2], today: &str) -> String {
    let Found { noise, fitted, scatter, cells, coefficients, moving, spacings } = found;
    let mut text = format!(
        "{cells} weekly means of {coefficients} coefficients between two events; {moving} left out because they move\n"
    );
    for Spacing { lag, years, half_square, differences } in spacings {
        let spread = half_square.sqrt();
        text += &format!(
            "{lag:>3} weeks with records apart ({:.0} days): spread {spread:.6} deg/(h g0) from {differences} differences\n",
            years * 365.25
        );
    }
    match (fitted, scatter) {
        (Some(NoiseParameters { phi, walk, .. }), Some(scatter)) => {
            text += &format!(
                "fitted: scatter {scatter:.6} deg/(h g0), correlation {phi:.2}, walk {walk:.6} deg/(h g0) a root year\n\
                 For the configuration (drawn towards the defaults by 100 weekly means):\n\n\
                 [judging]\nnoise = {{ phi = {:.3}, walk = {:.3e}, fitted = \"{today}\" }}",
                noise.phi, noise.walk
            );
        }
        _ => text += "The history is too short for a fit: the defaults stay in force.",
    }
    let [d_i, d_s] = between;
    text += &if between == [0.0; 2] {
        "\nThe fleet does not tell how stations differ: between_stations stays 0.".to_owned()
    } else {
        format!("\nbetween_stations = {{ d_i = {d_i:.3e}, d_s = {d_s:.3e} }}")
    };
    text
}
