//! Grown boards as pictures, against their truth.

use glam::Vec2;
use procedural::{Class, Stream};
use wood_picture::{Encoding, Settings, fibre_map};

use crate::board::{picture, wood};
use crate::{apart_deg, quantile};

fn linear() -> Settings {
    Settings { encoding: Encoding::Linear, ..Settings::default() }
}

#[test]
fn wip() {
    let boards = 12;
    let (mut clear_all, mut around_all) = (vec![], vec![]);
    for board in 0..boards {
        let stream = Stream::root(1).child("board").index(board);
        let t = std::time::Instant::now();
        let seen = picture(stream, wood(stream, (board % 5) as f64, 0.0), 0.15);
        let t1 = t.elapsed();
        let t = std::time::Instant::now();
        let map = match fibre_map(&seen.light, seen.size, seen.pixel_mm, &linear()) {
            Ok(map) => map,
            Err(e) => {
                println!("board {board}: {e}");
                continue;
            }
        };
        let t2 = t.elapsed();
        let (mut clear, mut around, mut zs, mut naive) = (vec![], vec![], vec![], vec![]);
        for i in 0..map.azimuth_rad.len() {
            if seen.class[i] != Class::Clear {
                continue;
            }
            let e = apart_deg(map.azimuth_rad[i], seen.azimuth_rad[i]);
            let place = map.place_mm(i);
            let near = seen.plank.instances().iter().map(|k| {
                let c = Vec2::new(k.x_mm as f32 + 0.5 * seen.wood.board.width_mm as f32, k.y_mm as f32);
                c.distance(place) / (0.5 * k.diameter_mm as f32)
            }).fold(f32::INFINITY, f32::min);
            if near < 2.0 { around.push(e) } else if near > 4.0 {
                clear.push(e);
                naive.push(apart_deg(0.0, seen.azimuth_rad[i]));
                zs.push(e.to_radians() / map.azimuth_error_rad(i));
            }
        }
        clear_all.extend_from_slice(&clear);
        around_all.extend_from_slice(&around);
        let q = |v: &mut Vec<f32>| if v.is_empty() { f32::NAN } else { quantile(v, 0.5) };
        println!("board {board} ({t1:.1?} {t2:.1?}): clear {:.2} (naive {:.2}) around {:.2} z {:.2} streak {:.3} tilt {:.2} offset {:.0} depth {:.0}", q(&mut clear), q(&mut naive), q(&mut around), q(&mut zs), seen.wood.log.streak, seen.wood.log.pith_tilt_deg, seen.wood.log.pith_offset_mm, seen.wood.log.pith_depth_mm);
        for k in seen.plank.instances() {
            let c = Vec2::new(k.x_mm as f32 + 0.5 * seen.wood.board.width_mm as f32, k.y_mm as f32);
            let (row, col) = ((c.y / 0.15) as usize, (c.x / 0.15) as usize);
            let i = row * seen.size[1] + col;
            println!("   truth {:?} {c} d {:.1} dive {:.0} azimuth {:.0} dive_px {:.0}", k.class, k.diameter_mm, k.dive_deg, seen.azimuth_rad[i].to_degrees(), seen.dive_rad[i].to_degrees());
        }
        for k in &map.knots {
            let at = (k.centre_mm / 0.15).as_uvec2();
            let i = at.y as usize * seen.size[1] + at.x as usize;
            println!("   found {} axes {:?} dive {:.0} azimuth {:.0} signed {:.0} end {:.2} b {:.2}", k.centre_mm, k.half_axes_mm, k.dive_rad().to_degrees(), map.azimuth_rad[i].to_degrees(), map.dive_rad[i].to_degrees(), k.end_confidence, k.brightness);
        }
    }
    println!("clear {:.2} around {:.2}", quantile(&mut clear_all, 0.5), quantile(&mut around_all, 0.5));
}
