//! Purpose: foil and coats against closed forms, and the kernel's films against the judge on plane stacks.

use glam::{DVec3, Vec3};
use procedural::{Gloss, Stream};
use sheetlight::transport::answer::{Answer, Estimate, Question, Side};
use sheetlight::transport::fresnel::gloss;
use sheetlight::transport::kernel;
use sheetlight::transport::path::{Effort, solve};
use sheetlight::transport::stack::{Below, Foil, Layer, Scattering, Stack};

const FOIL: Foil = Foil { reflectance: 0.9, roughness: [0.25, 0.12] };

/// A film whose pigment has the reduced scattering `sigma` [mm^-1].
fn film(sigma: f64, mu_a: f64, thickness: f64) -> Layer {
    Layer::new(thickness, 1.53, mu_a, Scattering::Isotropic { mu_s: sigma / (1.0 - 0.557), g: 0.557 })
}

fn over_tablet(film: Layer, gap: f64, coat: f64) -> Stack {
    let tablet = Layer::new(f64::INFINITY, 1.5, 0.005, Scattering::Isotropic { mu_s: 40.0, g: 0.0 });
    Stack { above: 1.0, layers: vec![film, Layer::air(gap), Layer { coat, ..tablet }], below: Below::Index(1.0) }
}

fn over_foil(film: Layer, gap: Option<f64>) -> Stack {
    let layers = std::iter::once(film).chain(gap.map(Layer::air)).collect();
    Stack { above: 1.0, layers, below: Below::Foil(FOIL) }
}

fn judge(case: &str, stack: &Stack, question: Question, photons: u64) -> Answer {
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

/// Foil below air throws back its reflectance of light from straight above and from everywhere, exactly: no light is lost
/// between facets. Below a film that absorbs nothing a perfect mirror sends everything back.
#[test]
fn foil_reflects_its_reflectance() {
    let air = |foil| Stack { above: 1.0, layers: vec![Layer::air(1.0)], below: Below::Foil(foil) };
    for incidence in [Some(0.0), Some(0.7), None] {
        let question = Question { incidence, ..Question::default() };
        let a = judge("air", &air(FOIL), question, 2_000);
        near("foil", a.reflectance, 0.9, 1e-9);
        near("absorbed", a.absorbed[0], 0.1, 1e-9);
    }
    let mut mirror = over_foil(film(12.0, 0.0, 0.12), Some(2.0));
    mirror.below = Below::Foil(Foil { reflectance: 1.0, ..FOIL });
    let a = judge("perfect mirror", &mirror, Question::default(), 5_000);
    // Roulette books single photons; with full weights there is none.
    assert!((a.reflectance.value + a.specular - 1.0).abs() < 1e-9, "{:?} and {}", a.reflectance, a.specular);
}

/// The directions in which foil throws light from straight above are those of the GGX law: light in a cone of 5 degrees
/// about three views, against the law's own mean over the cone.
#[test]
fn foil_mirrors_by_its_law() {
    let metal = Gloss { share: 1.0, reflectance: 0.9, roughness: FOIL.roughness.map(|alpha| alpha as f32) };
    let stack = Stack { above: 1.0, layers: vec![Layer::air(1.0)], below: Below::Foil(FOIL) };
    for view in
        [DVec3::new(0.0, -0.422_618, 0.906_308), DVec3::new(0.3, 0.0, 0.953_939), DVec3::new(0.2, 0.2, 0.959_166)]
    {
        let a = judge("lobe", &stack, Question { view, ..Question::default() }, 200_000);
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
        near("cone", a.cone.expect("the judge counts it"), sum / count, 0.03 * sum / count);
    }
}

/// Two films of half the thickness are one film; and light passes a coat twice on its way to a mirror and back.
#[test]
fn layers_add_up() {
    let half = film(12.0, 0.5, 0.06);
    let slab = |layers| Stack { above: 1.0, layers, below: Below::Index(1.0) };
    let one = judge("one", &slab(vec![film(12.0, 0.5, 0.12)]), Question::default(), 200_000);
    let two = judge("two", &slab(vec![half, half]), Question::default(), 200_000);
    for (what, a, b) in [("R", one.reflectance, two.reflectance), ("T", one.transmittance, two.transmittance)] {
        let error = (a.error * a.error + b.error * b.error).sqrt();
        assert!((a.value - b.value).abs() < 4.0 * error, "{what}: {a:?} and {b:?}");
    }
    let coated = Layer { coat: 0.8, ..Layer::air(1.0) };
    let mirror = Below::Foil(Foil { reflectance: 1.0, ..FOIL });
    let a = judge("coat", &Stack { above: 1.0, layers: vec![coated], below: mirror }, Question::default(), 1_000);
    near("coat", a.reflectance, 0.64, 1e-9);
    let inner = Stack { above: 1.0, layers: vec![Layer::air(1.0), coated], below: mirror };
    near("inner coat", judge("inner coat", &inner, Question::default(), 1_000).reflectance, 0.64, 1e-9);
}
