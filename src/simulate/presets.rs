//! Ready scenarios.

use super::programme::{DwellOrder, Positions, Programme};
use super::scenario::{GeometryChoice, OptionalColumns, OutputNoise, Scenario, StandardErrors, StatedE};

/// Name, and the code of the words about it.
pub const PRESETS: [(&str, &str); 6] = [
    ("24-position", "preset_24_position"),
    ("24-bare", "preset_24_bare"),
    ("36-position", "preset_36_position"),
    ("60-position", "preset_60_position"),
    ("long", "preset_long"),
    ("orthogonal-mems", "preset_orthogonal_mems"),
];

/// The preset of that name, if there is one.
pub fn preset(name: &str) -> Option<Scenario> {
    let base = Scenario::default();
    Some(match name {
        "24-position" => base,
        "24-bare" => {
            let programme =
                Programme { repeats: 0, rates_arcsec_s: Vec::new(), order: DwellOrder::Fixed, ..Programme::default() };
            let mut bare = Scenario { programme, ..base };
            bare.gyros.iter_mut().for_each(|gyro| gyro.states_e = StatedE::True);
            bare
        }
        "36-position" => positions(base, Positions::WithEdges),
        "60-position" => positions(base, Positions::WithTilts),
        "long" => {
            let long = positions(base, Positions::WithTilts);
            Scenario {
                programme: Programme { cycles: 8, repeats: 18, power_ups: 4, ..long.programme },
                noise: OutputNoise {
                    bias_instability_deg_per_h: 5e-4,
                    rate_random_walk_deg_per_h_sqrt_h: 2e-4,
                    pulse_quantum: 1.0 / 64.0,
                    ..long.noise
                },
                ..long
            }
        }
        "orthogonal-mems" => {
            let mut mems = Scenario {
                geometry: GeometryChoice::Named("orthogonal".into()),
                programme: Programme { rates_arcsec_s: Vec::new(), ..Programme::default() },
                noise: OutputNoise {
                    angle_random_walk_deg_per_sqrt_h: 0.2,
                    bias_instability_deg_per_h: 5.0,
                    pulse_quantum: 1.0,
                    ..OutputNoise::default()
                },
                columns: OptionalColumns {
                    temperature: false,
                    attitude: true,
                    standard_errors: StandardErrors::Absent,
                },
                ..base
            };
            mems.population.scale_factor = 1.0;
            mems.population.scale_factor_sd = 0.0;
            mems.population.d_f_sd = 200.0;
            mems.population.d_i_sd = 50.0;
            mems.population.d_s_sd = 50.0;
            mems.gyros.iter_mut().for_each(|gyro| gyro.states_e = StatedE::True);
            mems
        }
        _ => return None,
    })
}

fn positions(base: Scenario, positions: Positions) -> Scenario {
    Scenario { programme: Programme { positions, ..base.programme }, ..base }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_listed_preset_exists_and_runs() {
        for (name, _) in PRESETS {
            let scenario = preset(name).unwrap_or_else(|| panic!("{name} is listed"));
            crate::simulate::simulate(&scenario).unwrap_or_else(|faults| panic!("{name}: {faults}"));
        }
        assert!(preset("25-position").is_none());
    }
}
