//! What people say of a gyro, as an event or as a baseline: read and submitted alike, each with messages of its own.

use crate::core::gyro_event::GyroEvent;
use crate::core::message::Message;
use crate::core::record::Name;
use crate::http::prelude::*;
use crate::pipeline::{Accepted, EventOrder, Submission};

/// Why, when and who, as they were sent.
pub struct SentRemark {
    pub reason: String,
    pub at: Option<String>,
    pub author: Option<String>,
}

impl SentRemark {
    /// Checked; `blank` is what is told of a reason that says nothing. Without a time, now.
    pub fn read(self, app: &App, blank: Message, faults: &mut Faults) -> (String, UtcMicros, Option<String>) {
        if self.reason.trim().is_empty() {
            faults.push("/reason", blank);
        }
        let reason = text::note("/reason", &Some(self.reason), faults).unwrap_or_default();
        let at = self.at.map_or_else(|| app.clock.now(), |at| text::start("/at", &at, faults));
        let author = text::short("/author", &self.author, faults);
        if faults.is_empty()
            && let Err(impossible) = app.pipeline.reader.check_time("/at", at)
        {
            faults.absorb("", impossible);
        }
        (reason, at, author)
    }
}

/// Reads what a document says of the gyro of a path and submits it: 201 and its identifier where it is new, 200 where
/// it was there in the same words; `otherwise` is told where it was in others.
pub async fn post(
    app: &App,
    serial: &str,
    body: &Document,
    read: impl FnOnce(&App, &[u8]) -> Result<GyroEvent, Faults>,
    otherwise: Message,
) -> Answer<(StatusCode, Id, GyroEvent)> {
    let serial = Name::parse(serial).map_err(|_| Problem::unknown_gyro(serial))?;
    let event = body.read(|bytes| read(app, bytes))?;
    let order = EventOrder { serial, event: event.clone() };
    match app.pipeline.ingest.submit(Submission::Event(order)).await? {
        Accepted::Stored { id, .. } => Ok((StatusCode::CREATED, id, event)),
        Accepted::There { id, same_bytes: true, .. } => Ok((StatusCode::OK, id, event)),
        Accepted::There { id, .. } => Err(Problem::new(409, "title_differs", otherwise).with_existing(id)),
    }
}
