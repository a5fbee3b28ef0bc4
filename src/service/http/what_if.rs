//! `/v1/what-if`: many cases of one scene as one job.

use super::app::App;
use super::extract::{JsonBody, Owner, Sender};
use super::problem::Problem;
use super::submission::{SubmitAnswer, SubmitHeaders, accept};
use super::validation::parsed;
use crate::scene::problem::Pointer;
use crate::scene::{self, Problems};
use crate::service::jobs::engine::JsonDocument;
use crate::service::jobs::{JobId, JobKind};
use crate::study::what_if::WhatIfDocument;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// Longest value of `job` that a refusal repeats [bytes]: an id is shorter.
const LONGEST_SHOWN: usize = 100;

/// Ask a what-if question.
///
/// A base (a scene, or a job by its id) and what varies: explicit cases, one parameter at a time, a sample, limits. It
/// becomes a job: every case is an event `case` under `/v1/jobs/{id}/events` as soon as it is available, in the order
/// of the cases, and the whole answer is `/v1/jobs/{id}/summary`. It has no recording.
#[utoipa::path(
    post, path = "/v1/what-if", tag = "studies", operation_id = "ask_what_if",
    request_body(content = WhatIfDocument, content_type = "application/json"),
    params(SubmitHeaders), responses(SubmitAnswer)
)]
pub async fn ask(
    State(app): State<Arc<App>>,
    Owner(owner): Owner,
    sender: Sender,
    headers: HeaderMap,
    JsonBody(body): JsonBody,
) -> Result<Response, Problem> {
    let completed = async |question| with_scene(&app, (&owner, &sender), question).await;
    accept(&app, &owner, JobKind::WhatIf, &headers, body, completed).await
}

/// Replaces a named job by its scene, so that the question no longer depends on that job. Neither is parsed for that, as their values take
/// many times the memory of their texts.
async fn with_scene(
    app: &App,
    (owner, Sender(sender)): (&str, &Sender),
    question: JsonDocument,
) -> Result<JsonDocument, Problem> {
    // Any other body is left to the validation.
    let Ok(Base { job: Some(job), is_repeated, has_scene }) = serde_json::from_slice(&question.text) else {
        return Ok(question);
    };
    let named: Option<String> = serde_json::from_str(job.get()).ok();
    // The id, or whatever else stands there, unless it is long.
    let shown = Some(job.get()).filter(|text| text.len() <= LONGEST_SHOWN);
    let shown: Value = shown.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default();
    let refuse = |code: &'static str, message: &str, limit: &str, remedy: &str| {
        let problem = scene::Problem::error(code, &Pointer::root().key("job"), message).value(shown.clone());
        let mut all = question.parsed().map(|parsed| parsed.problems.clone()).unwrap_or_default();
        // Whoever parsed a short question has found a repeated key already.
        all.retain(|other| other.pointer != problem.pointer);
        all.push(problem.limit(limit).remedy(remedy));
        let all: Problems = all.into_iter().collect();
        Problem::invalid_scene("question", all)
    };
    if is_repeated {
        return Err(refuse("repeated_key", "\"job\" is written twice", "written once", "keep one of them"));
    }
    // The base must be a job that runs a scene.
    if has_scene {
        return Err(refuse(
            "bad_base",
            "the question has two bases",
            "one of `scene` and `job`",
            "omit one of them",
        ));
    }
    let place = place_of_member(&question.text, job);
    let completed = async {
        let kept = match named.and_then(|text| text.parse::<JobId>().ok()) {
            Some(id) => app.queue.store.document(owner, id).await?,
            None => None,
        };
        let unknown = || refuse("bad_base", "there is no such job", "the id of a job", "see /v1/jobs");
        let (kind, scene) = kept.ok_or_else(unknown)?;
        if let Some(purpose) = kind.purpose() {
            return Err(refuse(
                "no_base",
                &format!("this job {purpose}: it has no scene of its own"),
                "the id of a job that runs a scene",
                "name the job of its base, or send the scene of the base as `scene`",
            ));
        }
        let (before, after) = (&question.text[..place.start], &question.text[place.end..]);
        Ok([before, br#""scene":"#.as_slice(), &scene[..], after].concat())
    };
    // Memory for the scene, and for the question with it.
    let most = 2 * app.config.runs.budget.document_bytes as usize + question.text.len();
    let text = app.bodies.load(sender, most, completed).await?;
    parsed(app, owner, text).await
}

/// What a question varies: a job, as it is written last, or a scene.
#[derive(Default)]
struct Base<'a> {
    job: Option<&'a RawValue>,
    is_repeated: bool,
    has_scene: bool,
}

impl<'de> Deserialize<'de> for Base<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Self::default())
    }
}

impl<'de> Visitor<'de> for Base<'de> {
    type Value = Self;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a question")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut members: A) -> Result<Self, A::Error> {
        while let Some(key) = members.next_key::<Cow<'_, str>>()? {
            match &*key {
                "job" => self.is_repeated = self.job.replace(members.next_value()?).is_some(),
                other => {
                    self.has_scene |= other == "scene";
                    members.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(self)
    }
}

/// Where a member is in a text, of which `value` is a part: from the quotation mark before its key, which has none in it.
fn place_of_member(text: &[u8], value: &RawValue) -> Range<usize> {
    let start = value.get().as_ptr().addr() - text.as_ptr().addr();
    let quote = |end: usize| text[..end].iter().rposition(|byte| *byte == b'"').unwrap_or_default();
    quote(quote(start))..start + value.get().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_is_found_where_it_stands() {
        for (before, member, after) in [
            (r#"{"a": {"job": 1}, "#, r#""job": "x y""#, r#", "cases": [{"job": "z"}]}"#),
            ("{", r#""j\u006fb" : [1, "}"]"#, "}"),
            (r#"{"say \"job\"": 1,"#, r#""job":null"#, r#","b":{}}"#),
        ] {
            let text = format!("{before}{member}{after}");
            let base: Base<'_> = serde_json::from_str(&text).unwrap();
            let place = place_of_member(text.as_bytes(), base.job.unwrap());
            assert_eq!((&text[place.clone()], &text[..place.start]), (member, before));
        }
        let none: Base<'_> = serde_json::from_str(r#"{"a": "job", "scene": 1}"#).unwrap();
        assert!(none.job.is_none() && none.has_scene);
        assert!(serde_json::from_str::<Base<'_>>("[1]").is_err());
    }
}
