//! Traces of OpenTelemetry: what a request and the run of its job do, whichever processes do it.
//!
//! The context of a request is that of its client (`traceparent`, W3C Trace Context), and is stored with the job, whose run continues it.
//! Without the feature `otel` there are no contexts, and spans are those of the log alone.

#[cfg(feature = "otel")]
mod context;
#[cfg(feature = "otel")]
mod export;

#[cfg(feature = "otel")]
pub use export::Exporter;

use tracing::Span;

/// Header with the context of a trace.
pub const TRACEPARENT: &str = "traceparent";

/// Makes a span, which has not been entered, a part of the trace with a context; a context that is none changes nothing.
pub fn continue_from(span: &Span, traceparent: Option<&str>) {
    #[cfg(feature = "otel")]
    if let Some(traceparent) = traceparent {
        context::continued(span, traceparent);
    }
    #[cfg(not(feature = "otel"))]
    let _ = (span, traceparent);
}

/// Context of a span, for what continues it elsewhere; `None` if it is not traced.
pub fn context_of(span: &Span) -> Option<String> {
    #[cfg(feature = "otel")]
    return context::of(span);
    #[cfg(not(feature = "otel"))]
    {
        let _ = span;
        None
    }
}
