//! The OpenBLAS library behind LAPACK: its threads and the kernels that it computes with.

use std::ffi::{CStr, c_char, c_int};
use std::sync::Once;

unsafe extern "C" {
    fn openblas_set_num_threads(threads: c_int);
    fn openblas_get_config() -> *const c_char;
    fn openblas_get_corename() -> *const c_char;
}

/// The linear algebra library, its version, and the kernels that it uses: the last bits of a fit depend on
/// them.
pub fn linear_algebra() -> String {
    // SAFETY: a plain getter of the library.
    let config = text(unsafe { openblas_get_config() });
    let name = config.split_whitespace().take(2).collect::<Vec<_>>();
    format!("{}, {} kernels", name.join(" "), core_name())
}

/// Tells OpenBLAS to use one thread: callers solve many small problems in parallel, and its own threads
/// would contend with them and make bits depend on their number.
pub fn one_thread() {
    static ONCE: Once = Once::new();
    // SAFETY: a plain setter of the library.
    ONCE.call_once(|| unsafe { openblas_set_num_threads(1) });
}

/// Makes OpenBLAS use its Haswell kernels where the processor has AVX2 and FMA, so that fits have the same
/// bytes on all such processors, whatever `OPENBLAS_CORETYPE` in the environment says. Other processors, and
/// builds of the library for one processor alone, keep what they have; [`linear_algebra`] tells.
///
/// # Safety
/// No other thread may use the library or the environment meanwhile: to be called first in a program.
pub unsafe fn fix_kernels() {
    #[cfg(all(unix, target_arch = "x86_64"))]
    if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
        // SAFETY: the caller's promise.
        unsafe { choose(KERNELS) };
    }
}

/// Kernels that every processor with AVX2 and FMA can run.
#[cfg(all(unix, target_arch = "x86_64"))]
const KERNELS: &str = "Haswell";

/// Lets the library choose anew, with a name in the environment. It chooses when it is loaded, before `main`.
///
/// # Safety
/// That of [`fix_kernels`], and the processor has to have what the kernels use.
#[cfg(all(unix, target_arch = "x86_64"))]
unsafe fn choose(kernels: &str) {
    const NAME: &str = "OPENBLAS_CORETYPE";
    if core_name() == kernels {
        return;
    }
    // only builds for many processors have them
    let symbol = |name: &CStr| {
        // SAFETY: the name ends with a zero byte.
        let address = unsafe { libc::dlsym(libc::RTLD_DEFAULT, name.as_ptr()) };
        // SAFETY: both are functions without arguments and results, or null.
        unsafe { std::mem::transmute::<*mut libc::c_void, Option<extern "C" fn()>>(address) }
    };
    let (quit, init) = (
        symbol(c"gotoblas_dynamic_quit"),
        symbol(c"gotoblas_dynamic_init"),
    );
    if let (Some(quit), Some(init)) = (quit, init) {
        let own = std::env::var_os(NAME);
        // SAFETY: no other thread reads or writes the environment, by the caller's promise.
        unsafe { std::env::set_var(NAME, kernels) };
        quit();
        init();
        match own {
            // SAFETY: as above.
            Some(own) => unsafe { std::env::set_var(NAME, own) },
            // SAFETY: as above.
            None => unsafe { std::env::remove_var(NAME) },
        }
    }
}

fn core_name() -> String {
    // SAFETY: a plain getter of the library.
    text(unsafe { openblas_get_corename() })
}

fn text(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: not null; the library's texts end with a zero byte and live as long as the process.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_string_lossy().into_owned()
}
