//! Whether what was commanded is what the Earth allows: checks that need no attitude.
//!
//! In a static dwell |w| is the Earth's rate, w.f/|f| its vertical part Omega sin L, and |f| local gravity. In a rate
//! dwell the table turns about the vertical, so w lies along f. What breaks one of these has moved D_I and D_S,
//! whatever the fit looks like.
//!
//! Reading order: [`measure`] (what each dwell says), [`transform`] (the mistakes that stations make, undone),
//! [`search`] (which explains all dwells), [`senses`] (turning against static dwells), [`trial_fit`] (whether it
//! matters). A campaign whose dwells are all as
//! they should be costs no fit.

mod measure;
mod search;
mod senses;
mod transform;
mod trial_fit;

pub use search::{findings, force_off_gravity, latitude_of_rates};

use crate::core::mounting::Slot;
use crate::core::named::named;
use crate::core::numerics::median::median_of;
use crate::core::units::EARTH_RATE_DEG_H;

named! {
/// What is not as it should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symptom {
    /// |w| of static dwells is not the Earth's rate.
    StaticRate = "static_rate",
    /// w.f/|f| of static dwells is not Omega sin(latitude), or not the same in all.
    VerticalRate = "vertical_rate",
    /// The rate of rate dwells is too slow for one, or is not along the vertical.
    TurningRate = "turning_rate",
    /// The rate of static dwells is not the Earth's at their attitude, though its length and its vertical part are.
    Heading = "heading",
    /// The outputs contradict what was commanded.
    Output = "output",
    /// The outputs of turning dwells show other input axes than those of static dwells.
    Senses = "senses",
    /// The outputs of turning dwells answer rates with another scale factor than those of static dwells.
    Scale = "scale",
    /// |f| is not local gravity.
    Gravity = "gravity",
    /// The attitude contradicts the specific force.
    Attitude = "attitude",
}
}

/// What a mistake was made in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vectors {
    Force,
    Rate,
    Both,
}

/// Which dwells' rates a mistake was made in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AffectedDwells {
    All,
    Static,
    Turning,
}

/// What it most likely is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MistakeKind {
    /// Specific force with the other sign, that of gravity.
    ForceReversed,
    /// Rates with the other sign.
    RateReversed,
    /// The sign of the site's latitude, or of the one that the rates were made with.
    LatitudeReversed,
    /// Vectors in North-East-Down beside others in East-North-Up.
    NedForEnu,
    /// The attitude turns body coordinates into nav coordinates instead of the reverse.
    AttitudeInverted,
    /// Rates are the table's alone.
    EarthRateLeftOut,
    /// Rates in `unit` instead of arcsec/s.
    RateUnit { unit: &'static str, part: AffectedDwells },
    /// One component with the other sign.
    AxisReversed { axis: usize, of: Vectors },
    /// Two components, each in the place of the other.
    AxesExchanged { axes: (usize, usize), of: Vectors },
    /// The rates are those of another latitude than the site's, degrees.
    OtherLatitude { degrees: f64 },
    /// |w| is the same everywhere and not the Earth's: 15 arcsec/s is that of a solar day.
    OtherEarthRate { arcsec_s: f64 },
    /// The rates of static dwells are made with other headings than the attitudes.
    OtherHeadings,
    /// Specific force in `unit` instead of g0.
    ForceUnit { unit: &'static str },
    /// Unit vectors where the site's gravity is another.
    ForceNormalised,
    /// |f| over gravity, the same in all dwells.
    ForceScale { ratio: f64 },
    /// Outputs of the gyros in these slots, while the table turns, in another unit than at rest.
    OutputScale { of: [bool; Slot::ALL.len()] },
}

impl MistakeKind {
    /// Its name in answers.
    pub fn code(&self) -> &'static str {
        match self {
            Self::ForceReversed => "specific_force_reversed",
            Self::RateReversed => "rate_reversed",
            Self::LatitudeReversed => "latitude_reversed",
            Self::NedForEnu => "ned_for_enu",
            Self::AttitudeInverted => "attitude_inverted",
            Self::EarthRateLeftOut => "earth_rate_left_out",
            Self::RateUnit { .. } => "rate_unit",
            Self::AxisReversed { .. } => "axis_reversed",
            Self::AxesExchanged { .. } => "axes_exchanged",
            Self::OtherLatitude { .. } => "other_latitude",
            Self::OtherEarthRate { .. } => "other_earth_rate",
            Self::OtherHeadings => "other_headings",
            Self::ForceUnit { .. } => "specific_force_unit",
            Self::ForceNormalised => "specific_force_normalised",
            Self::ForceScale { .. } => "specific_force_scale",
            Self::OutputScale { .. } => "output_scale",
        }
    }
}

/// One thing that was commanded as the Earth does not allow it.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandFinding {
    pub symptom: Symptom,
    /// As likely as one another; empty where no mistake that is known explains it.
    pub causes: Vec<MistakeKind>,
    /// The dwells that show it, by index, and what they measure: arcsec/s, g0 or degrees; never empty.
    pub dwells: Vec<(usize, f64)>,
    /// Of how many dwells of that kind.
    pub of: usize,
    /// Whether these are single dwells, and the others are as they should be.
    pub single: bool,
    /// What it should be, where that is known.
    pub expected: Option<f64>,
    /// Whether D_I and D_S cannot be relied on.
    pub matters: bool,
}

impl CommandFinding {
    /// Of these very dwells together, where nothing says what it should be.
    fn of_all(symptom: Symptom, causes: Vec<MistakeKind>, dwells: Vec<(usize, f64)>, matters: bool) -> Self {
        Self { symptom, causes, of: dwells.len(), dwells, single: false, expected: None, matters }
    }

    /// Median over the dwells of what they measure.
    pub fn measured(&self) -> f64 {
        median_of(self.dwells.iter().map(|(_, value)| *value)).unwrap_or(0.0)
    }
}

/// The Earth's rate in arcsec/s.
const EARTH: f64 = EARTH_RATE_DEG_H;

#[cfg(test)]
mod tests;
