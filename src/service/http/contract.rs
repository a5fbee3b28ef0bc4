//! General information of the API.

use utoipa::OpenApi;
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityScheme};

/// General information of the document.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "Contuse",
        description = "What a blunt impact does to soft tissue: submit a scene, follow the run, download the recording.\n\n\
            Research use only: not a medical device, not a diagnosis.",
    ),
    servers((url = "/")),
    security((), ("bearer" = [])),
    modifiers(&Bearer),
    tags(
        (name = "jobs", description = "Scenes that wait, run and end"),
        (name = "studies", description = "Many runs of one scene: error against run time, stability"),
        (name = "meshes", description = "Meshes that scenes can name"),
        (name = "materials", description = "Named sets of material parameters that scenes can use"),
        (name = "service", description = "Health, metrics, schemas and documentation of the service"),
    )
)]
pub struct Contract;

/// Bearer tokens, if the service requires them.
struct Bearer;

impl utoipa::Modify for Bearer {
    fn modify(&self, openapi: &mut utoipa::openapi::OpenApi) {
        let scheme = SecurityScheme::Http(Http::new(HttpAuthScheme::Bearer));
        openapi.components.get_or_insert_default().add_security_scheme("bearer", scheme);
    }
}
