//! A disk with a cache that forgets: what was flushed stays, what was not may be there, missing, or torn between
//! sectors.

use rand::{Rng, RngExt};

use super::{Call, Moment, Recording};
use crate::prelude::*;

const SECTOR: usize = 512;

/// What the disk does when it is told to flush.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flushing {
    /// As it is told.
    Honest,
    /// The log is flushed only before it is copied into the database: SQLite's `synchronous = NORMAL`.
    LogOnlyBeforeCopying,
}

#[derive(Debug, Default, Clone)]
struct File {
    durable: Vec<u8>,
    /// Changes since, by the number of their calls.
    cached: Vec<(usize, Change)>,
}

#[derive(Debug, Clone)]
enum Change {
    Write { at: usize, data: Vec<u8> },
    Resize { len: usize },
}

#[derive(Debug)]
pub struct Disk<'a> {
    recording: &'a Recording,
    flushing: Flushing,
    files: BTreeMap<String, File>,
    /// Names that have come, and files whose names have gone, since the directory was flushed.
    new_names: BTreeSet<String>,
    gone: BTreeMap<String, File>,
    /// Calls that have succeeded.
    done: BTreeSet<usize>,
    /// Which changes a flush under way covers, by its call.
    flushes: BTreeMap<usize, Vec<usize>>,
    passed: usize,
}

impl<'a> Disk<'a> {
    pub fn new(recording: &'a Recording, flushing: Flushing) -> Self {
        Self {
            recording,
            flushing,
            files: BTreeMap::new(),
            new_names: BTreeSet::new(),
            gone: BTreeMap::new(),
            done: BTreeSet::new(),
            flushes: BTreeMap::new(),
            passed: 0,
        }
    }

    /// Lets everything before `moment` happen.
    pub fn pass(&mut self, moment: usize) {
        for at in self.passed..moment {
            match self.recording.moments[at] {
                Moment::Begins(call) => self.begins(call),
                Moment::Succeeds(call) => self.succeeds(call),
            }
        }
        self.passed = moment;
    }

    fn begins(&mut self, number: usize) {
        match &self.recording.calls[number] {
            Call::Write { file, at, data } => {
                if self.flushing == Flushing::LogOnlyBeforeCopying && file == "gyrowatch.db" {
                    self.flush("gyrowatch.db-wal", &self.covered("gyrowatch.db-wal"));
                }
                let change = Change::Write { at: *at, data: data.clone() };
                self.files.entry(file.clone()).or_default().cached.push((number, change));
            }
            Call::Resize { file, len } => {
                self.files.entry(file.clone()).or_default().cached.push((number, Change::Resize { len: *len }));
            }
            Call::Flush { file } => _ = self.flushes.insert(number, self.covered(file)),
            Call::Create { .. } | Call::FlushDirectory | Call::Remove { .. } | Call::Tell { .. } => {}
        }
    }

    fn succeeds(&mut self, number: usize) {
        match &self.recording.calls[number] {
            Call::Write { .. } | Call::Resize { .. } => _ = self.done.insert(number),
            Call::Flush { file } => {
                let covered = self.flushes.remove(&number).unwrap_or_default();
                if self.flushing == Flushing::Honest || !file.ends_with("-wal") {
                    self.flush(file, &covered);
                }
            }
            Call::Create { file } => {
                if !self.files.contains_key(file) {
                    self.files.insert(file.clone(), File::default());
                    self.new_names.insert(file.clone());
                }
            }
            Call::Remove { file } => {
                if let Some(removed) = self.files.remove(file)
                    && !self.new_names.remove(file)
                {
                    self.gone.insert(file.clone(), removed);
                }
            }
            Call::FlushDirectory => {
                self.new_names.clear();
                self.gone.clear();
            }
            Call::Tell { .. } => {}
        }
    }

    /// A flush that begins now covers what has been written by now.
    fn covered(&self, file: &str) -> Vec<usize> {
        let cached = self.files.get(file).map_or(&[][..], |file| &file.cached);
        cached.iter().map(|(number, _)| *number).filter(|number| self.done.contains(number)).collect()
    }

    fn flush(&mut self, file: &str, covered: &[usize]) {
        let Some(file) = self.files.get_mut(file) else { return };
        let covered: BTreeSet<usize> = covered.iter().copied().collect();
        for (number, change) in std::mem::take(&mut file.cached) {
            if covered.contains(&number) {
                apply(&change, &mut file.durable);
            } else {
                file.cached.push((number, change));
            }
        }
    }

    /// Something that a power cut could take away now.
    pub fn at_risk(&self) -> bool {
        self.files.values().any(|file| !file.cached.is_empty())
    }

    /// The files as the operating system shows them now.
    pub fn cached(&self) -> BTreeMap<String, Vec<u8>> {
        let mut shown = BTreeMap::new();
        for (name, file) in &self.files {
            let mut content = file.durable.clone();
            file.cached.iter().for_each(|(_, change)| apply(change, &mut content));
            shown.insert(name.clone(), content);
        }
        shown
    }

    /// The files that are found after the power has failed now.
    pub fn cut(&self, random: &mut impl Rng) -> BTreeMap<String, Vec<u8>> {
        let mut found = BTreeMap::new();
        let gone = self.gone.iter().filter(|(name, _)| !self.files.contains_key(*name));
        let gone: Vec<_> = gone.filter(|_| random.random_bool(0.5)).collect();
        for (name, file) in self.files.iter().chain(gone) {
            if self.new_names.contains(name) && random.random_bool(0.5) {
                continue;
            }
            // Nothing, everything, or each sector of each write as chance will have it.
            let kept = [0.0, 1.0, 0.9, 0.5, 0.1][random.random_range(0..5)];
            let mut content = file.durable.clone();
            for (_, change) in &file.cached {
                for part in parts(change) {
                    if random.random_bool(kept) {
                        apply(&part, &mut content);
                    }
                }
            }
            found.insert(name.clone(), content);
        }
        found
    }
}

/// What of a change the disk does in one go.
fn parts(change: &Change) -> Vec<Change> {
    let Change::Write { at, data } = change else { return vec![change.clone()] };
    let (mut parts, mut from) = (Vec::new(), 0);
    while from < data.len() {
        let to = data.len().min(from + SECTOR - (at + from) % SECTOR);
        parts.push(Change::Write { at: at + from, data: data[from..to].to_vec() });
        from = to;
    }
    parts
}

fn apply(change: &Change, content: &mut Vec<u8>) {
    match change {
        Change::Write { at, data } => {
            let end = at + data.len();
            if content.len() < end {
                content.resize(end, 0);
            }
            content[*at..end].copy_from_slice(data);
        }
        Change::Resize { len } => content.resize(*len, 0),
    }
}
