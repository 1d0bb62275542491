//! `/v1/gyros/{serial}/baseline`: from here on a gyro is compared with itself anew.

use super::remark::{self, SentRemark};
use crate::core::gyro_event::GyroEvent;
use crate::core::judge::{Event, FixedLevels, Measured};
use crate::core::message::text;
use crate::http::prelude::*;

/// Why and from when on a new baseline counts.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
struct BaselineBody {
    /// What was done to the gyro, in words.
    #[schema(min_length = 1, max_length = 4096)]
    reason: String,
    /// From when on, a day (UTC) or an RFC 3339 time; now, where it is left out.
    at: Option<String>,
    author: Option<String>,
    /// The levels from then on, from an acceptance file, say; what is left out is the median of the first three
    /// records.
    fixed: Option<FixedBody>,
}

/// Levels that are stated instead of measured, deg/(h*g0), and their standard deviations where they are known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(min_properties = 1)]
pub struct FixedBody {
    #[serde(rename = "D_I", default, skip_serializing_if = "Option::is_none")]
    d_i: Option<f64>,
    #[serde(rename = "D_I_sd", default, skip_serializing_if = "Option::is_none")]
    d_i_sd: Option<f64>,
    #[serde(rename = "D_S", default, skip_serializing_if = "Option::is_none")]
    d_s: Option<f64>,
    #[serde(rename = "D_S_sd", default, skip_serializing_if = "Option::is_none")]
    d_s_sd: Option<f64>,
}

impl FixedBody {
    /// None where nothing is fixed.
    pub fn of(fixed: &FixedLevels) -> Option<Self> {
        let [d_i, d_s] = fixed;
        let (value, sd) = (|m: &Measured| m.value, |m: &Measured| m.sd);
        fixed.iter().any(Option::is_some).then(|| Self {
            d_i: d_i.as_ref().map(value),
            d_i_sd: d_i.as_ref().and_then(sd),
            d_s: d_s.as_ref().map(value),
            d_s_sd: d_s.as_ref().and_then(sd),
        })
    }

    fn checked(self, most: f64, faults: &mut Faults) -> FixedLevels {
        if self.d_i.is_none() && self.d_s.is_none() {
            faults.push("/fixed", message!("nothing_fixed"));
        }
        [("D_I", self.d_i, self.d_i_sd), ("D_S", self.d_s, self.d_s_sd)].map(|(name, value, sd)| {
            if let Some(value) = value.filter(|value| value.is_nan() || value.abs() > most) {
                faults
                    .push(format!("/fixed/{name}"), message!("baseline_range", most = text(most), value = text(value)));
            }
            if value.is_none() && sd.is_some() {
                faults.push(format!("/fixed/{name}_sd"), message!("goes_with", member = text(name)));
            }
            let sd = text::deviation(&format!("/fixed/{name}_sd"), sd, faults);
            value.map(|value| Measured { value, sd })
        })
    }
}

/// A baseline mark as it is stored.
#[derive(Serialize, ToSchema)]
pub struct BaselineAnswer {
    id: String,
    serial: String,
    at: String,
    reason: String,
    #[schema(required)]
    author: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fixed: Option<FixedBody>,
}

/// Starts a new baseline (after a repair or re-installation). What it changes is judged again.
#[utoipa::path(post, path = "/v1/gyros/{serial}/baseline", tag = "gyros", request_body = BaselineBody,
    responses(
        (status = 201, description = "the baseline is set", body = BaselineAnswer),
        (status = 200, description = "was set before, in the same words", body = BaselineAnswer),
        (status = 409, description = "another baseline begins at that very time, for another reason or at other levels")))]
pub async fn post_baseline(
    app: App,
    Path(serial): Path<String>,
    body: Document,
) -> Answer<(StatusCode, Json<BaselineAnswer>)> {
    let (status, id, event) = remark::post(&app, &serial, &body, read, message!("baseline_there")).await?;
    let GyroEvent { at, fixed, reason, author, .. } = event;
    let (id, at, fixed) = (id.to_string(), time::format(at), FixedBody::of(&fixed));
    Ok((status, Json(BaselineAnswer { id, serial, at, reason, author, fixed })))
}

fn read(app: &App, bytes: &[u8]) -> Result<GyroEvent, Faults> {
    let BaselineBody { reason, at, author, fixed } = json::parse(bytes)?;
    let mut faults = Faults::default();
    let (reason, at, author) = SentRemark { reason, at, author }.read(app, message!("baseline_reason"), &mut faults);
    let most = app.config.plausibility.max_drift_deg_per_h_g0;
    let fixed = fixed.map_or([None; 2], |fixed| fixed.checked(most, &mut faults));
    faults.or(GyroEvent { at, event: Event::Baseline, until: None, test: None, fixed, reason, author })
}
