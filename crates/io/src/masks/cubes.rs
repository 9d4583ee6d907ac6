//! The image around a place as a cube along the axes of the patient, for a person who looks at slices of it.

use willis_core::support::geometry::Point;

/// Samples along each side of a cube.
pub const SIDE: usize = 40;
/// The distance between them, m: 24 mm in all.
pub const STEP: f64 = 0.6e-3;
/// A cube holds values from this many typical contrasts below the background to that many above it ...
const HELD: [f64; 2] = [-2.0, 6.0];
/// ... of which these are black and white at first.
const SHOWN: [f64; 2] = [-0.5, 1.5];

/// The image around one place.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageCube {
    /// The value of the image that a sample of 1 stands for, and that of 255.
    pub held: [f64; 2],
    /// Those that are black and white at first.
    pub shown: [f64; 2],
    /// Whether vessels are dark.
    pub is_dark: bool,
    /// The samples, x fastest, then y; 0 where the image has no value.
    pub samples: Vec<u8>,
}

impl ImageCube {
    /// The cube around a place (m); `None` outside of the image.
    pub fn new(scene: &super::scene::Scene, centre: Point) -> Option<Self> {
        let level = scene.level(centre);
        // In an image of dark vessels all is turned round.
        let ends = |[low, high]: [f64; 2]| {
            let value = |share: f64| scene.sign * (level.background + share * scene.typical);
            if scene.sign < 0.0 { [value(high), value(low)] } else { [value(low), value(high)] }
        };
        let (held, shown, is_dark) = (ends(HELD), ends(SHOWN), scene.sign < 0.0);
        let off = |n: usize| (n as f64 - (SIDE - 1) as f64 / 2.0) * STEP;
        let sample = |n: usize| {
            let at = super::indices_of([SIDE; 3], n);
            let Some(x) = scene.brightness([0, 1, 2].map(|k| centre[k] + off(at[k]))) else { return 0 };
            let share = (scene.sign * x - held[0]) / (held[1] - held[0]);
            1 + (254.0 * share.clamp(0.0, 1.0)).round() as u8
        };
        let samples: Vec<u8> = (0..SIDE * SIDE * SIDE).map(sample).collect();
        samples.iter().any(|sample| *sample > 0).then_some(Self { held, shown, is_dark, samples })
    }
}
