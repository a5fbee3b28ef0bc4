//! Arrays that name parts and sets: a convention, since VTK has neither.
//!
//! The part of a cell is its value in the first cell array of one component, in the order of [`PART_ARRAYS`], whose values
//! are integers or texts: `part_<value>`, or the text; the integers of `part` are numbers, from 0, in the texts `parts` of the field data,
//! where there are so many, as `contuse` writes them. A point array of integers that are all 0 or 1 is a node set.

use super::scalar::Values;
use std::collections::BTreeMap;

/// What the values of an array belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// One tuple for each point.
    Points,
    /// One tuple for each cell.
    Cells,
}

/// The array of cells whose integers may have names.
pub(super) const PART: &str = "part";

/// Names of cell arrays that give parts, in the order of preference; in lower case, without `_`, `-` and spaces.
const PART_ARRAYS: [&str; 16] = [
    "part",
    "parts",
    "partname",
    "partid",
    "material",
    "materialid",
    "materialids",
    "gmsh:physical",
    "medit:ref",
    "cellentityids",
    "elementblockids",
    "blockid",
    "objectid",
    "region",
    "regionid",
    "pid",
];

/// Place of a name among those of [`PART_ARRAYS`].
pub(super) fn part_rank(name: &str) -> Option<usize> {
    let plain: String = name.chars().filter(|c| !matches!(c, '_' | '-' | ' ')).collect();
    PART_ARRAYS.iter().position(|known| plain.eq_ignore_ascii_case(known))
}

/// Whether the values mark some points and not others.
pub(super) fn is_set(marks: &[i64]) -> bool {
    marks.iter().all(|mark| matches!(mark, 0 | 1)) && marks.contains(&1)
}

/// The name of each cell's part, as an index into a list of names.
pub(super) struct Labels {
    of_cell: Vec<u32>,
    names: Vec<String>,
}

impl Labels {
    /// Labels from the values of an array: integers in ascending order, texts in the order in which they appear; `None` for
    /// numbers that are not integers. Integers that all are numbers of `names` have those.
    pub(super) fn new(values: Values, names: &[String]) -> Option<Self> {
        match values {
            Values::Texts(texts) => Some(Self::of_texts(texts)),
            Values::Integers(numbers) => Some(Self::of_integers(&numbers, names)),
            Values::Reals(numbers) => {
                // Whole numbers up to 2⁵³ are exact.
                let whole = |x: f64| (x.fract() == 0.0 && x.abs() < 9e15).then_some(x as i64);
                let numbers = numbers.into_iter().map(whole).collect::<Option<Vec<i64>>>()?;
                Some(Self::of_integers(&numbers, names))
            }
        }
    }

    fn of_integers(numbers: &[i64], names: &[String]) -> Self {
        let mut known = numbers.to_vec();
        known.sort_unstable();
        known.dedup();
        let index = |number: &i64| known.partition_point(|other| other < number) as u32;
        let named = |n: &i64| usize::try_from(*n).ok().and_then(|n| names.get(n)).cloned();
        let known_names: Option<Vec<String>> = known.iter().map(named).collect();
        let names = known_names.unwrap_or_else(|| known.iter().map(|n| format!("part_{n}")).collect());
        Self { of_cell: numbers.iter().map(index).collect(), names }
    }

    fn of_texts(texts: Vec<String>) -> Self {
        let mut index: BTreeMap<String, u32> = BTreeMap::new();
        let mut names = Vec::new();
        let of_cell = texts.into_iter().map(|text| {
            let text = if text.is_empty() { "unnamed".to_owned() } else { text };
            *index.entry(text.clone()).or_insert_with(|| {
                names.push(text);
                names.len() as u32 - 1
            })
        });
        Self { of_cell: of_cell.collect(), names }
    }

    /// Number of cells, labelled or not.
    pub(super) fn len(&self) -> usize {
        self.of_cell.len()
    }

    /// Label of a cell, as an index.
    pub(super) fn of(&self, cell: usize) -> usize {
        self.of_cell[cell] as usize
    }

    /// Name of a label.
    pub(super) fn name(&self, label: usize) -> String {
        self.names[label].clone()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    #[test]
    fn numbers_of_names_have_them_and_others_have_none() {
        let named = ["skin", "fat", "bone"].map(String::from);
        let names = |numbers: &[i64], names: &[String]| {
            Labels::new(Values::Integers(numbers.to_vec()), names).unwrap().names
        };
        assert_eq!(names(&[2, 0, 2], &named), ["skin", "bone"]);
        for other in [&[1, 3][..], &[-1, 0]] {
            assert!(names(other, &named).iter().all(|name| name.starts_with("part_")), "{other:?}");
        }
        assert_eq!(names(&[1], &[]), ["part_1"]);
    }
}
