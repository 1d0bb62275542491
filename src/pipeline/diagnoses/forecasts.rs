//! Forecasts of an IMU's stored campaigns, each from the model in force when it came in: how the gap between what was
//! foretold and what was measured went over time.
//!
//! Made when they are asked for, from what is stored: nothing waits for them where campaigns come in.

use std::sync::Arc;

use super::Diagnoses;
use super::models::{InForce, read};
use crate::core::augmented::AugmentedModel;
use crate::core::campaign::{Campaign, TestKind};
use crate::core::id::Id;
use crate::core::imu_model::{Identified, Sample, changed, compare, identify, ladder, promised};
use crate::core::kind::Kind;
use crate::core::message::Message;
use crate::message;
use crate::pipeline::error::StorageError;
use crate::pipeline::ingest::fitted::damaged;
use crate::store;
use crate::store::StoreError;
use crate::wire::campaign;
use crate::wire::forecast::{ForecastBody, ForecastPointBody, ForecastSeriesBody};
use crate::wire::time;
use crate::words;

/// Campaigns before one that its model is fitted to, where none was fitted when it came in.
const FITTED: usize = 5;

/// A stored campaign, and the model in force when it came in.
struct Stored {
    id: Id,
    campaign: Campaign,
    in_force: InForce,
}

impl Diagnoses {
    /// The forecasts of the newest `limit` campaigns of an IMU, oldest first; none where no such IMU is known.
    /// Computing, some milliseconds a campaign.
    ///
    /// # Errors
    /// [`StorageError`].
    pub async fn forecasts(&self, imu: &str, limit: u32) -> Result<Option<ForecastSeriesBody>, StorageError> {
        let Some(number) = self.store.names().read().imus.number(imu) else { return Ok(None) };
        let models = store::model::of_imu(&self.store, number).await?;
        let models = models.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let most = limit + u32::try_from(FITTED).unwrap_or(u32::MAX);
        let mut stored = Vec::new();
        for head in store::record::of_imu(&self.store, number, most).await? {
            if head.kind != Kind::Campaign {
                continue;
            }
            let Some(row) = store::record::get(&self.store, head.id).await? else { continue };
            let campaign = campaign::parse_json(row.body.as_bytes()).map_err(|faults| damaged(head.id, &faults))?;
            // Identifiers are in order of arrival; the models are newest first.
            let in_force = models.iter().find(|model| model.id.is_some_and(|id| id < head.id));
            stored.push(Stored { id: head.id, campaign, in_force: in_force.cloned().unwrap_or_default() });
        }
        stored.reverse();
        let imu = imu.to_owned();
        let work = words::spawn_blocking(move || series(imu, &stored, limit as usize));
        let failed = |error| StoreError::Damaged(format!("forecasts could not be made: {error}"));
        Ok(Some(work.await.map_err(failed)?))
    }
}

fn series(imu: String, stored: &[Stored], limit: usize) -> ForecastSeriesBody {
    let mut latest = None;
    let first = stored.len().saturating_sub(limit);
    let points = (first..stored.len()).map(|k| {
        let this = &stored[k];
        let told = foretold(&stored[..k], this);
        let (forecast, why_not) = match told {
            Ok(forecast) => (Some(forecast), None),
            Err(why) => (None, Some(words::asked().words(&why))),
        };
        let point = ForecastPointBody::of(this.id.to_string(), &this.campaign, forecast.as_ref(), why_not);
        latest = forecast.or_else(|| latest.take());
        ForecastPointBody { imu_model: this.in_force.id.map(|id| id.to_string()), ..point }
    });
    let points = points.collect();
    ForecastSeriesBody { imu, points, latest }
}

/// The forecast of `this` campaign: by the coefficients that were adopted, else by those of the campaigns before it,
/// with the terms and effects in force.
fn foretold(before: &[Stored], this: &Stored) -> Result<ForecastBody, Message> {
    let in_force = &this.in_force.model;
    let usable = |model: &&Arc<Identified>| compare(model, &this.campaign).is_ok();
    let model = match in_force.identified.as_ref().filter(usable) {
        Some(adopted) => Arc::clone(adopted),
        None => Arc::new(of_campaigns(before, &this.campaign, in_force)?),
    };
    let campaign = &this.campaign;
    let comparison = compare(&model, campaign).map_err(|why| why.message())?;
    let steps = ladder(&model, campaign).map_err(|why| why.message())?;
    let promised = promised(&model, campaign).map_err(|why| why.message())?;
    let changed = if model.effects.is_empty() { None } else { changed(&model, campaign).ok() };
    let body = ForecastBody::of(&model, campaign, &comparison.forecast, promised);
    Ok(body.compared(&comparison, &steps, changed.as_ref()))
}

fn of_campaigns(before: &[Stored], this: &Campaign, in_force: &AugmentedModel) -> Result<Identified, Message> {
    let gyros = |campaign: &Campaign| -> Vec<_> {
        campaign.gyros.iter().map(|gyro| (gyro.slot, gyro.serial.clone(), gyro.known_e)).collect()
    };
    let alike = |stored: &&Stored| {
        let c = &stored.campaign;
        c.test == TestKind::Imu && gyros(c) == gyros(this) && c.geometry.is_same(&this.geometry)
    };
    let samples: Vec<Sample> = before
        .iter()
        .rev()
        .filter(alike)
        .take(FITTED)
        .map(|stored| Sample { campaign: &stored.campaign, source: Some(stored.id.to_string()), occasions: Vec::new() })
        .collect();
    if samples.is_empty() {
        return Err(message!("nothing_to_foretell_from"));
    }
    identify(&samples, in_force).map_err(|why| why.message())
}

impl ForecastPointBody {
    fn of(id: String, campaign: &Campaign, forecast: Option<&ForecastBody>, why_not: Option<String>) -> Self {
        let compared = forecast.and_then(|forecast| forecast.compared.clone());
        let effects = forecast.and_then(|forecast| forecast.effects_against_model.as_ref());
        let changed = effects.into_iter().flat_map(|body| &body.effects).filter(|effect| effect.changed);
        let mut effects_changed: Vec<String> = changed.map(|effect| effect.effect.clone()).collect();
        effects_changed.dedup();
        Self {
            campaign: id,
            imu_model: None,
            measured_at: time::format(campaign.measured_at),
            station: campaign.station.to_string(),
            model: forecast.map(|forecast| forecast.model.clone()),
            promised: forecast.and_then(|forecast| forecast.promised),
            compared: compared.map(|compared| compared.without_dwells()),
            effects_changed,
            notes: forecast.map(|forecast| forecast.notes.clone()).unwrap_or_default(),
            why_not,
        }
    }
}
