//! The image around the centerlines of vessels, by what is measured near each place: so units, window and bias field change nothing.

use std::fmt;

use fixedbitset::FixedBitSet;

use super::{Image, Picture, image::block_before, indices_of, row_at, strides_of};
use willis_core::support::geometry::{Point, apart, bounds, dot, norm, norm_squared};
use willis_core::{error::ensure, network::millimetres, support::statistics::median};

/// The image is averaged with a Gaussian of so many spacings.
const SIGMA: f64 = 0.5;
/// The box around the vessels is so many spacings wider to each side.
const MARGIN: f64 = 12.0;
/// Background lies so many spacings outside the walls at least.
const CLEAR: f64 = 1.5;
/// What is no vessel is taken off as its mean around each place, by a Gaussian of so many spacings: so tissue counts for less.
const TISSUE: f64 = 2.0;
/// Background and noise are measured in cells of so many spacings, in at most so many voxels along each axis.
const CELL: f64 = 16.0;
const CELL_SAMPLES: usize = 12;
/// A cell with fewer of them is as its neighbours.
const LEAST_SAMPLES: usize = 40;
/// The contrast of a vessel at a point is the median of so many points to either side.
const WINDOW: usize = 6;
/// An image shows the vessels where half of their points stand out by so many standard deviations of the noise.
const LEAST_CONTRAST: f64 = 1.5;
/// The median distance from the median times this is the standard deviation of normal numbers.
const NORMAL: f64 = 1.4826;

/// How vessels look in an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Appearance {
    /// Brighter or darker than what is around them, whichever most of their points are.
    #[default]
    Auto,
    /// Brighter: TOF, CTA, contrast-enhanced MRA.
    Bright,
    /// Darker: black-blood MRI.
    Dark,
}

/// An image, and how vessels look in it.
#[derive(Debug, Clone)]
pub struct View {
    /// The image.
    pub image: Image,
    /// How vessels look in it.
    pub appearance: Appearance,
}

/// Centerlines as the image is measured by them.
#[derive(Debug, Clone, Copy)]
pub struct ScanCenterlines<'a> {
    /// Position of each point, m.
    pub position: &'a [Point],
    /// Radius of each point, m.
    pub radius: &'a [f64],
    /// The points of each vessel in order.
    pub lines: &'a [Vec<usize>],
    /// The distance between points, m.
    pub spacing: f64,
}

/// Why an image or a mask says nothing of the vessels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unseen {
    /// Its box ends so far (m) from theirs.
    Beside(f64),
    /// It has no value where most of the vessels are.
    Unknown,
    /// Most of the vessels are outside of what a mask holds.
    Outside,
    /// The vessels do not stand out: so many standard deviations of what is around them.
    Hidden(f64),
}

impl Unseen {
    /// Why a mask does not hold vessels, by the box (m) of its voxels and theirs.
    pub fn by(mask: [Point; 2], vessels: [Point; 2]) -> Self {
        let away = apart(mask, vessels);
        if away > 0.0 { Self::Beside(away) } else { Self::Outside }
    }
}

impl fmt::Display for Unseen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Beside(away) => write!(f, "it lies {:.1} mm beside them", millimetres(*away)),
            Self::Unknown => f.write_str("it has no values where they are"),
            Self::Outside => f.write_str("most of them lie outside of it"),
            Self::Hidden(z) => write!(
                f,
                "they stand out by {z:.1} standard deviations of what is around them (expected {LEAST_CONTRAST} at least)"
            ),
        }
    }
}

/// The image around the centerlines of vessels.
pub struct Scene {
    picture: Picture,
    levels: Cells,
    /// Whether each voxel is inside a vessel.
    lumen: Bits,
    /// Per point of the centerlines how far its vessel stands out there, positive; the unit is that of the image.
    pub contrast: Vec<f64>,
    /// The median contrast.
    pub typical: f64,
    /// 1 where vessels are bright, -1 where they are dark.
    pub sign: f64,
    /// The median noise at those points, as a share of the typical contrast.
    pub noise_share: f64,
    /// The distance between the points of the centerlines, m.
    pub spacing: f64,
}

/// Background and noise near a place.
#[derive(Debug, Clone, Copy)]
pub struct Level {
    /// The median of what is no vessel, times the sign of vessels.
    pub background: f64,
    /// The standard deviation around it, positive.
    pub noise: f64,
}

impl Scene {
    /// Measures an image around centerlines.
    ///
    /// # Errors
    ///
    /// [`Unseen`], where the image does not show the vessels.
    pub fn new(e: &ScanCenterlines, View { image, appearance }: View) -> Result<Self, Unseen> {
        let h = e.spacing;
        let [low, high] = bounds(e.position.iter().copied());
        let wider = [low.map(|x| x - MARGIN * h), high.map(|x| x + MARGIN * h)];
        let away = apart(image.bounds(), [low, high]);
        let Some(mut picture) = Picture::of(image, wider, SIGMA * h) else { return Err(Unseen::Beside(away)) };
        let near = Bits::around(&picture, e, CLEAR * h);
        let lumen = Bits::around(&picture, e, 0.0);
        picture.flatten(TISSUE * h, |voxel| !near.has(voxel));
        let levels = levels(&picture, &near, CELL * h).ok_or(Unseen::Unknown)?;
        let around: Vec<[f64; 2]> = e.position.iter().map(|p| levels.at(&picture, *p)).collect();
        let raw = e.position.iter().zip(&around).map(|(p, [background, _])| Some(picture.value(*p)? - background));
        let raw: Vec<Option<f64>> = raw.collect();
        let known: Vec<f64> = raw.iter().flatten().copied().collect();
        let is_seen = 2 * known.len() >= raw.len();
        ensure(is_seen, || if away > 0.0 { Unseen::Beside(away) } else { Unseen::Unknown })?;
        let sign = match appearance {
            Appearance::Bright => 1.0,
            Appearance::Dark => -1.0,
            Appearance::Auto => median(&known).map_or(1.0, |m| if m < 0.0 { -1.0 } else { 1.0 }),
        };
        let typical = median(&known).unwrap_or(0.0) * sign;
        let noises: Vec<f64> = around.iter().map(|[_, noise]| *noise).collect();
        let noise_share = median(&noises).unwrap_or(0.0) / typical;
        let stand_out = raw.iter().zip(&noises).filter_map(|(x, noise)| Some(sign * (*x)? / noise));
        let stands_out = median(&stand_out.filter(|z| !z.is_nan()).collect::<Vec<f64>>()).unwrap_or(0.0);
        // Not a number is no contrast either.
        ensure(stands_out >= LEAST_CONTRAST && typical > 0.0, || Unseen::Hidden(stands_out))?;
        let mut contrast = vec![typical; e.position.len()];
        for line in e.lines {
            for (at, point) in line.iter().enumerate() {
                let window = &line[at.saturating_sub(WINDOW)..(at + WINDOW + 1).min(line.len())];
                let values: Vec<f64> = window.iter().filter_map(|p| raw[*p]).map(|x| sign * x).collect();
                if let Some(x) = median(&values) {
                    contrast[*point] = x;
                }
            }
        }
        Ok(Self { picture, levels, lumen, contrast, typical, sign, noise_share, spacing: h })
    }

    /// Background and noise at a place (m).
    pub fn level(&self, place: Point) -> Level {
        let [background, noise] = self.levels.at(&self.picture, place);
        Level { background: self.sign * background, noise: noise.max(f64::MIN_POSITIVE) }
    }

    /// How bright a place (m) is, or how dark where vessels are; `None` where it is not known.
    pub fn brightness(&self, place: Point) -> Option<f64> {
        self.picture.value(place).map(|x| self.sign * x)
    }

    /// Whether a place (m) is inside a vessel.
    pub fn is_inside(&self, place: Point) -> bool {
        self.is_inside_at(self.picture.index(place))
    }

    /// The indices of a place (m) in the image, between voxels too.
    pub fn index(&self, place: Point) -> [f64; 3] {
        self.picture.index(place)
    }

    /// As [`Scene::brightness`], at indices.
    pub fn brightness_at(&self, index: [f64; 3]) -> Option<f64> {
        self.picture.value_at(index).map(|x| self.sign * x)
    }

    /// As [`Scene::is_inside`], at indices.
    pub fn is_inside_at(&self, index: [f64; 3]) -> bool {
        let shape = self.picture.shape;
        let nearest = index.map(|x| x + 0.5);
        let inside = (0..3).all(|axis| nearest[axis] >= 0.0 && nearest[axis] < shape[axis] as f64);
        inside && self.lumen.has(self.picture.row(nearest.map(|x| x as usize)))
    }
}

/// One bit for each voxel of a picture.
pub struct Bits(FixedBitSet);

impl Bits {
    /// The voxels that are no further from a point than its radius and so much (m).
    pub fn around(picture: &Picture, e: &ScanCenterlines, more: f64) -> Self {
        let shape = picture.shape;
        let mut bits = FixedBitSet::with_capacity(picture.values.len());
        let steps = [0, 1, 2].map(|axis| picture.step(axis));
        // A box of indices that holds a ball of radius 1 m.
        let unit = {
            let origin = picture.index([0.0; 3]);
            let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|p| picture.index(p));
            [0, 1, 2].map(|axis| norm(columns.map(|c| c[axis] - origin[axis])))
        };
        for (position, radius) in e.position.iter().zip(e.radius) {
            let (centre, reach) = (picture.index(*position), radius + more);
            let range = |axis: usize| {
                let half = unit[axis] * reach;
                let low = (centre[axis] - half).ceil().max(0.0);
                let high = (centre[axis] + half).floor().min((shape[axis] - 1) as f64);
                low as isize..=if high < 0.0 { -1 } else { high as isize }
            };
            for z in range(2) {
                for y in range(1) {
                    let by = [y as f64 - centre[1], z as f64 - centre[2]];
                    let to: Point = [0, 1, 2].map(|k| steps[1][k] * by[0] + steps[2][k] * by[1]);
                    // Along the first axis the ball is between two roots.
                    let (a, b) = (norm_squared(steps[0]), dot(steps[0], to));
                    let under_root = b * b - a * (norm_squared(to) - reach * reach);
                    if under_root < 0.0 {
                        continue;
                    }
                    let half = under_root.sqrt();
                    let low = (centre[0] - (b + half) / a).ceil().max(0.0);
                    let high = (centre[0] - (b - half) / a).floor().min((shape[0] - 1) as f64);
                    if low <= high {
                        let first = picture.row([0, y as usize, z as usize]);
                        bits.insert_range(first + low as usize..first + high as usize + 1);
                    }
                }
            }
        }
        Self(bits)
    }

    /// Whether the voxel of this row is one of them.
    pub fn has(&self, row: usize) -> bool {
        self.0.contains(row)
    }
}

/// Background and noise in cells of voxels, linear between their middles.
struct Cells {
    shape: [usize; 3],
    /// Voxels of a cell along each axis.
    size: [f64; 3],
    /// Of each cell its background and its noise.
    levels: Vec<[f64; 2]>,
}

impl Cells {
    fn at(&self, picture: &Picture, place: Point) -> [f64; 2] {
        let index = picture.index(place);
        let (mut low, mut share) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            (low[axis], share[axis]) = block_before(index[axis], self.size[axis], self.shape[axis]);
        }
        let mut sum = [0.0; 2];
        for corner in 0..8 {
            let (mut weight, mut cell) = (1.0, [0; 3]);
            for axis in 0..3 {
                let upper = corner >> axis & 1 == 1;
                weight *= if upper { share[axis] } else { 1.0 - share[axis] };
                cell[axis] = (low[axis] + usize::from(upper)).min(self.shape[axis] - 1);
            }
            if weight > 0.0 {
                let [background, noise] = self.levels[row_at(self.shape, cell)];
                sum = [sum[0] + weight * background, sum[1] + weight * noise];
            }
        }
        sum
    }
}

/// Background and noise by cells about so wide (m): median and spread of the voxels that are not near vessels; `None` where no voxel of
/// them is known.
fn levels(picture: &Picture, near: &Bits, width: f64) -> Option<Cells> {
    let voxels = picture.shape;
    let along = [0, 1, 2].map(|axis| norm(picture.step(axis)));
    let shape = [0, 1, 2].map(|axis| ((voxels[axis] as f64 * along[axis] / width).round() as usize).clamp(1, voxels[axis]));
    let size = [0, 1, 2].map(|axis| voxels[axis] as f64 / shape[axis] as f64);
    let stride = size.map(|size| (size / CELL_SAMPLES as f64).floor().max(1.0) as usize);
    let count = shape.iter().product();
    let mut samples: Vec<Vec<f32>> = vec![Vec::new(); count];
    let values = &picture.values;
    let cell = |axis: usize, index: usize| (((index as f64 + 0.5) / size[axis]) as usize).min(shape[axis] - 1);
    for z in (0..voxels[2]).step_by(stride[2]) {
        for y in (0..voxels[1]).step_by(stride[1]) {
            let row = picture.row([0, y, z]);
            let cells = row_at(shape, [0, cell(1, y), cell(2, z)]);
            for x in (0..voxels[0]).step_by(stride[0]) {
                if values[row + x].is_finite() && !near.has(row + x) {
                    samples[cells + cell(0, x)].push(values[row + x]);
                }
            }
        }
    }
    let mut found: Vec<Option<[f64; 2]>> = samples.iter_mut().map(|of| spread(of)).collect();
    if found.iter().all(Option::is_none) {
        return None;
    }
    while found.contains(&None) {
        found = filled_from_neighbours(&found, shape);
    }
    Some(Cells { shape, size, levels: found.into_iter().flatten().collect() })
}

/// Median and standard deviation by the median distance from it; `None` for too few.
fn spread(values: &mut [f32]) -> Option<[f64; 2]> {
    let middle = |values: &mut [f32]| {
        let half = values.len() / 2;
        f64::from(*values.select_nth_unstable_by(half, f32::total_cmp).1)
    };
    if values.len() < LEAST_SAMPLES {
        return None;
    }
    let median = middle(values);
    for x in values.iter_mut() {
        *x = (*x - median as f32).abs();
    }
    Some([median, NORMAL * middle(values)])
}

/// Cells without a value take the mean of those beside them that have one.
fn filled_from_neighbours(found: &[Option<[f64; 2]>], shape: [usize; 3]) -> Vec<Option<[f64; 2]>> {
    let steps = strides_of(shape);
    let mean = |row: usize| {
        let at = indices_of(shape, row);
        let before = (0..3).filter(|axis| at[*axis] > 0).map(|axis| row - steps[axis]);
        let after = (0..3).filter(|axis| at[*axis] + 1 < shape[*axis]).map(|axis| row + steps[axis]);
        let beside: Vec<[f64; 2]> = before.chain(after).filter_map(|row| found[row]).collect();
        let count = beside.len() as f64;
        (count > 0.0).then(|| [0, 1].map(|k| beside.iter().map(|of| of[k]).sum::<f64>() / count))
    };
    found.iter().enumerate().map(|(row, of)| of.or_else(|| mean(row))).collect()
}
