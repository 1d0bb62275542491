//! What may be wrong beyond model (6): causes as physics, each acting on one gyro at one moment or on the table.

use nalgebra::{Rotation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::outside::{FAMILIES, UncataloguedCause};
use super::programme::any_direction;
use super::sensed::{Action, Disturbance, Sensed, Situation, drift, scale};

use Law::{Along, Own, Plain};
use ShownBy::{Always, Attitudes, Closure, OffAxis, OwnTerm, Rotation};

/// The drift that an effect of size one makes along a direction.
pub type Projection = fn(&Vector3<f64>, &Sensed, &Situation) -> f64;

/// How an effect of the catalogue acts.
#[derive(Debug, Clone, Copy)]
pub enum Law {
    Plain(Action),
    /// Along a direction a gyro, of unit length.
    Along(Projection),
    /// By particulars of its own, or not within the gyros.
    Own,
}

/// An effect of the catalogue with its hidden particulars.
#[derive(Debug, Clone)]
pub enum Mechanism {
    Plain(Action),
    Along(Projection, [Vector3<f64>; 3]),
    Warmup {
        tau_h: f64,
    },
    BiasStep {
        first: usize,
    },
    OutlierDwell {
        index: usize,
    },
    Periodic {
        period_h: f64,
        phase: f64,
    },
    Levelling {
        east: f64,
        north: f64,
    },
    Azimuth,
    /// A tilt of the table that begins with a dwell.
    Relevelling {
        east: f64,
        north: f64,
        first: usize,
    },
    /// The IMU sits otherwise in its fixture, turned about body axes, from a dwell on; where none is given, while the
    /// table turns.
    Reseating {
        about: Vector3<f64>,
        first: Option<usize>,
    },
    MountClocking,
}

/// What a campaign must hold for an effect to show in its residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShownBy {
    Always,
    Rotation,
    /// Rotation, and the attitudes of the dwells.
    Attitudes,
    /// Positions off the body axes.
    OffAxis,
    /// A term of the model in use.
    OwnTerm,
    /// Hidden in a term of the model: only the closure of G.
    Closure,
}

/// An effect of the catalogue that can be injected.
#[derive(Debug, Clone, Copy)]
pub struct Injectable {
    pub id: &'static str,
    /// Typical size in its own unit.
    pub typical: f64,
    pub shown_by: ShownBy,
    law: Law,
}

const fn row(id: &'static str, typical: f64, shown_by: ShownBy, law: Law) -> Injectable {
    Injectable { id, typical, shown_by, law }
}

/// The effects that can be injected.
pub const CATALOGUE: [Injectable; 26] = [
    row("g_linear", 0.05, OwnTerm, Along(|k, s, _| k.dot(&s.body.a))), // deg/(h g0)
    row("g_squared", 0.05, OwnTerm, Along(|k, s, _| k.dot(&s.body.a.component_mul(&s.body.a)))), // deg/(h g0^2)
    row("temperature_bias", 0.005, Always, Plain(|_, at| drift(at.temperature_k))), // deg/h/K
    row("temperature_g", 0.01, Always, Along(|k, s, at| at.temperature_k * k.dot(&s.a))), // deg/(h g0 K)
    row("temperature_scale", 1e-6, Rotation, Plain(|_, at| scale(at.temperature_k))), // 1/K
    row("warmup", 0.02, Always, Own),                                  // deg/h
    row("time_ramp", 0.002, Always, Plain(|_, at| drift(at.time_h))),  // deg/h per h
    row("bias_step", 0.01, Always, Own),                               // deg/h
    row("outlier_dwell", 0.02, Always, Own),                           // deg/h
    row("periodic", 0.005, Always, Own),                               // deg/h
    row("hysteresis", 0.005, Always, Plain(|s, _| drift(s.a_before.map_or(0.0, |a| a.z)))), // deg/(h g0)
    row("scale_asymmetry", 1e-6, Rotation, Plain(|s, _| scale(s.w.x.signum()))),
    row("scale_quadratic", 1e-9, Rotation, Plain(|s, _| drift(s.w.x * s.w.x))), // deg/h per (deg/h)^2
    row("scale_cubic", 1e-13, Rotation, Plain(|s, _| drift(s.w.x.powi(3)))),    // deg/h per (deg/h)^3
    row("anisoinertia", 1e-9, Rotation, Plain(|s, _| drift(s.w.x * s.w.y))),    // deg/h per (deg/h)^2
    row("g_rate_coupling", 1e-6, Rotation, Plain(|s, _| scale(s.a.x))),         // 1/g0
    row("levelling", 1e-4, Attitudes, Own),                                     // rad
    row("azimuth", 2e-4, Attitudes, Own),                                       // rad
    row("relevelling", 1e-4, Attitudes, Own),                                   // rad
    row("reseating", 1e-4, Rotation, Own),                                      // rad
    row("magnetic", 0.01, Attitudes, Along(|k, s, _| k.dot(&s.field))),         // deg/h in the field of the site
    row("axial_compliance", 0.05, OffAxis, Along(|k, s, _| k.dot(&axial(&s.a)))), // deg/(h g0^2)
    row("cross_compliance", 0.05, OffAxis, Along(|k, s, _| k.dot(&crossed(&s.a)))), // deg/(h g0^2)
    row("cubic_g", 0.02, OffAxis, Plain(|s, _| drift(s.a.x.powi(3)))),          // deg/(h g0^3)
    row("output_axis_g", 0.1, Closure, Plain(|s, _| drift(s.a.z))),             // deg/(h g0)
    row("mount_clocking", 1e-3, Closure, Own),                                  // rad
];

/// What D_II and D_SS act on.
fn axial(a: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(a.x * a.x, a.y * a.y, 0.0)
}

/// What k_IS, k_IO and k_OS act on.
fn crossed(a: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(a.x * a.y, a.x * a.z, a.z * a.y)
}

/// Everything that can be put into a campaign, by the name to ask for it, for messages.
pub fn known() -> String {
    let outside = FAMILIES.map(|family| format!("outside:{family}"));
    format!("{}, and outside the catalogue {}", listed(), outside.join(", "))
}

/// The effects of the catalogue by name.
pub fn listed() -> String {
    CATALOGUE.map(|known| known.id).join(", ")
}

fn law_of(id: &str) -> Option<Law> {
    CATALOGUE.iter().find(|known| known.id == id).map(|known| known.law)
}

/// What a station does, by its id: a field, the table tilted throughout and from a dwell on, the IMU seated anew, the
/// power put on.
pub const FIELD: &str = "magnetic";
pub const TILT: &str = "levelling";
pub const NORTH: &str = "azimuth";
pub const TILT_FROM_A_DWELL: &str = "relevelling";
pub const SEAT: &str = "reseating";
pub const POWER_UP: &str = "warmup";

/// Ids that act in every dwell of a campaign that shows them, one way throughout.
pub const THROUGHOUT: [&str; 10] = [
    "temperature_bias",
    "temperature_g",
    "temperature_scale",
    "time_ramp",
    "hysteresis",
    "scale_asymmetry",
    "scale_quadratic",
    "anisoinertia",
    "g_rate_coupling",
    FIELD,
];

/// Ids of biases that change in the course of a campaign.
pub const IN_TIME: [&str; 5] = ["time_ramp", POWER_UP, "bias_step", "periodic", "temperature_bias"];

/// Ids that act through the table on every gyro at once.
pub const COMMON: [&str; 4] = ["levelling", "azimuth", "relevelling", "reseating"];

/// A cause in one campaign: what, how much, and by which factor in each slot (zero: the gyro does not have it).
#[derive(Debug, Clone)]
pub struct Cause {
    /// Catalogue id, or `outside:FAMILY`.
    pub label: String,
    pub size: f64,
    pub weights: [f64; 3],
    pub kind: CauseKind,
    /// From when to when it acts, hours.
    pub acts_in_h: [f64; 2],
}

/// All the time.
pub const ALWAYS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Whether the diagnosis has an entry for a cause.
#[derive(Debug, Clone)]
pub enum CauseKind {
    Catalogue(Mechanism),
    Uncatalogued(UncataloguedCause),
}

/// Particulars that a person may fix; the rest is drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Particulars {
    pub time_h: Option<f64>,
    pub dwell: Option<usize>,
    pub direction: Option<Vector3<f64>>,
}

impl Mechanism {
    /// The effect of a catalogue id with its particulars; none where the id is unknown.
    /// `starts_h` holds the mid-times of the dwells.
    pub fn draw(id: &str, fixed: &Particulars, starts_h: &[f64], rng: &mut ChaCha8Rng) -> Option<Self> {
        match law_of(id)? {
            Plain(action) => return Some(Self::Plain(action)),
            Along(of) => {
                let directions = [0; 3].map(|_| fixed.direction.unwrap_or_else(|| any_direction(rng)));
                return Some(Self::Along(of, directions));
            }
            Own => {}
        }
        let dwells = starts_h.len();
        let span_h = starts_h.last().copied().unwrap_or(0.0).max(1e-3);
        let tilt = |rng: &mut ChaCha8Rng| {
            let angle = rng.random_range(0.0..std::f64::consts::TAU);
            fixed.direction.unwrap_or(Vector3::new(angle.cos(), angle.sin(), 0.0))
        };
        Some(match id {
            "warmup" => Self::Warmup { tau_h: fixed.time_h.unwrap_or_else(|| span_h * rng.random_range(0.05..0.3)) },
            "bias_step" => Self::BiasStep { first: fixed.dwell.unwrap_or_else(|| inner_dwell(dwells, rng)) },
            "outlier_dwell" => Self::OutlierDwell { index: fixed.dwell.unwrap_or_else(|| rng.random_range(0..dwells)) },
            "periodic" => {
                let drawn = span_h / rng.random_range(1.5..(dwells as f64 / 6.0).max(2.0));
                let phase = rng.random_range(0.0..std::f64::consts::TAU);
                Self::Periodic { period_h: fixed.time_h.unwrap_or(drawn), phase }
            }
            "levelling" => {
                let along = tilt(rng);
                Self::Levelling { east: along.x, north: along.y }
            }
            "relevelling" => {
                let along = tilt(rng);
                let first = fixed.dwell.unwrap_or_else(|| inner_dwell(dwells, rng));
                Self::Relevelling { east: along.x, north: along.y, first }
            }
            "reseating" => {
                Self::Reseating { about: fixed.direction.unwrap_or_else(|| any_direction(rng)), first: fixed.dwell }
            }
            "azimuth" => Self::Azimuth,
            "mount_clocking" => Self::MountClocking,
            _ => return None,
        })
    }

    /// Its own time constant or period, hours.
    pub fn own_time_h(&self) -> Option<f64> {
        match self {
            Self::Warmup { tau_h } => Some(*tau_h),
            Self::Periodic { period_h, .. } => Some(*period_h),
            _ => None,
        }
    }

    /// Alternatives of an effect, each with one member for every free coefficient, over a campaign of so many hours
    /// and dwells; `times` are tried beside the grid of time constants and periods.
    pub fn alternatives(id: &str, span_h: f64, dwells: usize, times: &[f64]) -> Option<Vec<Vec<Self>>> {
        match law_of(id)? {
            Plain(action) => return Some(vec![vec![Self::Plain(action)]]),
            Along(of) => {
                return Some(vec![(0..3).map(|axis| Self::Along(of, [Vector3::ith(axis, 1.0); 3])).collect()]);
            }
            Own => {}
        }
        let sines =
            |period_h: f64| [0.0, std::f64::consts::FRAC_PI_2].map(|phase| Self::Periodic { period_h, phase }).to_vec();
        Some(match id {
            "levelling" => {
                vec![vec![Self::Levelling { east: 1.0, north: 0.0 }, Self::Levelling { east: 0.0, north: 1.0 }]]
            }
            "relevelling" => {
                let tilts =
                    |first| [(1.0, 0.0), (0.0, 1.0)].map(|(east, north)| Self::Relevelling { east, north, first });
                (1..dwells).map(|first| tilts(first).to_vec()).collect()
            }
            "reseating" => {
                let turns = |first| (0..3).map(|i| Self::Reseating { about: Vector3::ith(i, 1.0), first }).collect();
                [None].into_iter().chain((1..dwells).map(Some)).map(turns).collect()
            }
            "warmup" => {
                let grid =
                    (0..TIME_CONSTANTS).map(|k| span_h * 0.01 * 100.0_f64.powf(k as f64 / (TIME_CONSTANTS - 1) as f64));
                let taus = grid.chain(times.iter().copied());
                taus.map(|tau_h| vec![Self::Warmup { tau_h }]).collect()
            }
            "periodic" => {
                let grid = (1..=dwells).map(|k| 2.0 * span_h / k as f64);
                grid.chain(times.iter().copied()).map(sines).collect()
            }
            "bias_step" => (1..dwells).map(|first| vec![Self::BiasStep { first }]).collect(),
            "outlier_dwell" => (0..dwells).map(|index| vec![Self::OutlierDwell { index }]).collect(),
            "azimuth" => vec![vec![Self::Azimuth]],
            "mount_clocking" => vec![vec![Self::MountClocking]],
            _ => return None,
        })
    }
}

/// Time constants that are tried, from a hundredth of the campaign to all of it.
const TIME_CONSTANTS: usize = 24;

/// A dwell away from both ends, where a step leaves something on either side.
fn inner_dwell(dwells: usize, rng: &mut ChaCha8Rng) -> usize {
    let margin = (dwells / 6).max(1);
    rng.random_range(margin..(dwells - margin).max(margin + 1))
}

impl Cause {
    fn is_acting(&self, at: &Situation) -> bool {
        (self.acts_in_h[0]..=self.acts_in_h[1]).contains(&at.time_h)
    }

    /// How this cause misplaces the table in one dwell; the identity for causes inside gyros.
    pub fn table_from_nav(&self, at: &Situation) -> Rotation3<f64> {
        let tilt = |east: f64, north: f64, up: f64| Rotation3::new(Vector3::new(east, north, up) * self.size);
        match self.kind {
            CauseKind::Catalogue(Mechanism::Levelling { east, north }) if self.is_acting(at) => tilt(east, north, 0.0),
            CauseKind::Catalogue(Mechanism::Relevelling { east, north, first }) if at.index >= first => {
                tilt(east, north, 0.0)
            }
            CauseKind::Catalogue(Mechanism::Azimuth) if self.is_acting(at) => tilt(0.0, 0.0, 1.0),
            _ => Rotation3::identity(),
        }
    }

    /// How the IMU sits in its fixture, as the body axes of one dwell see it.
    pub fn seat(&self, at: &Situation) -> Rotation3<f64> {
        match &self.kind {
            CauseKind::Catalogue(Mechanism::Reseating { about, first })
                if first.map_or(at.turning, |first| at.index >= first) =>
            {
                Rotation3::new(*about * self.size)
            }
            CauseKind::Uncatalogued(UncataloguedCause::TiltedFaces(angles)) => {
                Rotation3::new(angles[at.face] * self.size)
            }
            _ => Rotation3::identity(),
        }
    }

    /// Rotation of the spin axis about the input axis, radians.
    pub fn clocking(&self, gyro: usize) -> f64 {
        match self.kind {
            CauseKind::Catalogue(Mechanism::MountClocking) => self.size * self.weights[gyro],
            _ => 0.0,
        }
    }

    /// What it adds to one gyro at one moment.
    pub fn acts(&self, gyro: usize, sensed: &Sensed, at: &Situation) -> Disturbance {
        let k = self.size * self.weights[gyro];
        if k == 0.0 || !self.is_acting(at) {
            return Disturbance::default();
        }
        let unit = match &self.kind {
            CauseKind::Catalogue(effect) => effect.at_unit_size(gyro, sensed, at),
            CauseKind::Uncatalogued(outside) => outside.at_unit_size(gyro, sensed, at),
        };
        Disturbance { drift: k * unit.drift, scale: k * unit.scale }
    }
}

impl Mechanism {
    fn at_unit_size(&self, gyro: usize, sensed: &Sensed, at: &Situation) -> Disturbance {
        match self {
            Self::Plain(action) => action(sensed, at),
            Self::Along(of, directions) => drift(of(&directions[gyro], sensed, at)),
            Self::Warmup { tau_h } => drift((-at.since_power_up_h / tau_h).exp()),
            Self::BiasStep { first } => drift(f64::from(at.index >= *first)),
            Self::OutlierDwell { index } => drift(f64::from(at.index == *index)),
            Self::Periodic { period_h, phase } => drift((std::f64::consts::TAU * at.time_h / period_h + phase).sin()),
            Self::Levelling { .. }
            | Self::Azimuth
            | Self::Relevelling { .. }
            | Self::Reseating { .. }
            | Self::MountClocking => Disturbance::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{Stream, random};

    #[test]
    fn every_listed_id_can_be_drawn_and_no_other() {
        let mut rng = random(1, Stream::Causes);
        for Injectable { id, typical, .. } in CATALOGUE {
            assert!(Mechanism::draw(id, &Particulars::default(), &[0.1, 0.2, 0.3, 0.4], &mut rng).is_some(), "{id}");
            assert!(typical > 0.0);
            assert!(Mechanism::alternatives(id, 1.0, 4, &[]).is_some_and(|all| !all.is_empty()), "{id}");
        }
        assert!(COMMON.iter().all(|id| CATALOGUE.iter().any(|known| known.id == *id)));
        assert!(Mechanism::draw("time_rampp", &Particulars::default(), &[0.1], &mut rng).is_none());
    }
}
