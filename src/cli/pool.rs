//! The threads that a command computes with.
//!
//! `RAYON_NUM_THREADS` says how many; by default there are as many as cores. Results have the same bits for any number.

use super::console::warn;
use crate::error::Error;
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use std::io;

/// As many threads as may be asked for on any machine; more than cores are of no use, and slow down each other.
const MOST: usize = 64;

/// Stack of a thread, bytes: that of a main thread.
const STACK: usize = 8 << 20;

/// How many threads are asked for, as far as that is sensible; 0: as many as cores.
fn wanted() -> usize {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.trim().parse::<usize>().ok());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    asked.unwrap_or(0).min(cores.max(MOST))
}

/// Does `work` with as many threads as are wanted, or with one if the system starts no more.
///
/// # Errors
/// [`Error::Threads`] if not even that is possible.
pub(super) fn within<T: Send>(work: impl FnOnce() -> T + Send) -> crate::Result<T> {
    Ok(pool(wanted(), start)?.install(work))
}

fn start(thread: ThreadBuilder) -> io::Result<()> {
    let builder = std::thread::Builder::new().stack_size(STACK);
    builder.spawn(|| thread.run()).map(drop)
}

fn pool(threads: usize, start: fn(ThreadBuilder) -> io::Result<()>) -> crate::Result<ThreadPool> {
    let many = ThreadPoolBuilder::new().num_threads(threads).spawn_handler(start).build();
    many.or_else(|error| {
        warn(&format!(
            "warning: threads cannot be started ({error}): computing with one; raise the limit of processes (ulimit -u), or set \
             RAYON_NUM_THREADS to fewer"
        ));
        ThreadPoolBuilder::new().num_threads(1).use_current_thread().build()
    })
    .map_err(|error| Error::Threads(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn where_no_thread_starts_one_does_the_work() {
        let none = |_| Err(io::Error::from(io::ErrorKind::WouldBlock));
        for (start, threads) in [(none as fn(ThreadBuilder) -> io::Result<()>, 1), (start, 3)] {
            let sum = |pool: &ThreadPool| pool.install(|| (0..100_u32).into_par_iter().sum::<u32>());
            // A thread of its own: one that becomes a pool stays one.
            let (found, sum) = std::thread::spawn(move || {
                let pool = pool(3, start).unwrap();
                (pool.current_num_threads(), sum(&pool))
            })
            .join()
            .unwrap();
            assert_eq!((found, sum), (threads, 4950));
        }
    }
}
