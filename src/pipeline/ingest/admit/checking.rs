//! A calibration held against what is known of its IMU and gyros: what is to be noted, and whether its time is in
//! doubt.

use super::lookup::{Admission, Lookup};
use super::overlapping::{Tested, overlapping};
use super::recent_records::{NearbyRecords, RecentRecord};
use crate::core::history_note::{
    EARLIER_IN_DOUBT, FAR_DAYS, HistoryNote, NameKind, NamedRecord, SERVICE, Seat, TimeDoubt, doubt, slipped_year,
};
use crate::core::own_history::{CheckedGyro, LEVEL_RECORDS, RecordFigures, UNCERTAINTY_FACTOR, against_histories};
use crate::core::suspect_window::SuspectWindow;
use crate::pipeline::ingest::submission::{CalibratedGyro, Calibration};
use crate::pipeline::prelude::*;
use crate::store::{NamesOf, SetAsideRecord};
use crate::wire::history_note;

/// A clock may be ahead of the service's by so much without a word, days.
const AHEAD_DAYS: f64 = 10.0 / 1440.0;
/// As near as this to its last record, in budgets, a gyro gives nothing to ask about.
const UNREMARKABLE_BUDGETS: f64 = 3.0;
const UNREMARKABLE_SCALE: f64 = 0.1;
/// A clock that was never set makes a few records, within so many days of one another.
const FALSE_RECORDS: usize = 64;
const FALSE_DAYS: f64 = 400.0;

/// What was found.
#[derive(Debug, Default)]
pub(super) struct Checked {
    pub notes: Vec<Note>,
    /// Its time is in doubt, or its station was suspect then: it is not to count before somebody confirms it.
    pub set_aside: bool,
}

/// A gyro of the record and what is known of it.
struct Known<'a> {
    sent: &'a CalibratedGyro,
    number: Option<u32>,
    around: NearbyRecords,
    budget: f64,
}

impl Known<'_> {
    fn shown(&self) -> RecordFigures {
        shown(self.sent)
    }

    /// What its figures are held against.
    fn history(&self) -> &[RecentRecord] {
        if self.around.before.is_empty() { &self.around.after } else { &self.around.before }
    }

    /// Whether its figures are so near to those of its last record and to its level that nothing can be found.
    fn is_unremarkable(&self) -> bool {
        let now = self.shown();
        let is_near = |then: &RecordFigures| {
            let near = (0..2).all(|i| (now.d[i] - then.d[i]).abs() <= UNREMARKABLE_BUDGETS * self.budget);
            let scale = now.scale.zip(then.scale).is_none_or(|(a, b)| (a / b - 1.0).abs() < UNREMARKABLE_SCALE);
            let stated = now.uncertainty().zip(then.uncertainty());
            near && scale && stated.is_none_or(|(a, b)| a.max(b) < UNCERTAINTY_FACTOR * a.min(b))
        };
        // Near to most of those that make the level is near to the level.
        self.history().iter().rev().take(LEVEL_RECORDS / 2 + 1).all(|row| is_near(&row.shown))
    }
}

pub(super) fn shown(gyro: &CalibratedGyro) -> RecordFigures {
    let rigid = &gyro.separation.rigid;
    let sd = rigid.sd().map(|[d_i, d_s, _]| [d_i, d_s]);
    RecordFigures { d: [rigid.d_i, rigid.d_s, rigid.d_o], sd, scale: Some(gyro.separation.scale_factor) }
}

/// A calibration that is held against what is known.
pub(super) struct Check<'c> {
    sent: &'c Calibration,
    imu: Option<u32>,
    gyros: Vec<Known<'c>>,
    notes: Vec<HistoryNote>,
}

impl<'c> Check<'c> {
    /// Holds a calibration that is about to be entered against what is known. Earlier records whose times turn out to
    /// be in doubt are set aside in the group.
    pub async fn of(sent: &'c Calibration, admission: &mut Admission<'_>) -> Result<Checked, StoreError> {
        let at = sent.calibrated_at;
        let mut gyros = Vec::with_capacity(sent.gyros.len());
        for gyro in &sent.gyros {
            let number = admission.known.number(NamesOf::Gyros, gyro.serial.as_str());
            let around = match number {
                Some(number) => {
                    admission.known.memory.around(admission.known.store, number, at, &admission.known.group).await?
                }
                None => NearbyRecords::default(),
            };
            let budget = admission.config.judging.budget_of(sent.imu.as_str(), gyro.serial.as_str());
            gyros.push(Known { sent: gyro, number, around, budget });
        }
        let imu = admission.known.number(NamesOf::Imus, sent.imu.as_str());
        let mut check = Self { sent, imu, gyros, notes: Vec::new() };
        let in_doubt = check.check_times(admission).await?.is_some();
        let is_suspect = check.check_window(&admission.known).await?;
        check.check_names(&admission.known).await?;
        check.check_figures(&admission.known).await?;
        if sent.kind == Kind::Campaign {
            let tested = check.gyros.iter();
            let tested = tested.filter_map(|one| Some((one.number?, one.sent.serial.as_str(), &one.around)));
            let tested: Vec<Tested<'_>> = tested.collect();
            let span = Span { from: at, to: sent.ends_at };
            check.notes.extend(overlapping(&mut admission.known, span, &tested).await?);
        }
        let notes = check.notes.into_iter().map(Note::History).collect();
        Ok(Checked { notes, set_aside: in_doubt || is_suspect })
    }

    /// Whether its own time is in doubt, or those of earlier records are.
    async fn check_times(&mut self, admission: &mut Admission<'_>) -> Result<Option<TimeDoubt>, StoreError> {
        let at = self.sent.calibrated_at;
        let nearest = self.gyros.iter().filter_map(|gyro| gyro.around.nearest(at)).min_by_key(|it| it.0.abs_diff(at.0));
        let in_doubt = self.doubt(nearest, admission).await?;
        self.notes.extend(in_doubt.map(HistoryNote::TimeInDoubt));
        if nearest.is_some_and(|nearest| at.days_since(nearest) > FAR_DAYS) {
            let records = self.doubt_earlier(admission).await?;
            if !records.is_empty() {
                self.notes.push(HistoryNote::OthersSetAside { records });
                self.gyros.iter_mut().for_each(|gyro| gyro.around = NearbyRecords::default());
            }
        }
        if at.days_since(admission.now) > AHEAD_DAYS {
            self.notes.push(HistoryNote::AheadOfNow { hours: at.days_since(admission.now) * 24.0 });
        }
        let newest = self.gyros.iter().filter_map(|gyro| admission.known.memory.newest_of(gyro.number?)).max();
        let slipped = newest.and_then(|newest| slipped_year(at, newest, admission.now));
        self.notes.extend(slipped.map(|year| HistoryNote::YearInDoubt { year }));
        Ok(in_doubt)
    }

    /// Whether it lies in a window in which its station is suspect.
    async fn check_window(&mut self, lookup: &Lookup<'_>) -> Result<bool, StoreError> {
        let Some(station) = lookup.number(NamesOf::Stations, self.sent.station.as_str()) else { return Ok(false) };
        let window = lookup.suspect_window(station, self.sent.calibrated_at).await?;
        let is_suspect = window.is_some();
        self.notes.extend(window.map(|SuspectWindow { author, reason, .. }| {
            let station = self.sent.station.to_string();
            HistoryNote::Suspect { station, author, reason }
        }));
        Ok(is_suspect)
    }

    async fn doubt(
        &self,
        of_gyros: Option<UtcMicros>,
        admission: &Admission<'_>,
    ) -> Result<Option<TimeDoubt>, StoreError> {
        let at = self.sent.calibrated_at;
        let nearest = match (of_gyros, self.imu) {
            // What is set aside is among the IMU's records: it is no company.
            (None, Some(imu)) => {
                let newest = store::record::newest_of_imu(admission.known.store, imu).await?;
                newest.filter(|newest| newest.days_since(at) > FAR_DAYS)
            }
            (of_gyros, _) => of_gyros,
        };
        Ok(doubt(at, &admission.config.plausibility.clock_epochs, nearest))
    }

    /// New names: what they look like, and who was in the slot before.
    async fn check_names(&mut self, known: &Lookup<'_>) -> Result<(), StoreError> {
        let Self { sent, imu, gyros, notes } = self;
        let imu = *imu;
        let names = [(NameKind::Imu, sent.imu.as_str()), (NameKind::Station, sent.station.as_str())];
        notes.extend(known.look_alikes(&names));
        for Known { sent: gyro, .. } in gyros.iter().filter(|gyro| gyro.number.is_none()) {
            let serial = gyro.serial.to_string();
            let alike = known.look_alike(NamesOf::Gyros, &serial);
            if let Some(known) = alike.clone() {
                notes.push(HistoryNote::LookAlike { of: NameKind::Serial, name: serial.clone(), known });
            }
            let had = match imu {
                Some(imu) => known.occupant(imu, gyro.slot, sent.calibrated_at).await?,
                None => None,
            };
            if let Some(had) = had.map(|had| known.name_of(NamesOf::Gyros, had)) {
                let nearest = alike.or_else(|| known.nearest(&serial, &had));
                notes.push(HistoryNote::NewSerial { slot: gyro.slot, serial, had, nearest });
            }
        }
        Ok(())
    }

    /// The figures: seen before, of another gyro or unit of measurement; and where the gyro was.
    async fn check_figures(&mut self, known: &Lookup<'_>) -> Result<(), StoreError> {
        let Self { sent, imu, gyros, notes } = self;
        let mut identical: BTreeMap<(UtcMicros, Id), Vec<String>> = BTreeMap::new();
        for gyro in gyros.iter() {
            let same = gyro.number.and_then(|number| known.memory.identical(number, &gyro.shown()));
            if let Some(same) = same {
                identical.entry((same.at, same.record)).or_default().push(gyro.sent.serial.to_string());
            }
        }
        for ((at, record), serials) in identical {
            let record = NamedRecord { record: record.to_string(), at };
            notes.push(HistoryNote::IdenticalFigures { serials, record });
        }
        let mut exchanged = Vec::new();
        if !gyros.iter().all(Known::is_unremarkable) {
            let before: Vec<Vec<RecordFigures>> =
                gyros.iter().map(|gyro| gyro.history().iter().map(|row| row.shown).collect()).collect();
            let looked: Vec<CheckedGyro<'_>> = gyros
                .iter()
                .zip(&before)
                .map(|(gyro, before)| CheckedGyro {
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
                let explained = matches!(note, HistoryNote::OtherUnit { .. } | HistoryNote::AnotherGyro { .. })
                    && something_was_done(gyros, sent.calibrated_at, known).await?;
                if !explained {
                    notes.push(note);
                }
            }
        }
        for gyro in gyros.iter().filter(|gyro| !exchanged.iter().any(|serial| *serial == *gyro.sent.serial.as_str())) {
            let Some(last) = gyro.around.before.last() else { continue };
            if (Some(last.imu), last.slot) != (*imu, gyro.sent.slot) {
                let from = Seat { imu: known.name_of(NamesOf::Imus, last.imu), slot: last.slot };
                let to = Seat { imu: sent.imu.to_string(), slot: gyro.sent.slot };
                notes.push(HistoryNote::Moved { serial: gyro.sent.serial.to_string(), from, to });
            }
        }
        Ok(())
    }

    /// Sets aside the few records that the gyros have decades before `at`, where they are those of a clock that was
    /// never set: soon after one another, of these gyros alone, and confirmed by nobody.
    async fn doubt_earlier(&self, admission: &mut Admission<'_>) -> Result<Vec<NamedRecord>, StoreError> {
        let at = self.sent.calibrated_at;
        let numbers: Vec<u32> = self.gyros.iter().filter_map(|gyro| gyro.number).collect();
        let mut earlier: BTreeMap<(UtcMicros, Id), bool> = BTreeMap::new();
        for number in &numbers {
            let stored = store::history::oldest(admission.known.store, *number, Span::EVER, FALSE_RECORDS + 1).await?;
            let stored = stored
                .iter()
                .filter(|row| !admission.known.group.withdraws(row.record))
                .map(|row| ((row.at, row.record), true));
            earlier.extend(stored);
            let new = admission.known.group.changes.history.iter().filter(|row| row.gyro == *number);
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
                set_stored_aside(id, &numbers, &note, admission).await?
            } else {
                admission.known.group.set_new_aside(id, &numbers, &note)
            };
            if done {
                named.push(NamedRecord { record: id.to_string(), at: then });
            }
        }
        admission.known.memory.forget_of(numbers);
        Ok(named)
    }
}

async fn set_stored_aside(
    id: Id,
    of: &[u32],
    note: &HistoryNote,
    admission: &mut Admission<'_>,
) -> Result<bool, StoreError> {
    let Some(record) = store::record::get(admission.known.store, id).await? else { return Ok(false) };
    let others = record.verdicts.0.iter().any(|(gyro, _)| !of.contains(gyro));
    let is_confirmed = admission.known.group.changes.confirmed.iter().any(|row| row.record == id);
    if others || is_confirmed || store::set_aside::confirmation(admission.known.store, id).await?.is_some() {
        return Ok(false);
    }
    admission.withdraw(&record).await?;
    let (author, reason) = (SERVICE.to_owned(), EARLIER_IN_DOUBT.to_owned());
    admission.known.group.changes.set_aside.stored.push(SetAsideRecord { record: id, author, reason });
    admission.known.group.changes.rejudged.notes.push((id, history_note::with(record.notes.as_deref(), note)));
    Ok(true)
}

/// Whether one of the gyros has been repaired, mounted anew or given a new baseline between the record and the
/// one before it.
async fn something_was_done(gyros: &[Known<'_>], at: UtcMicros, known: &Lookup<'_>) -> Result<bool, StoreError> {
    for gyro in gyros {
        let (Some(number), Some(other)) = (gyro.number, gyro.history().last()) else { continue };
        let between = at.min(other.at)..=at.max(other.at);
        let stored = store::event::of_gyro(known.store, number).await?;
        let new = known.group.changes.events.iter().filter(|event| event.gyro == number);
        if stored.iter().chain(new).any(|it| it.told.event.resets_baseline() && between.contains(&it.told.at)) {
            return Ok(true);
        }
    }
    Ok(false)
}
