//! The blind check itself: campaigns are sound, the seal holds, and the score tells truth-tellers from liars.

use gyrowatch::blindcheck::answer::{Answer, AnsweredEffect, AnsweredHeldOut, AnsweredShift, Unseen};
use gyrowatch::blindcheck::draw::{Case, Draw, Trial};
use gyrowatch::blindcheck::report::{Rate, Report};
use gyrowatch::blindcheck::run::{Foreign, case_of, drawn, file_name, foreign, key, key_text};
use gyrowatch::blindcheck::score::Score;
use gyrowatch::blindcheck::seal;
use gyrowatch::core::model::Terms;
use gyrowatch::simulate::cause::CATALOGUE;
use gyrowatch::simulate::detectability::Sight;
use gyrowatch::simulate::truth::Key;
use gyrowatch::wire::campaign::{parse_json, to_json};
use nalgebra::Vector3;

use crate::prelude::*;

const COUNT: usize = 240;

fn draw(seed: u64) -> Draw {
    Draw { seed, cases: vec![], effects: vec![], detectability: vec![8.0, 15.0] }
}

fn only(case: Case) -> Draw {
    Draw { cases: vec![case], ..draw(5) }
}

fn silent() -> Answer {
    let (effects, description) = (vec![], vec![]);
    let (not_identifiable, impact, impact_within_noise) = (vec![], vec![], vec![]);
    let (verdict, closure, noise) = ("no_gap".into(), None, None);
    Answer { verdict, effects, closure, noise, description, not_identifiable, impact, impact_within_noise }
}

fn named(effect: &str, gyros: Vec<String>) -> AnsweredEffect {
    let held_out = Some(AnsweredHeldOut { closure: Some(0.97), interval: Some([0.9, 1.0]) });
    AnsweredEffect { effect: effect.into(), class: vec![effect.into()], gyros, held_out, acts_in: None }
}

/// The trial that a campaign's text is of: its IMU is numbered.
fn trial_of(text: &str, draw: &Draw) -> Trial {
    let campaign = parse_json(text.as_bytes()).unwrap();
    draw.trial(campaign.imu.as_str().trim_start_matches("IMU-").parse().unwrap())
}

/// Says what is true, as far as anybody could know it.
fn oracle(text: &str, draw: &Draw) -> Answer {
    let trial = trial_of(text, draw);
    let (truth, world) = (&trial.simulated.truth, &trial.simulated.world);
    let slots = || world.gyros.iter().map(|gyro| gyro.slot.name().to_owned()).collect::<Vec<_>>();
    let mut answer = silent();
    let plain = |slot: &String, coefficient: &str, true_value: f64| AnsweredShift {
        slot: slot.clone(),
        coefficient: coefficient.into(),
        shift: -0.02,
        plain: Some(true_value + 0.021),
    };
    for (slot, gyro) in slots().iter().zip(&truth.truth) {
        answer.impact.extend([plain(slot, "D_I", gyro.d_i), plain(slot, "D_S", gyro.d_s)]);
    }
    match trial.case {
        Case::Clean => {}
        Case::Outside => answer.verdict = "unexplained".into(),
        Case::Unseen => {
            answer.not_identifiable = truth.effects.iter().map(|id| Unseen { effect: id.clone() }).collect();
        }
        Case::Withheld => {
            let left_out = gyrowatch::core::model::Term::ALL.into_iter().find(|t| !world.terms.contains(*t)).unwrap();
            let gyros = if truth.gyros.is_empty() { slots() } else { truth.gyros.clone() };
            answer.effects.push(named(left_out.name(), gyros));
        }
        Case::One | Case::Faint | Case::Pair => {
            let gyros =
                |i: usize| truth.seen_by[i].iter().filter(|(_, d)| **d > 1e-3).map(|(s, _)| s.clone()).collect();
            answer.effects = truth.effects.iter().enumerate().map(|(i, id)| named(id, gyros(i))).collect();
            // Of two effects each closes a part that nobody but the scorer knows.
            if truth.effects.len() == 2 {
                answer.effects.iter_mut().for_each(|named| named.held_out = None);
            }
        }
    }
    if !answer.effects.is_empty() {
        answer.verdict = "explained".into();
    }
    answer
}

fn scored(draw: &Draw, count: usize, diagnose: impl Fn(&str) -> Answer + Sync) -> Report {
    let scores = drawn(draw, count, &|text| Ok(diagnose(text)), &|| ());
    Report::of("", scores)
}

fn row<'a>(report: &'a Report, what: &str) -> &'a Rate {
    report.rows.iter().find(|row| row.what.starts_with(what)).unwrap_or_else(|| panic!("no row {what}"))
}

#[test]
fn every_drawn_campaign_is_a_file_that_a_station_could_send() {
    let (mut cases, mut designs, mut hidden, mut gyros) =
        (BTreeSet::new(), BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for number in 0..COUNT {
        let trial = draw(1).trial(number);
        let text = to_json(&trial.simulated.campaign);
        let read = parse_json(text.as_bytes()).unwrap_or_else(|faults| panic!("{number}: {faults}"));
        assert_eq!(read.dwells.len(), trial.simulated.campaign.dwells.len());
        // A withheld term is named by the model that lacks it, nothing else by anything.
        let told = |id: &&String| !id.starts_with("g_") && text.contains(&format!("\"{id}\""));
        assert_eq!(trial.simulated.truth.effects.iter().find(told), None);
        cases.insert(trial.case);
        designs.insert(trial.simulated.truth.design.clone());
        gyros.insert(read.gyros.len());
        hidden.extend(trial.simulated.truth.effects.clone());
    }
    assert_eq!(cases.len(), Case::ALL.len());
    assert_eq!(designs.into_iter().collect::<Vec<_>>(), ["24", "36", "60"]);
    assert_eq!(gyros.into_iter().collect::<Vec<_>>(), [1, 2, 3]);
    let never: Vec<_> = CATALOGUE.iter().filter(|known| !hidden.contains(known.id)).collect();
    assert!(never.is_empty(), "{never:?}");
}

#[test]
fn the_key_is_sealed_by_what_it_says() {
    let text = key_text(&key(&draw(1), 12));
    assert_eq!(seal(&text), seal(&key_text(&key(&draw(1), 12))));
    assert_ne!(seal(&text), seal(&key_text(&key(&draw(2), 12))));
    // FIPS 180-4's own example.
    assert_eq!(seal("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

#[test]
fn whoever_tells_the_truth_reaches_every_figure() {
    let report = scored(&draw(3), COUNT, |text| oracle(text, &draw(3)));
    for row in &report.rows {
        assert_ne!(row.reached, Some(false), "{row:?}");
    }
    assert!(report.reached());
    assert_eq!(row(&report, "  its class").rate, Some(1.0));
}

#[test]
fn whoever_says_nothing_raises_no_alarm_and_finds_nothing() {
    let report = scored(&draw(3), COUNT, |_| silent());
    for (what, rate) in [
        ("one effect, d >= 8: named", 0.0),
        ("one effect, d = 5", 0.0),
        ("clean", 0.0),
        ("two effects", 0.0),
        ("outside", 0.0),
        ("unseen", 0.0),
        ("a term withheld", 0.0),
    ] {
        assert_eq!(row(&report, what).rate, Some(rate), "{what}");
    }
    assert!(!report.reached());
}

#[test]
fn whoever_always_blames_the_same_is_found_out() {
    let blame = |_: &str| Answer {
        verdict: "explained".into(),
        effects: vec![named("time_ramp", vec!["G1".into(), "G2".into(), "G3".into()])],
        ..silent()
    };
    let report = scored(&draw(3), COUNT, blame);
    assert_eq!(row(&report, "clean").rate, Some(1.0));
    assert_eq!(row(&report, "clean").reached, Some(false));
    assert_eq!(row(&report, "outside").rate, Some(0.0));
    assert!(row(&report, "one effect, d >= 8: named").rate.unwrap() < 0.2);
    assert!(report.by_effect["time_ramp"].rate() == Some(1.0));
    assert!(row(&report, "  and nothing else named").rate.unwrap() < 0.2);
}

#[test]
fn a_class_of_everything_is_a_wrong_answer() {
    let draw = Draw { cases: vec![Case::One], ..draw(4) };
    let report = scored(&draw, 40, |text| {
        let mut answer = oracle(text, &draw);
        answer.effects[0].class = CATALOGUE.iter().map(|known| known.id.to_owned()).collect();
        answer
    });
    assert_eq!(row(&report, "one effect, d >= 8: named").rate, Some(1.0));
    assert_eq!(row(&report, "  its class").rate, Some(0.0));
}

#[test]
fn a_gyro_too_few_or_too_many_is_counted() {
    let draw = Draw { effects: vec!["time_ramp".into()], ..only(Case::One) };
    let with = |change: fn(&mut AnsweredEffect)| {
        let report = scored(&draw, 60, |text| {
            let mut answer = oracle(text, &draw);
            change(&mut answer.effects[0]);
            answer
        });
        row(&report, "  and its gyros right").rate.unwrap()
    };
    assert_eq!(with(|_| ()), 1.0);
    assert!(with(|named| named.gyros = vec!["G1".into(), "G2".into(), "G3".into()]) < 0.6);
    assert_eq!(with(|named| named.gyros.clear()), 0.0);
}

#[test]
fn a_closure_beside_the_truth_is_not_covered() {
    let draw = only(Case::One);
    let covered = |interval: [f64; 2]| {
        let report = scored(&draw, 30, |text| {
            let mut answer = oracle(text, &draw);
            answer.effects[0].held_out = Some(AnsweredHeldOut { closure: Some(0.5), interval: Some(interval) });
            answer
        });
        row(&report, "closure").rate.unwrap()
    };
    assert_eq!(covered([0.4, 0.6]), 0.0);
    assert_eq!(covered([0.4, 1.0]), 1.0);
}

#[test]
fn campaigns_of_another_maker_are_scored_by_their_key() {
    let draw = draw(8);
    let make = |number| {
        let trial = draw.trial(number);
        let mut key = trial.simulated.truth.clone();
        // A key of the least: no family, no detectability by gyro.
        (key.family, key.seed) = (None, None);
        key.seen_by.clear();
        Foreign { name: file_name(number), text: to_json(&trial.simulated.campaign), key }
    };
    let with_hidden = |number: &usize| !matches!(draw.trial(*number).case, Case::Withheld);
    let campaigns: Vec<Foreign> = (0..60).filter(with_hidden).map(make).collect();
    let scores = foreign(&campaigns, &|text| Ok(oracle(text, &draw)), &|| ()).unwrap();
    for (score, campaign) in scores.iter().zip(&campaigns) {
        assert_eq!(score.campaign, campaign.name);
        assert_eq!(score.case, trial_of(&campaign.text, &draw).case);
        assert_eq!(score.case, case_of(&campaign.key));
    }
    assert!(
        Report::of("", scores).rows.iter().filter(|row| row.what.contains("named")).all(|r| r.reached != Some(false))
    );
}

#[test]
fn a_diagnosis_that_fails_is_a_miss_and_is_reported() {
    let scores: Vec<Score> = drawn(&only(Case::One), 5, &|_| Err("no".into()), &|| ());
    let report = Report::of("", scores);
    assert_eq!(report.errors.len(), 5);
    assert!(!report.reached());
    assert_eq!(row(&report, "one effect, d >= 8: named").tally.hits, 0);
}

/// The campaigns that `scripts/blind_generator.py` wrote.
fn of_the_second_generator() -> Vec<Foreign> {
    let folder = root().join("tests/data/second-generator");
    let key: Key = serde_json::from_str(&std::fs::read_to_string(folder.join("key.json")).unwrap()).unwrap();
    let read = |name: String| std::fs::read_to_string(folder.join(name)).unwrap();
    key.into_iter().map(|(name, key)| Foreign { text: read(name.clone()), name, key }).collect()
}

#[test]
fn the_second_generator_means_the_same_by_axes_noise_and_detectability() {
    let campaigns = of_the_second_generator();
    assert_eq!(campaigns.len(), 4);
    for one in campaigns {
        let campaign = parse_json(one.text.as_bytes()).unwrap_or_else(|faults| panic!("{}: {faults}", one.name));
        let commanded: Vec<_> = campaign.dwells.iter().map(|d| (d.specific_force_g0, d.rate_arcsec_s)).collect();
        let n = campaign.dwells.len() as f64;
        let (mut power, mut free) = (0.0, 0.0);
        for (j, truth) in one.key.truth.iter().enumerate() {
            let sem: Vec<f64> = campaign.dwells.iter().map(|d| d.output_sem_pulse_s.as_ref().unwrap()[j]).collect();
            let drift = Vector3::from(truth.input) * truth.d_i + Vector3::from(truth.spin) * truth.d_s;
            let unexplained: Vec<f64> = campaign
                .dwells
                .iter()
                .map(|d| {
                    let rate = d.rate_arcsec_s.dot(&Vector3::from(truth.input));
                    d.output_pulse_s[j] - truth.k * (rate + truth.d_f + d.specific_force_g0.dot(&drift))
                })
                .collect();
            let sight = Sight::new(Terms::MODEL_6, &commanded, &sem);
            power += sight.detectability(&unexplained).powi(2);
            free += n - 9.0;
        }
        // Noise gives `free` +- sqrt(2 free), 4 % more where standard errors are noisy, the hidden cause d^2 on top.
        let d2 = one.key.seen.powi(2);
        let excess = power - free - d2;
        let sigma = (2.0 * free + 4.0 * d2).sqrt();
        assert!(excess.abs() < 3.0 * sigma + 0.06 * (free + d2), "{}: {power} of {free} + {d2}", one.name);
    }
}
