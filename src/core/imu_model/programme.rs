//! What a campaign, measured or to be measured, asks of the model: columns, noise, and what the model knows for it.

use nalgebra::{DMatrix, DVector, Vector3};

use super::columns::columns;
use super::identified::{Identified, ModelGyro};
use crate::core::calibrate::noise::t_variance;
use crate::core::calibrate::{errors_as_weighed, station};
use crate::core::campaign::{Campaign, StationUncertainty, Temperatures, TestKind};
use crate::core::effects::{CATALOGUE, Parameter, Refusal, Scope, Setting, Shape};
use crate::core::message::{Message, figure, text};
use crate::core::mounting::Slot;
use crate::core::numerics::normal_equations::inverse_of_covariance;
use crate::core::record::Name;
use crate::message;

/// Why a model foretells nothing of a campaign.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", self.message())]
pub enum NoForecast {
    OtherImu {
        model: Name,
        campaign: Name,
    },
    OtherGeometry,
    BenchTest,
    NoGyro,
    FittedTo,
    #[error(transparent)]
    Refused(#[from] Refusal),
}

impl NoForecast {
    /// The refusal as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::OtherImu { model, campaign } => {
                message!("model_of_other_imu", model = text(model), campaign = text(campaign))
            }
            Self::OtherGeometry => message!("model_of_other_geometry"),
            Self::BenchTest => message!("bench_test_has_no_forecast"),
            Self::NoGyro => message!("model_without_gyros"),
            Self::FittedTo => message!("model_fitted_to_campaign"),
            Self::Refused(why) => why.message(),
        }
    }
}

/// Cosine of the angle from every direction that the model has seen beyond which an attitude is new to it: 20 degrees.
const NEW_DIRECTION: f64 = 0.94;
/// Share by which a rate may exceed those seen.
const FASTER: f64 = 1.01;
/// K by which a temperature may lie outside the span seen, beside a tenth of it.
const WARMER_K: f64 = 0.5;

/// A gyro that both the model and the campaign have.
#[derive(Debug, Clone)]
pub(super) struct ForecastGyro {
    /// Among the campaign's gyros.
    pub place: usize,
    pub slot: Slot,
    pub serial: Name,
    /// |E|, pulse/arcsec.
    pub scale: f64,
    /// Degrees of freedom that its noise is known by.
    pub dof: f64,
    /// Square of the noise's standard deviation, which is one of a t distribution, over the estimated variance.
    pub t_variance: f64,
}

/// Whether the model has seen the like of a dwell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub temperature: bool,
    pub rate: bool,
    pub attitude: bool,
    /// K above the highest temperature seen, or below the lowest (negative).
    pub beyond_k: f64,
}

impl Seen {
    /// Whether the dwell lies within the temperatures, rates and attitudes that the model has seen.
    pub fn whole(self) -> bool {
        self.temperature && self.rate && self.attitude
    }
}

/// Rows of all gyros one after the other, dwell by dwell.
#[derive(Debug, Clone)]
pub(super) struct StackedDesign {
    pub gyros: Vec<ForecastGyro>,
    pub dwells: usize,
    /// pulse/s per unit of each coefficient, then of each rotation of the station in its standard uncertainty: drawn
    /// anew in every campaign, the same in all dwells and gyros of one.
    pub columns: DMatrix<f64>,
    /// What held E make of the rates, pulse/s.
    pub held: DVector<f64>,
    /// Standard deviation of each output's noise, pulse/s.
    pub noise: DVector<f64>,
    /// What D_I and D_S of the row's gyro make of it, pulse/s per deg/(h g0).
    pub steps: Vec<[f64; 2]>,
    pub seen: Vec<Seen>,
    pub setting: Setting,
    /// Whether the scale of the noise is one for all gyros: a factor on stated standard errors.
    pub one_scale: bool,
    pub notes: Vec<Message>,
}

impl StackedDesign {
    /// Columns, noise and sensitivities of a campaign's dwells for the gyros that the model knows. What it cannot
    /// forecast is noted.
    ///
    /// # Errors
    /// A bench test, another IMU or geometry, no gyro in common, or axes that the model does not have.
    pub fn of(model: &Identified, campaign: &Campaign) -> Result<Self, NoForecast> {
        if campaign.test != TestKind::Imu {
            return Err(NoForecast::BenchTest);
        }
        if campaign.imu != model.imu {
            return Err(NoForecast::OtherImu { model: model.imu.clone(), campaign: campaign.imu.clone() });
        }
        if !campaign.geometry.is_same(&model.geometry) {
            return Err(NoForecast::OtherGeometry);
        }
        let mut notes = Vec::new();
        let known = known(model, campaign, &mut notes);
        if known.is_empty() {
            return Err(NoForecast::NoGyro);
        }
        let axes = known.iter().map(|(_, gyro)| model.axes(gyro)).collect::<Result<Vec<_>, _>>()?;
        let setting = Setting::of(campaign, axes).referred_to(campaign, model.reference_c);
        let columns = columns(&setting, &model.coefficients, &model.effects);
        notes.extend(
            columns
                .lacking
                .iter()
                .map(|(effect, lack)| message!("effect_not_foretold", effect = effect.word(), why = lack.message())),
        );
        let seen = outside(model, campaign, &setting, &mut notes);
        let n = setting.dwells();
        let one_scale = campaign.states_errors() && known.iter().all(|(_, gyro)| gyro.noise.sem_factor.is_some());
        let (mut held, mut noise) = (DVector::zeros(known.len() * n), DVector::zeros(known.len() * n));
        let errors = errors_as_weighed(campaign);
        for (j, (place, gyro)) in known.iter().enumerate() {
            let stated = errors.as_ref().map(|errors| &errors[*place]).zip(gyro.noise.sem_factor);
            let law = |k: usize| {
                let walk = gyro.noise.random_walk.powi(2) * 3600.0 / setting.duration[k];
                let uneven = 1e-6 * gyro.noise.rate_ppm * setting.rate[k].dot(&setting.gyros[j].input);
                setting.gyros[j].scale * (walk + uneven * uneven).sqrt()
            };
            for k in 0..n {
                noise[j * n + k] = stated.as_ref().map_or_else(|| law(k), |(sem, factor)| sem[k] * factor);
                held[j * n + k] = if gyro.e_held { gyro.e.dot(&setting.rate[k]) } else { 0.0 };
            }
        }
        let along = |j: usize, k: usize| {
            let axes = &setting.gyros[j];
            [axes.input, axes.spin].map(|axis| axes.scale * axis.dot(&setting.force[k]))
        };
        let steps = (0..known.len() * n).map(|i| along(i / n, i % n)).collect();
        let gyros = known.iter().zip(&setting.gyros).map(|((place, gyro), axes)| ForecastGyro {
            place: *place,
            slot: gyro.slot,
            serial: gyro.serial.clone(),
            scale: axes.scale,
            dof: gyro.noise.dof,
            // The scale is the mean of those of the campaigns.
            t_variance: t_variance(model.dof(Some(gyro.slot))),
        });
        let stated =
            if is_fitted_to(model, campaign) { StationUncertainty::default() } else { campaign.station_uncertainty };
        Ok(Self {
            gyros: gyros.collect(),
            dwells: n,
            columns: beside(columns.matrix, &station_columns(&setting, &stated)),
            held,
            noise,
            steps,
            seen,
            setting,
            one_scale,
            notes,
        })
    }

    /// Of a campaign that the model was not fitted to.
    pub fn of_another(model: &Identified, campaign: &Campaign) -> Result<Self, NoForecast> {
        let programme = Self::of(model, campaign)?;
        if is_fitted_to(model, campaign) { Err(NoForecast::FittedTo) } else { Ok(programme) }
    }

    /// The same with whatever temperature may do beyond those seen: as much more of every effect that the catalogue has of
    /// it as is plausible, straight and bent; and in each dwell for itself, as shapes that the catalogue lacks have it,
    /// the largest size met in practice.
    pub fn beyond_seen(&self) -> Self {
        let n = self.dwells;
        let beyond: Vec<f64> = self.seen.iter().map(|seen| seen.beyond_k).collect();
        let furthest = beyond.iter().fold(0.0_f64, |most, k| most.max(k.abs()));
        if furthest == 0.0 {
            return self.clone();
        }
        let straight = Setting { temperature: Some(beyond.clone()), ..self.setting.clone() };
        let bent = Setting { temperature: Some(beyond.iter().map(|k| k * k / furthest).collect()), ..straight.clone() };
        let (mut columns, mut variance) = (Vec::new(), self.noise.component_mul(&self.noise));
        for entry in CATALOGUE.iter().filter(|entry| entry.of_temperature) {
            for j in 0..self.gyros.len() {
                let scale = self.gyros[j].scale;
                let of = |setting: &Setting| entry.regressors(setting, j, Shape::Linear);
                for regressor in of(&straight) {
                    (0..n).for_each(|k| variance[j * n + k] += (scale * entry.typical[1] * regressor[k]).powi(2));
                }
                for regressor in of(&straight).into_iter().chain(of(&bent)) {
                    let of_row = |i: usize| if i / n == j { scale * entry.plausible * regressor[i % n] } else { 0.0 };
                    columns.push(DVector::from_fn(variance.len(), |i, _| of_row(i)));
                }
            }
        }
        let columns = beside(self.columns.clone(), &DMatrix::from_columns(&columns));
        Self { columns, noise: variance.map(f64::sqrt), ..self.clone() }
    }

    /// Outputs of the gyros, less what held E make of the rates, pulse/s.
    pub fn measured(&self, campaign: &Campaign) -> DVector<f64> {
        let all = self.gyros.iter().flat_map(|gyro| campaign.dwells.iter().map(|d| d.output_pulse_s[gyro.place]));
        DVector::from_iterator(self.held.len(), all) - &self.held
    }
}

/// What each rotation that a station states makes of the outputs, gyro by gyro, dwell by dwell: pulse/s per standard
/// uncertainty.
pub(super) fn station_columns(setting: &Setting, stated: &StationUncertainty) -> DMatrix<f64> {
    let n = setting.dwells();
    let rotations = station::rotations(setting, stated);
    DMatrix::from_fn(setting.gyros.len() * n, rotations.len(), |i, c| rotations[c].columns[i / n][i % n])
}

fn beside(left: DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let (p, q) = (left.ncols(), right.ncols());
    let mut both = left.resize_horizontally(p + q, 0.0);
    both.columns_mut(p, q).copy_from(right);
    both
}

fn is_fitted_to(model: &Identified, campaign: &Campaign) -> bool {
    model.campaigns.iter().any(|fitted| fitted.measured_at == campaign.measured_at)
}

/// The gyros that both have; what the others are is noted.
fn known<'a>(model: &'a Identified, campaign: &Campaign, notes: &mut Vec<Message>) -> Vec<(usize, &'a ModelGyro)> {
    let mut known = Vec::new();
    for (place, gyro) in campaign.gyros.iter().enumerate() {
        match model.gyro(gyro.slot) {
            Some(own) if own.serial == gyro.serial => known.push((place, own)),
            Some(own) => notes.push(message!(
                "gyro_exchanged_since",
                slot = gyro.slot.name(),
                then = text(&own.serial),
                now = text(&gyro.serial)
            )),
            None => notes.push(message!("gyro_not_in_model", slot = gyro.slot.name(), serial = text(&gyro.serial))),
        }
    }
    known
}

/// Notes what the model's campaigns have not shown; whether they have, dwell by dwell.
fn outside(model: &Identified, campaign: &Campaign, setting: &Setting, notes: &mut Vec<Message>) -> Vec<Seen> {
    let mut seen = vec![Seen { temperature: true, rate: true, attitude: true, beyond_k: 0.0 }; setting.dwells()];
    if let (Some([low, high]), Some(now)) = (model.validity.temperature_c, Temperatures::stated(campaign)) {
        let room = WARMER_K + 0.1 * (high - low);
        for (seen, t) in seen.iter_mut().zip(&now) {
            seen.temperature = (low - room..=high + room).contains(t);
            seen.beyond_k = t - t.clamp(low, high);
        }
        let (least, most) = now.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), t| (l.min(*t), m.max(*t)));
        if least < low - room || most > high + room {
            let [low, high, least, most] = [low, high, least, most].map(|t| figure(t, 1));
            notes.push(message!("temperature_outside_model", low, high, least, most));
        }
    }
    let fastest = setting.rate.iter().map(|w| w.norm()).fold(0.0, f64::max);
    if fastest > FASTER * model.validity.rate_arcsec_s {
        let slow = |rate: &Vector3<f64>| rate.norm() <= FASTER * model.validity.rate_arcsec_s;
        seen.iter_mut().zip(&setting.rate).for_each(|(seen, rate)| seen.rate = slow(rate));
        let (seen, now) = (figure(model.validity.rate_arcsec_s, 0), figure(fastest, 0));
        notes.push(message!("rate_outside_model", seen, now));
    }
    let is_new = |force: &&Vector3<f64>| {
        let along = |known: &Vector3<f64>| known.dot(force) / force.norm();
        force.norm() > 0.0 && model.validity.directions.iter().all(|known| along(known) < NEW_DIRECTION)
    };
    seen.iter_mut().zip(&setting.force).for_each(|(seen, force)| seen.attitude = !is_new(&force));
    let new = setting.force.iter().filter(is_new).count();
    if new > 0 {
        notes.push(message!("attitudes_outside_model", dwells = new));
    }
    if campaign.measured_at < model.measured_at {
        notes.push(message!("campaign_before_model"));
    }
    let stations = || model.campaigns.iter().map(|fitted| &fitted.station);
    if !stations().any(|station| *station == campaign.station) {
        let of_station = model.effects.iter().filter(|adopted| adopted.effect.entry().scope == Scope::Common);
        notes.extend(of_station.map(|a| message!("effect_of_other_station", effect = a.effect.word())));
    }
    if model.campaigns.len() == 1 {
        notes.push(message!("ageing_unknown"));
    }
    seen
}

/// Coefficients with their covariance.
#[derive(Debug, Clone)]
pub(super) struct CoefficientEstimate {
    pub values: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

impl CoefficientEstimate {
    /// What the model knows for a campaign, with its first `effects` effects only.
    ///
    /// Without the others it is the fit in which they are zero, `theta - C_k C_kk^-1 k`: what the same campaigns say
    /// where nobody has adopted them. From campaign to campaign coefficients differ by `between`; the phase of a
    /// cycle is any; effects of another station's table are none of this one's. What `programme` asks of beside the
    /// model's coefficients is zero with unit variance.
    pub fn of(model: &Identified, campaign: &Campaign, programme: &StackedDesign, effects: usize) -> Self {
        let mut estimate = Self { values: model.values(), covariance: model.covariance.clone() };
        let omitted: Vec<usize> = (effects..model.effects.len()).flat_map(|e| model.of_effect(e)).collect();
        estimate.condition(&omitted, &DVector::zeros(omitted.len()));
        let same_station = model.campaigns.iter().any(|fitted| fitted.station == campaign.station);
        let fitted_to = is_fitted_to(model, campaign);
        for (e, adopted) in model.effects.iter().enumerate().take(effects).filter(|_| !fitted_to) {
            let entry = adopted.effect.entry();
            let places = model.of_effect(e);
            if entry.scope == Scope::Common && !same_station {
                places.iter().for_each(|place| estimate.set(*place, 0.0, 0.0));
            }
            if entry.parameter == Parameter::Period {
                for pair in places.chunks(2) {
                    let power: f64 = pair.iter().map(|p| estimate.values[*p].powi(2)).sum();
                    pair.iter().for_each(|place| estimate.set(*place, 0.0, 0.5 * power));
                }
            }
        }
        if !fitted_to {
            for (place, coefficient) in model.coefficients.iter().enumerate() {
                estimate.covariance[(place, place)] += coefficient.between.powi(2);
            }
        }
        let (p, all) = (model.coefficients.len(), programme.columns.ncols());
        let mut covariance = estimate.covariance.resize(all, all, 0.0);
        (p..all).for_each(|place| covariance[(place, place)] = 1.0);
        Self { values: estimate.values.resize_vertically(all, 0.0), covariance }
    }

    /// Fixes the coefficients at `places` at `values`.
    pub fn condition(&mut self, places: &[usize], values: &DVector<f64>) {
        if places.is_empty() {
            return;
        }
        let across = self.covariance.select_columns(places);
        let within = across.select_rows(places);
        let Some(inverse) = inverse_of_covariance(&within) else { return };
        let gain = across * inverse;
        self.values -= &gain * (self.values.select_rows(places) - values);
        let told = &gain * self.covariance.select_rows(places);
        self.covariance -= told;
        for (place, value) in places.iter().zip(values) {
            self.set(*place, *value, 0.0);
        }
    }

    /// A coefficient whose error has nothing in common with any other's.
    fn set(&mut self, place: usize, value: f64, variance: f64) {
        self.values[place] = value;
        self.covariance.row_mut(place).fill(0.0);
        self.covariance.column_mut(place).fill(0.0);
        self.covariance[(place, place)] = variance;
    }
}
