//! A window of time in which what a station measured is suspect: its records are set aside, and trusted again.

use crate::core::alert_decision::Late;
use crate::core::id::Id;
use crate::core::time::Span;
use crate::pipeline::error::WriteError;
use crate::pipeline::{Accepted, Actor, Confirmation, Doubt, ListFilter, Pipeline, Refused, Submission};
use crate::wire::note;

/// Records that are asked for, and submitted, at a time.
const PAGE: u32 = 500;

/// What somebody says of a station's records in a window.
#[derive(Debug, Clone)]
pub struct SuspectWindow {
    pub station: String,
    pub span: Span,
    pub author: String,
    pub reason: String,
}

/// What has come of it.
#[derive(Debug, Default)]
pub struct WindowOutcome {
    pub changed: Vec<Id>,
    /// What stands in the way of the others: corrected meanwhile, or another record stands at the time.
    pub refused: Vec<(Id, Refused)>,
}

impl Pipeline {
    /// Sets aside every record and campaign of the window that counts; what depends on them is judged again.
    ///
    /// # Errors
    /// [`Refused`], where nothing can be read or stored.
    pub async fn suspect(&self, window: &SuspectWindow) -> Result<WindowOutcome, Refused> {
        let counting = self.of_window(window, true).await?;
        let doubt = |id| {
            let (author, reason) = (window.author.clone(), window.reason.clone());
            Submission::Doubt(Doubt { id, author, reason, by: Actor::by_caller() })
        };
        self.submit_window(counting, doubt).await
    }

    /// What [`Pipeline::suspect`] has set aside in the window counts again.
    ///
    /// # Errors
    /// As [`Pipeline::suspect`].
    pub async fn trust(&self, window: &SuspectWindow) -> Result<WindowOutcome, Refused> {
        let mut suspect = Vec::new();
        for id in self.of_window(window, false).await? {
            let is_aside = self.queries.records.status(id).await.map_err(WriteError::from)?.set_aside;
            let Some(record) = self.queries.records.sent(id).await.map_err(WriteError::from)?.filter(|_| is_aside)
            else {
                continue;
            };
            if note::read(record.notes.as_deref()).iter().any(|note| note.code == "suspect") {
                suspect.push(id);
            }
        }
        let confirm = |id| {
            let (author, reason) = (window.author.clone(), window.reason.clone());
            Submission::Confirmation(Confirmation { id, author, reason, by: Actor::by_caller() })
        };
        self.submit_window(suspect, confirm).await
    }

    /// Records and campaigns of the window, those that count or those that do not, oldest first.
    async fn of_window(&self, window: &SuspectWindow, counting: bool) -> Result<Vec<Id>, Refused> {
        let station = Some(window.station.as_str());
        let filter = ListFilter { kind: None, imu: None, station, calibrated: window.span };
        let (mut found, mut before) = (Vec::new(), Id(i64::MAX));
        loop {
            let (page, more) = self.queries.records.listed(&filter, before, PAGE).await.map_err(WriteError::from)?;
            before = page.last().map_or(before, |last| last.id);
            found.extend(page.into_iter().filter(|record| record.counts == counting).map(|r| (r.calibrated_at, r.id)));
            if !more {
                break;
            }
        }
        found.sort_unstable();
        Ok(found.into_iter().map(|(_, id)| id).collect())
    }

    async fn submit_window(&self, of: Vec<Id>, item: impl Fn(Id) -> Submission) -> Result<WindowOutcome, Refused> {
        let mut outcome = WindowOutcome::default();
        for part in of.chunks(PAGE as usize) {
            let replies = self.ingest.enqueue(part.iter().copied().map(&item).collect(), Late::Quiet).await.await;
            for (id, reply) in part.iter().zip(replies) {
                match reply {
                    Ok(Accepted::Stored { .. }) => outcome.changed.push(*id),
                    Ok(Accepted::There { .. }) => {}
                    Err(write @ Refused::Write(_)) => return Err(write),
                    Err(refused) => outcome.refused.push((*id, refused)),
                }
            }
        }
        Ok(outcome)
    }
}
