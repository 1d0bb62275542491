//! What a standard deviation is made of: noise, the station, and what the model leaves out (GUM 2008, 5.1.2: variances
//! add).

use nalgebra::{DMatrix, DVector};

use super::noise::Share;
use crate::core::campaign::StationPart;

/// Covariances of the parameters of one gyro (p x p), part by part.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Of the fit, over all kinds of noise.
    pub(super) fit: DMatrix<f64>,
    /// What white noise as stated has of it, with the weight of that: the other kinds take their size from the
    /// residuals, so that what the model leaves out is in theirs already.
    pub(super) white: DMatrix<f64>,
    pub(super) share: Share,
    /// S diag(u^2) S' of what the station states and the campaign can tell; empty where it does neither.
    pub(super) station: Vec<(StationPart, DMatrix<f64>)>,
    /// A part of the discrepancy: the same of rotations that the residuals contradict, beyond what is stated, and what
    /// rounded rates may have made.
    pub(super) unstated: Option<DMatrix<f64>>,
}

/// What one rotation of its standard uncertainty makes of a gyro's fit.
#[derive(Debug, Clone)]
pub(super) struct StationResponse {
    pub part: StationPart,
    /// Of the estimates.
    pub estimate: DVector<f64>,
    /// Of the residuals, pulse/s.
    pub residuals: DVector<f64>,
    /// By how many times the residuals say that it is larger; 1 where they do not contradict what is stated.
    pub times: f64,
}

impl StationResponse {
    /// S diag(u^2) S' of the parameters that `expand` makes of the estimates, over the rotations of one part.
    pub fn covariance<'a>(of_part: impl Iterator<Item = &'a Self>, expand: &DMatrix<f64>) -> DMatrix<f64> {
        let p = expand.nrows();
        let columns = of_part.map(|response| expand * &response.estimate);
        columns.fold(DMatrix::zeros(p, p), |sum, s| sum + &s * s.transpose())
    }

    /// The same of every part that has any.
    pub fn by_part(responses: &[Self], expand: &DMatrix<f64>) -> Vec<(StationPart, DMatrix<f64>)> {
        let of_part = |part: StationPart| {
            let those = || responses.iter().filter(move |response| response.part == part);
            those().next().map(|_| (part, Self::covariance(those(), expand)))
        };
        StationPart::ALL.into_iter().filter_map(of_part).collect()
    }

    /// The same of those that are contradicted, beyond what is stated.
    pub fn contradicted(responses: &[Self], expand: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let beyond = |response: &Self| {
            let s = expand * &response.estimate;
            &s * s.transpose() * (response.times * response.times - 1.0)
        };
        responses.iter().filter(|response| response.times > 1.0).map(beyond).reduce(|sum, one| sum + one)
    }
}

/// Standard deviations of one figure. `combined` is the root of the sum of the squares of the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UncertaintyBudget {
    pub statistical: f64,
    /// None where nothing is stated, or the campaign cannot tell.
    pub station: Option<f64>,
    /// Of which by part, in the order of [`StationPart::ALL`].
    pub of_station: [Option<f64>; 3],
    /// Zero where residuals are within the noise; none where nothing tests that.
    pub discrepancy: Option<f64>,
    pub combined: f64,
}

impl Uncertainty {
    /// What the model leaves out: in the variance of the fit, or beside that of white noise.
    fn discrepancy(&self) -> Option<DMatrix<f64>> {
        let Share { statistical, discrepancy } = self.share;
        let of_noise = discrepancy.map(|share| if statistical < 1.0 { &self.fit * share } else { &self.white * share });
        of_noise.into_iter().chain(self.unstated.clone()).reduce(|sum, one| sum + one)
    }

    /// What the standard deviations come from.
    pub fn covariance(&self) -> DMatrix<f64> {
        let parts = self.station.iter().map(|(_, part)| part.clone()).chain(self.discrepancy());
        parts.fold(&self.fit * self.share.statistical, |sum, part| sum + part)
    }

    /// `variances` of some figures, each linear in the covariance of the parameters.
    pub fn budgets<const N: usize>(
        &self,
        variances: impl Fn(&DMatrix<f64>) -> Option<[f64; N]>,
    ) -> Option<[UncertaintyBudget; N]> {
        let fit = variances(&self.fit)?;
        let mut of_station = [None; 3];
        for (part, covariance) in &self.station {
            of_station[*part as usize] = Some(variances(covariance)?);
        }
        let discrepancy = match self.discrepancy() {
            Some(covariance) => Some(variances(&covariance)?),
            None => None,
        };
        let statistical = self.share.statistical;
        let sd = |variance: f64| variance.max(0.0).sqrt();
        Some(std::array::from_fn(|i| {
            let of_station: [Option<f64>; 3] = of_station.map(|part| part.map(|variances| variances[i]));
            let station = (!self.station.is_empty()).then(|| of_station.iter().flatten().sum::<f64>());
            let discrepancy = discrepancy.map(|variances| variances[i]);
            let combined = statistical * fit[i] + station.unwrap_or(0.0) + discrepancy.unwrap_or(0.0);
            UncertaintyBudget {
                statistical: sd(statistical * fit[i]),
                station: station.map(sd),
                of_station: of_station.map(|part| part.map(sd)),
                discrepancy: discrepancy.map(sd),
                combined: sd(combined),
            }
        }))
    }
}
