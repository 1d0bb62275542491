//! Which failure of the pipeline or the store leaves as which status, said once.

use crate::pipeline::{Kind, Refused, StoreError};
use crate::wire::problem::{Place, Problem};

impl From<Refused> for Problem {
    fn from(refused: Refused) -> Self {
        let detail = refused.to_string();
        match refused {
            Refused::Differs { existing, differences } => {
                let place = |pointer| Place { pointer, detail: "differs from what is stored".into() };
                let problem = Self::new(409, "Already stored with other content", detail).with_existing(existing);
                differences.pointers.into_iter().map(place).fold(problem, Self::with_place)
            }
            Refused::KeyReused { existing } => {
                Self::new(409, "Idempotency-Key used for other content", detail).with_existing(existing)
            }
            Refused::GyroElsewhere { existing, index, .. } => {
                let place = Place { pointer: format!("/gyros/{index}/serial"), detail: detail.clone() };
                Self::new(409, "Gyro calibrated elsewhere at the same time", detail)
                    .with_existing(existing)
                    .with_place(place)
            }
            Refused::UnknownRecord { .. } => Self::new(404, "No such record", detail),
            Refused::UnknownBench { .. } => Self::new(404, "No such bench result", detail),
            Refused::AlreadyCorrected { existing, .. } => {
                Self::new(409, "Already voided or revised", detail).with_existing(existing)
            }
            Refused::NotSetAside { .. } => Self::new(409, "Not set aside", detail),
            Refused::AnotherImu => {
                let place = Place { pointer: "/imu".into(), detail: detail.clone() };
                Self::new(422, "Cannot be stored as it is", detail).with_place(place)
            }
            Refused::TimeTaken { existing, kind } => {
                let member = if kind == Kind::Record { "calibrated_at" } else { "measured_at" };
                let place = Place { pointer: format!("/{member}"), detail: detail.clone() };
                Self::new(409, "Another stands at that time", detail).with_existing(existing).with_place(place)
            }
            Refused::UnknownGyro { serial } => Self::unknown_gyro(&serial),
            Refused::UnknownImu { .. } => Self::new(404, "Unknown IMU", detail),
            Refused::NoSuchHook { .. } => Self::new(404, "No such hook", detail),
            Refused::NoSuchToken { .. } => Self::new(404, "No such token", detail),
            Refused::OtherStation { .. } => Self::new(403, "Another station's", detail),
            Refused::SetupOver => Self::new(401, "Token not valid", detail),
            Refused::NoRandomNumbers => Self::new(503, "Try again", detail),
            Refused::NoSuchDelivery { .. } => Self::new(404, "No such delivery", detail),
            Refused::HookDisabled { .. } => Self::new(409, "Hook disabled", detail),
            Refused::StillBehind { .. } => Self::new(409, "Not its turn", detail),
            Refused::TooManyHooks { .. } => Self::new(409, "Too many hooks", detail),
            Refused::SecretNeeded => {
                let place = Place { pointer: "/secret".into(), detail: detail.clone() };
                Self::new(422, "Cannot be stored as it is", detail).with_place(place)
            }
            Refused::NoSuchDiagnoses { .. } => Self::new(404, "No such diagnoses", detail),
            Refused::DiagnosesEnded { .. } => Self::new(409, "Diagnoses have ended", detail),
            Refused::UnknownAlert { .. } => Self::new(404, "Unknown alert", detail),
            Refused::UnknownSilence { .. } => Self::new(404, "Unknown silence", detail),
            Refused::TooManySilences { .. } => Self::new(409, "Too many silences", detail),
            Refused::AlertResolved { .. } => Self::new(409, "Alert is resolved", detail),
            Refused::Busy | Refused::Stopping => Self::new(503, "Try again", detail),
            Refused::Store(error) => Self::from(&*error),
        }
    }
}

impl From<&StoreError> for Problem {
    fn from(error: &StoreError) -> Self {
        match error {
            StoreError::Full => Self::new(507, "No room left", "the service's disk is full; nothing was stored"),
            StoreError::ReadOnly(_) | StoreError::Busy | StoreError::Unreachable(_) => {
                Self::new(503, "Cannot store", "the service's database cannot be written now; nothing was stored")
            }
            StoreError::Unanswered(_) => Self::new(
                503,
                "Perhaps stored",
                "the service's database broke off while this was stored, and cannot be asked whether it is: measurements can be sent again; of hooks, tokens and other orders look first",
            ),
            StoreError::NotDurable(_) => Self::new(
                503,
                "Cannot store",
                "the service's disk failed; nothing is accepted until it is looked after",
            ),
            StoreError::Damaged(what) => Self::new(500, "Damaged database", format!("the database is damaged: {what}")),
            StoreError::Refused(_)
            | StoreError::InUse(_)
            | StoreError::File(_)
            | StoreError::Key(_)
            | StoreError::Other(_) => Self::new(500, "Internal error", "the service failed; its log says why"),
        }
    }
}

/// A failure to read: logged here, once.
impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        tracing::error!(%error, "a query failed");
        Self::from(&error)
    }
}
