//! Validation of documents, in slots that owners share.

use super::app::App;
use super::problem::{Problem, VALIDATION_WAIT_S};
use crate::scene::Problems;
use crate::service::fair_queue::Lane;
use crate::service::jobs::JobKind;
use crate::service::jobs::engine::{JsonDocument, NOT_JSON, NOT_VALIDATED};
use crate::service::jobs::held_text::HeldText;
use crate::service::meshes::{MeshShelf, is_id};
use std::sync::Arc;

/// Largest number of elements of a scene that is validated in well below a second.
const SMALL_SCENE: u64 = 20_000;

/// Reads a document in a slot of validation: it may have megabytes.
pub(super) async fn parsed(app: &App, owner: &str, text: HeldText) -> Result<JsonDocument, Problem> {
    let read = app.validation_slots.call(owner, Lane::Small, move || JsonDocument::read(text)).await?;
    read.map_err(|e| Problem::bad_json(&e))
}

/// Validates a document with its scene, given the meshes of its owner and whether its client still waits. Large scenes have a queue of their own. One that names meshes is
/// refused while the object store, which has them, does not answer.
pub(super) async fn validated<T: Send + 'static>(
    app: &Arc<App>,
    owner: &str,
    kind: JobKind,
    document: JsonDocument,
    check: impl FnOnce(JsonDocument, &MeshShelf, &dyn Fn() -> bool) -> Result<T, Problems> + Send + 'static,
) -> Result<T, Problem> {
    let (shelf, engine) = (app.queue.shelf(owner), Arc::clone(&app.queue.engine));
    let names_meshes = names_meshes(&document.text);
    let if_small = move |is_wanted: &dyn Fn() -> bool| {
        if engine.elements(kind, &document, &shelf) <= SMALL_SCENE {
            Ok(check(document, &shelf, is_wanted))
        } else {
            Err(move |is_wanted: &dyn Fn() -> bool| check(document, &shelf, is_wanted))
        }
    };
    let checked = async {
        match app.validation_slots.call_while_wanted(owner, Lane::Small, if_small).await? {
            Ok(checked) => Ok(checked),
            Err(large) => app.validation_slots.call_while_wanted(owner, Lane::Large, large).await,
        }
    };
    let checked = if names_meshes { app.queue.unless_silent(checked).await? } else { checked.await };
    checked?.map_err(|errors| match errors.0.as_slice() {
        [one] if one.code == NOT_JSON => Problem::not_json(one.message.clone()),
        [one] if one.code == NOT_VALIDATED => Problem::busy(
            format!("The {} was not checked: {}.", kind.document(), one.message),
            VALIDATION_WAIT_S,
        ),
        _ => Problem::invalid_scene(kind.document(), errors),
    })
}

/// Whether a document names uploaded meshes, wherever it does.
fn names_meshes(text: &[u8]) -> bool {
    text.split(|byte| *byte == b'"').any(|part| std::str::from_utf8(part).is_ok_and(is_id))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blobs::BlobStore;
    use crate::service::audit::Audit;
    use crate::service::config::ServiceConfig;
    use crate::service::http::{Rates, Slots, ValidationSlots};
    use crate::service::jobs::data_folder::DataFolder;
    use crate::service::jobs::pulse::Pulse;
    use crate::service::jobs::pulse::tests::{Distant, distant};
    use crate::service::jobs::queue::{Queue, Storage};
    use crate::service::jobs::simulator::Simulator;
    use crate::service::jobs::store::StoreAddress;
    use crate::service::permits::AllPermits;
    use axum::http::{StatusCode, header};
    use axum::response::IntoResponse as _;
    use std::path::Path;
    use std::sync::atomic::Ordering;
    use std::time::{Duration, Instant};

    /// A service whose blobs are on other machines.
    async fn service(dir: &Path) -> (Arc<App>, Arc<Distant>, Arc<Pulse>) {
        let (folder, blobs) = (DataFolder::open(dir).unwrap(), distant(dir));
        let pulse = Arc::new(Pulse::of(Arc::clone(&blobs) as Arc<dyn BlobStore>, None));
        let jobs = StoreAddress::in_folder(dir).open().await.unwrap();
        let config = Arc::new(ServiceConfig::default());
        let engine = Arc::new(Simulator::new(&config.runs));
        let storage =
            Storage { jobs, blobs: Arc::clone(&blobs) as _, pulse: Some(Arc::clone(&pulse)), folder };
        let queue = Queue::new(storage, Arc::clone(&config), engine, Arc::default());
        let app = App {
            queue,
            validation_slots: ValidationSlots::new(crate::service::validations(&config)),
            permits: AllPermits::of(config.max_connections),
            config,
            access: Arc::default(),
            metrics: Arc::default(),
            readiness: crate::service::readiness::Readiness::default(),
            audit: Arc::new(Audit::open(dir, u64::MAX).unwrap()),
            attempts: crate::service::http::Attempts::default(),
            rates: Rates::new(1),
            bodies: crate::service::http::Bodies::default(),
            exports: Slots::new(1),
        };
        (Arc::new(app), blobs, pulse)
    }

    /// Validates a document for so long.
    async fn answer(app: &Arc<App>, document: &str, takes: Duration) -> Result<(), Problem> {
        let document = JsonDocument::read(Vec::from(document).into()).unwrap();
        validated(app, "", JobKind::Study, document, move |_, _, _| {
            std::thread::sleep(takes);
            Ok(())
        })
        .await
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn only_scenes_that_name_meshes_are_refused_while_the_object_store_is_silent() {
        let dir = tempfile::tempdir().unwrap();
        let (app, blobs, pulse) = service(dir.path()).await;
        let naming = format!(
            r#"{{"scene": {{"bodies": [{{"mesh": {{"file": {{"name": "{}"}}}}}}]}}}}"#,
            "0a".repeat(32)
        );
        answer(&app, &naming, Duration::ZERO).await.unwrap();
        // One that waits for its meshes is refused when the outage is noticed, and later ones at once.
        let begun = Instant::now();
        blobs.is_down.store(true, Ordering::SeqCst);
        let waiting = answer(&app, &naming, Duration::from_secs(5));
        let noticed = async {
            tokio::time::sleep(Duration::from_millis(50)).await;
            tokio::task::spawn_blocking(move || pulse.ask()).await.unwrap()
        };
        let (waiting, is_felt) = futures::join!(waiting, noticed);
        assert!(!is_felt);
        for refused in [waiting, answer(&app, &naming, Duration::from_secs(5)).await] {
            let response = refused.unwrap_err().into_response();
            assert_eq!(response.status(), StatusCode::SERVICE_UNAVAILABLE);
            assert!(response.headers().contains_key(header::RETRY_AFTER));
        }
        assert!(begun.elapsed() < Duration::from_secs(4), "{:?}", begun.elapsed());
        answer(&app, r#"{"scene": {"name": "a"}}"#, Duration::ZERO).await.unwrap();
    }
}
