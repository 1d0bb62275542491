//! Where a gyro's axes point nominally: the skewed triads of the paper's Tables 1-2, orthogonal ones, custom ones.

use nalgebra::{Matrix3, Vector3};

use super::fault::Faults;
use crate::core::message::{figure, text};
use crate::core::named::named;
use crate::message;

named! {
/// Position of a gyro in its IMU. The paper's G1, G2, G3.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Slot {
    #[default]
    G1 = "G1",
    G2 = "G2",
    G3 = "G3",
}
}

impl Slot {
    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Input and spin axes of one gyro as unit vectors in body axes, perpendicular to one another.
///
/// The output axis is O = I x S, the paper's order. IEEE 517 counts O the other way (O = S x I there), so
/// signs of O-axis terms differ from data sheets written to that standard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triad {
    input: Vector3<f64>,
    spin: Vector3<f64>,
}

/// Largest |I.S| accepted from a custom geometry: axes stated to four digits still pass.
const MAX_NON_ORTHOGONALITY: f64 = 1e-3;

impl Triad {
    /// From stated axes: each is normalised, S is made exactly perpendicular to I.
    /// Faults where an axis has no direction or the two are not nearly perpendicular.
    pub fn from_stated_axes(input: Vector3<f64>, spin: Vector3<f64>) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        for (name, axis) in [("/input", &input), ("/spin", &spin)] {
            let norm = axis.norm();
            if !norm.is_finite() || (norm - 1.0).abs() > 1e-3 {
                faults.push(name, message!("not_unit_vector", length = text(norm)));
            }
        }
        if faults.is_empty() && input.normalize().dot(&spin.normalize()).abs() > MAX_NON_ORTHOGONALITY {
            let angle = input.normalize().dot(&spin.normalize()).acos().to_degrees();
            faults.push("/spin", message!("not_perpendicular", angle = figure(angle, 3)));
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let input = input.normalize();
        let spin = (spin - input * input.dot(&spin)).normalize();
        Ok(Self { input, spin })
    }

    fn nominal(input: [f64; 3], spin: [f64; 3]) -> Self {
        Self { input: Vector3::from(input), spin: Vector3::from(spin) }
    }

    /// I, a unit vector in body axes.
    pub fn input(&self) -> Vector3<f64> {
        self.input
    }

    /// S, a unit vector in body axes, perpendicular to I.
    pub fn spin(&self) -> Vector3<f64> {
        self.spin
    }

    /// O = I x S.
    pub fn output(&self) -> Vector3<f64> {
        self.input.cross(&self.spin)
    }

    /// S and O, carried along by the smallest rotation that takes I to `input`, a unit vector less than 180 deg away.
    pub(crate) fn carried_to(&self, input: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let half = (self.input + input) / (1.0 + self.input.dot(input));
        [self.spin, self.output()].map(|axis| axis - half * input.dot(&axis))
    }

    /// Rows I, S, O: turns body coordinates into gyro coordinates.
    pub fn mat_gyro_body(&self) -> Matrix3<f64> {
        Matrix3::from_rows(&[self.input.transpose(), self.spin.transpose(), self.output().transpose()])
    }
}

/// How the gyros of an IMU are mounted nominally.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// Tables 1-2: input axes on a cone of half-angle 54.7356 deg (= atan sqrt 2) about X_b.
    Skewed,
    /// I along X, Y, Z of G1, G2, G3, and S along Y, Z, X.
    Orthogonal,
    /// Stated by the station, slot by slot.
    Custom([Option<Triad>; 3]),
}

impl Geometry {
    /// Whether every slot has the same axes, within what a document keeps of them.
    pub fn is_same(&self, other: &Self) -> bool {
        let alike = |a: Triad, b: Triad| (a.mat_gyro_body() - b.mat_gyro_body()).amax() < 1e-9;
        Slot::ALL.into_iter().all(|slot| match (self.triad(slot), other.triad(slot)) {
            (Some(a), Some(b)) => alike(a, b),
            (None, None) => true,
            _ => false,
        })
    }

    /// The nominal triad of a slot; none where a custom geometry leaves the slot out.
    ///
    /// ```
    /// use gyrowatch::core::mounting::{Geometry, Slot};
    ///
    /// // G1: I is 54.7356 deg from X_b (Table 1), S is 30 deg from Y_b (Table 2).
    /// let g1 = Geometry::Skewed.triad(Slot::G1).expect("the paper has every slot");
    /// assert!((g1.input().x.acos().to_degrees() - 54.7356).abs() < 1e-4);
    /// assert!((g1.spin().y.acos().to_degrees() - 30.0).abs() < 1e-9);
    /// ```
    pub fn triad(&self, slot: Slot) -> Option<Triad> {
        match self {
            Geometry::Skewed => Some(skewed(slot)),
            Geometry::Orthogonal => Some(orthogonal(slot)),
            Geometry::Custom(triads) => triads[slot.index()],
        }
    }
}

/// Table 1 (input axes) and Table 2 (spin axes) with exact values: cos theta = 1/sqrt 3, sin theta = sqrt(2/3).
fn skewed(slot: Slot) -> Triad {
    let (c, s) = ((1.0_f64 / 3.0).sqrt(), (2.0_f64 / 3.0).sqrt());
    let half_sqrt3 = 3.0_f64.sqrt() / 2.0;
    match slot {
        Slot::G1 => Triad::nominal([c, -0.5 * s, half_sqrt3 * s], [0.0, half_sqrt3, 0.5]),
        Slot::G2 => Triad::nominal([c, -0.5 * s, -half_sqrt3 * s], [0.0, half_sqrt3, -0.5]),
        Slot::G3 => Triad::nominal([c, s, 0.0], [0.0, 0.0, 1.0]),
    }
}

fn orthogonal(slot: Slot) -> Triad {
    match slot {
        Slot::G1 => Triad::nominal([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        Slot::G2 => Triad::nominal([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
        Slot::G3 => Triad::nominal([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skewed_triads_are_tables_1_and_2() {
        let table1 = [[54.7356, 114.0950, 45.0], [54.7356, 114.0950, 135.0], [54.7356, 35.2644, 90.0]];
        let table2 = [[90.0, 30.0, 60.0], [90.0, 30.0, 120.0], [90.0, 90.0, 0.0]];
        for slot in Slot::ALL {
            let triad = Geometry::Skewed.triad(slot).expect("skewed names every slot");
            for axis in 0..3 {
                let i = triad.input()[axis].acos().to_degrees();
                let s = triad.spin()[axis].clamp(-1.0, 1.0).acos().to_degrees();
                assert!((i - table1[slot.index()][axis]).abs() < 3e-4, "{slot:?} I {axis}: {i}");
                assert!((s - table2[slot.index()][axis]).abs() < 1e-9, "{slot:?} S {axis}: {s}");
            }
        }
    }

    #[test]
    fn every_nominal_triad_is_orthonormal_and_right_handed() {
        for geometry in [Geometry::Skewed, Geometry::Orthogonal] {
            for slot in Slot::ALL {
                let m = geometry.triad(slot).expect("both name every slot").mat_gyro_body();
                assert!((m * m.transpose() - Matrix3::identity()).amax() < 1e-15);
                assert!((m.determinant() - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn stated_axes_that_are_not_perpendicular_are_refused() {
        let faults = Triad::from_stated_axes(Vector3::x(), Vector3::new(0.6, 0.8, 0.0)).unwrap_err();
        assert_eq!(faults.0[0].pointer, "/spin");
        assert!(Triad::from_stated_axes(Vector3::zeros(), Vector3::y()).is_err());
        assert!(Triad::from_stated_axes(Vector3::new(f64::NAN, 0.0, 0.0), Vector3::y()).is_err());
    }
}
