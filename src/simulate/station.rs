//! What an IMU feels on the table: gravity, Earth rate, table rate and magnetic field, moment by moment.

use nalgebra::{Rotation3, Vector3};

use crate::core::campaign::gravity::normal_gravity_g0;
use crate::core::campaign::{Phase, Site};
use crate::core::fault::Faults;
use crate::core::units::{EARTH_RATE_DEG_H, radians};

use super::fault_at::fault;
use super::programme::Planned;
use super::scenario::SiteChoice;
use crate::core::message::text;
use crate::message;

/// Moments over which one turn of the table is averaged. Equal steps are exact for harmonics of the heading below
/// this number; products of up to four first harmonics occur.
const MOMENTS_A_TURN: usize = 12;

/// The Earth at the station, in East, North, Up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Earth {
    pub latitude: f64,
    /// Specific force of a body at rest, g0.
    pub gravity: Vector3<f64>,
    /// Earth rate, arcsec/s.
    pub rate: Vector3<f64>,
    /// Unit vector of the magnetic field.
    pub field: Vector3<f64>,
}

impl Earth {
    /// Rate (deg/h) and gravity (g0) in east, north, up, and the direction of the field. Gravity is GRS 80's normal
    /// gravity where none is stated.
    ///
    /// # Errors
    /// A latitude outside -90 to 90 deg, a field without direction, a gravity that is not positive.
    pub fn at(site: &SiteChoice) -> Result<Self, Faults> {
        if !(-90.0..=90.0).contains(&site.latitude_deg) {
            return Err(fault("/site/latitude_deg", message!("scenario_latitude", value = text(site.latitude_deg))));
        }
        let field = Vector3::from(site.magnetic_field_nav);
        if !(field.norm().is_finite() && field.norm() > 0.0) {
            return Err(fault("/site/magnetic_field_nav", message!("has_no_direction")));
        }
        let latitude = radians(site.latitude_deg);
        let g0 = site.gravity_g0.unwrap_or_else(|| normal_gravity_g0(latitude, site.height_m));
        if !(g0.is_finite() && g0 > 0.0) {
            return Err(fault("/site/gravity_g0", message!("not_positive_gravity", value = text(g0))));
        }
        let rate = EARTH_RATE_DEG_H * Vector3::new(0.0, latitude.cos(), latitude.sin());
        Ok(Self { latitude, gravity: Vector3::new(0.0, 0.0, g0), rate, field: field.normalize() })
    }

    /// What the station states about itself.
    pub fn stated(&self, states_field: bool) -> Site {
        Site {
            latitude: self.latitude,
            gravity_g0: self.gravity.z,
            magnetic_field_nav: states_field.then_some(self.field),
        }
    }
}

/// Body-frame quantities at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Specific force, g0.
    pub a: Vector3<f64>,
    /// Inertial rate, arcsec/s.
    pub w: Vector3<f64>,
    /// Direction of the magnetic field.
    pub field: Vector3<f64>,
    /// Direction of north.
    pub north: Vector3<f64>,
}

/// What the IMU feels over one dwell: one moment at rest, equally spaced headings of one turn otherwise.
///
/// `table_from_nav`: East, North, Up as they are, into what the table takes for East, North, Up, whose base is not
/// level and not to the north.
pub fn moments(dwell: &Planned, earth: &Earth, table_from_nav: &Rotation3<f64>) -> Vec<Moment> {
    let steps = match dwell.phase {
        Phase::Static => 1,
        Phase::Rate => MOMENTS_A_TURN,
    };
    let turn = Vector3::new(0.0, 0.0, dwell.turn_arcsec_s);
    (0..steps)
        .map(|step| {
            let heading = step as f64 / steps as f64 * std::f64::consts::TAU * dwell.turn_arcsec_s.signum();
            let heading = if dwell.phase == Phase::Static { 0.0 } else { heading };
            let body_from_table = dwell.attitude * Rotation3::from_axis_angle(&Vector3::z_axis(), -heading);
            let body_from_nav = body_from_table * table_from_nav;
            Moment {
                a: body_from_nav * earth.gravity,
                w: body_from_nav * earth.rate + body_from_table * turn,
                field: body_from_nav * earth.field,
                north: body_from_nav * Vector3::y(),
            }
        })
        .collect()
}

/// What the station believes and writes down: the means of a level table turned to the north.
pub fn commanded(dwell: &Planned, earth: &Earth) -> (Vector3<f64>, Vector3<f64>) {
    let rate = match dwell.phase {
        Phase::Static => earth.rate,
        Phase::Rate => Vector3::new(0.0, 0.0, earth.rate.z + dwell.turn_arcsec_s),
    };
    (dwell.attitude * earth.gravity, dwell.attitude * rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::units::degrees;
    use crate::simulate::programme::attitude;

    fn turning(up: Vector3<f64>, arcsec_s: f64) -> Planned {
        Planned {
            phase: if arcsec_s == 0.0 { Phase::Static } else { Phase::Rate },
            start_s: 0.0,
            duration_s: 180.0,
            attitude: attitude(up, 0.4),
            turn_arcsec_s: arcsec_s,
            since_power_up_s: 90.0,
            power_up: 0,
        }
    }

    #[test]
    fn earth_rate_has_one_size_everywhere_and_points_to_the_pole() {
        for latitude_deg in [-89.0, -34.25, 0.0, 51.48, 90.0] {
            let earth = Earth::at(&SiteChoice { latitude_deg, ..Default::default() }).unwrap();
            let sidereal_day_s = 86_164.098_903_691;
            assert!((earth.rate.norm() - 360.0 * 3600.0 / sidereal_day_s).abs() < 1e-6);
            assert!((degrees(earth.rate.z.atan2(earth.rate.y)) - latitude_deg).abs() < 1e-9);
        }
    }

    #[test]
    fn at_rest_the_imu_feels_what_the_station_commands() {
        let earth = Earth::at(&SiteChoice::default()).unwrap();
        let dwell = turning(Vector3::new(0.5, -0.3, 0.8), 0.0);
        let sensed = moments(&dwell, &earth, &Rotation3::identity());
        let (a, w) = commanded(&dwell, &earth);
        assert_eq!(sensed.len(), 1);
        assert!((sensed[0].a - a).norm() < 1e-15 && (sensed[0].w - w).norm() < 1e-13);
    }

    #[test]
    fn over_a_whole_turn_the_horizontal_earth_rate_averages_out_and_its_square_does_not() {
        let earth = Earth::at(&SiteChoice::default()).unwrap();
        let up = Vector3::new(0.0, 0.6, -0.8);
        for arcsec_s in [3600.0, -7200.0] {
            let dwell = turning(up, arcsec_s);
            let sensed = moments(&dwell, &earth, &Rotation3::identity());
            let n = sensed.len() as f64;
            let mean_w: Vector3<f64> = sensed.iter().map(|m| m.w).sum::<Vector3<f64>>() / n;
            let (a, w) = commanded(&dwell, &earth);
            assert!((mean_w - w).norm() < 1e-9);
            assert!(sensed.iter().all(|m| (m.a - a).norm() < 1e-15), "gravity does not turn with the table");
            // Across the vertical, the mean square of the horizontal Earth rate is N^2/2 in every direction.
            let across = Vector3::x();
            let mean_square = sensed.iter().map(|m| m.w.dot(&across).powi(2)).sum::<f64>() / n;
            assert!((mean_square - 0.5 * earth.rate.y.powi(2)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_tilted_table_tilts_gravity_by_the_same_angle_in_every_position() {
        let earth = Earth::at(&SiteChoice::default()).unwrap();
        let tilt = 1e-3;
        let table_from_nav = Rotation3::new(Vector3::new(tilt, 0.0, 0.0));
        let dwell = turning(Vector3::y(), 0.0);
        let (a, _) = commanded(&dwell, &earth);
        let sensed = moments(&dwell, &earth, &table_from_nav)[0];
        assert!((sensed.a.angle(&a) - tilt).abs() < 1e-12);
        assert!((sensed.a.norm() - a.norm()).abs() < 1e-15);
    }

    #[test]
    fn an_impossible_site_is_refused_by_name() {
        let site = SiteChoice { latitude_deg: 91.0, ..Default::default() };
        assert_eq!(Earth::at(&site).unwrap_err().0[0].pointer, "/site/latitude_deg");
    }
}
