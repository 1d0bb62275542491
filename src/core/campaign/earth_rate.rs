//! The Earth's rate of each dwell, for a station that states what its table did.

use nalgebra::Vector3;

use super::commanded::AffectedDwells;
use super::{Campaign, Phase};
use crate::core::frames::Vector;

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
