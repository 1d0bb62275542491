//! `notify` and `more` of a query: who is told of what is found late.

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use url::form_urlencoded;

use super::query::not_one_of;
use crate::core::alert_decision::Late;
use crate::http::prelude::*;

/// What a request that brings measurements says of telling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct NotifyQuery {
    /// How what fires since longer than `alerts.backfill_days` is told. `all`: every change of every alert by itself.
    /// `digest`: what fires still, in one message at the end of the import; so for an import unless it is given.
    /// `none`: not at all.
    #[param(value_type = Option<String>)]
    notify: Option<Late>,
    /// `true`: more requests of the same import follow. The digest comes after the last, which may be empty, or a
    /// quarter of an hour after nothing has come.
    #[param(value_type = Option<bool>)]
    more: bool,
}

impl<S: Send + Sync> FromRequestParts<S> for NotifyQuery {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Answer<Self> {
        Self::of(parts.uri.query().unwrap_or_default())
    }
}

impl NotifyQuery {
    fn of(query: &str) -> Answer<Self> {
        let mut notify_query = Self::default();
        for (name, value) in form_urlencoded::parse(query.as_bytes()) {
            match (&*name, &*value) {
                ("notify", "all") => notify_query.notify = Some(Late::Told),
                ("notify", "digest") => notify_query.notify = Some(Late::Digest),
                ("notify", "none") => notify_query.notify = Some(Late::Never),
                ("notify", other) => return Err(not_one_of("notify", ["all", "digest", "none"], other)),
                ("more", "true") => notify_query.more = true,
                ("more", "false") => notify_query.more = false,
                ("more", other) => return Err(not_one_of("more", ["true", "false"], other)),
                _ => {}
            }
        }
        Ok(notify_query)
    }

    /// How what is found late is told: as was asked, else as `usual`.
    pub fn late_or(self, usual: Late) -> Late {
        self.notify.unwrap_or(usual)
    }

    /// After all of a request is stored: an import has come to its end, unless more of it is to follow.
    pub async fn end(self, app: &App, late: Late) {
        if late != Late::Digest || self.more {
            return;
        }
        if let Err(error) = app.pipeline.ingest.end_import().await {
            tracing::warn!(%error, "the digest of an import could not be queued; it is when nothing has come for a while");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_is_read_and_what_cannot_be_is_refused_with_the_choices() {
        assert_eq!(NotifyQuery::of("").unwrap(), NotifyQuery::default());
        assert_eq!(NotifyQuery::of("").unwrap().late_or(Late::Quiet), Late::Quiet);
        for (asked, late) in [("all", Late::Told), ("digest", Late::Digest), ("none", Late::Never)] {
            let notify_query = NotifyQuery::of(&format!("x=1&notify={asked}&more=true")).unwrap();
            assert_eq!((notify_query.late_or(Late::Quiet), notify_query.more), (late, true));
        }
        for (wrong, says) in [("notify=some", "all, digest, none"), ("more=1", "true, false")] {
            let problem = NotifyQuery::of(wrong).unwrap_err();
            assert_eq!(problem.status, 400);
            let (code, log) = (&problem.message.code, problem.message.to_string());
            assert!(code == "parameter_one_of" && log.contains(says), "{log}");
        }
    }
}
