//! Whether a BSDF obeys physics and says what its maker meant, and how it can be mended.
//!
//! In: a BSDF. Out: a [`Report`]: what was measured (energy, reciprocity, symmetry, noise, colour) and [`Finding`]s, each with its kind, how
//! bad it is, where, how much, what to do, and whether [`crate::repair`] can do it. Everything is told from the data alone, so some mistakes
//! cannot be: front and back that change places everywhere, or a reciprocal reflection whose matrix is transposed (which is
//! that of the device turned by 180°), obey all laws. What they are told by, and what is told of the real files, is in docs/check.md.
//!
//! Source: Radiance's checkBSDF for energy and reciprocity; it compares unweighted, here pairs of directions are drawn from the
//! BSDF itself, so that means are weighted by flux.

mod energy;
mod gamut;
mod header;
mod motion;
mod noise;
mod pairs;
mod reciprocity;
mod relation;
mod sides;
mod symmetry;
mod units;

pub use energy::Energy;
pub use gamut::Gamut;

pub(crate) use energy::{energy, incident_directions};
pub(crate) use header::{mended_lengths, nanometers};
pub use motion::Motion;
pub use noise::Noise;
pub use reciprocity::Reciprocity;
pub(crate) use reciprocity::can_be_symmetric;
use reciprocity::reciprocity;
pub(crate) use relation::peak_light;
pub use symmetry::Symmetry;
pub use units::Factor;
pub(crate) use units::mean_cosine;

use crate::bsdf::{Band, Bsdf, Part};
use crate::direction::{Direction, Side};

/// What is tolerated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Most scattered light over 1.
    pub energy: f64,
    /// Largest flux-weighted mean of |a − b|/(a + b).
    pub reciprocity: f64,
    /// Largest relative standard deviation of a value.
    pub noise: f64,
}

impl Default for Tolerance {
    fn default() -> Tolerance {
        Tolerance { energy: 0.01, reciprocity: 0.25, noise: 0.25 }
    }
}

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Breaks a law of physics beyond tolerance, or says what no BSDF can.
    Violation,
    /// May not be what was meant.
    Warning,
    /// A guess, or something to know.
    Note,
}

/// What a finding is about, and by which name it is repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Numbers that a file cannot have; found by its reader.
    Values,
    /// What numbers and lengths are multiples of.
    Units,
    /// Directions and up.
    Orientation,
    /// Components that are absent, the same, or in each other's place.
    Sides,
    /// Swapped directions.
    Reciprocity,
    /// More light out than in.
    Energy,
    /// Colours that there are none of.
    Colour,
    /// Values that are not smooth.
    Noise,
}

impl Kind {
    /// All, in the order in which they are repaired: later ones are measured on what earlier ones mended.
    pub const ALL: [Kind; 8] = [
        Kind::Values,
        Kind::Units,
        Kind::Orientation,
        Kind::Sides,
        Kind::Reciprocity,
        Kind::Energy,
        Kind::Colour,
        Kind::Noise,
    ];

    /// Its name at the prompt and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Values => "values",
            Kind::Units => "units",
            Kind::Orientation => "orientation",
            Kind::Sides => "sides",
            Kind::Reciprocity => "reciprocity",
            Kind::Energy => "energy",
            Kind::Colour => "colour",
            Kind::Noise => "noise",
        }
    }
}

/// How something found is mended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Repair {
    /// All values of the band are multiplied by a factor.
    Scale(f64),
    /// Values of the component are divided by what they were multiplied by.
    Divide(Factor),
    /// Lengths of the header that were meant in millimetres.
    Lengths,
    /// A wavelength that was meant in micrometres becomes one in nanometres.
    Wavelength,
    /// Incident directions are moved, exitant ones are not.
    MoveIncident(Motion),
    /// The component is that of the moved device; with `reverse`, light is taken to have travelled the other way besides.
    Move {
        /// How.
        motion: Motion,
        /// Whether incident and exitant are swapped too.
        reverse: bool,
    },
    /// The two reflections change places.
    SwapReflections,
    /// The component is left out.
    Drop,
    /// The component is made from its reverse.
    FromReverse,
    /// Values and those of the swapped pair become their mean.
    Symmetrize,
    /// Pairs of directions are scaled down until none scatters more than it brings.
    ScaleDown,
    /// Colours that there are none of move towards white until there are.
    ClipColour,
}

/// Where something is worst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Direction that light comes from.
    pub incident: Direction,
    /// Direction that it leaves to, if it matters.
    pub exitant: Option<Direction>,
}

impl From<Direction> for Place {
    fn from(incident: Direction) -> Place {
        Place { incident, exitant: None }
    }
}

impl From<[Direction; 2]> for Place {
    fn from([incident, exitant]: [Direction; 2]) -> Place {
        Place { incident, exitant: Some(exitant) }
    }
}

/// Something the user should know.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What it is about.
    pub kind: Kind,
    /// How bad.
    pub severity: Severity,
    /// The component, if it is about one.
    pub part: Option<Part>,
    /// Where it is worst, if it is somewhere.
    pub at: Option<Place>,
    /// How much, as the message says in words.
    pub amount: f64,
    /// What, where and how much.
    pub message: String,
    /// What to do.
    pub advice: &'static str,
    /// How [`crate::repair::repaired`] can mend it, if it can.
    pub repair: Option<Repair>,
}

impl Finding {
    fn new(kind: Kind, severity: Severity, message: String, advice: &'static str) -> Finding {
        Finding { kind, severity, part: None, at: None, amount: 0.0, message, advice, repair: None }
    }

    fn of(self, part: Part) -> Finding {
        Finding { part: Some(part), ..self }
    }

    fn at(self, at: impl Into<Place>) -> Finding {
        Finding { at: Some(at.into()), ..self }
    }

    fn by(self, amount: f64) -> Finding {
        Finding { amount, ..self }
    }

    fn mended_by(self, repair: Repair) -> Finding {
        Finding { repair: Some(repair), ..self }
    }
}

/// Results for one band.
#[derive(Clone, Debug, PartialEq)]
pub struct BandReport {
    /// Its name.
    pub band: String,
    /// One for each side that something is known of.
    pub energy: Vec<Energy>,
    /// One for each reflection, and one for transmission if both are there.
    pub reciprocity: Vec<Reciprocity>,
    /// One for each component that is not isotropic by its kind.
    pub symmetry: Vec<Symmetry>,
    /// One for each component.
    pub noise: Vec<Noise>,
    /// One for each component with colour.
    pub gamut: Vec<Gamut>,
    /// What is wrong with it.
    pub findings: Vec<Finding>,
}

/// What was measured and found.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// What is wrong with the file's header.
    pub findings: Vec<Finding>,
    /// Results for each band.
    pub bands: Vec<BandReport>,
}

impl Report {
    /// All findings with the band that they are about.
    pub fn all(&self) -> impl Iterator<Item = (Option<&str>, &Finding)> {
        let of_bands =
            self.bands.iter().flat_map(|band| band.findings.iter().map(|f| (Some(band.band.as_str()), f)));
        self.findings.iter().map(|f| (None, f)).chain(of_bands)
    }

    /// Whether nothing is violated.
    pub fn is_ok(&self) -> bool {
        self.all().all(|(_, finding)| finding.severity != Severity::Violation)
    }
}

/// Checks the header and all bands.
pub fn check(bsdf: &Bsdf, tolerance: Tolerance) -> Report {
    Report {
        findings: header::lengths(&bsdf.header),
        bands: bsdf.bands.iter().map(|band| check_band(band, tolerance)).collect(),
    }
}

fn check_band(band: &Band, tolerance: Tolerance) -> BandReport {
    let mut report = BandReport {
        band: band.name.clone(),
        energy: Vec::new(),
        reciprocity: Vec::new(),
        symmetry: Vec::new(),
        noise: Vec::new(),
        gamut: Vec::new(),
        findings: Vec::new(),
    };
    if let Err(damage) = band.verify() {
        let advice = "copy the file or make it again";
        report.findings = vec![Finding::new(Kind::Values, Severity::Violation, damage.to_string(), advice)];
        return report;
    }
    report.energy = [Side::Front, Side::Back].into_iter().filter_map(|side| energy(band, side)).collect();
    report.reciprocity = Part::ALL.into_iter().filter_map(|part| reciprocity(band, part)).collect();
    report.symmetry = band.components().filter_map(|(part, c)| symmetry::symmetry(c, part)).collect();
    report.noise = band.components().map(|(part, c)| noise::noise(band, c, part)).collect();
    report.gamut = band.components().filter_map(|(part, c)| gamut::gamut(c, part)).collect();

    let mut found = energy::findings(&report.energy, tolerance.energy);
    let units = units::findings(band, &report);
    // What the wrong unit explains is not told twice.
    let turned = if units.is_empty() { relation::findings(band, &report) } else { Vec::new() };
    found.extend(reciprocity::findings(band, &report.reciprocity, tolerance.reciprocity));
    found.extend(units);
    found.extend(header::wavelength(band));
    found.extend(turned);
    found.extend(sides::findings(band, &report, tolerance.energy));
    found.extend(symmetry::finding(&report.symmetry));
    found.extend(noise::findings(&report.noise, tolerance.noise));
    found.extend(gamut::findings(&report.gamut));
    found.sort_by_key(|finding| finding.severity as u8);
    report.findings = found;
    report
}

/// The name of a component, or of both transmissions.
fn name(part: Part) -> &'static str {
    if part.is_reflection() { part.file_name() } else { "Transmission" }
}

fn from(side: Side) -> &'static str {
    match side {
        Side::Front => "the room (front, +Z)",
        Side::Back => "outside (back, −Z)",
    }
}

/// A direction as polar angle from the nearer normal and azimuth \[degree\].
fn polar([x, y, z]: Direction) -> String {
    let theta = x.hypot(y).atan2(z.abs()).to_degrees();
    let phi = y.atan2(x).to_degrees().rem_euclid(360.0);
    format!("θ = {theta:.1}°, φ = {phi:.1}°")
}

#[cfg(test)]
mod tests;
