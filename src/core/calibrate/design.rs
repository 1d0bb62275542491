//! Model (6) as a design matrix, and the gauge that it needs at constant |a|.

use std::rc::Rc;

use nalgebra::{DMatrix, DVector};

use crate::core::campaign::Dwell;
use crate::core::model::{Term, Terms};
use crate::core::numerics::least_squares::Factor;

/// Spread of |a|^2, or of a_I^2 + a_S^2 (standard deviation over mean) below which it counts as constant.
///
/// Two per cent of |a| is what a static dwell may be off the site's gravity (measured specific force is accepted),
/// and what differs by less is rounding or accelerometer noise. To fit along it would be to fit noise.
const CONSTANT_FORCE_SPREAD: f64 = 0.02;

/// Parameters of the model by name, in the order of [`Terms::push_row`].
pub fn parameter_names(terms: Terms) -> Vec<&'static str> {
    terms
        .iter()
        .flat_map(|term| match term {
            Term::Bias => &["D0"][..],
            Term::GLinear => &["G_x", "G_y", "G_z"],
            Term::GSquared => &["P_x", "P_y", "P_z"],
            Term::Scale => &["E_x", "E_y", "E_z"],
        })
        .copied()
        .collect()
}

/// Unit of a term's parameters as answers write it.
pub fn unit(term: Term) -> &'static str {
    match term {
        Term::Bias => "pulse/s",
        Term::GLinear => "pulse/(s*g0)",
        Term::GSquared => "pulse/(s*g0^2)",
        Term::Scale => "pulse/arcsec",
    }
}

/// The design, reduced to a basis of the parameters that obey the gauge.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    pub terms: Terms,
    /// n x q: what is fitted.
    pub reduced: DMatrix<f64>,
    /// p x q: turns the q fitted numbers into the p parameters; the identity without a gauge.
    pub expand: DMatrix<f64>,
    /// Along this unit vector of the p parameters nothing changes; the gauge (sum of P = 0) fixes it.
    pub gauge: Option<DVector<f64>>,
}

impl Design {
    /// For dwells that are given, and at least one term.
    ///
    /// At 1 g, A_x^2 + A_y^2 + A_z^2 is one number in all dwells: what D0 gains, the three P can lose. Where |a| is
    /// constant and both terms are fitted, P_x + P_y + P_z = 0 is imposed instead of leaving it to rounding.
    pub fn new(dwells: &[Dwell], terms: Terms) -> Self {
        let p = terms.columns();
        let full = model_matrix(dwells, terms);
        let squared = mean_if_constant(dwells.iter().map(|d| d.specific_force_g0.norm_squared()));
        match (squared, terms.contains(Term::Bias) && terms.contains(Term::GSquared)) {
            (Some(squared), true) => Self::gauged(full, terms, squared),
            _ => Self { terms, reduced: full, expand: DMatrix::identity(p, p), gauge: None },
        }
    }

    fn gauged(full: DMatrix<f64>, terms: Terms, squared_force: f64) -> Self {
        let p = terms.columns();
        let bias = first_column(terms, Term::Bias);
        let p_x = first_column(terms, Term::GSquared);
        let mut direction = DVector::zeros(p);
        direction[bias] = squared_force;
        direction.rows_mut(p_x, 3).fill(-1.0);
        // P_x = -P_y - P_z leaves the parameters as they are but for P_x, which is no longer free.
        let mut expand = DMatrix::identity(p, p).remove_column(p_x);
        expand.row_mut(p_x).columns_mut(p_x, 2).fill(-1.0);
        Self { terms, reduced: full * &expand, expand, gauge: Some(direction.normalize()) }
    }
}

/// The columns of the terms, dwell by dwell.
pub fn model_matrix(dwells: &[Dwell], terms: Terms) -> DMatrix<f64> {
    let mut rows = Vec::with_capacity(dwells.len() * terms.columns());
    for dwell in dwells {
        terms.push_row(&dwell.specific_force_g0, &dwell.rate_arcsec_s, &mut rows);
    }
    DMatrix::from_row_iterator(dwells.len(), terms.columns(), rows)
}

/// A design, and its factorisation for rows of standard deviations `sd`.
#[derive(Debug)]
pub(super) struct WeightedDesign {
    pub design: Design,
    pub sd: Vec<f64>,
    pub factor: Factor,
}

impl WeightedDesign {
    /// Of at least one column.
    pub fn new(design: Design, sd: Vec<f64>) -> Rc<Self> {
        let factor = Factor::new(design.reduced.clone(), &sd);
        Rc::new(Self { design, sd, factor })
    }
}

/// Column at which a term begins.
pub fn first_column(terms: Terms, wanted: Term) -> usize {
    terms.iter().take_while(|&term| term != wanted).map(Term::columns).sum()
}

/// Mean over the dwells of what their squared force comes to, g0^2, where it is the same in all.
pub(super) fn mean_if_constant(squared: impl ExactSizeIterator<Item = f64> + Clone) -> Option<f64> {
    let n = squared.len() as f64;
    let mean = squared.clone().sum::<f64>() / n;
    let variance = squared.map(|s| (s - mean).powi(2)).sum::<f64>() / n;
    (variance.sqrt() <= CONSTANT_FORCE_SPREAD * mean).then_some(mean)
}
