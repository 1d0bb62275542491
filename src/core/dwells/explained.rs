//! Whether the outputs are explained by what was commanded: which rows of a programme the intervals are, where order,
//! vertical and rate leave several, and which dwells contradict the others.

use nalgebra::{DMatrix, Vector3};

use super::programme::{LoggedInterval, Position, align, align_with_cost, disagreement};
use crate::core::campaign::{Campaign, Site};
use crate::core::numerics::median::upper_median_of;

/// What the gyros said in each interval, and what is known of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Begin and end, s.
    pub spans: Vec<(f64, f64)>,
    /// Mean output of each gyro, by interval.
    pub means: Vec<Vec<f64>>,
    /// Nominal input axes of the gyros; none where the map does not say them.
    pub axes: Vec<Vector3<f64>>,
    /// Whether they measure rates of turn: E is about the input axis then.
    pub are_rates: bool,
    pub site: Site,
}

/// Several ways to lay a programme over a log, of which nothing says which is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Undecided;

/// One way to lay the programme over the log.
struct Alignment {
    rows: Vec<Option<usize>>,
    taken: usize,
    /// Squares that the error model leaves, and how many independent ones they are.
    squares: f64,
    freedom: f64,
    /// Whether every input axis is near its nominal one.
    plausible: bool,
}

/// Twice the logarithm of the likelihood by which the best must exceed all others: there are many others.
const CLEARLY: f64 = 25.0;
/// Angle of an input axis from its nominal one that belongs to another attitude, rad.
const OTHER_AXIS: f64 = 0.5;
/// Part of a turn's rate that scale factors leave unexplained, and what every dwell may, arcsec/s.
const OF_RATE: f64 = 5e-3;
/// What it costs to contradict the outputs, at most: less than to leave out a row and an interval.
const CONTRADICTS: f64 = 1.8;
/// What E of gyros that measure rates weighs against outputs in arcsec/s, where it is not the input axis.
const NEAR_NOMINAL: f64 = 100.0;
/// Squares of a residual, in the middle one, at which a pair contradicts the outputs.
const FAR: f64 = 400.0;
/// Ways that are tried, and how often each is mended by what its fit says.
const TRIED: usize = 64;
const MENDED: usize = 4;
/// Room for regular intervals, and how many must be so.
const REGULAR: f64 = 0.05;
const MOST_REGULAR: f64 = 0.8;

/// Which interval is which row. Of ways that leave out equally little, the one whose commands explain the outputs;
/// where several do, the one that goes with the log's clock.
///
/// # Errors
/// Several that explain them as well.
pub fn align_by_outputs(
    seen: &[LoggedInterval],
    outputs: &Outputs,
    programme: &[Position],
) -> Result<Vec<Option<usize>>, Undecided> {
    let mut found = tried(seen, outputs, programme);
    let Some(best) = best_of(&found) else { return Err(Undecided) };
    let (best, taken, plausible) = (best.squares, best.taken, best.plausible);
    found.retain(|alignment| {
        let is_clearly_worse = alignment.freedom * (alignment.squares / best).ln() >= CLEARLY;
        alignment.taken == taken && alignment.plausible == plausible && !is_clearly_worse
    });
    found.sort_by(|a, b| a.squares.total_cmp(&b.squares));
    let slots = slots(&outputs.spans);
    let on_clock = |alignment: &Alignment| slots.as_ref().is_some_and(|slots| alignment.is_on_clock(slots));
    if found.iter().any(on_clock) {
        found.retain(on_clock);
    }
    // A station leaves out once, or breaks off, sooner than twice.
    let least = found.iter().map(|alignment| alignment.pieces(programme.len())).min().unwrap_or(0);
    found.retain(|alignment| alignment.pieces(programme.len()) == least);
    let best = found.swap_remove(0);
    let one_way = found.iter().all(|other| best.commands_as(other, programme));
    // Where it is another programme, no way of laying it is the right one.
    if one_way || is_another(best.taken, seen.len()) { Ok(best.rows) } else { Err(Undecided) }
}

/// Ways to lay the programme over the log, each once: that of the order alone, with what is missing in one place and
/// mended by what its fit says, and what is next to the best, until nothing next to it is better.
fn tried(seen: &[LoggedInterval], outputs: &Outputs, programme: &[Position]) -> Vec<Alignment> {
    let mut found: Vec<Alignment> = Vec::new();
    let add = |found: &mut Vec<Alignment>, rows: Vec<Option<usize>>| {
        if !found.iter().any(|own| own.rows == rows) {
            found.push(Alignment::new(rows, outputs, programme));
        }
    };
    add(&mut found, align(seen, programme));
    few_left_out(seen, programme).into_iter().for_each(|rows| add(&mut found, rows));
    // All that is missing, or too much, before one interval.
    let shift = programme.len() as isize - seen.len() as isize;
    let places = if shift == 0 { 0 } else { seen.len().min(programme.len()) };
    // Less, all together, than one that is left out.
    let not_tried = 0.9 / (places + 1) as f64;
    for gap in (0..=places).step_by((places / TRIED).max(1)) {
        let is_tried = |k: usize, j: usize| {
            let row = if k.min(j) < gap { k as isize } else { k as isize + shift };
            row == j as isize
        };
        let mut rows = align_with_cost(seen, programme, |k, j| if is_tried(k, j) { 0.0 } else { not_tried });
        for _ in 0..MENDED {
            add(&mut found, rows.clone());
            let misfit = misfit(&rows, outputs, programme);
            rows = align_with_cost(seen, programme, |k, j| misfit[k * programme.len() + j]);
        }
        add(&mut found, rows);
    }
    for _ in 0..TRIED {
        let Some(best) = best_of(&found).map(|alignment| alignment.rows.clone()) else { break };
        let before = found.len();
        neighbours(&best, seen, programme).into_iter().for_each(|rows| add(&mut found, rows));
        if found.len() == before || best_of(&found).is_some_and(|alignment| alignment.rows == best) {
            break;
        }
    }
    found
}

/// Whether so few intervals are rows of a programme that it is another one.
pub fn is_another(taken: usize, intervals: usize) -> bool {
    taken == 0 || 5 * taken < 4 * intervals
}

/// The ways that leave out least, with input axes near their nominal ones if any has; of these the least squares.
fn best_of(found: &[Alignment]) -> Option<&Alignment> {
    let order = |a: &&Alignment, b: &&Alignment| {
        let key = |alignment: &Alignment| (std::cmp::Reverse(alignment.taken), !alignment.plausible);
        key(a).cmp(&key(b)).then(a.squares.total_cmp(&b.squares))
    };
    found.iter().min_by(order)
}

/// All ways in which nothing is left out but one or two rows, or one or two intervals.
fn few_left_out(seen: &[LoggedInterval], programme: &[Position]) -> Vec<Vec<Option<usize>>> {
    let (intervals, rows) = (seen.len(), programme.len());
    let most = intervals.max(rows);
    let left: Vec<Vec<usize>> = match intervals.abs_diff(rows) {
        1 => (0..most).map(|a| vec![a]).collect(),
        2 if most <= TRIED => (0..most).flat_map(|a| (a + 1..most).map(move |b| vec![a, b])).collect(),
        _ => Vec::new(),
    };
    let way = |left: Vec<usize>| -> Vec<Option<usize>> {
        if intervals < rows {
            return (0..rows).filter(|row| !left.contains(row)).map(Some).collect();
        }
        let before = |k: usize| left.iter().filter(|own| **own < k).count();
        (0..intervals).map(|k| (!left.contains(&k)).then(|| k - before(k))).collect()
    };
    let agrees = |way: &Vec<Option<usize>>| {
        let pair =
            |(k, row): (usize, &Option<usize>)| row.is_none_or(|j| disagreement(&seen[k], &programme[j]).is_finite());
        way.iter().enumerate().all(pair)
    };
    left.into_iter().map(way).filter(agrees).collect()
}

/// Ways in which one interval is the row before or after, or is left out in place of the next.
fn neighbours(rows: &[Option<usize>], seen: &[LoggedInterval], programme: &[Position]) -> Vec<Vec<Option<usize>>> {
    let agrees = |k: usize, j: usize| disagreement(&seen[k], &programme[j]).is_finite();
    let mut found = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        let Some(row) = *row else { continue };
        let steps = [row.checked_sub(1), Some(row + 1).filter(|next| *next < programme.len())];
        for next in steps.into_iter().flatten().filter(|next| !rows.contains(&Some(*next)) && agrees(k, *next)) {
            let mut other = rows.to_vec();
            other[k] = Some(next);
            found.push(other);
        }
        let beside = [k.checked_sub(1), Some(k + 1).filter(|next| *next < rows.len())];
        for next in beside.into_iter().flatten().filter(|next| rows[*next].is_none() && agrees(*next, row)) {
            let mut other = rows.to_vec();
            other.swap(k, next);
            found.push(other);
        }
    }
    found
}

impl Alignment {
    fn new(rows: Vec<Option<usize>>, outputs: &Outputs, programme: &[Position]) -> Self {
        let fit = Fit::of(&rows, outputs, programme);
        let taken = rows.iter().flatten().count();
        let (squares, freedom) = (fit.squares, fit.freedom);
        let plausible = fit.known_e.iter().zip(&outputs.axes).all(|((e, sd), axis)| {
            let room = OTHER_AXIS + 3.0 * sd / e.norm();
            e.angle(axis) < room
        });
        Self { rows, taken, squares, freedom, plausible }
    }

    /// Whether from one interval to the next there are as many rows as periods of the clock.
    fn is_on_clock(&self, slots: &[i64]) -> bool {
        let taken: Vec<(i64, i64)> =
            self.rows.iter().zip(slots).filter_map(|(row, slot)| Some(((*row)? as i64, *slot))).collect();
        taken.windows(2).all(|pair| pair[1].0 - pair[0].0 == pair[1].1 - pair[0].1)
    }

    /// Pieces of the programme that are missing.
    fn pieces(&self, rows: usize) -> usize {
        let is_missing: Vec<bool> = (0..rows).map(|row| !self.rows.contains(&Some(row))).collect();
        is_missing.chunk_by(|a, b| a == b).filter(|piece| piece[0]).count()
    }

    /// Whether every interval that both have is commanded the same by both.
    fn commands_as(&self, other: &Self, programme: &[Position]) -> bool {
        let same = |(own, other): (&Option<usize>, &Option<usize>)| match (own, other) {
            (Some(own), Some(other)) => {
                let (own, other) = (&programme[*own], &programme[*other]);
                let turned = (own.attitude.matrix() - other.attitude.matrix()).norm();
                turned < 1e-6 && own.turn_arcsec_s == other.turn_arcsec_s
            }
            _ => true,
        };
        self.rows.iter().zip(&other.rows).all(same)
    }
}

/// Which period of a regular clock each interval is in, where periods without interval say that some are missing:
/// without such, a row may have been left out by the station.
fn slots(spans: &[(f64, f64)]) -> Option<Vec<i64>> {
    let steps: Vec<f64> = spans.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    let period = upper_median_of(steps.iter().copied())?;
    let off = |step: f64| step / period - (step / period).round();
    let regular = steps.iter().filter(|step| **step > 0.5 * period && off(**step).abs() < REGULAR).count();
    let is_regular = regular as f64 >= MOST_REGULAR * steps.len() as f64;
    let slots: Vec<i64> = spans.iter().map(|span| ((span.0 - spans[0].0) / period).round() as i64).collect();
    let has_gap = slots.windows(2).any(|pair| pair[1] > pair[0] + 1);
    (is_regular && has_gap).then_some(slots)
}

/// What the error model leaves of the outputs in every interval that has a row, weighted.
struct Fit {
    squares: f64,
    freedom: f64,
    coefficients: Option<DMatrix<f64>>,
    /// Scale factor and input axis of each gyro, where the rates tell all three parts, and how well.
    known_e: Vec<(Vector3<f64>, f64)>,
}

const COLUMNS: usize = 10;
/// Those without squares, and the first of E. What is quadratic is small: it must not explain another row.
const LINEAR: usize = 7;
const E: usize = 4;
/// Part of the largest singular value that is none.
const NOTHING: f64 = 1e-9;

/// The terms of y = D0 + G.A + E.w + P.A^2 in a dwell.
fn terms(force: Vector3<f64>, rate: Vector3<f64>) -> [f64; COLUMNS] {
    let square = force.component_mul(&force);
    [1.0, force.x, force.y, force.z, rate.x, rate.y, rate.z, square.x, square.y, square.z]
}

fn terms_of(position: &Position, site: &Site) -> [f64; COLUMNS] {
    let (force, rate) = position.commanded(site);
    terms(force, rate)
}

fn weight(position: &Position) -> f64 {
    (1.0 + OF_RATE * position.turn_arcsec_s.abs()).recip()
}

impl Fit {
    fn of(rows: &[Option<usize>], outputs: &Outputs, programme: &[Position]) -> Self {
        let pairs: Vec<(usize, &Position)> =
            rows.iter().enumerate().filter_map(|(k, row)| Some((k, &programme[(*row)?]))).collect();
        let gyros = outputs.means.first().map_or(0, Vec::len);
        let mut rows: Vec<[f64; COLUMNS]> =
            pairs.iter().map(|(_, p)| terms_of(p, &outputs.site).map(|term| weight(p) * term)).collect();
        let mut told: Vec<Vec<f64>> =
            pairs.iter().map(|(k, p)| outputs.means[*k].iter().map(|mean| weight(p) * mean).collect()).collect();
        if outputs.are_rates && outputs.axes.len() == gyros {
            for c in 0..3 {
                let mut row = [0.0; COLUMNS];
                row[E + c] = NEAR_NOMINAL;
                rows.push(row);
                told.push(outputs.axes.iter().map(|axis| NEAR_NOMINAL * axis[c]).collect());
            }
        }
        let design = DMatrix::from_fn(rows.len(), LINEAR, |k, c| rows[k][c]);
        let y = DMatrix::from_fn(rows.len(), gyros, |k, j| told[k][j]);
        let Solved { coefficients, rank, spread } = solve(&design, &y);
        let squares = coefficients.as_ref().map_or(0.0, |c| (&y - &design * c).norm_squared());
        let rates = design.columns(E, 3).into_owned();
        let tells_e = rank == LINEAR && rates.rank(1e-6 * rates.norm().max(1.0)) == 3;
        let freedom = (gyros * rows.len().saturating_sub(rank)) as f64;
        let sd = (squares / freedom.max(1.0)).sqrt() * spread[E..].iter().map(|s| s * s).sum::<f64>().sqrt();
        let e = |j: usize| coefficients.as_ref().map(|c| (Vector3::from(c.fixed_view::<3, 1>(E, j)), sd));
        let known_e = if tells_e { (0..gyros).filter_map(e).collect() } else { Vec::new() };
        // What rounding leaves is no difference.
        Self { squares: squares.max(1e-18 * y.norm_squared()), freedom, coefficients, known_e }
    }
}

struct Solved {
    coefficients: Option<DMatrix<f64>>,
    rank: usize,
    /// Standard deviation of each coefficient for outputs of standard deviation one.
    spread: Vec<f64>,
}

/// Columns of length one, and the lengths that they had.
fn unit_columns(design: &DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>) {
    let lengths: Vec<f64> = design.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    (DMatrix::from_fn(design.nrows(), design.ncols(), |k, c| design[(k, c)] / lengths[c]), lengths)
}

/// Least squares by the singular values; columns are brought to length one first.
fn solve(design: &DMatrix<f64>, y: &DMatrix<f64>) -> Solved {
    let (unit, lengths) = unit_columns(design);
    let parts = unit.svd(true, true);
    let rank = parts.rank(NOTHING);
    let spread = |c: usize| {
        let of = |i: usize| parts.v_t.as_ref().map_or(0.0, |v| v[(i, c)] / parts.singular_values[i]);
        (0..rank).map(|i| of(i).powi(2)).sum::<f64>().sqrt() / lengths[c]
    };
    let spread = (0..design.ncols()).map(spread).collect();
    let mut coefficients = parts.solve(y, NOTHING).ok();
    for (mut row, length) in coefficients.iter_mut().flat_map(|c| c.row_iter_mut()).zip(&lengths) {
        row /= *length;
    }
    Solved { coefficients, rank, spread }
}

/// By interval and row, how much the row's command contradicts the outputs by the fit of these rows: 0 to 1.8.
fn misfit(rows: &[Option<usize>], outputs: &Outputs, programme: &[Position]) -> Vec<f64> {
    let none = vec![0.0; rows.len() * programme.len()];
    let Some(coefficients) = Fit::of(rows, outputs, programme).coefficients else { return none };
    let told: Vec<Vec<f64>> = programme
        .iter()
        .map(|position| {
            let terms = DMatrix::from_row_slice(1, LINEAR, &terms_of(position, &outputs.site)[..LINEAR]);
            (terms * &coefficients).iter().copied().collect()
        })
        .collect();
    let off = |k: usize, j: usize| -> f64 {
        let squares = outputs.means[k].iter().zip(&told[j]).map(|(y, told)| (y - told).powi(2)).sum::<f64>();
        weight(&programme[j]).powi(2) * squares
    };
    let own = rows.iter().enumerate().filter_map(|(k, row)| Some(off(k, (*row)?)));
    let Some(middle) = upper_median_of(own).filter(|middle| *middle > 0.0) else { return none };
    let pairs = (0..rows.len()).flat_map(|k| (0..programme.len()).map(move |j| (k, j)));
    pairs.map(|(k, j)| CONTRADICTS * (off(k, j) / (FAR * middle)).min(1.0)).collect()
}

/// Outputs that no error model brings together with what was commanded.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// What the error model leaves, against what noise and small errors of a table may.
    pub times: f64,
    /// Dwells without which the rest agrees; else those that are worst.
    pub dwells: Vec<usize>,
    pub rest_agrees: bool,
}

/// What the error model leaves of a dwell without anything being wrong, arcsec/s and part of the rate, beside noise.
const SMALL_ERROR: f64 = 0.05;
/// So many times noise and small errors no model leaves, and so many are left where nothing is wrong.
const CONTRADICTION: f64 = 20.0;
const AGREES: f64 = 5.0;
/// Share of the dwells that may be the wrong ones, and how many are named where more are.
const FEW: f64 = 0.25;
const WORST: usize = 5;

/// Whether the outputs contradict what was commanded; none where they agree. Where nothing says how noisy they are, the
/// others do: only a few dwells against them are a contradiction then.
pub fn contradiction(campaign: &Campaign) -> Option<Contradiction> {
    let of = campaign.dwells.len();
    let are_known = (0..campaign.gyros.len()).all(|j| campaign.errors_of(j).is_some());
    let gyros: Vec<Weighted> = (0..campaign.gyros.len()).map(|j| Weighted::of(campaign, j)).collect::<Option<_>>()?;
    let mut kept: Vec<usize> = (0..of).collect();
    let LeaveOneOut { times, each: first, freedom } = leave_one_out(&gyros, &kept)?;
    if times <= CONTRADICTION {
        return None;
    }
    let agrees = if are_known { AGREES } else { times / CONTRADICTION };
    let mut worst: Vec<usize> = (0..of).collect();
    worst.sort_by(|a, b| first[*b].total_cmp(&first[*a]));
    worst.truncate(WORST);
    worst.sort_unstable();
    let mut wrong = Vec::new();
    while (wrong.len() as f64) < FEW * of as f64 {
        // A fit to hardly more dwells than it has unknowns agrees with anything.
        let Some(now) = leave_one_out(&gyros, &kept).filter(|now| are_known || 2 * now.freedom >= freedom) else {
            break;
        };
        if now.times <= agrees {
            wrong.sort_unstable();
            let noise = if are_known { 1.0 } else { now.times.max(1.0) };
            return Some(Contradiction { times: times / noise, dwells: wrong, rest_agrees: true });
        }
        let place = (0..kept.len()).max_by(|a, b| now.each[*a].total_cmp(&now.each[*b]))?;
        wrong.push(kept.remove(place));
    }
    are_known.then_some(Contradiction { times, dwells: worst, rest_agrees: false })
}

/// Design and outputs of one gyro, each row by what it may be off.
struct Weighted {
    design: DMatrix<f64>,
    output: DMatrix<f64>,
}

impl Weighted {
    fn of(campaign: &Campaign, j: usize) -> Option<Self> {
        let dwells = &campaign.dwells;
        let errors = campaign.errors_of(j).unwrap_or_else(|| vec![0.0; dwells.len()]);
        let held = campaign.gyros[j].known_e;
        let scale = held.or_else(|| input_axis(campaign, j))?.norm();
        let may = |k: usize| {
            let small = SMALL_ERROR + OF_RATE * dwells[k].rate_arcsec_s.norm();
            errors[k].hypot(scale * small).recip()
        };
        // E that is held is taken off.
        let fitted: Vec<usize> = (0..COLUMNS).filter(|c| held.is_none() || !(E..E + 3).contains(c)).collect();
        let row = |k: usize| terms(dwells[k].specific_force_g0, dwells[k].rate_arcsec_s);
        let output = campaign.free_outputs(j).enumerate().map(|(k, output)| may(k) * output);
        Some(Self {
            design: DMatrix::from_fn(dwells.len(), fitted.len(), |k, c| may(k) * row(k)[fitted[c]]),
            output: DMatrix::from_iterator(dwells.len(), 1, output),
        })
    }
}

/// Scale factor and input axis of a gyro as a campaign's outputs show it, pulse/arcsec.
pub fn input_axis(campaign: &Campaign, j: usize) -> Option<Vector3<f64>> {
    let dwells = &campaign.dwells;
    let row = |k: usize| terms(dwells[k].specific_force_g0, dwells[k].rate_arcsec_s);
    let design = DMatrix::from_fn(dwells.len(), COLUMNS, |k, c| row(k)[c]);
    let output = DMatrix::from_fn(dwells.len(), 1, |k, _| dwells[k].output_pulse_s[j]);
    Some(Vector3::from(solve(&design, &output).coefficients?.fixed_view::<3, 1>(E, 0)))
}

/// Root of the squares that the model leaves in some dwells by their freedom, and by how much each dwell's absence
/// lessens them.
struct LeaveOneOut {
    times: f64,
    freedom: usize,
    each: Vec<f64>,
}

fn leave_one_out(gyros: &[Weighted], kept: &[usize]) -> Option<LeaveOneOut> {
    let (mut squares, mut freedom, mut each) = (0.0, 0, vec![0.0; kept.len()]);
    for gyro in gyros {
        let (design, output) = (gyro.design.select_rows(kept), gyro.output.select_rows(kept));
        let parts = unit_columns(&design).0.svd(true, false);
        let rank = parts.rank(NOTHING);
        let basis = parts.u?.columns(0, rank).into_owned();
        let residual = &output - &basis * (basis.transpose() * &output);
        squares += residual.norm_squared();
        freedom += kept.len().saturating_sub(rank);
        for (k, each) in each.iter_mut().enumerate() {
            let free = 1.0 - basis.row(k).norm_squared();
            *each += if free > NOTHING { residual[k].powi(2) / free } else { 0.0 };
        }
    }
    (freedom > 0).then(|| LeaveOneOut { times: (squares / freedom as f64).sqrt(), freedom, each })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::dwells::programme::twenty_four;

    const DWELL_S: f64 = 60.0;
    const PERIOD_S: f64 = 75.0;

    fn site() -> Site {
        Site { latitude: 0.6, gravity_g0: 0.999, magnetic_field_nav: None }
    }

    /// Twenty-four positions, and six turns to and fro about each face.
    fn programme(turns: usize) -> Vec<Position> {
        let faces = twenty_four();
        let turn = |k: usize| Position {
            turn_arcsec_s: if k.is_multiple_of(2) { 18_000.0 } else { -18_000.0 },
            ..faces[k / 2 * 4]
        };
        faces.iter().copied().chain((0..turns).map(turn)).collect()
    }

    /// What three gyros say of these rows, `noise` pulse/s off, by a clock of which `slots` are the periods.
    fn log(rows: &[usize], slots: &[usize], noise: f64, programme: &[Position]) -> (Vec<LoggedInterval>, Outputs) {
        let axes = vec![Vector3::new(0.6, -0.4, 0.7), Vector3::new(0.6, -0.4, -0.7), Vector3::new(0.6, 0.8, 0.0)];
        let drift = [Vector3::new(2.4, 4.1, 6.5), Vector3::new(0.9, 4.6, -3.4), Vector3::new(1.0, 1.4, -10.0)];
        let mut state = 1_u32;
        let mut off = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            noise * (f64::from(state) / f64::from(u32::MAX) - 0.5)
        };
        let mut means = Vec::new();
        for &row in rows {
            let (force, rate) = programme[row].commanded(&site());
            let output =
                |(axis, drift): (&Vector3<f64>, &Vector3<f64>)| 2.0 + 1.4 * axis.dot(&rate) + drift.dot(&force) + off();
            means.push(axes.iter().zip(&drift).map(output).collect());
        }
        let seen = |row: &usize| LoggedInterval { up: None, turn_arcsec_s: Some(programme[*row].turn_arcsec_s) };
        let span = |slot: &usize| (*slot as f64 * PERIOD_S, *slot as f64 * PERIOD_S + DWELL_S);
        let spans = slots.iter().map(span).collect();
        (rows.iter().map(seen).collect(), Outputs { spans, means, axes, are_rates: false, site: site() })
    }

    fn without(gone: &[usize], of: usize) -> Vec<usize> {
        (0..of).filter(|row| !gone.contains(row)).collect()
    }

    #[test]
    fn a_missing_position_is_the_one_that_the_outputs_say() {
        for turns in [12, 0] {
            let programme = programme(turns);
            for gone in [vec![5], vec![0], vec![23], vec![2, 17], vec![7, 8, 9], (18..24).collect(), (0..3).collect()] {
                let rows = without(&gone, programme.len());
                // The station's clock went on without a gap.
                let slots: Vec<usize> = (0..rows.len()).collect();
                let (seen, outputs) = log(&rows, &slots, 0.01, &programme);
                let found: Vec<usize> = align_by_outputs(&seen, &outputs, &programme)
                    .unwrap_or_else(|_| panic!("{turns} turns, without {gone:?}"))
                    .into_iter()
                    .flatten()
                    .collect();
                assert_eq!(found, rows, "{turns} turns, without {gone:?}");
            }
        }
    }

    #[test]
    fn outputs_in_noise_leave_it_to_the_clock_and_else_to_the_station() {
        let programme = programme(12);
        let rows = without(&[5], programme.len());
        let (seen, outputs) = log(&rows, &rows, 3000.0, &programme);
        assert_eq!(
            align_by_outputs(&seen, &outputs, &programme).map(|found| found.into_iter().flatten().collect()),
            Ok(rows.clone())
        );
        let slots: Vec<usize> = (0..rows.len()).collect();
        let (seen, outputs) = log(&rows, &slots, 3000.0, &programme);
        assert_eq!(align_by_outputs(&seen, &outputs, &programme), Err(Undecided));
    }

    #[test]
    fn of_a_position_taken_twice_either_is_its_row() {
        let programme = programme(12);
        let mut rows: Vec<usize> = (0..programme.len()).collect();
        rows.insert(6, 5);
        let slots: Vec<usize> = (0..rows.len()).collect();
        let (seen, outputs) = log(&rows, &slots, 0.01, &programme);
        let found = align_by_outputs(&seen, &outputs, &programme).unwrap();
        assert_eq!(found.iter().filter(|row| row.is_none()).count(), 1);
        assert!(found[5].is_none() || found[6].is_none(), "{found:?}");
    }
}
