//! Blooming: charge above the full well flows to the neighbours along the column.
//!
//! Of what is above the full well a share flows on, half of it up and half down, and fills the room of the pixels that
//! it meets until it is used up; the rest goes down the drain. Phenomenology of an anti-blooming drain that is too weak
//! (Janesick 2001); a pixel that overflows still reads full. Charge that flows on makes photon noise where it arrives.
//! What leaves the window of the line is lost.

use crate::optics::light::ROWS;
use crate::optics::speckle::TILE;
use crate::optics::window::WindowSignal;

impl WindowSignal {
    /// Lets `share` of what is above `full` flow on.
    pub(crate) fn bloom(&mut self, full: f32, share: f32) {
        let over: Vec<[f32; TILE]> =
            self.level.iter().map(|row| row.map(|v| 0.5 * share * (v - full).max(0.0))).collect();
        for c in 0..TILE {
            if over.iter().any(|row| row[c] > 0.0) {
                self.flow(&over, full, c, 0..ROWS);
                self.flow(&over, full, c, (0..ROWS).rev());
            }
        }
    }

    fn flow(&mut self, over: &[[f32; TILE]], full: f32, c: usize, rows: impl Iterator<Item = usize>) {
        let mut carried = 0.0f32;
        for k in rows {
            let taken = carried.min((full - self.level[k][c]).max(0.0));
            self.level[k][c] += taken;
            self.noisy[k][c] += taken;
            carried += over[k][c] - taken;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What pixels gain is the share of what lies above the full well, as long as it stays in the window, and it fills
    /// the nearest room on both sides alike.
    #[test]
    fn overflowing_charge_is_kept_and_fills_the_neighbours() {
        let full = 240.0f32;
        let light = |k: usize| 1200.0 * (-0.5 * ((k as f32 - 21.3) / 1.4).powi(2)).exp();
        for share in [0.0f32, 0.1, 0.5, 1.0] {
            let mut signal = WindowSignal::default();
            for k in 0..ROWS {
                signal.level[k] = [light(k); TILE];
                signal.noisy[k] = [light(k); TILE];
            }
            signal.bloom(full, share);
            let held = |level: f32| f64::from(level.min(full));
            let before: f64 = (0..ROWS).map(|k| held(light(k))).sum();
            let after: f64 = (0..ROWS).map(|k| held(signal.level[k][5])).sum();
            let over: f64 = (0..ROWS).map(|k| f64::from((light(k) - full).max(0.0))).sum();
            assert!(
                (after - before - f64::from(share) * over).abs() < 1e-3 * over,
                "{share}: {before} to {after} of {over}"
            );
            let noisy: f64 = (0..ROWS).map(|k| f64::from(signal.noisy[k][5] - light(k))).sum();
            assert!((noisy - f64::from(share) * over).abs() < 1e-3 * over, "noise of {noisy}");
            let full_rows: Vec<usize> = (0..ROWS).filter(|&k| signal.level[k][5] >= full).collect();
            let (first, last) = (full_rows[0], full_rows[full_rows.len() - 1]);
            assert_eq!(full_rows.len(), last - first + 1, "full pixels are together");
            if share == 1.0 {
                let sides = [21.3 - first as f32, last as f32 - 21.3];
                assert!((sides[0] - sides[1]).abs() <= 1.5 && sides[0] > 4.0, "{first} to {last}");
            }
        }
    }

    /// Columns that are not full stay as they are.
    #[test]
    fn columns_with_room_stay() {
        let mut signal = WindowSignal::default();
        (signal.level[20][3], signal.level[20][4]) = (500.0, 100.0);
        signal.bloom(240.0, 1.0);
        assert_eq!((signal.level[20][4], signal.level[19][4], signal.level[21][3]), (100.0, 0.0, 130.0));
    }
}
