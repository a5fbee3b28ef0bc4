//! What all handlers share.

use super::attempts::Attempts;
use super::bodies::Bodies;
use super::rates::Rates;
use super::slots::{Slots, ValidationSlots};
use crate::service::access::Access;
use crate::service::audit::Audit;
use crate::service::config::ServiceConfig;
use crate::service::jobs::queue::Queue;
use crate::service::metrics::Metrics;
use crate::service::permits::AllPermits;
use crate::service::readiness::Readiness;
use std::sync::Arc;

/// Shared state of the handlers.
pub struct App {
    /// Queue that stores, starts and stops jobs.
    pub queue: Arc<Queue>,
    /// Limits of the service.
    pub config: Arc<ServiceConfig>,
    /// Tokens that grant access.
    pub access: Arc<Access>,
    /// Counters served to Prometheus.
    pub metrics: Arc<Metrics>,
    /// Whether the service accepts work.
    pub readiness: Readiness,
    /// Log of who did what.
    pub audit: Arc<Audit>,
    /// Wrong tokens of each address.
    pub attempts: Attempts,
    /// Requests of each owner.
    pub rates: Rates,
    /// Limits of uploads, downloads and event streams.
    pub permits: AllPermits,
    /// Memory of bodies.
    pub bodies: Bodies,
    /// Threads for the validation of scenes and meshes.
    pub validation_slots: ValidationSlots,
    /// Threads for archives, which are made as fast as their clients read: they delay no validation.
    pub exports: Slots,
}
