//! Where a campaign and the error model part, which unmodelled effect parts them, and how far the gap shrinks.
//!
//! [`diagnose`] is to be read from top to bottom: each stage is a function below it, and its parts lie in the room of
//! its name (`residuals`, `search`, `report`); [`diagnosis`] is what comes out.

mod adopt;
mod diagnosis;
mod record_closure;
mod report;
mod residuals;
mod search;

pub use crate::core::diagnose::diagnosis::*;
pub use crate::core::diagnose::record_closure::{CLOSURE_CLASS, ClosureDiagnosis, GyroClosure, closures};

pub use crate::core::diagnose::report::against_reference::{
    Moved, NoReference, Parts, Reference, Split, may_be_split, split,
};
pub use crate::core::diagnose::search::noise_rounds::FALSE_ALARM;

use crate::core::diagnose::report::calibrated::Calibrated;
use crate::core::diagnose::report::closure::{self, ClosureReference, GAP};
use crate::core::diagnose::report::named::{self, Named};
use crate::core::diagnose::report::{
    identifiability, impact, next_dwells, stated_errors, where_in_campaign, why_not_named,
};
use crate::core::diagnose::residuals::augmented_fit::{self, Fit, Part};
use crate::core::diagnose::residuals::noise_floor;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::noise_rounds::SearchOutcome;
use crate::core::diagnose::search::odds;
use crate::core::diagnose::search::refined_shape;
use crate::core::diagnose::search::stepwise::Search;

use super::augmented::Options;
use super::campaign::{Campaign, CampaignNote};
use super::effects::{CATALOGUE, COMPETITORS, Effect, Refusal, Shape};
use super::message::{Message, figure};
use super::note::Note;
use crate::message;

/// Raised with every change of what a diagnosis finds: one that was kept is then made again. A new entry of the
/// catalogue raises it by itself: there were 48 when it was 8.
pub const METHOD: u32 = 28 + 100 * (CATALOGUE.len() + COMPETITORS.len() - 48) as u32;

/// Dwells of three gyros, at most: what a search holds grows with the gyros and the square of the dwells, and is half a
/// gigabyte of so many.
const MOST_DWELLS: usize = 1200;

/// Diagnoses one campaign against the terms and effects in use, in four stages, each of which takes what the one
/// before returned. Where the first look names something or sees a gap, the search and what follows are done once more
/// with all that the noise may be.
///
/// ```
/// use gyrowatch::core::augmented::Options;
/// use gyrowatch::core::diagnose::{Verdict, diagnose};
/// use gyrowatch::core::effects::Effect;
///
/// // A campaign of another simulator, into which a change of bias with temperature was put.
/// let text = std::fs::read("tests/data/practice/campaign-02.json")?;
/// let campaign = gyrowatch::wire::document::parse(&text)?;
/// let diagnosis = diagnose(&campaign, &Options::default()).expect("it has dwells to spare");
/// assert_eq!(diagnosis.verdict, Verdict::Explained);
/// assert_eq!(diagnosis.effects[0].effect, Effect::TemperatureBias);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Refusal`] where no residual can be formed at all, or there are more dwells than a search has memory for. What merely cannot be tested (no temperature, no
/// attitude, no repeats) is said in `notes` and `not_identifiable`.
pub fn diagnose(campaign: &Campaign, options: &Options) -> Result<Diagnosis, Refusal> {
    let residuals = residuals(campaign, options)?;
    let searched = searched(residuals)?;
    let first = closed(names(campaign, &searched));
    if first.verdict == Verdict::NoGap {
        return Ok(answer(campaign, first));
    }
    let searched = searched.closer()?;
    Ok(answer(campaign, closed(names(campaign, &searched))))
}

/// Stage 1: the campaign with the model in use taken out of it, over its noise.
fn residuals(campaign: &Campaign, options: &Options) -> Result<Frame, Refusal> {
    let (dwells, gyros) = (campaign.dwells.len(), campaign.gyros.len().max(1));
    let most = (MOST_DWELLS as f64 * (3.0 / gyros as f64).sqrt()) as usize;
    if dwells > most {
        return Err(Refusal::TooManyDwells { dwells, most });
    }
    Frame::of(campaign, options)
}

/// Searches about a strong effect: what it is may look otherwise once what hangs on it is right.
const ROUNDS_ABOUT_STRONG: usize = 2;

/// Stage 2: every hypothesis is scored, and those are chosen that noise alone does not explain. Where one is strong,
/// the search is done again about its fit.
fn searched(residuals: Frame) -> Result<SearchOutcome, Refusal> {
    let mut settled = SearchOutcome::of(residuals.clone())?;
    let mut about = Vec::new();
    for _ in 0..ROUNDS_ABOUT_STRONG {
        match settled.about_strong(&residuals)? {
            Some((strong, frame)) if strong != about => {
                settled = SearchOutcome::of(frame)?;
                about = strong;
            }
            _ => break,
        }
    }
    Ok(settled)
}

/// What the search chose and what of it gets a name, fitted together with the model in use.
struct Names<'a> {
    settled: &'a SearchOutcome,
    search: Search<'a>,
    named: Vec<Named>,
    /// What speaks against the names.
    doubts: Vec<Sign>,
    parts: Vec<Part>,
    /// The same as a model is to hold them.
    told: Vec<Part>,
    fit: Fit,
    /// The campaign calibrated without and with them.
    calibrated: Calibrated,
}

/// Still stage 2: contract entries among the choices, as far as they close something of dwells that were held out.
fn names<'a>(campaign: &Campaign, settled: &'a SearchOutcome) -> Names<'a> {
    let search = settled.search();
    let (mut named, doubts) = named::named(&search, &settled.found);
    named.retain(|n| !identifiability::is_unseen(&settled.frame, &settled.bank, n.part.effect));
    let parts: Vec<Part> = named.iter().map(|n| n.part.clone()).collect();
    let mut closes = odds::closing(&settled.frame, &parts).into_iter();
    named.retain(|_| closes.next().unwrap_or(true));
    let parts: Vec<Part> = named.iter().map(|n| n.part.clone()).collect();
    let fit = augmented_fit::fit(&settled.frame, &parts);
    let told = refined_shape::as_told(&settled.frame, &parts, &fit);
    let calibrated = Calibrated::of(campaign, &settled.frame, &told);
    Names { settled, search, named, doubts, parts, told, fit, calibrated }
}

/// How far the names close the gap, and what remains.
struct Closed<'a> {
    names: Names<'a>,
    verdict: Verdict,
    /// Noise of each gyro over that of its dwells' standard errors.
    variances: Vec<f64>,
    noise_floor: NoiseFloor,
    gap: Gap,
    effects: Vec<NamedEffect>,
    closure: Option<HeldOut>,
    remaining: Remaining,
}

/// Stage 3: what remains beside the names says what the noise is; that, how much of the gap they close on dwells that
/// were not fitted.
fn closed(names: Names<'_>) -> Closed<'_> {
    let Names { settled, search, named, parts, told, fit, calibrated, .. } = &names;
    let frame = &settled.frame;
    let signs = closure::signs(settled, search, named, fit, &names.doubts, calibrated.augmented());
    let remains = signs.remain(named);
    let variances = closure::floor_variances(frame, fit, remains);
    let noise_floor = noise_floor::report(frame, &variances, !remains, calibrated.augmented());
    let gap = closure::gap(settled, search, &variances, &signs, named.is_empty(), &calibrated.plain);
    let verdict = match (named.is_empty(), remains) {
        (true, _) if gap.p_value >= GAP => Verdict::NoGap,
        (true, _) => Verdict::Unexplained,
        (false, false) => Verdict::Explained,
        (false, true) => Verdict::PartlyExplained,
    };
    let (floor_deg_per_h, may_be_noise) = (noise_floor.deg_per_h, signs.are_of_spread());
    let ground = ClosureReference { frame, fit, variances: &variances, floor_deg_per_h, remains, may_be_noise };
    let effects = closure::effects(settled, named, (parts, told), &ground, &signs);
    let all: Vec<&Part> = parts.iter().collect();
    let closure = (!parts.is_empty()).then(|| ground.held_out(&[], &all, fit.fitted.len()));
    let remaining = Remaining {
        rms_deg_per_h: noise_floor::rms(frame, fit.residuals.iter().map(Vec::as_slice)),
        reduced_chi2: calibrated.augmented().reduced_chi2().unwrap_or(1.0),
        // Where nothing is named the gap is what remains.
        p_value: if named.is_empty() { signs.p_value.min(gap.p_value) } else { signs.p_value },
        signs: signs.list,
    };
    Closed { verdict, variances, noise_floor, gap, effects, closure, remaining, names }
}

/// Stage 4: the answer, with what was not named and why, what the names do to the coefficients, and what to measure
/// next.
fn answer(campaign: &Campaign, closed: Closed) -> Diagnosis {
    let Closed { names, verdict, variances, noise_floor, gap, effects, closure, remaining } = closed;
    let Names { settled, search, named, parts, told, fit, calibrated, .. } = names;
    let (frame, bank) = (&settled.frame, &settled.bank);
    let classes: Vec<Vec<Effect>> = named.iter().map(Named::anywhere).collect();
    let g_confounders = identifiability::g_confounders(frame, bank, &parts);
    let mut noise = settled.noise_found.report(frame, &settled.laws);
    let of_fit = &calibrated.augmented().noise_found;
    if let (Some(memory), Some(of_fit)) = (&mut noise.memory, &of_fit.memory) {
        memory.deg_per_h.clone_from(&of_fit.deg_per_h);
        memory.kind = of_fit.kind;
    }
    let said = noise.notes();
    // Where nothing would be named the search does not ask whether gyros share noise; the fit always does.
    let is_silent = noise.between_gyros.is_empty() && noise.memory.is_none();
    let shared = of_fit.largest_correlation().filter(|_| is_silent);
    if shared.is_some() {
        noise.between_gyros.clone_from(&of_fit.between_gyros);
    }
    let shared = shared.map(|correlation| Note::Campaign(CampaignNote::NoiseShared { correlation }));
    let remains = matches!(verdict, Verdict::PartlyExplained | Verdict::Unexplained);
    // Beside the names; where they leave nothing and are in doubt themselves, without them.
    let is_named = |effect, shape| named.iter().any(|n| n.part.effect == effect && n.part.shape == shape);
    let mut described = if remains { settled.described(is_named) } else { Vec::new() };
    if remains && described.is_empty() && !named.is_empty() {
        described = settled.described(|_, _| false);
    }
    let description: Vec<Described> = described.into_iter().map(|(by, evidence)| Described { by, evidence }).collect();
    let described = description.first().map(|first| match description.get(1) {
        Some(second) => message!("described_by_two", first = first.by.word(), second = second.by.word()),
        None => message!("described_by", variable = first.by.word()),
    });
    let parts_of_time = parts_of_time(settled, &effects);
    let untold = told.iter().find(|part| part.adopted(frame).is_of_any_direction());
    let untold = untold.map(|part| message!("field_direction_untold", effect = part.effect.word()));
    let overstated = stated_errors::too_large(&calibrated).map(Note::Campaign);
    Diagnosis {
        terms: frame.terms,
        adopted: frame.adopted.clone(),
        hypotheses: frame.hypotheses.clone(),
        verdict,
        noise_floor,
        gap,
        located: where_in_campaign::located(frame, &variances),
        effects,
        closure,
        remaining,
        candidates: why_not_named::candidates(settled, &search, &named, &variances, remains),
        not_identifiable: identifiability::not_identifiable((frame, bank), (&parts, &variances), &g_confounders),
        impact: impact::impact(&calibrated, &campaign.geometry),
        next_dwells: next_dwells::next_dwells(frame, bank, &parts, &fit, &classes, &g_confounders),
        residuals: where_in_campaign::residuals(frame, &fit.residuals, &variances),
        of_campaign: frame.of_campaign.iter().cloned().chain(overstated).chain(shared).collect(),
        notes: (frame.notes.iter().cloned())
            .chain(stated_errors::too_small(&calibrated, remains))
            .chain(said)
            .chain(parts_of_time)
            .chain(untold)
            .chain(described)
            .collect(),
        noise,
        description,
    }
}

/// What acts in a part of the campaign only: names, and what stands for a name.
fn parts_of_time(settled: &SearchOutcome, effects: &[NamedEffect]) -> Vec<Message> {
    let hours = |s: f64| figure(s.clamp(0.0, settled.frame.setting.span()) / 3600.0, 1);
    let note = |effect: Effect, from: f64, to: f64| {
        message!("acts_in_part", effect = effect.word(), from = hours(from), to = hours(to))
    };
    let named = effects.iter().filter_map(|e| e.acts_in.map(|[from, to]| note(e.effect, from, to)));
    let suspects = settled.found.iter().filter_map(|c| match settled.bank.hypotheses[c.hypothesis].shape {
        Shape::Part { of, from, to } => Some(note(of, from, to)),
        _ => None,
    });
    named.chain(suspects).collect()
}
