//! What has become of a submission, or why it is not taken.

use crate::core::message::{Message, list, text};
use crate::core::note::Note;
use crate::pipeline::error::unwritten;
use crate::pipeline::prelude::*;
use crate::wire::differences::Differences;

/// The answer to one submission.
pub type Reply = Result<Accepted, Refused>;

/// What has become of a submission.
#[derive(Debug, Clone, PartialEq)]
pub enum Accepted {
    /// It is new, and on disk once [`Ingest::submit`](super::Ingest::submit) has returned it.
    Stored { id: Id, judged: Arc<[Judged]>, notes: Arc<[Note]> },
    /// An item with the same key has been there before; whether it says the same is for
    /// [`Ingest::settle`](super::Ingest::settle) to find out.
    /// `counts`: it was not voided or set aside, and no other stands in its place, as far as was looked.
    There { id: Id, same_bytes: bool, counts: bool },
}

impl Accepted {
    /// It was there before, says the same and counts.
    pub fn there(id: Id) -> Self {
        Self::There { id, same_bytes: true, counts: true }
    }

    /// What is to be said of it, where it is new.
    pub fn notes(&self) -> &[Note] {
        match self {
            Self::Stored { notes, .. } => notes,
            Self::There { .. } => &[],
        }
    }

    /// It is new, and there is nothing to be said of it.
    pub fn stored(id: Id) -> Self {
        Self::Stored { id, judged: [].into(), notes: [].into() }
    }
}

/// A gyro's verdicts on the record that was submitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    pub serial: Arc<str>,
    pub verdicts: Vec<Verdict>,
}

#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.message())]
pub enum Refused {
    /// It is there with other content.
    Differs { existing: Id, differences: Differences },
    /// The idempotency key was another item's.
    KeyReused { existing: Id },
    /// Another record holds this gyro at that instant; its place among the gyros that were sent.
    GyroElsewhere { existing: Id, index: usize, serial: String },
    /// There is no such record.
    UnknownRecord { id: Id },
    /// There is no such bench result.
    UnknownBench { id: Id },
    /// Something else was said of it before.
    AlreadyCorrected { id: Id, existing: Id },
    /// There is nothing to confirm.
    NotSetAside { id: Id },
    /// What is to stand in a record's place is of another IMU.
    AnotherImu,
    /// Another record counts at that time.
    TimeTaken { existing: Id, kind: Kind },
    /// There is no such gyro.
    UnknownGyro { serial: String },
    /// There is no such station.
    UnknownStation { name: String },
    /// The sender may send for another station alone.
    OtherStation { station: String },
    /// It could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl Refused {
    pub fn message(&self) -> Message {
        match self {
            Self::Differs { existing, differences } => differs(*existing, differences),
            Self::KeyReused { existing } => message!("key_reused", id = text(existing)),
            Self::GyroElsewhere { existing, serial, .. } => {
                message!("gyro_elsewhere", serial = serial.clone(), id = text(existing))
            }
            Self::UnknownRecord { id } => message!("no_such_record", id = text(id)),
            Self::UnknownBench { id } => message!("no_such_bench_result", id = text(id)),
            Self::AlreadyCorrected { id, .. } => message!("corrected_otherwise", id = text(id)),
            Self::NotSetAside { id } => message!("not_set_aside", id = text(id)),
            Self::AnotherImu => message!("another_imu"),
            Self::TimeTaken { existing, .. } => message!("time_taken", id = text(existing)),
            Self::UnknownGyro { serial } => message!("unknown_gyro", serial = serial.clone()),
            Self::UnknownStation { name } => message!("no_such_station", name = name.clone()),
            Self::OtherStation { station } => message!("other_station", station = station.clone()),
            Self::Write(error) => error.message(),
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

unwritten!(Refused);
