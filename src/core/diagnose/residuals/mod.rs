//! Stage 1: the fit that a diagnosis starts from, its residuals made white, and the noise that they are held against.

pub(super) mod augmented_fit;
pub(super) mod noise;
pub(super) mod noise_floor;
pub(super) mod noise_growth;
pub(super) mod pooled_noise;
pub(super) mod whitened;
