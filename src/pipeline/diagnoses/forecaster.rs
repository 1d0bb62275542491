//! What foretells a stored campaign: the model in force when it came in, and the campaigns before it.

use super::models::{InForce, read};
use crate::core::campaign::{Campaign, TestKind};
use crate::core::imu_model::{CampaignSample, Identified, changed, compare, identify, ladder, promised};
use crate::core::judge::Limit;
use crate::pipeline::ingest::campaign::campaign_of;
use crate::pipeline::prelude::*;
use crate::wire::forecast::{ForecastBody, ForecastPointBody};

/// Campaigns before one that its model is fitted to, where none was fitted when it came in.
const FITTED: usize = 5;
/// Calibrations that are looked through for them.
const LOOKED_THROUGH: u32 = 32;

/// What foretells a stored campaign.
pub(super) struct Forecaster {
    id: Id,
    /// Of the same IMU with the same gyros, newest first.
    before: Vec<(Id, Campaign)>,
    /// When it came in.
    in_force: InForce,
    /// Of the rule `forecast`.
    limits: [Option<Limit>; 2],
}

impl Forecaster {
    /// Of the campaign `id` of the IMU with number `imu`.
    pub async fn of(
        store: &Store,
        config: &Config,
        (id, imu): (Id, u32),
        campaign: &Campaign,
    ) -> Result<Self, StoreError> {
        // Identifiers are in order of arrival; the models are newest first.
        let models = store::model::of_imu(store, imu).await?;
        let in_force = models.iter().find(|model| model.id < id).map(read).transpose()?.unwrap_or_default();
        let (mut before, mut otherwise): (Vec<(Id, Campaign)>, Vec<_>) = Default::default();
        for head in store::record::of_imu_before(store, imu, campaign.measured_at, LOOKED_THROUGH).await? {
            if head.kind != Kind::Campaign || before.len() == FITTED {
                continue;
            }
            let Some(earlier) = stored(store, head.id).await? else { continue };
            let earlier = config.stations.complete(earlier);
            if are_alike(&earlier, campaign) {
                before.push((head.id, earlier));
            } else if has_gyros_of(&earlier, campaign)
                && otherwise.len() < FITTED
                && otherwise.first().is_none_or(|(_, first)| are_alike(&earlier, first))
            {
                otherwise.push((head.id, earlier));
            }
        }
        // One that holds E, or fits it, is foretold by those that do not as well.
        let before = if before.is_empty() { otherwise } else { before };
        let limits = config.judging.limits(campaign.imu.as_str(), "").forecast();
        Ok(Self { id, before, in_force, limits })
    }

    /// The forecast without its dwells, or why there is none. Computing, some milliseconds.
    pub fn point(&self, campaign: &Campaign) -> ForecastPointBody {
        self.point_of(campaign, self.forecast(campaign).as_ref())
    }

    pub fn point_of(&self, campaign: &Campaign, told: Result<&ForecastBody, &Message>) -> ForecastPointBody {
        ForecastPointBody::of(&self.id, campaign, self.in_force.id, told)
    }

    /// By the coefficients that were adopted, else by those of the campaigns before, with the terms and effects in
    /// force.
    pub fn forecast(&self, campaign: &Campaign) -> Result<ForecastBody, Message> {
        let usable = |model: &&Arc<Identified>| compare(model, campaign).is_ok();
        // What nobody has adopted is held against nobody.
        let (model, limits) = match self.in_force.model.identified.as_ref().filter(usable) {
            Some(adopted) => (Arc::clone(adopted), self.limits),
            None => (Arc::new(self.of_campaigns()?), [None; 2]),
        };
        let comparison = compare(&model, campaign).map_err(|why| why.message())?;
        let steps = ladder(&model, campaign).map_err(|why| why.message())?;
        let promised = promised(&model, campaign).map_err(|why| why.message())?;
        let changed = if model.effects.is_empty() { None } else { changed(&model, campaign) };
        let body = ForecastBody::of(&model, campaign, &comparison.forecast, promised);
        Ok(body.compared(&comparison, &steps, changed.as_ref(), (&model, limits)))
    }

    fn of_campaigns(&self) -> Result<Identified, Message> {
        let samples = self.before.iter().map(|(id, campaign)| CampaignSample {
            campaign,
            source: Some(id.to_string()),
            occasions: Vec::new(),
        });
        let samples: Vec<CampaignSample> = samples.collect();
        if samples.is_empty() {
            return Err(message!("nothing_to_foretell_from"));
        }
        identify(&samples, &self.in_force.model).map_err(|why| why.message())
    }
}

/// A stored campaign; none where there is no such record.
pub(super) async fn stored(store: &Store, id: Id) -> Result<Option<Campaign>, StoreError> {
    store::record::get(store, id).await?.map(|row| campaign_of(&row)).transpose()
}

/// Whether campaigns can be fitted together.
fn are_alike(one: &Campaign, other: &Campaign) -> bool {
    let held = |campaign: &Campaign| -> Vec<_> { campaign.gyros.iter().map(|gyro| gyro.known_e).collect() };
    has_gyros_of(one, other) && held(one) == held(other)
}

/// Whether it is of an IMU as `other` has it.
fn has_gyros_of(one: &Campaign, other: &Campaign) -> bool {
    let gyros = |campaign: &Campaign| -> Vec<_> {
        campaign.gyros.iter().map(|gyro| (gyro.slot, gyro.serial.clone())).collect()
    };
    one.test == TestKind::Imu && gyros(one) == gyros(other) && one.geometry.is_same(&other.geometry)
}
