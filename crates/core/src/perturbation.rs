//! Structural perturbation: ε-occlusion, by which every uncertain vessel is open with probability λA, independently, λ = 1 - ε, drawn at
//! random or enumerated; and stenosis, a vessel narrowed over its whole length or over a stretch of it.

use rand::Rng;

use crate::support::random::{BLOCK, RandomStream, stream};
use crate::{flow::Factors, support::random};

/// Vessels that draw on the same words.
const TOGETHER: usize = 16;
/// Binary digits of the keep probability that are compared for all vessels; the rest only where these do not decide.
const DIGITS: usize = 8;
/// Words of 32 bits that vessels draw together, two for each digit of each.
const WORDS: usize = 2 * TOGETHER * DIGITS;

/// What keep probabilities, in [0, 1], leave to chance: per vessel the samples of a block in which it is open whatever is drawn, all or none; and
/// the vessels that are open by chance, with their keep probabilities.
fn by_chance(keep: impl IntoIterator<Item = f64>) -> (Vec<u64>, Vec<(usize, f64)>) {
    let keep: Vec<f64> = keep.into_iter().collect();
    let random = keep.iter().copied().enumerate().filter(|(_, p)| *p > 0.0 && *p < 1.0);
    (keep.iter().map(|p| if *p >= 1.0 { u64::MAX } else { 0 }).collect(), random.collect())
}

/// The keep probabilities of a network's vessels.
#[derive(Debug, Clone, PartialEq)]
pub struct Occlusion {
    /// Per vessel the samples in which it is open whatever is drawn: all or none.
    surely: Vec<u64>,
    /// Vessels that are open by chance, with their keep probabilities, times 2⁶⁴.
    random: Vec<(u32, u64)>,
}

impl Occlusion {
    /// From the keep probability λA of each vessel, in [0, 1]; exact to 2⁻⁶⁴.
    pub fn new(keep: impl IntoIterator<Item = f64>) -> Self {
        let (surely, random) = by_chance(keep);
        Self { surely, random: random.into_iter().map(|(vessel, p)| (vessel as u32, (p * 2_f64.powi(64)) as u64)).collect() }
    }

    /// Draws block `block` of `seed`: bit i of word e says whether vessel e is open in sample i of the block.
    ///
    /// A uniform fraction per vessel and sample is compared with the keep probability digit by digit, all 64 samples of a vessel in one word,
    /// until every comparison is decided.
    pub fn draw(&self, seed: u64, block: u64, masks: &mut Vec<u64>) {
        masks.clone_from(&self.surely);
        let number = random::occlusion(block);
        let mut rng = stream(seed, number);
        // What the first digits leave undecided draws on the words after those that all vessels draw.
        let mut rest = None;
        for together in self.random.chunks(TOGETHER) {
            let words = words(&mut rng);
            for (at, (vessel, keep)) in together.iter().enumerate() {
                let (mut below, mut open) = (0, u64::MAX);
                for (digit, words) in words.iter().enumerate() {
                    let (zeros, ones) = (open & !words[at], open & words[at]);
                    let is_set = keep >> (63 - digit) & 1 == 1;
                    below |= if is_set { zeros } else { 0 };
                    open = if is_set { ones } else { zeros };
                }
                if open != 0 {
                    let rng = rest.get_or_insert_with(|| {
                        let mut rng = stream(seed, number);
                        rng.set_word_pos((WORDS * self.random.len().div_ceil(TOGETHER)) as u128);
                        rng
                    });
                    below |= decide(*keep, open, rng);
                }
                masks[*vessel as usize] = below;
            }
        }
    }
}

/// The next random words, one for each vessel of each digit. Their order is that in which sixteen blocks of the cipher, of sixteen words each,
/// are computed side by side: the first words of all blocks come first.
fn words(rng: &mut RandomStream) -> [[u64; TOGETHER]; DIGITS] {
    let mut bytes = [0; 4 * WORDS];
    rng.fill_bytes(&mut bytes);
    let drawn = bytes.as_chunks().0;
    let half = |at: usize| u64::from(u32::from_le_bytes(drawn[at % 16 * 16 + at / 16]));
    let word = |at: usize| half(2 * at + 1) << 32 | half(2 * at);
    std::array::from_fn(|digit| std::array::from_fn(|vessel| word(digit * TOGETHER + vessel)))
}

/// The samples of `open` that are below the keep probability by the digits after the first ones, one word each.
fn decide(keep: u64, mut open: u64, rng: &mut RandomStream) -> u64 {
    let mut below = 0;
    while open != 0 {
        let sample = open & open.wrapping_neg();
        below |= if rng.next_u64() < keep << DIGITS { sample } else { 0 };
        open ^= sample;
    }
    below
}

/// Vessels that may be open or closed that can be enumerated at the most: 2²⁰ patterns.
pub const MOST_UNCERTAIN: usize = 20;

const LOW_BITS: usize = BLOCK.trailing_zeros() as usize;

/// The patterns of the vessels that are neither always nor never open, in blocks of 64.
///
/// The first six of them run through all patterns within a block, bit i of their pattern number set in sample i; the
/// others follow the Gray code of the block's number.
#[derive(Debug, Clone, PartialEq)]
pub struct Enumeration {
    /// Per vessel the patterns of a block in which it is open whatever else is: all or none.
    surely: Vec<u64>,
    /// Vessels that are open in some patterns, with their keep probabilities.
    changing: Vec<(usize, f64)>,
}

impl Enumeration {
    /// From the keep probability of each vessel.
    ///
    /// # Errors
    ///
    /// More than [`MOST_UNCERTAIN`] lie between 0 and 1: how many.
    pub fn new(keep: &[f64]) -> Result<Self, usize> {
        let (surely, changing) = by_chance(keep.iter().copied());
        if changing.len() > MOST_UNCERTAIN { Err(changing.len()) } else { Ok(Self { surely, changing }) }
    }

    /// How many patterns there are.
    pub fn patterns(&self) -> u64 {
        1 << self.changing.len()
    }

    /// Block `block`: bit i of word e says whether vessel e is open in pattern i, whose probability is `probability[i]`.
    pub fn fill(&self, block: u64, masks: &mut Vec<u64>, probability: &mut [f64; BLOCK as usize]) {
        let gray = block ^ (block >> 1);
        let is_open = |place: usize, pattern: usize| {
            if place < LOW_BITS { pattern >> place & 1 == 1 } else { gray >> (place - LOW_BITS) & 1 == 1 }
        };
        masks.clone_from(&self.surely);
        for (place, (vessel, _)) in self.changing.iter().enumerate() {
            masks[*vessel] = (0..BLOCK as usize).fold(0, |word, i| word | u64::from(is_open(place, i)) << i);
        }
        for (pattern, probability) in probability.iter_mut().enumerate() {
            let factors =
                self.changing.iter().enumerate().map(|(place, (_, p))| if is_open(place, pattern) { *p } else { 1.0 - p });
            *probability = factors.product();
        }
    }
}

/// A narrowing. With the open share of the diameter o = 1 - s (s the reduction of diameter), and the narrowed share of the
/// length f = stretch/l, the narrowed and the normal stretch are in series under Poiseuille's law:
/// R' = R·(1 - f + f/o⁴), the volume of the lumen V' = V·(1 - f + f·o²), and the radius where it is narrowest r' = r·o.
///
/// A steady flow does not notice where along the vessel the stretch lies. The loss of a jet behind the narrowing, which
/// goes as the square of the flow (Young & Tsai 1973), is not part of this law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stenosis {
    /// What is left of the diameter, in (0, 1].
    pub open_diameter: f64,
    /// Length of the narrowed stretch, m; the whole vessel where there is none.
    pub stretch: Option<f64>,
    /// Where the stretch lies, which only a pulse notices.
    pub place: StretchPlace,
}

/// Where a narrowed stretch lies in a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StretchPlace {
    /// At the first node.
    Start,
    /// In the middle.
    #[default]
    Middle,
    /// At the second node.
    End,
}

impl Stenosis {
    /// A reduction of the diameter by the share `reduction` in [0, 1), over the whole vessel.
    pub fn of_diameter(reduction: f64) -> Self {
        Self { open_diameter: 1.0 - reduction, stretch: None, place: StretchPlace::Middle }
    }

    /// A reduction of the cross-section area by the share `reduction` in [0, 1): o = sqrt(1 - reduction).
    pub fn of_area(reduction: f64) -> Self {
        Self { open_diameter: (1.0 - reduction).sqrt(), stretch: None, place: StretchPlace::Middle }
    }

    /// The factors for a vessel of a length in m, at least the stretch.
    pub fn factors(&self, length: f64) -> Factors {
        let narrow = self.stretch.map_or(1.0, |stretch| stretch / length);
        let (normal, radius) = (1.0 - narrow, self.open_diameter);
        let (resistance, volume) = (normal + narrow / radius.powi(4), normal + narrow * radius * radius);
        Factors { resistance, volume, radius, length: 1.0 }
    }
}
