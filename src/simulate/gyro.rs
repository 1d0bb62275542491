//! One gyro as it is: true axes, scale factor, drift by eq. (5).

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use crate::core::fault::Faults;
use crate::core::mounting::{Geometry, Slot};
use crate::core::units::radians_from_arcmin;

use super::fault_at::fault;
use super::scenario::{GyroChoice, Population, StatedE, slot_named};
use crate::core::message::text;
use crate::message;

/// The truth about one gyro.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueGyro {
    pub slot: Slot,
    pub serial: String,
    /// E that the campaign states, pulse/arcsec in body axes.
    pub stated_e: Option<Vector3<f64>>,
    /// K, pulse/arcsec.
    pub scale_factor: f64,
    /// Rows I, S, O in body axes, as mounted: body coordinates into gyro coordinates.
    pub axes: Matrix3<f64>,
    pub drift: Drift,
}

/// Coefficients of eq. (5): deg/h, deg/(h g0), deg/(h g0^2).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Drift {
    pub d_f: f64,
    pub d_i: f64,
    pub d_s: f64,
    pub d_io: f64,
    pub d_os: f64,
    pub d_si: f64,
    pub d_ii: f64,
    pub d_ss: f64,
}

impl Drift {
    /// Drift rate in deg/h at specific force `a` (g0) along I, S, O: eq. (5), with the specific force where its
    /// list of symbols prints "angular acceleration".
    pub fn rate(&self, a: &Vector3<f64>) -> f64 {
        let (i, s, o) = (a.x, a.y, a.z);
        self.d_f
            + self.d_i * i
            + self.d_s * s
            + self.d_io * i * o
            + self.d_os * o * s
            + self.d_si * s * i
            + self.d_ii * i * i
            + self.d_ss * s * s
    }
}

impl TrueGyro {
    /// True I, a unit vector in body axes.
    pub fn input(&self) -> Vector3<f64> {
        self.axes.row(0).transpose()
    }

    /// True S, a unit vector in body axes.
    pub fn spin(&self) -> Vector3<f64> {
        self.axes.row(1).transpose()
    }

    /// E as model (6) has it, pulse/arcsec in body axes.
    pub fn e(&self) -> Vector3<f64> {
        self.input() * self.scale_factor
    }
}

/// Draws what the choices leave open (another seed draws other gyros, with other serials), in slot order so that each
/// gyro's numbers depend on its own choices only.
pub fn gyros(
    choices: &[GyroChoice],
    geometry: &Geometry,
    population: &Population,
    (imu, seed): (&str, u64),
    rng: &mut ChaCha8Rng,
) -> Result<Vec<TrueGyro>, Faults> {
    if choices.is_empty() || choices.len() > 3 {
        return Err(fault("/gyros", message!("gyros_one_to_three", have = choices.len())));
    }
    choices
        .iter()
        .enumerate()
        .map(|(k, choice)| {
            let slot = slot_named(&choice.slot, &format!("/gyros/{k}/slot"))?;
            let nominal = geometry
                .triad(slot)
                .ok_or_else(|| fault(&format!("/gyros/{k}/slot"), message!("no_axes_for", slot = text(slot.name()))))?;
            let (scale_factor, misalignment_arcmin, drift) = drawn(population, rng)?;
            let arcmin = choice.misalignment_arcmin.map_or(misalignment_arcmin, Vector3::from);
            let in_mount = Rotation3::new(arcmin.map(radians_from_arcmin));
            let scale_factor = choice.scale_factor.unwrap_or(scale_factor);
            let stated = match choice.states_e {
                StatedE::No => None,
                StatedE::True => Some(in_mount * nominal.input()),
                StatedE::Nominal => Some(nominal.input()),
            };
            Ok(TrueGyro {
                slot,
                serial: choice.serial.clone().unwrap_or_else(|| format!("LFG-{imu}-{seed}-{}", k + 1)),
                stated_e: stated.map(|input| input * scale_factor),
                scale_factor,
                axes: nominal.mat_gyro_body() * in_mount.matrix().transpose(),
                drift: drift.overridden_by(choice),
            })
        })
        .collect()
}

/// Scale factor, misalignment (arcmin) and drift of a gyro of the population.
fn drawn(population: &Population, rng: &mut ChaCha8Rng) -> Result<(f64, Vector3<f64>, Drift), Faults> {
    let mut draw = |name: &str, mean: f64, sd: f64| {
        let refuse = || fault(&format!("/population/{name}"), message!("not_a_standard_deviation", value = text(sd)));
        if !(sd.is_finite() && sd >= 0.0) {
            return Err(refuse());
        }
        Ok(Normal::new(mean, sd).map_err(|_| refuse())?.sample(rng))
    };
    let scale_factor = draw("scale_factor_sd", population.scale_factor, population.scale_factor_sd)?;
    let mut arcmin = || draw("misalignment_arcmin", 0.0, population.misalignment_arcmin);
    let misalignment_arcmin = Vector3::new(arcmin()?, arcmin()?, arcmin()?);
    let drift = Drift {
        d_f: draw("d_f_sd", 0.0, population.d_f_sd)?,
        d_i: draw("d_i_sd", 0.0, population.d_i_sd)?,
        d_s: draw("d_s_sd", 0.0, population.d_s_sd)?,
        d_io: draw("d_cross_sd", 0.0, population.d_cross_sd)?,
        d_os: draw("d_cross_sd", 0.0, population.d_cross_sd)?,
        d_si: draw("d_squared_sd", 0.0, population.d_squared_sd)?,
        d_ii: draw("d_squared_sd", 0.0, population.d_squared_sd)?,
        d_ss: draw("d_squared_sd", 0.0, population.d_squared_sd)?,
    };
    Ok((scale_factor, misalignment_arcmin, drift))
}

impl Drift {
    fn overridden_by(self, choice: &GyroChoice) -> Self {
        Self {
            d_f: choice.d_f.unwrap_or(self.d_f),
            d_i: choice.d_i.unwrap_or(self.d_i),
            d_s: choice.d_s.unwrap_or(self.d_s),
            d_io: choice.d_io.unwrap_or(self.d_io),
            d_os: choice.d_os.unwrap_or(self.d_os),
            d_si: choice.d_si.unwrap_or(self.d_si),
            d_ii: choice.d_ii.unwrap_or(self.d_ii),
            d_ss: choice.d_ss.unwrap_or(self.d_ss),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::units::degrees;
    use crate::simulate::{Stream, random};

    #[test]
    fn eq_5_by_hand() {
        let drift = Drift { d_f: 1.0, d_i: 2.0, d_s: 3.0, d_io: 4.0, d_os: 5.0, d_si: 6.0, d_ii: 7.0, d_ss: 8.0 };
        // 1 + 2*.5 + 3*(-2) + 4*.5*.1 + 5*.1*(-2) + 6*(-2)*.5 + 7*.25 + 8*4
        assert!((drift.rate(&Vector3::new(0.5, -2.0, 0.1)) - 22.95).abs() < 1e-12);
    }

    #[test]
    fn mounting_errors_turn_a_rigid_triad_by_the_stated_angle() {
        let choice = GyroChoice {
            slot: "G2".into(),
            misalignment_arcmin: Some([0.0, 0.0, 30.0]),
            scale_factor: Some(2.0),
            ..Default::default()
        };
        let geometry = Geometry::Orthogonal;
        let mut rng = random(1, Stream::Population);
        let gyro = &gyros(&[choice], &geometry, &Population::default(), ("A", 1), &mut rng).unwrap()[0];
        assert!((gyro.axes * gyro.axes.transpose() - Matrix3::identity()).amax() < 1e-15);
        // Nominal I is Y; turned by +30' about Z it leans towards -X.
        assert!((degrees(gyro.input().angle(&Vector3::y())) - 0.5).abs() < 1e-12);
        assert!(gyro.input().x < 0.0 && (gyro.e().norm() - 2.0).abs() < 1e-15);
    }

    #[test]
    fn a_fourth_gyro_or_an_unknown_slot_is_refused() {
        let mut rng = random(1, Stream::Population);
        let four = vec![GyroChoice { slot: "G1".into(), ..Default::default() }; 4];
        assert!(gyros(&four, &Geometry::Skewed, &Population::default(), ("A", 1), &mut rng).is_err());
        let odd = [GyroChoice { slot: "G9".into(), ..Default::default() }];
        let faults = gyros(&odd, &Geometry::Skewed, &Population::default(), ("A", 1), &mut rng).unwrap_err();
        assert_eq!(faults.0[0].pointer, "/gyros/0/slot");
    }
}
