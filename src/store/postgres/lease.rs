//! Work in the background that one server does for all the others.
//!
//! Whoever holds a lease renews it long before it ends; whoever dies loses it when it ends, and another takes the
//! work over. The database's clock decides who may take a lease; whether its holder still may work, it tells by its
//! own, counted from before it asked.

use std::time::{Duration, Instant};

use tokio::sync::watch;

use crate::core::named::named;
use crate::store::db::PgReaders;
use crate::store::error::Result;

named! {
    /// What one server does for all.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum LeasedTask {
        /// Telling hooks what the outbox holds.
        Deliveries = "deliveries",
        /// Letting alerts follow the clock.
        Clock = "clock",
    }
}

/// Until when this server holds each lease.
pub(crate) type HeldLeases = [Option<Instant>; LeasedTask::ALL.len()];

pub(super) fn is_held(held: &HeldLeases, duty: LeasedTask) -> bool {
    held[duty as usize].is_some_and(|until| Instant::now() < until)
}

/// Renews what is held and takes what is free, until nobody wants to know any more.
pub(super) async fn keep(readers: PgReaders, number: i64, lease: Duration, held: watch::Sender<HeldLeases>) {
    let pause = lease / 5;
    while !held.is_closed() && !readers.is_closed() {
        for (place, duty) in LeasedTask::ALL.into_iter().enumerate() {
            let asked = Instant::now();
            match take(&readers, duty, number, lease).await {
                Ok(mine) => publish(&held, place, mine.then(|| asked + lease - pause)),
                Err(error) => {
                    tracing::debug!(%error, duty = duty.name(), "a lease could not be renewed");
                    let until = held.borrow()[place];
                    publish(&held, place, until.filter(|until| Instant::now() < *until));
                }
            }
        }
        tokio::select! {
            () = tokio::time::sleep(pause) => {}
            () = held.closed() => {}
        }
    }
}

/// At the end of a server: its leases, and the diagnoses that it has claimed.
pub(super) async fn give_back(readers: &PgReaders, number: i64) -> Result<()> {
    let release = "UPDATE lease SET until = now() WHERE holder = $1";
    sqlx::query(release).bind(number).execute(readers).await?;
    sqlx::query("DELETE FROM diagnosis_claim WHERE holder = $1").bind(number).execute(readers).await?;
    Ok(())
}

/// Wakes those who wait when a lease begins or ends, not each time it goes on.
fn publish(held: &watch::Sender<HeldLeases>, place: usize, until: Option<Instant>) {
    held.send_if_modified(|held| {
        let turned = held[place].is_some() != until.is_some();
        held[place] = until;
        turned
    });
}

async fn take(readers: &PgReaders, duty: LeasedTask, number: i64, lease: Duration) -> Result<bool> {
    let sql = "UPDATE lease SET holder = $2, until = now() + $3 * INTERVAL '1 second'
               WHERE name = $1 AND (holder = $2 OR until < now())";
    let query = sqlx::query(sql).bind(duty.name()).bind(number).bind(lease.as_secs_f64());
    Ok(query.execute(readers).await?.rows_affected() == 1)
}
