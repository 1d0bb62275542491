//! Which columns of eq. (5) a bench test's positions show, and the coefficients that come of them.

use nalgebra::Vector3;

use super::design::mean_if_constant;

/// How the squares a_I^2, a_S^2 stand in the design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Squares {
    Both,
    /// Their difference, in the gauge D_II + D_SS = 0.
    Difference,
    Left,
}

impl Squares {
    /// Which squares the dwells' specific forces (g0, along I, S, O) tell apart: both, or the difference alone where
    /// a_I^2 + a_S^2 is constant within 2 %.
    pub fn seen_in(forces: &[Vector3<f64>]) -> Self {
        let squared = forces.iter().map(|a| a.x * a.x + a.y * a.y);
        if mean_if_constant(squared).is_some() { Self::Difference } else { Self::Both }
    }

    fn count(self) -> usize {
        match self {
            Self::Both => 2,
            Self::Difference => 1,
            Self::Left => 0,
        }
    }

    fn columns(self, a: &Vector3<f64>) -> Vec<f64> {
        let (i, s) = (a.x * a.x, a.y * a.y);
        match self {
            Self::Both => vec![i, s],
            Self::Difference => vec![i - s],
            Self::Left => vec![],
        }
    }
}

/// Which columns follow 1, a_I and a_S.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BenchForm {
    pub squares: Squares,
    /// a_O: eq. (5) has no such term, but a gyro clocked about I on its fixture has, and what is left out leaks into
    /// E and D_F.
    pub output: bool,
}

impl BenchForm {
    /// Columns of one dwell beyond 1, a_I and a_S; `a` is the specific force along I, S and O, g0.
    pub fn columns(self, a: &Vector3<f64>) -> Vec<f64> {
        self.squares.columns(a).into_iter().chain(self.output.then_some(a.z)).collect()
    }

    /// Name, unit, column (after the rates) and sign of every coefficient.
    pub fn names(self) -> impl Iterator<Item = (&'static str, &'static str, usize, f64)> {
        const LINEAR: &str = "deg/(h*g0)";
        const SQUARE: &str = "deg/(h*g0^2)";
        let squares: &[_] = match self.squares {
            Squares::Both => &[("D_II", SQUARE, 3, 1.0), ("D_SS", SQUARE, 4, 1.0)],
            Squares::Difference => &[("D_II", SQUARE, 3, 1.0), ("D_SS", SQUARE, 3, -1.0)],
            Squares::Left => &[],
        };
        [("D_F", "deg/h", 0, 1.0), ("D_I", LINEAR, 1, 1.0), ("D_S", LINEAR, 2, 1.0)]
            .into_iter()
            .chain(squares.iter().copied())
            .chain(self.output.then_some(("D_O", LINEAR, 3 + self.squares.count(), 1.0)))
    }
}
