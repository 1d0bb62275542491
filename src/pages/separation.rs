//! What was separated from one calibration: D_I, D_S and the closure by both methods, angles and branches.

use super::prelude::*;
use crate::core::mounting::Slot;
use crate::wire::answer::{FigureBody, SeparationBody, UncertaintiesBody, UncertaintyBody};

pub(super) fn tables(t: &Text, separations: &[SeparationBody]) -> Markup {
    html! {
        (wide_table("cards", html! {
            th { (t.serial) } th { (t.method) } @for name in DRIFTS { th.n { (symbol(name)) } } th.n { (t.closure_rms) }
        }, html! { @for one in separations { (figures(t, one)) } }))
        p.note { (t.unit) ". " (t.as_printed_note) }
        (budgets(t, separations))
        h3 { (t.mounting) }
        (wide_table("cards", html! {
            th { (t.serial) } th.n { "α" sub { "x" } } th.n { "α" sub { "y" } } th.n { "α" sub { "z" } }
            th.n { (t.misalignment) ", ′" } th.n { (t.clocking) ", °" } th.n { "|E|, pulse/arcsec" }
        }, html! { @for one in separations { tr {
            (gyro(one))
            @for (angle, name) in one.alpha_deg.0.into_iter().zip(["αx", "αy", "αz"]) {
                td.n data-label=(name) { (figure::fixed(angle, 6)) "°" }
            }
            td.n data-label={ (t.misalignment) ", ′" } { (figure::fixed(one.misalignment_arcmin, 3)) }
            td.n data-label={ (t.clocking) ", °" } { (measured(&one.clocking_deg)) }
            td.n data-label="|E|, pulse/arcsec" { (measured(&one.scale_factor)) }
        } } }))
    }
}

fn figures(t: &Text, one: &SeparationBody) -> Markup {
    // The main figures may be the published ones; then the rigid ones stand beside them, without uncertainty.
    let rigid = match &one.rigid {
        Some(rigid) => [rigid.d_i, rigid.d_s, rigid.d_o].map(|value| FigureBody { value, sd: None }),
        None => [one.d_i, one.d_s, one.d_o],
    };
    html! {
        tr {
            (gyro(one))
            td { (t.method("rigid")) }
            @for (figure, name) in rigid.iter().zip(DRIFTS) { td.n { (label("", name)) (measured(figure)) } }
            td.n {}
        }
        @if let Some(own) = &one.as_measured {
            tr.beside {
                td {}
                td { (t.as_measured) " (" (format!("{:.1} °C", own.temperature_c)) ")" }
                td.n { (label("", "D_I")) (measured(&own.d_i)) }
                td.n { (label("", "D_S")) (measured(&own.d_s)) }
                td.n {} td.n {}
            }
        }
        @for (body, name) in [(&one.published, t.published_by), (&one.as_printed, t.as_printed)] {
            @if let Some(body) = body {
                tr.beside {
                    td {}
                    td { (name) " (" (body.branch) ")" }
                    td.n { (label("", "D_I")) (figure::drift(body.d_i, body.d_i_sd)) }
                    td.n { (label("", "D_S")) (figure::drift(body.d_s, body.d_s_sd)) }
                    td.n {}
                    td.n data-label=(t.closure_rms) { (figure::short(body.closure_rms)) }
                }
            }
        }
    }
}

/// What the standard deviations are made of; folded where nothing but the noise is in them.
fn budgets(t: &Text, separations: &[SeparationBody]) -> Markup {
    let of_gyro = |one: &SeparationBody| {
        one.uncertainty.map(|UncertaintiesBody { d_i, d_s, d_o, .. }| ([d_i, d_s, d_o], one.slot, one.serial.clone()))
    };
    let all: Vec<([UncertaintyBody; 3], Slot, String)> = separations.iter().filter_map(of_gyro).collect();
    let has = |part: fn(&UncertaintyBody) -> Option<f64>| {
        all.iter().flat_map(|(budgets, ..)| budgets).filter_map(part).any(|sd| sd > 0.0)
    };
    let beyond_noise = has(|budget| budget.station) || has(|budget| budget.discrepancy);
    let parts: [(&str, fn(&UncertaintyBody) -> Option<f64>); 3] = [
        (t.part_noise, |budget| Some(budget.statistical)),
        (t.station, |budget| budget.station),
        (t.discrepancy, |budget| budget.discrepancy),
    ];
    html! {
        @if !all.is_empty() {
            details #budget open[beyond_noise] {
                summary { (t.uncertainty_budget) }
                (wide_table("cards", html! {
                    th { (t.serial) } th { (t.coefficient) }
                    @for (name, _) in &parts { th.n { (name) } } th.n { (t.combined) }
                }, html! { @for (budgets, slot, serial) in &all {
                    @for (budget, name) in budgets.iter().zip(DRIFTS) {
                        tr {
                            td { (slot.name()) " " (serial) } td { (symbol(name)) }
                            @for (name, part) in &parts {
                                td.n data-label=(name) { (or_dash(part(budget).map(figure::short))) }
                            }
                            td.n data-label=(t.combined) { strong { (figure::short(budget.combined)) } }
                        }
                    }
                } }))
                p.note { (t.unit) ". " (t.uncertainty_note) }
            }
        }
    }
}

fn gyro(one: &SeparationBody) -> Markup {
    html! {
        th scope="row" {
            (one.slot.name()) " " a href={ "/gyros/" (encoded(&one.serial)) } { (one.serial) }
        }
    }
}

fn measured(figure: &FigureBody) -> String {
    figure::drift(figure.value, figure.sd)
}
