//! Lines of sets, and the nodes in the sets after all lines are read.

use super::Reader;
use super::card::{Card, Format};
use super::set::{Members, Set};
use crate::mesh::MeshError;
use crate::mesh::read::assembly::{NodeTag, free_name};
use crate::mesh::read::entries::{Numbers, most_entries, within_limit};
use std::collections::{BTreeMap, HashMap};

impl Reader<'_> {
    /// Reads one line of a set.
    pub(super) fn set_line(
        &mut self,
        set: &mut Set,
        line: &[u8],
        format: Format,
        offset: usize,
    ) -> Result<(), MeshError> {
        if set.awaits_title() {
            // A blank title is none.
            set.title =
                Some(String::from_utf8_lossy(line).trim().to_owned()).filter(|title| !title.is_empty());
            return Ok(());
        }
        let card = Card::plain(line, format);
        if set.number.is_none() {
            set.number = Some(self.number(card.get(0), offset)?);
            return Ok(());
        }
        match set.members {
            Members::Nodes => set.nodes.extend(self.members(card.from(0), offset)?),
            Members::NodeSets => set.sets.extend(self.members(card.from(0), offset)?),
            Members::Parts => set.parts.extend(self.members(card.from(0), offset)?),
            Members::NodeRanges => set.nodes.extend(self.ranges(&card, offset)?),
            Members::PartRanges => set.parts.extend(self.ranges(&card, offset)?),
            Members::Segments => {
                set.nodes.extend(self.members(card.from(0).take(4), offset)?);
            }
            Members::General => match card.get(0).to_ascii_uppercase().as_str() {
                "ALL" => set.all = true,
                "NODE" => set.nodes.extend(self.members(card.from(1), offset)?),
                "PART" => set.parts.extend(self.members(card.from(1), offset)?),
                other => {
                    let what = format!("a set of nodes by {other}");
                    return Err(self.refuse(offset, &what, "list its nodes"));
                }
            },
        }
        Ok(())
    }

    /// The numbers in these fields; blank ones and zeros are none.
    fn members<'f>(
        &self,
        fields: impl Iterator<Item = &'f str>,
        offset: usize,
    ) -> Result<Vec<Numbers>, MeshError> {
        let mut numbers = Vec::new();
        for field in fields.filter(|field| !field.is_empty()) {
            let number = self.number(field, offset)?;
            if number != 0 {
                numbers.push(Numbers::one(number, offset));
            }
        }
        Ok(numbers)
    }

    /// Pairs of first and last numbers.
    fn ranges(&self, card: &Card, offset: usize) -> Result<Vec<Numbers>, MeshError> {
        let ends = self.members(card.from(0), offset)?;
        let (pairs, odd) = ends.as_chunks::<2>();
        if !odd.is_empty() || pairs.iter().any(|[first, last]| last.first < first.first) {
            return Err(self.error(offset, "expected pairs of a first and a last number"));
        }
        Ok(pairs
            .iter()
            .map(|[first, last]| Numbers { first: first.first, last: last.first, step: 1, offset })
            .collect())
    }

    /// Makes node sets of all sets.
    ///
    /// # Errors
    /// `Malformed` for a set of sets that are missing, `Unsupported` when sets are too large.
    pub(super) fn collect_sets(&mut self) -> Result<(), MeshError> {
        let mut of_part: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
        if self.sets.iter().any(|set| !set.parts.is_empty()) {
            for (cell, &part) in self.assembly.cells().iter().zip(&self.part_of_cell) {
                of_part.entry(part).or_default().extend(cell.nodes);
            }
            for nodes in of_part.values_mut() {
                nodes.sort_unstable();
                nodes.dedup();
            }
        }
        let sets = std::mem::take(&mut self.sets);
        let numbered: HashMap<u64, &Set> = sets
            .iter()
            .filter(|set| !matches!(set.members, Members::Parts | Members::PartRanges | Members::Segments))
            .filter_map(|set| Some((set.number?, set)))
            .collect();
        let (mut entries, most) = (0, most_entries(self.deck.size()));
        for set in &sets {
            let Some(number) = set.number else { continue };
            let mut tags = Vec::new();
            // Sets of sets, each with the number of those around it.
            let (mut around, mut left) = (Vec::new(), vec![(set, 0)]);
            while let Some((next, depth)) = left.pop() {
                around.truncate(depth);
                around.extend(next.number);
                entries += next.sets.len() as u64;
                within_limit(entries, most)?;
                self.add_members(next, &of_part, &mut entries, most, &mut tags)?;
                for of_set in &next.sets {
                    let Some(other) = numbered.get(&of_set.first) else {
                        let message = format!("there is no set of nodes {}", of_set.first);
                        return Err(self.error(of_set.offset, message));
                    };
                    if around.contains(&of_set.first) {
                        let message = format!("the set of nodes {} is a member of itself", of_set.first);
                        return Err(self.error(of_set.offset, message));
                    }
                    left.push((other, around.len()));
                }
            }
            let name = free_name(&self.assembly.node_sets, &set.name(number), &number.to_string());
            self.assembly.node_sets.entry(name).or_default().extend(tags);
        }
        Ok(())
    }

    /// Adds the nodes of a set, apart from those of sets in it.
    fn add_members(
        &self,
        set: &Set,
        of_part: &BTreeMap<u64, Vec<u64>>,
        entries: &mut u64,
        most: u64,
        tags: &mut Vec<NodeTag>,
    ) -> Result<(), MeshError> {
        let mut count = |more: u64| {
            *entries = entries.saturating_add(more);
            within_limit(*entries, most)
        };
        for range in &set.nodes {
            count(range.count())?;
            let known = range.each().filter(|tag| range.is_one() || self.assembly.has_node(*tag));
            tags.extend(known.map(|tag| NodeTag { tag, offset: range.offset }));
        }
        let of_parts = set.parts.iter().flat_map(|range| of_part.range(range.first..=range.last));
        let all = set.all.then_some(&self.nodes).into_iter();
        for nodes in of_parts.map(|(_, nodes)| nodes).chain(all) {
            count(nodes.len() as u64)?;
            tags.extend(nodes.iter().map(|&tag| NodeTag { tag, offset: set.offset }));
        }
        Ok(())
    }
}
