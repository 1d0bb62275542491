//! One diagnosis against the truth of its campaign.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::simulate::Simulated;
use crate::simulate::truth::{GyroKey, KeyEntry, OUTSIDE};

use super::answer::{Answer, AnsweredEffect, AnsweredShift};
use super::draw::Case;
use super::reach::Structure;

/// A gyro has to be listed from this own detectability on.
pub const OWN_DETECTABILITY: f64 = 4.5;
/// A member of a class that leaves this much of the true effect unexplained could have been told from it: at 7 the
/// likelihood ratio of the two names is right 9,998 times in 10,000.
const TELLABLE: f64 = 7.0;

/// How one campaign was answered.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    pub campaign: String,
    pub case: Case,
    pub design: String,
    pub sem: String,
    /// What was hidden: ids, or the family of an outside cause.
    pub hidden: Vec<String>,
    pub detectability: f64,
    pub verdict: String,
    pub named: Vec<String>,
    /// For each hidden effect, whether an adopted one means it.
    pub found: Vec<bool>,
    /// Adopted effects that mean nothing of what was hidden.
    pub wrong: usize,
    /// For each hidden effect that was found: its gyros are right.
    pub gyros: Vec<bool>,
    /// For each hidden effect that was found: its class holds nothing that the design could tell from it.
    pub classes: Vec<bool>,
    /// Effects that leave nothing in this design: listed as such.
    pub listed_as_unseen: Option<bool>,
    pub closures: Vec<Closure>,
    /// Over all coefficients of the gyros that are named.
    pub shift: Option<ShiftScore>,
    /// For each coefficient that is reported as moved: the augmented value is the nearer one.
    pub moved: Vec<bool>,
    pub milliseconds: f64,
    /// Why there is no answer.
    pub error: Option<String>,
}

/// The closure that was claimed, and that of the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Closure {
    pub claimed: f64,
    pub interval: [f64; 2],
    /// Share of the hidden structure's power that the named effect can reproduce.
    pub truth: f64,
}

impl Closure {
    /// Whether the true closure is within the interval.
    pub fn covered(&self) -> bool {
        (self.interval[0]..=self.interval[1]).contains(&self.truth)
    }
}

/// Errors of D_I and D_S against the truth with the plain and with the augmented model, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShiftScore {
    pub plain_rms: f64,
    pub augmented_rms: f64,
    /// Whether any of these coefficients is reported as moved.
    pub material: bool,
}

impl ShiftScore {
    /// Whether the named effects bring D_I and D_S nearer to the truth.
    pub fn nearer(&self) -> bool {
        self.augmented_rms < self.plain_rms
    }
}

/// What is known about a campaign besides its file.
pub struct CampaignTruth<'a> {
    pub campaign: &'a str,
    pub case: Case,
    pub key: &'a KeyEntry,
    /// Slots in the order of the campaign's gyros.
    pub slots: &'a [String],
    /// Where the campaign is of this program's making, everything about it.
    pub simulated: Option<&'a Simulated>,
}

impl CampaignTruth<'_> {
    /// Scores `answer`, which took `milliseconds`.
    pub fn score(&self, answer: &Result<Answer, String>, milliseconds: f64) -> Score {
        let mut score = self.blank(milliseconds);
        let answer = match answer {
            Ok(answer) => answer,
            Err(error) => {
                score.error = Some(error.clone());
                return score;
            }
        };
        score.verdict.clone_from(&answer.verdict);
        score.named = answer.effects.iter().map(|named| named.effect.clone()).collect();
        let hidden = self.nameable();
        score.wrong = answer.effects.iter().filter(|named| !hidden.iter().any(|(_, id)| named.means(id))).count();
        for &(i, id) in &hidden {
            let by = answer.effects.iter().find(|n| n.effect == id).or(answer.effects.iter().find(|n| n.means(id)));
            score.found.push(by.is_some());
            if let Some(named) = by {
                score.gyros.push(self.gyros_right(i, named));
                score.classes.extend(self.class_is_forced(i, id, named));
            }
        }
        if self.case == Case::Unseen {
            score.listed_as_unseen = Some(self.key.effects.iter().all(|id| answer.lists_as_unseen(id)));
        }
        score.closures = self.closures(answer);
        score.shift = self.shift(answer);
        score.moved = answer.impact.iter().filter_map(|entry| self.errors(entry)).map(|(a, b)| b < a).collect();
        score
    }

    fn blank(&self, milliseconds: f64) -> Score {
        let outside = |id: &String| if id == OUTSIDE { self.key.family.clone() } else { None };
        Score {
            campaign: self.campaign.to_owned(),
            case: self.case,
            design: self.key.design.clone(),
            sem: self.key.sem.clone(),
            hidden: self.hidden().iter().map(|id| outside(id).unwrap_or_else(|| id.clone())).collect(),
            detectability: self.key.seen,
            verdict: String::new(),
            named: Vec::new(),
            found: Vec::new(),
            wrong: 0,
            gyros: Vec::new(),
            classes: Vec::new(),
            listed_as_unseen: None,
            closures: Vec::new(),
            shift: None,
            moved: Vec::new(),
            milliseconds,
            error: None,
        }
    }

    fn hidden(&self) -> Vec<String> {
        match self.case {
            Case::Withheld => self.withheld_term().into_iter().collect(),
            _ => self.key.effects.clone(),
        }
    }

    /// The term that the model leaves out; it need not be an injected effect, the gyros have it anyway.
    fn withheld_term(&self) -> Option<String> {
        let terms = self.simulated?.world.terms;
        crate::core::model::Term::ALL.into_iter().find(|t| !terms.contains(*t)).map(|t| t.name().to_owned())
    }

    /// Hidden effects that ought to be named, with their place in the key.
    fn nameable(&self) -> Vec<(usize, &str)> {
        match self.case {
            Case::Unseen => Vec::new(),
            Case::Withheld => {
                let term = self.withheld_term();
                let known = ["g_linear", "g_squared", "scale"].into_iter().find(|id| Some(*id) == term.as_deref());
                known.into_iter().map(|id| (0, id)).collect()
            }
            _ => {
                let ids = self.key.effects.iter().enumerate();
                ids.filter(|(_, id)| *id != OUTSIDE).map(|(i, id)| (i, id.as_str())).collect()
            }
        }
    }

    /// Every gyro with a detectability of its own of 4.5 or more is listed, and none that has nothing of the effect.
    fn gyros_right(&self, effect: usize, named: &AnsweredEffect) -> bool {
        let own = self.own_detectability(effect);
        own.iter().all(|(slot, d)| {
            let listed = named.gyros.contains(slot);
            (listed || *d < OWN_DETECTABILITY) && (!listed || *d > 0.0)
        })
    }

    /// Slot by slot; a key that does not say is taken to mean equal shares.
    fn own_detectability(&self, effect: usize) -> BTreeMap<String, f64> {
        if let Some(own) = self.key.seen_by.get(effect) {
            return own.clone();
        }
        if self.case == Case::Withheld {
            return self.slots.iter().map(|slot| (slot.clone(), f64::INFINITY)).collect();
        }
        let share = self.key.seen / (self.key.gyros.len() as f64).sqrt();
        let d = |slot: &String| if self.key.gyros.contains(slot) { share } else { 0.0 };
        self.slots.iter().map(|slot| (slot.clone(), d(slot))).collect()
    }

    fn class_is_forced(&self, effect: usize, id: &str, named: &AnsweredEffect) -> Option<bool> {
        let simulated = self.simulated?;
        let cause = simulated.causes.get(effect)?;
        let structure = Structure::of_causes(&simulated.world, std::slice::from_ref(cause));
        let tellable = |member: &String| {
            member != id && structure.left_with(member, self.slots).is_some_and(|left| left > TELLABLE)
        };
        Some(!named.class.iter().chain([&named.effect]).any(tellable))
    }

    fn closures(&self, answer: &Answer) -> Vec<Closure> {
        if let Some(simulated) = self.simulated {
            return closures(simulated, &answer.effects);
        }
        match answer.effects.as_slice() {
            [named] if self.case == Case::One && named.effect == self.key.effects[0] => {
                named.claim().map(|(claimed, interval)| Closure { claimed, interval, truth: 1.0 }).into_iter().collect()
            }
            _ => Vec::new(),
        }
    }

    fn shift(&self, answer: &Answer) -> Option<ShiftScore> {
        let gyros: Vec<&String> = answer.effects.iter().flat_map(|named| &named.gyros).collect();
        let named = |entry: &&AnsweredShift| gyros.contains(&&entry.slot);
        let (mut plain, mut augmented, mut count) = (0.0, 0.0, 0);
        for entry in answer.impact.iter().chain(&answer.impact_within_noise).filter(named) {
            let Some((before, after)) = self.errors(entry) else { continue };
            plain += before * before;
            augmented += after * after;
            count += 1;
        }
        let material = answer.impact.iter().any(|entry| named(&entry));
        let rms = |sum: f64| (sum / f64::from(count)).sqrt();
        (count > 0).then(|| ShiftScore { plain_rms: rms(plain), augmented_rms: rms(augmented), material })
    }

    /// Errors of the plain and of the augmented value of a coefficient, without their signs.
    fn errors(&self, entry: &AnsweredShift) -> Option<(f64, f64)> {
        let (truth, before) = (self.true_coefficient(&entry.slot, &entry.coefficient)?, entry.plain?);
        Some(((before - truth).abs(), (before + entry.shift - truth).abs()))
    }

    fn true_coefficient(&self, slot: &str, coefficient: &str) -> Option<f64> {
        let place = self.slots.iter().position(|s| s == slot)?;
        let truth: &GyroKey = self.key.truth.get(place)?;
        match coefficient {
            "D_I" => Some(truth.d_i),
            "D_S" => Some(truth.d_s),
            _ => None,
        }
    }
}

/// What each name claims to close, given those before it, beside the share of what is hidden that it can reproduce.
pub(super) fn closures(simulated: &Simulated, effects: &[AnsweredEffect]) -> Vec<Closure> {
    if simulated.causes.is_empty() {
        return Vec::new();
    }
    let mut structure = Structure::of(simulated);
    let closure = |named: &AnsweredEffect| {
        let before = structure.left();
        structure.name(&named.effect, &named.gyros);
        let (claimed, interval) = named.claim().filter(|_| before > 1.0)?;
        Some(Closure { claimed, interval, truth: 1.0 - (structure.left() / before).powi(2) })
    };
    effects.iter().filter_map(closure).collect()
}

impl Score {
    /// Something was named in a campaign where nothing ought to be.
    pub fn false_alarm(&self) -> bool {
        !self.named.is_empty()
    }

    /// The answer admits that something is there which it cannot name.
    pub fn honest_about_outside(&self) -> bool {
        ["partly_explained", "unexplained"].contains(&self.verdict.as_str())
    }

    /// Whether everything that was hidden was named, and something was hidden.
    pub fn all_found(&self) -> bool {
        self.error.is_none() && self.found.iter().all(|found| *found) && !self.found.is_empty()
    }
}
