//! What is done about hooks: set up, tried, switched, deleted; and what they were told, sent again.

use axum::extract::State as Held;
use serde_json::{Map, Value};

use super::known;
use crate::core::delivery::DeliveryState;
use crate::core::fault::Fault;
use crate::core::judge::Severity;
use crate::core::message::text;
use crate::pages::form::{ActionForm, ItemAction, Word, choice, said, see_other};
use crate::pages::prelude::*;
use crate::pipeline::{HookKind, Order};
use crate::wire::hook::{ExpectBody, FilterBody, HookPatchBody, NewHookBody};

/// Dead letters that are sent again together.
const MOST_AT_ONCE: usize = 1000;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct NewHook {
    #[serde(flatten)]
    word: Word,
    name: String,
    kind: String,
    url: String,
    secret: String,
    authorization: String,
    rules: String,
    gyros: String,
    min_severity: String,
    /// `true` where a record's alerts go in one message.
    batch: String,
    /// `member = value, ...` that a successful answer must hold.
    expect: String,
}

impl NewHook {
    /// As the API takes it: what is empty is left out.
    fn body(&self) -> Result<NewHookBody, Faults> {
        let list = |text: &str| text.split([',', '，']).filter_map(said).collect();
        let json = self.expected()?;
        Ok(NewHookBody {
            name: said(&self.name),
            kind: self.kind.clone(),
            url: self.url.trim().to_owned(),
            secret: said(&self.secret),
            authorization: said(&self.authorization),
            filter: FilterBody {
                rules: list(&self.rules),
                gyros: list(&self.gyros),
                min_severity: Some(self.min_severity.clone()).filter(|least| !least.is_empty()),
            },
            enabled: true,
            batch: self.batch == "true",
            expect: (!json.is_empty()).then_some(ExpectBody { json }),
        })
    }

    /// `member = value, ...`; a value is JSON (`0`, `true`), or else text.
    fn expected(&self) -> Result<Map<String, Value>, Faults> {
        let pairs = self.expect.split([',', '，']).map(str::trim).filter(|pair| !pair.is_empty());
        pairs
            .map(|pair| {
                let (member, value) = pair.split_once('=').ok_or_else(|| Fault {
                    pointer: "/expect".into(),
                    message: message!("expected_pair", given = text(pair)),
                })?;
                let value = value.trim();
                let value = serde_json::from_str(value).unwrap_or_else(|_| value.into());
                Ok((member.trim().to_owned(), value))
            })
            .collect()
    }
}

pub(crate) async fn ask_add(viewer: Viewer) -> Page {
    let new = NewHook { batch: "true".into(), ..NewHook::default() };
    form(viewer.text(), &new).fresh(&viewer, &new.word)
}

pub(crate) async fn add(
    PageContext(ref pages, ref viewer): PageContext,
    Form(ref new): Form<NewHook>,
) -> Result<Response, Problem> {
    let mut faults = Faults::default();
    let read = new.body().and_then(|hook| pages.pipeline.hooks.check(hook));
    let read = read.map_err(|wrong| faults.absorb("", wrong)).ok().filter(|_| faults.is_empty());
    let Some(hook) = read else {
        return Ok(form(viewer.text(), new).again(viewer, &new.word, &faults));
    };
    let drawn = hook.drawn();
    let id = pages.pipeline.hooks.order(Order::Create(hook)).await?;
    let hook = pages.pipeline.hooks.get(id, drawn.as_ref()).await?;
    match hook.and_then(|hook| hook.secret) {
        Some(secret) => Ok((StatusCode::CREATED, shown_once(viewer.text(), id, &new.name, &secret)).into_response()),
        None => Ok(see_other(&format!("/hooks/{id}"))),
    }
}

fn shown_once(t: &Text, id: Id, name: &str, secret: &str) -> Page {
    let body = html! {
        h1 { (t.hook_set_up) }
        p.lead { (t.hook_secret_shown) }
        p { code { (secret) } }
        form.actions action={ "/hooks/" (id) "/test" } method="post" { button { (t.test_hook) } }
        p { a href={ "/hooks/" (id) } { @if name.is_empty() { (t.hook) } @else { span translate="no" { (name) } } } }
    };
    Page { title: t.hook_set_up.into(), section: Section::Hooks, body }
}

fn form(t: &Text, new: &NewHook) -> ActionForm {
    let fields = html! {
        label { (t.hook_name) input name="name" value=(new.name) maxlength="128"; }
        label { (t.kind) select name="kind" {
            @for kind in HookKind::ALL.map(HookKind::name) {
                option value=(kind) selected[kind == new.kind] translate="no" { (kind) }
            }
        } }
        label { (t.hook_url) input name="url" type="url" value=(new.url) required placeholder="https://" translate="no"; }
        label { (t.hook_secret) input name="secret" value=(new.secret) autocomplete="off"; }
        label { (t.hook_authorization) input name="authorization" value=(new.authorization) autocomplete="off" placeholder="Bearer …"; }
        label { (t.hook_rules) input name="rules" value=(new.rules) placeholder="step, baseline" translate="no"; }
        label { (t.hook_gyros) input name="gyros" value=(new.gyros); }
        (choice(t, t.alerts, "min_severity", [(Severity::Critical.name(), t.status(Status::Confirmed))], &new.min_severity))
        label.sure {
            input type="checkbox" name="batch" value="true" checked[new.batch == "true"]; span { (t.hook_batch) }
        }
        label { (t.hook_expect) input name="expect" value=(new.expect) placeholder="errcode = 0" translate="no"; }
    };
    ActionForm {
        section: Section::Hooks,
        title: t.add_hook.into(),
        what: html! { p.lead { (t.add_hook_what) } },
        fields,
        action: "/hooks/new".into(),
        button: t.add_hook,
        back: "/hooks".into(),
        unreasoned: true,
        ..ActionForm::default()
    }
}

pub(crate) struct DeleteHook;

impl ItemAction for DeleteHook {
    type Item = Id;

    async fn form(pages: &Pages, viewer: &Viewer, id: &str, _: &Word) -> Result<(Id, ActionForm), Problem> {
        let (id, hook) = known(pages, id).await?;
        let t = viewer.text();
        let form = ActionForm {
            section: Section::Hooks,
            title: t.delete_hook_title.into(),
            what: html! { p { code { (hook.url) } } p.lead { (t.delete_hook_what) } },
            action: format!("/hooks/{id}/delete"),
            button: t.delete_hook,
            back: "/hooks".into(),
            unreasoned: true,
            is_final: true,
            ..ActionForm::default()
        };
        Ok((id, form))
    }

    async fn run(pages: &Pages, id: Id, _: ActionForm, _: Word) -> Result<Response, Problem> {
        pages.pipeline.hooks.order(Order::Delete(id)).await?;
        Ok(see_other("/hooks"))
    }
}

pub(crate) async fn test(Held(pages): Held<Pages>, Path(id): Path<String>) -> Result<Response, Problem> {
    let (number, _) = known(&pages, &id).await?;
    pages.pipeline.hooks.order(Order::Test(number)).await?;
    Ok(see_other(&format!("/hooks/{id}")))
}

#[derive(Debug, Deserialize)]
pub(crate) struct Switch {
    enabled: String,
}

pub(crate) async fn switch(
    Held(pages): Held<Pages>,
    Path(id): Path<String>,
    Form(switch): Form<Switch>,
) -> Result<Response, Problem> {
    let (number, _) = known(&pages, &id).await?;
    let patch = HookPatchBody { enabled: Some(switch.enabled == "true"), ..HookPatchBody::default() };
    let patch = pages.pipeline.hooks.check_patch(patch);
    let patch = patch.map_err(|faults| Problem::of_faults(422, "title_cannot_be_stored", faults))?;
    pages.pipeline.hooks.order(Order::Change(number, patch)).await?;
    Ok(see_other(&format!("/hooks/{id}")))
}

pub(crate) async fn redeliver(
    Held(pages): Held<Pages>,
    Path((id, delivery)): Path<(String, String)>,
) -> Result<Response, Problem> {
    let delivery = delivery.parse().map_err(|_| Problem::no_such_delivery(&delivery))?;
    pages.pipeline.hooks.order(Order::Redeliver(delivery)).await?;
    known(&pages, &id).await?;
    Ok(see_other(&format!("/hooks/{id}")))
}

/// Sends the dead letters again, in the order in which they came.
pub(crate) async fn redeliver_dead(Held(pages): Held<Pages>, Path(id): Path<String>) -> Result<Response, Problem> {
    let (number, _) = known(&pages, &id).await?;
    let dead = pages.pipeline.hooks.deliveries(number, Some(DeliveryState::Dead), None, MOST_AT_ONCE).await?;
    for delivery in dead.iter().rev() {
        if let Ok(delivery) = delivery.id.parse() {
            pages.pipeline.hooks.order(Order::Redeliver(delivery)).await?;
        }
    }
    Ok(see_other(&format!("/hooks/{id}")))
}
