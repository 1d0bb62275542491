//! What this campaign could not show, whatever its data: from the design alone.

use crate::core::calibrate::outcome::JUST_MISSED;
use crate::core::diagnose::diagnosis::NotIdentifiable;
use crate::core::diagnose::residuals::augmented_fit::Part;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::hypotheses::Bank;
use crate::core::effects::{Effect, Entry, Shape};
use crate::core::message::{Message, figure, significant, text};
use crate::core::model::Term;
use crate::core::numerics::basis::{Basis, dot};
use crate::message;

/// Visible share of power below which an entry is listed: less than three per cent of its amplitude shows.
const LITTLE: f64 = 1e-3;

/// Share of an entry's power in the span of g_linear from which on the two are called confounded: 45 deg.
const SHARED: f64 = 0.5;

/// Span below which temperatures may be too steady for effects that are as large as usual, K.
const STEADY_K: f64 = 1.0;

/// Entries that the campaign lacks a column for, that the model in use absorbs, that temperatures are too steady for, or
/// that hide in D_I and D_S. `variances` are those of the noise, gyro by gyro, over that of the frame.
pub(crate) fn not_identifiable(
    (frame, bank): (&Frame, &Bank),
    (parts, variances): (&[Part], &[f64]),
    g_confounders: &[GConfounder],
) -> Vec<NotIdentifiable> {
    let open = |entry: &&Entry| !held(frame, entry);
    let named = |entry: &Entry| parts.iter().any(|part| part.effect == entry.effect);
    let steady = |entry: &Entry| if named(entry) { None } else { too_steady(frame, variances, entry) };
    let unseen = |entry: &'static Entry| judged(frame, bank, entry).or_else(|| steady(entry));
    let mut list: Vec<NotIdentifiable> = frame.nameable().filter(open).filter_map(unseen).collect();
    let further: Vec<&GConfounder> =
        g_confounders.iter().filter(|m| list.iter().all(|n| n.effect != m.effect)).collect();
    list.extend(further.into_iter().map(GConfounder::not_identifiable));
    list
}

/// An entry whose regressor nearly lies in the span of g_linear, in every shape and gyro: what is too small to be
/// seen of it still moves G, hence D_I and D_S. Bias is taken out of both first: every campaign has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GConfounder {
    pub effect: Effect,
    pub shape: Shape,
    pub gyro: usize,
    /// Share of the regressor's power in the span of g_linear: the squared cosine of the principal angle.
    pub shared: f64,
    /// Share of it that the model in use, g_linear included, leaves over.
    pub visible: f64,
}

/// The entries that this design confounds with g_linear, where that is in the model or was named.
pub(crate) fn g_confounders(frame: &Frame, bank: &Bank, parts: &[Part]) -> Vec<GConfounder> {
    let named = |effect: Effect| parts.iter().any(|part| part.effect == effect);
    if !frame.terms.contains(Term::GLinear) && !parts.iter().any(|part| part.effect.term() == Some(Term::GLinear)) {
        return Vec::new();
    }
    let open = |entry: &&Entry| {
        !held(frame, entry) && !entry.closure_only && !named(entry.effect) && (entry.missing)(&frame.setting).is_none()
    };
    // What is seen beside the bias and the model is not shared with g_linear.
    let doubtful = |entry: &&Entry| visible(bank, entry.effect) < 1.0 - SHARED;
    let spans: Vec<Spans> = (0..frame.gyros.len()).map(|j| Spans::of(frame, j)).collect();
    frame.nameable().filter(open).filter(doubtful).filter_map(|entry| GConfounder::of(frame, &spans, entry)).collect()
}

/// What regressors of one gyro are held against.
struct Spans {
    bias: Basis,
    /// g_linear beside the bias.
    g: Basis,
    /// The model in use, with g_linear.
    model: Basis,
}

impl Spans {
    fn of(frame: &Frame, j: usize) -> Self {
        let (gyro, n) = (&frame.gyros[j], frame.dwells());
        let constant = frame.terms.contains(Term::Bias).then(|| gyro.whiten(vec![1.0; n]));
        let bias = Basis::of(constant);
        let (mut g, mut model) = (bias.clone(), gyro.basis.clone());
        for axis in 0..3 {
            let column = gyro.whiten(frame.setting.column(|k| frame.setting.force[k][axis]));
            g.push(column.clone());
            model.push(column);
        }
        Self { g: g.split_off(bias.rank()), bias, model }
    }

    /// Shares of a whitened column, bias taken out, in g_linear and beside the model; none of a mere bias.
    fn shares(&self, mut column: Vec<f64>) -> Option<(f64, f64)> {
        let raw = dot(&column, &column);
        self.bias.project_out(&mut column);
        let whole = dot(&column, &column);
        if whole.is_nan() || whole <= 1e-12 * raw {
            return None;
        }
        let shared: f64 = self.g.vectors().iter().map(|q| dot(q, &column).powi(2)).sum();
        self.model.project_out(&mut column);
        Some((shared / whole, dot(&column, &column) / whole))
    }
}

impl GConfounder {
    /// The shape and gyro in which the entry is least confounded, where even there it is.
    fn of(frame: &Frame, spans: &[Spans], entry: &Entry) -> Option<Self> {
        let shapes = (entry.shapes)(&frame.setting);
        let all = shapes.iter().flat_map(|(shape, _)| spans.iter().enumerate().map(move |(j, s)| (*shape, j, s)));
        let each = all.filter_map(|(shape, gyro, spans)| {
            let columns = (entry.columns)(&frame.setting, gyro, shape).into_iter();
            let shares: Vec<_> = columns.filter_map(|c| spans.shares(frame.gyros[gyro].whiten(c))).collect();
            let mean = |pick: fn(&(f64, f64)) -> f64| shares.iter().map(pick).sum::<f64>() / shares.len() as f64;
            let (shared, visible) = (mean(|s| s.0), mean(|s| s.1));
            (!shares.is_empty()).then_some(Self { effect: entry.effect, shape, gyro, shared, visible })
        });
        each.min_by(|a, b| a.shared.total_cmp(&b.shared)).filter(|mimic| mimic.shared > SHARED)
    }

    /// By how many standard deviations what is just missed of it moves D_I and D_S at most.
    fn hidden_shift(&self) -> f64 {
        JUST_MISSED * (self.shared / self.visible.max(1e-6)).sqrt()
    }

    fn not_identifiable(&self) -> NotIdentifiable {
        let angle = self.shared.min(1.0).sqrt().acos().to_degrees();
        NotIdentifiable {
            effect: self.effect,
            visible_fraction: self.visible,
            confounded_with: Effect::of_term(Term::GLinear).into_iter().collect(),
            reason: message!(
                "hard_to_tell_from_g_linear",
                share = figure(100.0 * self.shared, 0),
                angle = figure(angle, 0),
                sds = figure(self.hidden_shift(), 0)
            ),
        }
    }
}

/// Terms and effects of the model in use are fitted, not sought.
fn held(frame: &Frame, entry: &Entry) -> bool {
    frame.terms.iter().any(|term| term.name() == entry.id)
        || frame.adopted.iter().any(|adopted| adopted.effect == entry.effect)
}

/// Whether it is listed as what this design cannot show: then it is no name.
pub(crate) fn is_unseen(frame: &Frame, bank: &Bank, effect: Effect) -> bool {
    judged(frame, bank, effect.entry()).is_some()
}

fn judged(frame: &Frame, bank: &Bank, entry: &Entry) -> Option<NotIdentifiable> {
    let listed = |visible_fraction: f64, reason: Message| {
        Some(NotIdentifiable { effect: entry.effect, visible_fraction, confounded_with: Vec::new(), reason })
    };
    if entry.closure_only {
        return listed(0.0, message!("seen_in_closure_of_g_only"));
    }
    if let Some(lack) = (entry.missing)(&frame.setting) {
        return listed(0.0, lack.message());
    }
    let visible = visible(bank, entry.effect);
    if visible >= LITTLE {
        return None;
    }
    let reason = match visible > 1e-12 {
        true => message!("mostly_absorbed_by_model", share = format!("{visible:.1e}")),
        false => message!("absorbed_by_model"),
    };
    listed(visible, reason)
}

/// An entry of temperature that, as large as it usually is at most, would more often be missed than named.
fn too_steady(frame: &Frame, variances: &[f64], entry: &Entry) -> Option<NotIdentifiable> {
    let (most, temperature) = (entry.typical[1], frame.setting.temperature.as_ref().filter(|_| entry.of_temperature)?);
    let extreme = |pick: fn(f64, f64) -> f64| temperature.iter().copied().reduce(pick);
    let span = extreme(f64::max)? - extreme(f64::min)?;
    if span > STEADY_K || most <= 0.0 {
        return None;
    }
    let (mut longest, mut visible_fraction) = (0.0_f64, 0.0_f64);
    for (shape, _) in (entry.shapes)(&frame.setting) {
        for (j, (gyro, variance)) in frame.gyros.iter().zip(variances).enumerate() {
            for column in (entry.columns)(&frame.setting, j, shape) {
                let mut left = gyro.whiten(column);
                let whole = dot(&left, &left);
                gyro.basis.project_out(&mut left);
                let power = dot(&left, &left);
                longest = longest.max((power / variance).sqrt());
                visible_fraction = visible_fraction.max(power / whole.max(f64::MIN_POSITIVE));
            }
        }
    }
    (longest * most < JUST_MISSED).then(|| NotIdentifiable {
        effect: entry.effect,
        visible_fraction,
        confounded_with: Vec::new(),
        reason: message!(
            "temperature_too_steady",
            span = significant(span, 2),
            least = significant(JUST_MISSED / longest.max(f64::MIN_POSITIVE), 2),
            most = text(most),
            unit = entry.unit
        ),
    })
}

/// Largest visible share over shapes and gyros.
pub(crate) fn visible(bank: &Bank, effect: Effect) -> f64 {
    let own = bank.hypotheses.iter().filter(|h| h.kind == effect);
    own.flat_map(|h| &h.blocks).map(|block| block.visible).fold(0.0, f64::max)
}
