//! What is read of a diagnosis: its JSON as users get it, and of that only what the score needs.

use serde::Deserialize;

/// The diagnosis of one campaign.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Answer {
    pub verdict: String,
    #[serde(default)]
    pub effects: Vec<AnsweredEffect>,
    /// Closure by all adopted effects together.
    pub closure: Option<AnsweredHeldOut>,
    /// What the noise is beyond white and independent, where the answer says it.
    pub noise: Option<serde_json::Value>,
    /// What is left goes with, the strongest first.
    #[serde(default)]
    pub description: Vec<Described>,
    #[serde(default)]
    pub not_identifiable: Vec<Unseen>,
    /// Coefficients that are reported as moved.
    #[serde(default)]
    pub impact: Vec<AnsweredShift>,
    #[serde(default)]
    pub impact_within_noise: Vec<AnsweredShift>,
}

/// An adopted effect.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct AnsweredEffect {
    pub effect: String,
    #[serde(default)]
    pub class: Vec<String>,
    #[serde(default)]
    pub gyros: Vec<String>,
    pub held_out: Option<AnsweredHeldOut>,
    /// The part of the campaign in which it acts, where that is not all of it.
    pub acts_in: Option<serde_json::Value>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct AnsweredHeldOut {
    pub closure: Option<f64>,
    pub interval: Option<[f64; 2]>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Described {
    pub by: String,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Unseen {
    pub effect: String,
}

/// By how much a coefficient moves when the adopted effects are in the model: augmented less plain.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct AnsweredShift {
    pub slot: String,
    pub coefficient: String,
    pub shift: f64,
    /// The coefficient without the adopted effects.
    pub plain: Option<f64>,
}

impl AnsweredEffect {
    /// Whether this entry means `id`: by name, or as a member of the class that cannot be told apart.
    pub fn means(&self, id: &str) -> bool {
        self.effect == id || self.class.iter().any(|member| member == id)
    }

    /// The closure that it claims, and the interval of that.
    pub fn claim(&self) -> Option<(f64, [f64; 2])> {
        self.held_out.and_then(|held| held.closure.zip(held.interval))
    }
}

impl Answer {
    /// Whether an effect is among those that this campaign cannot show.
    pub fn lists_as_unseen(&self, id: &str) -> bool {
        self.not_identifiable.iter().any(|entry| entry.effect == id)
    }
}
