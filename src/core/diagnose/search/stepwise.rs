//! Which hypotheses enter the model: forward with everything else refitted, pairs tried outright, then backward.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use crate::core::diagnose::residuals::augmented_fit::Part;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::bayes_factor::{Score, log_bayes_in, scores, scores_of, together};
use crate::core::diagnose::search::choice::{Choice, designs, without};
use crate::core::diagnose::search::hypotheses::Bank;
use crate::core::diagnose::search::noise_models::{NoiseModels, WeightedModel};
use crate::core::diagnose::search::null_distribution::Null;
use crate::core::diagnose::search::projections::{Extra, Products, State, each_by_itself, from_one_another, state};
use crate::core::effects::{Effect, Shape};
use crate::core::numerics::basis::dot;
use crate::core::numerics::log_sum::LogSum;

/// More causes than this at once are not named: whatever needs them has not been understood.
pub(crate) const MOST: usize = 4;

/// ln of prior odds of a competitor against a contract entry.
pub(crate) const SUSPECT_ODDS: f64 = -2.0;

/// ln of evidence that a replacement must win by.
const CLEARLY: f64 = 0.3;

/// A choice is credited with others that explain the same as far as they are no better than this.
const TIED: f64 = 0.3;

/// ln of evidence by which a competitor must beat a contract entry, or a pair of them, to stand in its place.
const CONTRACT_FIRST: f64 = 2.5;

/// Share of an effect that its regressors may miss.
const MISSED: f64 = 0.006;

/// ln of prior odds against each further cause.
pub(crate) const PER_CAUSE: f64 = 3.0;

/// Pairs start from this many contract entries with at least this evidence alone; what a first look finds to fall
/// short by more than `POLISH` is not looked at again.
const PAIR_STARTS: usize = 10;
const PAIR_START: f64 = 1.0;
const POLISH: f64 = 12.0;

/// Hypotheses and their members, in whatever order they were adopted.
type Adopted = Vec<(usize, Vec<bool>)>;

/// Scores that have been computed, by what had been adopted: over all that the noise may be, and under each model.
#[derive(Default)]
pub(crate) struct Known {
    scores: RefCell<HashMap<Adopted, Rc<[Score]>>>,
    under_each: RefCell<HashMap<Adopted, Rc<[Scored]>>>,
}

/// Every kind under one model of the noise, with the logarithm of its weight.
struct Scored {
    log_weight: f64,
    has_memory: bool,
    scores: Vec<Score>,
}

pub(crate) struct Search<'a> {
    pub frame: &'a Frame,
    pub bank: &'a Bank,
    pub null: &'a Null,
    pub known: &'a Known,
    pub threshold: Threshold,
    /// What the noise may be beside that of `frame`.
    pub noise: &'a NoiseModels,
}

/// Evidence that adoption asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Threshold {
    /// Of what is named alone.
    pub alone: f64,
    /// Of what is named beside another: a name that is not quite right leaves something for a second one.
    pub beside: f64,
}

impl Search<'_> {
    /// Probability that noise alone reaches this evidence anywhere in the search.
    pub fn p_value(&self, evidence: f64) -> f64 {
        self.null.p_value(evidence)
    }

    /// The model in use with the columns of `choices`.
    pub fn state(&self, choices: &[Choice]) -> State {
        state(self.frame, self.extras(choices))
    }

    pub(crate) fn extras(&self, choices: &[Choice]) -> Vec<Extra> {
        extras(self.bank, choices)
    }

    /// Evidence of every kind given `choices`, with prior odds.
    pub fn scores(&self, choices: &[Choice]) -> Rc<[Score]> {
        kept(&self.known.scores, choices, || self.computed(choices, 0.0))
    }

    /// The same where noise with a memory has these odds (ln) more.
    fn computed(&self, choices: &[Choice], odds_of_memory: f64) -> Vec<Score> {
        let all = kept(&self.known.under_each, choices, || self.under_each(choices));
        let weight = |model: &Scored| model.log_weight + if model.has_memory { odds_of_memory } else { 0.0 };
        let mut weights = LogSum::default();
        all.iter().for_each(|model| weights.add(weight(model)));
        let of_kind = |k: usize| {
            let (mut sum, mut best) = (LogSum::default(), (f64::NEG_INFINITY, &all[0].scores[k]));
            for model in all.iter() {
                let log = weight(model) + model.scores[k].log_evidence;
                sum.add(log);
                if log > best.0 {
                    best = (log, &model.scores[k]);
                }
            }
            Score { log_evidence: sum.log() - weights.log(), ..best.1.clone() }
        };
        let mut scores: Vec<Score> = (0..self.bank.kinds.len()).map(of_kind).collect();
        for score in &mut scores {
            if !score.kind.is_nameable() {
                score.log_evidence += SUSPECT_ODDS;
            }
        }
        let as_stated: Vec<f64> = all[0].scores.iter().map(|score| score.log_evidence).collect();
        self.weigh(choices, &mut scores, &as_stated);
        scores
    }

    /// Evidence of every kind under each model of the noise, that as stated first.
    fn under_each(&self, choices: &[Choice]) -> Vec<Scored> {
        if self.noise.is_empty() {
            let scores = scores(self.bank, &self.state(choices));
            return vec![Scored { log_weight: 0.0, has_memory: false, scores }];
        }
        let mut all = Vec::new();
        for model in self.under(choices) {
            let WeightedModel { log_weight, has_memory, bank, state, .. } = &model;
            let products = Products::of(bank, state);
            let scores = independent(&model, &products);
            all.push(Scored { log_weight: *log_weight, has_memory: *has_memory, scores });
            if let Some((log_weight, shared)) = &model.shared {
                let scores = shared.scores(bank, state, &products);
                all.push(Scored { log_weight: *log_weight, has_memory: *has_memory, scores });
            }
        }
        all
    }

    /// Evidence of one kind beside `choices` where the noise is white and each gyro knows its own alone.
    pub(super) fn against_white_noise(&self, choices: &[Choice], kind: Effect) -> f64 {
        evidence_of(&scores(self.bank, &each_by_itself(self.frame, self.extras(choices))), kind)
    }

    fn under(&self, choices: &[Choice]) -> Vec<WeightedModel<'_>> {
        let columns = || designs(self.frame, self.bank, choices);
        let state = |frame: &Frame, bank: &Bank| each_by_itself(frame, extras(bank, choices));
        self.noise.under(self.frame, self.bank, columns, state)
    }

    /// Whether `kind` was ruled out given `choices`.
    pub fn is_ruled_out(&self, choices: &[Choice], kind: Effect) -> bool {
        self.evidence(choices, kind) == f64::NEG_INFINITY
    }

    /// The best shape of a scored kind. Its gyros are those whose own evidence is above zero, the strongest always; all
    /// of them for a common effect.
    pub fn choice(&self, score: &Score) -> Choice {
        let hypothesis = &self.bank.hypotheses[score.best];
        let gyros = self.frame.gyros.len();
        let best = (0..gyros).max_by(|&a, &b| score.gyro_log[a].total_cmp(&score.gyro_log[b])).unwrap_or(0);
        let members = (0..gyros).map(|j| hypothesis.common || j == best || score.gyro_log[j] > 0.0).collect();
        Choice { kind: score.kind, hypothesis: score.best, members, evidence: score.log_evidence, rival: None }
    }

    /// A choice as a part of the augmented model; none of a competitor.
    pub fn part(&self, choice: &Choice) -> Option<Part> {
        let part =
            || Part { effect: choice.kind, shape: self.shape(choice.hypothesis), members: choice.members.clone() };
        choice.kind.is_nameable().then(part)
    }

    /// The strongest kind given `choices`; among contract entries only where `contract` says so.
    fn best_given(&self, choices: &[Choice], contract: bool) -> Option<Choice> {
        let scores = self.scores(choices);
        strongest(scores.iter().filter(|score| !contract || score.kind.is_nameable())).map(|best| self.choice(best))
    }

    /// The adopted choices, in order of adoption.
    pub fn run(&self) -> Vec<Choice> {
        let mut found = self.grown(Vec::new());
        if !found.is_empty()
            && let Some(pair) = self.better_pair(&found, &[])
        {
            found = self.grown(pair);
        }
        for _ in 0..MOST {
            let Some(pair) = self.pair_for_one(&found) else { break };
            found = self.grown(pair);
        }
        let found = self.fewest(self.prune(self.in_parts(found)));
        let found = self.fewest(self.contract_first(found));
        let count = found.len();
        let mut found = self.most_plausible_first(merged(found));
        if found.len() < count {
            for i in 0..found.len() {
                found[i].evidence = self.earned_beside_others(&found, i);
            }
        }
        found
    }

    /// Adds what is strongest given the rest, until nothing is strong enough.
    fn grown(&self, mut found: Vec<Choice>) -> Vec<Choice> {
        while found.len() < MOST {
            match self.best_given(&found, false) {
                Some(next) if self.earned(&found, next.kind) > self.needed(&found) => {
                    found.push(next);
                    self.polish(&mut found);
                }
                _ => break,
            }
        }
        found
    }

    /// Replaces choices one at a time by better ones given the others, until none is better.
    pub(crate) fn polish(&self, choices: &mut [Choice]) {
        self.polish_among(choices, false);
    }

    pub(crate) fn polish_contract(&self, choices: &mut [Choice]) {
        self.polish_among(choices, true);
    }

    fn polish_among(&self, choices: &mut [Choice], contract: bool) {
        for _ in 0..4 {
            let mut changed = false;
            for i in (0..choices.len()).filter(|&i| !contract || !choices[i].is_competitor()).collect::<Vec<_>>() {
                let scores = self.scores(&without(choices, i));
                let eligible = || scores.iter().filter(|score| !contract || score.kind.is_nameable());
                let same = eligible().find(|score| score.kind == choices[i].kind);
                let held = same.map_or(f64::NEG_INFINITY, |same| same.log_evidence);
                let clearly_better = strongest(eligible()).filter(|best| best.log_evidence > held + CLEARLY);
                let Some(replacement) = clearly_better.or(same).map(|score| self.choice(score)) else { continue };
                changed |= replacement.hypothesis != choices[i].hypothesis || replacement.members != choices[i].members;
                choices[i] = replacement;
            }
            if !changed {
                break;
            }
        }
    }

    /// Two entries can hide each other, or together pass for a third: each of the stronger contract entries with its
    /// best companion, beside `beside`, against what is held.
    fn better_pair(&self, held: &[Choice], beside: &[Choice]) -> Option<Vec<Choice>> {
        let mut best: Option<Vec<Choice>> = None;
        let mut to_beat =
            self.worth(held) - if held.iter().any(Choice::is_competitor) { CONTRACT_FIRST } else { -CLEARLY };
        let alone = self.scores(beside);
        let starts = |score: &&Score| score.kind.is_nameable() && score.log_evidence > PAIR_START;
        let mut firsts: Vec<&Score> = alone.iter().filter(starts).collect();
        firsts.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
        let worth_beside = self.worth(beside);
        for score in firsts.iter().take(PAIR_STARTS) {
            let first = self.choice(score);
            let mut pair = beside.to_vec();
            pair.push(first);
            let Some(second) = self.best_given(&pair, true) else { continue };
            if worth_beside + score.log_evidence + second.evidence - 2.0 * PER_CAUSE < to_beat - POLISH {
                continue;
            }
            pair.push(second);
            self.polish_contract(&mut pair);
            let mut named = (0..pair.len()).filter(|&i| !pair[i].is_competitor());
            let each = named.all(|i| self.earned_beside_others(&pair, i) > self.needed(&without(&pair, i)));
            let worth = self.worth(&pair);
            if each && worth > to_beat {
                to_beat = worth;
                best = Some(pair);
            }
        }
        best
    }

    /// A pair of entries that, beside the other choices, explains what one is held for: two laws of one variable are a
    /// smooth function of it, which leads each of them alone, and two rotations of the table a field in each gyro.
    fn pair_for_one(&self, held: &[Choice]) -> Option<Vec<Choice>> {
        let may_be_two = |choice: &Choice| choice.is_competitor() || choice.kind.entry().may_be_two_shared();
        let ones = (0..held.len()).filter(|&i| held.len() < MOST && may_be_two(&held[i]));
        let beside = ones.map(|i| without(held, i)).filter(|beside| !beside.is_empty());
        beside.into_iter().find_map(|beside| self.better_pair(held, &beside))
    }

    /// A contract entry stands for a competitor that is hardly better; that the competitor explains it as well is
    /// noted.
    fn contract_first(&self, mut choices: Vec<Choice>) -> Vec<Choice> {
        for i in 0..choices.len() {
            if !choices[i].is_competitor() {
                continue;
            }
            let others = without(&choices, i);
            let Some(best) = self.best_given(&others, true) else { continue };
            let earned = self.earned(&others, best.kind) > self.needed(&others);
            if earned && best.evidence > choices[i].evidence - CONTRACT_FIRST {
                choices[i] = Choice { rival: Some(choices[i].kind), ..best };
            }
        }
        choices
    }

    /// What adoption beside `others` asks for. Time, temperature and attitude are known to some thousandths: what a
    /// strong effect leaves of that size is no effect of its own. One dwell that is set aside leaves nothing.
    pub fn needed(&self, others: &[Choice]) -> f64 {
        if others.is_empty() {
            return self.threshold.alone;
        }
        let power = |r: &[f64]| dot(r, r);
        let set_aside: Vec<Choice> = others.iter().filter(|other| other.kind.entry().is_one_dwell()).cloned().collect();
        let [before, left] = [&set_aside[..], others].map(|choices| each_by_itself(self.frame, self.extras(choices)));
        let gyros = before.iter().zip(&left);
        let taken: f64 = gyros
            .map(|(before, left)| (power(&before.residual) - power(&left.residual)) / left.scatter.variance())
            .sum();
        self.threshold.beside + 0.5 * MISSED * MISSED * taken
    }

    /// Evidence with which `kind` is held against the threshold, given `choices`. Where nothing is named yet, a
    /// contract entry shares it with those that explain the same; beside a name, what is tied with much has been told
    /// from little.
    pub fn earned(&self, choices: &[Choice], kind: Effect) -> f64 {
        self.earned_of(&self.scores(choices), choices, kind)
    }

    /// By how much (ln) choice `i` passes, given all others, where noise with a memory has odds (ln) beyond its prior:
    /// below zero, such noise may be what it shows.
    pub fn lead_over_memory(&self, choices: &[Choice], i: usize, odds_of_memory: f64) -> f64 {
        let others = without(choices, i);
        let scores = self.computed(&others, odds_of_memory);
        self.earned_of(&scores, &others, choices[i].kind) - self.needed(&others)
    }

    fn earned_of(&self, scores: &[Score], choices: &[Choice], kind: Effect) -> f64 {
        let own = self.against_noise(kind, evidence_of(scores, kind));
        let contract = scores.iter().filter(|s| s.kind.is_nameable());
        match kind {
            _ if choices.is_empty() && kind.is_nameable() => {
                together(contract.map(|s| self.against_noise(s.kind, s.log_evidence).min(own + TIED)))
            }
            _ => own,
        }
    }

    /// Evidence with which choice `i` is held against the threshold, given all others.
    pub fn earned_beside_others(&self, choices: &[Choice], i: usize) -> f64 {
        self.earned(&without(choices, i), choices[i].kind)
    }

    /// Evidence (ln of the Bayes factor) of the best hypothesis of `kind`, given that `choices` are in the model.
    pub fn evidence(&self, choices: &[Choice], kind: Effect) -> f64 {
        evidence_of(&self.scores(choices), kind)
    }

    /// Evidence of choice `i` given all others.
    fn given_others(&self, choices: &[Choice], i: usize) -> f64 {
        evidence_of(&self.scores(&without(choices, i)), choices[i].kind)
    }

    /// By how much (ln) choice `i` explains more than the best wandering course in its place would.
    pub fn lead_of_one(&self, choices: &[Choice], i: usize) -> f64 {
        self.given_others(choices, i) - self.of_wandering(&without(choices, i))
    }

    /// Evidence of the best wandering course, given `choices`.
    fn of_wandering(&self, choices: &[Choice]) -> f64 {
        let known = self.scores(choices);
        let wandering = known.iter().filter(|score| score.kind.entry().wanders);
        wandering.map(|score| score.log_evidence).fold(f64::NEG_INFINITY, f64::max)
    }

    /// By how much (ln) choices `i` and `j` together explain more than the best single course in time in their place
    /// would: little where two named courses are an approximation to a wandering one.
    pub fn lead_over_wandering(&self, choices: &[Choice], i: usize, j: usize) -> f64 {
        let others: Vec<Choice> =
            (0..choices.len()).filter(|k| ![i, j].contains(k)).map(|k| choices[k].clone()).collect();
        let with = |more: &[usize]| others.iter().cloned().chain(more.iter().map(|&k| choices[k].clone())).collect();
        let (one, both): (Vec<Choice>, Vec<Choice>) = (with(&[i]), with(&[i, j]));
        let pair = self.given_others(&one, others.len()) + self.given_others(&both, others.len() + 1);
        pair - PER_CAUSE - self.of_wandering(&others)
    }

    /// Drops, weakest first, what the others make superfluous.
    pub(crate) fn prune(&self, mut choices: Vec<Choice>) -> Vec<Choice> {
        loop {
            for i in 0..choices.len() {
                choices[i].evidence = self.earned_beside_others(&choices, i);
            }
            let Some(weakest) = (0..choices.len()).min_by(|&a, &b| choices[a].evidence.total_cmp(&choices[b].evidence))
            else {
                return choices;
            };
            if choices[weakest].evidence > self.needed(&without(&choices, weakest)) {
                return choices;
            }
            choices.remove(weakest);
            self.polish(&mut choices);
        }
    }

    /// Drops names that the others, chosen anew without them, make superfluous, the least missed first: a cause that
    /// two entries explain alike may have been given to one of them in some gyros and to the other in the rest.
    pub(crate) fn fewest(&self, mut choices: Vec<Choice>) -> Vec<Choice> {
        while choices.len() > 1 {
            let all = self.evidence_together(&choices);
            let fewer = (0..choices.len()).filter(|&i| !choices[i].is_competitor()).map(|i| {
                let mut fewer = without(&choices, i);
                self.polish_contract(&mut fewer);
                (all - self.evidence_together(&fewer), fewer)
            });
            match fewer.min_by(|(a, _), (b, _)| a.total_cmp(b)) {
                Some((missed, mut fewer)) if missed <= self.needed_beyond(&fewer, &choices) => {
                    self.polish(&mut fewer);
                    choices = self.prune(fewer);
                }
                _ => break,
            }
        }
        choices
    }

    /// What `more` than `fewer` have to show: nothing where they are but the parts of as many causes.
    fn needed_beyond(&self, fewer: &[Choice], more: &[Choice]) -> f64 {
        let as_many = self.as_wholes(fewer).len() == self.as_wholes(more).len();
        if as_many { 0.0 } else { self.needed(fewer) }
    }

    /// Evidence of all choices together less what each further cause costs beforehand.
    pub(crate) fn worth(&self, choices: &[Choice]) -> f64 {
        let wholes = self.as_wholes(choices);
        self.evidence_of_wholes(&wholes) - PER_CAUSE * wholes.len() as f64
    }

    /// Evidence of all choices: each given those before it, in its own gyros.
    fn evidence_together(&self, choices: &[Choice]) -> f64 {
        self.evidence_of_wholes(&self.as_wholes(choices))
    }

    fn evidence_of_wholes(&self, choices: &[Choice]) -> f64 {
        (0..choices.len()).map(|i| self.in_members(&choices[..i], &choices[i])).sum()
    }

    fn shape(&self, hypothesis: usize) -> Shape {
        self.bank.hypotheses[hypothesis].shape
    }

    /// The hypotheses of one kind, where the bank has any.
    fn hypotheses_of(&self, kind: Effect) -> Option<Range<usize>> {
        self.bank.kinds.iter().find(|(of, _)| *of == kind).map(|(_, range)| range.clone())
    }

    /// `choices` with each whole as its parts, where each of them earns its place beside the others.
    fn in_parts(&self, mut choices: Vec<Choice>) -> Vec<Choice> {
        for i in (0..choices.len()).rev() {
            let whole = &choices[i];
            let part = |part: &Effect| {
                let mut range = self.hypotheses_of(*part)?;
                let first = range.start;
                let alike = range.find(|&of_part| self.shape(of_part) == self.shape(whole.hypothesis));
                Some(Choice { kind: *part, hypothesis: alike.unwrap_or(first), ..whole.clone() })
            };
            let parts: Option<Vec<Choice>> = whole.kind.entry().parts.iter().map(part).collect();
            let Some(parts) = parts.filter(|parts| !parts.is_empty()) else { continue };
            let count = choices.len() - 1;
            let all = [without(&choices, i), parts].concat();
            if (count..all.len()).all(|i| self.earned_beside_others(&all, i) > self.needed(&without(&all, i))) {
                choices = all;
            }
        }
        choices
    }

    /// `choices` with those that are the parts of one whole as that one: beside a part that each gyro takes as its own,
    /// another shows less than both do where all gyros share them.
    fn as_wholes(&self, choices: &[Choice]) -> Vec<Choice> {
        let mut all = choices.to_vec();
        for (kind, range) in &self.bank.kinds {
            let parts = kind.entry().parts;
            let of_it = |choice: &Choice| parts.contains(&choice.kind);
            let is_held = |part: &Effect| all.iter().any(|choice| choice.kind == *part);
            if parts.is_empty() || !parts.iter().all(is_held) {
                continue;
            }
            let is_shape_held = |&i: &usize| all.iter().any(|c| of_it(c) && self.shape(c.hypothesis) == self.shape(i));
            let Some(hypothesis) = range.clone().find(is_shape_held) else { continue };
            let members = vec![true; self.frame.gyros.len()];
            all.retain(|choice| !of_it(choice));
            all.push(Choice { kind: *kind, hypothesis, members, evidence: 0.0, rival: None });
        }
        all
    }

    /// Evidence of a choice in its own gyros and no others, given `before`. [`Search::scores`] average over all sets
    /// of gyros: were that added up, two names that share the gyros between them would each be credited with the
    /// other's. For the same reason each gyro's noise is its own here: what is taken out of one must not make
    /// another's evidence stronger.
    fn in_members(&self, before: &[Choice], choice: &Choice) -> f64 {
        let Some(range) = self.hypotheses_of(choice.kind) else { return 0.0 };
        let (mut total, mut weights) = (LogSum::default(), LogSum::default());
        for WeightedModel { log_weight, bank, state, shared, .. } in self.under(before) {
            let hypotheses = &bank.hypotheses[range.clone()];
            let products = Products::of(bank, &state);
            let seen = products.seen();
            let mut independent = LogSum::default();
            hypotheses.iter().for_each(|hypothesis| independent.add(log_bayes_in(hypothesis, &choice.members, &seen)));
            weights.add(log_weight);
            total.add(log_weight + independent.log());
            if let Some((log_weight, shared)) = shared {
                weights.add(log_weight);
                total.add(log_weight + shared.in_members(bank, hypotheses, &choice.members, &state, &products));
            }
        }
        let may_be_named = choice.kind.is_nameable() || !choice.kind.entry().parts.is_empty();
        let odds = if may_be_named { 0.0 } else { SUSPECT_ODDS };
        total.log() - weights.log() + odds
    }
}

/// Evidence from which on what one gyro holds is too much noise to another that knows its noise from all.
const STRONG: f64 = 25.0;

/// Evidence under noise that gyros do not share. Where gyros know their noise from one another, what a strong effect
/// leaves in the others counts as noise to each, and its evidence falls short of the likelihoods that it is weighed
/// with: there each gyro has its own.
fn independent(model: &WeightedModel, products: &Products) -> Vec<Score> {
    let own = || scores_of(model.bank, &products.seen());
    let Some(known) = from_one_another(model.frame, &model.state) else { return own() };
    let pooled = scores_of(model.bank, &products.seen_in(&known));
    if pooled.iter().all(|score| score.log_evidence < STRONG) {
        return pooled;
    }
    let stronger = |(pooled, own): (Score, Score)| {
        if own.log_evidence > STRONG.max(pooled.log_evidence) { own } else { pooled }
    };
    pooled.into_iter().zip(own()).map(stronger).collect()
}

/// What `known` holds beside `choices`, computed where it does not yet.
fn kept<T>(
    known: &RefCell<HashMap<Adopted, Rc<[T]>>>,
    choices: &[Choice],
    compute: impl FnOnce() -> Vec<T>,
) -> Rc<[T]> {
    let mut key: Adopted = choices.iter().map(|choice| (choice.hypothesis, choice.members.clone())).collect();
    key.sort();
    if let Some(known) = known.borrow().get(&key) {
        return Rc::clone(known);
    }
    let computed: Rc<[T]> = compute().into();
    known.borrow_mut().insert(key, Rc::clone(&computed));
    computed
}

/// Columns of the choices in each gyro.
fn extras(bank: &Bank, choices: &[Choice]) -> Vec<Extra> {
    let of_gyro = |j: usize| {
        let mut extra = Extra::default();
        for choice in choices.iter().filter(|choice| choice.members[j]) {
            let block = &bank.hypotheses[choice.hypothesis].blocks[j];
            (block.start..block.start + block.len).for_each(|column| extra.push(bank, j, column));
        }
        extra
    };
    (0..bank.columns.len()).map(of_gyro).collect()
}

fn strongest<'a>(scores: impl Iterator<Item = &'a Score>) -> Option<&'a Score> {
    scores.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
}

fn evidence_of(scores: &[Score], kind: Effect) -> f64 {
    scores.iter().find(|score| score.kind == kind).map_or(f64::NEG_INFINITY, |score| score.log_evidence)
}

/// One effect that came in twice, for other gyros each time, is one choice.
fn merged(choices: Vec<Choice>) -> Vec<Choice> {
    let mut merged: Vec<Choice> = Vec::new();
    for choice in choices {
        match merged.iter_mut().find(|held| held.hypothesis == choice.hypothesis) {
            Some(held) => held.members.iter_mut().zip(&choice.members).for_each(|(held, member)| *held |= member),
            None => merged.push(choice),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_that_came_in_twice_for_other_gyros_is_one() {
        let choice = |hypothesis: usize, members: [bool; 3]| Choice {
            kind: Effect::ScaleCubic,
            hypothesis,
            members: members.to_vec(),
            evidence: 9.0,
            rival: None,
        };
        let merged = merged(vec![
            choice(4, [true, false, false]),
            choice(5, [false, true, false]),
            choice(4, [false, false, true]),
        ]);
        let found: Vec<_> = merged.iter().map(|c| (c.hypothesis, c.members.as_slice())).collect();
        assert_eq!(found, [(4, &[true, false, true][..]), (5, &[false, true, false][..])]);
    }
}
