//! What real stations do beyond white, independent noise, kind by kind: how often it gets a wrong name.
//!
//! Each kind takes a campaign of the plain draw and changes one thing. *Confident wrong*: something is `explained` and
//! a name is none of what was hidden. *Doubted wrong*: such a name beside something that is said to remain.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

use super::answer::Answer;
use super::draw::{effect_in_some_gyros, is_outside, one_of, seen_by, style};
use super::reach::Structure;
use super::run::{CampaignDiagnoser, timed};
use super::score::{Closure, closures};
use super::tally::Tally;
use crate::core::numerics::median::upper_median_of;
use crate::core::units::radians_from_arcsec;
use crate::simulate::cause::{ALWAYS, FIELD, IN_TIME, NORTH, POWER_UP, SEAT, THROUGHOUT, TILT, TILT_FROM_A_DWELL};
use crate::simulate::outside::{TILTED_FACES, depends_on, in_gyros};
use crate::simulate::programme::DwellOrder;
use crate::simulate::scenario::{EffectChoice, Scenario, StandardErrors};
use crate::simulate::{Simulated, simulate};
use crate::wire;

/// What a kind hides, and so what its names are worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Hidden {
    /// Noise only: every name is wrong.
    Nothing,
    /// What the scenario's effects are called.
    Effects,
    /// Effects of a part of the time: right names, where the answer says that they are not the whole.
    PartOfTheTime,
    /// Causes of no catalogue.
    Outside,
}

pub struct CampaignKind {
    pub name: &'static str,
    hidden: Hidden,
    /// None where the scenario drawn cannot show it.
    put: fn(&mut Scenario, &mut ChaCha8Rng) -> Option<()>,
}

const fn kind(
    name: &'static str,
    hidden: Hidden,
    put: fn(&mut Scenario, &mut ChaCha8Rng) -> Option<()>,
) -> CampaignKind {
    CampaignKind { name, hidden, put }
}

use Hidden::{Effects, Nothing, Outside, PartOfTheTime};

/// d from which on a test can be asked to see what is hidden, or that it acts for a part of the time only.
const VISIBLE: f64 = 5.0;

pub const KINDS: [CampaignKind; 30] = [
    kind("clean", Nothing, |_, _| Some(())),
    kind("shared_noise_0.3", Nothing, |s, _| shared_noise(s, 0.3)),
    kind("shared_noise_0.5", Nothing, |s, _| shared_noise(s, 0.5)),
    kind("shared_noise_0.8", Nothing, |s, _| shared_noise(s, 0.8)),
    kind("shared_noise_0.95", Nothing, |s, _| shared_noise(s, 0.95)),
    kind("unequal_dwells", Nothing, |s, _| {
        (s.programme.dwell_s, s.programme.longest_dwell_s) = (60.0, Some(600.0));
        constant_errors(s)
    }),
    kind("growing_noise", Nothing, |s, _| {
        s.noise.growth = 3.0;
        constant_errors(s)
    }),
    kind("falling_noise", Nothing, |s, _| {
        s.noise.growth = 1.0 / 3.0;
        constant_errors(s)
    }),
    kind("flicker", Nothing, |s, _| flicker(s, 1.0)),
    kind("flicker_2", Nothing, |s, _| flicker(s, 2.0)),
    kind("shared_flicker_2", Nothing, |s, _| {
        s.noise.shared_wander = true;
        flicker(s, 2.0)
    }),
    kind("random_walk", Nothing, |s, _| {
        // Some three standard deviations of a dwell over the campaign of five hours.
        s.noise.rate_random_walk_deg_per_h_sqrt_h = 1.3 * dwell_sd(s);
        stated(s)
    }),
    kind("reseated_20", Effects, |s, rng| reseated(s, 20.0, rng)),
    kind("reseated_60", Effects, |s, rng| reseated(s, 60.0, rng)),
    kind("reseated_300", Effects, |s, rng| reseated(s, 300.0, rng)),
    kind("reseated_unstated", Effects, |s, rng| {
        reseated(s, 20.0, rng)?;
        s.columns.standard_errors = StandardErrors::Absent;
        Some(())
    }),
    kind("reseated_midway", Effects, |s, rng| {
        reseated(s, 60.0, rng)?;
        s.effects.iter_mut().for_each(|e| e.dwell = Some(30 + rng.random_range(0..20)));
        Some(())
    }),
    kind(FIELD, Effects, |s, rng| {
        let d = one_of([8.0, 15.0], rng);
        put(s, &[FIELD], d, rng)
    }),
    kind("half", PartOfTheTime, |s, rng| {
        let acts_in = one_of([[0.0, 0.5], [0.5, 1.0]], rng);
        part(s, acts_in, rng)
    }),
    kind("third", PartOfTheTime, |s, rng| {
        let from = rng.random_range(0.15..0.5);
        part(s, [from, from + 0.33], rng)
    }),
    kind("power_up_midway", PartOfTheTime, |s, rng| {
        s.programme.power_ups = 2;
        stated(s)?;
        s.effects.push(effect_in_some_gyros(POWER_UP, one_of([12.0, 20.0], rng), s, rng));
        Some(())
    }),
    kind("tilt_midway", PartOfTheTime, |s, rng| {
        stated(s)?;
        let shown = seen_by(s).contains(&TILT);
        let d = one_of([12.0, 20.0], rng);
        s.effects.push(EffectChoice { acts_in: Some([0.5, 1.0]), ..EffectChoice::detectable(TILT, d) });
        shown.then_some(())
    }),
    kind("three", Effects, |s, rng| {
        let d = one_of([12.0, 20.0], rng);
        (0..3).try_for_each(|_| put(s, &seen_by(s), d, rng))?;
        let names: Vec<&String> = s.effects.iter().map(|e| &e.effect).collect();
        (names[0] != names[1] && names[0] != names[2] && names[1] != names[2]).then_some(())
    }),
    kind("strong", Effects, |s, rng| put(s, &seen_by(s), 1000.0, rng)),
    kind("one_8", Effects, |s, rng| put(s, &seen_by(s), 8.0, rng)),
    kind("time_8", Effects, |s, rng| put(s, &IN_TIME, 8.0, rng)),
    kind("outside", Outside, |s, rng| {
        let family = format!("outside:{}", in_gyros()[rng.random_range(0..in_gyros().len())]);
        s.effects.push(effect_in_some_gyros(&family, one_of([15.0, 20.0, 30.0], rng), s, rng));
        Some(())
    }),
    kind("tilted_faces_5", Outside, |s, _| tilted_faces(s, 5.0)),
    kind("tilted_faces_20", Outside, |s, _| tilted_faces(s, 20.0)),
    kind("misaligned", Effects, |s, rng| {
        let d = one_of([12.0, 20.0], rng);
        put(s, &[TILT], d, rng)?;
        put(s, &[NORTH], d, rng)?;
        let others: Vec<&str> = seen_by(s).into_iter().filter(|id| ![TILT, NORTH].contains(id)).collect();
        if rng.random() { put(s, &others, d, rng) } else { Some(()) }
    }),
];

impl CampaignKind {
    pub fn from_name(name: &str) -> Option<&'static Self> {
        KINDS.iter().find(|kind| kind.name == name)
    }

    pub fn campaign(&self, seed: u64, number: usize) -> Simulated {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let place = KINDS.iter().position(|kind| kind.name == self.name).unwrap_or(0);
        rng.set_stream(1 + number as u64 + ((1 + place as u64) << 40));
        loop {
            let mut scenario = style(&mut rng);
            scenario.imu = format!("IMU-{number:05}");
            if (self.put)(&mut scenario, &mut rng).is_some()
                && let Ok(simulated) = simulate(&scenario)
                && (self.hidden != Outside || is_outside(&simulated))
            {
                return simulated;
            }
        }
    }

    fn score(&self, truth: &Simulated, answer: Result<Answer, String>, milliseconds: f64) -> KindScore {
        let hidden: Vec<&str> = match self.hidden {
            Nothing | Outside => Vec::new(),
            Effects | PartOfTheTime => truth.truth.effects.iter().map(String::as_str).collect(),
        };
        // A tilt or a seat that changes midway is its own entry.
        let means = |named: &super::answer::AnsweredEffect, id: &str| {
            named.means(id) || self.hidden == PartOfTheTime && id == TILT && named.means(TILT_FROM_A_DWELL)
        };
        let in_part = truth.causes.iter().any(|cause| cause.acts_in_h != ALWAYS);
        let change = in_part.then(|| left_by_the_whole(truth));
        let answer = match answer {
            Ok(answer) => answer,
            Err(error) => return KindScore { error: Some(error), ..KindScore::of(truth.truth.seen, milliseconds) },
        };
        let right = |named: &super::answer::AnsweredEffect| hidden.iter().any(|id| means(named, id));
        let whole = |named: &super::answer::AnsweredEffect| {
            self.hidden == PartOfTheTime && right(named) && named.acts_in.is_none() && !named.means(TILT_FROM_A_DWELL)
        };
        KindScore {
            named: answer.effects.iter().map(|named| named.effect.clone()).collect(),
            explained: answer.verdict == "explained",
            gap: answer.verdict != "no_gap",
            wrong: answer.effects.iter().any(|named| !right(named)),
            found: !hidden.is_empty() && hidden.iter().all(|id| answer.effects.iter().any(|n| means(n, id))),
            change,
            whole: answer.effects.iter().any(whole),
            closures: closures(truth, &answer.effects),
            said: answer.noise.is_some(),
            described: match &truth.truth.family {
                Some(family) => answer.description.iter().any(|d| depends_on(family).contains(&d.by.as_str())),
                None => !answer.description.is_empty(),
            },
            ..KindScore::of(truth.truth.seen, milliseconds)
        }
    }
}

/// How one campaign of a kind was answered.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct KindScore {
    /// Detectability of what was hidden.
    pub seen: f64,
    pub named: Vec<String>,
    pub explained: bool,
    pub gap: bool,
    /// Something was named that was not hidden.
    pub wrong: bool,
    /// All that was hidden was named.
    pub found: bool,
    /// Detectability of what is left of an effect of a part of the time once it is taken to act throughout.
    pub change: Option<f64>,
    /// An effect of a part of the time was named as though it acted throughout.
    pub whole: bool,
    /// What the names claim to close.
    pub closures: Vec<Closure>,
    /// Something was said of the noise.
    pub said: bool,
    /// What an outside cause depends on was among the description; of any other, something was described.
    pub described: bool,
    pub milliseconds: f64,
    pub error: Option<String>,
}

impl KindScore {
    fn of(seen: f64, milliseconds: f64) -> Self {
        Self { seen, milliseconds, ..Self::default() }
    }
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KindRow {
    pub kind: &'static str,
    pub confident_wrong: Tally,
    pub doubted_wrong: Tally,
    /// Of campaigns in which what is hidden can be seen.
    pub found: Tally,
    /// Of campaigns with an effect of a part of the time, where that it is one can be seen.
    pub explained_as_whole: Tally,
    /// Of closures that are claimed, those with the truth in their interval.
    pub closure_covers: Tally,
    pub gap_without_a_name: Tally,
    pub noise_said: Tally,
    pub described: Tally,
    pub milliseconds: f64,
    pub errors: usize,
    pub scores: Vec<KindScore>,
}

pub fn row(kind: &CampaignKind, seed: u64, count: usize, diagnose: &CampaignDiagnoser<'_>) -> KindRow {
    let scores: Vec<KindScore> = (0..count)
        .into_par_iter()
        .map(|number| {
            let simulated = kind.campaign(seed, number);
            let (answer, milliseconds) = timed(&wire::campaign::to_json(&simulated.campaign), diagnose);
            kind.score(&simulated, answer, milliseconds)
        })
        .collect();
    let tally = |of: fn(&KindScore) -> bool| Tally::of(scores.iter().map(of));
    let is_visible = |s: &&KindScore| s.change.is_none_or(|change| change >= VISIBLE);
    let visibly_in_part = scores.iter().filter(|_| kind.hidden == PartOfTheTime).filter(is_visible);
    let hides = matches!(kind.hidden, Effects | PartOfTheTime);
    KindRow {
        kind: kind.name,
        confident_wrong: tally(|s| s.wrong && s.explained),
        doubted_wrong: tally(|s| s.wrong && !s.explained),
        found: Tally::of(scores.iter().filter(|s| hides && s.seen >= VISIBLE).map(|s| s.found)),
        explained_as_whole: Tally::of(visibly_in_part.map(|s| s.whole && s.explained)),
        closure_covers: Tally::of(scores.iter().flat_map(|s| s.closures.iter().map(Closure::covered))),
        gap_without_a_name: tally(|s| s.gap && s.named.is_empty()),
        noise_said: tally(|s| s.said),
        described: tally(|s| s.described),
        milliseconds: upper_median_of(scores.iter().map(|score| score.milliseconds)).unwrap_or(0.0),
        errors: scores.iter().filter(|s| s.error.is_some()).count(),
        scores,
    }
}

/// d of what the effects of a campaign leave where each is taken to act throughout, with sizes of its own.
fn left_by_the_whole(simulated: &Simulated) -> f64 {
    let slots: Vec<String> = simulated.world.slots().map(|slot| slot.name().to_owned()).collect();
    let mut structure = Structure::of(simulated);
    simulated.truth.effects.iter().for_each(|effect| structure.name(effect, &slots));
    structure.left()
}

fn stated(s: &mut Scenario) -> Option<()> {
    if s.columns.standard_errors == StandardErrors::Absent {
        s.columns.standard_errors = StandardErrors::Noisy;
    }
    Some(())
}

fn constant_errors(s: &mut Scenario) -> Option<()> {
    s.columns.standard_errors = StandardErrors::Constant;
    Some(())
}

fn shared_noise(s: &mut Scenario, correlation: f64) -> Option<()> {
    s.noise.correlation = correlation;
    stated(s)?;
    (s.gyros.len() == 3).then_some(())
}

/// Standard deviation of a static dwell, deg/h.
fn dwell_sd(s: &Scenario) -> f64 {
    s.noise.angle_random_walk_deg_per_sqrt_h / (s.programme.dwell_s / 3600.0).sqrt()
}

fn flicker(s: &mut Scenario, sigmas: f64) -> Option<()> {
    s.noise.bias_instability_deg_per_h = sigmas * dwell_sd(s);
    stated(s)
}

/// Between the static and the turning part, as a change of fixtures is: never while the two are mixed.
fn reseated(s: &mut Scenario, arcsec: f64, rng: &mut ChaCha8Rng) -> Option<()> {
    if s.programme.order == DwellOrder::Mixed {
        s.programme.order = DwellOrder::Random;
    }
    s.effects.push(EffectChoice::sized(SEAT, radians_from_arcsec(arcsec)));
    stated(s)?;
    let _: f64 = rng.random();
    (!s.programme.rates_arcsec_s.is_empty()).then_some(())
}

/// Each face by angles of its own, so many arcsec about each axis.
fn tilted_faces(s: &mut Scenario, arcsec: f64) -> Option<()> {
    s.effects.push(EffectChoice::sized(&format!("outside:{TILTED_FACES}"), radians_from_arcsec(arcsec)));
    stated(s)?;
    (!s.programme.rates_arcsec_s.is_empty()).then_some(())
}

fn put(s: &mut Scenario, ids: &[&str], d: f64, rng: &mut ChaCha8Rng) -> Option<()> {
    stated(s)?;
    let seen = seen_by(s);
    let id = ids[rng.random_range(0..ids.len())];
    s.effects.push(effect_in_some_gyros(id, d, s, rng));
    seen.contains(&id).then_some(())
}

/// An effect that would act throughout, in a part of the campaign.
fn part(s: &mut Scenario, acts_in: [f64; 2], rng: &mut ChaCha8Rng) -> Option<()> {
    let d = one_of([12.0, 20.0], rng);
    put(s, &THROUGHOUT, d, rng)?;
    s.effects.iter_mut().for_each(|effect| effect.acts_in = Some(acts_in));
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_draws_the_same_campaign_again_and_another_for_another_number() {
        for kind in &KINDS {
            let text = |number| wire::campaign::to_json(&kind.campaign(3, number).campaign);
            assert_eq!(text(0), text(0), "{}", kind.name);
            assert_ne!(text(0), text(1), "{}", kind.name);
        }
    }
}
