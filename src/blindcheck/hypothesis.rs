//! What somebody's own hypothesis would take to be found: hidden in campaigns of one design at rising sizes, and asked
//! for in campaigns that do not hold it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;

use super::answer::Answer;
use super::run::{CampaignDiagnoser, timed};
use super::tally::Tally;
use crate::core::effects::Effect;
use crate::core::fault::Faults;
use crate::core::mounting::Slot;
use crate::core::numerics::median::upper_median_of;
use crate::simulate::augment::NotPossible;
use crate::simulate::of_hypothesis::{Amount, hide};
use crate::simulate::{Scenario, Simulated, simulate};
use crate::wire;

/// Share of campaigns in which what is called found is named.
pub const FOUND: f64 = 0.95;

/// The check of one hypothesis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HypothesisReport {
    pub hypothesis: String,
    /// Of `size`.
    pub unit: String,
    /// Campaigns that hold noise only: in how many it was named, and in how many anything was.
    pub clean: Tally,
    pub clean_anything: Tally,
    /// By detectability.
    pub hidden: Vec<HiddenRow>,
    /// The smallest size at which, and at all larger ones, it was named in 95 %; none where no size reached that.
    pub found_from: Option<f64>,
    /// The same with the lower end of Wilson's interval: that it is named in 95 % is shown; none where it is not.
    pub surely_from: Option<f64>,
    /// Campaigns that were not answered, and why.
    pub errors: Vec<String>,
}

/// Campaigns in which it was hidden, as visible as `detectability`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HiddenRow {
    pub detectability: f64,
    /// Median over the campaigns of the largest coefficient.
    pub size: f64,
    /// Named, itself or in a class that holds it.
    pub named: Tally,
    /// Of those, beside others that the campaign cannot tell from it.
    pub in_class: Tally,
    /// What the classes held beside it, the most frequent first.
    pub class: Vec<String>,
    /// Something else was named, and not it.
    pub something_else: Tally,
}

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum NoReport {
    #[error(transparent)]
    Scenario(#[from] Faults),
    #[error(transparent)]
    NotPossible(#[from] NotPossible),
}

struct TrialOutcome {
    size: f64,
    answer: Result<Answer, String>,
}

/// Hides `effect` in `count` campaigns of the scenario at each of `detectabilities`, in gyros drawn by lot, and lets
/// them be diagnosed from their text alone; `diagnose` asks for it. `done` is called after each.
///
/// # Errors
/// A scenario that cannot be, or a design that cannot see the hypothesis.
pub fn hypothesis(
    effect: Effect,
    design: (&Scenario, u64, usize),
    detectabilities: &[f64],
    diagnose: &CampaignDiagnoser<'_>,
    done: &(dyn Fn() + Sync),
) -> Result<HypothesisReport, NoReport> {
    let (base, seed, count) = design;
    let of = |row: usize, d: Option<f64>| -> Result<Vec<TrialOutcome>, NoReport> {
        let one = |number: usize| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(1 + number as u64 + ((1 + row as u64) << 40));
            let scenario = Scenario { seed: rng.random(), imu: format!("IMU-{number:05}"), ..base.clone() };
            let mut simulated = simulate(&scenario)?;
            let size = d.map(|d| hidden(&mut simulated, effect, d, &mut rng)).transpose()?.unwrap_or(0.0);
            let (answer, _) = timed(&wire::campaign::to_json(&simulated.campaign), diagnose);
            done();
            Ok(TrialOutcome { size, answer })
        };
        (0..count).into_par_iter().map(one).collect()
    };
    let clean = of(0, None)?;
    let mut errors = errors(&clean);
    let mut rows = Vec::new();
    for (row, d) in detectabilities.iter().enumerate() {
        let outcomes = of(1 + row, Some(*d))?;
        errors.extend(self::errors(&outcomes));
        rows.push(HiddenRow::of(*d, effect.id(), outcomes));
    }
    rows.sort_by(|a, b| a.detectability.total_cmp(&b.detectability));
    let answers = || clean.iter().filter_map(|outcome| outcome.answer.as_ref().ok());
    let from = |share: &dyn Fn(&Tally) -> Option<f64>| {
        let reached = rows.iter().rev().take_while(|row| share(&row.named).is_some_and(|share| share >= FOUND));
        reached.last().map(|row| row.size)
    };
    Ok(HypothesisReport {
        hypothesis: effect.id().to_owned(),
        unit: effect.entry().unit.to_owned(),
        clean: Tally::of(answers().map(|answer| names(answer, effect.id()))),
        clean_anything: Tally::of(answers().map(|answer| !answer.effects.is_empty())),
        found_from: from(&Tally::rate),
        surely_from: from(&|named| named.interval().map(|[low, _]| low)),
        hidden: rows,
        errors,
    })
}

/// Hides it in some gyros; its largest coefficient.
fn hidden(simulated: &mut Simulated, effect: Effect, d: f64, rng: &mut ChaCha8Rng) -> Result<f64, NotPossible> {
    let there: Vec<Slot> = simulated.campaign.gyros.iter().map(|gyro| gyro.slot).collect();
    let lot: u32 = rng.random_range(1..1 << there.len());
    let slots: Vec<Slot> = (0..there.len()).filter(|j| lot >> j & 1 == 1).map(|j| there[j]).collect();
    let known = hide(simulated, effect, Amount::Detectability(d), &slots, rng)?;
    Ok(known.estimates.iter().map(|estimate| estimate.value.abs()).fold(0.0, f64::max))
}

fn names(answer: &Answer, id: &str) -> bool {
    answer.effects.iter().any(|named| named.means(id))
}

fn errors(outcomes: &[TrialOutcome]) -> Vec<String> {
    outcomes.iter().filter_map(|outcome| outcome.answer.as_ref().err().cloned()).collect()
}

impl HiddenRow {
    fn of(detectability: f64, id: &str, outcomes: Vec<TrialOutcome>) -> Self {
        let size = upper_median_of(outcomes.iter().map(|outcome| outcome.size)).unwrap_or(0.0);
        let answers: Vec<Answer> = outcomes.into_iter().filter_map(|outcome| outcome.answer.ok()).collect();
        let own =
            |answer: &Answer| answer.effects.iter().find(|named| named.means(id)).map(|named| named.class.clone());
        let classes: Vec<Vec<String>> = answers.iter().filter_map(own).collect();
        let mut beside: Vec<(usize, String)> = Vec::new();
        for other in classes.iter().flatten().filter(|other| *other != id) {
            match beside.iter_mut().find(|(_, known)| known == other) {
                Some((count, _)) => *count += 1,
                None => beside.push((1, other.clone())),
            }
        }
        beside.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
        Self {
            detectability,
            size,
            named: Tally::of(answers.iter().map(|answer| names(answer, id))),
            in_class: Tally::of(classes.iter().map(|class| class.len() > 1)),
            class: beside.into_iter().map(|(_, id)| id).collect(),
            something_else: Tally::of(answers.iter().map(|answer| !names(answer, id) && !answer.effects.is_empty())),
        }
    }
}
