//! The error model (6) as a set of terms, and the design columns that each term contributes.
//!
//! N = D0 + G.A + P.A^2 + E.w (pulse/s), with A in g0 and w in arcsec/s, both in body axes. The printed text
//! under (6) calls the nine E "drift coefficients"; they are scale/installation terms, and the nine G are meant.

use crate::core::named::named;
use nalgebra::Vector3;

named! {
/// One group of columns of model (6).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Term {
    /// D0, pulse/s: one column of ones.
    Bias = "bias",
    /// G, pulse/(s g0): A_x, A_y, A_z.
    GLinear = "g_linear",
    /// P, pulse/(s g0^2): A_x^2, A_y^2, A_z^2.
    GSquared = "g_squared",
    /// E, pulse/arcsec: w_x, w_y, w_z.
    Scale = "scale",
}
}

impl Term {
    /// Number of its parameters in one gyro.
    pub fn columns(self) -> usize {
        match self {
            Term::Bias => 1,
            _ => 3,
        }
    }
}

/// A subset of model (6)'s terms, in the order of [`Term::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Terms([bool; 4]);

impl Terms {
    /// Model (6) whole: bias, G, P and E.
    pub const MODEL_6: Terms = Terms([true; 4]);

    /// The set of these terms; one that is named twice counts once.
    pub fn of(terms: &[Term]) -> Self {
        let mut set = [false; 4];
        for &term in terms {
            set[term as usize] = true;
        }
        Self(set)
    }

    /// Whether the term is in the set.
    pub fn contains(self, term: Term) -> bool {
        self.0[term as usize]
    }

    /// The set less one term.
    pub fn without(mut self, term: Term) -> Self {
        self.0[term as usize] = false;
        self
    }

    /// Its terms, in the order of [`Term::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Term> {
        Term::ALL.into_iter().filter(move |&term| self.contains(term))
    }

    /// Whether no term is left.
    pub fn is_empty(self) -> bool {
        self == Self([false; 4])
    }

    /// Number of design columns.
    pub fn columns(self) -> usize {
        self.iter().map(Term::columns).sum()
    }

    /// Appends one dwell's row of the design matrix: `a` in g0, `w` in arcsec/s, both in body axes.
    pub fn push_row(self, a: &Vector3<f64>, w: &Vector3<f64>, row: &mut Vec<f64>) {
        for term in self.iter() {
            match term {
                Term::Bias => row.push(1.0),
                Term::GLinear => row.extend(a.iter()),
                Term::GSquared => row.extend(a.iter().map(|x| x * x)),
                Term::Scale => row.extend(w.iter()),
            }
        }
    }
}

impl Default for Terms {
    fn default() -> Self {
        Self::MODEL_6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_of_model_6_is_bias_g_p_e() {
        let mut row = Vec::new();
        Terms::MODEL_6.push_row(&Vector3::new(1.0, -2.0, 3.0), &Vector3::new(4.0, 5.0, 6.0), &mut row);
        assert_eq!(row, [1.0, 1.0, -2.0, 3.0, 1.0, 4.0, 9.0, 4.0, 5.0, 6.0]);
        assert_eq!(row.len(), Terms::MODEL_6.columns());
    }
}
