//! Computes again, from what stations sent, everything that was stored about it, and compares.
//!
//! The checksums tell whether a figure is the one that was written; this tells whether it is the right one. Verdicts
//! are decided again with the limits of the configuration in force: of a record that was judged with other limits,
//! the verdicts cannot be compared, and are counted; so are those on records that count no more.

use std::fmt::Display;

use crate::core::figures::near;
use crate::core::judge::history::Need;
use crate::core::judge::{Older, State};
use crate::core::name::normal_form;
use crate::pipeline::ingest::admit::figures_of;
use crate::pipeline::ingest::judge::gyro_window::GyroWindow;
use crate::pipeline::prelude::*;
use crate::pipeline::queries::heads::{checksum, stored_rows};
use crate::pipeline::queries::record::{DecodedRecord, Records};
use crate::pipeline::{CalibratedGyro, Calibration};
use crate::store::{StoredVerdict, Table};
use crate::wire::bench::parse_bench_result;

/// What was computed again.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Verified {
    pub records: usize,
    pub separations: usize,
    pub verdicts: usize,
    pub bench_results: usize,
    /// Gyros whose row in the table `head` was compared; none where those were made with other limits than those in
    /// force.
    pub heads: Option<usize>,
    /// Verdicts that were decided with other limits than those in force, on records that count no more, or by an earlier
    /// version to which uncertainty exceeded.
    pub not_compared: usize,
    /// Which record and what about it. Empty where everything is right.
    pub faults: Vec<Message>,
}

/// Versions up to 0.1 left the turn of a fitted input axis out of the standard deviations of a bench test's dwells:
/// what they stored is smaller, by no more than this.
const LEAST_OF_SD: f64 = 0.5;
/// Gyros whose standing is looked at together.
const HEADS_AT_ONCE: usize = 256;

impl Records {
    /// Computes everything again. Takes as long as there are records: about a millisecond a campaign, less a record.
    ///
    /// # Errors
    /// [`StoreError`] where something cannot be read at all; what differs is in [`Verified::faults`].
    pub async fn verify(&self) -> Result<Verified, StoreError> {
        let mut verified = Verified::default();
        for id in store::record::ids(&self.store).await? {
            verified.records += 1;
            match self.reread(id).await {
                Ok(Some(stored)) => self.verify_record(&stored, &mut verified).await?,
                Ok(None) => verified.faults.push(of_record(id, message!("in_index_only"))),
                Err(StoreError::Damaged(what)) => verified.faults.push(what),
                Err(error) => return Err(error),
            }
        }
        self.verify_benches(&mut verified).await?;
        self.verify_heads(&mut verified).await?;
        Ok(verified)
    }

    /// Every gyro stands in lists as what is stored says.
    async fn verify_heads(&self, verified: &mut Verified) -> Result<(), StoreError> {
        let made = store::head::made(&self.store).await?;
        if made.limits != checksum(&self.config.judging) || made.through.is_some() {
            return Ok(());
        }
        let gyros = self.store.names().read().gyros.numbers();
        for some in gyros.chunks(HEADS_AT_ONCE) {
            let found = store::head::of_gyros(&self.store, some).await?;
            for expected in stored_rows(&self.store, &self.config.judging, some).await? {
                let serial = &expected.serial;
                match found.iter().find(|row| row.gyro == expected.gyro) {
                    None => verified.faults.push(of_gyro(serial, message!("head_missing"))),
                    Some(row) if !row.agrees(&expected) => {
                        let (found, expected) = (format_args!("{row:?}"), format_args!("{expected:?}"));
                        verified.faults.push(of_gyro(serial, message!("head_differs", found, expected)));
                    }
                    Some(_) => {}
                }
            }
        }
        verified.heads = Some(gyros.len());
        Ok(())
    }

    async fn verify_record(&self, stored: &DecodedRecord, verified: &mut Verified) -> Result<(), StoreError> {
        let DecodedRecord { row, calibration: again, .. } = stored;
        let (id, counts) = (row.id, !row.voided);
        let names = self.store.names();
        let wrong = |fault| of_record(id, fault);
        let (imu, station) = (name(&names.read().imus, row.imu), name(&names.read().stations, row.station));
        if normal_form(&imu) != again.imu.as_str() {
            verified.faults.push(wrong(message!("under_other_imu", stored = imu, sent = text(&again.imu))));
        }
        if normal_form(&station) != again.station.as_str() {
            verified.faults.push(wrong(message!("under_other_station", stored = station, sent = text(&again.station))));
        }
        if row.calibrated_at != again.calibrated_at {
            verified.faults.push(wrong(message!("under_other_time")));
        }
        // A campaign that cannot be fitted with the model in force, or has other gyros by it, stays as it came.
        let places = |of: &Calibration| of.gyros.iter().map(|gyro| gyro.place).collect::<Vec<_>>();
        let by_model_in_force = self.reader.restated_anew(again).filter(|anew| counts && places(anew) == places(again));
        for gyro in by_model_in_force.iter().flat_map(|anew| &anew.gyros) {
            let figures = |of: &CalibratedGyro| figures_of(&of.separation, id, row.calibrated_at, row.imu, row.station);
            let was = again.gyros.iter().find(|was| was.place == gyro.place);
            if was.is_some_and(|was| difference(&figures(was), &figures(gyro)).is_some()) {
                verified.faults.push(wrong(of_gyro(&gyro.serial, message!("not_of_model_in_force"))));
            }
        }
        for gyro in &again.gyros {
            let serial = gyro.serial.as_str();
            let wrong = |fault| wrong(of_gyro(serial, fault));
            let number = names.read().gyros.number(serial);
            let at = Span { from: row.calibrated_at, to: row.calibrated_at };
            let stored = match number {
                Some(number) if counts => store::history::oldest(&self.store, number, at, 1).await?.pop(),
                Some(number) => {
                    store::history::voided(&self.store, number, at).await?.into_iter().find(|row| row.record == id)
                }
                None => None,
            };
            verified.separations += 1;
            let computed = figures_of(&gyro.separation, id, row.calibrated_at, row.imu, row.station);
            match stored {
                None => verified.faults.push(wrong(message!("history_missing"))),
                Some(stored) => verified.faults.extend(difference(&stored, &computed).map(wrong)),
            }
            let of_it = row.verdicts.0.iter().find(|(of, _)| Some(*of) == number);
            let Some((number, decided)) = of_it else {
                verified.faults.push(wrong(message!("verdicts_missing")));
                continue;
            };
            if !counts {
                // They stay as they were decided; others have been judged without it since.
                verified.not_compared += decided.len();
                continue;
            }
            let (limits, method) = (self.config.judging.limits(again.imu.as_str(), serial), self.config.judging.method);
            let line = GyroWindow::load(&self.store, *number, row.calibrated_at, Need::of(&limits), method).await?;
            let judged = line.judge_newest(&limits, Older::NONE);
            let states = crate::pipeline::ingest::judge::states(&judged);
            let expected: Vec<StoredVerdict> =
                judged.iter().chain(gyro.requirements.iter().flatten()).map(StoredVerdict::from).collect();
            verified.verdicts += decided.len();
            if !same_limits(decided, &expected) {
                verified.not_compared += decided.len();
                continue;
            }
            let computed = |stored: &StoredVerdict| expected.iter().find(|computed| same_rule(stored, computed));
            let exceeded_before =
                |stored: &&StoredVerdict| computed(stored).is_some_and(|now| uncertainty_exceeded(stored, now));
            let (of_earlier_version, compared): (Vec<_>, Vec<_>) = decided.iter().partition(exceeded_before);
            verified.not_compared += of_earlier_version.len();
            for stored in compared {
                let computed = computed(stored);
                if computed.is_none_or(|computed| !same(stored, computed)) {
                    let (rule, coefficient) = (stored.rule.name(), stored.coefficient.name());
                    let again = computed.map_or_else(|| "-".to_owned(), |computed| format!("{computed:?}"));
                    let stored = format_args!("{stored:?}");
                    verified.faults.push(wrong(message!("verdict_differs", rule, coefficient, stored, again)));
                }
            }
            if of_earlier_version.is_empty() && stored.is_some_and(|stored| stored.states != states) {
                verified.faults.push(wrong(message!("state_differs")));
            }
        }
        Ok(())
    }

    async fn verify_benches(&self, verified: &mut Verified) -> Result<(), StoreError> {
        let gyros = self.store.names().read().gyros.numbers();
        for gyro in gyros {
            for row in store::bench::of_gyro(&self.store, gyro, Span::EVER).await? {
                verified.bench_results += 1;
                let sent = match parse_bench_result(row.body.as_bytes(), f64::INFINITY) {
                    Ok(result) => Some(([result.d_i, result.d_s], [result.d_i_sd, result.d_s_sd], 1.0)),
                    Err(_) => self.reader.fitted_bench(&row.body).ok().map(|fitted| {
                        let d = [fitted.d_i_deg_per_h_g0, fitted.d_s_deg_per_h_g0];
                        (d, [fitted.d_i_sd, fitted.d_s_sd], LEAST_OF_SD)
                    }),
                };
                let wrong = |fault| message!("fault_of_bench_result", id = text(row.id), fault);
                match sent {
                    None => verified.faults.push(wrong(message!("text_unreadable"))),
                    Some((d, sd, least)) => {
                        let values = d.iter().zip(&row.d).all(|(a, b)| near(*a, *b));
                        let sds = sd.iter().zip(&row.sd).all(|(a, b)| {
                            let within = a.zip(*b).is_some_and(|(a, b)| (least * a..=a).contains(&b));
                            within || near_or_none(*a, *b)
                        });
                        if !(values && sds) {
                            let (stored, sent) = (format_args!("{:?}", row.d), format_args!("{d:?}"));
                            verified.faults.push(wrong(message!("bench_differs", stored, sent)));
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

fn of_record(id: Id, fault: Message) -> Message {
    message!("fault_of_record", id = text(id), fault)
}

fn of_gyro(serial: impl Display, fault: Message) -> Message {
    message!("fault_of_gyro", serial = text(serial), fault)
}

fn name(table: &Table, number: u32) -> String {
    table.name(number).map_or_else(|| format!("number {number}"), ToString::to_string)
}

/// What of the stored figures is not as computed, but for the states, which are the verdicts'.
fn difference(stored: &Figures, computed: &Figures) -> Option<Message> {
    let head = |figures: &Figures| (figures.record, figures.imu, figures.station, figures.slot, figures.at);
    if head(stored) != head(computed) {
        return Some(message!("history_of_another"));
    }
    let figures =
        || message!("figures_differ", stored = format_args!("{stored:?}"), again = format_args!("{computed:?}"));
    (!stored.agrees(computed)).then(figures)
}

fn same_rule(a: &StoredVerdict, b: &StoredVerdict) -> bool {
    (a.rule, a.coefficient) == (b.rule, b.coefficient)
}

/// Whether both were decided with the same limits, as far as verdicts hold them.
fn same_limits(decided: &[StoredVerdict], expected: &[StoredVerdict]) -> bool {
    // The limit of a shift is three of its standard deviations where those are more: that is a figure, and compared
    // as one.
    let same = |a: &StoredVerdict, b: &StoredVerdict| a.rule == Rule::Shift || near(a.limit, b.limit);
    let found = |verdict: &StoredVerdict, among: &[StoredVerdict]| {
        among.iter().any(|other| same_rule(verdict, other) && same(verdict, other))
    };
    decided.iter().all(|verdict| found(verdict, expected)) && expected.iter().all(|verdict| found(verdict, decided))
}

fn same(a: &StoredVerdict, b: &StoredVerdict) -> bool {
    let figures = |v: &StoredVerdict| [v.value, Some(v.limit), v.sd, v.probability];
    let near = figures(a).into_iter().zip(figures(b)).all(|(a, b)| near_or_none(a, b));
    (a.state, a.confirmed) == (b.state, b.confirmed) && near
}

/// Whether an earlier version decided it, to which a figure that may lie beyond either limit exceeded one.
fn uncertainty_exceeded(stored: &StoredVerdict, computed: &StoredVerdict) -> bool {
    let StoredVerdict { state, confirmed, .. } = *stored;
    (state, computed.state) == (State::Exceeded, State::Indeterminate)
        && stored.sd.is_some_and(|sd| sd > stored.limit)
        && same(stored, &StoredVerdict { state, confirmed, ..*computed })
}

fn near_or_none(a: Option<f64>, b: Option<f64>) -> bool {
    a.zip(b).map_or(a.is_none() && b.is_none(), |(a, b)| near(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::Coefficient;

    #[test]
    fn what_uncertainty_exceeded_in_an_earlier_version_is_no_fault() {
        let computed = StoredVerdict {
            coefficient: Coefficient::DI,
            rule: Rule::Step,
            state: State::Indeterminate,
            value: Some(0.56),
            limit: 0.01,
            sd: Some(1.0),
            probability: Some(0.993),
            confirmed: false,
        };
        let before = StoredVerdict { state: State::Exceeded, ..computed };
        assert!(uncertainty_exceeded(&before, &computed));
        for other in [
            StoredVerdict { state: State::Within, ..computed },
            StoredVerdict { value: Some(0.57), ..before },
            StoredVerdict { sd: Some(0.005), ..before },
        ] {
            assert!(!uncertainty_exceeded(&other, &StoredVerdict { sd: other.sd, ..computed }), "{other:?}");
        }
    }
}
