//! Where the meshes go, as it was typed.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::args::{ExtractArgs, FormatArg, OutputArgs};
use super::usage::Usage;
use crate::sink::{MeshFormat, folder_of};

/// Where the meshes go.
#[derive(Clone, Debug)]
pub(crate) enum Output {
    /// One mesh, in this file.
    File(PathBuf),
    /// Any number, in this folder, which need not exist yet.
    Folder(PathBuf),
    Stdout,
}

/// Understands `--output`; `many` is what asks for more than one mesh.
pub(super) fn output(args: &ExtractArgs, many: Option<&str>) -> Result<Output, Usage> {
    let Some(path) = &args.output.output else {
        if args.batch.dry_run {
            return Ok(Output::Folder(PathBuf::from(".")));
        }
        return Err(
            Usage::new("no output: -o is missing").hint("-o mesh.stl, or -o - for standard output")
        );
    };
    if is_dash(path) {
        if args.output.json {
            return Err(both_on_stdout(path, "mesh"));
        }
        if let Some(many) = many {
            let message = format!("{many}: many meshes need a folder, standard output holds one");
            return Err(Usage::new(message).hint("-o meshes/"));
        }
        return Ok(Output::Stdout);
    }
    let shown = path.display();
    let ends_as_folder = path.as_os_str().as_encoded_bytes().ends_with(b"/");
    if path.is_dir() || ends_as_folder || many.is_some() && MeshFormat::from_path(path).is_none() {
        // Without the / at its end.
        let plain = path.components().as_path();
        let above = if path.is_dir() || plain.exists() { plain } else { folder_of(plain) };
        let is_needed = !args.batch.dry_run || in_the_way(above).is_some();
        if is_needed && !above.is_dir() {
            return Err(no_folder(above, path));
        }
        return Ok(Output::Folder(path.clone()));
    }
    if let Some(many) = many {
        return Err(Usage::new(format!("{many}: many meshes need a folder, {shown} is a file"))
            .hint(format!("-o {}/", path.with_extension("").display())));
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(no_folder(folder, folder));
    }
    if args.output.json && is_stdout(path) {
        return Err(both_on_stdout(path, "mesh"));
    }
    Ok(Output::File(path.clone()))
}

/// Two things for one place; `what` is the one that has others.
pub(crate) fn both_on_stdout(path: &Path, what: &str) -> Usage {
    Usage::new(format!("--json and -o {} both want standard output", path.display()))
        .hint(format!("write the {what} to a file"))
}

/// Whether a path is another name of standard output. The system has no name for a pipe, so its
/// own names are known here.
pub(crate) fn is_stdout(path: &Path) -> bool {
    let names = ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].map(Path::new);
    names.contains(&path) || is_same_file(path, names[0])
}

/// What stands where a folder is wanted, or one above it.
fn in_the_way(folder: &Path) -> Option<&Path> {
    folder.ancestors().find(|above| above.exists()).filter(|above| !above.is_dir())
}

/// A folder that is missing; `wanted` is what making would help, unless a file is in the way.
pub(crate) fn no_folder(missing: &Path, wanted: &Path) -> Usage {
    if let Some(file) = in_the_way(missing) {
        return Usage::new(format!("{}: is a file, a folder is wanted", file.display()));
    }
    Usage::new(format!("{}: there is no such folder", missing.display()))
        .hint(format!("mkdir -p {}", wanted.display()))
}

/// Whether two paths name one file, which exists.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Understands `--format`: what the name of a file says where nothing else does.
pub(super) fn format(args: &OutputArgs, output: &Output) -> Result<MeshFormat, Usage> {
    match (args.format, output) {
        (Some(FormatArg::Stl), _) | (None, Output::Stdout | Output::Folder(_)) => {
            Ok(MeshFormat::Stl)
        }
        (Some(FormatArg::Ply), _) => Ok(MeshFormat::Ply),
        (Some(FormatArg::Obj), _) => Ok(MeshFormat::Obj),
        (None, Output::File(path)) => MeshFormat::from_path(path).ok_or_else(|| {
            let said = path.extension().map_or_else(
                || "no extension".to_owned(),
                |e| format!("unknown extension .{}", e.to_string_lossy()),
            );
            Usage::new(format!("{}: {said}", path.display()))
                .hint("name it .stl, .ply or .obj, or say --format")
        }),
    }
}

pub(crate) fn is_dash(path: &Path) -> bool {
    path.as_os_str() == OsStr::new("-")
}
