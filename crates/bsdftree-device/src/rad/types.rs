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
    /// A modifier that it does not handle, and which kind of modifier.
    UnsupportedModifier(&'static str),
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
            | "spectrum" | "specfile" | "specfunc" => Class::Modifier,
            "mixfunc" | "mixdata" | "mixpict" => Class::Mixture,
            "instance" | "mesh" => Class::Reference,
            "source" => Class::UnsupportedSurface,
            "colortext" | "brighttext" | "specdata" | "specpict" => Class::UnsupportedModifier("pattern"),
            "mixtext" => Class::UnsupportedModifier("mixture"),
            "mist" | "sBSDF" => Class::UnsupportedModifier("material"),
            _ => return None,
        })
    }
}

/// What to do about a kind of modifier that is not handled.
pub(super) fn advice(kind: &str) -> &'static str {
    match kind {
        "pattern" => "draw it into a picture for colorpict, or describe it by colorfunc or colordata",
        "mixture" => "draw it into a picture for mixpict, or describe it by mixfunc or mixdata",
        _ => "use plastic, metal, trans, their 2-forms, glass, dielectric, interface or mirror instead",
    }
}

/// Whether a type is of geometry, so that its name is no modifier's.
pub(crate) fn is_surface(kind: &str) -> bool {
    matches!(Class::of(kind), Some(Class::Surface | Class::Reference | Class::UnsupportedSurface))
}
