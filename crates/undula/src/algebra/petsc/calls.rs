//! Functions of PETSc, found at run time. Beside it, `system.rs` has `unsafe` code: it calls them.
//!
//! The declared functions have the same signatures in all versions of PETSc from 3.18 on. Integers of
//! PETSc that are passed by value are declared with 64 bits: where they have 32, the lower half of the register is read.
//! Those that are returned have room for 64 bits, and zeros in it.
#![allow(unsafe_code)]

use super::error::{Trouble, record};
use crate::parallel::library::{Library, Object, functions, text_of};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

/// An integer of PETSc, `PetscInt`.
type Int = i64;

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
        MatUpdateMPIAIJWithArray(Object, *const f64);
        MatCreateVecs(Object, *mut Object, *mut Object);
        MatDestroy(*mut Object);
        VecGetArray(Object, *mut *mut f64);
        VecRestoreArray(Object, *mut *mut f64);
        VecDestroy(*mut Object);
        VecScatterCreateToAll(Object, *mut Object, *mut Object);
        VecScatterBegin(Object, Object, Object, c_int, c_int);
        VecScatterEnd(Object, Object, Object, c_int, c_int);
        VecScatterDestroy(*mut Object);
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
        PCApply(Object, Object, Object);
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
        // SAFETY: the variable is a pointer or an `int`.
        unsafe { library.read("PETSC_COMM_WORLD", narrow) }
    }
}
