//! The command line: one file per subcommand. Results go to `out`, which is standard output outside tests.

pub mod contact_problem;
pub mod convert;
#[cfg(feature = "service")]
pub mod doctor;
mod exit;
pub mod export;
mod input_file;
#[cfg(feature = "service")]
mod job_process;
mod json;
pub mod keep;
pub mod log;
pub mod material;
mod material_fit;
mod material_path;
pub mod materials;
pub mod mesh;
mod mesh_file;
mod mesh_picture;
mod output_file;
pub mod plan;
mod recording_output;
pub mod report;
pub mod run;
pub mod scene;
pub mod schema;
#[cfg(feature = "service")]
pub mod serve;
pub mod study;
mod study_bulk_modulus;
mod study_coverage;
pub mod study_error;
pub mod study_stability;
#[cfg(feature = "service")]
mod this_process;
#[cfg(feature = "service")]
pub mod token;
pub mod validate;
pub mod what_if;
mod what_if_table;
mod what_if_words;
#[cfg(feature = "service")]
mod work_args;
#[cfg(feature = "service")]
pub mod worker;

mod performance_profile;
mod picture;
mod plot;

pub use exit::{CliError, Exit};

use clap::{Parser, Subcommand};
use std::io::Write;

/// Simulates blunt impact on soft tissue.
///
/// Exit codes: 0 success, 1 unexpected error, 2 invalid input, 3 the run failed with a diagnosis, 4 cancelled, 5 the
/// run finished but its results are withheld (a check failed, or a law was used beyond its declared limits).
#[derive(Debug, Parser)]
#[command(name = "contuse", version, max_term_width = 110)]
pub struct Cli {
    /// Subcommand to execute, with its arguments.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Log filter if `RUST_LOG` is not set: a service logs its activity, a command only warnings.
    pub fn default_log(&self) -> &'static str {
        if self.is_service() || self.is_read_by_service() { "warn,contuse=info" } else { "warn" }
    }

    /// Whether this process serves, or runs the jobs of others.
    pub fn is_service(&self) -> bool {
        match self.command {
            #[cfg(feature = "service")]
            Command::Serve(_) | Command::Worker(_) => true,
            _ => false,
        }
    }

    /// Whether the log is to be lines of JSON.
    pub fn logs_json(&self) -> bool {
        match &self.command {
            #[cfg(feature = "service")]
            Command::Serve(args) => args.work.logs_json(),
            #[cfg(feature = "service")]
            Command::Worker(args) => args.work.logs_json(),
            _ => false,
        }
    }

    /// Whether a service reads the log and adds the time and the job to each line.
    pub fn is_read_by_service(&self) -> bool {
        match self.command {
            #[cfg(feature = "service")]
            Command::JobProcess => true,
            _ => false,
        }
    }
}

/// Subcommands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scene and record it.
    Run(run::RunArgs),
    /// Report all errors in a scene, without running it.
    Validate(validate::ValidateArgs),
    /// Show the plan of a scene: what is kept, what is omitted and why, and the expected cost.
    Plan(plan::PlanArgs),
    /// Many runs: error against run time, stability on extreme cases, coverage of the error bars, savings of omitted
    /// computations.
    #[command(subcommand)]
    Study(study::StudyCommand),
    /// Vary a scene: cases, sensitivities, spread, and the parameter values up to which limits are met.
    WhatIf(what_if::WhatIfArgs),
    /// Write a report on a recording, or on a scene that is run for it: one HTML page with pictures.
    Report(report::ReportArgs),
    /// Export a recording to other formats: a FHIR bundle, tables, fields for ParaView, surfaces.
    Export(export::ExportArgs),
    /// Evaluate a constitutive law: energy and stresses at a point or along a path; `fit` its parameters to curves.
    Material(material::MaterialArgs),
    /// List the named sets of material parameters that scenes can use, with their sources.
    Materials(materials::MaterialsArgs),
    /// Inspect mesh files and scans: kinds, parts, sets, quality.
    #[command(subcommand)]
    Mesh(mesh::MeshCommand),
    /// Write a mesh file in another format.
    Convert(convert::ConvertArgs),
    /// Create a scene from a mesh, a scan or a FEBio file.
    #[command(subcommand)]
    Scene(scene::SceneCommand),
    /// Solve saved frictional contact problems, and compare solvers on them.
    ContactProblem(contact_problem::ContactProblemArgs),
    /// Print the JSON Schema of the scene document.
    Schema,
    /// Serve jobs over HTTP.
    #[cfg(feature = "service")]
    Serve(Box<serve::ServeArgs>),
    /// Run the jobs of a database, without answering requests.
    #[cfg(feature = "service")]
    Worker(Box<worker::WorkerArgs>),
    /// Run one job of a service, which starts this command.
    #[cfg(feature = "service")]
    #[command(hide = true)]
    JobProcess,
    /// Print the OpenAPI document of the service.
    #[cfg(feature = "service")]
    Openapi,
    /// Delete old jobs and meshes from the data folder of a service that is not running.
    #[cfg(feature = "service")]
    Purge(serve::PurgeArgs),
    /// Report what is damaged or lost in the data folder of a service, and what can be recovered.
    #[cfg(feature = "service")]
    Doctor(doctor::DoctorArgs),
    /// Make a bearer token for a service.
    #[cfg(feature = "service")]
    Token(token::TokenArgs),
    /// Check whether a service is ready.
    #[cfg(feature = "service")]
    Health(serve::HealthArgs),
}

/// Executes the command.
///
/// # Errors
/// Why it could not be executed; errors in a scene are part of the output instead.
pub fn dispatch(cli: Cli, out: &mut dyn Write) -> Result<Exit, CliError> {
    match cli.command {
        Command::Run(args) => run::run(&args, out),
        Command::Validate(args) => validate::validate(&args, out),
        Command::Plan(args) => plan::plan(&args, out),
        Command::Study(command) => study::study(&command, out),
        Command::WhatIf(args) => what_if::what_if(&args, out),
        Command::Report(args) => report::report(&args, out),
        Command::Export(args) => export::export(&args, out),
        Command::Material(args) => material::material(&args, out),
        Command::Materials(args) => materials::materials(&args, out),
        Command::Mesh(command) => mesh::mesh(&command, out),
        Command::Convert(args) => convert::convert(&args, out),
        Command::Scene(command) => scene::scene(&command, out),
        Command::ContactProblem(args) => contact_problem::contact_problem(&args, out),
        Command::Schema => schema::print(out),
        #[cfg(feature = "service")]
        Command::Serve(args) => serve::serve(*args, out),
        #[cfg(feature = "service")]
        Command::Worker(args) => worker::worker(*args, out),
        #[cfg(feature = "service")]
        Command::JobProcess => job_process::job_process(),
        #[cfg(feature = "service")]
        Command::Openapi => serve::print_openapi(out),
        #[cfg(feature = "service")]
        Command::Purge(args) => serve::purge(&args, out),
        #[cfg(feature = "service")]
        Command::Doctor(args) => doctor::doctor(&args, out),
        #[cfg(feature = "service")]
        Command::Token(args) => token::token(&args, out),
        #[cfg(feature = "service")]
        Command::Health(args) => serve::health(&args),
    }
}
