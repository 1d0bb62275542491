//! From fitted E and G to D_I, D_S, D_O, with the covariance of the fit carried through.

use super::{Calibration, GyroCalibration, ScaleSource};
use crate::core::model::Term;
use crate::core::mounting::Geometry;
use crate::core::record::Plausibility;
use crate::core::separate::{CovarianceEg, Separation, separate};

/// Smallest |E|/sd for which a quotient by E, and its first-order covariance, mean anything.
const LEAST_SCALE_TO_NOISE: f64 = 10.0;

/// Why a fitted gyro has no drift coefficients in deg/(h g0).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotSeparated {
    #[error("the model has no g_linear term: no acceleration-sensitive drift was fitted")]
    NoDrift,
    #[error(
        "E is neither fitted (no scale term) nor held (known_e_pulse_per_arcsec): G stays in pulse/(s g0) and D_I, D_S cannot be had in deg/(h g0)"
    )]
    NoScale,
    #[error("the dwells do not determine {}; {}", .parameters.join(", "), .needs)]
    Undetermined { parameters: Vec<&'static str>, needs: &'static str },
    #[error("E is not resolved from the noise: |E| is {ratio:.1} of its standard deviations")]
    ScaleInNoise { ratio: f64 },
    #[error("the fitted E is impossible: {0}")]
    Implausible(String),
    #[error("{0}")]
    Unseparable(#[from] crate::core::separate::Unseparable),
}

impl GyroCalibration {
    /// Covariance of (E, G) with its cross terms, where the noise is known. A held E has none of its own.
    pub fn covariance_eg(&self) -> Option<CovarianceEg> {
        let full = self.covariance.as_ref()?;
        let column = |term| self.terms.contains(term).then(|| super::design::first_column(self.terms, term));
        let places = [column(Term::Scale), column(Term::GLinear)];
        let mut eg = CovarianceEg::zeros();
        for (i, row) in places.iter().enumerate() {
            for (j, col) in places.iter().enumerate() {
                if let (Some(row), Some(col)) = (row, col) {
                    eg.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&full.view((*row, *col), (3, 3)));
                }
            }
        }
        Some(eg)
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
        let covariance = self.covariance_eg();
        if let Some(ratio) = covariance.map(|c| e.norm() / c.fixed_view::<3, 3>(0, 0).trace().max(0.0).sqrt())
            && ratio < LEAST_SCALE_TO_NOISE
        {
            return Err(NotSeparated::ScaleInNoise { ratio });
        }
        limits.check_scale(&e, geometry, self.slot).map_err(NotSeparated::Implausible)?;
        Ok(separate(geometry, self.slot, &e, &g, covariance.as_ref())?)
    }

    fn check_determined(&self) -> Result<(), NotSeparated> {
        let missing = |term| -> Vec<&'static str> {
            self.of(term).unwrap_or_default().iter().filter(|p| !p.determined).map(|p| p.name).collect()
        };
        let (g, e) = (missing(Term::GLinear), missing(Term::Scale));
        let needs = match (g.is_empty(), e.is_empty()) {
            (true, true) => return Ok(()),
            (false, true) => "dwells with other directions of the specific force are needed",
            (true, false) => "dwells with other rates are needed",
            (false, false) => "dwells with other directions of the specific force and other rates are needed",
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
