//! What the service answers to a record, and the command line prints: separations and verdicts.

use std::borrow::Cow;

use super::note::NoteBody;
use super::reason::Reason;
use crate::core::calibrate::GyroCalibration;
use crate::core::calibrate::uncertainty::UncertaintyBudget;
use crate::core::judge::{Measured, Verdict};
use crate::core::mounting::Geometry;
use crate::core::separate::{self, JudgedMethod, Separation};
use crate::wire::prelude::*;

/// The answer to one record or campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RecordAnswer {
    /// Identifier of the stored item; none where nothing is stored (the command line's `separate`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    pub separations: Vec<SeparationBody>,
    /// What was noticed beside what is known of the IMU and its gyros.
    #[serde(default)]
    pub notes: Vec<NoteBody>,
    pub verdicts: Vec<VerdictBody>,
}

/// A figure in deg/(h*g0), and its standard deviation where the station's are known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FigureBody {
    pub value: f64,
    #[schema(required)]
    pub sd: Option<f64>,
}

/// What the standard deviation of a figure is made of, in its unit: `combined` is the root of the sum of the squares of
/// `statistical`, `station` and `discrepancy`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct UncertaintyBody {
    /// Of the noise.
    pub statistical: f64,
    /// Of levelling, azimuth and fixture. None where the station states none of them, or the campaign cannot tell.
    pub station: Option<f64>,
    /// Of what the model leaves out: what the Birge ratio adds where residuals exceed the noise. None where nothing
    /// tests that.
    pub discrepancy: Option<f64>,
    pub combined: f64,
    /// Parts of `station`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levelling: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixture: Option<f64>,
}

/// Of what a campaign says of one gyro.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct UncertaintiesBody {
    pub d_i: UncertaintyBody,
    pub d_s: UncertaintyBody,
    pub d_o: UncertaintyBody,
    pub scale_factor: UncertaintyBody,
}

/// One gyro of a record, separated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SeparationBody {
    pub slot: Slot,
    pub serial: String,
    /// The method of `d_i` and `d_s`.
    pub method: JudgedMethod,
    pub d_i: FigureBody,
    pub d_s: FigureBody,
    /// The closure of the rigid method: zero but for the clocking of S about I, or a true output-axis term.
    pub d_o: FigureBody,
    /// atan(D_O/D_S), from -90 to 90 degrees: how far S is turned about I if D_O is zero in truth.
    pub clocking_deg: FigureBody,
    /// |E|, pulse/arcsec.
    pub scale_factor: FigureBody,
    /// Angles of the input axis to X_b, Y_b, Z_b, eq. (7), degrees.
    pub alpha_deg: Triple,
    /// Angle from the nominal to the measured input axis, arc minutes.
    pub misalignment_arcmin: f64,
    /// The rigid method's figures, where `method` is another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rigid: Option<RigidBody>,
    /// None for a geometry that equations (8) to (13) do not cover.
    #[schema(required)]
    pub published: Option<PublishedBody>,
    /// Equations (8) to (13) letter by letter, misprints included: for comparison only.
    #[schema(required)]
    pub as_printed: Option<PublishedBody>,
    /// Where the model in force states the coefficients at a temperature of its own: the same at the mean temperature
    /// of this campaign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub as_measured: Option<AsMeasuredBody>,
    /// Of a campaign: what the standard deviations are made of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintiesBody>,
}

/// D_I and D_S at the temperature at which they were measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AsMeasuredBody {
    pub temperature_c: f64,
    pub d_i: FigureBody,
    pub d_s: FigureBody,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RigidBody {
    pub d_i: f64,
    pub d_s: f64,
    pub d_o: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PublishedBody {
    /// Number of the equation that resolved the gyro, `8` to `13`.
    pub branch: Cow<'static, str>,
    pub d_i: f64,
    pub d_s: f64,
    #[schema(required)]
    pub d_i_sd: Option<f64>,
    #[schema(required)]
    pub d_s_sd: Option<f64>,
    /// Root mean square of the residuals of the equation's three rows.
    pub closure_rms: f64,
}

/// One gyro judged by one rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct VerdictBody {
    pub serial: String,
    pub coefficient: Cow<'static, str>,
    pub rule: Cow<'static, str>,
    /// `within`, `exceeded`, or `indeterminate`.
    pub state: Cow<'static, str>,
    /// What that comes to: `in_tolerance`, `not_enough_data`, `too_uncertain`, `borderline`, `overdue`, `drifting`,
    /// `unconfirmed`, `out_of_tolerance` or `confirmed`.
    pub status: Cow<'static, str>,
    /// The magnitude that is compared with the limit; none where there are too few points.
    #[schema(required)]
    pub value: Option<f64>,
    pub limit: f64,
    /// The key of the configuration that sets the limit; none where the verdict was decided with other limits than
    /// today's.
    #[schema(required)]
    pub limit_from: Option<String>,
    #[schema(required)]
    pub sd: Option<f64>,
    /// Probability that the true value exceeds the limit, where `sd` is known.
    #[schema(required)]
    pub probability: Option<f64>,
    /// Whether a second campaign says the same.
    pub confirmed: bool,
    #[serde(flatten)]
    pub reason: Reason,
}

impl SeparationBody {
    /// With the published method asked for and not defined, the figures are the rigid ones, and `method` says so.
    pub fn of(serial: &str, separation: &Separation, asked: JudgedMethod) -> Self {
        let rigid = &separation.rigid;
        let [i_sd, s_sd, o_sd] = split(rigid.sd());
        let published = separation.published.as_ref().ok();
        let method = if published.is_some() { asked } else { JudgedMethod::Rigid };
        let ([d_i, d_s], rigid_beside) = match (method, published) {
            (JudgedMethod::Published, Some(p)) => {
                let [i_sd, s_sd] = split(p.sd());
                let beside = RigidBody { d_i: rigid.d_i, d_s: rigid.d_s, d_o: rigid.d_o };
                ([figure(p.d_i, i_sd), figure(p.d_s, s_sd)], Some(beside))
            }
            _ => ([figure(rigid.d_i, i_sd), figure(rigid.d_s, s_sd)], None),
        };
        Self {
            slot: separation.slot,
            serial: serial.to_owned(),
            method,
            d_i,
            d_s,
            d_o: figure(rigid.d_o, o_sd),
            clocking_deg: figure(rigid.clocking().to_degrees(), rigid.clocking_sd().map(f64::to_degrees)),
            scale_factor: figure(separation.scale_factor, separation.scale_factor_sd),
            alpha_deg: Triple(separation.alpha.map(f64::to_degrees)),
            misalignment_arcmin: separation.misalignment.to_degrees() * 60.0,
            rigid: rigid_beside,
            published: published.map(PublishedBody::from),
            as_printed: separation.as_printed.as_ref().ok().map(PublishedBody::from),
            as_measured: None,
            uncertainty: None,
        }
    }

    /// With what the standard deviations are made of.
    pub fn with_uncertainty(mut self, fitted: &GyroCalibration, geometry: &Geometry) -> Self {
        let budgets = fitted.budgets(geometry, self.method == JudgedMethod::Published);
        self.uncertainty = budgets.map(|budgets| {
            let [d_i, d_s, d_o, scale_factor] = budgets.map(|budget| UncertaintyBody::from(&budget));
            UncertaintiesBody { d_i, d_s, d_o, scale_factor }
        });
        self
    }

    /// With the same gyro at the temperature at which it was measured.
    pub fn measured_at(self, temperature_c: f64, measured: &Separation) -> Self {
        let Self { d_i, d_s, .. } = Self::of(&self.serial, measured, self.method);
        Self { as_measured: Some(AsMeasuredBody { temperature_c, d_i, d_s }), ..self }
    }
}

bodies! {
    FigureBody of Measured: value, sd;
    UncertaintyBody of UncertaintyBudget: statistical, station, discrepancy, combined,
        levelling: |budget| budget.of_station[0], azimuth: |budget| budget.of_station[1],
        fixture: |budget| budget.of_station[2];
    PublishedBody of separate::Published: branch: |published| published.branch.name().into(), d_i, d_s,
        d_i_sd: |published| split(published.sd())[0], d_s_sd: |published| split(published.sd())[1], closure_rms;
}

impl VerdictBody {
    /// A verdict as answers write it, in deg/(h g0) or the rule's own unit.
    pub fn of(serial: &str, verdict: &Verdict) -> Self {
        Self {
            serial: serial.to_owned(),
            coefficient: verdict.coefficient.name().into(),
            rule: verdict.rule.name().into(),
            state: verdict.state.name().into(),
            status: verdict.status().name().into(),
            value: verdict.value,
            limit: verdict.limit,
            limit_from: Some(verdict.limit_from.to_string()),
            sd: verdict.sd,
            probability: verdict.probability,
            confirmed: verdict.confirmed,
            reason: Reason::of(verdict),
        }
    }
}

fn figure(value: f64, sd: Option<f64>) -> FigureBody {
    FigureBody { value, sd }
}

/// Standard deviations one by one, all unknown where the station gave none.
fn split<const N: usize>(sd: Option<[f64; N]>) -> [Option<f64>; N] {
    sd.map_or([None; N], |sd| sd.map(Some))
}
