//! A campaign as it is written.

use super::{CampaignBody, CampaignGyroBody, DwellBody, SiteBody, StationUncertaintyBody};
use crate::core::campaign::{Campaign, CampaignGyro, Dwell, Site, TestKind};
use crate::core::units::degrees;
use crate::wire::body::{ToBody, bodies};
use crate::wire::numbers::tidy;

bodies! {
    CampaignBody of Campaign: imu, station, measured_at, geometry, site,
        station_uncertainty: |c| StationUncertaintyBody::of(&c.station_uncertainty), gyros,
        dwells: |c| c.dwells.iter().map(|dwell| as_sent(c, dwell)).collect(), rates: |_| None,
        test: |c| (c.test != TestKind::Imu).then(|| c.test.to_body()),
        model: |c| c.model.map(|terms| terms.iter().map(|term| term.to_body()).collect()),
        temperature_c, operator, note;
    SiteBody of Site: latitude_deg: |site| tidy(degrees(site.latitude)), gravity_g0, magnetic_field_nav;
    CampaignGyroBody of CampaignGyro: slot: |gyro| Some(gyro.slot.to_body()), serial,
        known_e_pulse_per_arcsec = known_e;
    DwellBody of Dwell: phase, start_s, duration_s,
        attitude: |dwell| dwell.attitude.map(|attitude| attitude.to_attitude().as_slice().into()), specific_force_g0,
        rate_arcsec_s, temperature_c, output_pulse_s, output_sem_pulse_s;
}

fn as_sent(campaign: &Campaign, dwell: &Dwell) -> DwellBody {
    Dwell { rate_arcsec_s: campaign.sent_rate(dwell), ..dwell.clone() }.to_body()
}
