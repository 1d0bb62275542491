//! Units as people write them, and what they are worth in the campaign's: arcsec/s, g0, deg C, s, rad.

use crate::core::units::STANDARD_GRAVITY_M_S2;

/// What a column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    Time,
    Output,
    Force,
    Rate,
    Angle,
    Temperature,
}

pub const QUANTITIES: [Quantity; 6] =
    [Quantity::Time, Quantity::Output, Quantity::Force, Quantity::Rate, Quantity::Angle, Quantity::Temperature];

/// What a unit makes of a number: value = factor * number + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    pub factor: f64,
    pub offset: f64,
    pub counts: Counts,
}

/// Whether an output is a rate already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counts {
    /// A rate of turn: one pulse is one arcsec.
    Angular,
    /// Pulses a second.
    Rate,
    /// Pulses since the sample before.
    Increment,
    /// Pulses since the start: the counter as it stands.
    Total,
}

impl Counts {
    /// Whether pulses are divided by the time between samples.
    pub fn need_time(self) -> bool {
        matches!(self, Self::Increment | Self::Total)
    }
}

impl Quantity {
    /// Spellings of its units, the plainest first.
    pub fn units(self) -> &'static [&'static str] {
        match self {
            Self::Time => &["s", "ms", "us", "ns", "min", "h", "unix_s", "unix_ms", "unix_us", "unix_ns"],
            Self::Output => {
                &["pulse/s", "pulse", "pulse_total", "arcsec/s", "deg/h", "deg/s", "dps", "mdeg/s", "rad/s", "mrad/s"]
            }
            Self::Force => &["g0", "g", "mg", "ug", "m/s^2", "m/s2", "m/s/s", "mps2", "cm/s^2", "gal"],
            Self::Rate => &["deg/s", "dps", "mdeg/s", "arcsec/s", "deg/h", "rad/s", "mrad/s", "rpm"],
            Self::Angle => &["deg", "rad", "mrad", "arcmin", "arcsec", "rev"],
            Self::Temperature => &["c", "degc", "celsius", "k", "kelvin", "f", "degf"],
        }
    }

    pub fn unit(self, name: &str) -> Option<Unit> {
        let plain = plain(name);
        let known = self.units().iter().find(|unit| plain == **unit)?;
        let (factor, offset) = match (self, *known) {
            (Self::Temperature, "k" | "kelvin") => (1.0, -273.15),
            (Self::Temperature, "f" | "degf") => (5.0 / 9.0, -160.0 / 9.0),
            (Self::Temperature, _) => (1.0, 0.0),
            (Self::Force, unit) => (force(unit), 0.0),
            (Self::Angle, unit) => (angle(unit), 0.0),
            (Self::Time, unit) => (seconds(unit.strip_prefix("unix_").unwrap_or(unit)), 0.0),
            (Self::Output | Self::Rate, unit) => (rate(unit), 0.0),
        };
        let counts = match *known {
            "pulse/s" => Counts::Rate,
            "pulse" => Counts::Increment,
            "pulse_total" => Counts::Total,
            _ => Counts::Angular,
        };
        Some(Unit { factor, offset, counts })
    }
}

/// What is written otherwise, and the plain spelling.
const SPELLINGS: [(&str, &str); 12] = [
    ("℃", "degc"),
    ("pulses", "pulse"),
    ("impulse", "imp"),
    ("degrees", "deg"),
    ("degree", "deg"),
    ("sec^2", "s^2"),
    ("/sec", "/s"),
    ("脉冲", "pulse"),
    ("小时", "h"),
    ("秒", "s"),
    ("度", "deg"),
    ("米", "m"),
];

/// Lower case, without blanks, with the plain spelling of powers and degrees.
fn plain(name: &str) -> String {
    let plain: String = name.chars().filter(|c| !c.is_whitespace() && *c != '·' && *c != '*').collect();
    let mut plain = plain.to_lowercase().replace('²', "^2").replace(['°', 'º'], "deg").replace(['µ', 'μ'], "u");
    for (long, short) in SPELLINGS {
        plain = plain.replace(long, short);
    }
    match plain.as_str() {
        "sec" | "seconds" => "s".to_owned(),
        "deg/hr" => "deg/h".to_owned(),
        "imp" => "pulse".to_owned(),
        "imp/s" => "pulse/s".to_owned(),
        _ => plain,
    }
}

fn rate(unit: &str) -> f64 {
    match unit {
        "deg/s" | "dps" => 3600.0,
        "mdeg/s" => 3.6,
        "rad/s" => 1f64.to_degrees() * 3600.0,
        "mrad/s" => 1f64.to_degrees() * 3.6,
        "rpm" => 6.0 * 3600.0,
        _ => 1.0,
    }
}

fn force(unit: &str) -> f64 {
    match unit {
        "mg" => 1e-3,
        "ug" => 1e-6,
        "m/s^2" | "m/s2" | "m/s/s" | "mps2" => STANDARD_GRAVITY_M_S2.recip(),
        "cm/s^2" | "gal" => 0.01 / STANDARD_GRAVITY_M_S2,
        _ => 1.0,
    }
}

fn angle(unit: &str) -> f64 {
    match unit {
        "rad" => 1.0,
        "mrad" => 1e-3,
        "arcmin" => (1f64 / 60.0).to_radians(),
        "arcsec" => (1f64 / 3600.0).to_radians(),
        "rev" => std::f64::consts::TAU,
        _ => 1f64.to_radians(),
    }
}

fn seconds(unit: &str) -> f64 {
    match unit {
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "min" => 60.0,
        "h" => 3600.0,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_known_in_the_spellings_of_loggers() {
        let factor = |q: Quantity, name: &str| q.unit(name).unwrap().factor;
        assert_eq!(factor(Quantity::Output, "deg/s"), 3600.0);
        assert_eq!(factor(Quantity::Output, "°/s"), 3600.0);
        assert!((factor(Quantity::Output, "rad / sec") - 206_264.806_247).abs() < 1e-6);
        assert!((factor(Quantity::Force, "m/s²") * 9.806_65 - 1.0).abs() < 1e-15);
        assert_eq!(factor(Quantity::Time, "µs"), 1e-6);
        let fahrenheit = Quantity::Temperature.unit("°F").unwrap();
        assert!((212.0 * fahrenheit.factor + fahrenheit.offset - 100.0).abs() < 1e-12);
        for name in ["pulses", "Imp", "Impulse", "脉冲"] {
            assert_eq!(Quantity::Output.unit(name).unwrap().counts, Counts::Increment, "{name}");
        }
        assert_eq!(Quantity::Output.unit("度/小时").unwrap().factor, 1.0);
        assert_eq!(Quantity::Force.unit("deg/s"), None);
    }
}
