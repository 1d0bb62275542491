//! A diagnosis that was made, and what the one writer does with it.

use crate::pipeline::diagnoses::digest::{Digest, MountedGyro};
use crate::pipeline::diagnoses::models::ModelCache;
use crate::pipeline::prelude::*;
use crate::store::{DiagnosisRow, FinishedTask, JobChanges, NewDiagnosis};
use crate::wire::diagnosis::DiagnosisBody;
use crate::wire::forecast::ForecastPointBody;
use crate::wire::json;
use crate::wire::message::to_stored;

/// The answer, or why there is none.
pub type Diagnosed = Arc<Result<DiagnosisBody, Message>>;

/// What has come of a campaign that was to be diagnosed.
#[derive(Debug)]
pub(in crate::pipeline) struct FinishedDiagnosis {
    pub(super) campaign: Id,
    pub(super) begun_at: UtcMicros,
    pub(super) ended_at: UtcMicros,
    pub(super) outcome: DiagnosisOutcome,
}

#[derive(Debug)]
pub(super) enum DiagnosisOutcome {
    Known {
        imu: u32,
        /// That it was made against.
        model: Option<Id>,
        program: String,
        diagnosed: Diagnosed,
        gyros: Vec<MountedGyro>,
    },
    /// There is no answer, not even why the campaign leaves none: a fault of the program or of the disk.
    Failed(String),
}

impl FinishedDiagnosis {
    /// What the writer writes, none where another model has come into force or another hypothesis competes meanwhile.
    /// Orders that wait for the campaign are told in the same.
    pub fn changes(&self, models: &ModelCache) -> Option<Changes> {
        let Self { campaign, begun_at, ended_at, outcome } = self;
        let mut changes = Changes::default();
        let failed = match outcome {
            DiagnosisOutcome::Known { imu, model, program, diagnosed, gyros } => {
                if (models.of(Some(*imu)).id, &models.competing().program) != (*model, program) {
                    return None;
                }
                let (refused, body) = match &**diagnosed {
                    Ok(body) => (false, json::written(body)),
                    Err(why) => (true, to_stored(why)),
                };
                let (model, program) = (*model, program.clone());
                let row = DiagnosisRow { record: *campaign, model, program, refused, body: body.clone() };
                changes
                    .diagnoses
                    .push(NewDiagnosis { row, gist: json::written(&Digest::of(gyros.clone(), diagnosed)) });
                refused.then_some(body)
            }
            DiagnosisOutcome::Failed(why) => Some(why.clone()),
        };
        let settled = vec![FinishedTask { record: *campaign, begun_at: *begun_at, ended_at: *ended_at, failed }];
        changes.diagnosis_jobs = JobChanges { settled, ..JobChanges::default() };
        Some(changes)
    }

    /// The campaign, its IMU, and what was foretold of it.
    pub fn forecast(&self) -> Option<(Id, u32, &ForecastPointBody)> {
        let DiagnosisOutcome::Known { imu, diagnosed, .. } = &self.outcome else { return None };
        let body = diagnosed.as_ref().as_ref().ok()?;
        Some((self.campaign, *imu, body.forecast.as_ref()?))
    }
}
