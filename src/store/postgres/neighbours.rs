//! What the other servers on the database are up to.

use std::time::Duration;

use sqlx::PgPool;
use tokio::sync::watch;

use super::lease::{self, Duty, Held};
use super::turn::{LOOK, Missed, Standing};
use super::{claim, names};
use crate::store::error::StoreError;
use crate::store::names::Names;
use crate::store::open::{Place, Store};

/// How soon what others have written is known here.
const LOOK_EVERY: Duration = Duration::from_millis(250);

/// The other servers, watched as long as a clone is alive.
#[derive(Debug, Clone)]
pub(in crate::store) struct Neighbours {
    standing: watch::Receiver<Standing>,
    held: watch::Receiver<Held>,
    /// This server among them, and how long what it takes is its own; none where it takes nothing.
    lease: Option<(i64, Duration)>,
}

impl Neighbours {
    /// Nobody is watched, and nothing is this server's duty.
    pub fn none() -> Self {
        Self { standing: watch::channel(Standing::default()).1, held: watch::channel(Held::default()).1, lease: None }
    }

    pub async fn watch(readers: PgPool, names: Names, number: i64, lease: Duration) -> Result<Self, StoreError> {
        let row = sqlx::query(LOOK).fetch_one(&readers).await?;
        let (told, standing) = watch::channel(Standing::of(&row)?);
        let (keeper, held) = watch::channel(Held::default());
        tokio::spawn(look_around(readers.clone(), names, told));
        tokio::spawn(lease::keep(readers, number, lease, keeper));
        Ok(Self { standing, held, lease: Some((number, lease)) })
    }

    pub fn lease(&self) -> Option<(i64, Duration)> {
        self.lease
    }

    /// Gives up every duty, for others to take over at once.
    pub async fn part(&self, readers: &PgPool) {
        let Some((number, _)) = self.lease else { return };
        let leases = lease::give_back(readers, number).await;
        if let Err(error) = leases.and(claim::release_all(readers, number).await) {
            tracing::debug!(%error, "leases and claims could not be given back; they end by themselves");
        }
    }
}

async fn look_around(readers: PgPool, names: Names, told: watch::Sender<Standing>) {
    while !told.is_closed() && !readers.is_closed() {
        if let Err(error) = look(&readers, &names, &told).await {
            tracing::debug!(%error, "what other servers have written cannot be read");
        }
        tokio::select! {
            () = tokio::time::sleep(LOOK_EVERY) => {}
            () = told.closed() => {}
        }
    }
}

async fn look(readers: &PgPool, names: &Names, told: &watch::Sender<Standing>) -> Result<(), StoreError> {
    let found = Standing::of(&sqlx::query(LOOK).fetch_one(readers).await?)?;
    if told.borrow().version != found.version {
        names::learn_new(readers, names).await?;
        told.send_replace(found);
    }
    Ok(())
}

/// What is written, by whomever, and whose duty is whose, as it changes.
#[derive(Debug)]
pub struct Moves {
    neighbours: Neighbours,
    seen: Standing,
}

impl Moves {
    /// Waits until something was written or a duty began or ended; says what is new. None where nobody watches any more.
    pub async fn next(&mut self) -> Option<Missed> {
        tokio::select! {
            changed = self.neighbours.standing.changed() => changed.ok()?,
            changed = self.neighbours.held.changed() => {
                changed.ok()?;
                return Some(Missed { outbox: true, ..Missed::default() });
            }
        }
        let found = *self.neighbours.standing.borrow_and_update();
        let missed = Missed::between(&self.seen, &found);
        self.seen = found;
        Some(missed)
    }
}

impl Store {
    /// Whether something that one server does for all is this one's to do now. Alone on a file, everything is.
    pub fn is_on_duty(&self, duty: Duty) -> bool {
        match &self.place {
            Place::File(_) => true,
            Place::Server(neighbours) => lease::is_held(&neighbours.held.borrow(), duty),
        }
    }

    /// What is written by any server from now on; none where there can be no other.
    pub fn moves(&self) -> Option<Moves> {
        match &self.place {
            Place::File(_) => None,
            Place::Server(neighbours) => {
                let neighbours = neighbours.clone();
                let seen = *neighbours.standing.borrow();
                Some(Moves { neighbours, seen })
            }
        }
    }
}
