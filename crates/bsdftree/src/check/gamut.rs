//! Colours that no light has, and colours that RGB cannot show.

use super::pairs::{draw, mean};
use super::{Finding, Kind, Repair, Severity, polar};
use crate::bsdf::{Component, Part};
use crate::color::{rgb_from_xyz, uv_from_xyz};
use crate::direction::Direction;
use crate::locus::possible;

/// How far beyond the locus a colour may be by rounding \[u′v′\].
const ROUNDING: f64 = 0.002;
/// How negative a primary may be by rounding, as a fraction of the luminance.
const RGB_ROUNDING: f64 = 0.005;

/// What the colours of a component are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gamut {
    /// The component.
    pub part: Part,
    /// Share of its light whose colour is beyond the spectral locus.
    pub impossible: f64,
    /// Share of its light of which Radiance's RGB would be negative.
    pub beyond_rgb: f64,
    /// How far the worst lies beyond the locus, on the way from white \[u′v′\].
    pub max: f64,
    /// Its u′, v′.
    pub uv: [f64; 2],
    /// Its incident and exitant direction.
    pub at: [Direction; 2],
}

/// How far a colour lies beyond the locus \[u′v′\].
fn beyond(uv: [f64; 2]) -> f64 {
    let [u, v] = possible(uv);
    (uv[0] - u).hypot(uv[1] - v)
}

/// The colours of a component; `None` if it has none.
pub(super) fn gamut(component: &Component, part: Part) -> Option<Gamut> {
    component.chroma.as_ref()?;
    let pairs = draw(&component.luminance, part);
    let xyz = |i, o| component.eval_xyz(i, o, false);
    let mut gamut =
        Gamut { part, impossible: 0.0, beyond_rgb: 0.0, max: 0.0, uv: [0.0; 2], at: [[0.0, 0.0, 1.0]; 2] };
    for pair in &pairs {
        let uv = uv_from_xyz(xyz(pair.incident, pair.exitant));
        if beyond(uv) > gamut.max {
            (gamut.max, gamut.uv, gamut.at) = (beyond(uv), uv, [pair.incident, pair.exitant]);
        }
    }
    let share = |is: &dyn Fn([f64; 3]) -> bool| {
        mean(&pairs, |pair| f64::from(u8::from(is(xyz(pair.incident, pair.exitant)))))
    };
    gamut.impossible = share(&|xyz| beyond(uv_from_xyz(xyz)) > ROUNDING);
    gamut.beyond_rgb = share(&|xyz| rgb_from_xyz(xyz).iter().any(|&c| c < -RGB_ROUNDING * xyz[1]));
    Some(gamut)
}

pub(super) fn findings(gamuts: &[Gamut]) -> Vec<Finding> {
    let mut found = Vec::new();
    for g in gamuts {
        if g.impossible > 0.0 {
            let message = format!(
                "{:.1} % of the light of {} has a colour that no light has, the worst u′ = {:.3}, v′ = {:.3} from {} to {}",
                100.0 * g.impossible,
                g.part.file_name(),
                g.uv[0],
                g.uv[1],
                polar(g.at[0]),
                polar(g.at[1]),
            );
            let advice =
                "measure or generate it again, or move colours towards white until they are possible";
            let finding = Finding::new(Kind::Colour, Severity::Warning, message, advice);
            found.push(finding.of(g.part).at(g.at).by(g.impossible).mended_by(Repair::ClipColour));
        }
        if g.beyond_rgb > g.impossible {
            let message = format!(
                "{:.1} % of the light of {} is more saturated than the primaries of RGB: renderers will cut it off at 0",
                100.0 * g.beyond_rgb,
                g.part.file_name()
            );
            let advice = "nothing, unless the colour is not that of the device";
            found.push(
                Finding::new(Kind::Colour, Severity::Note, message, advice).of(g.part).by(g.beyond_rgb),
            );
        }
    }
    found
}
