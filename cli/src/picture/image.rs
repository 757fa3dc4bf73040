//! Pixels in memory, and the PNG file.

use super::colour::Rgb;
use std::io;
use std::path::Path;

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

    /// Pixels a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour at a pixel that is there.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 3] {
        self.pixels[y * self.width + x]
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
    pub fn png(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(io::Error::other)?;
        writer.write_image_data(self.pixels.as_flattened()).map_err(io::Error::other)?;
        writer.finish().map_err(io::Error::other)?;
        Ok(bytes)
    }

    /// Writes a PNG file: beside `path` first, then renamed, so that no half-written file carries the name.
    pub fn write_png(&self, path: &Path) -> io::Result<()> {
        let bytes = self.png()?;
        let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "not a file name"))?;
        let mut part = std::ffi::OsString::from(".");
        part.push(name);
        part.push(format!(".{}.part", std::process::id()));
        let part = path.with_file_name(part);
        let result = std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, path));
        if result.is_err() {
            let _ = std::fs::remove_file(&part); // the first error is the one to report
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back_and_nothing_else_is_left() {
        let mut image = Image::new(3, 2, [10, 20, 30]);
        image.put(2, 1, [255, 0, 1]);
        image.put(9, 9, [1, 1, 1]);
        let folder = std::env::temp_dir().join(format!("seamwright-image-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        image.write_png(&folder.join("a.png")).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(folder.join("a.png")).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, image.pixels.as_flattened());
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
        assert!(image.write_png(&folder.join("missing/a.png")).is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
