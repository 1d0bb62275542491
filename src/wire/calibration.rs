//! What the service answers to a campaign, and `calibrate` prints: the fit with its evidence, then as for a record.

use nalgebra::DVector;

use super::answer::{SeparationBody, VerdictBody};
use super::bench::BenchBody;
use super::campaign::StationUncertaintyBody;
use super::diagnosis::NoiseFoundBody;
use super::note::NoteBody;
use super::time;
use crate::core::calibrate::bench::BenchCalibration;
use crate::core::calibrate::drift::NotSeparated;
use crate::core::calibrate::noise::NoiseScale;
use crate::core::calibrate::noise_found::NoiseFound;
use crate::core::calibrate::outcome::Outcome;
use crate::core::calibrate::repeats_between::Repeated;
use crate::core::calibrate::reseated::Reseated;
use crate::core::calibrate::{Calibration, GyroCalibration, Parameter, ScaleSource};
use crate::core::campaign::{self, Campaign, CampaignNote, StationUncertainty};
use crate::core::model::{Term, Terms};
use crate::core::mounting::Geometry;
use crate::core::note::Note;
use crate::core::separate::{JudgedMethod, Separation};
use crate::core::units::arcsec;
use crate::wire::prelude::*;

mod parameters;

pub use parameters::{EffectParameterBody, NullDirectionBody, ParameterBody};

/// The answer to a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CampaignAnswer {
    /// Identifier of the stored campaign; none where nothing is stored (the command line's `calibrate`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    pub imu: String,
    /// Identifier of the adopted model that it was fitted with; none for the plain model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imu_model: Option<String>,
    pub station: String,
    pub measured_at: String,
    /// `imu`, `torque_feedback` or `turntable_servo`.
    pub test: String,
    pub calibration: CalibrationBody,
    pub separations: Vec<SeparationBody>,
    /// Gyros that were fitted but not separated, and why.
    pub not_separated: Vec<NotSeparatedBody>,
    /// Of a single-gyro bench test: what is stored and compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bench_result: Option<BenchBody>,
    /// What could not be checked, and how the figures came about.
    pub notes: Vec<NoteBody>,
    pub verdicts: Vec<VerdictBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NotSeparatedBody {
    pub slot: Slot,
    pub serial: String,
    pub reason: String,
}

/// The fit of every gyro.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CalibrationBody {
    /// The terms that were asked for.
    pub model: Vec<String>,
    /// Effects of an augmented model that were fitted beside them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<String>,
    pub dwells: usize,
    /// Groups of repeated dwells, as indices.
    pub repeats: Vec<Vec<usize>>,
    /// What the noise is beyond white, independent and as stated, where something is found. The memory is in every
    /// standard deviation and covariance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseFoundBody>,
    /// What the station states of itself, in the campaign or in the configuration.
    #[serde(default)]
    pub station_uncertainty: StationStatedBody,
    pub gyros: Vec<GyroFitBody>,
}

/// Several campaigns of one IMU, and what repeats between them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CampaignsAnswer {
    /// Each as it is answered by itself, in the order of time.
    pub campaigns: Vec<CampaignAnswer>,
    pub between_campaigns: Vec<RepeatedBody>,
    /// Campaigns in which all input axes are turned together against the first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reseated: Vec<ReseatedBody>,
}

/// An IMU that was seated anew.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReseatedBody {
    /// Place among the campaigns.
    pub campaign: usize,
    /// About the body axes.
    pub rotation_arcsec: Triple,
    pub sd_arcsec: Triple,
    /// Gyros whose D_O differs from that of the first campaign by no more than this rotation does.
    pub explains_d_o_of: Vec<Slot>,
}

/// One coefficient over several campaigns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RepeatedBody {
    pub slot: Slot,
    pub serial: String,
    pub coefficient: &'static str,
    pub unit: &'static str,
    /// Campaigns that determine it.
    pub campaigns: usize,
    /// Weighted mean, and its standard deviation with what campaigns differ by.
    pub mean: f64,
    pub sd: f64,
    /// Root mean square of the stated standard deviations, and standard deviation of the values.
    pub stated_sd: f64,
    pub scatter_sd: f64,
    /// Of the values about their weighted mean.
    pub chi2: f64,
    pub dof: usize,
    pub p_value: Option<f64>,
    /// Real over stated standard deviation, and its interval, 95 %.
    pub ratio: f64,
    pub ratio_interval: [f64; 2],
    /// What campaigns differ by beyond what is stated; zero within chance (p >= 0.05).
    pub beyond_sd: f64,
}

bodies! {
    ReseatedBody of Reseated: campaign, rotation_arcsec: |one| one.rotation.map(arcsec).into(),
        sd_arcsec: |one| one.sd.map(arcsec).into(), explains_d_o_of = explains;
    RepeatedBody of Repeated: slot, serial, coefficient, unit, campaigns, mean, sd, stated_sd, scatter_sd,
        chi2 = scatter.chi2, dof = scatter.dof, p_value: |repeated| repeated.scatter.p_value(), ratio: Repeated::ratio,
        ratio_interval: Repeated::ratio_interval, beyond_sd;
}

/// Systematic standard uncertainties of the station that are in the standard deviations.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StationStatedBody {
    /// Whether anything is: without, every standard deviation is statistical.
    pub stated: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levelling_arcsec: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth_arcsec: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixture_arcsec: Option<f64>,
}

impl StationStatedBody {
    fn of(station: &StationUncertainty) -> Self {
        let StationUncertaintyBody { levelling_arcsec, azimuth_arcsec, fixture_arcsec } =
            StationUncertaintyBody::of(station).unwrap_or_default();
        Self { stated: station.is_stated(), levelling_arcsec, azimuth_arcsec, fixture_arcsec }
    }
}

/// The fit of one gyro. Of a bench test, the coefficients of eq. (5) stand in `parameters`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GyroFitBody {
    pub slot: Slot,
    pub serial: String,
    /// Whether E was `fitted`, `held` (known_e_pulse_per_arcsec) or is `missing`.
    pub e_source: String,
    pub parameters: Vec<ParameterBody>,
    /// Coefficients of the effects of an augmented model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectParameterBody>,
    /// The parameters once more, under the names that a calibration record has for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e_pulse_per_arcsec: Option<Triple>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub g_pulse_per_s_g0: Option<Triple>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_pulse_per_s_g02: Option<Triple>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_pulse_per_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e_sd: Option<Triple>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub g_sd: Option<Triple>,
    /// Covariance of the parameters, row by row in their order; none where nothing gives the noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Of the parameters, without effects.
    pub rank: usize,
    /// Directions of the parameters that no dwell can see.
    pub null_directions: Vec<NullDirectionBody>,
    /// Against the standard errors as given; against 1 pulse/s where there are none.
    pub chi2: f64,
    pub dof: usize,
    /// chi2/dof, where standard errors are given and dwells are left over.
    #[schema(required)]
    pub reduced_chi2: Option<f64>,
    /// Lack of fit: the chance of residuals as large as these if the model and the noise scale are right. Where
    /// repeats give the scale it is no chi-square probability of `reduced_chi2`.
    #[schema(required)]
    pub p_value: Option<f64>,
    pub noise: NoiseBody,
    pub residuals: ResidualsBody,
}

/// How far the outputs are trusted, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NoiseBody {
    /// `sem`, `repeats+sem`, `repeats+residuals+sem`, `residuals+sem`, `repeats`, `residuals` or `none`.
    pub source: String,
    /// Whether dwells were weighted by their standard errors.
    pub weighted: bool,
    /// What the standard errors are multiplied by; none without standard errors.
    #[schema(required)]
    pub sem_factor: Option<f64>,
    #[schema(required)]
    pub sem_factor_sd: Option<f64>,
    /// Root mean square over the dwells of the standard deviation of one output.
    #[schema(required)]
    pub rms_pulse_per_s: Option<f64>,
    #[schema(required)]
    pub rms_deg_per_h: Option<f64>,
    /// Degrees of freedom behind the scale; none where standard errors are taken at their word.
    #[schema(required)]
    pub dof: Option<f64>,
    /// Spread of repeats: chi2 against the standard errors as given, and its degrees of freedom.
    pub pure_error_chi2: f64,
    pub pure_error_dof: usize,
}

/// Dwell by dwell, in their order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResidualsBody {
    /// Measured less fitted.
    pub pulse_per_s: Vec<f64>,
    /// The same over |E|; none where E is unknown.
    #[schema(required)]
    pub deg_per_h: Option<Vec<f64>>,
    /// Over its own standard deviation; none where nothing gives the noise.
    #[schema(required)]
    pub standardised: Option<Vec<f64>>,
    /// Share of its own output in each fitted value, 0 to 1.
    pub leverage: Vec<f64>,
}

impl CampaignAnswer {
    /// Without an id or verdicts: those belong to what is stored.
    pub fn of(campaign: &Campaign, outcome: &Outcome, method: JudgedMethod) -> Self {
        let mut answer = Self {
            id: None,
            imu: campaign.imu.to_string(),
            imu_model: None,
            station: campaign.station.to_string(),
            measured_at: time::format(campaign.measured_at),
            test: campaign.test.name().to_owned(),
            calibration: CalibrationBody {
                model: names(campaign.terms()),
                effects: Vec::new(),
                dwells: campaign.dwells.len(),
                repeats: Vec::new(),
                noise: None,
                station_uncertainty: StationStatedBody::of(&campaign.station_uncertainty),
                gyros: Vec::new(),
            },
            separations: Vec::new(),
            not_separated: Vec::new(),
            bench_result: None,
            verdicts: Vec::new(),
            notes: campaign::notes(campaign).iter().map(NoteBody::of).collect(),
        };
        match outcome {
            Outcome::Imu { calibration, separations, as_measured } => {
                answer.fitted(calibration);
                calibration.coarse_steps(campaign).for_each(|note| answer.note(note));
                for (j, (gyro, separation)) in calibration.gyros.iter().zip(separations).enumerate() {
                    let measured = as_measured.as_ref();
                    let measured =
                        measured.and_then(|own| Some((own.temperature_c, own.separations[j].as_ref().ok()?)));
                    answer.separated(gyro, separation, measured, (&campaign.geometry, method));
                }
            }
            Outcome::Bench(bench) => answer.tested(campaign, bench),
        }
        answer
    }

    fn note(&mut self, note: CampaignNote) {
        self.notes.push(NoteBody::of(&Note::Campaign(note)));
    }

    fn fitted(&mut self, calibration: &Calibration) {
        let body = &mut self.calibration;
        body.model = names(calibration.terms);
        body.repeats.clone_from(&calibration.repeats);
        body.noise = noise_found(&calibration.noise_found);
        for effect in calibration.gyros.iter().flat_map(|gyro| &gyro.effects).map(|e| e.effect.id()) {
            if !body.effects.iter().any(|known| known == effect) {
                body.effects.push(effect.to_owned());
            }
        }
        body.gyros = calibration.gyros.iter().map(|gyro| GyroFitBody::of(gyro, calibration.has_sem)).collect();
        for note in calibration.all_notes() {
            self.note(note);
        }
    }

    /// `measured`: the same gyro at the temperature at which it was measured, deg C.
    fn separated(
        &mut self,
        gyro: &GyroCalibration,
        separation: &Result<Separation, NotSeparated>,
        measured: Option<(f64, &Separation)>,
        (geometry, method): (&Geometry, JudgedMethod),
    ) {
        let (slot, serial) = (gyro.slot, gyro.serial.to_string());
        match separation {
            Ok(separation) => {
                let body = SeparationBody::of(&serial, separation, method).with_uncertainty(gyro, geometry);
                self.separations.push(match measured {
                    Some((temperature_c, measured)) => body.measured_at(temperature_c, measured),
                    None => body,
                });
            }
            Err(why) => self.not_separated.push(NotSeparatedBody { slot, serial, reason: why.message().to_body() }),
        }
    }

    fn tested(&mut self, campaign: &Campaign, bench: &BenchCalibration) {
        for note in bench.all_notes() {
            self.note(note);
        }
        self.calibration.noise = noise_found(&bench.noise_found);
        self.calibration.repeats.clone_from(&bench.repeats);
        self.calibration.gyros = vec![GyroFitBody::of_bench(campaign, bench)];
        self.bench_result = Some(BenchBody::from(&bench.result(campaign)));
    }
}

impl GyroFitBody {
    fn of(gyro: &GyroCalibration, has_sem: bool) -> Self {
        let scale = gyro.scale_factor();
        let sd = |term| {
            let p: &[Parameter] = gyro.of(term)?;
            Some(Triple([p[0].sd?, p[1].sd?, p[2].sd?]))
        };
        Self {
            slot: gyro.slot,
            serial: gyro.serial.to_string(),
            e_source: gyro.scale_source.name().to_owned(),
            parameters: gyro.parameters.iter().enumerate().map(|(i, p)| ParameterBody::of(p, gyro, i)).collect(),
            effects: gyro.effects.to_body(),
            e_pulse_per_arcsec: gyro.e().map(Triple::from),
            g_pulse_per_s_g0: gyro.g().map(Triple::from),
            p_pulse_per_s_g02: gyro.p().map(Triple::from),
            bias_pulse_per_s: gyro.bias(),
            e_sd: if gyro.scale_source == ScaleSource::Held { Some(Triple([0.0; 3])) } else { sd(Term::Scale) },
            g_sd: sd(Term::GLinear),
            covariance: gyro.covariance.as_ref().map(|c| c.row_iter().map(|r| r.iter().copied().collect()).collect()),
            rank: gyro.rank,
            null_directions: gyro.null_directions.iter().map(|n| NullDirectionBody::of(n, gyro)).collect(),
            chi2: gyro.chi2,
            dof: gyro.dof,
            reduced_chi2: gyro.reduced_chi2().filter(|_| has_sem),
            p_value: gyro.p_value,
            noise: NoiseBody::of(&gyro.noise, gyro.sigma.as_ref(), has_sem, scale),
            residuals: ResidualsBody::of(&gyro.residuals, scale, gyro.standardised.as_ref(), &gyro.leverage),
        }
    }

    fn of_bench(campaign: &Campaign, bench: &BenchCalibration) -> Self {
        let gyro = &campaign.gyros[0];
        let has_sem = campaign.states_errors();
        let k = bench.e.norm();
        Self {
            slot: gyro.slot,
            serial: gyro.serial.to_string(),
            e_source: bench.scale_source.name().to_owned(),
            parameters: bench.coefficients.to_body(),
            effects: Vec::new(),
            e_pulse_per_arcsec: Some(bench.e.into()),
            g_pulse_per_s_g0: None,
            p_pulse_per_s_g02: None,
            bias_pulse_per_s: None,
            e_sd: None,
            g_sd: None,
            covariance: None,
            rank: bench.rank,
            null_directions: bench
                .gauge
                .iter()
                .map(|gauge| NullDirectionBody {
                    direction: bench.null_direction().map(|(name, share)| (name.to_owned(), share)).collect(),
                    gauge: Some((*gauge).to_owned()),
                })
                .collect(),
            chi2: bench.chi2,
            dof: bench.dof,
            reduced_chi2: (has_sem && bench.dof > 0).then(|| bench.chi2 / bench.dof as f64),
            p_value: bench.p_value,
            noise: NoiseBody::of(&bench.noise, bench.sigma.as_ref(), has_sem, Some(k)),
            residuals: ResidualsBody::of(&bench.residuals, Some(k), bench.standardised.as_ref(), &bench.leverage),
        }
    }
}

impl ResidualsBody {
    fn of(
        residuals: &DVector<f64>,
        scale: Option<f64>,
        standardised: Option<&DVector<f64>>,
        leverage: &DVector<f64>,
    ) -> Self {
        Self {
            pulse_per_s: list(residuals),
            deg_per_h: scale.map(|k| residuals.iter().map(|r| r / k).collect()),
            standardised: standardised.map(list),
            leverage: list(leverage),
        }
    }
}

impl NoiseBody {
    fn of(noise: &NoiseScale, sigma: Option<&DVector<f64>>, has_sem: bool, scale: Option<f64>) -> Self {
        let rms = sigma.map(|s| (s.norm_squared() / s.len() as f64).sqrt());
        Self {
            source: noise.source.name().to_owned(),
            weighted: has_sem,
            sem_factor: noise.factor.filter(|_| has_sem),
            sem_factor_sd: noise.factor_sd.filter(|_| has_sem),
            rms_pulse_per_s: rms,
            rms_deg_per_h: rms.zip(scale).map(|(rms, k)| rms / k),
            dof: Some(noise.dof).filter(|dof| dof.is_finite()),
            pure_error_chi2: noise.pure_error.chi2,
            pure_error_dof: noise.pure_error.dof,
        }
    }
}

fn noise_found(found: &NoiseFound) -> Option<NoiseFoundBody> {
    (!found.is_empty()).then(|| NoiseFoundBody::from(found))
}

fn names(terms: Terms) -> Vec<String> {
    terms.iter().map(|term| term.name().to_owned()).collect()
}

fn list(v: &DVector<f64>) -> Vec<f64> {
    v.iter().copied().collect()
}

#[cfg(test)]
mod tests;
