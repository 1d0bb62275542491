//! Which server makes which diagnosis: each claims a few campaigns at a time, so that all take part and no two do the
//! same.

use std::pin::pin;
use std::time::Duration;

use crate::core::id::Id;
use crate::store::db::{PgReaders, Readers};
use crate::store::{Result, Store};

/// A claim is renewed this often in the time for which it holds.
const RENEWALS: u32 = 3;

/// The first of `wanted`, at most `most`, that no other server is at; for the time of a lease they are this one's.
/// Alone on a file, everything is.
pub async fn claim(store: &Store, wanted: &[Id], most: usize) -> Result<Vec<Id>> {
    match (&store.readers, claimant(store)) {
        (Readers::Sqlite(..), _) => Ok(wanted.iter().copied().take(most).collect()),
        (Readers::Postgres(..), Some(claimant)) => Ok(claimant.take(wanted, most).await?),
        (Readers::Postgres(..), None) => Ok(Vec::new()),
    }
}

/// Does `work` on what was claimed, which stays this server's as long as it takes, and is anybody's afterwards.
pub async fn while_claimed<T>(store: &Store, claimed: &[Id], work: impl Future<Output = T>) -> T {
    let Some(claimant) = claimant(store) else { return work.await };
    let mut work = pin!(work);
    let done = loop {
        match tokio::time::timeout(claimant.lease / RENEWALS, &mut work).await {
            Ok(done) => break done,
            Err(_) => log_error(claimant.renew(claimed).await),
        }
    };
    log_error(claimant.release(claimed).await);
    done
}

fn claimant(store: &Store) -> Option<ClaimHolder<'_>> {
    let Readers::Postgres(readers, other_servers) = &store.readers else { return None };
    other_servers.lease().map(|(number, lease)| ClaimHolder { readers, number, lease })
}

fn log_error(done: Result<(), sqlx::Error>) {
    if let Err(error) = done {
        tracing::debug!(%error, "claims could not be renewed or given back; they end by themselves");
    }
}

/// A server among those that share the database.
struct ClaimHolder<'a> {
    readers: &'a PgReaders,
    number: i64,
    lease: Duration,
}

impl ClaimHolder<'_> {
    async fn take(&self, wanted: &[Id], most: usize) -> Result<Vec<Id>, sqlx::Error> {
        sqlx::query("DELETE FROM diagnosis_claim WHERE until < now()").execute(self.readers).await?;
        // Of two servers that want the same at once the second finds it taken, and comes back for others.
        let sql = "INSERT INTO diagnosis_claim (record, holder, until)
                   SELECT record.id, $2, now() + $3 * INTERVAL '1 second' FROM record
                   WHERE record.id = ANY($1)
                       AND NOT EXISTS (SELECT 1 FROM diagnosis_claim AS taken WHERE taken.record = record.id)
                   ORDER BY array_position($1, record.id) LIMIT $4
                   ON CONFLICT (record) DO NOTHING RETURNING record";
        let query = sqlx::query_scalar(sql).bind(numbers(wanted)).bind(self.number).bind(self.lease.as_secs_f64());
        let taken: Vec<i64> = query.bind(most as i64).fetch_all(self.readers).await?;
        Ok(wanted.iter().copied().filter(|id| taken.contains(&id.0)).collect())
    }

    async fn renew(&self, claimed: &[Id]) -> Result<(), sqlx::Error> {
        let sql = "UPDATE diagnosis_claim SET until = now() + $3 * INTERVAL '1 second'
                   WHERE holder = $1 AND record = ANY($2)";
        let query = sqlx::query(sql).bind(self.number).bind(numbers(claimed)).bind(self.lease.as_secs_f64());
        query.execute(self.readers).await?;
        Ok(())
    }

    async fn release(&self, claimed: &[Id]) -> Result<(), sqlx::Error> {
        let sql = "DELETE FROM diagnosis_claim WHERE holder = $1 AND record = ANY($2)";
        sqlx::query(sql).bind(self.number).bind(numbers(claimed)).execute(self.readers).await?;
        Ok(())
    }
}

fn numbers(ids: &[Id]) -> Vec<i64> {
    ids.iter().map(|id| id.0).collect()
}
