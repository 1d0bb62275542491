//! `/find`: what a name or an identifier is of. Where that is one thing, its page; else the fleet, searched.

use super::form::see_other;
use super::prelude::*;
use crate::pipeline::FleetFilter;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct FindQuery {
    q: String,
}

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Query(asked): Query<FindQuery>,
) -> Result<Response, Problem> {
    let place = place(pages, asked.q.trim()).await?;
    Ok(see_other(&format!("{}{place}", viewer.base_path)))
}

/// The address of what is meant.
async fn place(pages: &Pages, sought: &str) -> Result<String, Problem> {
    let of_fleet = || format!("/fleet?q={}", encoded(sought));
    if let Some(named) = named(pages, sought) {
        return Ok(named);
    }
    if let Ok(id) = sought.parse::<Id>() {
        if pages.pipeline.queries.records.sent(id).await?.is_some() {
            return Ok(format!("/records/{id}"));
        }
        if pages.pipeline.alerts.get(id).await?.is_some() {
            return Ok(format!("/alerts/{id}"));
        }
    }
    if sought.is_empty() {
        return Ok("/fleet".to_owned());
    }
    let filter = FleetFilter { text: sought, ..FleetFilter::default() };
    let found = pages.pipeline.queries.fleet.page(&filter, 0, 1).await?;
    Ok(match &found.gyros[..] {
        [one] if found.found == 1 => format!("/gyros/{}", encoded(&one.serial)),
        _ => of_fleet(),
    })
}

/// A gyro, an IMU or a station of this very name.
fn named(pages: &Pages, name: &str) -> Option<String> {
    let names = pages.pipeline.queries.names();
    let path = if names.gyro_number(name).is_some() {
        "gyros"
    } else if names.imu_number(name).is_some() {
        "imus"
    } else if names.station_number(name).is_some() {
        "stations"
    } else {
        return None;
    };
    Some(format!("/{path}/{}", encoded(name)))
}
