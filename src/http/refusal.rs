//! Which failure of the pipeline or the store leaves as which status, said once.

use crate::message;
use crate::pipeline::{Kind, Refused, StoreError, of_store};
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
            Refused::AnotherImu => {
                let (pointer, place) = ("/imu", detail.clone());
                Self::new(422, "title_cannot_be_stored", detail).with_place(pointer, place)
            }
            Refused::TimeTaken { existing, kind } => {
                let member = if kind == Kind::Record { "calibrated_at" } else { "measured_at" };
                let (pointer, place) = (format!("/{member}"), detail.clone());
                Self::new(409, "title_time_taken", detail).with_existing(existing).with_place(pointer, place)
            }
            Refused::UnknownGyro { serial } => Self::unknown_gyro(&serial),
            Refused::UnknownImu { .. } => Self::new(404, "title_unknown_imu", detail),
            Refused::NoSuchHook { .. } => Self::new(404, "title_no_such_hook", detail),
            Refused::NoSuchToken { .. } => Self::new(404, "title_no_such_token", detail),
            Refused::OtherStation { .. } => Self::new(403, "title_other_station", detail),
            Refused::SetupOver => Self::new(401, "title_token_not_valid", detail),
            Refused::NoRandomNumbers => Self::new(503, "title_try_again", detail),
            Refused::NoSuchDelivery { .. } => Self::new(404, "title_no_such_delivery", detail),
            Refused::HookDisabled { .. } => Self::new(409, "title_hook_disabled", detail),
            Refused::StillBehind { .. } => Self::new(409, "title_not_its_turn", detail),
            Refused::TooManyHooks { .. } => Self::new(409, "title_too_many_hooks", detail),
            Refused::SecretNeeded => {
                let (pointer, place) = ("/secret", detail.clone());
                Self::new(422, "title_cannot_be_stored", detail).with_place(pointer, place)
            }
            Refused::NoSuchDiagnoses { .. } => Self::new(404, "title_no_such_diagnoses", detail),
            Refused::DiagnosesEnded { .. } => Self::new(409, "title_diagnoses_ended", detail),
            Refused::UnknownAlert { .. } => Self::new(404, "title_unknown_alert", detail),
            Refused::UnknownSilence { .. } => Self::new(404, "title_unknown_silence", detail),
            Refused::TooManySilences { .. } => Self::new(409, "title_too_many_silences", detail),
            Refused::AlertResolved { .. } => Self::new(409, "title_alert_resolved", detail),
            Refused::Busy | Refused::Stopping => Self::new(503, "title_try_again", detail),
            Refused::Store(error) => Self::from(&*error),
        }
    }
}

impl From<&StoreError> for Problem {
    fn from(error: &StoreError) -> Self {
        let (status, title) = match error {
            StoreError::Full => (507, "title_no_room"),
            StoreError::ReadOnly(_) | StoreError::Busy | StoreError::Unreachable(_) | StoreError::NotDurable(_) => {
                (503, "title_cannot_store")
            }
            StoreError::Unanswered(_) => (503, "title_perhaps_stored"),
            StoreError::Damaged(_) => (500, "title_damaged_database"),
            StoreError::Refused(_)
            | StoreError::InUse(_)
            | StoreError::File(_)
            | StoreError::Key(_)
            | StoreError::Other(_) => (500, "title_internal_error"),
        };
        Self::new(status, title, of_store(error))
    }
}

/// A failure to read: logged here, once.
impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        tracing::error!(%error, "a query failed");
        Self::from(&error)
    }
}
