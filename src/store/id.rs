//! Hands out identifiers.

use crate::core::id::Id;
use crate::core::time::UtcMicros;

/// Of the 63 bits of an identifier, those that keep items of one millisecond apart.
const SEQUENCE_BITS: u32 = 21;
/// Of these, those that keep items of one cell apart. The others are the cell, so that writers who hold different
/// cells never give out the same.
const CELL_SHIFT: u32 = 13;

/// Hands out identifiers. They ascend whatever the clock does.
#[derive(Debug)]
pub struct IdSource {
    last: i64,
    /// Whoever holds it gives out identifiers of it; none where nobody else gives out any.
    cell: Option<u8>,
}

impl IdSource {
    /// Continues after the greatest identifier in the database.
    pub fn after(last: i64) -> Self {
        Self { last, cell: None }
    }

    /// Continues after the greatest of the cells that are held, of which `cell` is one.
    pub(super) fn in_cell(cell: u8, last: i64) -> Self {
        Self { last, cell: Some(cell) }
    }

    pub(super) fn last(&self) -> i64 {
        self.last
    }

    pub fn next(&mut self, now: UtcMicros) -> Id {
        let from_clock = now.0.max(0) / 1000;
        let first_of = |ms: i64| ms << SEQUENCE_BITS | self.cell.map_or(0, |cell| i64::from(cell) << CELL_SHIFT);
        let after_last = match self.cell {
            None => self.last + 1,
            Some(_) if (self.last + 1) >> CELL_SHIFT == first_of(self.last >> SEQUENCE_BITS) >> CELL_SHIFT => {
                self.last + 1
            }
            Some(_) => first_of((self.last >> SEQUENCE_BITS) + 1),
        };
        self.last = first_of(from_clock).max(after_last);
        Id(self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_ascend_while_the_clock_stands_or_goes_back() {
        let mut source = IdSource::after(0);
        let day = UtcMicros(UtcMicros::DAY * 20_000);
        let ids = [day, day, UtcMicros(0), UtcMicros(day.0 + 1000)].map(|now| source.next(now));
        assert!(ids.is_sorted_by(|a, b| a < b), "{ids:?}");
        assert_eq!(ids[0].0 >> SEQUENCE_BITS, day.0 / 1000);
    }

    #[test]
    fn writers_of_different_cells_never_give_out_the_same() {
        let day = UtcMicros(UtcMicros::DAY * 20_000);
        let mut given = std::collections::HashSet::new();
        for cell in [0, 1, 255] {
            let mut source = IdSource::in_cell(cell, (day.0 / 1000) << SEQUENCE_BITS);
            let ids: Vec<Id> = (0..20_000).map(|_| source.next(day)).collect();
            assert!(ids.is_sorted_by(|a, b| a < b));
            assert!(ids.iter().all(|id| (id.0 >> CELL_SHIFT) & 0xff == i64::from(cell) && given.insert(*id)));
        }
    }
}
