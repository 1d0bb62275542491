//! A record is set aside, or what was set aside is confirmed and counts from now on.

use serde_json::json;

use super::context::Admission;
use super::group::Group;
use crate::core::history_note::HistoryNote;
use crate::core::time::Span;
use crate::pipeline::ingest::submission::{Confirmation, Doubt};
use crate::pipeline::{Accepted, Refused};
use crate::store;
use crate::store::{ConfirmationRow, HistoryRow, NamesOf, StoredAside};
use crate::wire::history_note;

impl Admission<'_> {
    pub(super) async fn confirmation(&mut self, sent: &Confirmation, group: &mut Group) -> Result<Accepted, Refused> {
        let id = sent.id;
        let record = store::record::get(self.store, id).await?.ok_or(Refused::UnknownRecord { id })?;
        let before = group.changes.confirmed.iter().any(|row| row.record == id);
        if before || store::set_aside::confirmation(self.store, id).await?.is_some() {
            return Ok(Accepted::There { id, same_bytes: true });
        }
        if !self.said_before(id, group).await?.is_empty() {
            return Err(Refused::AlreadyCorrected { id, existing: id });
        }
        if !record.voided {
            return Err(Refused::NotSetAside { id });
        }
        let at = record.calibrated_at;
        if let Some((existing, _)) = self.counting_at(Some(record.imu), at, group).await? {
            return Err(Refused::TimeTaken { existing, kind: record.kind });
        }
        let mut rows = Vec::new();
        for (index, &(gyro, _)) in record.verdicts.0.iter().enumerate() {
            if let Some(existing) = self.row_at(Some(gyro), at, group).await? {
                let serial = self.name_of(NamesOf::Gyros, gyro, group);
                return Err(Refused::GyroElsewhere { existing, index, serial });
            }
            let aside = store::history::voided(self.store, gyro, Span { from: at, to: at }).await?;
            rows.extend(aside.into_iter().filter(|row| row.record == id).map(|figures| HistoryRow { gyro, figures }));
        }
        for row in &rows {
            group.rows.insert((row.gyro, at), id);
        }
        group.records.insert((record.imu, at), (id, record.body_sha256));
        self.memory.forget_of(rows.iter().map(|row| row.gyro));
        group.changes.history.extend(rows);
        let (author, reason) = (sent.author.clone(), sent.reason.clone());
        let audited = json!({ "author": author, "reason": reason });
        let line = self.ids.next(self.now);
        let what = ("confirm", format!("records/{id}"));
        group.changes.access.audit.push(sent.by.line(line, self.now, what, None::<&()>, Some(&audited)));
        group.changes.confirmed.push(ConfirmationRow { record: id, at: self.now, author, reason });
        Ok(Accepted::stored(id))
    }

    pub(super) async fn suspicion(&mut self, sent: &Doubt, group: &mut Group) -> Result<Accepted, Refused> {
        let id = sent.id;
        let record = store::record::get(self.store, id).await?.ok_or(Refused::UnknownRecord { id })?;
        let said = self.said_before(id, group).await?;
        if !said.is_empty() || group.changes.confirmed.iter().any(|row| row.record == id) {
            return Err(Refused::AlreadyCorrected { id, existing: id });
        }
        if record.voided || group.withdraws(id) {
            return Ok(Accepted::There { id, same_bytes: true });
        }
        self.withdraw(&record, group).await?;
        let (author, reason) = (sent.author.clone(), sent.reason.clone());
        let station = self.name_of(NamesOf::Stations, record.station, group);
        let note = HistoryNote::Suspect { station, author: author.clone(), reason: reason.clone() };
        group.changes.rejudged.notes.push((id, history_note::with(record.notes.as_deref(), &note)));
        let audited = json!({ "author": author, "reason": reason });
        let line = self.ids.next(self.now);
        let what = ("suspect", format!("records/{id}"));
        group.changes.access.audit.push(sent.by.line(line, self.now, what, None::<&()>, Some(&audited)));
        group.changes.set_aside.stored.push(StoredAside { record: id, author, reason });
        Ok(Accepted::stored(id))
    }
}
