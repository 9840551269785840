//! The page of a run: what it says, and the numbers in it.

use super::{Place, SMALL};
use base64::prelude::{BASE64_STANDARD, Engine};
use serde_json::Value;
use std::io::Read;
use undula::output::{Collection, FieldSnapshot, History, read_vtu};

/// The data of a page.
fn data(here: &Place, page: &str) -> Value {
    let text = here.read(page);
    let (_, rest) = text.split_once("id=\"report-data\">").expect("the page has data");
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// Numbers of `W` bytes each, as they are stored.
fn numbers<const W: usize>(array: &Value, kind: &str) -> Vec<[u8; W]> {
    assert_eq!(array["type"], kind);
    let deflated = BASE64_STANDARD.decode(array["data"].as_str().unwrap()).unwrap();
    let mut planes = vec![];
    flate2::read::ZlibDecoder::new(&deflated[..]).read_to_end(&mut planes).unwrap();
    let n = array["length"].as_u64().unwrap() as usize;
    assert_eq!(planes.len(), n * W);
    (0..n).map(|i| std::array::from_fn(|byte| planes[byte * n + i])).collect()
}

fn doubles(array: &Value) -> Vec<f64> {
    numbers(array, "f64").into_iter().map(f64::from_le_bytes).collect()
}

fn integers(array: &Value) -> Vec<u32> {
    let mut sum = 0u32;
    let mut add = |n: [u8; 4]| {
        sum = sum.wrapping_add(u32::from_le_bytes(n));
        sum
    };
    numbers(array, "u32").into_iter().map(&mut add).collect()
}

/// The moments of a film, and half of the step between two codes.
fn film(array: &Value) -> (Vec<Vec<f64>>, f64) {
    let codes: Vec<u16> = numbers(array, "film").into_iter().map(u16::from_le_bytes).collect();
    let [base, step, zero] = ["base", "step", "zero"].map(|name| array[name].as_f64().unwrap());
    let frames = array["frames"].as_u64().unwrap() as usize;
    let points = codes.len() / frames;
    let mut before = vec![0u16; points];
    let mut moments = vec![];
    for frame in codes.chunks_exact(points) {
        let mut left = 0u16;
        for (&code, before) in frame.iter().zip(&mut before) {
            let difference = (code >> 1) as i16 ^ -((code & 1) as i16);
            left = left.wrapping_add(difference as u16);
            *before = before.wrapping_add(left);
        }
        let value = |&code: &u16| match code {
            u16::MAX => f64::NAN,
            code => base + step * (f64::from(code) - zero),
        };
        moments.push(before.iter().map(value).collect());
    }
    (moments, 0.5 * step)
}

/// The moments of a run.
fn moments(here: &Place, directory: &str) -> Vec<(f64, FieldSnapshot)> {
    let collection = Collection::read(here.file(directory).join("fields.pvd")).unwrap();
    let read = |(time, file): &(f64, String)| (*time, read_vtu(collection.resolve(file)).unwrap().0);
    collection.entries().iter().map(read).collect()
}

#[test]
fn a_run_ends_with_a_page_that_has_its_fields_and_histories() {
    let here = Place::new("report");
    let mut sets = SMALL.to_vec();
    sets.extend([
        "output.fields-every=1",
        "output.fields=[\"velocity\",\"displacement\",\"pressure\",\"von-mises\"]",
    ]);
    here.run("run fsi3 -o results --threads 2", &sets).expect(0, &["report    results/report.html"]);
    let page = here.read("results/report.html");
    for words in [
        "Reynolds number",
        "completed",
        "4\u{202f}896",
        "Newton iterations",
        "µs per unknown",
        "fields-every = 1",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // It needs nothing else.
    for outside in ["<link", "src=\"http", "import ", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    let data = data(&here, "results/report.html");
    let scene = &data["scene"];
    let found = moments(&here, "results");
    let times: Vec<f64> = serde_json::from_value(scene["times"].clone()).unwrap();
    assert_eq!(times, found.iter().map(|(time, _)| *time).collect::<Vec<_>>());
    let layer = &scene["layers"][0];
    assert_eq!(integers(&layer["cells"]), found[0].1.cells);
    let mut compared = 0;
    for (n, quantity) in scene["quantities"].as_array().unwrap().iter().enumerate() {
        let name = quantity["name"].as_str().unwrap();
        for (c, array) in layer["quantities"][n].as_array().unwrap().iter().enumerate() {
            let (shown, half) = film(array);
            for (shown, (_, snapshot)) in shown.iter().zip(&found) {
                let field = snapshot.at_points(name).unwrap();
                for (p, &value) in shown.iter().enumerate() {
                    let right = field.values[field.components * p + c];
                    let same = value.is_nan() && right.is_nan() || (value - right).abs() <= 1.001 * half;
                    assert!(same, "{name} {c} at {p}: {value} is {right}");
                    compared += 1;
                }
            }
        }
    }
    // Velocity, displacement, pressure, and the equivalent stress of both bodies.
    assert_eq!(compared, found.len() * found[0].1.points.len() * 7);
    let history = History::read(here.file("results/history.csv")).unwrap();
    assert_eq!(doubles(&data["histories"]["time"]), history.column("time").unwrap());
    let drag = &data["histories"]["signals"][0];
    assert_eq!((&drag["name"], &drag["force"]), (&"drag".into(), &true.into()));
    assert_eq!(doubles(&drag["values"]), history.column("drag").unwrap());
}

#[test]
fn pages_are_written_where_they_are_wanted() {
    let here = Place::new("report-wanted");
    here.run("run fsi3 -o out --quiet", &SMALL).expect(0, &[]);
    assert!(!here.file("out/report.html").exists());
    here.run("report out -o page.html", &[]).expect(0, &["page.html"]);
    assert!(here.read("page.html").contains("id=\"player\""));
    here.run("report out", &[]).expect(0, &["out/report.html"]);
    assert!(here.file("out/report.html").exists());
    // A new run in its place has another page or none.
    let mut sets = SMALL.to_vec();
    sets.push("output.report=false");
    let said = here.run("run fsi3 -o out --force", &sets).expect(0, &["plots/speed.png"]);
    assert!(!here.file("out/report.html").exists() && !said.out.contains("report"));
    here.run("check fsi3 --toml", &["output.report=false"]).expect(0, &["report = false"]);
    here.run("check fsi3", &["output.report=3"]).expect(2, &["output.report", "true or false"]);
    here.run("report nowhere", &[]).expect(2, &["nowhere"]);
    here.write("empty/case.toml", "");
    here.run("report empty", &[]).expect(2, &["summary.json"]);
}

#[test]
fn pages_of_space_have_bodies_and_a_cut() {
    has_bodies_and_a_cut("report-space", &["time.end=0.02"]);
}

#[test]
fn pages_of_tetrahedra_have_bodies_and_a_cut() {
    has_bodies_and_a_cut("report-tetrahedra", &["space.velocity=P2", "time.end=0.01"]);
}

fn has_bodies_and_a_cut(name: &str, sets: &[&str]) {
    let here = Place::new(name);
    let always =
        ["mesh.extrude={depth=0.1,layers=1}", "mesh.refine=0", "time.step=0.01", "output.fields-every=1"];
    here.run("run fsi3 -o space", &[&always, sets].concat()).expect(0, &["space/report.html"]);
    here.run("plot space --animate film.png", &[]).expect(0, &["film.png"]);
    let scene = &data(&here, "space/report.html")["scene"];
    let found = moments(&here, "space");
    let names: Vec<&str> =
        scene["layers"].as_array().unwrap().iter().map(|layer| layer["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["bodies", "cut at z = 0.05 m"]);
    here.run("report space -o cuts.html --cut x=0.3 --cut y", &[]).expect(0, &["cuts.html"]);
    let cuts = &data(&here, "cuts.html")["scene"]["layers"];
    assert_eq!([1, 2].map(|n| cuts[n]["name"].as_str().unwrap()), ["cut at x = 0.3 m", "cut at y = 0.205 m"]);
    here.run("report space --cut x=3", &[])
        .expect(2, &["--cut x=3: the plane meets no cell", "from x = 0 to 2.5 m"]);
    let quantity =
        scene["quantities"].as_array().unwrap().iter().position(|q| q["name"] == "velocity").unwrap();
    // The flow is that of the plane: on the cut as large as anywhere, and no faster.
    let (shown, half) = film(&scene["layers"][1]["quantities"][quantity][0]);
    for (shown, (_, snapshot)) in shown.iter().zip(&found) {
        let field = snapshot.at_points("velocity").unwrap();
        let most = field.values.iter().step_by(3).fold(0.0_f64, |most, v| most.max(*v));
        let seen = shown.iter().fold(0.0_f64, |most, v| most.max(*v));
        assert!(seen <= most + 2.0 * half && seen >= 0.7 * most, "{seen} of {most}");
    }
}
