//! What stands where an item is about to go: what is stored, and what its group already holds.

use super::group::Group;
use super::prefetched::Prefetched;
use super::recent_records::RecentRecords;
use crate::core::correction::CorrectionItem;
use crate::core::history_note::{HistoryNote, NameKind};
use crate::core::mounting::Slot;
use crate::core::name::distance;
use crate::core::suspect_window::{Mark, SuspectWindow, in_force};
use crate::pipeline::Calibration;
use crate::pipeline::ingest::same_content::{Origin, differences, says_the_same};
use crate::pipeline::prelude::*;
use crate::store::{IdSource, NamesOf, Table};
use crate::wire::document::DocumentKind;

/// A serial is near to another that differs by so many slips of the pen.
const SLIPS: usize = 2;

/// Who takes items into a group, one by one.
pub(crate) struct Admission<'a> {
    pub known: Lookup<'a>,
    pub ids: &'a mut IdSource,
    pub config: &'a Config,
    pub now: UtcMicros,
    /// Whose item is at hand.
    pub by: &'a Actor,
}

/// What admission may ask.
pub(crate) struct Lookup<'a> {
    pub store: &'a Store,
    pub memory: &'a mut RecentRecords,
    /// Whether a bench has measured a gyro, as far as that is known.
    pub benched: &'a HashMap<u32, bool>,
    pub ahead: &'a Prefetched,
    pub group: Group,
}

impl Lookup<'_> {
    pub async fn by_key(&self, key: &str, hash: &[u8; 32]) -> Result<Option<Accepted>, Refused> {
        let used = match self.group.keys.get(key) {
            Some((id, hash)) => Some((*id, hash.to_vec())),
            None => self.ahead.key(key, self.store).await?,
        };
        match used {
            None => Ok(None),
            Some((id, used_for)) if used_for == hash => Ok(Some(Accepted::there(id))),
            Some((existing, _)) => {
                let reused = message!("key_reused", id = text(existing));
                Err(Problem::new(409, "title_key_reused", reused).with_existing(existing).into())
            }
        }
    }

    /// The record that holds a row of the gyro at that very instant.
    pub async fn row_at(&self, gyro: Option<u32>, at: UtcMicros) -> Result<Option<Id>, StoreError> {
        let Some(gyro) = gyro else { return Ok(None) };
        if let Some(id) = self.group.rows.get(&(gyro, at)) {
            return Ok(Some(*id));
        }
        if self.memory.is_newer(gyro, at) {
            return Ok(None);
        }
        let held = self.ahead.row_at(gyro, at, self.store).await?;
        Ok(held.filter(|record| !self.group.withdraws(*record)))
    }

    /// What `find` finds among the names that are stored, or else among the new ones.
    fn among_names<T>(&self, of: NamesOf, find: impl Fn(&Table) -> Option<T>) -> Option<T> {
        find(self.store.names().read().of(of)).or_else(|| find(self.group.names.of(of)))
    }

    pub fn number(&self, of: NamesOf, name: &str) -> Option<u32> {
        self.among_names(of, |names| names.number(name))
    }

    /// What was said of an item as it stands, this group included.
    pub async fn said_before(&self, item: Id) -> Result<Vec<CorrectionItem>, StoreError> {
        let mut said = store::correction::of_item(self.store, item).await?;
        said.extend(self.group.changes.corrections.iter().cloned());
        said.retain(|row| row.item == item);
        Ok(said)
    }

    /// How the windows of a station are marked, this group's marks included, oldest mark first.
    pub async fn window_marks(&self, station: u32) -> Result<Vec<Mark>, StoreError> {
        let mut marks = match self.memory.marks(station) {
            Some(remembered) => remembered.to_vec(),
            None => self.ahead.marks(station, self.store).await?,
        };
        let new = self.group.changes.window_marks.iter().filter(|row| row.station == station);
        marks.extend(new.map(|row| row.mark.clone()));
        Ok(marks)
    }

    /// Whether a record or a bench result, stored or of this group, says the same as what is sent.
    pub async fn has_content(&self, id: Id, sent: &Origin) -> Result<bool, StoreError> {
        let Changes { records, benches, .. } = &self.group.changes;
        let new = match sent.kind {
            DocumentKind::Bench => {
                benches.iter().find(|bench| bench.id == id).map(|bench| (DocumentKind::Bench, &bench.body))
            }
            _ => records.iter().find(|record| record.id == id).map(|record| (record.kind.into(), &record.body)),
        };
        match new {
            Some((kind, body)) => Ok(kind == sent.kind && says_the_same(kind, body, &sent.body)),
            None => Ok(differences(self.store, id, sent).await?.is_empty()),
        }
    }

    /// The record of an IMU that counts at an instant, and the hash of its body.
    pub async fn counting_at(&self, imu: Option<u32>, at: UtcMicros) -> Result<Option<(Id, Vec<u8>)>, StoreError> {
        let Some(imu) = imu else { return Ok(None) };
        if let Some((id, hash)) = self.group.records.get(&(imu, at)) {
            return Ok(Some((*id, hash.to_vec())));
        }
        let mut stored = self.ahead.records_at(imu, at, self.store).await?.into_iter();
        let counts = stored.find(|record| !record.voided && !self.group.withdraws(record.id));
        Ok(counts.map(|record| (record.id, record.hash)))
    }

    /// The record that was sent before with the same content, and does not count any more: sent again it stays as it
    /// is, because the sender does not know. Another may stand in its place, of the same time; where that says the
    /// same, it is meant.
    pub async fn voided_alike(
        &self,
        imu: Option<u32>,
        sent: &Calibration,
        standing: Option<Id>,
    ) -> Result<Option<Id>, StoreError> {
        let Some(imu) = imu else { return Ok(None) };
        let stored = self.ahead.records_at(imu, sent.calibrated_at, self.store).await?.into_iter();
        let new = self.group.aside.get(&(imu, sent.calibrated_at)).into_iter().flatten();
        let others = stored.map(|record| (record.id, record.hash)).chain(new.map(|(id, hash)| (*id, hash.to_vec())));
        let others: Vec<(Id, Vec<u8>)> = others.filter(|(id, _)| Some(*id) != standing).collect();
        if let Some((same, _)) = others.iter().find(|(_, hash)| *hash == sent.body_sha256) {
            return Ok(Some(*same));
        }
        // What is read only to be compared keeps everybody waiting: not where nothing was withdrawn.
        if let Some(standing) = standing.filter(|_| !others.is_empty())
            && self.has_content(standing, &sent.into()).await?
        {
            return Ok(None);
        }
        for (id, _) in others {
            if self.has_content(id, &sent.into()).await? {
                return Ok(Some(id));
            }
        }
        Ok(None)
    }

    /// The records of an IMU at an instant that are set aside.
    pub async fn aside_at(&self, imu: Option<u32>, at: UtcMicros) -> Result<Vec<Id>, StoreError> {
        let Some(imu) = imu else { return Ok(Vec::new()) };
        let mut aside: Vec<Id> = self.group.aside.get(&(imu, at)).into_iter().flatten().map(|(id, _)| *id).collect();
        for record in self.ahead.records_at(imu, at, self.store).await?.into_iter().filter(|record| record.voided) {
            if store::set_aside::is_set_aside(self.store, record.id).await? {
                aside.push(record.id);
            }
        }
        aside.retain(|id| self.group.changes.corrections.iter().all(|row| row.item != *id));
        Ok(aside)
    }

    /// The window in which a station is suspect that an instant lies in.
    pub async fn suspect_window(&self, station: u32, at: UtcMicros) -> Result<Option<SuspectWindow>, StoreError> {
        let windows = in_force(&self.window_marks(station).await?);
        Ok(windows.into_iter().find(|window| window.span.contains(at)))
    }

    /// The gyro that was in a slot of an IMU before `at`.
    pub async fn occupant(&self, imu: u32, slot: Slot, at: UtcMicros) -> Result<Option<u32>, StoreError> {
        let here = self.group.changes.history.iter().map(|row| (row.figures.at, row.gyro, &row.figures));
        let here = here.filter(|(then, _, figures)| (figures.imu, figures.slot) == (imu, slot) && *then < at);
        if let Some((_, gyro, _)) = here.max_by_key(|(then, ..)| *then) {
            return Ok(Some(gyro));
        }
        for head in store::record::of_imu(self.store, imu, 3).await?.into_iter().filter(|head| head.calibrated_at < at)
        {
            let (then, held) = (head.calibrated_at, store::record::whose(self.store, head.id).await?);
            for gyro in held.into_iter().flat_map(|(_, gyros)| gyros) {
                let rows = store::history::oldest(self.store, gyro, Span { from: then, to: then }, 1).await?;
                if rows.iter().any(|row| row.record == head.id && row.slot == slot) {
                    return Ok(Some(gyro));
                }
            }
        }
        Ok(None)
    }

    /// Of these names those that are new and look like known ones.
    pub fn look_alikes(&self, names: &[(NameKind, &str)]) -> Vec<HistoryNote> {
        let alike = |(of, name): &(NameKind, &str)| {
            let table = match of {
                NameKind::Imu => NamesOf::Imus,
                NameKind::Station => NamesOf::Stations,
                NameKind::Serial => NamesOf::Gyros,
            };
            if self.number(table, name).is_some() {
                return None;
            }
            let known = self.look_alike(table, name)?;
            Some(HistoryNote::LookAlike { of: *of, name: (*name).to_owned(), known })
        };
        names.iter().filter_map(alike).collect()
    }

    pub fn look_alike(&self, of: NamesOf, name: &str) -> Option<String> {
        self.among_names(of, |names| names.look_alike(name).map(str::to_owned))
    }

    /// The known serial that is nearest to a new one; of several that of the slot.
    pub fn nearest(&self, serial: &str, had: &str) -> Option<String> {
        let tables = self.store.names().read();
        let all = std::iter::once(had).chain(tables.gyros.all()).chain(self.group.names.gyros.all());
        let most = SLIPS.min(serial.chars().count() / 3);
        let near = all.filter_map(|known| Some((distance(serial, known, most)?, known)));
        near.min_by_key(|(slips, _)| *slips).map(|(_, known)| known.to_owned())
    }

    pub fn name_of(&self, of: NamesOf, number: u32) -> String {
        self.among_names(of, |names| names.name(number).map(str::to_owned)).unwrap_or_default()
    }
}
