//! Forecasts of an IMU's stored campaigns, each from the model in force before it: how the gap between what was
//! foretold and what was measured went over time.
//!
//! Made in the background beside each diagnosis and kept with it: nothing waits for them where campaigns come in. What
//! has not been made yet is made for who asks.

use serde::Deserialize;

use super::forecaster::{Forecaster, stored};
use super::models::InForce;
use crate::core::judge::State;
use crate::core::kind::RecordEntry;
use crate::pipeline::Diagnoses;
use crate::pipeline::prelude::*;
use crate::wire::forecast::{ForecastBody, ForecastPointBody, ForecastSeriesBody};
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
    pub async fn forecasts(&self, imu: &str, limit: u32) -> Result<Option<ForecastSeriesBody>, StoreError> {
        let Some(number) = self.store.names().read().imus.number(imu) else { return Ok(None) };
        let (mut points, mut latest) = (Vec::new(), None);
        for id in self.campaigns_of(number, limit).await? {
            // The newest comes first.
            if let Some(kept) = self.said(id).await?.filter(|_| !points.is_empty()) {
                points.push(kept);
                continue;
            }
            let Some((point, told)) = self.made(id, number).await? else { continue };
            points.push(point);
            latest = latest.or(told);
        }
        points.reverse();
        Ok(Some(ForecastSeriesBody { imu: imu.to_owned(), points, latest }))
    }

    /// The forecast of a campaign made now, and dwell by dwell; none where there is no such campaign.
    async fn made(&self, id: Id, imu: u32) -> Result<Option<(ForecastPointBody, Option<ForecastBody>)>, StoreError> {
        let Some(campaign) = stored(&self.store, id).await? else { return Ok(None) };
        let config = &self.reader.config;
        let campaign = config.stations.complete(campaign);
        let forecaster = Forecaster::of(&self.store, config, (id, imu), &campaign).await?;
        let made = computed("forecasts could not be made".to_owned(), move || {
            let told = forecaster.forecast(&campaign);
            (forecaster.point_of(&campaign, told.as_ref()), told.ok())
        });
        Ok(Some(made.await?))
    }

    /// As [`Diagnoses::forecasts`], without dwells: those that are kept, and those of campaigns whose diagnosis is due.
    pub async fn forecasts_of_imu(&self, imu: u32, limit: u32) -> Result<Vec<ForecastPointBody>, StoreError> {
        let mut points = Vec::new();
        for id in self.campaigns_of(imu, limit).await? {
            let is_due = store::diagnosis::get(&self.store, id).await?.is_none();
            let made = if is_due { self.made(id, imu).await?.map(|(point, _)| point) } else { self.said(id).await? };
            points.extend(made);
        }
        points.reverse();
        Ok(points)
    }

    /// Newest first.
    pub(super) async fn campaigns_of(&self, imu: u32, limit: u32) -> Result<Vec<Id>, StoreError> {
        let heads = store::record::of_imu(&self.store, imu, limit.saturating_add(LOOKED_THROUGH)).await?;
        let campaigns = heads.into_iter().filter(|head| head.kind == Kind::Campaign);
        Ok(campaigns.take(limit as usize).map(|head| head.id).collect())
    }

    /// The forecast that is kept with the campaign's diagnosis, in the language that is asked for.
    async fn said(&self, id: Id) -> Result<Option<ForecastPointBody>, StoreError> {
        let mut forecast = kept(&self.store, id).await?;
        if let Some(forecast) = &mut forecast {
            forecast.say(words::asked());
        }
        Ok(forecast)
    }
}

/// The forecast that is kept with a campaign's diagnosis.
async fn kept(store: &Store, id: Id) -> Result<Option<ForecastPointBody>, StoreError> {
    let diagnosis = store::diagnosis::get(store, id).await?.filter(|kept| !kept.refused);
    let kept = diagnosis.and_then(|kept| serde_json::from_str::<WithForecast>(&kept.body).ok());
    Ok(kept.and_then(|kept| kept.forecast))
}

/// What the rule `forecast` says of the newest campaign of an IMU, by the model in force; confirmed where the campaign
/// before of which it says anything lies outside its forecast, too. None where nothing is adopted, or the campaign is
/// not judged by it.
///
/// `made`: one whose diagnosis is about to be kept; none of one that the verdict does not rest on. Without one, of the
/// newest campaign that decides: `gone` are about to be withdrawn.
pub(in crate::pipeline) async fn newest_verdict(
    store: &Store,
    (imu, in_force): (u32, &InForce),
    gone: &[Id],
    made: Option<(Id, &ForecastPointBody)>,
) -> Result<Option<(RecordEntry, Verdict)>, StoreError> {
    let Some(model) = in_force.id.filter(|_| in_force.model.identified.is_some()) else { return Ok(None) };
    let mut campaigns = store::record::of_imu(store, imu, LOOKED_THROUGH).await?;
    campaigns.retain(|head| head.kind == Kind::Campaign && !gone.contains(&head.id));
    let mut newest: Option<(RecordEntry, Verdict)> = None;
    let mut rests_on_made = made.is_none();
    for head in campaigns {
        let point = match made.filter(|(made, _)| *made == head.id) {
            Some((_, point)) => Some(point.clone()),
            None => kept(store, head.id).await?,
        };
        rests_on_made |= made.is_some_and(|(made, _)| made == head.id);
        let point = point.filter(|point| point.imu_model.as_deref() == Some(&*model.to_string()));
        let verdict = point.and_then(|point| point.compared?.verdict?.verdict());
        let decided = verdict.filter(|verdict| verdict.state != State::Indeterminate);
        match (&mut newest, verdict, decided) {
            (None, Some(verdict), _) if made.is_some() || decided.is_some() => newest = Some((head, verdict)),
            (None, None, _) if made.is_some() => return Ok(None),
            (Some((_, of_newest)), _, Some(before)) => {
                of_newest.confirmed = [of_newest.state, before.state] == [State::Exceeded; 2];
                break;
            }
            _ => {}
        }
    }
    Ok(newest.filter(|_| rests_on_made))
}
