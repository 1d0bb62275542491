//! Who sent what is new: one line of the audit trail for all that one sender has in a group.

use serde_json::json;

use super::{Desk, Group};
use crate::core::time::UtcMicros;
use crate::pipeline::Actor;
use crate::store::Id;

/// What one sender has in a group.
#[derive(Debug)]
pub(super) struct Sending {
    by: Actor,
    line: Id,
    /// The first of it, as the audit trail names it.
    subject: String,
    first: Id,
    last: Id,
    count: usize,
}

impl Desk<'_> {
    /// Takes down that an item under `place` is its sender's; gives the line that will say so.
    pub(super) fn sent(&mut self, place: &str, id: Id, group: &mut Group) -> Id {
        if let Some(known) = group.sendings.iter_mut().find(|sending| sending.by == *self.by) {
            (known.last, known.count) = (id, known.count + 1);
            return known.line;
        }
        let (by, line, subject) = (self.by.clone(), self.ids.next(self.now), format!("{place}/{id}"));
        group.sendings.push(Sending { by, line, subject, first: id, last: id, count: 1 });
        line
    }
}

impl Group {
    /// The lines about what was sent join what is to be written.
    pub fn audit_sendings(&mut self, now: UtcMicros) {
        for Sending { by, line, subject, first, last, count } in self.sendings.drain(..) {
            let subject = if count == 1 { subject } else { "records".to_owned() };
            let after = json!({ "stored": count, "first": first.to_string(), "last": last.to_string() });
            self.changes.access.audit.push(by.line(line, now, ("store", subject), None::<&()>, Some(&after)));
        }
    }
}
