//! The summary of many diagnoses as CSV (RFC 4180): a line for each effect in each gyro, then one for each doubt.

use super::csv_text::csv_text;
use super::diagnoses::{DoubtBody, FindingBody, SummaryBody};

/// The names of the columns.
const HEADER: &str = "kind,effect,class,imu,slot,serial,stations,campaigns,of,of_since,clear_at,first_at,\
                      first_campaign,last_at,last_campaign,closure_median,closure_least,closure_greatest,\
                      d_i_shift_deg_per_h_g0,d_i_of_budget,d_s_shift_deg_per_h_g0,d_s_of_budget";

/// Lists within a cell are parted by blanks, stations by semicolons (their names may hold blanks).
pub fn to_csv(summary: &SummaryBody) -> String {
    csv_text(HEADER, summary.findings.iter().map(finding).chain(summary.doubts.iter().map(doubt)))
}

fn finding(f: &FindingBody) -> [String; 22] {
    let stations: Vec<&str> = f.stations.iter().map(|at| at.station.as_str()).collect();
    let shift = |name: &str| {
        let found = f.impact.iter().find(|i| i.coefficient == name);
        found.map_or_else(Default::default, |i| [i.shift.to_string(), i.of_budget.to_string()])
    };
    let ([d_i, d_i_of], [d_s, d_s_of]) = (shift("D_I"), shift("D_S"));
    [
        "effect".to_owned(),
        f.effect.clone(),
        f.class.join(" "),
        f.imu.clone(),
        f.slot.clone(),
        f.serial.clone(),
        stations.join(";"),
        f.campaigns.to_string(),
        f.of.to_string(),
        f.of_since.to_string(),
        f.clear_at.clone().unwrap_or_default(),
        f.first.measured_at.clone(),
        f.first.campaign.clone(),
        f.last.measured_at.clone(),
        f.last.campaign.clone(),
        f.closure.median.to_string(),
        f.closure.least.to_string(),
        f.closure.greatest.to_string(),
        d_i,
        d_i_of,
        d_s,
        d_s_of,
    ]
}

fn doubt(d: &DoubtBody) -> [String; 22] {
    let mut cells: [String; 22] = Default::default();
    cells[0] = d.verdict.clone();
    cells[3] = d.imu.clone();
    cells[5] = d.gyros.join(" ");
    cells[6] = d.stations.join(";");
    cells[7] = d.campaigns.to_string();
    cells[8] = d.of.to_string();
    cells[11] = d.first.measured_at.clone();
    cells[12] = d.first.campaign.clone();
    cells[13] = d.last.measured_at.clone();
    cells[14] = d.last.campaign.clone();
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::diagnoses::{AtStationBody, ClosuresBody, LargestShiftBody, SightingBody};

    #[test]
    fn a_cell_stands_under_its_column_and_is_quoted_where_it_must_be() {
        let seen = |campaign: &str| SightingBody {
            campaign: campaign.into(),
            measured_at: "2026-03-01T08:00:00Z".into(),
            station: "a, b".into(),
        };
        let finding = FindingBody {
            effect: "time_ramp".into(),
            class: vec!["time_ramp".into(), "warmup".into()],
            imu: "IMU \"7\"".into(),
            slot: "G2".into(),
            serial: "L-1".into(),
            stations: vec![AtStationBody { station: "a, b".into(), campaigns: 1, of: 2 }],
            campaigns: 1,
            of: 2,
            of_since: 1,
            clear_at: None,
            first: seen("f"),
            last: seen("l"),
            closure: ClosuresBody { least: 0.5, median: 0.75, greatest: 1.0 },
            impact: vec![LargestShiftBody {
                coefficient: "D_S".into(),
                shift: -0.25,
                of_budget: 25.0,
                campaign: "l".into(),
            }],
        };
        let doubt = DoubtBody {
            verdict: "unexplained".into(),
            imu: "IMU-8".into(),
            gyros: vec!["L-2".into()],
            signs: vec!["spread".into()],
            stations: vec!["c".into()],
            campaigns: 3,
            of: 4,
            first: seen("d"),
            last: seen("e"),
        };
        let text = to_csv(&SummaryBody { findings: vec![finding], doubts: vec![doubt], ..SummaryBody::default() });
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], HEADER);
        assert_eq!(
            lines[1],
            "effect,time_ramp,time_ramp warmup,\"IMU \"\"7\"\"\",G2,L-1,\"a, b\",1,2,1,,2026-03-01T08:00:00Z,f,\
             2026-03-01T08:00:00Z,l,0.75,0.5,1,,,-0.25,25"
        );
        assert_eq!(lines[2], "unexplained,,,IMU-8,,L-2,c,3,4,,,2026-03-01T08:00:00Z,d,2026-03-01T08:00:00Z,e,,,,,,,");
        assert_eq!(lines.len(), 3);
    }
}
