//! Work on many things, as much of it at once as there are cores.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Stack of a worker, bytes: what a program's main thread has.
const STACK_BYTES: usize = 8 << 20;

/// What `work` gives of each of `items`, in their order, about as many of them at once as rayon has threads.
///
/// A worker does one item after another in a pool of its own, so that none begins an item while it waits within
/// another. The cores are shared out among the workers; a `work` that is independent of the number of threads gives
/// what it gives one by one.
pub fn at_once<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let cores = rayon::current_num_threads();
    let workers = cores.min(items.len());
    let next = AtomicUsize::new(0);
    let worker = || {
        let threads = cores / workers;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK_BYTES).build();
        let mut done = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(k) else { return done };
            // Without threads of its own it shares those of all.
            let result = pool.as_ref().map_or_else(|_| work(item), |pool| pool.install(|| work(item)));
            done.push((k, result));
        }
    };
    let mut results: Vec<(usize, R)> = thread::scope(|scope| {
        let running: Vec<_> = (0..workers).map(|_| scope.spawn(worker)).collect();
        running.into_iter().flat_map(|w| w.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    });
    results.sort_unstable_by_key(|(k, _)| *k);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_their_items() {
        let items: Vec<usize> = (0..57).collect();
        assert_eq!(at_once(&items, |k| k * k), items.iter().map(|k| k * k).collect::<Vec<_>>());
        assert_eq!(at_once(&[] as &[usize], |k| k * k), [] as [usize; 0]);
    }
}
