//! How well a station knows its own table: what no repetition on it shows.

use crate::core::named::named;

/// Systematic standard uncertainties (GUM type B) of small rotations that all dwells of a campaign share, radians; none
/// where nothing is stated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StationUncertainty {
    /// Of the table's vertical, about east and about north alike.
    pub levelling: Option<f64>,
    /// Of the table's north, about the vertical.
    pub azimuth: Option<f64>,
    /// Of the IMU against the table, about each body axis alike.
    pub fixture: Option<f64>,
}

named! {
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StationPart {
    Levelling = "levelling",
    Azimuth = "azimuth",
    Fixture = "fixture",
}
}

impl StationUncertainty {
    /// The standard uncertainty of a part, arcsec; none where the station does not state it.
    pub fn of(&self, part: StationPart) -> Option<f64> {
        match part {
            StationPart::Levelling => self.levelling,
            StationPart::Azimuth => self.azimuth,
            StationPart::Fixture => self.fixture,
        }
    }

    /// What is stated here, and of the rest what `otherwise` states.
    pub fn or(self, otherwise: Self) -> Self {
        Self {
            levelling: self.levelling.or(otherwise.levelling),
            azimuth: self.azimuth.or(otherwise.azimuth),
            fixture: self.fixture.or(otherwise.fixture),
        }
    }

    /// Whether any of levelling, azimuth and fixture is stated.
    pub fn is_stated(&self) -> bool {
        StationPart::ALL.iter().any(|part| self.of(*part).is_some())
    }
}
