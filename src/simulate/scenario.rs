//! What a simulated campaign is made of, as a person writes it in TOML or JSON. Everything has a default.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::fault_at::{below, fault};
use crate::core::campaign::TestKind;
use crate::core::fault::Faults;
use crate::core::model::{Term, Terms};
use crate::core::mounting::{Geometry, Slot, Triad};

use super::programme::Programme;
use crate::core::message::sent;
use crate::core::named::named;
use crate::message;

/// All that makes one simulated campaign: the same scenario gives the same campaign, bit for bit. What is left out is
/// drawn from `seed`, as `population` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    pub seed: u64,
    pub imu: String,
    pub station: String,
    /// RFC 3339 with offset.
    pub measured_at: String,
    pub geometry: GeometryChoice,
    pub site: SiteChoice,
    /// `imu`, `torque_feedback` or `turntable_servo`.
    pub test: String,
    /// The model's terms that the campaign asks for; none asks for model (6).
    pub model: Option<Vec<String>>,
    pub programme: Programme,
    /// How gyros are drawn where [`Scenario::gyros`] leaves something open.
    pub population: Population,
    pub gyros: Vec<GyroChoice>,
    pub temperature: Temperature,
    pub noise: OutputNoise,
    pub columns: OptionalColumns,
    pub effects: Vec<EffectChoice>,
}

/// `"skewed"`, `"orthogonal"`, or the nominal axes of each slot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum GeometryChoice {
    Named(String),
    Axes(BTreeMap<String, AxesChoice>),
}

/// Nominal axes of a gyro in the body, unit vectors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxesChoice {
    pub input: [f64; 3],
    pub spin: [f64; 3],
}

/// Where the table stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SiteChoice {
    pub latitude_deg: f64,
    pub height_m: f64,
    /// Local gravity; left open, normal gravity at latitude and height.
    pub gravity_g0: Option<f64>,
    /// Direction of the magnetic field in East, North, Up: what acts on the gyros.
    pub magnetic_field_nav: [f64; 3],
    /// Whether the station knows and states that direction.
    pub states_magnetic_field: bool,
}

/// Normal distributions that gyros are drawn from (means zero but for the scale factor).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Population {
    /// Pulse per arcsec.
    pub scale_factor: f64,
    pub scale_factor_sd: f64,
    /// deg/h.
    pub d_f_sd: f64,
    /// deg/(h g0).
    pub d_i_sd: f64,
    pub d_s_sd: f64,
    /// deg/(h g0^2): D_II, D_SS, D_SI.
    pub d_squared_sd: f64,
    /// deg/(h g0^2): D_IO, D_OS, which model (6) lacks.
    pub d_cross_sd: f64,
    /// Random rotation of each gyro in its mount, 1 sigma per axis.
    pub misalignment_arcmin: f64,
}

/// One gyro; what is left open is drawn from the population.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GyroChoice {
    pub slot: String,
    pub serial: Option<String>,
    pub scale_factor: Option<f64>,
    pub d_f: Option<f64>,
    pub d_i: Option<f64>,
    pub d_s: Option<f64>,
    pub d_io: Option<f64>,
    pub d_os: Option<f64>,
    pub d_si: Option<f64>,
    pub d_ii: Option<f64>,
    pub d_ss: Option<f64>,
    /// Rotation vector from the nominal to the true triad, arcmin about body X, Y, Z.
    pub misalignment_arcmin: Option<[f64; 3]>,
    /// Whether the campaign states E instead of leaving it to the fit.
    pub states_e: StatedE,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StatedE {
    #[default]
    No,
    /// As it is.
    True,
    /// The true scale factor along the nominal input axis.
    Nominal,
}

/// How temperature goes through the campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Temperature {
    pub profile: Profile,
    pub mean_c: f64,
    /// At which effects of temperature are nothing: the same for the campaigns of one IMU. The mean where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_c: Option<f64>,
    /// Standard deviation of a wander, amplitude of a cycle, whole span of a ramp; K.
    pub size_k: f64,
    /// Correlation time of a wander, period of a cycle.
    pub time_h: f64,
    /// Standard deviation of the thermometer's error; K.
    pub reading_sd_k: f64,
}

/// The course of temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    Constant,
    Wander,
    Ramp,
    Cycle,
}

/// Chance in the output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputNoise {
    /// Angle random walk N: a mean over T hours has a standard deviation of N/sqrt(T) deg/h.
    pub angle_random_walk_deg_per_sqrt_h: f64,
    /// Noise of the torquer current: parts per million of the input rate, in the mean of a dwell.
    pub rate_noise_ppm: f64,
    /// Standard deviation of the flicker-like part of the bias, deg/h.
    pub bias_instability_deg_per_h: f64,
    /// Rate random walk K: the bias wanders by K sqrt(t in h), deg/h per sqrt(h).
    pub rate_random_walk_deg_per_h_sqrt_h: f64,
    /// Change of bias at each power-up after the first, 1 sigma, deg/h.
    pub turn_on_bias_deg_per_h: f64,
    /// Smallest count that the electronics resolve, pulse (1 counts whole pulses, 0 has no grain).
    pub pulse_quantum: f64,
    /// Share of the white noise's variance that all gyros have in common: their correlation.
    pub correlation: f64,
    /// Whether all gyros share one wander of the bias: one supply, one room.
    pub shared_wander: bool,
    /// How many times the white noise's standard deviation grows from the first dwell to the last, evenly in its
    /// logarithm.
    pub growth: f64,
}

/// Which optional columns the station writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OptionalColumns {
    pub temperature: bool,
    pub attitude: bool,
    pub standard_errors: StandardErrors,
}

named! {
/// What the station states of each mean's standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StandardErrors {
    /// The true standard deviation of each mean.
    Exact = "exact",
    /// Wrong by 12 per cent, dwell by dwell, as estimates from few samples are.
    Noisy = "noisy",
    /// One number for all dwells of a gyro, the median of the true ones.
    Constant = "constant",
    Absent = "absent",
}
}

/// A cause to put into the campaign, sized either in its own unit or by how visible it is to be.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectChoice {
    /// An id of the effects catalogue, or `outside:FAMILY`.
    pub effect: String,
    /// Slots that have it; left out, all. Effects of the station act on all gyros anyway.
    pub gyros: Option<Vec<String>>,
    /// In the cause's own unit.
    pub size: Option<f64>,
    /// Square root of the whitened power that the model cannot absorb, over all gyros.
    pub detectability: Option<f64>,
    /// From which to which share of the campaign's time it acts; left out, all the time.
    pub acts_in: Option<[f64; 2]>,
    /// tau of `warmup`, period of `periodic`.
    pub time_h: Option<f64>,
    /// The dwell of `outlier_dwell`, the first dwell after a `bias_step`, a `relevelling` or a `reseating` (which is
    /// between static and turning dwells where it is left out).
    pub dwell: Option<usize>,
    /// The direction of `temperature_g`, `magnetic`, `axial_compliance` (D_II, D_SS), `cross_compliance` (k_IS, k_IO,
    /// k_OS), `levelling` (east, north).
    pub direction: Option<[f64; 3]>,
}

impl EffectChoice {
    /// `effect` in all gyros, as visible as `detectability` says.
    pub fn detectable(effect: &str, detectability: f64) -> Self {
        Self { effect: effect.into(), detectability: Some(detectability), ..Self::default() }
    }

    /// `effect` in all gyros, of a stated size.
    pub fn sized(effect: &str, size: f64) -> Self {
        Self { effect: effect.into(), size: Some(size), ..Self::default() }
    }
}

impl Default for Scenario {
    fn default() -> Self {
        Self {
            seed: 1,
            imu: "IMU-07".into(),
            station: "ST-2".into(),
            measured_at: "2026-03-01T08:00:00Z".into(),
            geometry: GeometryChoice::Named("skewed".into()),
            site: SiteChoice::default(),
            test: TestKind::Imu.name().into(),
            model: None,
            programme: Programme::default(),
            population: Population::default(),
            gyros: Slot::ALL.iter().map(|slot| GyroChoice { slot: slot.name().into(), ..Default::default() }).collect(),
            temperature: Temperature::default(),
            noise: OutputNoise::default(),
            columns: OptionalColumns::default(),
            effects: Vec::new(),
        }
    }
}

impl Default for SiteChoice {
    fn default() -> Self {
        Self {
            latitude_deg: 34.25,
            height_m: 0.0,
            gravity_g0: None,
            magnetic_field_nav: [0.0, 0.6, -0.8],
            states_magnetic_field: false,
        }
    }
}

impl Default for Population {
    fn default() -> Self {
        Self {
            scale_factor: 1.47,
            scale_factor_sd: 0.007,
            d_f_sd: 2.0,
            d_i_sd: 5.0,
            d_s_sd: 7.0,
            d_squared_sd: 0.0,
            d_cross_sd: 0.0,
            misalignment_arcmin: 6.0,
        }
    }
}

impl Default for Temperature {
    fn default() -> Self {
        Self { profile: Profile::Wander, mean_c: 45.0, reference_c: None, size_k: 0.6, time_h: 1.5, reading_sd_k: 0.0 }
    }
}

impl Default for OutputNoise {
    /// Some 0.001 deg/h in a mean of three minutes, doubled at 2 deg/s; no grain, no wander.
    fn default() -> Self {
        Self {
            angle_random_walk_deg_per_sqrt_h: 2.3e-4,
            rate_noise_ppm: 0.25,
            bias_instability_deg_per_h: 0.0,
            rate_random_walk_deg_per_h_sqrt_h: 0.0,
            turn_on_bias_deg_per_h: 0.0,
            pulse_quantum: 0.0,
            correlation: 0.0,
            shared_wander: false,
            growth: 1.0,
        }
    }
}

impl Default for OptionalColumns {
    fn default() -> Self {
        Self { temperature: true, attitude: true, standard_errors: StandardErrors::Exact }
    }
}

impl GeometryChoice {
    /// The core's geometry; faults where a name is unknown or axes are not a triad.
    pub fn resolve(&self) -> Result<Geometry, Faults> {
        match self {
            Self::Named(name) if name == "skewed" => Ok(Geometry::Skewed),
            Self::Named(name) if name == "orthogonal" => Ok(Geometry::Orthogonal),
            Self::Named(name) => Err(fault("/geometry", message!("unknown_geometry", value = sent(name)))),
            Self::Axes(slots) => {
                let mut triads = [None; 3];
                for (name, axes) in slots {
                    let slot = slot_named(name, "/geometry")?;
                    let triad = Triad::from_stated_axes(Vector3::from(axes.input), Vector3::from(axes.spin));
                    triads[slot.index()] = Some(triad.map_err(|part| below(&format!("/geometry/{name}"), part))?);
                }
                Ok(Geometry::Custom(triads))
            }
        }
    }
}

impl Scenario {
    /// The terms that the campaign asks for, where it asks.
    pub fn asked_terms(&self) -> Result<Option<Terms>, Faults> {
        let Some(names) = &self.model else { return Ok(None) };
        let mut terms = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let unknown = || fault(&format!("/model/{i}"), message!("unknown_model_term", value = sent(name)));
            terms.push(Term::from_name(name).ok_or_else(unknown)?);
        }
        Ok(Some(Terms::of(&terms)))
    }

    /// What kind of campaign it makes.
    ///
    /// # Errors
    /// A name that is none of `imu`, `torque_feedback` and `turntable_servo`.
    pub fn test_kind(&self) -> Result<TestKind, Faults> {
        TestKind::from_name(&self.test)
            .ok_or_else(|| fault("/test", message!("scenario_test", value = sent(&self.test))))
    }
}

pub(crate) fn slot_named(name: &str, pointer: &str) -> Result<Slot, Faults> {
    Slot::from_name(name).ok_or_else(|| fault(pointer, message!("scenario_slot", value = sent(name))))
}
