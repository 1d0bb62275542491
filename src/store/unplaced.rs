//! All that is durable but not in its place yet, as readers and the writer of a file share it. Of a server's database nothing is.

use sqlx::SqliteConnection;

use super::calendar::Calendar;
use super::error::StoreError;
use super::tail::Tail;
use super::waiting::Shared;

#[derive(Debug, Clone, Default)]
pub(super) struct Unplaced {
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
