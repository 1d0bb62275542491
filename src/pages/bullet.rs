//! A load as a bar the height of a word: every one on the same scale, so that the eye can run down a column.

use super::prelude::*;
use super::status::sign;
use crate::pipeline::{GyroStatus, Violation};

/// Loads beyond this stand at the edge, as an arrow.
const EDGE: f64 = 1.5;
/// Loads beyond this are told in budgets.
const MOST_IN_PERCENT: f64 = 10.0;
const WIDTH: f64 = 90.0;
const HEIGHT: f64 = 16.0;
/// Room for the arrow.
const ARROW: f64 = 7.0;

/// `+251 ± 7`, %: two digits of the standard deviation, at most whole ones.
pub(super) fn percent(load: Measured) -> String {
    let percent = 100.0 * load.value;
    let sd = load.sd.map(|sd| 100.0 * sd).filter(|sd| sd.is_finite());
    let places = if percent.abs().max(sd.unwrap_or(0.0)) < 9.95 && sd.is_none_or(|sd| sd < 0.95) { 1 } else { 0 };
    let size = format!("{:.places$}", percent.abs());
    let sign = match size.bytes().all(|byte| matches!(byte, b'0' | b'.')) {
        true => "",
        false if percent < 0.0 => "-",
        false => "+",
    };
    match sd {
        Some(sd) => format!("{sign}{size} ± {sd:.places$}"),
        None => format!("{sign}{size}"),
    }
}

/// `+251 ± 7 %`; of ten budgets and more `+265 budgets`.
pub(super) fn share(t: &Text, load: Measured) -> String {
    in_budgets(t, load).unwrap_or_else(|| format!("{}{}", percent(load), t.percent_sign))
}

/// As [`share`], in a column of percentages.
pub(super) fn in_column(t: &Text, load: Measured) -> String {
    in_budgets(t, load).unwrap_or_else(|| percent(load))
}

fn in_budgets(t: &Text, load: Measured) -> Option<String> {
    let budgets = (load.value.abs() >= MOST_IN_PERCENT).then(|| format!("{:+.0}", load.value))?;
    Some(t.words(&message!("page_load_in_budgets", budgets)))
}

/// `+251`, %: where there is room for no more.
pub(super) fn rounded(load: Measured) -> String {
    percent(Measured { value: (100.0 * load.value).round() / 100.0, sd: Some(0.01) }).replace(" ± 1", "")
}

/// The load of D_I, D_S or D_O, by its column, as a bar and in figures.
pub(super) fn of_coefficient(t: &Text, standing: &GyroStatus, column: usize) -> Markup {
    html! {
        @if let Some(load) = standing.projection.load[column] {
            span.leading { (symbol(DRIFTS[column])) } (bar(load, standing.drift[column])) " " span.n { (share(t, load)) }
        }
    }
}

/// Rules on how far D_I, D_S and D_O are from a level of theirs: what they find is a load.
const OF_LEVEL: [Rule; 5] = [Rule::Baseline, Rule::Trend, Rule::Cusum, Rule::Shift, Rule::Closure];

/// The largest figure of the gravest of these: a load where it is about the level, else what its rule compares.
pub(super) fn leading(t: &Text, standing: &GyroStatus, of: &[Violation]) -> Markup {
    let gravest = of.iter().map(|one| one.status).max();
    let of_gravest = of.iter().filter(|one| Some(one.status) == gravest);
    let of_level = of_gravest.clone().filter(|one| OF_LEVEL.contains(&one.rule));
    let columns = of_level.filter_map(|one| one.coefficient.column());
    let known = columns.filter_map(|column| Some((column, standing.projection.load[column]?.value.abs())));
    if let Some((column, _)) = known.max_by(|(_, a), (_, b)| a.total_cmp(b)) {
        return of_coefficient(t, standing, column);
    }
    if let Some(days) = standing.overdue_days.filter(|_| gravest == Some(Status::Overdue)) {
        return html! { (t.calibrated) " " (figure::whole_days(days)) " " (t.days_ago) };
    }
    let largest = of_gravest.filter_map(|one| Some((one, one.load?))).max_by(|(_, a), (_, b)| a.total_cmp(b));
    html! {
        @if let Some((one, load)) = largest {
            (symbol(one.coefficient.name())) " " (t.words(&message!("share_of_limit", percent = format!("{:.0}", 100.0 * load))))
        }
    }
}

/// The budget as a tint, zero as a line, the load as a dot with one standard deviation to either side, beside its
/// [`percent`] in words.
pub(super) fn bar(load: Measured, status: Status) -> Markup {
    let half = WIDTH / 2.0 - ARROW;
    let x = |value: f64| WIDTH / 2.0 + half * (value / EDGE).clamp(-1.0, 1.0);
    let at = |value: f64| format!("{:.1}", x(value));
    let (middle, value) = (HEIGHT / 2.0, load.value);
    let tip = WIDTH / 2.0 + (half + ARROW) * value.signum();
    let foot = WIDTH / 2.0 + half * value.signum();
    html! {
        svg.bullet viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } aria-hidden="true" {
            rect x=(at(-1.0)) y="1" width=(format!("{:.1}", x(1.0) - x(-1.0))) height=(HEIGHT - 2.0) {}
            path.level d={ "M" (WIDTH / 2.0) " 0V" (HEIGHT) } {}
            @if value.abs() > EDGE {
                polygon class=(status.name())
                    points={ (foot) "," (middle - 5.0) " " (tip) "," (middle) " " (foot) "," (middle + 5.0) } {}
            } @else {
                @if let Some(sd) = load.sd { path.sd d={ "M" (at(value - sd)) " " (middle) "H" (at(value + sd)) } {} }
                path class=(status.name()) transform={ "translate(" (at(value)) " " (middle) ")" } d=(sign(status)) {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    fn load(value: f64, sd: Option<f64>) -> Measured {
        Measured { value, sd }
    }

    #[test]
    fn a_load_has_its_sign_and_no_more_digits_than_it_deserves() {
        for (value, sd, text) in [
            (2.514, Some(0.069), "+251 ± 7"),
            (-0.0512, Some(0.069), "-5 ± 7"),
            (-0.0512, None, "-5.1"),
            (0.0004, Some(0.004), "0.0 ± 0.4"),
            (0.012, Some(0.004), "+1.2 ± 0.4"),
            (-519.0, Some(0.07), "-51900 ± 7"),
            (0.0, None, "0.0"),
        ] {
            assert_eq!(percent(load(value, sd)), text, "{value}");
        }
    }

    #[test]
    fn a_load_of_ten_budgets_and_more_is_told_in_budgets() {
        let said = |value| share(Language::English.text(), load(value, Some(0.05)));
        assert_eq!([said(9.99), said(-264.68)], ["+999 ± 5 %".to_owned(), "-265 budgets".to_owned()]);
    }

    #[test]
    fn what_is_beyond_the_scale_is_an_arrow_on_its_side() {
        let drawn = |value| bar(load(value, Some(0.07)), Status::Confirmed).into_string();
        assert!(
            drawn(0.5).contains("<path class=\"confirmed\"") && drawn(2.5).contains("<polygon class=\"confirmed\"")
        );
        assert!(drawn(2.5).contains("83,3 90,8 83,13") && drawn(-519.0).contains("7,3 0,8 7,13"), "{}", drawn(2.5));
        // Half the budget is a third of the way from the middle to the edge.
        assert!(drawn(0.5).contains(&format!("translate({:.1} 8)", 45.0 + 38.0 / 3.0)));
    }
}
