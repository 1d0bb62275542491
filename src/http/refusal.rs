//! Which failure of which room leaves as which status, said once.

use crate::core::kind::Kind;
use crate::message;
use crate::pipeline::{OrderError, Refused, StorageError, StorageFault, WriteError};
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

impl From<OrderError> for Problem {
    fn from(error: OrderError) -> Self {
        let detail = error.message();
        match error {
            OrderError::NoSuchToken(_) => Self::new(404, "title_no_such_token", detail),
            OrderError::SetupOver => Self::new(401, "title_token_not_valid", detail),
            OrderError::NoRandomNumbers => Self::new(503, "title_try_again", detail),
            OrderError::NoSuchHook(_) => Self::new(404, "title_no_such_hook", detail),
            OrderError::NoSuchDelivery(_) => Self::new(404, "title_no_such_delivery", detail),
            OrderError::HookDisabled(_) => Self::new(409, "title_hook_disabled", detail),
            OrderError::StillBehind(_) => Self::new(409, "title_not_its_turn", detail),
            OrderError::Dropped(_) => Self::new(409, "title_delivery_dropped", detail),
            OrderError::TooManyHooks(_) => Self::new(409, "title_too_many_hooks", detail),
            OrderError::SecretNeeded => Self::new(422, "title_cannot_be_stored", detail).at("/secret"),
            OrderError::OtherKind => Self::new(422, "title_cannot_be_stored", detail).at("/url"),
            OrderError::NoSuchDiagnoses(_) => Self::new(404, "title_no_such_diagnoses", detail),
            OrderError::DiagnosesEnded(_) => Self::new(409, "title_diagnoses_ended", detail),
            OrderError::OtherGyros(_) => Self::new(422, "title_cannot_be_stored", detail).at("/identified"),
            OrderError::UnknownImu(_) => Self::new(404, "title_unknown_imu", detail),
            OrderError::NoSuchHypothesis(_) => Self::new(404, "title_no_such_hypothesis", detail),
            OrderError::HypothesisTaken(_) => Self::new(409, "title_hypothesis_taken", detail),
            OrderError::TooManyHypotheses(_) => Self::new(409, "title_too_many_hypotheses", detail),
            OrderError::UnknownAlert(_) => Self::new(404, "title_unknown_alert", detail),
            OrderError::UnknownSilence(_) => Self::new(404, "title_unknown_silence", detail),
            OrderError::TooManySilences(_) => Self::new(409, "title_too_many_silences", detail),
            OrderError::AlertResolved(_) => Self::new(409, "title_alert_resolved", detail),
            OrderError::Write(error) => error.into(),
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
