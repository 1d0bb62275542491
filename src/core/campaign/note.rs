//! What is worth knowing about a campaign's dwells and their fit.

use super::commanded::CommandFinding;
use super::station_uncertainty::StationPart;
use super::steps::CoarseStep;
use super::stuck::StuckOutput;
use crate::core::bench::Alias;
use crate::core::calibrate::noise_found::LawFound;
use crate::core::effects::{Effect, MissingInput, Refusal};
use crate::core::mounting::Slot;
use crate::core::named::named;

/// What a campaign could not be checked for, or what was left out of it.
#[derive(Debug, Clone, PartialEq)]
pub enum CampaignNote {
    /// Some dwells lack an optional column; by index.
    Missing { column: DwellColumn, dwells: Vec<usize>, of: usize },
    /// A dwell's temperature is a fault value of the sensor.
    TemperatureOutlier { dwell: usize, celsius: f64, median: f64 },
    /// The median of the temperatures is none that a gyro is calibrated at: another unit.
    TemperatureUnit { median: f64 },
    /// Dwells are too short or too long for seconds: their median, s, and the most that one turns, degrees.
    TimeUnit { median_s: f64, turn_deg: Option<f64> },
    /// What was commanded contradicts itself, where that hardly matters.
    Commanded(CommandFinding),
    /// Static dwells whose rate is not the Earth's at their attitude: how many of how many, and the worst of them.
    RateNotOfAttitude { off: usize, of: usize, dwell: usize, most_arcsec_s: f64 },
    /// Single dwells whose outputs are far from the model that all others agree on, and the worst of them.
    OutputsContradict { dwells: Vec<usize>, most_arcsec_s: f64 },
    /// The output of a gyro stands still.
    OutputStuck(StuckOutput),
    /// Commands or outputs come in steps that are not small against the noise.
    Coarse(CoarseStep),
    /// Outputs come without standard errors: scatter alone shows their noise.
    NoStandardErrors,
    /// No orientation was measured twice.
    NoRepeats,
    /// The noise at the fastest rate over that at rest.
    NoiseGrows { times: f64 },
    /// Correlation of the two gyros that share most noise.
    NoiseShared { correlation: f64 },
    /// Dwells near in time err alike: how likely, and by how much in the gyro that wanders most.
    NoiseRemembers { probability: f64, deg_per_h: f64 },
    /// How many times the stated standard errors are too large.
    ErrorsOverstated { gyros: Vec<(Slot, f64)> },
    /// By how much the standard errors scatter (relative) about a law that the residuals follow better.
    ErrorsScatter { scatter: f64 },
    /// Gyros whose repeats scatter many times as much as the stated standard errors, and how many times together.
    ErrorsUnderstated { gyros: Vec<Slot>, times: f64 },
    /// Gyros whose residuals are more than the noise of their outputs as stated, and the law by which it may go instead.
    ResidualsExceedNoise { gyros: Vec<Slot>, law: Option<LawFound> },
    /// An effect of the model was not fitted.
    EffectLeftOut { slot: Option<Slot>, effect: Effect, why: EffectNotFitted },
    /// The dwells contradict what the model says of an effect, but tell it less well: D_I and D_S hold that uncertainty.
    EffectContradicted { slot: Slot, effect: Effect },
    /// D_I and D_S leave out what a hypothesis of one's own is at the reference temperature.
    EffectAtReference { effect: Effect },
    /// None of the model's effects was fitted.
    EffectsLeftOut { why: Refusal },
    /// What a station states of itself is not in the standard deviations.
    StationLeftOut { parts: Vec<StationPart>, why: StationUndetermined },
    /// Residuals look like a rotation of so many times the standard uncertainty that is stated, arcsec.
    StationContradicted { part: StationPart, times: f64, arcsec: f64 },
    /// A product of specific forces that a bench test does not fit moves a coefficient by so much of itself.
    ProductAliased(Alias),
    /// Terms of the third degree that a bench test does not fit, and what one deg/(h g0^3) of each would move, deg/(h g0);
    /// told of this size.
    CubicAliased { size: f64, aliases: Vec<Alias> },
    /// The positions follow time: a drift of so many deg/h an hour moves D_I and D_S, deg/(h g0), in a bench test or in
    /// this gyro of an IMU.
    DriftAliased { of: Option<DriftOfGyro>, drift: f64, d_i: f64, d_s: f64 },
    /// In the gauge of a tumble D_F holds this many deg/h for every deg/(h g0^2) of D_II + D_SS.
    OffsetInGauge { moves: f64 },
    /// D_I of all gyros is near the shift that a wrong sign of the latitude makes, deg/(h g0).
    LatitudeSign { shift: f64 },
    /// The specific force of static dwells is longer than the site's gravity by this share, and moves D_I or D_S of this
    /// gyro most, deg/(h g0).
    GravityOff { share: f64, slot: Slot, moves: f64 },
    /// The rates of static dwells are those of this latitude (degrees) and not quite the site's; where they are wrong,
    /// D_I is by so much, deg/(h g0).
    LatitudeOff { degrees: f64, moves: f64 },
    /// E is held: so many arcsec of its direction would move D_I or D_S of this gyro, deg/(h g0).
    HeldScale { slot: Slot, arcsec: f64, moves: f64 },
    /// The same of its size: of this share.
    HeldSize { slot: Slot, share: f64, moves: f64 },
    /// The campaign does not determine E, whose size along the nominal axis is taken, pulse/arcsec.
    NominalAxis { slot: Slot, scale: f64 },
}

/// The gyro of an IMU that a drift moves most, and the drift over the whole campaign, deg/h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftOfGyro {
    pub slot: Slot,
    pub whole: f64,
}

/// Why the campaign cannot tell what an error of its station does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StationUndetermined {
    Attitude,
    /// E is neither held nor determined.
    Scale(Slot),
}

named! {
/// An optional column of a campaign's dwells, by its member of a dwell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DwellColumn {
    Attitude = "attitude",
    Temperature = "temperature_c",
    StandardErrors = "output_sem_pulse_s",
}
}

/// Why an effect of the model was not fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffectNotFitted {
    Lacks(MissingInput),
    /// It and the other terms are one to these dwells.
    NotDistinguished,
    /// A field of any direction, whose part along north and the other terms are one to these dwells.
    NorthPart,
    /// The model knows it better than these dwells tell it.
    Held,
    /// Nobody states the temperature: standard deviations hold what any would do.
    AnyTemperature,
}

impl CampaignNote {
    /// Its name in answers; never changes once it has been given out.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Missing { column: DwellColumn::Attitude, .. } => "attitudes_missing",
            Self::Missing { column: DwellColumn::Temperature, .. } => "temperatures_missing",
            Self::Missing { column: DwellColumn::StandardErrors, .. } => "standard_errors_missing",
            Self::TemperatureOutlier { .. } => "temperature_outlier",
            Self::TemperatureUnit { .. } => "temperature_unit",
            Self::TimeUnit { .. } => "time_unit",
            Self::Commanded(finding) => finding.symptom.name(),
            Self::RateNotOfAttitude { .. } => "rate_not_of_attitude",
            Self::OutputsContradict { .. } => "dwells_contradict",
            Self::OutputStuck(_) => "output_stuck",
            Self::Coarse(step) => step.code(),
            Self::NoStandardErrors => "no_standard_errors",
            Self::NoRepeats => "no_repeats",
            Self::NoiseGrows { .. } => "noise_grows_with_rate",
            Self::NoiseShared { .. } => "residuals_shared",
            Self::NoiseRemembers { .. } => "residuals_remember",
            Self::ErrorsOverstated { .. } => "standard_errors_overstated",
            Self::ErrorsScatter { .. } => "standard_errors_scatter",
            Self::ErrorsUnderstated { .. } => "standard_errors_understated",
            Self::ResidualsExceedNoise { .. } => "residuals_exceed_noise",
            Self::EffectLeftOut { .. } => "effect_left_out",
            Self::EffectContradicted { .. } => "effect_contradicted",
            Self::EffectAtReference { .. } => "effect_at_reference",
            Self::EffectsLeftOut { .. } => "effects_left_out",
            Self::StationLeftOut { .. } => "station_left_out",
            Self::StationContradicted { .. } => "station_contradicted",
            Self::ProductAliased(_) => "product_aliased",
            Self::CubicAliased { .. } => "cubic_aliased",
            Self::DriftAliased { .. } => "drift_aliased",
            Self::OffsetInGauge { .. } => "d_f_in_gauge",
            Self::LatitudeSign { .. } => "latitude_sign",
            Self::GravityOff { .. } => "gravity_off",
            Self::LatitudeOff { .. } => "latitude_off",
            Self::HeldScale { .. } => "held_scale",
            Self::HeldSize { .. } => "held_scale_size",
            Self::NominalAxis { .. } => "nominal_axis",
        }
    }
}
