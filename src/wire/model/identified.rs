//! The part of a model file that is one IMU's own: its coefficients, their covariance, and where they come from.

use nalgebra::{DMatrix, Vector3};

use crate::core::augmented::Adopted;
use crate::core::calibrate::design;
use crate::core::imu_model::{FittedCampaign, Identified, ModelCoefficient, ModelGyro, NoiseLaw, Of, Validity};
use crate::core::message::{list, sent, text};
use crate::core::model::{Term, Terms};
use crate::wire::geometry::GeometryBody;
use crate::wire::numbers::in_range;
use crate::wire::prelude::*;
use crate::wire::{text, unit};

/// Most coefficients that a model may have: three gyros with every effect of the catalogue.
const MOST: usize = 400;
/// Share of the largest eigenvalue of the correlations by which one may be negative from rounding.
const ROUNDING: f64 = 1e-6;
/// How far outside the temperatures seen the reference may be, K.
const NEAR_K: f64 = 1.0;
/// Share of |E| by which the E that effects are resolved on may differ from the fitted one.
const E_AGREES: f64 = 0.01;

/// The coefficients of one IMU, fitted to its campaigns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedBody {
    pub imu: String,
    pub geometry: GeometryBody,
    /// Temperature at which the coefficients are stated; none where no campaign states temperatures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_temperature_c: Option<f64>,
    /// When the newest campaign was measured, RFC 3339 with offset.
    pub measured_at: String,
    pub gyros: Vec<ModelGyroBody>,
    pub coefficients: Vec<ModelCoefficientBody>,
    /// Joint covariance of all coefficients in their order, the lower triangle row by row.
    pub covariance: Vec<Vec<f64>>,
    pub campaigns: Vec<FittedCampaignBody>,
    pub validity: ValidityBody,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelGyroBody {
    pub slot: String,
    pub serial: String,
    /// Whether E is held at `e_pulse_per_arcsec` and not among the coefficients.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub e_held: bool,
    /// E and G that effects are resolved on.
    pub e_pulse_per_arcsec: Triple,
    pub g_pulse_per_s_g0: Triple,
    pub noise: NoiseLawBody,
}

/// The standard deviation of a mean over T hours is `sem_factor` times the stated standard error; where none is
/// stated, |E| sqrt(N^2/T + (q w_I)^2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NoiseLawBody {
    /// None where the campaigns state no standard errors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sem_factor: Option<f64>,
    /// N.
    pub random_walk_deg_per_sqrt_h: f64,
    /// q, in parts per million.
    pub rate_noise_ppm: f64,
    /// Degrees of freedom that the scale is known by; none where standard errors are taken at their word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dof: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelCoefficientBody {
    /// `all` for one that the gyros share.
    pub slot: String,
    /// Id of the effect that it belongs to; none for D0, G, P and E.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effect: Option<String>,
    pub name: String,
    pub value: f64,
    /// The root of its place in `covariance`.
    pub sd: f64,
    /// Standard deviation from campaign to campaign beyond their noise.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub between_campaigns_sd: f64,
    pub unit: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedCampaignBody {
    pub station: String,
    pub measured_at: String,
    pub dwells: usize,
    /// Its identifier in the service, or the SHA-256 of its file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// What the campaigns have shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidityBody {
    /// Lowest and highest temperature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<[f64; 2]>,
    /// Largest rate.
    pub rate_arcsec_s: f64,
    /// Directions of specific force, body axes.
    pub directions: Vec<Triple>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

const TERM_NAMES: [(Term, &[&str]); 4] = [
    (Term::Bias, &["D0"]),
    (Term::GLinear, &["G_x", "G_y", "G_z"]),
    (Term::GSquared, &["P_x", "P_y", "P_z"]),
    (Term::Scale, &["E_x", "E_y", "E_z"]),
];

bodies! {
    IdentifiedBody of Identified: imu, geometry, reference_temperature_c = reference_c, measured_at, gyros,
        coefficients: coefficients, covariance: triangle, campaigns, validity;
    ModelGyroBody of ModelGyro: slot, serial, e_held, e_pulse_per_arcsec = e, g_pulse_per_s_g0 = g, noise;
    NoiseLawBody of NoiseLaw: sem_factor, random_walk_deg_per_sqrt_h = random_walk, rate_noise_ppm = rate_ppm,
        dof: |noise| Some(noise.dof).filter(|dof| dof.is_finite());
    FittedCampaignBody of FittedCampaign: station, measured_at, dwells, source;
    ValidityBody of Validity: temperature_c, rate_arcsec_s, directions;
}

fn coefficients(model: &Identified) -> Vec<ModelCoefficientBody> {
    let coefficient = |(place, c): (usize, &ModelCoefficient)| {
        let (effect, name, unit) = match c.of {
            Of::Term(term, part) => (None, TERM_NAMES[term as usize].1[part], design::unit(term)),
            Of::Effect(effect, number) => {
                let entry = model.effects[effect].effect.entry();
                let one = entry.coefficients(model.effects[effect].shape)[number];
                (Some(entry.id.to_owned()), one.name, one.unit)
            }
        };
        ModelCoefficientBody {
            slot: c.slot.to_body(),
            effect,
            name: name.to_owned(),
            value: c.value,
            sd: model.sd(place),
            between_campaigns_sd: c.between,
            unit: unit::of_machines(unit),
        }
    };
    model.coefficients.iter().enumerate().map(coefficient).collect()
}

fn triangle(model: &Identified) -> Vec<Vec<f64>> {
    (0..model.coefficients.len()).map(|i| (0..=i).map(|k| model.covariance[(i, k)]).collect()).collect()
}

impl IdentifiedBody {
    /// The model; `effects` are those of the file.
    pub(super) fn to_core(&self, effects: &[Adopted], faults: &mut Faults) -> Option<Identified> {
        let before = faults.0.len();
        let effects: Vec<Adopted> = effects.iter().filter(|a| self.names(a)).cloned().collect();
        let geometry = self.geometry.to_core().map_err(|part| faults.absorb("/identified/geometry", part)).ok();
        let gyros: Vec<ModelGyro> =
            self.gyros.iter().enumerate().filter_map(|(i, gyro)| gyro.to_core(i, faults)).collect();
        if self.gyros.is_empty() {
            faults.push("/identified/gyros", message!("no_gyros_named"));
        }
        let place = |i: usize| format!("/identified/coefficients/{i}");
        let coefficients: Vec<ModelCoefficient> = (self.coefficients.iter().enumerate())
            .filter_map(|(i, c)| c.to_core(&effects, &gyros, &place(i), faults))
            .collect();
        let covariance = self.covariance(faults);
        let campaigns = self.campaigns.iter().enumerate().map(|(i, fitted)| FittedCampaign {
            station: text::name(&format!("/identified/campaigns/{i}/station"), &fitted.station, faults),
            measured_at: text::instant(&format!("/identified/campaigns/{i}/measured_at"), &fitted.measured_at, faults),
            dwells: fitted.dwells,
            source: fitted.source.clone(),
        });
        let campaigns: Vec<FittedCampaign> = campaigns.collect();
        if campaigns.is_empty() {
            faults.push("/identified/campaigns", message!("no_campaign_to_fit"));
        }
        let of_terms = coefficients.iter().filter_map(|c| match c.of {
            Of::Term(term, _) => Some(term),
            Of::Effect(..) => None,
        });
        let terms: Vec<Term> = of_terms.collect();
        let directions: Vec<Vector3<f64>> = self.validity.directions.iter().map(|d| d.vector()).collect();
        text::temperature("/identified/reference_temperature_c", self.reference_temperature_c, faults);
        for celsius in self.validity.temperature_c.into_iter().flatten() {
            text::temperature("/identified/validity/temperature_c", Some(celsius), faults);
        }
        for value in std::iter::once(&self.validity.rate_arcsec_s).chain(directions.iter().flatten()) {
            in_range(*value, "/identified/validity", faults);
        }
        let model = Identified {
            imu: text::name("/identified/imu", &self.imu, faults),
            geometry: geometry?,
            terms: Terms::of(&terms),
            reference_c: self.reference_temperature_c,
            measured_at: text::instant("/identified/measured_at", &self.measured_at, faults),
            gyros,
            effects,
            coefficients,
            covariance: covariance?,
            campaigns,
            validity: Validity {
                temperature_c: self.validity.temperature_c,
                rate_arcsec_s: self.validity.rate_arcsec_s,
                directions,
            },
        };
        (faults.0.len() == before).then_some(model)
    }

    /// What the file says in two places is to agree, and the reference temperature to be one that was seen.
    pub(super) fn check_agreement(&self, faults: &mut Faults) {
        if let Some([low, high]) = self.validity.temperature_c {
            if low > high {
                let message = message!("span_is_reversed", low = text(low), high = text(high));
                faults.push("/identified/validity/temperature_c", message);
            } else if let Some(reference) = self.reference_temperature_c
                && !(low - NEAR_K..=high + NEAR_K).contains(&reference)
            {
                let message = message!("reference_was_not_seen", low = text(low), high = text(high));
                faults.push("/identified/reference_temperature_c", message);
            }
        } else if self.reference_temperature_c.is_some() {
            faults.push("/identified/reference_temperature_c", message!("reference_without_temperatures"));
        }
        for (i, gyro) in self.gyros.iter().enumerate() {
            let e = gyro.e_pulse_per_arcsec.vector();
            for (part, name) in TERM_NAMES[Term::Scale as usize].1.iter().enumerate() {
                let found = self.coefficient(&gyro.slot, None, name);
                if found.is_some_and(|c| (c.value - e[part]).abs() > E_AGREES * e.norm() + c.sd) {
                    let place = format!("/identified/gyros/{i}/e_pulse_per_arcsec");
                    faults.push(place, message!("is_not_the_coefficient", name = text(name)));
                }
            }
        }
    }

    pub(super) fn agrees(&self, slot: &str, effect: &str, name: &str, value: f64) -> bool {
        let found = self.coefficient(slot, Some(effect), name);
        found.is_none_or(|c| (c.value - value).abs() <= c.sd + c.between_campaigns_sd)
    }

    fn coefficient(&self, slot: &str, effect: Option<&str>, name: &str) -> Option<&ModelCoefficientBody> {
        self.coefficients.iter().find(|c| c.slot == slot && c.effect.as_deref() == effect && c.name == name)
    }

    /// Whether any coefficient is of this effect of the file.
    fn names(&self, adopted: &Adopted) -> bool {
        let is = |c: &ModelCoefficientBody| {
            let slot = Slot::from_name(&c.slot);
            c.effect.as_deref() == Some(adopted.effect.id()) && slot.is_none_or(|slot| adopted.slots.contains(&slot))
        };
        self.coefficients.iter().any(is)
    }

    fn covariance(&self, faults: &mut Faults) -> Option<DMatrix<f64>> {
        let place = "/identified/covariance";
        let p = self.coefficients.len();
        let triangle = self.covariance.iter().enumerate().all(|(i, row)| row.len() == i + 1);
        if p == 0 || p > MOST || self.covariance.len() != p || !triangle {
            faults.push(place, message!("covariance_is_no_triangle", need = p, have = self.covariance.len()));
            return None;
        }
        let before = faults.0.len();
        for (i, row) in self.covariance.iter().enumerate() {
            row.iter().enumerate().for_each(|(k, value)| _ = in_range(*value, format_args!("{place}/{i}/{k}"), faults));
        }
        if faults.0.len() > before {
            return None;
        }
        let covariance = DMatrix::from_fn(p, p, |i, k| self.covariance[i.max(k)][i.min(k)]);
        let sd = covariance.diagonal().map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
        let correlation = covariance.map_with_location(|i, k, c| c / (sd[i] * sd[k]));
        let least = correlation.symmetric_eigenvalues().min();
        if least < -ROUNDING * p as f64 {
            faults.push(place, message!("covariance_is_not_positive"));
            return None;
        }
        for (i, c) in self.coefficients.iter().enumerate() {
            let sd = covariance[(i, i)].max(0.0).sqrt();
            if (c.sd - sd).abs() > 0.01 * sd {
                faults.push(format!("/identified/coefficients/{i}/sd"), message!("sd_is_not_of_covariance"));
            }
        }
        Some(covariance)
    }
}

impl ModelGyroBody {
    fn to_core(&self, i: usize, faults: &mut Faults) -> Option<ModelGyro> {
        let place = format!("/identified/gyros/{i}");
        let Some(slot) = Slot::from_name(&self.slot) else {
            faults.push(format!("{place}/slot"), message!("unknown_slot", value = sent(&self.slot)));
            return None;
        };
        let (e, g) = (self.e_pulse_per_arcsec.vector(), self.g_pulse_per_s_g0.vector());
        let NoiseLawBody { sem_factor, random_walk_deg_per_sqrt_h: walk, rate_noise_ppm: ppm, dof } = self.noise;
        for value in e.iter().chain(g.iter()).chain(&[walk, ppm]).chain(&sem_factor).chain(&dof) {
            in_range(*value, &place, faults);
        }
        let quiet = walk <= 0.0 && ppm <= 0.0;
        if quiet || walk < 0.0 || ppm < 0.0 || [sem_factor, dof].iter().flatten().any(|x| *x <= 0.0) || e.norm() <= 0.0
        {
            faults.push(place.clone(), message!("gyro_without_noise_or_scale"));
        }
        Some(ModelGyro {
            slot,
            serial: text::name(&format!("{place}/serial"), &self.serial, faults),
            e_held: self.e_held,
            e,
            g,
            noise: NoiseLaw { sem_factor, random_walk: walk, rate_ppm: ppm, dof: dof.unwrap_or(f64::INFINITY) },
        })
    }
}

impl ModelCoefficientBody {
    fn to_core(
        &self,
        effects: &[Adopted],
        gyros: &[ModelGyro],
        place: &str,
        faults: &mut Faults,
    ) -> Option<ModelCoefficient> {
        let slot = Slot::from_name(&self.slot).filter(|slot| gyros.iter().any(|gyro| gyro.slot == *slot));
        if slot.is_none() && self.slot != "all" {
            faults.push(format!("{place}/slot"), message!("unknown_slot", value = sent(&self.slot)));
            return None;
        }
        for (value, member) in [(self.value, "value"), (self.sd, "sd"), (self.between_campaigns_sd, "between")] {
            in_range(value, format_args!("{place}/{member}"), faults);
        }
        let (of, unit) = match &self.effect {
            None => {
                let part = |names: &[&str]| names.iter().position(|name| *name == self.name);
                let found = TERM_NAMES.iter().find_map(|(term, names)| Some((*term, part(names)?)));
                found.filter(|_| slot.is_some()).map(|(term, part)| (Of::Term(term, part), design::unit(term)))
            }
            Some(id) => {
                let is = |a: &Adopted| a.effect.id() == id && slot.is_none_or(|slot| a.slots.contains(&slot));
                effects.iter().position(is).and_then(|e| {
                    let names = effects[e].effect.entry().coefficients(effects[e].shape);
                    let number = names.iter().position(|c| c.name == self.name)?;
                    Some((Of::Effect(e, number), names[number].unit))
                })
            }
        }
        .or_else(|| {
            let known = list(["D0", "G_x", "P_x", "E_x"]);
            faults.push(format!("{place}/name"), message!("must_be_one_of", known, value = sent(&self.name)));
            None
        })?;
        let unit = unit::of_machines(unit);
        if unit::of_machines(&self.unit) != unit {
            let unknown = message!("must_be", wanted = sent(&unit), value = sent(&self.unit));
            faults.push(format!("{place}/unit"), unknown);
        }
        Some(ModelCoefficient { slot, of, value: self.value, between: self.between_campaigns_sd })
    }
}
