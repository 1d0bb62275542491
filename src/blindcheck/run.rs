//! A blind run from seed to scores: seal the key, diagnose from text alone, open the key, score.

use std::time::Instant;

use rayon::prelude::*;

use crate::core::fault::Faults;
use crate::simulate::truth::{Key, KeyEntry, OUTSIDE};
use crate::wire;

use super::answer::Answer;
use super::draw::{Case, Draw};
use super::score::{CampaignTruth, Score};

/// Turns the JSON of a campaign into what a diagnosis of it says.
pub type CampaignDiagnoser<'a> = dyn Fn(&str) -> Result<Answer, String> + Sync + 'a;

/// A campaign that somebody made, as it lies in a folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Foreign {
    pub name: String,
    pub text: String,
    pub key: KeyEntry,
}

/// File name of a drawn campaign.
pub fn file_name(number: usize) -> String {
    format!("campaign-{number:05}.json")
}

/// The key of a drawn run of `count` campaigns. Diagnosis has not begun when this is sealed.
pub fn key(draw: &Draw, count: usize) -> Key {
    let entry = |number| (file_name(number), draw.trial(number).simulated.truth);
    (0..count).into_par_iter().map(entry).collect::<Vec<_>>().into_iter().collect()
}

/// The text of a key, as it is sealed and revealed.
pub fn key_text(key: &Key) -> String {
    serde_json::to_string_pretty(key).expect("a key holds numbers and names only")
}

/// Diagnoses and scores the drawn campaigns; `done` is called after each.
pub fn drawn(draw: &Draw, count: usize, diagnose: &CampaignDiagnoser<'_>, done: &(dyn Fn() + Sync)) -> Vec<Score> {
    (0..count)
        .into_par_iter()
        .map(|number| {
            let trial = draw.trial(number);
            let text = wire::campaign::to_json(&trial.simulated.campaign);
            let (answer, milliseconds) = timed(&text, diagnose);
            let slots: Vec<String> =
                trial.simulated.campaign.gyros.iter().map(|gyro| gyro.slot.name().to_owned()).collect();
            let known = CampaignTruth {
                campaign: &file_name(number),
                case: trial.case,
                key: &trial.simulated.truth,
                slots: &slots,
                simulated: Some(&trial.simulated),
            };
            let score = known.score(&answer, milliseconds);
            done();
            score
        })
        .collect()
}

/// Diagnoses and scores campaigns of another maker.
pub fn foreign(
    campaigns: &[Foreign],
    diagnose: &CampaignDiagnoser<'_>,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Score>, Faults> {
    campaigns
        .par_iter()
        .map(|one| {
            let slots = slots(one)?;
            let (answer, milliseconds) = timed(&one.text, diagnose);
            let case = case_of(&one.key);
            let known = CampaignTruth { campaign: &one.name, case, key: &one.key, slots: &slots, simulated: None };
            done();
            Ok(known.score(&answer, milliseconds))
        })
        .collect()
}

pub(super) fn timed(text: &str, diagnose: &CampaignDiagnoser<'_>) -> (Result<Answer, String>, f64) {
    let begun = Instant::now();
    let answer = diagnose(text);
    (answer, begun.elapsed().as_secs_f64() * 1e3)
}

fn slots(one: &Foreign) -> Result<Vec<String>, Faults> {
    let campaign = wire::campaign::parse_json(one.text.as_bytes())?;
    Ok(campaign.gyros.iter().map(|gyro| gyro.slot.name().to_owned()).collect())
}

/// What a key without a word for it tries: d below 1 cannot be seen, below 7.5 is faint.
pub fn case_of(key: &KeyEntry) -> Case {
    match key.effects.as_slice() {
        [] => Case::Clean,
        ids if ids.iter().any(|id| id == OUTSIDE) => Case::Outside,
        _ if key.seen < 1.0 => Case::Unseen,
        [_] if key.seen < 7.5 => Case::Faint,
        [_] => Case::One,
        _ => Case::Pair,
    }
}
