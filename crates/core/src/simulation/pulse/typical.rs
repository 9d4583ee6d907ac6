//! Typical waveforms of the flow into the brain: their shapes, for an inlet whose mean flow is known.
//!
//! They are those of a model, not of a measurement: the flow in the middle of the left internal carotid and of the right vertebral artery of
//! the arteries of Alastruey et al. 2007 (J Biomech 40:1794; 33 vessels from the aorta to the Circle of Willis, as openBF ships them), in
//! the linear theory of this module, over their means. Pulsatility indices 0.73 and 1.18. Time 0 is the beginning of ejection.

use num_complex::Complex64;

/// An artery with a typical waveform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Typical {
    /// The internal carotid artery.
    Carotid,
    /// The vertebral artery.
    Vertebral,
}

/// The period of the waveforms, s.
pub const PERIOD: f64 = 1.0;

/// c_1 to c_10 of the flow over its mean, each by its real and its imaginary part.
const CAROTID: [f64; 20] = [
    -0.1336, -0.2482, -0.1176, -0.0167, -0.048, 0.0266, -0.0127, 0.0463, -0.0053, 0.0013, -0.0022, 0.0146, 0.0078, 0.0026,
    0.0002, -0.0005, 0.0011, -0.0029, -0.0152, 0.0013,
];
const VERTEBRAL: [f64; 20] = [
    0.0252, -0.3922, -0.1725, -0.1537, -0.0837, 0.027, -0.054, -0.0518, -0.0025, -0.018, -0.0572, -0.0085, -0.0155, 0.0299,
    -0.0005, 0.003, -0.013, -0.0174, -0.0583, 0.0154,
];

impl Typical {
    /// c_0 to c_H of the flow over its mean; zero above the harmonics of the model.
    pub fn shape(self, harmonics: usize) -> Vec<Complex64> {
        let known = match self {
            Self::Carotid => &CAROTID,
            Self::Vertebral => &VERTEBRAL,
        };
        let mut shape = vec![Complex64::ONE];
        shape.extend(known.as_chunks().0.iter().map(|[re, im]| Complex64::new(*re, *im)));
        shape.resize(harmonics + 1, Complex64::ZERO);
        shape
    }
}
