//! Sets of nodes, parts and segments.

use crate::mesh::read::entries::Numbers;

/// What the members of a set are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Members {
    Nodes,
    /// First and last node of ranges.
    NodeRanges,
    /// A word for the kind on each line, and members of that kind.
    General,
    /// Members that are themselves sets of nodes.
    NodeSets,
    Parts,
    /// First and last part of ranges.
    PartRanges,
    /// Three or four nodes on each line.
    Segments,
}

/// A set, as far as it is read.
pub(super) struct Set {
    /// What its lines list.
    pub(super) members: Members,
    /// Title, if the keyword has one.
    pub(super) title: Option<String>,
    /// Its number, once that is read.
    pub(super) number: Option<u64>,
    /// Offset of its keyword.
    pub(super) offset: usize,
    /// Nodes, and ranges of them.
    pub(super) nodes: Vec<Numbers>,
    /// Parts, and ranges of them.
    pub(super) parts: Vec<Numbers>,
    /// Sets of nodes whose nodes it has too.
    pub(super) sets: Vec<Numbers>,
    /// Whether it has all nodes.
    pub(super) all: bool,
}

/// A keyword for sets: its members, and whether a title comes first; `None` for other keywords.
pub(super) fn set_keyword(keyword: &str) -> Option<(Members, bool)> {
    let (name, titled) = keyword.strip_suffix("_TITLE").map_or((keyword, false), |name| (name, true));
    let members = match name.strip_prefix("SET_")? {
        "NODE" | "NODE_LIST" => Members::Nodes,
        "NODE_LIST_GENERATE" => Members::NodeRanges,
        "NODE_GENERAL" => Members::General,
        "NODE_ADD" => Members::NodeSets,
        "PART" | "PART_LIST" => Members::Parts,
        "PART_LIST_GENERATE" => Members::PartRanges,
        "SEGMENT" => Members::Segments,
        _ => return None,
    };
    Some((members, titled))
}

impl Set {
    /// A set whose lines follow the keyword at this offset.
    pub(super) fn new(members: Members, titled: bool, offset: usize) -> Self {
        let title = titled.then(String::new);
        let (nodes, parts, sets) = (Vec::new(), Vec::new(), Vec::new());
        Self { members, title, number: None, offset, nodes, parts, sets, all: false }
    }

    /// Whether the next line is its title.
    pub(super) fn awaits_title(&self) -> bool {
        self.title.as_ref().is_some_and(String::is_empty) && self.number.is_none()
    }

    /// Its name: the title, or `set_` and the number.
    pub(super) fn name(&self, number: u64) -> String {
        match self.title.as_deref().map(str::trim) {
            Some(title) if !title.is_empty() => title.to_owned(),
            _ => format!("set_{number}"),
        }
    }
}
