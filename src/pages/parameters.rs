//! E, G and P of an IMU's gyros in the form of the paper's Tables 3 and 4: each figure with its standard deviation,
//! what is required of it, and whether it keeps that.

use std::collections::BTreeSet;

use super::prelude::*;
use super::status;
use crate::config::Judging;
use crate::core::judge::limits::{Bounds, Requirement};
use crate::core::mounting::Slot;
use crate::wire::calibration::{GyroFitBody, ParameterBody};
use crate::wire::geometry::{GeometryBody, NamedGeometry};
use crate::wire::record::GyroBody;

/// One gyro's parameters of model (6).
pub(super) struct Parameters {
    slot: Slot,
    pub serial: String,
    /// Pulse/arcsec, pulse/(s g0) and pulse/(s g0^2), body axes.
    e: Option<Three>,
    g: Option<Three>,
    p: Option<Three>,
}

/// Values along X, Y, Z, and their standard deviations where they are known.
#[derive(Clone, Copy)]
struct Three {
    values: [f64; 3],
    sd: [Option<f64>; 3],
}

impl Three {
    fn of(values: [f64; 3], sd: Option<[f64; 3]>) -> Self {
        Self { values, sd: sd.map_or([None; 3], |sd| sd.map(Some)) }
    }

    fn norm(&self) -> f64 {
        self.values.iter().map(|v| v * v).sum::<f64>().sqrt()
    }
}

impl Parameters {
    /// As a station stated them. G that came in deg/(h g0) is multiplied by |E|.
    pub fn stated(gyro: &GyroBody) -> Self {
        let e = Three::of(gyro.e_pulse_per_arcsec.0, gyro.e_sd.map(|sd| sd.0));
        let factor = if gyro.g_pulse_per_s_g0.is_some() { 1.0 } else { e.norm() };
        let g = gyro.g_pulse_per_s_g0.or(gyro.g_deg_per_h_g0);
        Self {
            slot: gyro.slot,
            serial: gyro.serial.clone(),
            e: Some(e),
            g: g.map(|g| Three::of(g.0.map(|v| v * factor), gyro.g_sd.map(|sd| sd.0.map(|v| v * factor)))),
            p: gyro.p_pulse_per_s_g02.map(|p| Three::of(p.0, None)),
        }
    }

    /// As they were fitted here.
    pub fn fitted(gyro: &GyroFitBody) -> Self {
        let p: Vec<&ParameterBody> = gyro.parameters.iter().filter(|p| p.unit == "pulse/(s*g0^2)").collect();
        let p_sd = [0, 1, 2].map(|i| p.get(i).and_then(|parameter| parameter.sd));
        Self {
            slot: gyro.slot,
            serial: gyro.serial.clone(),
            e: gyro.e_pulse_per_arcsec.map(|e| Three::of(e.0, gyro.e_sd.map(|sd| sd.0))),
            g: gyro.g_pulse_per_s_g0.map(|g| Three::of(g.0, gyro.g_sd.map(|sd| sd.0))),
            p: gyro.p_pulse_per_s_g02.map(|p| Three { values: p.0, sd: p_sd }),
        }
    }
}

/// What E and G of a gyro of `imu` must keep, by its slot and serial number.
pub(super) fn required(judging: &Judging, imu: &str, geometry: &GeometryBody) -> impl Fn(Slot, &str) -> Requirement {
    let skewed = matches!(geometry, GeometryBody::Named(NamedGeometry::Skewed));
    move |slot, serial| judging.requirement(skewed, slot, imu, serial)
}

pub(super) fn tables(t: &Text, gyros: &[Parameters], required: impl Fn(Slot, &str) -> Requirement) -> Markup {
    let required = |gyro: &Parameters| required(gyro.slot, &gyro.serial);
    html! {
        (table(t, ("E", &t.unit_of("pulse/arcsec")), gyros, |gyro| {
            let e = gyro.e?;
            let required = required(gyro);
            Some((e, required.e, Some((e.norm(), required.e_norm))))
        }))
        (table(t, ("G", &t.unit_of("pulse/(s*g0)")), gyros, |gyro| Some((gyro.g?, required(gyro).g, None))))
        @if gyros.iter().any(|gyro| gyro.p.is_some()) {
            (table(t, ("P", &t.unit_of("pulse/(s*g0^2)")), gyros, |gyro| Some((gyro.p?, [None; 3], None))))
        }
        @let keys = keys(gyros.iter().map(required));
        @if !keys.is_empty() { p.note { (t.requirement_note) @for key in keys { " " code { (key) } } (t.stop) } }
    }
}

/// What in the configuration says so.
fn keys(required: impl Iterator<Item = Requirement>) -> BTreeSet<String> {
    let bounds = required.flat_map(|one| one.e.into_iter().chain(one.g).chain([one.e_norm]).flatten());
    bounds.map(|bounds| bounds.from.to_string()).collect()
}

/// Values, what is required of each, and the length with what is required of it.
type Line = (Three, [Option<Bounds>; 3], Option<(f64, Option<Bounds>)>);

fn table(
    t: &Text,
    (symbol, unit): (&str, &str),
    gyros: &[Parameters],
    line: impl Fn(&Parameters) -> Option<Line>,
) -> Markup {
    let lines: Vec<(&Parameters, Option<Line>)> = gyros.iter().map(|gyro| (gyro, line(gyro))).collect();
    let with_norm = lines.iter().any(|(_, line)| line.as_ref().is_some_and(|(.., norm)| norm.is_some()));
    html! {
        (wide_table("parameters cards", html! {
            th { var { (symbol) } ", " (unit) } th.n { "X" } th.n { "Y" } th.n { "Z" }
            @if with_norm { th.n { "|" (symbol) "|" } }
        }, html! { @for (gyro, line) in &lines { tr {
            th scope="row" { (gyro.slot.name()) " " a href={ "/gyros/" (encoded(&gyro.serial)) } { (gyro.serial) } }
            @if let Some((three, bounds, norm)) = line {
                @for (i, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
                    (cell(t, &format!("{symbol} {axis}, {unit}"), three.values[i], three.sd[i], bounds[i]))
                }
                @if let Some((length, bounds)) = norm { (cell(t, &format!("|{symbol}|, {unit}"), *length, None, *bounds)) }
            } @else {
                td.quiet colspan="4" { (t.not_determined) }
            }
        } } }))
    }
}

fn cell(t: &Text, label: &str, value: f64, sd: Option<f64>, bounds: Option<Bounds>) -> Markup {
    html! {
        td.n data-label=(label) {
            div {
                (figure::with_sd(value, sd, 6))
                @if let Some(Bounds { low, high, .. }) = bounds {
                    @let kept = (low..=high).contains(&value);
                    br;
                    span.quiet { (bounds_alike(low, high)) } " "
                    @if kept { (status::said(Some(Status::InTolerance), t.pass)) }
                    @else { (status::said(Some(Status::OutOfTolerance), t.fail)) }
                }
            }
        }
    }
}

/// Both with as many decimals as the longer one has in the paper.
fn bounds_alike(low: f64, high: f64) -> String {
    let decimals = |bound: f64| bound.to_string().split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let most = decimals(low).max(decimals(high));
    format!("{low:.most$} … {high:.most$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::wire::record::RecordBody;
    use crate::words::Language;

    #[test]
    fn the_papers_own_figures_are_shown_with_what_is_required_of_them() {
        let record: RecordBody =
            serde_json::from_str(include_str!("../../tests/data/paper.json")).expect("the paper's record");
        let gyros: Vec<Parameters> = record.gyros.iter().map(Parameters::stated).collect();
        let mut config = Config::defaults();
        config.judging.requirements = true;
        let required = required(&config.judging, &record.imu, &record.geometry);
        let shown = tables(Language::English.text(), &gyros, required).into_string();
        assert!(shown.contains("0.847300") && shown.contains("0.8425 … 0.8529"), "{shown}");
        assert!(shown.contains("<code>judging.requirements</code>"), "{shown}");
        assert_eq!(bounds_alike(-0.609, -0.5972), "-0.6090 … -0.5972");
        assert_eq!(shown.matches("class=\"badge ").count(), 3 * (3 + 1 + 3));
        let e: Vec<f64> = record.gyros.iter().flat_map(|gyro| gyro.e_pulse_per_arcsec.0).collect();
        let required = Requirement::tables_3_and_4().map(|r| r.e).concat();
        let outside = e.iter().zip(required).filter(|(v, b)| !b.is_some_and(|b| (b.low..=b.high).contains(*v))).count();
        assert_eq!(shown.matches("badge out_of_tolerance").count(), outside);
    }
}
