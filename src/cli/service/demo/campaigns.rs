//! Raw campaigns with something hidden in them, to diagnose.

use super::DemoInput;
use crate::core::time::UtcMicros;
use crate::simulate::presets::preset;
use crate::simulate::scenario::{EffectChoice, Population};
use crate::simulate::{Scenario, simulate};
use crate::wire::campaign::CampaignBody;
use crate::wire::time;

const IMU: &str = "IMU-21";
/// Each gyro with the scale factor (pulse per arcsec) that Table 3 requires, and how well they are mounted: E keeps
/// to the table.
const GYROS: [(&str, f64); 3] = [("LFG-0061", 1.468), ("LFG-0062", 1.468), ("LFG-0063", 1.4775)];
const MISALIGNMENT_ARCMIN: f64 = 2.0;
/// Days before today; the programme; what is hidden, and how visible it is.
const CAMPAIGNS: [(f64, &str, &[(&str, f64)]); 4] = [
    (52.0, "24-position", &[]),
    (38.0, "24-position", &[("temperature_bias", 14.0)]),
    (24.0, "60-position", &[("hysteresis", 16.0), ("scale_asymmetry", 18.0)]),
    (10.0, "24-bare", &[]),
];

pub fn inputs(today: UtcMicros) -> anyhow::Result<Vec<DemoInput>> {
    CAMPAIGNS.iter().map(|&(days_ago, programme, hidden)| campaign(today, days_ago, programme, hidden)).collect()
}

fn campaign(today: UtcMicros, days_ago: f64, programme: &str, hidden: &[(&str, f64)]) -> anyhow::Result<DemoInput> {
    let base = preset(programme).expect("the presets are those of the list");
    let mut gyros = base.gyros.clone();
    for (gyro, (serial, scale)) in gyros.iter_mut().zip(GYROS) {
        gyro.serial = Some(serial.into());
        gyro.scale_factor = Some(scale);
    }
    let population = Population { misalignment_arcmin: MISALIGNMENT_ARCMIN, ..base.population.clone() };
    let scenario = Scenario {
        seed: 21,
        imu: IMU.into(),
        station: "ST-1".into(),
        measured_at: time::format(today.plus_days(-days_ago)),
        gyros,
        population,
        effects: hidden.iter().map(|&(effect, visible)| EffectChoice::detectable(effect, visible)).collect(),
        ..base
    };
    let simulated = simulate(&scenario)?;
    Ok(DemoInput::Campaign(Box::new(CampaignBody::from(&simulated.campaign))))
}
