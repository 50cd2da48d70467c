//! Every error of the library, each naming its cause.

mod words;

pub(crate) use words::{number, one_line, shown, size};

use std::path::PathBuf;

/// What went wrong, with the name, value, file or pixel that has to be corrected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number outside the range in which the physics is defined.
    #[error("{name} = {}: must be {allowed}", number(*.value))]
    OutOfRange {
        /// The quantity's name.
        name: String,
        /// The value given.
        value: f64,
        /// The allowed range, in words.
        allowed: &'static str,
    },
    /// A file that cannot be opened or decoded.
    #[error("{}: cannot be read: {}", shown(.path), one_line(.reason))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the decoder said.
        reason: String,
    },
    /// A file or directory that cannot be written.
    #[error("{}: cannot be written: {source}", shown(.path))]
    Write {
        /// The file or directory.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// An output that would destroy what has to stay.
    #[error("{path}: {why}")]
    Protected {
        /// The file.
        path: PathBuf,
        /// Why it has to stay.
        why: String,
    },
    /// An image without the channel that is needed.
    #[error("{}: has no channel {}; it holds {}", shown(.path), one_line(.wanted), one_line(.found))]
    MissingChannel {
        /// The file.
        path: PathBuf,
        /// The channel names that were looked for.
        wanted: String,
        /// The channel names present.
        found: String,
    },
    /// An image in which several channels may be meant.
    #[error(
        "{}: several layers hold {wanted}: {}; say which by the key {key}", shown(.path), one_line(.among)
    )]
    Ambiguous {
        /// The file.
        path: PathBuf,
        /// What is wanted.
        wanted: String,
        /// The names that may be meant.
        among: String,
        /// The key that says it.
        key: &'static str,
    },
    /// One pixel holds a value that has no meaning there.
    #[error(
        "{}: channel {}, pixel ({x}, {y}) is {}: must be {allowed}",
        shown(.path), one_line(.channel), number(*.value)
    )]
    BadPixel {
        /// The file.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// Column, counted from the left, from 0.
        x: usize,
        /// Row, counted from the top, from 0.
        y: usize,
        /// The value found.
        value: f64,
        /// The allowed range, in words.
        allowed: &'static str,
    },
    /// An image for which the memory budget is too small.
    #[error(
        "{}: {} would take {} of memory, and the budget leaves {}; use a smaller image, or a larger budget",
        shown(.path), one_line(.what), size(*.bytes), size(*.left)
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What it holds.
        what: String,
        /// What it would take, bytes.
        bytes: u64,
        /// What is left, bytes.
        left: u64,
    },
    /// A computation for which the memory budget is too small.
    #[error(
        "{what}: takes {} of memory, and the budget leaves {}; use fewer pixels for the same scene, or a larger budget",
        size(*.bytes), size(*.left)
    )]
    Memory {
        /// What takes it.
        what: String,
        /// What it takes, bytes.
        bytes: u64,
        /// What is left, bytes.
        left: u64,
    },
    /// An image whose size does not fit the others.
    #[error("{}: is {found} px; {expected}", shown(.path))]
    WrongSize {
        /// The file.
        path: PathBuf,
        /// Its size, `WxH`.
        found: String,
        /// The size expected, in words.
        expected: String,
    },
    /// A scene file that is not valid TOML, or has a missing, unknown or contradictory key.
    #[error("{}: {}", shown(.path), one_line(.message))]
    Scene {
        /// The scene file.
        path: PathBuf,
        /// What is wrong, with the key's name.
        message: String,
    },
    /// A model that needs the planar second moment of the phase function, which does not exist.
    #[error(
        "model {model} needs the second moment of the phase function, and that of {phase} is infinite; \
         use small-angle, single-scatter or wide-angle"
    )]
    NoSecondMoment {
        /// The model's name.
        model: &'static str,
        /// The phase function's family, in words.
        phase: String,
    },
    /// A model that cannot render a shifted observation was asked to.
    #[error(
        "model traced does not register a shifted observation; use a model with kernels, such as wide-angle"
    )]
    NotShifted,
    /// Paths that meet a depth map see constant pixels.
    #[error(
        "model traced knows band-limited images of planes seen by parallel rays alone; use a model with kernels, such as wide-angle, \
         or read the object as constant pixels"
    )]
    NotBandlimited,
    /// A model that has no kernel was asked for one.
    #[error("model traced has no kernel: its paths are traced scene by scene")]
    NoKernel,
    /// An unknown name.
    #[error("unknown {what} {}; known are {known}", one_line(.name))]
    UnknownName {
        /// The kind of thing named.
        what: &'static str,
        /// The name given.
        name: String,
        /// The valid names.
        known: String,
    },
    /// A combination that the library does not support.
    #[error("{0} is not built yet")]
    NotBuilt(String),
    /// Bytes that are no table of a kernel.
    #[error("no table: {0}")]
    BadTable(String),
    /// Input that is well formed but holds nothing that a fit could use.
    #[error("nothing to fit: {}", one_line(.0))]
    NothingToFit(String),
    /// A machine without a graphics adapter.
    #[cfg(feature = "gpu")]
    #[error(
        "this machine has no graphics adapter with Vulkan, Metal or Direct3D 12; install its driver (a software one is \
         Mesa's: package mesa-vulkan-drivers)"
    )]
    NoAdapter,
    /// A graphics adapter that failed, or cannot do what is asked.
    #[cfg(feature = "gpu")]
    #[error("{0}")]
    Gpu(String),
    /// Threads that the system does not start.
    #[error(
        "no thread can be started to compute with: {0}; raise the limit of processes (ulimit -u), or set RAYON_NUM_THREADS to fewer"
    )]
    Threads(String),
    /// A computation that produced a number that is not finite.
    #[error("{0}")]
    NotFinite(String),
}

/// The library's result type.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// True where a model has no kernel for a medium, or nothing to fit: another model may work.
    pub(crate) fn is_about_model(&self) -> bool {
        matches!(self, Error::OutOfRange { .. } | Error::NothingToFit(_) | Error::NoSecondMoment { .. })
    }

    /// The same error about a name `within` something else: a section of a file, say.
    pub(crate) fn about(self, within: &str) -> Self {
        match self {
            Error::OutOfRange { name, value, allowed } => {
                Error::OutOfRange { name: format!("{within} {name}"), value, allowed }
            }
            Error::NothingToFit(what) => Error::NothingToFit(format!("{within}: {what}")),
            other => other,
        }
    }

    /// The same error about a channel, with what made it wanted.
    pub(crate) fn since(self, why: impl FnOnce() -> String) -> Self {
        match self {
            Error::MissingChannel { path, wanted, found } => {
                Error::MissingChannel { path, wanted: format!("{wanted} ({})", why()), found }
            }
            other => other,
        }
    }

    /// True where the user's input or usage is to blame, false where the machine is (disk full, say).
    pub fn is_usage(&self) -> bool {
        match self {
            Error::Write { source, .. } => is_of_the_path(source.kind()),
            #[cfg(feature = "gpu")]
            Error::Gpu(_) => false,
            Error::NotFinite(_) | Error::Threads(_) | Error::Memory { .. } => false,
            _ => true,
        }
    }
}

/// Whether an error of writing is answered by another path, not by a disk with more space.
fn is_of_the_path(kind: std::io::ErrorKind) -> bool {
    use std::io::ErrorKind as Kind;
    matches!(
        kind,
        Kind::NotFound
            | Kind::PermissionDenied
            | Kind::AlreadyExists
            | Kind::IsADirectory
            | Kind::NotADirectory
            | Kind::ReadOnlyFilesystem
            | Kind::InvalidInput
            | Kind::InvalidFilename
    )
}

/// Returns `value` if `ok`, else [`Error::OutOfRange`]. NaN fails every comparison, so it fails here.
pub(crate) fn in_range(name: &str, value: f64, ok: bool, allowed: &'static str) -> Result<f64> {
    if ok { Ok(value) } else { Err(Error::OutOfRange { name: name.to_string(), value, allowed }) }
}
