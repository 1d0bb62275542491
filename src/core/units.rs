//! The only place that converts units.
//!
//! Inside the program an angle is in radians, a drift or input rate in deg/h, a specific force in g0.
//! Two identities make most conversions vanish:
//!
//! * 1 arcsec/s = 1 deg/h exactly (both are 1/3600 deg/s), so a rate in arcsec/s *is* a rate in deg/h;
//! * hence E in pulse/arcsec turns pulse/s into deg/h by division, and G/E is in deg/(h g0).

/// Standard gravity, m/s^2 (exact by definition). The unit g0 of every coefficient here.
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Mean angular rate of the Earth with respect to inertial space, deg/h (WGS 84: 7.2921151467e-5 rad/s).
pub const EARTH_RATE_DEG_H: f64 = 15.041_067_178_669_1;

/// Degrees of arc to radians.
pub fn radians(degrees: f64) -> f64 {
    degrees.to_radians()
}

/// Radians to degrees of arc.
pub fn degrees(radians: f64) -> f64 {
    radians.to_degrees()
}

/// Minutes of arc to radians.
pub fn radians_from_arcmin(arcmin: f64) -> f64 {
    (arcmin / 60.0).to_radians()
}

/// Seconds of arc to radians.
pub fn radians_from_arcsec(arcsec: f64) -> f64 {
    (arcsec / 3600.0).to_radians()
}

/// Radians to seconds of arc.
pub fn arcsec(radians: f64) -> f64 {
    3600.0 * radians.to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earth_rate_is_that_of_wgs_84_in_radians() {
        let rad_per_s = EARTH_RATE_DEG_H.to_radians() / 3600.0;
        assert!((rad_per_s - 7.292_115_146_7e-5).abs() < 1e-16);
    }
}
