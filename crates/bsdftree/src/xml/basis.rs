//! Angle bases: those that the file defines, and the well-known ones.

use std::sync::Arc;

use super::document::Node;
use super::error::{Fault, XmlError, excerpt};
use super::header::{MAX_NAME, short_text};
use super::repair::Repairs;
use crate::klems::{Basis, Ring};

/// The bases of a file.
pub(super) struct Bases {
    defined: Vec<Arc<Basis>>,
}

impl Bases {
    /// Those of `DataDefinition`. A definition in the file goes before a well-known basis of that name (Radiance ignores it).
    pub(super) fn new(definition: Node<'_>, repairs: &mut Repairs) -> Result<Bases, XmlError> {
        let mut defined: Vec<Arc<Basis>> = Vec::new();
        for node in definition.all("AngleBasis") {
            let basis = basis(node, repairs)?;
            let known = Basis::named(basis.name());
            if !known.is_empty() && !known.iter().any(|k| k.rings() == basis.rings()) {
                let note = format!(
                    "the file's own definition of {} is used; it differs from the usual one, which Radiance uses",
                    basis.name()
                );
                repairs.note(node.offset(), note);
            }
            match defined.iter().find(|b| b.name().eq_ignore_ascii_case(basis.name())) {
                Some(first) if first.rings() != basis.rings() => {
                    let found = format!("a second, different definition of {}", basis.name());
                    repairs.repair(node.offset(), found, "the first used")?;
                }
                Some(_) => {}
                None => defined.push(Arc::new(basis)),
            }
        }
        Ok(Bases { defined })
    }

    /// The bases that a name may mean.
    pub(super) fn named(&self, node: Node<'_>, repairs: &mut Repairs) -> Result<Vec<Arc<Basis>>, XmlError> {
        let name = short_text(node, repairs)?;
        if let Some(basis) = self.defined.iter().find(|b| b.name().eq_ignore_ascii_case(&name)) {
            return Ok(vec![Arc::clone(basis)]);
        }
        let known = Basis::named(&name);
        if known.is_empty() {
            let known =
                "LBNL/Klems Full, LBNL/Klems Half, LBNL/Klems Quarter or one that DataDefinition defines";
            let fault = Fault::Unexpected {
                what: "the angle basis",
                found: excerpt(name.as_bytes()),
                expected: known.into(),
            };
            return Err(XmlError::new(node.offset(), fault));
        }
        Ok(known.into_iter().map(Arc::new).collect())
    }

    /// The one basis that the file defines, if it is one.
    pub(super) fn only(&self) -> Option<Vec<Arc<Basis>>> {
        (self.defined.len() == 1).then(|| self.defined.clone())
    }
}

fn basis(node: Node<'_>, repairs: &mut Repairs) -> Result<Basis, XmlError> {
    let name = short_text(node.need("AngleBasisName", "name the basis")?, repairs)?;
    if name.len() > MAX_NAME {
        return Err(XmlError::new(node.offset(), Fault::Limit { what: "bytes in a name", limit: MAX_NAME }));
    }
    let mut rings =
        node.all("AngleBasisBlock").map(|block| ring(block, repairs)).collect::<Result<Vec<_>, _>>()?;
    // π/2, however rounded; no basis ends there in degrees.
    if let Some(end) = rings.last().map(|ring| ring.bounds_deg[1]).filter(|end| (1.5..=1.6).contains(end)) {
        let found = format!("the basis {name} ends at {end}, which is 90° in radians");
        repairs.repair(node.offset(), found, "its angles taken as radians")?;
        // Rounded to a hundredth of a degree, since files round radians.
        let degrees = |angle: f64| (100.0 * angle.to_degrees()).round() / 100.0;
        rings.iter_mut().for_each(|ring| ring.bounds_deg = ring.bounds_deg.map(degrees));
    }
    let refused = |problem| XmlError::new(node.offset(), Fault::Basis { name: name.clone(), problem });
    Basis::new(name.clone(), rings).map_err(refused)
}

fn ring(block: Node<'_>, repairs: &mut Repairs) -> Result<Ring, XmlError> {
    let bounds = block.need("ThetaBounds", "give LowerTheta and UpperTheta of the ring")?;
    let lower = number(bounds.need("LowerTheta", "give the ring's lower polar angle in degrees")?, repairs)?;
    let upper = number(bounds.need("UpperTheta", "give the ring's upper polar angle in degrees")?, repairs)?;
    let n_phi = block.need("nPhis", "give the number of patches of the ring")?;
    let n_phi = number(n_phi, repairs).and_then(|n| {
        let whole = n >= 0.0 && n <= f64::from(u32::MAX) && n.fract() == 0.0;
        whole.then_some(n as u32).ok_or_else(|| {
            let found = excerpt(n.to_string().as_bytes());
            XmlError::new(n_phi.offset(), Fault::BadNumber { found, problem: "nPhis is a whole number" })
        })
    })?;
    Ok(Ring { bounds_deg: [lower, upper], n_phi })
}

fn number(node: Node<'_>, repairs: &mut Repairs) -> Result<f64, XmlError> {
    let text = short_text(node, repairs)?;
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(XmlError::new(
            node.offset(),
            Fault::BadNumber { found: excerpt(text.as_bytes()), problem: "it is not a finite number" },
        )),
    }
}
