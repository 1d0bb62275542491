//! Diagnoses of stored campaigns: made in the background once a campaign is stored, kept, made again when the model
//! in force for its IMU or the program has changed.
//!
//! A campaign is due from the transaction that stores it, its IMU's from the one that adopts a model: what was due when
//! the service stopped is made after its start. Whoever asks for one that is due comes first, and waits or asks again.
//!
//! [`orders`] takes those to diagnose many campaigns, [`queue`] works them off behind what is due, [`summary`] says
//! what many diagnoses say together, from the [`digest`] that is kept of each, [`forecasts`] what was foretold of
//! campaigns before they came in.

pub(super) mod background;
mod diagnoser;
pub(super) mod digest;
mod finished;
mod forecaster;
mod forecasts;
pub(super) mod models;
mod orders;
mod queue;
mod summary;

use super::write_queue::{Job, WriteQueue};
use crate::core::augmented::AugmentedModel;
use crate::core::campaign::Campaign;
use crate::core::diagnose::{NoReference, Reference, split};
use crate::core::effects::{self, Effect};
use crate::core::imu_model::{NoForecast, forecast};
use crate::core::message::text as shown_text;
use crate::pipeline::Reader;
use crate::pipeline::diagnoses::background::WorkPriority;
use crate::pipeline::diagnoses::digest::Digest;
use crate::pipeline::diagnoses::forecaster::stored;
use crate::pipeline::diagnoses::models::read;
use crate::pipeline::ingest::campaign::{campaign_of, damaged};
use crate::pipeline::ingest::submission::anything;
use crate::pipeline::prelude::*;
use crate::store::{CampaignFilter, FailedTask, JobRow, ModelRow, TaskCounts};
use crate::wire::cursor::{self, List};
use crate::wire::diagnoses::{CountsBody, FailureBody, JobBody, JobDetailBody, SummaryBody, WhichBody};
use crate::wire::diagnosis::{DiagnosisBody, residuals};
use crate::wire::message::from_stored;
use crate::wire::record::parse_record;
use crate::wire::split::SplitBody;
use crate::wire::{campaign, text, time};
use crate::words;

pub(super) use diagnoser::Diagnoser;
pub use diagnoser::DiagnosisAnswer;
pub use digest::Conclusion;
pub(super) use finished::FinishedDiagnosis;
pub(super) use forecasts::newest_verdict;
pub use models::{Adoption, StoredHypothesis};
pub use orders::{DiagnosisOrder, HypothesisOrder, WantedDiagnoses};
pub(super) use orders::{order_diagnoses, order_hypothesis};
pub use summary::SummaryFilter;
pub(super) use summary::outside_forecasts;

#[derive(Debug, Clone, PartialEq)]
pub struct AdoptedModel {
    pub row: ModelRow,
    pub model: Arc<AugmentedModel>,
    /// Stored campaigns, and records with effects of temperature, that are stated with it.
    pub campaigns: u64,
}

/// Diagnoses of stored campaigns, and the models in force for IMUs. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Diagnoses {
    pub(super) store: Store,
    pub(super) diagnoser: Diagnoser,
    pub(super) queue: WriteQueue,
    pub(super) reader: Reader,
}

impl Diagnoses {
    /// The diagnosis of a stored campaign against the model in force for its IMU; [`DiagnosisAnswer::Waiting`] where
    /// it is not made within `patience`.
    pub async fn of_campaign(&self, id: Id, patience: Duration) -> Result<DiagnosisAnswer, StoreError> {
        self.diagnoser.diagnosis(id, WorkPriority::Interactive, patience).await
    }

    /// The gap of a diagnosed campaign against another stored campaign or record of its IMU, or why that is no reference
    /// for it; none where one of the two is not stored. Computing, a few milliseconds.
    pub async fn split(
        &self,
        id: Id,
        diagnosis: &DiagnosisBody,
        reference: Id,
    ) -> Result<Option<Result<SplitBody, NoReference>>, StoreError> {
        let Some(row) = store::record::get(&self.store, id).await? else { return Ok(None) };
        let Some(held_against) = store::record::get(&self.store, reference).await? else { return Ok(None) };
        let campaign = campaign_of(&row)?;
        let body = held_against.body.as_bytes();
        let reference = match held_against.kind {
            Kind::Campaign => campaign::parse_json(body).map(Reference::Campaign),
            Kind::Record => parse_record(body, &anything()).map(Reference::Record),
        };
        let reference = reference.map_err(|faults| damaged(held_against.id, &faults))?;
        let options = self.reader.models.of(Some(row.imu)).model.options_as_asked(&campaign);
        let split = split(&campaign, &options, &residuals(&diagnosis.residuals), &reference);
        Ok(Some(split.map(|split| SplitBody::from(&split))))
    }

    /// An adoption of what the diagnosis of a stored campaign names, beside the model in force for its IMU; none where
    /// there is no such campaign or no answer.
    pub async fn adoption(&self, id: Id, author: String, reason: String) -> Result<Option<Adoption>, StoreError> {
        let Some((imu, model)) = self.diagnoser.proposed(id).await? else { return Ok(None) };
        let imu = self.store.names().read().imus.name(imu).map(|name| name.to_string());
        Ok(imu.map(|imu| Adoption { imu, model: Arc::new(model), author, reason }))
    }

    /// Puts a model in force for an IMU and states its stored campaigns anew; returns once that is on disk. One without
    /// terms and effects undoes those before it.
    pub async fn adopt(&self, adoption: Adoption) -> Result<Accepted, Refused> {
        if let Some(identified) = &adoption.model.identified
            && let Some(newest) = self.newest_campaign(&adoption.imu).await?
            && let Err(why @ (NoForecast::OtherGeometry | NoForecast::NoGyro)) = forecast(identified, &newest)
        {
            return Err(Refused::not_storable("/identified", message!("model_of_other_gyros", why = why.message())));
        }
        // Fitted here, so that nobody waits for it; what comes in between the writer fits itself.
        let restated = self.reader.restated(&adoption.imu, &adoption.model, HashMap::new()).await?;
        let (adoption, by) = (Box::new((adoption, restated)), Actor::by_caller());
        self.queue.ask(|reply| Job::Model { adoption, by, reply }).await
    }

    async fn newest_campaign(&self, imu: &str) -> Result<Option<Campaign>, StoreError> {
        let Some(imu) = self.store.names().read().imus.number(imu) else { return Ok(None) };
        let Some(id) = self.campaigns_of(imu, 1).await?.first().copied() else { return Ok(None) };
        stored(&self.store, id).await
    }

    /// The models of an IMU, newest first; none where no such IMU is known.
    pub async fn models(&self, imu: &str) -> Result<Option<Vec<AdoptedModel>>, StoreError> {
        let Some(imu) = self.store.names().read().imus.number(imu) else { return Ok(None) };
        let rows = store::model::of_imu(&self.store, imu).await?;
        let uses: HashMap<Id, u64> = store::model::uses(&self.store, imu).await?.into_iter().collect();
        let adopted = |row: ModelRow| -> Result<_, StoreError> {
            let campaigns = uses.get(&row.id).copied().unwrap_or_default();
            Ok(AdoptedModel { model: read(&row)?.model, row, campaigns })
        };
        Ok(Some(rows.into_iter().map(adopted).collect::<Result<_, _>>()?))
    }

    /// Has a hypothesis compete in every diagnosis, or no more; returns once that is on disk.
    pub async fn order_hypothesis(&self, order: HypothesisOrder) -> Result<Accepted, Refused> {
        let by = Actor::by_caller();
        self.queue.ask(|reply| Job::Hypothesis { order, by, reply }).await
    }

    /// The hypotheses that compete, in the order in which they were added.
    pub fn hypotheses(&self) -> Vec<StoredHypothesis> {
        self.reader.models.competing().hypotheses.clone()
    }

    pub fn check_wanted(&self, asked: WhichBody) -> Result<WantedDiagnoses, Faults> {
        let mut faults = Faults::default();
        let which = self.campaign_filter(&asked, &mut faults);
        let in_utc = |at: Option<String>, instant| at.map(|_| time::format(instant));
        let asked = WhichBody {
            since: in_utc(asked.since, which.measured.from),
            until: in_utc(asked.until, which.measured.to),
            ..asked
        };
        faults.or(WantedDiagnoses { asked, which })
    }

    /// The campaigns that are meant, faults noted at their places.
    pub(super) fn campaign_filter(&self, asked: &WhichBody, faults: &mut Faults) -> CampaignFilter {
        let mut known = |what: &str, name: &Option<String>, number: Option<u32>| {
            if let (Some(name), None) = (name, number) {
                let unknown = match what {
                    "imu" => message!("unknown_imu", imu = name.clone()),
                    _ => message!("unknown_station", station = name.clone()),
                };
                faults.push(format!("/{what}"), unknown);
            }
            number
        };
        let (imu, station) = {
            let tables = self.store.names().read();
            let imu = asked.imu.as_deref().and_then(|name| tables.imus.number(name));
            let station = asked.station.as_deref().and_then(|name| tables.stations.number(name));
            (known("imu", &asked.imu, imu), known("station", &asked.station, station))
        };
        let (since, until) = (asked.since.as_deref(), asked.until.as_deref());
        let from = since.map_or(Span::EVER.from, |since| text::start("/since", since, faults));
        let to = until.map_or(Span::EVER.to, |until| text::end("/until", until, faults));
        if faults.is_empty() && from > to {
            faults.push("/until", message!("until_before_since"));
        }
        CampaignFilter { imu, station, measured: Span { from, to } }
    }

    /// Has the writer carry out an order about many diagnoses; returns once it is on disk.
    pub async fn order(&self, order: DiagnosisOrder) -> Result<Accepted, Refused> {
        let by = Actor::by_caller();
        self.queue.ask(|reply| Job::Diagnoses { order, by, reply }).await
    }

    /// Orders with their progress, newest first, those before `before`.
    pub async fn jobs(&self, before: Option<Id>, limit: u32) -> Result<Vec<JobBody>, StoreError> {
        let mut bodies = Vec::new();
        for row in store::diagnosis_job::list(&self.store, before, limit).await? {
            let counts = store::diagnosis_job::task_counts(&self.store, row.id).await?;
            bodies.push(shown(row, counts)?);
        }
        Ok(bodies)
    }

    /// One order, and what failed of it after `after`.
    pub async fn job(&self, id: Id, after: Option<Id>, limit: u32) -> Result<Option<JobDetailBody>, StoreError> {
        let Some(row) = store::diagnosis_job::get(&self.store, id).await? else { return Ok(None) };
        let job = shown(row, store::diagnosis_job::task_counts(&self.store, id).await?)?;
        let mut failed = store::diagnosis_job::failed_tasks(&self.store, id, after, limit + 1).await?;
        let more = failed.len() > limit as usize;
        failed.truncate(limit as usize);
        let next = failed.last().filter(|_| more).map(|last| cursor::encode(List::DiagnosisFailures, last.record.0));
        let tables = self.store.names().read();
        let failure = |task: FailedTask| FailureBody {
            campaign: task.record.to_string(),
            imu: tables.imus.text(task.imu).to_owned(),
            measured_at: time::format(task.measured_at),
            reason: words::asked().words(&from_stored(&task.reason)),
        };
        Ok(Some(JobDetailBody { job, failures: failed.into_iter().map(failure).collect(), next }))
    }

    /// Campaigns that wait for their first diagnosis, and those that orders wait for.
    pub async fn waiting(&self) -> Result<(u64, u64), StoreError> {
        store::diagnosis_job::diagnoses_waiting(&self.store).await
    }

    /// Checks of what a summary is to be: campaigns as an order names them, and an effect by its catalogue name.
    pub fn summary_filter(&self, asked: &WhichBody, effect: Option<&str>) -> Result<SummaryFilter, Faults> {
        let mut faults = Faults::default();
        let campaigns = self.campaign_filter(asked, &mut faults);
        let competing = self.reader.models.competing();
        let own = |id: &str| competing.effects().find(|own| own.id() == id);
        let known = effect.and_then(|id| Effect::from_id(id).or_else(|| own(id)));
        if let (Some(id), None) = (effect, known) {
            faults.push(
                "/effect",
                message!("unknown_effect", effect = shown_text(id), effects = shown_text(effects::known())),
            );
        }
        faults.or(SummaryFilter { campaigns, effect: known })
    }

    /// What the diagnoses of stored campaigns say together. Campaigns that count no more are left out.
    pub async fn summary(&self, filter: &SummaryFilter) -> Result<SummaryBody, StoreError> {
        filter.summary(&self.store, &self.reader.models.competing().program).await
    }

    /// What was concluded of each campaign of an IMU that is diagnosed and counts.
    pub async fn conclusions(&self, imu: u32) -> Result<HashMap<Id, Conclusion>, StoreError> {
        let of_imu = CampaignFilter { imu: Some(imu), station: None, measured: Span::EVER };
        let mut all = HashMap::new();
        store::diagnosis_digest::each(&self.store, &of_imu, |row| {
            let Digest { verdict, effects, .. } = Digest::of_row(&row)?;
            let effects = effects.into_iter().map(|named| named.effect).collect();
            all.insert(row.record, Conclusion { verdict, effects });
            Ok(())
        })
        .await?;
        Ok(all)
    }
}

fn shown(row: JobRow, counts: TaskCounts) -> Result<JobBody, StoreError> {
    let damaged = |error| StoreError::damaged(format_args!("order {} of diagnoses cannot be read: {error}", row.id));
    let asked: WhichBody = serde_json::from_str(&row.asked).map_err(damaged)?;
    let state = match (row.canceled, row.ended_at, row.begun_at) {
        (true, ..) => "canceled",
        (false, Some(_), _) => "done",
        (false, None, Some(_)) => "running",
        (false, None, None) => "waiting",
    };
    let TaskCounts { waiting, done, failed, canceled } = counts;
    Ok(JobBody {
        id: row.id.to_string(),
        state: state.to_owned(),
        asked,
        asked_by: row.asked_by,
        asked_at: time::format(row.asked_at),
        begun_at: row.begun_at.map(time::format),
        ended_at: row.ended_at.map(time::format),
        counts: CountsBody { campaigns: waiting + done + failed + canceled, waiting, done, failed, canceled },
    })
}
