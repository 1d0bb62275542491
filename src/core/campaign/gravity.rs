//! Gravity that there is at a place, so that one that there is nowhere is known.

use super::Site;
use crate::core::units::STANDARD_GRAVITY_M_S2;

/// Heights of stations, m.
const LOWEST_M: f64 = -500.0;
const HIGHEST_M: f64 = 9000.0;
/// Room beyond them, g0: anomalies of gravity are 0.0003, and many a station states 1.
const ROOM_G0: f64 = 0.005;

/// Somigliana's formula of GRS 80 with the free-air gradient, in g0; latitude in radians.
pub fn normal_gravity_g0(latitude: f64, height_m: f64) -> f64 {
    let s2 = latitude.sin().powi(2);
    let at_ellipsoid = 9.780_326_771_5 * (1.0 + 0.001_931_851_353 * s2) / (1.0 - 0.006_694_380_022_9 * s2).sqrt();
    (at_ellipsoid - 3.086e-6 * height_m) / STANDARD_GRAVITY_M_S2
}

/// Least and most gravity, g0, that a station at the site's latitude may state: normal gravity at 9000 m and at -500 m,
/// and 0.005 g0 beyond.
pub fn possible_gravity_g0(site: &Site) -> (f64, f64) {
    let at = |height_m: f64| normal_gravity_g0(site.latitude, height_m);
    (at(HIGHEST_M) - ROOM_G0, at(LOWEST_M) + ROOM_G0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_gravity_is_the_tabulated_one() {
        // GRS 80 (Moritz 2000): 9.7803267715 at the equator, 9.8321863685 at the poles, 9.806199203 at 45 degrees.
        for (latitude_deg, m_s2) in [(0.0_f64, 9.780_326_771_5), (90.0, 9.832_186_368_5), (45.0, 9.806_199_203)] {
            let g = normal_gravity_g0(latitude_deg.to_radians(), 0.0) * 9.806_65;
            assert!((g - m_s2).abs() < 1e-8, "{latitude_deg}: {g}");
        }
    }

    #[test]
    fn gravity_of_every_station_is_possible_and_another_is_not() {
        let is_possible = |latitude_deg: f64, gravity_g0: f64| {
            let site = Site { latitude: latitude_deg.to_radians(), gravity_g0, magnetic_field_nav: None };
            let (least, most) = possible_gravity_g0(&site);
            (least..=most).contains(&gravity_g0)
        };
        for latitude_deg in [-90.0, -34.25, 0.0, 19.4, 51.5, 90.0] {
            assert!(is_possible(latitude_deg, 1.0), "{latitude_deg}: g at the place is g0");
            let normal = |height_m: f64| normal_gravity_g0(f64::to_radians(latitude_deg), height_m);
            assert!(is_possible(latitude_deg, normal(-400.0)) && is_possible(latitude_deg, normal(5000.0)));
            assert!(!is_possible(latitude_deg, 0.979) && !is_possible(latitude_deg, 1.02));
        }
    }
}
