//! Turns medical volumes into closed, manifold surface meshes.
//!
//! One pipeline, one direction: a *source* of planes, *slabs* of planes, the *kernel*, *patches* in
//! order, a *sink*. Imports go one way only, down this list:
//!
//! `error`, `limits`, `cancel` ← `geom` ← `volume`, `mesh` ← `source`, `kernel`, `sink`, `reader` ←
//! `pipeline`, `phantom` ← `cli`.
//!
//! A volume in memory: [`mesh()`], or [`mesh_placed`] where it has an affine. A file, a folder, a formula
//! or anything else that gives planes: [`source::open`] and [`pipeline::extract`], which hold a few
//! planes at a time.
//!
//! ```no_run
//! use mcubes::cancel::Cancel;
//! use mcubes::geom::{Place, Space};
//! use mcubes::pipeline::{RunOptions, SurfaceOptions, extract};
//! use mcubes::sink::{MeshFormat, MeshFile, MeshOptions};
//! use mcubes::source::{OpenOptions, open};
//!
//! let head = open("head.nii.gz".as_ref(), &OpenOptions::default(), &Cancel::new())?;
//! let place = Place::new(&head.meta.grid, Space::Ras)?;
//! let mut file = MeshFile::create("skull.stl".as_ref(), &MeshOptions::new(MeshFormat::Stl))?;
//! extract(head, &place, vec![(SurfaceOptions::at(300.0), &mut file)], &RunOptions::default())?;
//! file.commit()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cancel;
#[cfg(feature = "cli")]
pub mod cli;
pub mod error;
pub mod geom;
pub mod kernel;
pub mod limits;
pub mod mesh;
pub mod phantom;
pub mod pipeline;
pub mod reader;
pub mod sink;
pub mod source;
pub mod volume;

pub use error::{Error, Kind};
pub use pipeline::{mesh, mesh_placed};
