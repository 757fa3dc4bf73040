//! Labels in the order of faces: `.seg`, one integer a face as the Princeton benchmark has it, and `.json`, a list or a map.
//!
//! Problems are words for the user that call the mesh THE MESH; they give the counts of both sides.

use serde_json::Value;

/// The integers of a `.seg`, one of each of `faces` faces, between any white space.
pub fn seg(bytes: &[u8], faces: usize) -> Result<Vec<i64>, String> {
    let text = core::str::from_utf8(bytes).map_err(|_| "not text; a .seg holds one integer a line")?;
    let mut labels = Vec::new();
    for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        for word in line.split_whitespace() {
            let label = word.parse().map_err(|_| {
                let word: String = word.chars().take(40).collect();
                format!("line {}: '{word}' is no integer; a .seg holds one a face", i + 1)
            })?;
            labels.push(label);
        }
    }
    fitting(labels, faces)
}

fn fitting<T>(labels: Vec<T>, faces: usize) -> Result<Vec<T>, String> {
    match labels.len() {
        n if n == faces => Ok(labels),
        n => Err(format!("{n} labels, but THE MESH has {faces} faces; use labels of this very mesh")),
    }
}

/// The labels of `[label, ...]` or `{"face": label, ...}`, faces from 0, as words.
pub fn json(bytes: &[u8], faces: usize) -> Result<Vec<String>, String> {
    let value = serde_json::from_slice(bytes).map_err(|e| format!("not JSON: {e}; correct it"))?;
    match value {
        Value::Array(list) => {
            let labels = list.iter().enumerate().map(|(face, v)| word(v).ok_or_else(|| no_label(face, v)));
            fitting(labels.collect::<Result<_, _>>()?, faces)
        }
        Value::Object(map) => {
            let mut labels = vec![None; faces];
            for (key, v) in &map {
                let face: usize =
                    key.trim().parse().map_err(|_| format!("'{key}' is no number of a face, from 0; correct it"))?;
                let place = labels.get_mut(face).ok_or_else(|| {
                    format!(
                        "{} labels, one of them for face {face} (from 0), but THE MESH has {faces} faces; use labels of this very mesh",
                        map.len()
                    )
                })?;
                *place = Some(word(v).ok_or_else(|| no_label(face, v))?);
            }
            let missing = labels.iter().filter(|l| l.is_none()).count();
            match labels.iter().position(Option::is_none) {
                None => Ok(labels.into_iter().flatten().collect()),
                Some(first) => Err(format!(
                    "{missing} of the {faces} faces of THE MESH have no label, face {first} (from 0) the first; use labels of this very mesh"
                )),
            }
        }
        _ => Err("neither a list of labels nor a map from face to label; write one of them".into()),
    }
}

/// A label as a word: whole numbers, however they are written, and strings.
fn word(value: &Value) -> Option<String> {
    match value {
        Value::String(name) => Some(name.clone()),
        Value::Number(n) => match (n.as_i64(), n.as_f64()) {
            (Some(i), _) => Some(i.to_string()),
            (None, Some(x)) if x.fract() == 0.0 && x.abs() < 9e15 => Some((x as i64).to_string()),
            _ => None,
        },
        _ => None,
    }
}

fn no_label(face: usize, value: &Value) -> String {
    let shown: String = value.to_string().chars().take(40).collect();
    format!("face {face} (from 0): {shown} is no label; write an integer")
}

#[cfg(test)]
mod tests {
    use super::*;
    use quickcheck::quickcheck;

    #[test]
    fn a_seg_of_any_line_ends_is_read() {
        assert_eq!(seg(b"3\r\n-1\n\n 7", 3), Ok(vec![3, -1, 7]));
        assert_eq!(seg(b"", 0), Ok(vec![]));
    }

    #[test]
    fn what_does_not_fit_is_refused_with_the_counts() {
        let problem = seg(b"1\n2\n", 3).unwrap_err();
        assert!(problem.contains("2 labels") && problem.contains("3 faces"), "{problem}");
        assert!(seg(b"1\nleg\n", 2).unwrap_err().contains("line 2: 'leg'"));
        assert!(json(b"[1]", 2).unwrap_err().contains("1 labels, but THE MESH has 2"));
        assert!(json(br#"{"0": 1, "5": 2}"#, 2).unwrap_err().contains("face 5"));
        assert!(json(br#"{"1": 1}"#, 3).unwrap_err().contains("2 of the 3 faces"));
        assert!(json(b"[1, null]", 2).unwrap_err().contains("face 1 (from 0): null"));
        assert!(json(b"7", 1).unwrap_err().contains("neither"));
        assert!(json(b"[1.5]", 1).unwrap_err().contains("1.5 is no label"));
    }

    #[test]
    fn lists_and_maps_in_any_order_are_read() {
        assert_eq!(json(b"[4, 2.0, \"leg\"]", 3), Ok(["4", "2", "leg"].map(String::from).to_vec()));
        assert_eq!(json(br#"{"1": 5, "0": 9}"#, 2), Ok(["9", "5"].map(String::from).to_vec()));
    }

    quickcheck! {
        fn any_bytes_are_read_or_refused(bytes: Vec<u8>, faces: u8) -> bool {
            let fits = |n: Option<usize>| n.is_none_or(|n| n == usize::from(faces));
            fits(seg(&bytes, faces.into()).ok().map(|l| l.len())) && fits(json(&bytes, faces.into()).ok().map(|l| l.len()))
        }
    }
}
