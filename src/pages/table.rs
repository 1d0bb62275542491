//! Tables that scroll sideways by themselves, with the keyboard too, where a screen is narrower than they are.

use maud::{Markup, html};

/// `class`: of the style sheet, or empty; `heads`: the cells of its head.
pub(super) fn wide_table(class: &str, heads: Markup, rows: Markup) -> Markup {
    html! {
        div.scroll tabindex="0" { table class=[Some(class).filter(|class| !class.is_empty())] {
            thead { tr { (heads) } }
            tbody { (rows) }
        } }
    }
}
