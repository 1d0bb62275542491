//! Why an order about diagnoses or a model is not carried out, and why a gap cannot be split.

use crate::core::diagnose::NoReference;
use crate::core::id::Id;
use crate::core::imu_model::NoForecast;
use crate::core::message::{Message, sent, text};
use crate::message;
use crate::pipeline::error::{StorageError, WriteError, unwritten};
use crate::store::StoreError;

#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.message())]
pub enum DiagnosisError {
    NoSuchDiagnoses(Id),
    DiagnosesEnded(Id),
    UnknownImu(String),
    /// A model of other gyros, or another geometry, than the IMU's newest campaign has.
    OtherGyros(NoForecast),
    NoSuchHypothesis(String),
    HypothesisTaken(String),
    TooManyHypotheses(usize),
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl DiagnosisError {
    pub fn message(&self) -> Message {
        match self {
            Self::NoSuchDiagnoses(id) => message!("no_such_diagnoses", id = text(id)),
            Self::DiagnosesEnded(id) => message!("diagnoses_ended", id = text(id)),
            Self::OtherGyros(why) => message!("model_of_other_gyros", why = why.message()),
            Self::UnknownImu(imu) => message!("unknown_imu", imu = imu.clone()),
            Self::NoSuchHypothesis(name) => message!("no_such_hypothesis", name = sent(name)),
            Self::HypothesisTaken(name) => message!("hypothesis_taken", name = sent(name)),
            Self::TooManyHypotheses(most) => message!("hypotheses_too_many", most = *most),
            Self::Write(error) => error.message(),
        }
    }
}

unwritten!(DiagnosisError);

/// Why a diagnosis cannot be held against a reference.
#[derive(Debug, thiserror::Error)]
pub enum NotSplit {
    #[error("there is no campaign or record {0}")]
    NoSuchReference(Id),
    #[error(transparent)]
    NoReference(#[from] NoReference),
    #[error(transparent)]
    Storage(#[from] StorageError),
}

impl From<StoreError> for NotSplit {
    fn from(error: StoreError) -> Self {
        Self::Storage(error.into())
    }
}
