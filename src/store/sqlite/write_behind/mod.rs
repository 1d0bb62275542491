//! All that is durable but not in its place yet, as readers and the writer of a file share it. Of a server's database
//! nothing is.

pub(crate) mod history_log;
pub(crate) mod queues;
pub(crate) mod record_index;

use sqlx::SqliteConnection;

use crate::store::error::Result;
use crate::store::shared::Shared;
use crate::store::sqlite::write_behind::history_log::PendingHistory;
use crate::store::sqlite::write_behind::record_index::PendingIndex;

#[derive(Debug, Clone, Default)]
pub(crate) struct WriteBehind {
    pub history: Shared<PendingHistory>,
    pub index: Shared<PendingIndex>,
}

impl WriteBehind {
    /// Reads what was left.
    pub async fn load(connection: &mut SqliteConnection) -> Result<Self> {
        let history = Shared::new(PendingHistory::load(&mut *connection).await?);
        let index = Shared::new(PendingIndex::load(connection).await?);
        Ok(Self { history, index })
    }
}

#[cfg(test)]
pub(crate) mod history_log_tests;
#[cfg(test)]
pub(crate) mod record_index_tests;
