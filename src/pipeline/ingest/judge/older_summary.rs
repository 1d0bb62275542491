//! The older part of a line with very many records, of which only what a rule asks is kept.

use std::collections::VecDeque;

use crate::core::judge::{Older, Sample};
use crate::pipeline::prelude::*;

/// Records in a run.
pub(super) const RUN: usize = 128;

/// Runs of stored records, oldest first. Where a window begins within a run, its records are read again, once for all
/// windows that begin in it.
#[derive(Debug, Clone, Default)]
pub(super) struct OlderSummary {
    runs: VecDeque<Run>,
    /// The records of one run.
    edge: Vec<Sample>,
    /// The runs from the one that begins then, together.
    together: Option<(UtcMicros, Older)>,
}

#[derive(Debug, Clone)]
struct Run {
    first: UtcMicros,
    last: UtcMicros,
    of: Older,
}

impl OlderSummary {
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Adds the newest run.
    pub fn push(&mut self, samples: &[Sample]) {
        self.together = None;
        if let [first, .., last] = samples {
            self.runs.push_back(Run { first: first.at, last: last.at, of: Older::of(samples) });
        }
    }

    /// Forgets the runs that end before `from`, and says when the last of them ended.
    pub fn forget_before(&mut self, from: UtcMicros) -> Option<UtcMicros> {
        let gone = self.runs.partition_point(|run| run.last < from);
        self.runs.drain(..gone).next_back().map(|run| run.last)
    }

    /// The stretch that has to be read before [`OlderSummary::since`] can tell of `from`.
    pub fn wanted(&self, from: UtcMicros) -> Option<Span> {
        let run = self.begun_before(from)?;
        let there = self.edge.first().is_some_and(|first| first.at == run.first);
        (!there).then_some(Span { from: run.first, to: run.last })
    }

    /// Keeps what was [wanted](OlderSummary::wanted).
    pub fn keep(&mut self, edge: Vec<Sample>) {
        self.edge = edge;
    }

    /// The records at and after `from`.
    pub fn since(&mut self, from: UtcMicros) -> Older {
        let of_edge = self.begun_before(from).map_or(Older::NONE, |_| {
            let start = self.edge.partition_point(|sample| sample.at < from);
            Older::of(&self.edge[start..])
        });
        let whole = self.runs.partition_point(|run| run.first < from);
        let Some(begin) = self.runs.get(whole).map(|run| run.first) else { return of_edge };
        let known = self.together.filter(|(of, _)| *of == begin);
        let fold = || self.runs.range(whole..).fold(Older::NONE, |older, run| older.and(&run.of));
        let (_, of_whole) = *self.together.insert(known.unwrap_or_else(|| (begin, fold())));
        of_edge.and(&of_whole)
    }

    /// The run that begins before `from` and ends at or after it.
    fn begun_before(&self, from: UtcMicros) -> Option<&Run> {
        let place = self.runs.partition_point(|run| run.last < from);
        self.runs.get(place).filter(|run| run.first < from)
    }
}
