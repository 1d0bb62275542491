//! Why something is not done: the database may fail, the writer may be busy or gone, an order may make no sense.

use std::sync::Arc;

use crate::core::diagnose::NoReference;
use crate::core::id::Id;
use crate::core::imu_model::NoForecast;
use crate::core::message::{Message, sent, text};
use crate::message;
use crate::store::StoreError;

/// The database has failed. Cheap to clone; for logs it says what the database said.
#[derive(Debug, Clone, thiserror::Error)]
#[error(transparent)]
pub struct StorageError(Arc<StoreError>);

/// What a failure of the database means to whoever asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StorageFault {
    /// There is no room.
    Full,
    /// Nothing was stored, and another try may do better.
    Unwritable,
    /// What was sent may be stored or not.
    Unanswered,
    /// It cannot be read.
    Damaged,
    /// Anything else: a fault of the service.
    Internal,
}

impl StorageError {
    pub fn fault(&self) -> StorageFault {
        match &*self.0 {
            StoreError::Full => StorageFault::Full,
            StoreError::ReadOnly(_)
            | StoreError::Busy
            | StoreError::Unreachable(_)
            | StoreError::Overtaken(_)
            | StoreError::NotDurable(_) => StorageFault::Unwritable,
            StoreError::Unanswered(_) => StorageFault::Unanswered,
            StoreError::Damaged(_) | StoreError::NoDatabase(_) => StorageFault::Damaged,
            StoreError::Refused(_)
            | StoreError::InUse(_)
            | StoreError::File(_)
            | StoreError::Key(_)
            | StoreError::Other(_) => StorageFault::Internal,
        }
    }

    /// What a client is told. The log has the rest.
    pub fn message(&self) -> Message {
        match (&*self.0, self.fault()) {
            (StoreError::NotDurable(_), _) => message!("disk_failed"),
            (StoreError::Damaged(what), _) => message!("database_damaged", what = what.clone()),
            (_, StorageFault::Full) => message!("disk_full"),
            (_, StorageFault::Unwritable) => message!("cannot_write"),
            (_, StorageFault::Unanswered) => message!("perhaps_stored"),
            (_, StorageFault::Damaged | StorageFault::Internal) => message!("service_failed"),
        }
    }

    /// What the database said.
    pub fn store_error(&self) -> &StoreError {
        &self.0
    }
}

impl From<StoreError> for StorageError {
    fn from(error: StoreError) -> Self {
        Self(Arc::new(error))
    }
}

/// Nothing was written; after [`StorageFault::Unanswered`] that is not known.
#[derive(Debug, Clone, thiserror::Error)]
pub enum WriteError {
    #[error("{}", self.message())]
    Busy,
    #[error("{}", self.message())]
    Stopping,
    #[error(transparent)]
    Storage(#[from] StorageError),
}

impl WriteError {
    pub fn message(&self) -> Message {
        match self {
            Self::Busy => message!("busy"),
            Self::Stopping => message!("stopping"),
            Self::Storage(error) => error.message(),
        }
    }
}

/// An error behind which a failed write may be.
pub(super) trait WriteFailure: From<StoreError> {
    /// What the database said, if it was the database.
    fn store_error(&self) -> Option<&StoreError>;
}

impl From<StoreError> for WriteError {
    fn from(error: StoreError) -> Self {
        Self::Storage(error.into())
    }
}

impl WriteFailure for WriteError {
    fn store_error(&self) -> Option<&StoreError> {
        match self {
            Self::Storage(error) => Some(error.store_error()),
            Self::Busy | Self::Stopping => None,
        }
    }
}

/// Why an order is not carried out. Nothing has changed then; after [`StorageFault::Unanswered`] that is not known.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.message())]
pub enum OrderError {
    NoSuchToken(Id),
    SetupOver,
    NoRandomNumbers,
    UnknownAlert(Id),
    AlertResolved(Id),
    UnknownSilence(Id),
    TooManySilences(usize),
    NoSuchHook(Id),
    NoSuchDelivery(Id),
    HookDisabled(Id),
    StillBehind(Id),
    Dropped(Id),
    SecretNeeded,
    /// A `mailto:` address for a hook that is no e-mail, or another for one that is.
    OtherKind,
    TooManyHooks(usize),
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

impl OrderError {
    pub fn message(&self) -> Message {
        match self {
            Self::NoSuchToken(id) => message!("no_such_token", id = text(id)),
            Self::SetupOver => message!("setup_over"),
            Self::NoRandomNumbers => message!("no_random_numbers"),
            Self::UnknownAlert(id) => message!("unknown_alert", id = text(id)),
            Self::AlertResolved(id) => message!("alert_resolved", id = text(id)),
            Self::UnknownSilence(id) => message!("unknown_silence", id = text(id)),
            Self::TooManySilences(most) => message!("too_many_silences", most = *most),
            Self::NoSuchHook(id) => message!("no_such_hook", id = text(id)),
            Self::NoSuchDelivery(id) => message!("no_such_delivery", id = text(id)),
            Self::HookDisabled(id) => message!("hook_disabled", id = text(id)),
            Self::StillBehind(id) => message!("still_behind", id = text(id)),
            Self::Dropped(id) => message!("delivery_dropped", id = text(id)),
            Self::SecretNeeded => message!("secret_needed"),
            Self::OtherKind => message!("target_of_other_kind"),
            Self::TooManyHooks(most) => message!("too_many_hooks", most = *most),
            Self::NoSuchDiagnoses(id) => message!("no_such_diagnoses", id = text(id)),
            Self::DiagnosesEnded(id) => message!("diagnoses_ended", id = text(id)),
            Self::UnknownImu(imu) => message!("unknown_imu", imu = imu.clone()),
            Self::OtherGyros(why) => message!("model_of_other_gyros", why = why.message()),
            Self::NoSuchHypothesis(name) => message!("no_such_hypothesis", name = sent(name)),
            Self::HypothesisTaken(name) => message!("hypothesis_taken", name = sent(name)),
            Self::TooManyHypotheses(most) => message!("hypotheses_too_many", most = *most),
            Self::Write(error) => error.message(),
        }
    }
}

/// Makes an error with a variant `Write` one behind which a failed write may be.
macro_rules! unwritten {
    ($error:ty) => {
        impl From<$crate::store::StoreError> for $error {
            fn from(error: $crate::store::StoreError) -> Self {
                Self::Write(error.into())
            }
        }

        impl $crate::pipeline::error::WriteFailure for $error {
            fn store_error(&self) -> Option<&$crate::store::StoreError> {
                if let Self::Write(error) = self { error.store_error() } else { None }
            }
        }
    };
}

pub(super) use unwritten;

unwritten!(OrderError);

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
