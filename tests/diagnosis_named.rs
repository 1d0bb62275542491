//! What a diagnosis says of campaigns whose truth is known: names, gyros, class, closure and floor. The campaigns of
//! the simulator are few here; `gyrowatch blindcheck` has the figures.

use gyrowatch::blindcheck::draw::{Case, Draw, Trial};
use gyrowatch::core::augmented::Options;
use gyrowatch::core::diagnose::{Diagnosis, Verdict, diagnose};
use gyrowatch::core::effects::Effect;
use gyrowatch::core::mounting::Slot;
use gyrowatch::simulate::presets::preset;
use gyrowatch::simulate::scenario::{EffectChoice, Profile, Scenario};
use gyrowatch::simulate::simulate;
use gyrowatch::wire::campaign::{parse_json, terms_from_names, to_json};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::prelude::*;

fn drawn(case: Case, count: usize) -> Vec<(Trial, Diagnosis)> {
    let draw = Draw { seed: 20_261, cases: vec![case], effects: vec![], detectability: vec![12.0] };
    let diagnosed = |trial: Trial| {
        let found = diagnose(&trial.simulated.campaign, &Options::default()).expect("drawn campaigns can be diagnosed");
        (trial, found)
    };
    (0..count).map(|number| diagnosed(draw.trial(number))).collect()
}

fn names(diagnosis: &Diagnosis) -> BTreeSet<&'static str> {
    diagnosis.effects.iter().map(|named| named.effect.id()).collect()
}

fn means(diagnosis: &Diagnosis, id: &str) -> bool {
    diagnosis.effects.iter().any(|named| named.class.iter().any(|effect| effect.id() == id))
}

fn practice(name: &str) -> Value {
    document(&format!("practice/{name}"))
}

fn diagnosed(campaign: &Value) -> Diagnosis {
    let campaign = parse_json(campaign.to_string().as_bytes()).unwrap();
    diagnose(&campaign, &Options::default()).unwrap()
}

/// By itself each gyro would rather have an entry of its own, `scale_quadratic` and `scale_asymmetry`.
#[test]
fn a_cause_that_two_entries_explain_alike_has_one_name_in_all_its_gyros() {
    let answer = diagnosed(&document("one-name-for-both.json"));
    assert_eq!(names(&answer), BTreeSet::from(["scale_asymmetry"]));
    assert_eq!(answer.effects[0].gyros, [Slot::G1, Slot::G2]);
    assert_eq!(answer.verdict, Verdict::Explained);
}

/// A strong effect is explained by what is alike in dwells of one face as well, and that ends later.
#[test]
fn a_term_that_the_model_leaves_out_is_named_where_there_are_six_faces() {
    let terms = terms_from_names(&["bias", "g_squared", "scale"]).unwrap();
    for seed in 51..55 {
        let campaign = simulate(&Scenario { seed, ..preset("24-position").unwrap() }).unwrap().campaign;
        let answer = diagnose(&campaign, &Options { terms: Some(terms), ..Options::default() }).unwrap();
        assert_eq!((names(&answer), answer.verdict), (BTreeSet::from(["g_linear"]), Verdict::Explained), "{seed}");
    }
}

#[test]
fn every_practice_campaign_is_answered_as_its_key_says() {
    let key = practice("key.json");
    for (name, entry) in key.as_object().unwrap() {
        let answer = diagnosed(&practice(name));
        let hidden: BTreeSet<&str> = entry["effects"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        if hidden.iter().any(|id| id.contains(' ')) {
            assert!(matches!(answer.verdict, Verdict::Unexplained | Verdict::PartlyExplained), "{name}");
            continue;
        }
        // One of them hides an effect that its design cannot see.
        let seen = entry["seen"].as_f64().unwrap() > 1.0;
        let expected = if seen { hidden.clone() } else { BTreeSet::new() };
        assert_eq!(names(&answer), expected, "{name}");
        assert_eq!(answer.verdict, if expected.is_empty() { Verdict::NoGap } else { Verdict::Explained }, "{name}");
        let listed = |id: &&str| answer.not_identifiable.iter().any(|entry| entry.effect.id() == *id);
        assert!(seen || hidden.iter().all(listed), "{name}");
        // Of two effects each closes its part, both together the whole.
        if let Some(all) = answer.closure {
            assert!(all.closure > 0.8 && all.interval[1] > 0.95, "{name}: {all:?}");
        }
        for named in &answer.effects {
            assert!(named.held_out.after_deg_per_h < named.held_out.before_deg_per_h, "{name}");
            assert!(named.p_value_adjusted < 1e-4, "{name}");
        }
    }
}

#[test]
fn temperatures_that_hardly_change_leave_their_effects_unseen() {
    for (span, blind) in [(1e-6, 3), (1e-3, 2), (20.0, 0)] {
        let mut campaign = practice("campaign-00.json");
        for (k, dwell) in campaign["dwells"].as_array_mut().unwrap().iter_mut().enumerate() {
            dwell["temperature_c"] = json!(45.0 + 0.5 * span * (7.3 * k as f64).sin());
        }
        let answer = diagnosed(&campaign);
        let listed = answer.not_identifiable.iter().filter(|entry| entry.reason.code == "temperature_too_steady");
        let unseen: Vec<&str> = listed.map(|entry| entry.effect.id()).collect();
        // At 7,200 arcsec/s a scale factor of 0.1 % a kelvin would still show.
        let all = ["temperature_bias", "temperature_g", "temperature_scale"];
        assert_eq!(unseen, all[..blind], "{span} K");
    }
}

#[test]
fn noise_alone_gets_no_name_and_no_gap() {
    let answers = drawn(Case::Clean, 24);
    let named: Vec<usize> = answers.iter().filter(|(_, d)| !d.effects.is_empty()).map(|(t, _)| t.number).collect();
    assert!(named.len() <= 1, "campaigns {named:?}");
    assert!(answers.iter().filter(|(_, d)| d.verdict == Verdict::NoGap).count() >= 22);
}

#[test]
fn what_stands_out_is_named_in_its_gyros_and_closes_what_it_made() {
    let answers = drawn(Case::One, 16);
    let found = |(trial, d): &&(Trial, Diagnosis)| means(d, &trial.simulated.truth.effects[0]);
    assert!(answers.iter().filter(found).count() >= 15);
    for (trial, answer) in answers.iter().filter(found) {
        let own = &trial.simulated.truth.seen_by[0];
        let gyros: BTreeSet<&str> = answer.effects[0].gyros.iter().map(|slot| slot.name()).collect();
        for (slot, d) in own {
            assert!(*d < 6.0 || gyros.contains(slot.as_str()), "{}: {slot} {own:?}", trial.number);
        }
        assert!(answer.effects[0].held_out.interval[1] > 0.9, "{}", trial.number);
    }
}

#[test]
fn of_two_causes_both_are_named_and_nothing_beside_them() {
    let answers = drawn(Case::Pair, 10);
    let both = |(trial, d): &&(Trial, Diagnosis)| trial.simulated.truth.effects.iter().all(|id| means(d, id));
    assert!(answers.iter().filter(both).count() >= 9);
    assert!(answers.iter().filter(|(_, d)| d.effects.len() <= 2).count() >= 9);
    for (trial, answer) in &answers {
        assert_eq!(names(answer).len(), answer.effects.len(), "{}: one name twice", trial.number);
    }
}

#[test]
fn however_strong_an_effect_is_it_alone_is_named_and_closes_the_gap() {
    for d in [60.0, 400.0] {
        let draw = Draw { seed: 5_117, cases: vec![Case::One], effects: vec![], detectability: vec![d] };
        let answers: Vec<(Trial, Diagnosis)> = (0..12)
            .map(|number| {
                let trial = draw.trial(number);
                let found = diagnose(&trial.simulated.campaign, &Options::default()).expect("can be diagnosed");
                (trial, found)
            })
            .collect();
        let alone = |(trial, answer): &&(Trial, Diagnosis)| {
            answer.effects.len() == 1 && means(answer, &trial.simulated.truth.effects[0])
        };
        let found: Vec<_> = answers.iter().filter(alone).collect();
        assert!(found.len() >= 11, "{} of 12 at d = {d}", found.len());
        let explained = found.iter().filter(|(_, answer)| answer.verdict == Verdict::Explained).count();
        assert!(explained >= 10, "{explained} of 12 at d = {d}");
        for (trial, answer) in found {
            assert!(answer.effects[0].held_out.closure > 0.9, "{} at d = {d}", trial.number);
        }
    }
}

#[test]
fn standard_errors_that_repeats_show_to_be_too_small_are_told_and_get_no_name() {
    let mut scenario = Scenario { seed: 9, ..Scenario::default() };
    scenario.programme.repeats = 40;
    let mut campaign = simulate(&scenario).unwrap().campaign;
    let told = |answer: &Diagnosis| {
        answer.notes.iter().any(|note| {
            let times = note.parameter("times").map(ToString::to_string);
            note.code == "standard_errors_understated" && times.is_some_and(|times| times.starts_with("1."))
        })
    };
    let answer = diagnose(&campaign, &Options::default()).unwrap();
    assert!(answer.verdict == Verdict::NoGap && !told(&answer), "{:?}", answer.notes);
    for sem in campaign.dwells.iter_mut().flat_map(|dwell| dwell.output_sem_pulse_s.iter_mut().flatten()) {
        *sem /= 1.5;
    }
    let answer = diagnose(&campaign, &Options::default()).unwrap();
    assert!(answer.verdict == Verdict::NoGap && told(&answer), "{:?} {:?}", answer.remaining, answer.notes);
}

#[test]
fn standard_errors_that_some_dwells_lack_are_no_gap_and_are_noted() {
    let mut campaign = practice("campaign-00.json");
    for dwell in campaign["dwells"].as_array_mut().unwrap().iter_mut().step_by(3) {
        dwell.as_object_mut().unwrap().remove("output_sem_pulse_s");
    }
    let answer = diagnosed(&campaign);
    assert_eq!(answer.verdict, Verdict::NoGap);
    assert!(answer.of_campaign.iter().any(|note| note.code() == "standard_errors_missing"), "{:?}", answer.of_campaign);
}

#[test]
fn half_of_what_is_hardly_there_is_named_all_the_same() {
    let answers = drawn(Case::Faint, 16);
    let found = answers.iter().filter(|(trial, d)| means(d, &trial.simulated.truth.effects[0])).count();
    assert!(found >= 8, "{found} of 16");
}

#[test]
fn a_temperature_that_follows_time_makes_one_class_of_both() {
    let mut scenario = Scenario { seed: 5, ..Scenario::default() };
    scenario.temperature.profile = Profile::Ramp;
    scenario.temperature.size_k = 1.5;
    scenario.effects = vec![EffectChoice::detectable("time_ramp", 10.0)];
    let mut campaign = simulate(&scenario).unwrap().campaign;
    let first = campaign.dwells[0].start_s;
    for dwell in &mut campaign.dwells {
        dwell.temperature_c = Some(45.0 + 1e-5 * (dwell.start_s - first));
    }
    let answer = diagnose(&campaign, &Options::default()).unwrap();
    assert_eq!(answer.effects.len(), 1);
    let class = &answer.effects[0].class;
    assert!(class.contains(&Effect::TimeRamp) && class.contains(&Effect::TemperatureBias), "{class:?}");
    assert!(!class.contains(&Effect::ScaleCubic), "{class:?}");
}

#[test]
fn repeats_put_right_standard_errors_that_are_stated_too_small() {
    let told = diagnosed(&practice("campaign-00.json"));
    let mut campaign = practice("campaign-00.json");
    for dwell in campaign["dwells"].as_array_mut().unwrap() {
        for sem in dwell["output_sem_pulse_s"].as_array_mut().unwrap() {
            *sem = (0.75 * sem.as_f64().unwrap()).into();
        }
    }
    let wrong = diagnosed(&campaign);
    assert!(wrong.effects.is_empty() && wrong.verdict == Verdict::NoGap, "{:?}", wrong.remaining);
    assert!(wrong.noise_floor.sem_factor > 1.15 * told.noise_floor.sem_factor, "{:?}", wrong.noise_floor);
    let ratio = wrong.noise_floor.deg_per_h / told.noise_floor.deg_per_h;
    // As stated it would be 0.75.
    assert!((0.82..1.05).contains(&ratio), "{ratio}");
}

#[test]
fn when_a_step_happened_is_as_unsure_as_its_standard_deviation_says() {
    let over = |number: u64| -> Option<f64> {
        let first = 20 + number as usize;
        let step = EffectChoice { dwell: Some(first), ..EffectChoice::detectable("bias_step", 9.0) };
        let scenario = Scenario { seed: 700 + number, effects: vec![step], ..Scenario::default() };
        let campaign = simulate(&scenario).unwrap().campaign;
        let answer = diagnose(&campaign, &Options::default()).unwrap();
        let named = answer.effects.into_iter().find(|named| named.effect == Effect::BiasStep)?;
        let instant = named.estimates.iter().find(|estimate| estimate.name == "instant").unwrap();
        let [before, after] = [first - 1, first].map(|k| campaign.dwells[k].mid_s());
        Some((instant.value - instant.value.clamp(before, after)).abs() / instant.sd)
    };
    let all: Vec<f64> = (0..24).filter_map(over).collect();
    let mean_square = all.iter().map(|over| over * over).sum::<f64>() / all.len() as f64;
    let beyond = all.iter().filter(|over| **over > 2.0).count();
    // Half an interval between dwells, which it was said to be, left most of them beyond two deviations.
    assert!(all.len() >= 10 && beyond <= 1 && (0.05..1.5).contains(&mean_square), "{all:?}");
}

/// 0.35 of the campaign: its neighbours on the grid of periods leave of it what passed for a second cause.
#[test]
fn a_period_between_those_of_the_grid_is_named_alone() {
    let named = |seed: u64| {
        let cycle = EffectChoice {
            gyros: Some(vec!["G2".into()]),
            time_h: Some(4.2),
            ..EffectChoice::detectable("periodic", 26.0)
        };
        let scenario = Scenario { seed, effects: vec![cycle], ..Scenario::default() };
        let answer = diagnose(&simulate(&scenario).unwrap().campaign, &Options::default()).unwrap();
        let period = answer.effects.first()?.estimates.iter().find(|one| one.name == "period")?.clone();
        let is_near = (period.value - 4.2 * 3600.0).abs() < 4.0 * period.sd;
        (names(&answer) == BTreeSet::from(["periodic"]) && is_near).then_some(answer.verdict)
    };
    let found: Vec<Verdict> = (1..9).filter_map(named).collect();
    let explained = found.iter().filter(|verdict| **verdict == Verdict::Explained).count();
    assert!(found.len() == 8 && explained >= 6, "{found:?}");
}

/// The default scenario without a cause, as the file of a station that commands something else than it does.
fn commanded_wrongly(seed: u64, wrong: impl Fn(&mut Value)) -> Diagnosis {
    let scenario = Scenario { seed, ..Scenario::default() };
    let mut campaign: Value = serde_json::from_str(&to_json(&simulate(&scenario).unwrap().campaign)).unwrap();
    campaign["dwells"].as_array_mut().unwrap().iter_mut().filter(|dwell| dwell["phase"] == "rate").for_each(wrong);
    diagnosed(&campaign)
}

fn vector(of: &Value) -> Vector3<f64> {
    Vector3::from_iterator(of.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()))
}

fn signs(diagnosis: &Diagnosis) -> Vec<&'static str> {
    diagnosis.remaining.signs.iter().map(|sign| sign.kind).collect()
}

#[test]
fn a_table_that_is_wrong_in_one_sense_and_an_imu_off_its_axis_pass_for_no_effect_of_the_catalogue() {
    for seed in [41, 42, 43] {
        let faster = commanded_wrongly(seed, |dwell| {
            let (rate, up) = (vector(&dwell["rate_arcsec_s"]), vector(&dwell["specific_force_g0"]));
            if rate.dot(&up) > 0.0 {
                dwell["rate_arcsec_s"] = json!((rate * (1.0 - 4e-6)).as_slice());
            }
        });
        assert_eq!((names(&faster), signs(&faster)), (BTreeSet::new(), vec!["table_rate"]), "seed {seed}");
        // The rates are low, so the arm is long: w x (w x r) of 0.01 m/s2.
        let off_axis = commanded_wrongly(seed, |dwell| {
            let w = vector(&dwell["rate_arcsec_s"]) * (std::f64::consts::PI / 648_000.0);
            let outwards = w.cross(&w.cross(&Vector3::new(9.0, -6.0, 7.0))) / 9.806_65;
            dwell["specific_force_g0"] = json!((vector(&dwell["specific_force_g0"]) - outwards).as_slice());
        });
        assert_eq!((names(&off_axis), signs(&off_axis)), (BTreeSet::new(), vec!["lever_arm"]), "seed {seed}");
    }
}

#[test]
fn several_bad_dwells_are_one_sign_that_says_which() {
    let mut campaign: Value =
        serde_json::from_str(&to_json(&simulate(&Scenario { seed: 77, ..Scenario::default() }).unwrap().campaign))
            .unwrap();
    for (dwell, gyro, off) in [(7, 0, 0.02), (21, 0, -0.03), (33, 1, 0.02)] {
        let output = &mut campaign["dwells"][dwell]["output_pulse_s"][gyro];
        *output = (output.as_f64().unwrap() + off).into();
    }
    let answer = diagnosed(&campaign);
    assert_eq!((answer.verdict, signs(&answer)), (Verdict::Unexplained, vec!["several_bad_dwells"]));
    assert_eq!(answer.remaining.signs[0].dwells, [7, 21, 33]);
    assert_eq!(answer.remaining.signs[0].slots, [Slot::G1, Slot::G2]);
}

#[test]
fn what_a_campaign_does_not_show_of_an_effect_is_no_estimate() {
    let draw = Draw {
        seed: 20_262,
        cases: vec![Case::One],
        effects: vec!["relevelling".into(), "reseating".into()],
        detectability: vec![20.0],
    };
    for number in 0..12 {
        let found = diagnose(&draw.trial(number).simulated.campaign, &Options::default()).unwrap();
        for one in found.effects.iter().flat_map(|effect| &effect.estimates) {
            assert!(one.name == "instant" || one.sd > 0.0 && one.sd < 0.2, "{number}: {one:?}");
        }
    }
}

/// Standard errors of four samples each scatter by a third about noise that is the same throughout.
#[test]
fn standard_errors_of_a_few_samples_make_no_gap() {
    let scattered = |seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let scenario = Scenario { seed, ..Scenario::default() };
        let mut campaign: Value = serde_json::from_str(&to_json(&simulate(&scenario).unwrap().campaign)).unwrap();
        let mut of_four = || {
            let chi_square: f64 = (0..4).map(|_| Distribution::<f64>::sample(&StandardNormal, &mut rng).powi(2)).sum();
            (chi_square / 4.0).sqrt()
        };
        for dwell in campaign["dwells"].as_array_mut().unwrap() {
            for sem in dwell["output_sem_pulse_s"].as_array_mut().unwrap() {
                *sem = (sem.as_f64().unwrap() * of_four()).into();
            }
        }
        diagnosed(&campaign).verdict
    };
    let gaps = (0..20).filter(|seed| scattered(3_000 + seed) != Verdict::NoGap).count();
    assert!(gaps <= 2, "{gaps} of 20");
}

#[test]
fn rounded_commands_are_said_where_rounding_shows() {
    let rounded = |places: i32| {
        let scenario = Scenario { seed: 5, ..preset("60-position").unwrap() };
        let mut campaign: Value = serde_json::from_str(&to_json(&simulate(&scenario).unwrap().campaign)).unwrap();
        for dwell in campaign["dwells"].as_array_mut().unwrap() {
            for x in dwell["specific_force_g0"].as_array_mut().unwrap() {
                let scale = 10_f64.powi(places);
                *x = ((x.as_f64().unwrap() * scale).round() / scale).into();
            }
        }
        let said = diagnosed(&campaign).notes;
        said.iter().any(|note| note.code == "commands_rounded")
    };
    assert!(rounded(3) && !rounded(6));
}

/// Nothing is hidden in either: `cubic_g` and `g_rate_coupling` were named of what rounding makes.
#[test]
fn rates_in_coarse_steps_are_no_gap_where_the_site_tells_what_they_were() {
    for name in ["rates-in-hundredths.json", "rates-in-tenths.json"] {
        let answer = diagnosed(&document(name));
        assert_eq!((answer.verdict, names(&answer)), (Verdict::NoGap, BTreeSet::new()), "{name}");
        assert!(answer.notes.iter().any(|note| note.code == "commands_rounded"), "{name}");
    }
}

#[test]
fn no_name_is_explained_that_rounding_may_have_made() {
    let nowhere = |name: &str| {
        let mut campaign = document(name);
        campaign.as_object_mut().unwrap().remove("site");
        diagnosed(&campaign)
    };
    let hundredths = nowhere("rates-in-hundredths.json");
    assert_eq!(names(&hundredths), BTreeSet::from(["cubic_g"]));
    assert_eq!(hundredths.verdict, Verdict::PartlyExplained);
    assert!(hundredths.remaining.signs.iter().any(|sign| sign.kind == "commands_rounded"));
    let tenths = nowhere("rates-in-tenths.json");
    assert!(tenths.notes.iter().any(|note| note.code == "commands_rounded"));
    let listed = |effect| tenths.not_identifiable.iter().any(|one| one.effect == effect);
    assert!(tenths.effects.iter().all(|named| !listed(named.effect)), "what cannot be shown is no name");
    assert_ne!(tenths.verdict, Verdict::Explained);
}
