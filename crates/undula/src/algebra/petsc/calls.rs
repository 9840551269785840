//! Functions of PETSc and MPI, found at run time. Beside it, `system.rs` has `unsafe` code: it calls them.
//!
//! The declared functions have the same signatures in all versions of PETSc from 3.18 on, and in all of MPI. Integers of
//! PETSc that are passed by value are declared with 64 bits: where they have 32, the lower half of the register is read.
//! Those that are returned have room for 64 bits, and zeros in it.
#![allow(unsafe_code)]

use super::error::{Trouble, record};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

/// An integer of PETSc, `PetscInt`.
type Int = i64;

/// An object of PETSc or MPI: a pointer, or a number in its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Object(*mut c_void);

// SAFETY: a handle; what is behind it is used by the thread that holds the lock of `Session`.
unsafe impl Send for Object {}

impl Object {
    /// No object.
    pub(super) const NONE: Object = Object(null_mut());
}

/// A library that is loaded, for the rest of the process.
#[derive(Debug, Clone, Copy)]
pub(super) struct Library(*mut c_void);

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
    pub(super) fn open(name: &str) -> Result<Library, String> {
        let Ok(text) = CString::new(name) else { return Err(format!("{name}: a name has no zero byte")) };
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

    #[cfg(not(unix))]
    pub(super) fn open(name: &str) -> Result<Library, String> {
        Err(format!("{name}: libraries are loaded at run time on Unix systems only"))
    }

    /// Where a symbol of the library, or of one that it needs, is.
    #[cfg(unix)]
    fn find(self, symbol: &str) -> Option<*mut c_void> {
        let symbol = CString::new(symbol).ok()?;
        // SAFETY: the library is never closed; a string that ends with zero.
        let at = unsafe { dlsym(self.0, symbol.as_ptr()) };
        (!at.is_null()).then_some(at)
    }

    #[cfg(not(unix))]
    fn find(self, _symbol: &str) -> Option<*mut c_void> {
        None
    }

    /// Whether the library, or one that it needs, has this symbol.
    pub(super) fn has(self, symbol: &str) -> bool {
        self.find(symbol).is_some()
    }

    /// Whether both have the same `symbol`.
    pub(super) fn shares(self, other: Library, symbol: &str) -> bool {
        self.find(symbol) == other.find(symbol)
    }
}

/// # Safety
/// `text` is null, or ends with zero.
pub(super) unsafe fn text_of(text: *const c_char) -> String {
    // SAFETY: see above.
    if text.is_null() {
        String::new()
    } else {
        unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
    }
}

/// What PETSc calls with an error: communicator, line, function, file, code, whether it is the first, message, context.
type Handler = extern "C" fn(
    Object,
    c_int,
    *const c_char,
    *const c_char,
    c_int,
    c_int,
    *const c_char,
    *mut c_void,
) -> c_int;

/// Keeps what is said where an error arises; what its callers add is left out. The call then returns its code.
extern "C" fn keep(
    _: Object,
    _: c_int,
    function: *const c_char,
    _: *const c_char,
    code: c_int,
    repeated: c_int,
    message: *const c_char,
    _: *mut c_void,
) -> c_int {
    if repeated != 1 {
        // SAFETY: strings of PETSc, which live during the call.
        let (function, message) = unsafe { (text_of(function), text_of(message)) };
        record(&function, &message);
    }
    code
}

/// A table of functions, each of which returns a code that is zero if all is well.
macro_rules! functions {
    ($(#[$about:meta])* $table:ident { $($name:ident($($kind:ty),*);)* }) => {
        $(#[$about])*
        #[allow(non_snake_case)]
        #[derive(Clone, Copy)]
        pub(super) struct $table { $(pub(super) $name: unsafe extern "C" fn($($kind),*) -> c_int,)* }

        impl $table {
            /// Finds all; the name of one that is missing is the error.
            pub(super) fn find(library: Library) -> Result<$table, &'static str> {
                Ok($table { $($name: match library.find(stringify!($name)) {
                    // SAFETY: the function of this name has this signature, see the top of the file.
                    Some(at) => unsafe {
                        std::mem::transmute::<*mut c_void, unsafe extern "C" fn($($kind),*) -> c_int>(at)
                    },
                    None => return Err(stringify!($name)),
                },)* })
            }
        }
    };
}

functions! {
    /// Functions of MPI.
    Mpi {
        MPI_Get_library_version(*mut c_char, *mut c_int);
        MPI_Initialized(*mut c_int);
        MPI_Finalized(*mut c_int);
        MPI_Init_thread(*mut c_int, *mut *mut *mut c_char, c_int, *mut c_int);
        MPI_Finalize();
        MPI_Comm_size(Object, *mut c_int);
    }
}

functions! {
    /// Functions of PETSc.
    Petsc {
        PetscGetVersionNumber(*mut Int, *mut Int, *mut Int, *mut Int);
        PetscDataTypeFromString(*const c_char, *mut c_int, *mut c_int);
        PetscDataTypeGetSize(c_int, *mut usize);
        PetscInitialize(*mut c_int, *mut *mut *mut c_char, *const c_char, *const c_char);
        PetscFinalize();
        PetscPushErrorHandler(Option<Handler>, *mut c_void);
        PetscOptionsCreate(*mut Object);
        PetscOptionsDestroy(*mut Object);
        PetscOptionsInsertString(Object, *const c_char);
        PetscOptionsPush(Object);
        PetscOptionsPop();
        PetscOptionsLeftGet(Object, *mut Int, *mut *mut *mut c_char, *mut *mut *mut c_char);
        PetscOptionsLeftRestore(Object, *mut Int, *mut *mut *mut c_char, *mut *mut *mut c_char);
        MatCreate(Object, *mut Object);
        MatSetSizes(Object, Int, Int, Int, Int);
        MatSetType(Object, *const c_char);
        MatSeqAIJSetPreallocationCSR(Object, *const c_void, *const c_void, *const f64);
        MatMPIAIJSetPreallocationCSR(Object, *const c_void, *const c_void, *const f64);
        MatSeqAIJGetArray(Object, *mut *mut f64);
        MatSeqAIJRestoreArray(Object, *mut *mut f64);
        MatCreateVecs(Object, *mut Object, *mut Object);
        MatDestroy(*mut Object);
        VecGetArray(Object, *mut *mut f64);
        VecRestoreArray(Object, *mut *mut f64);
        VecDestroy(*mut Object);
        ISCreateGeneral(Object, Int, *const c_void, c_int, *mut Object);
        ISDestroy(*mut Object);
        KSPCreate(Object, *mut Object);
        KSPSetOperators(Object, Object, Object);
        KSPSetFromOptions(Object);
        KSPSetUp(Object);
        KSPSetUpOnBlocks(Object);
        KSPSolve(Object, Object, Object);
        KSPGetPC(Object, *mut Object);
        KSPGetType(Object, *mut *const c_char);
        KSPGetTolerances(Object, *mut f64, *mut f64, *mut f64, *mut Int);
        KSPGetIterationNumber(Object, *mut Int);
        KSPGetConvergedReason(Object, *mut c_int);
        KSPDestroy(*mut Object);
        PCGetType(Object, *mut *const c_char);
        PCGetFailedReason(Object, *mut c_int);
        PCFieldSplitSetIS(Object, *const c_char, Object);
    }
}

/// Integers as PETSc has them.
#[derive(Debug)]
pub(super) enum Indices {
    Narrow(Vec<i32>),
    Wide(Vec<i64>),
}

impl Indices {
    /// `None` if one does not fit.
    pub(super) fn new(bits: usize, values: impl Iterator<Item = usize>) -> Option<Indices> {
        match bits {
            32 => values.map(|i| i32::try_from(i).ok()).collect::<Option<_>>().map(Indices::Narrow),
            _ => values.map(|i| i64::try_from(i).ok()).collect::<Option<_>>().map(Indices::Wide),
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Indices::Narrow(values) => values.len(),
            Indices::Wide(values) => values.len(),
        }
    }

    pub(super) fn at(&self) -> *const c_void {
        match self {
            Indices::Narrow(values) => values.as_ptr().cast(),
            Indices::Wide(values) => values.as_ptr().cast(),
        }
    }
}

/// Calls a function of a table; a code that is not zero becomes an error with what was said.
macro_rules! call {
    ($table:expr, $name:ident($($argument:expr),*)) => {{
        // SAFETY: the arguments are objects that calls of this folder have made, buffers that outlive the call, and
        // strings that end with zero.
        let code = unsafe { ($table.$name)($($argument),*) };
        if code == 0 { Ok(()) } else { Err(Trouble::new(stringify!($name), code)) }
    }};
}
pub(super) use call;

impl Mpi {
    /// What the library calls itself.
    pub(super) fn version(&self) -> Result<String, Trouble> {
        // The largest of both kinds: MPI_MAX_LIBRARY_VERSION_STRING is 256 in Open MPI, 8192 in MPICH.
        let (mut text, mut length) = (vec![0 as c_char; 16384], 0);
        call!(self, MPI_Get_library_version(text.as_mut_ptr(), &raw mut length))?;
        // SAFETY: the buffer is longer than any text, and ends with zero.
        Ok(unsafe { text_of(text.as_ptr()) })
    }

    /// Starts MPI, for calls by one thread at a time, unless it has been started.
    pub(super) fn start(&self) -> Result<(), Trouble> {
        const SERIALIZED: c_int = 2;
        let (mut started, mut provided) = (0, 0);
        call!(self, MPI_Initialized(&raw mut started))?;
        if started == 0 {
            call!(self, MPI_Init_thread(null_mut(), null_mut(), SERIALIZED, &raw mut provided))?;
        }
        Ok(())
    }

    /// Ends MPI, unless it has ended.
    pub(super) fn end(&self) -> Result<(), Trouble> {
        let mut ended = 0;
        call!(self, MPI_Finalized(&raw mut ended))?;
        if ended == 0 { call!(self, MPI_Finalize()) } else { Ok(()) }
    }

    /// Number of processes.
    pub(super) fn size(&self, comm: Object) -> Result<usize, Trouble> {
        let mut size = 0;
        call!(self, MPI_Comm_size(comm, &raw mut size))?;
        Ok(usize::try_from(size).unwrap_or(1))
    }
}

impl Petsc {
    /// Major, minor and patch of its version.
    pub(super) fn version(&self) -> Result<[i64; 3], Trouble> {
        let mut n = [0; 4];
        let [major, minor, patch, release] = &mut n;
        call!(
            self,
            PetscGetVersionNumber(&raw mut *major, &raw mut *minor, &raw mut *patch, &raw mut *release)
        )?;
        Ok([n[0], n[1], n[2]])
    }

    /// Bytes of a type, and its number among the types of data; `None` if there is none of this name.
    pub(super) fn width(&self, name: &CStr) -> Result<Option<(usize, i32)>, Trouble> {
        let (mut kind, mut found, mut bytes) = (0, 0, 0);
        call!(self, PetscDataTypeFromString(name.as_ptr(), &raw mut kind, &raw mut found))?;
        // A byte in new versions, an int in old ones.
        if found & 1 == 0 {
            return Ok(None);
        }
        call!(self, PetscDataTypeGetSize(kind, &raw mut bytes))?;
        Ok(Some((bytes, kind)))
    }

    /// Starts PETSc with these arguments, and keeps its errors from ending the process.
    pub(super) fn start(&self, arguments: &[&CStr]) -> Result<(), Trouble> {
        // PETSc keeps the arguments.
        let list: Vec<*mut c_char> =
            arguments.iter().map(|a| CStr::to_owned(a).into_raw()).chain([null_mut()]).collect();
        let count: &'static mut c_int = Box::leak(Box::new(arguments.len() as c_int));
        let list: &'static mut *mut *mut c_char = Box::leak(Box::new(list.leak().as_mut_ptr()));
        call!(self, PetscInitialize(&raw mut *count, &raw mut *list, null(), null()))?;
        call!(self, PetscPushErrorHandler(Some(keep as Handler), null_mut()))
    }

    pub(super) fn end(&self) -> Result<(), Trouble> {
        call!(self, PetscFinalize())
    }

    /// All processes; `narrow` where communicators are numbers of 32 bits.
    pub(super) fn world(library: Library, narrow: bool) -> Option<Object> {
        let at = library.find("PETSC_COMM_WORLD")?;
        // SAFETY: the variable is a pointer or an `int`.
        Some(Object(unsafe { if narrow { *at.cast::<u32>() as usize as *mut c_void } else { *at.cast() } }))
    }
}
