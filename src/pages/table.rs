//! Tables that scroll sideways by themselves, with the keyboard too, where a screen is narrower than they are.

use super::prelude::*;
/// `class`: of the style sheet, or empty; `heads`: the cells of its head.
pub(super) fn wide_table(class: &str, heads: Markup, rows: Markup) -> Markup {
    scrolled("scroll", class, &heads, &rows)
}

/// One that scrolls up and down too, for it may be long.
pub(super) fn tall_table(class: &str, heads: Markup, rows: Markup) -> Markup {
    scrolled("scroll tall", class, &heads, &rows)
}

fn scrolled(frame: &str, class: &str, heads: &Markup, rows: &Markup) -> Markup {
    html! {
        div class=(frame) tabindex="0" { table class=[Some(class).filter(|class| !class.is_empty())] {
            thead { tr { (heads) } }
            tbody { (rows) }
        } }
    }
}
