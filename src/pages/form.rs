//! Forms for whatever changes something: with who and why, and that it is meant where it cannot be undone. That they come from this site's own
//! pages is seen to where every request is admitted.

use axum::http::HeaderValue;
use axum::http::header::LOCATION;

use super::prelude::*;
use super::viewer::is_local;
use crate::routes::{MinimumRole, Routes};
use crate::wire::text;

/// Goes on with another page, which may be loaded again without sending the form again.
pub(super) fn see_other(path: &str) -> Response {
    let path = HeaderValue::from_str(path).unwrap_or(HeaderValue::from_static("/"));
    (StatusCode::SEE_OTHER, [(LOCATION, path)]).into_response()
}

/// Who does something and why; that it is meant; and where to go on.
#[derive(Debug, Default, Clone, Deserialize)]
#[serde(default)]
pub(super) struct Word {
    pub by: String,
    pub reason: String,
    pub confirm: String,
    pub back: String,
}

impl Word {
    /// Notes what is missing of who and why.
    pub fn check(&self, faults: &mut Faults) {
        text::required_short("by", self.by.clone(), faults);
        text::required_note("reason", self.reason.clone(), faults);
    }

    pub fn check_meant(&self, viewer: &Viewer, faults: &mut Faults) {
        if self.confirm != "yes" {
            faults.push("confirm", Message::verbatim(viewer.text().must_confirm));
        }
    }

    /// Where to go on: on this service, whatever was sent.
    pub fn back_or<'a>(&'a self, otherwise: &'a str) -> &'a str {
        if is_local(&self.back) { &self.back } else { otherwise }
    }
}

/// Something that changes what is stored, on a page of its own: what it does, who does it and why; and that it is
/// meant, where it cannot be undone.
#[derive(Default)]
pub(super) struct ActionForm {
    pub section: Section,
    pub title: String,
    /// What it is about, and what it does.
    pub what: Markup,
    /// What it needs to know besides.
    pub fields: Markup,
    pub action: String,
    pub button: &'static str,
    /// Where to go on if it is not done.
    pub back: String,
    /// Whether it asks neither who nor why.
    pub unreasoned: bool,
    /// Whether it cannot be undone.
    pub is_final: bool,
}

impl ActionForm {
    /// Before anything was sent.
    pub fn fresh(&self, viewer: &Viewer, word: &Word) -> Page {
        self.page(viewer, word, &Faults::default())
    }

    fn page(&self, viewer: &Viewer, word: &Word, faults: &Faults) -> Page {
        let t = viewer.text();
        // Whoever has signed in need not write the name under which the audit trail has them anyway.
        let by = if word.by.is_empty() { viewer.signed_in.as_deref().unwrap_or_default() } else { &word.by };
        let body = html! {
            h1 { (self.title) }
            (self.what)
            (fault_list(t, faults))
            form.deed action=(self.action) method="post" {
                input type="hidden" name="back" value=(self.back);
                (self.fields)
                @if !self.unreasoned {
                    (who(t, by))
                    label { (t.reason_word) textarea name="reason" rows="3" required maxlength="4096" { (word.reason) } }
                }
                @if self.is_final {
                    label.sure { input type="checkbox" name="confirm" value="yes" required; span { (t.confirm_word) } }
                }
                p { button.primary { (self.button) } " " a href=(self.back) { (t.go_back) } }
            }
        };
        Page { title: self.title.clone(), section: self.section, body }
    }

    /// The form again where something that it asks for is missing; none where all of it was sent.
    fn incomplete(&self, viewer: &Viewer, word: &Word) -> Option<Response> {
        let mut faults = Faults::default();
        if !self.unreasoned {
            word.check(&mut faults);
        }
        if self.is_final {
            word.check_meant(viewer, &mut faults);
        }
        (!faults.is_empty()).then(|| self.again(viewer, word, &faults))
    }

    /// What was sent cannot be done as it is: the form again, with why.
    pub fn again(&self, viewer: &Viewer, word: &Word, faults: &Faults) -> Response {
        (StatusCode::UNPROCESSABLE_ENTITY, self.page(viewer, word, faults)).into_response()
    }
}

/// Something that is done to one item, on a page whose `GET` asks and whose `POST` does it.
pub(super) trait ItemAction {
    type Item: Send;

    /// The item of the path, and the form that asks whether it is to be done.
    fn form(
        pages: &Pages,
        viewer: &Viewer,
        id: &str,
        word: &Word,
    ) -> impl Future<Output = Result<(Self::Item, ActionForm), Problem>> + Send;

    fn run(
        pages: &Pages,
        item: Self::Item,
        form: ActionForm,
        word: Word,
    ) -> impl Future<Output = Result<Response, Problem>> + Send;
}

impl Routes<Pages> {
    /// The page that asks, and what its form is sent to.
    pub(super) fn action<A: ItemAction + 'static>(self, least: MinimumRole, path: &str) -> Self {
        self.get(least, path, ask::<A>).post(least, path, act::<A>)
    }
}

async fn ask<A: ItemAction>(
    PageContext(ref pages, ref viewer): PageContext,
    Path(id): Path<String>,
    Query(word): Query<Word>,
) -> Result<Page, Problem> {
    let (_, form) = A::form(pages, viewer, &id, &word).await?;
    Ok(form.fresh(viewer, &word))
}

async fn act<A: ItemAction>(
    PageContext(ref pages, ref viewer): PageContext,
    Path(id): Path<String>,
    Form(word): Form<Word>,
) -> Result<Response, Problem> {
    let (item, form) = A::form(pages, viewer, &id, &word).await?;
    match form.incomplete(viewer, &word) {
        Some(again) => Ok(again),
        None => A::run(pages, item, form, word).await,
    }
}

/// What somebody wrote into a field, if anything.
pub(super) fn said(text: &str) -> Option<String> {
    Some(text.trim().to_owned()).filter(|text| !text.is_empty())
}

/// One of several by their names, or any.
pub(super) fn choice<'a>(
    t: &Text,
    label: &str,
    name: &str,
    of: impl IntoIterator<Item = (&'static str, &'a str)>,
    chosen: &str,
) -> Markup {
    html! {
        label { (label) " " select name=(name) {
            option value="" { (t.any) }
            @for (value, word) in of { option value=(value) selected[value == chosen] { (word) } }
        } }
    }
}

/// Who does it: `by` where that is known.
pub(super) fn who(t: &Text, by: &str) -> Markup {
    html! { label { (t.who) input name="by" value=(by) required maxlength="128" autocomplete="name"; } }
}

pub(super) fn rule_choice(t: &Text, chosen: &str) -> Markup {
    // Of earlier versions: nothing is judged by it any more.
    let offered = Rule::ALL.into_iter().filter(|rule| *rule != Rule::Cusum || chosen == rule.name());
    choice(t, t.rule_word, "rule", offered.map(|rule| (rule.name(), t.rule(rule))), chosen)
}

/// A time as somebody types it, `2026-03-01 16:00`, for what reads RFC 3339 or a day. Without a zone it is of UTC, as the
/// pages are where no script has made it the viewer's.
pub(super) fn typed_time(text: &str) -> String {
    let text = text.trim().replacen(' ', "T", 1);
    let whole = [":00Z", "Z"].map(|rest| format!("{text}{rest}"));
    whole.into_iter().find(|whole| time::parse(whole).is_ok()).unwrap_or(text)
}

/// What is missing or wrong on a form.
pub(super) fn fault_list(t: &Text, faults: &Faults) -> Markup {
    html! {
        @if !faults.0.is_empty() {
            ul.fault role="alert" {
                @for fault in &faults.0 { li { (field(t, &fault.pointer)) ": " (t.words(&fault.message)) } }
            }
        }
    }
}

/// What a field is called on the form; a place within it as it stands.
fn field(t: &Text, pointer: &str) -> Markup {
    let label = match pointer {
        "by" => t.who,
        "reason" => t.reason_word,
        "event" => t.event_word,
        "at" => t.event_time,
        "days" => t.silence_days,
        "batch" => t.batch,
        "type" => t.gyro_type,
        "unit" => t.gyro_unit,
        "from" => t.window_from,
        "to" => t.window_to,
        "confirm" => t.confirmation,
        "alert" => t.alert,
        "/imu" => t.imu,
        "/station" => t.station,
        "/since" => t.measured_since,
        "/until" => t.measured_until,
        "/effect" => t.effect,
        "/name" => t.hook_name,
        "/kind" => t.kind,
        "/url" => t.hook_url,
        "/expect" => t.hook_expect,
        "/secret" => t.hook_secret_word,
        "/authorization" => t.hook_authorization,
        _ => return html! { code { (pointer) } },
    };
    html! { (label) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_typed_with_or_without_its_zone() {
        for (typed, read) in [
            ("2026-03-01", "2026-03-01"),
            (" 2026-03-01 16:00", "2026-03-01T16:00:00Z"),
            ("2026-03-01T16:00:30", "2026-03-01T16:00:30Z"),
            ("2026-03-01T16:00:00+08:00", "2026-03-01T16:00:00+08:00"),
            ("1.3.2026", "1.3.2026"),
        ] {
            assert_eq!(typed_time(typed), read);
        }
    }

    #[test]
    fn nobody_is_sent_elsewhere_afterwards() {
        let word = |back: &str| Word { back: back.into(), ..Word::default() };
        assert_eq!(word("/gyros/A").back_or("/alerts"), "/gyros/A");
        assert_eq!(word("//evil.example").back_or("/alerts"), "/alerts");
    }
}
