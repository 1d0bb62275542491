//! Silences of many alerts: those that hold, on the page of alerts; begun and ended on pages of their own.

use super::form::{ActionForm, ItemAction, Word, rule_choice, see_other};
use super::layout::remark;
use super::prelude::*;
use crate::core::alert_filter::Matchers;
use crate::pipeline::SilenceOrder;
use crate::wire::silence::MatchersBody;
use crate::wire::text;

/// Longest silence, days.
const LONGEST_SILENCE: f64 = 365.0;

/// For how many days there is to be silence; a week unless somebody has said otherwise.
pub(super) fn days_field(t: &Text, days: &str, required: bool) -> Markup {
    let days = if days.is_empty() { "7" } else { days };
    html! {
        label {
            (t.silence_days) " "
            input name="days" type="number" min="0.1" max=(LONGEST_SILENCE) step="0.1" value=(days) required[required];
        }
    }
}

/// When a silence of so many days ends; now, where they are at fault.
pub(super) fn silent_until(pages: &Pages, days: &str, faults: &mut Faults) -> UtcMicros {
    let days = days.trim().parse().ok().filter(|days| *days > 0.0 && *days <= LONGEST_SILENCE);
    if days.is_none() {
        faults.push("days", Message::verbatim(format_args!("0 … {LONGEST_SILENCE}")));
    }
    pages.clock.now().plus_days(days.unwrap_or_default())
}

/// Those that hold, and how to begin one.
pub(super) async fn list(pages: &Pages, viewer: &Viewer) -> Result<Markup, Problem> {
    let t = viewer.text();
    let silences = pages.pipeline.alerts.silences(false).await?;
    let may = viewer.may(Role::Engineer);
    Ok(html! {
        @if may { p.actions.no-print { a.action href="/silences/new" { (t.silence_many) } } }
        @if !silences.is_empty() {
            h2 { (t.silences) }
            (wide_table("", html! {
                th { (t.silence_of) } th { (t.until) } th { (t.reason_word) } @if may { th { (t.actions_word) } }
            }, html! { @for silence in &silences { tr {
                th.words scope="row" { (of(t, &silence.matchers)) }
                td data-label=(t.until) { (written(&silence.until)) }
                td.words { (remark(t.said_by, &silence.by, &silence.reason)) }
                @if may { td { a href={ "/silences/" (silence.id) "/end" } { (t.end_silence) } } }
            } } }))
        }
    })
}

fn of(t: &Text, matchers: &MatchersBody) -> Markup {
    let names = [(t.serial, &matchers.serial), (t.imu, &matchers.imu), (t.station, &matchers.station)];
    let rule = matchers.rule.as_deref().and_then(Rule::from_name);
    html! {
        @for (label, name) in names { @if let Some(name) = name { (label) " " span.id translate="no" { (name) } " " } }
        @if let Some(rule) = rule { (t.rule_word) " " (t.rule(rule)) }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct NewSilence {
    #[serde(flatten)]
    word: Word,
    serial: String,
    imu: String,
    station: String,
    rule: String,
    days: String,
}

pub(super) async fn ask_new(viewer: Viewer) -> Page {
    let new = NewSilence::default();
    form(viewer.text(), &new).fresh(&viewer, &new.word)
}

pub(super) async fn begin(
    PageContext(ref pages, ref viewer): PageContext,
    Form(ref new): Form<NewSilence>,
) -> Result<Response, Problem> {
    let mut faults = Faults::default();
    new.word.check(&mut faults);
    let until = silent_until(pages, &new.days, &mut faults);
    let mut name = |field: &str, text: &str| {
        let text = Some(text.trim()).filter(|text| !text.is_empty())?;
        text::matched(field, text, &mut faults)
    };
    let matchers = Matchers {
        serial: name("serial", &new.serial),
        imu: name("imu", &new.imu),
        station: name("station", &new.station),
        rule: Rule::from_name(&new.rule),
    };
    if matchers == Matchers::default() {
        faults.push("serial", Message::verbatim(viewer.text().silence_of_nothing));
    }
    if !faults.is_empty() {
        return Ok(form(viewer.text(), new).again(viewer, &new.word, &faults));
    }
    let Word { by, reason, .. } = new.word.clone();
    pages.pipeline.alerts.order_silence(SilenceOrder::Begin { matchers, until, by, reason }).await?;
    Ok(see_other("/alerts"))
}

fn form(t: &Text, new: &NewSilence) -> ActionForm {
    let names = [("serial", t.serial, &new.serial), ("imu", t.imu, &new.imu), ("station", t.station, &new.station)];
    let fields = html! {
        @for (name, label, value) in names { label { (label) input name=(name) value=(value) maxlength="128" translate="no"; } }
        (rule_choice(t, &new.rule))
        (days_field(t, &new.days, true))
    };
    ActionForm {
        section: Section::Alerts,
        title: t.silence_many.into(),
        what: html! { p.lead { (t.silence_many_what) } },
        fields,
        action: "/silences/new".into(),
        button: t.silence,
        back: "/alerts".into(),
        ..ActionForm::default()
    }
}

pub(super) struct EndSilence;

impl ItemAction for EndSilence {
    type Item = Id;

    async fn form(pages: &Pages, viewer: &Viewer, id: &str, _: &Word) -> Result<(Id, ActionForm), Problem> {
        let number = problem::id(id, Problem::unknown_silence)?;
        let silence = pages.pipeline.alerts.silence(number).await?.ok_or_else(|| Problem::unknown_silence(id))?;
        let t = viewer.text();
        let form = ActionForm {
            section: Section::Alerts,
            title: t.end_silence_title.into(),
            what: html! { p { (of(t, &silence.matchers)) } p.lead { (t.end_silence_what) } },
            action: format!("/silences/{number}/end"),
            button: t.end_silence,
            back: "/alerts".into(),
            ..ActionForm::default()
        };
        Ok((number, form))
    }

    async fn run(pages: &Pages, silence: Id, _: ActionForm, word: Word) -> Result<Response, Problem> {
        let Word { by, reason, .. } = word;
        pages.pipeline.alerts.order_silence(SilenceOrder::End { silence, by, reason }).await?;
        Ok(see_other("/alerts"))
    }
}
