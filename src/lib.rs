//! gyrowatch separates the acceleration-sensitive drift coefficients D_I and D_S of liquid-floated gyros from
//! calibrations of the whole inertial measurement unit, keeps their history, judges it, and diagnoses where a
//! campaign and the error model part.
//!
//! # Conventions, stated once
//!
//! * **Frames.** `nav` is East-North-Up; `body` is the IMU's X_b, Y_b, Z_b; `gyro` is input I, spin (motor) S,
//!   output O = I x S. `v_body` is a vector in body axes; `mat_gyro_body` turns body into gyro coordinates.
//! * **Letters.** `a` specific force in g0 (at rest on the table +g points up), `w` inertial rate in arcsec/s,
//!   E pulse/arcsec, G pulse/(s g0), P pulse/(s g0^2), D0 pulse/s; D_F, D_I, D_S, D_O in deg/h and deg/(h g0).
//! * **Units.** Angles are radians inside, degrees only where a person reads or writes. 1 arcsec/s = 1 deg/h, so
//!   rates need no factor and G/E is in deg/(h g0). [`core::units`] is the only place that converts.
//! * **Signs.** Drift adds to the output as it is counted: output = E.(w + drift along I), eq. (6) of the paper.
//! * **Time.** Instants are microseconds UTC ([`core::time::UtcMicros`]); within a campaign, seconds.
//!
//! # In reading order
//!
//! The mathematics, which is plain functions of their arguments:
//!
//! 1. [`core::units`], [`core::frames`], [`core::mounting`]: conversions, rotations with their direction in the type,
//!    where axes point (Tables 1 and 2 of the paper).
//! 2. [`core::record`], [`core::campaign`], [`core::model`]: what comes in, and what model (6) predicts.
//! 3. [`core::calibrate::calibrate`]: dwells to E and G, with covariance, rank and null directions.
//! 4. [`core::separate::separate`]: E and G to D_I, D_S and the closure D_O, by eqs. (7) to (13) and by the rigid method.
//! 5. [`core::judge::judge`]: a history and limits to verdicts; [`core::alert_decision`]: verdicts to alerts.
//! 6. [`core::effects`], [`core::diagnose::diagnose`]: the catalogue, and which of it explains what a campaign shows.
//! 7. [`core::changes`]: why a gyro's coefficients changed over its history, the gyro or its station.
//!
//! What it is checked by: [`simulate`] (a station from physics), [`experiment`] (the paper's own comparison) and
//! [`blindcheck`] (how often a hidden cause is found).
//!
//! The service around it: [`wire`] (documents), [`words`] (English and Chinese), [`store`], [`pipeline`], [`alert`],
//! [`http`], [`pages`], [`cli`]. `docs/architecture.md` says which may use which. Without the feature `server` there is
//! only what a station's agent needs.

// What ships never unwraps in silence: `expect` says why it cannot fail.
#![warn(clippy::unwrap_used)]
#![cfg_attr(not(feature = "server"), allow(dead_code, reason = "the agent needs a part of what the service does"))]

#[cfg(feature = "server")]
pub mod alert;
#[cfg(feature = "server")]
pub mod blindcheck;
pub mod cli;
#[cfg(feature = "server")]
pub mod config;
#[cfg(feature = "server")]
mod cookies;
pub mod core;
#[cfg(feature = "server")]
pub mod experiment;
#[cfg(feature = "server")]
pub mod http;
pub mod logs;
#[cfg(feature = "server")]
pub mod pages;
#[cfg(feature = "server")]
pub mod pipeline;
#[cfg(feature = "server")]
pub mod routes;
pub mod simulate;
#[cfg(feature = "server")]
pub mod store;
pub mod system;
#[cfg(feature = "server")]
pub mod telemetry;
pub mod wire;
pub mod words;
