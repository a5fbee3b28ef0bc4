//! `/`, `/docs/` and `/viewer/…`: the viewer, a web page that reads the same recordings as any other client.
//!
//! Its files are those of `api/viewer/`, embedded in the binary: plain ES modules, without a build step or external
//! resources. A development build reads them from the folder on request, so changes show after a reload, new modules after a restart.

use super::preloads::{import_map, with_preloads};
use super::problem::Problem;
use crate::study::what_if::name_of_build;
use axum::extract::Path;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use rust_embed::Embed;
use sha2::{Digest, Sha256};
use std::sync::LazyLock;

/// Embedded files of the viewer.
#[derive(Embed)]
#[folder = "api/viewer/"]
struct ViewerFiles;

/// An example scene: its file in `scenarios/`, and the contents.
macro_rules! preset {
    ($path:literal) => {
        ($path, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/", $path)))
    };
}

/// Scenarios without mesh files, which would need uploads first.
const PRESETS: [(&str, &str); 8] = [
    preset!("flashball_thigh/scene.json"),
    preset!("flashball_thigh/scene_elastic.json"),
    preset!("flashball_thigh/scene_44mm.json"),
    preset!("steel_ball_on_thigh/scene.json"),
    preset!("block_on_incline/scene.json"),
    preset!("two_bars/scene.json"),
    preset!("bar_on_wall/scene.json"),
    preset!("hollow_ball_breathing/scene.json"),
];

/// The page of the viewer with links to its modules and the name of the build; the modules are searched once.
static PAGE: LazyLock<Option<String>> = LazyLock::new(|| {
    let named = format!("<html data-build=\"{}\" ", name_of_build());
    Some(with_preloads(&source("index.html")?.replacen("<html ", &named, 1), source))
});

/// Text of a file of the viewer.
fn source(name: &str) -> Option<String> {
    Some(String::from_utf8_lossy(&ViewerFiles::get(name)?.data).into_owned())
}

/// `/`: the page of the viewer.
pub async fn page(headers: HeaderMap) -> Result<Response, Problem> {
    send_page(PAGE.as_ref().ok_or_else(Problem::no_such_address)?, &headers)
}

/// `/docs/`: the API documentation as a page.
pub async fn docs(headers: HeaderMap) -> Result<Response, Problem> {
    let file = ViewerFiles::get("docs.html").ok_or_else(Problem::no_such_address)?;
    send_page(&String::from_utf8_lossy(&file.data), &headers)
}

/// Sends a page with its content security policy.
fn send_page(page: &str, headers: &HeaderMap) -> Result<Response, Problem> {
    let policy = content_security_policy(page);
    let mut response = send("page.html", page.as_bytes().to_vec(), &Sha256::digest(page), headers);
    let policy = policy.try_into().map_err(|e| Problem::internal(&e))?;
    response.headers_mut().insert(header::CONTENT_SECURITY_POLICY, policy);
    Ok(response)
}

/// A module, style sheet or licence of the viewer.
pub async fn file(Path(path): Path<String>, headers: HeaderMap) -> Result<Response, Problem> {
    let file = ViewerFiles::get(&path).ok_or_else(Problem::no_such_address)?;
    Ok(send(&path, file.data.into_owned(), &file.metadata.sha256_hash(), &headers))
}

/// The example scenes: `[{"file": …, "scene": …}]`, each document with its original order of members.
pub async fn presets() -> Response {
    let presets = PRESETS.map(|(file, scene)| format!("{{\"file\": \"{file}\", \"scene\": {scene}}}"));
    ([(header::CONTENT_TYPE, "application/json")], format!("[{}]", presets.join(","))).into_response()
}

/// Sends a file, which has this SHA-256, with its media type, or 304 if the browser has it already.
fn send(path: &str, data: Vec<u8>, hash: &[u8], headers: &HeaderMap) -> Response {
    let etag = format!("\"{}\"", BASE64_STANDARD.encode(hash));
    let described = [
        (header::CONTENT_TYPE, media_type(path)),
        // It may change with the binary: revalidate every time.
        (header::CACHE_CONTROL, "no-cache"),
        (header::ETAG, etag.as_str()),
    ];
    if headers.get(header::IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == etag.as_bytes()) {
        return (StatusCode::NOT_MODIFIED, described).into_response();
    }
    (described, data).into_response()
}

/// Media type by the file extension. Browsers run modules of the proper type only.
fn media_type(path: &str) -> &'static str {
    match path.rsplit_once('.').map_or("", |(_, end)| end) {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "svg" => "image/svg+xml",
        _ => "text/plain; charset=utf-8",
    }
}

/// Policy: scripts of this service only, in the page itself only its import map, by digest; no connections to other
/// hosts.
fn content_security_policy(page: &str) -> String {
    let digest = BASE64_STANDARD.encode(Sha256::digest(import_map(page)));
    format!(
        "default-src 'none'; script-src 'self' 'sha256-{digest}'; style-src 'self'; img-src 'self' blob: data:; \
         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}
