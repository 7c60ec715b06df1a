//! Oblique and off-centre contacts, with spin and of two free spacecraft: how far the laws are from the ideal test.

use crate::delay_predictor::space::{SCENES, Scene};
use softdock_control::delay::LawName;

/// On an oblique wall no axis reverses, so that no pause makes up for what the lead brakes too much.
#[test]
fn contacts_in_space() {
    let bounds = [
        (LawName::Lead, 0.045),
        (LawName::Polynomial, 0.13),
        (LawName::Ats, 0.045),
        (LawName::Smith, 0.002),
        (LawName::Passivity, 0.006),
    ];
    for scene in SCENES.map(Scene::frictionless) {
        let errors = bounds.map(|(law, _)| scene.error(law, 0.0, 0.5));
        println!("{:30} {errors:.4?}", scene.name);
        for ((law, bound), error) in bounds.into_iter().zip(errors) {
            assert!(error < bound, "{} {law:?}: {error}", scene.name);
        }
    }
}
