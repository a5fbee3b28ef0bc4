//! Elements of a FEBio file, their texts and numbers.

use roxmltree::Node;

/// An element in words: `<bc name="fixed" type="zero displacement">`.
pub(super) fn title(node: Node) -> String {
    let attribute = |key: &str| Some(format!("{key}={:?}", node.attribute(key)?));
    let attributes = ["id", "name", "type"].into_iter().filter_map(attribute);
    let words: Vec<String> = std::iter::once(node.tag_name().name().to_owned()).chain(attributes).collect();
    format!("<{}>", words.join(" "))
}

/// The elements inside an element.
pub(super) fn elements<'x>(node: Node<'x, 'x>) -> impl Iterator<Item = Node<'x, 'x>> {
    node.children().filter(Node::is_element)
}

/// The text of an element without white space around it.
pub(super) fn text<'x>(node: Node<'x, 'x>) -> &'x str {
    node.text().unwrap_or_default().trim()
}

/// Finite numbers with commas between them.
pub(super) fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|field| field.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect()
}
