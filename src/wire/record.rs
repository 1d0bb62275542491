//! The calibration record: parameters of model (6) that a station has fitted (Tables 3-4 of the paper).

use nalgebra::Vector3;

use super::geometry::GeometryBody;
use super::text::Deviations;
use super::{json, text};
use crate::core::mounting::Geometry;
use crate::core::name::Name;
use crate::core::record::{GyroParameters, Plausibility, Record};
use crate::wire::prelude::*;

/// A record as it stands on the wire.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordBody {
    /// Identifier of the inertial measurement unit, at most 64 characters.
    pub imu: String,
    /// Identifier of the station that calibrated it, at most 64 characters.
    pub station: String,
    /// When it was calibrated, RFC 3339 with offset.
    pub calibrated_at: String,
    pub geometry: GeometryBody,
    /// One to three gyros.
    #[schema(min_items = 1, max_items = 3)]
    pub gyros: Vec<GyroBody>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
    /// The campaign that the record was fitted from, as the station names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub campaign: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// One gyro's row of model (6). G is given in one of its two units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct GyroBody {
    pub slot: Slot,
    /// Serial number of the gyro, at most 64 characters. Its history follows it from IMU to IMU.
    pub serial: String,
    pub e_pulse_per_arcsec: Triple,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub g_pulse_per_s_g0: Option<Triple>,
    /// G already divided by |E|.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub g_deg_per_h_g0: Option<Triple>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_pulse_per_s_g02: Option<Triple>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_pulse_per_s: Option<f64>,
    /// Standard deviations of E, pulse/arcsec.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Deviations>)]
    pub e_sd: Option<Triple>,
    /// Standard deviations of G, in the unit in which G is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Deviations>)]
    pub g_sd: Option<Triple>,
}

/// Reads and checks a record. Errors name every fault of content by its pointer, or the one fault of form.
pub fn parse_record(bytes: &[u8], limits: &Plausibility) -> Result<Record, Faults> {
    json::parse::<RecordBody>(bytes)?.to_core(limits)
}

/// As [`parse_record`], of one that comes in: its names must have nothing in them that cannot be seen.
pub fn parse_new_record(bytes: &[u8], limits: &Plausibility) -> Result<Record, Faults> {
    json::parse_and_read(bytes, |body: &RecordBody| {
        let mut faults = Faults::default();
        let serials = body.gyros.iter().enumerate().map(|(i, gyro)| (format!("/gyros/{i}/serial"), &gyro.serial));
        let named = [("/imu".to_owned(), &body.imu), ("/station".to_owned(), &body.station)];
        for (pointer, name) in named.into_iter().chain(serials) {
            let seen = Name::parse(name).map_or(Ok(()), |name| name.check_seen());
            seen.unwrap_or_else(|why| faults.push(pointer, why));
        }
        match body.to_core(limits) {
            Ok(record) => faults.or(record),
            Err(part) => {
                faults.absorb("", part);
                Err(faults)
            }
        }
    })
}

impl RecordBody {
    /// The record that the document states, if it can be one. All faults are collected.
    pub fn to_core(&self, limits: &Plausibility) -> Result<Record, Faults> {
        let mut faults = Faults::default();
        let calibrated_at = text::instant("/calibrated_at", &self.calibrated_at, &mut faults);
        let geometry = self.geometry.to_core().map_err(|part| faults.absorb("/geometry", part));
        let geometry_stands = geometry.is_ok();
        let record = Record {
            imu: text::name("/imu", &self.imu, &mut faults),
            station: text::name("/station", &self.station, &mut faults),
            calibrated_at,
            gyros: self.gyros.iter().enumerate().map(|(i, gyro)| gyro.to_core(i, &mut faults)).collect(),
            geometry: geometry.unwrap_or(Geometry::Skewed),
            temperature_c: text::temperature("/temperature_c", self.temperature_c, &mut faults),
            campaign: text::short("/campaign", &self.campaign, &mut faults),
            operator: text::short("/operator", &self.operator, &mut faults),
            note: text::note("/note", &self.note, &mut faults),
        };
        // Without axes there is nothing to hold E against; what else is wrong has been named.
        if geometry_stands && let Err(part) = record.check(limits) {
            faults.absorb("", part);
        }
        faults.or(record)
    }
}

bodies! {
    RecordBody of Record: imu, station, calibrated_at, geometry, gyros, temperature_c, campaign, operator, note;
    GyroBody of GyroParameters: slot, serial, e_pulse_per_arcsec = e, g_pulse_per_s_g0: |gyro| Some(gyro.g.to_body()),
        g_deg_per_h_g0: |_| None,
        p_pulse_per_s_g02: |gyro| (gyro.p != Vector3::zeros()).then(|| gyro.p.to_body()),
        bias_pulse_per_s: |gyro| (gyro.bias != 0.0).then_some(gyro.bias), e_sd, g_sd;
}

impl GyroBody {
    fn to_core(&self, index: usize, faults: &mut Faults) -> GyroParameters {
        let at = |member: &str| format!("/gyros/{index}/{member}");
        let e = self.e_pulse_per_arcsec.vector();
        let (g, g_sd_factor) = self.g_in_pulses(index, faults);
        GyroParameters {
            slot: self.slot,
            serial: text::name(&at("serial"), &self.serial, faults),
            e,
            g,
            p: self.p_pulse_per_s_g02.map_or_else(Vector3::zeros, Triple::vector),
            bias: self.bias_pulse_per_s.unwrap_or(0.0),
            e_sd: text::deviations(&at("e_sd"), self.e_sd, faults),
            g_sd: text::deviations(&at("g_sd"), self.g_sd, faults).map(|sd| sd * g_sd_factor),
            g_is_ratio: self.g_deg_per_h_g0.is_some(),
        }
    }

    /// G in pulse/(s*g0), and the factor that turns the stated unit of G into that one.
    fn g_in_pulses(&self, index: usize, faults: &mut Faults) -> (Vector3<f64>, f64) {
        match (self.g_pulse_per_s_g0, self.g_deg_per_h_g0) {
            (Some(g), None) => (g.vector(), 1.0),
            (None, Some(ratio)) => {
                let scale = self.e_pulse_per_arcsec.vector().norm();
                (ratio.vector() * scale, scale)
            }
            (None, None) => {
                let pointer = format!("/gyros/{index}/g_pulse_per_s_g0");
                faults.push(pointer, message!("no_drift_stated"));
                (Vector3::zeros(), 1.0)
            }
            (Some(_), Some(_)) => {
                faults.push(format!("/gyros/{index}/g_deg_per_h_g0"), message!("two_drifts_stated"));
                (Vector3::zeros(), 1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// Tables 3-4 of the paper.
    fn tables_3_and_4() -> Value {
        let gyro = |slot: &str, e: [f64; 3], g: [f64; 3]| json!({"slot": slot, "serial": format!("LFG-{slot}"), "e_pulse_per_arcsec": e, "g_pulse_per_s_g0": g});
        json!({
            "imu": "IMU-07", "station": "ST-2", "calibrated_at": "2026-03-01T08:00:00Z", "geometry": "skewed",
            "gyros": [
                gyro("G1", [0.8473, -0.6011, 1.0367], [2.4210, 4.0554, 6.5179]),
                gyro("G2", [0.8478, -0.6000, -1.0381], [0.8634, 4.6419, -3.4081]),
                gyro("G3", [0.8533, 1.2062, -0.0008], [0.9901, 1.4495, -9.9775]),
            ],
        })
    }

    fn read(document: &Value) -> Result<Record, Faults> {
        parse_record(document.to_string().as_bytes(), &Plausibility::default())
    }

    fn with(pointer: &str, value: Value) -> Value {
        let mut document = tables_3_and_4();
        let (parent, member) = pointer.rsplit_once('/').unwrap();
        match document.pointer_mut(parent).unwrap() {
            Value::Array(items) => items[member.parse::<usize>().unwrap()] = value,
            object => object[member] = value,
        }
        document
    }

    fn pointers(document: &Value) -> Vec<String> {
        read(document).unwrap_err().0.into_iter().map(|fault| fault.pointer).collect()
    }

    #[test]
    fn the_papers_record_is_read_and_written_back_unchanged() {
        let record = read(&tables_3_and_4()).unwrap();
        assert_eq!(record.gyros[1].g, Vector3::new(0.8634, 4.6419, -3.4081));
        assert_eq!(serde_json::to_value(RecordBody::from(&record)).unwrap(), tables_3_and_4());
    }

    #[test]
    fn every_bad_member_is_named_at_its_place() {
        let shift = [1.0367, 0.8473, -0.6011];
        for (pointer, value) in [
            ("/imu", json!("")),
            ("/imu", json!(7)),
            ("/station", json!("x".repeat(65))),
            ("/calibrated_at", json!("2026-03-01T08:00:00")),
            ("/calibrated_at", json!("2026-03-01T08:00:00+99:99")),
            ("/geometry", json!("cubic")),
            ("/geometry", json!(1)),
            ("/gyros", json!([])),
            ("/gyros/0/slot", json!("G4")),
            ("/gyros/1/slot", json!("G1")),
            ("/gyros/1/serial", json!("LFG-G1")),
            ("/gyros/1/serial", json!("LFG\u{0}")),
            ("/gyros/2/e_pulse_per_arcsec", json!([1.0, 2.0])),
            ("/gyros/2/e_pulse_per_arcsec", json!([1.0, 2.0, 3.0, 4.0])),
            ("/gyros/2/e_pulse_per_arcsec/1", json!("1.2")),
            ("/gyros/2/e_pulse_per_arcsec/1", Value::Null),
            ("/gyros/2/e_pulse_per_arcsec", json!([0, 0, 0])),
            ("/gyros/0/e_pulse_per_arcsec", json!(shift)),
            ("/gyros/0/g_pulse_per_s_g0", json!([1e308, 0, 0])),
            ("/gyros/0/g_pulse_per_s_g0", json!([1e6, 0, 0])),
            ("/gyros/0/e_sd", json!([1e-4, 1e-4])),
            ("/gyros/0/surprise", json!(1)),
            ("/surprise", json!(1)),
            ("/temperature_c", json!(-300)),
            ("/note", json!("bell\u{7}")),
        ] {
            assert_eq!(pointers(&with(pointer, value.clone())), [pointer], "{value}");
        }
        assert_eq!(pointers(&with("/gyros/0/e_sd", json!([1e-4, -1e-4, 0]))), ["/gyros/0/e_sd/1"]);
    }

    #[test]
    fn all_faults_of_content_are_named_at_once() {
        let mut document = with("/imu", json!("x\u{7}"));
        document["gyros"][0]["serial"] = json!("");
        document["gyros"][1]["serial"] = json!("");
        document["gyros"][2]["slot"] = json!("G1");
        document["gyros"][0]["e_pulse_per_arcsec"] = json!([0, 0, 0]);
        assert_eq!(
            pointers(&document),
            ["/imu", "/gyros/0/serial", "/gyros/1/serial", "/gyros/0/e_pulse_per_arcsec", "/gyros/2/slot"]
        );
    }

    #[test]
    fn a_missing_member_is_named_where_it_should_be() {
        for pointer in ["/station", "/gyros/1/serial", "/gyros/1/g_pulse_per_s_g0"] {
            let mut document = tables_3_and_4();
            let (parent, member) = pointer.rsplit_once('/').unwrap();
            document.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(member);
            assert_eq!(pointers(&document), [pointer]);
        }
    }

    #[test]
    fn g_already_divided_by_e_is_read_by_its_own_name_only() {
        let mut document = tables_3_and_4();
        let gyro = document["gyros"][0].as_object_mut().unwrap();
        gyro.insert("g_deg_per_h_g0".into(), json!([1.0, 2.0, 3.0]));
        assert_eq!(pointers(&document), ["/gyros/0/g_deg_per_h_g0"]);

        let gyro = document["gyros"][0].as_object_mut().unwrap();
        gyro.remove("g_pulse_per_s_g0");
        gyro.insert("g_deg_per_h_g0".into(), json!([1e6, 2.0, 3.0]));
        assert_eq!(pointers(&document), ["/gyros/0/g_deg_per_h_g0"]);

        let gyro = document["gyros"][0].as_object_mut().unwrap();
        gyro.insert("g_deg_per_h_g0".into(), json!([1.0, 2.0, 3.0]));
        gyro.insert("g_sd".into(), json!([0.1, 0.1, 0.1]));
        let gyro = &read(&document).unwrap().gyros[0];
        let scale = gyro.e.norm();
        assert!((gyro.g / scale - Vector3::new(1.0, 2.0, 3.0)).amax() < 1e-15);
        assert!((gyro.g_sd.unwrap() / scale - Vector3::repeat(0.1)).amax() < 1e-16);
    }

    #[test]
    fn axes_stated_slot_by_slot_are_read_and_their_faults_named() {
        let axes = json!({"input": [1, 0, 0], "spin": [0, 1, 0]});
        let mut document = with("/geometry", json!({"G1": axes}));
        document["gyros"] = json!([{"slot": "G1", "serial": "A", "e_pulse_per_arcsec": [1.1, 0, 0],
            "g_pulse_per_s_g0": [1, 2, 3]}]);
        assert!(read(&document).is_ok());
        document["geometry"]["G1"]["spin"] = json!([1, 0, 0]);
        assert_eq!(pointers(&document), ["/geometry/G1/spin"]);
        document["geometry"]["G1"]["spin"] = json!([0, 1]);
        assert_eq!(pointers(&document), ["/geometry/G1/spin"]);
        document["geometry"] = json!({"G9": axes});
        assert_eq!(pointers(&document), ["/geometry/G9"]);
        document["geometry"] = json!({"G2": axes});
        assert_eq!(pointers(&document), ["/gyros/0/slot"]);
    }
}
