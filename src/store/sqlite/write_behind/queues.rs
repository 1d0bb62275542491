//! Rows that wait in memory until those of one gyro or IMU can be put into their places together: a page is then
//! written once for all of them.

use std::collections::{BTreeSet, HashMap};

/// Rows that may wait: enough that a page of a gyro takes several of them at a time, in a fleet of thousands too.
const CAPACITY: usize = 16_384;
/// Rows of one gyro or IMU that are put into their places though there is room: more would take a commit longer than
/// a millisecond or two.
const MANY: usize = 512;
/// Rows that may come after one that waits: a start reads all of them again.
pub(crate) const LATER: u64 = 4 * CAPACITY as u64;

/// Rows that wait, by the number of their gyro or IMU.
#[derive(Debug)]
pub(crate) struct PendingRows<T> {
    queues: HashMap<u32, Queue<T>>,
    /// How many rows had come before the first of a queue, and the queue's number.
    by_age: BTreeSet<(u64, u32)>,
    /// Queues of [`MANY`] rows.
    with_many: BTreeSet<u32>,
    len: usize,
    /// Rows that have ever come.
    come: u64,
}

#[derive(Debug)]
struct Queue<T> {
    since: u64,
    /// Where its first row stands in the order in which rows came.
    place: i64,
    rows: Vec<T>,
}

impl<T> Default for PendingRows<T> {
    fn default() -> Self {
        Self { queues: HashMap::new(), by_age: BTreeSet::new(), with_many: BTreeSet::new(), len: 0, come: 0 }
    }
}

impl<T> PendingRows<T> {
    pub fn of(&self, number: u32) -> &[T] {
        self.queues.get(&number).map_or(&[], |queue| &queue.rows)
    }

    /// Every queue; none is empty.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[T])> {
        self.queues.iter().map(|(number, queue)| (*number, &*queue.rows))
    }

    /// The queues that are to be emptied so that `incoming` more rows find room, and none waits for too long.
    pub fn due(&self, incoming: usize) -> BTreeSet<u32> {
        let excess = (self.len + incoming).saturating_sub(CAPACITY);
        let mut due = self.with_many.clone();
        let mut taken: usize = due.iter().map(|number| self.of(*number).len()).sum();
        for (since, number) in &self.by_age {
            if taken >= excess && self.come - since <= LATER {
                break;
            }
            if due.insert(*number) {
                taken += self.of(*number).len();
            }
        }
        due
    }

    /// Where the first row stands that still waits once the queues in `gone` are empty.
    pub fn first_without(&self, gone: &BTreeSet<u32>) -> Option<i64> {
        let (_, oldest) = self.by_age.iter().find(|(_, number)| !gone.contains(number))?;
        Some(self.queues[oldest].place)
    }

    /// Lets `enter` put one row into a queue.
    pub fn enter(&mut self, place: i64, number: u32, enter: impl FnOnce(&mut Vec<T>)) {
        let queue = self.queues.entry(number).or_insert_with(|| {
            self.by_age.insert((self.come, number));
            Queue { since: self.come, place, rows: Vec::new() }
        });
        let before = queue.rows.len();
        enter(&mut queue.rows);
        self.come += 1;
        self.len += queue.rows.len() - before;
        if queue.rows.len() == MANY {
            self.with_many.insert(number);
        }
    }

    /// Counts rows that came without waiting: those that wait grow older by them, too.
    pub fn pass(&mut self, rows: usize) {
        self.come += rows as u64;
    }

    /// Empties a queue.
    pub fn remove(&mut self, number: u32) {
        if let Some(queue) = self.queues.remove(&number) {
            self.by_age.remove(&(queue.since, number));
            self.with_many.remove(&number);
            self.len -= queue.rows.len();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn enter(waiting: &mut PendingRows<i64>, place: i64, number: u32) {
        waiting.enter(place, number, |rows| rows.push(place));
    }

    /// Lets rows of `number` come, each in a commit of its own, and says how many it took until `awaited` was due.
    fn commits_until(waiting: &mut PendingRows<i64>, number: u32, awaited: u32) -> i64 {
        for place in 1..2 * LATER as i64 {
            let due = waiting.due(1);
            due.iter().for_each(|number| waiting.remove(*number));
            if due.contains(&awaited) {
                return place;
            }
            enter(waiting, place, number);
        }
        panic!("{awaited} is never due")
    }

    #[test]
    fn a_queue_to_which_nothing_comes_is_emptied_in_the_end() {
        let mut waiting = PendingRows::default();
        enter(&mut waiting, 0, 1);
        assert_eq!(waiting.first_without(&BTreeSet::new()), Some(0));
        let commits = commits_until(&mut waiting, 2, 1);
        assert!((LATER as i64..LATER as i64 + 10).contains(&commits), "{commits} commits");
        assert!(waiting.of(1).is_empty());
        let first = waiting.first_without(&BTreeSet::new());
        assert!(first.is_none_or(|first| first > LATER as i64 - MANY as i64), "{first:?}");
    }

    #[test]
    fn rows_that_come_without_waiting_let_a_queue_grow_old_too() {
        let mut waiting = PendingRows::default();
        enter(&mut waiting, 0, 1);
        waiting.pass(LATER as usize - 1);
        assert_eq!(waiting.due(0), BTreeSet::new());
        waiting.pass(1);
        assert_eq!(waiting.due(0), BTreeSet::from([1]));
    }

    #[test]
    fn no_more_rows_wait_than_there_is_room_for_and_the_oldest_go_first() {
        let mut waiting = PendingRows::default();
        for place in 0..CAPACITY as i64 {
            enter(&mut waiting, place, place as u32 / 4);
        }
        assert_eq!(waiting.due(0), BTreeSet::new());
        assert_eq!(waiting.due(1), BTreeSet::from([0]));
        assert_eq!(waiting.due(9), BTreeSet::from([0, 1, 2]));
        assert_eq!(waiting.first_without(&BTreeSet::from([0, 1, 5])), Some(8));
        assert_eq!(waiting.first_without(&(0..CAPACITY as u32).collect()), None);
    }

    #[test]
    fn a_queue_with_many_rows_is_emptied_though_there_is_room() {
        let mut waiting = PendingRows::default();
        enter(&mut waiting, 0, 1);
        assert_eq!(commits_until(&mut waiting, 2, 2), MANY as i64 + 1);
        assert_eq!(waiting.due(1), BTreeSet::new());
    }
}
