//! What was typed, by clap; `options` says what it means.
//!
//! Nothing here looks at files or at two options together.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::level::{self, Level};
use super::value;
use crate::phantom::Shape;
use crate::volume::StoredType;

/// What stands below the help.
pub(crate) const EXAMPLES: &str = "\
Examples:
  mcubes head.nii.gz --iso 300 -o skull.stl        a CT head's bone
  mcubes study/ --iso 300 -o skull.ply             a DICOM folder's largest series
  mcubes brain.nii --iso 0.5 --space lps -o b.obj  for a viewer that wants LPS
  mcubes scan.raw --dims 512x512x90 --type i16 --spacing 0.7x0.7x2.5 --iso 300 -o s.stl
  mcubes info head.nii.gz                          what a file holds, and which iso to take
  mcubes scans/ --recursive --iso 300 -o meshes/   every scan below a folder
  mcubes scans/ --recursive --iso 300 -o meshes/ --resume   what is not done yet

Exit status: 0 done, 1 something failed, 2 wrong use, 130 interrupted.
An input that is called like a command is written ./info.";

/// Turns medical volumes (NIfTI, DICOM, raw) into closed, manifold surface meshes.
#[derive(Parser, Debug)]
#[command(name = "mcubes", version, after_help = EXAMPLES)]
#[command(args_conflicts_with_subcommands = true, max_term_width = 100)]
#[command(override_usage = "mcubes INPUT... --iso V -o OUT [OPTIONS]\n       mcubes <COMMAND> ...")]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) extract: ExtractArgs,
    #[command(flatten)]
    pub(crate) common: CommonArgs,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Show what an input holds: sizes, place, range, histogram, iso values to try
    Info(InfoArgs),
    /// Verify that meshes are closed, manifold and wound outward
    Check(CheckArgs),
    /// Write a volume made by a formula, as NIfTI, and say what is true of its surface
    Phantom(PhantomArgs),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        #[arg(value_name = "SHELL")]
        shell: clap_complete::Shell,
    },
    /// Print the manual page, in roff
    Man,
}

#[derive(Args, Debug)]
pub(crate) struct CommonArgs {
    /// Print errors only
    #[arg(short, long, global = true, help_heading = "General")]
    pub(crate) quiet: bool,
    /// Print what is done and the time of each stage
    #[arg(short, long, global = true, conflicts_with = "quiet", help_heading = "General")]
    pub(crate) verbose: bool,
    /// Colour in messages [default: auto]
    #[arg(long, global = true, value_name = "WHEN", help_heading = "General")]
    pub(crate) color: Option<When>,
}

#[derive(Args, Debug)]
pub(crate) struct ExtractArgs {
    /// NIfTI, DICOM or raw files, DICOM folders or zips; - for raw data from standard input
    #[arg(value_name = "INPUT")]
    pub(crate) inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
    #[command(flatten)]
    pub(crate) steps: StepsArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) batch: BatchArgs,
    /// Threads of work in all, at most 1024 [default: all processors]
    #[arg(long, value_name = "N", help_heading = "General")]
    pub(crate) threads: Option<usize>,
    /// Options by their long names in a TOML file; the command line wins
    #[arg(long, value_name = "FILE", help_heading = "General")]
    pub(crate) config: Option<PathBuf>,
}

/// Many scans in one run.
#[expect(clippy::struct_excessive_bools, reason = "each is an option of the command line")]
#[derive(Args, Debug)]
#[command(next_help_heading = "Many scans")]
pub(crate) struct BatchArgs {
    /// Take every volume file and DICOM series below the folders
    #[arg(short, long)]
    pub(crate) recursive: bool,
    /// Names below the output folder, of {stem} {file} {parent} {series} {modality} {iso} {label}
    /// {patient_id} {patient_name} [default: as the inputs lie]
    #[expect(clippy::doc_markdown, reason = "printed as help, where a backtick would be one")]
    #[arg(long, value_name = "PATTERN")]
    pub(crate) name: Option<String>,
    /// Pass over what is done already, as the record in the output folder has it
    #[arg(long)]
    pub(crate) resume: bool,
    /// Say what would be done, and write nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Stop at the first failure
    #[arg(long)]
    pub(crate) fail_fast: bool,
    /// Scans side by side, never more than threads [default: as many as threads]
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<usize>,
    /// Memory for all scans together, such as 800M or 4G [default: half of what is free]
    #[arg(long, value_name = "BYTES", value_parser = value::bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Every N-th scan, beginning with the I-th
    #[arg(long, value_name = "I/N", value_parser = value::shard)]
    pub(crate) shard: Option<(usize, usize)>,
}

#[derive(Args, Debug)]
#[command(next_help_heading = "Surface")]
pub(crate) struct SurfaceArgs {
    /// Iso value in real units (HU for CT), bone, soft, fat, skin, lung or auto; may be given more
    /// than once; not needed for a volume of 0 and one other value
    #[arg(long, value_name = "V", value_parser = level::parse, allow_hyphen_values = true)]
    pub(crate) iso: Vec<Level>,
    /// Mesh where the stored value is one of a list (labels), instead of --iso
    #[arg(long, value_name = "V[,V...]", value_parser = value::list, allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["iso", "invert"])]
    pub(crate) mask: Option<std::vec::Vec<f64>>,
    /// Inside is below the iso value
    #[arg(long)]
    pub(crate) invert: bool,
    /// How cells become triangles: cubes with exact topology, or tetrahedra [default: cubes]
    #[arg(long, value_name = "METHOD")]
    pub(crate) method: Option<MethodArg>,
    /// Leave the surface open where it leaves the volume
    #[arg(long)]
    pub(crate) open: bool,
    /// A unit normal with each vertex, for smooth shading (PLY and OBJ)
    #[arg(long)]
    pub(crate) normals: bool,
}

/// What is done to the volume before it is meshed, in this order.
#[derive(Args, Debug)]
#[command(next_help_heading = "Part and resolution (always in this order)")]
pub(crate) struct StepsArgs {
    /// Only samples in these index ranges: I0:I1,J0:J1,K0:K1, from 0, ends not included
    #[arg(long, value_name = "RANGES", value_parser = value::index_ranges)]
    #[arg(allow_hyphen_values = true)]
    pub(crate) crop: Option<[[usize; 2]; 3]>,
    /// Only samples around this box in the output's coordinates: X0:X1,Y0:Y1,Z0:Z1
    #[arg(long, value_name = "BOX", value_parser = value::ranges, allow_hyphen_values = true)]
    #[arg(conflicts_with = "crop")]
    pub(crate) crop_mm: Option<[[f64; 2]; 3]>,
    /// Gaussian blur of this sigma
    #[arg(long, value_name = "MM", value_parser = value::not_negative, allow_hyphen_values = true)]
    pub(crate) blur: Option<f64>,
    /// Means of blocks of N samples along each axis, or of N x M x K
    #[arg(long, value_name = "N|NxMxK", value_parser = value::block)]
    pub(crate) downsample: Option<[usize; 3]>,
}

#[derive(Args, Debug)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    /// Mesh file (.stl, .ply, .obj), a folder for many, or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: Option<PathBuf>,
    /// File format [default: by the extension; stl for - and folders]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) format: Option<FormatArg>,
    /// Write STL or PLY as text
    #[arg(long)]
    pub(crate) ascii: bool,
    /// Coordinates: ras or lps in mm, voxel indices [default: ras]
    #[arg(long, value_name = "SPACE")]
    pub(crate) space: Option<SpaceArg>,
    /// Report as JSON on standard output, one object a line
    #[arg(long)]
    pub(crate) json: bool,
}

/// Which volume of an input, and how a raw one is laid out.
#[derive(Args, Debug, Default)]
pub(crate) struct ReadingArgs {
    /// Volume of a 4-D file, from 1 [default: 1]
    #[arg(long, value_name = "N", help_heading = "Input")]
    pub(crate) volume: Option<usize>,
    /// DICOM series: its number in `mcubes info`, its UID, or all [default: the largest]
    #[arg(long, value_name = "N|UID|all", help_heading = "Input")]
    pub(crate) series: Option<String>,
    /// Gaps where DICOM slices are missing: refuse them, or span them [default: refuse]
    #[arg(long, value_name = "GAPS", help_heading = "Input")]
    pub(crate) gaps: Option<GapsArg>,
    /// Samples along x (fastest), y, z; says that the input is raw
    #[arg(long, value_name = "XxYxZ", value_parser = value::dims, help_heading = "Raw input")]
    pub(crate) dims: Option<[i64; 3]>,
    /// u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64
    #[arg(long = "type", value_name = "TYPE", value_parser = value::stored_type)]
    #[arg(help_heading = "Raw input")]
    pub(crate) stored: Option<StoredType>,
    /// Byte order [default: little]
    #[arg(long, value_name = "ORDER", help_heading = "Raw input")]
    pub(crate) endian: Option<EndianArg>,
    /// Millimetres between samples [default: 1x1x1]
    #[arg(long, value_name = "XxYxZ", value_parser = value::spacing, help_heading = "Raw input")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) spacing: Option<[f64; 3]>,
    /// Centre of the first sample, RAS mm [default: 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = value::point, help_heading = "Raw input")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) origin: Option<[f64; 3]>,
    /// Bytes before the first sample [default: 0]
    #[arg(long, value_name = "BYTES", help_heading = "Raw input")]
    pub(crate) offset: Option<u64>,
}

#[derive(Args, Debug)]
pub(crate) struct InfoArgs {
    /// A NIfTI, DICOM or raw file, or a DICOM folder or zip
    #[arg(value_name = "INPUT", required = true)]
    pub(crate) inputs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    /// Report as JSON on standard output, one object a line
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct CheckArgs {
    /// Mesh files: STL, PLY or OBJ
    #[arg(value_name = "MESH", required = true)]
    pub(crate) meshes: Vec<PathBuf>,
    /// Report as JSON on standard output, one object a line
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct PhantomArgs {
    /// sphere, ellipsoid, torus, gyroid, metaballs, or skull (or skull-like: something like a CT of
    /// a head)
    #[arg(value_name = "KIND", value_parser = value::shape)]
    pub(crate) shape: Shape,
    /// NIfTI file (.nii, .nii.gz), or - for standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Samples along i, j, k
    #[arg(long, value_name = "N|XxYxZ", value_parser = value::sizes, default_value = "128")]
    pub(crate) dims: [i64; 3],
    /// Millimetres between samples
    #[arg(long, value_name = "MM|XxYxZ", value_parser = value::steps, default_value = "1")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) spacing: [f64; 3],
    /// Standard deviation of the noise on each sample, in real units
    #[arg(long, value_name = "SD", value_parser = value::not_negative, default_value = "0")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) noise: f64,
    /// Another seed, another noise
    #[arg(long, value_name = "N", default_value = "0")]
    pub(crate) seed: u64,
    /// u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64
    #[arg(long = "type", value_name = "TYPE", value_parser = value::stored_type)]
    #[arg(default_value = "i16")]
    pub(crate) stored: StoredType,
    /// Threads of work in all, at most 1024 [default: all processors]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Report as JSON on standard output, one object a line
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum When {
    Auto,
    Always,
    Never,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MethodArg {
    Cubes,
    Tetrahedra,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FormatArg {
    Stl,
    Ply,
    Obj,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SpaceArg {
    Ras,
    Lps,
    Voxel,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GapsArg {
    Refuse,
    Span,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EndianArg {
    Little,
    Big,
}
