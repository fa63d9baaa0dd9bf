//! Other materials for the same device, such as what its surfaces are in another band of light.
//!
//! In: a device, and scene files that define materials under the names of the device's. Out: the device with those. Surfaces in the files do
//! not count. What is before a material (patterns, textures) comes with it.

use std::path::PathBuf;

use super::definition::MadeOf;
use super::scene::{Placement, Scene};
use crate::device::{Device, NamedMaterial};
use crate::error::{DeviceError, Place};
use crate::material::Material;
use crate::options::ReadOptions;

/// Most names in a message.
const MOST_NAMES: usize = 12;

impl Device {
    /// The same device, of the materials that Radiance scene files define under the names of its own. A warning names those that it
    /// keeps.
    ///
    /// ```no_run
    /// use bsdftree_device::{Device, Unit};
    /// let visible = Device::read_rad(&["blinds.rad".into()], Unit::Meter)?;
    /// let solar = visible.with_materials(&["solar.rad".into()], Unit::Meter)?;
    /// # Ok::<(), bsdftree_device::DeviceError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Device::read_rad`], and if the files define none of the device's materials.
    pub fn with_materials(
        &self,
        paths: &[PathBuf],
        options: impl Into<ReadOptions>,
    ) -> Result<Device, DeviceError> {
        let options = options.into();
        let placement = Placement::scaled(options.unit.meters());
        let mut scene = Scene::new(options);
        for path in paths {
            scene.file(path, &placement)?;
        }
        let files: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        let at = Place { file: files.join(", ").into(), line: 1 };
        let mut device = self.clone();
        let (mut kept, mut n_exchanged) = (Vec::new(), 0);
        let is_material =
            |named: &NamedMaterial| !matches!(named.material, Material::Void | Material::Antimatter(_));
        for named in device.materials.iter_mut().filter(|named| is_material(named)) {
            match scene.defined(&named.name) {
                Some(definition) => {
                    let made_of = definition.made_of().map_err(|problem| problem.raise(&named.name, &at))?;
                    let MadeOf::Material(material) = made_of else {
                        return Err(DeviceError::Unexpected {
                            at,
                            expected: format!("a material \"{}\"", named.name),
                            found: "antimatter".into(),
                            advice: "what it hides is the device's geometry, the same in all bands".into(),
                        });
                    };
                    named.material = material;
                    n_exchanged += 1;
                }
                None => kept.push(named.name.clone()),
            }
        }
        kept.sort_unstable();
        kept.dedup();
        let names = kept[..kept.len().min(MOST_NAMES)].join(", ");
        if n_exchanged == 0 {
            return Err(DeviceError::Unexpected {
                at,
                expected: format!("materials of the device's names ({names})"),
                found: "none of them".into(),
                advice: "give each the name that it has in the device's own files".into(),
            });
        }
        if !kept.is_empty() {
            let warning =
                format!("{} defines no {names}: what they are in the device itself is taken", at.file);
            device.warnings.push(warning);
        }
        Ok(device)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::material::Material;
    use crate::{Device, Unit};

    fn read(text: &str) -> Device {
        Device::parse_rad(text, "device.rad", ".".as_ref(), Unit::Meter).unwrap()
    }

    fn exchanged(text: &str) -> Result<Device, String> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("solar.rad");
        std::fs::write(&path, text).unwrap();
        let device = read(
            "void mirror a 0 0 3 .1 .1 .1\nvoid mirror b 0 0 3 .2 .2 .2\n\
             a ring ra 0 0 8 0 0 0 0 0 1 0 1\nb ring rb 0 0 8 0 0 -1 0 0 1 0 1\n",
        );
        device.with_materials(&[path], Unit::Meter).map_err(|error| error.to_string())
    }

    #[test]
    fn materials_of_the_same_names_take_their_place() {
        let device = exchanged(
            "void glass other 0 0 3 1 1 1\nvoid mirror b 0 0 3 .9 .9 .9\nb ring r 0 0 8 0 0 0 0 0 1 0 9\n",
        );
        let device = device.unwrap();
        let reflectances: Vec<_> = device
            .materials
            .iter()
            .map(|named| match named.material {
                Material::Mirror { reflectance } => reflectance,
                _ => panic!("{named:?}"),
            })
            .collect();
        assert_eq!(reflectances, [DVec3::splat(0.1), DVec3::splat(0.9)]);
        assert_eq!(device.surfaces.len(), 2);
        assert!(
            device.warnings.iter().any(|w| w.contains("solar.rad defines no a:")),
            "{:?}",
            device.warnings
        );
    }

    #[test]
    fn files_with_none_of_the_names_are_refused() {
        let error = exchanged("void mirror c 0 0 3 .9 .9 .9\n").unwrap_err();
        assert!(
            error.contains("solar.rad:1: expected materials of the device's names (a, b), found none"),
            "{error}"
        );
        let error = exchanged("void mirror b 0 0 3 .9 .9 1.5\n").unwrap_err();
        assert!(error.contains("solar.rad:1:") && error.contains("reflectance"), "{error}");
    }
}
