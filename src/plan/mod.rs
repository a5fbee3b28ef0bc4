//! The plan: a scene compiled to what it needs. Immutable during the run; features that are not needed are absent.

mod blocks;
mod body;
mod by_pair;
mod capped_bulk;
mod compile;
mod compiled;
mod contact;
mod contact_mass;
mod contact_plan;
mod cost;
mod distant;
mod holder;
mod integrator;
mod loads;
mod measure_plan;
mod memory;
mod named_materials;
mod omitted;
mod parts;
mod report;
mod reporting;
mod requested;
mod rigid;
mod sector;
mod stable_step;
mod statics;
mod stepping;
#[cfg(test)]
mod tests;

pub use body::PlanBody;
pub use by_pair::{ByPair, MOST_LISTED_BODIES, MOST_LISTED_PAIRS};
pub use compiled::{Plan, SectorPlan};
pub use contact_plan::ContactPlan;
pub use distant::DistantPair;
pub use holder::Holder;
pub use integrator::{DynamicRelaxation, Explicit, Implicit, Integrator, SystemSize};
pub use loads::{FacePressure, LoadTime, Loads, NodalForces, Prescribed, Ramp};
pub use measure_plan::{ForceAverage, MeasurePlan, TissueEnd};
pub use memory::{FIELD_COPIES, FRAME_COPIES};
pub use named_materials::NamedMaterialReport;
pub use parts::CompileError;
pub use report::{
    BlockReport, IntegratorReport, MemoryReport, Omitted, PairReport, PlanReport, RefinementReport,
    RigidReport,
};
pub use rigid::RigidPlan;
pub use sector::mapping::Sector;
pub use sector::{compile, recompile};
pub use stable_step::{ElementsWithin, StableStepReport};
pub use statics::{Statics, UnderConstrained};
