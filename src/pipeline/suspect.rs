//! A window of time in which what a station measured is suspect: its records are set aside, and trusted again.

use crate::core::suspect_window::{Mark, SuspectWindow};
use crate::pipeline::Pipeline;
use crate::pipeline::prelude::*;
use crate::pipeline::{Confirmation, ListFilter, SetAsideOrder, Submission, WindowMark};
use crate::wire::note;

/// Records that are asked for, and submitted, at a time.
const PAGE: u32 = 500;

/// What has come of it.
#[derive(Debug, Default)]
pub struct WindowOutcome {
    pub changed: Vec<Id>,
    /// What stands in the way of the others: corrected meanwhile, or another record stands at the time.
    pub refused: Vec<(Id, Refused)>,
}

impl Pipeline {
    /// Marks a window of a station. Suspect: every record and campaign of it that counts is set aside, and so is what
    /// comes later. Trusted again: what was set aside for it counts. What depends on them is judged again.
    ///
    /// # Errors
    /// [`Refused`], where there is no such station, or nothing can be read or stored.
    pub async fn mark_window(&self, mark: WindowMark) -> Result<WindowOutcome, Refused> {
        // First: what comes while the stored ones are gone through is held against it.
        self.ingest.submit(Submission::Window(mark.clone())).await?;
        let WindowMark { station, mark: Mark { window, trusted } } = mark;
        let SuspectWindow { span, author, reason } = window;
        let (author, reason) = (|| author.clone(), || reason.clone());
        let outcome = if trusted {
            let confirm = |id| {
                Submission::Confirmation(Confirmation {
                    id,
                    of_window: true,
                    author: author(),
                    reason: reason(),
                    restated: None,
                })
            };
            self.submit_window(self.suspect_in(&station, span).await?, confirm).await?
        } else {
            let doubt = |id| Submission::SetAside(SetAsideOrder { id, author: author(), reason: reason() });
            self.submit_window(self.of_window(&station, span, true).await?, doubt).await?
        };
        self.ingest.look_at_shared().await?;
        Ok(outcome)
    }

    /// What is set aside in a window for no other reason than that it is suspect, oldest first.
    async fn suspect_in(&self, station: &str, span: Span) -> Result<Vec<Id>, Refused> {
        let mut suspect = Vec::new();
        for id in self.of_window(station, span, false).await? {
            let is_aside = self.queries.records.status(id).await?.set_aside;
            let Some(record) = self.queries.records.sent(id).await?.filter(|_| is_aside) else {
                continue;
            };
            let noted = note::read(record.notes.as_deref());
            let is_noted = |code: &str| noted.iter().any(|note| note.code == code);
            if is_noted("suspect") && !is_noted("time_in_doubt") {
                suspect.push(id);
            }
        }
        Ok(suspect)
    }

    /// Records and campaigns of the window, those that count or those that do not, oldest first.
    async fn of_window(&self, station: &str, span: Span, counting: bool) -> Result<Vec<Id>, Refused> {
        let filter = ListFilter { kind: None, imu: None, station: Some(station), calibrated: span };
        let (mut found, mut before) = (Vec::new(), Id(i64::MAX));
        loop {
            let page = self.queries.records.listed(&filter, before, PAGE).await?;
            let Some(last) = page.last() else { break };
            before = last.id;
            found.extend(page.iter().filter(|record| record.voided != counting).map(|r| (r.calibrated_at, r.id)));
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
                    Err(undone @ (Refused::Busy | Refused::Stopping | Refused::Storage(_))) => return Err(undone),
                    Err(refused) => outcome.refused.push((*id, refused)),
                }
            }
        }
        Ok(outcome)
    }
}
