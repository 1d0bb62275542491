//! What is remembered of gyros, so that a new record is held against their histories without asking the database each
//! time.

use std::collections::hash_map::Entry;

use super::group::Group;
use crate::core::mounting::Slot;
use crate::core::own_history::RecordFigures;
use crate::core::suspect_window::Mark;
use crate::pipeline::prelude::*;

/// Newest records of a gyro that are read, and how many more may gather before the oldest are forgotten.
const REMEMBERED: usize = 32;
/// Records before one that it is held against.
const BEFORE: usize = 8;
/// Gyros from which on everything is forgotten, about 3 kB each.
const MOST_GYROS: usize = 20_000;

/// The newest records of the gyros that have been seen, those included that are not stored yet.
#[derive(Debug, Default)]
pub(crate) struct RecentRecords {
    gyros: HashMap<u32, GyroRecords>,
    /// How the windows of stations are marked, where nobody else marks any.
    marks: HashMap<u32, Vec<Mark>>,
}

/// One gyro's newest records, oldest first.
#[derive(Debug, Default)]
struct GyroRecords {
    rows: Vec<RecentRecord>,
    /// Whether there are none before them.
    whole: bool,
}

impl GyroRecords {
    /// Of stored rows, oldest first, before which there are none where they are the `whole` of them.
    fn of(stored: &[Figures], whole: bool) -> Self {
        let newest = &stored[stored.len().saturating_sub(REMEMBERED)..];
        Self { rows: newest.iter().map(RecentRecord::from).collect(), whole: whole && newest.len() == stored.len() }
    }
}

/// A gyro in one of its records.
#[derive(Debug, Clone, Copy)]
pub(super) struct RecentRecord {
    pub at: UtcMicros,
    pub record: Id,
    pub imu: u32,
    pub slot: Slot,
    pub shown: RecordFigures,
    /// When its last dwell ended; none where that is not remembered.
    pub ends_at: Option<UtcMicros>,
}

impl From<&Figures> for RecentRecord {
    fn from(figures: &Figures) -> Self {
        let sd = figures.rigid_sd.map(|[d_i, d_s, _]| [d_i, d_s]);
        let shown = RecordFigures { d: figures.rigid, sd, scale: None };
        Self { at: figures.at, record: figures.record, imu: figures.imu, slot: figures.slot, shown, ends_at: None }
    }
}

/// A gyro's records about an instant.
#[derive(Debug, Default)]
pub(super) struct NearbyRecords {
    /// The last few before it, the newest last.
    pub before: Vec<RecentRecord>,
    /// The first few after it, the newest first; looked for only where there are none before.
    pub after: Vec<RecentRecord>,
    /// The first at it or after it.
    pub next: Option<RecentRecord>,
}

impl NearbyRecords {
    pub fn nearest(&self, at: UtcMicros) -> Option<UtcMicros> {
        let all = self.before.iter().chain(&self.after).map(|row| row.at);
        all.min_by_key(|other| other.0.abs_diff(at.0))
    }
}

impl RecentRecords {
    /// Forgets everything: what is remembered is not what was stored.
    pub fn forget(&mut self) {
        self.gyros.clear();
        self.marks.clear();
    }

    /// The stored marks of a station's windows, oldest first, where they are remembered.
    pub(super) fn marks(&self, station: u32) -> Option<&[Mark]> {
        self.marks.get(&station).map(Vec::as_slice)
    }

    /// Takes in the stored marks of stations. Whoever shares the database with other writers does not: they mark windows too.
    pub fn take_in_marks(&mut self, read: &HashMap<u32, Vec<Mark>>) {
        self.marks.extend(read.iter().map(|(station, marks)| (*station, marks.clone())));
    }

    /// Of a station that has just been marked.
    pub(super) fn forget_marks(&mut self, station: u32) {
        self.marks.remove(&station);
    }

    pub fn forget_of(&mut self, gyros: impl IntoIterator<Item = u32>) {
        gyros.into_iter().for_each(|gyro| drop(self.gyros.remove(&gyro)));
    }

    /// Takes in what is stored of gyros that are not remembered yet: the newest rows of each, and whether there are
    /// no others.
    pub fn take_in<'a>(&mut self, read: impl Iterator<Item = (u32, &'a [Figures], bool)>) {
        for (gyro, rows, whole) in read {
            self.gyros.entry(gyro).or_insert_with(|| GyroRecords::of(rows, whole));
        }
    }

    /// As [`RecentRecords::forget_of`], of those that `lost` names.
    pub fn forget_where(&mut self, lost: impl Fn(u32) -> bool) {
        self.gyros.retain(|gyro, _| !lost(*gyro));
    }

    /// When a gyro's newest record that counts was made, where that is remembered and there is one.
    pub fn newest_of(&self, gyro: u32) -> Option<UtcMicros> {
        self.gyros.get(&gyro)?.rows.last().map(|row| row.at)
    }

    /// Whether a gyro is known to have no record at `at` or after it that counts.
    pub(super) fn is_newer(&self, gyro: u32, at: UtcMicros) -> bool {
        self.gyros.get(&gyro).is_some_and(|ring| ring.rows.last().map_or(ring.whole, |row| row.at < at))
    }

    pub fn knows(&self, gyro: u32) -> bool {
        self.gyros.contains_key(&gyro)
    }

    pub fn is_full(&self) -> bool {
        self.gyros.len() > MOST_GYROS
    }

    /// Reads what is stored of a gyro, and adds what the group holds of it.
    async fn recall(&mut self, store: &Store, gyro: u32, group: &Group) -> Result<&mut GyroRecords, StoreError> {
        let unseen = match self.gyros.entry(gyro) {
            Entry::Occupied(seen) => return Ok(seen.into_mut()),
            Entry::Vacant(unseen) => unseen,
        };
        let is_new = group.changes.gyros.iter().any(|new| new.number == gyro);
        let stored =
            if is_new { Vec::new() } else { store::history::newest(store, gyro, Span::EVER, REMEMBERED).await? };
        let whole = stored.len() < REMEMBERED;
        let counts = |figures: &&Figures| !group.withdraws(figures.record);
        let mut rows: Vec<RecentRecord> = stored.iter().filter(counts).map(RecentRecord::from).collect();
        let of_group = group.changes.history.iter().filter(|row| row.gyro == gyro);
        rows.extend(of_group.map(|row| RecentRecord::from(&row.figures)));
        rows.sort_by_key(|row| row.at);
        Ok(unseen.insert(GyroRecords { rows, whole }))
    }

    /// What is known of a gyro about `at`.
    pub(super) async fn around(
        &mut self,
        store: &Store,
        gyro: u32,
        at: UtcMicros,
        group: &Group,
    ) -> Result<NearbyRecords, StoreError> {
        let ring = self.recall(store, gyro, group).await?;
        let place = ring.rows.partition_point(|row| row.at < at);
        let mut around = NearbyRecords {
            before: ring.rows[place.saturating_sub(BEFORE)..place].to_vec(),
            after: Vec::new(),
            next: ring.rows.get(place).copied(),
        };
        if place == 0 && !ring.whole {
            let upto = Span { to: UtcMicros(at.0 - 1), ..Span::EVER };
            let stored = store::history::newest(store, gyro, upto, BEFORE).await?;
            around.before = stored.iter().filter(|row| !group.withdraws(row.record)).map(RecentRecord::from).collect();
            let stored = store::history::oldest(store, gyro, Span { from: at, ..Span::EVER }, BEFORE).await?;
            around.next = stored.iter().find(|row| !group.withdraws(row.record)).map(RecentRecord::from);
        }
        if around.before.is_empty() {
            around.after = ring.rows[place..].iter().take(BEFORE).rev().copied().collect();
        }
        Ok(around)
    }

    /// The remembered record of a gyro with the very same figures.
    pub(super) fn identical(&self, gyro: u32, shown: &RecordFigures) -> Option<RecentRecord> {
        let bits = |d: [f64; 3]| d.map(f64::to_bits);
        let same_scale =
            |other: &RecordFigures| shown.scale.zip(other.scale).is_none_or(|(a, b)| a.to_bits() == b.to_bits());
        let mut rows = self.gyros.get(&gyro)?.rows.iter();
        rows.find(|row| bits(row.shown.d) == bits(shown.d) && same_scale(&row.shown)).copied()
    }

    /// Remembers when the last dwell of a record ended.
    pub(super) fn note_end(&mut self, gyro: u32, record: Id, ends_at: UtcMicros) {
        let rows = self.gyros.get_mut(&gyro).into_iter().flat_map(|ring| &mut ring.rows);
        rows.filter(|row| row.record == record).for_each(|row| row.ends_at = Some(ends_at));
    }

    /// Adds a record that has been admitted, of a gyro that was asked for, or is new.
    pub(super) fn add(&mut self, gyro: u32, row: RecentRecord) {
        let ring = self.gyros.entry(gyro).or_insert_with(|| GyroRecords { rows: Vec::new(), whole: true });
        let place = ring.rows.partition_point(|there| there.at <= row.at);
        if place == 0 && !ring.whole {
            return;
        }
        ring.rows.insert(place, row);
        if ring.rows.len() > 2 * REMEMBERED {
            ring.rows.drain(..REMEMBERED);
            ring.whole = false;
        }
    }
}
