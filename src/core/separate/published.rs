//! The published method: eqs. (7) to (13) of the paper, least squares over the three rows of each gyro.
//!
//! Each of (8)-(13) reads G_r/E = D_I cos(alpha_r) + D_S cos(beta_r), r = x, y, z, with the spin axis at
//! beta_r = base_r + gain_r (alpha_r - Table 1's alpha_r), in degrees. The gains are ratios (change of S angle)/
//! (change of I angle) for *one* turn of 5 deg of the pair about O; see `docs/method.md` for what that costs.
//! The errata are in `docs/method.md` too, each with its proof, and in `tests/errata.rs`.

use nalgebra::{Matrix2, SMatrix, Vector2, Vector3};

use super::normalised::{CovarianceEg, Normalised};
use crate::core::mounting::Slot;
use crate::core::named::named;
use crate::core::units::{degrees, radians};

named! {
/// Which equation resolved the gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    Eq8 = "8",
    Eq9 = "9",
    Eq10 = "10",
    Eq11 = "11",
    Eq12 = "12",
    Eq13 = "13",
}
}

impl Branch {
    /// The condition above (8), (10), (12), on d = alpha - Table 1: all three signs as printed, or all reversed.
    fn choose(slot: Slot, d: [f64; 3]) -> Self {
        let (signs, tilted, untilted) = match slot {
            Slot::G1 => ([1.0, 1.0, 1.0], Branch::Eq8, Branch::Eq9),
            Slot::G2 => ([1.0, 1.0, -1.0], Branch::Eq10, Branch::Eq11),
            Slot::G3 => ([1.0, 1.0, -1.0], Branch::Eq12, Branch::Eq13),
        };
        let all = |sense: f64| (0..3).all(|r| sense * signs[r] * d[r] > 0.0);
        if all(1.0) || all(-1.0) { tilted } else { untilted }
    }
}

/// Why the published method says nothing about a gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotPublished {
    #[error("equations (8) to (13) hold for the skewed geometry only")]
    Geometry,
    #[error("the input and spin directions of equations (8) to (13) coincide for this E")]
    Degenerate,
}

/// What eqs. (8)-(13) give, in deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    pub branch: Branch,
    pub d_i: f64,
    pub d_s: f64,
    /// Root mean square of the three rows' residuals.
    pub closure_rms: f64,
    /// First-order covariance of (D_I, D_S) *within the branch*; the jump between branches is not in it.
    pub covariance: Option<Matrix2<f64>>,
}

impl Published {
    /// Standard deviations of D_I and D_S, where a covariance was given.
    pub fn sd(&self) -> Option<[f64; 2]> {
        self.covariance.map(|c| [0, 1].map(|i| c[(i, i)].max(0.0).sqrt()))
    }

    pub(crate) fn is_finite(&self) -> bool {
        [self.d_i, self.d_s, self.closure_rms].iter().all(|x| x.is_finite())
            && self.covariance.is_none_or(|c| c.iter().all(|x| x.is_finite()))
    }
}

/// Table 1, degrees, as printed: the conditions and (8)-(13) are written with these roundings.
fn table_1(slot: Slot) -> [f64; 3] {
    match slot {
        Slot::G1 => [54.7356, 114.095, 45.0],
        Slot::G2 => [54.7356, 114.095, 135.0],
        Slot::G3 => [54.7356, 35.2644, 90.0],
    }
}

/// Eq. (7): angles of the input axis to the body axes, radians.
pub(crate) fn alpha(input: &Vector3<f64>) -> [f64; 3] {
    [0, 1, 2].map(|r| input[r].clamp(-1.0, 1.0).acos())
}

/// Base and gain of one branch's spin-axis angles, beta_r = base_r + gain_r d_r, degrees: eqs. (8)-(13) with the errata
/// applied, the sign of (10)'s z row, and (12) with alpha_y, alpha_z and S near 0 deg.
fn corrected_angles(branch: Branch) -> ([f64; 3], [f64; 3]) {
    match branch {
        Branch::Eq8 => ([90.0, 30.0, 60.0], [-18.7292, 0.8861, -1.1102]),
        Branch::Eq9 => ([90.0, 30.0, 60.0], [0.0; 3]),
        Branch::Eq10 => ([90.0, 30.0, 120.0], [-18.7292, 0.8861, -1.1103]),
        Branch::Eq11 => ([90.0, 30.0, 120.0], [0.0; 3]),
        Branch::Eq12 => ([90.0, 90.0, 0.0], [18.7292, 13.2839, 1.0]),
        Branch::Eq13 => ([90.0, 90.0, 0.0], [0.0; 3]),
    }
}

/// beta_r in degrees as printed, where that differs from [`corrected_angles`].
fn misprinted_beta(branch: Branch, alpha: [f64; 3], d: [f64; 3]) -> Option<[f64; 3]> {
    match branch {
        Branch::Eq10 => Some([90.0 - d[0] * 18.7292, 30.0 + d[1] * 0.8861, 120.0 + d[2] * 1.1103]),
        Branch::Eq12 => Some([90.0 - d[0] * 18.7292, 90.0 - (alpha[0] - 35.2644) * 13.2839, 180.0 - d[0]]),
        _ => None,
    }
}

/// Measured minus Table 1's angles, degrees.
fn deviation(slot: Slot, alpha: [f64; 3]) -> [f64; 3] {
    let nominal = table_1(slot);
    [0, 1, 2].map(|r| degrees(alpha[r]) - nominal[r])
}

/// Eqs. (8)-(13) with the errata applied.
pub(crate) fn corrected(
    slot: Slot,
    gyro: &Normalised,
    alpha: [f64; 3],
    covariance: Option<&CovarianceEg>,
) -> Result<Published, NotPublished> {
    let d = deviation(slot, alpha);
    let branch = Branch::choose(slot, d);
    let (base, gain) = corrected_angles(branch);
    let beta = [0, 1, 2].map(|r| radians(base[r] + gain[r] * d[r]));
    let rows = Rows::solve(gyro, beta.map(f64::cos))?;
    let covariance = covariance.map(|eg| rows.covariance(gyro, beta, &gain, eg));
    let published = rows.published(branch, covariance);
    if published.is_finite() { Ok(published) } else { Err(NotPublished::Degenerate) }
}

/// Eqs. (8)-(13) as printed; the same as `corrected` but for (10) and (12).
pub(crate) fn as_printed(
    slot: Slot,
    gyro: &Normalised,
    alpha: [f64; 3],
    corrected: Result<Published, NotPublished>,
) -> Result<Published, NotPublished> {
    let d = deviation(slot, alpha);
    let branch = Branch::choose(slot, d);
    match misprinted_beta(branch, alpha.map(degrees), d) {
        Some(beta) => Ok(Rows::solve(gyro, beta.map(|b| radians(b).cos()))?.published(branch, None)),
        None => corrected.map(|published| Published { covariance: None, ..published }),
    }
}

/// The three rows y = D_I cos(alpha) + D_S cos(beta), solved by least squares.
struct Rows {
    /// cos(beta): the spin direction that the branch asserts. Not exactly a unit vector.
    spin: Vector3<f64>,
    /// (A^T A)^-1 for A = [I^, spin].
    inverse: Matrix2<f64>,
    d: Vector2<f64>,
    residual: Vector3<f64>,
}

impl Rows {
    fn solve(gyro: &Normalised, cos_beta: [f64; 3]) -> Result<Self, NotPublished> {
        let spin = Vector3::from(cos_beta);
        let (u, y) = (gyro.input, gyro.y);
        let (uu, us, ss) = (u.dot(&u), u.dot(&spin), spin.dot(&spin));
        let determinant = uu * ss - us * us;
        if determinant < 1e-9 {
            return Err(NotPublished::Degenerate);
        }
        let inverse = Matrix2::new(ss, -us, -us, uu) / determinant;
        let d = inverse * Vector2::new(u.dot(&y), spin.dot(&y));
        Ok(Self { spin, inverse, d, residual: y - u * d[0] - spin * d[1] })
    }

    fn published(&self, branch: Branch, covariance: Option<Matrix2<f64>>) -> Published {
        let closure_rms = self.residual.norm() / 3.0_f64.sqrt();
        Published { branch, d_i: self.d[0], d_s: self.d[1], closure_rms, covariance }
    }

    /// First order: dD = (A^T A)^-1 (dA^T r + A^T (dy - dA D)), with d(cos beta_r) = gain_r sin(beta_r)/
    /// sin(alpha_r) du_r (degrees cancel), du = (1 - u u^T) dE/|E|, dy = (dG - y (u.dE))/|E|.
    fn covariance(
        &self,
        gyro: &Normalised,
        beta: [f64; 3],
        gain: &[f64; 3],
        covariance: &CovarianceEg,
    ) -> Matrix2<f64> {
        let Normalised { scale, input: u, y } = *gyro;
        let spin_by_u =
            [0, 1, 2].map(|r| if gain[r] == 0.0 { 0.0 } else { gain[r] * beta[r].sin() / (1.0 - u[r] * u[r]).sqrt() });
        let mut jacobian = SMatrix::<f64, 2, 6>::zeros();
        for column in 0..3 {
            let mut du = u * (-u[column] / scale);
            du[column] += 1.0 / scale;
            let d_spin = Vector3::new(du.x * spin_by_u[0], du.y * spin_by_u[1], du.z * spin_by_u[2]);
            let dy = y * (-u[column] / scale) - du * self.d[0] - d_spin * self.d[1];
            let right =
                Vector2::new(du.dot(&self.residual) + u.dot(&dy), d_spin.dot(&self.residual) + self.spin.dot(&dy));
            jacobian.set_column(column, &(self.inverse * right));
            let by_g = Vector2::new(u[column], self.spin[column]) / scale;
            jacobian.set_column(column + 3, &(self.inverse * by_g));
        }
        let c = jacobian * covariance * jacobian.transpose();
        (c + c.transpose()) * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beta_as_printed_follows_the_measured_angles() {
        let close = |found: Option<[f64; 3]>, expected: [f64; 3]| {
            let found = found.expect("it is misprinted");
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} is not {expected:?}");
        };
        let printed = |branch, d| misprinted_beta(branch, [36.2644, 35.0, 54.0], d);
        close(printed(Branch::Eq10, [2.0, 3.0, 10.0]), [52.5416, 32.6583, 131.103]);
        close(printed(Branch::Eq12, [2.0, 0.0, 0.0]), [52.5416, 76.7161, 178.0]);
        assert_eq!(printed(Branch::Eq8, [2.0, 3.0, 10.0]), None);
    }
}
