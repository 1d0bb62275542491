//! What the regressors are made of: the commanded and read quantities of a campaign, column by column.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::core::campaign::{Campaign, Phase, Temperatures};
use crate::core::mounting::Slot;
use crate::core::numerics::median::upper_median_of;

/// Axes and first-order parameters of one gyro as the campaign shows them.
#[derive(Debug, Clone, PartialEq)]
pub struct GyroAxes {
    pub slot: Slot,
    /// |E|, pulse/arcsec.
    pub scale: f64,
    /// Unit vectors in body axes; S and O are the nominal ones carried along with I.
    pub input: Vector3<f64>,
    pub spin: Vector3<f64>,
    pub output: Vector3<f64>,
    /// G/|E|, deg/(h g0), body axes.
    pub g: Vector3<f64>,
    /// P/|E|, deg/(h g0^2), likewise, and the bias, deg/h; only effects that are not small ask for them.
    pub p: Vector3<f64>,
    pub bias: f64,
}

impl GyroAxes {
    /// Carries the nominal triad along by the smallest rotation that takes the nominal I to the direction of `e`.
    pub fn carried(slot: Slot, nominal: Matrix3<f64>, e: Vector3<f64>, g: Vector3<f64>) -> Self {
        let scale = e.norm();
        let (i0, s0) = (nominal.row(0).transpose(), nominal.row(1).transpose());
        let turn = Rotation3::rotation_between(&i0, &e).unwrap_or_else(Rotation3::identity);
        let (input, spin) = (turn * i0, turn * s0);
        Self { slot, scale, input, spin, output: input.cross(&spin), g: g / scale, p: Vector3::zeros(), bias: 0.0 }
    }

    /// The same gyro with another E, G, P and bias, in units of the scale that it has, and its triad carried along.
    pub fn turned(&self, e: Vector3<f64>, [g, p]: [Vector3<f64>; 2], bias: f64) -> Self {
        let input = e.normalize();
        let spin = (self.spin - input * input.dot(&self.spin)).normalize();
        Self { input, spin, output: input.cross(&spin), g: g / e.norm(), p: p / e.norm(), bias, ..self.clone() }
    }
}

/// The dwells as columns. `n` dwells, `gyros` gyros.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Specific force, g0, body axes.
    pub force: Vec<Vector3<f64>>,
    /// Inertial rate, arcsec/s = deg/h, body axes.
    pub rate: Vec<Vector3<f64>>,
    pub phase: Vec<Phase>,
    /// Middle of each dwell, s.
    pub time: Vec<f64>,
    pub duration: Vec<f64>,
    /// Temperature minus its mean, K; sensors' fault values and gaps filled from the dwells beside them.
    pub temperature: Option<Vec<f64>>,
    /// C(q) of each dwell, where all dwells carry an attitude.
    pub nav_to_body: Option<Vec<Matrix3<f64>>>,
    /// Earth rate in nav, deg/h.
    pub earth_nav: Vector3<f64>,
    /// Plumb-line specific force, g0.
    pub gravity: f64,
    pub field_nav: Option<Vector3<f64>>,
    pub gyros: Vec<GyroAxes>,
}

impl Setting {
    /// The commanded dwells of a campaign, in the order of time. Without a site the Earth's rate is the mean of what
    /// the static dwells say at their attitudes, zero where they have none.
    pub fn of(campaign: &Campaign, gyros: Vec<GyroAxes>) -> Self {
        let dwells = &campaign.dwells;
        let nav_to_body: Option<Vec<_>> = dwells.iter().map(|d| d.attitude.map(|c| *c.matrix())).collect();
        let force: Vec<_> = dwells.iter().map(|d| d.specific_force_g0).collect();
        let rate: Vec<_> = dwells.iter().map(|d| d.rate_arcsec_s).collect();
        let phase: Vec<_> = dwells.iter().map(|d| d.phase).collect();
        let earth_nav = campaign.site.map(|s| s.earth_rate().0).unwrap_or_else(|| {
            nav_to_body.as_deref().map(|c| mean_static_rate_nav(c, &rate, &phase)).unwrap_or_default()
        });
        let gravity = campaign.site.map(|s| s.gravity_g0).unwrap_or_else(|| mean_norm(&force));
        Self {
            time: dwells.iter().map(|d| d.mid_s()).collect(),
            duration: dwells.iter().map(|d| d.duration_s).collect(),
            temperature: Temperatures::of(campaign).filled.map(centred),
            field_nav: campaign.site.and_then(|s| s.magnetic_field_nav),
            force,
            rate,
            phase,
            nav_to_body,
            earth_nav,
            gravity,
            gyros,
        }
    }

    /// The same with temperatures counted from `reference_c`, deg C, and not from the campaign's mean.
    pub fn referred_to(mut self, campaign: &Campaign, reference_c: Option<f64>) -> Self {
        if let (Some(reference), Some(stated)) = (reference_c, Temperatures::stated(campaign)) {
            self.temperature = Some(stated.into_iter().map(|t| t - reference).collect());
        }
        self
    }

    /// The same at one temperature throughout, K.
    pub fn at_kelvin(&self, kelvin: f64) -> Self {
        Self { temperature: Some(vec![kelvin; self.dwells()]), ..self.clone() }
    }

    /// Number of dwells.
    pub fn dwells(&self) -> usize {
        self.force.len()
    }

    /// One number a dwell.
    pub fn column(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.dwells()).map(value).collect()
    }

    /// A column for each body axis, of numbers by dwell and axis.
    pub(super) fn by_axis(&self, value: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
        (0..3).map(|i| self.column(|k| value(k, i))).collect()
    }

    /// Temperature of dwell `k`, K; zero where there is none.
    pub(super) fn kelvin(&self, k: usize) -> f64 {
        self.temperature.as_ref().map_or(0.0, |t| t[k])
    }

    /// Drift of gyro `j` in dwell `k` that model (6) knows of, deg/h: a scale factor that changes is that of all the gyro
    /// senses.
    pub(super) fn drift(&self, j: usize, k: usize) -> f64 {
        let (gyro, a) = (&self.gyros[j], self.force[k]);
        gyro.bias + gyro.g.dot(&a) + gyro.p.dot(&a.component_mul(&a))
    }

    /// From the first dwell's middle to the last's, s.
    pub fn span(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0) - self.time.first().copied().unwrap_or(0.0)
    }

    /// Time since the first dwell's middle, s.
    pub fn elapsed(&self, k: usize) -> f64 {
        self.time[k] - self.time[0]
    }

    /// Dwells before which there was a pause: ten usual intervals, which is what a change of fixture or power takes.
    pub fn pauses(&self) -> impl Iterator<Item = usize> {
        let long = 10.0 * self.interval();
        (1..self.dwells()).filter(move |&k| self.time[k] - self.time[k - 1] > long)
    }

    /// Median interval between the middles of neighbouring dwells, s.
    pub fn interval(&self) -> f64 {
        upper_median_of(self.time.windows(2).map(|w| w[1] - w[0])).unwrap_or(1.0)
    }
}

fn mean_static_rate_nav(c: &[Matrix3<f64>], rate: &[Vector3<f64>], phase: &[Phase]) -> Vector3<f64> {
    let nav: Vec<_> = (0..c.len()).filter(|&k| phase[k] == Phase::Static).map(|k| c[k].transpose() * rate[k]).collect();
    nav.iter().sum::<Vector3<f64>>() / nav.len().max(1) as f64
}

fn mean_norm(vectors: &[Vector3<f64>]) -> f64 {
    vectors.iter().map(Vector3::norm).sum::<f64>() / vectors.len().max(1) as f64
}

fn centred(values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.into_iter().map(|x| x - mean).collect()
}
