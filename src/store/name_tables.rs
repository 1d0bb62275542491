//! IMUs, stations and gyros by number and by name, held in memory.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use crate::core::name::{look_keys, normal_form};
use crate::store::cells::CELLS;
use crate::store::error::StoreError;

/// What has a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NamesOf {
    Imus,
    Stations,
    Gyros,
}

impl NamesOf {
    pub const ALL: [Self; 3] = [Self::Imus, Self::Stations, Self::Gyros];
}

/// A name that is new to the database.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewName {
    pub number: u32,
    /// Where it is at home among other servers.
    pub cell: u8,
    pub name: String,
}

/// Names of one kind.
#[derive(Debug, Default)]
pub struct Table {
    by_number: BTreeMap<u32, (Arc<str>, u8)>,
    /// Also by the normal form of a name that an earlier version stored otherwise.
    by_name: HashMap<Arc<str>, u32>,
    /// By hashes of its [`look_keys`], which in full would take as much room as everything else here.
    by_look: HashMap<u64, u32>,
    by_cell: HashMap<u8, HashSet<u32>>,
}

impl Table {
    /// Of the name as it is stored, letter for letter, or else of its normal form.
    pub fn number(&self, name: &str) -> Option<u32> {
        self.by_name.get(name).or_else(|| self.by_name.get(&*normal_form(name))).copied()
    }

    pub fn all(&self) -> impl Iterator<Item = &str> {
        self.by_number.values().map(|(name, _)| &**name)
    }

    /// A known name that looks like `name` and is another.
    pub fn look_alike(&self, name: &str) -> Option<&Arc<str>> {
        let keys = look_keys(name);
        let known = keys.iter().find_map(|key| self.by_look.get(&hash(key)))?;
        let looks_like = |known: &&Arc<str>| look_keys(known).iter().any(|key| keys.contains(key));
        self.name(*known).filter(|known| ***known != *name).filter(looks_like)
    }

    /// The name of a number that a row refers to; a number that was never given out has none.
    pub fn name(&self, number: u32) -> Option<&Arc<str>> {
        self.by_number.get(&number).map(|(name, _)| name)
    }

    /// Where a number is at home.
    pub fn cell(&self, number: u32) -> Option<u8> {
        self.by_number.get(&number).map(|(_, cell)| *cell)
    }

    /// Every name with its number, in the order of the numbers.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Arc<str>)> {
        self.by_number.iter().map(|(number, (name, _))| (*number, name))
    }

    pub fn numbers(&self) -> Vec<u32> {
        self.by_number.keys().copied().collect()
    }

    /// The greatest number.
    pub(crate) fn last_number(&self) -> u32 {
        self.by_number.last_key_value().map_or(0, |(number, _)| *number)
    }

    pub fn len(&self) -> usize {
        self.by_number.len()
    }

    pub fn is_empty(&self) -> bool {
        self.by_number.is_empty()
    }

    /// Adds a name with its number; false where either is another's already.
    pub(crate) fn add(&mut self, number: u32, cell: u8, name: &str) -> bool {
        if let Some(known) = self.name(number) {
            return **known == *name;
        }
        if self.by_name.get(name).is_some_and(|known| self.name(*known).is_some_and(|known| **known == *name)) {
            return false;
        }
        let name: Arc<str> = name.into();
        self.by_number.insert(number, (name.clone(), cell));
        self.by_cell.entry(cell).or_default().insert(number);
        if let Cow::Owned(normal) = normal_form(&name) {
            self.by_name.entry(normal.into()).or_insert(number);
        }
        look_keys(&name).iter().for_each(|key| _ = self.by_look.entry(hash(key)).or_insert(number));
        self.by_name.insert(name, number);
        true
    }

    fn remove(&mut self, number: u32) {
        let Some((name, cell)) = self.by_number.remove(&number) else { return };
        self.by_cell.entry(cell).or_default().remove(&number);
        self.by_name.retain(|_, known| *known != number);
        for key in look_keys(&name).iter().map(|key| hash(key)) {
            if self.by_look.get(&key) == Some(&number) {
                self.by_look.remove(&key);
            }
        }
    }
}

fn hash(key: &str) -> u64 {
    BuildHasherDefault::<DefaultHasher>::default().hash_one(key)
}

#[derive(Debug)]
pub struct Tables {
    pub imus: Table,
    pub stations: Table,
    pub gyros: Table,
    /// The commit of each cell up to which its names are known, of a database that others may write.
    pub(crate) seen: [i64; CELLS],
}

impl Default for Tables {
    fn default() -> Self {
        Self { imus: Table::default(), stations: Table::default(), gyros: Table::default(), seen: [0; CELLS] }
    }
}

impl Tables {
    pub fn of(&self, kind: NamesOf) -> &Table {
        match kind {
            NamesOf::Imus => &self.imus,
            NamesOf::Stations => &self.stations,
            NamesOf::Gyros => &self.gyros,
        }
    }

    fn of_mut(&mut self, kind: NamesOf) -> &mut Table {
        match kind {
            NamesOf::Imus => &mut self.imus,
            NamesOf::Stations => &mut self.stations,
            NamesOf::Gyros => &mut self.gyros,
        }
    }

    /// Takes over a stored name. One that had another number was lost with its commit, and has been stored anew.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] where the number is another name's.
    pub(crate) fn learn(&mut self, kind: NamesOf, number: u32, cell: u8, name: &str) -> Result<(), StoreError> {
        let table = self.of_mut(kind);
        let lost = table.by_name.get(name).copied().filter(|known| *known != number);
        if let Some(lost) = lost.filter(|lost| table.name(*lost).is_some_and(|known| **known == *name)) {
            table.remove(lost);
        }
        let wrong = || StoreError::Damaged(format!("`{name}` has more than one number"));
        table.add(number, cell, name).then_some(()).ok_or_else(wrong)
    }

    /// Of a cell there are these names and no others.
    pub(crate) fn forget_others(&mut self, cell: u8, there: HashSet<(NamesOf, u32)>) {
        for kind in NamesOf::ALL {
            let table = self.of_mut(kind);
            let known = table.by_cell.get(&cell).into_iter().flatten().copied();
            let gone: Vec<u32> = known.filter(|number| !there.contains(&(kind, *number))).collect();
            gone.into_iter().for_each(|number| table.remove(number));
        }
    }
}

/// The names of what is committed, shared by the writers and all readers.
#[derive(Debug, Clone, Default)]
pub struct Names(Arc<RwLock<Tables>>);

impl Names {
    pub(crate) fn new(tables: Tables) -> Self {
        Self(Arc::new(RwLock::new(tables)))
    }

    pub fn read(&self) -> RwLockReadGuard<'_, Tables> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn change<T>(&self, change: impl FnOnce(&mut Tables) -> T) -> T {
        change(&mut self.0.write().unwrap_or_else(PoisonError::into_inner))
    }

    /// Takes over what has been committed.
    pub(crate) fn learn(&self, new: [&[NewName]; 3]) {
        if new.iter().all(|names| names.is_empty()) {
            return;
        }
        self.change(|tables| {
            for (kind, new) in NamesOf::ALL.into_iter().zip(new) {
                for NewName { number, cell, name } in new {
                    let added = tables.of_mut(kind).add(*number, *cell, name);
                    debug_assert!(added, "{name} has another number already");
                }
            }
        });
    }
}
