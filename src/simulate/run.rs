//! From a scenario to a campaign and its truth.

use std::collections::BTreeMap;

use nalgebra::Matrix3;

use crate::core::campaign::{Campaign, CampaignGyro, Dwell, StationUncertainty};
use crate::core::fault::Faults;
use crate::core::frames::Rotation;
use crate::core::message::Message;
use crate::core::numerics::median::upper_median_of;
use crate::core::record::Name;
use crate::core::time::UtcMicros;

use super::cause::Cause;
use super::detectability::norm;
use super::fault_at::fault;
use super::gyro::TrueGyro;
use super::inject::{injected, is_visible};
use super::noise::{bias_wander, white};
use super::scenario::{OptionalColumns, Scenario, StandardErrors};
use super::truth::{GyroKey, KeyEntry, OUTSIDE};
use super::world::{World, clocked};
use super::{Stream, gaussian, random};

/// Relative standard deviation of noisy standard errors.
const NOISY: f64 = 0.12;
/// A campaign as the station writes it, and what it does not say.
#[derive(Debug, Clone)]
pub struct Simulated {
    pub campaign: Campaign,
    pub truth: KeyEntry,
    pub causes: Vec<Cause>,
    pub world: World,
}

/// Runs `scenario`. The same scenario gives the same campaign, bit for bit.
pub fn simulate(scenario: &Scenario) -> Result<Simulated, Faults> {
    let world = World::new(scenario)?;
    let mut rng = random(scenario.seed, Stream::Causes);
    let causes = scenario
        .effects
        .iter()
        .enumerate()
        .map(|(i, choice)| injected(&world, choice, &format!("/effects/{i}"), &mut rng))
        .collect::<Result<Vec<_>, _>>()?;
    let truth = world.truth(scenario, &causes);
    let campaign = world.measured(scenario, &causes)?;
    Ok(Simulated { campaign, truth, causes, world })
}

impl World {
    /// The key of this campaign.
    pub fn truth(&self, scenario: &Scenario, causes: &[Cause]) -> KeyEntry {
        let mut seen_by = Vec::new();
        let mut gyros = Vec::new();
        for cause in causes {
            let (seen, power) = self.detectability(std::slice::from_ref(cause));
            let by: BTreeMap<String, f64> = self.slots().zip(&seen).map(|(slot, d)| (slot.name().into(), *d)).collect();
            gyros.extend(
                self.slots()
                    .enumerate()
                    .filter(|(k, _)| is_visible(seen[*k], power[*k]))
                    .map(|(_, slot)| slot.name().to_owned()),
            );
            seen_by.push(by);
        }
        gyros.sort();
        gyros.dedup();
        let outside = causes.iter().find_map(|cause| cause.label.strip_prefix("outside:"));
        let label =
            |cause: &Cause| if cause.label.starts_with("outside:") { OUTSIDE.into() } else { cause.label.clone() };
        KeyEntry {
            effects: causes.iter().map(label).collect(),
            sizes: causes.iter().map(|cause| cause.size).collect(),
            design: scenario.programme.positions.name().into(),
            sem: scenario.columns.standard_errors.name().into(),
            seen: if causes.is_empty() { 0.0 } else { norm(&self.detectability(causes).0) },
            gyros,
            truth: self.gyros.iter().map(|gyro| gyro_key(gyro, &clocked(gyro, causes))).collect(),
            seed: Some(scenario.seed),
            family: outside.map(str::to_owned),
            seen_by,
        }
    }

    /// The campaign that the station writes: chance added, columns left out.
    fn measured(&self, scenario: &Scenario, causes: &[Cause]) -> Result<Campaign, Faults> {
        let outputs = self.noisy_outputs(scenario, causes);
        let stated = self.stated_standard_errors(&scenario.columns, scenario.seed);
        let mut rng = random(scenario.seed, Stream::Temperature);
        rng.set_word_pos(1 << 40);
        let read = scenario.temperature.reading_sd_k;
        let dwells = self
            .plan
            .iter()
            .enumerate()
            .map(|(k, dwell)| Dwell {
                phase: dwell.phase,
                start_s: dwell.start_s,
                duration_s: dwell.duration_s,
                attitude: scenario.columns.attitude.then(|| Rotation::stated_as(dwell.attitude)),
                specific_force_g0: self.commanded[k].0,
                rate_arcsec_s: self.commanded[k].1,
                temperature_c: scenario.columns.temperature.then(|| self.temperature_c[k] + read * gaussian(&mut rng)),
                output_pulse_s: outputs.iter().map(|gyro| gyro[k]).collect(),
                output_sem_pulse_s: stated.as_ref().map(|gyros| gyros.iter().map(|gyro| gyro[k]).collect()),
            })
            .collect();
        Ok(Campaign {
            imu: name(&scenario.imu, "/imu")?,
            station: name(&scenario.station, "/station")?,
            measured_at: instant(&scenario.measured_at)?,
            geometry: scenario.geometry.resolve()?,
            site: Some(self.earth.stated(scenario.site.states_magnetic_field)),
            station_uncertainty: StationUncertainty::default(),
            gyros: self.stated_gyros()?,
            dwells,
            rates_sent_in_steps: None,
            test: scenario.test_kind()?,
            model: scenario.asked_terms()?,
            temperature_c: scenario.columns.temperature.then_some(scenario.temperature.mean_c),
            operator: None,
            note: None,
        })
    }

    fn stated_gyros(&self) -> Result<Vec<CampaignGyro>, Faults> {
        self.gyros
            .iter()
            .enumerate()
            .map(|(k, gyro)| {
                let serial = name(&gyro.serial, &format!("/gyros/{k}/serial"))?;
                Ok(CampaignGyro { slot: gyro.slot, serial, known_e: gyro.stated_e })
            })
            .collect()
    }

    fn noisy_outputs(&self, scenario: &Scenario, causes: &[Cause]) -> Vec<Vec<f64>> {
        let noise = &scenario.noise;
        let mut rng = random(scenario.seed, Stream::Noise);
        let ideal = self.outputs(causes);
        let n = self.plan.len();
        let mid_h = self.mid_h();
        let last_h = mid_h.last().copied().unwrap_or(1.0);
        // Drawn only where gyros share something, so that a seed without it gives what it always gave.
        let mut of_all = random(scenario.seed, Stream::SharedNoise);
        let shared: Vec<f64> = (0..n).map(|_| gaussian(&mut of_all)).collect();
        let wander = noise.shared_wander.then(|| bias_wander(noise, &self.plan, &mut of_all));
        let noisy = |(gyro, ideal): (&TrueGyro, Vec<f64>)| -> Vec<f64> {
            let bias = wander.clone().unwrap_or_else(|| bias_wander(noise, &self.plan, &mut rng));
            (0..n)
                .map(|k| {
                    let dwell = &self.plan[k];
                    let w_input = gyro.input().dot(&self.commanded[k].1);
                    let white = white(noise, dwell.duration_s, w_input, gyro.scale_factor, shared[k], &mut rng);
                    let chance = noise.grown(mid_h[k] / last_h) * white;
                    let output = ideal[k] + gyro.scale_factor * bias[k] + chance;
                    noise.counted(output, dwell.duration_s, &mut rng)
                })
                .collect()
        };
        self.gyros.iter().zip(ideal).map(noisy).collect()
    }

    fn stated_standard_errors(&self, columns: &OptionalColumns, seed: u64) -> Option<Vec<Vec<f64>>> {
        let mut rng = random(seed, Stream::StandardErrors);
        let mut wrong = || (1.0 + NOISY * gaussian(&mut rng)).max(0.3);
        match columns.standard_errors {
            StandardErrors::Absent => None,
            StandardErrors::Exact => Some(self.sd.clone()),
            StandardErrors::Constant => {
                let middle = |sd: &Vec<f64>| upper_median_of(sd.iter().copied()).unwrap_or_default();
                Some(self.sd.iter().map(|sd| vec![middle(sd); sd.len()]).collect())
            }
            StandardErrors::Noisy => Some(self.sd.iter().map(|sd| sd.iter().map(|s| s * wrong()).collect()).collect()),
        }
    }
}

fn gyro_key(gyro: &TrueGyro, axes: &Matrix3<f64>) -> GyroKey {
    let row = |k: usize| [axes[(k, 0)], axes[(k, 1)], axes[(k, 2)]];
    GyroKey {
        d_i: gyro.drift.d_i,
        d_s: gyro.drift.d_s,
        k: gyro.scale_factor,
        d_f: gyro.drift.d_f,
        input: row(0),
        spin: row(1),
    }
}

fn name(text: &str, pointer: &str) -> Result<Name, Faults> {
    Name::parse(text).map_err(|why| fault(pointer, why))
}

fn instant(text: &str) -> Result<UtcMicros, Faults> {
    let parsed: Result<jiff::Timestamp, _> = text.parse();
    parsed.map(|t| UtcMicros(t.as_microsecond())).map_err(|e| fault("/measured_at", Message::verbatim(e)))
}
