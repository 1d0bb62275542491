//! Frames and rotations named by direction.
//!
//! A vector is always a vector *in* a frame, and a rotation always turns one frame's coordinates into
//! another's: `Rotation<Nav, Body>` takes `v_nav` to `v_body`. A composition that does not fit does not compile.
//!
//! ```
//! use gyrowatch::core::frames::{Body, Nav, Rotation, Vector};
//! use nalgebra::Vector3;
//!
//! // The IMU upside down, Y_b still to the north: at rest the specific force, 1 g0 upwards, is along -Z_b.
//! let attitude = Rotation::<Nav, Body>::from_attitude([0.0, 0.0, 1.0, 0.0]);
//! let force = attitude * Vector::<Nav>::new(Vector3::z());
//! assert!((force.0.z + 1.0).abs() < 1e-15);
//! ```
//!
//! ```compile_fail
//! use gyrowatch::core::frames::{Body, Nav, Rotation, Vector};
//! use nalgebra::Vector3;
//!
//! let attitude = Rotation::<Nav, Body>::from_attitude([0.0, 0.0, 1.0, 0.0]);
//! let force = attitude * Vector::<Body>::new(Vector3::z()); // it turns coordinates in Nav
//! ```

use std::marker::PhantomData;
use std::ops::Mul;

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// IMU axes X_b, Y_b, Z_b of the paper's figure 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Body;
/// Local level: East, North, Up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nav;

/// Three coordinates in frame `F`.
#[derive(Debug, Clone, Copy)]
pub struct Vector<F>(pub Vector3<f64>, PhantomData<F>);

impl<F> Vector<F> {
    /// States that `v` holds coordinates in `F`.
    pub fn new(v: Vector3<f64>) -> Self {
        Self(v, PhantomData)
    }
}

/// Turns coordinates in `From` into coordinates in `To` (a passive rotation, C_to_from).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation<From, To>(Rotation3<f64>, PhantomData<(From, To)>);

impl<A, B> Rotation<A, B> {
    /// States that `c` turns A's coordinates into B's. The caller vouches for it; nothing can check it here.
    pub fn stated_as(c: Rotation3<f64>) -> Self {
        Self(c, PhantomData)
    }

    /// C^T: from B's coordinates back to A's.
    pub fn inverse(&self) -> Rotation<B, A> {
        Rotation(self.0.inverse(), PhantomData)
    }

    /// C, 3 x 3, with v_b = C v_a.
    pub fn matrix(&self) -> &Matrix3<f64> {
        self.0.matrix()
    }
}

impl Rotation<Nav, Body> {
    /// The campaign format's attitude: unit quaternion [w, x, y, z] with v_body = C(q) v_nav.
    ///
    /// C(q) is the usual matrix of the quaternion: C(q) v = vec(q v q*), and it is applied to v_nav directly.
    /// (Checked on the example campaigns: q = [0, 0, 1, 0] gives f_body = [0, 0, -g], w_body = [0, N, -U].)
    /// The quaternion is normalised; that it is nearly unit has been validated before.
    pub fn from_attitude(q: [f64; 4]) -> Self {
        let q = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
        Self::stated_as(q.to_rotation_matrix())
    }

    /// The unit quaternion [w, x, y, z] of [`Rotation::from_attitude`], with w not negative.
    pub fn to_attitude(&self) -> [f64; 4] {
        let q = UnitQuaternion::from_rotation_matrix(&self.0);
        let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
        [q.w, q.i, q.j, q.k].map(|c| sign * c)
    }

    /// The vertical in body axes: the direction of the specific force at rest.
    pub fn up(&self) -> Vector3<f64> {
        (*self * Vector::new(Vector3::z())).0
    }
}

/// Angle between two directions, radians; accurate near 0 and 180 deg, where arccos is not.
pub(crate) fn angle_between(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

impl<A, B> Mul<Vector<A>> for Rotation<A, B> {
    type Output = Vector<B>;
    fn mul(self, v: Vector<A>) -> Vector<B> {
        Vector::new(self.0 * v.0)
    }
}

/// (B -> C) after (A -> B) is A -> C.
impl<A, B, C> Mul<Rotation<A, B>> for Rotation<B, C> {
    type Output = Rotation<A, C>;
    fn mul(self, inner: Rotation<A, B>) -> Rotation<A, C> {
        Rotation(self.0 * inner.0, PhantomData)
    }
}
