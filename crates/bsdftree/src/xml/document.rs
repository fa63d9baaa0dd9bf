//! The elements of an XML text, without their text: only where it stands.
//!
//! Nothing is expanded: a document type that declares entities is refused, other entities than XML's own five stay errors.
//! Depth, number of elements and length of a tag are bounded, so memory and time are linear in the file.

use std::borrow::Cow;
use std::ops::Range;

use quick_xml::errors::Error;
use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::error::{Fault, XmlError, excerpt};
use super::repair::Repairs;

/// Deepest element: a BSDF file needs 8.
const MAX_DEPTH: usize = 32;
/// Most elements: 5 000 wavelengths with four components each need as many.
const MAX_ELEMENTS: usize = 1 << 17;
/// Longest tag \[byte\].
const MAX_TAG: usize = 1 << 16;
/// Most comments before the root element.
const MAX_COMMENTS: usize = 1 << 12;
/// No element.
const NONE: u32 = u32::MAX;

struct Element<'a> {
    tag: BytesStart<'a>,
    /// Of its start tag.
    offset: usize,
    /// Between its tags.
    content: Range<usize>,
    first_child: u32,
    next_sibling: u32,
}

/// The elements of a text.
pub(super) struct Document<'a> {
    text: &'a str,
    elements: Vec<Element<'a>>,
    comments: Vec<&'a str>,
}

/// One element of a document.
#[derive(Clone, Copy)]
pub(super) struct Node<'d> {
    document: &'d Document<'d>,
    index: u32,
}

/// An element that is not closed yet.
struct Open {
    index: u32,
    last_child: u32,
}

/// The document being made.
struct Growth<'a> {
    document: Document<'a>,
    open: Vec<Open>,
}

impl<'a> Document<'a> {
    /// The elements of the text from `start` on.
    pub(super) fn new(text: &'a str, start: usize, repairs: &mut Repairs) -> Result<Document<'a>, XmlError> {
        let mut reader = Reader::from_str(&text[start..]);
        // A lone `&` is met in names; whether it is let pass is decided where the text is used.
        reader.config_mut().allow_dangling_amp = true;
        let document = Document { text, elements: Vec::new(), comments: Vec::new() };
        let mut growth = Growth { document, open: Vec::new() };
        loop {
            let offset = start + reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|error| growth.syntax(&error, &reader, start))?;
            let end = start + reader.buffer_position() as usize;
            match event {
                Event::Start(tag) => growth.open(tag, offset, end)?,
                Event::Empty(tag) => {
                    growth.open(tag, offset, end)?;
                    growth.close(end);
                }
                Event::End(_) => growth.close(offset),
                Event::Comment(_) if growth.document.elements.is_empty() => growth.comment(offset..end)?,
                Event::DocType(declaration) if declaration.contains('[') => {
                    return Err(XmlError::new(offset, Fault::Entities));
                }
                Event::Text(_) | Event::CData(_) | Event::GeneralRef(_) if growth.open.is_empty() => {
                    let outside = text[offset..end].trim_ascii();
                    if !outside.is_empty() {
                        let found = format!("`{}` outside the root element", excerpt(outside.as_bytes()));
                        repairs.repair(offset, found, "it ignored")?;
                    }
                }
                Event::Eof => return growth.finish(),
                _ => {}
            }
        }
    }

    /// Comments before the root element, as they stand in the file.
    pub(super) fn comments(&self) -> &[&'a str] {
        &self.comments
    }

    /// The root element.
    pub(super) fn root(&self) -> Node<'_> {
        Node { document: self, index: 0 }
    }
}

impl<'a> Growth<'a> {
    fn open(&mut self, tag: BytesStart<'a>, offset: usize, end: usize) -> Result<(), XmlError> {
        let elements = &mut self.document.elements;
        let limit = |what, limit| Err(XmlError::new(offset, Fault::Limit { what, limit }));
        if tag.len() > MAX_TAG {
            return limit("bytes in one tag", MAX_TAG);
        }
        if self.open.len() == MAX_DEPTH {
            return limit("elements inside each other", MAX_DEPTH);
        }
        if elements.len() == MAX_ELEMENTS {
            return limit("elements", MAX_ELEMENTS);
        }
        let index = elements.len() as u32;
        match self.open.last_mut() {
            Some(parent) if parent.last_child == NONE => {
                elements[parent.index as usize].first_child = index;
                parent.last_child = index;
            }
            Some(parent) => {
                elements[parent.last_child as usize].next_sibling = index;
                parent.last_child = index;
            }
            None if index > 0 => {
                let found = format!("a second root element <{}>", excerpt(tag.name().as_ref().as_bytes()));
                return Err(XmlError::new(offset, Fault::Syntax(found)));
            }
            None => {}
        }
        elements.push(Element { tag, offset, content: end..end, first_child: NONE, next_sibling: NONE });
        self.open.push(Open { index, last_child: NONE });
        Ok(())
    }

    fn close(&mut self, offset: usize) {
        if let Some(open) = self.open.pop() {
            let content = &mut self.document.elements[open.index as usize].content;
            content.end = offset.max(content.start);
        }
    }

    fn comment(&mut self, range: Range<usize>) -> Result<(), XmlError> {
        if self.document.comments.len() == MAX_COMMENTS {
            let what = "comments before the root element";
            return Err(XmlError::new(range.start, Fault::Limit { what, limit: MAX_COMMENTS }));
        }
        let comment = &self.document.text[range];
        let comment = comment.strip_prefix("<!--").and_then(|c| c.strip_suffix("-->")).unwrap_or_default();
        if !comment.trim().is_empty() {
            self.document.comments.push(comment);
        }
        Ok(())
    }

    fn finish(self) -> Result<Document<'a>, XmlError> {
        let end = self.document.text.len();
        if let Some(fault) = self.truncated() {
            return Err(XmlError::new(end, fault));
        }
        if self.document.elements.is_empty() {
            return Err(XmlError::new(end, Fault::NotText("no XML element")));
        }
        Ok(self.document)
    }

    /// What to say if the text ends here.
    fn truncated(&self) -> Option<Fault> {
        let innermost = self.open.last()?.index as usize;
        let element = excerpt(self.document.elements[innermost].tag.name().as_ref().as_bytes());
        Some(Fault::Truncated { element })
    }

    fn syntax(&self, error: &Error, reader: &Reader<&[u8]>, start: usize) -> XmlError {
        // A syntax error of this parser is always markup that the end of the text cuts off.
        let fault = match error {
            Error::Syntax(_) => self.truncated(),
            _ => None,
        };
        let offset = start + reader.error_position() as usize;
        XmlError::new(offset, fault.unwrap_or_else(|| Fault::Syntax(error.to_string())))
    }
}

impl<'d> Node<'d> {
    fn element(self) -> &'d Element<'d> {
        &self.document.elements[self.index as usize]
    }

    /// Its name without a namespace prefix.
    pub(super) fn name(self) -> &'d str {
        self.element().tag.local_name().into_inner()
    }

    /// Where its start tag stands.
    pub(super) fn offset(self) -> usize {
        self.element().offset
    }

    /// Its children.
    pub(super) fn children(self) -> impl Iterator<Item = Node<'d>> {
        let document = self.document;
        let node = move |index: u32| (index != NONE).then_some(Node { document, index });
        std::iter::successors(node(self.element().first_child), move |child| {
            node(child.element().next_sibling)
        })
    }

    /// Its children of a name.
    pub(super) fn all(self, name: &'static str) -> impl Iterator<Item = Node<'d>> {
        self.children().filter(move |child| child.name() == name)
    }

    /// Its first child of a name.
    pub(super) fn child(self, name: &'static str) -> Option<Node<'d>> {
        self.all(name).next()
    }

    /// The same, needed.
    pub(super) fn need(self, element: &'static str, advice: &'static str) -> Result<Node<'d>, XmlError> {
        let missing = || Fault::Missing { parent: self.name().into(), element, advice };
        self.child(element).ok_or_else(|| XmlError::new(self.offset(), missing()))
    }

    /// Whether its start tag has attributes, legal or not.
    pub(super) fn has_attributes(self) -> bool {
        self.element().tag.attributes().next().is_some()
    }

    /// An attribute's value.
    pub(super) fn attribute(self, name: &str) -> Result<Option<Cow<'d, str>>, XmlError> {
        let refused = |problem: String| XmlError::new(self.offset(), Fault::Syntax(problem));
        let tag = &self.element().tag;
        let found = tag.try_get_attribute(name).map_err(|error| refused(error.to_string()))?;
        match found {
            None => Ok(None),
            Some(attribute) => match unescape(&attribute.value) {
                Ok(value) => Ok(Some(Cow::Owned(value.into_owned()))),
                Err(error) => Err(refused(error.to_string())),
            },
        }
    }

    /// Its text: comments left out, CDATA and XML's own entities resolved, lines ended by `\n`.
    pub(super) fn text(self, repairs: &mut Repairs) -> Result<String, XmlError> {
        let mut text = String::new();
        for (piece, offset) in self.pieces() {
            match piece {
                Piece::Text(raw) => {
                    // Line ends first: a `&#13;` is meant as it is written.
                    let raw = raw.replace("\r\n", "\n");
                    match unescape(&raw) {
                        Ok(plain) => text.push_str(&plain),
                        Err(error) => {
                            let found =
                                format!("<{}> has a `&` that begins no entity ({error})", self.name());
                            repairs.repair(offset, found, "it taken as it stands")?;
                            text.push_str(&raw);
                        }
                    }
                }
                Piece::CData(raw) => text.push_str(&raw.replace("\r\n", "\n")),
                Piece::Comment => {}
                Piece::Markup => return Err(self.unexpected_markup(offset)),
            }
        }
        Ok(text)
    }

    /// Its text as numbers need it, and where that stands: markup blanked out, every byte at its place.
    pub(super) fn data(self) -> Result<(Cow<'d, [u8]>, usize), XmlError> {
        let content = self.element().content.clone();
        let start = content.start;
        let raw = self.document.text[content].as_bytes();
        if let Some(at) = memchr::memchr(b'&', raw) {
            let expected = "digits, braces and separators as they are".into();
            let found = excerpt(&raw[at..]);
            let fault = Fault::Unexpected { what: "a reference inside the data", found, expected };
            return Err(XmlError::new(start + at, fault));
        }
        if memchr::memchr(b'<', raw).is_none() {
            return Ok((Cow::Borrowed(raw), start));
        }
        let mut blanked = vec![b' '; raw.len()];
        for (piece, offset) in self.pieces() {
            match piece {
                Piece::Text(text) | Piece::CData(text) => {
                    blanked[offset - start..][..text.len()].copy_from_slice(text.as_bytes());
                }
                Piece::Comment => {}
                Piece::Markup => return Err(self.unexpected_markup(offset)),
            }
        }
        Ok((Cow::Owned(blanked), start))
    }

    fn unexpected_markup(self, offset: usize) -> XmlError {
        let found = excerpt(&self.document.text.as_bytes()[offset..self.element().content.end]);
        XmlError::new(
            offset,
            Fault::Unexpected {
                what: "markup inside text",
                found,
                expected: format!("only text in <{}>", excerpt(self.name().as_bytes())),
            },
        )
    }

    fn pieces(self) -> impl Iterator<Item = (Piece<'d>, usize)> {
        let Range { start, end } = self.element().content;
        let text = &self.document.text[..end];
        let mut at = start;
        std::iter::from_fn(move || {
            let rest = &text[at..];
            if rest.is_empty() {
                return None;
            }
            let until = |closing: &str| rest.find(closing).map_or(rest.len(), |i| i + closing.len());
            let begin = at;
            let (piece, offset) = if rest.starts_with("<!--") {
                at += until("-->");
                (Piece::Comment, begin)
            } else if let Some(raw) = rest.strip_prefix("<![CDATA[") {
                at += until("]]>");
                let raw = raw.split_once("]]>").map_or(raw, |(raw, _)| raw);
                (Piece::CData(raw), begin + "<![CDATA[".len())
            } else if rest.starts_with('<') {
                at += until(">");
                (Piece::Markup, begin)
            } else {
                at += memchr::memchr(b'<', rest.as_bytes()).unwrap_or(rest.len());
                (Piece::Text(&text[begin..at]), begin)
            };
            Some((piece, offset))
        })
    }
}

/// A stretch of an element's content.
enum Piece<'a> {
    /// With entities.
    Text(&'a str),
    /// Literal.
    CData(&'a str),
    Comment,
    /// A child element or a processing instruction.
    Markup,
}
