//! From fitted E and G to D_I, D_S, D_O, with the covariance of the fit carried through.

use nalgebra::DMatrix;

use super::design::first_column;
use super::uncertainty::UncertaintyBudget;
use super::{Calibration, GyroCalibration, ScaleSource};
use crate::core::message::{Message, figure, list};
use crate::core::model::Term;
use crate::core::mounting::Geometry;
use crate::core::record::Plausibility;
use crate::core::separate::{CovarianceEg, Separation, Unseparable, covariance_at, separate};
use crate::message;

/// Smallest |E|/sd for which a quotient by E, and its first-order covariance, mean anything.
pub(super) const LEAST_SCALE_TO_NOISE: f64 = 10.0;

/// Why a fitted gyro has no drift coefficients in deg/(h g0).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{}", self.message())]
pub enum NotSeparated {
    NoDrift,
    NoScale,
    Undetermined {
        parameters: Vec<&'static str>,
        needs: Message,
    },
    ScaleInNoise {
        ratio: f64,
    },
    /// E and G hold a part of a field.
    UntoldField,
    Implausible(Message),
    Unseparable(Unseparable),
}

impl NotSeparated {
    /// The reason as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::NoDrift => message!("no_drift_fitted"),
            Self::NoScale => message!("no_scale_fitted"),
            Self::Undetermined { parameters, needs } => {
                message!(
                    "parameters_undetermined",
                    parameters = list(parameters.iter().copied()),
                    needs = needs.clone()
                )
            }
            Self::ScaleInNoise { ratio } => message!("scale_in_noise", ratio = figure(*ratio, 1)),
            Self::UntoldField => message!("untold_field"),
            Self::Implausible(why) => message!("implausible_scale", why = why.clone()),
            Self::Unseparable(why) => why.message(),
        }
    }
}

impl GyroCalibration {
    /// Covariance of (E, G) with its cross terms, where the noise is known. A held E has none of its own.
    pub fn covariance_eg(&self) -> Option<CovarianceEg> {
        self.covariance.as_ref().map(|full| self.eg_of(full))
    }

    /// (E, G) of a covariance of all parameters.
    pub fn eg_of(&self, full: &DMatrix<f64>) -> CovarianceEg {
        let first = |term| self.terms.contains(term).then(|| first_column(self.terms, term));
        let places = |term| first(term).map(|first| [first, first + 1, first + 2]);
        covariance_at(full, places(Term::Scale), places(Term::GLinear))
    }

    /// Separates the gyro by both methods.
    ///
    /// # Errors
    /// [`NotSeparated`] with the reason.
    pub fn separate(&self, geometry: &Geometry, limits: &Plausibility) -> Result<Separation, NotSeparated> {
        if self.scale_source == ScaleSource::Missing {
            return Err(NotSeparated::NoScale);
        }
        let (Some(e), Some(g)) = (self.e(), self.g()) else { return Err(NotSeparated::NoDrift) };
        self.check_determined()?;
        if self.holds_untold_field {
            return Err(NotSeparated::UntoldField);
        }
        let covariance = self.covariance_eg();
        if let Some(ratio) = covariance.map(|c| e.norm() / c.fixed_view::<3, 3>(0, 0).trace().max(0.0).sqrt())
            && ratio < LEAST_SCALE_TO_NOISE
        {
            return Err(NotSeparated::ScaleInNoise { ratio });
        }
        limits.check_scale(&e, geometry, self.slot).map_err(NotSeparated::Implausible)?;
        separate(geometry, self.slot, &e, &g, covariance.as_ref()).map_err(NotSeparated::Unseparable)
    }

    /// How uncertain D_I, D_S, D_O and |E| are, and why; D_I and D_S by the published equations where those are asked
    /// for and defined.
    pub fn budgets(&self, geometry: &Geometry, published: bool) -> Option<[UncertaintyBudget; 4]> {
        let (e, g) = (self.e()?, self.g()?);
        self.uncertainty.as_ref()?.budgets(|covariance| {
            let separated = separate(geometry, self.slot, &e, &g, Some(&self.eg_of(covariance))).ok()?;
            let [d_i, d_s, d_o] = separated.rigid.sd()?;
            let of_equations = separated.published.ok().filter(|_| published).and_then(|p| p.sd());
            let [d_i, d_s] = of_equations.unwrap_or([d_i, d_s]);
            Some([d_i, d_s, d_o, separated.scale_factor_sd?].map(|sd| sd * sd))
        })
    }

    fn check_determined(&self) -> Result<(), NotSeparated> {
        let missing = |term| -> Vec<&'static str> {
            self.of(term).unwrap_or_default().iter().filter(|p| !p.determined).map(|p| p.name).collect()
        };
        let (g, e) = (missing(Term::GLinear), missing(Term::Scale));
        let needs = match (g.is_empty(), e.is_empty()) {
            (true, true) => return Ok(()),
            (false, true) => message!("needs_directions"),
            (true, false) => message!("needs_rates"),
            (false, false) => message!("needs_directions_and_rates"),
        };
        Err(NotSeparated::Undetermined { parameters: [g, e].concat(), needs })
    }
}

impl Calibration {
    /// The separation of every gyro, or why there is none, in the order of the campaign's gyros.
    pub fn separate(&self, geometry: &Geometry, limits: &Plausibility) -> Vec<Result<Separation, NotSeparated>> {
        self.gyros.iter().map(|gyro| gyro.separate(geometry, limits)).collect()
    }
}
