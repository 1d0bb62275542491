//! Which failure of which room leaves as which status, said once.

use crate::core::kind::Kind;
use crate::message;
use crate::pipeline::{
    AccessError, AlertError, DiagnosisError, HookError, Refused, StorageError, StorageFault, WriteError,
};
use crate::wire::problem::Problem;

impl From<Refused> for Problem {
    fn from(refused: Refused) -> Self {
        let detail = refused.message();
        match refused {
            Refused::Differs { existing, differences } => {
                let problem = Self::new(409, "title_differs", detail).with_existing(existing);
                let pointers = differences.pointers.into_iter();
                pointers.fold(problem, |problem, pointer| problem.with_place(pointer, message!("differs_here")))
            }
            Refused::KeyReused { existing } => Self::new(409, "title_key_reused", detail).with_existing(existing),
            Refused::GyroElsewhere { existing, index, .. } => {
                let (pointer, place) = (format!("/gyros/{index}/serial"), detail.clone());
                Self::new(409, "title_gyro_elsewhere", detail).with_existing(existing).with_place(pointer, place)
            }
            Refused::UnknownRecord { .. } => Self::new(404, "title_no_such_record", detail),
            Refused::UnknownBench { .. } => Self::new(404, "title_no_such_bench_result", detail),
            Refused::AlreadyCorrected { existing, .. } => {
                Self::new(409, "title_already_corrected", detail).with_existing(existing)
            }
            Refused::NotSetAside { .. } => Self::new(409, "title_not_set_aside", detail),
            Refused::AnotherImu => Self::new(422, "title_cannot_be_stored", detail).at("/imu"),
            Refused::TimeTaken { existing, kind } => {
                let member = if kind == Kind::Record { "calibrated_at" } else { "measured_at" };
                Self::new(409, "title_time_taken", detail).with_existing(existing).at(format!("/{member}"))
            }
            Refused::UnknownGyro { serial } => Self::unknown_gyro(&serial),
            Refused::UnknownStation { name } => Self::no_such_station(&name),
            Refused::OtherStation { .. } => Self::new(403, "title_other_station", detail),
            Refused::Write(error) => error.into(),
        }
    }
}

impl From<AccessError> for Problem {
    fn from(error: AccessError) -> Self {
        let detail = error.message();
        match error {
            AccessError::NoSuchToken(_) => Self::new(404, "title_no_such_token", detail),
            AccessError::SetupOver => Self::new(401, "title_token_not_valid", detail),
            AccessError::NoRandomNumbers => Self::new(503, "title_try_again", detail),
            AccessError::Write(error) => error.into(),
        }
    }
}

impl From<HookError> for Problem {
    fn from(error: HookError) -> Self {
        let detail = error.message();
        match error {
            HookError::NoSuchHook(_) => Self::new(404, "title_no_such_hook", detail),
            HookError::NoSuchDelivery(_) => Self::new(404, "title_no_such_delivery", detail),
            HookError::HookDisabled(_) => Self::new(409, "title_hook_disabled", detail),
            HookError::StillBehind(_) => Self::new(409, "title_not_its_turn", detail),
            HookError::Dropped(_) => Self::new(409, "title_delivery_dropped", detail),
            HookError::TooManyHooks(_) => Self::new(409, "title_too_many_hooks", detail),
            HookError::SecretNeeded => Self::new(422, "title_cannot_be_stored", detail).at("/secret"),
            HookError::OtherKind => Self::new(422, "title_cannot_be_stored", detail).at("/url"),
            HookError::Write(error) => error.into(),
        }
    }
}

impl From<DiagnosisError> for Problem {
    fn from(error: DiagnosisError) -> Self {
        let detail = error.message();
        match error {
            DiagnosisError::NoSuchDiagnoses(_) => Self::new(404, "title_no_such_diagnoses", detail),
            DiagnosisError::DiagnosesEnded(_) => Self::new(409, "title_diagnoses_ended", detail),
            DiagnosisError::OtherGyros(_) => Self::new(422, "title_cannot_be_stored", detail).at("/identified"),
            DiagnosisError::UnknownImu(_) => Self::new(404, "title_unknown_imu", detail),
            DiagnosisError::NoSuchHypothesis(_) => Self::new(404, "title_no_such_hypothesis", detail),
            DiagnosisError::HypothesisTaken(_) => Self::new(409, "title_hypothesis_taken", detail),
            DiagnosisError::TooManyHypotheses(_) => Self::new(409, "title_too_many_hypotheses", detail),
            DiagnosisError::Write(error) => error.into(),
        }
    }
}

impl From<AlertError> for Problem {
    fn from(error: AlertError) -> Self {
        let detail = error.message();
        match error {
            AlertError::UnknownAlert(_) => Self::new(404, "title_unknown_alert", detail),
            AlertError::UnknownSilence(_) => Self::new(404, "title_unknown_silence", detail),
            AlertError::TooManySilences(_) => Self::new(409, "title_too_many_silences", detail),
            AlertError::AlertResolved(_) => Self::new(409, "title_alert_resolved", detail),
            AlertError::Write(error) => error.into(),
        }
    }
}

impl From<WriteError> for Problem {
    fn from(error: WriteError) -> Self {
        match error {
            WriteError::Busy | WriteError::Stopping => Self::new(503, "title_try_again", error.message()),
            WriteError::Storage(error) => of_storage(&error),
        }
    }
}

/// A failure to read: logged here, once.
impl From<StorageError> for Problem {
    fn from(error: StorageError) -> Self {
        tracing::error!(%error, "a query failed");
        of_storage(&error)
    }
}

fn of_storage(error: &StorageError) -> Problem {
    let (status, title) = match error.fault() {
        StorageFault::Full => (507, "title_no_room"),
        StorageFault::Unwritable => (503, "title_cannot_store"),
        StorageFault::Unanswered => (503, "title_perhaps_stored"),
        StorageFault::Damaged => (500, "title_damaged_database"),
        StorageFault::Internal => (500, "title_internal_error"),
    };
    Problem::new(status, title, error.message())
}
