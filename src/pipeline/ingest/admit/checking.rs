//! A calibration held against what is known of its IMU and gyros: what is to be noted, and whether its time is in
//! doubt.

use std::collections::BTreeMap;

use super::context::Admission;
use super::group::Group;
use super::memory::{Around, Remembered};
use crate::core::history_note::{FAR_DAYS, HistoryNote, NameKind, Named, Seat, TimeDoubt, doubt};
use crate::core::id::Id;
use crate::core::mounting::Slot;
use crate::core::name::{distance, look_keys};
use crate::core::note::Note;
use crate::core::own_history::{Looked, Shown, against_histories};
use crate::core::time::UtcMicros;
use crate::pipeline::ingest::submission::{CalibratedGyro, Calibration};
use crate::store;
use crate::store::{NamesOf, StoreError, StoredAside};
use crate::wire::history_note;

/// A clock may be ahead of the service's by so much without a word, days.
const AHEAD_DAYS: f64 = 10.0 / 1440.0;
/// As near as this to its last record, in budgets, a gyro gives nothing to ask about.
const UNREMARKABLE_BUDGETS: f64 = 3.0;
const UNREMARKABLE_SCALE: f64 = 0.1;
/// A clock that was never set makes a few records, within so many days of one another.
const FALSE_RECORDS: usize = 64;
const FALSE_DAYS: f64 = 400.0;
/// A serial is near to another where so many slips of the pen part them.
const SLIPS: usize = 2;

/// What was found.
#[derive(Debug, Default)]
pub(super) struct Checked {
    pub notes: Vec<Note>,
    /// Its time is in doubt: it is not to count before somebody confirms it.
    pub set_aside: bool,
}

/// A gyro of the record and what is known of it.
struct Known<'a> {
    sent: &'a CalibratedGyro,
    number: Option<u32>,
    around: Around,
    budget: f64,
}

/// Who sets earlier records aside, and why, where nobody has said so.
const SERVICE: &str = "gyrowatch";
const EARLIER_IN_DOUBT: &str = "the time of earlier records is in doubt: they are set aside";

impl Known<'_> {
    fn shown(&self) -> Shown {
        shown(self.sent)
    }

    /// What its figures are held against.
    fn history(&self) -> &[Remembered] {
        if self.around.before.is_empty() { &self.around.after } else { &self.around.before }
    }

    /// Whether its figures are so near to those of its last record that nothing can be found.
    fn is_unremarkable(&self) -> bool {
        let Some(last) = self.history().last() else { return true };
        let now = self.shown();
        let near = (0..2).all(|i| (now.d[i] - last.shown.d[i]).abs() <= UNREMARKABLE_BUDGETS * self.budget);
        let scale = now.scale.zip(last.shown.scale);
        near && scale.is_none_or(|(a, b)| (a / b - 1.0).abs() < UNREMARKABLE_SCALE)
    }
}

pub(super) fn shown(gyro: &CalibratedGyro) -> Shown {
    let rigid = &gyro.separation.rigid;
    let sd = rigid.sd().map(|[d_i, d_s, _]| [d_i, d_s]);
    Shown { d: [rigid.d_i, rigid.d_s, rigid.d_o], sd, scale: Some(gyro.separation.scale_factor) }
}

impl Admission<'_> {
    /// Holds a calibration that is about to be entered against what is known. Earlier records whose times turn out to
    /// be in doubt are set aside in the group.
    pub(super) async fn check(&mut self, sent: &Calibration, group: &mut Group) -> Result<Checked, StoreError> {
        let at = sent.calibrated_at;
        let mut gyros = Vec::with_capacity(sent.gyros.len());
        for gyro in &sent.gyros {
            let number = self.number(NamesOf::Gyros, gyro.serial.as_str(), group);
            let around = match number {
                Some(number) => self.memory.around(self.store, number, at, group).await?,
                None => Around::default(),
            };
            let budget = self.judging.budget_of(sent.imu.as_str(), gyro.serial.as_str());
            gyros.push(Known { sent: gyro, number, around, budget });
        }
        let imu = self.number(NamesOf::Imus, sent.imu.as_str(), group);
        let mut notes = Vec::new();
        let nearest = gyros.iter().filter_map(|gyro| gyro.around.nearest(at)).min_by_key(|it| it.0.abs_diff(at.0));
        let in_doubt = self.doubt(at, imu, nearest).await?;
        notes.extend(in_doubt.map(HistoryNote::TimeInDoubt));
        if nearest.is_some_and(|nearest| at.days_since(nearest) > FAR_DAYS) {
            let records = self.doubt_earlier(&gyros, at, group).await?;
            if !records.is_empty() {
                notes.push(HistoryNote::OthersSetAside { records });
                gyros.iter_mut().for_each(|gyro| gyro.around = Around::default());
            }
        }
        if at.days_since(self.now) > AHEAD_DAYS {
            notes.push(HistoryNote::AheadOfNow { hours: at.days_since(self.now) * 24.0 });
        }
        self.check_names(sent, imu, &gyros, &mut notes, group).await?;
        self.check_figures(sent, imu, &gyros, &mut notes, group).await?;
        let notes = notes.into_iter().map(Note::History).collect();
        Ok(Checked { notes, set_aside: in_doubt.is_some() })
    }

    async fn doubt(
        &self,
        at: UtcMicros,
        imu: Option<u32>,
        of_gyros: Option<UtcMicros>,
    ) -> Result<Option<TimeDoubt>, StoreError> {
        let nearest = match (of_gyros, imu) {
            // What is set aside is among the IMU's records: it is no company.
            (None, Some(imu)) => {
                let newest = store::record::newest_of_imu(self.store, imu).await?;
                newest.filter(|newest| newest.days_since(at) > FAR_DAYS)
            }
            (of_gyros, _) => of_gyros,
        };
        Ok(doubt(at, self.epochs, nearest))
    }

    /// New names: what they look like, and who was in the slot before.
    async fn check_names(
        &self,
        sent: &Calibration,
        imu: Option<u32>,
        gyros: &[Known<'_>],
        notes: &mut Vec<HistoryNote>,
        group: &Group,
    ) -> Result<(), StoreError> {
        let station = self.number(NamesOf::Stations, sent.station.as_str(), group);
        for (of, table, name, number) in [
            (NameKind::Imu, NamesOf::Imus, &sent.imu, imu),
            (NameKind::Station, NamesOf::Stations, &sent.station, station),
        ] {
            let known = if number.is_none() { self.look_alike(table, name.as_str(), group) } else { None };
            notes.extend(known.map(|known| HistoryNote::LookAlike { of, name: name.to_string(), known }));
        }
        for Known { sent: gyro, .. } in gyros.iter().filter(|gyro| gyro.number.is_none()) {
            let serial = gyro.serial.to_string();
            let alike = self.look_alike(NamesOf::Gyros, &serial, group);
            if let Some(known) = alike.clone() {
                notes.push(HistoryNote::LookAlike { of: NameKind::Serial, name: serial.clone(), known });
            }
            let had = match imu {
                Some(imu) => self.occupant(imu, gyro.slot, sent.calibrated_at, group).await?,
                None => None,
            };
            if let Some(had) = had.map(|had| self.name_of(NamesOf::Gyros, had, group)) {
                let nearest = alike.or_else(|| self.nearest(&serial, &had, group));
                notes.push(HistoryNote::NewSerial { slot: gyro.slot, serial, had, nearest });
            }
        }
        Ok(())
    }

    /// The figures: seen before, of another gyro or unit of measurement; and where the gyro was.
    async fn check_figures(
        &self,
        sent: &Calibration,
        imu: Option<u32>,
        gyros: &[Known<'_>],
        notes: &mut Vec<HistoryNote>,
        group: &Group,
    ) -> Result<(), StoreError> {
        let mut identical: BTreeMap<(UtcMicros, Id), Vec<String>> = BTreeMap::new();
        for gyro in gyros {
            let same = gyro.number.and_then(|number| self.memory.identical(number, &gyro.shown()));
            if let Some(same) = same {
                identical.entry((same.at, same.record)).or_default().push(gyro.sent.serial.to_string());
            }
        }
        for ((at, record), serials) in identical {
            let record = Named { record: record.to_string(), at };
            notes.push(HistoryNote::IdenticalFigures { serials, record });
        }
        let mut exchanged = Vec::new();
        if !gyros.iter().all(Known::is_unremarkable) {
            let before: Vec<Vec<Shown>> =
                gyros.iter().map(|gyro| gyro.history().iter().map(|row| row.shown).collect()).collect();
            let looked: Vec<Looked<'_>> = gyros
                .iter()
                .zip(&before)
                .map(|(gyro, before)| Looked {
                    serial: gyro.sent.serial.as_str(),
                    now: gyro.shown(),
                    before,
                    budget: gyro.budget,
                })
                .collect();
            for note in against_histories(&looked) {
                if let HistoryNote::SerialsExchanged { fits } = &note {
                    exchanged.extend(fits.iter().map(|(serial, _)| serial.clone()));
                }
                let explained = matches!(note, HistoryNote::OtherUnit { .. })
                    && self.something_was_done(gyros, sent.calibrated_at, group).await?;
                if !explained {
                    notes.push(note);
                }
            }
        }
        for gyro in gyros.iter().filter(|gyro| !exchanged.iter().any(|serial| *serial == *gyro.sent.serial.as_str())) {
            let Some(last) = gyro.around.before.last() else { continue };
            if (Some(last.imu), last.slot) != (imu, gyro.sent.slot) {
                let from = Seat { imu: self.name_of(NamesOf::Imus, last.imu, group), slot: last.slot };
                let to = Seat { imu: sent.imu.to_string(), slot: gyro.sent.slot };
                notes.push(HistoryNote::Moved { serial: gyro.sent.serial.to_string(), from, to });
            }
        }
        Ok(())
    }

    /// Whether one of the gyros has been repaired, mounted anew or given a new baseline between the record and the
    /// one before it.
    async fn something_was_done(&self, gyros: &[Known<'_>], at: UtcMicros, group: &Group) -> Result<bool, StoreError> {
        for gyro in gyros {
            let (Some(number), Some(other)) = (gyro.number, gyro.history().last()) else { continue };
            let between = at.min(other.at)..=at.max(other.at);
            let stored = store::event::of_gyro(self.store, number).await?;
            let new = group.changes.events.iter().filter(|event| event.gyro == number);
            if stored.iter().chain(new).any(|it| it.event.resets_baseline() && between.contains(&it.at)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The gyro that was in a slot of an IMU before `at`.
    async fn occupant(&self, imu: u32, slot: Slot, at: UtcMicros, group: &Group) -> Result<Option<u32>, StoreError> {
        let here = group.changes.history.iter().map(|row| (row.figures.at, row.gyro, &row.figures));
        let here = here.filter(|(then, _, figures)| (figures.imu, figures.slot) == (imu, slot) && *then < at);
        if let Some((_, gyro, _)) = here.max_by_key(|(then, ..)| *then) {
            return Ok(Some(gyro));
        }
        for head in store::record::of_imu(self.store, imu, 3).await? {
            let (then, sheet) = (head.calibrated_at, store::record::verdict_sheet(self.store, head.id).await?);
            for (gyro, _) in sheet.filter(|_| then < at).into_iter().flat_map(|sheet| sheet.0) {
                let rows =
                    store::history::oldest(self.store, gyro, crate::core::time::Span { from: then, to: then }, 1)
                        .await?;
                if rows.iter().any(|row| row.record == head.id && row.slot == slot) {
                    return Ok(Some(gyro));
                }
            }
        }
        Ok(None)
    }

    fn look_alike(&self, table: NamesOf, name: &str, group: &Group) -> Option<String> {
        let stored = self.store.names().read().of(table).look_alike(name).map(ToString::to_string);
        stored.or_else(|| {
            let known = look_keys(name).into_iter().find_map(|key| group.looks.get(&(table, key)));
            known.filter(|known| *known != name).cloned()
        })
    }

    /// The known serial that is nearest to a new one; of several that of the slot.
    fn nearest(&self, serial: &str, had: &str, group: &Group) -> Option<String> {
        let tables = self.store.names().read();
        let stored = tables.gyros.iter().map(|(_, known)| &**known);
        let all = std::iter::once(had).chain(stored).chain(group.names(NamesOf::Gyros).keys().map(String::as_str));
        let most = SLIPS.min(serial.chars().count() / 3);
        let near = all.filter_map(|known| Some((distance(serial, known, most)?, known)));
        near.min_by_key(|(slips, _)| *slips).map(|(_, known)| known.to_owned())
    }

    pub(super) fn name_of(&self, table: NamesOf, number: u32, group: &Group) -> String {
        let stored = self.store.names().read().of(table).name(number).map(ToString::to_string);
        let new = || group.names(table).iter().find(|(_, other)| **other == number).map(|(name, _)| name.clone());
        stored.or_else(new).unwrap_or_default()
    }

    /// Sets aside the few records that the gyros have decades before `at`, where they are those of a clock that was
    /// never set: soon after one another, of these gyros alone, and confirmed by nobody.
    async fn doubt_earlier(
        &mut self,
        gyros: &[Known<'_>],
        at: UtcMicros,
        group: &mut Group,
    ) -> Result<Vec<Named>, StoreError> {
        let numbers: Vec<u32> = gyros.iter().filter_map(|gyro| gyro.number).collect();
        let mut earlier: BTreeMap<(UtcMicros, Id), bool> = BTreeMap::new();
        for number in &numbers {
            let stored =
                store::history::oldest(self.store, *number, crate::core::time::Span::EVER, FALSE_RECORDS + 1).await?;
            let stored =
                stored.iter().filter(|row| !group.withdraws(row.record)).map(|row| ((row.at, row.record), true));
            earlier.extend(stored);
            let new = group.changes.history.iter().filter(|row| row.gyro == *number);
            earlier.extend(new.map(|row| ((row.figures.at, row.figures.record), false)));
        }
        let ends = earlier.keys().next().zip(earlier.keys().next_back());
        let Some(((first, _), (last, _))) = ends else { return Ok(Vec::new()) };
        let few = earlier.len() <= FALSE_RECORDS && last.days_since(*first) <= FALSE_DAYS;
        if !few || at.days_since(*last) <= FAR_DAYS {
            return Ok(Vec::new());
        }
        let (nearest, mut named) = (at, Vec::new());
        let note = HistoryNote::TimeInDoubt(TimeDoubt::FarFromOthers { nearest });
        for ((then, id), is_stored) in earlier {
            let done = if is_stored {
                self.set_stored_aside(id, &numbers, &note, group).await?
            } else {
                group.set_new_aside(id, &numbers, &note)
            };
            if done {
                named.push(Named { record: id.to_string(), at: then });
            }
        }
        self.memory.forget_of(numbers);
        Ok(named)
    }

    async fn set_stored_aside(
        &mut self,
        id: Id,
        of: &[u32],
        note: &HistoryNote,
        group: &mut Group,
    ) -> Result<bool, StoreError> {
        let Some(record) = store::record::get(self.store, id).await? else { return Ok(false) };
        let others = record.verdicts.0.iter().any(|(gyro, _)| !of.contains(gyro));
        let is_confirmed = group.changes.confirmed.iter().any(|row| row.record == id);
        if others || is_confirmed || store::set_aside::confirmation(self.store, id).await?.is_some() {
            return Ok(false);
        }
        self.withdraw(&record, group).await?;
        let (author, reason) = (SERVICE.to_owned(), EARLIER_IN_DOUBT.to_owned());
        group.changes.set_aside.stored.push(StoredAside { record: id, author, reason });
        group.changes.rejudged.notes.push((id, history_note::with(record.notes.as_deref(), note)));
        Ok(true)
    }
}
