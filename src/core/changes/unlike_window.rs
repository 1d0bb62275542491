//! A time in which many gyros of a station were off, each in its own direction.

use crate::core::message::{Message, text};
use crate::core::time::UtcMicros;
use crate::message;

/// One gyro may be off so many days before the others or after them, where they were measured at other times.
const EDGE_DAYS: f64 = 15.0;

/// Many gyros of a station were off from the first instant on and before the second, each in its own direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unlike {
    pub from: UtcMicros,
    /// None where they still are.
    pub until: Option<UtcMicros>,
    /// How many, of how many.
    pub gyros: usize,
    pub of: usize,
}

impl Unlike {
    /// What is said of it.
    pub fn message(&self) -> Message {
        let Self { from, until, gyros, of } = *self;
        let from = text(from.date());
        match until {
            Some(until) => message!("station_unlike", from, until = text(until.date()), gyros, of),
            None => message!("station_unlike_since", from, gyros, of),
        }
    }

    /// How many, beside its dates.
    pub fn in_brief(&self) -> Message {
        message!("station_unlike_brief", gyros = self.gyros, of = self.of)
    }

    /// What `station` did to one of its gyros.
    pub(super) fn as_cause(&self, station: &str) -> Message {
        let Self { from, until, gyros, of } = *self;
        let (station, from) = (text(station), text(from.date()));
        match until {
            Some(until) => message!("change_station_unlike", station, from, until = text(until.date()), gyros, of),
            None => message!("change_station_unlike_since", station, from, gyros, of),
        }
    }

    /// Whether a record of the station may be one of those that are off: the edges are between records of many gyros.
    pub(super) fn may_hold(&self, at: UtcMicros) -> bool {
        at >= self.from.plus_days(-EDGE_DAYS) && self.until.is_none_or(|until| at < until.plus_days(EDGE_DAYS))
    }

    /// Where they may begin and end at records of one gyro, which are at `instants`.
    pub(super) fn edges(&self, instants: &[UtcMicros]) -> Vec<(UtcMicros, Option<UtcMicros>)> {
        let about = |edge: UtcMicros| -> Vec<UtcMicros> {
            let is_near = |at: &&UtcMicros| at.days_since(edge).abs() <= EDGE_DAYS && **at != edge;
            std::iter::once(edge).chain(instants.iter().filter(is_near).copied()).collect()
        };
        let ends: Vec<Option<UtcMicros>> =
            self.until.map_or(vec![None], |until| about(until).into_iter().map(Some).collect());
        let begin = about(self.from).into_iter();
        let windows = begin.flat_map(|from| ends.iter().map(move |until| (from, *until)));
        windows.filter(|(from, until)| until.is_none_or(|until| *from < until)).collect()
    }
}
