//! Contexts of traces as texts.

use opentelemetry::propagation::TextMapPropagator as _;
use opentelemetry::trace::TraceContextExt as _;
use opentelemetry_sdk::propagation::TraceContextPropagator;
use std::collections::HashMap;
use tracing::Span;
use tracing_opentelemetry::OpenTelemetrySpanExt as _;

/// Name of the field with a context.
const FIELD: &str = "traceparent";

/// Makes a span a part of the trace with a context.
pub(super) fn continued(span: &Span, traceparent: &str) {
    let carrier = HashMap::from([(FIELD.to_owned(), traceparent.to_owned())]);
    let context = TraceContextPropagator::new().extract(&carrier);
    if context.span().span_context().is_valid() {
        // Only a span that has begun elsewhere, or is not recorded, refuses it.
        let _ = span.set_parent(context);
    }
}

/// Context of a span.
pub(super) fn of(span: &Span) -> Option<String> {
    let mut carrier = HashMap::new();
    TraceContextPropagator::new().inject_context(&span.context(), &mut carrier);
    carrier.remove(FIELD)
}
