//! A label of each face of a mesh, numbered from 0, and what its file calls it.

use crate::formats::mark::Mark;
use std::collections::{BTreeMap, HashMap};

/// A label of each polygon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labels {
    /// Each polygon's label, as an index of `names`.
    pub label: Vec<u32>, // (p)
    /// What the file calls each label: its number, word or colour. Numbers rise, others stand as they come.
    pub names: Vec<String>,
}

impl Labels {
    pub(super) fn of_numbers(numbers: Vec<i64>) -> Self {
        Self::of_marks(numbers.into_iter().map(Mark::Label))
    }

    pub(super) fn of_marks(marks: impl Iterator<Item = Mark>) -> Self {
        let marks: Vec<Mark> = marks.collect();
        let mut number: BTreeMap<Mark, u32> = marks.iter().map(|m| (*m, 0)).collect();
        number.values_mut().enumerate().for_each(|(i, n)| *n = i as u32);
        let names = number.keys().map(|mark| match mark {
            Mark::Label(label) => label.to_string(),
            Mark::Colour(rgb) => {
                let [r, g, b] = rgb.map(|c| c as f64 / 257.0);
                format!("#{:02x}{:02x}{:02x}", r.round() as u8, g.round() as u8, b.round() as u8)
            }
        });
        Self { names: names.collect(), label: marks.iter().map(|m| number[m]).collect() }
    }

    /// Whole numbers in their order; where some label is a word, all are words, as they come.
    pub(super) fn of_names(all: Vec<String>) -> Self {
        if let Some(numbers) = all.iter().map(|name| name.parse().ok()).collect::<Option<Vec<i64>>>() {
            return Self::of_numbers(numbers);
        }
        let mut known = HashMap::new();
        let mut names = Vec::new();
        let label = all.into_iter().map(|name| {
            *known.entry(name).or_insert_with_key(|name| {
                names.push(name.clone());
                names.len() as u32 - 1
            })
        });
        let label = label.collect();
        Self { label, names }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_rise_and_words_stand_as_they_come() {
        assert_eq!(
            Labels::of_numbers(vec![7, -1, 7]),
            Labels { label: vec![1, 0, 1], names: vec!["-1".into(), "7".into()] }
        );
        let words = ["leg", "3", "leg"].map(String::from).to_vec();
        assert_eq!(Labels::of_names(words), Labels { label: vec![0, 1, 0], names: vec!["leg".into(), "3".into()] });
        let colours = Labels::of_marks([Mark::Colour([65535, 0, 257 * 16])].into_iter());
        assert_eq!(colours.names, ["#ff0010"]);
        assert_eq!(Labels::of_numbers(vec![]), Labels { label: vec![], names: vec![] });
    }
}
