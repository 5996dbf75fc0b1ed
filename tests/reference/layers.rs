//! Purpose: foil and coats against closed forms, and the kernel's films against the reference on plane stacks.

use base::{Film, Gloss, Medium, Stream};
use glam::{DVec3, Vec3};
use reference::path::{Effort, solve};
use transport::answer::{Answer, Estimate, LineSide, Question};
use transport::fresnel::gloss;
use transport::kernel;
use transport::kernel::film_stack::{FilmStack, FilmStackKernel};
use transport::stack::{Foil, Layer, Scattering, Stack, Substrate};

const FOIL: Foil = Foil { reflectance: 0.9, roughness: [0.25, 0.12] };

/// The same on all sides.
const ROUND: Foil = Foil { roughness: [0.2, 0.2], ..FOIL };

/// A film whose pigment has the reduced scattering `sigma` [mm^-1].
fn film(sigma: f64, mu_a: f64, thickness: f64) -> Layer {
    Layer::new(thickness, 1.53, mu_a, Scattering::Isotropic { mu_s: sigma / (1.0 - 0.557), g: 0.557 })
}

fn over_tablet(film: Layer, gap: f64, coat: f64) -> Stack {
    let tablet = Layer::new(f64::INFINITY, 1.5, 0.005, Scattering::Isotropic { mu_s: 40.0, g: 0.0 });
    Stack { above: 1.0, layers: vec![film, Layer::air(gap), Layer { coat, ..tablet }], below: Substrate::Index(1.0) }
}

fn over_foil(film: Layer, gap: Option<f64>) -> Stack {
    let layers = std::iter::once(film).chain(gap.map(Layer::air)).collect();
    Stack { above: 1.0, layers, below: Substrate::Foil(ROUND) }
}

fn reference(case: &str, stack: &Stack, question: Question, photons: u64) -> Answer {
    let seed = Stream::root(0).child("transport_layers").child(case).key();
    solve(stack, &Question { cells: 0, angles: 0, ..question }, Effort { photons, seed })
}

fn ask(stack: &Stack) -> Answer {
    kernel::solve(stack, &Question { cells: 0, ..Question::default() }).expect("the kernel knows it")
}

fn near(what: &str, value: Estimate, truth: f64, floor: f64) {
    let off = (value.value - truth).abs();
    assert!(off < 4.0 * value.error + floor, "{what}: {} +- {} against {truth}", value.value, value.error);
}

/// Foil below air throws back its reflectance of light from straight above and from everywhere, exactly: no light is
/// lost between facets. Below a film that absorbs nothing a perfect mirror sends everything back.
#[test]
fn foil_reflects_its_reflectance() {
    let air = |foil| Stack { above: 1.0, layers: vec![Layer::air(1.0)], below: Substrate::Foil(foil) };
    for incidence in [Some(0.0), Some(0.7), None] {
        let question = Question { incidence, ..Question::default() };
        let a = reference("air", &air(FOIL), question, 2_000);
        near("foil", a.reflectance, 0.9, 1e-9);
        near("absorbed", a.absorbed[0], 0.1, 1e-9);
    }
    let mut mirror = over_foil(film(12.0, 0.0, 0.12), Some(2.0));
    mirror.below = Substrate::Foil(Foil { reflectance: 1.0, ..FOIL });
    let a = reference("perfect mirror", &mirror, Question::default(), 5_000);
    // Roulette books single photons; with full weights there is none.
    assert!((a.reflectance.value + a.specular - 1.0).abs() < 1e-9, "{:?} and {}", a.reflectance, a.specular);
}

/// The directions in which foil throws light from straight above are those of the GGX law: light in a cone of 5 degrees
/// about three views, against the law's own mean over the cone.
#[test]
fn foil_mirrors_by_its_law() {
    let metal = Gloss { share: 1.0, reflectance: 0.9, roughness: FOIL.roughness.map(|alpha| alpha as f32), matte: 0.0 };
    let stack = Stack { above: 1.0, layers: vec![Layer::air(1.0)], below: Substrate::Foil(FOIL) };
    for view in
        [DVec3::new(0.0, -0.422_618, 0.906_308), DVec3::new(0.3, 0.0, 0.953_939), DVec3::new(0.2, 0.2, 0.959_166)]
    {
        let a = reference("lobe", &stack, Question { view, ..Question::default() }, 200_000);
        let side = view.cross(DVec3::X).normalize();
        let other = view.cross(side);
        let (mut sum, mut count) = (0.0, 0.0);
        for i in 0..40 {
            for j in 0..40 {
                let (u, v) = ((f64::from(i) - 19.5) / 20.0, (f64::from(j) - 19.5) / 20.0);
                if u * u + v * v < 1.0 {
                    let tan = 5f64.to_radians().tan();
                    let way = (view + (side * u + other * v) * tan).normalize();
                    // Metal's reflectance is the same for all directions, Schlick's is not: 0.1 % here.
                    let factor = gloss(&metal, Vec3::Z, Vec3::Z, way.as_vec3());
                    sum += f64::from(factor) * way.z / view.z;
                    count += 1.0;
                }
            }
        }
        // The law leaves out shadowing between facets, which is up to 2 % here.
        near("cone", a.cone.expect("the reference counts it"), sum / count, 0.03 * sum / count);
    }
}

/// Two films of half the thickness are one film; and light passes a coat twice on its way to a mirror and back.
#[test]
fn layers_add_up() {
    let half = film(12.0, 0.5, 0.06);
    let slab = |layers| Stack { above: 1.0, layers, below: Substrate::Index(1.0) };
    let one = reference("one", &slab(vec![film(12.0, 0.5, 0.12)]), Question::default(), 200_000);
    let two = reference("two", &slab(vec![half, half]), Question::default(), 200_000);
    for (what, a, b) in [("R", one.reflectance, two.reflectance), ("T", one.transmittance, two.transmittance)] {
        let error = (a.error * a.error + b.error * b.error).sqrt();
        assert!((a.value - b.value).abs() < 4.0 * error, "{what}: {a:?} and {b:?}");
    }
    let coated = Layer { coat: 0.8, ..Layer::air(1.0) };
    let mirror = Substrate::Foil(Foil { reflectance: 1.0, ..FOIL });
    let a = reference("coat", &Stack { above: 1.0, layers: vec![coated], below: mirror }, Question::default(), 1_000);
    near("coat", a.reflectance, 0.64, 1e-9);
    let inner = Stack { above: 1.0, layers: vec![Layer::air(1.0), coated], below: mirror };
    near("inner coat", reference("inner coat", &inner, Question::default(), 1_000).reflectance, 0.64, 1e-9);
}

/// The reference's R and rows 1 to 8 and 7 to 11, of light to all sides and of light to the lens, from 400 000 photons
/// (examples/film_stacks.rs); standard errors are under 0.2 %, 0.3 %, 1.2 %, 0.7 % and 2.5 %.
const REFERENCE: [(&str, [f64; 5]); 8] = [
    ("12 /mm over 0.5 mm over tablet", [0.8775, 0.5376, 0.1047, 0.5687, 0.1113]),
    ("12 /mm touching a tablet", [0.8775, 0.6590, 0.0451, 0.6983, 0.0461]),
    ("12 /mm over 5 mm over foil", [0.8367, 0.3192, 0.0234, 0.3290, 0.0243]),
    ("12 /mm sealed to foil", [0.7390, 0.5675, 0.0370, 0.5960, 0.0408]),
    ("4 /mm over tablet", [0.8744, 0.5425, 0.1468, 0.6037, 0.1472]),
    ("40 /mm over tablet", [0.8736, 0.4784, 0.0378, 0.5080, 0.0409]),
    ("100 /mm over tablet", [0.8891, 0.3888, 0.0260, 0.4136, 0.0286]),
    ("clear over tablet", [0.8882, 0.6073, 0.1309, 0.7882, 0.0594]),
];

/// Relative standard errors of these windows, the largest of the eight [1].
const ERRORS: [f64; 5] = [0.001, 0.004, 0.01, 0.01, 0.035];

fn by_reference() -> [Stack; 8] {
    let film = |sigma, thickness| film(sigma, 0.02, thickness);
    [
        over_tablet(film(12.0, 0.12), 0.5, 1.0),
        over_tablet(film(12.0, 0.12), 0.0, 1.0),
        over_foil(film(12.0, 0.12), Some(5.0)),
        over_foil(film(12.0, 0.25), None),
        over_tablet(film(4.0, 0.12), 0.5, 1.0),
        over_tablet(film(40.0, 0.2), 0.5, 1.0),
        over_tablet(film(100.0, 0.12), 0.5, 1.0),
        over_tablet(film(0.0, 0.12), 0.5, 1.0),
    ]
}

/// R, and both windows for all sides and for the lens.
fn figures(answer: &Answer) -> [f64; 5] {
    let seen = Answer { line: answer.seen.clone(), ..answer.clone() };
    let window = |answer: &Answer, from, to| answer.rows(from, to, LineSide::Both);
    [answer.reflectance.value, window(answer, 1, 8), window(answer, 7, 11), window(&seen, 1, 8), window(&seen, 7, 11)]
}

/// The production kernel on eight stacks: R within 0.01, windows within 10 % and a standard error of the reference's.
#[test]
fn kernel_agrees_with_the_reference() {
    for (stack, (name, by_reference)) in by_reference().iter().zip(REFERENCE) {
        let answer = ask(stack);
        let figures = figures(&answer);
        assert!((figures[0] - by_reference[0]).abs() < 0.01, "{name}: R {} against {}", figures[0], by_reference[0]);
        for i in 1..5 {
            let ratio = figures[i] / by_reference[i];
            assert!(
                (ratio - 1.0).abs() < 0.1 + ERRORS[i],
                "{name}: window {i} is {} against {}, {ratio}",
                figures[i],
                by_reference[i]
            );
        }
        let absorbed: f64 = answer.absorbed.iter().map(|e| e.value).sum();
        assert!((answer.specular + answer.reflectance.value + absorbed - 1.0).abs() < 1e-5, "{name}: energy");
    }
}

/// The reference still says what the kernel is held to, on a filled and an empty pocket.
#[test]
fn reference_still_says_so() {
    for i in [0, 2] {
        let (name, truth) = REFERENCE[i];
        let a = reference(name, &by_reference()[i], Question::default(), 40_000);
        let figures = figures(&a);
        near(name, a.reflectance, truth[0], 0.002);
        let middle = a.line.len() / 2;
        for (window, (from, to)) in [(1, (1usize, 8usize)), (2, (7, 11))] {
            let rows = (from..=to).flat_map(|row| [a.line[middle - row], a.line[middle + row]]);
            let error = rows.map(|row| row.error * row.error).sum::<f64>().sqrt();
            near(name, Estimate { value: figures[window], error }, truth[window], 0.012 * truth[window]);
        }
    }
}

/// Rows over a tablet against those over an empty pocket: brighter by the factor that the reference gives within 10 %
/// and a standard error over the range of pigment; and what is added fades to nothing as the film turns opaque.
#[test]
fn filled_pockets_scatter_more_until_the_film_is_opaque() {
    let factor = |sigma: f64, thickness: f64| {
        let film = film(sigma, 0.02, thickness);
        let window = |stack: &Stack| figures(&ask(stack));
        let (filled, empty) = (window(&over_tablet(film, 0.5, 1.0)), window(&over_foil(film, Some(5.0))));
        [filled[1] / empty[1], filled[2] / empty[2]]
    };
    for (sigma, thickness, by_reference, errors) in FACTORS {
        let factor = factor(sigma, thickness);
        for i in 0..2 {
            let off = factor[i] - by_reference[i];
            let allowed = 0.1 * by_reference[i] + errors[i];
            assert!(off.abs() < allowed, "{sigma} /mm, {thickness} mm: {} against {}", factor[i], by_reference[i]);
        }
    }
    // What a tablet adds to these rows, as a share of the light that arrives: the film's own light never gets so far.
    let mut last = f64::INFINITY;
    for sigma in [12.0, 40.0, 100.0, 300.0, 1000.0] {
        let film = film(sigma, 0.02, 0.12);
        let seen = |stack: &Stack| figures(&ask(stack))[4];
        let added = seen(&over_tablet(film, 0.5, 1.0)) - seen(&over_foil(film, Some(5.0)));
        assert!(added > 0.0 && added < last, "{sigma} /mm: {added} after {last}");
        last = added;
    }
    assert!(last < 1e-3, "an opaque film still shows what lies below: {last}");
    let [beside, _] = factor(1000.0, 0.12);
    assert!((beside - 1.0).abs() < 0.01, "rows 1 to 8 below an opaque film: {beside}");
}

/// Pigment [mm^-1], thickness [mm], and the reference's factor of filled over empty in rows 1 to 8 and 7 to 11, light
/// to all sides, from 150 000 photons each (examples/film_stacks.rs), with its standard errors.
const FACTORS: [(f64, f64, [f64; 2], [f64; 2]); 8] = [
    (4.0, 0.08, [2.109, 1.696], [0.012, 0.018]),
    (4.0, 0.12, [1.992, 2.009], [0.011, 0.022]),
    (4.0, 0.3, [1.600, 2.147], [0.009, 0.024]),
    (12.0, 0.12, [1.682, 4.430], [0.009, 0.077]),
    (40.0, 0.12, [1.349, 6.753], [0.007, 0.180]),
    (100.0, 0.12, [1.152, 7.834], [0.006, 0.323]),
    (150.0, 0.08, [1.171, 7.725], [0.007, 0.32]),
    (150.0, 0.3, [1.023, 5.346], [0.005, 0.432]),
];

/// What foil and a tablet's own gloss send through clear film follows the bisector of laser and lens, which off the
/// middle of the line both lean.
#[test]
fn glints_stand_where_facets_bisect_laser_and_lens() {
    let facets = |reflectance| Gloss { share: 1.0, reflectance, roughness: [0.1, 0.3], matte: 0.0 };
    let foil = Medium::opaque(facets(0.9));
    let black = Medium { gloss: facets(0.04), ..Medium::isotropic(50.0, 0.01, 1.5, Gloss::NONE) };
    let view = Vec3::new(-0.12, -0.42, 0.9).normalize();
    for under in [foil, black] {
        let glint = |light: Vec3| {
            let film = Film {
                thickness_mm: 0.1,
                gap_mm: Some(3.0),
                room_mm: [f32::INFINITY; 2],
                under,
                under_slope: [0.0; 2],
            };
            let medium = Medium::isotropic(0.001, 0.001, 1.53, Gloss::NONE);
            let cover =
                FilmStack { medium, film, enter: 0.956, view_up: view.z, light_up: 1.0, view, light, normal: Vec3::Z };
            FilmStackKernel::new().spread(&cover).below.iter().sum::<f32>() / gloss(&under.gloss, Vec3::Z, light, view)
        };
        let [above, aslant] = [Vec3::Z, Vec3::new(-0.14, 0.0, 1.0).normalize()].map(glint);
        assert!((above / aslant - 1.0).abs() < 0.05, "{above} of the lobe from above, {aslant} from aslant");
    }
}

/// Film that absorbs more than it lets pass: the reference's reflectance.
#[test]
fn dark_films_reflect_what_the_reference_says() {
    for (sigma, mu_a, thickness) in [(40.0, 3.0, 0.5), (40.0, 8.0, 0.5), (12.0, 4.0, 0.8)] {
        let stack = over_foil(film(sigma, mu_a, thickness), Some(2.0));
        let (kernel, reference) = (ask(&stack), reference("dark", &stack, Question::default(), 60_000));
        println!("{sigma} {mu_a} {thickness}: {} against {:?}", kernel.reflectance.value, reference.reflectance);
        near("dark film", reference.reflectance, kernel.reflectance.value, 0.012);
    }
}

/// Film sealed to foil of other reflectances and roughnesses than the table's.
#[test]
fn sealed_films_know_their_foil() {
    for (reflectance, roughness) in [(0.6, 0.2), (0.75, 0.08), (0.9, 0.25), (0.99, 0.6)] {
        let mut stack = over_foil(film(12.0, 0.05, 0.25), None);
        stack.below = Substrate::Foil(Foil { reflectance, roughness: [roughness; 2] });
        let (kernel, reference) = (ask(&stack), reference("sealed", &stack, Question::default(), 60_000));
        println!("{reflectance}: {} against {:?}", kernel.reflectance.value, reference.reflectance);
        near("sealed film", reference.reflectance, kernel.reflectance.value, 0.015);
    }
}
