//! Causes that no catalogue lists: an honest diagnosis sees that something is there and declines to name it.

use nalgebra::{Vector3, Vector6};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::gaussian;
use super::sensed::{Action, Disturbance, Sensed, Situation, drift, scale};

/// Families of such causes, each with its hidden particulars.
#[derive(Debug, Clone)]
pub enum UncataloguedCause {
    /// What has no particulars.
    Plain(Action),
    /// A smooth random function of the whole attitude (up and north in the body): waves of a few radians.
    Orientation(Box<[[Wave; 4]; 3]>),
    /// A number per dwell and gyro, whatever its origin.
    Series(Vec<[f64; 3]>),
    /// From -1/2 up to 1/2 in each period.
    Sawtooth { period_h: f64, phase: f64 },
    /// Scale factor that steps at a dwell.
    ScaleStep { first: usize },
    /// Each face of the fixture is off by small angles of its own, about body axes.
    TiltedFaces(Box<[Vector3<f64>; 6]>),
}

/// cos(k . (up, north) + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    k: Vector6<f64>,
    phase: f64,
}

/// Names of the families, as in `outside:NAME`.
pub const FAMILIES: [&str; 17] = [
    "orientation",
    "coloured_noise",
    "several_outliers",
    "temperature_squared",
    "temperature_rate",
    "temperature_time",
    "sawtooth",
    "random_walk",
    "face_age",
    "rate_time",
    "g_time",
    "scale_step",
    "rate_memory",
    "spin_rate_root",
    "noise_burst",
    "several_steps",
    TILTED_FACES,
];

/// What acts on all gyros at once, through the fixture.
pub const TILTED_FACES: &str = "tilted_faces";

/// The families that act in single gyros.
pub fn in_gyros() -> &'static [&'static str] {
    FAMILIES.split_last().map_or(&[], |(_, others)| others)
}

/// What a cause of a family depends on, by the names of a description: any of them is right.
pub fn depends_on(family: &str) -> &'static [&'static str] {
    match family {
        "orientation" => &["up_direction", "heading"],
        "several_outliers" => &["single_dwells"],
        "noise_burst" => &["single_dwells", "time"],
        "temperature_squared" => &["temperature"],
        "temperature_rate" => &["temperature_and_rate"],
        "temperature_time" => &["temperature_and_time", "temperature", "time"],
        "face_age" => &["orientation_age"],
        // The scale of all that the gyro senses: drift that follows force is in it.
        "rate_time" | "scale_step" => &["time_and_rate", "time_and_force"],
        "g_time" => &["time_and_force"],
        "rate_memory" => &["rate_history"],
        "spin_rate_root" => &["rate_level", "rate_axis"],
        TILTED_FACES => &["rate_axis", "up_direction", "heading"],
        _ => &["time"],
    }
}

impl UncataloguedCause {
    /// A member of a family; none where the name is unknown. `mid_h` holds the mid-times of the dwells.
    pub fn draw(family: &str, mid_h: &[f64], rng: &mut ChaCha8Rng) -> Option<Self> {
        let dwells = mid_h.len();
        let span_h = mid_h.last().copied().unwrap_or(0.0).max(1e-3);
        Some(match family {
            "orientation" => Self::Orientation(Box::new([0; 3].map(|_| [0; 4].map(|_| Wave::draw(rng))))),
            "coloured_noise" => Self::Series(coloured(dwells, rng)),
            "several_outliers" => Self::Series(outliers(dwells, rng)),
            "temperature_squared" => Self::Plain(|_, at| drift(at.temperature_k * at.temperature_k)),
            "temperature_rate" => Self::Plain(|sensed, at| drift(at.temperature_k * sensed.w.y)),
            "temperature_time" => Self::Plain(|_, at| drift(at.temperature_k * at.time_h)),
            "sawtooth" => {
                Self::Sawtooth { period_h: span_h / rng.random_range(2.0..5.0), phase: rng.random_range(0.0..1.0) }
            }
            "random_walk" => Self::Series(walk(dwells, rng)),
            "face_age" => Self::Plain(|_, at| drift(at.since_face_change_h)),
            // A scale factor, and a mass unbalance, that run away.
            "rate_time" => Self::Plain(|_, at| scale(at.time_h)),
            "g_time" => Self::Plain(|sensed, at| drift(sensed.a.y * at.time_h)),
            "scale_step" => {
                Self::ScaleStep { first: rng.random_range(dwells / 4..(3 * dwells / 4).max(dwells / 4 + 1)) }
            }
            "rate_memory" => Self::Plain(|sensed, _| drift(sensed.w_before.map_or(0.0, |w| w.y))),
            // A bearing that slips.
            "spin_rate_root" => Self::Plain(|sensed, _| drift(sensed.w.y.signum() * sensed.w.y.abs().sqrt())),
            "noise_burst" => Self::Series(burst(dwells, rng)),
            "several_steps" => Self::Series(steps(dwells, rng)),
            TILTED_FACES => Self::TiltedFaces(Box::new([0; 6].map(|_| Vector3::from_fn(|_, _| gaussian(rng))))),
            _ => return None,
        })
    }

    pub(super) fn at_unit_size(&self, gyro: usize, sensed: &Sensed, at: &Situation) -> Disturbance {
        match self {
            Self::Plain(action) => action(sensed, at),
            Self::Orientation(waves) => drift(waves[gyro].iter().map(|wave| wave.at(sensed)).sum()),
            Self::Series(values) => drift(values[at.index][gyro]),
            Self::Sawtooth { period_h, phase } => drift((at.time_h / period_h + phase).fract() - 0.5),
            Self::ScaleStep { first } => scale(f64::from(at.index >= *first)),
            // The seat of the IMU has it.
            Self::TiltedFaces(_) => Disturbance::default(),
        }
    }
}

impl Wave {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        Self { k: Vector6::from_fn(|_, _| 1.5 * gaussian(rng)), phase: rng.random_range(0.0..std::f64::consts::TAU) }
    }

    fn at(&self, sensed: &Sensed) -> f64 {
        let (up, north) = (sensed.body.a.normalize(), sensed.body.north);
        (self.k.dot(&Vector6::new(up.x, up.y, up.z, north.x, north.y, north.z)) + self.phase).cos()
    }
}

fn per_gyro(dwells: usize, mut series: impl FnMut() -> Vec<f64>) -> Vec<[f64; 3]> {
    let each = [series(), series(), series()];
    (0..dwells).map(|k| [each[0][k], each[1][k], each[2][k]]).collect()
}

/// AR(1) with a correlation of 0.6 to 0.9 from dwell to dwell.
fn coloured(dwells: usize, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let rho: f64 = rng.random_range(0.6..0.9);
    per_gyro(dwells, || {
        let mut x = gaussian(rng);
        let mut next = || {
            x = rho * x + (1.0 - rho * rho).sqrt() * gaussian(rng);
            x
        };
        (0..dwells).map(|_| next()).collect()
    })
}

fn walk(dwells: usize, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    per_gyro(dwells, || {
        let mut x = 0.0;
        let mut next = || {
            x += gaussian(rng);
            x
        };
        (0..dwells).map(|_| next()).collect()
    })
}

/// Three to six dwells off, each by its own amount and the same dwells in every gyro (a door, a truck).
fn outliers(dwells: usize, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let mut all: Vec<usize> = (0..dwells).collect();
    all.shuffle(rng);
    let mut series = vec![[0.0; 3]; dwells];
    for &k in all.iter().take(rng.random_range(3..=6)) {
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        series[k] = [0; 3].map(|_| sign * rng.random_range(0.7..1.3));
    }
    series
}

/// Noise in a sixth of the campaign only.
fn burst(dwells: usize, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let length = (dwells / 6).max(4).min(dwells);
    let first = rng.random_range(0..=dwells - length);
    let inside = first..first + length;
    let mut value = |k: usize| if inside.contains(&k) { gaussian(rng) } else { 0.0 };
    (0..dwells).map(|k| [0; 3].map(|_| value(k))).collect()
}

/// A bias that jumps at three instants and stays.
fn steps(dwells: usize, rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let mut edges: Vec<usize> = (1..4).map(|quarter| quarter * dwells / 4).collect();
    for edge in &mut edges {
        *edge += rng.random_range(0..=dwells / 8);
    }
    let mut levels = vec![[0.0; 3]];
    for _ in &edges {
        levels.push([0; 3].map(|_| gaussian(rng)));
    }
    (0..dwells).map(|k| levels[edges.iter().filter(|&&edge| k >= edge).count()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{Stream, random};

    #[test]
    fn every_family_can_be_drawn_and_no_other() {
        let mut rng = random(3, Stream::Causes);
        let mid_h: Vec<f64> = (0..24).map(|k| f64::from(k) / 15.0).collect();
        for family in FAMILIES {
            assert!(UncataloguedCause::draw(family, &mid_h, &mut rng).is_some(), "{family}");
        }
        assert!(UncataloguedCause::draw("temperature_bias", &mid_h, &mut rng).is_none());
    }

    #[test]
    fn several_outliers_are_several() {
        for seed in 0..20 {
            let hit = outliers(78, &mut random(seed, Stream::Causes)).iter().filter(|v| v[0] != 0.0).count();
            assert!((3..=6).contains(&hit));
        }
    }

    #[test]
    fn coloured_noise_is_correlated_from_dwell_to_dwell() {
        let series = coloured(4000, &mut random(5, Stream::Causes));
        let x: Vec<f64> = series.iter().map(|v| v[1]).collect();
        let power: f64 = x.iter().map(|v| v * v).sum();
        let lag1: f64 = x.windows(2).map(|p| p[0] * p[1]).sum();
        assert!((0.55..0.95).contains(&(lag1 / power)), "{}", lag1 / power);
    }
}
