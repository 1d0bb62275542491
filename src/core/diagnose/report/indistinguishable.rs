//! What a campaign cannot tell apart from what was adopted, and which gyros have it.

use crate::core::diagnose::search::bayes_factor::{criterion, gains, of_gyro, score};
use crate::core::diagnose::search::choice::Choice;
use crate::core::diagnose::search::choice::without;
use crate::core::diagnose::search::projections::Products;
use crate::core::diagnose::search::stepwise::Search;
use crate::core::effects::{Effect, Shape};

/// Entries whose evidence comes within this of the adopted one (a Bayes factor of 20) belong to its class.
const EVIDENCE_MARGIN: f64 = 3.0;

/// And share of the evidence: what a strong effect's regressors miss is some hundredths of it.
const MARGIN_SHARE: f64 = 0.03;

/// So do entries that fit as well to within this gain in log-likelihood per coefficient spent.
const FIT_MARGIN: f64 = 2.0;

/// Squared standard deviations that an effect must explain in a further gyro, by number of coefficients: probabilities
/// of 0.6, 0.7 and 0.8 % under noise, where an own detectability of 4.5 is found in 95 %.
const MEMBER: [f64; 3] = [7.5, 9.8, 11.8];

/// Contract entries that stand in for choice `i` as well as it does, itself first.
pub(crate) fn class(search: &Search, choices: &[Choice], i: usize) -> Vec<Effect> {
    let own = choices[i].kind;
    if !own.is_nameable() {
        return Vec::new();
    }
    let others = without(choices, i);
    let products = Products::of(search.bank, &search.state(&others));
    let seen = products.seen();
    let judged: Vec<(Effect, f64, f64)> = search
        .bank
        .kinds
        .iter()
        .filter(|(kind, _)| kind.is_nameable())
        .map(|(kind, range)| {
            let evidence = score(search.bank, *kind, range.clone(), &seen).log_evidence;
            (*kind, evidence, criterion(search.bank, range.clone(), &seen))
        })
        .collect();
    let Some(&(_, evidence, fit)) = judged.iter().find(|(effect, ..)| *effect == own) else { return vec![own] };
    let margin = EVIDENCE_MARGIN.max(MARGIN_SHARE * evidence);
    // An instant is chosen among as many as there are dwells: noise gains the logarithm of that by it.
    let of_instant = (search.frame.dwells() as f64).ln();
    let fit_margin = |effect: Effect| {
        if own.entry().throughout == Some(effect) { FIT_MARGIN + of_instant } else { FIT_MARGIN }
    };
    let mut class = vec![own];
    class.extend(
        judged
            .iter()
            .filter(|(effect, ..)| *effect != own && !search.is_ruled_out(&others, *effect))
            .filter(|(effect, e, f)| *e > evidence - margin || *f > fit - fit_margin(*effect))
            .map(|(effect, ..)| *effect),
    );
    let always =
        own.entry().never_told_from.iter().filter(|effect| search.bank.kinds.iter().any(|(k, _)| k == *effect));
    class.extend(always.filter(|effect| !class.contains(effect)).copied().collect::<Vec<_>>());
    class
}

/// What stands for another entry that acts in a part of the campaign, where that fits as well as choice `i` does: what
/// few dwells carry may be either, and the name is in doubt.
pub(crate) fn in_part(search: &Search, choices: &[Choice], i: usize) -> Option<Effect> {
    let (bank, own) = (search.bank, choices[i].kind);
    let (_, of_own) = bank.kinds.iter().find(|(kind, _)| *kind == own)?;
    let products = Products::of(bank, &search.state(&without(choices, i)));
    let seen = products.seen();
    let as_well = criterion(bank, of_own.clone(), &seen) - FIT_MARGIN;
    let of_another = |k: &usize| match bank.hypotheses[*k].shape {
        Shape::Part { of, .. } => of != own,
        Shape::Restart(tau) => !own.entry().parameter.takes(Shape::Tau(tau)),
        _ => false,
    };
    // Taken one by one, each has its part of the time as one more coefficient.
    let fits_as_well = |k: &usize| criterion(bank, *k..*k + 1, &seen) - 1.0 > as_well;
    (0..bank.hypotheses.len()).filter(of_another).find(fits_as_well).map(|k| bank.hypotheses[k].kind)
}

/// The same for single gyros: what stands in for choice `i` in member `j` as far as that gyro alone can say, where
/// that is more than `class`.
pub(crate) fn wider_in_gyros(
    search: &Search,
    choices: &[Choice],
    i: usize,
    members: &[bool],
    class: &[Effect],
) -> Vec<(usize, Vec<Effect>)> {
    let hypothesis = &search.bank.hypotheses[choices[i].hypothesis];
    let own = hypothesis.kind;
    if hypothesis.common || !own.is_nameable() {
        return Vec::new();
    }
    let others = without(choices, i);
    let products = Products::of(search.bank, &search.state(&others));
    let seen = products.seen();
    let in_gyro = |j: usize| {
        let judged: Vec<(Effect, f64, f64)> = (search.bank.kinds.iter())
            .filter(|(kind, _)| kind.is_nameable())
            .filter_map(|(kind, range)| {
                of_gyro(search.bank, range.clone(), j, &seen[j]).map(|(evidence, fit)| (*kind, evidence, fit))
            })
            .collect();
        let (_, evidence, fit) = *judged.iter().find(|(effect, ..)| *effect == own)?;
        let as_well = |effect: &Effect, e: f64, f: f64| {
            class.contains(effect) || e > evidence - EVIDENCE_MARGIN || f > fit - FIT_MARGIN
        };
        let possible = |effect: &Effect| *effect != own && !search.is_ruled_out(&others, *effect);
        let mut wider = vec![own];
        wider.extend(judged.iter().filter(|(x, e, f)| possible(x) && as_well(x, *e, *f)).map(|(effect, ..)| *effect));
        (wider.len() > class.len()).then_some((j, wider))
    };
    (0..members.len()).filter(|&j| members[j]).filter_map(in_gyro).collect()
}

/// Gyros in which choice `i` explains more than noise would; the one where it explains most in any case.
pub(crate) fn members(search: &Search, choices: &[Choice], i: usize) -> Vec<bool> {
    let hypothesis = &search.bank.hypotheses[choices[i].hypothesis];
    if hypothesis.common {
        return vec![true; search.frame.gyros.len()];
    }
    let products = Products::of(search.bank, &search.state(&without(choices, i)));
    let seen = products.seen();
    let gains = gains(hypothesis, &seen);
    let best = (0..gains.len()).max_by(|&a, &b| gains[a].0.total_cmp(&gains[b].0)).unwrap_or(0);
    gains
        .iter()
        .enumerate()
        .map(|(j, &(gain, len))| {
            j == best || (len > 0 && 2.0 * gain > MEMBER.get(len - 1).copied().unwrap_or(4.0 + 2.0 * len as f64))
        })
        .collect()
}
