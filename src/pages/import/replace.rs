//! The form that puts a document in the place of the one that is stored for its IMU and time.

use crate::pages::form::who;
use crate::pages::prelude::*;
use crate::pipeline::Refused;

/// What stands in the way of a document, and the form that puts it in its place.
pub(super) fn offer(viewer: &Viewer, why: &Refused, text: &str) -> Markup {
    let t = viewer.text();
    let Refused::Differs { existing, .. } = why else { return html! {} };
    let by = viewer.signed_in.as_deref().unwrap_or_default();
    html! {
        p { a href={ "/records/" (existing) } { (t.look_at_stored) } }
        @if viewer.may(Role::Engineer) {
            details {
                summary { (t.replace_it) }
                form.deed action="/import/replace" method="post" {
                    input type="hidden" name="id" value=(existing);
                    textarea name="text" hidden { (text) }
                    (who(t, by))
                    label { (t.reason_word) textarea name="reason" rows="2" required maxlength="4096" {} }
                    label.sure { input type="checkbox" name="confirm" value="yes" required; span { (t.replace_what) } }
                    p { button.primary { (t.replace_it) } }
                }
            }
        }
    }
}
