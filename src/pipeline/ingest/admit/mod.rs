//! Is it new, the same again, or in conflict? And the numbers and identifiers of what is new.

mod checking;
mod correction;
mod group;
mod lookup;
mod overlapping;
mod prefetched;
mod recent_records;

use serde_json::{Value, json};

use crate::core::bench::BenchItem;
use crate::core::figures::{PublishedFigures, States};
use crate::core::gyro_attributes::GyroAttributes;
use crate::core::history_note::{HistoryNote, NameKind};
use crate::core::record::Name;
use crate::core::separate::{Branch, Separation};
use crate::pipeline::ingest::same_content::{Origin, says_the_same};
use crate::pipeline::ingest::submission::BenchTest;
use crate::pipeline::prelude::*;
use crate::pipeline::{AttributesOrder, CalibratedGyro, Calibration, EventOrder, Submission};
use crate::store::{
    EventRow, GyroAttributeRow, HistoryRow, NamesOf, NewName, RecordRow, RecordVerdicts, RestatedRow, StoredVerdict,
};
use crate::wire::document::DocumentKind;
use crate::wire::{history_note, time};
use checking::{Check, Checked};
pub(crate) use group::Group;
pub(crate) use lookup::{Admission, Lookup};
use overlapping::overlapping;
pub(crate) use prefetched::Prefetched;
use recent_records::RecentRecord;
pub(crate) use recent_records::RecentRecords;

impl Admission<'_> {
    /// Takes one item into the group. Verdicts are added when the whole group is judged. A key is used for whatever its
    /// document is answered with, be that new or there already.
    pub async fn admit(&mut self, item: &Submission) -> Result<Accepted, Refused> {
        let Some((key, hash)) = item.key() else { return self.admit_by_itself(item).await };
        if let Some(there) = self.known.by_key(key, hash).await? {
            return Ok(there);
        }
        let accepted = self.admit_by_itself(item).await?;
        let (id, same_bytes) = match &accepted {
            Accepted::Stored { id, .. } => (*id, true),
            Accepted::There { id, same_bytes, .. } => (*id, *same_bytes),
        };
        let is_same = match Origin::of(item) {
            Some(sent) if !same_bytes => self.known.has_content(id, &sent).await?,
            _ => same_bytes,
        };
        if is_same {
            self.known.group.take_key(key, id, *hash);
        }
        Ok(accepted)
    }

    async fn admit_by_itself(&mut self, item: &Submission) -> Result<Accepted, Refused> {
        match item {
            Submission::Calibration(calibration) => self.calibration(calibration).await,
            Submission::Bench(bench) => self.bench(bench).await,
            Submission::Event(event) => self.event(event).await,
            Submission::Correction(correction) => self.correction(correction).await,
            Submission::Confirmation(confirmation) => self.confirmation(confirmation).await,
            Submission::SetAside(doubt) => self.suspicion(doubt).await,
            Submission::Window(window) => self.window(window).await,
            Submission::Attributes(order) => self.attributes(order).await,
        }
    }

    async fn calibration(&mut self, sent: &Calibration) -> Result<Accepted, Refused> {
        let imu = self.known.number(NamesOf::Imus, sent.imu.as_str());
        let standing = self.known.counting_at(imu, sent.calibrated_at).await?;
        if let Some((id, hash)) = &standing
            && *hash == sent.body_sha256
        {
            return Ok(Accepted::there(*id));
        }
        let stands = standing.as_ref().map(|(id, _)| *id);
        if let Some(id) = self.known.voided_alike(imu, sent, stands).await? {
            return Ok(Accepted::There { id, same_bytes: true, counts: false });
        }
        if let Some(id) = stands {
            return Ok(Accepted::There { id, same_bytes: false, counts: true });
        }
        let aside = self.known.aside_at(imu, sent.calibrated_at).await?;
        let (id, notes) = self.enter(sent, &aside).await?;
        Ok(Accepted::Stored { id, judged: [].into(), notes })
    }

    /// Takes a calibration in at an instant at which its IMU has none that counts, but perhaps some that are set `aside`.
    async fn enter(&mut self, sent: &Calibration, aside: &[Id]) -> Result<(Id, Arc<[Note]>), Refused> {
        let at = sent.calibrated_at;
        for gyro in &sent.gyros {
            let known = self.known.number(NamesOf::Gyros, gyro.serial.as_str());
            if let Some(existing) = self.known.row_at(known, at).await? {
                let (index, serial) = (gyro.place, gyro.serial.to_string());
                return Err(Refused::GyroElsewhere { existing, index, serial });
            }
        }
        let Checked { mut notes, set_aside } = Check::of(sent, self).await?;
        if !aside.is_empty() {
            let records = aside.iter().map(ToString::to_string).collect();
            notes.push(Note::History(HistoryNote::SameTimeSetAside { records }));
        }
        let id = self.ids.next(self.now);
        let home = store::names::cell_of_imu(self.known.store, sent.imu.as_str());
        let imu = self.take_number(NamesOf::Imus, sent.imu.as_str(), home);
        let station = self.take_number(NamesOf::Stations, sent.station.as_str(), home);
        let mut sheet = RecordVerdicts::default();
        for gyro in &sent.gyros {
            let number = self.take_number(NamesOf::Gyros, gyro.serial.as_str(), home);
            let figures = figures_of(&gyro.separation, id, at, imu, station);
            if set_aside {
                self.known.group.changes.set_aside.history.push(HistoryRow { gyro: number, figures });
            } else {
                self.known.group.changes.history.push(HistoryRow { gyro: number, figures });
                self.known.group.rows.insert((number, at), id);
                let (shown, ends_at) = (checking::shown(gyro), Some(sent.ends_at));
                self.known.memory.add(number, RecentRecord { shown, ends_at, ..RecentRecord::from(&figures) });
            }
            sheet.0.push((number, gyro.requirements.iter().flatten().map(StoredVerdict::from).collect()));
        }
        let place = if sent.kind == Kind::Campaign { "campaigns" } else { "records" };
        let sent_by = Some(self.note_sending(place, id));
        if set_aside {
            self.known.group.aside.entry((imu, at)).or_default().push((id, sent.body_sha256));
        } else {
            self.known.group.records.insert((imu, at), (id, sent.body_sha256));
        }
        self.known.group.changes.models_used.extend(sent.model.map(|model| (id, model)));
        self.known.group.changes.records.push(RecordRow {
            id,
            kind: sent.kind,
            imu,
            station,
            calibrated_at: at,
            received_at: self.now,
            body: Arc::clone(&sent.body),
            body_sha256: sent.body_sha256,
            verdicts: sheet,
            voided: set_aside,
            notes: history_note::kept(&notes).map(Into::into),
            sent_by,
            temperature_c: sent.temperature_c,
        });
        Ok((id, notes.into()))
    }

    async fn bench(&mut self, sent: &BenchTest) -> Result<Accepted, Refused> {
        let result = &sent.result;
        let (at, method) = (result.measured_at, result.method);
        if let Some(gyro) = self.known.number(NamesOf::Gyros, result.serial.as_str()) {
            let mut counting = None;
            if let Some((id, hash)) = self.known.group.benches.get(&(gyro, at, method)) {
                if *hash == sent.body_sha256 {
                    return Ok(Accepted::there(*id));
                }
                counting = Some(*id);
            }
            for there in store::bench::at(self.known.store, gyro, at, method).await? {
                let same_bytes = there.hash == sent.body_sha256;
                let counts = !there.voided && !self.known.group.changes.withdrawn.benches.contains(&(there.id, gyro));
                // What was voided and is sent again stays as it is: the sender does not know.
                if same_bytes || is_alike(there.id, &sent.body, self.known.store).await? {
                    return Ok(Accepted::There { id: there.id, same_bytes: same_bytes || !counts, counts });
                }
                counting = counting.or(counts.then_some(there.id));
            }
            if let Some(id) = counting {
                return Ok(Accepted::There { id, same_bytes: false, counts: true });
            }
        }
        let names = [(NameKind::Serial, result.serial.as_str()), (NameKind::Station, result.station.as_str())];
        let mut notes = self.known.look_alikes(&names);
        if let Some(gyro) = self.known.number(NamesOf::Gyros, result.serial.as_str()) {
            let around = self.known.memory.around(self.known.store, gyro, at, &self.known.group).await?;
            let tested = [(gyro, result.serial.as_str(), &around)];
            notes.extend(overlapping(&mut self.known, Span { from: at, to: sent.ends_at }, &tested).await?);
        }
        let notes = notes.into_iter().map(Note::History).collect();
        let id = self.ids.next(self.now);
        let home = store::names::cell_of_gyro(self.known.store, result.serial.as_str());
        let gyro = self.take_number(NamesOf::Gyros, result.serial.as_str(), home);
        let station = self.take_number(NamesOf::Stations, result.station.as_str(), home);
        let sent_by = Some(self.note_sending("bench-results", id));
        self.known.group.benches.insert((gyro, at, method), (id, sent.body_sha256));
        self.known.group.changes.benches.push(BenchItem {
            id,
            gyro,
            station,
            measured_at: at,
            method,
            d: [result.d_i, result.d_s],
            sd: [result.d_i_sd, result.d_s_sd],
            voided: false,
            received_at: self.now,
            body: Arc::clone(&sent.body),
            body_sha256: sent.body_sha256,
            sent_by,
        });
        Ok(Accepted::Stored { id, judged: [].into(), notes })
    }

    async fn event(&mut self, order: &EventOrder) -> Result<Accepted, Refused> {
        let EventOrder { serial, event } = order;
        let gyro = self.known_gyro(serial)?;
        let stored = store::event::of_gyro(self.known.store, gyro).await?;
        let mut known = stored.iter().chain(self.known.group.changes.events.iter().filter(|row| row.gyro == gyro));
        if let Some(row) = known.find(|row| (row.told.at, row.told.event) == (event.at, event.event)) {
            return Ok(Accepted::There { id: row.id, same_bytes: row.told == *event, counts: true });
        }
        let id = self.ids.next(self.now);
        let audited = json!({
            "id": id.to_string(), "event": event.event.name(), "at": time::format(event.at), "reason": event.reason,
            "author": event.author,
        });
        self.audit(("mark event", format!("gyros/{serial}")), &audited);
        self.known.group.changes.events.push(EventRow { id, gyro, told: event.clone(), received_at: self.now });
        Ok(Accepted::stored(id))
    }

    async fn attributes(&mut self, sent: &AttributesOrder) -> Result<Accepted, Refused> {
        let gyro = self.known_gyro(&sent.serial)?;
        let before = match self.known.group.changes.attributes.iter().rfind(|row| row.gyro == gyro) {
            Some(row) => row.attributes.clone(),
            None => store::gyro_attribute::of(self.known.store, &[gyro]).await?.remove(&gyro).unwrap_or_default(),
        };
        let attributes = before.patched(&sent.patch);
        let line = self.ids.next(self.now);
        if attributes == before {
            return Ok(Accepted::there(line));
        }
        let audited = |of: &GyroAttributes| json!({ "batch": of.batch, "type": of.r#type, "unit": of.unit });
        let (was, is) = (audited(&before), audited(&attributes));
        let what = ("set attributes", format!("gyros/{}", sent.serial));
        self.known.group.changes.access.audit.push(self.by.line(line, self.now, what, Some(&was), Some(&is)));
        self.known.group.changes.attributes.push(GyroAttributeRow { gyro, attributes });
        Ok(Accepted::stored(line))
    }

    /// The number of a gyro that people say something of.
    fn known_gyro(&self, serial: &Name) -> Result<u32, Refused> {
        let known = self.known.number(NamesOf::Gyros, serial.as_str());
        Ok(known.ok_or_else(|| Problem::unknown_gyro(serial))?)
    }

    /// Notes in the audit trail what the sender does, and with what outcome.
    fn audit(&mut self, what: (&str, String), after: &Value) {
        let line = self.ids.next(self.now);
        self.known.group.changes.access.audit.push(self.by.line(line, self.now, what, None::<&()>, Some(after)));
    }

    /// Takes down that an item under `place` is its sender's; gives the line that will say so.
    fn note_sending(&mut self, place: &str, id: Id) -> Id {
        self.known.group.note_sending(self.by, place, id, || self.ids.next(self.now))
    }

    /// The name's number; a new one, at home in `cell`, where it has none yet.
    fn take_number(&mut self, table: NamesOf, name: &str, cell: u8) -> u32 {
        if let Some(number) = self.known.number(table, name) {
            return number;
        }
        let known = self.known.store.names().read();
        let number = store::names::new_number(self.known.store, known.of(table), self.known.group.names.of(table));
        self.known.group.names.of_mut(table).add(number, cell, name);
        self.known.group.changes.names_mut(table).push(NewName { number, cell, name: name.to_owned() });
        number
    }
}

async fn is_alike(bench: Id, body: &str, store: &Store) -> Result<bool, StoreError> {
    Ok(store::bench::get(store, bench)
        .await?
        .is_some_and(|stored| says_the_same(DocumentKind::Bench, &stored.body, body)))
}

/// The rows of a stored calibration as it is stated now; none where those are of other gyros than the rows that are
/// stored.
pub(crate) fn rows_as_stated(store: &Store, stored: &RecordRow, now: &Calibration) -> Option<Vec<RestatedRow>> {
    let tables = store.names().read();
    let row = |gyro: &CalibratedGyro| {
        let number = tables.gyros.number(gyro.serial.as_str())?;
        let figures = figures_of(&gyro.separation, stored.id, stored.calibrated_at, stored.imu, stored.station);
        let requirements = gyro.requirements.iter().flatten().map(StoredVerdict::from).collect();
        Some(RestatedRow { row: HistoryRow { gyro: number, figures }, requirements })
    };
    let rows = now.gyros.iter().map(row).collect::<Option<Vec<_>>>()?;
    let is_stored = |row: &RestatedRow| stored.verdicts.0.iter().any(|(gyro, _)| *gyro == row.row.gyro);
    (rows.len() == stored.verdicts.0.len() && rows.iter().all(is_stored)).then_some(rows)
}

pub(crate) fn figures_of(separation: &Separation, record: Id, at: UtcMicros, imu: u32, station: u32) -> Figures {
    let rigid = &separation.rigid;
    let published = separation.published.as_ref().ok().map(|p| PublishedFigures {
        branch: equation(p.branch),
        d: [p.d_i, p.d_s],
        closure_rms: p.closure_rms,
        sd: p.sd(),
    });
    Figures {
        at,
        record,
        imu,
        station,
        slot: separation.slot,
        rigid: [rigid.d_i, rigid.d_s, rigid.d_o],
        rigid_sd: rigid.sd(),
        published,
        states: States::default(),
        voided: false,
    }
}

fn equation(branch: Branch) -> u8 {
    match branch {
        Branch::Eq8 => 8,
        Branch::Eq9 => 9,
        Branch::Eq10 => 10,
        Branch::Eq11 => 11,
        Branch::Eq12 => 12,
        Branch::Eq13 => 13,
    }
}
