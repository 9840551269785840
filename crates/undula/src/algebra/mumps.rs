//! MUMPS of the system, sequential, to compare with.
#![allow(unsafe_code)]

use super::direct::Failure;
use super::{Backend, Cost, Csr, Direct, Options, Pattern, Scaling, SolverError, Unknown};
use std::ffi::{c_char, c_int};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// LU of MUMPS 5.5, sequential but for its BLAS.
pub type MumpsLu = Direct<MumpsBackend>;

impl MumpsLu {
    /// A solver that knows no matrix yet.
    pub fn mumps(options: Options, ordering: Ordering) -> Self {
        Self::new(MumpsBackend::new(ordering), options)
    }
}

/// Fill-reducing ordering that MUMPS is to use; where it was built without, it takes another one, and the
/// name of the solver tells which.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ordering {
    /// Nested dissection of METIS.
    Metis,
    /// Nested dissection of Scotch.
    Scotch,
    /// PORD, which comes with MUMPS.
    Pord,
    /// Approximate minimum degree.
    Amd,
}

impl Ordering {
    /// All that there are.
    pub const ALL: [Self; 4] = [Self::Metis, Self::Scotch, Self::Pord, Self::Amd];

    /// ICNTL(7).
    fn code(self) -> c_int {
        match self {
            Self::Metis => 5,
            Self::Scotch => 3,
            Self::Pord => 4,
            Self::Amd => 0,
        }
    }
}

/// Backend of [`MumpsLu`].
#[derive(Debug)]
pub struct MumpsBackend {
    ordering: Ordering,
    instance: Option<Box<Parameters>>,
    /// Rows and columns from one, and values, which MUMPS reads where they are.
    row: Vec<c_int>,
    col: Vec<c_int>,
    values: Vec<f64>,
}

// SAFETY: the pointers in `instance` are to vectors of this struct or to memory of MUMPS, which one
// thread at a time uses (see `call`); MUMPS keeps nothing per thread.
unsafe impl Send for MumpsBackend {}

/// MUMPS has global state; one call at a time.
fn lock() -> MutexGuard<'static, ()> {
    static LOCK: Mutex<()> = Mutex::new(());
    LOCK.lock().unwrap_or_else(PoisonError::into_inner)
}

impl MumpsBackend {
    fn new(ordering: Ordering) -> Self {
        Self { ordering, instance: None, row: Vec::new(), col: Vec::new(), values: Vec::new() }
    }

    /// Does one job on the instance; returns INFOG(1), which is negative for an error.
    fn call(&mut self, job: c_int) -> c_int {
        let Self { instance: Some(instance), row, col, values, .. } = self else { return -1 };
        let _one = lock();
        instance.job = job;
        (instance.irn, instance.jcn) = (row.as_mut_ptr(), col.as_mut_ptr());
        instance.a = values.as_mut_ptr();
        // SAFETY: `instance` has the layout of the C structure; `n`, `nnz` and, where the job reads
        // them, the arrays behind `irn`, `jcn`, `a` and `rhs` fit together and outlive the call.
        unsafe { dmumps_c(&raw mut **instance) };
        instance.infog[0]
    }

    fn close(&mut self) {
        if self.instance.is_some() {
            self.call(-2);
            self.instance = None;
        }
    }
}

impl Drop for MumpsBackend {
    fn drop(&mut self) {
        self.close();
    }
}

impl Backend for MumpsBackend {
    fn name(&self) -> &'static str {
        // What was used, not what was asked for: the library may have been built without it.
        match self.instance.as_ref().map(|i| i.infog[6]) {
            Some(5) => "mumps-metis",
            Some(3) => "mumps-scotch",
            Some(4) => "mumps-pord",
            Some(0) => "mumps-amd",
            _ => "mumps",
        }
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, _: &[Unknown]) -> Result<(), SolverError> {
        self.close();
        let too_large = || SolverError::TooLarge(format!("{} unknowns", pattern.n));
        let n = c_int::try_from(pattern.n).map_err(|_| too_large())?;
        self.row = (0..n).flat_map(|i| vec![i + 1; pattern.row(i as usize).len()]).collect();
        self.col = pattern.all_columns().map(|j| j as c_int + 1).collect();
        self.values = vec![0.0; pattern.nnz()];
        let mut instance = Parameters::new();
        // Unsymmetric, this process works, no MPI.
        (instance.sym, instance.par, instance.comm_fortran) = (0, 1, -987_654);
        self.instance = Some(instance);
        let started = self.call(-1);
        if let Some(instance) = &mut self.instance {
            instance.n = n;
            instance.nnz = pattern.nnz() as i64;
            // ICNTL: 1 to 4 no messages, 6 no column permutation by values (they are not there yet), 7
            // ordering, 8 no scaling (done before), 14 room for delayed pivots, 28 sequential analysis.
            for (at, value) in [
                (1, -1),
                (2, -1),
                (3, -1),
                (4, 0),
                (6, 0),
                (7, self.ordering.code()),
                (8, 0),
                (14, 60),
                (28, 1),
            ] {
                instance.icntl[at - 1] = value;
            }
        }
        match started.min(self.call(1)) {
            code if code < 0 => Err(SolverError::Memory(format!("MUMPS: INFOG(1) = {code}"))),
            _ => Ok(()),
        }
    }

    fn factor(&mut self, a: &Csr, scaling: &Scaling) -> Result<Cost, Failure> {
        for i in 0..a.pattern.n {
            for k in a.pattern.row(i) {
                self.values[k] = a.values[k] * scaling.row[i] * scaling.col[a.pattern.column(i, k) as usize];
            }
        }
        let mut code = self.call(2);
        // More room, where delayed pivots did not fit.
        while matches!(code, -9 | -8) && self.instance.as_ref().is_some_and(|i| i.icntl[13] < 1000) {
            if let Some(instance) = &mut self.instance {
                instance.icntl[13] *= 2;
            }
            code = self.call(2);
        }
        match (code, &self.instance) {
            (0.., Some(instance)) => Ok(Cost {
                fill: Some(millions(instance.infog[28])),
                flops: Some(instance.rinfog[2]),
                delayed: usize::try_from(instance.infog[12]).unwrap_or(0),
                bytes: Some(8 * millions(instance.infog[28])),
                read: None,
            }),
            (-10, _) => Err(Failure::ZeroPivot(0)),
            _ => Err(Failure::Memory(format!("MUMPS: INFOG(1) = {code}"))),
        }
    }

    fn solve(&mut self, y: &mut [f64]) {
        if let Some(instance) = &mut self.instance {
            (instance.nrhs, instance.lrhs) = (1, instance.n);
            instance.rhs = y.as_mut_ptr();
        }
        if self.call(3) < 0 {
            y.fill(f64::NAN);
        }
        if let Some(instance) = &mut self.instance {
            instance.rhs = std::ptr::null_mut();
        }
    }
}

/// Numbers in INFOG that are negative count millions.
fn millions(count: c_int) -> usize {
    if count < 0 { 1_000_000 * count.unsigned_abs() as usize } else { count as usize }
}

unsafe extern "C" {
    fn dmumps_c(parameters: *mut Parameters);
}

/// DMUMPS_STRUC_C of dmumps_c.h 5.5, with integers of 32 bits.
#[repr(C)]
#[derive(Debug)]
#[allow(dead_code)]
struct Parameters {
    sym: c_int,
    par: c_int,
    job: c_int,
    comm_fortran: c_int,
    icntl: [c_int; 60],
    keep: [c_int; 500],
    cntl: [f64; 15],
    dkeep: [f64; 230],
    keep8: [i64; 150],
    n: c_int,
    nblk: c_int,
    nz_alloc: c_int,
    nz: c_int,
    nnz: i64,
    irn: *mut c_int,
    jcn: *mut c_int,
    a: *mut f64,
    nz_loc: c_int,
    nnz_loc: i64,
    irn_loc: *mut c_int,
    jcn_loc: *mut c_int,
    a_loc: *mut f64,
    nelt: c_int,
    eltptr: *mut c_int,
    eltvar: *mut c_int,
    a_elt: *mut f64,
    blkptr: *mut c_int,
    blkvar: *mut c_int,
    perm_in: *mut c_int,
    sym_perm: *mut c_int,
    uns_perm: *mut c_int,
    colsca: *mut f64,
    rowsca: *mut f64,
    colsca_from_mumps: c_int,
    rowsca_from_mumps: c_int,
    rhs: *mut f64,
    redrhs: *mut f64,
    rhs_sparse: *mut f64,
    sol_loc: *mut f64,
    rhs_loc: *mut f64,
    irhs_sparse: *mut c_int,
    irhs_ptr: *mut c_int,
    isol_loc: *mut c_int,
    irhs_loc: *mut c_int,
    nrhs: c_int,
    lrhs: c_int,
    lredrhs: c_int,
    nz_rhs: c_int,
    lsol_loc: c_int,
    nloc_rhs: c_int,
    lrhs_loc: c_int,
    schur_mloc: c_int,
    schur_nloc: c_int,
    schur_lld: c_int,
    mblock: c_int,
    nblock: c_int,
    nprow: c_int,
    npcol: c_int,
    info: [c_int; 80],
    infog: [c_int; 80],
    rinfo: [f64; 40],
    rinfog: [f64; 40],
    deficiency: c_int,
    pivnul_list: *mut c_int,
    mapping: *mut c_int,
    size_schur: c_int,
    listvar_schur: *mut c_int,
    schur: *mut f64,
    instance_number: c_int,
    wk_user: *mut f64,
    version_number: [c_char; 32],
    ooc_tmpdir: [c_char; 256],
    ooc_prefix: [c_char; 64],
    write_problem: [c_char; 256],
    lwk_user: c_int,
    save_dir: [c_char; 256],
    save_prefix: [c_char; 256],
    metis_options: [c_int; 40],
}

/// Sizes and places as a C compiler has them on 64-bit machines.
const _: () = assert!(
    size_of::<Parameters>() == 8360
        && std::mem::offset_of!(Parameters, infog) == 6048
        && std::mem::offset_of!(Parameters, metis_options) == 8196
);

impl Parameters {
    /// All zero, as MUMPS wants what is not set.
    fn new() -> Box<Self> {
        // SAFETY: integers, floating point numbers and raw pointers may all be zero.
        unsafe { Box::new(std::mem::zeroed()) }
    }
}
