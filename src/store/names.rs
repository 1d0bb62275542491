//! IMUs, stations and gyros by number and by name, held in memory: there are thousands of them, not millions.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use super::commit::Changes;

/// Names of one kind. Numbers count from 1.
#[derive(Debug, Default)]
pub struct Table {
    by_number: Vec<Arc<str>>,
    by_name: HashMap<Arc<str>, u32>,
}

impl Table {
    pub fn number(&self, name: &str) -> Option<u32> {
        self.by_name.get(name).copied()
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
