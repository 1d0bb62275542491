//! The diagnosis of a campaign as `diagnose --format json` and `GET /v1/campaigns/{id}/diagnosis` answer it.

use super::forecast::{ChangedBody, ForecastPointBody};
use super::hypothesis::HypothesisBody;
use super::located::WhereBody;
use super::note;
use super::split::SplitBody;
use crate::core::augmented::Adopted;
use crate::core::calibrate::noise_found::{CorrelatedNoiseFound, LawFound, NoiseFound};
use crate::core::diagnose as core;
use crate::core::effects::{Effect, Estimate};
use crate::wire::prelude::*;
use crate::wire::unit;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DiagnosisBody {
    /// What the campaign was compared with.
    pub model: InUseBody,
    /// `no_gap`, `explained`, `partly_explained` or `unexplained`.
    pub verdict: String,
    pub noise_floor: NoiseFloorBody,
    pub gap: GapBody,
    #[serde(rename = "where")]
    pub located: WhereBody,
    /// Adopted effects in the order of adoption.
    pub effects: Vec<EffectBody>,
    /// Closure by all adopted effects together.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub closure: Option<HeldOutBody>,
    pub remaining: RemainingBody,
    pub candidates: Vec<CandidateBody>,
    pub not_identifiable: Vec<NotIdentifiableBody>,
    /// Coefficients that the named effects move beyond their noise.
    pub impact: Vec<ImpactBody>,
    /// Those that they move by less than that: plain and augmented values are equally good.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub impact_within_noise: Vec<ImpactBody>,
    pub next_dwells: Vec<NextDwellBody>,
    pub residuals: Vec<ResidualBody>,
    pub notes: Vec<String>,
    /// What the noise is beyond white, independent and as stated, where something is found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseFoundBody>,
    /// What is left goes with, the strongest first: no cause.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub description: Vec<DescribedBody>,
    /// The notes for programs.
    #[serde(default)]
    pub note_codes: Vec<MessageBody>,
    /// The gap against a reference, where one was given.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub reference: Option<SplitBody>,
    /// Effects of the model in use as this campaign shows them, where the model holds the coefficients of the IMU.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub effects_against_model: Option<ChangedBody>,
    /// What was foretold of this campaign by the model in force before it; of stored campaigns.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub forecast: Option<ForecastPointBody>,
    /// Hypotheses of one's own that competed with the catalogue.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub hypotheses: Vec<HypothesisBody>,
}

impl DiagnosisBody {
    /// Says in `language` why candidates were not taken, what cannot be told, and what is noted.
    #[must_use]
    pub fn said_in(mut self, language: Language) -> Self {
        for candidate in &mut self.candidates {
            candidate.why_not = candidate.finding.say(language);
        }
        for one in &mut self.not_identifiable {
            one.reason = one.finding.say(language);
            let own = self.hypotheses.iter().any(|own| own.id == one.effect).then(|| message!("needed_for_ones_own"));
            let needs = Effect::from_id(&one.effect).map(Effect::needs).or(own);
            one.needs = needs.map_or_else(String::new, |needs| language.words(&needs));
        }
        self.notes = self.note_codes.iter_mut().map(|note| note.say(language)).collect();
        if let Some(reference) = &mut self.reference {
            reference.say(language);
        }
        if let Some(forecast) = &mut self.forecast {
            forecast.say(language);
        }
        self
    }

    /// With what was foretold of the campaign, which is noted where it lies outside.
    #[must_use]
    pub fn with_forecast(self, forecast: Option<ForecastPointBody>) -> Self {
        let finding = forecast.as_ref().and_then(ForecastPointBody::finding);
        Self { forecast, ..self.noted(finding) }
    }

    /// With further notes.
    #[must_use]
    pub fn noted(mut self, notes: impl IntoIterator<Item = Message>) -> Self {
        for note in notes {
            self.notes.push(asked().words(&note));
            self.note_codes.push(MessageBody::of(&note, asked()));
        }
        self
    }

    /// The verdict in a sentence or two.
    pub fn verdict_in_words(&self, language: Language) -> String {
        let verdict = match self.verdict.as_str() {
            "no_gap" => message!("diagnosis_no_gap"),
            "explained" => message!("diagnosis_explained"),
            "partly_explained" => message!("diagnosis_partly_explained"),
            _ => message!("diagnosis_unexplained"),
        };
        // Single dwells that stand out are in the noise of repeats as well.
        let of_single_dwells = self.remaining.signs.iter().any(|sign| !sign.pointers.is_empty());
        let is_small = self.gap.rms_deg_per_h <= self.gap.noise_alone_deg_per_h;
        let by_pattern = self.verdict != "no_gap" && is_small && !of_single_dwells;
        let by_pattern = by_pattern.then(|| message!("diagnosis_by_pattern"));
        language.sentences(&[verdict].into_iter().chain(by_pattern).collect::<Vec<_>>()).into_owned()
    }

    /// D_I and D_S of every gyro before and after the named effects entered the model, in order, and whether they
    /// moved beyond their noise.
    pub fn drift_before_and_after(&self) -> Vec<(&ImpactBody, bool)> {
        let moved = self.impact.iter().map(|one| (one, true));
        let mut all: Vec<_> = moved.chain(self.impact_within_noise.iter().map(|one| (one, false))).collect();
        all.sort_by_key(|(one, _)| (one.slot.as_str(), one.coefficient.as_str()));
        all
    }
}

/// The error model in use.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InUseBody {
    pub terms: Vec<String>,
    /// Effects beyond the terms, fitted with them.
    pub effects: Vec<InUseEffectBody>,
}

impl InUseBody {
    /// Its terms, and the effects that it holds beside them: `bias, g_linear + warmup (G1 G2)`.
    pub fn listed(&self) -> String {
        let effects = self.effects.iter().map(|e| format!(" + {} ({})", e.effect, e.gyros.join(" ")));
        self.terms.join(", ") + &effects.collect::<String>()
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct InUseEffectBody {
    pub effect: String,
    pub gyros: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NoiseFloorBody {
    pub deg_per_h: f64,
    pub source: String,
    pub sem_factor: f64,
    pub gyros: Vec<GyroFloorBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GyroFloorBody {
    pub slot: String,
    pub deg_per_h: f64,
    pub repeat_dof: usize,
}

/// One thing that what is left goes with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DescribedBody {
    /// `time`, `temperature`, `rate_of_temperature`, `up_direction`, `heading`, `rate_level`, `rate_axis`,
    /// `rate_history`, `previous_orientation`, `orientation_age` or `phase`; of two together `time_and_force`,
    /// `time_and_rate`, `time_and_heading`, `temperature_and_force`, `temperature_and_rate`, `temperature_and_heading` or
    /// `temperature_and_time`; `single_dwells` where it lies in a few.
    pub by: String,
    /// ln of the odds against noise.
    pub evidence: f64,
}

/// Noise beyond white, independent and as stated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NoiseFoundBody {
    /// Correlation of each pair of gyros.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub between_gyros: Vec<CorrelationBody>,
    /// A bias that wanders from dwell to dwell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flicker: Option<MemoryBody>,
    /// With what power of duration the noise falls, where the standard errors do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub falls_with_duration: Option<f64>,
    /// How many times the noise is as large at the fastest rate as at rest, where the standard errors do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grows_with_rate: Option<f64>,
    /// How many times the noise is as large at the end as at the beginning, where the standard errors do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grows_in_time: Option<f64>,
    /// Whether a growth that is said is the most that is tried: the true one may be larger, or smaller of a fall.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub growth_is_bound: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CorrelationBody {
    pub gyros: [String; 2],
    pub correlation: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MemoryBody {
    /// `flicker` or `random_walk`, whichever is likelier.
    pub kind: String,
    /// Standard deviation of the wander; of a random walk at mid-campaign.
    pub gyros: Vec<GyroMemoryBody>,
    pub probability: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GyroMemoryBody {
    pub slot: String,
    pub deg_per_h: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GapBody {
    /// Root mean square of the residuals.
    pub rms_deg_per_h: f64,
    /// What noise alone would leave of that.
    #[serde(default)]
    pub noise_alone_deg_per_h: f64,
    pub reduced_chi2: f64,
    pub p_value: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EffectBody {
    pub effect: String,
    /// Every entry that this campaign cannot tell from it, itself included.
    pub class: Vec<String>,
    /// Gyros in which more would do as well, as far as that gyro alone can say.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub wider_in: Vec<GyroClassBody>,
    pub gyros: Vec<String>,
    /// From when to when it acts, s after the first dwell, where that is not the whole campaign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acts_in: Option<[f64; 2]>,
    pub estimates: Vec<EstimateBody>,
    pub held_out: HeldOutBody,
    pub p_value_adjusted: f64,
    pub detectability: f64,
    /// What it adds in each dwell of the gyros that have it, at the estimates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drift: Vec<EffectDriftBody>,
}

/// What an effect adds to the drift of one gyro, dwell by dwell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EffectDriftBody {
    pub slot: String,
    pub deg_per_h: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GyroClassBody {
    pub slot: String,
    /// All that would do, the named effect first.
    pub class: Vec<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EstimateBody {
    /// `all` for a coefficient that the gyros share.
    pub slot: String,
    pub name: String,
    pub value: f64,
    pub sd: f64,
    pub unit: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct HeldOutBody {
    pub before_deg_per_h: f64,
    pub after_deg_per_h: f64,
    /// Of the reducible gap: of what the error on held-out dwells exceeds the noise floor by (mean squares).
    pub closure: f64,
    pub interval: [f64; 2],
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RemainingBody {
    pub rms_deg_per_h: f64,
    pub reduced_chi2: f64,
    pub p_value: f64,
    pub signs: Vec<SignBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SignBody {
    pub kind: String,
    pub gyros: Vec<String>,
    /// JSON pointers of the dwells that stand out, where it is of single ones.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pointers: Vec<String>,
    pub p_value: f64,
}

impl SignBody {
    /// What shows that more remains, and in which single dwells.
    pub fn in_words(&self, language: Language) -> String {
        let words = sign_word(&self.kind, language);
        match self.pointers.as_slice() {
            [] => words.to_owned(),
            dwells => format!("{words} ({})", dwells.join(", ")),
        }
    }
}

/// The words of a sign: those of a test, or of a competing hypothesis.
pub fn sign_word(kind: &str, language: Language) -> &str {
    let words = ["sign_", "effect_"].map(|prefix| language.word(&format!("{prefix}{kind}")));
    words.into_iter().find(|word| !word.is_empty()).unwrap_or(kind)
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CandidateBody {
    pub effect: String,
    /// Fraction of the reducible gap that it closes alone; null where it could not be tried.
    #[schema(required)]
    pub closure: Option<f64>,
    /// 95 % interval of that.
    #[schema(required)]
    pub interval: Option<[f64; 2]>,
    pub p_value_adjusted: f64,
    /// Whether noise alone shows as much too often for a name: `closure` is then that of a chance pattern, and no
    /// finding.
    #[serde(default)]
    pub within_noise: bool,
    pub gyros: Vec<String>,
    /// In the language that the request asks for.
    pub why_not: String,
    /// The same for programs.
    #[serde(default)]
    pub finding: MessageBody,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NotIdentifiableBody {
    pub effect: String,
    pub visible_fraction: f64,
    /// What it is hard to tell from in this campaign.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub confounded_with: Vec<String>,
    /// In the language that the request asks for.
    pub reason: String,
    /// What a campaign must hold for the effect to show.
    pub needs: String,
    /// The reason for programs.
    #[serde(default)]
    pub finding: MessageBody,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ImpactBody {
    pub slot: String,
    pub coefficient: String,
    pub plain: f64,
    /// As the campaign itself states it; none in diagnoses of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plain_sd: Option<f64>,
    pub augmented: f64,
    pub augmented_sd: f64,
    pub shift: f64,
    pub of_budget: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NextDwellBody {
    pub phase: String,
    pub specific_force_g0: [f64; 3],
    pub rate_arcsec_s: [f64; 3],
    /// How the table is set for it; none in diagnoses of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<TableBody>,
    pub separates: Vec<String>,
}

/// How a table is set for a dwell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TableBody {
    /// Which body direction points up, and which north.
    pub up: [f64; 3],
    pub north: [f64; 3],
    /// About the vertical, without the Earth's.
    pub rate_deg_s: f64,
}

impl TableBody {
    /// A body direction as a person sets it: `+X`, `+Z 30° +X` (thirty degrees from +Z towards +X), else its components.
    pub fn direction(of: [f64; 3]) -> String {
        let mut axes: Vec<(f64, char)> = of.into_iter().zip(['X', 'Y', 'Z']).filter(|(x, _)| x.abs() > 1e-3).collect();
        axes.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        let signed = |(x, axis): (f64, char)| format!("{}{axis}", if x < 0.0 { '-' } else { '+' });
        match axes[..] {
            [one] => signed(one),
            [far, near] => {
                let angle = near.0.abs().atan2(far.0.abs()).to_degrees();
                format!("{} {angle:.0}° {}", signed(far), signed(near))
            }
            _ => of.map(|x| format!("{x:.4}")).join(" "),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResidualBody {
    pub index: usize,
    pub slot: String,
    pub before_deg_per_h: f64,
    pub after_deg_per_h: f64,
    pub sd_deg_per_h: f64,
}

bodies! {
    DiagnosisBody of core::Diagnosis: model: |d| d.into(), verdict: |d| d.verdict.name().to_owned(), noise_floor, gap,
        located, effects, closure, remaining, candidates, not_identifiable, impact: |d| impact(d, true),
        impact_within_noise: |d| impact(d, false), next_dwells, residuals, notes: |d| noted(d).to_body(),
        noise: |d| (!d.noise.is_empty()).then(|| (&d.noise).into()), description, note_codes: |d| noted(d).to_body(),
        reference: |_| None, effects_against_model: |_| None, forecast: |_| None,
        hypotheses: |d| d.hypotheses.iter().filter_map(|own| Some((&own.hypothesis()?.written).into())).collect();
    InUseBody of core::Diagnosis: terms: |d| d.terms.iter().map(|term| term.name().to_owned()).collect(),
        effects = adopted;
    InUseEffectBody of Adopted: effect, gyros = slots;
    NoiseFoundBody of NoiseFound: between_gyros, flicker = memory,
        falls_with_duration: |noise| by_law(noise, |law| match law {
            LawFound::Duration { power } => Some(power),
            _ => None,
        }),
        grows_with_rate: |noise| by_law(noise, |law| match law {
            LawFound::Rate { times, .. } => Some(times),
            _ => None,
        }),
        grows_in_time: |noise| by_law(noise, |law| match law {
            LawFound::Time { times, .. } => Some(times),
            _ => None,
        }),
        growth_is_bound: |noise| noise.laws.iter().any(|law| law.is_bound());
    CorrelationBody of (Slot, Slot, f64): gyros: |(a, b, _)| [*a, *b].to_body(), correlation = 2;
    MemoryBody of CorrelatedNoiseFound: kind, gyros = deg_per_h, probability;
    GyroMemoryBody of (Slot, f64): slot = 0, deg_per_h = 1;
    GyroClassBody of (Slot, Vec<Effect>): slot = 0, class = 1;
    EffectDriftBody of (Slot, Vec<f64>): slot = 0,
        deg_per_h: |(_, drift)| drift.iter().map(|v| (v * 1e9).round() / 1e9).collect();
    HeldOutBody of core::HeldOut: before_deg_per_h, after_deg_per_h, closure, interval;
    GyroFloorBody of core::GyroFloor: slot, deg_per_h, repeat_dof;
    NoiseFloorBody of core::NoiseFloor: deg_per_h, source, sem_factor, gyros;
    GapBody of core::Gap: rms_deg_per_h, noise_alone_deg_per_h, reduced_chi2, p_value;
    EffectBody of core::NamedEffect: effect, class, wider_in, gyros, acts_in, estimates, held_out, p_value_adjusted,
        detectability, drift;
    RemainingBody of core::Remaining: rms_deg_per_h, reduced_chi2, p_value, signs;
    SignBody of core::Sign: kind, gyros = slots, p_value,
        pointers: |sign| sign.dwells.iter().map(|k| format!("/dwells/{k}")).collect();
    ImpactBody of core::Impact: slot, coefficient, plain, plain_sd, augmented, augmented_sd, shift, of_budget;
    ResidualBody of core::Residual: index, slot, before_deg_per_h, after_deg_per_h, sd_deg_per_h;
    DescribedBody of core::Described: by, evidence;
    EstimateBody of Estimate: slot, name, value, sd, unit: |estimate| unit::of_machines(estimate.unit);
    CandidateBody of core::Candidate: effect, closure, interval, p_value_adjusted, within_noise, gyros, why_not,
        finding = why_not;
    NotIdentifiableBody of core::NotIdentifiable: effect, visible_fraction, confounded_with, reason,
        needs: |one| one.effect.needs().to_body(), finding = reason;
    NextDwellBody of core::NextDwell: phase, specific_force_g0, rate_arcsec_s, table: |next| Some(next.into()),
        separates;
    TableBody of core::NextDwell: up: |next| next.attitude.column(2).into_owned().into(),
        north: |next| next.attitude.column(1).into_owned().into(), rate_deg_s: |next| next.table_rate_arcsec_s / 3600.0;
}

/// How the noise goes by one law, where that is found.
fn by_law(noise: &NoiseFound, of: fn(LawFound) -> Option<f64>) -> Option<f64> {
    noise.laws.iter().rev().find_map(|law| of(*law))
}

fn noted(d: &core::Diagnosis) -> Vec<Message> {
    d.of_campaign.iter().map(note::message).chain(d.notes.iter().cloned()).collect()
}

fn impact(d: &core::Diagnosis, is_material: bool) -> Vec<ImpactBody> {
    d.impact.iter().filter(|one| one.is_material() == is_material).map(ImpactBody::from).collect()
}

/// Residuals of a diagnosis as they were answered; those of unknown slots are left out.
pub fn residuals(bodies: &[ResidualBody]) -> Vec<core::Residual> {
    let residual = |body: &ResidualBody| {
        let ResidualBody { index, before_deg_per_h, after_deg_per_h, sd_deg_per_h, .. } = *body;
        let slot = Slot::from_name(&body.slot)?;
        Some(core::Residual { index, slot, before_deg_per_h, after_deg_per_h, sd_deg_per_h })
    };
    bodies.iter().filter_map(residual).collect()
}
