//! IMUs, stations and gyros by number and by name, held in memory.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};

use hashbrown::HashTable;

use crate::core::name::{look_keys, normal_form};
use crate::store::cells::CELLS;
use crate::store::error::StoreError;
use crate::store::shared::Shared;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NamesOf {
    Imus,
    Stations,
    Gyros,
}

impl NamesOf {
    pub const ALL: [Self; 3] = [Self::Imus, Self::Stations, Self::Gyros];
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewName {
    pub number: u32,
    /// Where it is at home among other servers.
    pub cell: u8,
    pub name: String,
}

/// Places of names by hashes of texts.
#[derive(Debug, Default)]
struct Hashes(HashTable<(u32, u32)>);

impl Hashes {
    /// A place that was entered with `text` or one of the same hash, and is the right one.
    fn find(&self, text: &str, is_it: impl Fn(u32) -> bool) -> Option<u32> {
        let hash = hash(text);
        let found = self.0.find(spread(hash), |(known, place)| *known == hash && is_it(*place));
        found.map(|(_, place)| *place)
    }

    /// Places under the hash of `text`, in no order.
    fn each(&self, text: &str) -> impl Iterator<Item = u32> {
        let hash = hash(text);
        self.0.iter_hash(spread(hash)).filter(move |(known, _)| *known == hash).map(|(_, place)| *place)
    }

    fn enter(&mut self, text: &str, place: u32) {
        let hash = hash(text);
        self.0.insert_unique(spread(hash), (hash, place), |(hash, _)| spread(*hash));
    }

    fn remove(&mut self, text: &str, place: u32) {
        let entry = (hash(text), place);
        if let Ok(found) = self.0.find_entry(spread(entry.0), |known| *known == entry) {
            found.remove();
        }
    }
}

fn hash(text: &str) -> u32 {
    BuildHasherDefault::<DefaultHasher>::default().hash_one(text) as u32
}

/// The table looks at the first bits and at the last.
fn spread(hash: u32) -> u64 {
    u64::from(hash).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

/// Where the letters of a name are among those of all.
#[derive(Debug, Clone, Copy)]
struct Entry {
    number: u32,
    start: u32,
    bytes: u16,
    cell: u8,
}

/// Names of one kind.
#[derive(Debug, Default)]
pub struct Table {
    /// Of all names one after the other. One that was removed leaves its own behind.
    letters: String,
    entries: Vec<Entry>,
    /// Places among the entries, by number.
    by_number: HashTable<u32>,
    /// Also by the normal form of a name that an earlier version stored otherwise.
    by_name: Hashes,
    /// By its [`look_keys`].
    by_look: Hashes,
    /// Names that look like one that was known before.
    alike: Vec<u32>,
    /// Each number once.
    by_cell: HashMap<u8, Vec<u32>>,
    last_number: u32,
}

impl Table {
    fn place(&self, number: u32) -> Option<u32> {
        self.by_number.find(spread(number), |place| self.entry(*place).number == number).copied()
    }

    fn entry(&self, place: u32) -> Entry {
        self.entries[place as usize]
    }

    fn at(&self, place: u32) -> &str {
        let Entry { start, bytes, .. } = self.entry(place);
        &self.letters[start as usize..start as usize + usize::from(bytes)]
    }

    /// Of the name as it is stored, letter for letter, or else of its normal form.
    pub fn number(&self, name: &str) -> Option<u32> {
        let normal = normal_form(name);
        let has_form = |place| normal_form(self.at(place)) == normal;
        let place = self
            .stored_as(name)
            .or_else(|| self.stored_as(&normal))
            .or_else(|| self.by_name.find(&normal, has_form))?;
        Some(self.entry(place).number)
    }

    fn stored_as(&self, name: &str) -> Option<u32> {
        self.by_name.find(name, |place| self.at(place) == name)
    }

    /// The known name that looks like `name` and is another; of several the one that was known first.
    pub fn look_alike(&self, name: &str) -> Option<&str> {
        let keys = look_keys(name);
        let looks_like = |place: &u32| {
            let known = self.at(*place);
            known != name && look_keys(known).iter().any(|key| keys.contains(key))
        };
        let alike = keys.iter().flat_map(|key| self.by_look.each(key)).filter(looks_like);
        alike.min().map(|place| self.at(place))
    }

    /// Numbers of names that looked like one that was known before; the newest last.
    pub fn alike(&self) -> &[u32] {
        &self.alike
    }

    /// The name of a number that a row refers to; a number that was never given out has none.
    pub fn name(&self, number: u32) -> Option<&str> {
        self.place(number).map(|place| self.at(place))
    }

    /// The name of a number; empty where it was never given out.
    pub fn text(&self, number: u32) -> &str {
        self.name(number).unwrap_or_default()
    }

    /// Where a number is at home.
    pub fn cell(&self, number: u32) -> Option<u8> {
        self.place(number).map(|place| self.entry(place).cell)
    }

    /// Every name, in no order.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        self.by_number.iter().map(|place| self.at(*place))
    }

    /// In ascending order.
    pub fn numbers(&self) -> Vec<u32> {
        let mut numbers: Vec<u32> = self.by_number.iter().map(|place| self.entry(*place).number).collect();
        numbers.sort_unstable();
        numbers
    }

    /// The greatest number that was ever given out.
    pub(crate) fn last_number(&self) -> u32 {
        self.last_number
    }

    pub fn len(&self) -> usize {
        self.by_number.len()
    }

    pub fn is_empty(&self) -> bool {
        self.by_number.is_empty()
    }

    /// Adds a name with its number; false where either is another's already, or there is no room for it.
    pub fn add(&mut self, number: u32, cell: u8, name: &str) -> bool {
        if let Some(known) = self.name(number) {
            return known == name;
        }
        if self.stored_as(name).is_some() {
            return false;
        }
        let (Ok(start), Ok(bytes)) = (u32::try_from(self.letters.len()), u16::try_from(name.len())) else {
            return false;
        };
        if self.look_alike(name).is_some() {
            self.alike.push(number);
        }
        let place = self.entries.len() as u32;
        self.letters.push_str(name);
        self.entries.push(Entry { number, start, bytes, cell });
        let entries = &self.entries;
        self.by_number.insert_unique(spread(number), place, |place| spread(entries[*place as usize].number));
        if let Cow::Owned(normal) = normal_form(name) {
            self.by_name.enter(&normal, place);
        }
        look_keys(name).iter().for_each(|key| self.by_look.enter(key, place));
        self.by_name.enter(name, place);
        self.by_cell.entry(cell).or_default().push(number);
        self.last_number = self.last_number.max(number);
        true
    }

    fn remove(&mut self, number: u32) {
        let entries = &self.entries;
        let Ok(found) = self.by_number.find_entry(spread(number), |place| entries[*place as usize].number == number)
        else {
            return;
        };
        let (place, _) = found.remove();
        let name = self.at(place).to_owned();
        let cell = self.entry(place).cell;
        self.by_cell.entry(cell).or_default().retain(|other| *other != number);
        if let Cow::Owned(normal) = normal_form(&name) {
            self.by_name.remove(&normal, place);
        }
        look_keys(&name).iter().for_each(|key| self.by_look.remove(key, place));
        self.alike.retain(|other| *other != number);
        self.by_name.remove(&name, place);
    }
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

    pub fn of_mut(&mut self, kind: NamesOf) -> &mut Table {
        match kind {
            NamesOf::Imus => &mut self.imus,
            NamesOf::Stations => &mut self.stations,
            NamesOf::Gyros => &mut self.gyros,
        }
    }

    /// Takes over what has been committed.
    pub(crate) fn enter(&mut self, new: [&[NewName]; 3]) {
        for (kind, new) in NamesOf::ALL.into_iter().zip(new) {
            for NewName { number, cell, name } in new {
                let added = self.of_mut(kind).add(*number, *cell, name);
                debug_assert!(added, "{name} has another number already");
            }
        }
    }

    /// Takes over a stored name. One that had another number was lost with its commit, and has been stored anew.
    pub(crate) fn learn(&mut self, kind: NamesOf, number: u32, cell: u8, name: &str) -> Result<(), StoreError> {
        let table = self.of_mut(kind);
        let lost = table.stored_as(name).map(|place| table.entry(place).number);
        if let Some(lost) = lost.filter(|known| *known != number) {
            table.remove(lost);
        }
        let wrong = || StoreError::damaged(format_args!("`{name}` has more than one number"));
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
pub type Names = Shared<Tables>;

#[cfg(test)]
mod tests {
    use super::*;

    /// Two names whose hashes are the same.
    fn twins() -> [String; 2] {
        let mut seen = HashMap::new();
        (0..)
            .map(|k| format!("IMU-{k}"))
            .find_map(|name| Some([seen.insert(hash(&name), name.clone())?, name]))
            .unwrap()
    }

    #[test]
    fn names_of_one_hash_are_two_names() {
        let ([one, other], mut table) = (twins(), Table::default());
        assert!(table.add(7, 0, &one));
        assert_eq!((table.number(&one), table.number(&other)), (Some(7), None));
        assert!(table.add(8, 0, &other));
        assert!(!table.add(9, 0, &one) && !table.add(7, 0, &other), "a name or a number is another's");
        table.remove(7);
        assert_eq!((table.number(&one), table.number(&other)), (None, Some(8)));
    }

    #[test]
    fn a_name_is_found_by_its_normal_form_and_by_its_looks() {
        let mut table = Table::default();
        // As an earlier version stored it: e and an accent.
        assert!(table.add(1, 0, "Le\u{301}on"));
        assert_eq!((table.number("Le\u{301}on"), table.number("L\u{e9}on")), (Some(1), Some(1)));
        assert!(table.add(2, 0, "IMU-O1"));
        assert_eq!(table.look_alike("IMU-01"), Some("IMU-O1"));
        assert_eq!(table.look_alike("IMU-O1"), None);
        assert!(table.add(3, 0, "IMU01"));
        assert_eq!((table.alike(), table.look_alike("IMU01")), (&[3][..], Some("IMU-O1")));
        table.remove(3);
        table.remove(2);
        assert_eq!((table.alike(), table.look_alike("IMU-01")), (&[][..], None));
    }
}
