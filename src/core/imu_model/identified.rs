//! What the model of one IMU is: data, and the few numbers that follow from them.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::core::adopted::Adopted;
use crate::core::effects::{GyroAxes, Refusal};
use crate::core::model::{Term, Terms};
use crate::core::mounting::{Geometry, Slot};
use crate::core::record::Name;
use crate::core::separate::{Separation, covariance_at, separate};
use crate::core::time::UtcMicros;

/// Model (6) and the adopted effects of one IMU as its campaigns determine them together.
///
/// y = D0 + G.A + P.A^2 + E.w + |E| sum_m k_m x_m (pulse/s), T in the x_m counted from `reference_c`: G, and with it
/// D_I and D_S, are those at that temperature.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    pub imu: Name,
    pub geometry: Geometry,
    pub terms: Terms,
    /// Deg C; none where no campaign states temperatures.
    pub reference_c: Option<f64>,
    /// When the newest of its campaigns was measured.
    pub measured_at: UtcMicros,
    pub gyros: Vec<ModelGyro>,
    /// Effects that act in every campaign, in the order of adoption.
    pub effects: Vec<Adopted>,
    pub coefficients: Vec<ModelCoefficient>,
    /// Of all coefficients of all gyros, in their order. Directions that no campaign shows have a variance beyond
    /// anything possible.
    pub covariance: DMatrix<f64>,
    pub campaigns: Vec<FittedCampaign>,
    pub validity: Validity,
}

/// A gyro as the model of its IMU knows it.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelGyro {
    pub slot: Slot,
    pub serial: Name,
    /// Whether E is held at [`Self::e`] and not among the coefficients.
    pub e_held: bool,
    /// E, pulse/arcsec, that effects are resolved on.
    pub e: Vector3<f64>,
    /// G, pulse/(s g0), likewise.
    pub g: Vector3<f64>,
    pub noise: NoiseLaw,
}

/// Noise of one gyro's mean over a dwell: f times the standard error that a station states, else
/// `sd^2 = |E|^2 (N^2/T + (q w_I)^2)` with T in hours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLaw {
    /// f; none where the campaigns state no standard errors.
    pub sem_factor: Option<f64>,
    /// N, deg/sqrt(h).
    pub random_walk: f64,
    /// q, 1e-6 of the rate along the input axis.
    pub rate_ppm: f64,
    /// Degrees of freedom that the scale is known by; infinite where standard errors are taken at their word.
    pub dof: f64,
}

/// Of a scale that has a standard deviation.
const LEAST_DOF: f64 = 3.0;

/// What a coefficient belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Of {
    /// Component of a term of model (6).
    Term(Term, usize),
    /// Place among the model's effects, and number of the coefficient.
    Effect(usize, usize),
}

impl Of {
    /// The effect and the number of its coefficient, where it is one's.
    pub fn effect(self) -> Option<(usize, usize)> {
        match self {
            Self::Effect(effect, number) => Some((effect, number)),
            Self::Term(..) => None,
        }
    }
}

/// A coefficient of the model. Its variance stands in the joint covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelCoefficient {
    /// None for one that all gyros share.
    pub slot: Option<Slot>,
    pub of: Of,
    /// pulse units for terms; the effect's own unit for effects.
    pub value: f64,
    /// Standard deviation from campaign to campaign beyond what their noise explains; zero where none shows.
    pub between: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct FittedCampaign {
    pub station: Name,
    pub measured_at: UtcMicros,
    pub dwells: usize,
    /// Its identifier or the hash of its document.
    pub source: Option<String>,
}

/// What the campaigns have shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Validity {
    /// Lowest and highest temperature, deg C.
    pub temperature_c: Option<[f64; 2]>,
    /// Largest commanded rate, arcsec/s.
    pub rate_arcsec_s: f64,
    /// Directions of specific force, body axes, unit length, no two nearer than some degrees.
    pub directions: Vec<Vector3<f64>>,
}

impl Identified {
    /// Estimates of all coefficients, in the order of the covariance's rows.
    pub fn values(&self) -> DVector<f64> {
        DVector::from_iterator(self.coefficients.len(), self.coefficients.iter().map(|c| c.value))
    }

    /// Degrees of freedom that one campaign's scale of the noise has on the mean, the least of all gyros without one.
    pub fn dof(&self, slot: Option<Slot>) -> f64 {
        let of_gyros = self.gyros.iter().filter(|gyro| slot.is_none_or(|slot| slot == gyro.slot));
        let least = of_gyros.map(|gyro| gyro.noise.dof).fold(f64::INFINITY, f64::min);
        (least / self.campaigns.len().max(1) as f64).max(LEAST_DOF)
    }

    /// Standard deviation of the coefficient at `place`, in its unit.
    pub fn sd(&self, place: usize) -> f64 {
        self.covariance[(place, place)].max(0.0).sqrt()
    }

    /// The gyro of a slot, if the model has one.
    pub fn gyro(&self, slot: Slot) -> Option<&ModelGyro> {
        self.gyros.iter().find(|gyro| gyro.slot == slot)
    }

    /// Places of the coefficients of an effect.
    pub fn of_effect(&self, effect: usize) -> Vec<usize> {
        let is = |c: &ModelCoefficient| c.of.effect().is_some_and(|(own, _)| own == effect);
        self.coefficients.iter().enumerate().filter(|(_, c)| is(c)).map(|(place, _)| place).collect()
    }

    /// Places of the three components of a term of one gyro.
    pub fn of_term(&self, slot: Slot, term: Term) -> Option<[usize; 3]> {
        let place = |i| self.coefficients.iter().position(|c| c.slot == Some(slot) && c.of == Of::Term(term, i));
        Some([place(0)?, place(1)?, place(2)?])
    }

    /// D_I, D_S, D_O of a gyro at the reference temperature, with coefficients `values` and their covariance.
    pub fn separation(&self, slot: Slot, values: &DVector<f64>, covariance: &DMatrix<f64>) -> Option<Separation> {
        let gyro = self.gyro(slot)?;
        let g_places = self.of_term(slot, Term::GLinear)?;
        let e_places = if gyro.e_held { None } else { Some(self.of_term(slot, Term::Scale)?) };
        let vector = |places: [usize; 3]| Vector3::from(places.map(|place| values[place]));
        let e = e_places.map_or(gyro.e, vector);
        let of_eg = covariance_at(covariance, e_places, Some(g_places));
        separate(&self.geometry, slot, &e, &vector(g_places), Some(&of_eg)).ok()
    }

    /// Axes of a gyro that effects are resolved on.
    ///
    /// # Errors
    /// [`Refusal::NoAxes`], where the geometry names none.
    pub(super) fn axes(&self, gyro: &ModelGyro) -> Result<GyroAxes, Refusal> {
        let triad = self.geometry.triad(gyro.slot).ok_or(Refusal::NoAxes(gyro.slot.name()))?;
        let is_bias = |c: &&ModelCoefficient| c.slot == Some(gyro.slot) && c.of == Of::Term(Term::Bias, 0);
        let bias = self.coefficients.iter().find(is_bias).map_or(0.0, |c| c.value / gyro.e.norm());
        Ok(GyroAxes { bias, ..GyroAxes::carried(gyro.slot, triad.mat_gyro_body(), gyro.e, gyro.g) })
    }
}
