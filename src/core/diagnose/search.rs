//! Which hypotheses enter the model: forward with everything else refitted, pairs tried outright, then backward.

use super::bank::{Bank, Kind};
use super::basis::Basis;
use super::evidence::{Score, State, scores, state};
use super::frame::Frame;

/// More causes than this at once are not named: whatever needs them has not been understood.
const MOST: usize = 4;

/// ln of prior odds of a suspect against a contract entry.
pub(super) const SUSPECT_ODDS: f64 = -2.0;

/// ln of evidence that a replacement must win by.
const CLEARLY: f64 = 0.3;

/// One adopted hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    pub kind: Kind,
    /// Index into the bank.
    pub hypothesis: usize,
    pub members: Vec<bool>,
    /// Evidence given the other choices, prior odds included.
    pub evidence: f64,
}

pub(super) struct Search<'a> {
    pub frame: &'a Frame,
    pub bank: &'a Bank,
    /// Evidence that adoption asks for.
    pub threshold: f64,
}

impl Search<'_> {
    /// The model in use with the columns of `choices`.
    pub fn state(&self, choices: &[Choice]) -> State {
        let extras = (0..self.frame.gyros.len()).map(|j| self.extra(choices, j)).collect();
        state(self.frame, extras)
    }

    fn extra(&self, choices: &[Choice], j: usize) -> Basis {
        let mut extra = Basis::default();
        for choice in choices.iter().filter(|choice| choice.members[j]) {
            let block = &self.bank.hypotheses[choice.hypothesis].blocks[j];
            for c in block.start..block.start + block.len {
                extra.push(self.bank.column(j, c).as_slice().to_vec());
            }
        }
        extra
    }

    /// Evidence of every kind given `choices`, with prior odds.
    pub fn scores(&self, choices: &[Choice]) -> Vec<Score> {
        let mut scores = scores(self.bank, &self.state(choices));
        for score in &mut scores {
            if matches!(score.kind, Kind::Suspect(_)) {
                score.log_evidence += SUSPECT_ODDS;
            }
        }
        scores
    }

    pub fn choice(&self, score: &Score) -> Choice {
        let hypothesis = &self.bank.hypotheses[score.best];
        let gyros = self.frame.gyros.len();
        let best = (0..gyros).max_by(|&a, &b| score.gyro_log[a].total_cmp(&score.gyro_log[b])).unwrap_or(0);
        let members = (0..gyros).map(|j| hypothesis.common || j == best || score.gyro_log[j] > 0.0).collect();
        Choice { kind: score.kind, hypothesis: score.best, members, evidence: score.log_evidence }
    }

    fn best_given(&self, choices: &[Choice]) -> Option<Choice> {
        let scores = self.scores(choices);
        let best = scores.iter().max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))?;
        Some(self.choice(best))
    }

    /// The adopted choices, in order of adoption.
    pub fn run(&self) -> Vec<Choice> {
        let mut found: Vec<Choice> = Vec::new();
        while found.len() < MOST {
            let Some(next) = self.best_given(&found) else { break };
            let mut trial = found.clone();
            let adopt = next.evidence > self.threshold;
            if adopt {
                trial.push(next);
                self.polish(&mut trial);
            }
            if trial.len() == 2 {
                trial = self.better_pair(trial);
            }
            if trial.len() <= found.len() {
                found = trial;
                break;
            }
            found = trial;
        }
        self.prune(found)
    }

    /// Replaces choices one at a time by better ones given the others, until none is better.
    fn polish(&self, choices: &mut [Choice]) {
        for _ in 0..4 {
            let mut changed = false;
            for i in 0..choices.len() {
                let mut others = choices.to_vec();
                others.remove(i);
                let scores = self.scores(&others);
                let held = scores
                    .iter()
                    .find(|score| score.kind == choices[i].kind)
                    .map_or(f64::NEG_INFINITY, |s| s.log_evidence);
                let Some(best) = scores.iter().max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence)) else {
                    continue;
                };
                let replacement = if best.log_evidence > held + CLEARLY {
                    self.choice(best)
                } else {
                    match scores.iter().find(|score| score.kind == choices[i].kind) {
                        Some(same) => self.choice(same),
                        None => continue,
                    }
                };
                changed |= replacement.hypothesis != choices[i].hypothesis || replacement.members != choices[i].members;
                choices[i] = replacement;
            }
            if !changed {
                break;
            }
        }
    }

    /// Two entries can hide each other: every contract entry with its best companion, against what is held.
    fn better_pair(&self, held: Vec<Choice>) -> Vec<Choice> {
        let mut best = (self.total(&held), held);
        for score in self.scores(&[]) {
            if !matches!(score.kind, Kind::Effect(_)) {
                continue;
            }
            let first = self.choice(&score);
            let Some(second) = self.best_given(std::slice::from_ref(&first)) else { continue };
            if first.evidence + second.evidence > best.0 + CLEARLY {
                let mut pair = vec![first, second];
                self.polish(&mut pair);
                let total = self.total(&pair);
                let each = (0..2).all(|i| self.given_others(&pair, i) > self.threshold);
                if each && total > best.0 + if best.1.len() < 2 { self.threshold } else { CLEARLY } {
                    best = (total, pair);
                }
            }
        }
        best.1
    }

    /// Evidence of all choices together: each given those before it.
    pub fn total(&self, choices: &[Choice]) -> f64 {
        (0..choices.len())
            .map(|i| {
                let scores = self.scores(&choices[..i]);
                scores.iter().find(|s| s.kind == choices[i].kind).map_or(0.0, |s| s.log_evidence)
            })
            .sum()
    }

    /// Evidence of choice `i` given all others.
    pub fn given_others(&self, choices: &[Choice], i: usize) -> f64 {
        let mut others = choices.to_vec();
        let kind = others.remove(i).kind;
        self.scores(&others).iter().find(|s| s.kind == kind).map_or(f64::NEG_INFINITY, |s| s.log_evidence)
    }

    /// Drops, weakest first, what the others make superfluous.
    fn prune(&self, mut choices: Vec<Choice>) -> Vec<Choice> {
        loop {
            for i in 0..choices.len() {
                choices[i].evidence = self.given_others(&choices, i);
            }
            let Some(weakest) = (0..choices.len()).min_by(|&a, &b| choices[a].evidence.total_cmp(&choices[b].evidence))
            else {
                return choices;
            };
            if choices[weakest].evidence > self.threshold {
                return choices;
            }
            choices.remove(weakest);
            self.polish(&mut choices);
        }
    }
}
