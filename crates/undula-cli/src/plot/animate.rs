//! `undula plot --animate FILE`: the moments of a run as one moving picture, an animated PNG or a GIF.

use super::colors::{self, Rgb, SOLID};
use super::figure::Image;
use super::picture::{Film, View};
use super::tetrahedra::read_fields;
use super::{NotDrawn, solid_cells};
use crate::args::{AnimatedField, say_notes, threads};
use crate::digits::fixed;
use anyhow::Context;
use std::collections::HashMap;
use std::io::Write;
use std::path::Path;
use undula::output::{Collection, FieldSnapshot, RunDirectory, Summary, write_atomic};

/// More moments are thinned.
const MOMENTS: usize = 500;

/// Shades of the colours of the field: as they are, and under mesh lines.
const SHADES: usize = 100;

/// How moving pictures are stored.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Format {
    /// Animated PNG.
    Png,
    /// GIF.
    Gif,
}

impl Format {
    /// By the end of a name.
    ///
    /// # Errors
    /// What would be right.
    pub fn of(file: &Path) -> Result<Format, String> {
        match file.extension().and_then(|end| end.to_str()).map(str::to_lowercase).as_deref() {
            Some("png" | "apng") => Ok(Format::Png),
            Some("gif") => Ok(Format::Gif),
            _ => Err(format!(
                "--animate {}: expected a name that ends with .png (an animated PNG) or .gif",
                file.display()
            )),
        }
    }
}

/// Draws all moments of the run in `dir` into `file`, `rate` of them a second.
///
/// # Errors
/// If a file cannot be read or written; [`NotDrawn`] where there is nothing to draw.
pub fn animate(dir: &Path, file: &Path, field: Option<AnimatedField>, rate: u16) -> anyhow::Result<()> {
    let format = Format::of(file).map_err(NotDrawn)?;
    let run = RunDirectory::open(dir)?;
    let none = || NotDrawn(format!("{} has no field files, which pictures are drawn from", dir.display()));
    if !run.collection().is_file() {
        return Err(none().into());
    }
    let collection = Collection::read(run.collection())?;
    let entries = thinned(collection.entries());
    let (_, last) = entries.last().ok_or_else(none)?;
    let last = read_fields(collection.resolve(last))?;
    let field = field.unwrap_or_else(|| leading(&last)).name();
    let mut film = Film::new(field, entries.len());
    for (_, name) in &entries {
        let snapshot = read_fields(collection.resolve(name))?;
        if !film.include(&view(&snapshot)?) {
            let dir = dir.display();
            return Err(NotDrawn(format!("the fields of {dir} have no `{field}` with finite values")).into());
        }
    }
    let case = Summary::read(run.summary()).map(|summary| summary.case).unwrap_or_default();
    let draw = |(time, name): &(f64, String), palette: &mut Palette| -> anyhow::Result<Frame> {
        let snapshot = read_fields(collection.resolve(name))?;
        let title = format!("{case},  t = {} s", fixed(*time, *time, 3));
        let image = film.image(&view(&snapshot)?, &title)?.context("a field that is gone")?;
        Ok(palette.frame(&image))
    };
    let frames = on_all_cores(&entries, |entries| {
        let mut palette = Palette::new(film.map());
        entries.iter().map(|entry| draw(entry, &mut palette)).collect()
    })?;
    let colors = Palette::new(film.map()).colors;
    let bytes = match format {
        Format::Png => png(&frames, &colors, rate)?,
        Format::Gif => gif(&frames, &colors, rate)?,
    };
    write_atomic(file, |out| out.write_all(&bytes))?;
    Ok(())
}

/// What `draw` makes of parts of `entries`, in their order.
fn on_all_cores<T: Sync, R: Send>(
    entries: &[T],
    draw: impl Fn(&[T]) -> anyhow::Result<Vec<R>> + Sync,
) -> anyhow::Result<Vec<R>> {
    let part = entries.len().div_ceil(threads(None)).max(1);
    let mut all = vec![];
    std::thread::scope(|scope| {
        let draw = &draw;
        let parts: Vec<_> = entries.chunks(part).map(|part| scope.spawn(move || draw(part))).collect();
        for part in parts {
            match part.join() {
                Ok(frames) => all.extend(frames?),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        Ok(())
    })
    .map(|()| all)
}

/// The entries, some left out evenly if there are too many.
fn thinned(entries: &[(f64, String)]) -> Vec<&(f64, String)> {
    let every = entries.len().div_ceil(MOMENTS).max(1);
    if every > 1 {
        say_notes(&[format!("every {every}th of the {} moments of the run is drawn", entries.len())]);
    }
    let last = entries.len().saturating_sub(1);
    entries
        .iter()
        .enumerate()
        .filter(|(n, _)| (last - n).is_multiple_of(every))
        .map(|(_, entry)| entry)
        .collect()
}

/// What is seen of fields.
fn view(snapshot: &FieldSnapshot) -> Result<View<'_>, NotDrawn> {
    match snapshot.kind.dim() {
        2 => Ok(View::whole(snapshot)),
        _ => View::middle(snapshot).map_err(NotDrawn),
    }
}

/// The speed, or of bodies alone the displacement.
fn leading(snapshot: &FieldSnapshot) -> AnimatedField {
    let all_solid = solid_cells(snapshot).iter().all(|&solid| solid);
    if all_solid { AnimatedField::Displacement } else { AnimatedField::Speed }
}

/// A picture whose pixels are numbers of colours.
struct Frame {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

/// Colours of all pictures.
struct Palette {
    colors: Vec<Rgb>,
    /// Numbers of the nearest colours.
    known: HashMap<Rgb, u8>,
}

impl Palette {
    fn new(map: &[Rgb; 17]) -> Palette {
        let at = |n: usize| colors::at(map, n as f64 / (SHADES - 1) as f64);
        let mut all: Vec<Rgb> = (0..SHADES).map(at).collect();
        all.extend((0..SHADES).map(|n| at(n).map(|c| (f64::from(c) * 0.7) as u8)));
        all.push(SOLID);
        all.extend((0..55u8).map(|n| [(255.0 * f64::from(n) / 54.0) as u8; 3]));
        Palette { colors: all, known: HashMap::new() }
    }

    /// The picture in colours of the palette.
    fn frame(&mut self, image: &Image) -> Frame {
        let Palette { colors, known } = self;
        let nearest = |pixel: Rgb| {
            let distance = |color: &Rgb| -> i32 {
                (0..3).map(|c| (i32::from(color[c]) - i32::from(pixel[c])).pow(2)).sum()
            };
            (0..colors.len()).min_by_key(|&n| distance(&colors[n])).unwrap_or(0) as u8
        };
        let number = |pixel: &[u8]| {
            let pixel = [pixel[0], pixel[1], pixel[2]];
            *known.entry(pixel).or_insert_with(|| nearest(pixel))
        };
        let pixels = image.rgb.chunks_exact(3).map(number).collect();
        Frame { width: image.width, height: image.height(), pixels }
    }
}

fn png(frames: &[Frame], colors: &[Rgb], rate: u16) -> anyhow::Result<Vec<u8>> {
    let first = &frames[0];
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, first.width as u32, first.height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(colors.as_flattened().to_vec());
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::NoFilter);
    if frames.len() > 1 {
        encoder.set_animated(frames.len() as u32, 0)?;
        encoder.set_frame_delay(1, rate)?;
    }
    let mut writer = encoder.write_header()?;
    for frame in frames {
        writer.write_image_data(&frame.pixels)?;
    }
    writer.finish()?;
    Ok(bytes)
}

fn gif(frames: &[Frame], colors: &[Rgb], rate: u16) -> anyhow::Result<Vec<u8>> {
    let first = &frames[0];
    let side = |n: usize| u16::try_from(n).context("a picture that is too large for a GIF");
    let [width, height] = [side(first.width)?, side(first.height)?];
    let mut bytes = vec![];
    let mut encoder = gif::Encoder::new(&mut bytes, width, height, colors.as_flattened())?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    for frame in frames {
        let mut image = gif::Frame::from_indexed_pixels(width, height, &frame.pixels[..], None);
        // In hundredths of a second.
        image.delay = (100 / rate).max(2);
        encoder.write_frame(&image)?;
    }
    drop(encoder);
    Ok(bytes)
}
