//! The verdicts of one record, packed with a checksum: what was decided, figure by figure, without the words.
//!
//! Words are made again from the history when somebody reads (they are ten times as long). Layout: version 2; then
//! for each gyro its number (4 bytes), how many verdicts (1), and each verdict as rule, coefficient, flags (1 byte
//! each), limit, and those of value, standard deviation and probability (8 each) that the flags announce; at the end
//! the CRC-32 of record number (8 bytes) and all before. Most limits of a sheet are alike: a limit is the place (1
//! byte) of the same one among those written out before, or 255 and itself (8). Version 1 wrote out each.

use crate::core::id::Id;
use crate::core::judge::{Coefficient, Finding, LimitKey, Rule, State, Status, Verdict};
use crate::store::error::{Result, StoreError};
use crate::store::packed::{Fields, checksum};

const VERSION: u8 = 2;
/// Every limit written out.
const FIRST_VERSION: u8 = 1;
/// In the place of a limit: it follows.
const NEW_LIMIT: u8 = u8::MAX;

/// A verdict as it was decided, see [`Verdict`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoredVerdict {
    pub coefficient: Coefficient,
    pub rule: Rule,
    pub state: State,
    pub value: Option<f64>,
    pub limit: f64,
    pub sd: Option<f64>,
    pub probability: Option<f64>,
    pub confirmed: bool,
}

impl From<&Verdict> for StoredVerdict {
    fn from(verdict: &Verdict) -> Self {
        let Verdict { coefficient, rule, state, value, limit, sd, probability, confirmed, .. } = *verdict;
        Self { coefficient, rule, state, value, limit, sd, probability, confirmed }
    }
}

impl StoredVerdict {
    pub fn status(&self) -> Status {
        Status::of(self.rule, self.state, self.value, self.limit, self.sd, self.confirmed)
    }

    /// The verdict without what its rule saw and where its limit came from, which are not kept: for alerts to follow
    /// it, never for its reason.
    pub fn without_words(&self) -> Verdict {
        let Self { coefficient, rule, state, value, limit, sd, probability, confirmed } = *self;
        let (finding, limit_from, between) = (Finding::TooFew { have: 0, need: 0 }, LimitKey::BUDGET, None);
        Verdict { coefficient, rule, state, value, limit, limit_from, sd, probability, between, confirmed, finding }
    }
}

/// The verdicts of one record by gyro number, in the order of the record's gyros.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordVerdicts(pub Vec<(u32, Vec<StoredVerdict>)>);

impl RecordVerdicts {
    pub fn states(&self) -> impl Iterator<Item = State> {
        self.0.iter().flat_map(|(_, verdicts)| verdicts).map(|verdict| verdict.state)
    }

    /// Those on one gyro; none where the record does not hold it.
    pub fn of(&self, gyro: u32) -> &[StoredVerdict] {
        self.0.iter().find(|(number, _)| *number == gyro).map_or(&[], |(_, verdicts)| verdicts)
    }

    /// Puts new verdicts in the place of those of `gyro`; false where the record does not hold it.
    pub fn replace(&mut self, gyro: u32, verdicts: Vec<StoredVerdict>) -> bool {
        let found = self.0.iter_mut().find(|(number, _)| *number == gyro);
        found.map(|(_, old)| *old = verdicts).is_some()
    }

    pub(crate) fn pack(&self, record: Id, out: &mut Vec<u8>) {
        let start = out.len();
        out.push(VERSION);
        let mut limits = WrittenLimits::default();
        for (gyro, verdicts) in &self.0 {
            out.extend(gyro.to_le_bytes());
            out.push(u8::try_from(verdicts.len()).expect("a gyro has a few dozen verdicts at most"));
            verdicts.iter().for_each(|verdict| pack_one(verdict, &mut limits, out));
        }
        out.extend(checksum(record.0.to_le_bytes(), &out[start..]).to_le_bytes());
    }

    /// # Errors
    /// [`StoreError::Damaged`] where the bytes are not what was packed for this record.
    pub(crate) fn unpack(record: Id, bytes: &[u8]) -> Result<Self> {
        Self::read(record, bytes)
            .ok_or_else(|| StoreError::damaged(format_args!("the verdicts of record {record} fail their checksum")))
    }

    fn read(record: Id, bytes: &[u8]) -> Option<Self> {
        let (content, sum) = bytes.split_last_chunk()?;
        if checksum(record.0.to_le_bytes(), content) != u32::from_le_bytes(*sum) {
            return None;
        }
        let (version, content) = content.split_first()?;
        let mut fields = Fields(content);
        let mut sheet = Self::default();
        let mut limits = match *version {
            FIRST_VERSION => None,
            VERSION => Some(WrittenLimits::default()),
            _ => return None,
        };
        while !fields.0.is_empty() {
            let gyro = u32::from_le_bytes(fields.take()?);
            let [count] = fields.take()?;
            let verdicts = (0..count).map(|_| read_one(&mut fields, limits.as_mut())).collect::<Option<_>>()?;
            sheet.0.push((gyro, verdicts));
        }
        Some(sheet)
    }
}

const CONFIRMED: u8 = 4;
const HAS_VALUE: u8 = 8;
const HAS_SD: u8 = 16;
const HAS_PROBABILITY: u8 = 32;

/// The limits of a sheet that have been written out, as many as a place can name.
#[derive(Debug, Default)]
struct WrittenLimits(Vec<f64>);

impl WrittenLimits {
    fn push(&mut self, limit: f64) {
        if self.0.len() < usize::from(NEW_LIMIT) {
            self.0.push(limit);
        }
    }

    fn pack(&mut self, limit: f64, out: &mut Vec<u8>) {
        if let Some(place) = self.0.iter().position(|known| known.to_bits() == limit.to_bits()) {
            out.push(place as u8);
        } else {
            out.push(NEW_LIMIT);
            out.extend(limit.to_le_bytes());
            self.push(limit);
        }
    }

    fn read(&mut self, fields: &mut Fields<'_>) -> Option<f64> {
        match fields.take()? {
            [NEW_LIMIT] => {
                let limit = f64::from_le_bytes(fields.take()?);
                self.push(limit);
                Some(limit)
            }
            [place] => self.0.get(usize::from(place)).copied(),
        }
    }
}

fn pack_one(verdict: &StoredVerdict, limits: &mut WrittenLimits, out: &mut Vec<u8>) {
    let flag = |set: bool, flag: u8| if set { flag } else { 0 };
    let flags = place(&State::ALL, verdict.state)
        | flag(verdict.confirmed, CONFIRMED)
        | flag(verdict.value.is_some(), HAS_VALUE)
        | flag(verdict.sd.is_some(), HAS_SD)
        | flag(verdict.probability.is_some(), HAS_PROBABILITY);
    out.extend([place(&Rule::ALL, verdict.rule), place(&Coefficient::ALL, verdict.coefficient), flags]);
    limits.pack(verdict.limit, out);
    for figure in [verdict.value, verdict.sd, verdict.probability].into_iter().flatten() {
        out.extend(figure.to_le_bytes());
    }
}

/// The codes are the places in the core's lists, which only ever grow at their ends (a test below pins them).
fn place<T: PartialEq>(all: &[T], one: T) -> u8 {
    all.iter().position(|other| *other == one).expect("the list holds every variant") as u8
}

/// `limits` are those read before; none where each is written out.
fn read_one(fields: &mut Fields<'_>, limits: Option<&mut WrittenLimits>) -> Option<StoredVerdict> {
    let [rule, coefficient, flags] = fields.take()?;
    let limit = match limits {
        Some(limits) => limits.read(fields)?,
        None => f64::from_le_bytes(fields.take()?),
    };
    let mut optional = |flag| match flags & flag {
        0 => Some(None),
        _ => fields.take().map(f64::from_le_bytes).map(Some),
    };
    Some(StoredVerdict {
        value: optional(HAS_VALUE)?,
        sd: optional(HAS_SD)?,
        probability: optional(HAS_PROBABILITY)?,
        rule: *Rule::ALL.get(usize::from(rule))?,
        coefficient: *Coefficient::ALL.get(usize::from(coefficient))?,
        state: *State::ALL.get(usize::from(flags & 3))?,
        confirmed: flags & CONFIRMED != 0,
        limit,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet() -> RecordVerdicts {
        let verdict = StoredVerdict {
            coefficient: Coefficient::DS,
            rule: Rule::Step,
            state: State::Exceeded,
            value: Some(0.0123),
            limit: 0.01,
            sd: None,
            probability: Some(0.99),
            confirmed: true,
        };
        let bare =
            StoredVerdict { value: None, probability: None, confirmed: false, state: State::Indeterminate, ..verdict };
        RecordVerdicts(vec![
            (7, vec![verdict, bare]),
            (8, vec![]),
            (9, vec![StoredVerdict { sd: Some(1e-4), ..verdict }]),
        ])
    }

    fn packed(sheet: &RecordVerdicts) -> Vec<u8> {
        let mut out = Vec::new();
        sheet.pack(Id(5), &mut out);
        out
    }

    #[test]
    fn verdicts_come_back_as_they_were_decided() {
        assert_eq!(RecordVerdicts::unpack(Id(5), &packed(&sheet())).unwrap(), sheet());
    }

    #[test]
    fn what_was_packed_before_limits_were_shared_is_still_read() {
        let step = [0, 1, 2 | CONFIRMED | HAS_VALUE];
        let mut old = vec![FIRST_VERSION];
        for gyro in [7_u32, 8] {
            old.extend(gyro.to_le_bytes());
            old.push(1);
            old.extend(step);
            old.extend(0.01_f64.to_le_bytes());
            old.extend(0.0123_f64.to_le_bytes());
        }
        old.extend(checksum(5_i64.to_le_bytes(), &old).to_le_bytes());
        let RecordVerdicts(mut expected) = sheet();
        expected.truncate(1);
        expected[0].1.truncate(1);
        expected[0].1[0].probability = None;
        expected.push((8, expected[0].1.clone()));
        assert_eq!(RecordVerdicts::unpack(Id(5), &old).unwrap(), RecordVerdicts(expected));
    }

    #[test]
    fn more_limits_than_a_place_can_name_come_back_too() {
        let [(_, verdicts), ..] = &sheet().0[..] else { panic!("a gyro") };
        let of = |from: usize| (from..from + 150).map(|k| StoredVerdict { limit: k as f64, ..verdicts[0] }).collect();
        let many = RecordVerdicts(vec![(1, of(0)), (2, of(150)), (3, of(200))]);
        assert_eq!(RecordVerdicts::unpack(Id(5), &packed(&many)).unwrap(), many);
    }

    #[test]
    fn every_flipped_bit_a_cut_and_another_record_are_found_out() {
        let good = packed(&sheet());
        assert!(RecordVerdicts::unpack(Id(6), &good).is_err());
        for bit in 0..good.len() * 8 {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(RecordVerdicts::unpack(Id(5), &bad).is_err(), "bit {bit}");
        }
        for len in 0..good.len() {
            assert!(RecordVerdicts::unpack(Id(5), &good[..len]).is_err(), "{len} bytes");
        }
    }

    #[test]
    fn the_stored_codes_never_change() {
        let known = "step range baseline trend cusum rms_successive closure agreement requirement overdue shift \
                     before_after station_shift forecast imu_shift batch_shift";
        assert_eq!(Rule::ALL.map(Rule::name)[..16].join(" "), known);
        assert_eq!(Coefficient::ALL.map(Coefficient::name)[..6], ["D_I", "D_S", "D_O", "E", "G", "all"]);
        assert_eq!(State::ALL.map(State::name), ["within", "indeterminate", "exceeded"]);
    }
}
