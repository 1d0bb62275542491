//! How far the named effects close the gap, and what remains beside them.

use super::remaining::{self, FittedResiduals, Tested};
use crate::core::calibrate::Calibration;
use crate::core::calibrate::noise::{self, Evidence};
use crate::core::diagnose::diagnosis::*;
use crate::core::diagnose::report::constancy::{self, Change};
use crate::core::diagnose::report::held_out;
use crate::core::diagnose::report::named::{Named, all_slots, sign, slots};
use crate::core::diagnose::report::stated_errors;
use crate::core::diagnose::residuals::augmented_fit;
use crate::core::diagnose::residuals::augmented_fit::{Fit, Part, with_parts};
use crate::core::diagnose::residuals::noise_floor;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::noise_rounds::{FALSE_ALARM, SearchOutcome};
use crate::core::diagnose::search::refined_shape::{instant, shape_sd};
use crate::core::diagnose::search::stepwise::Search;
use crate::core::effects::{Estimate, Shape};
use crate::core::mounting::Slot;
use crate::core::numerics::basis::{Basis, dot};

/// Probability below which there is a gap. The search has as much of it as its first name is refused at, the tests
/// that know no catalogue the rest (Bonferroni's inequality, weighted), so that names, signs and verdict never
/// contradict one another.
pub(crate) const GAP: f64 = 0.02;
const SHARE_OF_SEARCH: f64 = FALSE_ALARM / GAP;
const REMAINS: f64 = GAP - FALSE_ALARM;

/// Probability below which what remains beside a name is significant. A name speaks for a cause of nearly its form as
/// well: there what it leaves has to be looked at more closely.
const REMAINS_BESIDE_A_NAME: f64 = 0.05;

/// Power, in noise variances, of structure that the tests of what remains would miss half of the time.
pub(crate) const UNSEEN: f64 = 10.0;

/// What the probability that noise has no memory counts as at most, where it is certain enough to be said.
const CERTAIN: f64 = 1e-2;

fn level(named: &[Named]) -> f64 {
    if named.is_empty() { REMAINS } else { REMAINS_BESIDE_A_NAME }
}

/// Where something remains the residual is no measure of noise: what the fit takes for one is.
pub(crate) fn floor_variances(frame: &Frame, fit: &Fit, remains: bool) -> Vec<f64> {
    if !remains {
        return fit.variances.clone();
    }
    let of_gyros = frame.gyros.iter().zip(&fit.residuals).zip(&fit.dof);
    let evidence: Vec<Evidence> = of_gyros
        .map(|((gyro, residual), dof)| {
            Evidence::of(dot(residual, residual), *dof as usize, noise_floor::pure_error(frame, gyro, residual))
        })
        .collect();
    let noise = noise::noise(&evidence, frame.noise.stated);
    noise.iter().zip(&fit.variances).map(|(noise, left)| noise.floor().map_or(*left, |f| f.max(1e-12))).collect()
}

/// What closures are held against.
pub(crate) struct ClosureReference<'a> {
    pub frame: &'a Frame,
    pub fit: &'a Fit,
    pub variances: &'a [f64],
    pub floor_deg_per_h: f64,
    pub remains: bool,
    /// Scatter is all that remains: it may be noise that standard errors understate.
    pub may_be_noise: bool,
}

impl ClosureReference<'_> {
    /// The share of the gap that `asked` close beside `earlier`, and its interval, which reaches as far as if what is
    /// left were noise where that may be.
    pub fn held_out(&self, earlier: &[&Part], asked: &[&Part], coefficients: usize) -> HeldOut {
        let of = |variances: &[f64], remains: bool| {
            let errors = held_out::errors(self.frame, earlier, asked, variances, remains);
            errors.held_out(self.floor_deg_per_h, coefficients as f64, UNSEEN)
        };
        let mut held_out = of(self.variances, self.remains);
        if self.may_be_noise {
            held_out.interval[1] = held_out.interval[1].max(of(&self.fit.variances, false).interval[1]);
        }
        held_out
    }
}

pub(crate) struct Signs {
    pub list: Vec<Sign>,
    pub p_value: f64,
    /// Names that are not the same throughout.
    pub changes: Vec<Change>,
}

impl Signs {
    /// Whether what is left beside the names is significant.
    pub fn remain(&self, named: &[Named]) -> bool {
        self.p_value < level(named)
    }

    /// Whether residuals that scatter more than is stated are all that they tell of.
    pub fn are_of_spread(&self) -> bool {
        !self.list.is_empty() && self.list.iter().all(|sign| sign.kind == remaining::SPREAD)
    }
}

/// What is left beside the named effects: competitors that the search adopted, rivals, and tests that know no
/// catalogue.
pub(crate) fn signs(
    settled: &SearchOutcome,
    search: &Search,
    named: &[Named],
    fit: &Fit,
    crowded: &[Sign],
    calibration: &Calibration,
) -> Signs {
    let frame = &settled.frame;
    let mut list: Vec<Sign> = crowded.to_vec();
    let competitors = settled.found.iter().filter(|choice| choice.is_competitor());
    list.extend(competitors.map(|choice| sign(search, choice.kind.id(), &choice.members, choice.evidence)));
    let of_rival = |named: &Named| Some(sign(search, named.rival?.id(), &named.part.members, named.evidence));
    list.extend(named.iter().filter_map(of_rival));
    if let Some((_, _, without)) = settled.noise_found.memory {
        list.push(Sign::of_no_dwell("noise_with_memory", all_slots(frame), without.min(CERTAIN)));
    }
    let parts: Vec<&Part> = named.iter().map(|named| &named.part).collect();
    let extras: Vec<Basis> = (0..frame.gyros.len())
        .map(|j| {
            let model = &frame.gyros[j].basis;
            with_parts(frame, j, model.clone(), &parts).split_off(model.rank())
        })
        .collect();
    let apart = settled.noise_found.between_gyros.as_ref().map(|shared| shared.apart(&fit.residuals));
    let left = FittedResiduals { frame, extras: &extras, residuals: apart.as_ref().unwrap_or(&fit.residuals) };
    let power = |r: &[f64]| dot(r, r);
    let taken: f64 = frame.gyros.iter().zip(&fit.residuals).map(|(g, r)| power(&g.residual) - power(r)).sum();
    // No name is sure where all that the names take may be what rounding makes.
    let by_rounding = frame.noise.commands.powi(2) * (frame.dwells() * frame.gyros.len()) as f64;
    if !named.is_empty() && taken < by_rounding {
        list.push(Sign::of_no_dwell("commands_rounded", all_slots(frame), CERTAIN));
    }
    let changes = constancy::changes(&left, named, fit, taken.max(0.0).sqrt());
    let of_change = |change: &Change| {
        Sign::of_no_dwell("not_constant", vec![frame.setting.gyros[change.gyro].slot], change.p_value)
    };
    list.extend(changes.iter().map(of_change));
    let mut tests = left.tests();
    tests.extend(harmonics(&left, named));
    let all_slots = all_slots(frame);
    let p_value = remaining::combined(&tests);
    if list.is_empty() && p_value < level(named) {
        list = remaining::signs(&tests, &all_slots, level(named));
        if list.is_empty() {
            list.push(Sign::of_no_dwell("tests_together", all_slots, p_value));
        }
        return Signs { list, p_value, changes };
    }
    // What goes with something in repeats as well passes for noise everywhere else.
    if named.is_empty() && list.is_empty() {
        let p_value = settled.p_value_of_components();
        if p_value < level(named) {
            list.push(Sign::of_no_dwell("goes_with_a_variable", all_slots, p_value));
        }
    }
    if list.is_empty() {
        list.extend(stated_errors::beyond_belief(calibration));
    }
    let strongest = list.iter().map(|sign| sign.p_value).fold(p_value, f64::min);
    Signs { list, p_value: strongest, changes }
}

/// The second and third harmonic of each named sinusoid: a cycle of another form has them.
fn harmonics(left: &FittedResiduals, named: &[Named]) -> Vec<Tested> {
    let mut tests = Vec::new();
    for part in named.iter().map(|n| &n.part) {
        let Shape::Period(period) = part.shape else { continue };
        for j in (0..part.members.len()).filter(|&j| part.members[j]) {
            let overtones = [2.0, 3.0].map(|n| Part { shape: Shape::Period(period / n), ..part.clone() });
            let columns = overtones.iter().flat_map(|overtone| overtone.columns(left.frame, j));
            tests.extend(left.of_form("harmonics", j, columns.map(|c| left.frame.gyros[j].whiten(c)).collect()));
        }
    }
    tests
}

pub(crate) fn gap(
    settled: &SearchOutcome,
    search: &Search,
    variances: &[f64],
    signs: &Signs,
    nothing_named: bool,
    plain: &Calibration,
) -> Gap {
    let best = search.scores(&[]).iter().map(|s| search.earned(&[], s.kind)).fold(f64::NEG_INFINITY, f64::max);
    let seen = search.p_value(best);
    // What the noise took away again is no gap.
    let from_search = if seen < FALSE_ALARM && !settled.stands() { 1.0 } else { seen };
    let from_tests = if nothing_named { signs.p_value / (1.0 - SHARE_OF_SEARCH) } else { 1.0 };
    Gap {
        rms_deg_per_h: noise_floor::rms(
            &settled.frame,
            settled.frame.gyros.iter().map(|gyro| gyro.residual.as_slice()),
        ),
        noise_alone_deg_per_h: noise_floor::expected_rms(&settled.frame, variances),
        reduced_chi2: plain.reduced_chi2().unwrap_or(1.0),
        p_value: (from_search / SHARE_OF_SEARCH).min(from_tests).min(1.0),
    }
}

pub(crate) fn effects(
    settled: &SearchOutcome,
    named: &[Named],
    (parts, told): (&[Part], &[Part]),
    ground: &ClosureReference<'_>,
    signs: &Signs,
) -> Vec<NamedEffect> {
    let &ClosureReference { frame, fit, variances, .. } = ground;
    let fit_as_told = (told != parts).then(|| augmented_fit::fit(frame, told));
    let fit_as_told = fit_as_told.as_ref().unwrap_or(fit);
    let rss = |fit: &Fit| fit.residuals.iter().zip(variances).map(|(r, v)| dot(r, r) / v).sum::<f64>();
    (0..named.len())
        .map(|p| {
            // How far each shrinks the gap in the order of adoption, so that the closures lead from the gap to what
            // remains.
            let earlier: Vec<&Part> = parts[..p].iter().collect();
            let others: Vec<Part> =
                parts.iter().enumerate().filter(|(q, _)| *q != p).map(|(_, part)| part.clone()).collect();
            let coefficients = fit.fitted.iter().filter(|f| f.part == p).count();
            NamedEffect {
                effect: parts[p].effect,
                shape: told[p].shape,
                class: named[p].class.clone(),
                wider_in: (named[p].wider_in.iter())
                    .map(|(j, class)| (frame.setting.gyros[*j].slot, class.clone()))
                    .collect(),
                gyros: slots(frame, &parts[p].members),
                acts_in: (signs.changes.iter()).find(|change| change.named == p).and_then(|change| change.acts_in),
                estimates: estimates(frame, told, p, fit_as_told),
                held_out: ground.held_out(&earlier, &[&parts[p]], coefficients),
                p_value_adjusted: settled.null.p_value(named[p].evidence),
                detectability: (rss(&augmented_fit::fit(frame, &others)) - rss(fit)).max(0.0).sqrt(),
                drift: drift(frame, &parts[p], p, fit),
            }
        })
        .collect()
}

/// What one part adds in each dwell of the gyros that have it, deg/h.
fn drift(frame: &Frame, part: &Part, p: usize, fit: &Fit) -> Vec<(Slot, Vec<f64>)> {
    let of_gyro = |j: usize| (frame.setting.gyros[j].slot, fit.drift_of((p, part), &frame.setting, j));
    (0..part.members.len()).filter(|j| part.members[*j]).map(of_gyro).collect()
}

/// What the campaign does not show of an effect is no estimate: neither zero nor a size that nothing has.
fn estimates(frame: &Frame, parts: &[Part], p: usize, fit: &Fit) -> Vec<Estimate> {
    let plausible = parts[p].effect.entry().plausible;
    let mut list: Vec<Estimate> = fit
        .fitted
        .iter()
        .filter(|f| f.part == p && f.sd > 0.0 && f.sd <= plausible)
        .map(|f| Estimate {
            slot: f.gyro.map(|j| frame.setting.gyros[j].slot),
            name: f.coefficient.name,
            value: f.value,
            sd: f.sd,
            unit: f.coefficient.unit,
        })
        .collect();
    let shape =
        |name: &'static str, value, sd, unit: &'static str| Some(Estimate { slot: None, name, value, sd, unit });
    let known_to = |grid: f64| shape_sd(frame, parts, p, &fit.variances, grid);
    list.extend(match parts[p].shape {
        Shape::Tau(tau) => shape("tau", tau, known_to(0.25 * tau), "s"),
        Shape::Instant(_) => {
            let (at, sd) = instant(frame, parts, p, &fit.variances);
            shape("instant", at, sd, "s")
        }
        Shape::Period(period) => shape("period", period, known_to(0.2 * period * period / frame.setting.span()), "s"),
        Shape::Dwell(dwell) => shape("dwell", dwell as f64, 0.0, "1"),
        Shape::Azimuth(angle) => {
            shape("field_azimuth", angle.to_degrees(), known_to(5.0_f64.to_radians()).to_degrees(), "deg")
        }
        Shape::Own(value) => parts[p].effect.hypothesis().and_then(|own| {
            let range = own.written.range.as_ref()?;
            shape(&range.name, value, known_to(0.1 * (range.to - range.from)), &range.unit)
        }),
        _ => None,
    });
    list
}
