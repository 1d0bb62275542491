//! A campaign as it is written.

use super::{CampaignBody, CampaignGyroBody, DwellBody, SiteBody, StationUncertaintyBody};
use crate::core::campaign::{Campaign, CampaignGyro, Dwell, TestKind};
use crate::core::units::degrees;
use crate::wire::geometry::GeometryBody;
use crate::wire::numbers::{Numbers, tidy};
use crate::wire::time;

impl From<&Campaign> for CampaignBody {
    fn from(c: &Campaign) -> Self {
        Self {
            imu: c.imu.to_string(),
            station: c.station.to_string(),
            measured_at: time::format(c.measured_at),
            geometry: GeometryBody::of(&c.geometry),
            site: c.site.as_ref().map(|s| SiteBody {
                latitude_deg: tidy(degrees(s.latitude)),
                gravity_g0: s.gravity_g0,
                magnetic_field_nav: s.magnetic_field_nav.as_ref().map(Numbers::from),
            }),
            station_uncertainty: StationUncertaintyBody::of(&c.station_uncertainty),
            gyros: c.gyros.iter().map(CampaignGyroBody::from).collect(),
            dwells: c.dwells.iter().map(DwellBody::from).collect(),
            rates: None,
            test: (c.test != TestKind::Imu).then(|| c.test.name().to_owned()),
            model: c.model.map(|terms| terms.iter().map(|t| t.name().to_owned()).collect()),
            temperature_c: c.temperature_c,
            operator: c.operator.clone(),
            note: c.note.clone(),
        }
    }
}

impl From<&CampaignGyro> for CampaignGyroBody {
    fn from(g: &CampaignGyro) -> Self {
        Self {
            slot: Some(g.slot.name().to_owned()),
            serial: g.serial.to_string(),
            known_e_pulse_per_arcsec: g.known_e.as_ref().map(Numbers::from),
        }
    }
}

impl From<&Dwell> for DwellBody {
    fn from(d: &Dwell) -> Self {
        Self {
            phase: d.phase.name().to_owned(),
            start_s: d.start_s,
            duration_s: d.duration_s,
            attitude: d.attitude.map(|c| c.to_attitude().as_slice().into()),
            specific_force_g0: (&d.specific_force_g0).into(),
            rate_arcsec_s: (&d.rate_arcsec_s).into(),
            temperature_c: d.temperature_c,
            output_pulse_s: d.output_pulse_s.as_slice().into(),
            output_sem_pulse_s: d.output_sem_pulse_s.as_deref().map(Numbers::from),
        }
    }
}
