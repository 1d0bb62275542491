//! IMUs, stations and gyros by number and by name, held in memory.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard};

use crate::core::name::{look_keys, normal_form};
use crate::store::cells::{CELLS, cell_of};
use crate::store::commit::Changes;
use crate::store::error::StoreError;
use crate::store::open::{Place, Store};
use crate::store::postgres;

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
    pub(crate) fn learn(&self, changes: &Changes) {
        if [changes.imus.len(), changes.stations.len(), changes.gyros.len()] == [0; 3] {
            return;
        }
        self.change(|tables| {
            for (kind, new) in NamesOf::ALL.into_iter().zip([&changes.imus, &changes.stations, &changes.gyros]) {
                for NewName { number, cell, name } in new {
                    let added = tables.of_mut(kind).add(*number, *cell, name);
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

/// Has names that only other servers may know looked up.
///
/// # Errors
/// [`StoreError`].
pub async fn look_up(store: &Store, names: [Vec<&str>; 3]) -> Result<(), StoreError> {
    if matches!(store.place, Place::File(_)) {
        return Ok(());
    }
    let unknown = {
        let tables = store.names.read();
        let mut kinds = NamesOf::ALL.into_iter();
        names.map(|names| {
            let table = tables.of(kinds.next().expect("there are three kinds"));
            let unknown: HashSet<&str> = names.into_iter().filter(|name| table.number(name).is_none()).collect();
            unknown.into_iter().map(str::to_owned).collect::<Vec<_>>()
        })
    };
    postgres::names::look_up(store, unknown).await
}

/// As [`look_up`], of numbers of gyros.
///
/// # Errors
/// [`StoreError`].
pub async fn look_up_gyros(store: &Store, gyros: Vec<u32>) -> Result<(), StoreError> {
    postgres::names::look_up_numbers(store, [Vec::new(), Vec::new(), gyros]).await
}

/// Where an IMU is at home, known or not.
pub fn cell_of_imu(store: &Store, imu: &str) -> u8 {
    let tables = store.names.read();
    tables.imus.number(imu).and_then(|number| tables.imus.cell(number)).unwrap_or_else(|| cell_of(imu))
}

/// Where a gyro is at home, known or not; an IMU that brings a new one takes it into its own cell.
pub fn cell_of_gyro(store: &Store, serial: &str) -> u8 {
    let tables = store.names.read();
    tables.gyros.number(serial).and_then(|number| tables.gyros.cell(number)).unwrap_or_else(|| cell_of(serial))
}
