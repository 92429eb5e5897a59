//! Available memory, asked for before work that needs it.

use crate::failure::BadInput;

/// Bytes of a pixel: five layers of a frame, its rows and what the writers take.
const PIXEL: u64 = 96;

/// Address space of a buffer of the linear algebra library, one for each thread that calls it.
const BUFFER: u64 = 128 << 20;

/// Address space that training takes beside those buffers, at least.
const TRAINING: u64 = 256 << 20;

/// Refuses a frame that does not fit into memory.
pub fn check_frame(width: u32, height: u32) -> Result<(), BadInput> {
    let needed = u64::from(width) * u64::from(height) * PIXEL;
    match available() {
        Some(there) if needed > there => Err(BadInput(format!(
            "--size {width}x{height}: the frame needs about {} MiB of memory, {} MiB are there; \
             give a smaller size",
            needed >> 20,
            there >> 20
        ))),
        _ => Ok(()),
    }
}

/// Refuses a transfer whose rows do not fit into memory.
pub fn check_transfer(rows: usize, needed: u64) -> Result<(), BadInput> {
    match available() {
        Some(there) if needed > there => Err(BadInput(format!(
            "--rows {rows}: they need about {} MiB of memory in a transfer, {} MiB are there; give fewer",
            needed >> 20,
            there >> 20
        ))),
        _ => Ok(()),
    }
}

/// Refuses to train where the process may not have the memory that it takes at least, and takes the
/// buffers of the linear algebra library where a limit could come in its way: it asks for one until it gets
/// it, for ever. What it was given once it keeps.
pub fn check_solver() -> Result<(), BadInput> {
    let Some(there) = address_space() else {
        return Ok(());
    };
    let threads = rayon::current_num_threads();
    let needed = threads as u64 * BUFFER + TRAINING;
    if there < needed {
        return Err(BadInput(format!(
            "the address space left to this process is {} MiB (ulimit -v); training with --threads {threads} \
             needs {} MiB; raise the limit or give fewer threads",
            there >> 20,
            needed >> 20
        )));
    }
    #[cfg(unix)]
    take_buffers(threads);
    Ok(())
}

/// Has OpenBLAS map a buffer for each thread; another library, which has no such function, is left alone.
#[cfg(unix)]
fn take_buffers(threads: usize) {
    use std::ffi::{c_int, c_void};
    type Take = unsafe extern "C" fn(c_int) -> *mut c_void;
    type Free = unsafe extern "C" fn(*mut c_void);
    // SAFETY: the names are valid strings; the types are those of OpenBLAS's `common.h`; each buffer is
    // given back once.
    unsafe {
        let take = libc::dlsym(libc::RTLD_DEFAULT, c"blas_memory_alloc".as_ptr());
        let free = libc::dlsym(libc::RTLD_DEFAULT, c"blas_memory_free".as_ptr());
        if take.is_null() || free.is_null() {
            return;
        }
        let take = std::mem::transmute::<*mut c_void, Take>(take);
        let free = std::mem::transmute::<*mut c_void, Free>(free);
        let buffers: Vec<_> = (0..threads).map(|_| take(0)).collect();
        buffers.into_iter().for_each(|buffer| free(buffer));
    }
}

/// Starts the program anew where its address space is limited and the linear algebra library has threads
/// of its own: each asks for a buffer until it gets one, and without one the program never ends. We use
/// one thread of it, and with one it asks for no more than it gets.
pub fn start_within_limits() {
    const THREADS: &str = "OPENBLAS_NUM_THREADS";
    #[cfg(unix)]
    if address_limit().is_some() && std::env::var_os(THREADS).is_none_or(|n| n != "1") {
        use std::os::unix::process::CommandExt;
        if let Ok(program) = std::env::current_exe() {
            let words = std::env::args_os().skip(1);
            // comes back only where it fails, and the program goes on as it is
            let _ = std::process::Command::new(program)
                .args(words)
                .env(THREADS, "1")
                .exec();
        }
    }
}

/// Makes the allocator give memory back where a bound is to be kept. By default it keeps what was freed
/// in a heap for each thread, and large blocks too once one was freed: how much depends on which
/// threads happened to work at a time.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const LARGE: std::ffi::c_int = 128 << 10;
        // SAFETY: sets numbers of the C library's allocator.
        unsafe {
            libc::mallopt(libc::M_ARENA_MAX, 1);
            libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE);
            libc::mallopt(libc::M_TRIM_THRESHOLD, LARGE);
        }
    }
}

/// Bytes that this process may still take; none where nothing says so.
fn available() -> Option<u64> {
    let free = status("/proc/meminfo", "MemAvailable:");
    [free, address_space()].into_iter().flatten().min()
}

/// Bytes of address space left below the limit of `ulimit -v`; none without such a limit.
pub fn address_space() -> Option<u64> {
    let limit = address_limit()?;
    let taken = status("/proc/self/status", "VmSize:").unwrap_or(0);
    Some(limit.saturating_sub(taken))
}

#[cfg(unix)]
fn address_limit() -> Option<u64> {
    let mut limit = libc::rlimit {
        rlim_cur: 0,
        rlim_max: 0,
    };
    // SAFETY: the pointer is to a value of the type that the call fills.
    let result = unsafe { libc::getrlimit(libc::RLIMIT_AS, &raw mut limit) };
    (result == 0 && limit.rlim_cur != libc::RLIM_INFINITY).then_some(limit.rlim_cur)
}

#[cfg(not(unix))]
fn address_limit() -> Option<u64> {
    None
}

/// A line `NAME: N kB` of a file of Linux, in bytes.
fn status(file: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let number: u64 = line.split_whitespace().next()?.parse().ok()?;
    number.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_frames_fit_and_enormous_ones_do_not() {
        assert!(check_frame(64, 64).is_ok());
        if available().is_some() {
            assert!(check_frame(u32::MAX, u32::MAX).is_err());
        }
    }
}
