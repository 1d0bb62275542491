//! Where a campaign and the error model part, which unmodelled effect parts them, and how far the gap shrinks.
//!
//! Reading order: [`answer`] (what comes out), `frame` (model (6) taken out of everything), `bank` and `evidence` (how
//! a candidate scores), `null` (what noise alone scores), `search` (which are adopted), `fit` (the augmented model).

mod answer;
mod bank;
mod basis;
mod evidence;
mod fit;
mod floor;
mod frame;
mod law;
mod located;
mod noise;
mod null;
mod search;

pub use answer::*;

use bank::{Bank, Kind};
use fit::{Fit, Part};
use frame::Frame;
use null::Null;
use search::{Choice, Search};

use super::campaign::Campaign;
use super::effects::suspects::SUSPECTS;
use super::effects::{Effect, Shape};
use super::model::Terms;
use super::mounting::Slot;

/// An effect that has entered the model: its regressors are fitted with model (6), its shape is held.
#[derive(Debug, Clone, PartialEq)]
pub struct Adopted {
    pub effect: Effect,
    pub shape: Shape,
    /// Gyros that have it; all of them for effects of the station.
    pub slots: Vec<Slot>,
}

/// What is compared with the campaign.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Terms of model (6) in use; the campaign's own where none are given.
    pub terms: Option<Terms>,
    /// Effects that the model in use holds already.
    pub adopted: Vec<Adopted>,
}

/// Why a campaign cannot be diagnosed at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    #[error(
        "{dwells} dwells leave nothing over the {parameters} parameters of the model: nothing can be held against it"
    )]
    TooFewDwells { dwells: usize, parameters: usize },
    #[error("the output of {0} is the same in every dwell")]
    NoOutput(&'static str),
    #[error("the geometry names no axes for {0}")]
    NoAxes(&'static str),
    #[error("the model holds no terms")]
    NoTerms,
}

/// Probability with which noise alone may get anything named.
const FALSE_ALARM: f64 = 0.005;

/// Diagnoses one campaign against the terms and effects in use.
///
/// Errors: [`Refusal`] where no residual can be formed at all. What merely cannot be tested (no temperature, no
/// attitude, no repeats) is said in `notes` and `not_identifiable`.
pub fn diagnose(campaign: &Campaign, options: &Options) -> Result<Diagnosis, Refusal> {
    let frame = Frame::of(campaign, options)?;
    let bank = Bank::of(&frame);
    let null = Null::of(&frame, &bank);
    let search = Search { frame: &frame, bank: &bank, threshold: null.threshold(FALSE_ALARM) };
    let found = search.run();
    let parts: Vec<Part> = found.iter().filter_map(|choice| part(&bank, choice)).collect();
    let fit = fit::fit(&frame, &parts);
    let gap = floor::gap(&frame, &fit.variances);
    let remaining = Remaining {
        rms_deg_per_h: floor::rms(&frame, fit.residuals.iter().map(Vec::as_slice)),
        reduced_chi2: 1.0,
        p_value: 1.0,
        signs: signs(&frame, &found, &null),
    };
    Ok(Diagnosis {
        verdict: match (parts.is_empty(), remaining.signs.is_empty()) {
            (true, true) => Verdict::NoGap,
            (true, false) => Verdict::Unexplained,
            (false, true) => Verdict::Explained,
            (false, false) => Verdict::PartlyExplained,
        },
        noise_floor: floor::report(&frame, &fit.variances, true),
        gap,
        located: located::located(&frame, &fit.variances),
        effects: named(&frame, &found, &parts, &fit, &null),
        closure: None,
        remaining,
        candidates: Vec::new(),
        not_identifiable: Vec::new(),
        impact: Vec::new(),
        next_dwells: Vec::new(),
        residuals: located::residuals(&frame, &fit.residuals, &fit.variances),
        notes: frame.notes.clone(),
    })
}

fn part(bank: &Bank, choice: &Choice) -> Option<Part> {
    match choice.kind {
        Kind::Effect(effect) => {
            Some(Part { effect, shape: bank.hypotheses[choice.hypothesis].shape, members: choice.members.clone() })
        }
        Kind::Suspect(_) => None,
    }
}

fn signs(frame: &Frame, found: &[Choice], null: &Null) -> Vec<Sign> {
    found
        .iter()
        .filter_map(|choice| match choice.kind {
            Kind::Suspect(i) => Some(Sign {
                kind: SUSPECTS[i].id,
                slots: slots(frame, &choice.members),
                p_value: null.p_value(choice.evidence),
            }),
            Kind::Effect(_) => None,
        })
        .collect()
}

fn slots(frame: &Frame, members: &[bool]) -> Vec<Slot> {
    (0..members.len()).filter(|&j| members[j]).map(|j| frame.setting.gyros[j].slot).collect()
}

fn named(frame: &Frame, found: &[Choice], parts: &[Part], fit: &Fit, null: &Null) -> Vec<NamedEffect> {
    let choices = found.iter().filter(|choice| matches!(choice.kind, Kind::Effect(_)));
    let total = floor::rms(frame, frame.gyros.iter().map(|gyro| gyro.residual.as_slice()));
    let left = floor::rms(frame, fit.residuals.iter().map(Vec::as_slice));
    parts
        .iter()
        .zip(choices)
        .enumerate()
        .map(|(p, (part, choice))| NamedEffect {
            effect: part.effect,
            class: vec![part.effect],
            gyros: slots(frame, &part.members),
            estimates: fit
                .fitted
                .iter()
                .filter(|f| f.part == p)
                .map(|f| Estimate {
                    slot: f.gyro.map(|j| frame.setting.gyros[j].slot),
                    name: f.coefficient.name,
                    value: f.value,
                    sd: f.sd,
                    unit: f.coefficient.unit,
                })
                .collect(),
            held_out: HeldOut {
                before_deg_per_h: total,
                after_deg_per_h: left,
                closure: 1.0 - (left / total).powi(2),
                interval: [0.0, 1.0],
            },
            p_value_adjusted: null.p_value(choice.evidence),
            detectability: (2.0 * choice.evidence).sqrt(),
        })
        .collect()
}
