//! What a campaign's dwells must satisfy beyond their shape.
//!
//! Places are JSON pointers with the wire names; a CSV reader maps them to lines and columns.

use super::{Campaign, CampaignGyro, Dwell, Phase, Site};
use crate::core::fault::Faults;
use crate::core::frames::angle_between;
use crate::core::message::{figure, text};
use crate::core::mounting::Geometry;
use crate::core::record::Plausibility;
use crate::message;

/// What is refused as impossible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CampaignLimits {
    /// By how much a dwell may begin before its predecessor ends, s: rounding of printed times.
    pub overlap_s: f64,
    /// Largest | |a| - gravity | in a static dwell, as a share of gravity. Measured (not commanded) specific
    /// force is accepted, so this is wider than a table needs.
    pub gravity_share: f64,
    /// Largest angle between the commanded specific force and the vertical of the commanded attitude, rad.
    pub attitude: f64,
    /// Largest rate in a static dwell, arcsec/s; the Earth alone makes 15.04.
    pub static_rate_arcsec_s: f64,
    /// For `known_e_pulse_per_arcsec`.
    pub plausibility: Plausibility,
}

impl Default for CampaignLimits {
    fn default() -> Self {
        Self {
            overlap_s: 1e-3,
            gravity_share: 0.02,
            attitude: 0.1_f64.to_radians(),
            static_rate_arcsec_s: 20.0,
            plausibility: Plausibility::ever(),
        }
    }
}

/// Smallest standard error, pulse/s. Far below any pulse counter, and its inverse square still is a number.
const SMALLEST_SEM: f64 = 1e-12;

impl Campaign {
    /// Every check of this module.
    ///
    /// # Errors
    /// All faults, by JSON pointer.
    pub fn check(&self, limits: &CampaignLimits) -> Result<(), Faults> {
        let mut faults = Faults::default();
        if self.gyros.is_empty() || self.gyros.len() > 3 {
            faults.push("/gyros", message!("gyros_one_to_three", have = self.gyros.len()));
        }
        check_gyros(&self.gyros, &self.geometry, limits, &mut faults);
        if self.dwells.is_empty() {
            faults.push("/dwells", message!("no_dwells"));
        }
        check_dwells(self.dwells.iter().enumerate(), self.site.as_ref(), limits, &mut faults);
        faults.or(())
    }

    /// Whether each `known_e_pulse_per_arcsec` is a possible row of E within these limits.
    ///
    /// # Errors
    /// All faults, by JSON pointer.
    pub fn check_known_scales(&self, limits: &Plausibility) -> Result<(), Faults> {
        let mut faults = Faults::default();
        for (i, gyro) in self.gyros.iter().enumerate() {
            if let Some(e) = gyro.known_e
                && let Err(reason) = limits.check_scale(&e, &self.geometry, gyro.slot)
            {
                faults.push(format!("/gyros/{i}/known_e_pulse_per_arcsec"), reason);
            }
        }
        faults.or(())
    }
}

fn check_gyros(gyros: &[CampaignGyro], geometry: &Geometry, limits: &CampaignLimits, faults: &mut Faults) {
    for (i, gyro) in gyros.iter().enumerate() {
        if let Some(twin) = gyros[..i].iter().position(|g| g.serial == gyro.serial) {
            faults.push(
                format!("/gyros/{i}/serial"),
                message!("serial_taken", serial = text(&gyro.serial), place = format_args!("/gyros/{twin}")),
            );
        }
        if let Some(twin) = gyros[..i].iter().position(|g| g.slot == gyro.slot) {
            faults.push(
                format!("/gyros/{i}/slot"),
                message!("slot_taken", slot = gyro.slot.name(), place = format_args!("/gyros/{twin}")),
            );
            continue;
        }
        if geometry.triad(gyro.slot).is_none() {
            faults.push(format!("/gyros/{i}/slot"), message!("no_axes_for", slot = text(gyro.slot.name())));
            continue;
        }
        if let Some(e) = gyro.known_e
            && let Err(reason) = limits.plausibility.check_scale(&e, geometry, gyro.slot)
        {
            faults.push(format!("/gyros/{i}/known_e_pulse_per_arcsec"), reason);
        }
    }
}

/// Checks dwells given with their index in the document (a reader leaves out those that it could not read).
pub fn check_dwells<'a>(
    dwells: impl Iterator<Item = (usize, &'a Dwell)>,
    site: Option<&Site>,
    limits: &CampaignLimits,
    faults: &mut Faults,
) {
    let mut before: Option<(usize, &Dwell)> = None;
    for (i, dwell) in dwells {
        check_time(i, dwell, before, limits, faults);
        check_force(i, dwell, site, limits, faults);
        check_sem(i, dwell, faults);
        before = Some((i, dwell));
    }
}

fn check_time(i: usize, dwell: &Dwell, before: Option<(usize, &Dwell)>, limits: &CampaignLimits, faults: &mut Faults) {
    if dwell.duration_s <= 0.0 {
        faults.push(format!("/dwells/{i}/duration_s"), message!("not_positive", value = text(dwell.duration_s)));
    }
    if dwell.start_s < 0.0 {
        faults.push(format!("/dwells/{i}/start_s"), message!("negative_start", value = text(dwell.start_s)));
    }
    let Some((j, before)) = before else { return };
    let place = || format!("/dwells/{i}/start_s");
    let end = before.start_s + before.duration_s.max(0.0);
    if dwell.start_s < before.start_s {
        faults.push(
            place(),
            message!(
                "out_of_time_order",
                start = text(dwell.start_s),
                place = format_args!("/dwells/{j}"),
                earlier = text(before.start_s)
            ),
        );
    } else if dwell.start_s < end - limits.overlap_s {
        faults.push(
            place(),
            message!("overlaps", place = format_args!("/dwells/{j}"), start = text(dwell.start_s), end = text(end)),
        );
    }
}

fn check_force(i: usize, dwell: &Dwell, site: Option<&Site>, limits: &CampaignLimits, faults: &mut Faults) {
    let force = dwell.specific_force_g0.norm();
    let place = || format!("/dwells/{i}/specific_force_g0");
    if dwell.phase == Phase::Static {
        let gravity = site.map_or(1.0, |s| s.gravity_g0);
        if (force - gravity).abs() > limits.gravity_share * gravity {
            faults.push(
                place(),
                message!(
                    "force_not_gravity",
                    length = figure(force, 5),
                    reference = if site.is_some() { message!("site_gravity") } else { message!("standard_gravity") },
                    gravity = text(gravity),
                    percent = text(limits.gravity_share * 100.0)
                ),
            );
        }
        let rate = dwell.rate_arcsec_s.norm();
        if rate > limits.static_rate_arcsec_s {
            faults.push(format!("/dwells/{i}/rate_arcsec_s"), message!("static_too_fast", rate = figure(rate, 3)));
        }
    }
    if let Some(attitude) = dwell.attitude
        && force > 0.0
    {
        let angle = angle_between(&attitude.up(), &dwell.specific_force_g0);
        if angle > limits.attitude {
            faults.push(
                format!("/dwells/{i}/attitude"),
                message!("attitude_contradicts_force", angle = figure(angle.to_degrees(), 3)),
            );
        }
    }
}

fn check_sem(i: usize, dwell: &Dwell, faults: &mut Faults) {
    for (j, &sem) in dwell.output_sem_pulse_s.iter().flatten().enumerate() {
        if sem < SMALLEST_SEM {
            faults.push(
                format!("/dwells/{i}/output_sem_pulse_s/{j}"),
                message!("sem_not_positive", least = format_args!("{SMALLEST_SEM:e}"), value = text(sem)),
            );
        }
    }
}
