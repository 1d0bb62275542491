//! The rigid method: the nominal triad carried along by the smallest rotation that takes the nominal I to I^.
//!
//! With n, s, o the nominal axes, u = I^ and c = n.u, that rotation takes v perpendicular to n to
//! v - (u.v)/(1+c) (n+u) (Rodrigues). Hence, without any trigonometry,
//!
//! * D_I = y.u exactly, y = G/|E|;
//! * S^ = s - sigma (n+u), sigma = (u.s)/(1+c), D_S = y.S^;
//! * O^ = o - tau (n+u), tau = (u.o)/(1+c), D_O = y.O^, the closure.
//!
//! The rotation of the gyro about I itself cannot be seen in E. With D_O = 0 in truth it is atan2(D_O, D_S) up to a
//! half turn: that leaves D_S with one sign or the other, and nothing in E and G tells which. Of the two the one
//! nearer to nominal is meant.

use nalgebra::{Matrix3, Matrix3x6, Vector3};

use super::normalised::{CovarianceEg, Normalised};
use crate::core::mounting::Triad;

/// D_I, D_S and the closure D_O in deg/(h g0), and the axes that they were resolved on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    pub d_i: f64,
    pub d_s: f64,
    /// The closure: zero but for the clocking of S about I, or a true output-axis term.
    pub d_o: f64,
    /// S^, unit vector in body axes, perpendicular to I^.
    pub spin_axis: Vector3<f64>,
    /// O^ = I^ x S^ (IEEE 517 counts O the other way).
    pub output_axis: Vector3<f64>,
    /// First-order covariance of (D_I, D_S, D_O).
    pub covariance: Option<Matrix3<f64>>,
}

impl Rigid {
    pub(crate) fn of(gyro: &Normalised, triad: &Triad, covariance: Option<&CovarianceEg>) -> Self {
        let (u, y) = (gyro.input, gyro.y);
        let [spin_axis, output_axis] = triad.carried_to(&u);
        let covariance = covariance.map(|eg| {
            let jacobian = jacobian(gyro, triad, [&spin_axis, &output_axis]);
            let c = jacobian * eg * jacobian.transpose();
            (c + c.transpose()) * 0.5
        });
        Self { d_i: y.dot(&u), d_s: y.dot(&spin_axis), d_o: y.dot(&output_axis), spin_axis, output_axis, covariance }
    }

    /// Standard deviations of D_I, D_S, D_O, where a covariance was given.
    pub fn sd(&self) -> Option<[f64; 3]> {
        self.covariance.map(|c| [0, 1, 2].map(|i| c[(i, i)].max(0.0).sqrt()))
    }

    /// atan(D_O/D_S), radians, from -pi/2 to pi/2: how far S is turned about I if D_O is zero in truth and S points
    /// the way it should.
    pub fn clocking(&self) -> f64 {
        (self.d_o * self.d_s.signum()).atan2(self.d_s.abs())
    }

    /// First-order standard deviation of [`Self::clocking`], radians; none without a covariance, or where D_S and
    /// D_O are both zero and the angle has no meaning.
    pub fn clocking_sd(&self) -> Option<f64> {
        let c = self.covariance?;
        let squared = self.d_s * self.d_s + self.d_o * self.d_o;
        let (by_s, by_o) = (-self.d_o / squared, self.d_s / squared);
        let variance = by_s * by_s * c[(1, 1)] + 2.0 * by_s * by_o * c[(1, 2)] + by_o * by_o * c[(2, 2)];
        variance.is_finite().then(|| variance.max(0.0).sqrt())
    }

    pub(crate) fn is_finite(&self) -> bool {
        [self.d_i, self.d_s, self.d_o].iter().all(|x| x.is_finite())
            && self.covariance.is_none_or(|c| c.iter().all(|x| x.is_finite()))
    }
}

/// d(D_I, D_S, D_O)/d(E, G), 3 x 6.
///
/// For a carried axis x(u) = v - (u.v)/(1+c) (n+u) and D = y.x, with u = E/|E| and y = G/|E|:
/// dD/dG = x/|E| and dD/dE = ((1 - u u^T) h - u D)/|E|, h = dD/du at fixed y. For x = u, h = y.
fn jacobian(gyro: &Normalised, triad: &Triad, [s_hat, o_hat]: [&Vector3<f64>; 2]) -> Matrix3x6<f64> {
    let Normalised { scale, input: u, y } = *gyro;
    let by_axis = [
        (u, y),
        (*s_hat, gradient_of_carried(gyro, &triad.input(), &triad.spin())),
        (*o_hat, gradient_of_carried(gyro, &triad.input(), &triad.output())),
    ];
    let mut jacobian = Matrix3x6::zeros();
    for (row, (axis, h)) in by_axis.into_iter().enumerate() {
        let by_e = (h - u * (u.dot(&h) + y.dot(&axis))) / scale;
        let by_g = axis / scale;
        for column in 0..3 {
            jacobian[(row, column)] = by_e[column];
            jacobian[(row, column + 3)] = by_g[column];
        }
    }
    jacobian
}

/// h = d(y.x)/du = -(y.(n+u))/(1+c) (v - k n) - k y, with k = (u.v)/(1+c).
fn gradient_of_carried(gyro: &Normalised, n: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let Normalised { input: u, y, .. } = gyro;
    let one_plus_c = 1.0 + n.dot(u);
    let k = u.dot(v) / one_plus_c;
    (v - n * k) * (-y.dot(&(n + u)) / one_plus_c) - y * k
}
