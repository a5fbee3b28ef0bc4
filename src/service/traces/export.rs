//! Spans for a collector of OpenTelemetry.

use opentelemetry::trace::TracerProvider as _;
use opentelemetry_http::hyper::HyperClient;
use opentelemetry_http::{Bytes, HttpClient, HttpError, Request, Response};
use opentelemetry_otlp::{ExporterBuildError, SpanExporter, WithHttpConfig as _};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::SdkTracerProvider;
use std::pin::Pin;
use std::time::Duration;
use tokio::runtime::{Builder, Handle, Runtime};
use tracing::Level;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::filter_fn;
use tracing_subscriber::registry::LookupSpan;

/// Variables with the address of the collector, of traces alone and of all signals.
const ENDPOINTS: [&str; 2] = ["OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT"];
/// Time allowed to the collector for an answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// Sends spans to a collector (OTLP over HTTP, binary), in batches. The variables of OpenTelemetry configure it.
#[derive(Debug)]
pub struct Exporter {
    provider: SdkTracerProvider,
    // Held for the client, whose connections it drives.
    _runtime: Runtime,
}

/// A client whose requests a runtime drives: batches are sent from a thread of their own.
#[derive(Debug)]
struct DrivenClient {
    client: HyperClient,
    runtime: Handle,
}

impl HttpClient for DrivenClient {
    fn send_bytes<'a, 'b>(
        &'a self,
        request: Request<Bytes>,
    ) -> Pin<Box<dyn Future<Output = Result<Response<Bytes>, HttpError>> + Send + 'b>>
    where
        'a: 'b,
        Self: 'b,
    {
        let client = self.client.clone();
        let sending = self.runtime.spawn(async move { client.send_bytes(request).await });
        Box::pin(async { sending.await? })
    }
}

impl Exporter {
    /// The exporter that the environment asks for; `None` if it names no collector.
    ///
    /// # Errors
    /// If the address is not one, or the system has no thread for it.
    pub fn from_environment() -> Result<Option<Self>, ExporterBuildError> {
        if ENDPOINTS.iter().all(|name| std::env::var_os(name).is_none()) {
            return Ok(None);
        }
        let runtime = Builder::new_multi_thread().worker_threads(1).enable_all().build();
        let runtime = runtime.map_err(|error| ExporterBuildError::InternalFailure(error.to_string()))?;
        let client = HyperClient::with_default_connector(PATIENCE, None);
        let client = DrivenClient { client, runtime: runtime.handle().clone() };
        let exporter = SpanExporter::builder().with_http().with_http_client(client).build()?;
        let mut resource = Resource::builder();
        if std::env::var_os("OTEL_SERVICE_NAME").is_none() {
            resource = resource.with_service_name("contuse");
        }
        let provider = SdkTracerProvider::builder()
            .with_resource(resource.build())
            .with_batch_exporter(exporter)
            .build();
        Ok(Some(Self { provider, _runtime: runtime }))
    }

    /// The layer that records the spans of this program.
    pub fn layer<S: tracing::Subscriber + for<'a> LookupSpan<'a>>(&self) -> impl Layer<S> + use<S> {
        // Spans that the log does not repeat on its lines have the level `debug`.
        let spans = filter_fn(|of| {
            of.target().starts_with("contuse") && (of.is_span() || *of.level() <= Level::INFO)
        });
        tracing_opentelemetry::layer().with_tracer(self.provider.tracer("contuse")).with_filter(spans)
    }
}

impl Drop for Exporter {
    /// Sends what is left.
    fn drop(&mut self) {
        // A collector that does not answer has said so in the log of the library.
        let _ = self.provider.shutdown();
    }
}
