//! Time that is left of a work, from the time that parts of it took.
//!
//! Threads work side by side, so the first part comes when all of them are as far: after one of four threads' parts,
//! four are nearly done. The start (tables, patterns of speckle, files that are opened) comes once. Time is therefore
//! counted from the moment at which each thread can have handed in a part, in whole rounds of all threads, and nothing
//! is said before the second round.

use std::time::Duration;

/// Takes parts as they are done.
#[derive(Debug, Clone)]
pub(super) struct RemainingTime {
    threads: u64,
    parts: u64,
    /// When each thread can have handed in a part, and the work that was done then.
    start: Option<(Duration, u64)>,
    /// The same of the last whole round.
    round: (Duration, u64),
    /// When the last part came.
    last: Duration,
}

impl RemainingTime {
    /// For work of so many threads.
    pub(super) fn new(threads: usize) -> Self {
        Self { threads: threads.max(1) as u64, parts: 0, start: None, round: (Duration::ZERO, 0), last: Duration::ZERO }
    }

    /// A part is done: time since the beginning, and all work that is done.
    pub(super) fn part(&mut self, elapsed: Duration, done: u64) {
        self.parts += 1;
        self.last = elapsed;
        if self.parts.is_multiple_of(self.threads) {
            self.round = (elapsed, done);
            self.start.get_or_insert(self.round);
        }
    }

    /// Work that is done in a second, the start left out; `None` while too little is known.
    pub(super) fn rate(&self) -> Option<f64> {
        let ((from, before), (to, done)) = (self.start?, self.round);
        (done > before && to > from).then(|| (done - before) as f64 / (to - from).as_secs_f64())
    }

    /// Time that is left until `total` is done; `None` while too little is known.
    pub(super) fn left(&self, total: u64) -> Option<Duration> {
        let (to, done) = self.round;
        let left = Duration::try_from_secs_f64(total.saturating_sub(done) as f64 / self.rate()?).ok()?;
        Some(left.saturating_sub(self.last - to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parts of 10, each of a second, by some threads after a start of five seconds: from its first word on the
    /// estimate is within a fifth of what it really takes, whether the threads keep step or not.
    #[test]
    fn the_first_estimate_is_right() {
        for (threads, shift) in [(1, 0.0), (4, 0.0), (4, 0.25), (16, 0.01)] {
            let mut parts: Vec<f64> = (0..threads)
                .flat_map(|thread| (1..=20).map(move |part| 5.0 + f64::from(part) + shift * f64::from(thread)))
                .collect();
            parts.sort_by(f64::total_cmp);
            let (end, total) = (parts[parts.len() - 1], 10 * parts.len() as u64);
            let mut time = RemainingTime::new(threads as usize);
            let mut told = 0;
            for (count, at) in parts.iter().enumerate() {
                time.part(Duration::from_secs_f64(*at), 10 * (count as u64 + 1));
                let Some(left) = time.left(total) else { continue };
                told += 1;
                // Whole steps can't be told from parts of them: one second beside the share.
                let error = (left.as_secs_f64() - (end - at)).abs();
                assert!(error <= 1.0 + 0.2 * (end - at), "{threads} threads, part {count}: {left:?}, not {}", end - at);
            }
            assert!(told > parts.len() / 2, "{threads} threads: {told} of {}", parts.len());
        }
    }

    #[test]
    fn nothing_is_said_before_something_is_known() {
        let mut time = RemainingTime::new(2);
        assert_eq!(time.left(10), None);
        for part in 1..=3 {
            time.part(Duration::from_secs(part), part);
            assert_eq!(time.left(10), None);
        }
        time.part(Duration::from_secs(4), 4);
        assert_eq!(time.left(10), Some(Duration::from_secs(6)));
        time.part(Duration::from_secs(10), 10);
        assert_eq!(time.left(10), Some(Duration::ZERO));
    }
}
