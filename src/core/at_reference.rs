//! A finished calibration at the temperature at which its IMU's model states D_I and D_S: what
//! [`crate::core::calibrate`] does for campaigns, where there are no dwells.

use nalgebra::{Matrix3, Vector3};

use super::augmented::AugmentedModel;
use super::campaign::{Phase, unknown_kelvin};
use super::effects::{GyroAxes, Setting};
use super::record::{GyroParameters, Record};
use super::separate::{CovarianceEg, diagonal_covariance};

/// A gyro's parameters at the model's temperature, and the covariance of its E and G.
#[derive(Debug, Clone, PartialEq)]
pub struct AtReference {
    pub gyro: GyroParameters,
    pub covariance: Option<CovarianceEg>,
}

/// None where the model knows no effect of temperature of the very gyro that moves G.
///
/// An effect's drift at the record's temperature goes with specific force as G does. So G at the reference is
/// G - |E| sum_m k_m u_m, with u_m half the difference of its regressor at +1 and -1 g0 on each axis, and the variances
/// of the k_m join G's. Of a record that states no temperature G stays as it is, and its covariance holds what any
/// temperature would do.
pub fn at_reference(
    model: &AugmentedModel,
    record: &Record,
    gyro: &GyroParameters,
    covariance: Option<&CovarianceEg>,
) -> Option<AtReference> {
    let reference_c = model.restates_at()?;
    let known = model.known(&record.imu, &[(gyro.slot, &gyro.serial)]);
    let triad = record.geometry.triad(gyro.slot)?;
    let kelvin = record.temperature_c.map(|celsius| celsius - reference_c);
    let setting = at_rest(GyroAxes::carried(gyro.slot, triad.mat_gyro_body(), gyro.e, gyro.g), kelvin.unwrap_or(1.0));
    let (mut moved, mut spread) = (Vector3::zeros(), Matrix3::zeros());
    for adopted in model.effects.iter().map(|known| &known.adopted) {
        let entry = adopted.effect.entry();
        if !entry.of_temperature || entry.of_order || (entry.missing)(&setting).is_some() {
            continue;
        }
        let columns = (entry.columns)(&setting, 0, adopted.shape);
        for (column, coefficient) in columns.iter().zip(entry.coefficients(adopted.shape)) {
            let one = known.iter().find(|one| one.effect == adopted.effect && one.name == coefficient.name);
            let Some(one) = one else { continue };
            let by_axis = Vector3::from_fn(|i, _| gyro.e.norm() * (column[2 * i] - column[2 * i + 1]) / 2.0);
            let sd = match kelvin {
                Some(_) => one.sd,
                None => one.value.hypot(one.sd) * unknown_kelvin(reference_c),
            };
            moved += by_axis * kelvin.map_or(0.0, |_| one.value);
            spread += by_axis * by_axis.transpose() * (sd * sd);
        }
    }
    if spread == Matrix3::zeros() && moved == Vector3::zeros() {
        return None;
    }
    let wider = |stated: Vector3<f64>| stated.zip_map(&spread.diagonal(), |sd, variance| sd.hypot(variance.sqrt()));
    // Without standard deviations a record is taken at its word, but not at any temperature.
    let at_its_word = |sd: Option<Vector3<f64>>| sd.or_else(|| kelvin.is_none().then(Vector3::zeros));
    let (e_sd, g_sd) = (at_its_word(gyro.e_sd), at_its_word(gyro.g_sd));
    let covariance = covariance.copied().or_else(|| diagonal_covariance(e_sd.as_ref(), g_sd.as_ref()));
    Some(AtReference {
        gyro: GyroParameters { g: gyro.g - moved, g_sd: g_sd.map(wider), ..gyro.clone() },
        covariance: covariance.map(|mut covariance| {
            let mut of_g = covariance.fixed_view_mut::<3, 3>(3, 3);
            of_g += spread;
            covariance
        }),
    })
}

/// +1 and -1 g0 along each body axis, at a temperature `kelvin` above the reference.
fn at_rest(axes: GyroAxes, kelvin: f64) -> Setting {
    let force: Vec<Vector3<f64>> = (0..3).flat_map(|i| [1.0, -1.0].map(|g| Vector3::ith(i, g))).collect();
    let n = force.len();
    Setting {
        force,
        rate: vec![Vector3::zeros(); n],
        phase: vec![Phase::Static; n],
        time: (0..n).map(|k| 100.0 * k as f64).collect(),
        duration: vec![100.0; n],
        temperature: Some(vec![kelvin; n]),
        nav_to_body: None,
        earth_nav: Vector3::zeros(),
        gravity: 1.0,
        field_nav: None,
        gyros: vec![axes],
    }
}
