//! What somebody says of a stored item: it does not count, another record stands in its place, it is set aside, or what
//! was set aside counts from now on.

use serde_json::json;

use super::lookup::Admission;
use super::rows_as_stated;
use crate::core::correction::CorrectionItem;
use crate::core::history_note::HistoryNote;
use crate::core::suspect_window::{Mark, SuspectWindow, in_force};
use crate::pipeline::prelude::*;
use crate::pipeline::{Calibration, Confirmation, Corrected, Correction, SetAsideOrder, WindowMark};
use crate::store::{ConfirmationRow, HistoryRow, NamesOf, RecordRow, RestatedRow, SetAsideRecord, WindowMarkRow};
use crate::wire::{history_note, time};

impl Admission<'_> {
    pub(super) async fn correction(&mut self, sent: &Correction) -> Result<Accepted, Refused> {
        let id = sent.item.id();
        let said = self.known.said_before(id).await?;
        if let Some(there) = self.repeated(sent, &said).await? {
            return Ok(there);
        }
        match (sent.item, &sent.replacement) {
            (Corrected::Bench(_), _) => {
                let bench =
                    store::bench::get(self.known.store, id).await?.ok_or_else(|| Problem::no_such_bench_result(id))?;
                self.known.group.changes.withdrawn.benches.push((id, bench.gyro));
            }
            (Corrected::Calibration { id, kind }, replacement) => {
                let record = store::record::get(self.known.store, id)
                    .await?
                    .filter(|record| kind.is_none_or(|kind| record.kind == kind));
                let record = record.ok_or_else(|| Problem::no_such_record(id))?;
                let before = (
                    self.known.group.changes.withdrawn.records.len(),
                    self.known.group.changes.withdrawn.history.len(),
                );
                if said.is_empty() {
                    self.withdraw(&record).await?;
                }
                if let Some(new) = replacement {
                    let entered = self.replace(&record, new).await;
                    if entered.is_err() {
                        // What was to stand in its place is not taken: it goes on counting.
                        self.known.group.changes.withdrawn.records.truncate(before.0);
                        self.known.group.changes.withdrawn.history.truncate(before.1);
                    }
                    let (new, notes) = entered?;
                    self.take_down(sent, Some(new));
                    return Ok(Accepted::Stored { id: new, judged: [].into(), notes });
                }
            }
        }
        self.take_down(sent, None);
        Ok(Accepted::stored(id))
    }

    fn take_down(&mut self, sent: &Correction, replaced_by: Option<Id>) {
        let (item, author, reason) = (sent.item.id(), sent.author.clone(), sent.reason.clone());
        let audited =
            json!({ "author": author, "reason": reason, "replaced_by": replaced_by.map(|id| id.to_string()) });
        let subject = match sent.item {
            Corrected::Calibration { .. } => format!("records/{item}"),
            Corrected::Bench(_) => format!("bench-results/{item}"),
        };
        let action = if replaced_by.is_some() { "revise" } else { "void" };
        self.audit((action, subject), &audited);
        self.known.group.changes.corrections.push(CorrectionItem { item, replaced_by, at: self.now, author, reason });
    }

    /// Takes a record out of what counts.
    pub(super) async fn withdraw(&mut self, record: &RecordRow) -> Result<(), StoreError> {
        let at = record.calibrated_at;
        for &(gyro, _) in &record.verdicts.0 {
            let rows = store::history::oldest(self.known.store, gyro, Span { from: at, to: at }, 1).await?;
            let own = rows.into_iter().filter(|figures| figures.record == record.id);
            let withdrawn = own.map(|figures| HistoryRow { gyro, figures });
            self.known.group.changes.withdrawn.history.extend(withdrawn);
        }
        self.known.memory.forget_of(record.verdicts.0.iter().map(|(gyro, _)| *gyro));
        self.known.group.changes.withdrawn.records.push(record.id);
        Ok(())
    }

    /// Enters the record that is to stand in another's place.
    async fn replace(&mut self, old: &RecordRow, new: &Calibration) -> Result<(Id, Arc<[Note]>), Refused> {
        if self.known.number(NamesOf::Imus, new.imu.as_str()) != Some(old.imu) {
            return Err(Refused::not_storable("/imu", message!("another_imu")));
        }
        if let Some((existing, _)) = self.known.counting_at(Some(old.imu), new.calibrated_at).await? {
            return Err(time_taken(existing, new.kind));
        }
        self.enter(new, &[]).await
    }

    /// The answer where the same was said before. A record that was voided can still be revised, so that what was
    /// voided by mistake counts again.
    async fn repeated(&self, sent: &Correction, said: &[CorrectionItem]) -> Result<Option<Accepted>, Refused> {
        let id = sent.item.id();
        let Some(last) = said.iter().max_by_key(|row| row.replaced_by.is_some()) else { return Ok(None) };
        let same_words = |row: &&CorrectionItem| row.author == sent.author && row.reason == sent.reason;
        let differs = corrected_otherwise(id, last.replaced_by.unwrap_or(id));
        match (&sent.replacement, last.replaced_by) {
            (None, _) => {
                let same = said.iter().filter(|row| row.replaced_by.is_none()).find(same_words);
                same.map(|_| Some(Accepted::there(id))).ok_or(differs)
            }
            (Some(_), None) => Ok(None),
            (Some(new), Some(standing)) => {
                let same = same_words(&last) && self.known.has_content(standing, &new.into()).await?;
                if same { Ok(Some(Accepted::there(standing))) } else { Err(differs) }
            }
        }
    }

    pub(super) async fn confirmation(&mut self, sent: &Confirmation) -> Result<Accepted, Refused> {
        let id = sent.id;
        let record = store::record::get(self.known.store, id).await?.ok_or_else(|| Problem::no_such_record(id))?;
        let before = self.known.group.changes.confirmed.iter().any(|row| row.record == id);
        if before || store::set_aside::confirmation(self.known.store, id).await?.is_some() {
            return Ok(Accepted::there(id));
        }
        if !self.known.said_before(id).await?.is_empty() {
            return Err(corrected_otherwise(id, id));
        }
        if !record.voided {
            return Err(Refused::conflict("title_not_set_aside", message!("not_set_aside", id = text(id))));
        }
        let at = record.calibrated_at;
        // Its window is suspect again meanwhile.
        if sent.of_window && self.known.suspect_window(record.station, at).await?.is_some() {
            return Ok(Accepted::There { id, same_bytes: true, counts: false });
        }
        if let Some((existing, _)) = self.known.counting_at(Some(record.imu), at).await? {
            return Err(time_taken(existing, record.kind));
        }
        let mut rows = Vec::new();
        for (index, &(gyro, _)) in record.verdicts.0.iter().enumerate() {
            if let Some(existing) = self.known.row_at(Some(gyro), at).await? {
                let serial = self.known.name_of(NamesOf::Gyros, gyro);
                return Err(Refused::GyroElsewhere { existing, index, serial });
            }
            let aside = store::history::voided(self.known.store, gyro, Span { from: at, to: at }).await?;
            rows.extend(aside.into_iter().filter(|row| row.record == id).map(|figures| HistoryRow { gyro, figures }));
        }
        if let Some((now, model)) = sent.restated.as_deref()
            && let Some(restated) = rows_as_stated(self.known.store, &record, now)
            && restated.iter().any(|RestatedRow { row, .. }| {
                !rows.iter().any(|aside| aside.gyro == row.gyro && aside.figures.agrees(&row.figures))
            })
        {
            rows = restated.iter().map(|restated| restated.row.clone()).collect();
            self.known.group.changes.rejudged.restated.extend(restated);
            self.known.group.changes.models_used.push((id, *model));
        }
        for row in &rows {
            self.known.group.rows.insert((row.gyro, at), id);
        }
        self.known.group.records.insert((record.imu, at), (id, record.body_sha256));
        self.known.memory.forget_of(rows.iter().map(|row| row.gyro));
        self.known.group.changes.history.extend(rows);
        let (author, reason) = (sent.author.clone(), sent.reason.clone());
        let audited = json!({ "author": author, "reason": reason });
        self.audit(("confirm", format!("records/{id}")), &audited);
        self.known.group.changes.confirmed.push(ConfirmationRow { record: id, at: self.now, author, reason });
        Ok(Accepted::stored(id))
    }

    pub(super) async fn suspicion(&mut self, sent: &SetAsideOrder) -> Result<Accepted, Refused> {
        let id = sent.id;
        let record = store::record::get(self.known.store, id).await?.ok_or_else(|| Problem::no_such_record(id))?;
        let said = self.known.said_before(id).await?;
        if !said.is_empty() || self.known.group.changes.confirmed.iter().any(|row| row.record == id) {
            return Err(corrected_otherwise(id, id));
        }
        // It is set aside already, or its window is trusted again meanwhile.
        let is_suspect = self.known.suspect_window(record.station, record.calibrated_at).await?.is_some();
        if record.voided || self.known.group.withdraws(id) || !is_suspect {
            return Ok(Accepted::there(id));
        }
        self.withdraw(&record).await?;
        let (author, reason) = (sent.author.clone(), sent.reason.clone());
        let station = self.known.name_of(NamesOf::Stations, record.station);
        let note = HistoryNote::Suspect { station, author: author.clone(), reason: reason.clone() };
        // A time that somebody has confirmed is in doubt no more, whatever the station did.
        let is_confirmed = store::set_aside::confirmation(self.known.store, id).await?.is_some();
        let before = record.notes.as_deref().map(|kept| match is_confirmed {
            true => history_note::without(kept, "time_in_doubt"),
            false => kept.to_owned(),
        });
        self.known.group.changes.rejudged.notes.push((id, history_note::with(before.as_deref(), &note)));
        let audited = json!({ "author": author, "reason": reason });
        self.audit(("suspect", format!("records/{id}")), &audited);
        self.known.group.changes.set_aside.stored.push(SetAsideRecord { record: id, author, reason });
        Ok(Accepted::stored(id))
    }

    /// Marks a window of a station. What is stored of it is set aside, or confirmed, item by item after it.
    pub(super) async fn window(&mut self, sent: &WindowMark) -> Result<Accepted, Refused> {
        let id = self.ids.next(self.now);
        let unknown = || Problem::no_such_station(&sent.station);
        let station = self.known.number(NamesOf::Stations, &sent.station).ok_or_else(unknown)?;
        let mut marks = self.known.window_marks(station).await?;
        let before = in_force(&marks);
        marks.push(sent.mark.clone());
        if in_force(&marks) == before {
            return Ok(Accepted::there(id));
        }
        let Mark { window: SuspectWindow { span, author, reason }, trusted } = &sent.mark;
        let audited = json!({
            "from": time::format(span.from), "to": time::format(span.to), "author": author, "reason": reason,
        });
        let what = (if *trusted { "trust window" } else { "suspect window" }, format!("stations/{}", sent.station));
        self.known.group.changes.access.audit.push(self.by.line(id, self.now, what, None::<&()>, Some(&audited)));
        self.known.memory.forget_marks(station);
        self.known.group.changes.window_marks.push(WindowMarkRow { id, station, mark: sent.mark.clone() });
        Ok(Accepted::stored(id))
    }
}

/// Something else was said of it before.
fn corrected_otherwise(id: Id, existing: Id) -> Refused {
    let otherwise = message!("corrected_otherwise", id = text(id));
    Problem::new(409, "title_already_corrected", otherwise).with_existing(existing).into()
}

/// Another record counts at that time.
fn time_taken(existing: Id, kind: Kind) -> Refused {
    let taken = Problem::new(409, "title_time_taken", message!("time_taken", id = text(existing)));
    let member = if kind == Kind::Record { "/calibrated_at" } else { "/measured_at" };
    taken.with_existing(existing).at(member).into()
}
