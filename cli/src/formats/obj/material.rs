//! The file of materials beside an OBJ: names, base colours, textures.

use crate::base::colour::encoded;
use crate::formats::model::{Material, Model};

/// The text of an `.mtl` with the materials that pieces of `model` use; nothing where there is none.
pub fn text(model: &Model) -> Option<String> {
    let is_used = |m: usize| model.pieces.iter().any(|piece| piece.material == Some(m as u32));
    let used: Vec<usize> = (0..model.materials.len()).filter(|m| is_used(*m)).collect();
    let mut text = String::new();
    for m in &used {
        let Material { colour, texture, .. } = &model.materials[*m];
        text += &format!("newmtl {}\n", name(model, *m as u32));
        if let Some(colour) = colour {
            let [r, g, b, opacity] = encoded(*colour).map(digits);
            text += &format!("Kd {r} {g} {b}\n");
            if opacity < 1.0 {
                text += &format!("d {opacity}\n");
            }
        }
        if let Some(texture) = texture {
            text += &format!("map_Kd {texture}\n");
        }
        text.push('\n');
    }
    (!used.is_empty()).then_some(text)
}

/// A share with as many digits as a colour has.
pub(super) fn digits(c: f32) -> f64 {
    (f64::from(c) * 1e6).round() / 1e6
}

/// What the OBJ calls material `m`: its name without blanks, which some readers end it at; its number where it has none or
/// another has the same.
pub(super) fn name(model: &Model, m: u32) -> String {
    let own = |m: usize| model.materials[m].name.split_whitespace().collect::<Vec<_>>().join("_");
    let name = own(m as usize);
    let is_taken = (0..m as usize).any(|other| own(other) == name);
    match name.is_empty() || is_taken {
        true => format!("{}material{m}", if name.is_empty() { String::new() } else { name + "_" }),
        false => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::model::Piece;

    #[test]
    fn colours_are_those_of_a_screen_and_names_are_one_word_each() {
        let material = |name: &str, colour, texture: Option<&str>| Material {
            name: name.into(),
            colour,
            texture: texture.map(String::from),
        };
        let materials = vec![
            material("red hot", Some([1.0, 0.0, 0.214_041_14, 0.5]), Some("a b.png")),
            material("unused", None, None),
            material("", None, None),
            material("red_hot", None, None),
        ];
        let pieces = [0, 2, 3].map(|m| Piece { material: Some(m), ..Piece::default() }).to_vec();
        let model = Model { materials, pieces, ..Model::default() };
        let expected =
            "newmtl red_hot\nKd 1 0 0.5\nd 0.5\nmap_Kd a b.png\n\nnewmtl material2\n\nnewmtl red_hot_material3\n\n";
        assert_eq!(text(&model).unwrap(), expected);
        assert_eq!(text(&Model::default()), None);
    }
}
