//! The `[stations]` section: what stations know of their own tables.

use serde::Deserialize;

use super::ConfigError;
use crate::core::campaign::{Campaign, StationUncertainty};
use crate::core::name::normal_form;
use crate::wire::campaign::StationUncertaintyBody;

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stations {
    pub uncertainty: Vec<StatedUncertainty>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatedUncertainty {
    pub station: Option<String>,
    pub levelling_arcsec: Option<f64>,
    pub azimuth_arcsec: Option<f64>,
    pub fixture_arcsec: Option<f64>,
}

impl StatedUncertainty {
    fn sizes(&self) -> StationUncertaintyBody {
        let Self { levelling_arcsec, azimuth_arcsec, fixture_arcsec, .. } = *self;
        StationUncertaintyBody { levelling_arcsec, azimuth_arcsec, fixture_arcsec }
    }
}

impl Stations {
    /// The campaign with what it leaves unsaid of its station.
    pub fn complete(&self, mut campaign: Campaign) -> Campaign {
        let station = normal_form(campaign.station.as_str());
        let matching =
            |stated: &&StatedUncertainty| stated.station.as_deref().is_none_or(|name| normal_form(name) == station);
        let stated = self.uncertainty.iter().rev().filter(matching).filter_map(|stated| stated.sizes().to_core().ok());
        campaign.station_uncertainty = stated.fold(campaign.station_uncertainty, StationUncertainty::or);
        campaign
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        for (i, stated) in self.uncertainty.iter().enumerate() {
            if let Err(faults) = stated.sizes().to_core() {
                let fault = &faults.0[0];
                let member = fault.pointer.rsplit('/').next().unwrap_or_default();
                let key = format!("stations.uncertainty[{i}].{member}");
                return Err(ConfigError::of(key, fault.message.clone()));
            }
        }
        Ok(())
    }
}
