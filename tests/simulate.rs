//! What a simulated campaign is: physics checked by formulas of its own, chance checked by its statistics.

use crate::command::{complaint, printed};
use gyrowatch::core::campaign::{Campaign, Phase};
use gyrowatch::core::mounting::Slot;
use gyrowatch::simulate::cause::{CATALOGUE, COMMON};
use gyrowatch::simulate::outside::FAMILIES;
use gyrowatch::simulate::presets::{PRESETS, preset};
use gyrowatch::simulate::programme::{DwellOrder, Positions, Programme};
use gyrowatch::simulate::scenario::{EffectChoice, OutputNoise, Profile, Scenario, StandardErrors, Temperature};
use gyrowatch::simulate::truth::{Key, KeyEntry};
use gyrowatch::simulate::{Simulated, simulate};
use gyrowatch::wire::campaign::{parse_json, to_json};
use nalgebra::{DMatrix, DVector, Vector3};
use rstest::rstest;

fn station_runs(scenario: &Scenario) -> Simulated {
    simulate(scenario).unwrap_or_else(|faults| panic!("{faults}"))
}

fn without_noise(scenario: Scenario) -> Scenario {
    let noise = OutputNoise { angle_random_walk_deg_per_sqrt_h: 0.0, rate_noise_ppm: 0.0, ..scenario.noise };
    Scenario { noise, ..scenario }
}

fn with_positions(positions: Positions) -> Scenario {
    Scenario { programme: Programme { positions, ..Programme::default() }, ..Scenario::default() }
}

fn with_effect(scenario: Scenario, effect: EffectChoice) -> Scenario {
    Scenario { effects: vec![effect], ..scenario }
}

/// Outputs of one gyro, dwell by dwell.
fn outputs(campaign: &Campaign, gyro: usize) -> Vec<f64> {
    campaign.dwells.iter().map(|dwell| dwell.output_pulse_s[gyro]).collect()
}

#[test]
fn without_noise_or_cause_the_output_is_scale_times_rate_plus_mass_unbalance() {
    let run = station_runs(&without_noise(with_positions(Positions::WithTilts)));
    for (j, truth) in run.truth.truth.iter().enumerate() {
        let (input, spin) = (Vector3::from(truth.input), Vector3::from(truth.spin));
        for dwell in &run.campaign.dwells {
            let (a, w) = (dwell.specific_force_g0, dwell.rate_arcsec_s);
            let drift = truth.d_f + truth.d_i * a.dot(&input) + truth.d_s * a.dot(&spin);
            let expected = truth.k * (w.dot(&input) + drift);
            assert!((dwell.output_pulse_s[j] - expected).abs() < 1e-8, "{} {expected}", dwell.output_pulse_s[j]);
        }
    }
}

#[test]
fn effects_of_temperature_count_from_the_reference_that_the_scenario_states() {
    let constant = Temperature { profile: Profile::Constant, mean_c: 48.0, ..Temperature::default() };
    for (reference_c, drift) in [(Some(45.0), 0.03), (None, 0.0)] {
        let temperature = Temperature { reference_c, ..constant.clone() };
        let plain = without_noise(Scenario { temperature, ..Scenario::default() });
        let warm = station_runs(&with_effect(plain.clone(), EffectChoice::sized("temperature_bias", 0.01)));
        let plain = station_runs(&plain);
        for (warm_output, output) in outputs(&warm.campaign, 0).iter().zip(outputs(&plain.campaign, 0)) {
            let more = (warm_output - output) / warm.truth.truth[0].k;
            assert!((more.abs() - drift).abs() < 1e-9, "{reference_c:?}: {more}");
        }
    }
}

#[test]
fn at_rest_every_position_feels_one_gravity_and_one_earth_rate_at_the_latitude_s_angle() {
    let run = station_runs(&with_positions(Positions::WithTilts));
    let g = run.campaign.site.unwrap().gravity_g0;
    for dwell in run.campaign.dwells.iter().filter(|dwell| dwell.phase == Phase::Static) {
        let (a, w) = (dwell.specific_force_g0, dwell.rate_arcsec_s);
        assert!((a.norm() - g).abs() < 1e-12);
        assert!((w.norm() - 15.041_067).abs() < 1e-5);
        assert!((a.angle(&w).to_degrees() - (90.0 - 34.25)).abs() < 1e-9);
    }
}

#[rstest]
#[case(Positions::Faces, 6)]
#[case(Positions::TwentyFour, 24)]
#[case(Positions::WithEdges, 36)]
#[case(Positions::WithTilts, 60)]
#[case(Positions::PolarTumble, 24)]
fn a_set_of_positions_has_its_number_of_different_attitudes(#[case] positions: Positions, #[case] count: usize) {
    let programme = Programme { positions, rates_arcsec_s: vec![], repeats: 0, ..Programme::default() };
    let run = station_runs(&Scenario { programme, ..Scenario::default() });
    let attitudes: Vec<_> = run.campaign.dwells.iter().map(|dwell| *dwell.attitude.unwrap().matrix()).collect();
    assert_eq!(attitudes.len(), count);
    for (k, one) in attitudes.iter().enumerate() {
        assert!((one * one.transpose() - nalgebra::Matrix3::identity()).amax() < 1e-12 && one.determinant() > 0.0);
        assert!(attitudes[..k].iter().all(|other| (one - other).amax() > 0.1), "{positions:?} {k}");
    }
}

#[test]
fn on_the_polar_axis_the_input_and_spin_axes_feel_no_earth_rate() {
    let programme =
        Programme { positions: Positions::PolarTumble, rates_arcsec_s: vec![], repeats: 0, ..Programme::default() };
    for dwell in station_runs(&Scenario { programme, ..Scenario::default() }).campaign.dwells {
        assert!(dwell.rate_arcsec_s.xy().norm() < 1e-12);
        assert!((dwell.rate_arcsec_s.z.abs() - 15.041_067).abs() < 1e-5);
    }
}

#[test]
fn each_rate_is_run_in_both_senses_on_every_axis_up_and_down() {
    let run = station_runs(&Scenario::default());
    let rates: Vec<_> = run.campaign.dwells.iter().filter(|dwell| dwell.phase == Phase::Rate).collect();
    assert_eq!((run.campaign.dwells.len(), rates.len()), (78, 48));
    for axis in 0..3 {
        for up in [1.0, -1.0] {
            let on_axis = rates.iter().filter(|d| d.specific_force_g0[axis] * up > 0.9);
            let (there, back): (Vec<f64>, Vec<f64>) = on_axis.map(|d| d.rate_arcsec_s[axis]).partition(|w| *w > 0.0);
            assert_eq!((there.len(), back.len()), (4, 4));
            // Earth rate stays on: senses differ by twice its vertical part.
            let sum: f64 = there.iter().chain(&back).sum();
            assert!((sum - up * 8.0 * 15.041_067 * 34.25_f64.to_radians().sin()).abs() < 1e-4);
        }
    }
}

#[test]
fn whole_turns_are_whole() {
    let programme = Programme { whole_turns: true, dwell_s: 200.0, ..Programme::default() };
    let run = station_runs(&Scenario { programme, ..Scenario::default() });
    for (dwell, planned) in run.campaign.dwells.iter().zip(&run.world.plan) {
        let turns = planned.turn_arcsec_s.abs() * dwell.duration_s / 1_296_000.0;
        assert!(dwell.duration_s >= 200.0 && (turns - turns.round()).abs() < 1e-9);
    }
}

#[test]
fn dwells_follow_one_another_without_overlap_and_power_ups_leave_a_gap() {
    let programme = Programme { power_ups: 3, cycles: 2, order: DwellOrder::Mixed, ..Programme::default() };
    let run = station_runs(&Scenario { programme, ..Scenario::default() });
    let gaps: Vec<f64> =
        run.campaign.dwells.windows(2).map(|p| p[1].start_s - p[0].start_s - p[0].duration_s).collect();
    assert!(gaps.iter().all(|gap| *gap >= 60.0));
    assert_eq!(gaps.iter().filter(|gap| **gap > 7000.0).count(), 2);
}

#[test]
fn the_same_seed_gives_the_same_campaign_and_another_seed_another() {
    let scenario = preset("long").unwrap();
    assert_eq!(station_runs(&scenario).campaign, station_runs(&scenario).campaign);
    let other = Scenario { seed: 2, ..scenario.clone() };
    assert_ne!(outputs(&station_runs(&other).campaign, 0), outputs(&station_runs(&scenario).campaign, 0));
}

#[test]
fn a_cause_changes_nothing_but_what_it_causes() {
    let clean = Scenario::default();
    let ramp = with_effect(clean.clone(), EffectChoice::sized("time_ramp", 0.01));
    let (clean, ramp) = (station_runs(&clean), station_runs(&ramp));
    for (j, truth) in clean.truth.truth.iter().enumerate() {
        let pairs = outputs(&ramp.campaign, j).into_iter().zip(outputs(&clean.campaign, j));
        for ((with, without), dwell) in pairs.zip(&clean.campaign.dwells) {
            let expected = truth.k * 0.01 * dwell.mid_s() / 3600.0;
            assert!((with - without - expected).abs() < 1e-9);
        }
    }
}

#[rstest]
#[case(StandardErrors::Exact, 0.0)]
#[case(StandardErrors::Noisy, 0.12)]
fn the_noise_is_as_large_as_the_standard_errors_say(#[case] stated: StandardErrors, #[case] wrong: f64) {
    let (mut scores, mut ratios) = (Vec::new(), Vec::new());
    for seed in 0..12 {
        let mut scenario = Scenario { seed, ..Scenario::default() };
        scenario.columns.standard_errors = stated;
        let run = station_runs(&scenario);
        let ideal = run.world.outputs(&[]);
        for (k, dwell) in run.campaign.dwells.iter().enumerate() {
            for (j, sem) in dwell.output_sem_pulse_s.as_ref().unwrap().iter().enumerate() {
                scores.push((dwell.output_pulse_s[j] - ideal[j][k]) / run.world.sd[j][k]);
                ratios.push(sem / run.world.sd[j][k]);
            }
        }
    }
    let n = scores.len() as f64;
    let rms = (scores.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
    assert!((rms - 1.0).abs() < 4.0 / (2.0 * n).sqrt(), "{rms} of {n}");
    let spread = (ratios.iter().map(|r| (r - 1.0).powi(2)).sum::<f64>() / n).sqrt();
    assert!((spread - wrong).abs() < 0.01, "{spread}");
}

/// The columns of model (6) for the campaign, whitened, and the singular-value way to what they leave of a response.
fn left_over_by_svd(run: &Simulated, gyro: usize, response: &[f64]) -> f64 {
    let n = response.len();
    let sd = &run.world.sd[gyro];
    let design = DMatrix::from_fn(n, 10, |k, c| {
        let (a, w) = (run.campaign.dwells[k].specific_force_g0, run.campaign.dwells[k].rate_arcsec_s);
        let row = [1.0, a.x, a.y, a.z, a.x * a.x, a.y * a.y, a.z * a.z, w.x, w.y, w.z];
        // Columns scaled to one size, so that one cut-off suits them all.
        row[c] / sd[k] / if c > 6 { 7200.0 } else { 1.0 }
    });
    let y = DVector::from_iterator(n, response.iter().zip(sd).map(|(r, s)| r / s));
    let svd = design.clone().svd(true, true);
    let fitted = &design * svd.solve(&y, 1e-9 * svd.singular_values.max()).unwrap();
    (y - fitted).norm()
}

#[rstest]
#[case("temperature_bias", Positions::TwentyFour)]
#[case("levelling", Positions::TwentyFour)]
#[case("scale_asymmetry", Positions::TwentyFour)]
#[case("magnetic", Positions::WithEdges)]
#[case("cross_compliance", Positions::WithTilts)]
#[case("outside:random_walk", Positions::WithTilts)]
fn detectability_is_what_a_singular_value_decomposition_leaves_over(
    #[case] effect: &str,
    #[case] positions: Positions,
) {
    let run = station_runs(&with_effect(with_positions(positions), EffectChoice::detectable(effect, 12.0)));
    let (with, without) = (run.world.outputs(&run.causes), run.world.outputs(&[]));
    let mut power = 0.0;
    for j in 0..3 {
        let response: Vec<f64> = with[j].iter().zip(&without[j]).map(|(a, b)| a - b).collect();
        let d = left_over_by_svd(&run, j, &response);
        assert!((d - run.truth.seen_by[0][Slot::ALL[j].name()]).abs() < 1e-4, "{effect}: {d}");
        power += d * d;
    }
    assert!((power.sqrt() - 12.0).abs() < 1e-3, "{effect}: {}", power.sqrt());
    assert!((run.truth.seen - 12.0).abs() < 1e-3);
}

#[test]
fn every_effect_can_be_put_in_at_a_detectability_where_its_design_sees_it() {
    for id in CATALOGUE.map(|known| known.id) {
        let mut scenario = with_effect(with_positions(Positions::WithTilts), EffectChoice::detectable(id, 8.0));
        match id {
            "g_linear" => scenario.model = Some(vec!["bias".into(), "g_squared".into(), "scale".into()]),
            "g_squared" => scenario.model = Some(vec!["bias".into(), "g_linear".into(), "scale".into()]),
            _ => {}
        }
        let hidden = ["output_axis_g", "mount_clocking"].contains(&id);
        match simulate(&scenario) {
            Ok(run) => assert!(!hidden && (run.truth.seen - 8.0).abs() < 1e-3, "{id}: {}", run.truth.seen),
            Err(faults) => assert!(hidden && faults.0[0].message.code == "effect_not_seen", "{id}: {faults}"),
        }
    }
    for family in FAMILIES {
        let effect = EffectChoice::detectable(&format!("outside:{family}"), 15.0);
        let run = station_runs(&with_effect(with_positions(Positions::WithTilts), effect));
        assert!((run.truth.seen - 15.0).abs() < 1e-3, "{family}");
        assert_eq!(
            (run.truth.effects[0].as_str(), run.truth.family.as_deref()),
            ("outside the catalogue", Some(family))
        );
    }
}

#[rstest]
#[case("axial_compliance", Positions::TwentyFour, false)]
#[case("axial_compliance", Positions::WithTilts, true)]
#[case("cross_compliance", Positions::TwentyFour, false)]
#[case("cross_compliance", Positions::WithEdges, true)]
#[case("cubic_g", Positions::TwentyFour, false)]
#[case("cubic_g", Positions::WithTilts, true)]
#[case("output_axis_g", Positions::WithTilts, false)]
fn what_six_faces_saturate_is_seen_off_the_axes_only(
    #[case] effect: &str,
    #[case] positions: Positions,
    #[case] seen: bool,
) {
    let run = station_runs(&with_effect(with_positions(positions), EffectChoice::sized(effect, 1.0)));
    assert_eq!(run.truth.seen > 1.0, seen, "{effect}: {}", run.truth.seen);
    assert_eq!(run.truth.gyros.is_empty(), !seen);
}

#[test]
fn one_sense_of_rotation_hides_an_asymmetry() {
    let programme = Programme { both_senses: false, both_ups: false, ..Programme::default() };
    let effect = EffectChoice::sized("scale_asymmetry", 1e-6);
    let blind = station_runs(&with_effect(Scenario { programme, ..Scenario::default() }, effect.clone()));
    let sighted = station_runs(&with_effect(Scenario::default(), effect));
    assert!(blind.truth.seen < 0.2 * sighted.truth.seen, "{} {}", blind.truth.seen, sighted.truth.seen);
}

#[test]
fn an_effect_is_put_into_the_chosen_gyros_only_and_a_common_one_into_all() {
    for (id, chosen) in [("time_ramp", vec!["G2"]), ("levelling", vec!["G1", "G2", "G3"])] {
        let effect = EffectChoice { gyros: Some(vec!["G2".into()]), ..EffectChoice::detectable(id, 10.0) };
        assert_eq!(COMMON.contains(&id), id == "levelling");
        assert_eq!(station_runs(&with_effect(Scenario::default(), effect)).truth.gyros, chosen);
    }
}

#[test]
fn a_level_error_tilts_gravity_and_the_mass_unbalance_answers() {
    let tilt = 1e-4;
    let effect = EffectChoice { direction: Some([1.0, 0.0, 0.0]), ..EffectChoice::sized("levelling", tilt) };
    let run = station_runs(&with_effect(Scenario::default(), effect));
    let (with, without) = (run.world.outputs(&run.causes), run.world.outputs(&[]));
    for (j, truth) in run.truth.truth.iter().enumerate() {
        let (input, spin) = (Vector3::from(truth.input), Vector3::from(truth.spin));
        for (k, planned) in run.world.plan.iter().enumerate().filter(|(_, p)| p.phase == Phase::Static) {
            // About east by theta: up goes to -theta north, north to theta up, to first order.
            let (north, up) = (planned.attitude * Vector3::y(), planned.attitude * Vector3::z());
            let (n, u) = (run.world.earth.rate.y, run.world.earth.rate.z);
            let tilted_w = (up * n - north * u) * tilt;
            let tilted_a = -north * run.world.earth.gravity.z * tilt;
            let g = input * truth.d_i + spin * truth.d_s;
            let expected = truth.k * (tilted_w.dot(&input) + tilted_a.dot(&g));
            assert!((with[j][k] - without[j][k] - expected).abs() < 1e-6, "{j} {k}");
        }
    }
}

#[test]
fn a_key_survives_being_written_and_read() {
    let effect = EffectChoice::detectable("outside:sawtooth", 15.0);
    let run = station_runs(&with_effect(with_positions(Positions::WithTilts), effect));
    let text = serde_json::to_string(&run.truth).unwrap();
    let back: KeyEntry = serde_json::from_str(&text).unwrap();
    // serde_json's fast reader may miss the last bit of a number.
    assert_eq!((&back.effects, &back.gyros, &back.family), (&run.truth.effects, &run.truth.gyros, &run.truth.family));
    assert!((back.seen / run.truth.seen - 1.0).abs() < 1e-14);
    assert!((back.truth[1].d_s / run.truth.truth[1].d_s - 1.0).abs() < 1e-14);
    let entry: serde_json::Value = serde_json::from_str(&text).unwrap();
    for field in ["effects", "sizes", "design", "sem", "seen", "gyros", "truth"] {
        assert!(entry.get(field).is_some(), "{field}");
    }
    for field in ["D_I", "D_S", "K", "D_F", "I", "S"] {
        assert!(entry["truth"][2].get(field).is_some(), "{field}");
    }
}

#[test]
fn a_scenario_survives_being_written_as_toml_and_a_misspelt_key_is_named() {
    let mut scenario = preset("60-position").unwrap();
    scenario.effects.push(EffectChoice { gyros: Some(vec!["G1".into()]), ..EffectChoice::detectable("warmup", 9.0) });
    let text = toml::to_string(&scenario).unwrap();
    assert_eq!(toml::from_str::<Scenario>(&text).unwrap(), scenario);
    let error = toml::from_str::<Scenario>("[programme]\nrepeat = 3").unwrap_err().to_string();
    assert!(error.contains("repeat"), "{error}");
}

#[rstest]
#[case("/effects/0/effect", |s: &mut Scenario| s.effects.push(EffectChoice::sized("time_rampp", 1.0)))]
#[case("/effects/0/detectability", |s: &mut Scenario| s.effects.push(EffectChoice::detectable("cubic_g", 8.0)))]
#[case("/programme/cycles", |s: &mut Scenario| s.programme.cycles = 0)]
#[case("/programme/dwell_s", |s: &mut Scenario| s.programme.dwell_s = f64::NAN)]
#[case("/temperature/time_h", |s: &mut Scenario| s.temperature.time_h = 0.0)]
#[case("/population/d_i_sd", |s: &mut Scenario| s.population.d_i_sd = -1.0)]
#[case("/measured_at", |s: &mut Scenario| s.measured_at = "yesterday".into())]
#[case("/imu", |s: &mut Scenario| s.imu.clear())]
#[case("/test", |s: &mut Scenario| s.test = "spin".into())]
#[case("/model/0", |s: &mut Scenario| s.model = Some(vec!["g_cubic".into()]))]
#[case("/gyros", |s: &mut Scenario| s.gyros.clear())]
fn an_impossible_scenario_is_refused_by_the_name_of_the_field(#[case] pointer: &str, #[case] spoil: fn(&mut Scenario)) {
    let mut scenario = Scenario::default();
    spoil(&mut scenario);
    let faults = simulate(&scenario).unwrap_err();
    assert_eq!(faults.0[0].pointer, pointer, "{faults}");
}

#[test]
fn every_preset_is_a_file_that_a_station_could_send() {
    for (name, _) in PRESETS {
        let campaign = station_runs(&preset(name).unwrap()).campaign;
        let read = parse_json(to_json(&campaign).as_bytes()).unwrap_or_else(|faults| panic!("{name}: {faults}"));
        assert_eq!((read.imu, read.dwells.len()), (campaign.imu, campaign.dwells.len()));
        for (read, sent) in read.dwells.iter().zip(&campaign.dwells) {
            let pairs = read.output_pulse_s.iter().zip(&sent.output_pulse_s);
            assert!(pairs.clone().all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs()));
            let turned = read.attitude.unwrap().matrix() - sent.attitude.unwrap().matrix();
            assert!(turned.amax() < 1e-9, "{name}: {turned}");
        }
    }
}

#[test]
fn the_command_prints_a_campaign_and_keeps_the_truth_apart() {
    let dir = tempfile::tempdir().unwrap();
    let truth = dir.path().join("truth.json");
    let text = printed(&["simulate", "--seed", "3", "--truth", truth.to_str().unwrap()]);
    let campaign = parse_json(text.as_bytes()).unwrap();
    assert_eq!(campaign.dwells.len(), 78);
    let key: Key = serde_json::from_str(&std::fs::read_to_string(truth).unwrap()).unwrap();
    assert_eq!(key["-"].seed, Some(3));
    assert_eq!(printed(&["simulate", "--seed", "3"]), text);
}

#[test]
fn a_printed_scenario_can_be_edited_and_run() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("mine.toml");
    let scenario = printed(&["simulate", "--preset", "36-position", "--print-scenario"]);
    let effect = "[[effects]]\neffect = \"warmup\"\ngyros = [\"G2\"]\ndetectability = 12.0\n";
    std::fs::write(&file, scenario.replace("effects = []\n", "") + effect).unwrap();
    let out = dir.path().join("c.json");
    let truth = dir.path().join("t.json");
    let [file, out, truth] = [&file, &out, &truth].map(|path| path.to_str().unwrap().to_owned());
    printed(&["simulate", "--scenario", &file, "--out", &out, "--truth", &truth]);
    let key: Key = serde_json::from_str(&std::fs::read_to_string(truth).unwrap()).unwrap();
    assert_eq!(
        (key["c.json"].effects.as_slice(), key["c.json"].gyros.as_slice()),
        (&["warmup".into()][..], &["G2".into()][..])
    );
    std::fs::write(&file, "[programme]\nrepeat = 3\n").unwrap();
    assert!(complaint(&["simulate", "--scenario", &file], 1).contains("mine.toml"));
}

#[test]
fn many_campaigns_go_into_a_folder_with_one_key() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("made");
    printed(&["simulate", "--count", "3", "--seed", "10", "--dir", folder.to_str().unwrap()]);
    let key: Key = serde_json::from_str(&std::fs::read_to_string(folder.join("key.json")).unwrap()).unwrap();
    assert_eq!(key.values().map(|entry| entry.seed.unwrap()).collect::<Vec<_>>(), [10, 11, 12]);
    for name in key.keys() {
        parse_json(&std::fs::read(folder.join(name)).unwrap()).unwrap();
    }
}

#[test]
fn the_documented_table_of_the_papers_experiment_is_what_the_command_prints() {
    let table = printed(&["simulate", "--preset", "paper-experiment"]);
    let cells = |line: &str| {
        line.trim_matches('│').split('┆').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>().join(" | ")
    };
    let printed: Vec<String> =
        table.lines().filter(|line| line.starts_with("│ G")).map(|line| format!("| {} |", cells(line))).collect();
    let documented =
        include_str!("../docs/simulation.md").lines().filter(|line| line.starts_with("| G")).collect::<Vec<_>>();
    assert_eq!((printed.len(), documented), (12, printed.iter().map(String::as_str).collect()));
}

#[test]
fn the_paper_s_experiment_is_seven_campaigns_or_one_table() {
    let dir = tempfile::tempdir().unwrap();
    printed(&["simulate", "--preset", "paper-experiment", "--dir", dir.path().to_str().unwrap()]);
    let names: Vec<_> = std::fs::read_dir(dir.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 8, "{names:?}");
    let bench = parse_json(&std::fs::read(dir.path().join("0001-1-bench-G2.json")).unwrap()).unwrap();
    let system = parse_json(&std::fs::read(dir.path().join("0001-2-system.json")).unwrap()).unwrap();
    assert_eq!(bench.gyros[0].serial, system.gyros[1].serial);
    let table = printed(&["simulate", "--preset", "paper-experiment", "--count", "5"]);
    assert!(table.contains("rigid      5 of 5"), "{table}");
    let csv = printed(&["simulate", "--preset", "paper-experiment", "--count", "2", "--csv"]);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!((rows.len(), rows[0][4], rows[7][0], rows[8][..3].to_vec()), (13, "rigid", "2", vec!["2", "G1", "D_S"]));
}

#[rstest]
#[case(&["--preset", "25-position"], 2, "24-position")]
#[case(&["--count", "3"], 2, "--dir")]
#[case(&["--scenario", "/nowhere.toml"], 1, "/nowhere.toml")]
#[case(&["--seed", "one"], 2, "--seed")]
fn wrong_use_is_named(#[case] arguments: &[&str], #[case] status: i32, #[case] names: &str) {
    let text = complaint(&[&["simulate"], arguments].concat(), status);
    assert!(text.contains(names), "{text}");
}
