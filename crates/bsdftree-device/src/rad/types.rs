//! The types of Radiance's primitives, by name.

/// What a type of primitive is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Geometry that this reader handles.
    Surface,
    /// A material that this reader handles.
    Material,
    /// Geometry that it does not handle.
    UnsupportedSurface,
    /// A modifier that it does not handle, and which kind of modifier.
    UnsupportedModifier(&'static str),
}

impl Class {
    /// The class of a type, `None` if Radiance has no such type.
    pub(super) fn of(kind: &str) -> Option<Class> {
        Some(match kind {
            "polygon" | "sphere" | "bubble" | "cylinder" | "tube" | "cone" | "cup" | "ring" => Class::Surface,
            "plastic" | "metal" | "trans" | "plastic2" | "metal2" | "trans2" | "glass" | "dielectric"
            | "interface" | "mirror" | "light" | "glow" | "spotlight" | "illum" => Class::Material,
            "source" | "instance" | "mesh" => Class::UnsupportedSurface,
            "texfunc" | "texdata" => Class::UnsupportedModifier("texture"),
            "colorfunc" | "brightfunc" | "colordata" | "brightdata" | "colorpict" | "colortext"
            | "brighttext" | "spectrum" | "specfile" | "specfunc" | "specdata" | "specpict" => {
                Class::UnsupportedModifier("pattern")
            }
            "mixfunc" | "mixdata" | "mixpict" | "mixtext" => Class::UnsupportedModifier("mixture"),
            "prism1" | "prism2" | "mist" | "plasfunc" | "metfunc" | "transfunc" | "BRTDfunc" | "plasdata"
            | "metdata" | "transdata" | "antimatter" | "BSDF" | "aBSDF" | "sBSDF" | "WGMDfunc" | "ashik2" => {
                Class::UnsupportedModifier("material")
            }
            _ => return None,
        })
    }
}

/// What to do about a kind of modifier that is not handled.
pub(super) fn advice(kind: &str) -> &'static str {
    match kind {
        "texture" => "remove it, or model the relief with polygons",
        "pattern" => "remove it or flatten it to a plain colour",
        "mixture" => "use one of its two materials",
        _ => "use plastic, metal, trans, their 2-forms, glass, dielectric, interface or mirror instead",
    }
}
