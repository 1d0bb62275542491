//! Forward selection against noise that may remember, with corrected significance and classes of equals.

use std::sync::Arc;

use nalgebra::DVector;

use crate::core::judge::{Coefficient, Mark};
use crate::core::numerics::basis::dot;
use crate::core::numerics::normal::normal_cdf;
use crate::core::numerics::normal_equations::{NormalEquations, Solution};
use crate::core::numerics::tails::chi2_tail;

use super::answer::{
    Attribution, CauseEstimate, ChangeCause, ExcessScatter, NamedCause, RandomVariation, Rejected, StationForm,
    WhyRejected,
};
use super::candidates::{self, CandidateCause};
use super::closure;
use super::fitted_rows::{FittedRows, NoisePrior, along, whitened};
use super::noise::{self, Process};
use super::pairs;
use super::series::RecordSeries;
use super::station::{CoursePart, Shared, StationCourse};
use super::unlike_window::Unlike;

/// Adjusted significance below which a cause is named.
const SIGNIFICANCE: f64 = 0.005;
/// The same against a coefficient that wanders, corrected for instants: from here on a cause is named, with wandering
/// in its class,
const BEYOND_WANDERING: f64 = 3e-3;
/// and from here on by itself. Of walks that move a coefficient by three to nine standard deviations, two in a hundred
/// are beyond it.
const NOT_WANDERING: f64 = 1.5e-4;
/// Significance below which something is said to remain.
const REMAINS: f64 = 0.01;
/// Two candidates explain a change equally well where 2 ln L differs by less than this (the 1 % point of chi-square
/// with one degree of freedom).
const EQUALLY_GOOD: f64 = 6.635;
/// An own estimate within this many standard deviations of the other gyros' may be the station's.
const CONSISTENT: f64 = 3.5;
/// A part of the station's course is named where it moves this gyro by so many standard deviations.
const SEEN: f64 = 3.0;
const MOST_CAUSES: usize = 4;

/// A candidate beside what is named.
#[derive(Clone, Copy)]
struct CandidateTrial {
    white: f64,
    best: f64,
    value: f64,
    sd: f64,
    p_white: f64,
    p_wandering: f64,
}

/// A step of the selection: what is named, and what may be named beside it.
#[derive(Clone, Copy)]
struct Selection<'a> {
    rows: &'a SearchedRows,
    taken: &'a [CandidateCause],
    fitted: &'a FittedRows,
    pool: &'a [CandidateCause],
    /// Columns of the pool, whitened by each model.
    white: &'a [Vec<Vec<f64>>],
    /// How many are tried in all, those that are searched for as one.
    kinds: usize,
}

/// What is named next.
struct Leading {
    candidate: CandidateCause,
    class: Vec<ChangeCause>,
    trial: CandidateTrial,
    /// As [`CauseSearch::open`] says.
    open: f64,
}

/// What was found, and the fit that it ended with.
pub(super) struct SearchResult {
    pub named: Vec<NamedCause>,
    pub rejected: Vec<Rejected>,
    pub wander: Option<RandomVariation>,
    pub excess: Option<ExcessScatter>,
    pub remaining_p_value: f64,
    /// By the instants at which ageing may have begun, with their likelihoods over that of the one named, which is the first.
    pub levels: Vec<(f64, NewestLevel)>,
}

/// Level and slope as they are believed at the newest row.
#[derive(Debug, Clone, Copy)]
pub(super) struct NewestLevel {
    pub value: f64,
    pub slope: f64,
    /// Variances of level and slope, and their covariance.
    pub covariance: [f64; 3],
    pub freedom: f64,
    pub ages: bool,
}

/// What the models are fitted to.
#[derive(Clone)]
struct SearchedRows {
    years: Vec<f64>,
    y: Vec<f64>,
    /// Of each row, in units of `unit^2`.
    variance: Vec<f64>,
    /// Columns whose coefficient is known with a variance.
    known: Vec<(Vec<f64>, f64)>,
}

impl SearchedRows {
    fn fitted(&self, taken: &[CandidateCause], prior: NoisePrior) -> FittedRows {
        let models = noise::models(&self.years, &self.variance, &self.known);
        FittedRows::of(models, &self.y, &columns(taken), prior)
    }

    /// Of the rows whose regressor is not known the variance is larger by what it would have done there; `per_unit` is
    /// the candidate's coefficient in units of a record's standard deviation.
    fn inflate(&mut self, candidate: &CandidateCause, per_unit: f64) {
        for k in &candidate.missing {
            self.variance[*k] += per_unit * per_unit * candidate.spread;
        }
    }
}

fn columns(taken: &[CandidateCause]) -> Vec<&[f64]> {
    taken.iter().map(|candidate| &*candidate.column).collect()
}

pub(super) struct CauseSearch<'a> {
    pub series: &'a RecordSeries,
    pub marks: &'a [Mark],
    pub coefficient: Coefficient,
    pub reference: usize,
    pub course: &'a StationCourse,
    /// Gyros of the same IMU.
    pub mates: &'a StationCourse,
    pub prior: NoisePrior,
    /// When gyros of its stations were off with it, each in its own direction.
    pub unlike: &'a [(Arc<str>, Unlike)],
}

impl CauseSearch<'_> {
    /// Names causes one by one, each significant against white noise and against a wandering coefficient. None where
    /// the records allow no model of white noise.
    pub fn answer(&self) -> Option<SearchResult> {
        let series = self.series;
        let scale = series.unit * series.scatter.of_stated;
        let known = self.course.taken.iter().map(|(part, common)| (self.column(part), (common.sd / scale).powi(2)));
        let mut rows = SearchedRows {
            years: series.column(|row| row.years),
            y: series.column(|row| row.y),
            variance: series.column(|row| row.variance),
            known: known.collect(),
        };
        let mut pool = candidates::all(series, self.marks, self.coefficient, self.reference, self.course, self.unlike);
        let kinds = kinds(&pool);
        let mut taken: Vec<CandidateCause> = Vec::new();
        let mut named: Vec<NamedCause> = Vec::new();
        let mut open: Vec<f64> = Vec::new();
        let mut fitted = rows.fitted(&taken, self.prior);
        if fitted.models.first()?.process != Process::White {
            return None;
        }
        let mut white = whitened(&fitted, &pool);
        let mut rejected;
        loop {
            let selection =
                Selection { rows: &rows, taken: &taken, fitted: &fitted, pool: &pool, white: &white, kinds };
            let trials = self.trials(&selection);
            rejected = self.rejected(&pool, &trials);
            let more = MOST_CAUSES - named.len();
            let alone = (more > 0).then(|| self.leading(&selection, &trials)).flatten();
            let two = || if more > 1 && something_remains(&fitted) { self.first_of_two(&selection) } else { None };
            let Some(leading) = alone.or_else(two) else { break };
            let Leading { candidate, class, trial, open: share } = leading;
            open.push(share);
            named.push(NamedCause {
                cause: candidate.cause,
                class,
                tie: candidate.tie.clone(),
                estimate: estimate(&candidate, trial.value, trial.sd),
                held_out: None,
                p_value_adjusted: trial.p_white.max(trial.p_wandering),
            });
            rows.inflate(&candidate, trial.value / scale);
            pool.retain(|other| other.column != candidate.column);
            taken.push(candidate);
            fitted = rows.fitted(&taken, self.prior);
            white = whitened(&fitted, &pool);
        }
        let columns = columns(&taken);
        let y = &rows.y;
        let mut levels = Vec::new();
        // What is not told apart in one fit keeps the estimates that it was named with, and has no level.
        if let Some((estimates, level)) = self.together(&fitted, y, &taken) {
            levels = self.levels((&fitted, level), y, &taken, &pool);
            for (cause, (value, sd)) in named.iter_mut().zip(estimates) {
                cause.estimate = CauseEstimate { value, sd, ..cause.estimate.clone() };
            }
        }
        let noise_variance = fitted.variance(fitted.squares[0]);
        let stated: Vec<f64> = rows.variance.iter().map(|v| v * noise_variance).collect();
        for (k, cause) in named.iter_mut().enumerate() {
            cause.held_out = closure::held_out(y, &stated, &columns, k, open[k]);
        }
        // Two slopes one after the other fit any smooth bend, of a year or of settling, and tell nothing of its end.
        let is_slope = |one: &NamedCause| matches!(one.tie, Attribution::Slope | Attribution::SlopeSince(_));
        if named.iter().filter(|one| is_slope(one)).count() > 1 {
            for one in named.iter_mut().filter(|one| is_slope(one) && !one.class.contains(&ChangeCause::Wandering)) {
                one.class.push(ChangeCause::Wandering);
            }
            levels.clear();
        }
        let (remaining_p_value, model) = remaining(&fitted);
        let wander = (remaining_p_value < REMAINS).then(|| self.random_variation(&fitted, model, remaining_p_value));
        let mut stations = self.stations_named(y, &stated, &columns);
        stations.append(&mut named);
        Some(SearchResult { named: stations, rejected, wander, excess: fitted.excess(), remaining_p_value, levels })
    }

    fn column(&self, part: &CoursePart) -> Vec<f64> {
        self.series.column(|row| part.at(row.station, row.at, row.years))
    }

    fn trial(&self, selection: &Selection<'_>, k: usize) -> Option<CandidateTrial> {
        let &Selection { rows, taken, fitted, pool, white, kinds } = selection;
        let (candidate, white) = (&pool[k], &*white[k]);
        let own;
        let (fit, white) = if candidate.missing.is_empty() {
            (fitted, white)
        } else {
            let (value, _) = along(fitted, 0, &white[0])?;
            let mut rows = rows.clone();
            rows.inflate(candidate, value / (self.series.unit * self.series.scatter.of_stated));
            let fit = rows.fitted(taken, self.prior);
            let white = whitened(&fit, std::slice::from_ref(candidate)).remove(0);
            own = (fit, white);
            (&own.0, &*own.1)
        };
        if fitted.n < fitted.parameters() + 3 {
            return None;
        }
        let mut trial: Option<CandidateTrial> = None;
        let mut each = Vec::with_capacity(fit.models.len());
        for (m, white) in white.iter().enumerate() {
            let (value, information) = along(fit, m, white)?;
            let squares = (fit.squares[m] - value * value * information).max(0.0);
            let l = fit.ln_likelihood(m, squares);
            let sd = (fit.variance(squares) / information).sqrt();
            each.push(l);
            match &mut trial {
                None => trial = Some(CandidateTrial { white: l, best: l, value, sd, p_white: 1.0, p_wandering: 1.0 }),
                Some(trial) if l > trial.best => (trial.best, trial.value, trial.sd) = (l, value, sd),
                Some(_) => {}
            }
        }
        let mut trial = trial?;
        trial.best = fit.mean(|m| each[m]);
        let p = |gain: f64, tried: usize| (fitted.significance(gain, 1.0) * tried as f64).min(1.0);
        trial.p_white = p(trial.white - fitted.white(), kinds * candidate.tried);
        trial.p_wandering = p(trial.best - fitted.evidence(), candidate.tried);
        Some(trial)
    }

    fn trials(&self, selection: &Selection<'_>) -> Vec<Option<CandidateTrial>> {
        (0..selection.pool.len()).map(|k| self.trial(selection, k)).collect()
    }

    fn leading(&self, selection: &Selection<'_>, trials: &[Option<CandidateTrial>]) -> Option<Leading> {
        let (k, class) = self.lead(selection.pool, trials)?;
        let open = self.open(selection, trials, k);
        Some(Leading { candidate: selection.pool[k].clone(), class, trial: trials[k]?, open })
    }

    /// The first of two causes that only together explain what is left: it leads beside the other, and one beside it.
    fn first_of_two(&self, selection: &Selection<'_>) -> Option<Leading> {
        let &Selection { rows, fitted, pool, white, kinds, .. } = selection;
        let beside = |one: &CandidateCause| {
            let taken: Vec<CandidateCause> = selection.taken.iter().chain([one]).cloned().collect();
            let fitted = rows.fitted(&taken, self.prior);
            let selection = Selection { taken: &taken, fitted: &fitted, ..*selection };
            self.leading(&selection, &self.trials(&selection))
        };
        let [_, second] = pairs::best(fitted, pool, white, [SIGNIFICANCE, NOT_WANDERING], kinds)?;
        let first = beside(&pool[second])?;
        beside(&first.candidate).is_some().then_some(first)
    }

    /// The candidate that leads, and the class of those that explain as much.
    fn lead(&self, pool: &[CandidateCause], trials: &[Option<CandidateTrial>]) -> Option<(usize, Vec<ChangeCause>)> {
        let possible: Vec<(usize, CandidateTrial)> = (0..pool.len())
            .filter_map(|k| Some((k, trials[k]?)))
            .filter(|(k, trial)| self.denied(&pool[*k], trial).is_none())
            .collect();
        let significant = |trial: &CandidateTrial| trial.p_white < SIGNIFICANCE && trial.p_wandering < BEYOND_WANDERING;
        let best = possible.iter().filter(|(_, trial)| significant(trial)).map(|(_, trial)| trial.best);
        let best = best.max_by(f64::total_cmp)?;
        let equals: Vec<&(usize, CandidateTrial)> =
            possible.iter().filter(|(_, trial)| 2.0 * (best - trial.best) <= EQUALLY_GOOD).collect();
        let rank = |k: usize| rank(&pool[k]);
        let named = equals.iter().filter(|(_, trial)| significant(trial));
        let (lead, _) = named.min_by(|a, b| rank(a.0).cmp(&rank(b.0)).then(b.1.best.total_cmp(&a.1.best)))?;
        let recorded = matches!(pool[*lead].cause, ChangeCause::StepAtEvent | ChangeCause::ReMounting);
        let counts = |candidate: &CandidateCause| !recorded || rank_of_searched(candidate).is_none();
        let mut class: Vec<ChangeCause> =
            equals.iter().map(|(k, _)| &pool[*k]).filter(|c| counts(c)).map(|c| c.cause).collect();
        class.push(pool[*lead].cause);
        let may_wander = trials[*lead].is_some_and(|trial| trial.p_wandering >= NOT_WANDERING);
        class.extend(may_wander.then_some(ChangeCause::Wandering));
        class.sort_unstable();
        class.dedup();
        Some((*lead, class))
    }

    /// What share of a named course is open: the largest squared distance from it to the course of a candidate that
    /// explains as much, another instant among them, over its own square. Level and named causes count in neither.
    fn open(&self, selection: &Selection<'_>, trials: &[Option<CandidateTrial>], named: usize) -> f64 {
        let &Selection { fitted, pool, white, .. } = selection;
        let possible =
            |(k, trial): (usize, &Option<CandidateTrial>)| trial.filter(|one| self.denied(&pool[k], one).is_none());
        let best = trials.iter().enumerate().filter_map(possible).map(|one| one.best).fold(f64::NEG_INFINITY, f64::max);
        let course = |k: usize| -> Option<Vec<f64>> {
            let trial = possible((k, &trials[k])).filter(|one| 2.0 * (best - one.best) <= EQUALLY_GOOD)?;
            let mut column = fitted.projected(0, &white[k][0]);
            column.iter_mut().for_each(|value| *value *= trial.value);
            Some(column)
        };
        let Some(own) = course(named) else { return 0.0 };
        let apart = |other: Vec<f64>| own.iter().zip(&other).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        (0..pool.len()).filter_map(course).map(apart).fold(0.0, f64::max) / dot(&own, &own)
    }

    /// What the other gyros, or those of the same IMU, say against a station.
    fn denied(&self, candidate: &CandidateCause, trial: &CandidateTrial) -> Option<Shared> {
        let part = candidate.part?;
        if let Some(others) = self.course.estimate(&part) {
            let sd = trial.sd.hypot(others.sd).hypot(others.between);
            let consistent = (trial.value - others.value).abs() <= CONSISTENT * sd;
            return (!consistent).then_some(others);
        }
        if part.form == StationForm::Offset {
            return None;
        }
        let mates = self.mates.estimate(&part)?;
        let still = mates.value.abs() < 3.0 * mates.sd;
        (still && (trial.value - mates.value).abs() > 4.0 * trial.sd.hypot(mates.sd)).then_some(mates)
    }

    fn rejected(&self, pool: &[CandidateCause], trials: &[Option<CandidateTrial>]) -> Vec<Rejected> {
        // Of what was searched for the best of its kind.
        let mut best: Vec<(f64, Option<CoursePart>, Rejected)> = Vec::new();
        let mut out = Vec::new();
        for (candidate, trial) in pool.iter().zip(trials) {
            let searched = rank_of_searched(candidate).is_some();
            let why = match trial {
                None => WhyRejected::NotSeparable,
                Some(trial) => match self.denied(candidate, trial) {
                    Some(others) => WhyRejected::OthersDeny {
                        own: trial.value,
                        others: others.value,
                        sd: others.sd,
                        gyros: others.gyros,
                    },
                    None if trial.p_white >= SIGNIFICANCE => WhyRejected::NotSignificant { p: trial.p_white },
                    None => WhyRejected::NoBetterThanWandering { p: trial.p_wandering },
                },
            };
            let one = Rejected { cause: candidate.cause, tie: candidate.tie.clone(), why };
            match trial {
                _ if !searched => out.push(one),
                Some(trial) if candidate.cause != ChangeCause::Ageing && !self.is_taken(candidate) => {
                    let is_kind = |(_, part, known): &(f64, Option<CoursePart>, Rejected)| {
                        known.cause == one.cause && is_alike(part.as_ref(), candidate.part.as_ref())
                    };
                    match best.iter_mut().find(|known| is_kind(known)) {
                        None => best.push((trial.best, candidate.part, one)),
                        Some(known) if trial.best > known.0 => *known = (trial.best, candidate.part, one),
                        Some(_) => {}
                    }
                }
                _ => {}
            }
        }
        out.extend(best.into_iter().map(|(.., one)| one));
        out
    }

    /// Whether the like of it is known of its station already.
    fn is_taken(&self, candidate: &CandidateCause) -> bool {
        let Some(part) = candidate.part else { return false };
        self.course.taken.iter().any(|(taken, _)| is_alike(Some(taken), Some(&part)))
    }

    /// Estimates of all named causes from one fit of them together, and level and slope at the newest row; none where
    /// the rows do not tell them apart.
    fn together(
        &self,
        fitted: &FittedRows,
        y: &[f64],
        taken: &[CandidateCause],
    ) -> Option<(Vec<(f64, f64)>, NewestLevel)> {
        let (_, m) = fitted.best();
        let model = &fitted.models[m];
        let goes_on = |candidate: &&CandidateCause| {
            matches!(candidate.tie, Attribution::Slope | Attribution::SlopeAfter(_) | Attribution::SlopeSince(_))
        };
        let columns = taken.iter().map(|candidate| {
            let newest = Some(candidate).filter(goes_on).and_then(|one| one.column.last().copied()).unwrap_or(0.0);
            candidate.column.iter().map(|value| value - newest).collect()
        });
        let columns = std::iter::once(vec![1.0; y.len()]).chain(columns);
        let design: Vec<Vec<f64>> = columns.map(|column| model.whiten(&column)).collect();
        let p = design.len();
        let Solution { estimate, covariance } = NormalEquations::of_columns(&design, &model.whiten(y)).solve()?;
        let covariance = covariance * fitted.variance(fitted.squares[m]);
        let estimates = (1..p).map(|k| (estimate[k], covariance[(k, k)].sqrt())).collect();
        // Steps and offsets that stand at the newest row belong to the level there.
        let (mut here, mut slope) = (DVector::zeros(p), DVector::zeros(p));
        here[0] = 1.0;
        for (k, candidate) in taken.iter().enumerate() {
            slope[k + 1] = f64::from(u8::from(goes_on(&candidate)));
            if candidate.cause.is_step() {
                here[k + 1] = candidate.column.last().copied().unwrap_or(0.0);
            }
        }
        let of_level = &covariance * &here;
        let level = NewestLevel {
            value: self.series.mean + here.dot(&estimate),
            slope: slope.dot(&estimate),
            covariance: [here.dot(&of_level), slope.dot(&(&covariance * &slope)), slope.dot(&of_level)],
            freedom: fitted.freedom(),
            ages: taken.iter().any(|candidate| goes_on(&candidate)),
        };
        Some((estimates, level))
    }

    /// Levels with another beginning of what ages, where that explains as much. From the first record on is as likely
    /// beforehand as from all instants after it together.
    fn levels(
        &self,
        (fitted, level): (&FittedRows, NewestLevel),
        y: &[f64],
        taken: &[CandidateCause],
        pool: &[CandidateCause],
    ) -> Vec<(f64, NewestLevel)> {
        let is_onset = |candidate: &CandidateCause| matches!(candidate.tie, Attribution::SlopeSince(_));
        let ages = |candidate: &CandidateCause| candidate.tie == Attribution::Slope || is_onset(candidate);
        let mut levels = vec![(1.0, level)];
        let Some(place) = taken.iter().position(ages) else { return levels };
        let instants = taken.iter().chain(pool).filter(|candidate| is_onset(candidate)).count() as f64;
        let likely = |candidate: &CandidateCause| if is_onset(candidate) { 1.0 / instants } else { 1.0 };
        let beforehand = likely(&taken[place]);
        for other in pool.iter().filter(|candidate| ages(candidate)) {
            let mut taken = taken.to_vec();
            taken[place] = other.clone();
            let another = FittedRows::of(fitted.models.clone(), y, &columns(&taken), self.prior);
            let gain = another.best().0 - fitted.best().0;
            if -2.0 * gain <= EQUALLY_GOOD {
                let level = self.together(&another, y, &taken).map(|(_, level)| level);
                levels.extend(level.map(|level| (gain.exp() * likely(other) / beforehand, level)));
            }
        }
        levels
    }

    fn random_variation(&self, fitted: &FittedRows, model: usize, p_value: f64) -> RandomVariation {
        let noise = &fitted.models[model];
        let variance = fitted.variance(fitted.squares[model]) * noise.power;
        let rows = &self.series.rows;
        let years = rows.last().map_or(1.0, |row| row.years).max(1e-6);
        let per = match noise.process {
            Process::RandomWalk => years,
            Process::WalkByRecord => (rows.len() - 1) as f64,
            Process::White | Process::Flicker => 1.0,
        };
        RandomVariation { process: noise.process, size: (variance / per).sqrt(), p_value }
    }

    /// Whether the gyros that share a station's drift do not go on alike where they are elsewhere: then they do not all age
    /// so. Where none of them is, that is not known.
    fn is_parted_from_ageing(&self, part: &CoursePart, drift: &Shared) -> bool {
        let elsewhere = self.course.slope_elsewhere(part, self.series);
        elsewhere.is_some_and(|slope| (drift.value - slope.value).abs() > SEEN * slope.sd.hypot(drift.sd))
    }

    /// What the station did, where it moves this gyro's records by more than they scatter.
    fn stations_named(&self, y: &[f64], variance: &[f64], columns: &[&[f64]]) -> Vec<NamedCause> {
        let mut out = Vec::new();
        for (part, common) in &self.course.taken {
            let column = self.column(part);
            let total: f64 = variance.iter().map(|v| 1.0 / v).sum();
            let mean = column.iter().zip(variance).map(|(c, v)| c / v).sum::<f64>() / total;
            let information: f64 = column.iter().zip(variance).map(|(c, v)| (c - mean).powi(2) / v).sum();
            if common.value.abs() * information.sqrt() < SEEN {
                continue;
            }
            let tie: Attribution = candidates::attribution(self.series, self.reference, part);
            let may_age = part.form.is_drift() && !self.is_parted_from_ageing(part, common);
            out.push(NamedCause {
                cause: ChangeCause::Station,
                class: may_age.then_some(ChangeCause::Ageing).into_iter().chain([ChangeCause::Station]).collect(),
                tie,
                estimate: CauseEstimate { name: "k", value: common.value, sd: common.sd, unit: part.form.unit() },
                held_out: closure::held_out_known(y, variance, columns, &column, common.value),
                p_value_adjusted: 2.0 * normal_cdf(-common.significance()),
            });
        }
        out
    }
}

/// Significance of noise that remembers beside white noise, and the likeliest model of it.
fn remaining(fitted: &FittedRows) -> (f64, usize) {
    let (best, model) = fitted.best();
    let gain = 2.0 * (best - fitted.white());
    let p_value = if gain > 0.0 { (1.5 * chi2_tail(gain, 1).unwrap_or(1.0)).min(1.0) } else { 1.0 };
    (p_value, model)
}

fn something_remains(fitted: &FittedRows) -> bool {
    remaining(fitted).0 < REMAINS || fitted.excess().is_some()
}

fn estimate(candidate: &CandidateCause, value: f64, sd: f64) -> CauseEstimate {
    CauseEstimate { name: candidate.parameter, value, sd, unit: candidate.unit }
}

/// What was recorded of the occasion comes before an instant that was only searched for, and that before what a
/// station would have had to do to nobody else that is known.
fn rank(candidate: &CandidateCause) -> u8 {
    rank_of_searched(candidate).unwrap_or(1)
}

fn rank_of_searched(candidate: &CandidateCause) -> Option<u8> {
    match candidate.part {
        Some(CoursePart { form, .. }) if form == StationForm::Drift || form.is_searched() => Some(3),
        _ => (candidate.cause == ChangeCause::Step || matches!(candidate.tie, Attribution::SlopeSince(_))).then_some(2),
    }
}

/// Whether two parts are of one station and form, whatever their instants.
fn is_alike(a: Option<&CoursePart>, b: Option<&CoursePart>) -> bool {
    let kind = |part: &CoursePart| (part.station, std::mem::discriminant(&part.form));
    a.map(kind) == b.map(kind)
}

fn kinds(pool: &[CandidateCause]) -> usize {
    let recorded: Vec<&CandidateCause> =
        pool.iter().filter(|candidate| rank_of_searched(candidate).is_none()).collect();
    let is_new = |(k, one): &(usize, &&CandidateCause)| recorded[..*k].iter().all(|other| other.column != one.column);
    recorded.iter().enumerate().filter(is_new).count() + 2
}
