//! Pixels in memory, and as PNG.

use crate::base::colour::Rgb;

/// 8-bit sRGB pixels, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>, // (height, width)
}

impl Image {
    /// All of one colour.
    pub(super) fn new(width: usize, height: usize, colour: Rgb) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Sets a pixel; outside the image nothing happens.
    pub(super) fn put(&mut self, x: usize, y: usize, colour: Rgb) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = colour;
        }
    }

    /// Mixes `share` of `colour` into a pixel.
    pub(super) fn mix(&mut self, x: usize, y: usize, colour: Rgb, share: f32) {
        if x < self.width && y < self.height {
            let pixel = &mut self.pixels[y * self.width + x];
            for k in 0..3 {
                pixel[k] = (pixel[k] as f32 + (colour[k] as f32 - pixel[k] as f32) * share + 0.5) as u8;
            }
        }
    }

    /// Fills a rectangle, cut to the image.
    pub(super) fn fill(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2], colour: Rgb, share: f32) {
        for row in y..y + height {
            for column in x..x + width {
                self.mix(column, row, colour, share);
            }
        }
    }

    /// Draws `pixels`, rows of `width`, with the upper left corner at (x, y).
    pub(super) fn paste(&mut self, [x, y]: [usize; 2], width: usize, pixels: impl Iterator<Item = Rgb>) {
        for (i, pixel) in pixels.enumerate() {
            self.put(x + i % width, y + i / width, pixel);
        }
    }

    /// The bytes of a PNG file; the same for the same pixels.
    pub fn png(&self) -> Vec<u8> {
        self.encode().expect("an image has a pixel, and a Vec takes every byte")
    }

    fn encode(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn the_png_reads_back_pixel_for_pixel() {
        let mut image = Image::new(3, 2, [10, 20, 30]);
        image.put(2, 1, [255, 0, 1]);
        image.put(9, 9, [1, 1, 1]);
        let mut reader = png::Decoder::new(Cursor::new(image.png())).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, image.pixels.as_flattened());
    }
}
