//! A record's figures against the histories of the gyros that it names: whose figures are they, and in which unit?
//!
//! D_I and D_S belong to the gyro wherever it is mounted, and so does |E|; the direction of E belongs to its seat.

use std::collections::BTreeSet;

use super::history_note::{HistoryNote, Quantity};
use crate::core::numerics::median::median_of;

/// A gyro's figures in one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordFigures {
    /// D_I, D_S, D_O, deg/(h g0).
    pub d: [f64; 3],
    /// Standard deviations of D_I and D_S, where the station gave them.
    pub sd: Option<[f64; 2]>,
    /// |E|, pulse/arcsec; none where it is not remembered.
    pub scale: Option<f64>,
}

impl RecordFigures {
    /// Of D_I and D_S in one figure: the root of the sum of their stated variances, deg/(h g0); none where none is
    /// stated.
    pub fn uncertainty(&self) -> Option<f64> {
        self.sd.map(|[d_i, d_s]| d_i.hypot(d_s))
    }
}

/// A gyro of a record that is looked at.
#[derive(Debug, Clone, Copy)]
pub struct CheckedGyro<'a> {
    pub serial: &'a str,
    pub now: RecordFigures,
    /// Its records before, the newest last; those after, where there are none before.
    pub before: &'a [RecordFigures],
    /// Of its D_I and D_S, deg/(h g0).
    pub budget: f64,
}

/// Records that make a level.
pub const LEVEL_RECORDS: usize = 5;
/// A gyro is off its level by so many budgets, or so many standard deviations of its own scatter where that is larger.
const OFF_BUDGETS: f64 = 5.0;
const OFF_SCATTERS: f64 = 10.0;
/// From so many on a gyro is asked whether another's history fits it better,
const STRANGE_BUDGETS: f64 = 3.0;
/// which it does where it is so many times as near.
const NEARER: f64 = 4.0;
/// A factor is a unit's when it is met within this part of it.
const UNIT_TOLERANCE: f64 = 0.02;
/// Where both D_I and D_S are so many budgets off, and |E| by more than this part of it, the gyro is another.
const UNLIKE_BUDGETS: f64 = 20.0;
const OWN_SCALE: f64 = 1e-4;
/// |E| that moved by more has another unit, or is another gyro's.
const SAME_SCALE: f64 = 0.2;

/// Standard deviations that are so many times those before, or such a part of them, are stated in another unit.
pub const UNCERTAINTY_FACTOR: f64 = 30.0;
/// All of a gyro's drift has grown by one factor, within this part of it,
const ONE_FACTOR: f64 = 0.01;
/// where it was so many times what it may be off by without a word.
const LEAST_LEVEL: f64 = 20.0;

/// Factors between units that are mistaken for one another: minutes, hours or degrees, radians, g0 and m/s2.
const FACTORS: [f64; 5] = [60.0, 3600.0, 206_264.806, 57.295_779_5, 9.806_65];

/// What is to be noted. `OtherUnit` is for the caller to drop where something was done to one of the gyros.
pub fn against_histories(gyros: &[CheckedGyro<'_>]) -> Vec<HistoryNote> {
    let mut notes = of_figures(gyros);
    let has_factor = |serial: &str| {
        notes.iter().any(
            |note| matches!(note, HistoryNote::UnitFactor { serials, .. } if serials.iter().any(|one| one == serial)),
        )
    };
    let stated: Vec<(&str, f64)> =
        gyros.iter().filter_map(|gyro| Some((gyro.serial, gyro.uncertainty_factor()?))).collect();
    // What G is multiplied by, its standard deviation is too.
    let stated = stated.into_iter().filter(|(serial, _)| !has_factor(serial));
    let (larger, smaller): (Vec<_>, Vec<_>) = stated.partition(|(_, factor)| *factor > 1.0);
    for same in [larger, smaller] {
        if let Some(factor) = median_of(same.iter().map(|(_, factor)| *factor)) {
            let serials = same.into_iter().map(|(serial, _)| serial.to_owned()).collect();
            notes.push(HistoryNote::UncertaintyFactor { serials, factor });
        }
    }
    notes
}

fn of_figures(gyros: &[CheckedGyro<'_>]) -> Vec<HistoryNote> {
    let mut notes = Vec::new();
    let known = gyros.iter().filter(|gyro| !gyro.before.is_empty()).count();
    let found: Vec<(&CheckedGyro<'_>, Quantity, f64)> = gyros
        .iter()
        .flat_map(|gyro| {
            wrong_units(gyro).into_iter().flatten().map(move |(quantity, factor)| (gyro, quantity, factor))
        })
        .collect();
    for quantity in [Quantity::E, Quantity::G] {
        let mut left: Vec<(&CheckedGyro<'_>, f64)> =
            found.iter().filter(|one| one.1 == quantity).map(|one| (one.0, one.2)).collect();
        while let Some(&(gyro, factor)) = left.first() {
            let (same, others): (Vec<_>, Vec<_>) = left.into_iter().partition(|one| is_about(one.1, factor));
            left = others;
            // A factor that is no unit's, or a sense the other way round, is believed only where all gyros have it, or
            // where it is the gyro's own scale factor.
            let is_by_scale = quantity == Quantity::G && gyro.is_by_scale(factor) && gyro.grew_by(factor);
            let is_units = factor > 0.0 && unit_of(factor).is_some();
            if is_units || is_by_scale || same.len() >= 2 && same.len() == known {
                notes.push(HistoryNote::UnitFactor {
                    serials: same.iter().map(|(gyro, _)| gyro.serial.to_owned()).collect(),
                    quantity,
                    factor,
                    by_scale: same.iter().all(|(gyro, factor)| gyro.is_by_scale(*factor)),
                });
            }
        }
    }
    if !notes.is_empty() {
        return notes;
    }
    if let Some(fits) = exchanged(gyros) {
        notes.push(HistoryNote::SerialsExchanged { fits });
    } else if gyros.len() >= 2 && gyros.iter().all(|gyro| gyro.off_by() > OFF_BUDGETS) {
        let least = gyros.iter().map(CheckedGyro::off_by).fold(f64::INFINITY, f64::min);
        let serials = gyros.iter().map(|gyro| gyro.serial.to_owned()).collect();
        notes.push(HistoryNote::OtherUnit { serials, budgets: least });
    } else {
        let others: Vec<_> =
            gyros.iter().filter_map(|gyro| Some((gyro.serial.to_owned(), gyro.unlike_itself()?))).collect();
        if let Some(budgets) = others.iter().map(|(_, budgets)| *budgets).reduce(f64::min) {
            let serials = others.into_iter().map(|(serial, _)| serial).collect();
            notes.push(HistoryNote::AnotherGyro { serials, budgets });
        }
    }
    notes
}

impl CheckedGyro<'_> {
    /// How far its figures are from its own level and from its last record, whichever is nearer, in budgets; nothing
    /// where it has no history.
    fn off_by(&self) -> f64 {
        self.distance_to(self.before).unwrap_or(0.0)
    }

    /// By how many budgets both D_I and D_S are off its level and its last record, where that is more than any gyro
    /// changes by and |E| is known not to be the same.
    fn unlike_itself(&self) -> Option<f64> {
        let last = self.before.last()?;
        let off = |i: usize, from: f64| (self.now.d[i] - from).abs() / self.tolerance(self.before, i);
        let level = level(self.before);
        let least = (0..2).map(|i| off(i, level[i]).min(off(i, last.d[i]))).fold(f64::INFINITY, f64::min);
        let (now, then) = self.now.scale.zip(last.scale)?;
        (least > UNLIKE_BUDGETS && (now / then - 1.0).abs() >= OWN_SCALE).then_some(least)
    }

    /// As [`CheckedGyro::off_by`], from its level alone.
    fn off_level(&self) -> f64 {
        self.distance_to_level(self.before).unwrap_or(0.0)
    }

    fn distance_to(&self, history: &[RecordFigures]) -> Option<f64> {
        Some(self.distance_to_level(history)?.min(self.distance(history.last()?.d, history)))
    }

    fn distance_to_level(&self, history: &[RecordFigures]) -> Option<f64> {
        (!history.is_empty()).then(|| self.distance(level(history), history))
    }

    fn distance(&self, from: [f64; 3], history: &[RecordFigures]) -> f64 {
        (0..2).map(|i| (self.now.d[i] - from[i]).abs() / self.tolerance(history, i)).fold(0.0, f64::max)
    }

    /// What makes a budget for D_I or D_S: its own, or as much of its own scatter and of its uncertainty as is worth
    /// one.
    fn tolerance(&self, history: &[RecordFigures], column: usize) -> f64 {
        let of_scatter = OFF_SCATTERS / OFF_BUDGETS;
        let stated = |shown: &RecordFigures| shown.sd.map_or(0.0, |sd| sd[column]);
        // What is stated in another unit measures nothing.
        let now = if self.uncertainty_factor().is_some() { 0.0 } else { stated(&self.now) };
        let sd = median_of(history.iter().map(stated)).map_or(now, |before| before.max(now));
        self.budget.max(of_scatter * scatter(history, column)).max(of_scatter * sd)
    }

    /// How many times those of its last records its stated standard deviations are, where that is more than any
    /// station's change of method makes; dimensionless.
    fn uncertainty_factor(&self) -> Option<f64> {
        let last = &self.before[self.before.len().saturating_sub(LEVEL_RECORDS)..];
        let before = median_of(last.iter().filter_map(RecordFigures::uncertainty)).filter(|before| *before > 0.0)?;
        let factor = self.now.uncertainty().filter(|now| *now > 0.0)? / before;
        (factor.max(factor.recip()) >= UNCERTAINTY_FACTOR).then_some(factor)
    }

    /// Whether a factor is that of its |E|: of G that was divided by it already, or multiplied once more.
    fn is_by_scale(&self, factor: f64) -> bool {
        let is = |scale: f64| (factor / scale - 1.0).abs() < UNIT_TOLERANCE;
        self.now.scale.is_some_and(|scale| is(scale) || is(scale.recip()))
    }

    /// Whether nothing but a factor tells its drift from its level, which has to be large enough to show one.
    fn grew_by(&self, factor: f64) -> bool {
        let level = level(self.before);
        let off = norm([0, 1, 2].map(|i| self.now.d[i] / factor - level[i]));
        let tolerance = (0..2).map(|i| self.tolerance(self.before, i)).fold(0.0, f64::max);
        norm(level) > LEAST_LEVEL * tolerance && off <= ONE_FACTOR * norm(level) + tolerance
    }
}

/// The median record of the last few, figure by figure.
fn level(history: &[RecordFigures]) -> [f64; 3] {
    let last = &history[history.len().saturating_sub(LEVEL_RECORDS)..];
    [0, 1, 2].map(|i| median_of(last.iter().map(|shown| shown.d[i])).unwrap_or(0.0))
}

/// The standard deviation of one record, from the median of the differences between neighbours; nothing of fewer than
/// three.
fn scatter(history: &[RecordFigures], column: usize) -> f64 {
    if history.len() < 3 {
        return 0.0;
    }
    // The median of |N(0, 2 s2)| is 0.954 s.
    let differences = history.windows(2).map(|pair| (pair[1].d[column] - pair[0].d[column]).abs());
    median_of(differences).map_or(0.0, |median| median / 0.954)
}

/// Gyros off their own level of which each fits the history of another of them far better: each with whose it fits.
/// Where the last record was as strange, something may have been done to them: they have to be at another's level.
fn exchanged(gyros: &[CheckedGyro<'_>]) -> Option<Vec<(String, String)>> {
    let strange: Vec<&CheckedGyro<'_>> = gyros.iter().filter(|gyro| gyro.off_level() > STRANGE_BUDGETS).collect();
    let is_new = |gyro: &CheckedGyro<'_>| gyro.off_by() > STRANGE_BUDGETS;
    let same_scale = |gyro: &CheckedGyro<'_>, other: &CheckedGyro<'_>| {
        let there = median_of(other.before.iter().filter_map(|shown| shown.scale));
        gyro.now.scale.zip(there).is_none_or(|(a, b)| (a / b - 1.0).abs() < SAME_SCALE)
    };
    let fits = |gyro: &&CheckedGyro<'_>| {
        let others = strange.iter().filter(|other| other.serial != gyro.serial && same_scale(gyro, other));
        let distance_to = |history: &[RecordFigures]| match is_new(gyro) {
            true => gyro.distance_to(history),
            false => gyro.distance_to_level(history).filter(|distance| *distance <= STRANGE_BUDGETS),
        };
        let near = others.filter_map(|other| Some((other.serial, distance_to(other.before)?)));
        let (nearest, distance) = near.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (distance * NEARER < gyro.off_level()).then_some(nearest)
    };
    // One that stays where its last record was, and fits no other, has moved.
    let looked_at = strange.iter().map(|gyro| (gyro, fits(gyro))).filter(|(gyro, of)| is_new(gyro) || of.is_some());
    let found: Vec<(String, String)> =
        looked_at.map(|(gyro, of)| Some((gyro.serial.to_owned(), of?.to_owned()))).collect::<Option<_>>()?;
    let taken: BTreeSet<&str> = found.iter().map(|(_, of)| of.as_str()).collect();
    (found.len() >= 2 && taken.len() == found.len()).then_some(found)
}

/// By which factors E and G differ from the gyro's history, where both are those of units.
fn wrong_units(gyro: &CheckedGyro<'_>) -> Option<Vec<(Quantity, f64)>> {
    let level = (!gyro.before.is_empty()).then(|| level(gyro.before))?;
    let scales: Vec<f64> = gyro.before.iter().filter_map(|shown| shown.scale).collect();
    let e = match gyro.now.scale {
        Some(scale) if !scales.is_empty() => {
            let ratio = scale / median_of(scales)?;
            if (ratio - 1.0).abs() < SAME_SCALE { 1.0 } else { unit_of(ratio).unwrap_or(ratio) }
        }
        _ => 1.0,
    };
    let tolerance = (0..2).map(|i| gyro.tolerance(gyro.before, i)).fold(0.0, f64::max);
    let size = norm(level);
    // Too small a drift is no measure of a factor.
    let of_unit = if size < 2.0 * OFF_BUDGETS * tolerance { None } else { drift_factor(gyro.now.d, level, tolerance) };
    // |E| may be so near to 1 that its factor is no unit's.
    let by_scale = gyro.now.scale.filter(|_| e == 1.0 && gyro.off_by() > OFF_BUDGETS);
    let by_scale = by_scale.and_then(|scale| [scale.recip(), scale].into_iter().find(|factor| gyro.grew_by(*factor)));
    let d = of_unit.filter(|factor| *factor != 1.0).or(by_scale).or(of_unit);
    let mut found = Vec::new();
    if e != 1.0 {
        found.push((Quantity::E, e));
    }
    // D = G / |E|: with E alone in another unit it is smaller by as much, and with both it stays.
    match d {
        Some(d) if !is_about(d * e, 1.0) => {
            let of_outputs = if is_about(d, 1.0) { e } else { d * e };
            found.push((Quantity::G, unit_of(d * e).unwrap_or(of_outputs)));
        }
        None if e == 1.0 => return None,
        _ => {}
    }
    Some(found).filter(|found| !found.is_empty())
}

/// By which factor, that of a unit or 1, all of the drift has grown; below 0 where it has changed its sign.
fn drift_factor(now: [f64; 3], level: [f64; 3], tolerance: f64) -> Option<f64> {
    let along: f64 = now.iter().zip(level).map(|(now, level)| now * level).sum();
    let ratio = (norm(now) / norm(level)).copysign(along);
    let is_same_size = (ratio.abs() - 1.0).abs() < SAME_SCALE;
    let factor = if is_same_size { ratio.signum() } else { unit_of(ratio).unwrap_or(ratio) };
    let off = norm([0, 1, 2].map(|i| now[i] / factor - level[i]));
    (off <= 2.0 * UNIT_TOLERANCE * norm(level) + tolerance).then_some(factor)
}

/// The factor between units that this is: 1 is none, -1 is that of a sense taken the other way round.
fn unit_of(ratio: f64) -> Option<f64> {
    let signed = FACTORS.into_iter().flat_map(|f| [f, -f, f.recip(), -f.recip()]).chain([-1.0]);
    signed.into_iter().find(|factor| (ratio / factor - 1.0).abs() < UNIT_TOLERANCE)
}

fn is_about(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 2.0 * UNIT_TOLERANCE
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
