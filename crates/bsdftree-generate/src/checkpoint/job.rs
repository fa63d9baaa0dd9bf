//! What is counted, in clear text: a checkpoint of anything else is refused, with what differs.
//!
//! In: device and options. Out: one line for each thing that the counts depend on, and the device as the tracer sees it, without names.
//! Left out is what may change from run to run: how many samples, when to stop, how counts are reduced, threads.

use std::collections::HashMap;
use std::fmt::Write;

use bsdftree_device::field::digest;
use bsdftree_device::material::Antimatter;
use bsdftree_device::{Device, Material, Shape};

use crate::bands::Band;
use crate::entrance::Entrance;
use crate::layout::Layout;
use crate::options::Options;

/// First line of the file, but for its number.
const TITLE: &str = "bsdftree checkpoint";
/// Number of the form of all files of a checkpoint. To be raised with any change of that, or of what is counted, within a version.
const FORMAT: u32 = 3;
const DEVICE: &str = "\ndevice:\n";

/// What is counted in each band.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counted {
    /// Whether paths carry spectra.
    pub spectral: bool,
    /// Numbers in each band.
    pub n_channels: usize,
}

/// What is counted.
pub(crate) struct Job {
    entries: Vec<(&'static str, String)>,
    device: String,
}

impl Job {
    /// `n_sites`: patches of surface, if diffused light is reused.
    pub fn new(
        device: &Device,
        options: &Options,
        entrance: &Entrance,
        Counted { spectral, n_channels }: Counted,
        n_sites: Option<usize>,
    ) -> Job {
        let [low, high] = entrance.corners();
        let yes = |yes: bool| if yes { "yes" } else { "no" }.to_string();
        let entries = vec![
            ("version", env!("CARGO_PKG_VERSION").into()),
            ("layout", layout(&options.layout)),
            ("sides", format!("{:?}", options.sides).to_lowercase()),
            ("bands", options.bands.iter().map(Band::to_string).collect::<Vec<_>>().join(", ")),
            ("wavelengths", yes(spectral)),
            ("color", yes(n_channels > 1)),
            ("reuse", n_sites.map_or("no".into(), |n| format!("yes, {n} patches"))),
            ("sampling", if options.stratified { "sobol" } else { "random" }.into()),
            ("tile", yes(options.tile)),
            ("aperture", format!("{:?} to {:?} m", low.to_array(), high.to_array())),
            ("periods", format!("{:?}", entrance.periods())),
            ("seed", options.seed.to_string()),
        ];
        Job { entries, device: described(device) }
    }

    pub fn text(&self) -> String {
        let mut text = format!("{TITLE} {FORMAT}\n");
        for (name, value) in &self.entries {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{name}: {value}");
        }
        text + DEVICE + &self.device
    }

    /// What the text of another job has otherwise, or `None` if it is the text of no job.
    pub fn differences(&self, text: &str) -> Option<Vec<String>> {
        let (title, rest) = text.split_once('\n')?;
        let format = title.strip_prefix(TITLE)?.trim();
        if format != FORMAT.to_string() {
            return Some(vec![format!("format {FORMAT} here, but {format} there")]);
        }
        let (head, device) = rest.split_once(DEVICE)?;
        let theirs: HashMap<&str, &str> = head.lines().filter_map(|line| line.split_once(": ")).collect();
        let mut differences: Vec<String> = self
            .entries
            .iter()
            .map(|(name, ours)| (name, ours, theirs.get(name).copied().unwrap_or("nothing")))
            .filter(|(_, ours, theirs)| ours.as_str() != *theirs)
            .map(|(name, ours, theirs)| format!("{name} {ours} here, but {theirs} there"))
            .collect();
        differences.extend(self.device_difference(device));
        Some(differences)
    }

    fn device_difference(&self, device: &str) -> Option<String> {
        if self.device == device {
            return None;
        }
        let (mut ours, mut theirs) = (self.device.lines(), device.lines());
        let (mut definition, mut line) = ("", 1);
        loop {
            let (a, b) = (ours.next(), theirs.next());
            if a != b || a.is_none() {
                let [a, b] = [a, b].map(|text| text.map_or("nothing".into(), shortened));
                return Some(format!(
                    "the device has, as line {line} ({definition}), {a} here, but {b} there"
                ));
            }
            if let Some(text) = a.filter(|text| text.contains(char::is_alphabetic)) {
                definition = text;
            }
            line += 1;
        }
    }
}

fn shortened(line: &str) -> String {
    const MOST: usize = 60;
    let line = line.trim();
    match line.char_indices().nth(MOST) {
        None => format!("{line:?}"),
        Some((end, _)) => format!("{:?}…", &line[..end]),
    }
}

fn layout(layout: &Layout) -> String {
    match layout {
        Layout::Tree { rank, log2_res } => {
            format!("tree of rank {} with 2^{log2_res} cells per axis", rank.dimensions())
        }
        Layout::Klems(basis) => {
            let ring =
                |r: &bsdftree::klems::Ring| format!("{}-{}:{}", r.bounds_deg[0], r.bounds_deg[1], r.n_phi);
            let rings: Vec<String> = basis.rings().iter().map(ring).collect();
            format!("Klems basis of {} patches in rings {}", basis.n_patches(), rings.join(" "))
        }
    }
}

/// The device as text. Materials that scenes name files for, and what is smooth about meshes, are told by their content, not
/// by where it is.
fn described(original: &Device) -> String {
    let mut device = nameless(original);
    let mut more = String::new();
    for named in device.materials.iter_mut().filter(|named| !named.material.is_constant()) {
        let material = std::mem::replace(&mut named.material, Material::Void);
        // Writing to a String cannot fail.
        let _ = writeln!(more, "{} is {material:?}", named.name);
        if let Material::Antimatter(Antimatter { skin: Some(skin), .. }) = material {
            // It may be that of no surface.
            let _ = writeln!(more, "{} shows {:?}", named.name, original.materials[skin as usize].material);
        }
    }
    for (k, surface) in device.surfaces.iter().enumerate() {
        if let Shape::Mesh(mesh) = &surface.shape {
            let normals = mesh.vertices.normals.iter().flat_map(|n| n.to_array());
            let numbers = normals.chain(mesh.vertices.uvs.iter().flat_map(|uv| uv.to_array()));
            let bytes: Vec<u8> = numbers.flat_map(|x| x.to_bits().to_le_bytes()).collect();
            let _ = writeln!(more, "surface {k} is smooth and placed as {:016x}", digest(&bytes));
        }
    }
    device.to_rad() + &more
}

/// The device with its materials named in the order of their use, and nothing else named: names do not matter to light.
fn nameless(device: &Device) -> Device {
    let mut device = Device { warnings: Vec::new(), tile: None, ..device.clone() };
    let mut names = vec![None; device.materials.len()];
    let mut n_used = 0;
    for surface in &mut device.surfaces {
        surface.name = "s".into();
        names[surface.material as usize].get_or_insert_with(|| {
            n_used += 1;
            format!("m{n_used}")
        });
    }
    for (material, name) in device.materials.iter_mut().zip(names) {
        material.name = name.unwrap_or_default();
    }
    device
}
