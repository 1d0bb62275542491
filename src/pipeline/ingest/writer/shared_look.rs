//! The clock's look at what gyros share, beside the writer.

use super::shared_shifts::SharedShifts;
use crate::pipeline::alerts::{AlertCache, Naming, SharedVerdict};
use crate::pipeline::prelude::*;
use crate::store::AlertRow;

/// What gyros share is looked at again after so many days, though nothing was written: an hour.
const LOOKED_AGAIN: f64 = 1.0 / 24.0;

/// A look at what gyros share, beside the writer: of a large fleet it takes a second, for which nobody is to wait.
pub(super) struct SharedLook {
    pub store: Store,
    pub config: Arc<Config>,
    pub now: UtcMicros,
    /// As the look before it found.
    pub nothing: Option<NothingShared>,
}

/// Since when nothing new is found that gyros share, and by which heads.
pub(super) type NothingShared = (UtcMicros, [i64; 2]);

impl SharedLook {
    /// None where an alert has to follow what it has found. Where nothing is written of gyros, time alone changes what
    /// they share, slowly: by what is no longer recent.
    pub async fn nothing(self) -> Result<Option<NothingShared>, StoreError> {
        let Self { store, config, now, nothing } = self;
        let version = store::head::version(&store).await?;
        let is_known = |(since, of): &NothingShared| *of == version && now.days_since(*since).abs() < LOOKED_AGAIN;
        if let Some(nothing) = nothing.filter(is_known) {
            return Ok(Some(nothing));
        }
        let mut alerts = AlertCache::new(config.alerts.policy(), config.judging.confidence);
        let (found, rows) = shared_and_explicable(&store, &config, &mut alerts, now).await?;
        let tables = store.names().read();
        let naming = Naming { tables: &tables, new: None };
        let shared = alerts.shared();
        let is_anything = shared.not_judged(&found).next().is_some()
            || found.iter().any(|one| shared.is_moved_by(one, &naming))
            || !shared.explained_anew(&rows, &naming).is_empty();
        Ok((!is_anything).then_some((now, version)))
    }
}

/// What is shared, and the alerts of gyros that it explains, or did.
pub(super) async fn shared_and_explicable(
    store: &Store,
    config: &Config,
    alerts: &mut AlertCache,
    now: UtcMicros,
) -> Result<(Vec<SharedVerdict>, Vec<AlertRow>), StoreError> {
    alerts.recall(store, [], now).await?;
    let excesses = store::alerts::excesses(store).await?;
    let found = SharedShifts { store, config, alerts, now }.all(&excesses).await?;
    alerts.learn_mates(&found);
    let (subjects, gyros) = alerts.shared().that_explain(&found);
    let rows = store::alerts::explicable(store, &subjects, &gyros).await?;
    Ok((found, rows))
}
