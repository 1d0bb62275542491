//! Forecasts of an IMU's stored campaigns, each from the model in force before it: how the gap between what was
//! foretold and what was measured went over time.
//!
//! Made in the background beside each diagnosis and kept with it: nothing waits for them where campaigns come in. What
//! has not been made yet is made for who asks.

use serde::Deserialize;

use super::Diagnoses;
use super::foretelling::{Foretelling, stored};
use crate::core::id::Id;
use crate::core::kind::Kind;
use crate::pipeline::error::StorageError;
use crate::store;
use crate::store::StoreError;
use crate::wire::forecast::{ForecastPointBody, ForecastSeriesBody};
use crate::words;

/// Calibrations beside the campaigns that are asked for among which these are looked for.
const LOOKED_THROUGH: u32 = 32;

/// What a kept diagnosis says of it.
#[derive(Deserialize)]
struct WithForecast {
    forecast: Option<ForecastPointBody>,
}

impl Diagnoses {
    /// The forecasts of the newest `limit` campaigns of an IMU, oldest first, the newest dwell by dwell; none where no
    /// such IMU is known. Computing, some milliseconds for the newest and each that has not been made.
    ///
    /// # Errors
    /// [`StorageError`].
    pub async fn forecasts(&self, imu: &str, limit: u32) -> Result<Option<ForecastSeriesBody>, StorageError> {
        let Some(number) = self.store.names().read().imus.number(imu) else { return Ok(None) };
        let (mut points, mut latest) = (Vec::new(), None);
        for id in self.campaigns_of(number, limit).await? {
            // The newest comes first.
            if let Some(kept) = self.kept(id).await?.filter(|_| !points.is_empty()) {
                points.push(kept);
                continue;
            }
            let Some(campaign) = stored(&self.store, id).await? else { continue };
            let foretelling = Foretelling::of(&self.store, (id, number), &campaign).await?;
            let work = words::spawn_blocking(move || {
                let told = foretelling.foretold(&campaign);
                (foretelling.point_of(&campaign, told.as_ref()), told)
            });
            let failed = |error| StoreError::Damaged(format!("forecasts could not be made: {error}"));
            let (point, told) = work.await.map_err(failed)?;
            points.push(point);
            latest = latest.or(told.ok());
        }
        points.reverse();
        Ok(Some(ForecastSeriesBody { imu: imu.to_owned(), points, latest }))
    }

    /// As [`Diagnoses::forecasts`], those that have been made.
    ///
    /// # Errors
    /// [`StorageError`].
    pub async fn forecasts_made(&self, imu: u32, limit: u32) -> Result<Vec<ForecastPointBody>, StorageError> {
        let mut points = Vec::new();
        for id in self.campaigns_of(imu, limit).await? {
            points.extend(self.kept(id).await?);
        }
        points.reverse();
        Ok(points)
    }

    /// Newest first.
    async fn campaigns_of(&self, imu: u32, limit: u32) -> Result<Vec<Id>, StoreError> {
        let heads = store::record::of_imu(&self.store, imu, limit.saturating_add(LOOKED_THROUGH)).await?;
        let campaigns = heads.into_iter().filter(|head| head.kind == Kind::Campaign);
        Ok(campaigns.take(limit as usize).map(|head| head.id).collect())
    }

    /// The forecast that is kept with the campaign's diagnosis, in the language that is asked for.
    async fn kept(&self, id: Id) -> Result<Option<ForecastPointBody>, StoreError> {
        let diagnosis = store::diagnosis::get(&self.store, id).await?.filter(|kept| !kept.refused);
        let kept = diagnosis.and_then(|kept| serde_json::from_str::<WithForecast>(&kept.body).ok());
        let mut forecast = kept.and_then(|kept| kept.forecast);
        if let Some(forecast) = &mut forecast {
            forecast.say(words::asked());
        }
        Ok(forecast)
    }
}
