//! Everything true about a campaign: where it is measured, when, with which gyros, and what they answer.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::core::campaign::{Phase, TestKind};
use crate::core::fault::Faults;
use crate::core::model::Terms;
use crate::core::mounting::Slot;

use super::cause::Cause;
use super::detectability::Sight;
use super::environment::temperatures;
use super::fault_at::fault;
use super::gyro::{TrueGyro, gyros};
use super::programme::{Planned, plan};
use super::scenario::Scenario;
use super::sensed::{Disturbance, Sensed, Situation};
use super::station::{Earth, Moment, commanded, moments};
use super::{SECONDS_PER_HOUR, Stream, random};
use crate::message;

/// Two body directions are one vertical within this angle.
const SAME_VERTICAL: f64 = 1e-6;

/// Everything true about a campaign but chance in the output.
#[derive(Debug, Clone)]
pub struct World {
    pub earth: Earth,
    pub plan: Vec<Planned>,
    pub situations: Vec<Situation>,
    pub gyros: Vec<TrueGyro>,
    /// What the station commands and writes down: specific force, inertial rate.
    pub commanded: Vec<(Vector3<f64>, Vector3<f64>)>,
    pub temperature_c: Vec<f64>,
    /// True standard deviation of the means, gyro by gyro, pulse/s.
    pub sd: Vec<Vec<f64>>,
    /// The model against which causes are sized.
    pub terms: Terms,
}

impl World {
    /// Draws everything that a seed decides: programme, temperatures, gyros and their errors.
    pub fn new(scenario: &Scenario) -> Result<Self, Faults> {
        scenario.noise.check()?;
        let geometry = scenario.geometry.resolve()?;
        let earth = Earth::at(&scenario.site)?;
        let seed = scenario.seed;
        let plan = plan(&scenario.programme, earth.latitude, &mut random(seed, Stream::Programme))?;
        let mid_h: Vec<f64> = plan.iter().map(mid_h).collect();
        let temperature_c = temperatures(&scenario.temperature, &mid_h, &mut random(seed, Stream::Temperature))?;
        let mut rng = random(seed, Stream::Population);
        let mut gyros =
            gyros(&scenario.gyros, &geometry, &scenario.population, (&scenario.imu, scenario.seed), &mut rng)?;
        if scenario.test_kind()? == TestKind::TurntableServo {
            // The table's own rate in arcsec/s is the output: the gyro's scale factor does not enter.
            gyros.iter_mut().for_each(|gyro| gyro.scale_factor = 1.0);
        }
        let commanded: Vec<_> = plan.iter().map(|dwell| commanded(dwell, &earth)).collect();
        let last_h = mid_h.last().copied().unwrap_or(1.0);
        let grown: Vec<f64> = mid_h.iter().map(|t| scenario.noise.grown(t / last_h)).collect();
        let sd_of = |gyro: &TrueGyro| -> Vec<f64> {
            plan.iter()
                .zip(&commanded)
                .zip(&grown)
                .map(|((dwell, (_, w)), grown)| {
                    grown * scenario.noise.white_sd_pulse_s(dwell.duration_s, gyro.input().dot(w), gyro.scale_factor)
                })
                .collect()
        };
        let sd: Vec<Vec<f64>> = gyros.iter().map(sd_of).collect();
        if sd.iter().flatten().any(|s| *s == 0.0) && scenario.effects.iter().any(|e| e.detectability.is_some()) {
            return Err(fault("/noise", message!("no_noise_no_detectability")));
        }
        let mean = temperature_c.iter().sum::<f64>() / temperature_c.len() as f64;
        let reference_c = scenario.temperature.reference_c.unwrap_or(mean);
        let kelvin: Vec<f64> = temperature_c.iter().map(|celsius| celsius - reference_c).collect();
        let situations = situations(&plan, &commanded, &kelvin);
        let terms = scenario.asked_terms()?.unwrap_or_default();
        Ok(Self { earth, plan, situations, gyros, commanded, temperature_c, sd, terms })
    }

    /// Noise-free means of every gyro, pulse/s: `[gyro][dwell]`.
    pub fn outputs(&self, causes: &[Cause]) -> Vec<Vec<f64>> {
        let sensed: Vec<Vec<Moment>> =
            self.plan.iter().zip(&self.situations).map(|(dwell, at)| self.sensed(dwell, at, causes)).collect();
        self.gyros
            .iter()
            .map(|gyro| {
                let axes = clocked(gyro, causes);
                sensed.iter().zip(&self.situations).map(|(m, at)| mean_output(gyro, &axes, causes, m, at)).collect()
            })
            .collect()
    }

    /// What the IMU feels in one dwell.
    fn sensed(&self, dwell: &Planned, at: &Situation, causes: &[Cause]) -> Vec<Moment> {
        let one = Rotation3::identity();
        let table_from_nav = causes.iter().fold(one, |r, cause| cause.table_from_nav(at) * r);
        let seat = causes.iter().fold(one, |r, cause| cause.seat(at) * r);
        let mut sensed = moments(dwell, &self.earth, &table_from_nav);
        for moment in &mut sensed {
            for vector in [&mut moment.a, &mut moment.w, &mut moment.field, &mut moment.north] {
                *vector = seat * *vector;
            }
        }
        sensed
    }

    /// Detectability of a set of causes, gyro by gyro, and the power of their response, seen or not.
    pub fn detectability(&self, causes: &[Cause]) -> (Vec<f64>, Vec<f64>) {
        let (with, without) = (self.outputs(causes), self.outputs(&[]));
        let each = with.iter().zip(&without).zip(&self.sd).map(|((with, without), sd)| {
            let response: Vec<f64> = with.iter().zip(without).map(|(a, b)| a - b).collect();
            let sight = Sight::new(self.terms, &self.commanded, sd);
            (sight.detectability(&response), sight.power(&response))
        });
        each.unzip()
    }

    /// Slots of its gyros, in the order of the outputs.
    pub fn slots(&self) -> impl Iterator<Item = Slot> {
        self.gyros.iter().map(|gyro| gyro.slot)
    }

    /// Middles of the dwells, hours after the start.
    pub fn mid_h(&self) -> Vec<f64> {
        self.plan.iter().map(mid_h).collect()
    }
}

fn mid_h(dwell: &Planned) -> f64 {
    (dwell.start_s + 0.5 * dwell.duration_s) / SECONDS_PER_HOUR
}

fn situations(plan: &[Planned], commanded: &[(Vector3<f64>, Vector3<f64>)], kelvin: &[f64]) -> Vec<Situation> {
    let mut face_since_s = 0.0;
    (0..plan.len())
        .map(|k| {
            if k > 0 && commanded[k].0.angle(&commanded[k - 1].0) > SAME_VERTICAL {
                face_since_s = plan[k].start_s;
            }
            let time_h = mid_h(&plan[k]);
            Situation {
                index: k,
                face: nearest_face(&commanded[k].0),
                turning: plan[k].phase == Phase::Rate,
                time_h,
                since_power_up_h: plan[k].since_power_up_s / SECONDS_PER_HOUR,
                since_face_change_h: time_h - face_since_s / SECONDS_PER_HOUR,
                temperature_k: kelvin[k],
                a_before: k.checked_sub(1).map(|before| commanded[before].0),
                w_before: k.checked_sub(1).map(|before| commanded[before].1),
            }
        })
        .collect()
}

/// Which of +x, -x, +y, -y, +z, -z is nearest to a direction.
fn nearest_face(up: &Vector3<f64>) -> usize {
    let axis = up.iamax();
    2 * axis + usize::from(up[axis] < 0.0)
}

/// The gyro's axes with every clocking among `causes`: S and O turned about I.
pub(super) fn clocked(gyro: &TrueGyro, causes: &[Cause]) -> Matrix3<f64> {
    let angle: f64 = causes.iter().map(|cause| cause.clocking(gyro.slot.index())).sum();
    let (s, c) = angle.sin_cos();
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, s, 0.0, -s, c) * gyro.axes
}

/// K (1 + scale changes)(w_I + drift), averaged over the moments of one dwell, pulse/s.
fn mean_output(gyro: &TrueGyro, axes: &Matrix3<f64>, causes: &[Cause], moments: &[Moment], at: &Situation) -> f64 {
    let one = |moment: &Moment| {
        let sensed = Sensed {
            a: axes * moment.a,
            w: axes * moment.w,
            field: axes * moment.field,
            a_before: at.a_before.map(|a| axes * a),
            w_before: at.w_before.map(|w| axes * w),
            body: *moment,
        };
        let slot = gyro.slot.index();
        let sum = causes.iter().fold(Disturbance::default(), |sum, cause| {
            let more = cause.acts(slot, &sensed, at);
            Disturbance { drift: sum.drift + more.drift, scale: sum.scale + more.scale }
        });
        gyro.scale_factor * (1.0 + sum.scale) * (sensed.w.x + gyro.drift.rate(&sensed.a) + sum.drift)
    };
    moments.iter().map(one).sum::<f64>() / moments.len() as f64
}
