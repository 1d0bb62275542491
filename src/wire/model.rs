//! The model file: terms and effects that an IMU is compared with. `diagnose --adopt` writes it; `calibrate`,
//! `diagnose` and `simulate` take it with `--model`, the service by `POST /v1/imus/{imu}/model`.

mod identified;

use std::collections::BTreeMap;
use std::sync::Arc;

pub use identified::IdentifiedBody;

use super::campaign::terms_from_names;
use super::hypothesis::HypothesisBody;
use super::numbers::in_range;
use super::{json, text};
use crate::core::augmented::{Adopted, AugmentedModel, KnownEffect, PlausibleSizes, Provenance};
use crate::core::effects::{self, Effect, Estimate, Parameter, Scope, Shape};
use crate::core::message::{Parameter as Filling, list, sent, text};
use crate::core::name::normal_form;
use crate::wire::prelude::*;
use crate::wire::unit;

/// An augmented error model. Without effects it is model (6), or as much of it as `terms` names.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelBody {
    /// Of the file's form: 2 where it holds the coefficients of one IMU, else 1 or left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<u32>,
    /// Of `bias`, `g_linear`, `g_squared`, `scale`; empty: those that each campaign asks for.
    pub terms: Vec<String>,
    /// Effects beside the terms, in the order of adoption.
    pub effects: Vec<KnownEffectBody>,
    /// The campaign in which the effects were found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<ProvenanceBody>,
    /// The coefficients of the very IMU (`gyrowatch model fit`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identified: Option<IdentifiedBody>,
    /// Largest sizes that gyros of this kind may have, by id of the catalogue, in the unit of the effect's
    /// coefficients. A diagnosis names nothing larger. The catalogue's are those of any kind.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "json::each_once")]
    pub plausible_sizes: BTreeMap<String, f64>,
}

/// Forms of the model file that are read.
const VERSIONS: [u32; 2] = [1, 2];

/// The content of a model file, with who adopts it and why.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AdoptionBody {
    pub version: Option<u32>,
    /// As in the model file. Without terms, effects and sizes the plain model is in force again.
    #[serde(default)]
    pub terms: Vec<String>,
    #[serde(default)]
    pub effects: Vec<KnownEffectBody>,
    pub provenance: Option<ProvenanceBody>,
    pub identified: Option<IdentifiedBody>,
    #[serde(default, deserialize_with = "json::each_once")]
    pub plausible_sizes: BTreeMap<String, f64>,
    #[schema(min_length = 1, max_length = 64)]
    pub author: String,
    #[schema(min_length = 1, max_length = 4096)]
    pub reason: String,
}

/// One effect of the catalogue in the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct KnownEffectBody {
    /// Id of the catalogue.
    pub effect: String,
    /// Slots that have it. Effects of the station act on all gyros.
    #[schema(min_items = 1)]
    pub gyros: Vec<String>,
    /// Its non-linear parameter, where it has one: held, not fitted.
    #[serde(default, skip_serializing_if = "ShapeBody::is_linear")]
    pub shape: ShapeBody,
    /// As the campaign of the provenance shows them. Each later campaign fits its own.
    pub estimates: Vec<KnownEstimateBody>,
    /// What it is, where it is a hypothesis of one's own: `effect` is then its id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hypothesis: Option<HypothesisBody>,
}

/// One coefficient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct KnownEstimateBody {
    /// `all` for a coefficient that the gyros share.
    pub slot: String,
    pub name: String,
    pub value: f64,
    pub sd: f64,
    pub unit: String,
}

/// At most one member.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(max_properties = 1)]
#[serde(deny_unknown_fields)]
pub struct ShapeBody {
    /// Time constant of `warmup`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tau_s: Option<f64>,
    /// Instant of `bias_step`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instant_s: Option<f64>,
    /// Index of `outlier_dwell`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dwell: Option<usize>,
    /// Period of `periodic`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Direction of the field of `magnetic`, from north towards east, rad; left out where it is not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field_azimuth_rad: Option<f64>,
    /// Rotation of S about I that `anisoinertia` assumes, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clocking_rad: Option<f64>,
    /// The one product of `cross_compliance`: 0 for a_I a_S, 1 for a_I a_O, 2 for a_O a_S.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub product: Option<usize>,
    /// Whether `levelling` tilts the IMU on the table (true) or the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub with_rate: Option<bool>,
    /// `input_spin`, where `temperature_g` acts along I and S alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<String>,
    /// Value of the parameter of a hypothesis of one's own, in the unit of its range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ProvenanceBody {
    pub imu: String,
    pub station: String,
    /// RFC 3339, with offset.
    pub measured_at: String,
}

/// Reads and checks a model file.
pub fn parse(bytes: &[u8]) -> Result<AugmentedModel, Faults> {
    json::parse::<ModelBody>(bytes)?.checked()
}

/// Reads a stored model, adopted when less may have been checked.
pub fn parse_stored(bytes: &[u8]) -> Result<AugmentedModel, Faults> {
    json::parse::<ModelBody>(bytes)?.to_core()
}

/// The model as one JSON document, ready to be read by [`parse`].
pub fn to_json(model: &AugmentedModel) -> String {
    serde_json::to_string_pretty(&ModelBody::from(model)).expect("strings and finite numbers always serialise")
}

impl ModelBody {
    /// Converts and checks.
    pub fn to_core(&self) -> Result<AugmentedModel, Faults> {
        let mut faults = Faults::default();
        if let Some(version) = self.version.filter(|version| !VERSIONS.contains(version)) {
            faults.push("/version", message!("must_be_one_of", known = list(["1", "2"]), value = text(version)));
        }
        let terms = match self.terms.as_slice() {
            [] => None,
            names => terms_from_names(names).map_err(|part| faults.absorb("/terms", part)).ok(),
        };
        let effects: Vec<KnownEffect> =
            self.effects.iter().enumerate().filter_map(|(i, e)| e.to_core(i, &mut faults)).collect();
        let found_in = self.provenance.as_ref().map(|p| Provenance {
            imu: text::name("/provenance/imu", &p.imu, &mut faults),
            station: text::name("/provenance/station", &p.station, &mut faults),
            measured_at: text::instant("/provenance/measured_at", &p.measured_at, &mut faults),
        });
        let adopted: Vec<Adopted> = effects.iter().map(|known| known.adopted.clone()).collect();
        let identified = self.identified.as_ref().and_then(|body| body.to_core(&adopted, &mut faults));
        let plausible_sizes = self.plausible_sizes(&mut faults);
        faults.or(AugmentedModel { terms, effects, found_in, identified: identified.map(Arc::new), plausible_sizes })
    }

    /// As [`Self::to_core`], of a file that agrees with itself.
    fn checked(&self) -> Result<AugmentedModel, Faults> {
        let model = self.to_core()?;
        let mut faults = Faults::default();
        let without_size = |(effect, _): &&(Effect, f64)| !effect.entry().has_size();
        for (effect, _) in model.plausible_sizes.0.iter().filter(without_size) {
            let message = message!("effect_without_size", effect = effect.id(), effects = effects::known_with_size());
            faults.push(format!("/plausible_sizes/{}", effect.id()), message);
        }
        if let Some(identified) = &self.identified {
            identified.check_agreement(&mut faults);
            for (i, effect) in self.effects.iter().enumerate() {
                for (k, estimate) in effect.estimates.iter().enumerate() {
                    if !identified.agrees(&estimate.slot, &effect.effect, &estimate.name, estimate.value) {
                        let place = format!("/effects/{i}/estimates/{k}/value");
                        faults.push(place, message!("is_not_the_coefficient", name = text(&estimate.name)));
                    }
                }
            }
        }
        faults.or(model)
    }

    fn plausible_sizes(&self, faults: &mut Faults) -> PlausibleSizes {
        let size = |(id, &size): (&String, &f64)| {
            let place = format!("/plausible_sizes/{id}");
            let Some(effect) = Effect::from_id(id) else {
                let message = message!("unknown_effect", effect = sent(id), effects = effects::known());
                faults.push(place, message);
                return None;
            };
            if in_range(size, &place, faults) && size <= 0.0 {
                faults.push(place, message!("not_positive", value = text(size)));
            }
            Some((effect, size))
        };
        PlausibleSizes(self.plausible_sizes.iter().filter_map(size).collect())
    }
}

impl AdoptionBody {
    /// As [`Self::to_core`], of the IMU with this name: coefficients of another one are no model of it.
    pub fn to_core_of(self, imu: &str) -> Result<(AugmentedModel, String, String), Faults> {
        let (model, author, reason) = self.to_core()?;
        match &model.identified {
            Some(identified) if normal_form(identified.imu.as_str()) != normal_form(imu) => {
                let message = message!("model_is_of_imu", model = text(&identified.imu), imu = sent(imu));
                Err(Fault { pointer: "/identified/imu".to_owned(), message }.into())
            }
            _ => Ok((model, author, reason)),
        }
    }

    /// The model, its author and the reason.
    pub fn to_core(self) -> Result<(AugmentedModel, String, String), Faults> {
        let mut faults = Faults::default();
        let (author, reason) = text::signed("/author", self.author, self.reason, &mut faults);
        let Self { version, terms, effects, provenance, identified, plausible_sizes, .. } = self;
        let file = ModelBody { version, terms, effects, provenance, identified, plausible_sizes };
        let Ok(model) = file.checked().map_err(|part| faults.absorb("", part)) else { return Err(faults) };
        faults.or((model, author, reason))
    }
}

impl KnownEffectBody {
    fn to_core(&self, i: usize, faults: &mut Faults) -> Option<KnownEffect> {
        let place = format!("/effects/{i}");
        let before = faults.0.len();
        let own = self.hypothesis.as_ref().map(HypothesisBody::to_core).transpose();
        let own = own.map_err(|part| faults.absorb(&format!("{place}/hypothesis"), part)).ok().flatten();
        let Some(effect) = Effect::from_id(&self.effect).or(own.filter(|own| own.id() == self.effect)) else {
            let message = message!("unknown_effect", effect = sent(&self.effect), effects = effects::known());
            faults.push(format!("{place}/effect"), message);
            return None;
        };
        let slots = self.slots(&place, faults);
        let shape = self.shape.to_core(effect, &format!("{place}/shape"), faults);
        let estimates: Vec<Estimate> = self
            .estimates
            .iter()
            .enumerate()
            .filter_map(|(k, e)| e.to_core(effect, shape?, &slots, &format!("{place}/estimates/{k}"), faults))
            .collect();
        (faults.0.len() == before)
            .then_some(KnownEffect { adopted: Adopted { effect, shape: shape?, slots }, estimates })
    }

    fn slots(&self, place: &str, faults: &mut Faults) -> Vec<Slot> {
        let mut slots = Vec::new();
        for (k, name) in self.gyros.iter().enumerate() {
            match Slot::from_name(name) {
                Some(slot) if slots.contains(&slot) => {
                    faults.push(format!("{place}/gyros/{k}"), message!("named_twice", name = text(name)));
                }
                Some(slot) => slots.push(slot),
                None => faults.push(format!("{place}/gyros/{k}"), message!("unknown_slot", value = sent(name))),
            }
        }
        if self.gyros.is_empty() {
            faults.push(format!("{place}/gyros"), message!("no_gyros_named"));
        }
        slots
    }
}

impl KnownEstimateBody {
    fn to_core(
        &self,
        effect: Effect,
        shape: Shape,
        slots: &[Slot],
        place: &str,
        faults: &mut Faults,
    ) -> Option<Estimate> {
        let entry = effect.entry();
        let common = entry.scope == Scope::Common;
        let slot = Slot::from_name(&self.slot);
        let known = match slot {
            Some(slot) => !common && slots.contains(&slot),
            None => common && self.slot == "all",
        };
        if !known {
            let wanted = if common { "all".into() } else { Filling::from(message!("a_gyro_of_the_effect")) };
            faults.push(format!("{place}/slot"), message!("must_be", wanted, value = sent(&self.slot)));
        }
        let coefficients = entry.coefficients(shape);
        let Some(coefficient) = coefficients.iter().find(|c| c.name == self.name) else {
            let names: Vec<&str> = coefficients.iter().map(|c| c.name).collect();
            faults.push(
                format!("{place}/name"),
                message!("must_be_one_of", known = list(names), value = sent(&self.name)),
            );
            return None;
        };
        if unit::of_machines(&self.unit) != unit::of_machines(coefficient.unit) {
            faults.push(
                format!("{place}/unit"),
                message!("must_be", wanted = sent(&unit::of_machines(coefficient.unit)), value = sent(&self.unit)),
            );
        }
        in_range(self.value, format_args!("{place}/value"), faults);
        if in_range(self.sd, format_args!("{place}/sd"), faults) && self.sd < 0.0 {
            faults.push(format!("{place}/sd"), message!("negative", value = text(self.sd)));
        }
        Some(Estimate { slot, name: coefficient.name, value: self.value, sd: self.sd, unit: coefficient.unit })
    }
}

/// The products of `cross_compliance` one by one.
const PRODUCTS: [&[usize]; 3] = [&[0], &[1], &[2]];

impl ShapeBody {
    fn is_linear(&self) -> bool {
        *self == Self::default()
    }

    fn to_core(&self, effect: Effect, place: &str, faults: &mut Faults) -> Option<Shape> {
        let given = [
            self.tau_s.map(Shape::Tau),
            self.instant_s.map(Shape::Instant),
            self.dwell.map(Shape::Dwell),
            self.period_s.map(Shape::Period),
            self.field_azimuth_rad.map(Shape::Azimuth),
            self.clocking_rad.map(Shape::Clocking),
            self.product.and_then(|i| PRODUCTS.get(i)).map(|only| Shape::Only(only)),
            self.with_rate.map(|with_rate| Shape::Tilt { with_rate }),
            self.axes.as_deref().filter(|axes| *axes == "input_spin").map(|_| Shape::InputSpin),
            self.value.map(Shape::Own),
        ];
        let unknown = self.product.is_some_and(|i| i >= PRODUCTS.len())
            || self.axes.as_deref().is_some_and(|a| a != "input_spin");
        let mut given = given.into_iter().flatten();
        let shape = given.next().unwrap_or(Shape::Linear);
        if unknown || given.next().is_some() || !effect.entry().parameter.takes(shape) {
            faults.push(place, message!("shape_for", wanted = wanted(effect), effect = text(effect.id())));
            return None;
        }
        let sound = match shape {
            Shape::Tau(x) | Shape::Period(x) => x > 0.0 && x.is_finite(),
            Shape::Instant(x) | Shape::Azimuth(x) | Shape::Clocking(x) | Shape::Own(x) => x.is_finite(),
            _ => true,
        };
        if !sound {
            faults.push(place, message!("shape_not_finite"));
        }
        sound.then_some(shape)
    }

    fn of(shape: Shape) -> Self {
        let linear = Self::default();
        match shape {
            Shape::Tau(tau) => Self { tau_s: Some(tau), ..linear },
            Shape::Instant(instant) => Self { instant_s: Some(instant), ..linear },
            Shape::Dwell(dwell) => Self { dwell: Some(dwell), ..linear },
            Shape::Period(period) => Self { period_s: Some(period), ..linear },
            Shape::Azimuth(angle) => Self { field_azimuth_rad: Some(angle), ..linear },
            Shape::Clocking(angle) => Self { clocking_rad: Some(angle), ..linear },
            Shape::Only(only) => Self { product: only.first().copied(), ..linear },
            Shape::Tilt { with_rate } => Self { with_rate: Some(with_rate), ..linear },
            Shape::Own(value) => Self { value: Some(value), ..linear },
            Shape::InputSpin => Self { axes: Some("input_spin".to_owned()), ..linear },
            // Windows and parts belong to competitors, which are never adopted.
            Shape::Linear | Shape::Window(..) | Shape::Part { .. } | Shape::Restart(_) => linear,
        }
    }
}

fn wanted(effect: Effect) -> Filling {
    let absent_or = |shape: &'static str| message!("absent_or", shape).into();
    match effect.entry().parameter {
        Parameter::Tau => "{\"tau_s\": seconds}".into(),
        Parameter::Instant => "{\"instant_s\": seconds}".into(),
        Parameter::Dwell => "{\"dwell\": index}".into(),
        Parameter::Period => "{\"period_s\": seconds}".into(),
        Parameter::FieldAzimuth => absent_or("{\"field_azimuth_rad\": angle}"),
        Parameter::Clocking => "{\"clocking_rad\": angle}".into(),
        Parameter::Product => absent_or("{\"product\": 0|1|2}"),
        Parameter::Tilt => "{\"with_rate\": true|false}".into(),
        Parameter::Seating => absent_or("{\"instant_s\": seconds}"),
        Parameter::Own => "{\"value\": number}".into(),
        Parameter::Axes => absent_or("{\"axes\": \"input_spin\"}"),
        Parameter::None => message!("absent").into(),
    }
}

/// The shape's own entries among the estimates are said by `shape`.
fn estimates(known: &KnownEffect) -> Vec<KnownEstimateBody> {
    let coefficients = known.adopted.effect.entry().coefficients(known.adopted.shape);
    let said = known.estimates.iter().filter(|e| coefficients.iter().any(|c| c.name == e.name));
    said.map(KnownEstimateBody::from).collect()
}

bodies! {
    ModelBody of AugmentedModel: version: |model| model.identified.as_ref().map(|_| 2),
        terms: |model| model.terms.iter().flat_map(|terms| terms.iter()).map(|term| term.name().to_owned()).collect(),
        effects, provenance = found_in, identified: |model| model.identified.as_deref().map(IdentifiedBody::from),
        plausible_sizes: |model| model.plausible_sizes.0.iter().map(|(of, size)| (of.id().to_owned(), *size)).collect();
    KnownEffectBody of KnownEffect: effect = adopted.effect, gyros = adopted.slots,
        shape: |known| ShapeBody::of(known.adopted.shape), estimates: estimates,
        hypothesis: |known| known.adopted.effect.hypothesis().map(|own| (&own.written).into());
    ProvenanceBody of Provenance: imu, station, measured_at;
    KnownEstimateBody of Estimate: slot, name, value, sd, unit: |estimate| unit::of_machines(estimate.unit);
}

#[cfg(test)]
mod tests;
