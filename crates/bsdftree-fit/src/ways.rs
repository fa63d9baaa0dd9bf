//! Ways of light through a prismatic film that reflect it inside, or let it out of one ridge and into the next.
//!
//! In: the two facets of a film and its index, as the maps of its brightest lobes tell them. Out: all sequences of refraction and
//! reflection that light of a direction can take ([`Film::ways`]), where each goes, and what faces let through on the way (Fresnel). How
//! much of the light meets the faces in that order depends on how long they are, which is not known, so a sequence is only what a lobe may
//! follow: [`crate::link`] says which do.

use bsdftree::Part;
use bsdftree::direction::Direction;
use bsdftree::peaks::{Map, bent, reflected, transmittance};

/// Most faces that light meets.
const MOST_STEPS: usize = 7;

/// What is less than this part of the light is not followed.
const LEAST: f64 = 5e-3;

/// The number of the flat face.
const FLAT: usize = 2;

/// Two facets and a flat face, with ridges on one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Film {
    /// Unit, out of the material; the flat one last.
    faces: [Direction; 3],
    index: f64,
    flat_first: bool,
    /// The sign of z of light that leaves.
    leaves: f64,
}

/// What light meets: a face, and whether it goes through it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Step {
    face: u8,
    through: bool,
}

/// A film with the faces that light meets in it, one after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Way {
    film: Film,
    steps: [Option<Step>; MOST_STEPS],
}

/// Light on its way.
#[derive(Clone, Copy)]
struct Light {
    /// The direction of travel times the index of where it is.
    vector: Direction,
    inside: bool,
    /// What is left of it.
    power: f64,
}

impl Film {
    /// The film of two prism maps, if they can be of one.
    pub fn of(part: Part, one: Map, other: Map) -> Option<Film> {
        let Map::Prism { normal: a, index: m, flat_first } = one else { return None };
        let Map::Prism { normal: b, index: n, flat_first: second } = other else { return None };
        /// Facets of one film have the same index and differ.
        const SAME: f64 = 0.1;
        if flat_first != second || (m - n).abs() > SAME || (a[0] - b[0]).hypot(a[1] - b[1]) < SAME {
            return None;
        }
        let [ridges, flat] = match flat_first {
            true => [part.exitant_side().sign(), part.incident_side().sign()],
            false => [part.incident_side().sign(), part.exitant_side().sign()],
        };
        let faces = [a.map(|c| c * ridges), b.map(|c| c * ridges), [0.0, 0.0, flat]];
        Some(Film { faces, index: 0.5 * (m + n), flat_first, leaves: part.exitant_side().sign() })
    }

    /// All ways of light from a direction through the film, with the place where each goes and what is let through.
    pub fn ways(&self, incident: Direction) -> Vec<(Way, [f64; 2], f64)> {
        let mut found = Vec::new();
        let light = Light { vector: incident.map(|c| -c), inside: false, power: 1.0 };
        self.follow(light, Way { film: *self, steps: [None; MOST_STEPS] }, 0, &mut found);
        found
    }

    fn follow(&self, light: Light, way: Way, n: usize, found: &mut Vec<(Way, [f64; 2], f64)>) {
        if n == MOST_STEPS {
            return;
        }
        let faces = match (light.inside, n == 0 && self.flat_first) {
            (true, _) => 0..FLAT + 1,
            (false, true) => FLAT..FLAT + 1,
            (false, false) => 0..FLAT,
        };
        for (face, through) in faces.flat_map(|face| [(face, true), (face, false)]) {
            let Some(next) = self.met(light, face, through).filter(|next| next.power > LEAST) else {
                continue;
            };
            let mut way = way;
            way.steps[n] = Some(Step { face: face as u8, through });
            if !next.inside && (face != FLAT) == self.flat_first && next.vector[2] * self.leaves > 0.0 {
                found.push((way, [next.vector[0], next.vector[1]], next.power));
            }
            if next.inside || face != FLAT {
                self.follow(next, way, n + 1, found);
            }
        }
    }

    /// Light after it has met a face; `None` if it does not go there. Light that the flat face would let out keeps x and y, beyond the
    /// unit circle too, where nothing is left of it.
    fn met(&self, light: Light, face: usize, through: bool) -> Option<Light> {
        let (normal, square) = (self.faces[face], self.index * self.index);
        let part: f64 = (0..3).map(|k| light.vector[k] * normal[k]).sum();
        if light.inside != (part > 0.0) {
            return None;
        }
        let outside = if light.inside { part * part + 1.0 - square } else { part * part };
        let passed = if outside > 0.0 { transmittance(self.index, outside.sqrt()) } else { 0.0 };
        if !through {
            return Some(Light {
                vector: reflected(light.vector, normal),
                power: light.power * (1.0 - passed),
                ..light
            });
        }
        let growth = if light.inside { 1.0 - square } else { square - 1.0 };
        let vector = match bent(light.vector, normal, growth) {
            None if face == FLAT => light.vector,
            vector => vector?,
        };
        Some(Light { vector, inside: !light.inside, power: light.power * passed })
    }
}

impl Way {
    /// Where light from a direction leaves, in direction cosines, and what is let through; `None` if it does not go that way.
    pub fn to(&self, incident: Direction) -> Option<([f64; 2], f64)> {
        let mut light = Light { vector: incident.map(|c| -c), inside: false, power: 1.0 };
        for step in self.steps.iter().flatten() {
            light = self.film.met(light, usize::from(step.face), step.through)?;
        }
        Some(([light.vector[0], light.vector[1]], light.power))
    }

    /// Faces that are met, to tell ways of a film apart.
    pub fn is_same(&self, other: &Way) -> bool {
        self.steps == other.steps
    }
}

#[cfg(test)]
mod tests {
    use bsdftree::direction::normalized;

    use super::*;

    fn film(part: Part, flat_first: bool) -> Film {
        let prism =
            |y: f64, z: f64| Map::Prism { normal: normalized([0.1, y, z]).unwrap(), index: 1.49, flat_first };
        Film::of(part, prism(0.866, 0.5), prism(-0.5, 0.866)).unwrap()
    }

    #[test]
    fn light_that_goes_back_takes_the_same_way() {
        let [forward, back] = [film(Part::TransmissionBack, false), film(Part::TransmissionFront, true)];
        let incident = normalized([0.2, 0.65, 0.7]).unwrap();
        let mut n_found = 0;
        for (way, [x, y], power) in forward.ways(incident) {
            let from = [x, y, -(1.0 - x * x - y * y).sqrt()];
            let is_same = |&(_, to, other): &(Way, [f64; 2], f64)| {
                (to[0] - incident[0]).hypot(to[1] - incident[1]) < 1e-9 && (other - power).abs() < 1e-9
            };
            assert!(back.ways(from).iter().any(is_same), "{way:?}");
            n_found += 1;
        }
        assert!(n_found > 3, "{n_found}");
    }

    #[test]
    fn a_way_goes_where_its_film_found_it() {
        let film = film(Part::TransmissionBack, false);
        let incident = normalized([0.2, 0.65, 0.7]).unwrap();
        let ways = film.ways(incident);
        assert!(ways.iter().all(|&(way, place, power)| way.to(incident) == Some((place, power))));
        // Straight through both facets there is what their maps say.
        let prism =
            Map::Prism { normal: normalized([0.1, -0.5, 0.866]).unwrap(), index: 1.49, flat_first: false };
        let [x, y] = prism.cosines(incident, bsdftree::direction::Side::Back).unwrap();
        let through = prism.transmittance(incident, [x, y]);
        let same = |&(_, [u, v], power): &(Way, [f64; 2], f64)| {
            (x - u).hypot(y - v) < 1e-9 && (power - through).abs() < 1e-9
        };
        assert!(ways.iter().any(same));
    }
}
