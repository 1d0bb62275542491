//! Who sent what is new: one line of the audit trail for all that one sender has in a group.

use super::context::Admission;
use super::group::{Group, Sending};
use crate::core::id::Id;

impl Admission<'_> {
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
