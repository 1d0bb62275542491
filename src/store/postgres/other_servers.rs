//! What the other servers on the database are up to.

use std::time::Duration;

use tokio::sync::watch;

use super::bounded::PgReaders;
use super::cell_rows::AllCells;
use super::hosts::Hosts;
use super::lease::{self, HeldLeases};
use super::names;
use crate::store::name_tables::Names;
use crate::store::{ChangeTopic, LeasedTask, RemoteChanges, Result};

/// How soon what others have written is known here.
const LOOK_EVERY: Duration = Duration::from_millis(250);

/// The other servers, watched as long as a clone is alive.
#[derive(Debug, Clone)]
pub(crate) struct OtherServers {
    seen: watch::Receiver<AllCells>,
    held: watch::Receiver<HeldLeases>,
    /// This server among them, and how long what it takes is its own; none where it takes nothing.
    lease: Option<(i64, Duration)>,
}

impl OtherServers {
    /// Nobody is watched, and this server holds no lease.
    pub fn none() -> Self {
        Self { seen: watch::channel(AllCells::default()).1, held: watch::channel(HeldLeases::default()).1, lease: None }
    }

    pub fn watch(readers: PgReaders, hosts: Hosts, names: Names, number: i64, lease: Duration) -> Self {
        // Whatever there is, is news to the first look.
        let (told, seen) = watch::channel(AllCells::default());
        let (keeper, held) = watch::channel(HeldLeases::default());
        tokio::spawn(look_around(readers.clone(), hosts, names, told));
        tokio::spawn(lease::keep(readers, number, lease, keeper));
        Self { seen, held, lease: Some((number, lease)) }
    }

    pub fn lease(&self) -> Option<(i64, Duration)> {
        self.lease
    }

    pub fn holds_lease(&self, duty: LeasedTask) -> bool {
        lease::is_held(&self.held.borrow(), duty)
    }

    /// What is written by any server from now on.
    pub fn change_feed(&self) -> ChangeFeed {
        ChangeFeed { other_servers: self.clone(), seen: *self.seen.borrow() }
    }

    /// Gives up every lease, for others to take over at once.
    pub async fn part(&self, readers: &PgReaders) {
        let Some((number, _)) = self.lease else { return };
        if let Err(error) = lease::give_back(readers, number).await {
            tracing::debug!(%error, "leases and claims could not be given back; they end by themselves");
        }
    }
}

async fn look_around(readers: PgReaders, hosts: Hosts, names: Names, told: watch::Sender<AllCells>) {
    while !told.is_closed() && !readers.is_closed() {
        if let Err(error) = look(&readers, &names, &told).await {
            tracing::debug!(%error, "what other servers have written cannot be read");
            // The writer may have found another host already, or nobody writes.
            if hosts.are_several() && hosts.reach(LOOK_EVERY * 8).await.is_ok() {
                readers.turn_to(hosts.last().clone());
            }
        }
        tokio::select! {
            () = tokio::time::sleep(LOOK_EVERY) => {}
            () = told.closed() => {}
        }
    }
}

async fn look(readers: &PgReaders, names: &Names, told: &watch::Sender<AllCells>) -> Result<()> {
    let found = AllCells::look(readers).await?;
    if *told.borrow() != found {
        names::learn_cells(readers, names, &found.0).await?;
        told.send_replace(found);
    }
    Ok(())
}

/// What is written, by whomever, and who holds which lease, as it changes.
#[derive(Debug)]
pub struct ChangeFeed {
    other_servers: OtherServers,
    seen: AllCells,
}

impl ChangeFeed {
    /// Waits until something was written or a lease began or ended; says what is new. None where nobody watches any
    /// more.
    pub async fn next(&mut self) -> Option<RemoteChanges> {
        tokio::select! {
            changed = self.other_servers.seen.changed() => changed.ok()?,
            changed = self.other_servers.held.changed() => {
                changed.ok()?;
                return Some(RemoteChanges { topics: vec![ChangeTopic::Outbox], ..RemoteChanges::default() });
            }
        }
        let found = *self.other_servers.seen.borrow_and_update();
        Some(self.seen.learn(&found.0))
    }
}
