//! A station simulator from physics: what a table, the Earth, the thermostat and imperfect gyros would write down.
//!
//! It is the other side of every check of this program, so it shares no code with the fit, the effects catalogue
//! or the diagnosis: attitudes are finite rotations, a turn of the table is averaged moment by moment, drift comes
//! from the gyro's own axes by eq. (5), and an unmodelled cause changes what the IMU feels or how it answers,
//! never a design column. Of the core it uses the conventions only: frames, mounting, units, the campaign type.
//!
//! # In reading order
//!
//! [`scenario`] what can be asked for, [`presets`] ready ones, [`experiment`] the paper's; [`programme`] the table's
//! positions and rates in time; [`station`] what the IMU feels in each dwell ([`sensed`]: at one moment); [`gyro`] how
//! it answers; [`cause`] and [`outside`] what may go wrong, [`inject`] how much of it; [`world`] puts them together;
//! [`noise`] and [`environment`] chance; [`detectability`] how visible a cause is; [`truth`] what is written apart
//! from the campaign. [`of_model`] and [`augment`] take gyros and effects from a model file
//! instead, [`of_hypothesis`] an effect from what somebody wrote.

pub mod augment;
pub mod cause;
pub mod detectability;
pub mod environment;
pub mod experiment;
mod fault_at;
pub mod gyro;
pub mod inject;
pub mod noise;
pub mod of_hypothesis;
pub mod of_model;
pub mod outside;
pub mod presets;
pub mod programme;
pub mod run;
pub mod scenario;
pub mod sensed;
pub mod station;
pub mod truth;
pub mod world;

pub use run::{Simulated, simulate};
pub use scenario::Scenario;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// What a stream of random numbers is for. Each has its own, so that adding a cause leaves the noise, the order of
/// positions and the gyros of the same seed untouched.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Stream {
    Programme = 1,
    Population = 2,
    Temperature = 3,
    Noise = 4,
    StandardErrors = 5,
    Causes = 6,
    Experiment = 7,
    SharedNoise = 8,
    Model = 9,
    Hypothesis = 10,
}

/// The generator of one stream of a seed; ChaCha8, so that the same seed gives the same campaign everywhere.
pub(crate) fn random(seed: u64, stream: Stream) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream as u64);
    rng
}

const SECONDS_PER_HOUR: f64 = 3600.0;

/// A standard normal deviate.
fn gaussian(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}
