//! Stage 2: every hypothesis scored against the residuals, and those named that noise alone does not explain.

pub(super) mod bayes_factor;
pub(super) mod choice;
pub(super) mod components;
pub(super) mod hypotheses;
pub(super) mod noise_models;
pub(super) mod noise_rounds;
pub(super) mod null_distribution;
pub(super) mod null_tables;
pub(super) mod odds;
pub(super) mod projections;
pub(super) mod refined_shape;
pub(super) mod shared_coefficients;
pub(super) mod shared_noise;
pub(super) mod stepwise;
mod temperature_odds;
