//! Vector instructions chosen at run time, with equal bits from each: plain loops over lanes, compiled once per
//! instruction set, without fused multiply-add.

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
    pub fn run<R>(self, kernel: impl FnOnce() -> R) -> R {
        match (self, pulp::x86::V4::try_new(), pulp::x86::V3::try_new()) {
            (Self::Avx512, Some(v4), _) => v4.vectorize(kernel),
            (Self::Avx512 | Self::Avx2, _, Some(v3)) => v3.vectorize(kernel),
            _ => kernel(),
        }
    }

    /// Runs `kernel`.
    #[cfg(not(target_arch = "x86_64"))]
    pub fn run<R>(self, kernel: impl FnOnce() -> R) -> R {
        kernel()
    }
}

/// One figure for each sample of a group, at the start of a cache line, so that no vector straddles two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<const B: usize>(pub [f64; B]);

impl<const B: usize> Lanes<B> {
    /// Nothing in every lane.
    pub const ZERO: Self = Self([0.0; B]);
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

/// `f` of each lane of two groups. The result is a new value, which is what lets the compiler use whole vectors.
#[expect(clippy::inline_always, reason = "the innermost lane loops")]
#[inline(always)]
pub fn zip<const B: usize>(a: &Lanes<B>, b: &Lanes<B>, f: impl Fn(f64, f64) -> f64) -> Lanes<B> {
    let mut out = Lanes::ZERO;
    for lane in 0..B {
        out[lane] = f(a[lane], b[lane]);
    }
    out
}

/// a + w b, lane by lane, with two roundings.
#[expect(clippy::inline_always, reason = "the innermost lane loops")]
#[inline(always)]
pub fn plus_product<const B: usize>(a: &Lanes<B>, w: &Lanes<B>, b: &Lanes<B>) -> Lanes<B> {
    let mut out = Lanes::ZERO;
    for lane in 0..B {
        out[lane] = a[lane] + w[lane] * b[lane];
    }
    out
}

/// All bits set in the lanes whose bit in `word` is set.
#[expect(clippy::inline_always, reason = "the innermost lane loops")]
#[inline(always)]
pub fn lane_masks<const B: usize>(word: u64) -> [u64; B] {
    let mut out = [0; B];
    for (lane, mask) in out.iter_mut().enumerate() {
        *mask = (word >> lane & 1).wrapping_neg();
    }
    out
}

/// `value` in the lanes that `mask` admits, zero elsewhere.
#[expect(clippy::inline_always, reason = "the innermost lane loops")]
#[inline(always)]
pub fn masked<const B: usize>(value: &Lanes<B>, mask: &[u64; B]) -> Lanes<B> {
    let mut out = Lanes::ZERO;
    for lane in 0..B {
        out[lane] = f64::from_bits(value[lane].to_bits() & mask[lane]);
    }
    out
}
