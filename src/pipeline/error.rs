//! Why something is not done: the database may fail, the writer may be busy or gone, what is asked for may make no sense;
//! and as which status each of it leaves.

use crate::core::id::Id;
use crate::core::message::{Message, list, text};
use crate::message;
use crate::store::StoreError;
use crate::wire::differences::Differences;
use crate::wire::problem::Problem;
use crate::words;

/// What a client is told. The log has the rest.
fn of_store(error: &StoreError) -> Problem {
    let (status, title, message) = match error {
        StoreError::Full => (507, "title_no_room", message!("disk_full")),
        StoreError::NotDurable(_) => (503, "title_cannot_store", message!("disk_failed")),
        StoreError::ReadOnly(_) | StoreError::Busy | StoreError::Unreachable(_) | StoreError::Overtaken(_) => {
            (503, "title_cannot_store", message!("cannot_write"))
        }
        StoreError::Unanswered(_) => (503, "title_perhaps_stored", message!("perhaps_stored")),
        StoreError::Damaged(what) => (500, "title_damaged_database", message!("database_damaged", what = what.clone())),
        StoreError::NoDatabase(_) => (500, "title_damaged_database", message!("service_failed")),
        StoreError::Refused(_)
        | StoreError::InUse(_)
        | StoreError::File(_)
        | StoreError::Key(_)
        | StoreError::Other(_) => (500, "title_internal_error", message!("service_failed")),
    };
    Problem::new(status, title, message)
}

/// Computes on a thread for that; where that panics, what it reads is damaged: `what` says so.
pub(super) async fn computed<T: Send + 'static>(
    what: String,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, StoreError> {
    words::spawn_blocking(work).await.map_err(|error| StoreError::damaged(format_args!("{what}: {error}")))
}

/// A failure to read: logged here, once.
impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        tracing::error!(%error, "a query failed");
        of_store(&error)
    }
}

/// Why what was submitted or ordered is not taken. Nothing has changed then; after
/// [`StoreError::Unanswered`] that is not known.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.message())]
pub enum Refused {
    /// It makes no sense, or something stands in its way.
    Problem(Box<Problem>),
    /// It is there with other content.
    Differs { existing: Id, differences: Differences },
    /// Another record holds this gyro at that instant; its place among the gyros that were sent.
    GyroElsewhere { existing: Id, index: usize, serial: String },
    /// The writer has too much to do.
    Busy,
    /// The writer is gone.
    Stopping,
    /// It could not be read or written.
    #[error(transparent)]
    Storage(#[from] StoreError),
}

impl Refused {
    /// Something stored stands in its way.
    pub(super) fn conflict(title: &'static str, message: Message) -> Self {
        Problem::new(409, title, message).into()
    }

    /// What it says at this place cannot be stored.
    pub(super) fn not_storable(pointer: &str, message: Message) -> Self {
        Problem::new(422, "title_cannot_be_stored", message).at(pointer).into()
    }

    pub fn message(&self) -> Message {
        self.problem().message
    }

    fn problem(&self) -> Problem {
        match self {
            Self::Problem(problem) => Problem::clone(problem),
            Self::Differs { existing, differences } => {
                let problem = Problem::new(409, "title_differs", differs(*existing, differences));
                let places = differences.pointers.iter();
                let place = |problem: Problem, pointer| problem.with_place(pointer, message!("differs_here"));
                places.fold(problem.with_existing(existing), place)
            }
            Self::GyroElsewhere { existing, index, serial } => {
                let message = message!("gyro_elsewhere", serial = serial.clone(), id = text(existing));
                let problem = Problem::new(409, "title_gyro_elsewhere", message).with_existing(existing);
                problem.at(format!("/gyros/{index}/serial"))
            }
            Self::Busy => Problem::new(503, "title_try_again", message!("busy")),
            Self::Stopping => Problem::new(503, "title_try_again", message!("stopping")),
            Self::Storage(error) => of_store(error),
        }
    }
}

fn differs(existing: Id, differences: &Differences) -> Message {
    let (id, further) = (text(existing), differences.further);
    let places = list(differences.places());
    match differences.pointers.iter().any(String::is_empty) {
        true => message!("differs_in_everything", id = id),
        false if further > 0 => message!("differs_further", id = id, places = places, further = further),
        false => message!("differs", id = id, places = places),
    }
}

impl From<Problem> for Refused {
    fn from(problem: Problem) -> Self {
        Self::Problem(Box::new(problem))
    }
}

impl From<Refused> for Problem {
    fn from(refused: Refused) -> Self {
        refused.problem()
    }
}
