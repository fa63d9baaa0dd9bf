//! The types of Radiance's primitives, by name.

/// What a type of primitive is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// Geometry that this reader handles.
    Surface,
    /// A material that this reader handles.
    Material,
    /// A pattern or texture that this reader handles.
    Modifier,
    /// A mixture that this reader handles.
    Mixture,
    /// Geometry in another file.
    Reference,
    /// Geometry that it does not handle.
    UnsupportedSurface,
    /// A material that it does not handle.
    UnsupportedMaterial,
}

impl Class {
    /// The class of a type, `None` if Radiance has no such type.
    pub(super) fn of(kind: &str) -> Option<Class> {
        Some(match kind {
            "polygon" | "sphere" | "bubble" | "cylinder" | "tube" | "cone" | "cup" | "ring" => Class::Surface,
            "plastic" | "metal" | "trans" | "plastic2" | "metal2" | "trans2" | "glass" | "dielectric"
            | "interface" | "mirror" | "light" | "glow" | "spotlight" | "illum" | "plasfunc" | "metfunc"
            | "transfunc" | "BRTDfunc" | "plasdata" | "metdata" | "transdata" | "BSDF" | "aBSDF"
            | "ashik2" | "WGMDfunc" | "prism1" | "prism2" | "antimatter" => Class::Material,
            "texfunc" | "texdata" | "colorfunc" | "brightfunc" | "colordata" | "brightdata" | "colorpict"
            | "spectrum" | "specfile" | "specfunc" | "specdata" | "specpict" | "brighttext" | "colortext" => {
                Class::Modifier
            }
            "mixfunc" | "mixdata" | "mixpict" | "mixtext" => Class::Mixture,
            "instance" | "mesh" => Class::Reference,
            "source" => Class::UnsupportedSurface,
            "mist" => Class::UnsupportedMaterial,
            _ => return None,
        })
    }
}

/// What to do about a word that is no type.
pub(super) fn advice(kind: &str) -> &'static str {
    match kind {
        "BRTDdata" => "Radiance has no such material: use BRTDfunc, plasdata, metdata or transdata",
        _ => "check the spelling, and the argument counts of the primitive before it",
    }
}

/// Whether a type is of geometry, so that its name is no modifier's.
pub(crate) fn is_surface(kind: &str) -> bool {
    matches!(Class::of(kind), Some(Class::Surface | Class::Reference | Class::UnsupportedSurface))
}
