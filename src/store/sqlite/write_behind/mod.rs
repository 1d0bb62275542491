//! All that is durable but not in its place yet, as readers and the writer of a file share it. Of a server's database
//! nothing is.

pub(crate) mod history_log;
pub(crate) mod queues;
pub(crate) mod record_index;

use sqlx::SqliteConnection;

use crate::store::error::StoreError;
use crate::store::sqlite::write_behind::history_log::Tail;
use crate::store::sqlite::write_behind::queues::Shared;
use crate::store::sqlite::write_behind::record_index::Calendar;

#[derive(Debug, Clone, Default)]
pub(crate) struct Unplaced {
    pub tail: Shared<Tail>,
    pub calendar: Shared<Calendar>,
}

impl Unplaced {
    /// Reads what was left.
    pub async fn load(connection: &mut SqliteConnection) -> Result<Self, StoreError> {
        let tail = Shared::new(Tail::load(&mut *connection).await?);
        let calendar = Shared::new(Calendar::load(connection).await?);
        Ok(Self { tail, calendar })
    }
}

#[cfg(test)]
pub(crate) mod history_log_tests;
#[cfg(test)]
pub(crate) mod record_index_tests;
