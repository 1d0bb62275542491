//! The Earth's rate of each dwell, for a station that states what its table did, or writes it with few digits.

use std::ops::RangeInclusive;

use nalgebra::Vector3;

use super::commanded::AffectedDwells;
use super::steps::decimal_step;
use super::{Campaign, Dwell, Phase};
use crate::core::frames::{Nav, Vector};

/// What the Earth's rate cannot be known without.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoEarthRate {
    pub site: bool,
    /// Static dwells without an attitude, by index.
    pub attitudes: Vec<usize>,
}

/// The campaign with the Earth's rate added to the rates of these dwells: C Omega at rest; along the vertical, of
/// which the specific force speaks where there is no attitude, where the table turns whole turns about it (the
/// horizontal part averages to zero).
///
/// # Errors
/// What is missing for it.
pub fn with_earth_rate(campaign: &Campaign, part: AffectedDwells) -> Result<Campaign, NoEarthRate> {
    let still = |k: &usize| part != AffectedDwells::Turning && campaign.dwells[*k].phase == Phase::Static;
    let attitudes: Vec<usize> =
        (0..campaign.dwells.len()).filter(still).filter(|k| campaign.dwells[*k].attitude.is_none()).collect();
    let Some(site) = campaign.site.filter(|_| attitudes.is_empty()) else {
        return Err(NoEarthRate { site: campaign.site.is_none(), attitudes });
    };
    let earth = site.earth_rate();
    let mut whole = campaign.clone();
    for dwell in &mut whole.dwells {
        dwell.rate_arcsec_s += match (dwell.phase, dwell.attitude) {
            (Phase::Static, Some(c)) if part != AffectedDwells::Turning => (c * earth).0,
            (Phase::Rate, Some(c)) if part != AffectedDwells::Static => (c * Vector::new(earth.0.z * Vector3::z())).0,
            (Phase::Rate, None) if part != AffectedDwells::Static => {
                earth.0.z * dwell.specific_force_g0.try_normalize(0.0).unwrap_or_default()
            }
            _ => Vector3::zeros(),
        };
    }
    Ok(whole)
}

/// Steps of rates for which exact ones are looked for, arcsec/s: smaller ones move nothing, and larger ones are those
/// of many latitudes.
const STEPS: RangeInclusive<f64> = 0.9e-3..=0.11;

/// How far a rounded rate may be off, in steps: half of one, and what the digits of an attitude add.
const ROOM: f64 = 0.6;

/// Powers of ten, the largest first, that a table's rate is a multiple of, arcsec/s.
const ROUND_RATES: [i32; 8] = [-4, -3, -2, -1, 0, 1, 2, 3];

/// The campaign with the exact inertial rates where those that were sent are them rounded: rounding is no noise, since
/// the vertical part of the Earth's rate rounds alike in all dwells, and D_I holds it.
///
/// At rest C Omega or, where the heading is another or not stated, Omega sin L along the vertical and Omega cos L along
/// the horizontal part that was sent. While the table turns, Omega sin L and the roundest rate that fits, along the
/// vertical. Each is held within half a step (arcsec/s) of what was sent. Unchanged without a site, and where a static
/// dwell is of another Earth's rate.
pub fn with_exact_rates(mut campaign: Campaign) -> Campaign {
    let step = decimal_step(campaign.dwells.iter().flat_map(|d| <[f64; 3]>::from(d.rate_arcsec_s)));
    let Some(site) = campaign.site.filter(|_| STEPS.contains(&step)) else { return campaign };
    let earth = site.earth_rate();
    let exact: Vec<Option<Vector3<f64>>> = campaign.dwells.iter().map(|d| exact_rate(d, &earth, step)).collect();
    let mut still = campaign.dwells.iter().zip(&exact).filter(|(d, _)| d.phase == Phase::Static).peekable();
    if still.peek().is_none() || still.any(|(_, exact)| exact.is_none()) {
        return campaign;
    }
    for (dwell, exact) in campaign.dwells.iter_mut().zip(exact) {
        dwell.rate_arcsec_s = exact.unwrap_or(dwell.rate_arcsec_s);
    }
    campaign.rates_sent_in_steps = Some(step);
    campaign
}

/// None where nothing of what the Earth allows is what was sent.
fn exact_rate(dwell: &Dwell, earth: &Vector<Nav>, step: f64) -> Option<Vector3<f64>> {
    let sent = dwell.rate_arcsec_s;
    let up = dwell.attitude.map_or_else(|| dwell.specific_force_g0.try_normalize(0.0), |c| Some(c.up()))?;
    let along = sent.dot(&up);
    let fits = |exact: &Vector3<f64>| (exact - sent).amax() < ROOM * step;
    // Strictly within: rounded again, it is what was sent.
    let half = (0.5 - 1e-6) * step;
    let exact = match dwell.phase {
        Phase::Static => {
            let north = (sent - along * up).try_normalize(0.0).unwrap_or_default();
            let of_attitude = dwell.attitude.map(|c| (c * *earth).0);
            let of_vertical = earth.0.z * up + earth.0.y * north;
            of_attitude.into_iter().chain([of_vertical]).find(fits)
        }
        Phase::Rate => ROUND_RATES.into_iter().find_map(|places| {
            let scale = 10_f64.powi(places);
            let table = ((along - earth.0.z) * scale).round() / scale;
            Some((table + earth.0.z) * up).filter(fits)
        }),
    };
    exact.map(|exact| exact.zip_map(&sent, |exact, sent| exact.clamp(sent - half, sent + half)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::campaign::{Site, made_for_tests};
    use crate::core::frames::Rotation;

    /// At rest and turning, at the latitude of the site plus `off` degrees, with rates of so many decimals.
    fn sent(places: i32, off: f64, has_attitudes: bool) -> (Campaign, Vec<Vector3<f64>>) {
        let site = Site { latitude: 34.25_f64.to_radians(), gravity_g0: 0.9989, magnetic_field_nav: None };
        let of_table = Site { latitude: site.latitude + off.to_radians(), ..site }.earth_rate();
        let mut exact = Vec::new();
        let dwell = |k: usize| {
            let angle = 0.7 * k as f64;
            let q = [(0.5 * angle).cos(), 0.6 * (0.5 * angle).sin(), 0.0, 0.8 * (0.5 * angle).sin()];
            let c = Rotation::from_attitude(q);
            let turning = k % 4 == 3;
            let table = Vector::new(Vector3::z() * (of_table.0.z + [1800.0, -359.8][k % 2]));
            let rate = (c * if turning { table } else { of_table }).0;
            let scale = 10_f64.powi(places);
            let written = rate.map(|x| (x * scale).round() / scale);
            exact.push(rate);
            Dwell {
                phase: if turning { Phase::Rate } else { Phase::Static },
                attitude: has_attitudes.then_some(c),
                ..made_for_tests::dwell(k, site.gravity_g0 * c.up(), written, vec![0.0])
            }
        };
        let dwells = (0..12).map(dwell).collect();
        (Campaign { site: Some(site), ..made_for_tests::campaign(vec![], dwells) }, exact)
    }

    #[test]
    fn rounded_rates_give_way_to_the_exact_ones_and_are_written_as_they_were_sent() {
        for (places, step) in [(1, 0.1), (2, 0.01), (3, 0.001)] {
            for has_attitudes in [true, false] {
                let (rounded, exact) = sent(places, 0.0, has_attitudes);
                let campaign = with_exact_rates(rounded.clone());
                assert_eq!(campaign.rates_sent_in_steps, Some(step));
                for ((dwell, sent), exact) in campaign.dwells.iter().zip(&rounded.dwells).zip(exact) {
                    let up = dwell.specific_force_g0.normalize();
                    let (off, before) = (dwell.rate_arcsec_s - exact, sent.rate_arcsec_s - exact);
                    let most = if has_attitudes || dwell.phase == Phase::Rate { 1e-9 } else { step };
                    assert!(off.amax() < most && off.dot(&up).abs() < 0.2 * step, "{off} {before}");
                    assert_eq!(campaign.sent_rate(dwell), sent.rate_arcsec_s);
                }
            }
        }
    }

    #[test]
    fn rates_of_another_earth_stay_as_they_were_sent() {
        for (places, off) in [(2, 0.1), (1, 1.0), (0, 0.0), (5, 0.0)] {
            let (sent, _) = sent(places, off, true);
            assert_eq!(with_exact_rates(sent.clone()), sent, "{places} {off}");
        }
        let (sent, _) = sent(2, 0.0, true);
        let nowhere = Campaign { site: None, ..sent };
        assert_eq!(with_exact_rates(nowhere.clone()), nowhere);
    }
}
