//! Columns as logs name them, and rows of their numbers.

use super::units::QUANTITIES;

/// A column as the log names it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// The name without its unit; empty where there is none.
    pub name: String,
    /// The unit as it stands behind the name or below it.
    pub unit: Option<String>,
}

/// A column with its numbers.
pub type Named = (Column, Vec<f64>);

/// Names of columns that say which IMU a row is of.
const IDS: [&str; 12] = [
    "imu",
    "imu_id",
    "imu_no",
    "serial",
    "serial_no",
    "sn",
    "unit",
    "device",
    "device_id",
    "sensor",
    "sensor_id",
    "编号",
];

impl Column {
    /// Whether it may say which of several IMUs a row is of.
    pub fn is_id(&self) -> bool {
        let plain = self.name.to_lowercase().replace([' ', '-', '.'], "_");
        IDS.contains(&plain.trim_end_matches('_'))
    }

    /// From a heading such as `gyro_x (deg/s)` or `ax [m/s^2]`.
    pub fn named(heading: &str) -> Self {
        let heading = heading.trim().replace(['（', '［'], "(").replace(['）', '］'], ")");
        let heading = heading.as_str();
        let is_unit = |at: usize| at > 0 || QUANTITIES.iter().any(|q| q.unit(&heading[1..heading.len() - 1]).is_some());
        let open = heading.rfind(['(', '[']).filter(|&at| heading.ends_with([')', ']']) && is_unit(at));
        match open {
            Some(at) => {
                let unit = heading[at + 1..heading.len() - 1].trim();
                if unit.parse::<f64>().is_ok() {
                    return Self { name: heading.to_owned(), unit: None };
                }
                let unit = Some(unit).filter(|unit| !unit.is_empty()).map(str::to_owned);
                Self { name: heading[..at].trim().to_owned(), unit }
            }
            None => Self { name: heading.to_owned(), unit: None },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_parted_from_their_units() {
        for (heading, name, unit) in [
            ("gyro_x (deg/s)", "gyro_x", Some("deg/s")),
            ("ax [m/s^2]", "ax", Some("m/s^2")),
            ("a(1) [g]", "a(1)", Some("g")),
            ("a(2)", "a(2)", None),
            ("gyro_x", "gyro_x", None),
            ("[pulse]", "", Some("pulse")),
            ("(left)", "(left)", None),
            ("t []", "t", None),
            ("时间（秒）", "时间", Some("秒")),
        ] {
            assert_eq!(Column::named(heading), Column { name: name.to_owned(), unit: unit.map(str::to_owned) });
        }
    }
}
