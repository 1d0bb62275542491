//! Linear algebra, least squares and probabilities that the mathematics shares.

pub(super) mod basis;
pub mod between;
pub(crate) mod bisection;
pub mod least_squares;
pub(super) mod log_sum;
pub(crate) mod median;
pub(crate) mod normal;
pub(crate) mod normal_equations;
pub(crate) mod pivoted_cholesky;
pub mod tails;
