//! Which dwells to measure next: positions and rates that a two-axis table can do, chosen one after the other for
//! what they add to telling apart what this campaign ties, and to showing what it hides.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::core::calibrate::outcome::JUST_MISSED;
use crate::core::campaign::Phase;
use crate::core::diagnose::diagnosis::NextDwell;
use crate::core::diagnose::report::identifiability::{GConfounder, visible};
use crate::core::diagnose::residuals::augmented_fit::{Fit, Part};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::hypotheses::Bank;
use crate::core::effects::{Effect, Scope, Setting, Shape};
use crate::core::model::Term;
use crate::core::numerics::basis::{axpy, dot, scale};
use crate::core::numerics::median::median_of;

/// Dwells that are proposed at most.
const PROPOSED: usize = 4;

/// As many of them are first for what the named ones are tied to.
const FOR_CLASSES: usize = PROPOSED / 2;

/// Separation, in squared standard deviations, at which a question counts as settled.
const SETTLED: f64 = 25.0;

/// Least separation that a dwell must add to be worth an hour of table time.
const WORTH: f64 = 1.0;
/// The same of what the named ones are tied to: one dwell at another rate tells little, several in both senses do.
const WORTH_FOR_CLASSES: f64 = 0.01;

/// One question: does the signal come from `asked`, or can the model, with `other` where there is one, absorb it?
struct Question {
    effects: Vec<Effect>,
    /// Signal in each dwell, old then proposed, in standard deviations.
    signal: Vec<f64>,
    /// What may absorb it, in standard deviations.
    columns: Vec<Vec<f64>>,
}

/// Greedy choice, first for what ties the named ones; `classes` are those of the adopted parts, in their order.
pub(crate) fn next_dwells(
    frame: &Frame,
    bank: &Bank,
    parts: &[Part],
    fit: &Fit,
    classes: &[Vec<Effect>],
    g_confounders: &[GConfounder],
) -> Vec<NextDwell> {
    let proposals = proposals(frame);
    let setting = extended(&frame.setting, &proposals);
    let mut questions = tied(frame, &setting, parts, fit, classes);
    let of_classes = questions.len();
    questions.extend(hidden(frame, &setting, bank));
    questions.extend(g_confounders.iter().map(|mimic| confounded(frame, &setting, mimic)));
    let n = frame.dwells();
    let mut taken: Vec<usize> = Vec::new();
    let mut chosen = Vec::new();
    while chosen.len() < PROPOSED {
        let gains: Vec<Vec<f64>> = questions.iter().map(|q| q.gains(n, &taken, proposals.len())).collect();
        let tells_class = gains[..of_classes].iter().flatten().any(|gain| *gain > WORTH_FOR_CLASSES);
        let first = chosen.len() < FOR_CLASSES && tells_class;
        let asked = if first { &gains[..of_classes] } else { &gains[..] };
        let total = |p: usize| asked.iter().map(|gain| gain[p].min(SETTLED)).sum::<f64>();
        let open = (0..proposals.len()).filter(|p| !taken.contains(p));
        let Some(best) = open.max_by(|&a, &b| total(a).total_cmp(&total(b))) else { break };
        let mut separates: Vec<Effect> = Vec::new();
        for (q, (question, gain)) in questions.iter().zip(&gains).enumerate() {
            if gain[best] > if q < of_classes { WORTH_FOR_CLASSES } else { WORTH } {
                separates.extend(question.effects.iter().filter(|e| !separates.contains(e)).collect::<Vec<_>>());
            }
        }
        if separates.is_empty() {
            break;
        }
        let (phase, force, rate, c) = proposals[best];
        let earth = frame.setting.earth_nav.z;
        let table_rate_arcsec_s = if phase == Phase::Rate { rate.dot(&c.column(2)) - earth } else { 0.0 };
        chosen.push(NextDwell {
            phase,
            specific_force_g0: force,
            rate_arcsec_s: rate,
            attitude: c,
            table_rate_arcsec_s,
            separates,
        });
        taken.push(best);
    }
    chosen
}

type Proposal = (Phase, Vector3<f64>, Vector3<f64>, Matrix3<f64>);

/// Six faces with four headings, twelve edges at 45 degrees, twenty-four tilts of 30 and 60, and rates about each axis
/// up and down in both senses.
fn proposals(frame: &Frame) -> Vec<Proposal> {
    let s = &frame.setting;
    let mut list = Vec::new();
    let still = |up: Vector3<f64>, heading: f64| {
        let c = attitude(up, heading);
        (Phase::Static, c * Vector3::new(0.0, 0.0, s.gravity), c * s.earth_nav, c)
    };
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    for axis in axes.iter().flat_map(|a| [*a, -a]) {
        list.extend((0..4).map(|q| still(axis, f64::from(q) * std::f64::consts::FRAC_PI_2)));
    }
    for (i, a) in axes.iter().enumerate() {
        let b = axes[(i + 1) % 3];
        for (p, q) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            for angle in [45.0_f64, 30.0, 60.0] {
                list.push(still(a * (p * angle.to_radians().cos()) + b * (q * angle.to_radians().sin()), 0.0));
            }
        }
    }
    let top = s.rate.iter().map(Vector3::amax).fold(0.0, f64::max);
    let top = if top > 100.0 { top } else { 3600.0 };
    for up in axes.iter().flat_map(|a| [*a, -a]) {
        for rate in [top, -top, 0.5 * top, -0.5 * top, 0.1 * top, -0.1 * top] {
            let c = attitude(up, 0.0);
            list.push((Phase::Rate, c * Vector3::new(0.0, 0.0, s.gravity), up * (rate + s.earth_nav.z), c));
        }
    }
    list
}

/// C with the body axis `up` along nav's up, turned about it by `heading`.
fn attitude(up: Vector3<f64>, heading: f64) -> Matrix3<f64> {
    let up = up.normalize();
    let aside = if up.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let east = aside.cross(&up).normalize();
    let east = east * heading.cos() + up.cross(&east) * heading.sin();
    Matrix3::from_columns(&[east, up.cross(&east), up])
}

/// The campaign with each proposal next after it, at its mean temperature.
fn extended(s: &Setting, proposals: &[Proposal]) -> Setting {
    let mut all = s.clone();
    let duration = s.duration.last().copied().unwrap_or(1.0);
    // Each would be the next one, and none comes after all others.
    let next = s.time.last().copied().unwrap_or(0.0) + s.interval();
    for (phase, force, rate, c) in proposals {
        all.phase.push(*phase);
        all.force.push(*force);
        all.rate.push(*rate);
        all.time.push(next);
        all.duration.push(duration);
        if let Some(t) = all.temperature.as_mut() {
            t.push(0.0);
        }
        if let Some(attitudes) = all.nav_to_body.as_mut() {
            attitudes.push(*c);
        }
    }
    all
}

/// Standard deviation of gyro `j` in every dwell, old and proposed: the proposed ones have the campaign's median.
fn deviations(frame: &Frame, j: usize, total: usize) -> Vec<f64> {
    let mut sd = frame.gyros[j].sd.clone();
    let usual = median_of(sd.iter().copied()).unwrap_or(1.0);
    sd.resize(total, usual);
    sd
}

fn whitened(column: Vec<f64>, sd: &[f64], factor: f64) -> Vec<f64> {
    column.iter().zip(sd).map(|(x, sd)| x * factor / sd).collect()
}

/// Columns of the model in use over old and proposed dwells; without those that no old dwell excites, because E is held
/// or nothing ever turned: of them no proposal could be predicted, and none would seem worth its time.
fn model(frame: &Frame, setting: &Setting, j: usize, sd: &[f64]) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::new(); frame.terms.columns()];
    let mut row = Vec::new();
    for (a, w) in setting.force.iter().zip(&setting.rate) {
        row.clear();
        frame.terms.push_row(a, w, &mut row);
        columns.iter_mut().zip(&row).for_each(|(column, x)| column.push(*x));
    }
    let slot = setting.gyros[j].slot;
    for adopted in frame.adopted.iter().filter(|adopted| adopted.slots.contains(&slot)) {
        columns.extend((adopted.effect.entry().columns)(setting, j, adopted.shape));
    }
    columns.retain(|column| column[..frame.dwells()].iter().any(|x| *x != 0.0));
    columns.into_iter().map(|column| whitened(column, sd, 1.0)).collect()
}

/// Adopted effects against each other member of their class, in the gyro where they are strongest.
fn tied(frame: &Frame, setting: &Setting, parts: &[Part], fit: &Fit, classes: &[Vec<Effect>]) -> Vec<Question> {
    let mut questions = Vec::new();
    for (p, (part, class)) in parts.iter().zip(classes).enumerate() {
        for &other in class.iter().filter(|other| **other != part.effect) {
            let strength = |j: usize| fit.drift_of((p, part), setting, j).iter().map(|x| x * x).sum::<f64>();
            let Some(j) = (0..frame.gyros.len())
                .filter(|j| part.members[*j])
                .max_by(|&a, &b| strength(a).total_cmp(&strength(b)))
            else {
                continue;
            };
            let sd = deviations(frame, j, setting.dwells());
            let mut columns = model(frame, setting, j, &sd);
            for column in (other.entry().columns)(setting, j, likeliest(frame, other)) {
                columns.push(whitened(column, &sd, 1.0));
            }
            let signal = whitened(fit.drift_of((p, part), setting, j), &sd, 1.0 / fit.variances[j].sqrt());
            questions.push(Question { effects: vec![part.effect, other], signal, columns });
        }
    }
    questions
}

/// A shape of an entry to stand for all of them: the middle one.
fn likeliest(frame: &Frame, effect: Effect) -> Shape {
    let shapes = (effect.entry().shapes)(&frame.setting);
    shapes[shapes.len() / 2].0
}

/// Entries of the gyros that the design hides, at a typical size, against the model alone.
fn hidden(frame: &Frame, setting: &Setting, bank: &Bank) -> Vec<Question> {
    let held = |id: &str| frame.terms.iter().any(|term| term.name() == id);
    let mut questions = Vec::new();
    for entry in frame.nameable().filter(|entry| entry.scope == Scope::Gyro && !entry.closure_only && !held(entry.id)) {
        if (entry.missing)(&frame.setting).is_some() || visible(bank, entry.effect) > 0.01 {
            continue;
        }
        let sd = deviations(frame, 0, setting.dwells());
        let columns = (entry.columns)(setting, 0, likeliest(frame, entry.effect));
        // Each coefficient at the geometric mean of what is met in practice.
        let size = (entry.typical[0] * entry.typical[1]).sqrt();
        for column in columns {
            questions.push(Question {
                effects: vec![entry.effect],
                signal: whitened(column, &sd, size),
                columns: model(frame, setting, 0, &sd),
            });
        }
    }
    questions
}

/// An entry that hides in g_linear, as large as it may be without being seen.
fn confounded(frame: &Frame, setting: &Setting, mimic: &GConfounder) -> Question {
    let sd = deviations(frame, mimic.gyro, setting.dwells());
    let mut columns = model(frame, setting, mimic.gyro, &sd);
    columns.extend((0..3).map(|axis| whitened(setting.column(|k| setting.force[k][axis]), &sd, 1.0)));
    let raw = (mimic.effect.entry().columns)(setting, mimic.gyro, mimic.shape);
    let mut signal = vec![0.0; setting.dwells()];
    for column in raw {
        axpy(1.0, &whitened(column, &sd, 1.0), &mut signal);
    }
    let old = &signal[..frame.dwells()];
    let mut beside = frame.gyros[mimic.gyro].basis.clone();
    for axis in 0..3 {
        beside.push(frame.gyros[mimic.gyro].whiten(frame.setting.column(|k| frame.setting.force[k][axis])));
    }
    let mut seen = old.to_vec();
    beside.project_out(&mut seen);
    let seen = dot(&seen, &seen).sqrt();
    let size = if seen > 0.0 { JUST_MISSED / seen } else { 0.0 };
    scale(size, &mut signal);
    let effects = [mimic.effect].into_iter().chain(Effect::of_term(Term::GLinear)).collect();
    Question { effects, signal, columns }
}

impl Question {
    /// What each proposed dwell adds to the power that nothing absorbs: e^2 / (1 + z' (X'X)^-1 z), with e the error of
    /// predicting the signal there from the old dwells.
    fn gains(&self, n: usize, taken: &[usize], proposals: usize) -> Vec<f64> {
        let rows: Vec<usize> = (0..n).chain(taken.iter().map(|p| n + p)).collect();
        let m = self.columns.len();
        let lengths: Vec<f64> =
            self.columns.iter().map(|c| rows.iter().map(|&k| c[k] * c[k]).sum::<f64>().sqrt().max(1e-12)).collect();
        let design = DMatrix::from_fn(rows.len(), m, |r, c| self.columns[c][rows[r]] / lengths[c]);
        let signal = DVector::from_iterator(rows.len(), rows.iter().map(|&k| self.signal[k]));
        // A touch of ridge gives null directions a finite price instead of none.
        let Some(inverse) = (design.tr_mul(&design) + DMatrix::identity(m, m) * 1e-9).cholesky() else {
            return vec![0.0; proposals];
        };
        let estimate = inverse.solve(&design.tr_mul(&signal));
        (0..proposals)
            .map(|p| {
                let z = DVector::from_fn(m, |c, _| self.columns[c][n + p] / lengths[c]);
                let error = self.signal[n + p] - z.dot(&estimate);
                error * error / (1.0 + z.dot(&inverse.solve(&z)))
            })
            .collect()
    }
}
