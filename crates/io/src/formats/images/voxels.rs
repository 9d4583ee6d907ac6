//! The voxels of an image, read as a stream: as the classes of a mask, or as numbers.

use std::io::{self, Read};

use crate::formats::{
    binary::NumberType::{self, Real, Signed, Unsigned},
    ensure,
};
use crate::masks::{Affine, Image, Mask, WallFinder, indices_of, steps_of, volume_of};
use willis_core::{error::Fault, error::in_few_digits, network::Frame, support::geometry::norm};

/// More classes than any list of arteries has.
const MOST_CLASSES: usize = 64;
/// Values of a mask that went through real numbers are off by this at least.
const LEAST_TOLERANCE: f64 = 1e-3;
/// A value that is off the nearest whole number by so much is no class.
const FAR_FROM_WHOLE: f64 = 0.25;
const ACCEPTED: &str = "give `level`, the least value inside a vessel; a mask has whole numbers from 0 to 255, 0 for background";
/// Voxels that are read at once.
const BLOCK: usize = 1 << 14;
/// Values by which an image in memory grows.
const GROWTH: usize = 1 << 24;

/// A type of number: how it is stored, its bytes, its code in NIfTI, and its words in MetaImage and in NRRD, with `|` between them.
type TypeRow = (NumberType, usize, i64, &'static str, &'static str);

const TYPES: [TypeRow; 10] = [
    (Unsigned, 1, 2, "MET_UCHAR", "uchar|unsigned char|uint8|uint8_t"),
    (Unsigned, 2, 512, "MET_USHORT", "ushort|unsigned short|unsigned short int|uint16|uint16_t"),
    // What ITK writes for a long: four bytes, whatever the machine has.
    (Unsigned, 4, 768, "MET_UINT|MET_ULONG", "uint|unsigned int|uint32|uint32_t"),
    (Unsigned, 8, 1280, "MET_ULONG_LONG", "ulonglong|unsigned long long|unsigned long long int|uint64|uint64_t"),
    (Signed, 1, 256, "MET_CHAR", "char|signed char|int8|int8_t"),
    (Signed, 2, 4, "MET_SHORT", "short|short int|signed short|signed short int|int16|int16_t"),
    (Signed, 4, 8, "MET_INT|MET_LONG", "int|signed int|int32|int32_t"),
    (Signed, 8, 1024, "MET_LONG_LONG", "longlong|long long|long long int|signed long long|signed long long int|int64|int64_t"),
    (Real, 4, 16, "MET_FLOAT", "float"),
    (Real, 8, 64, "MET_DOUBLE", "double"),
];

/// The type of the row that `is_so` admits, and its bytes.
pub(super) fn number_type(is_so: impl Fn(&TypeRow) -> bool) -> Option<(NumberType, usize)> {
    TYPES.iter().find(|row| is_so(row)).map(|(kind, size, ..)| (*kind, *size))
}

/// How an image stores its voxels, and where they are.
#[derive(Debug, Clone)]
pub(crate) struct Voxels {
    /// Lengths along the three axes; the first runs fastest.
    pub shape: [usize; 3],
    pub kind: NumberType,
    /// Bytes of a value.
    pub size: usize,
    pub big: bool,
    /// A value is this many times the stored number, plus the second.
    pub slope: [f64; 2],
    /// The frame, mm.
    pub affine: Affine,
    /// The scanner's frame where the file states which way its axes point.
    pub frame: Frame,
    /// Whether the file's array counts its axes from the one that varies slowest, as NumPy does.
    pub reversed: bool,
}

/// The voxels of a file whose header has been read, and their bytes.
pub(crate) type OpenedVoxels<'a> = Result<(Voxels, Box<dyn Read + 'a>), Fault>;
type Taken = Result<(), Fault>;

impl Voxels {
    /// How many bytes they take; a fault where that is more than `most`, or nothing.
    pub fn bytes(&self, most: u64) -> Result<u64, Fault> {
        let shape = self.shape;
        let words = format!("{} x {} x {} voxels of {} bytes", shape[0], shape[1], shape[2], self.size);
        ensure(!shape.contains(&0), || Fault::file(&*words, "expected an image with voxels"))?;
        let count = shape.iter().try_fold(self.size as u64, |all, n| all.checked_mul(*n as u64));
        let count = count.filter(|count| *count <= most);
        count.ok_or_else(|| Fault::file(words, format!("expected at most {most} bytes; `max_input` allows more")))
    }

    /// Reads an image: each voxel's value.
    pub fn read_values(self, mut bytes: impl Read, most: u64) -> Result<Image, Fault> {
        self.check_frame()?;
        let count = (self.bytes(most)? / self.size as u64) as usize;
        let mut values: Vec<f32> = Vec::new();
        let value = |stored: &[u8]| (self.slope[0] * self.kind.value(stored, self.big) + self.slope[1]) as f32;
        // The values that one byte can store.
        let of_byte: Option<Vec<f32>> = (self.size == 1).then(|| (0..=u8::MAX).map(|byte| value(&[byte])).collect());
        self.in_blocks(&mut bytes, count, most, |block| {
            // Memory grows with what was read, not with what a header claims, and never to twice of it.
            if values.capacity() < values.len() + BLOCK {
                values.reserve_exact((count - values.len()).min(GROWTH));
            }
            match &of_byte {
                Some(of_byte) => values.extend(block.iter().map(|byte| of_byte[usize::from(*byte)])),
                None => values.extend(block.chunks_exact(self.size).map(value)),
            }
            Ok(())
        })?;
        Ok(Image { shape: self.shape, values, affine: self.affine })
    }

    /// Hands over the stored values block by block, and reads on to the end, where packed files have the checksum of what was read.
    fn in_blocks(&self, bytes: &mut impl Read, count: usize, most: u64, mut take: impl FnMut(&[u8]) -> Taken) -> Taken {
        let mut block = Vec::with_capacity(BLOCK * self.size);
        let broken = |done: usize, error: io::Error| {
            Fault::file(format!("after {done} of {count} voxels: {error}"), "expected a whole file")
        };
        for done in (0..count).step_by(BLOCK) {
            block.clear();
            let wanted = (count - done).min(BLOCK) * self.size;
            let found = bytes.by_ref().take(wanted as u64).read_to_end(&mut block).map_err(|error| broken(done, error))?;
            let whole = done + found / self.size;
            let cut = || Fault::file(format!("{whole} of {count} voxels"), "expected all of them; is the file cut off?");
            ensure(found == wanted, cut)?;
            take(&block)?;
        }
        io::copy(&mut bytes.take(most), &mut io::sink()).map_err(|error| broken(count, error))?;
        Ok(())
    }

    /// Reads a mask: each voxel's class, or 1 from a level on.
    pub fn read(self, mut bytes: impl Read, level: Option<f64>, most: u64) -> Result<Mask, Fault> {
        self.check_frame()?;
        let count = (self.bytes(most)? / self.size as u64) as usize;
        let mut classes: Vec<u8> = Vec::new();
        let mut values = Classes::new(&self);
        let mut seen = [false; 256];
        // The bytes before and their class: most voxels are as the one before.
        let mut last: (Vec<u8>, u8) = (Vec::new(), 0);
        let mut walls = level.and_then(|_| WallFinder::new(self.shape));
        // Whether the values could be classes, and which then.
        let (mut are_classes, mut known) = (true, [false; 256]);
        self.in_blocks(&mut bytes, count, most, |block| {
            for stored in block.chunks_exact(self.size) {
                if walls.is_none() && last.0 == stored {
                    classes.push(last.1);
                    continue;
                }
                let value = self.slope[0] * self.kind.value(stored, self.big) + self.slope[1];
                let class = match level {
                    _ if value.is_nan() => {
                        return Err(Fault::item(self.place(classes.len()), "not a number", "expected a finite value"));
                    }
                    Some(level) => u8::from(value >= level),
                    None => values.class(value, classes.len()).map_err(|odd| self.no_class(odd))?,
                };
                seen[usize::from(class)] = true;
                classes.push(class);
                last.0.clear();
                last.0.extend_from_slice(stored);
                last.1 = class;
                if let Some(walls) = &mut walls {
                    walls.add(value);
                    if are_classes {
                        values.whole(value).map_or_else(|| are_classes = false, |class| known[usize::from(class)] = true);
                    }
                }
            }
            if let Some(walls) = &mut walls {
                walls.advance(&classes);
            }
            Ok(())
        })?;
        let count = |seen: &[bool]| seen[1..].iter().filter(|is| **is).count();
        let several = count(&seen);
        let wrong = || Fault::file(format!("looks like an image, not a mask: {several} values"), ACCEPTED);
        ensure(several <= MOST_CLASSES, wrong)?;
        let accepted = if level.is_some() { "expected a lower `level`" } else { "expected voxels of vessels, which are not 0" };
        ensure(several > 0, || Fault::file("an empty mask", accepted))?;
        // What would do as a mask has no partial volume.
        are_classes &= count(&known) <= MOST_CLASSES;
        let walls = walls.filter(|_| !are_classes).zip(level).and_then(|(walls, level)| walls.finish(level, &classes));
        let notes = values.finish().map_err(|odd| self.no_class(odd))?.into_iter().collect();
        Ok(Mask { walls, frame: self.frame, reversed: self.reversed, notes, ..Mask::new(self.shape, classes, self.affine) })
    }

    /// The place of a voxel, as the file counts its axes.
    fn place(&self, row: usize) -> String {
        let [a, b, c] = indices_of(self.shape, row);
        if self.reversed { format!("voxel {c},{b},{a}") } else { format!("voxel {a},{b},{c}") }
    }

    fn no_class(&self, odd: Odd) -> Fault {
        let value = in_few_digits(odd.value.to_string());
        Fault::item(self.place(odd.row), format!("{value}: looks like an image, not a mask"), ACCEPTED)
    }

    /// Refuses a frame that is flat, or not finite.
    fn check_frame(&self) -> Result<(), Fault> {
        let steps = steps_of(&self.affine);
        let lengths = steps.map(norm);
        let found = || format!("voxels of {} x {} x {} mm", lengths[0], lengths[1], lengths[2]);
        let wrong = || Fault::file(found(), "expected a positive spacing along every axis, and a finite origin");
        let is_positive = lengths.iter().all(|length| length.is_finite() && *length > 0.0);
        ensure(is_positive && self.affine.iter().flatten().all(|x| x.is_finite()), wrong)?;
        let is_flat = volume_of(steps) < 1e-6 * lengths.iter().product::<f64>();
        ensure(!is_flat, || Fault::file("axes that lie in a plane", "expected three independent directions"))
    }
}

/// Tells the classes of a mask from the values of an image.
///
/// Programs that work in real numbers write 1.00000006 for 1, or scale classes to whole steps of the largest over 255. A value that is
/// off by more is rounded where the values are few and no two of them are one class.
struct Classes {
    /// A value that is off a whole number by no more is that number.
    tolerance: f64,
    /// Which classes values without an oddity have.
    whole: [bool; 256],
    odd: Vec<Odd>,
}

/// A value that is no whole number, the first voxel that has it, and the class that it is taken as.
#[derive(Debug, Clone, Copy)]
struct Odd {
    value: f64,
    row: usize,
    class: u8,
}

impl Classes {
    fn new(voxels: &Voxels) -> Self {
        let is_scaled = voxels.kind != Real && voxels.slope[0] != 1.0;
        let step = if is_scaled { voxels.slope[0].abs() / 2.0 } else { 0.0 };
        Self { tolerance: step.clamp(LEAST_TOLERANCE, FAR_FROM_WHOLE), whole: [false; 256], odd: Vec::new() }
    }

    /// The class of a value that is near a whole number.
    fn whole(&self, value: f64) -> Option<u8> {
        let class = value.round();
        ((0.0..=255.0).contains(&class) && (value - class).abs() <= self.tolerance).then_some(class as u8)
    }

    /// The class of a value; the first one that cannot be a class, where that is certain.
    fn class(&mut self, value: f64, row: usize) -> Result<u8, Odd> {
        if let Some(class) = self.whole(value) {
            self.whole[usize::from(class)] = true;
            return Ok(class);
        }
        let odd = Odd { value, row, class: value.round() as u8 };
        let is_near = (value - value.round()).abs() < FAR_FROM_WHOLE;
        ensure(is_near && (0.0..=255.0).contains(&value.round()), || odd)?;
        if !self.odd.iter().any(|known| known.value == value) {
            ensure(self.odd.len() < MOST_CLASSES, || self.odd[0])?;
            self.odd.push(odd);
        }
        Ok(odd.class)
    }

    /// What a person should know about the values; an odd one that shares its class with another.
    fn finish(mut self) -> Result<Option<String>, Odd> {
        for odd in &self.odd {
            ensure(!std::mem::replace(&mut self.whole[usize::from(odd.class)], true), || *odd)?;
        }
        let said = |odd: &Odd| format!("classes are rounded: {} is taken as {}", odd.value, odd.class);
        Ok(self.odd.iter().max_by_key(|odd| odd.class).map(said))
    }
}
