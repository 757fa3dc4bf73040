//! What a PLY calls UVs and what else is known of its elements.

use super::header::Element;

/// The list of UVs of a face's corners in set `set`.
pub(super) fn texcoord(set: u32) -> String {
    if set == 0 { "texcoord".into() } else { format!("texcoord{set}") }
}

/// The set whose list of UVs has this name.
pub(super) fn set_of(name: &str) -> Option<u32> {
    match name.strip_prefix("texcoord")? {
        "" => Some(0),
        number => number.parse().ok().filter(|set| *set > 0 && texcoord(*set) == name),
    }
}

/// Names of a vertex's u and of its v.
pub(super) const U: [&str; 3] = ["u", "s", "texture_u"];
/// See [`U`].
pub(super) const V: [&str; 3] = ["v", "t", "texture_v"];

/// Whether a property holds UVs of some set, by corner or, for the first set, by vertex.
pub(super) fn uv_set(element: &Element, property: usize) -> Option<u32> {
    let name = element.properties[property].name.as_str();
    match element.name.as_str() {
        "face" => set_of(name),
        "vertex" => {
            let both = element.find(&U).is_some() && element.find(&V).is_some();
            (both && (element.find(&U) == Some(property) || element.find(&V) == Some(property))).then_some(0)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_have_names_and_names_sets() {
        assert_eq!([texcoord(0), texcoord(3)], ["texcoord", "texcoord3"]);
        assert_eq!(
            ["texcoord", "texcoord2", "texcoord0", "texcoord02", "tex"].map(set_of),
            [Some(0), Some(2), None, None, None]
        );
    }
}
