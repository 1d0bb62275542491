//! What the other servers on the database are up to.

use std::time::Duration;

use tokio::sync::watch;

use super::bounded::PgReaders;
use super::cell_rows::AllCells;
use super::hosts::Hosts;
use super::lease::{self, Held};
use super::names;
use crate::store::name_tables::Names;
use crate::store::{Duty, Missed, News, Result};

/// How soon what others have written is known here.
const LOOK_EVERY: Duration = Duration::from_millis(250);

/// The other servers, watched as long as a clone is alive.
#[derive(Debug, Clone)]
pub(crate) struct Neighbours {
    seen: watch::Receiver<AllCells>,
    held: watch::Receiver<Held>,
    /// This server among them, and how long what it takes is its own; none where it takes nothing.
    lease: Option<(i64, Duration)>,
}

impl Neighbours {
    /// Nobody is watched, and nothing is this server's duty.
    pub fn none() -> Self {
        Self { seen: watch::channel(AllCells::default()).1, held: watch::channel(Held::default()).1, lease: None }
    }

    pub fn watch(readers: PgReaders, hosts: Hosts, names: Names, number: i64, lease: Duration) -> Self {
        // Whatever there is, is news to the first look.
        let (told, seen) = watch::channel(AllCells::default());
        let (keeper, held) = watch::channel(Held::default());
        tokio::spawn(look_around(readers.clone(), hosts, names, told));
        tokio::spawn(lease::keep(readers, number, lease, keeper));
        Self { seen, held, lease: Some((number, lease)) }
    }

    pub fn lease(&self) -> Option<(i64, Duration)> {
        self.lease
    }

    pub fn is_on_duty(&self, duty: Duty) -> bool {
        lease::is_held(&self.held.borrow(), duty)
    }

    /// What is written by any server from now on.
    pub fn moves(&self) -> Moves {
        Moves { neighbours: self.clone(), seen: *self.seen.borrow() }
    }

    /// Gives up every duty, for others to take over at once.
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

/// What is written, by whomever, and whose duty is whose, as it changes.
#[derive(Debug)]
pub struct Moves {
    neighbours: Neighbours,
    seen: AllCells,
}

impl Moves {
    /// Waits until something was written or a duty began or ended; says what is new. None where nobody watches any
    /// more.
    pub async fn next(&mut self) -> Option<Missed> {
        tokio::select! {
            changed = self.neighbours.seen.changed() => changed.ok()?,
            changed = self.neighbours.held.changed() => {
                changed.ok()?;
                return Some(Missed { news: vec![News::Outbox], ..Missed::default() });
            }
        }
        let found = *self.neighbours.seen.borrow_and_update();
        Some(self.seen.learn(&found.0))
    }
}
