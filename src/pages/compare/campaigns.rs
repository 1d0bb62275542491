//! Two campaigns side by side: parameters with their difference over its standard deviation, residuals on one scale,
//! the effects found in each.

use std::time::Duration;

use crate::core::mounting::Slot;
use crate::pages::calibration::stored_campaign;
use crate::pages::layout::{effect_word, encoded, instant, joined, symbol};
use crate::pages::prelude::*;
use crate::pages::{figure, residuals};
use crate::pipeline::{DiagnosisAnswer, StoredCampaign};
use crate::wire::calibration::GyroFitBody;

/// How long the page waits for a diagnosis that is being made.
const PATIENCE: Duration = Duration::from_secs(2);

/// The class of a difference beyond three standard deviations.
const FAR: &str = "beyond3";

/// What a diagnosis found; none while it is being made.
type Found = Option<Vec<(String, Vec<String>)>>;

pub(super) async fn page(pages: &Pages, viewer: &Viewer, ids: [&str; 2]) -> Result<Page, Problem> {
    let t = viewer.text();
    let mut both = [stored_campaign(pages, ids[0]).await?, stored_campaign(pages, ids[1]).await?];
    both.sort_by_key(|stored| stored.item.calibrated_at);
    let found = [found(pages, &both[0]).await?, found(pages, &both[1]).await?];
    let pairs = pairs(&both);
    let body = html! {
        h1 { (t.compare_campaigns) }
        (wide_table("cards", html! {
            td {} th { (t.imu) } th { (t.station) } th { (t.measured_at) } th { (t.effects_found) }
        }, html! {
            @for ((name, stored), found) in ["A", "B"].into_iter().zip(&both).zip(&found) {
                (side(t, name, stored, found))
            }
        }))
        @if both[0].answer.imu != both[1].answer.imu { p.note { (t.other_imus) } }
        @if pairs.is_empty() { p { (t.no_common_slot) } } @else { (differing(t, &both, &pairs)) }
        @for (slot, a, b) in &pairs {
            section.pair {
                h2 { (slot.name()) " " (serials(a, b)) }
                @if a.serial != b.serial { p.fault { (t.other_gyros) } }
                (parameters(t, &both, *slot, a, b))
                @let of_both = [a, b].into_iter().filter_map(|fit| fit.residuals.deg_per_h.as_ref());
                @let extent = residuals::extent(of_both.flatten());
                @for (name, fit) in [("A", a), ("B", b)] {
                    @if let Some(residuals) = &fit.residuals.deg_per_h {
                        (residuals::in_rate(t, &format!("{name} {}{}{}", fit.serial, t.colon, t.residual_word), residuals, extent))
                    }
                }
            }
        }
    };
    Ok(Page { title: format!("{}: {}", t.compare_campaigns, both[0].answer.imu), section: Section::Fleet, body })
}

fn serials(a: &GyroFitBody, b: &GyroFitBody) -> Markup {
    html! {
        a href={ "/gyros/" (encoded(&a.serial)) } { (a.serial) }
        @if a.serial != b.serial { " · " a href={ "/gyros/" (encoded(&b.serial)) } { (b.serial) } }
    }
}

fn pairs(both: &[StoredCampaign; 2]) -> Vec<(Slot, &GyroFitBody, &GyroFitBody)> {
    let [a, b] = both.each_ref().map(|stored| &stored.answer.calibration.gyros);
    let other = |fit: &GyroFitBody| b.iter().find(|other| other.slot == fit.slot);
    a.iter().filter_map(|fit| Some((fit.slot, fit, other(fit)?))).collect()
}

/// What lies beyond three standard deviations, slot by slot.
fn differing(t: &Text, both: &[StoredCampaign; 2], pairs: &[(Slot, &GyroFitBody, &GyroFitBody)]) -> Markup {
    let of_slot = |(slot, a, b): &(Slot, &GyroFitBody, &GyroFitBody)| {
        let compared = lines(both, *slot, a, b).into_iter().filter_map(|line| Some((line.over_sd()?, line.name)));
        compared.map(|(over, name)| (slot.name(), name, over)).collect::<Vec<_>>()
    };
    let compared: Vec<_> = pairs.iter().flat_map(of_slot).collect();
    let is_far = |(.., over): &&(&str, String, f64)| beyond(*over).is_some_and(|(class, _)| class == FAR);
    let far: Vec<_> = compared.iter().filter(is_far).collect();
    html! {
        @if !compared.is_empty() {
            p.lead {
                @if far.is_empty() { (t.differs_nowhere) } @else {
                    (t.differs) (t.colon)
                    (joined(t.semicolon, far.iter().map(|(slot, name, over)| html! {
                        span.nowrap { (slot) " " (symbol(name)) " " (figure::signed(*over, 1)) " σ" }
                    })))
                }
            }
        }
    }
}

async fn found(pages: &Pages, stored: &StoredCampaign) -> Result<Found, Problem> {
    Ok(match pages.pipeline.diagnoses.of_campaign(stored.item.id, PATIENCE).await? {
        DiagnosisAnswer::Answered(diagnosed) => Some(diagnosed.as_ref().as_ref().map_or_else(
            |_| Vec::new(),
            |diagnosis| diagnosis.effects.iter().map(|effect| (effect.effect.clone(), effect.gyros.clone())).collect(),
        )),
        DiagnosisAnswer::Waiting | DiagnosisAnswer::NoSuchCampaign => None,
    })
}

fn side(t: &Text, name: &str, stored: &StoredCampaign, found: &Found) -> Markup {
    let id = stored.item.id;
    let named = |(effect, gyros): &(String, Vec<String>)| format!("{} ({})", effect_word(t, effect), gyros.join(", "));
    html! {
        tr {
            th scope="row" { (name) }
            td data-label=(t.imu) { a href={ "/imus/" (encoded(&stored.answer.imu)) } { (stored.answer.imu) } }
            td data-label=(t.station) { (stored.answer.station) }
            td data-label=(t.measured_at) { a href={ "/campaigns/" (id) } { (instant(stored.item.calibrated_at)) } }
            td.words {
                @match found.as_deref() {
                    None => (t.coverage_waiting),
                    Some([]) => (t.no_effect),
                    Some(effects) => (joined("; ", effects.iter().map(named))),
                }
                " · " a href={ "/campaigns/" (id) "/diagnosis" } { (t.diagnosis) }
            }
        }
    }
}

/// One figure of both, with its unit.
struct Line {
    name: String,
    unit: String,
    /// Values and standard deviations.
    of: [(f64, Option<f64>); 2],
}

impl Line {
    /// B - A over its standard deviation.
    fn over_sd(&self) -> Option<f64> {
        let [(a, _), (b, _)] = self.of;
        Some((b - a) / self.sd().filter(|sd| *sd > 0.0)?)
    }

    /// Of B - A.
    fn sd(&self) -> Option<f64> {
        let [(_, a), (_, b)] = self.of;
        a.zip(b).map(|(a, b)| a.hypot(b))
    }
}

/// D_I, D_S and D_O, then every parameter of the fit that both have.
fn lines(both: &[StoredCampaign; 2], slot: Slot, a: &GyroFitBody, b: &GyroFitBody) -> Vec<Line> {
    let separated = both.each_ref().map(|stored| stored.answer.separations.iter().find(|one| one.slot == slot));
    let mut lines = Vec::new();
    if let [Some(a), Some(b)] = separated {
        for (name, a, b) in [("D_I", &a.d_i, &b.d_i), ("D_S", &a.d_s, &b.d_s), ("D_O", &a.d_o, &b.d_o)] {
            lines.push(Line { name: name.into(), unit: "deg/(h*g0)".into(), of: [(a.value, a.sd), (b.value, b.sd)] });
        }
    }
    for own in &a.parameters {
        if let Some(other) = b.parameters.iter().find(|other| other.name == own.name && other.unit == own.unit) {
            let of = [(own.value, own.sd), (other.value, other.sd)];
            lines.push(Line { name: own.name.clone(), unit: own.unit.clone(), of });
        }
    }
    lines
}

fn parameters(t: &Text, both: &[StoredCampaign; 2], slot: Slot, a: &GyroFitBody, b: &GyroFitBody) -> Markup {
    html! {
        (wide_table("cards", html! {
            th { (t.parameter) } th.n { "A" } th.n { "B" } th.n { "B - A" } th.n { "(B - A)/σ" }
            th { (t.unit_word) }
        }, html! { @for line in lines(both, slot, a, b) { (parameter(t, &line)) } }))
        p.note { (t.beyond_note) }
    }
}

fn parameter(t: &Text, line: &Line) -> Markup {
    let [(a, sd_a), (b, sd_b)] = line.of;
    let over = line.over_sd();
    let beyond = over.and_then(beyond);
    html! {
        tr {
            th scope="row" { (symbol(&line.name)) }
            td.n data-label="A" { (figure::with_sd(a, sd_a, 6)) }
            td.n data-label="B" { (figure::with_sd(b, sd_b, 6)) }
            td.n data-label="B - A" { (figure::signed_drift(b - a, line.sd())) }
            td.n data-label="(B - A)/σ" {
                @if let Some((class, mark)) = beyond { span class=(class) { (mark) " " } }
                @if let Some(over) = over { span class=[beyond.map(|(class, _)| class)] { (figure::signed(over, 1)) } }
                @else { "–" }
            }
            td translate="no" data-label=(t.unit_word) { (t.unit_of(&line.unit)) }
        }
    }
}

/// The class and the mark of a difference beyond two or three standard deviations.
fn beyond(over: f64) -> Option<(&'static str, &'static str)> {
    match over.abs() {
        size if size > 3.0 => Some((FAR, "▲")),
        size if size > 2.0 => Some(("beyond2", "△")),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_beyond_two_and_three_standard_deviations_is_marked_by_shape() {
        assert_eq!(
            [1.9, -2.1, 3.1, -4.0].map(|over| beyond(over).map(|(_, mark)| mark)),
            [None, Some("△"), Some("▲"), Some("▲")]
        );
    }

    #[test]
    fn a_difference_counts_by_the_uncertainty_of_both() {
        let line = |of| Line { name: "E_x".into(), unit: String::new(), of };
        assert_eq!(line([(1.0, Some(0.3)), (2.5, Some(0.4))]).over_sd(), Some(3.0));
        assert_eq!(line([(1.0, Some(0.3)), (2.5, None)]).over_sd(), None, "one of them is not known");
        assert_eq!(line([(1.0, Some(0.0)), (2.5, Some(0.0))]).over_sd(), None);
    }
}
