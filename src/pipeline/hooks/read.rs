//! What clients say of hooks, checked: whatever can be refused is refused here, by the caller's task.

use crate::alert::HookKind;
use crate::alert::mail::recipients;
use crate::alert::sign::Secret;
use crate::alert::target::TargetPolicy;
use crate::core::fault::Faults;
use crate::core::message::{list, sent, text};
use crate::core::record::Name;
use crate::message;
use crate::wire::hook::{HookPatchBody, NewHookBody};

/// Longest `Authorization` header.
const MAX_AUTHORIZATION: usize = 4096;

/// A hook that can be set up.
#[derive(Debug)]
pub struct NewHook {
    /// Without the secret that it gives.
    pub(super) body: NewHookBody,
    pub(super) kind: HookKind,
    pub(super) secret: Option<Secret>,
    drawn: bool,
}

/// Changes of a hook that can be made, but for a kind that does not allow them.
#[derive(Debug)]
pub struct HookPatch {
    /// Without the secret that it gives.
    pub(super) body: HookPatchBody,
    pub(super) secret: Option<Option<Secret>>,
}

impl NewHook {
    /// The secret, where the service has drawn it.
    pub fn drawn(&self) -> Option<Secret> {
        self.secret.clone().filter(|_| self.drawn)
    }
}

impl HookPatch {
    /// The new secret, where the service has drawn it.
    pub fn drawn(&self) -> Option<Secret> {
        self.secret.clone().flatten().filter(|_| self.body.rotate_secret)
    }
}

/// `has_mail`: the configuration names a mail server.
pub(super) fn new_hook(mut body: NewHookBody, policy: &TargetPolicy, has_mail: bool) -> Result<NewHook, Faults> {
    let mut faults = Faults::default();
    let kind = HookKind::from_name(&body.kind);
    if kind.is_none() {
        let kinds = list(HookKind::ALL.map(HookKind::name));
        faults.push("/kind", message!("must_be_one_of", known = kinds, value = sent(&body.kind)));
    }
    let kind = kind.unwrap_or(HookKind::StandardWebhooks);
    check_name(body.name.as_deref(), &mut faults);
    check_target(kind, &body.url, policy, has_mail, &mut faults);
    check_authorization(body.authorization.as_deref(), &mut faults);
    body.filter.check("/filter", &mut faults);
    if let Some(expect) = &body.expect {
        expect.check("/expect", &mut faults);
    }
    let given = body.secret.take();
    let drawn = given.is_none() && kind == HookKind::StandardWebhooks;
    let secret = if drawn { draw("/secret", &mut faults) } else { secret(given.as_deref(), &mut faults) };
    faults.or(NewHook { body, kind, secret, drawn })
}

pub(super) fn patch(mut body: HookPatchBody, policy: &TargetPolicy, has_mail: bool) -> Result<HookPatch, Faults> {
    let mut faults = Faults::default();
    check_name(body.name.as_deref(), &mut faults);
    if let Some(url) = &body.url {
        let kind = if url.starts_with("mailto:") { HookKind::Email } else { HookKind::StandardWebhooks };
        check_target(kind, url, policy, has_mail, &mut faults);
    }
    check_authorization(body.authorization.as_ref().and_then(Option::as_deref), &mut faults);
    if let Some(filter) = &body.filter {
        filter.check("/filter", &mut faults);
    }
    if let Some(Some(expect)) = &body.expect {
        expect.check("/expect", &mut faults);
    }
    if body.rotate_secret && body.secret.is_some() {
        faults.push("/rotate_secret", message!("secret_is_drawn"));
    }
    let secret = match body.secret.take() {
        _ if body.rotate_secret => Some(draw("/rotate_secret", &mut faults)),
        Some(given) => Some(secret(given.as_deref(), &mut faults)),
        None => None,
    };
    faults.or(HookPatch { body, secret })
}

fn check_name(name: Option<&str>, faults: &mut Faults) {
    if let Some(Err(why)) = name.map(Name::parse) {
        faults.push("/name", why);
    }
}

fn check_target(kind: HookKind, url: &str, policy: &TargetPolicy, has_mail: bool, faults: &mut Faults) {
    let checked = match kind {
        HookKind::Email if !has_mail => Err(message!("no_mail_server")),
        HookKind::Email => recipients(url).map(|_| ()),
        _ => policy.check_url(url).map(|_| ()),
    };
    if let Err(why) = checked {
        faults.push("/url", why);
    }
}

/// The words never repeat the value.
fn check_authorization(value: Option<&str>, faults: &mut Faults) {
    let Some(value) = value else { return };
    let sendable = value.bytes().all(|byte| (b' '..=b'~').contains(&byte)) && value.trim() == value;
    if value.is_empty() || value.len() > MAX_AUTHORIZATION || !sendable {
        let detail = message!("authorization_form", most = MAX_AUTHORIZATION);
        faults.push("/authorization", detail);
    }
}

fn secret(text: Option<&str>, faults: &mut Faults) -> Option<Secret> {
    Secret::parse(text?).map_err(|why| faults.push("/secret", why)).ok()
}

fn draw(pointer: &str, faults: &mut Faults) -> Option<Secret> {
    let failed = |error| faults.push(pointer, message!("no_secret_drawn", why = text(error)));
    Secret::generate().map_err(failed).ok()
}
