//! Which campaigns a blind run draws: cases, designs, gyros, noise and columns, all from one seed.

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use super::reach::Structure;
use crate::core::named::named;
use crate::simulate::cause::{CATALOGUE, Injectable, SEAT, ShownBy};
use crate::simulate::outside::in_gyros;
use crate::simulate::programme::{DwellOrder, Positions, Programme, any_direction};
use crate::simulate::scenario::{
    AxesChoice, EffectChoice, GeometryChoice, GyroChoice, OutputNoise, Profile, Scenario, StandardErrors, Temperature,
};
use crate::simulate::{Simulated, simulate};

named! {
/// What a campaign of a blind run is to try.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Case {
    /// One effect of the catalogue, d of 8 or more.
    One = "one",
    /// One effect at d = 5.
    Faint = "faint",
    /// Nothing but noise.
    Clean = "clean",
    /// Two effects, d = 12 each.
    Pair = "pair",
    /// A cause in no catalogue, d of 15 or more.
    Outside = "outside",
    /// An effect that leaves nothing in this design.
    Unseen = "unseen",
    /// A term of model (6) that the model in use leaves out.
    Withheld = "withheld",
}
}

impl Case {
    /// Share of a mixed run, per cent.
    fn share(self) -> u32 {
        match self {
            Case::One => 38,
            Case::Clean => 22,
            Case::Pair | Case::Outside => 12,
            Case::Faint => 8,
            Case::Unseen | Case::Withheld => 4,
        }
    }
}

/// Which cases and how visible.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    pub seed: u64,
    /// Only these; all in their usual shares where empty.
    pub cases: Vec<Case>,
    /// Only these effects (where the case has a choice); all where empty.
    pub effects: Vec<String>,
    /// Detectabilities of the case `one`.
    pub detectability: Vec<f64>,
}

/// One campaign of a blind run, before it is sealed.
#[derive(Debug, Clone)]
pub struct Trial {
    pub number: usize,
    pub case: Case,
    pub simulated: Simulated,
}

/// An effect whose response keeps less than this share after the model's fit would have to be absurdly large.
const LEAST_VISIBLE: f64 = 0.02;
/// What the best effect of the catalogue must leave of an outside cause, in units of d.
const LEAST_OUTSIDE: f64 = 6.0;
/// Attempts at a design that can see what was drawn; the plain default design follows.
const ATTEMPTS: usize = 40;

impl Draw {
    /// Trial `number` of this run. The same run and number give the same campaign.
    pub fn trial(&self, number: usize) -> Trial {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(number as u64 + 1);
        let case = self.case(&mut rng);
        for _ in 0..ATTEMPTS {
            if let Some(simulated) = self.attempt(case, number, &mut rng) {
                return Trial { number, case, simulated };
            }
        }
        let simulated = simulate(&Scenario { seed: rng.random(), imu: imu(number), ..Scenario::default() });
        Trial {
            number,
            case: Case::Clean,
            simulated: simulated.expect("the default scenario is sound: a test simulates it"),
        }
    }

    fn case(&self, rng: &mut ChaCha8Rng) -> Case {
        if let Some(case) = self.cases.choose(rng) {
            return *case;
        }
        let mut ticket = rng.random_range(0..100);
        for case in Case::ALL {
            if ticket < case.share() {
                return case;
            }
            ticket -= case.share();
        }
        Case::Clean
    }

    fn attempt(&self, case: Case, number: usize, rng: &mut ChaCha8Rng) -> Option<Simulated> {
        let mut scenario = style(rng);
        scenario.imu = imu(number);
        match case {
            Case::Clean => {}
            Case::One => {
                let d = *self.detectability.choose(rng)?;
                scenario.effects.push(self.effect(&seen_by(&scenario), d, &scenario, rng)?);
            }
            Case::Faint => scenario.effects.push(self.effect(&seen_by(&scenario), 5.0, &scenario, rng)?),
            Case::Pair => {
                let ids = seen_by(&scenario);
                let first = self.effect(&ids, 12.0, &scenario, rng)?;
                let second = self.effect(&ids, 12.0, &scenario, rng)?;
                if first.effect == second.effect {
                    return None;
                }
                scenario.effects.extend([first, second]);
            }
            Case::Outside => {
                let family = format!("outside:{}", in_gyros().choose(rng)?);
                let d = *[15.0, 20.0, 30.0].choose(rng)?;
                scenario.effects.push(in_some_gyros(EffectChoice::detectable(&family, d), &scenario, rng));
            }
            Case::Unseen => {
                scenario.programme.positions = Positions::TwentyFour;
                let unseen = |known: &&Injectable| matches!(known.shown_by, ShownBy::OffAxis | ShownBy::Closure);
                let ids: Vec<&str> = CATALOGUE.iter().filter(unseen).map(|known| known.id).collect();
                let id = *ids.choose(rng)?;
                scenario.effects.push(EffectChoice { effect: id.into(), ..EffectChoice::default() });
            }
            Case::Withheld => withhold(&mut scenario, rng),
        }
        let simulated = simulate(&scenario).ok()?;
        let sound = match case {
            Case::Unseen => true,
            Case::Outside => visible_enough(&simulated) && is_outside(&simulated),
            _ => visible_enough(&simulated),
        };
        sound.then_some(simulated)
    }

    fn effect(&self, ids: &[&str], d: f64, scenario: &Scenario, rng: &mut ChaCha8Rng) -> Option<EffectChoice> {
        let wanted: Vec<&&str> =
            ids.iter().filter(|id| self.effects.is_empty() || self.effects.iter().any(|e| e == **id)).collect();
        Some(in_some_gyros(EffectChoice::detectable(wanted.choose(rng)?, d), scenario, rng))
    }
}

fn imu(number: usize) -> String {
    format!("IMU-{number:05}")
}

fn visible_enough(simulated: &Simulated) -> bool {
    // Another seat turns all rates alike, which E takes up whole; what is left is small and no absurd size.
    simulated.causes.iter().filter(|cause| cause.label != SEAT).all(|cause| {
        let (seen, power) = simulated.world.detectability(std::slice::from_ref(cause));
        seen.iter().sum::<f64>() > LEAST_VISIBLE * power.iter().sum::<f64>()
    })
}

/// Whether no single effect of the catalogue can mimic the cause in this campaign: scale factor times time *is*
/// scale factor times temperature where temperature is a ramp, and nobody can tell.
pub(super) fn is_outside(simulated: &Simulated) -> bool {
    let structure = Structure::of(simulated);
    let slots: Vec<String> = simulated.world.slots().map(|slot| slot.name().to_owned()).collect();
    let mimics = |id: &str| structure.left_with(id, &slots).is_some_and(|left| left < LEAST_OUTSIDE);
    !CATALOGUE.iter().any(|known| mimics(known.id))
}

/// Ids that a campaign of this scenario can show.
pub(super) fn seen_by(scenario: &Scenario) -> Vec<&'static str> {
    let turns = !scenario.programme.rates_arcsec_s.is_empty();
    let shows = |by: ShownBy| match by {
        ShownBy::Always => true,
        ShownBy::Rotation => turns,
        ShownBy::Attitudes => turns && scenario.columns.attitude,
        ShownBy::OffAxis => scenario.programme.positions != Positions::TwentyFour,
        ShownBy::OwnTerm | ShownBy::Closure => false,
    };
    // Kind by kind, so that a seed draws what it always drew.
    let kinds =
        [ShownBy::Always, ShownBy::Rotation, ShownBy::Attitudes, ShownBy::OffAxis].into_iter().filter(|by| shows(*by));
    let mut ids: Vec<&str> =
        kinds.flat_map(|by| CATALOGUE.iter().filter(move |known| known.shown_by == by).map(|known| known.id)).collect();
    if !scenario.columns.temperature {
        ids.retain(|id| !id.starts_with("temperature"));
    }
    ids
}

/// An effect of this detectability in a few of the gyros.
pub(super) fn effect_in_some_gyros(id: &str, d: f64, scenario: &Scenario, rng: &mut ChaCha8Rng) -> EffectChoice {
    in_some_gyros(EffectChoice::detectable(id, d), scenario, rng)
}

fn in_some_gyros(effect: EffectChoice, scenario: &Scenario, rng: &mut ChaCha8Rng) -> EffectChoice {
    let slots: Vec<String> = scenario.gyros.iter().map(|gyro| gyro.slot.clone()).collect();
    let mut chosen: Vec<String> = slots.iter().filter(|_| rng.random_bool(0.6)).cloned().collect();
    if chosen.is_empty() {
        chosen.extend(slots.choose(rng).cloned());
    }
    EffectChoice { gyros: Some(chosen), ..effect }
}

fn withhold(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let term = one_of(["g_linear", "g_squared", "scale"], rng);
    let kept = ["bias", "g_linear", "g_squared", "scale"].into_iter().filter(|name| *name != term);
    scenario.model = Some(kept.map(str::to_owned).collect());
    if term == "g_linear" {
        scenario.population.d_i_sd = 0.0;
        scenario.population.d_s_sd = 0.0;
    }
    if term != "scale" {
        let d = one_of([8.0, 15.0, 30.0], rng);
        let effect = in_some_gyros(EffectChoice::detectable(term, d), scenario, rng);
        scenario.effects.push(effect);
    }
}

/// One of a list that is never empty, each as likely as often as it stands there.
pub(super) fn one_of<T: Copy, const N: usize>(choices: [T; N], rng: &mut ChaCha8Rng) -> T {
    const { assert!(N > 0) };
    choices[rng.random_range(0..N)]
}

/// A station, its programme and its gyros.
pub(super) fn style(rng: &mut ChaCha8Rng) -> Scenario {
    let mut scenario = Scenario { seed: rng.random(), ..Scenario::default() };
    scenario.programme = programme(rng);
    scenario.temperature = temperature(rng);
    scenario.geometry = geometry(rng);
    scenario.site.latitude_deg = rng.random_range(-65.0..65.0);
    let (declination, dip): (f64, f64) = (rng.random_range(-0.15..0.15), rng.random_range(0.3..1.2));
    scenario.site.magnetic_field_nav = [declination.sin() * dip.cos(), declination.cos() * dip.cos(), -dip.sin()];
    scenario.site.states_magnetic_field = rng.random_bool(0.3);
    scenario.noise = OutputNoise {
        angle_random_walk_deg_per_sqrt_h: rng.random_range(1.5e-4..5e-4),
        rate_noise_ppm: rng.random_range(0.0..0.4),
        ..OutputNoise::default()
    };
    let count = one_of([3, 3, 3, 3, 3, 3, 2, 1], rng);
    scenario.gyros =
        ["G1", "G2", "G3"].iter().take(count).map(|s| GyroChoice { slot: (*s).into(), ..Default::default() }).collect();
    use StandardErrors::{Absent, Exact, Noisy};
    scenario.columns.standard_errors = one_of([Exact, Exact, Noisy, Noisy, Noisy, Absent], rng);
    scenario.columns.temperature = rng.random_bool(0.95);
    scenario.columns.attitude = rng.random_bool(0.95);
    scenario
}

fn programme(rng: &mut ChaCha8Rng) -> Programme {
    use Positions::{TwentyFour, WithEdges, WithTilts};
    let rates: [&[f64]; 4] = [
        &[360.0, 1800.0, 3600.0, 7200.0],
        &[360.0, 1800.0, 3600.0, 7200.0],
        &[900.0, 3600.0, 7200.0],
        &[600.0, 1800.0, 5400.0, 10_800.0],
    ];
    Programme {
        positions: one_of([TwentyFour, TwentyFour, WithEdges, WithTilts, WithTilts], rng),
        repeats: one_of([0, 3, 6, 6, 12], rng),
        rates_arcsec_s: one_of(rates, rng).to_vec(),
        order: one_of(
            [DwellOrder::Random, DwellOrder::Random, DwellOrder::Random, DwellOrder::Mixed, DwellOrder::Fixed],
            rng,
        ),
        dwell_s: one_of([120.0, 180.0, 300.0], rng),
        ..Programme::default()
    }
}

fn temperature(rng: &mut ChaCha8Rng) -> Temperature {
    let profile = one_of([Profile::Wander, Profile::Wander, Profile::Wander, Profile::Ramp, Profile::Cycle], rng);
    let size_k = match profile {
        Profile::Ramp => rng.random_range(0.8..2.5),
        _ => rng.random_range(0.3..1.0),
    };
    Temperature { profile, size_k, time_h: rng.random_range(0.7..3.0), reading_sd_k: 0.002, ..Temperature::default() }
}

fn geometry(rng: &mut ChaCha8Rng) -> GeometryChoice {
    match rng.random_range(0..10) {
        0..7 => GeometryChoice::Named("skewed".into()),
        7 | 8 => GeometryChoice::Named("orthogonal".into()),
        _ => {
            let mut axes = || {
                let input = any_direction(rng);
                let spin = input.cross(&any_direction(rng)).normalize();
                AxesChoice { input: input.into(), spin: spin.into() }
            };
            GeometryChoice::Axes(
                ["G1", "G2", "G3"].map(|slot| (slot.to_owned(), axes())).into_iter().collect::<BTreeMap<_, _>>(),
            )
        }
    }
}
