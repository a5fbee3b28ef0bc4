//! The API contract: OpenAPI 3.1, generated from the handlers and therefore consistent with them.

use super::calls::calls;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use std::sync::LazyLock;

static TEXT: LazyLock<String> = LazyLock::new(|| {
    let (_, document) = calls().split_for_parts();
    // Formatted, with a final newline, since it is under version control.
    document.to_pretty_json().unwrap_or_default() + "\n"
});

/// The document as JSON text.
pub fn text() -> &'static str {
    &TEXT
}

/// The document as a page.
pub async fn page() -> Response {
    ([(header::CONTENT_TYPE, "application/json")], text()).into_response()
}
