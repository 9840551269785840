//! Moving pictures.

use super::{Place, SMALL};
use std::fs::File;
use std::io::BufReader;

/// All pictures of an animated PNG, as numbers of colours, and its colours.
fn png_frames(here: &Place, name: &str) -> (Vec<Vec<u8>>, Vec<u8>) {
    let mut decoder = png::Decoder::new(BufReader::new(File::open(here.file(name)).unwrap()));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().unwrap();
    let count = reader.info().animation_control.map_or(1, |control| control.num_frames);
    let palette = reader.info().palette.as_ref().unwrap().to_vec();
    let size = reader.output_buffer_size().unwrap();
    let mut next = || {
        let mut pixels = vec![0; size];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    };
    ((0..count).map(|_| next()).collect(), palette)
}

fn gif_frames(here: &Place, name: &str) -> Vec<Vec<u8>> {
    let mut reader = gif::DecodeOptions::new().read_info(File::open(here.file(name)).unwrap()).unwrap();
    let mut frames = vec![];
    while let Some(frame) = reader.read_next_frame().unwrap() {
        assert_eq!(frame.delay, 10);
        frames.push(frame.buffer.to_vec());
    }
    frames
}

#[test]
#[ignore = "long"]
fn moving_pictures_have_all_moments_in_the_same_colours() {
    let here = Place::new("animate");
    let mut sets = SMALL.to_vec();
    sets.push("output.fields-every=2");
    here.run("run fsi3 -o out --quiet", &sets).expect(0, &[]);
    here.run("plot out --animate film.png --rate 10", &[]).expect(0, &["film.png"]);
    let (frames, palette) = png_frames(&here, "film.png");
    assert_eq!(frames.len(), 4);
    assert!(frames.windows(2).all(|pair| pair[0].len() == pair[1].len() && pair[0] != pair[1]));
    // At the start all is at rest, which has the lowest colour: the others are in the bar and in the frame alone.
    let bright = |frame: &[u8]| {
        let color = |&n: &u8| [0, 1, 2].map(|c| palette[3 * usize::from(n) + c]);
        frame.iter().map(color).filter(|[r, g, b]| g > r && g > b).count()
    };
    assert!(3 * bright(&frames[0]) < bright(&frames[3]), "{} {}", bright(&frames[0]), bright(&frames[3]));
    here.run("plot out --animate film.gif --rate 10", &[]).expect(0, &["film.gif"]);
    assert_eq!(gif_frames(&here, "film.gif"), frames);
    here.run("plot out --animate p.gif --field pressure --rate 10", &[]).expect(0, &[]);
    assert_ne!(gif_frames(&here, "p.gif"), frames);
    here.run("plot out --animate film.mp4", &[]).expect(2, &["film.mp4", ".png", ".gif"]);
    here.run("plot out --field pressure", &[]).expect(2, &["--animate"]);
    here.run("plot nowhere --animate film.png", &[]).expect(2, &["nowhere"]);
}
