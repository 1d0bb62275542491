//! What somebody says of a stored item: it does not count, or another record stands in its place.

use std::sync::Arc;

use serde_json::json;

use super::context::Admission;
use super::group::Group;
use crate::core::correction::CorrectionItem;
use crate::core::id::Id;
use crate::core::kind::Kind;
use crate::core::note::Note;
use crate::core::time::Span;
use crate::core::time::UtcMicros;
use crate::pipeline::ingest::same_content::says_the_same;
use crate::pipeline::ingest::submission::{Calibration, Corrected, Correction};
use crate::pipeline::{Accepted, Refused};
use crate::store;
use crate::store::{HistoryRow, NamesOf, RecordRow, StoreError};

impl Admission<'_> {
    pub(super) async fn correction(&mut self, sent: &Correction, group: &mut Group) -> Result<Accepted, Refused> {
        let id = sent.item.id();
        let said = self.said_before(id, group).await?;
        if let Some(there) = self.repeated(sent, &said, group).await? {
            return Ok(there);
        }
        match (sent.item, &sent.replacement) {
            (Corrected::Bench(_), _) => {
                let bench = store::bench::get(self.store, id).await?.ok_or(Refused::UnknownBench { id })?;
                group.changes.withdrawn.benches.push((id, bench.gyro));
            }
            (Corrected::Calibration { id, kind }, replacement) => {
                let record = store::record::get(self.store, id)
                    .await?
                    .filter(|record| kind.is_none_or(|kind| record.kind == kind));
                let record = record.ok_or(Refused::UnknownRecord { id })?;
                let before = (group.changes.withdrawn.records.len(), group.changes.withdrawn.history.len());
                if said.is_empty() {
                    self.withdraw(&record, group).await?;
                }
                if let Some(new) = replacement {
                    let entered = self.replace(&record, new, group).await;
                    if entered.is_err() {
                        // What was to stand in its place is not taken: it goes on counting.
                        group.changes.withdrawn.records.truncate(before.0);
                        group.changes.withdrawn.history.truncate(before.1);
                    }
                    let (new, notes) = entered?;
                    self.take_down(sent, Some(new), group);
                    return Ok(Accepted::Stored { id: new, judged: [].into(), notes });
                }
            }
        }
        self.take_down(sent, None, group);
        Ok(Accepted::stored(id))
    }

    fn take_down(&mut self, sent: &Correction, replaced_by: Option<Id>, group: &mut Group) {
        let (item, author, reason) = (sent.item.id(), sent.author.clone(), sent.reason.clone());
        let audited =
            json!({ "author": author, "reason": reason, "replaced_by": replaced_by.map(|id| id.to_string()) });
        let subject = match sent.item {
            Corrected::Calibration { .. } => format!("records/{item}"),
            Corrected::Bench(_) => format!("bench-results/{item}"),
        };
        let what = (if replaced_by.is_some() { "revise" } else { "void" }, subject);
        let line = self.ids.next(self.now);
        group.changes.access.audit.push(sent.by.line(line, self.now, what, None::<&()>, Some(&audited)));
        group.changes.corrections.push(CorrectionItem { item, replaced_by, at: self.now, author, reason });
    }

    /// Takes a record out of what counts.
    pub(super) async fn withdraw(&mut self, record: &RecordRow, group: &mut Group) -> Result<(), StoreError> {
        let at = record.calibrated_at;
        for &(gyro, _) in &record.verdicts.0 {
            let rows = store::history::oldest(self.store, gyro, Span { from: at, to: at }, 1).await?;
            let withdrawn = rows.into_iter().map(|figures| HistoryRow { gyro, figures });
            group.changes.withdrawn.history.extend(withdrawn);
        }
        self.memory.forget_of(record.verdicts.0.iter().map(|(gyro, _)| *gyro));
        group.changes.withdrawn.records.push(record.id);
        Ok(())
    }

    /// Enters the record that is to stand in another's place.
    async fn replace(
        &mut self,
        old: &RecordRow,
        new: &Calibration,
        group: &mut Group,
    ) -> Result<(Id, Arc<[Note]>), Refused> {
        if self.number(NamesOf::Imus, new.imu.as_str(), group) != Some(old.imu) {
            return Err(Refused::AnotherImu);
        }
        if let Some((existing, _)) = self.counting_at(Some(old.imu), new.calibrated_at, group).await? {
            return Err(Refused::TimeTaken { existing, kind: new.kind });
        }
        self.enter(new, group).await
    }

    /// What was said of an item as it stands, this group included.
    pub(super) async fn said_before(&self, item: Id, group: &Group) -> Result<Vec<CorrectionItem>, StoreError> {
        let mut said = store::correction::of_item(self.store, item).await?;
        said.extend(group.changes.corrections.iter().cloned());
        said.retain(|row| row.item == item);
        Ok(said)
    }

    /// The answer where the same was said before. A record that was voided can still be revised, so that what was
    /// voided by mistake counts again.
    async fn repeated(
        &self,
        sent: &Correction,
        said: &[CorrectionItem],
        group: &Group,
    ) -> Result<Option<Accepted>, Refused> {
        let id = sent.item.id();
        let Some(last) = said.iter().max_by_key(|row| row.replaced_by.is_some()) else { return Ok(None) };
        let same_words = |row: &&CorrectionItem| row.author == sent.author && row.reason == sent.reason;
        let differs = Refused::AlreadyCorrected { id, existing: last.replaced_by.unwrap_or(id) };
        match (&sent.replacement, last.replaced_by) {
            (None, _) => {
                let same = said.iter().filter(|row| row.replaced_by.is_none()).find(same_words);
                same.map(|_| Some(Accepted::There { id, same_bytes: true })).ok_or(differs)
            }
            (Some(_), None) => Ok(None),
            (Some(new), Some(standing)) => {
                let same = same_words(&last) && self.has_content(standing, new, group).await?;
                if same { Ok(Some(Accepted::There { id: standing, same_bytes: true })) } else { Err(differs) }
            }
        }
    }

    /// Whether a record, stored or of this group, says the same as another.
    async fn has_content(&self, id: Id, other: &Calibration, group: &Group) -> Result<bool, StoreError> {
        let says = |kind: Kind, body: &str| kind == other.kind && says_the_same(kind, body, &other.body);
        if let Some(record) = group.changes.records.iter().find(|record| record.id == id) {
            return Ok(says(record.kind, &record.body));
        }
        Ok(store::record::get(self.store, id).await?.is_some_and(|record| says(record.kind, &record.body)))
    }

    /// The record of an IMU that counts at an instant, and the hash of its body.
    pub(super) async fn counting_at(
        &self,
        imu: Option<u32>,
        at: UtcMicros,
        group: &Group,
    ) -> Result<Option<(Id, Vec<u8>)>, StoreError> {
        let Some(imu) = imu else { return Ok(None) };
        if let Some((id, hash)) = group.records.get(&(imu, at)) {
            return Ok(Some((*id, hash.to_vec())));
        }
        let mut stored = self.ahead.records_at(imu, at, self.store).await?.into_iter();
        let counts = stored.find(|record| !record.voided && !group.withdraws(record.id));
        Ok(counts.map(|record| (record.id, record.hash)))
    }

    /// The record that was sent before with the same content, and does not count any more: sent again it stays as it
    /// is, because the sender does not know. Another may stand in its place, of the same time; where that says the
    /// same, it is meant.
    pub(super) async fn voided_alike(
        &self,
        imu: Option<u32>,
        sent: &Calibration,
        standing: Option<Id>,
        group: &Group,
    ) -> Result<Option<Id>, StoreError> {
        let Some(imu) = imu else { return Ok(None) };
        let mut others = self.ahead.records_at(imu, sent.calibrated_at, self.store).await?;
        others.retain(|record| Some(record.id) != standing);
        if let Some(same) = others.iter().find(|record| record.hash == sent.body_sha256) {
            return Ok(Some(same.id));
        }
        // What is read only to be compared keeps everybody waiting: not where nothing was withdrawn.
        if let Some(standing) = standing.filter(|_| !others.is_empty())
            && self.has_content(standing, sent, group).await?
        {
            return Ok(None);
        }
        for record in others {
            if self.has_content(record.id, sent, group).await? {
                return Ok(Some(record.id));
            }
        }
        Ok(None)
    }
}
