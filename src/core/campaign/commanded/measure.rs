//! What each dwell says of the Earth, and whether it can be.

use super::{EARTH, Symptom};
use crate::core::campaign::{Campaign, Dwell, Phase};
use crate::core::frames::angle_between;
use crate::core::numerics::median::median_of;

/// By how much |w| and w.f/|f| of a static dwell may be off, arcsec/s: printed digits, and measured specific force some
/// arc-minutes off.
pub(super) const RATE_ROOM: f64 = 0.1;

/// As [`RATE_ROOM`] for the whole vector against a stated attitude: a heading that is 2 degrees off.
pub(super) const HEADING_ROOM: f64 = 0.5;

/// Largest angle between the specific force and the vertical of the attitude, rad.
pub(super) const TILT_ROOM: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// A table that turns is faster than this, arcsec/s.
const SLOWEST_TURN: f64 = 5.0;

/// Share of a turning rate that may lie across the specific force, beside the Earth's own rate.
const ACROSS_SHARE: f64 = 2e-3;

/// One dwell's measures.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measure {
    pub phase: Phase,
    /// |w|, arcsec/s.
    pub rate: f64,
    /// w.f/|f|.
    pub vertical: f64,
    /// |w - (w.f/|f|) f/|f||.
    pub across: f64,
    /// |f|, g0.
    pub force: f64,
    /// Angle of the attitude's vertical to f, rad.
    pub tilt: Option<f64>,
    /// |w - C Omega| of a static dwell.
    pub off: Option<f64>,
}

impl Measure {
    /// Of one dwell. `tilt` needs an attitude; `off` needs attitude, site and a static phase.
    pub fn of(campaign: &Campaign, dwell: &Dwell) -> Self {
        let (f, w) = (&dwell.specific_force_g0, &dwell.rate_arcsec_s);
        let up = f.try_normalize(0.0).unwrap_or_default();
        let vertical = w.dot(&up);
        let still = dwell.phase == Phase::Static;
        let earth = campaign.site.filter(|_| still).map(|site| site.earth_rate());
        Self {
            phase: dwell.phase,
            rate: w.norm(),
            vertical,
            across: (w - vertical * up).norm(),
            force: f.norm(),
            tilt: dwell.attitude.filter(|_| f.norm() > 0.0).map(|c| angle_between(&c.up(), f)),
            off: dwell.attitude.zip(earth).map(|(c, earth)| (w - (c * earth).0).norm()),
        }
    }

    /// What cannot be, with `vertical` for Omega sin(latitude) where it is known.
    pub fn symptom(&self, vertical: Option<f64>) -> Option<Symptom> {
        if self.tilt.is_some_and(|tilt| tilt > TILT_ROOM) {
            return Some(Symptom::Attitude);
        }
        match self.phase {
            Phase::Static if (self.rate - EARTH).abs() > RATE_ROOM => Some(Symptom::StaticRate),
            Phase::Static if vertical.is_some_and(|v| (self.vertical - v).abs() > RATE_ROOM) => {
                Some(Symptom::VerticalRate)
            }
            Phase::Rate if self.rate < SLOWEST_TURN || self.across > EARTH + 1.0 + ACROSS_SHARE * self.rate => {
                Some(Symptom::TurningRate)
            }
            Phase::Static | Phase::Rate => None,
        }
    }

    /// The measure that a symptom is read from: arcsec/s, g0 for gravity, degrees for the attitude.
    pub fn value(&self, symptom: Symptom) -> f64 {
        match symptom {
            Symptom::StaticRate | Symptom::TurningRate => self.rate,
            Symptom::VerticalRate => self.vertical,
            Symptom::Heading | Symptom::Output | Symptom::Senses | Symptom::Scale => self.off.unwrap_or(0.0),
            Symptom::Gravity => self.force,
            Symptom::Attitude => self.tilt.unwrap_or(0.0).to_degrees(),
        }
    }
}

/// The measures of all dwells, and the vertical part of the Earth's rate that they are held against.
#[derive(Debug, Clone)]
pub(super) struct Measures {
    pub dwells: Vec<Measure>,
    /// Omega sin(latitude) at the site; without a site, what most static dwells agree on.
    pub vertical: Option<f64>,
}

impl Measures {
    /// Of every dwell, in the campaign's order.
    pub fn of(campaign: &Campaign) -> Self {
        let dwells: Vec<Measure> = campaign.dwells.iter().map(|dwell| Measure::of(campaign, dwell)).collect();
        let of_site = campaign.site.map(|site| site.earth_rate().0.z);
        let vertical = of_site.or_else(|| median_of(still(&dwells).map(|m| m.vertical)));
        Self { dwells, vertical }
    }

    /// Those of the static dwells.
    pub fn still(&self) -> impl Iterator<Item = &Measure> {
        still(&self.dwells)
    }

    /// What cannot be, dwell by dwell.
    pub fn symptoms(&self) -> Vec<Option<Symptom>> {
        self.dwells.iter().map(|m| m.symptom(self.vertical)).collect()
    }

    /// How many dwells are as they should be, their whole rate at the attitude included.
    pub fn good(&self) -> usize {
        let whole = |m: &Measure| m.off.is_none_or(|off| off <= HEADING_ROOM);
        self.dwells.iter().filter(|m| m.symptom(self.vertical).is_none() && whole(m)).count()
    }
}

fn still(dwells: &[Measure]) -> impl Iterator<Item = &Measure> {
    dwells.iter().filter(|m| m.phase == Phase::Static)
}
