//! Reads a recording: the summary, and force and energy over time, with one chunk in memory at a time.

use super::instant::{Instant, instant};
use crate::measure::summary::{Accuracy, InjuryMeasure, Numerics, RelaxationOfBody, Results};
use crate::record::RecordError;
use crate::record::proto::foxglove::Vector3;
use crate::record::reader::for_each_record_of;
use crate::step::Failure;
use ::mcap::McapError;
use ::mcap::records::Record;
use prost::Message as _;
use serde::Deserialize;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

/// Bytes read from the file at a time.
const PIECE: usize = 256 << 10;

/// Why a recording cannot be reported on.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error("cannot read {0}")]
    File(#[from] RecordError),
    /// The file is not MCAP, or is damaged.
    #[error("{path} is not a readable recording: {source}")]
    Mcap {
        /// The file, as it was given.
        path: PathBuf,
        /// Error of the MCAP reader.
        source: McapError,
    },
    /// The fields of the recording cannot be exported.
    #[error("cannot export the fields: {0}")]
    Fields(#[source] RecordError),
    /// There are no fields at a requested time.
    #[error("{path} has no fields at {} ms: they are from {} to {} ms", 1e3 * requested, 1e3 * first, 1e3 * last)]
    NoSuchTime {
        /// The file, as it was given.
        path: PathBuf,
        /// The requested time [s].
        requested: f64,
        /// First field time [s].
        first: f64,
        /// Last field time [s].
        last: f64,
    },
    /// The numbers of its summary are not those of this version.
    #[error("the numbers of {path} are not those of this version of the program: {source}")]
    Numbers {
        /// The file, as it was given.
        path: PathBuf,
        /// What is missing or of another kind.
        source: serde_json::Error,
    },
    /// There is no summary: the run did not end, or another program wrote the file.
    #[error("{path} has no summary: the run did not end, or another program wrote the file")]
    NoSummary {
        /// The file, as it was given.
        path: PathBuf,
    },
}

/// An instant that stands for a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Worst {
    /// Its time [s].
    pub time_s: f64,
    /// What happens then: "the peak force".
    pub what: &'static str,
}

/// A function of time: (t [s], value).
pub type Series = Vec<(f64, f64)>;

/// Time series of one contact pair.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedPair {
    /// Times of the recorded steps [s].
    pub time_s: Vec<f64>,
    /// Impulse on the slave up to each time [N s].
    pub impulse_n_s: Vec<[f64; 3]>,
    /// Patch area at each time [m²].
    pub patch_area_m2: Vec<f64>,
}

/// The contents of a recording that a report needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedRun {
    /// Summary written at the end of the run.
    pub summary: Value,
    /// Its numbers, withheld or not; `None` where a withheld one is not finite.
    pub values: Option<Results>,
    /// The quality of its computation; `None` where a number of a withheld run is not finite.
    pub numerics: Option<Numerics>,
    /// Energy of the branches of relaxation.
    pub relaxation: Vec<RelaxationOfBody>,
    /// Its accuracy, if one was requested.
    pub accuracy: Option<Accuracy>,
    /// Why it failed.
    pub failure: Option<Failure>,
    /// Published injury criteria, as the summary evaluated them.
    pub criteria: Vec<InjuryMeasure>,
    /// Scene document in the recording.
    pub scene: Value,
    /// Metadata of the run: engine version, commit, scene hash.
    pub metadata: BTreeMap<String, String>,
    /// Contact pairs, by name.
    pub pairs: BTreeMap<String, RecordedPair>,
    /// Kinetic and strain energy of each body [J].
    pub bodies: BTreeMap<String, Series>,
    /// Energy absorbed by the tissue [J].
    pub absorbed: Series,
    /// Total energy in the ledger [J].
    pub total: Series,
    /// The bodies at the field time nearest to the worst instant; `None` if no fields were recorded.
    pub instant: Option<Instant>,
    /// SHA-256 of the recording, in hexadecimal digits.
    pub digest: String,
}

/// The required fields of `/contact/forces`; the contacts themselves are not decoded.
#[derive(Clone, PartialEq, prost::Message)]
struct Forces {
    #[prost(double, tag = "1")]
    time_s: f64,
    #[prost(message, repeated, tag = "3")]
    pairs: Vec<PairForces>,
}

#[derive(Clone, PartialEq, prost::Message)]
struct PairForces {
    #[prost(string, tag = "1")]
    pair: String,
    #[prost(message, optional, tag = "6")]
    impulse_n_s: Option<Vector3>,
    #[prost(double, tag = "8")]
    patch_area_m2: f64,
}

impl RecordedRun {
    /// Reads a recording from a file.
    ///
    /// # Errors
    /// When the file cannot be read, or has no summary.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let file = File::open(path).map_err(|source| RecordError::File { path: path.to_owned(), source })?;
        Self::of(file, path)
    }

    /// As [`RecordedRun::read`], from any input; `name` is its name in errors.
    ///
    /// # Errors
    /// As [`RecordedRun::read`].
    pub fn of(mut input: impl Read + Seek, name: &Path) -> Result<Self, ReadError> {
        let (mut run, mut topics) = (Self::default(), BTreeMap::new());
        let broken_off = for_each_record_of(&mut input, name, |record| {
            run.take(record, &mut topics);
            Ok(())
        })?;
        if let Some(source) = broken_off {
            return Err(ReadError::Mcap { path: name.to_owned(), source });
        }
        if run.summary.is_null() {
            return Err(ReadError::NoSummary { path: name.to_owned() });
        }
        run.take_numbers().map_err(|source| ReadError::Numbers { path: name.to_owned(), source })?;
        run.instant = instant(&mut input, name, run.worst().time_s)?;
        run.digest = digest(&mut input, name)?;
        Ok(run)
    }

    /// Takes the numbers from the summary.
    pub(super) fn take_numbers(&mut self) -> Result<(), serde_json::Error> {
        let of = |name: &str| self.summary.get(name);
        self.values = match of("results") {
            Some(results) => Some(Results::deserialize(results)?),
            None => finite(self.summary.pointer("/withheld/values"), true)?,
        };
        let is_withheld = of("withheld").is_some();
        self.numerics = finite(of("numerics"), is_withheld)?;
        self.relaxation = finite(of("relaxation"), is_withheld)?.unwrap_or_default();
        self.accuracy = of("accuracy").map(Accuracy::deserialize).transpose()?;
        self.failure = of("failure").map(Failure::deserialize).transpose()?;
        self.criteria = of("injury_measures").map(Vec::deserialize).transpose()?.unwrap_or_default();
        Ok(())
    }

    /// The results, unless they are withheld.
    pub fn results(&self) -> Option<&Results> {
        self.values.as_ref().filter(|_| self.withheld().is_none())
    }

    /// Why the results are withheld.
    pub fn withheld(&self) -> Option<&str> {
        self.summary.pointer("/withheld/reason")?.as_str()
    }

    /// Whether nothing touched, so that the numbers describe no impact.
    pub fn is_miss(&self) -> bool {
        self.values.as_ref().is_some_and(|values| values.nothing_touched)
    }

    /// The instant that the picture of the report shows: of the largest stress in the tissue, exceeded in a volume or else at a point;
    /// without it of the peak force of the headline contact, else the end.
    pub(super) fn worst(&self) -> Worst {
        let tissue = self.values.as_ref().and_then(|values| values.tissue.as_ref());
        let in_volume = tissue.and_then(|tissue| tissue.exceeded_in_volume.as_ref());
        let in_volume = in_volume.filter(|of| of.von_mises_pa.quantity.value > 0.0);
        let at_point = tissue.and_then(|tissue| tissue.peaks.peak_von_mises_pa.as_ref());
        let at_point = at_point.filter(|peak| peak.quantity.value > 0.0);
        let impact = self.values.as_ref().and_then(Results::headline_impact);
        let known = in_volume
            .map(|of| (of.von_mises_pa.time_s, "the largest stress in the tissue"))
            .or_else(|| at_point.map(|peak| (peak.time_s, "the largest stress at a point of the tissue")))
            .or_else(|| impact.map(|impact| (impact.peak_force_time_s.value, "the peak force")));
        let end = || self.summary["time_s"].as_f64().unwrap_or_default();
        let (time_s, what) = known.unwrap_or_else(|| (end(), "the end of the run"));
        Worst { time_s, what }
    }

    fn take(&mut self, record: Record, topics: &mut BTreeMap<u16, String>) {
        match record {
            Record::Channel(channel) => {
                topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => match topics.get(&header.channel_id).map(String::as_str) {
                Some("/contact/forces") => self.take_forces(&data),
                Some("/energy") => self.take_energy(&data),
                _ => {}
            },
            Record::Attachment { header, data, .. } => match header.name.as_str() {
                "summary.json" => self.summary = serde_json::from_slice(&data).unwrap_or_default(),
                "scene.json" => self.scene = serde_json::from_slice(&data).unwrap_or_default(),
                _ => {}
            },
            Record::Metadata(metadata) => self.metadata.extend(metadata.metadata),
            _ => {}
        }
    }

    /// A message that cannot be decoded is skipped; the chunks have their own checksums.
    fn take_forces(&mut self, data: &[u8]) {
        let Ok(forces) = Forces::decode(data) else { return };
        for pair in forces.pairs {
            let impulse = pair.impulse_n_s.unwrap_or_default();
            let kept = self.pairs.entry(pair.pair).or_default();
            kept.time_s.push(forces.time_s);
            kept.impulse_n_s.push([impulse.x, impulse.y, impulse.z]);
            kept.patch_area_m2.push(pair.patch_area_m2);
        }
    }

    fn take_energy(&mut self, data: &[u8]) {
        let Ok(energy) = crate::record::proto::contuse::Energy::decode(data) else { return };
        for body in energy.bodies {
            let line = self.bodies.entry(body.body).or_default();
            line.push((energy.time_s, body.kinetic_j + body.strain_j));
        }
        self.absorbed.push((energy.time_s, energy.absorbed_by_tissue_j));
        self.total.push((energy.time_s, energy.total_j));
    }
}

/// Reads what is there. JSON has no number for a value that is not finite, so of a withheld run some may be missing.
fn finite<'a, T: Deserialize<'a>>(
    written: Option<&'a Value>,
    is_withheld: bool,
) -> Result<Option<T>, serde_json::Error> {
    match written.map(T::deserialize) {
        Some(Err(_)) if is_withheld => Ok(None),
        read => read.transpose(),
    }
}

/// SHA-256 of a file, in hexadecimal digits.
fn digest(input: &mut (impl Read + Seek), name: &Path) -> Result<String, RecordError> {
    let at = |source| RecordError::File { path: name.to_owned(), source };
    input.rewind().map_err(at)?;
    let (mut hash, mut piece) = (Sha256::new(), vec![0; PIECE]);
    loop {
        match input.read(&mut piece).map_err(at)? {
            0 => break,
            count => hash.update(&piece[..count]),
        }
    }
    Ok(hash.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }))
}
