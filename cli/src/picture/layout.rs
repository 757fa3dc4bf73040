//! What all sheets have in common: the space around tiles, where views look from, and their scale.

use super::surface::PictureSurface;
use super::view::Camera;
use glam::Vec3;

/// Space around tiles, and the strips that carry words.
pub(super) const GAP: usize = 12;
pub(super) const HEADER: usize = 56;
pub(super) const CAPTION: usize = 26;

/// Four views around the mesh and one from above; a mesh says nowhere where its front is, so axes name them.
pub(super) fn cameras(z_up: bool) -> [Camera; 5] {
    // 40 degrees to the side, 22 degrees from above.
    const SIDE: (f32, f32) = (0.642_787_6, 0.766_044_4);
    const ABOVE: (f32, f32) = (0.374_606_6, 0.927_183_9);
    let [near, far, above] = if z_up { ["-Y", "+Y", "+Z"] } else { ["+Z", "-Z", "+Y"] };
    let turn = |v: Vec3| if z_up { Vec3::new(v.x, -v.z, v.y) } else { v };
    let camera = |name, right: Vec3, up: Vec3| Camera { name, right: turn(right), up: turn(up) };
    let three_quarter = |name, sin: f32| {
        let back = Vec3::new(sin * ABOVE.1, ABOVE.0, SIDE.1 * ABOVE.1); // out of the picture
        let right = Vec3::new(SIDE.1, 0.0, -sin);
        camera(name, right, back.cross(right))
    };
    [
        camera(near, Vec3::X, Vec3::Y),
        three_quarter("LEFT", -SIDE.0),
        three_quarter("RIGHT", SIDE.0),
        camera(far, -Vec3::X, Vec3::Y),
        camera(above, Vec3::X, -Vec3::Z),
    ]
}

/// One scale for all views: the widest fills its tile but for a margin.
pub(super) fn pixel_width(surface: &PictureSurface, cameras: &[Camera], tile: usize) -> f32 {
    let extent = |camera: &Camera| {
        let (low, high) = camera.bounds(surface.faces.iter().flatten().map(|v| surface.points[*v as usize]));
        (high - low).max_element()
    };
    cameras.iter().map(extent).fold(1e-3, f32::max) * 1.08 / tile as f32
}
