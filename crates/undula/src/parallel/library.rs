//! Libraries that are loaded while the program runs: it is linked to none of them, and starts without them.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_void};
#[cfg(unix)]
use std::ffi::{CString, c_int};
#[cfg(unix)]
use std::fs::File;
#[cfg(unix)]
use std::io::Read;
use std::ptr::null_mut;

/// An object of a library: a pointer, or a number in its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Object(*mut c_void);

// SAFETY: a handle; those who call with it see to it that one thread at a time does.
unsafe impl Send for Object {}

impl Object {
    /// No object.
    pub(crate) const NONE: Object = Object(null_mut());

    /// A handle that is a number.
    pub(crate) fn of_number(number: usize) -> Object {
        Object(number as *mut c_void)
    }
}

/// A library that is loaded, for the rest of the process.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Library(*mut c_void);

// SAFETY: a handle that any thread may look symbols up with.
unsafe impl Send for Library {}
// SAFETY: as above.
unsafe impl Sync for Library {}

#[cfg(unix)]
unsafe extern "C" {
    fn dlopen(name: *const c_char, flags: c_int) -> *mut c_void;
    fn dlsym(library: *mut c_void, symbol: *const c_char) -> *mut c_void;
    fn dlerror() -> *const c_char;
}

/// All symbols at once, and known to libraries that are loaded later, which the parts of Open MPI need.
#[cfg(unix)]
const NOW_GLOBAL: c_int = if cfg!(target_os = "macos") { 0x2 | 0x8 } else { 0x2 | 0x100 };

impl Library {
    /// Loads the library of this name or path.
    ///
    /// # Errors
    /// What the system says.
    #[cfg(unix)]
    pub(crate) fn open(name: &str) -> Result<Library, String> {
        if name.contains('/') && is_cut_off(name) {
            return Err(format!("{name}: the file is shorter than its header says"));
        }
        let Ok(text) = CString::new(name) else { return Err(format!("{name:?}: a name has no zero byte")) };
        // SAFETY: a string that ends with zero; what a library does when it is loaded is trusted, as in any program that
        // is linked to it.
        let handle = unsafe { dlopen(text.as_ptr(), NOW_GLOBAL) };
        if handle.is_null() {
            // SAFETY: the text lives until the next call of these functions on this thread.
            Err(unsafe { text_of(dlerror()) })
        } else {
            Ok(Library(handle))
        }
    }

    /// Loads nothing.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(unix))]
    pub(crate) fn open(name: &str) -> Result<Library, String> {
        Err(format!("{name}: libraries are loaded at run time on Unix systems only"))
    }

    /// Where a symbol of the library, or of one that it needs, is.
    #[cfg(unix)]
    pub(crate) fn find(self, symbol: &str) -> Option<*mut c_void> {
        let symbol = CString::new(symbol).ok()?;
        // SAFETY: the library is never closed; a string that ends with zero.
        let at = unsafe { dlsym(self.0, symbol.as_ptr()) };
        (!at.is_null()).then_some(at)
    }

    /// Nothing is loaded.
    #[cfg(not(unix))]
    pub(crate) fn find(self, _symbol: &str) -> Option<*mut c_void> {
        None
    }

    /// A variable whose address is a handle.
    pub(crate) fn address(self, symbol: &str) -> Option<Object> {
        self.find(symbol).map(Object)
    }

    /// A variable that holds a handle; `narrow` where that has 32 bits.
    ///
    /// # Safety
    /// The variable of this name is of that kind.
    pub(crate) unsafe fn read(self, symbol: &str, narrow: bool) -> Option<Object> {
        let at = self.find(symbol)?;
        // SAFETY: see above.
        Some(unsafe { if narrow { Object::of_number(*at.cast::<u32>() as usize) } else { *at.cast() } })
    }

    /// Whether the library, or one that it needs, has this symbol.
    pub(crate) fn has(self, symbol: &str) -> bool {
        self.find(symbol).is_some()
    }

    /// Whether both have the same `symbol`.
    pub(crate) fn shares(self, other: Library, symbol: &str) -> bool {
        self.find(symbol) == other.find(symbol)
    }
}

/// Whether a file of a library is shorter than it should be, as after a copy that was broken off: the system would end
/// the process while it loads it.
#[cfg(unix)]
fn is_cut_off(path: &str) -> bool {
    let Ok(mut file) = File::open(path) else { return false };
    let mut head = [0; 64];
    let (Ok(()), Ok(data)) = (file.read_exact(&mut head), file.metadata()) else { return false };
    // ELF of 64 bits, little-endian: the table of its sections is the last of the file.
    if !head.starts_with(b"\x7fELF\x02\x01") {
        return false;
    }
    let number = |at: usize, bytes: usize| {
        head[at..at + bytes].iter().rev().fold(0u64, |number, byte| number << 8 | u64::from(*byte))
    };
    let table = number(0x28, 8).saturating_add(number(0x3a, 2) * number(0x3c, 2));
    table > data.len()
}

/// # Safety
/// `text` is null, or ends with zero.
pub(crate) unsafe fn text_of(text: *const c_char) -> String {
    // SAFETY: see above.
    if text.is_null() {
        String::new()
    } else {
        unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
    }
}

/// A table of functions that are declared with their arguments, each of which returns a code that is zero if all is well.
macro_rules! functions {
    ($(#[$about:meta])* $table:ident { $($name:ident($($kind:ty),*);)* }) => {
        $(#[$about])*
        #[allow(non_snake_case)]
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $table { $(pub(crate) $name: unsafe extern "C" fn($($kind),*) -> std::ffi::c_int,)* }

        impl $table {
            /// Finds all; the name of one that is missing is the error.
            pub(crate) fn find(library: $crate::parallel::library::Library) -> Result<$table, &'static str> {
                Ok($table { $($name: match library.find(stringify!($name)) {
                    // SAFETY: the function of this name has these arguments in all versions that are meant.
                    Some(at) => unsafe {
                        std::mem::transmute::<
                            *mut std::ffi::c_void,
                            unsafe extern "C" fn($($kind),*) -> std::ffi::c_int,
                        >(at)
                    },
                    None => return Err(stringify!($name)),
                },)* })
            }
        }
    };
}
pub(crate) use functions;
