//! Rows of a Fourier transform side by side: a number of [`LANES`] lanes, each of which is reckoned as a single one is.
//!
//! A transform that takes any type of number takes this one, and does with it what it does with `f32`, operation by
//! operation: the bits are those of one row after the other on any CPU, the instructions those of vectors.

use std::ops::{Add, Div, Mul, Neg, Rem, Sub};

use rustfft::num_traits::{FromPrimitive, Num, One, Signed, Zero};

/// Lanes of a number: what a vector register of any CPU of the time holds.
pub(super) const LANES: usize = 4;

/// One number for each of [`LANES`] rows or columns.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(16))]
pub(super) struct Lanes(pub(super) [f32; LANES]);

impl Lanes {
    /// The same number in all lanes.
    pub(super) fn of(number: f32) -> Self {
        Self([number; LANES])
    }

    /// A function of each lane.
    #[inline(always)]
    pub(super) fn map(self, function: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(function))
    }

    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|lane| function(self.0[lane], other.0[lane])))
    }
}

macro_rules! lane_by_lane {
    ($($operation:ident $method:ident),*) => {$(
        impl $operation for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, f32::$method)
            }
        }
    )*};
}

lane_by_lane!(Add add, Sub sub, Mul mul, Div div, Rem rem);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(f32::neg)
    }
}

impl Zero for Lanes {
    fn zero() -> Self {
        Self::of(0.0)
    }
    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl One for Lanes {
    fn one() -> Self {
        Self::of(1.0)
    }
}

impl Num for Lanes {
    type FromStrRadixErr = <f32 as Num>::FromStrRadixErr;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f32::from_str_radix(text, radix).map(Self::of)
    }
}

impl Signed for Lanes {
    fn abs(&self) -> Self {
        self.map(f32::abs)
    }
    fn abs_sub(&self, other: &Self) -> Self {
        self.zip(*other, |a, b| (a - b).max(0.0))
    }
    fn signum(&self) -> Self {
        self.map(f32::signum)
    }
    fn is_positive(&self) -> bool {
        self.0.iter().all(|n| n.is_positive())
    }
    fn is_negative(&self) -> bool {
        self.0.iter().all(|n| n.is_negative())
    }
}

impl FromPrimitive for Lanes {
    fn from_i64(n: i64) -> Option<Self> {
        Some(Self::of(n as f32))
    }
    fn from_u64(n: u64) -> Option<Self> {
        Some(Self::of(n as f32))
    }
    fn from_f64(n: f64) -> Option<Self> {
        Some(Self::of(n as f32))
    }
}

#[cfg(test)]
mod tests {
    use base::Stream;
    use rustfft::FftPlannerScalar;
    use rustfft::num_complex::Complex;

    use super::*;

    /// A transform of lanes is the transform of each, bit by bit, at lengths of all kinds: powers, products, primes.
    #[test]
    fn lanes_are_transformed_as_single_numbers_are() {
        let stream = Stream::root(5);
        for length in [4, 128, 512, 768, 1000, 1536, 3072, 12, 1031, 2018] {
            let number = |lane: usize, i: usize, part: u64| {
                let own = stream.child("number").key() ^ (part << 40 | (lane as u64) << 20 | i as u64);
                (base::mix(own) >> 40) as f32 / 16_777_216.0 - 0.5
            };
            let single = |lane: usize| {
                let mut row: Vec<Complex<f32>> =
                    (0..length).map(|i| Complex::new(number(lane, i, 0), number(lane, i, 1))).collect();
                FftPlannerScalar::new().plan_fft_forward(length).process(&mut row);
                row
            };
            let part = |i: usize, part: u64| Lanes(std::array::from_fn(|lane| number(lane, i, part)));
            let mut together: Vec<Complex<Lanes>> = (0..length).map(|i| Complex::new(part(i, 0), part(i, 1))).collect();
            FftPlannerScalar::new().plan_fft_forward(length).process(&mut together);
            for lane in 0..LANES {
                for (i, (one, all)) in single(lane).iter().zip(&together).enumerate() {
                    let found = [all.re.0[lane], all.im.0[lane]].map(f32::to_bits);
                    assert_eq!(found, [one.re, one.im].map(f32::to_bits), "length {length}, lane {lane}, number {i}");
                }
            }
        }
    }
}
