//! The error model that an IMU is compared with: terms of model (6), and the effects that diagnoses have added to them.
//!
//! y = D0 + G.A + P.A^2 + E.w + |E| sum_m k_m x_m, with x_m the regressors of the adopted effects
//! ([`super::effects`], deg/h per unit of k_m). Each campaign fits the k_m anew beside model (6); the shapes (time
//! constants, periods, directions) are held at what the diagnosis found.

use std::sync::Arc;

pub use super::adopted::{Adopted, KnownCoefficient};
use super::campaign::Campaign;
use super::effects::{Effect, Estimate};
use super::imu_model::Identified;
use super::message::{Message, text};
use super::model::{Term, Terms};
use super::mounting::Slot;
use super::record::Name;
use super::time::UtcMicros;
use crate::message;

/// What is compared with the campaign.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Terms of model (6) in use; the campaign's own where none are given.
    pub terms: Option<Terms>,
    /// Effects that the model in use holds already.
    pub adopted: Vec<Adopted>,
    /// What the model of the very gyros says of these.
    pub known: Vec<KnownCoefficient>,
    /// Temperature at which the coefficients are stated, deg C; the campaign's mean where none is given.
    pub reference_c: Option<f64>,
    /// Hypotheses of one's own, which compete with the catalogue.
    pub hypotheses: Vec<Effect>,
    pub plausible_sizes: PlausibleSizes,
}

/// Largest sizes that gyros of this kind may have, by effect, in the unit of its coefficients; the catalogue's
/// ([`super::effects::Entry::plausible`]) of the others.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlausibleSizes(pub Vec<(Effect, f64)>);

impl PlausibleSizes {
    /// Largest plausible size of an effect, in the unit of its coefficients: the IMU's own, else the catalogue's.
    pub fn of(&self, effect: Effect) -> f64 {
        let own = self.0.iter().find(|(kind, _)| *kind == effect);
        own.map_or(effect.entry().plausible, |(_, size)| *size)
    }
}

/// An effect in the model, as large as the campaign in which it was found says.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownEffect {
    pub adopted: Adopted,
    pub estimates: Vec<Estimate>,
}

/// The campaign in which the effects were found.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    pub imu: Name,
    pub station: Name,
    pub measured_at: UtcMicros,
}

/// Terms and effects in use for an IMU. The default is the plain model: each campaign's own terms, no effects.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AugmentedModel {
    /// None: those that each campaign asks for.
    pub terms: Option<Terms>,
    pub effects: Vec<KnownEffect>,
    pub found_in: Option<Provenance>,
    /// The coefficients of the very IMU, where campaigns were fitted.
    pub identified: Option<Arc<Identified>>,
    pub plausible_sizes: PlausibleSizes,
}

impl AugmentedModel {
    /// Whether it says nothing beyond equation (6) with the campaign's own terms.
    pub fn is_plain(&self) -> bool {
        self.terms.is_none() && self.effects.is_empty() && self.plausible_sizes.0.is_empty()
    }

    /// What of the model is not of `campaign`'s IMU and gyros: its effects are fitted there all the same.
    pub fn notes_of_others(&self, campaign: &Campaign) -> Vec<Message> {
        let identified = self.identified.as_ref();
        let found_in = self.found_in.as_ref().map(|found| &found.imu);
        let imu = identified.map(|identified| &identified.imu).or(found_in);
        if let Some(imu) = imu.filter(|imu| **imu != campaign.imu) {
            return vec![message!("model_found_in_other_imu", model = text(imu), campaign = text(&campaign.imu))];
        }
        let exchanged = campaign.gyros.iter().filter_map(|gyro| {
            let own = identified?.gyro(gyro.slot).filter(|own| own.serial != gyro.serial)?;
            let (slot, then, now) = (gyro.slot.name(), text(&own.serial), text(&gyro.serial));
            Some(message!("model_found_in_other_gyro", slot, then, now))
        });
        exchanged.filter(|_| !self.effects.is_empty()).collect()
    }

    /// What `campaign` is fitted with and compared with.
    ///
    /// A term of model (6) that was adopted as an effect joins the terms of all gyros. An effect of one occasion (a
    /// step, a bad dwell) belongs to the campaign in which it happened and to no other.
    pub fn options(&self, campaign: &Campaign) -> Options {
        self.options_with(campaign, self.terms.unwrap_or_else(|| campaign.terms()))
    }

    /// As [`Self::options`], but the terms that a station asks for come first: it knows what its design determines.
    pub fn options_as_asked(&self, campaign: &Campaign) -> Options {
        self.options_with(campaign, campaign.model.or(self.terms).unwrap_or_default())
    }

    /// Temperature at which D_I and D_S are stated where effects of temperature are known, deg C.
    pub fn restates_at(&self) -> Option<f64> {
        let reference_c = self.identified.as_ref()?.reference_c?;
        self.effects.iter().any(|known| known.adopted.effect.entry().of_temperature).then_some(reference_c)
    }

    /// What is known of the effects of the very gyros of `imu`.
    pub fn known(&self, imu: &Name, gyros: &[(Slot, &Name)]) -> Vec<KnownCoefficient> {
        let identified = self.identified.as_ref().filter(|identified| identified.imu == *imu);
        let is_same = |slot| {
            let own = identified.and_then(|identified| identified.gyro(slot));
            own.is_some_and(|own| gyros.contains(&(slot, &own.serial)))
        };
        let of = |known: &KnownEffect| {
            let effect = known.adopted.effect;
            let one = |estimate: &Estimate| {
                let Estimate { slot, name, value, sd, .. } = *estimate;
                Some(KnownCoefficient { slot: slot.filter(|slot| is_same(*slot))?, effect, name, value, sd })
            };
            known.estimates.iter().filter_map(one).collect::<Vec<KnownCoefficient>>()
        };
        self.effects.iter().flat_map(of).collect()
    }

    fn options_with(&self, campaign: &Campaign, terms: Terms) -> Options {
        let of_model_6 = self.effects.iter().filter_map(|known| known.adopted.effect.term());
        let terms: Vec<Term> = terms.iter().chain(of_model_6).collect();
        let here = self
            .found_in
            .as_ref()
            .is_some_and(|found| found.imu == campaign.imu && found.measured_at == campaign.measured_at);
        let adopted = self.effects.iter().map(|known| &known.adopted);
        let adopted = adopted.filter(|a| a.effect.term().is_none() && (here || !a.effect.entry().one_occasion));
        let reference_c = self.identified.as_ref().and_then(|identified| identified.reference_c);
        let gyros: Vec<(Slot, &Name)> = campaign.gyros.iter().map(|gyro| (gyro.slot, &gyro.serial)).collect();
        Options {
            terms: Some(Terms::of(&terms)),
            adopted: adopted.cloned().collect(),
            known: self.known(&campaign.imu, &gyros),
            reference_c,
            hypotheses: Vec::new(),
            plausible_sizes: self.plausible_sizes.clone(),
        }
    }
}
