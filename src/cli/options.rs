//! What was typed, understood: defaults filled in, options checked together.
//!
//! Everything that is wrong use by the arguments and the look of the file system alone is found
//! here, before any input is opened. What is left for later is two meshes with one name, which the
//! headers decide.

use std::path::PathBuf;

use super::args::{EndianArg, ExtractArgs, GapsArg, MethodArg, ReadingArgs, SpaceArg, SurfaceArgs};
use super::level::Level;
use super::output::{self, Output, is_dash};
use super::pattern::Pattern;
use super::steps::Steps;
use super::usage::Usage;
use crate::geom::Space;
use crate::pipeline::{Method, Side, SurfaceOptions};
use crate::sink::{MeshFormat, MeshOptions};
use crate::source::dicom::Selector;
use crate::source::{RawOptions, is_stream};

/// More threads than any machine of this time has; a typing error of some zeros asks for more than
/// the system gives.
const MAX_THREADS: usize = 1024;

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
    /// Each series that is fit to be meshed.
    pub(crate) all_series: bool,
    pub(crate) span_gaps: bool,
    pub(crate) raw: Option<RawOptions>,
}

/// What is made of a volume: all that decides the bytes of its mesh, and nothing else, since
/// `--resume` compares it.
#[derive(Clone, Debug)]
pub(crate) struct Extract {
    pub(crate) reading: Reading,
    /// The stored values that are inside, instead of an iso value.
    pub(crate) mask: Option<Vec<f64>>,
    /// What is done to the volume first.
    pub(crate) steps: Steps,
    /// The surface, but for its iso value.
    pub(crate) surface: SurfaceOptions,
    pub(crate) space: Space,
    pub(crate) mesh: MeshOptions,
}

/// The main command, understood.
#[expect(clippy::struct_excessive_bools, reason = "each is an option of the command line")]
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) inputs: Vec<PathBuf>,
    pub(crate) extract: Extract,
    /// A mesh for each.
    pub(crate) levels: Vec<Level>,
    pub(crate) output: Output,
    /// The file that options came from, which no mesh may replace.
    pub(crate) config: Option<PathBuf>,
    pub(crate) pattern: Option<Pattern>,
    pub(crate) recursive: bool,
    pub(crate) resume: bool,
    pub(crate) is_dry: bool,
    pub(crate) fail_fast: bool,
    pub(crate) shard: Option<(usize, usize)>,
    pub(crate) threads: usize,
    pub(crate) jobs: usize,
    pub(crate) max_memory: Option<u64>,
    pub(crate) json: bool,
}

/// Where samples come from; `-` needs to be told what they are.
pub(crate) fn source(path: PathBuf, reading: &Reading) -> Result<Input, Usage> {
    if !is_dash(&path) {
        return Ok(Input::Path(path));
    }
    if reading.raw.is_none() {
        return Err(Usage::new("standard input is read as raw samples, --dims is missing")
            .hint("--dims 512x512x90 --type i16, for example; ./- names a file"));
    }
    Ok(Input::Stdin)
}

/// Understands the main command.
pub(crate) fn run(args: &ExtractArgs) -> Result<Run, Usage> {
    let how = "mcubes INPUT --iso V -o OUT; mcubes --help says more";
    let inputs = args.inputs.clone();
    if inputs.is_empty() {
        return Err(Usage::new("no input").hint(how));
    }
    let reading = reading(&args.reading)?;
    let levels = levels(&args.surface);
    if inputs.iter().any(|input| is_dash(input)) {
        stdin(&inputs, &reading)?;
    }
    once(&inputs, &levels)?;
    let many = [
        (inputs.len() > 1, format!("{} inputs", inputs.len())),
        (levels.len() > 1, format!("{} iso values", levels.len())),
        (args.batch.recursive, "--recursive".to_owned()),
        (reading.all_series, "--series all".to_owned()),
        (args.batch.name.is_some(), "--name".to_owned()),
    ];
    let many = many.iter().find_map(|(is_given, what)| is_given.then_some(what.as_str()));
    let output = output::output(args, many)?;
    if args.batch.resume && !matches!(output, Output::Folder(_)) {
        return Err(Usage::new("--resume keeps its record in an output folder").hint("-o meshes/"));
    }
    if args.batch.shard.is_some() && !matches!(output, Output::Folder(_)) {
        return Err(Usage::new("--shard takes its share of the meshes of an output folder")
            .hint("-o meshes/"));
    }
    let extract = extract(args, reading, &output)?;
    let pattern = args.batch.name.as_deref().map(Pattern::parse).transpose()?;
    let threads = threads(args.threads)?;
    let jobs = a_few("--jobs", args.batch.jobs)?.unwrap_or(threads).min(threads);
    Ok(Run {
        inputs,
        extract,
        levels,
        output,
        config: args.config.clone(),
        pattern,
        recursive: args.batch.recursive,
        resume: args.batch.resume,
        is_dry: args.batch.dry_run,
        fail_fast: args.batch.fail_fast,
        shard: args.batch.shard,
        threads,
        jobs,
        max_memory: args.batch.max_memory,
        json: args.output.json,
    })
}

/// What is made of each volume.
fn extract(args: &ExtractArgs, reading: Reading, output: &Output) -> Result<Extract, Usage> {
    let space = match args.output.space {
        Some(SpaceArg::Ras) | None => Space::Ras,
        Some(SpaceArg::Lps) => Space::Lps,
        Some(SpaceArg::Voxel) => Space::Voxel,
    };
    let format = output::format(&args.output, output)?;
    let normals = args.surface.normals;
    if normals && format == MeshFormat::Stl {
        return Err(Usage::new(
            "--normals: STL has no vertex normals, only those of its triangles",
        )
        .hint("-o mesh.ply or -o mesh.obj, or --format ply"));
    }
    let side = if args.surface.invert { Side::Below } else { Side::AtLeast };
    let method = match args.surface.method {
        Some(MethodArg::Tetrahedra) => Method::Tetrahedra,
        Some(MethodArg::Cubes) | None => Method::Cubes,
    };
    let open = args.surface.open;
    Ok(Extract {
        reading,
        mask: args.surface.mask.clone(),
        steps: Steps::new(&args.steps, space),
        surface: SurfaceOptions { side, method, open, normals, ..SurfaceOptions::at(0.5) },
        space,
        mesh: MeshOptions { ascii: args.output.ascii, space, normals, ..MeshOptions::new(format) },
    })
}

fn levels(args: &SurfaceArgs) -> Vec<Level> {
    match (&args.mask, args.iso.as_slice()) {
        (Some(_), _) => vec![Level::Labels],
        // Where no iso value is given the volume itself says it.
        (None, []) => vec![Level::Halfway],
        (None, levels) => levels.to_vec(),
    }
}

/// Standard input is one raw volume.
fn stdin(inputs: &[PathBuf], reading: &Reading) -> Result<(), Usage> {
    if inputs.len() > 1 {
        return Err(Usage::new("standard input goes with no other input"));
    }
    source(PathBuf::from("-"), reading).map(|_| ())
}

/// What gives its bytes only once cannot be looked at for an iso value first.
fn once(inputs: &[PathBuf], levels: &[Level]) -> Result<(), Usage> {
    if !levels.iter().any(|level| matches!(level, Level::Halfway | Level::Auto)) {
        return Ok(());
    }
    let stream = inputs.iter().find_map(|input| {
        if is_dash(input) {
            return Some("standard input".to_owned());
        }
        is_stream(input).then(|| format!("{}: is no regular file and", input.display()))
    });
    match stream {
        Some(it) => Err(Usage::new(format!("{it} is read once: --iso or --mask is missing"))
            .hint("give --iso a number, or copy the bytes to a file first")),
        None => Ok(()),
    }
}

/// Understands which volume is meant, and the layout of a raw one.
pub(crate) fn reading(args: &ReadingArgs) -> Result<Reading, Usage> {
    let volume = at_least_one("--volume", args.volume)?;
    let series = match args.series.as_deref() {
        None => None,
        Some(text) => match text.parse::<usize>() {
            Ok(0) => return Err(Usage::new("--series counts from 1")),
            Ok(number) => Some(Selector::Number(number)),
            Err(_) if text == "all" => None,
            Err(_) if text.contains('.') => Some(Selector::Uid(text.to_owned())),
            Err(_) => {
                return Err(Usage::new(format!("--series {text}: neither number, UID nor all")));
            }
        },
    };
    let span_gaps = args.gaps == Some(GapsArg::Span);
    let raw = raw(args)?;
    if raw.is_some() && (volume.is_some() || args.series.is_some() || args.gaps.is_some()) {
        return Err(Usage::new(
            "--dims says that the input is raw: it has no volumes, series or gaps",
        ));
    }
    let all_series = args.series.as_deref() == Some("all");
    Ok(Reading { volume, series, all_series, span_gaps, raw })
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

/// How many threads: all processors where none are named.
pub(crate) fn threads(named: Option<usize>) -> Result<usize, Usage> {
    Ok(a_few("--threads", named)?.unwrap_or_else(|| processors().min(MAX_THREADS)))
}

/// A number of threads, or of what runs on threads of its own.
fn a_few(name: &str, value: Option<usize>) -> Result<Option<usize>, Usage> {
    match at_least_one(name, value)? {
        Some(n) if n > MAX_THREADS => {
            Err(Usage::new(format!("{name} is {n}, it must be at most {MAX_THREADS}")))
        }
        value => Ok(value),
    }
}

fn at_least_one(name: &str, value: Option<usize>) -> Result<Option<usize>, Usage> {
    if value == Some(0) { Err(Usage::new(format!("{name} must be at least 1"))) } else { Ok(value) }
}

fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}
