//! Parsing of XML, and places in it.

use super::cursor::{Cursor, Numbers, place_of, shown};
use crate::mesh::{MeshError, Place};
use roxmltree::{Document, Error, Node, ParsingOptions};

/// Largest number of elements and texts: 20 million take about 2 GB.
const MOST_NODES: u32 = 20_000_000;

/// Largest number of attributes of an element: each is compared with all others.
const MOST_ATTRIBUTES: usize = 100;

/// Largest number of namespaces of a file: each element within lists all of them.
const MOST_NAMESPACES: usize = 100;

/// A parsed file, with the text that its places refer to.
pub(crate) struct Xml<'a> {
    text: &'a str,
    document: Document<'a>,
}

impl<'a> Xml<'a> {
    /// Parses a text. Document type definitions are refused: they can define entities that grow without end.
    ///
    /// # Errors
    /// `Malformed` for a text that is not XML, or has too many attributes or namespaces.
    pub(crate) fn new(text: &'a str) -> Result<Self, MeshError> {
        check_numbers(text)?;
        let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options).map_err(|error| match error {
            Error::UnclosedRootNode | Error::UnexpectedEndOfStream => MeshError::Malformed {
                place: place_of(text.as_bytes(), text.len(), Numbers::Text),
                message: "the file ends within an element: it is truncated".into(),
            },
            _ => MeshError::Malformed {
                place: Place::Line(error.pos().row as usize),
                message: error.to_string(),
            },
        })?;
        Ok(Self { text, document })
    }

    /// The outermost element, whose name says what kind of document it is.
    pub(crate) fn root(&self) -> Node<'_, 'a> {
        self.document.root_element()
    }

    /// Length of the text [bytes].
    pub(super) fn length(&self) -> usize {
        self.text.len()
    }

    /// Place of a byte offset.
    pub(crate) fn place(&self, offset: usize) -> Place {
        place_of(self.text.as_bytes(), offset, Numbers::Text)
    }

    /// An error in an element.
    pub(super) fn error(&self, node: Node, message: impl Into<String>) -> MeshError {
        MeshError::Malformed { place: self.place(node.range().start), message: message.into() }
    }

    /// The first child element of this name.
    ///
    /// # Errors
    /// `Malformed` if there is none.
    pub(super) fn child<'s>(&self, node: Node<'s, 'a>, name: &str) -> Result<Node<'s, 'a>, MeshError> {
        let found = node.children().find(|child| child.has_tag_name(name));
        found.ok_or_else(|| self.error(node, format!("<{}> has no <{name}>", node.tag_name().name())))
    }

    /// The value of an attribute.
    ///
    /// # Errors
    /// `Malformed` if it is missing.
    pub(crate) fn attribute<'s>(&self, node: Node<'s, 'a>, name: &str) -> Result<&'s str, MeshError> {
        node.attribute(name)
            .ok_or_else(|| self.error(node, format!("<{}> has no attribute {name}", node.tag_name().name())))
    }

    /// The value of an attribute as a number.
    ///
    /// # Errors
    /// `Malformed` if it is missing, or something else.
    pub(super) fn number<T: std::str::FromStr>(
        &self,
        node: Node<'_, 'a>,
        name: &str,
    ) -> Result<T, MeshError> {
        let value = self.attribute(node, name)?;
        let found = || format!("expected a number as {name}, found {}", shown(value.as_bytes()));
        value.trim().parse().map_err(|_| self.error(node, found()))
    }

    /// A cursor on the text inside an element, up to its first child element.
    pub(super) fn cursor(&self, node: Node<'_, 'a>) -> Cursor<'a> {
        let inside = node.children().find(Node::is_text).map_or(0..0, |text| text.range());
        Cursor::within(self.text.as_bytes(), inside.start, inside.end)
    }
}

/// Refuses numbers of attributes and namespaces whose parsing would take endless time.
fn check_numbers(text: &str) -> Result<(), MeshError> {
    let error = |offset: usize, what: String| {
        let place = place_of(text.as_bytes(), offset, Numbers::Text);
        Err(MeshError::Malformed { place, message: format!("more than {what}") })
    };
    if let Some((offset, _)) = text.match_indices("xmlns").nth(MOST_NAMESPACES) {
        return error(offset, format!("{MOST_NAMESPACES} namespaces"));
    }
    // Tags begin with `<` and a name, and each attribute has an equals sign.
    let mut offset = 0;
    for piece in text.split('<') {
        let is_tag = !piece.starts_with(['!', '?']);
        if is_tag && piece.bytes().filter(|&b| b == b'=').count() > MOST_ATTRIBUTES {
            return error(offset, format!("{MOST_ATTRIBUTES} attributes"));
        }
        offset += piece.len() + 1;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_that_would_take_endless_time_are_refused() {
        let many = |each: &dyn Fn(u32) -> String| (0..100_000).map(each).collect::<String>();
        let attributes = format!("<a>\n<b {}/></a>", many(&|i| format!("a{i}=\"\" ")));
        let namespaces = many(&|i| format!("<a xmlns:b{i}=\"{i}\">\n"));
        for (text, place) in [(&attributes, 2), (&namespaces, 101)] {
            match Xml::new(text).map(|_| ()) {
                Err(MeshError::Malformed { place: Place::Line(line), .. }) => assert_eq!(line, place),
                other => panic!("{other:?}"),
            }
        }
        assert!(Xml::new("<a b=\"1\"><!-- ===== --></a>").is_ok());
    }
}
