//! Whose turn it is: the newest request of each page is worked at first, and what it makes needless is dropped.
//!
//! What one waits for (a region, a frame) goes in front: it has threads of its own, and what is worked out behind (the
//! whole scan, the rig, other samples) rests meanwhile. A page numbers its states (`turn`) and what it looks at
//! (`look`); work of an older number stops between two bands of profiles.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use serde::Deserialize;

/// Pages that are remembered.
const MAX_PAGES: usize = 64;
/// How long work behind rests before it looks again.
const REST: Duration = Duration::from_millis(2);

/// Which request of which page it is.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct PageTurn {
    /// The page.
    pub page: String,
    /// Number of the recipe and sample that it shows.
    pub turn: u64,
    /// Number of what it looks at.
    #[serde(default)]
    pub look: u64,
}

/// The newest numbers of a page.
#[derive(Debug, Default, Clone, Copy)]
struct NewestTurn {
    turn: u64,
    look: u64,
    asked: u64,
}

/// Threads, and what is newest.
#[derive(Debug)]
pub(super) struct Turns {
    pages: Mutex<BTreeMap<String, NewestTurn>>,
    in_front: AtomicUsize,
    front: (Mutex<()>, ThreadPool),
    behind: (Mutex<()>, ThreadPool),
}

/// Counts work in front for as long as it lives.
struct InFront<'t>(&'t AtomicUsize);

impl Drop for InFront<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Turns {
    /// With so many threads in front and behind.
    pub fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let pool = || Ok((Mutex::new(()), ThreadPoolBuilder::new().num_threads(threads).build()?));
        Ok(Self { pages: Mutex::default(), in_front: AtomicUsize::new(0), front: pool()?, behind: pool()? })
    }

    /// Notes what a page shows now; older work of it ends.
    pub fn note(&self, asked: &PageTurn) {
        let mut pages = locked(&self.pages);
        let last = pages.values().map(|page| page.asked).max().unwrap_or(0);
        let page = pages.entry(asked.page.clone()).or_default();
        *page = NewestTurn { turn: page.turn.max(asked.turn), look: page.look.max(asked.look), asked: last + 1 };
        if pages.len() > MAX_PAGES
            && let Some(oldest) = pages.iter().min_by_key(|(_, page)| page.asked).map(|(name, _)| name.clone())
        {
            pages.remove(&oldest);
        }
    }

    /// Whether a page has gone on to another recipe or sample.
    fn is_past(&self, asked: &PageTurn) -> bool {
        locked(&self.pages).get(&asked.page).is_some_and(|page| page.turn > asked.turn)
    }

    /// Whether it looks elsewhere, too.
    fn is_passed_by(&self, asked: &PageTurn) -> bool {
        let newer = |page: &NewestTurn| page.turn > asked.turn || page.look > asked.look;
        locked(&self.pages).get(&asked.page).is_some_and(newer)
    }

    /// Works at what somebody waits for; `work` is told when to stop. `None` where it was stopped.
    pub fn in_front<T: Send>(
        &self,
        asked: &PageTurn,
        work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> Option<T> + Send,
    ) -> Option<T> {
        self.note(asked);
        self.in_front.fetch_add(1, Ordering::Relaxed);
        let _counted = InFront(&self.in_front);
        let _alone = locked(&self.front.0);
        let is_stopped = || self.is_passed_by(asked);
        if is_stopped() { None } else { self.front.1.install(|| work(&is_stopped)) }
    }

    /// The same behind: `work` rests whenever it asks while something is in front.
    pub fn behind<T: Send>(
        &self,
        asked: &PageTurn,
        work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> Option<T> + Send,
    ) -> Option<T> {
        self.note(asked);
        let _alone = locked(&self.behind.0);
        let is_stopped = || {
            while self.in_front.load(Ordering::Relaxed) > 0 && !self.is_past(asked) {
                std::thread::sleep(REST);
            }
            self.is_past(asked)
        };
        if is_stopped() { None } else { self.behind.1.install(|| work(&is_stopped)) }
    }
}

/// What a mutex holds, whatever became of others who held it.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(page: &str, turn: u64, look: u64) -> PageTurn {
        PageTurn { page: page.into(), turn, look }
    }

    /// A newer state stops all of a page's work, a newer look what is in front alone, and other pages neither.
    #[test]
    fn newer_requests_stop_older_ones() {
        let turns = Turns::new(1).expect("threads start");
        let stopped_by = |newer: &PageTurn| {
            let old = asked("a", 1, 1);
            let told = |is_stopped: &(dyn Fn() -> bool + Sync)| {
                let before = is_stopped();
                turns.note(newer);
                Some((before, is_stopped()))
            };
            let all = [turns.in_front(&old, told), turns.behind(&old, told)];
            locked(&turns.pages).clear();
            all
        };
        assert_eq!(stopped_by(&asked("a", 2, 1)), [Some((false, true)), None]);
        assert_eq!(stopped_by(&asked("a", 1, 2)), [Some((false, true)), Some((false, false))]);
        assert_eq!(stopped_by(&asked("b", 9, 9)), [Some((false, false)), Some((false, false))]);
        turns.note(&asked("a", 5, 0));
        assert_eq!(turns.behind(&asked("a", 4, 0), |_| Some(())), None, "what is old is not begun");
        assert_eq!(turns.behind(&asked("a", 5, 0), |_| Some(())), Some(()));
    }

    /// What is behind rests while something is in front.
    #[test]
    fn work_behind_rests() {
        let turns = Turns::new(1).expect("threads start");
        let (begun, finished) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                turns.in_front(&asked("a", 0, 0), |_| {
                    begun.store(1, Ordering::SeqCst);
                    std::thread::sleep(Duration::from_millis(50));
                    finished.store(1, Ordering::SeqCst);
                    Some(())
                })
            });
            while begun.load(Ordering::SeqCst) == 0 {
                std::thread::yield_now();
            }
            let seen = turns.behind(&asked("b", 0, 0), |_| Some(finished.load(Ordering::SeqCst)));
            assert_eq!(seen, Some(1));
        });
    }

    #[test]
    fn few_pages_are_remembered() {
        let turns = Turns::new(1).expect("threads start");
        (0..1000).for_each(|number| turns.note(&asked(&number.to_string(), 0, 0)));
        assert_eq!(locked(&turns.pages).len(), MAX_PAGES);
        assert!(locked(&turns.pages).contains_key("999"));
    }
}
