//! The campaign document: raw dwells as a station writes them.

use super::geometry::GeometryBody;
use super::numbers::{Numbers, in_range, tidy};
use super::{json, text};
use crate::core::campaign::commanded::AffectedDwells;
use crate::core::campaign::{
    Campaign, CampaignGyro, CampaignLimits, Dwell, Phase, Site, StationPart, StationUncertainty, TestKind,
    check_dwells, with_earth_rate, with_exact_rates,
};
use crate::core::frames::{Body, Nav, Rotation};
use crate::core::message::{figure, list, sent};
use crate::core::model::{Term, Terms};
use crate::core::mounting::Geometry;
use crate::core::units::{arcsec, radians, radians_from_arcsec};
use crate::wire::prelude::*;

pub mod commanded;
mod write;

/// A degree: beyond it a station's error is a mistake and no uncertainty.
pub const MAX_UNCERTAINTY_ARCSEC: f64 = 3600.0;

/// What `rate_arcsec_s` may hold.
const INERTIAL: &str = "inertial";
const TABLE: &str = "table";

/// Largest | |q| - 1 | of an attitude: four printed digits still pass.
const MAX_QUATERNION_EXCESS: f64 = 1e-4;

/// Site of the station.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SiteBody {
    /// Geodetic latitude, degrees, north positive.
    pub latitude_deg: f64,
    /// Local gravity, g0 (9.80665 m/s^2).
    pub gravity_g0: f64,
    /// Direction of the magnetic field [East, North, Up], any unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<[f64; 3]>, min_items = 3, max_items = 3)]
    pub magnetic_field_nav: Option<Numbers>,
}

/// Systematic standard uncertainties of the station, arcsec. What is left out is the configuration's.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StationUncertaintyBody {
    /// Of the table's vertical, about east and about north alike.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levelling_arcsec: Option<f64>,
    /// Of the table's north.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth_arcsec: Option<f64>,
    /// Of the IMU against the table, about each body axis alike.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixture_arcsec: Option<f64>,
}

/// One gyro of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CampaignGyroBody {
    /// G1, G2 or G3. A single-gyro bench test may leave it out (G1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slot: Option<String>,
    pub serial: String,
    /// E that is held and not fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<[f64; 3]>, min_items = 3, max_items = 3)]
    pub known_e_pulse_per_arcsec: Option<Numbers>,
}

/// One averaging interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DwellBody {
    /// `static` or `rate`.
    pub phase: String,
    pub start_s: f64,
    pub duration_s: f64,
    /// Commanded unit quaternion [w, x, y, z] with v_body = C(q) v_nav, nav = East-North-Up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<[f64; 4]>, min_items = 4, max_items = 4)]
    pub attitude: Option<Numbers>,
    /// Commanded mean specific force, body axes, g0.
    #[schema(value_type = [f64; 3], min_items = 3, max_items = 3)]
    pub specific_force_g0: Numbers,
    /// Commanded mean inertial rate, Earth rate included, body axes, arcsec/s.
    #[schema(value_type = [f64; 3], min_items = 3, max_items = 3)]
    pub rate_arcsec_s: Numbers,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// Mean output of each gyro, in the order of `gyros`.
    #[schema(value_type = Vec<f64>, min_items = 1, max_items = 3)]
    pub output_pulse_s: Numbers,
    /// Standard errors of those means.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 1, max_items = 3)]
    pub output_sem_pulse_s: Option<Numbers>,
}

/// A campaign of raw dwells, or a raw single-gyro bench test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CampaignBody {
    pub imu: String,
    pub station: String,
    /// RFC 3339, with offset.
    pub measured_at: String,
    pub geometry: GeometryBody,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub site: Option<SiteBody>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub station_uncertainty: Option<StationUncertaintyBody>,
    #[schema(min_items = 1, max_items = 3)]
    pub gyros: Vec<CampaignGyroBody>,
    #[schema(min_items = 1)]
    pub dwells: Vec<DwellBody>,
    /// What `rate_arcsec_s` holds: `inertial` rates (default), or the `table`'s own, to which the service adds the
    /// Earth's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rates: Option<String>,
    /// `imu` (default), `torque_feedback` or `turntable_servo`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test: Option<String>,
    /// Terms to fit: any of `bias`, `g_linear`, `g_squared`, `scale`. All four by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1)]
    pub model: Option<Vec<String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Reads and checks a campaign in JSON.
pub fn parse_json(bytes: &[u8]) -> Result<Campaign, Faults> {
    json::parse_and_read(bytes, CampaignBody::to_core)
}

/// As [`parse_json`], of a campaign that comes in: what was commanded must be what the Earth allows.
pub fn parse_json_as_sent(bytes: &[u8]) -> Result<Campaign, Faults> {
    let campaign = parse_json(bytes)?;
    commanded::check(&campaign).map(|()| campaign)
}

/// How a campaign is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    Json,
    Csv,
}

/// The campaign as one JSON document, ready to be read by [`parse_json`].
pub fn to_json(campaign: &Campaign) -> String {
    serde_json::to_string(&CampaignBody::from(campaign)).expect("strings and finite numbers always serialise")
}

/// Terms by name, faults by position.
pub fn terms_from_names<S: AsRef<str>>(names: &[S]) -> Result<Terms, Faults> {
    let mut faults = Faults::default();
    let mut terms = Vec::new();
    for (i, name) in names.iter().map(AsRef::as_ref).enumerate() {
        match Term::from_name(name) {
            Some(term) if terms.contains(&term) => {
                faults.push(format!("/{i}"), message!("named_twice", name = format_args!("{name}")))
            }
            Some(term) => terms.push(term),
            None => faults.push(format!("/{i}"), message!("unknown_term", value = sent(name))),
        }
    }
    if names.is_empty() {
        faults.push("", message!("no_terms"));
    }
    faults.or(Terms::of(&terms))
}

impl CampaignBody {
    /// Converts and checks.
    pub fn to_core(&self) -> Result<Campaign, Faults> {
        let faults = &mut Faults::default();
        let head = self.head(faults);
        let site = self.site.as_ref().and_then(|s| s.to_core(faults));
        let dwells: Vec<Option<Dwell>> =
            self.dwells.iter().enumerate().map(|(i, d)| d.to_core(i, self.gyros.len(), faults)).collect();
        let limits = CampaignLimits::default();
        if faults.is_empty() {
            let campaign = Campaign { site, dwells: dwells.into_iter().flatten().collect(), ..head };
            let campaign = self.inertial(campaign)?;
            return match campaign.check(&limits) {
                Ok(()) => Ok(campaign),
                Err(faults) => Err(commanded::explained(&campaign, faults)),
            };
        }
        // What could be read is still checked, so that a station hears of everything at once.
        let read = dwells.iter().enumerate().filter_map(|(i, d)| d.as_ref().map(|d| (i, d)));
        check_dwells(read, site.as_ref(), &limits, faults);
        Err(std::mem::take(faults))
    }

    /// Everything but site and dwells. A refused member has a stand-in.
    fn head(&self, faults: &mut Faults) -> Campaign {
        let imu = text::name("/imu", &self.imu, faults);
        let station = text::name("/station", &self.station, faults);
        let measured_at = text::instant("/measured_at", &self.measured_at, faults);
        let test = self.test(faults);
        if let Some(rates) = self.rates.as_deref().filter(|rates| !matches!(*rates, INERTIAL | TABLE)) {
            faults.push("/rates", message!("rates_inertial_or_table", value = sent(rates)));
        }
        let gyros = self.gyros(test != TestKind::Imu, faults);
        let stated = self.station_uncertainty.unwrap_or_default();
        let station_uncertainty = stated.to_core().map_err(|part| faults.absorb("", part)).unwrap_or_default();
        let geometry = self.geometry.to_core().map_err(|part| faults.absorb("/geometry", part));
        Campaign {
            imu,
            station,
            measured_at,
            geometry: geometry.unwrap_or(Geometry::Skewed),
            site: None,
            station_uncertainty,
            gyros,
            dwells: Vec::new(),
            rates_sent_in_steps: None,
            test,
            model: self.model(faults),
            temperature_c: text::temperature("/temperature_c", self.temperature_c, faults),
            operator: text::short("/operator", &self.operator, faults),
            note: text::note("/note", &self.note, faults),
        }
    }

    /// With inertial rates, whichever were sent, and the exact ones where they were rounded.
    fn inertial(&self, campaign: Campaign) -> Result<Campaign, Faults> {
        match self.rates.as_deref() {
            None | Some(INERTIAL) => Ok(with_exact_rates(campaign)),
            Some(_) => with_earth_rate(&campaign, AffectedDwells::All).map_err(|lacks| {
                let mut missing = Vec::new();
                missing.extend(lacks.site.then(|| message!("site_missing")));
                missing.extend(lacks.attitudes.first().map(|first| {
                    let first = format_args!("/dwells/{first}");
                    message!("attitudes_missing", count = lacks.attitudes.len(), first)
                }));
                let message = message!("earth_rate_needs", missing = list(missing));
                Fault { pointer: "/rates".to_owned(), message }.into()
            }),
        }
    }

    fn test(&self, faults: &mut Faults) -> TestKind {
        let name = self.test.as_deref().unwrap_or(TestKind::Imu.name());
        let Some(test) = TestKind::from_name(name) else {
            faults.push("/test", message!("unknown_test", value = sent(name)));
            return TestKind::Imu;
        };
        if test != TestKind::Imu && self.gyros.len() != 1 {
            faults.push("/gyros", message!("bench_one_gyro", test = test.name(), have = self.gyros.len()));
        }
        test
    }

    fn gyros(&self, bench: bool, faults: &mut Faults) -> Vec<CampaignGyro> {
        if self.gyros.is_empty() || self.gyros.len() > 3 {
            faults.push("/gyros", message!("gyros_one_to_three", have = self.gyros.len()));
            return Vec::new();
        }
        self.gyros.iter().enumerate().map(|(i, gyro)| gyro.to_core(i, bench, faults)).collect()
    }

    fn model(&self, faults: &mut Faults) -> Option<Terms> {
        terms_from_names(self.model.as_ref()?).map_err(|part| faults.absorb("/model", part)).ok()
    }
}

impl CampaignGyroBody {
    fn to_core(&self, i: usize, bench: bool, faults: &mut Faults) -> CampaignGyro {
        let place = format!("/gyros/{i}/slot");
        let slot = match self.slot.as_deref() {
            None if bench => Slot::G1,
            None => {
                faults.push(place, message!("missing_member", member = "slot"));
                Slot::ALL[i]
            }
            Some(text) => Slot::from_name(text).unwrap_or_else(|| {
                faults.push(place, message!("unknown_slot", value = sent(text)));
                Slot::ALL[i]
            }),
        };
        let serial = text::name(&format!("/gyros/{i}/serial"), &self.serial, faults);
        let place = format_args!("/gyros/{i}/known_e_pulse_per_arcsec");
        let known_e = self.known_e_pulse_per_arcsec.as_ref().and_then(|e| e.vector(place, faults));
        CampaignGyro { slot, serial, known_e }
    }
}

impl StationUncertaintyBody {
    pub fn to_core(self) -> Result<StationUncertainty, Faults> {
        let mut faults = Faults::default();
        let mut part = |member: &str, arcsec: Option<f64>| {
            let arcsec = arcsec?;
            if !(0.0..=MAX_UNCERTAINTY_ARCSEC).contains(&arcsec) {
                let most = format_args!("{MAX_UNCERTAINTY_ARCSEC}");
                let message = message!("station_uncertainty_range", value = format_args!("{arcsec}"), most);
                faults.push(format!("/station_uncertainty/{member}"), message);
            }
            Some(radians_from_arcsec(arcsec))
        };
        let stated = StationUncertainty {
            levelling: part("levelling_arcsec", self.levelling_arcsec),
            azimuth: part("azimuth_arcsec", self.azimuth_arcsec),
            fixture: part("fixture_arcsec", self.fixture_arcsec),
        };
        faults.or(stated)
    }

    /// None where nothing is stated.
    pub fn of(stated: &StationUncertainty) -> Option<Self> {
        let [levelling_arcsec, azimuth_arcsec, fixture_arcsec] =
            StationPart::ALL.map(|part| stated.of(part).map(|sd| tidy(arcsec(sd))));
        stated.is_stated().then_some(Self { levelling_arcsec, azimuth_arcsec, fixture_arcsec })
    }
}

impl SiteBody {
    fn to_core(&self, faults: &mut Faults) -> Option<Site> {
        let before = faults.0.len();
        if !(-90.0..=90.0).contains(&self.latitude_deg) {
            faults
                .push("/site/latitude_deg", message!("latitude_range", value = format_args!("{}", self.latitude_deg)));
        }
        if !(0.9..=1.1).contains(&self.gravity_g0) {
            faults.push("/site/gravity_g0", message!("gravity_range", value = format_args!("{}", self.gravity_g0)));
        }
        let place = "/site/magnetic_field_nav";
        let magnetic_field_nav = self.magnetic_field_nav.as_ref().and_then(|b| b.vector(place, faults));
        if magnetic_field_nav.is_some_and(|b| b.norm() == 0.0) {
            faults.push(place, message!("no_direction"));
        }
        (faults.0.len() == before).then_some(Site {
            latitude: radians(self.latitude_deg),
            gravity_g0: self.gravity_g0,
            magnetic_field_nav,
        })
    }
}

impl DwellBody {
    fn to_core(&self, i: usize, gyros: usize, faults: &mut Faults) -> Option<Dwell> {
        let before = faults.0.len();
        let phase = Phase::from_name(&self.phase);
        if phase.is_none() {
            faults.push(format!("/dwells/{i}/phase"), message!("unknown_phase", value = sent(&self.phase)));
        }
        in_range(self.start_s, format_args!("/dwells/{i}/start_s"), faults);
        in_range(self.duration_s, format_args!("/dwells/{i}/duration_s"), faults);
        let specific_force_g0 = self.specific_force_g0.vector(format_args!("/dwells/{i}/specific_force_g0"), faults);
        let rate_arcsec_s = self.rate_arcsec_s.vector(format_args!("/dwells/{i}/rate_arcsec_s"), faults);
        let attitude = self.attitude.as_ref().and_then(|q| attitude(q, i, faults));
        let place = format_args!("/dwells/{i}/temperature_c");
        let temperature_c = text::temperature(place, self.temperature_c, faults);
        let outputs = |list: &Numbers, field: &str, faults: &mut Faults| {
            list.slice(gyros, format_args!("/dwells/{i}/{field}"), faults).map(<[f64]>::to_vec)
        };
        let output_pulse_s = outputs(&self.output_pulse_s, "output_pulse_s", faults);
        let output_sem_pulse_s =
            self.output_sem_pulse_s.as_ref().and_then(|list| outputs(list, "output_sem_pulse_s", faults));
        if faults.0.len() > before {
            return None;
        }
        Some(Dwell {
            phase: phase?,
            start_s: self.start_s,
            duration_s: self.duration_s,
            attitude,
            specific_force_g0: specific_force_g0?,
            rate_arcsec_s: rate_arcsec_s?,
            temperature_c,
            output_pulse_s: output_pulse_s?,
            output_sem_pulse_s,
        })
    }
}

fn attitude(q: &Numbers, i: usize, faults: &mut Faults) -> Option<Rotation<Nav, Body>> {
    let q = q.exactly::<4>(format_args!("/dwells/{i}/attitude"), faults)?;
    let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    if (length - 1.0).abs() > MAX_QUATERNION_EXCESS {
        faults.push(format!("/dwells/{i}/attitude"), message!("not_unit_quaternion", length = figure(length, 6)));
        return None;
    }
    Some(Rotation::from_attitude(q))
}

#[cfg(test)]
mod tests;
