//! Random streams keyed by meaning (seed / sample / name / index), never by call order.
//!
//! A `Stream` is a 64-bit key. Children are derived by hashing a name or an index into it, so adding a draw somewhere
//! leaves every other stream as it was. The hash is splitmix64's finaliser (Steele, Lea, Flood 2014) over FNV-1a
//! (Fowler, Noll, Vo); the generator behind a key is xoshiro256++ (Blackman, Vigna 2019), whose output is portable.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// A key from which independent streams are derived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stream(u64);

impl Stream {
    /// The root of everything drawn for one seed; seed 0 is a seed like any other.
    pub fn root(seed: u64) -> Self {
        Self(mix(seed ^ 0x5368_6565_746c_6974))
    }

    /// The child stream called `name`.
    pub fn child(self, name: &str) -> Self {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for byte in name.bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        Self(mix(self.0 ^ mix(hash)))
    }

    /// The child stream number `index`.
    pub fn index(self, index: u64) -> Self {
        Self(mix(self.0.wrapping_add(mix(index.wrapping_add(0x9e37_79b9_7f4a_7c15)))))
    }

    /// The key itself, for counter-based noise.
    pub fn key(self) -> u64 {
        self.0
    }

    /// A portable generator that starts at this key.
    pub fn rng(self) -> Xoshiro256PlusPlus {
        Xoshiro256PlusPlus::seed_from_u64(self.0)
    }
}

/// splitmix64's finaliser: a bijection of 64-bit words in which every input bit moves every output bit.
pub fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn values_are_stable() {
        let stream = Stream::root(0).child("laser.power_mw").index(3);
        assert_eq!(stream, Stream::root(0).child("laser.power_mw").index(3));
        assert_eq!(stream.rng().next_u64(), stream.rng().next_u64());
    }

    #[test]
    fn neighbours_differ_in_half_their_bits() {
        let root = Stream::root(7);
        let flips: u32 = (0..4096).map(|i| (root.index(i).key() ^ root.index(i + 1).key()).count_ones()).sum();
        let mean = f64::from(flips) / 4096.0;
        // 64 fair bits, 4096 words: mean 32, standard error 4/64 = 0.0625.
        assert!((mean - 32.0).abs() < 4.0 * 0.0625, "mean flips {mean}");
    }
}
