//! What the model of an IMU foretells of a campaign, and how far it came true.

use super::time;
use crate::core::campaign::Campaign;
use crate::core::effects;
use crate::core::id::Id;
use crate::core::imu_model::{
    Changed, ChangedEffect, DriftShift, ErrorReduction, Forecast, ForecastComparison, GyroComparison, GyroForecast,
    Identified, InformativeDwell, ModelStep, OutlyingDwell,
};
use crate::core::judge;
use crate::core::judge::{Coefficient, Finding, Limit, LimitKey, Limits, Rule, State, Unseen, Verdict};
use crate::core::message::{figure, p_value as probability, text};
use crate::wire::prelude::*;
use crate::wire::unit;

/// Forecast of one campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ForecastBody {
    pub imu: String,
    pub station: String,
    pub measured_at: String,
    pub model: ForecastModelBody,
    pub gyros: Vec<GyroForecastBody>,
    /// What the adopted effects should take away of the forecast error; none without effects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub promised: Option<ClosingBody>,
    /// Where the campaign is still to be measured: the dwells that tell most of what the model does not know, the best
    /// first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub next_dwells: Vec<TellingBody>,
    /// Where the campaign is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<ComparedBody>,
    /// The model's effects as this campaign shows them; none without effects, or where they cannot be fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effects_against_model: Option<ChangedBody>,
    /// What is left out, and what lies outside the model's validity.
    pub notes: Vec<String>,
    pub note_codes: Vec<MessageBody>,
}

/// Forecasts of the stored campaigns of an IMU, each from the model in force when it came in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ForecastSeriesBody {
    pub imu: String,
    /// Oldest first.
    pub points: Vec<ForecastPointBody>,
    /// The newest forecast, dwell by dwell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latest: Option<ForecastBody>,
}

/// The forecast of one stored campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ForecastPointBody {
    /// Its identifier.
    pub campaign: String,
    /// The adopted model that was in force when it came in; none for the plain one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imu_model: Option<String>,
    pub measured_at: String,
    pub station: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<ForecastModelBody>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub promised: Option<ClosingBody>,
    /// Without what is said dwell by dwell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<ComparedBody>,
    /// Adopted effects whose coefficients are others in this campaign.
    pub effects_changed: Vec<String>,
    pub notes: Vec<String>,
    #[serde(default)]
    pub note_codes: Vec<MessageBody>,
    /// Why nothing was foretold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why_not: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why_not_code: Option<MessageBody>,
}

impl ForecastPointBody {
    /// What was foretold of a campaign, dwells left out, or why nothing was.
    pub fn of(id: &Id, campaign: &Campaign, imu_model: Option<Id>, told: Result<&ForecastBody, &Message>) -> Self {
        let forecast = told.ok();
        let effects = forecast.and_then(|forecast| forecast.effects_against_model.as_ref());
        let changed = effects.into_iter().flat_map(|body| &body.effects).filter(|effect| effect.changed);
        let mut effects_changed: Vec<String> = changed.map(|effect| effect.effect.clone()).collect();
        effects_changed.dedup();
        Self {
            campaign: id.to_string(),
            imu_model: imu_model.map(|id| id.to_string()),
            measured_at: time::format(campaign.measured_at),
            station: campaign.station.to_string(),
            model: forecast.map(|forecast| forecast.model.clone()),
            promised: forecast.and_then(|forecast| forecast.promised),
            compared: forecast.and_then(|forecast| forecast.compared.clone()).map(ComparedBody::without_dwells),
            effects_changed,
            notes: forecast.map(|forecast| forecast.notes.clone()).unwrap_or_default(),
            note_codes: forecast.map(|forecast| forecast.note_codes.clone()).unwrap_or_default(),
            why_not: told.err().map(ToBody::to_body),
            why_not_code: told.err().map(ToBody::to_body),
        }
    }

    /// Its notes, or why nothing was foretold, in `language`.
    pub fn say(&mut self, language: Language) {
        self.notes = self.note_codes.iter_mut().map(|note| note.say(language)).collect();
        if let Some(why) = &mut self.why_not_code {
            self.why_not = Some(why.say(language));
        }
        if let Some(verdict) = self.compared.as_mut().and_then(|compared| compared.verdict.as_mut()) {
            verdict.say(language);
        }
    }

    /// The comparison where the campaign lies outside its forecast, and that is a finding: of a model that somebody has
    /// adopted, or of campaigns enough to know what changes from one to the next.
    pub fn outside(&self) -> Option<&ComparedBody> {
        let knows_ageing = self.imu_model.is_some() || self.model.as_ref().is_some_and(|model| model.campaigns > 1);
        self.compared.as_ref().filter(|compared| compared.is_outside() && knows_ageing)
    }

    /// [`Self::outside`] as a note.
    pub fn finding(&self) -> Option<Message> {
        let compared = self.outside()?;
        let LargestForecastError { slot, rms_over_sd, p_value } = compared.furthest()?;
        let effects = &self.effects_changed;
        let (slot, rms, p) = (text(slot), figure(rms_over_sd, 2), probability(p_value));
        Some(match effects.as_slice() {
            [] => message!("campaign_outside_forecast", slot, rms, p),
            _ => {
                let effects = text(effects.join(", "));
                message!("campaign_outside_forecast_changed", slot, rms, p, effects)
            }
        })
    }
}

/// The model that foretold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ForecastModelBody {
    /// When the newest of its campaigns was measured.
    pub measured_at: String,
    pub campaigns: usize,
    pub effects: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_temperature_c: Option<f64>,
}

/// By dwell, deg/h: pulse/s over `scale_pulse_per_arcsec`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GyroForecastBody {
    pub slot: String,
    pub serial: String,
    pub scale_pulse_per_arcsec: f64,
    pub predicted_pulse_s: Vec<f64>,
    /// Of the output: model, campaign to campaign, noise.
    pub sd_pulse_s: Vec<f64>,
    /// Of the noise alone.
    pub noise_sd_pulse_s: Vec<f64>,
    /// Dwells of which the model's campaigns say nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_foretold: Vec<usize>,
}

/// A dwell that is worth measuring.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TellingBody {
    pub dwell: usize,
    pub specific_force_g0: Triple,
    pub rate_arcsec_s: Triple,
    /// What it tells of the coefficients beside those before it, nats.
    pub information: f64,
    /// Standard deviation of what is foretold of it, in those of its noise.
    pub sd_over_noise: f64,
}

/// How much of the forecast error above the noise goes away with the adopted effects.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ClosingBody {
    /// Root mean square of the error without and with them.
    pub before_deg_per_h: f64,
    pub after_deg_per_h: f64,
    /// 1 - (after^2 - noise^2)/(before^2 - noise^2). Without an interval it says nothing.
    pub closure: f64,
    /// 95 %; none where the error without them does not exceed the noise.
    #[schema(required)]
    pub interval: Option<[f64; 2]>,
}

/// A gyro, the root mean square of its errors over their standard deviations, and the p of such over all gyros.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LargestForecastError {
    /// Empty in digests of before.
    #[serde(default)]
    pub slot: String,
    pub rms_over_sd: f64,
    pub p_value: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ComparedBody {
    /// `as_foretold`, `outside` or `indeterminate`: what the rule `forecast` says, also where nobody has adopted the
    /// model or the rule is switched off (then with the limits that are built in).
    pub state: String,
    /// By the rule `forecast`; none where no model was adopted, or the rule is switched off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<ForecastVerdictBody>,
    /// Dwells times gyros that were foretold.
    pub count: usize,
    pub rms_over_sd: f64,
    pub rms_deg_per_h: f64,
    pub noise_deg_per_h: f64,
    pub p_value: f64,
    /// Kolmogorov's test that the probability integral transform of the independent errors is uniform.
    pub pit_p_value: f64,
    pub gyros: Vec<GyroComparedBody>,
    /// Dwells beyond what chance has in 1 % of campaigns, the furthest first.
    pub missed: Vec<MissBody>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub closing: Option<ClosingBody>,
    /// Model (6) alone, then effect by effect.
    pub ladder: Vec<RungBody>,
}

/// The campaign judged against its forecast, by the gyro that is furthest from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ForecastVerdictBody {
    /// `within`, `indeterminate` or `exceeded`.
    pub state: String,
    pub slot: String,
    /// Root mean square of its independent errors over their standard deviations.
    pub value: f64,
    /// By chance one campaign of 500 without a change has a gyro beyond its limit.
    pub limit: f64,
    /// Of errors as large, over all gyros.
    pub p_value: f64,
    /// The dwell that is furthest from its forecast, and its error in standard deviations.
    pub dwell: Option<usize>,
    pub z: Option<f64>,
    /// Of D_I or D_S, the smallest that would show in every gyro in 95 %, deg/(h*g0); none where none would.
    pub smallest_step: Option<f64>,
    /// What of the campaign the model has not seen, as a note of the forecast says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen: Option<String>,
    /// Campaigns that the model was fitted to.
    pub campaigns: usize,
    pub reason: String,
    pub reason_codes: Vec<MessageBody>,
}

impl ForecastVerdictBody {
    /// None of a verdict by another rule.
    pub fn of(verdict: &Verdict) -> Option<Self> {
        let Finding::Forecast { slot, furthest, p, step, campaigns, unseen } = verdict.finding else { return None };
        let said = verdict.messages();
        Some(Self {
            state: verdict.state.name().to_owned(),
            slot: slot.name().to_owned(),
            value: verdict.value?,
            limit: verdict.limit,
            p_value: p,
            dwell: furthest.map(|(dwell, _)| dwell),
            z: furthest.map(|(_, z)| z),
            smallest_step: step,
            unseen: unseen.map(|unseen| unseen.name().to_owned()),
            campaigns,
            reason: asked().sentences(&said).into_owned(),
            reason_codes: said.to_body(),
        })
    }

    /// The verdict that it is; none where a later version wrote what this one does not know.
    pub fn verdict(&self) -> Option<Verdict> {
        let unseen = self.unseen.as_deref().map(|name| Unseen::from_name(name).ok_or(())).transpose().ok()?;
        Some(Verdict {
            coefficient: Coefficient::All,
            rule: Rule::Forecast,
            state: State::from_name(&self.state)?,
            value: Some(self.value),
            limit: self.limit,
            limit_from: LimitKey::BUDGET,
            sd: None,
            probability: None,
            between: None,
            confirmed: false,
            finding: Finding::Forecast {
                slot: Slot::from_name(&self.slot)?,
                furthest: self.dwell.zip(self.z),
                p: self.p_value,
                step: self.smallest_step,
                campaigns: self.campaigns,
                unseen,
            },
        })
    }

    /// Whether the campaign came out as forecast.
    pub fn is_within(&self) -> bool {
        self.state == State::Within.name()
    }

    fn say(&mut self, language: Language) {
        let said: Vec<Message> = self.verdict().map(|verdict| verdict.messages()).unwrap_or_default();
        self.reason = language.sentences(&said).into_owned();
        self.reason_codes = said.iter().map(|message| MessageBody::of(message, language)).collect();
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct GyroComparedBody {
    pub slot: String,
    pub rms_over_sd: f64,
    pub p_value: f64,
    /// By dwell.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub error_pulse_s: Vec<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub z: Vec<f64>,
    /// Probability integral transform of the independent errors, of the dwells that are foretold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pit: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MissBody {
    pub slot: String,
    pub dwell: usize,
    pub z: f64,
}

/// One step of the ladder of models.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RungBody {
    /// The effect that joins here; none for model (6) alone.
    #[schema(required)]
    pub effect: Option<String>,
    pub rms_deg_per_h: f64,
    pub rms_over_sd: f64,
}

/// The model's effects then and now.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ChangedBody {
    pub effects: Vec<ChangedEffectBody>,
    /// D_I and D_S with the changed effects as the campaign has them, less those with the model's.
    pub shifts: Vec<ShiftBody>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ChangedEffectBody {
    pub effect: String,
    /// `all` for one that the gyros share.
    pub slot: String,
    pub coefficients: Vec<ThenNowBody>,
    /// Adjusted for everything that is compared.
    pub p_value: f64,
    /// p below 0.001, and the model with this campaign's coefficients leaves no gap.
    pub changed: bool,
    /// p below 0.001, but the diagnosis finds more in the gyro than the model holds: whether the coefficient or that has
    /// changed cannot be told.
    #[serde(default)]
    pub undecided: bool,
    /// Undecided because the campaign lies beyond the temperatures that the model has seen: the effect may be bent there.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub beyond_seen: bool,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ThenNowBody {
    pub name: String,
    pub unit: String,
    pub model: f64,
    pub model_sd: f64,
    pub now: f64,
    pub now_sd: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ShiftBody {
    pub slot: String,
    pub coefficient: String,
    pub shift: f64,
    pub sd: f64,
}

/// The state of a campaign that lies outside its forecast.
const OUTSIDE: &str = "outside";

impl ForecastBody {
    /// A forecast as answers write it. `promised` is how far the effects are to close the forecast error.
    pub fn of(model: &Identified, campaign: &Campaign, forecast: &Forecast, promised: Option<ErrorReduction>) -> Self {
        Self {
            imu: campaign.imu.to_string(),
            station: campaign.station.to_string(),
            measured_at: time::format(campaign.measured_at),
            model: model.to_body(),
            gyros: forecast.gyros.to_body(),
            promised: promised.to_body(),
            next_dwells: Vec::new(),
            compared: None,
            effects_against_model: None,
            notes: forecast.notes.to_body(),
            note_codes: forecast.notes.to_body(),
        }
    }

    /// With the dwells that are worth measuring.
    pub fn to_measure(mut self, campaign: &Campaign, informative: &[InformativeDwell]) -> Self {
        let body = |one: &InformativeDwell| {
            let dwell = campaign.dwells.get(one.dwell)?;
            Some(TellingBody {
                dwell: one.dwell,
                specific_force_g0: Triple(dwell.specific_force_g0.into()),
                rate_arcsec_s: Triple(dwell.rate_arcsec_s.into()),
                information: one.information,
                sd_over_noise: one.sd_over_noise,
            })
        };
        self.next_dwells = informative.iter().filter_map(body).collect();
        self
    }

    /// With what was measured; `limits`: of the rule `forecast`, the steps of D_I and D_S that are to show.
    pub fn compared(
        mut self,
        comparison: &ForecastComparison,
        ladder: &[ModelStep],
        changed: Option<&Changed>,
        (model, limits): (&Identified, [Option<Limit>; 2]),
    ) -> Self {
        let errors = comparison.foretold(model);
        let verdict = judge::forecast(&errors, limits);
        let said = verdict.or_else(|| judge::forecast(&errors, Limits::default().forecast()));
        self.compared = Some(ComparedBody::of(comparison, ladder, verdict.as_ref(), said.as_ref()));
        self.effects_against_model = changed.map(ChangedBody::from);
        self
    }
}

impl ComparedBody {
    /// `verdict` is kept, `said` is what the rule says, judged or not.
    fn of(c: &ForecastComparison, ladder: &[ModelStep], verdict: Option<&Verdict>, said: Option<&Verdict>) -> Self {
        let state = match said.map(|verdict| verdict.state) {
            Some(State::Exceeded) => OUTSIDE,
            Some(State::Within) => "as_foretold",
            _ => "indeterminate",
        };
        Self {
            state: state.to_owned(),
            verdict: verdict.and_then(ForecastVerdictBody::of),
            count: c.count,
            rms_over_sd: c.rms_over_sd,
            rms_deg_per_h: c.rms_deg_per_h,
            noise_deg_per_h: c.noise_deg_per_h,
            p_value: c.p_value,
            pit_p_value: c.pit_p_value,
            gyros: c.gyros.to_body(),
            missed: c.missed.to_body(),
            closing: c.closing.to_body(),
            ladder: ladder.iter().map(RungBody::from).collect(),
        }
    }

    pub fn is_outside(&self) -> bool {
        self.state == OUTSIDE
    }

    /// Whether that cannot be decided.
    pub fn is_indeterminate(&self) -> bool {
        self.state == State::Indeterminate.name()
    }

    /// The gyro that is furthest from its forecast, as the rule has it.
    pub fn furthest(&self) -> Option<LargestForecastError> {
        if let Some(verdict) = &self.verdict {
            let (rms_over_sd, p_value) = (verdict.value, verdict.p_value);
            return Some(LargestForecastError { slot: verdict.slot.clone(), rms_over_sd, p_value });
        }
        let worst = self.gyros.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value))?;
        let p_value = (worst.p_value * self.gyros.len() as f64).min(1.0);
        Some(LargestForecastError { slot: worst.slot.clone(), rms_over_sd: worst.rms_over_sd, p_value })
    }

    /// For a series: what is said of whole gyros and of dwells that missed.
    pub fn without_dwells(mut self) -> Self {
        for gyro in &mut self.gyros {
            gyro.error_pulse_s.clear();
            gyro.z.clear();
            gyro.pit.clear();
        }
        self
    }
}

bodies! {
    ForecastModelBody of Identified: measured_at, campaigns: |model| model.campaigns.len(),
        effects: |model| model.effects.iter().map(|adopted| adopted.effect.to_body()).collect(),
        reference_temperature_c = reference_c;
    GyroForecastBody of GyroForecast: slot, serial, scale_pulse_per_arcsec = scale, predicted_pulse_s = predicted,
        sd_pulse_s = sd, noise_sd_pulse_s = noise,
        not_foretold: |gyro| (0..gyro.foretold.len()).filter(|&k| !gyro.foretold[k]).collect();
    ClosingBody of ErrorReduction: before_deg_per_h, after_deg_per_h, closure, interval;
    RungBody of ModelStep: effect, rms_deg_per_h, rms_over_sd;
    MissBody of OutlyingDwell: slot, dwell, z;
    GyroComparedBody of GyroComparison: slot, rms_over_sd, p_value, error_pulse_s = error, z, pit;
    ShiftBody of DriftShift: slot, coefficient, shift, sd;
    ChangedEffectBody of ChangedEffect: effect, slot, coefficients, p_value, changed, undecided, beyond_seen;
    ChangedBody of Changed: effects, shifts;
    ThenNowBody of (effects::Coefficient, [f64; 2], [f64; 2]): name = 0.name,
        unit: |(coefficient, ..)| unit::of_machines(coefficient.unit), model: |(_, model, _)| model[0],
        model_sd: |(_, model, _)| model[1], now: |(.., now)| now[0], now_sd: |(.., now)| now[1];
}
