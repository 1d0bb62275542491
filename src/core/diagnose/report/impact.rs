//! What the adopted effects do to D_I and D_S: the coefficients of the plain and of the augmented model.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::core::diagnose::diagnosis::{BUDGET_DEG_PER_H_G0, Impact};
use crate::core::diagnose::residuals::augmented_fit::{Fit, Part};
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::model::Term;
use crate::core::numerics::least_squares::Factor;

/// Shift of D_I and D_S of every gyro; empty where neither model holds G.
pub(crate) fn impact(frame: &Frame, parts: &[Part], fit: &Fit) -> Vec<Impact> {
    let g_in_model = frame.terms.contains(Term::GLinear);
    let g_adopted = parts.iter().any(|part| part.effect.term() == Some(Term::GLinear));
    if parts.is_empty() || !(g_in_model || g_adopted) {
        return Vec::new();
    }
    (0..frame.gyros.len()).flat_map(|j| of_gyro(frame, parts, fit, j, g_in_model)).collect()
}

fn of_gyro(frame: &Frame, parts: &[Part], fit: &Fit, j: usize, g_in_model: bool) -> Vec<Impact> {
    let gyro = &frame.setting.gyros[j];
    let plain = Coefficients::of(frame, j, &frame.outputs[j], &[], fit.variances[j]);
    let corrected: Vec<f64> = frame.outputs[j].iter().zip(&fit.drift[j]).map(|(y, d)| y - d).collect();
    let own: Vec<&Part> = parts.iter().filter(|part| part.members[j] && !part.common()).collect();
    let mut augmented = Coefficients::of(frame, j, &corrected, &[], fit.variances[j]);
    augmented.g += adopted_g(parts, fit, j);
    let spread = Coefficients::of(frame, j, &frame.outputs[j], &own, fit.variances[j]);
    [("D_I", gyro.input), ("D_S", gyro.spin)]
        .into_iter()
        .map(|(coefficient, axis)| {
            let before = if g_in_model { plain.along(&axis) } else { 0.0 };
            let after = augmented.along(&axis);
            Impact {
                slot: gyro.slot,
                coefficient,
                plain: before,
                augmented: after,
                augmented_sd: spread.sd_along(&axis),
                shift: after - before,
                of_budget: (after - before).abs() / BUDGET_DEG_PER_H_G0,
            }
        })
        .collect()
}

/// G where it was adopted as an effect, deg/(h g0).
fn adopted_g(parts: &[Part], fit: &Fit, j: usize) -> Vector3<f64> {
    let values: Vec<f64> = fit
        .fitted
        .iter()
        .filter(|f| parts[f.part].effect.term() == Some(Term::GLinear) && f.gyro == Some(j))
        .map(|f| f.value)
        .collect();
    if values.len() == 3 { Vector3::from_column_slice(&values) } else { Vector3::zeros() }
}

/// G of one fit, relative to its scale factor.
struct Coefficients {
    g: Vector3<f64>,
    /// Covariance of G, 3 x 3.
    covariance: DMatrix<f64>,
    /// |E| of this fit over the one that outputs were divided by.
    scale: f64,
}

impl Coefficients {
    fn of(frame: &Frame, j: usize, output: &[f64], further: &[&Part], variance: f64) -> Self {
        let mut columns: Vec<Vec<f64>> = frame.designs[j].clone();
        let from_g = offset(frame, Term::GLinear);
        let from_e = offset(frame, Term::Scale).filter(|_| frame.scale_fitted[j]);
        for part in further {
            // G adopted as an effect is reported from the effect's own fit.
            columns.extend(part.columns(frame, j));
        }
        let from_g = from_g
            .or_else(|| further.iter().any(|p| p.effect.term() == Some(Term::GLinear)).then(|| columns.len() - 3));
        let n = frame.dwells();
        let design = DMatrix::from_fn(n, columns.len(), |k, c| columns[c][k]);
        let fit = Factor::new(design, &frame.gyros[j].sd).fit(&DVector::from_column_slice(output));
        let triple = |at: usize| Vector3::new(fit.estimate[at], fit.estimate[at + 1], fit.estimate[at + 2]);
        let scale = from_e.map_or(1.0, |at| triple(at).norm());
        Self {
            g: from_g.map_or_else(Vector3::zeros, triple),
            covariance: from_g
                .map_or_else(|| DMatrix::zeros(3, 3), |at| fit.covariance.view((at, at), (3, 3)) * variance),
            scale: if scale > 0.5 { scale } else { 1.0 },
        }
    }

    /// deg/(h g0) along a unit vector of the body.
    fn along(&self, axis: &Vector3<f64>) -> f64 {
        self.g.dot(axis) / self.scale
    }

    fn sd_along(&self, axis: &Vector3<f64>) -> f64 {
        let axis = DVector::from_column_slice(axis.as_slice());
        (&self.covariance * &axis).dot(&axis).max(0.0).sqrt() / self.scale
    }
}

/// First column of a term in the design.
fn offset(frame: &Frame, term: Term) -> Option<usize> {
    frame.terms.contains(term).then(|| frame.terms.iter().take_while(|t| *t != term).map(Term::columns).sum())
}
