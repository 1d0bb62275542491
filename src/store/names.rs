//! IMUs, stations and gyros by number and by name, held in memory: there are thousands of them, not millions.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use super::commit::Changes;
use crate::core::name::{look_keys, normal_form};

/// Names of one kind. Numbers count from 1.
#[derive(Debug, Default)]
pub struct Table {
    by_number: Vec<Arc<str>>,
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
        self.by_number.get(number.checked_sub(1)? as usize)
    }

    /// Every name with its number, in the order in which they were first seen.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Arc<str>)> {
        (1..).zip(&self.by_number)
    }

    pub fn len(&self) -> usize {
        self.by_number.len()
    }

    pub fn is_empty(&self) -> bool {
        self.by_number.is_empty()
    }

    /// Adds the name with the next number; false where the number is not the next.
    pub(super) fn add(&mut self, number: u32, name: &str) -> bool {
        let is_next = number as usize == self.by_number.len() + 1;
        if is_next {
            let name: Arc<str> = name.into();
            self.by_number.push(name.clone());
            if let Cow::Owned(normal) = normal_form(&name) {
                self.by_name.entry(normal.into()).or_insert(number);
            }
            look_keys(&name).into_iter().for_each(|key| _ = self.by_look.entry(key).or_insert(number));
            self.by_name.insert(name, number);
        }
        is_next
    }

    /// As [`Table::add`]; true also where the name has this number already.
    pub(super) fn learn(&mut self, number: u32, name: &str) -> bool {
        self.number(name) == Some(number) || self.add(number, name)
    }

    /// Adds names that were numbered on from [`Table::len`]; those that are there already may be among them.
    pub(super) fn extend(&mut self, names: &[(u32, String)]) {
        for (number, name) in names {
            let added = self.learn(*number, name);
            debug_assert!(added, "{name} is out of sequence");
        }
    }
}

#[derive(Debug, Default)]
pub struct Tables {
    pub imus: Table,
    pub stations: Table,
    pub gyros: Table,
}

/// The names of what is committed, shared by the writer and all readers.
#[derive(Debug, Clone, Default)]
pub struct Names(Arc<RwLock<Tables>>);

impl Names {
    pub(super) fn new(tables: Tables) -> Self {
        Self(Arc::new(RwLock::new(tables)))
    }

    pub fn read(&self) -> RwLockReadGuard<'_, Tables> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn change(&self, change: impl FnOnce(&mut Tables)) {
        change(&mut self.0.write().unwrap_or_else(PoisonError::into_inner));
    }

    /// Takes over what has been committed.
    pub(super) fn learn(&self, changes: &Changes) {
        self.change(|tables| {
            tables.imus.extend(&changes.imus);
            tables.stations.extend(&changes.stations);
            tables.gyros.extend(&changes.gyros);
        });
    }
}
