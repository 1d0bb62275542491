//! Hooks: whom to tell.

use super::*;
use crate::core::judge::Severity;
use crate::store::Secrets;

/// A hook. Its secrets are for signing and sending only; what shows hooks leaves them out, and so does `Debug`.
#[derive(Clone, PartialEq, Eq)]
pub struct HookRow {
    pub id: Id,
    pub name: String,
    pub kind: String,
    pub url: String,
    pub authorization: Option<String>,
    pub secret: Option<String>,
    /// The secret before, and until when it signs as well.
    pub old_secret: Option<(String, UtcMicros)>,
    /// JSON.
    pub filter: String,
    /// One message for all that a record changes.
    pub batch: bool,
    /// What an answer is to say, JSON; none where its status is enough.
    pub expect: Option<String>,
    pub enabled: bool,
    pub disabled_because: Option<String>,
    pub created_at: UtcMicros,
    pub changed_at: UtcMicros,
    pub deleted_at: Option<UtcMicros>,
}

impl std::fmt::Debug for HookRow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // The address too may hold a token.
        f.debug_struct("HookRow").field("id", &self.id).field("kind", &self.kind).finish_non_exhaustive()
    }
}

impl HookRow {
    /// What is secret of it, each text with where it stands.
    pub(in crate::store) fn secret_texts(&mut self) -> impl Iterator<Item = (String, &mut String)> {
        let Self { id, url, authorization, secret, old_secret, .. } = self;
        let id: Id = *id;
        let old_secret = old_secret.as_mut().map(|(secret, _)| secret);
        // What replaces a secret makes it the old one as it is.
        let texts = [
            ("url", Some(url)),
            ("authorization", authorization.as_mut()),
            ("secret", secret.as_mut()),
            ("secret", old_secret),
        ];
        texts.into_iter().filter_map(move |(column, text)| Some((format!("hook {id} {column}"), text?)))
    }

    /// Encrypts its secrets as far as they are not; says whether there was anything to do.
    pub(in crate::store) fn hide(&mut self, secrets: &Secrets) -> Result<bool> {
        secrets.hide(self.secret_texts())
    }

    /// Decrypts its secrets.
    pub(in crate::store) fn show(&mut self, secrets: &Secrets) -> Result<()> {
        secrets.show(&format!("hook {} ({})", self.id, self.name), self.secret_texts())
    }
}

columns! {
    HookRow in "hook" {
        id, name, kind, url, authorization: ["\"authorization\""], secret, old_secret: ["old_secret", "old_secret_until"],
        filter, enabled, disabled_because, created_at, changed_at, deleted_at, batch, expect,
    }
}

/// The secret before, and until when it signs.
impl Part for Option<(String, UtcMicros)> {
    fn put(&self, row: &mut Row<'_>) {
        let (secret, until) = self.clone().unzip();
        row.put(&secret).put(&until);
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        let (secret, until): (Option<_>, Option<_>) = found.part()?;
        Ok(secret.zip(until))
    }
}

/// Encrypts the secrets of hooks that are to be written, where there is a key.
pub fn hide(store: &Store, hooks: &mut [HookRow]) -> Result<()> {
    hooks.iter_mut().try_for_each(|hook| hook.hide(&store.secrets).map(|_| ()))
}

/// Every hook as it is stored, deleted ones too: its secrets may be encrypted.
pub(in crate::store) async fn stored(store: &Store) -> Result<Vec<HookRow>> {
    read!(store, all, HookRow::select("ORDER BY id"))
}

/// Every hook that was not deleted, oldest first.
pub async fn all(store: &Store) -> Result<Vec<HookRow>> {
    let mut hooks: Vec<HookRow> = read!(store, all, HookRow::select("WHERE deleted_at IS NULL ORDER BY id"))?;
    hooks.iter_mut().try_for_each(|hook| hook.show(&store.secrets))?;
    Ok(hooks)
}

/// A hook, unless it was deleted.
pub async fn get(store: &Store, id: Id) -> Result<Option<HookRow>> {
    let sql = HookRow::select("WHERE id = $1 AND deleted_at IS NULL");
    let mut hook: Option<HookRow> = read!(store, first, sql, id)?;
    hook.iter_mut().try_for_each(|hook| hook.show(&store.secrets))?;
    Ok(hook)
}

/// The hooks that the service itself has disabled, oldest first: which, its name, and why.
pub async fn disabled(store: &Store) -> Result<Vec<(Id, String, String)>> {
    let sql = "SELECT id, name, disabled_because FROM hook
               WHERE deleted_at IS NULL AND enabled = 0 AND disabled_because IS NOT NULL ORDER BY id";
    read!(store, all, sql)
}

/// What hooks have heard last of these alerts, where that is that they fire: hook, alert, severity.
pub async fn heard_of(store: &Store, alerts: &[Id]) -> Result<Vec<(Id, Id, String)>> {
    let those = store.readers.list("$1");
    let sql = AssertSqlSafe(format!("SELECT hook, alert, severity FROM hook_heard WHERE alert IN {those}"));
    read!(store, all, sql, alerts)
}

/// What a hook has heard last of the alerts that fire, to its knowledge.
pub async fn heard_by(store: &Store, hook: Id) -> Result<HashMap<Id, Severity>> {
    let sql = "SELECT alert, severity FROM hook_heard WHERE hook = $1";
    let heard: Vec<(Id, Severity)> = read!(store, all, sql, hook)?;
    Ok(heard.into_iter().collect())
}

/// Alerts of which the message that a hook was to take is a dead letter.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct DeadLetters {
    /// That they fire, and it has taken nothing else that says so.
    pub fires: HashSet<Id>,
    /// That they are resolved, and the last that it has taken is that they fire.
    pub ends: HashSet<Id>,
}

pub async fn dead_letters(store: &Store, hook: Id) -> Result<DeadLetters> {
    let sql = "SELECT coalesce(d.alert, p.alert), coalesce(p.action, d.action, s.action), d.id
               FROM delivery AS d LEFT JOIN alert_step AS s ON s.id = d.step LEFT JOIN delivery_part AS p ON p.delivery = d.id
               WHERE d.hook = $1 AND d.state = 'dead' AND coalesce(d.alert, p.alert) IS NOT NULL
                   AND coalesce(p.action, d.action, s.action) IN ('fire', 'resolve')";
    let dead: Vec<(Id, String, Id)> = read!(store, all, sql, hook)?;
    if dead.is_empty() {
        return Ok(DeadLetters::default());
    }
    let taken = delivered_firing(store, hook).await?;
    let (mut fires, mut ends): (HashSet<Id>, HashSet<Id>) = (HashSet::new(), HashSet::new());
    for (alert, action, delivery) in dead {
        match (action.as_str(), taken.get(&alert)) {
            ("fire", None) => _ = fires.insert(alert),
            // It may have begun again since, and the hook have taken that.
            ("resolve", Some(last)) if delivery > *last => _ = ends.insert(alert),
            _ => {}
        }
    }
    Ok(DeadLetters { fires, ends })
}

/// The alerts that an open delivery of a hook tells of.
pub async fn waiting_alerts(store: &Store, hook: Id) -> Result<HashSet<Id>> {
    let sql = "SELECT coalesce(d.alert, p.alert) FROM delivery AS d LEFT JOIN delivery_part AS p ON p.delivery = d.id
               WHERE d.hook = $1 AND d.state IN ('behind', 'waiting') AND coalesce(d.alert, p.alert) IS NOT NULL";
    let alerts: Vec<Id> = read!(store, all, sql, hook)?;
    Ok(alerts.into_iter().collect())
}

/// The alerts of which the last message that a hook took was not that they are resolved, with that message.
pub async fn delivered_firing(store: &Store, hook: Id) -> Result<BTreeMap<Id, Id>> {
    let sql = "SELECT told.alert, told.action, told.id
               FROM (SELECT d.alert AS alert, coalesce(d.action, s.action) AS action, d.id AS id
                     FROM delivery AS d LEFT JOIN alert_step AS s ON s.id = d.step
                     WHERE d.hook = $1 AND d.state = 'delivered' AND d.alert IS NOT NULL
                     UNION ALL
                     SELECT p.alert, p.action, p.delivery FROM delivery_part AS p JOIN delivery AS d ON d.id = p.delivery
                     WHERE p.hook = $1 AND d.state = 'delivered') AS told
               ORDER BY told.id";
    let told: Vec<(Id, Option<String>, Id)> = read!(store, all, sql, hook)?;
    let last: BTreeMap<Id, (Option<String>, Id)> =
        told.into_iter().map(|(alert, action, id)| (alert, (action, id))).collect();
    let fires = last.into_iter().filter(|(_, (action, _))| action.as_deref() != Some("resolve"));
    Ok(fires.map(|(alert, (_, id))| (alert, id)).collect())
}
