//! Vector instructions chosen at run time, with equal bits from each: kernels are generic over the vectors of an
//! instruction set and compiled once for each, without fused multiply-add.

#![expect(clippy::inline_always, reason = "a kernel is compiled as a whole for each instruction set")]

pub use pulp::Scalar;

pub use pulp::Simd;

pub use pulp::WithSimd as Kernel;

/// An instruction set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstructionSet {
    /// What every processor of the architecture has (SSE2 on x86-64, NEON on aarch64).
    Baseline,
    /// AVX2.
    Avx2,
    /// AVX-512.
    Avx512,
}

/// The variable that forces an instruction set: `baseline`, `avx2` or `avx512`.
pub const FORCE: &str = "WILLIS_SIMD";

impl InstructionSet {
    /// The best one of this processor, or a lesser one that [`FORCE`] names.
    pub fn detect() -> Self {
        let best = Self::best();
        match std::env::var(FORCE).as_deref() {
            Ok("baseline") => Self::Baseline,
            Ok("avx2") if best != Self::Baseline => Self::Avx2,
            _ => best,
        }
    }

    /// The usual name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    #[cfg(target_arch = "x86_64")]
    fn best() -> Self {
        match pulp::x86::Arch::new() {
            pulp::x86::Arch::V4(_) => Self::Avx512,
            pulp::x86::Arch::V3(_) => Self::Avx2,
            _ => Self::Baseline,
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn best() -> Self {
        Self::Baseline
    }

    /// Runs `kernel`, which must be inlined all the way down, compiled for this instruction set.
    #[cfg(target_arch = "x86_64")]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match (self, pulp::x86::V4::try_new(), pulp::x86::V3::try_new()) {
            (Self::Avx512, Some(v4), _) => Simd::vectorize(v4, kernel),
            (Self::Avx512 | Self::Avx2, _, Some(v3)) => Simd::vectorize(v3, kernel),
            _ => kernel.with_simd(Scalar::new()),
        }
    }

    /// Runs `kernel`.
    #[cfg(not(target_arch = "x86_64"))]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        kernel.with_simd(Scalar::new())
    }
}

/// One figure for each sample of a group, at the start of a cache line, so that no vector straddles two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<const B: usize>(pub [f64; B]);

impl<const B: usize> Lanes<B> {
    /// Nothing in every lane.
    pub const ZERO: Self = Self([0.0; B]);

    /// The vectors that make up the group.
    #[inline(always)]
    pub fn vectors<S: Simd>(&self) -> &[S::f64s] {
        const { assert!(B.is_multiple_of(S::F64_LANES), "a group is made of whole vectors") }
        S::as_simd_f64s(&self.0).0
    }

    /// The vectors that make up the group.
    #[inline(always)]
    pub fn vectors_mut<S: Simd>(&mut self) -> &mut [S::f64s] {
        const { assert!(B.is_multiple_of(S::F64_LANES), "a group is made of whole vectors") }
        S::as_mut_simd_f64s(&mut self.0).0
    }
}

impl<const B: usize> std::ops::Deref for Lanes<B> {
    type Target = [f64; B];

    #[inline]
    fn deref(&self) -> &[f64; B] {
        &self.0
    }
}

impl<const B: usize> std::ops::DerefMut for Lanes<B> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [f64; B] {
        &mut self.0
    }
}

/// `f` of each vector of two groups.
#[inline(always)]
pub fn zip<S: Simd, const B: usize>(_: S, a: &Lanes<B>, b: &Lanes<B>, f: impl Fn(S::f64s, S::f64s) -> S::f64s) -> Lanes<B> {
    let mut out = Lanes::ZERO;
    let pairs = a.vectors::<S>().iter().zip(b.vectors::<S>());
    for (out, (a, b)) in out.vectors_mut::<S>().iter_mut().zip(pairs) {
        *out = f(*a, *b);
    }
    out
}

/// `f` of each vector of a group.
#[inline(always)]
pub fn map<S: Simd, const B: usize>(simd: S, a: &Lanes<B>, f: impl Fn(S::f64s) -> S::f64s) -> Lanes<B> {
    zip(simd, a, a, |a, _| f(a))
}

/// One figure in every lane.
#[inline(always)]
pub fn splat<S: Simd, const B: usize>(simd: S, value: f64) -> Lanes<B> {
    let mut out = Lanes::ZERO;
    out.vectors_mut::<S>().fill(simd.splat_f64s(value));
    out
}

/// a + b, lane by lane.
#[inline(always)]
pub fn plus<S: Simd, const B: usize>(simd: S, a: &Lanes<B>, b: &Lanes<B>) -> Lanes<B> {
    zip(simd, a, b, |a, b| simd.add_f64s(a, b))
}

/// a b, lane by lane.
#[inline(always)]
pub fn product<S: Simd, const B: usize>(simd: S, a: &Lanes<B>, b: &Lanes<B>) -> Lanes<B> {
    zip(simd, a, b, |a, b| simd.mul_f64s(a, b))
}

/// a + w b, lane by lane, with two roundings.
#[inline(always)]
pub fn plus_product<S: Simd, const B: usize>(simd: S, a: &Lanes<B>, w: &Lanes<B>, b: &Lanes<B>) -> Lanes<B> {
    plus(simd, a, &product(simd, w, b))
}

/// The bit of each sample in a word: sample i is bit i.
#[repr(C, align(64))]
struct SampleBits([u64; 64]);

static SAMPLE_BITS: SampleBits = {
    let (mut bits, mut sample) = ([0; 64], 0);
    while sample < 64 {
        bits[sample] = 1 << sample;
        sample += 1;
    }
    SampleBits(bits)
};

/// `value` in the lanes of the samples from `first` on, a multiple of a vector's lanes, that are set in `word`; zero elsewhere.
#[inline(always)]
pub fn masked<S: Simd, const B: usize>(simd: S, value: &Lanes<B>, word: u64, first: usize) -> Lanes<B> {
    let mut out = Lanes::ZERO;
    let (vectors, values) = (out.vectors_mut::<S>(), value.vectors::<S>());
    let bits = &S::as_simd_u64s(&SAMPLE_BITS.0).0[first / S::F64_LANES..][..values.len()];
    for ((out, value), bits) in vectors.iter_mut().zip(values).zip(bits) {
        let set = simd.greater_than_u64s(simd.and_u64s(simd.splat_u64s(word), *bits), simd.splat_u64s(0));
        *out = simd.select_f64s(set, *value, simd.splat_f64s(0.0));
    }
    out
}

/// The lanes of a group of 64 at most that are above zero, as bits: lane i is bit i.
#[inline(always)]
pub fn positive<S: Simd, const B: usize>(simd: S, values: &Lanes<B>) -> u64 {
    let mut any = SampleBits([0; 64]);
    let sum = &mut S::as_mut_simd_u64s(&mut any.0).0[0];
    for (value, bits) in values.vectors::<S>().iter().zip(S::as_simd_u64s(&SAMPLE_BITS.0).0) {
        let set = simd.greater_than_f64s(*value, simd.splat_f64s(0.0));
        *sum = simd.or_u64s(*sum, simd.select_u64s(set, *bits, simd.splat_u64s(0)));
    }
    any.0[..S::F64_LANES].iter().fold(0, |all, bits| all | bits)
}
