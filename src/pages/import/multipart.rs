//! The form of the import page: with a file as browsers send it (`multipart/form-data`), or as `text/plain`.

use axum::body::Bytes;
use axum::extract::{FromRequest, Multipart, Request};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;

pub(super) enum Upload {
    Fields(Vec<Field>),
    Plain(String),
}

pub(super) struct Field {
    pub name: String,
    /// Of a file its name; empty where none was chosen.
    pub file: String,
    pub content: Bytes,
}

impl Upload {
    /// # Errors
    /// 413 of a form that is too large, 400 of one that broke off or is none.
    pub async fn of(request: Request) -> Result<Self, StatusCode> {
        let content_type = request.headers().get(CONTENT_TYPE).and_then(|value| value.to_str().ok());
        if !content_type.is_some_and(|kind| kind.starts_with("multipart/form-data")) {
            let text = String::from_request(request, &()).await;
            return text.map(Self::Plain).map_err(|refused| refused.status());
        }
        let mut form = Multipart::from_request(request, &()).await.map_err(|refused| refused.status())?;
        let mut fields = Vec::new();
        while let Some(field) = form.next_field().await.map_err(|error| error.status())? {
            let said = |said: Option<&str>| said.unwrap_or_default().to_owned();
            let (name, file) = (said(field.name()), said(field.file_name()));
            fields.push(Field { name, file, content: field.bytes().await.map_err(|error| error.status())? });
        }
        Ok(Self::Fields(fields))
    }
}
