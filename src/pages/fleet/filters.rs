//! What the fleet's page is narrowed down to: in the address, in a form, and in the heads of columns.

use axum::http::HeaderValue;
use axum::http::header::HeaderName;

use crate::core::fleet_order::FleetOrder;
use crate::core::named::Named;
use crate::pages::form::rule_choice;
use crate::pages::layout::query;
use crate::pages::prelude::*;
use crate::pipeline::{BEYOND, FleetFilter, FleetPage};
use crate::wire::problem::{self, not_one_of};

/// Stations that the form offers.
const MOST_OFFERED: usize = 100;
/// What `state` may be.
const OLD_STATES: [&str; 5] = ["exceeded", "warning", "indeterminate", "within", "overdue"];
/// A wall display is loaded again after no less, s.
const LEAST_REFRESH: u32 = 10;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::pages) struct Filters {
    /// Part of a serial, IMU or station.
    pub q: String,
    /// By its name on the wire.
    pub status: String,
    /// As links of earlier versions have it: `exceeded`, `warning`, `indeterminate`, `within` or `overdue`.
    pub state: String,
    pub station: String,
    /// `ever`: the station is any that has calibrated it.
    pub station_when: String,
    pub imu: String,
    pub rule: String,
    pub batch: String,
    pub calibrated_since: String,
    pub changed_since: String,
    /// `load`, `eta`, `age` or `serial`; else the worst status first.
    pub sort: String,
    /// `imu`: by IMU.
    pub view: String,
    /// Seconds after which a browser loads the page again.
    pub refresh: String,
    pub page: usize,
}

impl Filters {
    /// How many of those that the other filters find have each status; each leads to them.
    pub fn tiles(&self, t: &Text, fleet: &FleetPage) -> Markup {
        let of_status = |status: Status| (status.name(), t.status(status), fleet.of_status[status as usize]);
        let there = |(name, _, count): &(&str, &str, usize)| *count > 0 || self.status == *name;
        let counts = Status::ALL.into_iter().rev().map(of_status).filter(there);
        let counts = counts.chain([("", t.all_states, fleet.of_any)]);
        html! {
            ul.tiles {
                @for (status, name, count) in counts {
                    li {
                        a.(if status.is_empty() { "total" } else { status }) href=(self.of_status(status))
                            aria-current=[(self.status == status && self.state.is_empty()).then_some("true")] {
                            strong { (count) } span { (name) }
                        }
                    }
                }
            }
        }
    }

    pub fn is_wall(&self) -> bool {
        self.view == "imu"
    }

    /// What is asked of the fleet.
    pub fn filter(&self) -> Result<FleetFilter<'_>, Problem> {
        let (now, ever) = if self.station_when == "ever" { ("", &*self.station) } else { (&*self.station, "") };
        let start = |name: &'static str, said: &str| match said.trim() {
            "" => Ok(None),
            said => time::parse_start(said).map(Some).map_err(|fault| bad_parameter(name, fault)),
        };
        Ok(FleetFilter {
            text: &self.q,
            station: now,
            ever,
            imu: self.imu.trim(),
            rule: named("rule", &self.rule)?,
            batch: self.batch.trim(),
            calibrated_since: start("calibrated_since", &self.calibrated_since)?,
            changed_since: start("changed_since", &self.changed_since)?,
            statuses: self.known_statuses()?,
            order: named::<FleetOrder>("sort", &self.sort)?,
        })
    }

    fn known_statuses(&self) -> Result<Option<&'static [Status]>, Problem> {
        let statuses = self.statuses();
        match statuses {
            Some([]) if self.status.is_empty() => Err(not_one_of("state", OLD_STATES, &self.state)),
            Some([]) => Err(not_one_of("status", Status::NAMES.iter().copied(), &self.status)),
            _ => Ok(statuses),
        }
    }

    /// What is wanted; none where all is, and nothing where no status has that name.
    fn statuses(&self) -> Option<&'static [Status]> {
        if !self.status.is_empty() {
            let one = Status::ALL.iter().position(|status| status.name() == self.status);
            return Some(one.map_or(&[], |place| &Status::ALL[place..=place]));
        }
        match self.state.as_str() {
            "" => None,
            "exceeded" => Some(&BEYOND),
            "warning" => Some(&[Status::Drifting]),
            "indeterminate" => Some(&[Status::Borderline, Status::TooUncertain, Status::NotEnoughData]),
            "within" => Some(&[Status::InTolerance]),
            "overdue" => Some(&[Status::Overdue]),
            _ => Some(&[]),
        }
    }

    /// Has the browser load a wall display again.
    pub fn again(&self, mut response: Response) -> Response {
        if let Some(seconds) = self.refresh.parse::<u32>().ok().filter(|_| self.is_wall()) {
            let name = HeaderName::from_static("refresh");
            response.headers_mut().insert(name, HeaderValue::from(seconds.max(LEAST_REFRESH)));
        }
        response
    }

    /// The address of the same list with another value of some parameters.
    fn with(&self, other: &[(&str, &str)]) -> String {
        let all = [
            ("q", self.q.trim()),
            ("status", &self.status),
            ("state", &self.state),
            ("station", &self.station),
            ("station_when", &self.station_when),
            ("imu", self.imu.trim()),
            ("rule", &self.rule),
            ("batch", self.batch.trim()),
            ("calibrated_since", &self.calibrated_since),
            ("changed_since", &self.changed_since),
            ("sort", &self.sort),
            ("view", &self.view),
            ("refresh", &self.refresh),
            ("page", ""),
        ];
        let of = |(key, value)| (key, other.iter().find(|(name, _)| *name == key).map_or(value, |(_, value)| *value));
        let query = query(all.map(of));
        if query.is_empty() { "/fleet".into() } else { format!("/fleet?{query}") }
    }

    pub fn of_status(&self, status: &str) -> String {
        self.with(&[("status", status), ("state", "")])
    }

    pub fn at_page(&self, page: usize) -> String {
        self.with(&[("page", &if page > 0 { page.to_string() } else { String::new() })])
    }

    /// The head of a column by which the list can be sorted.
    pub fn head(&self, sort: &str, name: &Markup) -> Markup {
        let is_it = self.sort == sort;
        let direction = if matches!(sort, "serial" | "eta" | "age") { "ascending" } else { "descending" };
        html! {
            th aria-sort=[is_it.then_some(direction)] {
                a href=(self.with(&[("sort", sort)])) { (name) @if is_it { " " span.sorted aria-hidden="true" { "▾" } } }
            }
        }
    }

    pub fn form(&self, t: &Text, found: &FleetPage) -> Markup {
        let kept = [
            ("status", &self.status),
            ("state", &self.state),
            ("sort", &self.sort),
            ("view", &self.view),
            ("refresh", &self.refresh),
        ];
        let more = [&self.station, &self.imu, &self.rule, &self.batch, &self.calibrated_since, &self.changed_since];
        let has_more = more.iter().any(|value| !value.is_empty());
        let is_narrowed = has_more || !self.q.is_empty() || self.statuses().is_some();
        html! {
            form.search role="search" action="/fleet" method="get" {
                input type="search" name="q" value=(self.q) placeholder=(t.search_hint) aria-label=(t.search_hint);
                @for (name, value) in kept {
                    @if !value.is_empty() { input type="hidden" name=(name) value=(value); }
                }
                button { (t.search) }
                @if is_narrowed { a href="/fleet" { (t.clear_filters) } }
                (self.views(t))
                details.filters open[has_more] {
                    summary { (t.more_filters) }
                    div.fields {
                        label { (t.station) " " input name="station" value=(self.station) list="stations" size="12"; }
                        datalist #stations {
                            @for name in found.of_station.keys().take(MOST_OFFERED) { option value=(name) {} }
                        }
                        label { (t.calibrated_there) " " select name="station_when" {
                            option value="" { (t.calibrated_last) }
                            option value="ever" selected[self.station_when == "ever"] { (t.calibrated_ever) }
                        } }
                        label { (t.imu) " " input name="imu" value=(self.imu) size="12"; }
                        (rule_choice(t, &self.rule))
                        label { (t.batch) " " input name="batch" value=(self.batch) size="12"; }
                        label { (t.calibrated_since) " " input type="date" name="calibrated_since" value=(self.calibrated_since); }
                        label { (t.changed_since) " " input type="date" name="changed_since" value=(self.changed_since); }
                    }
                }
            }
        }
    }

    /// As a list, or by IMU.
    fn views(&self, t: &Text) -> Markup {
        html! {
            span.views {
                a href=(self.with(&[("view", ""), ("refresh", "")])) aria-current=[(!self.is_wall()).then_some("true")] {
                    (t.as_list)
                }
                a href=(self.with(&[("view", "imu"), ("sort", "")])) aria-current=[self.is_wall().then_some("true")] {
                    (t.by_imu)
                }
            }
        }
    }

    pub fn pager(&self, t: &Text, number: usize, last: usize) -> Markup {
        html! {
            @if last > 0 {
                p.on-paper { (t.printed_part) " " (number + 1) " / " (last + 1) }
                nav.pager aria-label=(t.page_of) {
                    @if number > 0 { a rel="prev" href=(self.at_page(number - 1)) { (t.previous) } }
                    span { (number + 1) " / " (last + 1) }
                    @if number < last { a rel="next" href=(self.at_page(number + 1)) { (t.next) } }
                }
            }
        }
    }
}

/// A parameter of an address that cannot be used.
pub(in crate::pages) fn bad_parameter(name: &'static str, fault: Message) -> Problem {
    Problem::new(400, "title_bad_query", message!("parameter_fault", parameter = name, fault))
}

/// The value that a parameter names; none where it is empty.
pub(in crate::pages) fn named<T: Named>(name: &'static str, said: &str) -> Result<Option<T>, Problem> {
    problem::named(name, Some(said).filter(|said| !said.is_empty()))
}

/// The day of an instant as a form has it.
pub(in crate::pages) fn as_day(at: UtcMicros) -> String {
    at.date().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_stay_in_the_address() {
        let filters = Filters {
            q: " IMU 07&".into(),
            station: "ST-2".into(),
            station_when: "ever".into(),
            status: "confirmed".into(),
            sort: "load".into(),
            ..Filters::default()
        };
        let kept = "station=ST-2&station_when=ever&sort=load";
        assert_eq!(filters.at_page(2), format!("/fleet?q=IMU%2007%26&status=confirmed&{kept}&page=2"));
        assert_eq!(filters.of_status("overdue"), format!("/fleet?q=IMU%2007%26&status=overdue&{kept}"));
        assert_eq!(Filters::default().at_page(0), "/fleet");
        let filter = filters.filter().unwrap();
        assert_eq!((filter.station, filter.ever, filter.order), ("", "ST-2", Some(FleetOrder::Load)));
        assert!(Filters { changed_since: "yesterday".into(), ..Filters::default() }.filter().is_err());
        for unknown in [
            Filters { status: "foo".into(), ..Filters::default() },
            Filters { state: "foo".into(), ..Filters::default() },
            Filters { rule: "foo".into(), ..Filters::default() },
            Filters { sort: "foo".into(), ..Filters::default() },
        ] {
            assert_eq!(unknown.filter().err().map(|problem| problem.status), Some(400), "{unknown:?}");
        }
    }

    #[test]
    fn addresses_of_earlier_versions_find_what_they_found() {
        let of = |state: &str| Filters { state: state.into(), ..Filters::default() };
        assert_eq!(of("exceeded").at_page(1), "/fleet?state=exceeded&page=1");
        assert_eq!(of("exceeded").of_status("drifting"), "/fleet?status=drifting", "another choice takes its place");
        let every: Vec<&Status> = ["exceeded", "warning", "indeterminate", "within", "overdue"]
            .iter()
            .flat_map(|old| of(old).statuses().unwrap())
            .collect();
        assert!(every.len() == Status::ALL.len() && Status::ALL.iter().all(|status| every.contains(&status)));
        assert_eq!((of("").statuses(), of("nonsense").statuses()), (None, Some(&[][..])));
    }
}
