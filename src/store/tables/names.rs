//! IMUs, stations and gyros by number and by name, held in memory: there are thousands of them, not millions.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use crate::core::name::{look_keys, normal_form};
use crate::store::commit::Changes;
use crate::store::open::{Place, Store};

/// Names of one kind.
#[derive(Debug, Default)]
pub struct Table {
    by_number: BTreeMap<u32, Arc<str>>,
    /// Also by the normal form of a name that an earlier version stored otherwise.
    by_name: HashMap<Arc<str>, u32>,
    /// By [`look_keys`].
    by_look: HashMap<String, u32>,
}

impl Table {
    /// Of the name as it is stored, letter for letter, or else of its normal form.
    pub fn number(&self, name: &str) -> Option<u32> {
        self.by_name.get(name).or_else(|| self.by_name.get(&*normal_form(name))).copied()
    }

    /// A known name that looks like `name` and is another.
    pub fn look_alike(&self, name: &str) -> Option<&Arc<str>> {
        let known = look_keys(name).into_iter().find_map(|key| self.by_look.get(&key));
        known.and_then(|number| self.name(*number)).filter(|known| ***known != *name)
    }

    /// The name of a number that a row refers to; a number that was never given out has none.
    pub fn name(&self, number: u32) -> Option<&Arc<str>> {
        self.by_number.get(&number)
    }

    /// Every name with its number, in the order of the numbers.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Arc<str>)> {
        self.by_number.iter().map(|(number, name)| (*number, name))
    }

    pub fn numbers(&self) -> Vec<u32> {
        self.by_number.keys().copied().collect()
    }

    /// The greatest number.
    fn last_number(&self) -> u32 {
        self.by_number.last_key_value().map_or(0, |(number, _)| *number)
    }

    pub fn len(&self) -> usize {
        self.by_number.len()
    }

    pub fn is_empty(&self) -> bool {
        self.by_number.is_empty()
    }

    /// Adds a name with its number; false where either is another's already.
    pub(crate) fn add(&mut self, number: u32, name: &str) -> bool {
        if let Some(known) = self.by_number.get(&number) {
            return **known == *name;
        }
        if self.by_name.get(name).is_some_and(|known| self.name(*known).is_some_and(|known| **known == *name)) {
            return false;
        }
        let name: Arc<str> = name.into();
        self.by_number.insert(number, name.clone());
        if let Cow::Owned(normal) = normal_form(&name) {
            self.by_name.entry(normal.into()).or_insert(number);
        }
        look_keys(&name).into_iter().for_each(|key| _ = self.by_look.entry(key).or_insert(number));
        self.by_name.insert(name, number);
        true
    }
}

#[derive(Debug, Default)]
pub struct Tables {
    pub imus: Table,
    pub stations: Table,
    pub gyros: Table,
    /// The commit up to which names are known, of a database that others may write.
    pub(crate) seen: Commit,
}

/// A commit to a database that several servers write: its number, and a stamp that no other has. A failover or a
/// restore may lose commits whose numbers are then given out again, with other stamps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Commit {
    pub version: i64,
    pub stamp: i64,
}

impl Tables {
    pub(crate) fn all_mut(&mut self) -> [&mut Table; 3] {
        [&mut self.imus, &mut self.stations, &mut self.gyros]
    }
}

/// The names of what is committed, shared by the writer and all readers.
#[derive(Debug, Clone, Default)]
pub struct Names(Arc<RwLock<Tables>>);

impl Names {
    pub(crate) fn new(tables: Tables) -> Self {
        Self(Arc::new(RwLock::new(tables)))
    }

    pub fn read(&self) -> RwLockReadGuard<'_, Tables> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn change(&self, change: impl FnOnce(&mut Tables)) {
        change(&mut self.0.write().unwrap_or_else(PoisonError::into_inner));
    }

    /// Takes over what has been committed.
    pub(crate) fn learn(&self, changes: &Changes) {
        self.change(|tables| {
            let [imus, stations, gyros] = tables.all_mut();
            for (table, new) in [(imus, &changes.imus), (stations, &changes.stations), (gyros, &changes.gyros)] {
                for (number, name) in new {
                    let added = table.add(*number, name);
                    debug_assert!(added, "{name} has another number already");
                }
            }
        });
    }
}

/// A number for a new name, beside `new` others of the same group: of a file the next, of a database server one at
/// random. A commit that a failover has lost may have been answered, so that its numbers are in use somewhere and
/// must not become another name's.
pub fn new_number(store: &Store, known: &Table, new: usize, is_new: impl Fn(u32) -> bool) -> u32 {
    match &store.place {
        Place::File(_) => known.last_number() + new as u32 + 1,
        Place::Server(_) => std::iter::repeat_with(|| rand::random_range(1..=i32::MAX.unsigned_abs()))
            .find(|number| known.name(*number).is_none() && !is_new(*number))
            .expect("there are more numbers than names"),
    }
}
