//! The model of one IMU: fitted to its campaigns, it foretells the next ones, says what has changed, and is what
//! `simulate --model` draws.

use crate::command::{answer, printed, read_json, run};
use crate::lab::at;
use crate::prelude::*;
use crate::support::data_path;
use gyrowatch::core::alert_decision::Late;
use gyrowatch::core::augmented::{Adopted, AugmentedModel, KnownEffect};
use gyrowatch::core::calibrate::outcome::{Outcome, evaluate_with};
use gyrowatch::core::campaign::{Campaign, Phase, StationUncertainty};
use gyrowatch::core::effects::{Effect, Shape};
use gyrowatch::core::imu_model::{
    CampaignSample, Identified, ModelCoefficient, NoForecast, NotIdentified, Of, changed, compare, identify, ladder,
    most_telling, named, promised,
};
use gyrowatch::core::judge::{Finding, Limits, State, Unseen, forecast};
use gyrowatch::core::model::Term;
use gyrowatch::core::mounting::Slot;
use gyrowatch::core::record::Plausibility;
use gyrowatch::pipeline::Submission;
use gyrowatch::simulate::scenario::GyroChoice;
use gyrowatch::simulate::{Scenario, simulate};
use gyrowatch::wire;
use nalgebra::Vector3;

/// Change of D_I and D_S of G1 with temperature, deg/(h g0 K).
const K: [f64; 2] = [0.003, -0.002];
/// Deg C at which D_I and D_S are what [`gyros`] says.
const NOMINAL_C: f64 = 45.0;
const D_I: [f64; 3] = [4.2, -1.6, 1.7];
const D_S: [f64; 3] = [5.8, 6.1, -9.9];

/// The same gyros in every campaign.
fn gyros() -> Vec<GyroChoice> {
    let one = |k: usize| GyroChoice {
        slot: format!("G{}", k + 1),
        serial: Some(format!("LFG-{k}")),
        scale_factor: Some(1.46 + 0.01 * k as f64),
        d_f: Some(0.7 - 0.3 * k as f64),
        d_i: Some(D_I[k]),
        d_s: Some(D_S[k]),
        misalignment_arcmin: Some([3.0 * k as f64, -4.0, 5.0]),
        ..GyroChoice::default()
    };
    (0..3).map(one).collect()
}

/// A campaign of that IMU in the `month`, at a mean temperature; G1's mass unbalance follows temperature, `times` as
/// much as [`K`] says. What the temperature does is written out here, by the true axes.
fn campaign(seed: u64, month: u32, celsius: f64, times: f64) -> Campaign {
    let mut scenario = Scenario { seed, gyros: gyros(), ..Scenario::default() };
    scenario.temperature.mean_c = celsius;
    scenario.measured_at = format!("2026-{month:02}-01T08:00:00Z");
    let simulated = simulate(&scenario).unwrap();
    let gyro = &simulated.world.gyros[0];
    let mut campaign = simulated.campaign;
    for dwell in &mut campaign.dwells {
        let (a, warm) = (dwell.specific_force_g0, dwell.temperature_c.unwrap() - NOMINAL_C);
        let drift = warm * (K[0] * gyro.input().dot(&a) + K[1] * gyro.spin().dot(&a));
        dwell.output_pulse_s[0] += times * gyro.scale_factor * drift;
    }
    campaign
}

fn sample(campaign: &Campaign) -> CampaignSample<'_> {
    CampaignSample { campaign, source: None, occasions: Vec::new() }
}

fn temperature_g() -> AugmentedModel {
    let adopted = Adopted { effect: Effect::TemperatureG, shape: Shape::InputSpin, slots: vec![Slot::G1] };
    let effects = vec![KnownEffect { adopted, estimates: Vec::new() }];
    AugmentedModel { effects, ..AugmentedModel::default() }
}

fn model(campaigns: &[&Campaign]) -> Identified {
    let samples: Vec<CampaignSample> = campaigns.iter().map(|c| sample(c)).collect();
    identify(&samples, &temperature_g()).unwrap()
}

#[test]
fn the_next_campaign_is_as_foretold_also_three_kelvin_warmer_and_d_i_makes_no_step() {
    let (mut squares, mut count, mut inside, mut sorted, mut closures) = (0.0, 0, 0, Vec::new(), Vec::new());
    for seed in 0..10 {
        let (first, next) = (campaign(seed, 1, NOMINAL_C, 1.0), campaign(1000 + seed, 2, NOMINAL_C + 3.0, 1.0));
        let chosen = named(&[&first], None).unwrap();
        let effects: Vec<Effect> = chosen.model.effects.iter().map(|known| known.adopted.effect).collect();
        if effects.is_empty() {
            continue;
        }
        assert_eq!(effects, [Effect::TemperatureG], "seed {seed}");
        let model = identify(&[sample(&first)], &chosen.model).unwrap();
        let found = compare(&model, &next).unwrap();
        squares += found.rms_over_sd.powi(2) * found.count as f64;
        count += found.count;
        sorted.push(found.rms_over_sd);
        let steps = ladder(&model, &next).unwrap();
        assert!(steps[0].rms_over_sd > 2.0 && steps[0].effect.is_none(), "{steps:?}");
        assert_eq!((steps.len(), steps[1].rms_deg_per_h), (2, found.rms_deg_per_h));
        let (told, seen) = (promised(&model, &next).unwrap().unwrap(), found.closing.unwrap());
        assert!(told.before_deg_per_h > told.after_deg_per_h, "{told:?}");
        closures.push(seen.closure);
        let [low, high] = told.interval.unwrap();
        inside += usize::from(low <= seen.closure && seen.closure <= high);
        assert!(!changed(&model, &next).unwrap().effects[0].changed, "seed {seed}");

        // D_I and D_S are stated at the model's temperature, in the model and in either campaign.
        let whole = model.separation(Slot::G1, &model.values(), &model.covariance).unwrap().rigid;
        let warm = model.reference_c.unwrap() - NOMINAL_C;
        let (truth, sd) = ([D_I[0] + K[0] * warm, D_S[0] + K[1] * warm], whole.sd().unwrap());
        assert!((whole.d_i - truth[0]).abs() < 4.0 * sd[0] && (whole.d_s - truth[1]).abs() < 4.0 * sd[1]);
        let file = model.into_model(&chosen.model);
        let at = |campaign: &Campaign| {
            let outcome = evaluate_with(campaign, &file.options(campaign), &Plausibility::ever()).unwrap();
            let Outcome::Imu { separations, as_measured, .. } = outcome else { panic!("a campaign of an IMU") };
            let own = as_measured.unwrap();
            (separations[0].as_ref().unwrap().rigid, own.temperature_c, own.separations[0].as_ref().unwrap().rigid)
        };
        let ((then, ..), (now, celsius, measured)) = (at(&first), at(&next));
        let step = (now.d_i - then.d_i).abs() / now.sd().unwrap()[0].hypot(then.sd().unwrap()[0]);
        assert!(step < 3.5, "seed {seed}: {step} sd");
        let warm = celsius - NOMINAL_C;
        assert!((measured.d_i - D_I[0] - K[0] * warm).abs() < 5.0 * measured.sd().unwrap()[0]);
        assert!((measured.d_i - then.d_i).abs() > 10.0 * measured.sd().unwrap()[0], "as measured it does step");
    }
    sorted.sort_by(f64::total_cmp);
    closures.sort_by(f64::total_cmp);
    assert!(closures[closures.len() / 2] > 0.7, "{closures:?}");
    let rms = (squares / f64::from(u32::try_from(count).unwrap())).sqrt();
    assert!(sorted.len() >= 8, "named in {} of 10", sorted.len());
    assert!(sorted[sorted.len() - 2] <= 1.15 && (rms - 1.0).abs() < 0.06, "{rms} {sorted:?}");
    assert!(inside + 2 >= sorted.len(), "{inside} of {}", sorted.len());
}

/// The torquer of G1 follows temperature: what it senses of drift as well as of rate.
#[test]
fn a_scale_factor_that_follows_temperature_is_foretold_with_the_drift_that_it_multiplies() {
    const BY_KELVIN: f64 = 2e-4;
    let with_scale = |seed: u64, month: u32, celsius: f64| {
        let mut campaign = campaign(seed, month, celsius, 0.0);
        for dwell in &mut campaign.dwells {
            dwell.output_pulse_s[0] *= 1.0 + BY_KELVIN * (dwell.temperature_c.unwrap() - NOMINAL_C);
        }
        campaign
    };
    let adopted = Adopted { effect: Effect::TemperatureScale, shape: Shape::Linear, slots: vec![Slot::G1] };
    let effects = vec![KnownEffect { adopted, estimates: Vec::new() }];
    let known = AugmentedModel { effects, ..AugmentedModel::default() };
    let model = identify(&[sample(&with_scale(1, 1, NOMINAL_C))], &known).unwrap();
    for (seed, month, warmer) in [(2, 2, 0.0), (3, 3, 5.0)] {
        let told = compare(&model, &with_scale(seed, month, NOMINAL_C + warmer)).unwrap();
        // Ten deg/h of drift times 0.1 % are ten times the noise.
        assert!(told.rms_over_sd < 1.25 && told.p_value > 1e-3, "{warmer} K: {} {}", told.rms_over_sd, told.p_value);
    }
}

#[test]
fn a_coefficient_that_has_tripled_is_said_with_what_it_does_to_d_i() {
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    let model = model(&[&first]);
    // The campaign's own mean lies beside the model's temperature: what k does there is what D_I is off by.
    let next = campaign(2, 2, NOMINAL_C + 3.0, 3.0);
    let found = changed(&model, &next).unwrap();
    assert!(found.effects[0].changed && found.effects[0].p_value < 1e-6, "{found:?}");
    let (_, then, now) = found.effects[0].coefficients[0];
    assert!((then[0] - K[0]).abs() < 4.0 * then[1] && (now[0] - 3.0 * K[0]).abs() < 4.0 * now[1], "{found:?}");
    let d_i = found.shifts.iter().find(|s| (s.slot, s.coefficient) == (Slot::G1, "D_I")).unwrap();
    let mean = |c: &Campaign| c.dwells.iter().map(|d| d.temperature_c.unwrap()).sum::<f64>() / c.dwells.len() as f64;
    let expected = -2.0 * K[0] * (mean(&next) - mean(&first));
    assert!((d_i.shift - expected).abs() < 4.0 * d_i.sd, "{d_i:?} is not {expected}");
    // A gyro that shows something else, too, may have changed in that: undecided, and nothing is said to D_I.
    let mut more = next.clone();
    for (k, dwell) in more.dwells.iter_mut().enumerate() {
        dwell.output_pulse_s[0] += if k < 20 { 0.01 } else { 0.0 };
    }
    let doubted = changed(&model, &more).unwrap();
    let [one] = &doubted.effects[..] else { panic!("{doubted:?}") };
    assert!(!one.changed && one.undecided && one.p_value < 0.005 && doubted.shifts.is_empty(), "{doubted:?}");
    // What the noise is known by counts: a few repeats of the first campaign make the same difference less sure.
    let doubled = campaign(2, 2, NOMINAL_C + 3.0, 2.0);
    let p_by = |dof: f64| {
        let mut model = model.clone();
        model.gyros.iter_mut().for_each(|gyro| gyro.noise.dof = dof);
        changed(&model, &doubled).unwrap().effects[0].p_value
    };
    let (sure, few) = (p_by(1e6), p_by(5.0));
    assert!(sure < 0.01 && few > 1.1 * sure, "{sure} {few}");
    let told = compare(&model, &next).unwrap();
    assert!(
        told.p_value < 0.05 && told.rms_over_sd > 2.0,
        "outside its forecast: {} {}",
        told.p_value,
        told.rms_over_sd
    );
}

/// As [`campaign`], of which all gyros follow temperature, and that wanders by so many kelvin about `celsius`.
fn wandering(seed: u64, month: u32, [celsius, wander]: [f64; 2], times: [f64; 3]) -> Campaign {
    let mut scenario = Scenario { seed, gyros: gyros(), ..Scenario::default() };
    scenario.temperature.mean_c = celsius;
    scenario.measured_at = format!("2026-{month:02}-01T08:00:00Z");
    let simulated = simulate(&scenario).unwrap();
    let mut campaign = simulated.campaign;
    let n = campaign.dwells.len() as f64;
    let mean = campaign.dwells.iter().map(|d| d.temperature_c.unwrap()).sum::<f64>() / n;
    let rms = (campaign.dwells.iter().map(|d| (d.temperature_c.unwrap() - mean).powi(2)).sum::<f64>() / n).sqrt();
    for dwell in &mut campaign.dwells {
        let warmer = celsius + wander * (dwell.temperature_c.unwrap() - mean) / rms - NOMINAL_C;
        dwell.temperature_c = Some(NOMINAL_C + warmer);
        let a = dwell.specific_force_g0;
        for ((gyro, times), output) in simulated.world.gyros.iter().zip(times).zip(&mut dwell.output_pulse_s) {
            let by_kelvin = K[0] * gyro.input().dot(&a) + K[1] * gyro.spin().dot(&a);
            *output += times * gyro.scale_factor * warmer * by_kelvin;
        }
    }
    campaign
}

/// A campaign of steady temperature tells what an effect of temperature is less well than the model does: the model's is
/// taken, unless the campaign contradicts it.
#[test]
fn a_coefficient_that_steady_dwells_contradict_is_not_held_and_d_i_is_as_uncertain_as_that() {
    let as_adopted = [1.0; 3];
    let first: Vec<Campaign> = [(1, 45.0), (2, 47.0), (3, 43.0), (4, 46.0)]
        .map(|(month, celsius)| wandering(u64::from(month), month, [celsius, 0.7], as_adopted))
        .into();
    let of_all = Adopted { slots: vec![Slot::G1, Slot::G2, Slot::G3], ..temperature_g().effects[0].adopted.clone() };
    let chosen = AugmentedModel {
        effects: vec![KnownEffect { adopted: of_all, estimates: Vec::new() }],
        ..AugmentedModel::default()
    };
    let samples: Vec<CampaignSample> = first.iter().map(sample).collect();
    let model = identify(&samples, &chosen).unwrap();
    let warm = model.reference_c.unwrap() - NOMINAL_C;
    let file = model.into_model(&chosen);
    // Errors of D_I and D_S over their standard deviations, these, and the gyros of which the note says so.
    let stated = |campaign: &Campaign, times: [f64; 3]| {
        let outcome = evaluate_with(campaign, &file.options(campaign), &Plausibility::ever()).unwrap();
        let Outcome::Imu { calibration, separations, .. } = outcome else { panic!("a campaign of an IMU") };
        let noted = calibration.all_notes().iter().filter(|note| note.code() == "effect_contradicted").count();
        let one = |j: usize| {
            let rigid = separations[j].as_ref().unwrap().rigid;
            let [d_i, d_s, _] = rigid.sd().unwrap();
            let off = |value: f64, truth: f64, k: f64| value - truth - times[j] * k * warm;
            ([off(rigid.d_i, D_I[j], K[0]) / d_i, off(rigid.d_s, D_S[j], K[1]) / d_s], d_i)
        };
        ([one(0), one(1), one(2)], noted)
    };
    let (mut squares, mut noted, mut sure) = (0.0, 0, 0);
    for seed in 0..12 {
        let now = |times| wandering(500 + seed, 6, [47.5, 0.1], times);
        let (gyros, said) = stated(&now(as_adopted), as_adopted);
        assert!(gyros.iter().all(|(_, sd)| *sd < 1e-3), "seed {seed}: held, {gyros:?}");
        assert_eq!(said, 0, "seed {seed}");
        squares += gyros.iter().flat_map(|(off, _)| off).map(|off| off * off).sum::<f64>();

        // Of all gyros it is four times as large: what is stated is not off by tens of its standard deviations.
        let (gyros, said) = stated(&now([4.0; 3]), [4.0; 3]);
        assert!(gyros.iter().flat_map(|(off, _)| off).all(|off| off.abs() < 4.0), "seed {seed}: {gyros:?}");
        noted += said;

        // One alone has changed, by more: it takes the others' from none that are near the model.
        let (gyros, _) = stated(&now([1.0, 9.0, 1.0]), [1.0, 9.0, 1.0]);
        assert!(gyros.iter().flat_map(|(off, _)| off).all(|off| off.abs() < 4.0), "seed {seed}: {gyros:?}");
        sure += [0, 2].into_iter().filter(|j| gyros[*j].1 < 1e-3).count();
    }
    let rms = (squares / 72.0).sqrt();
    assert!((0.75..1.25).contains(&rms), "as adopted: {rms}");
    assert!(noted >= 34 && sure >= 15, "{noted} of 36 said, {sure} of 24 as sure as before");
}

#[test]
fn what_coefficients_do_from_campaign_to_campaign_is_in_the_sd_of_the_next_forecast() {
    // The bias of each gyro is another after each power-up.
    let turned_on = |month: u32, shift: f64| {
        let mut campaign = campaign(40 + u64::from(month), month, NOMINAL_C, 1.0);
        for dwell in &mut campaign.dwells {
            dwell.output_pulse_s.iter_mut().enumerate().for_each(|(j, y)| *y += shift * (1.0 - 0.7 * j as f64));
        }
        campaign
    };
    let shifts = [0.004, -0.011, 0.008, -0.003, 0.010, -0.007];
    let all: Vec<Campaign> = shifts.iter().zip(1..).map(|(shift, month)| turned_on(month, *shift)).collect();
    let model = model(&all[..5].iter().collect::<Vec<_>>());
    let bias = model.coefficients.iter().find(|c| c.of == gyrowatch::core::imu_model::Of::Term(Term::Bias, 0)).unwrap();
    assert!((0.003..0.02).contains(&bias.between), "{bias:?}");
    let found = compare(&model, &all[5]).unwrap();
    assert!(found.p_value > 1e-3 && found.rms_over_sd < 2.0, "{} {}", found.p_value, found.rms_over_sd);
    let lone = identify(&[sample(&all[4])], &temperature_g()).unwrap();
    assert!(compare(&lone, &all[5]).unwrap().p_value < 1e-9, "one campaign knows nothing of it");
}

/// As [`campaign`] on a table whose vertical is tilted about east and north, arcsec; the station states 60.
fn tilted(seed: u64, month: u32, [east, north]: [f64; 2]) -> Campaign {
    const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;
    let mut campaign = campaign(seed, month, NOMINAL_C, 0.0);
    campaign.station_uncertainty.levelling = Some(60.0 * ARCSEC);
    let site = campaign.site.unwrap();
    let (tilt, up) = (Vector3::new(east, north, 0.0) * ARCSEC, Vector3::new(0.0, 0.0, site.gravity_g0));
    let (geometry, gyros) = (campaign.geometry.clone(), gyros());
    for dwell in &mut campaign.dwells {
        let c = *dwell.attitude.unwrap().matrix();
        let of_earth = tilt.cross(&site.earth_rate().0);
        // Over whole turns only what lies along the vertical stays.
        let (force, rate) = match dwell.phase {
            Phase::Static => (c * tilt.cross(&up), c * of_earth),
            Phase::Rate => (Vector3::zeros(), c * Vector3::new(0.0, 0.0, of_earth.z)),
        };
        for (j, gyro) in gyros.iter().enumerate() {
            let triad = geometry.triad(Slot::ALL[j]).unwrap();
            let drift = D_I[j] * triad.input().dot(&force) + D_S[j] * triad.spin().dot(&force);
            dwell.output_pulse_s[j] += gyro.scale_factor.unwrap() * (triad.input().dot(&rate) + drift);
        }
    }
    campaign
}

#[test]
fn what_a_station_states_of_its_level_is_in_the_forecast_and_in_what_has_changed() {
    let adopted =
        Adopted { effect: Effect::Levelling, shape: Shape::Tilt { with_rate: false }, slots: Slot::ALL.to_vec() };
    let effects = vec![KnownEffect { adopted, estimates: Vec::new() }];
    let levelling = AugmentedModel { effects, ..AugmentedModel::default() };
    let plain = AugmentedModel::default();
    let campaigns = [tilted(61, 1, [66.0, -42.0]), tilted(62, 2, [-27.0, 75.0])];
    let fitted = |model: &AugmentedModel, first: &Campaign| identify(&[sample(first)], model).unwrap();
    let judged = |model: &Identified, next: &Campaign| {
        forecast(&compare(model, next).unwrap().foretold(model), Limits::default().forecast()).unwrap().state
    };
    let [first, next] = &campaigns;
    let model = fitted(&plain, first);
    let found = compare(&model, next).unwrap();
    assert!(found.p_value > 1e-3 && found.rms_over_sd < 1.5, "{} {}", found.p_value, found.rms_over_sd);
    assert_eq!(judged(&model, next), State::Within);
    assert!(!changed(&fitted(&levelling, first), next).unwrap().effects[0].changed);
    let mut moved = next.clone();
    let input = moved.geometry.triad(Slot::G1).unwrap().input();
    moved.dwells.iter_mut().for_each(|d| d.output_pulse_s[0] += 1.46 * 0.03 * d.specific_force_g0.dot(&input));
    assert_eq!(judged(&model, &moved), State::Exceeded, "a step that no level makes");

    let [first, next] = &campaigns.clone().map(|mut campaign| {
        campaign.station_uncertainty = StationUncertainty::default();
        campaign
    });
    assert_eq!(judged(&fitted(&plain, first), next), State::Exceeded, "where the station states nothing");
    assert!(changed(&fitted(&levelling, first), next).unwrap().effects[0].changed);
}

/// As [`campaign`], but what temperature does to G1 is as well its square times `bent`.
fn bent(seed: u64, month: u32, celsius: f64, bent: f64) -> Campaign {
    let mut campaign = campaign(seed, month, celsius, 1.0);
    let input = campaign.geometry.triad(Slot::G1).unwrap().input();
    for dwell in &mut campaign.dwells {
        let warm = dwell.temperature_c.unwrap() - NOMINAL_C;
        dwell.output_pulse_s[0] += 1.46 * bent * warm * warm * input.dot(&dwell.specific_force_g0);
    }
    campaign
}

#[test]
fn a_coefficient_that_may_be_bent_beyond_the_temperatures_seen_is_undecided() {
    let campaigns = [bent(71, 1, 42.0, 1e-3), bent(72, 2, 45.0, 1e-3), bent(73, 3, 48.0, 1e-3)];
    let model = model(&campaigns.iter().collect::<Vec<_>>());
    let found = changed(&model, &bent(74, 4, 53.0, 1e-3)).unwrap();
    let [one] = &found.effects[..] else { panic!("{found:?}") };
    assert!(!one.changed && one.undecided && one.beyond_seen && found.shifts.is_empty(), "{found:?}");
}

#[test]
fn another_gyro_under_an_old_serial_is_outside_in_whatever_temperature() {
    let first = campaign(81, 1, NOMINAL_C, 0.0);
    let mut next = campaign(82, 2, NOMINAL_C + 2.5, 0.0);
    let model = model(&[&first]);
    let judged = |next: &Campaign| {
        let verdict = forecast(&compare(&model, next).unwrap().foretold(&model), Limits::default().forecast()).unwrap();
        let Finding::Forecast { slot, unseen, .. } = verdict.finding else { panic!("{verdict}") };
        (verdict.state, slot, unseen)
    };
    assert_eq!(judged(&next).0, State::Indeterminate);
    // What temperature may do, however much of it.
    let mut warmed = next.clone();
    warmed.dwells.iter_mut().for_each(|d| d.output_pulse_s[1] += 0.5 * (d.temperature_c.unwrap() - NOMINAL_C));
    assert_eq!(judged(&warmed).0, State::Indeterminate);
    let across = next.geometry.triad(Slot::G2).unwrap().spin();
    next.dwells.iter_mut().for_each(|d| d.output_pulse_s[1] += 1.47 * 0.01 * d.rate_arcsec_s.dot(&across));
    assert_eq!(judged(&next), (State::Exceeded, Slot::G2, Some(Unseen::Temperature)));
}

#[test]
fn campaigns_that_are_not_of_one_imu_make_no_model_and_other_campaigns_have_no_forecast() {
    let (first, next) = (campaign(1, 1, NOMINAL_C, 1.0), campaign(2, 2, NOMINAL_C, 1.0));
    let with = |change: &dyn Fn(&mut Campaign)| {
        let mut other = next.clone();
        change(&mut other);
        other
    };
    let name = |text: &str| gyrowatch::core::record::Name::parse(text).unwrap();
    let of_both = |other: &Campaign| identify(&[sample(&first), sample(other)], &temperature_g()).unwrap_err();
    let exchanged = with(&|c| c.gyros[1].serial = name("LFG-NEW"));
    assert!(matches!(of_both(&exchanged), NotIdentified::GyroExchanged { slot: Slot::G2, .. }));
    assert!(matches!(of_both(&with(&|c| c.imu = name("IMU-X"))), NotIdentified::OtherImu { .. }));
    assert_eq!(of_both(&first), NotIdentified::SameInstant);
    let held = with(&|c| c.gyros[2].known_e = Some(nalgebra::Vector3::x()));
    assert_eq!(of_both(&held), NotIdentified::OtherHeld(Slot::G3));
    // The same gyros in another order are the same gyros.
    let turned = with(&|c| {
        c.gyros.reverse();
        for dwell in &mut c.dwells {
            dwell.output_pulse_s.reverse();
            dwell.output_sem_pulse_s.iter_mut().for_each(|sem| sem.reverse());
        }
    });
    let fitted = |other: &Campaign| identify(&[sample(&first), sample(other)], &temperature_g()).unwrap();
    assert_eq!(fitted(&turned), fitted(&next));

    let model = model(&[&first]);
    assert_eq!(compare(&model, &first).unwrap_err(), NoForecast::FittedTo);
    assert!(matches!(compare(&model, &with(&|c| c.imu = name("IMU-X"))), Err(NoForecast::OtherImu { .. })));
    let found = compare(&model, &exchanged).unwrap();
    let codes: Vec<&str> = found.forecast.notes.iter().map(|note| note.code.as_ref()).collect();
    assert_eq!(found.gyros.len(), 2);
    assert!(codes.contains(&"gyro_exchanged_since") && codes.contains(&"ageing_unknown"), "{codes:?}");
    let turned = with(&|c| c.geometry = gyrowatch::core::mounting::Geometry::Orthogonal);
    assert_eq!(compare(&model, &turned).unwrap_err(), NoForecast::OtherGeometry);
    assert_eq!(of_both(&turned), NotIdentified::OtherGeometry);
    let strangers = with(&|c| c.gyros.iter_mut().enumerate().for_each(|(k, g)| g.serial = name(&format!("NEW-{k}"))));
    assert_eq!(compare(&model, &strangers).unwrap_err(), NoForecast::NoGyro);
    // In any order campaigns are the same model; one that is older than the model is foretold with a note.
    let (ab, ba) = ([sample(&first), sample(&next)], [sample(&next), sample(&first)]);
    let [ab, ba] = [ab, ba].map(|samples| identify(&samples, &temperature_g()).unwrap());
    assert_eq!((&ab.campaigns, ab.measured_at), (&ba.campaigns, ba.measured_at));
    assert!((ab.values() - ba.values()).amax() < 1e-9, "the last digits alone");
    let earlier = with(&|c| c.measured_at = first.measured_at.plus_days(-40.0));
    let notes = compare(&model, &earlier).unwrap().forecast.notes;
    assert!(notes.iter().any(|note| note.code == "campaign_before_model"), "{notes:?}");
    let blind = with(&|c| {
        c.temperature_c = None;
        c.dwells.iter_mut().for_each(|dwell| dwell.temperature_c = None);
    });
    let notes = compare(&model, &blind).unwrap().forecast.notes;
    assert!(notes.iter().any(|note| note.code == "effect_not_foretold"), "{notes:?}");
    let warm = compare(&model, &campaign(3, 3, 49.0, 1.0)).unwrap().forecast.notes;
    assert!(warm.iter().any(|note| note.code == "temperature_outside_model"), "{warm:?}");
}

#[test]
fn a_campaign_is_judged_by_the_dwells_that_are_like_those_the_model_has_seen() {
    let (first, mut next) = (campaign(1, 1, NOMINAL_C, 0.0), campaign(2, 2, NOMINAL_C, 0.0));
    for (dwell, like) in next.dwells.iter_mut().zip(&first.dwells) {
        dwell.temperature_c = like.temperature_c;
    }
    let model = model(&[&first]);
    let judged = |campaign: &Campaign| {
        let found = compare(&model, campaign).unwrap();
        let foretold = found.foretold(&model);
        (forecast(&foretold, Limits::default().forecast()).unwrap(), foretold.gyros[0].count)
    };
    // The last dwells are read 10 K warmer than they are: nobody knows what the model would say of them.
    let heated = |dwells: usize| {
        let mut campaign = next.clone();
        let from = campaign.dwells.len() - dwells;
        campaign.dwells[from..].iter_mut().for_each(|dwell| *dwell.temperature_c.as_mut().unwrap() += 10.0);
        campaign
    };
    let n = next.dwells.len();
    let (whole, count) = judged(&next);
    assert_eq!((whole.state, count), (State::Within, n));
    let (most, count) = judged(&heated(5));
    assert_eq!((most.state, count), (State::Within, n - 5), "{most}");
    let (few, _) = judged(&heated(n / 2 + 1));
    assert_eq!(few.state, State::Indeterminate, "{few}");
    let Finding::Forecast { unseen, .. } = few.finding else { panic!("{few}") };
    assert_eq!(unseen, Some(Unseen::Temperature));
    // What shows in the others shows.
    let mut moved = heated(5);
    let input = moved.geometry.triad(Slot::G1).unwrap().input();
    moved.dwells.iter_mut().for_each(|d| d.output_pulse_s[0] += 1.46 * 0.01 * d.specific_force_g0.dot(&input));
    assert_eq!(judged(&moved).0.state, State::Exceeded);
}

#[test]
fn the_dwells_to_measure_next_are_those_that_the_model_knows_least_of() {
    // A model of the static half knows nothing of rates: what it does not know, dwells at rate tell.
    let whole = campaign(1, 1, NOMINAL_C, 1.0);
    let is_static = |dwell: &gyrowatch::core::campaign::Dwell| dwell.rate_arcsec_s.norm() < 20.0;
    let mut half = whole.clone();
    half.dwells.retain(is_static);
    let asked = Scenario { seed: 2, gyros: gyros(), ..Scenario::default() };
    let next = simulate(&asked).unwrap().campaign;
    let knows_half = identify(&[sample(&half)], &AugmentedModel::default()).unwrap();
    let knows_all = identify(&[sample(&whole)], &AugmentedModel::default()).unwrap();
    let told = most_telling(&knows_half, &next, 6).unwrap();
    let of_all = most_telling(&knows_all, &next, 6).unwrap();
    assert_eq!(told.len(), 6);
    assert!(told[..3].iter().all(|one| !is_static(&next.dwells[one.dwell])), "{told:?}");
    assert!(told[0].information > 3.0 * of_all[0].information, "{told:?} {of_all:?}");
    assert!(told.windows(2).all(|pair| pair[0].information >= pair[1].information - 1e-9), "each beside those before");
    let dwells: BTreeSet<usize> = told.iter().map(|one| one.dwell).collect();
    assert_eq!(dwells.len(), 6, "no dwell twice");
}

fn written(dir: &Path, name: &str, campaign: &Campaign) -> PathBuf {
    let path = dir.join(name);
    std::fs::write(&path, wire::campaign::to_json(campaign)).unwrap();
    path
}

#[test]
fn the_command_line_fits_foretells_climbs_the_ladder_and_simulates_this_imu() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let first = written(dir.path(), "first.json", &campaign(1, 1, NOMINAL_C, 1.0));
    let next = written(dir.path(), "next.json", &campaign(2, 2, NOMINAL_C + 3.0, 1.0));
    let (first, next) = (first.to_str().unwrap(), next.to_str().unwrap());
    let model = path("model.json");
    let table = printed(&["model", "fit", first, "-o", &model]);
    assert!(table.contains("temperature_g") && table.contains("LFG-0"), "{table}");
    let file = read_json(&model);
    assert_eq!((&file["version"], &file["effects"][0]["effect"]), (&json!(2), &json!("temperature_g")));
    let coefficients = file["identified"]["coefficients"].as_array().unwrap();
    assert_eq!(file["identified"]["covariance"].as_array().unwrap().len(), coefficients.len());
    let asked = printed(&["model", "fit", first, "--effects", "temperature_g"]);
    let asked: Value = serde_json::from_str(&asked).unwrap();
    assert_eq!(asked["effects"][0]["gyros"], json!(["G1", "G2", "G3"]));
    let mut cold = campaign(3, 3, NOMINAL_C, 1.0);
    cold.temperature_c = None;
    cold.dwells.iter_mut().for_each(|dwell| dwell.temperature_c = None);
    let cold = written(dir.path(), "cold.json", &cold);
    let (status, out, said) = run(&["model", "fit", cold.to_str().unwrap(), "--effects", "temperature_g"]);
    assert!(status == 0 && !out.contains("temperature_g") && said.contains("temperature_g is left out"), "{said}");

    let told = answer(&["predict", &model, next]);
    // Three kelvin warmer than the model has seen: every place says so, and none that it is as foretold.
    let verdict = &told["compared"]["verdict"];
    assert_eq!((&told["compared"]["state"], &verdict["state"]), (&json!("indeterminate"), &json!("indeterminate")));
    assert_eq!(told["gyros"][0]["predicted_pulse_s"].as_array().unwrap().len(), 78);
    let table = printed(&["predict", &model, next]);
    assert!(table.contains("Promised by the model") && table.contains("noise floor"), "{table}");
    assert!(table.contains("cannot be judged") && table.contains("has not seen such temperatures"), "{table}");
    let steps = answer(&["gap", &model, next]);
    assert_eq!(steps[0]["rungs"][1]["effect"], "temperature_g");
    let words = printed(&["gap", &model, next]);
    let said = ["forecast error of each campaign", "model (6)", "+ temperature_g", "cannot be judged", "noise floor"];
    assert!(said.iter().all(|part| words.contains(part)), "{words}");
    let against = answer(&["diagnose", next, "--model", &model]);
    assert_eq!(against["effects_against_model"]["effects"][0]["changed"], false);

    // What is still to be measured: the same IMU at another temperature, and one that the model allows.
    let scenario = path("tomorrow.toml");
    std::fs::write(&scenario, "measured_at = \"2026-09-01T08:00:00Z\"\n[temperature]\nmean_c = 47.0\n").unwrap();
    let told = answer(&["predict", &model, &scenario]);
    assert_eq!(told["next_dwells"].as_array().unwrap().len(), 8);
    assert!(told["compared"].is_null() && told["promised"]["closure"].as_f64().unwrap() > 0.8, "{}", told["promised"]);
    let mut z = Vec::new();
    for seed in ["3", "4", "5"] {
        let made = path("made.json");
        printed(&["simulate", "--scenario", &scenario, "--model", &model, "--seed", seed, "--out", &made]);
        let told = answer(&["predict", &model, &made]);
        z.push(told["compared"]["p_value"].as_f64().unwrap());
        let document = read_json(&made);
        assert_eq!(document["gyros"][2]["serial"], "LFG-2");
    }
    assert!(z.iter().all(|p| *p > 1e-3), "{z:?}");

    let old = path("old.json");
    std::fs::write(&old, json!({"terms": [], "effects": []}).to_string()).unwrap();
    let practice = data_path("practice/campaign-00.json");
    // Effects of another IMU are fitted anew, and it is said.
    for command in ["diagnose", "calibrate"] {
        let (status, out, error) = run(&[command, practice.to_str().unwrap(), "--model", &model]);
        let said = format!("{out}{error}").split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            status == 0 && said.contains("the model is of IMU IMU-07; its effects are fitted"),
            "{command}: {said}"
        );
        let own = run(&[command, next, "--model", &model]);
        assert!(own.0 == 0 && !format!("{}{}", own.1, own.2).contains("the model is of IMU"), "{own:?}");
    }
    let refusals: [(&[&str], &str); 7] = [
        (&["predict", &old, next], "gyrowatch model fit"),
        (&["predict", &model, first], "fitted to this campaign"),
        (&["predict", &model, practice.to_str().unwrap()], "the model is of IMU"),
        (&["model", "fit", first, practice.to_str().unwrap()], "the campaigns are of IMU"),
        (&["model", "fit", first, first], "first.json: two campaigns have the same time: leave one out"),
        (&["model", "fit", first, "--effects", "ghost"], "ghost"),
        (&["model", "fit", first, "-o", next], "holds no model"),
    ];
    for (arguments, said) in refusals {
        let (status, out, error) = run(arguments);
        assert!(status == 1 && out.is_empty() && error.contains(said), "{arguments:?}: {error}");
    }
}

#[test]
fn a_model_file_that_contradicts_itself_is_refused_by_the_place_of_its_fault() {
    let model = model(&[&campaign(1, 1, NOMINAL_C, 1.0)]).into_model(&temperature_g());
    let file: Value = serde_json::from_str(&wire::model::to_json(&model)).unwrap();
    let again = wire::model::parse(file.to_string().as_bytes()).unwrap();
    let (one, other) = (model.identified.unwrap(), again.identified.unwrap());
    assert_eq!((&one.effects, &one.gyros.len(), &one.terms), (&other.effects, &other.gyros.len(), &other.terms));
    assert!((&one.covariance - &other.covariance).amax() <= 1e-12 * one.covariance.amax());
    assert_eq!(one.values().len(), other.values().len());
    let cases = [
        ("/version", json!(3), "/version"),
        ("/identified/covariance/0", json!([1.0, 2.0]), "/identified/covariance"),
        ("/identified/covariance/3/3", json!(-1.0), "/identified/covariance"),
        ("/identified/coefficients/0/sd", json!(5.0), "/identified/coefficients/0/sd"),
        ("/identified/coefficients/0/unit", json!("deg/h"), "/identified/coefficients/0/unit"),
        ("/identified/coefficients/0/name", json!("D_F"), "/identified/coefficients/0/name"),
        ("/identified/coefficients/0/slot", json!("G9"), "/identified/coefficients/0/slot"),
        ("/identified/gyros/0/noise/random_walk_deg_per_sqrt_h", json!(-1.0), "/identified/gyros/0"),
        ("/identified/campaigns", json!([]), "/identified/campaigns"),
        ("/identified/reference_temperature_c", json!(450.0), "/identified/reference_temperature_c"),
        ("/identified/validity/temperature_c", json!([50.0, 40.0]), "/identified/validity/temperature_c"),
        ("/identified/validity/temperature_c", json!([20.0, 1e9]), "/identified/validity/temperature_c"),
        ("/identified/validity/temperature_c", json!(null), "/identified/reference_temperature_c"),
        ("/identified/gyros/0/e_pulse_per_arcsec", json!([1.0, -1.0, 0.0]), "/identified/gyros/0/e_pulse_per_arcsec"),
        ("/effects/0/estimates/0/value", json!(100.0), "/effects/0/estimates/0/value"),
    ];
    for (place, value, fault) in cases {
        let mut bad = file.clone();
        *bad.pointer_mut(place).unwrap() = value;
        let faults = wire::model::parse(bad.to_string().as_bytes()).unwrap_err();
        assert!(faults.0.iter().any(|f| f.pointer == fault), "{place}: {faults:?}");
    }
}

#[tokio::test]
async fn the_service_foretells_each_campaign_by_the_model_in_force_when_it_came_in() {
    let lab = Lab::open().await;
    let (first, second) = (campaign(1, 1, NOMINAL_C, 1.0), campaign(2, 2, NOMINAL_C + 3.0, 1.0));
    let third = campaign(3, 3, NOMINAL_C + 3.0, 1.0);
    lab.get("/v1/imus/IMU-07/forecast").await.refused(404);
    lab.post("/v1/campaigns", &document(&first)).await.created();
    lab.post("/v1/campaigns", &document(&second)).await.created();

    let file = model(&[&first]).into_model(&temperature_g());
    let body = adoption(&file);
    let adopted = lab.post("/v1/imus/IMU-07/model", &body).await.created();
    assert_eq!(adopted["model"]["version"], 2);
    let stored = lab.post("/v1/campaigns", &document(&third)).await.created();
    let own = &stored["separations"][0]["as_measured"];
    assert!((own["temperature_c"].as_f64().unwrap() - 48.0).abs() < 1.0, "{stored}");
    let moved = stored["separations"][0]["d_i"]["value"].as_f64().unwrap() - own["d_i"]["value"].as_f64().unwrap();
    assert!((moved + 3.0 * K[0]).abs() < 0.003, "{moved}");

    let series = lab.get("/v1/imus/IMU-07/forecast").await.ok();
    let points = series["points"].as_array().unwrap();
    let state = |k: usize| points[k]["compared"]["state"].as_str();
    assert_eq!((points.len(), state(0), state(1), state(2)), (3, None, Some("indeterminate"), Some("indeterminate")));
    assert!(points[0]["why_not"].as_str().unwrap().contains("no earlier campaign"));
    assert_eq!((&points[1]["imu_model"], &points[2]["imu_model"]), (&Value::Null, &adopted["id"]));
    assert_eq!(points[2]["model"]["effects"], json!(["temperature_g"]));
    assert_eq!(series["latest"]["gyros"][0]["predicted_pulse_s"].as_array().unwrap().len(), 78);
    assert_eq!(lab.get("/v1/imus/IMU-07/forecast?limit=1").await.ok()["points"].as_array().unwrap().len(), 1);
    lab.get("/v1/imus/IMU-07/forecast?limit=0").await.refused(400);
    let diagnosis = lab.diagnosis(stored["id"].as_str().unwrap()).await.ok();
    assert_eq!(diagnosis["effects_against_model"]["effects"][0]["changed"], false, "{diagnosis}");

    // Made by itself, and kept with the diagnosis: the series answers what was kept.
    assert_eq!(diagnosis["forecast"], points[2], "{diagnosis}");
    let kept = lab.get("/v1/imus/IMU-07/forecast").await.ok();
    assert_eq!((&kept["points"], &kept["latest"]), (&series["points"], &series["latest"]));
    let summary = lab.get("/v1/diagnoses/summary").await.ok();
    assert_eq!(summary["outside_forecast"], json!([]), "the model in force has not seen three kelvin more");

    // G1 has moved by itself: that is none of the model's.
    let mut moved = campaign(4, 4, NOMINAL_C, 1.0);
    moved.dwells.iter_mut().for_each(|dwell| dwell.output_pulse_s[1] += 0.02 * dwell.specific_force_g0.x);
    let last = lab.post("/v1/campaigns", &document(&moved)).await.created();
    let diagnosis = lab.diagnosis(last["id"].as_str().unwrap()).await.ok();
    assert_eq!(diagnosis["forecast"]["compared"]["state"], "outside");
    let codes: Vec<&Value> = diagnosis["note_codes"].as_array().unwrap().iter().map(|note| &note["code"]).collect();
    assert!(codes.contains(&&json!("campaign_outside_forecast")), "{codes:?}");
    let summary = lab.get("/v1/diagnoses/summary").await.ok();
    let outside = summary["outside_forecast"].as_array().unwrap();
    assert_eq!((outside.len(), &outside[0]["campaign"]["campaign"]), (1, &last["id"]));
    // One word, one meaning: the rule's gyro, figure and p stand in the summary, in the note and on the page of today.
    let verdict = &diagnosis["forecast"]["compared"]["verdict"];
    assert_eq!([&verdict["state"], &verdict["slot"]], ["exceeded", "G2"]);
    assert_eq!([&outside[0]["slot"], &outside[0]["rms_over_sd"]], [&verdict["slot"], &verdict["value"]]);
    assert_eq!(outside[0]["p_value"], verdict["p_value"]);
}

#[tokio::test]
async fn a_model_of_other_gyros_is_not_adopted_and_a_gyro_exchanged_since_is_said() {
    let lab = Lab::open().await;
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    lab.post("/v1/campaigns", &document(&first)).await.created();
    let file = model(&[&first]).into_model(&temperature_g());
    let body = adoption(&file);
    let mut strangers = body.clone();
    for gyro in strangers["identified"]["gyros"].as_array_mut().unwrap() {
        gyro["serial"] = format!("NEW-{}", gyro["slot"]).into();
    }
    let mut turned = body.clone();
    turned["identified"]["geometry"] = "orthogonal".into();
    for (other, code) in [(&strangers, "no gyro"), (&turned, "another geometry")] {
        let refused = lab.post("/v1/imus/IMU-07/model", other).await;
        assert_eq!(refused.refused(422), ["/identified"]);
        assert!(refused.text.contains(code), "{}", refused.text);
    }
    lab.post("/v1/imus/IMU-07/model", &body).await.created();

    let mut next = document(&campaign(2, 2, NOMINAL_C, 1.0));
    next["gyros"][1]["serial"] = "LFG-NEW".into();
    let stored = lab.post("/v1/campaigns", &next).await.created();
    let diagnosis = lab.diagnosis(stored["id"].as_str().unwrap()).await.ok();
    let said = diagnosis["notes"].to_string();
    assert!(said.contains("G2 was LFG-1 when the model was made and is LFG-NEW"), "{said}");
    let foretold = diagnosis["forecast"]["notes"].to_string();
    assert!(foretold.contains("left out of the forecast"), "{foretold}");
}

/// A campaign that holds E, of static dwells alone, is foretold by campaigns that fit it.
#[tokio::test]
async fn a_campaign_that_holds_e_has_a_forecast_too() {
    let lab = Lab::open().await;
    let (first, next) = (campaign(1, 1, NOMINAL_C, 1.0), campaign(2, 2, NOMINAL_C, 1.0));
    lab.post("/v1/campaigns", &document(&first)).await.created();
    let mut holding = document(&next);
    let of_first = model(&[&first]);
    for (gyro, known) in holding["gyros"].as_array_mut().unwrap().iter_mut().zip(&of_first.gyros) {
        gyro["known_e_pulse_per_arcsec"] = json!(<[f64; 3]>::from(known.e));
    }
    holding["dwells"].as_array_mut().unwrap().retain(|dwell| dwell["phase"] == "static");
    let stored = lab.post("/v1/campaigns", &holding).await.created();
    let diagnosis = lab.diagnosis(stored["id"].as_str().unwrap()).await.ok();
    let forecast = &diagnosis["forecast"];
    assert_eq!((&forecast["why_not"], &forecast["model"]["campaigns"]), (&Value::Null, &json!(1)), "{forecast}");
    assert!(forecast["compared"]["rms_over_sd"].as_f64().unwrap() < 1.5, "{forecast}");
}

/// The D_I of a gyro as the trend has it, oldest first, with its standard deviation.
async fn d_i(lab: &Lab, serial: &str) -> Vec<[f64; 2]> {
    let points = lab.sees_trend(serial, "coefficient=D_I").await;
    points.iter().map(|point| ["value", "sd"].map(|member| point[member].as_f64().unwrap())).collect()
}

/// By how many standard deviations two values differ.
fn step([one, one_sd]: [f64; 2], [other, other_sd]: [f64; 2]) -> f64 {
    (one - other).abs() / one_sd.hypot(other_sd)
}

#[tokio::test]
async fn an_adoption_states_the_stored_campaigns_at_its_temperature_and_its_undoing_as_they_were() {
    let mut lab = Lab::open().await;
    let firing = async |lab: &Lab| -> Vec<Value> {
        let alerts = lab.get("/v1/alerts?state=firing&serial=LFG-0").await.ok();
        let mut rules: Vec<Value> =
            alerts["alerts"].as_array().unwrap().iter().map(|alert| alert["rule"].clone()).collect();
        rules.sort_by_key(ToString::to_string);
        rules
    };
    // Six kelvin warmer D_I of G1 is 0.018 larger: beyond its limit.
    let campaigns: Vec<Campaign> =
        (1..=4).map(|k| campaign(u64::from(k), k, NOMINAL_C + if k < 3 { 0.0 } else { 6.0 }, 1.0)).collect();
    let mut stored = Vec::new();
    for campaign in &campaigns {
        stored.push(lab.post("/v1/campaigns", &document(campaign)).await.created());
    }
    let before = d_i(&lab, "LFG-0").await;
    assert!(before[2][0] - before[0][0] > 0.015 && step(before[2], before[0]) > 20.0, "{before:?}");
    let fired = firing(&lab).await;
    assert!(!fired.is_empty());
    let unmoved = d_i(&lab, "LFG-1").await;

    let file = model(&[&campaigns[0]]).into_model(&temperature_g());
    let mut body = adoption(&file);
    body["reason"] = "D_I follows temperature".into();
    let mut other = body.clone();
    other["identified"]["imu"] = "IMU-99".into();
    assert_eq!(lab.post("/v1/imus/IMU-07/model", &other).await.refused(422), ["/identified/imu"]);
    let adopted = lab.post("/v1/imus/IMU-07/model", &body).await.created();
    assert_eq!(adopted["campaigns"], 4, "all are stated with it");

    let now = d_i(&lab, "LFG-0").await;
    assert!(step(now[2], now[0]) < 3.0 && step(now[3], now[1]) < 3.0, "{now:?}");
    for (now, then) in d_i(&lab, "LFG-1").await.iter().zip(&unmoved) {
        assert!((now[0] - then[0]).abs() < 1e-3, "no effect of its own: {now:?} {then:?}");
    }
    assert_eq!(firing(&lab).await, [] as [Value; 0], "the step was the temperature");
    // What is said of an alert that ends so is who adopted, and why.
    let alert = &lab.get("/v1/alerts?state=resolved&serial=LFG-0").await.ok()["alerts"][0];
    let steps = lab.get(&format!("/v1/alerts/{}", alert["id"].as_str().unwrap())).await.ok()["history"].to_string();
    assert!(steps.contains("M. Adopter") && steps.contains("D_I follows temperature"), "{steps}");

    // The value as measured stands beside it, and everything that is stored agrees with what is computed anew.
    let third = lab.get(&format!("/v1/campaigns/{}", stored[2]["id"].as_str().unwrap())).await.ok();
    assert_eq!(third["imu_model"], adopted["id"]);
    let own = &third["separations"][0]["as_measured"];
    assert!((own["d_i"]["value"].as_f64().unwrap() - before[2][0]).abs() < 0.003, "{own}");
    assert!((own["temperature_c"].as_f64().unwrap() - 51.0).abs() < 1.0, "{own}");
    let verified = lab.verified().await;
    assert!(verified.faults.is_empty(), "{:?}", verified.faults);
    assert_eq!(verified.not_compared, 0);

    lab.restart().await;
    assert_eq!(d_i(&lab, "LFG-0").await, now);
    // A late campaign is judged among those that are stated anew.
    let between = at(document(&campaign(9, 5, NOMINAL_C, 1.0)), "2026-01-15T08:00:00Z");
    let late = lab.post("/v1/campaigns", &between).await;
    assert_eq!(late.created()["imu_model"], adopted["id"]);

    let plain = json!({"terms": [], "effects": [], "author": "M. Adopter", "reason": "the gyro was exchanged"});
    let undone = lab.post("/v1/imus/IMU-07/model", &plain).await.created();
    assert_eq!(undone["campaigns"], 5);
    let again = d_i(&lab, "LFG-0").await;
    assert_eq!([again[0], again[2], again[3], again[4]], before[..], "to the last bit");
    // What fires is what would if all had come in time and nothing had been adopted; the step into it is the past.
    let in_time = Lab::open().await;
    let mut all: Vec<Value> = campaigns.iter().map(document).chain([between]).collect();
    all.sort_by_key(|campaign| campaign["measured_at"].as_str().unwrap().to_owned());
    for campaign in &all {
        in_time.post("/v1/campaigns", campaign).await.created();
    }
    let lasting = |rules: Vec<Value>| rules.into_iter().filter(|rule| *rule != "step").collect::<Vec<_>>();
    assert_eq!(lasting(firing(&lab).await), lasting(firing(&in_time).await));
    let fires = firing(&lab).await;
    assert!(fired.iter().all(|rule| *rule == "step" || fires.contains(rule)), "{fired:?} {fires:?}");
    let verified = lab.verified().await;
    assert!(verified.faults.is_empty(), "{:?}", verified.faults);
    let history = lab.get("/v1/imus/IMU-07/model").await.ok()["history"].clone();
    assert_eq!((&history[0]["campaigns"], &history[1]["campaigns"]), (&json!(5), &json!(0)));
}

/// A window of a station is set aside, a model comes into force or goes, and the window counts again.
#[tokio::test]
async fn what_was_set_aside_counts_as_the_model_in_force_states_it() {
    let lab = Lab::open().await;
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    let mut record = finished(&campaign(3, 3, NOMINAL_C + 6.0, 1.0), true);
    let station = document(&first)["station"].as_str().unwrap().to_owned();
    record["station"] = station.as_str().into();
    lab.post("/v1/campaigns", &document(&first)).await.created();
    let warm = lab.post("/v1/campaigns", &document(&campaign(2, 2, NOMINAL_C + 6.0, 1.0))).await.created();
    let warm = format!("/v1/campaigns/{}", warm["id"].as_str().unwrap());
    lab.post("/v1/records", &record).await.created();
    let plain = d_i(&lab, "LFG-0").await;
    assert!(step(plain[1], plain[0]) > 5.0 && step(plain[2], plain[0]) > 5.0, "{plain:?}");

    let window = json!({
        "from": "2026-01-20T00:00:00Z", "to": "2026-04-01T00:00:00Z", "by": "Li Wei", "reason": "the table was open",
    });
    let says = async |deed: &str| lab.post(&format!("/v1/stations/{station}/{deed}"), &window).await.ok();
    assert_eq!(says("suspect").await["records"].as_array().unwrap().len(), 2);
    let adopted = adopts(&lab, &model(&[&first]).into_model(&temperature_g())).await;
    says("trust").await;
    let now = d_i(&lab, "LFG-0").await;
    assert!(step(now[1], now[0]) < 3.0 && step(now[2], now[0]) < 3.0, "{now:?}");
    assert_eq!(lab.get(&warm).await.ok()["imu_model"], adopted["id"]);
    assert_eq!(lab.verified().await.faults, []);

    says("suspect").await;
    let none = json!({"terms": [], "effects": [], "author": "M. Adopter", "reason": "no more"});
    lab.post("/v1/imus/IMU-07/model", &none).await.created();
    says("trust").await;
    assert_eq!(d_i(&lab, "LFG-0").await, plain, "to the last bit");
    assert_eq!(lab.verified().await.faults, []);
}

/// What a station would state that had fitted the campaign itself; at its mean temperature, or at none.
fn finished(campaign: &Campaign, states_temperature: bool) -> Value {
    let plain = AugmentedModel::default().options(campaign);
    let Outcome::Imu { calibration, .. } = evaluate_with(campaign, &plain, &Plausibility::ever()).unwrap() else {
        panic!("a campaign of an IMU")
    };
    let gyros = calibration.gyros.iter().zip(&campaign.gyros).map(|(fitted, gyro)| {
        let sd = fitted.covariance_eg().unwrap().diagonal().map(f64::sqrt);
        let [e, g] = [fitted.e().unwrap(), fitted.g().unwrap()].map(<[f64; 3]>::from);
        json!({
            "slot": gyro.slot.name(), "serial": gyro.serial.as_str(), "e_pulse_per_arcsec": e, "g_pulse_per_s_g0": g,
            "e_sd": [sd[0], sd[1], sd[2]], "g_sd": [sd[3], sd[4], sd[5]],
        })
    });
    let measured_at = document(campaign)["measured_at"].clone();
    let mut record = json!({
        "imu": "IMU-07", "station": "station-2", "calibrated_at": measured_at, "geometry": "skewed",
        "gyros": gyros.collect::<Vec<Value>>(),
    });
    if states_temperature {
        let temperatures = campaign.dwells.iter().map(|dwell| dwell.temperature_c.unwrap());
        record["temperature_c"] = json!(temperatures.sum::<f64>() / campaign.dwells.len() as f64);
    }
    record
}

fn without_temperatures(campaign: &Campaign) -> Value {
    let mut document = document(campaign);
    document.as_object_mut().unwrap().remove("temperature_c");
    for dwell in document["dwells"].as_array_mut().unwrap() {
        dwell.as_object_mut().unwrap().remove("temperature_c");
    }
    document
}

#[tokio::test]
async fn records_are_restated_as_campaigns_are_and_what_states_no_temperature_is_held_against_nothing() {
    let mut lab = Lab::open().await;
    let exceeded = async |lab: &Lab, path: &str| -> Vec<Value> {
        let verdicts = lab.get(path).await.ok()["verdicts"].as_array().unwrap().clone();
        let of_g1 = |verdict: &Value| verdict["serial"] == "LFG-0" && verdict["state"] == "exceeded";
        verdicts.into_iter().filter(of_g1).map(|verdict| verdict["rule"].clone()).collect()
    };
    let warm = |month: u32| campaign(u64::from(month), month, NOMINAL_C + 6.0, 1.0);
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    let mut paths = Vec::new();
    for (kind, sent) in [
        ("campaigns", document(&first)),
        ("records", finished(&campaign(2, 2, NOMINAL_C, 1.0), true)),
        ("campaigns", document(&campaign(3, 3, NOMINAL_C, 1.0))),
        ("records", finished(&warm(4), true)),
        ("campaigns", without_temperatures(&warm(5))),
        ("records", finished(&warm(6), false)),
    ] {
        let stored = lab.post(&format!("/v1/{kind}"), &sent).await.created();
        paths.push(format!("/v1/{kind}/{}", stored["id"].as_str().unwrap()));
    }
    let before = d_i(&lab, "LFG-0").await;
    for k in 3..6 {
        assert!(step(before[k], before[2]) > 5.0, "{before:?}");
        assert!(!exceeded(&lab, &paths[k]).await.is_empty(), "as measured {} steps", paths[k]);
    }
    let unmoved = d_i(&lab, "LFG-1").await;

    adopts(&lab, &model(&[&first]).into_model(&temperature_g())).await;
    let now = d_i(&lab, "LFG-0").await;
    assert!(step(now[3], now[2]) < 3.0 && now[3][1] < 0.005, "{now:?}");
    assert!(now[3][1] > before[3][1], "what is known of the effect is not known exactly: {now:?} {before:?}");
    assert!(step(now[1], now[0]) < 3.0 && step(now[1], now[2]) < 3.0, "{now:?}");
    for k in 4..6 {
        let [value, sd] = now[k];
        assert!((value - before[k][0]).abs() < 1e-3 && (0.05..0.5).contains(&sd), "{now:?}");
    }
    for path in &paths {
        assert_eq!(exceeded(&lab, path).await, [] as [Value; 0], "{path}");
    }
    assert_eq!(d_i(&lab, "LFG-1").await[3..4], unmoved[3..4], "G2 has no effect of its own");
    let record = lab.get(&paths[3]).await.ok();
    let own = &record["separations"][0]["as_measured"];
    assert!((own["d_i"]["value"].as_f64().unwrap() - before[3][0]).abs() < 1e-12, "{own}");
    assert!((own["temperature_c"].as_f64().unwrap() - 51.0).abs() < 1.0, "{own}");
    assert!(record["separations"][1].get("as_measured").is_none_or(Value::is_null), "{record}");
    for (path, code) in [(&paths[4], "effect_left_out"), (&paths[5], "any_temperature_of_record")] {
        let notes = lab.get(path).await.ok()["notes"].clone();
        let note = notes.as_array().unwrap().iter().find(|note| note["code"] == code);
        assert!(note.is_some_and(|note| note["detail"].as_str().unwrap().contains("no temperature")), "{notes}");
    }
    assert_eq!(lab.verified().await.faults, []);

    // What comes now is stated so from the start, and read so after a restart.
    let stored = lab.post("/v1/records", &finished(&warm(7), true)).await.created();
    let path = format!("/v1/records/{}", stored["id"].as_str().unwrap());
    lab.restart().await;
    assert_eq!(lab.get(&path).await.ok()["separations"], stored["separations"]);
    let all = d_i(&lab, "LFG-0").await;
    assert!(step(all[6], all[2]) < 3.0, "{all:?}");
    let late = lab.post("/v1/records", &finished(&warm(8), false)).await.created();
    assert!(late["notes"].to_string().contains("any_temperature_of_record"), "{late}");
    assert_eq!(lab.verified().await.faults, []);

    let plain = json!({"terms": [], "effects": [], "author": "M. Adopter", "reason": "no more"});
    lab.post("/v1/imus/IMU-07/model", &plain).await.created();
    assert_eq!(d_i(&lab, "LFG-0").await[..6], before[..], "to the last bit");
    let record = lab.get(&paths[3]).await.ok();
    assert!(record["separations"][0].get("as_measured").is_none_or(Value::is_null), "{record}");
    assert!(!lab.get(&paths[5]).await.ok()["notes"].to_string().contains("any_temperature"));
    assert_eq!(lab.verified().await.faults, []);
}

/// Records that are sent while a model is adopted, and one that was read before and is stored after.
#[tokio::test]
async fn a_record_that_meets_an_adoption_on_its_way_is_stated_by_the_model() {
    let lab = Lab::open().await;
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    lab.post("/v1/campaigns", &document(&first)).await.created();
    let warm = |day: u32| {
        let mut record = finished(&campaign(2, 2, NOMINAL_C + 6.0, 1.0), true);
        record["calibrated_at"] = format!("2026-02-{day:02}T08:00:00Z").into();
        record
    };
    let read = lab.pipeline().reader.record(warm(1).to_string().as_bytes()).unwrap();
    let file = model(&[&first]).into_model(&temperature_g());
    let documents: Vec<Value> = (2..20).map(warm).collect();
    let sent = futures::future::join_all(documents.iter().map(|record| lab.post("/v1/records", record)));
    let (_, sent) = futures::future::join(adopts(&lab, &file), sent).await;
    assert!(sent.iter().all(|answer| answer.status == 201));
    let late = lab.pipeline().ingest.enqueue(vec![Submission::Calibration(Box::new(read))], Late::Quiet).await.await;
    assert!(late[0].is_ok());

    let all = d_i(&lab, "LFG-0").await;
    assert_eq!(all.len(), 20);
    for one in &all[1..] {
        assert!(step(*one, all[0]) < 3.0 && (one[0] - all[1][0]).abs() < 1e-12, "{all:?}");
    }
    assert_eq!(lab.verified().await.faults, []);
}

/// As an earlier version of the program leaves a database: its model is in force, what is stored is stated otherwise.
#[tokio::test]
async fn what_an_earlier_version_stated_otherwise_is_stated_anew_after_the_start() {
    let mut lab = Lab::open().await;
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    let warm = |month: u32| campaign(u64::from(month), month, NOMINAL_C + 6.0, 1.0);
    lab.post("/v1/campaigns", &document(&first)).await.created();
    lab.post("/v1/campaigns", &document(&warm(2))).await.created();
    lab.post("/v1/campaigns", &without_temperatures(&warm(3))).await.created();
    lab.post("/v1/records", &finished(&warm(4), true)).await.created();
    let silent = lab.post("/v1/records", &finished(&warm(5), false)).await.created();
    let gone = lab.post("/v1/records", &finished(&warm(6), true)).await.created();
    let gone = format!("/v1/records/{}", gone["id"].as_str().unwrap());
    let aside = without_temperatures(&warm(7));
    let station = aside["station"].as_str().unwrap().to_owned();
    lab.post("/v1/campaigns", &aside).await.created();
    let as_measured = d_i(&lab, "LFG-0").await;
    let voiding = json!({"author": "M. Voider", "reason": "a wrong fixture"});
    assert!(lab.post(&format!("{gone}/void"), &voiding).await.status < 300);
    let file = model(&[&first]).into_model(&temperature_g());
    adopts(&lab, &file).await;
    let right = d_i(&lab, "LFG-0").await;
    assert!(step(right[1], as_measured[1]) > 3.0 && step(right[3], as_measured[3]) > 3.0);

    // The same rows by another model, under the identifier of this one; records by none.
    let mut other = file.clone();
    other.effects[0].estimates.iter_mut().for_each(|estimate| estimate.value *= 0.3);
    let identified = Arc::make_mut(other.identified.as_mut().unwrap());
    let of_effect = |c: &&mut ModelCoefficient| matches!(c.of, Of::Effect(..));
    identified.coefficients.iter_mut().filter(of_effect).for_each(|c| c.value *= 0.3);
    adopts(&lab, &other).await;
    let otherwise = d_i(&lab, "LFG-0").await;
    assert!(otherwise.iter().zip(&right).skip(3).all(|(other, right)| other != right), "{otherwise:?} {right:?}");
    let window = json!({
        "from": "2026-07-01T00:00:00Z", "to": "2026-08-01T00:00:00Z", "by": "Li Wei", "reason": "the table was open",
    });
    let suspected = lab.post(&format!("/v1/stations/{station}/suspect"), &window).await.ok();
    assert_eq!(suspected["records"].as_array().unwrap().len(), 1);
    lab.stop().await;
    let body = wire::model::to_json(&file);
    assert!(lab.change_to("UPDATE imu_model SET body = $1", &[&body]).await > 0);
    let of_records = "DELETE FROM campaign_model WHERE record IN (SELECT id FROM record WHERE kind = 0)";
    assert!(lab.change(of_records).await > 0);
    lab.start().await;
    let counting = &right[..5];
    once(async || d_i(&lab, "LFG-0").await, |now| now == counting).await;
    // What was set aside then is stated anew where it counts again.
    lab.post(&format!("/v1/stations/{station}/trust"), &window).await.ok();
    assert_eq!(d_i(&lab, "LFG-0").await, right);
    let silent = lab.get(&format!("/v1/records/{}", silent["id"].as_str().unwrap())).await.ok();
    assert!(silent["notes"].to_string().contains("any_temperature_of_record"), "{silent}");
    assert_eq!(lab.get(&gone).await.ok()["voided"]["author"], "M. Voider");
    assert_eq!(lab.verified().await.faults, []);
    // Nothing is left to do: the next start leaves it as it is.
    lab.restart().await;
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert_eq!(d_i(&lab, "LFG-0").await, right);
}

fn document(campaign: &Campaign) -> Value {
    serde_json::from_str(&wire::campaign::to_json(campaign)).unwrap()
}

/// As [`campaign`] at the usual temperature, on a day of June; D_I of G2 higher by `moved`, deg/(h g0).
fn in_june(day: u32, moved: f64) -> Value {
    let mut campaign = campaign(60 + u64::from(day), 6, NOMINAL_C, 1.0);
    let input = campaign.geometry.triad(Slot::G2).unwrap().input();
    for dwell in &mut campaign.dwells {
        dwell.output_pulse_s[1] += 1.47 * moved * dwell.specific_force_g0.dot(&input);
    }
    at(document(&campaign), &format!("2026-06-{day:02}T08:00:00Z"))
}

/// What adopts a model.
fn adoption(model: &AugmentedModel) -> Value {
    let mut body: Value = serde_json::from_str(&wire::model::to_json(model)).unwrap();
    body["author"] = "M. Adopter".into();
    body["reason"] = "it foretells".into();
    body
}

async fn adopts(lab: &Lab, model: &AugmentedModel) -> Value {
    lab.post("/v1/imus/IMU-07/model", &adoption(model)).await.created()
}

/// Posts a campaign and waits until its diagnosis is kept: what is made of its forecast.
async fn measured(lab: &Lab, campaign: &Value) -> Value {
    let stored = lab.post("/v1/campaigns", campaign).await.created();
    let id = stored["id"].as_str().unwrap();
    let mut forecast = lab.diagnosis(id).await.ok()["forecast"].clone();
    forecast["id"] = stored["id"].clone();
    forecast
}

/// Waits until the alert of the IMU stands so and is so severe; it, or null where there is none.
async fn alert_is(lab: &Lab, wanted: Option<[&str; 2]>) -> Value {
    let look = async || lab.get("/v1/alerts?rule=forecast").await.ok()["alerts"][0].clone();
    let stands =
        |alert: &Value| [&alert["state"], &alert["severity"]].map(|word| word.as_str().unwrap_or_default().to_owned());
    once(look, |alert| wanted.map_or(alert.is_null(), |wanted| stands(alert) == wanted)).await
}

#[tokio::test]
async fn a_campaign_outside_what_its_imus_adopted_model_foretold_fires_and_the_next_confirms_or_resolves_it() {
    let (lab, target) = (Lab::open().await, Receiver::start().await);
    lab.tells(&target, json!({"filter": {"rules": ["forecast"]}})).await;
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    measured(&lab, &document(&first)).await;
    // Nobody has adopted anything: it is foretold, and judged by nobody.
    let unasked = measured(&lab, &in_june(1, 0.02)).await;
    assert_eq!((&unasked["compared"]["state"], &unasked["compared"]["verdict"]), (&json!("outside"), &Value::Null));
    alert_is(&lab, None).await;

    adopts(&lab, &model(&[&first]).into_model(&temperature_g())).await;
    let clean = measured(&lab, &in_june(2, 0.0)).await;
    let verdict = &clean["compared"]["verdict"];
    assert_eq!(verdict["state"], "within", "{verdict}");
    assert!(verdict["smallest_step"].as_f64().unwrap() < 0.01, "{verdict}");
    alert_is(&lab, None).await;

    let moved = measured(&lab, &in_june(3, 0.02)).await;
    let verdict = &moved["compared"]["verdict"];
    assert_eq!((&verdict["state"], &verdict["slot"]), (&json!("exceeded"), &json!("G2")), "{verdict}");
    let alert = alert_is(&lab, Some(["firing", "warning"])).await;
    assert_eq!(
        [&alert["subject"], &alert["imu"], &alert["slot"], &alert["record"], &alert["status"], &alert["unit"]],
        ["imu", "IMU-07", "G2", moved["id"].as_str().unwrap(), "unconfirmed", "standard deviations"]
    );
    assert!(alert["serial"].is_null() && alert["value"].as_f64() > alert["limit"].as_f64(), "{alert}");
    let said = alert["reason"].as_str().unwrap();
    let dwell = format!("Dwell {} is furthest", verdict["dwell"]);
    assert!(said.contains("G2") && said.contains(&dwell) && said.contains("of one campaign"), "{said}");
    let fired = target.has_been_told(1).await[0].json();
    assert_eq!((&fired["type"], &fired["data"]["imu"]), (&json!("alert.fired"), &json!("IMU-07")));
    let id = alert["id"].as_str().unwrap();
    assert_eq!(lab.get("/v1/alerts?imu=IMU-07&rule=forecast").await.ok()["alerts"][0]["id"], alert["id"]);

    // Six kelvin warmer than the model has seen: nothing is known, and nothing changes.
    let warm = document(&campaign(90, 6, NOMINAL_C + 6.0, 1.0));
    let unseen = measured(&lab, &at(warm, "2026-06-04T08:00:00Z")).await;
    let verdict = &unseen["compared"]["verdict"];
    assert_eq!((&verdict["state"], &verdict["unseen"]), (&json!("indeterminate"), &json!("temperature_outside_model")));
    alert_is(&lab, Some(["firing", "warning"])).await;

    // The next that says anything confirms it.
    let fifth = measured(&lab, &in_june(5, 0.02)).await;
    let confirmed = alert_is(&lab, Some(["firing", "critical"])).await;
    assert_eq!(confirmed["status"], "confirmed");
    assert!(confirmed["reason"].as_str().unwrap().contains("second campaign"), "{confirmed}");

    // What confirmed it counts no more; then what raised it.
    let void = json!({"author": "Li Wei", "reason": "the table was not level"});
    let voids = async |campaign: &Value| {
        let path = format!("/v1/records/{}/void", campaign["id"].as_str().unwrap());
        lab.post(&path, &void).await.ok();
    };
    voids(&fifth).await;
    alert_is(&lab, Some(["firing", "warning"])).await;
    voids(&moved).await;
    alert_is(&lab, Some(["resolved", "warning"])).await;
    let steps = lab.get(&format!("/v1/alerts/{id}")).await.ok()["history"].to_string();
    assert!(steps.contains("Li Wei") && steps.contains("lower"), "{steps}");

    // It comes again, and goes by itself: by one campaign far within, or by the second within.
    measured(&lab, &in_june(7, 0.02)).await;
    alert_is(&lab, Some(["firing", "warning"])).await;
    measured(&lab, &in_june(8, 0.0)).await;
    measured(&lab, &in_june(9, 0.0)).await;
    alert_is(&lab, Some(["resolved", "warning"])).await;

    // Another model comes into force: what the one before had foretold is over, and stays so.
    measured(&lab, &in_june(10, 0.02)).await;
    alert_is(&lab, Some(["firing", "warning"])).await;
    let plain = json!({"terms": [], "effects": [], "author": "M. Adopter", "reason": "G2 is another now"});
    lab.post("/v1/imus/IMU-07/model", &plain).await.created();
    alert_is(&lab, Some(["resolved", "warning"])).await;
    let steps = lab.get(&format!("/v1/alerts/{id}")).await.ok()["history"].to_string();
    assert!(steps.contains("G2 is another now"), "{steps}");
    assert_eq!(measured(&lab, &in_june(11, 0.04)).await["compared"]["verdict"], Value::Null);
    alert_is(&lab, Some(["resolved", "warning"])).await;
    let verified = lab.verified().await;
    assert!(verified.faults.is_empty(), "{:?}", verified.faults);
}

#[tokio::test]
async fn an_old_campaign_outside_its_forecast_is_told_to_nobody_and_a_rule_that_is_off_judges_nothing() {
    let lab = Lab::with(|config| config.alerts.backfill_days = 30.0).await;
    let target = Receiver::start().await;
    lab.tells(&target, json!({"filter": {"rules": ["forecast"]}})).await;
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    measured(&lab, &document(&first)).await;
    adopts(&lab, &model(&[&first]).into_model(&temperature_g())).await;
    // The clock of the laboratory stands in November.
    measured(&lab, &in_june(3, 0.02)).await;
    let alert = alert_is(&lab, Some(["firing", "warning"])).await;
    let steps = lab.get(&format!("/v1/alerts/{}", alert["id"].as_str().unwrap())).await.ok()["history"].clone();
    assert!(steps.as_array().unwrap().iter().all(|step| step["told"] == false), "{steps}");
    let mut recent = in_june(4, 0.02);
    recent["measured_at"] = "2026-11-20T08:00:00Z".into();
    measured(&lab, &recent).await;
    let told = target.has_been_told(1).await[0].json();
    assert_eq!((&told["type"], &told["data"]["severity"]), (&json!("alert.fired"), &json!("critical")));
    // A campaign of between is history: the newest has decided.
    measured(&lab, &in_june(20, 0.0)).await;
    tokio::time::sleep(Duration::from_millis(200)).await;
    alert_is(&lab, Some(["firing", "critical"])).await;

    let off = Lab::with(|config| config.judging.rules.off = serde_json::from_value(json!(["forecast"])).unwrap()).await;
    measured(&off, &document(&first)).await;
    adopts(&off, &model(&[&first]).into_model(&temperature_g())).await;
    let moved = measured(&off, &in_june(3, 0.02)).await;
    assert_eq!((&moved["compared"]["state"], &moved["compared"]["verdict"]), (&json!("outside"), &Value::Null));
    alert_is(&off, None).await;
}

/// As a person sees it, on the clock of this machine.
#[tokio::test]
async fn pages_show_the_alert_of_an_imu_with_the_gyro_and_the_dwell() {
    let server = Server::start().await;
    let first = campaign(1, 1, NOMINAL_C, 1.0);
    server.post_json("/v1/campaigns", &document(&first)).await.created();
    let body = adoption(&model(&[&first]).into_model(&temperature_g()));
    server.post_json("/v1/imus/IMU-07/model", &body).await.created();
    server.post_json("/v1/campaigns", &in_june(3, 0.02)).await.created();
    let look = async || server.get("/v1/alerts?rule=forecast").await.json()["alerts"][0].clone();
    let alert = once(look, |alert| !alert.is_null()).await;
    let (id, record) = (alert["id"].as_str().unwrap(), alert["record"].as_str().unwrap());
    let forecast = format!("/campaigns/{record}/diagnosis");
    for (page, shows) in [
        ("/alerts".to_owned(), ["href=\"/imus/IMU-07\"", &*format!("{forecast}#forecast")]),
        (format!("/alerts/{id}"), ["IMU-07", "is furthest"]),
        ("/imus/IMU-07".to_owned(), ["is furthest", "outside its forecast"]),
        (forecast.clone(), ["G2 is furthest from the forecast of the adopted model", "is furthest"]),
    ] {
        let text = server.get(&page).await.text();
        assert!(shows.iter().all(|shown| text.contains(shown)), "{page}: {text}");
    }
}
