//! What the table was told: positions and turns, the attitudes they give, and which interval of a log is which.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use crate::core::campaign::{Phase, Site};
use crate::core::frames::{Body, Nav, Rotation, Vector};
use crate::core::numerics::median::upper_median_of;

/// One position or turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// v_body = C v_nav at the start.
    pub attitude: Rotation<Nav, Body>,
    /// Rate of the table about the vertical, counter-clockwise seen from above, arcsec/s; zero in a position.
    pub turn_arcsec_s: f64,
    /// When the station says it began, by a clock of its own, and how long it lasted.
    pub start_s: Option<f64>,
    pub duration_s: Option<f64>,
}

/// What a log says of one of its intervals.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoggedInterval {
    /// Body direction that points up, by the accelerometers.
    pub up: Option<Vector3<f64>>,
    /// Rate of the table, arcsec/s.
    pub turn_arcsec_s: Option<f64>,
}

/// Two axes of a table: one fixed to the Earth, which carries one fixed to the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table {
    /// Outer axis in East, North, Up.
    pub outer: Vector3<f64>,
    /// Inner axis in the body.
    pub inner: Vector3<f64>,
    /// The attitude with both angles at zero.
    pub zero: Rotation<Nav, Body>,
}

/// Angle between accelerometers and programme that is another position, radians (20 deg).
const OTHER_POSITION: f64 = 0.35;
/// Relative difference of a rate that is another rate.
const OTHER_RATE: f64 = 0.2;
/// Rates below this are rest, arcsec/s: faster than the Earth.
pub const REST_ARCSEC_S: f64 = 30.0;

impl Position {
    /// `static` where the table does not turn.
    pub fn phase(&self) -> Phase {
        if self.turn_arcsec_s == 0.0 { Phase::Static } else { Phase::Rate }
    }

    /// Commanded mean specific force (g0) and inertial rate (arcsec/s) in body axes.
    ///
    /// f = g C up. At rest w = C Omega [0, cos L, sin L]; over whole turns about the vertical the part towards north
    /// averages to zero, and w = (turn + Omega sin L) C up.
    pub fn commanded(&self, site: &Site) -> (Vector3<f64>, Vector3<f64>) {
        let up = self.up();
        let earth = site.earth_rate();
        let rate = match self.phase() {
            Phase::Static => (self.attitude * earth).0,
            Phase::Rate => (self.turn_arcsec_s + earth.0.z) * up,
        };
        (site.gravity_g0 * up, rate)
    }

    /// The same over the part of a turn from angle `from` to angle `to`, rad from the stated attitude: what is left of
    /// the Earth's horizontal rate W = Omega cos L is, in East and North, W (cos from - cos to, sin to - sin from)
    /// / (to - from).
    pub fn commanded_over(&self, site: &Site, (from, to): (f64, f64)) -> (Vector3<f64>, Vector3<f64>) {
        let (force, rate) = self.commanded(site);
        let part = Vector3::new(from.cos() - to.cos(), to.sin() - from.sin(), 0.0) / (to - from);
        (force, rate + (self.attitude * Vector::new(site.earth_rate().0.y * part)).0)
    }

    /// Body coordinates of the vertical, pointing up.
    pub fn up(&self) -> Vector3<f64> {
        self.attitude.up()
    }
}

/// The attitude in which body direction `up` points up and the part of `north` that is level points north; none where
/// the two are parallel.
pub fn attitude(up: Vector3<f64>, north: Vector3<f64>) -> Option<Rotation<Nav, Body>> {
    let up = up.try_normalize(0.0)?;
    let north = (north - up * up.dot(&north)).try_normalize(1e-6)?;
    let east = north.cross(&up);
    let matrix = Matrix3::from_columns(&[east, north, up]);
    Some(Rotation::stated_as(Rotation3::from_matrix_unchecked(matrix)))
}

/// Six faces up, each in four headings: +X, -X, +Y, -Y, +Z, -Z up, and of each the four level axes towards north, in
/// the order +X, -X, +Y, -Y, +Z, -Z.
pub fn twenty_four() -> Vec<Position> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|axis| [axis, -axis]);
    let pairs = axes.clone().flat_map(|up| axes.clone().map(move |north| (up, north)));
    pairs
        .filter_map(|(up, north)| attitude(up, north))
        .map(|attitude| Position { attitude, turn_arcsec_s: 0.0, start_s: None, duration_s: None })
        .collect()
}

impl Table {
    /// The attitude at two angles in radians: C = R(inner)^T C0 R(outer)^T, each R turning vectors about its axis.
    pub fn attitude(&self, outer: f64, inner: f64) -> Rotation<Nav, Body> {
        let about = |axis: Vector3<f64>, angle: f64| {
            Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle).inverse().matrix().clone_owned()
        };
        let matrix = about(self.inner, inner) * self.zero.matrix() * about(self.outer, outer);
        Rotation::stated_as(Rotation3::from_matrix_unchecked(matrix))
    }

    /// The inner axis in East, North, Up.
    pub fn inner_in_nav(&self, angles: (f64, f64)) -> Vector3<f64> {
        (self.attitude(angles.0, angles.1).inverse() * Vector::new(self.inner.normalize())).0
    }

    /// Rate about the vertical, counter-clockwise from above, of axes that turn at these rates, at these angles.
    pub fn turn(&self, (outer, inner): (f64, f64), (outer_rate, inner_rate): (f64, f64)) -> f64 {
        let up = self.attitude(outer, inner).up();
        outer_rate * self.outer.normalize().z + inner_rate * self.inner.normalize().dot(&up)
    }
}

/// Which interval is which position of the programme, in order; `None` where an interval is none of them.
///
/// Of all ways to go through both lists in order, one that leaves out least, where matched pairs agree in phase,
/// in the vertical (20 deg) and in the rate (a fifth).
pub fn align(seen: &[LoggedInterval], programme: &[Position]) -> Vec<Option<usize>> {
    align_with_cost(seen, programme, |_, _| 0.0)
}

/// As [`align`], where `more` is what else speaks against an interval and a row being one; one left out costs 1.
pub fn align_with_cost(
    seen: &[LoggedInterval],
    programme: &[Position],
    more: impl Fn(usize, usize) -> f64,
) -> Vec<Option<usize>> {
    let (rows, columns) = (seen.len(), programme.len());
    let width = columns + 1;
    let pair = |k: usize, j: usize| disagreement(&seen[k], &programme[j]) + more(k, j);
    let mut cost = vec![0.0_f64; (rows + 1) * width];
    for k in 0..=rows {
        for j in 0..=columns {
            if k + j == 0 {
                continue;
            }
            let skip_interval = if k > 0 { cost[(k - 1) * width + j] + 1.0 } else { f64::INFINITY };
            let skip_position = if j > 0 { cost[k * width + j - 1] + 1.0 } else { f64::INFINITY };
            let taken = if k > 0 && j > 0 { cost[(k - 1) * width + j - 1] + pair(k - 1, j - 1) } else { f64::INFINITY };
            cost[k * width + j] = taken.min(skip_interval).min(skip_position);
        }
    }
    let mut found = vec![None; rows];
    let (mut k, mut j) = (rows, columns);
    while k > 0 && j > 0 {
        let here = cost[k * width + j];
        if here == cost[(k - 1) * width + j - 1] + pair(k - 1, j - 1) {
            found[k - 1] = Some(j - 1);
            k -= 1;
            j -= 1;
        } else if here == cost[(k - 1) * width + j] + 1.0 {
            k -= 1;
        } else {
            j -= 1;
        }
    }
    found
}

/// Rows of a programme, of as many intervals as rows, that contradict their own interval where most others agree. Laid
/// over one another otherwise, all between them would be taken for their neighbours.
pub fn exchanged(seen: &[LoggedInterval], programme: &[Position]) -> Vec<usize> {
    let pairs = seen.iter().zip(programme).enumerate();
    let wrong: Vec<usize> = pairs.filter(|(_, (s, p))| disagreement(s, p).is_infinite()).map(|(row, _)| row).collect();
    let is_few = seen.len() == programme.len() && 4 * wrong.len() <= seen.len();
    if is_few { wrong } else { Vec::new() }
}

pub(super) fn disagreement(seen: &LoggedInterval, position: &Position) -> f64 {
    let mut cost = 0.0;
    if let Some(up) = seen.up.and_then(|up| up.try_normalize(0.0)) {
        let angle = up.dot(&position.up()).clamp(-1.0, 1.0).acos();
        if angle > OTHER_POSITION {
            return f64::INFINITY;
        }
        cost += 0.1 * angle / OTHER_POSITION;
    }
    if let Some(turn) = seen.turn_arcsec_s {
        let told = position.turn_arcsec_s;
        let off = (turn - told).abs();
        if off > (OTHER_RATE * told.abs()).max(REST_ARCSEC_S) {
            return f64::INFINITY;
        }
        cost += 0.1 * off / (told.abs() + REST_ARCSEC_S);
    }
    cost
}

/// How much later the log's clock is than the programme's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    pub offset_s: f64,
    /// Another offset, a dwell away, that fits as well: of regular dwells of which the first or the last are missing.
    pub rival_s: Option<f64>,
}

/// The offset at which most positions are held in intervals that do not contradict them.
///
/// The candidates are all differences between the begin of an interval and that of a position, or their ends; clocks
/// that agree to a second are taken for one. None where no position states its time, or fewer than half fit.
pub fn clock_offset(intervals: &[(f64, f64)], seen: &[LoggedInterval], programme: &[Position]) -> Option<Clock> {
    let told: Vec<(f64, f64)> =
        programme.iter().filter_map(|p| Some((p.start_s?, p.start_s? + p.duration_s?))).collect();
    if told.len() < programme.len() || told.is_empty() {
        return None;
    }
    let agrees: Vec<Vec<bool>> =
        programme.iter().map(|p| seen.iter().map(|s| disagreement(s, p).is_finite()).collect()).collect();
    let overlap = |offset: f64| -> f64 {
        let shared = |(row, &(from, to)): (usize, &(f64, f64))| {
            let part = |(k, &(a, b)): (usize, &(f64, f64))| match agrees[row][k] {
                true => (b.min(to + offset) - a.max(from + offset)).max(0.0),
                false => 0.0,
            };
            intervals.iter().enumerate().map(part).sum::<f64>() / (to - from)
        };
        told.iter().enumerate().map(shared).sum()
    };
    let ends = intervals.iter().flat_map(|&(a, b)| told.iter().flat_map(move |&(from, to)| [a - from, b - to]));
    let tried: Vec<(f64, f64)> = ends.chain([0.0]).map(|offset| (overlap(offset), offset)).collect();
    let most = tried.iter().map(|(shared, _)| *shared).fold(0.0, f64::max);
    if most < 0.5 * told.len() as f64 {
        return None;
    }
    let as_good = || tried.iter().filter(|(shared, _)| *shared >= most - AS_GOOD);
    let is_one = |(_, offset): &&(f64, f64)| offset.abs() <= ONE_CLOCK_S;
    if let Some(&(_, offset_s)) = as_good().filter(is_one).max_by(|a, b| a.0.total_cmp(&b.0)) {
        return Some(Clock { offset_s, rival_s: None });
    }
    let offset_s = tried.iter().find(|(shared, _)| *shared == most)?.1;
    let apart = 0.5 * told.iter().map(|(from, to)| to - from).fold(f64::INFINITY, f64::min);
    let rival_s = as_good().map(|(_, offset)| *offset).find(|offset| (offset - offset_s).abs() > apart);
    Some(Clock { offset_s, rival_s })
}

/// By what a programme's times must be multiplied to fit the log, where they are in ms, minutes or hours: its dwells then
/// last about as long as the intervals.
pub fn clock_factor(intervals: &[(f64, f64)], seen: &[LoggedInterval], programme: &[Position]) -> Option<f64> {
    const FACTORS: [f64; 5] = [1e-3, 60.0, 3600.0, 1e-6, 86_400.0];
    let in_unit = |factor: f64| -> Vec<Position> {
        let scaled = |time: Option<f64>| time.map(|time| factor * time);
        let of = |p: &Position| Position { start_s: scaled(p.start_s), duration_s: scaled(p.duration_s), ..*p };
        programme.iter().map(of).collect()
    };
    let found = upper_median_of(intervals.iter().map(|(from, to)| to - from))?;
    let told = upper_median_of(programme.iter().filter_map(|p| p.duration_s))?;
    let lasts = |factor: &f64| AS_LONG.contains(&(factor * told / found));
    FACTORS.into_iter().filter(lasts).find(|factor| clock_offset(intervals, seen, &in_unit(*factor)).is_some())
}

/// Dwells by which one offset must fit better than another; clocks that agree so well are one.
const AS_GOOD: f64 = 0.5;
/// A usual dwell of a programme over a usual interval, of which edges are gone or which two dwells share.
const AS_LONG: std::ops::Range<f64> = 0.3..4.0;
const ONE_CLOCK_S: f64 = 1.0;
