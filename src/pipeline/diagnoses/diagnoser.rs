//! Makes diagnoses, one for all who ask, and has them kept.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use tokio::sync::{Semaphore, watch};

use crate::core::augmented::{AugmentedModel, Options};
use crate::core::campaign::Campaign;
use crate::core::diagnose::diagnose;
use crate::core::effects::Effect;
use crate::core::imu_model::changed_since;
use crate::pipeline::Reader;
use crate::pipeline::diagnoses::background::{IdleDetector, WorkPriority, beside_others};
use crate::pipeline::diagnoses::digest::seats;
use crate::pipeline::diagnoses::finished::{Diagnosed, DiagnosisOutcome, FinishedDiagnosis};
use crate::pipeline::diagnoses::forecaster::Forecaster;
use crate::pipeline::diagnoses::models::{Competing, InForce};
use crate::pipeline::ingest::campaign::campaign_of;
use crate::pipeline::prelude::*;
use crate::pipeline::write_queue::{Job, WeakWriteQueue};
use crate::store::{DiagnosisRow, RecordRow};
use crate::telemetry;
use crate::wire::diagnosis::DiagnosisBody;
use crate::wire::forecast::ChangedBody;
use crate::wire::message::{from_stored, to_stored};

/// Computed at the same time at the least, where there is but one processor: one asked for need not wait for another.
const AT_ONCE: usize = 2;

/// What has become of the question.
#[derive(Debug, Clone)]
pub enum DiagnosisAnswer {
    NoSuchCampaign,
    /// It is being made; ask again.
    Waiting,
    Answered(Diagnosed),
}

/// Those who wait for one that is being made, of a campaign against a model by a program, learn of its end.
type InProgress = HashMap<(Id, Option<Id>, String), watch::Receiver<Option<Diagnosed>>>;

/// Who makes diagnoses and has them kept. Cheap to clone.
#[derive(Debug, Clone)]
pub(in crate::pipeline) struct Diagnoser {
    pub(super) reader: Reader,
    /// Weak: the writer ends when nobody but this could send to it.
    queue: WeakWriteQueue,
    pub(super) idle: IdleDetector,
    /// How many are computed at the same time.
    pub(super) at_once: usize,
    turns: Arc<Semaphore>,
    under_way: Arc<Mutex<InProgress>>,
}

/// What a campaign is compared with.
fn against(in_force: &InForce, competing: &Competing, campaign: &Campaign) -> Options {
    let options = in_force.model.options_as_asked(campaign);
    // One that the model holds is fitted, and has nothing to compete for.
    let is_held = |own: &Effect| options.adopted.iter().any(|adopted| adopted.effect.id() == own.id());
    let hypotheses = competing.effects().filter(|own| !is_held(own)).collect();
    Options { hypotheses, ..options }
}

impl Diagnoser {
    pub fn new(reader: Reader, queue: WeakWriteQueue, idle: IdleDetector) -> Self {
        let at_once = std::thread::available_parallelism().map_or(AT_ONCE, |n| n.get().max(AT_ONCE));
        let turns = Arc::new(Semaphore::new(at_once));
        Self { reader, queue, idle, at_once, turns, under_way: Arc::default() }
    }

    /// The diagnosis of a stored campaign against the model in force: as it was kept, or made now.
    pub(super) async fn diagnosis(
        &self,
        id: Id,
        awaited: WorkPriority,
        patience: Duration,
    ) -> Result<DiagnosisAnswer, StoreError> {
        let Some(row) = self.campaign(id).await? else { return Ok(DiagnosisAnswer::NoSuchCampaign) };
        let in_force = self.reader.models.of(Some(row.imu));
        if let Some(diagnosed) = self.kept(&row, &in_force).await? {
            return Ok(DiagnosisAnswer::Answered(diagnosed));
        }
        let mut end = self.begin(&row, in_force, awaited)?;
        let ended = tokio::time::timeout(patience, end.wait_for(Option::is_some)).await;
        let Ok(ended) = ended else { return Ok(DiagnosisAnswer::Waiting) };
        let gone = || StoreError::damaged(format_args!("the diagnosis of campaign {id} failed"));
        let diagnosed = ended.map_err(|_| gone())?.clone().ok_or_else(gone)?;
        Ok(DiagnosisAnswer::Answered(diagnosed))
    }

    pub(super) async fn campaign(&self, id: Id) -> Result<Option<RecordRow>, StoreError> {
        Ok(store::record::get(&self.reader.store, id).await?.filter(|row| row.kind == Kind::Campaign))
    }

    /// As it was kept by this program against the model in force.
    async fn kept(&self, row: &RecordRow, in_force: &InForce) -> Result<Option<Diagnosed>, StoreError> {
        let kept = store::diagnosis::get(&self.reader.store, row.id).await?;
        let is_of_now =
            |kept: &DiagnosisRow| kept.program == self.reader.models.competing().program && kept.model == in_force.id;
        let Some(kept) = kept.filter(is_of_now) else { return Ok(None) };
        let damaged =
            |error| StoreError::damaged(format_args!("the diagnosis of campaign {} cannot be read: {error}", row.id));
        let read = |body: &str| serde_json::from_str(body).map_err(damaged);
        Ok(Some(Arc::new(if kept.refused { Err(from_stored(&kept.body)) } else { Ok(read(&kept.body)?) })))
    }

    /// Has it made by a task of its own, whether or not the caller stays; once, however many ask.
    pub(super) fn begin(
        &self,
        row: &RecordRow,
        in_force: InForce,
        awaited: WorkPriority,
    ) -> Result<watch::Receiver<Option<Diagnosed>>, StoreError> {
        let competing = self.reader.models.competing();
        let key = (row.id, in_force.id, competing.program.clone());
        let mut under_way = self.under_way.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(end) = under_way.get(&key) {
            return Ok(end.clone());
        }
        let campaign = self.reader.config.stations.complete(campaign_of(row)?);
        let (ended, end) = watch::channel(None);
        under_way.insert(key.clone(), end.clone());
        let (diagnoser, imu) = (self.clone(), row.imu);
        tokio::spawn(async move {
            let gyros = seats(&campaign);
            let Reader { store, config, .. } = &diagnoser.reader;
            let forecaster = Forecaster::of(store, config, (key.0, imu), &campaign).await;
            let forecaster = forecaster.inspect_err(|error| {
                tracing::warn!(%error, campaign = %key.0, "what foretells a campaign cannot be read");
            });
            // Without what foretells it, it is an answer for now: it is still due.
            let is_whole = !matches!(&forecaster, Err(error) if !matches!(error, StoreError::Damaged(_)));
            let asked = (campaign, forecaster.ok());
            let (begun_at, made) = diagnoser.compute(asked, (&in_force, &competing), awaited).await;
            let (campaign, model, program) = key.clone();
            let outcome = match &made {
                Some(diagnosed) => {
                    DiagnosisOutcome::Known { imu, model, program, diagnosed: Arc::clone(diagnosed), gyros }
                }
                None => DiagnosisOutcome::Failed(to_stored(&message!("computation_broke_off"))),
            };
            let ended_at = diagnoser.reader.clock.now();
            if is_whole {
                diagnoser.have_kept(FinishedDiagnosis { campaign, begun_at, ended_at, outcome }).await;
            }
            if made.is_some() {
                ended.send_replace(made);
            }
            diagnoser.under_way.lock().unwrap_or_else(PoisonError::into_inner).remove(&key);
        });
        Ok(end)
    }

    /// When it is its turn: since when, and the answer; none where it panicked.
    async fn compute(
        &self,
        (campaign, forecaster): (Campaign, Option<Forecaster>),
        (in_force, competing): (&InForce, &Competing),
        awaited: WorkPriority,
    ) -> (UtcMicros, Option<Diagnosed>) {
        // Nobody closes it: a turn always comes.
        let _turn = self.turns.acquire().await;
        let (begun_at, begun) = (self.reader.clock.now(), Instant::now());
        let options = against(in_force, competing, &campaign);
        let model = Arc::clone(&in_force.model);
        let work = move || match diagnose(&campaign, &options) {
            Ok(diagnosis) => {
                let changed = changed_since(&model, &campaign).map(|changed| ChangedBody::from(&changed));
                let body = DiagnosisBody { effects_against_model: changed, ..DiagnosisBody::from(&diagnosis) };
                let body = body.noted(model.notes_of_others(&campaign));
                Ok(body.with_forecast(forecaster.map(|forecaster| forecaster.point(&campaign))))
            }
            Err(why) => Err(why.message()),
        };
        let made = beside_others("diagnosis", awaited, work).await;
        let outcome = match &made {
            Some(Ok(_)) => "made",
            Some(Err(_)) => "refused",
            None => "failed",
        };
        metrics::counter!(telemetry::DIAGNOSES, "outcome" => outcome).increment(1);
        metrics::histogram!(telemetry::DIAGNOSIS_TIME).record(begun.elapsed());
        let forecast = made.iter().flatten().find_map(|body| body.forecast.as_ref()?.compared.as_ref());
        if let Some(compared) = forecast {
            metrics::histogram!(telemetry::FORECAST_RMS).record(compared.rms_over_sd);
        }
        (begun_at, made.map(Arc::new))
    }

    /// The model in force for the IMU of a stored campaign with what the campaign's diagnosis names; none where there
    /// is no such campaign or no answer.
    pub(super) async fn proposed(&self, id: Id) -> Result<Option<(u32, AugmentedModel)>, StoreError> {
        let Some(row) = self.campaign(id).await? else { return Ok(None) };
        let campaign = campaign_of(&row)?;
        let in_force = self.reader.models.of(Some(row.imu));
        let options = against(&in_force, &self.reader.models.competing(), &campaign);
        let work = move || Some(in_force.model.adopting(&campaign, &diagnose(&campaign, &options).ok()?));
        let model = beside_others("diagnosis", WorkPriority::Interactive, work).await.flatten();
        Ok(model.map(|model| (row.imu, model)))
    }

    /// Puts it on disk; where that fails it is still due, and is made again.
    pub(super) async fn have_kept(&self, made: FinishedDiagnosis) {
        let Some(queue) = self.queue.upgrade() else { return };
        let campaign = made.campaign;
        match queue.ask_in_turn(|reply| Job::Diagnosed { made, reply }).await {
            Ok(()) | Err(Refused::Stopping) => {}
            Err(error) => tracing::warn!(%error, %campaign, "a diagnosis could not be kept"),
        }
    }
}
