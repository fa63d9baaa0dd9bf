//! `antimatter`: volumes inside of which some materials are not there.
//!
//! In: what a path meets. Out: whether it is there, and as what. Nothing of this is kept for a device without antimatter.
//!
//! A path that passes the front of an antimatter surface becomes blind to the surfaces of the materials it names, until it passes
//! the back. It goes on counting them, though: a path that has passed more fronts than backs of a material is inside an object of
//! it. Where the path is inside an object on one side of the antimatter surface only, that is the object's new surface: it has the
//! first of the named materials, and its front is where the object is not, which is the back of the antimatter surface. If the
//! first name is `void`, no such surface is seen.
//!
//! Source: Radiance's reference manual; `rtrace`, observed. Deviations: antimatter volumes may overlap, and are then one volume
//! (in Radiance a path that leaves either sees all again); definitions of one name and the same parameters are one
//! material; what a path is inside of is told for each material, not for their sum. As in Radiance, objects have to be closed with
//! normals that point out of them, and a path has to start outside of all of them.

use bsdftree_device::Device;
use bsdftree_device::material::{Antimatter, Material};

use crate::bvh::Hit;

/// The materials of a device that antimatter hides, and the antimatter.
#[derive(Clone, Debug)]
pub(super) struct Volumes {
    /// For each material, its place in [`Within`], if some antimatter hides it.
    places: Vec<Option<usize>>,
    /// For each material, the places of what it hides, if it is antimatter, and what its surface is made of.
    rules: Vec<Option<Rule>>,
    n_places: usize,
}

#[derive(Clone, Debug)]
struct Rule {
    hidden: Vec<usize>,
    skin: Option<u32>,
}

/// What a path is inside of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Within(Vec<Counts>);

/// Surfaces passed from the front less those from the back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counts {
    /// Of the material.
    objects: i32,
    /// Of antimatter that hides it; never below 0.
    antimatter: i32,
}

/// What a path meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Seen {
    /// Nothing: it goes straight on.
    Nothing,
    /// What it hit.
    Surface,
    /// The surface of an object that antimatter has cut, of this material; its front is the back of what was hit.
    Skin(u32),
}

impl Volumes {
    /// `None` for a device without antimatter.
    pub fn new(device: &Device) -> Option<Volumes> {
        let is_antimatter = |m: &&Material| matches!(m, Material::Antimatter(_));
        device.materials.iter().map(|m| &m.material).find(is_antimatter)?;
        let mut volumes =
            Volumes { places: vec![None; device.materials.len()], rules: Vec::new(), n_places: 0 };
        for named in &device.materials {
            let rule = match &named.material {
                Material::Antimatter(Antimatter { skin, hidden }) => Some(Rule {
                    hidden: hidden.iter().map(|&material| volumes.place(material)).collect(),
                    skin: *skin,
                }),
                _ => None,
            };
            volumes.rules.push(rule);
        }
        Some(volumes)
    }

    fn place(&mut self, material: u32) -> usize {
        *self.places[material as usize].get_or_insert_with(|| {
            self.n_places += 1;
            self.n_places - 1
        })
    }

    /// A path that begins outside of everything.
    pub fn outside(&self) -> Within {
        Within(vec![Counts::default(); self.n_places])
    }

    /// What a path meets at a hit.
    pub fn meet(&self, within: &Within, hit: &Hit) -> Seen {
        let material = hit.material as usize;
        if self.places[material].is_some_and(|place| within.0[place].antimatter > 0) {
            return Seen::Nothing;
        }
        match &self.rules[material] {
            None => Seen::Surface,
            Some(rule) => {
                rule.skin.filter(|_| within.is_cut(rule, hit.front)).map_or(Seen::Nothing, Seen::Skin)
            }
        }
    }

    /// Notes that a path has passed through what it hit, whatever that was to it.
    pub fn pass(&self, within: &mut Within, hit: &Hit) {
        let material = hit.material as usize;
        let step = if hit.front { 1 } else { -1 };
        let place = self.places[material];
        // Antimatter that is hidden itself does not hide.
        let is_hidden = place.is_some_and(|place| within.0[place].antimatter > 0);
        if let Some(place) = place {
            within.0[place].objects += step;
        }
        if let Some(rule) = self.rules[material].as_ref().filter(|_| !is_hidden) {
            for &place in &rule.hidden {
                let count = &mut within.0[place].antimatter;
                *count = (*count + step).max(0);
            }
        }
    }
}

impl Within {
    /// Whether one side of an antimatter surface is inside an object and the other is not.
    fn is_cut(&self, rule: &Rule, entering: bool) -> bool {
        // Hidden by this surface's own volume, one is no more after leaving it.
        let own = i32::from(!entering);
        rule.hidden.iter().map(|&place| self.0[place]).any(|c| c.objects > 0 && c.antimatter <= own)
    }
}
