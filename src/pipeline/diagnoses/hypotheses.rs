//! Hypotheses of one's own that compete in every diagnosis of the service.

use crate::core::diagnose::METHOD;
use crate::core::effects::Effect;
use crate::core::fault::Faults;
use crate::pipeline::prelude::*;
use crate::store::HypothesisRow;
use crate::wire::hypothesis::HypothesisBody;

/// One that competes.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredHypothesis {
    pub effect: Effect,
    pub row: HypothesisRow,
}

/// Which program a kept diagnosis is of, without hypotheses of one's own.
fn program() -> String {
    format!("{}, method {METHOD}", env!("CARGO_PKG_VERSION"))
}

/// Those that compete, and the program that makes diagnoses with them.
#[derive(Debug, Clone)]
pub(crate) struct Competing {
    pub hypotheses: Vec<StoredHypothesis>,
    pub program: String,
}

impl Default for Competing {
    fn default() -> Self {
        Self { hypotheses: Vec::new(), program: program() }
    }
}

impl Competing {
    pub async fn read(store: &Store) -> Result<Self, StoreError> {
        let rows = store::hypothesis::in_force(store).await?;
        let mut hasher = crc32fast::Hasher::new();
        rows.iter().for_each(|row| hasher.update(row.body.as_bytes()));
        let program =
            if rows.is_empty() { program() } else { format!("{}, hypotheses {:08x}", program(), hasher.finalize()) };
        Ok(Self { hypotheses: rows.into_iter().map(stored).collect::<Result<_, _>>()?, program })
    }

    pub fn effects(&self) -> impl Iterator<Item = Effect> {
        self.hypotheses.iter().map(|stored| stored.effect)
    }
}

/// As it is used.
fn stored(row: HypothesisRow) -> Result<StoredHypothesis, StoreError> {
    let damaged = |why: &dyn std::fmt::Display| StoreError::damaged(format_args!("hypothesis {}: {why}", row.id));
    let body: HypothesisBody = serde_json::from_str(&row.body).map_err(|error| damaged(&error))?;
    let effect = body.to_core().map_err(|faults: Faults| damaged(&faults))?;
    Ok(StoredHypothesis { effect, row })
}
