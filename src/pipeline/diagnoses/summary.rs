//! What the diagnoses of many campaigns say together: which effects, in which gyros, at which stations, since when.
//!
//! One pass over the digests in order of time; what is held grows with gyros and findings, not with campaigns.

use crate::core::effects::Effect;
use crate::core::first_of::FirstOf;
use crate::pipeline::diagnoses::digest::{Digest, NamedDigest, OUTSIDE, REFUSED};
use crate::pipeline::prelude::*;
use crate::store::{CampaignFilter, DigestRow, Tables};
use crate::wire::diagnoses::{
    AtStationBody, ClosuresBody, CoverageBody, DoubtBody, FindingBody, LargestShiftBody, OutsideForecastBody,
    OverviewBody, SightingBody, SummaryBody,
};
use crate::wire::forecast::LargestForecastError;
use crate::wire::time;

/// Of which campaigns, and of which effect.
#[derive(Debug, Clone)]
pub struct SummaryFilter {
    pub(super) campaigns: CampaignFilter,
    pub(super) effect: Option<Effect>,
}

/// A campaign in which something was seen.
#[derive(Debug, Clone, Copy)]
struct Occurrence {
    record: Id,
    at: UtcMicros,
    station: u32,
}

/// A gyro in an IMU, as far as its campaigns have been passed.
#[derive(Debug, Default)]
struct GyroCampaigns {
    campaigns: u64,
    stations: BTreeMap<u32, u64>,
    last: Option<UtcMicros>,
}

#[derive(Debug)]
struct GyroEffect {
    class: Vec<String>,
    slot: String,
    stations: BTreeMap<u32, u64>,
    campaigns: u64,
    /// Campaigns of the gyro before the first one with it, and when the last of these was.
    before: u64,
    clear: Option<UtcMicros>,
    first: Occurrence,
    last: Occurrence,
    closures: Vec<f64>,
    impact: BTreeMap<String, LargestShiftBody>,
}

/// A gap of an IMU that is not wholly explained.
#[derive(Debug)]
struct UnexplainedGap {
    serials: BTreeSet<String>,
    signs: BTreeSet<String>,
    stations: BTreeSet<u32>,
    campaigns: u64,
    first: Occurrence,
    last: Occurrence,
}

/// One effect over all IMUs.
#[derive(Debug)]
struct Overview {
    campaigns: u64,
    first: UtcMicros,
    last: UtcMicros,
}

/// What has been passed so far.
#[derive(Debug, Default)]
struct SummaryTally {
    effect: Option<&'static str>,
    coverage: CoverageBody,
    /// By IMU and serial.
    courses: HashMap<(u32, String), GyroCampaigns>,
    /// Diagnosed campaigns of each IMU.
    imus: HashMap<u32, u64>,
    /// By effect, IMU and serial.
    findings: BTreeMap<(String, u32, String), GyroEffect>,
    overview: BTreeMap<String, Overview>,
    /// By verdict and IMU.
    doubts: BTreeMap<(String, u32), UnexplainedGap>,
    /// By IMU.
    outside: BTreeMap<u32, Vec<(Occurrence, LargestForecastError)>>,
}

impl SummaryTally {
    fn add(&mut self, row: &DigestRow, digest: &Digest, program: &str) {
        self.cover(row, digest, program);
        if digest.verdict == REFUSED {
            return;
        }
        let seen = Occurrence { record: row.record, at: row.measured_at, station: row.station };
        *self.imus.entry(row.imu).or_default() += 1;
        if let Some(outside) = digest.outside_forecast.clone().filter(|_| self.effect.is_none()) {
            self.outside.entry(row.imu).or_default().push((seen, outside));
        }
        for named in &digest.effects {
            if self.effect.is_none_or(|wanted| wanted == named.effect) {
                self.note(row.imu, seen, digest, named);
            }
        }
        if self.effect.is_none() && matches!(digest.verdict.as_str(), "unexplained" | "partly_explained") {
            self.doubt(row.imu, seen, digest);
        }
        for seat in &digest.gyros {
            let course = self.courses.entry((row.imu, seat.serial.clone())).or_default();
            course.campaigns += 1;
            *course.stations.entry(row.station).or_default() += 1;
            course.last = Some(row.measured_at);
        }
    }

    fn cover(&mut self, row: &DigestRow, digest: &Digest, program: &str) {
        let of_verdict = match digest.verdict.as_str() {
            "no_gap" => &mut self.coverage.no_gap,
            "explained" => &mut self.coverage.explained,
            "partly_explained" => &mut self.coverage.partly_explained,
            REFUSED => &mut self.coverage.refused,
            _ => &mut self.coverage.unexplained,
        };
        *of_verdict += 1;
        self.coverage.diagnosed += u64::from(digest.verdict != REFUSED);
        self.coverage.outdated += u64::from(row.program != program);
    }

    /// An effect that a campaign names. The campaign itself has not been added to the courses of its gyros yet.
    fn note(&mut self, imu: u32, seen: Occurrence, digest: &Digest, named: &NamedDigest) {
        let new = || Overview { campaigns: 0, first: seen.at, last: seen.at };
        let overview = self.overview.entry(named.effect.clone()).or_insert_with(new);
        overview.campaigns += 1;
        overview.last = seen.at;
        for slot in &named.gyros {
            let Some(serial) = digest.serial(slot) else { continue };
            let course = self.courses.get(&(imu, serial.to_owned()));
            let key = (named.effect.clone(), imu, serial.to_owned());
            let finding = self.findings.entry(key).or_insert_with(|| GyroEffect {
                class: named.class.clone(),
                slot: slot.clone(),
                stations: BTreeMap::new(),
                campaigns: 0,
                before: course.map_or(0, |course| course.campaigns),
                clear: course.and_then(|course| course.last),
                first: seen,
                last: seen,
                closures: Vec::new(),
                impact: BTreeMap::new(),
            });
            finding.add(seen, slot, digest, named);
        }
    }

    fn doubt(&mut self, imu: u32, seen: Occurrence, digest: &Digest) {
        let doubt = self.doubts.entry((digest.verdict.clone(), imu)).or_insert_with(|| UnexplainedGap {
            serials: BTreeSet::new(),
            signs: BTreeSet::new(),
            stations: BTreeSet::new(),
            campaigns: 0,
            first: seen,
            last: seen,
        });
        doubt.campaigns += 1;
        doubt.last = seen;
        doubt.stations.insert(seen.station);
        for sign in &digest.signs {
            doubt.signs.insert(sign.kind.clone());
            doubt.serials.extend(sign.gyros.iter().filter_map(|slot| digest.serial(slot)).map(str::to_owned));
        }
    }

    fn into_body(self, tables: &Tables) -> SummaryBody {
        let mut effects: Vec<OverviewBody> =
            self.overview.iter().map(|(effect, overview)| self.overview_body(effect, overview, tables)).collect();
        effects.sort_by_key(|one| std::cmp::Reverse((one.imus.len(), one.campaigns)));
        let findings = self.findings.iter().map(|(key, finding)| self.finding_body(key, finding, tables)).collect();
        let doubts = self.doubts.iter().map(|(key, doubt)| self.doubt_body(key, doubt, tables)).collect();
        let outside = self.outside.iter().flat_map(|(imu, all)| all.iter().map(|one| outside_body(*imu, one, tables)));
        let outside_forecast = outside.collect();
        SummaryBody { campaigns: self.coverage, effects, findings, doubts, outside_forecast }
    }

    fn overview_body(&self, effect: &str, overview: &Overview, tables: &Tables) -> OverviewBody {
        let of_effect = || self.findings.iter().filter(|((name, ..), _)| name == effect);
        let imus: BTreeSet<String> = of_effect().map(|((_, imu, _), _)| tables.imus.text(*imu).to_owned()).collect();
        let stations: BTreeSet<String> = of_effect()
            .flat_map(|(_, found)| found.stations.keys())
            .map(|at| tables.stations.text(*at).to_owned())
            .collect();
        OverviewBody {
            effect: effect.to_owned(),
            imus: imus.into_iter().collect(),
            stations: stations.into_iter().collect(),
            gyros: of_effect().count() as u64,
            campaigns: overview.campaigns,
            first_at: time::format(overview.first),
            last_at: time::format(overview.last),
        }
    }

    fn finding_body(
        &self,
        (effect, imu, serial): &(String, u32, String),
        found: &GyroEffect,
        tables: &Tables,
    ) -> FindingBody {
        let course = self.courses.get(&(*imu, serial.clone()));
        let of = course.map_or(0, |course| course.campaigns);
        let at_station = |(station, campaigns): (&u32, &u64)| AtStationBody {
            station: tables.stations.text(*station).to_owned(),
            campaigns: *campaigns,
            of: course.and_then(|course| course.stations.get(station)).copied().unwrap_or(*campaigns),
        };
        FindingBody {
            effect: effect.clone(),
            class: found.class.clone(),
            imu: tables.imus.text(*imu).to_owned(),
            slot: found.slot.clone(),
            serial: serial.clone(),
            stations: found.stations.iter().map(at_station).collect(),
            campaigns: found.campaigns,
            of,
            of_since: of - found.before,
            clear_at: found.clear.map(time::format),
            first: found.first.body(tables),
            last: found.last.body(tables),
            closure: closures(&found.closures),
            impact: found.impact.values().cloned().collect(),
        }
    }

    fn doubt_body(&self, (verdict, imu): &(String, u32), doubt: &UnexplainedGap, tables: &Tables) -> DoubtBody {
        DoubtBody {
            verdict: verdict.clone(),
            imu: tables.imus.text(*imu).to_owned(),
            gyros: doubt.serials.iter().cloned().collect(),
            signs: doubt.signs.iter().cloned().collect(),
            stations: doubt.stations.iter().map(|at| tables.stations.text(*at).to_owned()).collect(),
            campaigns: doubt.campaigns,
            of: self.imus.get(imu).copied().unwrap_or(doubt.campaigns),
            first: doubt.first.body(tables),
            last: doubt.last.body(tables),
        }
    }
}

impl GyroEffect {
    fn add(&mut self, seen: Occurrence, slot: &str, digest: &Digest, named: &NamedDigest) {
        self.campaigns += 1;
        self.last = seen;
        slot.clone_into(&mut self.slot);
        *self.stations.entry(seen.station).or_default() += 1;
        self.class.retain(|id| named.class.contains(id));
        self.closures.push(named.closure);
        for shift in digest.impact.iter().filter(|shift| shift.slot == slot) {
            let new = || LargestShiftBody {
                coefficient: shift.coefficient.clone(),
                shift: shift.shift,
                of_budget: shift.of_budget,
                campaign: seen.record.to_string(),
            };
            let largest = self.impact.entry(shift.coefficient.clone()).or_insert_with(new);
            if shift.shift.abs() > largest.shift.abs() {
                *largest = new();
            }
        }
    }
}

impl Occurrence {
    fn body(&self, tables: &Tables) -> SightingBody {
        SightingBody {
            campaign: self.record.to_string(),
            measured_at: time::format(self.at),
            station: tables.stations.text(self.station).to_owned(),
        }
    }
}

fn outside_body(
    imu: u32,
    (seen, outside): &(Occurrence, LargestForecastError),
    tables: &Tables,
) -> OutsideForecastBody {
    OutsideForecastBody {
        imu: tables.imus.text(imu).to_owned(),
        campaign: seen.body(tables),
        slot: outside.slot.clone(),
        rms_over_sd: outside.rms_over_sd,
        p_value: outside.p_value,
    }
}

/// The newest `limit` campaigns since `since` that lie outside what was foretold of them, the newest first; and how many
/// there are.
pub(in crate::pipeline) async fn outside_forecasts(
    store: &Store,
    since: UtcMicros,
    limit: usize,
) -> Result<FirstOf<OutsideForecastBody>, StoreError> {
    let (rows, of) = store::diagnosis_digest::holding(store, OUTSIDE, since, limit).await?;
    let tables = store.names().read();
    let body = |row: &DigestRow| {
        let outside = serde_json::from_str::<Digest>(&row.gist).ok()?.outside_forecast?;
        let seen = Occurrence { record: row.record, at: row.measured_at, station: row.station };
        Some(outside_body(row.imu, &(seen, outside), &tables))
    };
    Ok(FirstOf { first: rows.iter().filter_map(body).collect(), of })
}

/// The median of an even number is the lower of the two in the middle: a figure that some campaign reports.
fn closures(all: &[f64]) -> ClosuresBody {
    let mut sorted = all.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |k: usize| sorted.get(k).copied().unwrap_or_default();
    let last = sorted.len().saturating_sub(1);
    ClosuresBody { least: at(0), median: at(last / 2), greatest: at(last) }
}

impl SummaryFilter {
    /// Campaigns that count no more are left out.
    pub(super) async fn summary(&self, store: &Store, program: &str) -> Result<SummaryBody, StoreError> {
        let mut tally = SummaryTally { effect: self.effect.map(Effect::id), ..SummaryTally::default() };
        let add = |row: DigestRow| {
            tally.add(&row, &Digest::of_row(&row)?, program);
            Ok(())
        };
        // First: what is diagnosed in between then counts twice, and never not at all.
        let waiting = store::diagnosis_digest::not_diagnosed(store, &self.campaigns).await?;
        store::diagnosis_digest::each(store, &self.campaigns, add).await?;
        let mut body = tally.into_body(&store.names().read());
        body.campaigns.waiting = waiting;
        Ok(body)
    }
}
