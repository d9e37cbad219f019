//! What was typed, understood: defaults filled in, options checked together.
//!
//! Everything that is wrong use by the arguments and the look of the file system alone is found
//! here, before any input is opened.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::args::{EndianArg, ExtractArgs, FormatArg, GapsArg, OutputArgs, ReadingArgs, SpaceArg};
use super::steps::Steps;
use crate::geom::Space;
use crate::pipeline::{Side, SurfaceOptions};
use crate::sink::{Format, MeshOptions};
use crate::source::RawOptions;
use crate::source::dicom::Selector;

/// Wrong use: one line, and perhaps what to do. Exit status 2.
#[derive(Debug, PartialEq)]
pub(crate) struct Usage {
    pub(crate) message: String,
    pub(crate) hint: Option<String>,
}

impl Usage {
    fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), hint: None }
    }

    fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

/// Where samples come from.
#[derive(Clone, Debug)]
pub(crate) enum Input {
    Path(PathBuf),
    Stdin,
}

/// Which volume of an input is meant.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reading {
    /// From 1.
    pub(crate) volume: Option<usize>,
    pub(crate) series: Option<Selector>,
    pub(crate) span_gaps: bool,
    pub(crate) raw: Option<RawOptions>,
}

/// Where the mesh goes.
#[derive(Clone, Debug)]
pub(crate) enum Output {
    File(PathBuf),
    Stdout,
}

/// The main command, understood.
#[derive(Clone, Debug)]
pub(crate) struct Extract {
    pub(crate) input: Input,
    pub(crate) reading: Reading,
    /// Where no iso value was given the volume itself says it.
    pub(crate) iso: Option<f64>,
    /// The stored values that are inside, instead of an iso value.
    pub(crate) mask: Option<Vec<f64>>,
    /// What is done to the volume first.
    pub(crate) steps: Steps,
    /// The rest of what the surface is.
    pub(crate) surface: SurfaceOptions,
    pub(crate) space: Space,
    pub(crate) mesh: MeshOptions,
    pub(crate) output: Output,
    pub(crate) threads: usize,
    pub(crate) json: bool,
}

/// Understands the main command.
pub(crate) fn extract(args: &ExtractArgs) -> Result<Extract, Usage> {
    let how = "mcubes INPUT --iso V -o OUT; mcubes --help says more";
    let Some(input) = args.input.clone() else { return Err(Usage::new("no input").hint(how)) };
    let reading = reading(&args.reading)?;
    let (iso, mask) = (args.surface.iso, args.surface.mask.clone());
    if is_dash(&input) && iso.is_none() && mask.is_none() {
        return Err(Usage::new("standard input is read once: --iso or --mask is missing"));
    }
    let output = output(&args.output, &input)?;
    let space = match args.output.space {
        Some(SpaceArg::Ras) | None => Space::Ras,
        Some(SpaceArg::Lps) => Space::Lps,
        Some(SpaceArg::Voxel) => Space::Voxel,
    };
    let format = format(&args.output, &output)?;
    let mesh = MeshOptions { ascii: args.output.ascii, space, ..MeshOptions::new(format) };
    let side = if args.surface.invert { Side::Below } else { Side::AtLeast };
    let surface =
        SurfaceOptions { side, open: args.surface.open, ..SurfaceOptions::at(iso.unwrap_or(0.5)) };
    let input = if is_dash(&input) {
        if reading.raw.is_none() {
            return Err(Usage::new("standard input is read as raw samples, --dims is missing")
                .hint("--dims 512x512x90 --type i16, for example; ./- names a file"));
        }
        Input::Stdin
    } else {
        Input::Path(input)
    };
    let threads = threads(args.threads)?;
    let steps = Steps::new(&args.steps, space);
    Ok(Extract {
        input,
        reading,
        iso,
        mask,
        steps,
        surface,
        space,
        mesh,
        output,
        threads,
        json: args.output.json,
    })
}

/// Understands which volume is meant, and the layout of a raw one.
pub(crate) fn reading(args: &ReadingArgs) -> Result<Reading, Usage> {
    let volume = at_least_one("--volume", args.volume)?;
    let series = match args.series.as_deref() {
        None => None,
        Some(text) => match text.parse::<usize>() {
            Ok(0) => return Err(Usage::new("--series counts from 1")),
            Ok(number) => Some(Selector::Number(number)),
            Err(_) if text.contains('.') => Some(Selector::Uid(text.to_owned())),
            Err(_) => return Err(Usage::new(format!("--series {text}: neither number nor UID"))),
        },
    };
    let span_gaps = args.gaps == Some(GapsArg::Span);
    let raw = raw(args)?;
    if raw.is_some() && (volume.is_some() || series.is_some() || args.gaps.is_some()) {
        return Err(Usage::new(
            "--dims says that the input is raw: it has no volumes, series or gaps",
        ));
    }
    Ok(Reading { volume, series, span_gaps, raw })
}

fn raw(args: &ReadingArgs) -> Result<Option<RawOptions>, Usage> {
    match (args.dims, args.stored) {
        (Some(dims), Some(stored)) => Ok(Some(RawOptions {
            big_endian: args.endian == Some(EndianArg::Big),
            spacing_mm: args.spacing.unwrap_or([1.0; 3]),
            origin_mm: args.origin.unwrap_or([0.0; 3]),
            offset_bytes: args.offset.unwrap_or(0),
            ..RawOptions::new(dims, stored)
        })),
        (Some(_), None) => Err(Usage::new("--dims says that the input is raw, --type is missing")
            .hint("--type i16, for example")),
        (None, _) => {
            let given = [
                ("--type", args.stored.is_some()),
                ("--endian", args.endian.is_some()),
                ("--spacing", args.spacing.is_some()),
                ("--origin", args.origin.is_some()),
                ("--offset", args.offset.is_some()),
            ];
            match given.iter().find(|(_, given)| *given) {
                Some((name, _)) => {
                    Err(Usage::new(format!("{name} is about raw input, --dims is missing"))
                        .hint("--dims 512x512x90, for example"))
                }
                None => Ok(None),
            }
        }
    }
}

fn output(args: &OutputArgs, input: &Path) -> Result<Output, Usage> {
    let Some(path) = &args.output else {
        return Err(
            Usage::new("no output: -o is missing").hint("-o mesh.stl, or -o - for standard output")
        );
    };
    if is_dash(path) {
        if args.json {
            return Err(Usage::new("--json and -o - both want standard output")
                .hint("write the mesh to a file"));
        }
        return Ok(Output::Stdout);
    }
    writable(path, "mesh.stl")?;
    if let (Ok(a), Ok(b)) = (input.canonicalize(), path.canonicalize())
        && a == b
    {
        return Err(Usage::new(format!("{}: the output is the input", path.display())));
    }
    Ok(Output::File(path.clone()))
}

/// Looks whether a file could be written at `path`.
fn writable(path: &Path, example: &str) -> Result<(), Usage> {
    if path.is_dir() {
        return Err(Usage::new(format!("{}: the output is a folder", path.display()))
            .hint(format!("-o {}", path.join(example).display())));
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(Usage::new(format!("{}: there is no such folder", folder.display()))
            .hint(format!("mkdir -p {}", folder.display())));
    }
    Ok(())
}

/// Understands where a phantom goes.
pub(crate) fn phantom_output(path: &Path, json: bool) -> Result<Output, Usage> {
    if is_dash(path) {
        if json {
            return Err(Usage::new("--json and -o - both want standard output")
                .hint("write the volume to a file"));
        }
        return Ok(Output::Stdout);
    }
    writable(path, "phantom.nii.gz")?;
    let unzipped = match path.extension() {
        Some(end) if end.eq_ignore_ascii_case("gz") => path.with_extension(""),
        _ => path.to_owned(),
    };
    if !unzipped.extension().is_some_and(|end| end.eq_ignore_ascii_case("nii")) {
        return Err(Usage::new(format!("{}: neither .nii nor .nii.gz", path.display())));
    }
    Ok(Output::File(path.to_owned()))
}

/// How many threads: all processors where none are named.
pub(crate) fn threads(named: Option<usize>) -> Result<usize, Usage> {
    Ok(at_least_one("--threads", named)?.unwrap_or_else(processors))
}

fn format(args: &OutputArgs, output: &Output) -> Result<Format, Usage> {
    match (args.format, output) {
        (Some(FormatArg::Stl), _) | (None, Output::Stdout) => Ok(Format::Stl),
        (Some(FormatArg::Ply), _) => Ok(Format::Ply),
        (Some(FormatArg::Obj), _) => Ok(Format::Obj),
        (None, Output::File(path)) => Format::from_path(path).ok_or_else(|| {
            let said = path.extension().map_or_else(
                || "no extension".to_owned(),
                |e| format!("unknown extension .{}", e.to_string_lossy()),
            );
            Usage::new(format!("{}: {said}", path.display()))
                .hint("name it .stl, .ply or .obj, or say --format")
        }),
    }
}

fn at_least_one(name: &str, value: Option<usize>) -> Result<Option<usize>, Usage> {
    if value == Some(0) { Err(Usage::new(format!("{name} must be at least 1"))) } else { Ok(value) }
}

fn is_dash(path: &Path) -> bool {
    path.as_os_str() == OsStr::new("-")
}

/// The folder that a path lies in; `.` for a bare name.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
        None => Path::new("/"),
    }
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}
