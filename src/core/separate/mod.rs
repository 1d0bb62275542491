//! One gyro's row of model (6) in, its acceleration-sensitive drift coefficients out.
//!
//! Two methods side by side, always: [`rigid`] (the default that is judged) and [`published`] (eqs. 7-13 of the
//! paper). Both begin with eq. (7): the scale factor is |E| and the input axis I^ = E/|E|; both resolve
//! y = G/|E|, in deg/(h g0), on gyro axes.

mod normalised;
pub mod published;
pub mod rigid;

use nalgebra::{DMatrix, Vector3};

use super::frames::angle_between;
use super::mounting::{Geometry, Slot};
use super::record::GyroParameters;
use crate::core::named::named;
use normalised::Normalised;
pub use normalised::{CovarianceEg, Unseparable};
pub use published::{Branch, NotPublished, Published};
pub use rigid::Rigid;

named! {
/// Which method's D_I and D_S are judged and shown first; both are always computed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum JudgedMethod {
    /// The nominal triad carried along by the smallest rotation to the measured input axis.
    #[default]
    Rigid = "rigid",
    /// Equations (7) to (13) of the paper, its errata applied.
    Published = "published",
}
}

/// Everything that one gyro's E and G say about its mounting and its drift.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    pub slot: Slot,
    /// E_i = |E|, pulse/arcsec, eq. (7).
    pub scale_factor: f64,
    /// First-order standard deviation of the scale factor, where a covariance was given.
    pub scale_factor_sd: Option<f64>,
    /// I^ = E/|E|, a unit vector in body axes.
    pub input_axis: Vector3<f64>,
    /// alpha_x, alpha_y, alpha_z of eq. (7): angles of the input axis to the body axes, radians.
    pub alpha: [f64; 3],
    /// Angle from the nominal to the measured input axis, radians.
    pub misalignment: f64,
    pub rigid: Rigid,
    /// Eqs. (8)-(13) with the errata applied.
    pub published: Result<Published, NotPublished>,
    /// Eqs. (8)-(13) letter by letter, so that a reader can compare; never judged, and without covariance.
    pub as_printed: Result<Published, NotPublished>,
}

/// Separates one gyro by both methods.
///
/// `e` pulse/arcsec and `g` pulse/(s g0) in body axes; `covariance` of (E, G) with its cross terms, or none, and
/// then no standard deviations come out. No allocation.
///
/// ```
/// use gyrowatch::core::mounting::{Geometry, Slot};
/// use gyrowatch::core::separate::separate;
/// use nalgebra::Vector3;
///
/// // G1 of the paper: E from Table 3, G from Table 4.
/// let (e, g) = (Vector3::new(0.8473, -0.6011, 1.0367), Vector3::new(2.4210, 4.0554, 6.5179));
/// let g1 = separate(&Geometry::Skewed, Slot::G1, &e, &g, None)?;
/// assert!((g1.rigid.d_i - 2.957643).abs() < 1e-6 && (g1.rigid.d_s - 4.618005).abs() < 1e-6);
/// let by_eq_8 = g1.published.expect("the geometry is the paper's");
/// assert!((by_eq_8.d_i - 2.958219).abs() < 1e-6);
/// # Ok::<(), gyrowatch::core::separate::Unseparable>(())
/// ```
///
/// # Errors
/// [`Unseparable`] where E has no usable direction, lies more than 90 deg from the nominal input axis, or a result
/// would not be finite.
pub fn separate(
    geometry: &Geometry,
    slot: Slot,
    e: &Vector3<f64>,
    g: &Vector3<f64>,
    covariance: Option<&CovarianceEg>,
) -> Result<Separation, Unseparable> {
    let triad = geometry.triad(slot).ok_or(Unseparable::NoAxes(slot))?;
    let gyro = Normalised::of(e, g)?;
    let misalignment = angle_between(&gyro.input, &triad.input());
    if misalignment > std::f64::consts::FRAC_PI_2 {
        return Err(Unseparable::PointsAway(misalignment));
    }
    let rigid = Rigid::of(&gyro, &triad, covariance);
    let alpha = published::alpha(&gyro.input);
    let skewed = matches!(geometry, Geometry::Skewed);
    let (published, as_printed) = if skewed {
        let corrected = published::corrected(slot, &gyro, alpha, covariance);
        (corrected, published::as_printed(slot, &gyro, alpha, corrected))
    } else {
        (Err(NotPublished::Geometry), Err(NotPublished::Geometry))
    };
    let separation = Separation {
        slot,
        scale_factor: gyro.scale,
        scale_factor_sd: covariance.map(|c| scale_factor_sd(&gyro.input, c)),
        input_axis: gyro.input,
        alpha,
        misalignment,
        rigid,
        published,
        as_printed,
    };
    if separation.is_finite() { Ok(separation) } else { Err(Unseparable::NotFinite) }
}

/// Covariance of (E, G) from that of all parameters, by the places of the components of E and of G among them; zero of
/// what is not among them.
pub fn covariance_at(all: &DMatrix<f64>, e: Option<[usize; 3]>, g: Option<[usize; 3]>) -> CovarianceEg {
    let places: [Option<usize>; 6] = std::array::from_fn(|i| Some((if i < 3 { e } else { g })?[i % 3]));
    CovarianceEg::from_fn(|i, j| places[i].zip(places[j]).map_or(0.0, |place| all[place]))
}

/// Diagonal covariance of (E, G) from the station's standard deviations.
///
/// None unless both are known: a standard deviation that leaves out half of its sources would mislead. A station
/// that holds E fixed says so with zeros.
pub fn diagonal_covariance(e_sd: Option<&Vector3<f64>>, g_sd: Option<&Vector3<f64>>) -> Option<CovarianceEg> {
    let (e_sd, g_sd) = (e_sd?, g_sd?);
    let mut covariance = CovarianceEg::zeros();
    for axis in 0..3 {
        covariance[(axis, axis)] = e_sd[axis] * e_sd[axis];
        covariance[(axis + 3, axis + 3)] = g_sd[axis] * g_sd[axis];
    }
    Some(covariance)
}

/// Covariance of (E, G) from what the station states of a gyro; none unless both standard deviations are known.
///
/// Where the station states the ratio r = G/|E| with its standard deviation, G = r |E| has the share r I^'dE in
/// common with E (I^ = E/|E|): cov(E, G) = C_E I^ r', cov(G) = |E|^2 C_r + r r' (I^' C_E I^). D_I and D_S, which are
/// made of the ratio, then do not depend on |E|.
pub fn stated_covariance(gyro: &GyroParameters) -> Option<CovarianceEg> {
    let mut covariance = diagonal_covariance(gyro.e_sd.as_ref(), gyro.g_sd.as_ref())?;
    let scale = gyro.e.norm();
    if gyro.g_is_ratio && scale > 0.0 {
        let (input, ratio) = (gyro.e / scale, gyro.g / scale);
        let along: Vector3<f64> = covariance.fixed_view::<3, 3>(0, 0) * input;
        let cross = along * ratio.transpose();
        covariance.fixed_view_mut::<3, 3>(0, 3).copy_from(&cross);
        covariance.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross.transpose());
        let mut of_g = covariance.fixed_view_mut::<3, 3>(3, 3);
        of_g += ratio * ratio.transpose() * input.dot(&along);
    }
    Some(covariance)
}

/// d|E| = I^ . dE.
fn scale_factor_sd(input: &Vector3<f64>, covariance: &CovarianceEg) -> f64 {
    let e_block = covariance.fixed_view::<3, 3>(0, 0);
    input.dot(&(e_block * input)).max(0.0).sqrt()
}

impl Separation {
    fn is_finite(&self) -> bool {
        self.rigid.is_finite()
            && self.scale_factor_sd.is_none_or(f64::is_finite)
            && [&self.published, &self.as_printed].iter().all(|p| p.as_ref().map_or(true, Published::is_finite))
    }
}

#[cfg(test)]
mod tests;
