//! Which hooks are to be told of an alert. The writer keeps them in memory: it alone changes them.

use super::show;
use crate::store::{Id, Store, StoreError};
use crate::wire::alert::AlertBody;
use crate::wire::hook::FilterBody;

/// The enabled hooks and what each wants to hear.
#[derive(Debug, Default)]
pub(in crate::pipeline) struct HookBook(Vec<(Id, FilterBody)>);

impl HookBook {
    pub async fn load(store: &Store) -> Result<Self, StoreError> {
        let enabled = store.hooks().await?.into_iter().filter(|hook| hook.enabled);
        enabled.map(|hook| Ok((hook.id, show::filter(&hook)?))).collect::<Result<_, _>>().map(Self)
    }

    /// The hooks that are told of an alert, oldest first.
    pub fn wanting(&self, alert: &AlertBody) -> impl Iterator<Item = Id> {
        self.0.iter().filter(|(_, filter)| filter.wants(alert)).map(|(hook, _)| *hook)
    }
}
