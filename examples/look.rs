//! scratch
use sheetlight::{optics::speckle::Tiles, pipeline, recipe::Recipe};
fn save(name: &str, w: usize, h: usize, v: &[f32], lo: f32, hi: f32) {
    let px: Vec<u8> =
        v.iter().map(|&x| if x.is_nan() { 0 } else { ((x - lo) / (hi - lo) * 255.).clamp(0., 255.) as u8 }).collect();
    image::GrayImage::from_raw(w as u32, h as u32, px).unwrap().save(name).unwrap();
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let r = Recipe::load(&a[1]).map_err(|e| println!("{e}")).unwrap();
    let i: u64 = a[2].parse().unwrap();
    let s = r.draw(0, i);
    let t = Tiles::new(0);
    let t0 = std::time::Instant::now();
    let rec = pipeline::render(&s, &t, &|_| ());
    println!("{} {:?} objects {} {:?}", rec.class, t0.elapsed(), rec.objects.len(), rec.physics);
    let (w, h) = (rec.cols, rec.rows);
    let m = rec.maps.range.iter().filter(|v| v.is_nan()).count();
    println!("missing {}", m as f64 / (w * h) as f64);
    let mx = |v: &[f32]| {
        let mut q: Vec<f32> = v.iter().copied().filter(|x| !x.is_nan()).collect();
        q.sort_by(f32::total_cmp);
        (q[q.len() / 100], q[q.len() * 99 / 100])
    };
    for (n, v) in [("range", &rec.maps.range), ("refl", &rec.maps.reflectance), ("scatter", &rec.maps.scatter)] {
        let (lo, hi) = mx(v);
        println!("{n} {lo} {hi}");
        save(&format!("/tmp/{n}.png"), w, h, v, lo, hi);
    }
    let l: Vec<f32> = rec.labels.class.iter().map(|&c| c as f32).collect();
    save("/tmp/label.png", w, h, &l, 0., 4.);
    if let Some(t) = &rec.truth {
        save("/tmp/dive.png", w, h, &t.fibre_dive, 0., 90.);
        save("/tmp/az.png", w, h, &t.fibre_azimuth, -30., 30.);
        save("/tmp/height.png", w, h, &t.height, 21., 23.);
    }
}
