//! One history row's figures, packed: what a gyro's record says of it, with a checksum over all of it.
//!
//! Packed because reading dominates: a driver hands a row over value by value, while a thousand packed rows come out
//! of the database as one value, twenty times as fast (docs/performance.md). Little-endian throughout:
//!
//! | bytes | what |
//! |---|---|
//! | 0 | version, 1 |
//! | 1 | slot, 0 to 2 |
//! | 2 | number of the published equation, 8 to 13; 0 where the method is not defined |
//! | 3 | states of D_I, D_S, D_O, two bits each: 0 not judged, 1 within, 2 indeterminate, 3 exceeded; bit 6: voided |
//! | 4-11 | numbers of the IMU and of the station |
//! | 12-27 | instant (us UTC) and record |
//! | 28-75 | rigid D_I, D_S, D_O and their standard deviations, deg/(h g0) |
//! | 76-115 | published D_I, D_S, closure, and standard deviations of D_I, D_S |
//! | 116-119 | CRC-32 of gyro number (4 bytes) and bytes 0-115 |
//!
//! A figure that is not known is stored as NaN.

use crate::core::figures::{Figures, PublishedFigures, States};
use crate::core::id::Id;
use crate::core::judge::State;
use crate::core::mounting::Slot;
use crate::core::time::UtcMicros;
use crate::store::batch::{Batch, OnConflict};
use crate::store::error::{Result, StoreError};
use crate::store::packed::{Fields, checksum};
use crate::store::rows::Rows;

/// What a record says of a gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryRow {
    pub gyro: u32,
    pub figures: Figures,
}

const COLUMNS: &str = "gyro, calibrated_at, record, figures";

/// Puts rows into their gyros' places; one that is there already is replaced.
pub(crate) fn upsert<'a>(history: impl IntoIterator<Item = &'a HistoryRow>, batch: &mut Batch) {
    batch.insert("history", COLUMNS, OnConflict::Set("gyro, calibrated_at", &["record", "figures"]), rows(history));
}

/// Puts rows among those that do not count.
pub(crate) fn void<'a>(history: impl IntoIterator<Item = &'a HistoryRow>, batch: &mut Batch) {
    batch.insert("voided_history", COLUMNS, OnConflict::Fail, rows(history));
}

fn rows<'a>(history: impl IntoIterator<Item = &'a HistoryRow>) -> Rows {
    Rows::each(history, |HistoryRow { gyro, figures }, row| {
        row.put(gyro).put(&figures.at).put(&figures.record).written(|out| figures.pack(*gyro, out));
    })
}

pub(crate) const PACKED_LEN: usize = 120;
const VERSION: u8 = 1;
/// In the byte of the states.
const VOIDED: u8 = 1 << 6;

impl States {
    fn packed(self) -> u8 {
        let code = |state| match state {
            None => 0,
            Some(State::Within) => 1,
            Some(State::Indeterminate) => 2,
            Some(State::Exceeded) => 3,
        };
        let [i, s, o] = self.0.map(code);
        i | s << 2 | o << 4
    }

    fn unpacked(byte: u8) -> Self {
        Self([0, 2, 4].map(|shift| match byte >> shift & 3 {
            0 => None,
            1 => Some(State::Within),
            2 => Some(State::Indeterminate),
            _ => Some(State::Exceeded),
        }))
    }
}

impl Figures {
    pub(crate) fn pack(&self, gyro: u32, out: &mut Vec<u8>) {
        let start = out.len();
        let published = self.published.as_ref();
        out.extend([
            VERSION,
            self.slot.index() as u8,
            published.map_or(0, |p| p.branch),
            self.states.packed() | if self.voided { VOIDED } else { 0 },
        ]);
        out.extend(self.imu.to_le_bytes());
        out.extend(self.station.to_le_bytes());
        out.extend(self.at.0.to_le_bytes());
        out.extend(self.record.0.to_le_bytes());
        let [p_i, p_s] = published.map_or([f64::NAN; 2], |p| p.d);
        let [p_i_sd, p_s_sd] = published.and_then(|p| p.sd).unwrap_or([f64::NAN; 2]);
        let closure = published.map_or(f64::NAN, |p| p.closure_rms);
        let sd = self.rigid_sd.unwrap_or([f64::NAN; 3]);
        for figure in self.rigid.into_iter().chain(sd).chain([p_i, p_s, closure, p_i_sd, p_s_sd]) {
            out.extend(figure.to_le_bytes());
        }
        out.extend(checksum(gyro.to_le_bytes(), &out[start..]).to_le_bytes());
    }

    /// # Errors
    /// [`StoreError::Damaged`] where the bytes are not what was packed for this gyro.
    pub(crate) fn unpack(gyro: u32, bytes: &[u8; PACKED_LEN]) -> Result<Self> {
        Self::read(gyro, bytes)
            .ok_or_else(|| StoreError::damaged(format_args!("a history row of gyro number {gyro} fails its checksum")))
    }

    fn read(gyro: u32, bytes: &[u8; PACKED_LEN]) -> Option<Self> {
        let (content, sum) = bytes.split_last_chunk()?;
        if checksum(gyro.to_le_bytes(), content) != u32::from_le_bytes(*sum) {
            return None;
        }
        let mut fields = Fields(content);
        let [version, slot, branch, states] = fields.take()?;
        let figures = Self {
            imu: u32::from_le_bytes(fields.take()?),
            station: u32::from_le_bytes(fields.take()?),
            at: UtcMicros(i64::from_le_bytes(fields.take()?)),
            record: Id(i64::from_le_bytes(fields.take()?)),
            slot: Slot::ALL[usize::from(slot).min(2)],
            rigid: fields.figures()?,
            rigid_sd: known(fields.figures()?),
            published: {
                let ([d_i, d_s, closure_rms], sd) = (fields.figures()?, known(fields.figures()?));
                (branch != 0).then_some(PublishedFigures { branch, d: [d_i, d_s], closure_rms, sd })
            },
            states: States::unpacked(states),
            voided: states & VOIDED != 0,
        };
        (version == VERSION).then_some(figures)
    }
}

fn known<const N: usize>(figures: [f64; N]) -> Option<[f64; N]> {
    figures.iter().all(|f| !f.is_nan()).then_some(figures)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures() -> Figures {
        Figures {
            at: UtcMicros(1_772_352_000_000_000),
            record: Id(77),
            imu: 3,
            station: 4,
            slot: Slot::G2,
            rigid: [0.688549, 3.898225, 0.232169],
            rigid_sd: None,
            published: Some(PublishedFigures {
                branch: 10,
                d: [0.688255, 3.898324],
                closure_rms: 0.13,
                sd: Some([1e-4, 2e-4]),
            }),
            states: States([Some(State::Within), Some(State::Exceeded), None]),
            voided: false,
        }
    }

    fn packed(figures: &Figures) -> [u8; PACKED_LEN] {
        let mut out = Vec::new();
        figures.pack(9, &mut out);
        out.try_into().unwrap()
    }

    #[test]
    fn figures_come_back_as_they_went_in() {
        let with_sd = Figures { rigid_sd: Some([1e-4, 2e-4, 3e-4]), published: None, ..figures() };
        for figures in [figures(), with_sd, Figures { voided: true, ..figures() }] {
            assert_eq!(Figures::unpack(9, &packed(&figures)).unwrap(), figures);
        }
    }

    #[test]
    fn every_flipped_bit_and_another_gyro_are_found_out() {
        let good = packed(&figures());
        assert!(Figures::unpack(8, &good).is_err());
        for bit in 0..PACKED_LEN * 8 {
            let mut bad = good;
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(Figures::unpack(9, &bad).is_err(), "bit {bit}");
        }
    }
}
