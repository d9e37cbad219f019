//! The shapes and their fields: a real value for each place.

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

/// What a phantom shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// A ball.
    Sphere,
    /// An ellipsoid with an axis of its own along each axis of the grid.
    Ellipsoid,
    /// A ring around the axis k.
    Torus,
    /// The surface `cos x sin y + cos y sin z + cos z sin x = 0`, three periods along the shortest
    /// axis; it leaves the volume on all sides.
    Gyroid,
    /// Balls that flow into one another: a sum of `s² / r²`.
    Metaballs,
    /// Something like a CT of a head, in Hounsfield units: skin, bone, sockets, what is within.
    Skull,
}

/// Real values of the shapes that are no scan lie from 0 to this, with the surface halfway.
const TOP: f64 = 1000.0;

/// Hounsfield units.
const AIR: f64 = -1000.0;
const SOFT: f64 = 40.0;
const BONE: f64 = 1000.0;

impl Shape {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Sphere, Self::Ellipsoid, Self::Torus, Self::Gyroid, Self::Metaballs, Self::Skull];

    /// The word on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Ellipsoid => "ellipsoid",
            Self::Torus => "torus",
            Self::Gyroid => "gyroid",
            Self::Metaballs => "metaballs",
            Self::Skull => "skull",
        }
    }

    /// The iso value at which the surface is meant to be meshed.
    pub fn iso(self) -> f64 {
        if self == Self::Skull { 300.0 } else { TOP / 2.0 }
    }

    /// The least and the greatest value, without noise.
    pub(super) fn range(self) -> (f64, f64) {
        if self == Self::Skull { (AIR, BONE) } else { (0.0, TOP) }
    }

    /// The field in a box of `extent` mm around the origin, sampled each `spacing` mm.
    pub(super) fn field(
        self,
        extent: [f64; 3],
        spacing: [f64; 3],
    ) -> Box<dyn Fn([f64; 3]) -> f64 + Send + Sync> {
        let coarsest = spacing.iter().fold(0.0_f64, |m, s| m.max(*s));
        let sizes = Sizes::new(extent);
        // Linear in the distance (positive inside) for five samples on either side of the surface.
        let ramp =
            move |distance: f64| (TOP / 2.0 + distance / coarsest * (TOP / 10.0)).clamp(0.0, TOP);
        match self {
            Self::Sphere => Box::new(move |p| ramp(sizes.radius - length(p))),
            Self::Ellipsoid => Box::new(move |p| ramp(ellipsoid(p, sizes.axes))),
            Self::Torus => {
                Box::new(move |[x, y, z]| ramp(sizes.tube - (x.hypot(y) - sizes.ring).hypot(z)))
            }
            Self::Gyroid => Box::new(move |p| {
                let [x, y, z] = p.map(|v| v * TAU / sizes.period);
                let value = x.cos() * y.sin() + y.cos() * z.sin() + z.cos() * x.sin();
                // The sum never leaves -1.5 to 1.5.
                TOP / 2.0 + value * (TOP / 3.0)
            }),
            Self::Metaballs => Box::new(move |p| metaballs(p.map(|v| v / sizes.least)).min(TOP)),
            Self::Skull => Box::new(move |p| {
                skull([0, 1, 2].map(|a| p[a] / sizes.half[a]), coarsest / sizes.least)
            }),
        }
    }
}

/// Lengths that fill a box.
#[derive(Clone, Copy)]
pub(super) struct Sizes {
    /// Half the extents, nowhere 0.
    half: [f64; 3],
    least: f64,
    pub(super) radius: f64,
    pub(super) axes: [f64; 3],
    pub(super) ring: f64,
    pub(super) tube: f64,
    period: f64,
}

impl Sizes {
    pub(super) fn new(extent: [f64; 3]) -> Self {
        let half = extent.map(|e| (e / 2.0).max(f64::MIN_POSITIVE));
        let least = half.iter().fold(f64::INFINITY, |m, h| m.min(*h));
        let flat = half[0].min(half[1]);
        let tube = (0.3 * flat).min(0.8 * half[2]);
        Self {
            half,
            least,
            radius: 0.8 * least,
            axes: half.map(|h| 0.8 * h),
            ring: 0.85 * flat - tube,
            tube,
            period: 2.0 * least / 3.0,
        }
    }
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// About the distance to an ellipsoid, positive inside: exact to first order at its surface.
fn ellipsoid(p: [f64; 3], axes: [f64; 3]) -> f64 {
    let scaled = [0, 1, 2].map(|a| p[a] / axes[a]);
    let slope = length([0, 1, 2].map(|a| scaled[a] / axes[a]));
    let reach = length(scaled);
    if slope > 0.0 {
        reach * (1.0 - reach) / slope
    } else {
        axes.iter().fold(f64::MAX, |m, a| m.min(*a))
    }
}

/// `s² / r²` around five centres, in halves of the least extent.
fn metaballs(p: [f64; 3]) -> f64 {
    const BALLS: [([f64; 3], f64); 5] = [
        ([0.0, 0.0, 0.0], 0.28),
        ([0.45, 0.1, 0.05], 0.2),
        ([-0.3, 0.4, -0.1], 0.22),
        ([-0.2, -0.4, 0.3], 0.2),
        ([0.1, -0.1, -0.5], 0.18),
    ];
    let sum: f64 = BALLS
        .iter()
        .map(|(centre, size)| {
            let d = [0, 1, 2].map(|a| p[a] - centre[a]);
            size * size / d.iter().map(|v| v * v).sum::<f64>()
        })
        .sum();
    TOP / 2.0 * sum
}

/// A head in a box from -1 to 1; `step` is a sample's part of it, over which tissues change.
fn skull(p: [f64; 3], step: f64) -> f64 {
    let [x, y, z] = p;
    // How much of a sample lies inside a surface at a distance, positive inside.
    let part = |distance: f64| (0.5 + distance / step).clamp(0.0, 1.0);
    let around = |centre: [f64; 3], axes: [f64; 3]| {
        part(ellipsoid([x - centre[0], y - centre[1], z - centre[2]], axes))
    };
    let head = around([0.0; 3], [0.78, 0.92, 0.92]);
    let outer = around([0.0, -0.02, 0.06], [0.7, 0.84, 0.78]);
    let inner = around([0.0, -0.04, 0.08], [0.62, 0.75, 0.69]);
    // A jaw: a bent bar below the face.
    let bend = (x.hypot(y - 0.1) - 0.48).hypot((z + 0.68) * 0.8);
    let jaw = part(0.09 - bend) * part(y - 0.05);
    let sockets = around([0.27, 0.68, -0.08], [0.16, 0.3, 0.13])
        .max(around([-0.27, 0.68, -0.08], [0.16, 0.3, 0.13]));
    let nose = around([0.0, 0.78, -0.32], [0.1, 0.3, 0.16]);
    // Where the spine leaves the skull.
    let foramen = part(0.15 - x.hypot(y + 0.2)) * part(-0.4 - z);
    let shell = outer * (1.0 - inner) * (1.0 - sockets) * (1.0 - nose) * (1.0 - foramen);
    let bone = shell.max(jaw);
    let airway = nose * part(0.92 - y);
    let soft = AIR + (SOFT - AIR) * (head.max(outer) * (1.0 - airway));
    soft + (BONE - soft) * bone
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for Shape {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|s| s.as_str() == word).ok_or_else(|| {
            let all = Self::ALL.map(Self::as_str).join(", ");
            format!("{word} is no phantom; there are {all}")
        })
    }
}
