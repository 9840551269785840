//! Processes that MPI has started. Its library is loaded at run time: Open MPI, or MPICH and those of its binary
//! interface, told apart by a symbol. All data are bytes, so that one type and no operation of MPI is needed.
#![allow(unsafe_code)]

use super::comm::{Comm, Fault, Message};
use super::library::{Library, Object, functions};
use std::ffi::{c_char, c_int, c_void};
use std::ptr::null_mut;

/// Names of the libraries: Open MPI from version 2 on, MPICH and those of its binary interface, MPICH of Debian, others.
pub(crate) const MPI_NAMES: [&str; 4] = ["libmpi.so.40", "libmpi.so.12", "libmpich.so.12", "libmpi.so"];

functions! {
    /// Functions of MPI.
    Functions {
        MPI_Get_library_version(*mut c_char, *mut c_int);
        MPI_Initialized(*mut c_int);
        MPI_Finalized(*mut c_int);
        MPI_Init_thread(*mut c_int, *mut *mut *mut c_char, c_int, *mut c_int);
        MPI_Finalize();
        MPI_Comm_size(Object, *mut c_int);
        MPI_Comm_rank(Object, *mut c_int);
        MPI_Barrier(Object);
        MPI_Bcast(*mut c_void, c_int, Object, c_int, Object);
        MPI_Allgather(*const c_void, c_int, Object, *mut c_void, c_int, Object, Object);
        MPI_Isend(*const c_void, c_int, Object, c_int, c_int, Object, *mut c_void);
        MPI_Irecv(*mut c_void, c_int, Object, c_int, c_int, Object, *mut c_void);
        MPI_Waitall(c_int, *mut c_void, *mut c_void);
    }
}

/// Calls a function of MPI; a code that is not zero becomes an error.
macro_rules! call {
    ($table:expr, $name:ident($($argument:expr),*)) => {{
        // SAFETY: handles of this MPI, and buffers of the lengths that are told, which outlive the call, or, where it only
        // begins, the call that waits for its end.
        let code = unsafe { ($table.$name)($($argument),*) };
        if code == 0 { Ok(()) } else { Err(Fault::Call { function: stringify!($name), code }) }
    }};
}

impl Functions {
    /// What the library calls itself, in one line.
    pub(crate) fn version(&self) -> Result<String, Fault> {
        // The largest of both kinds: MPI_MAX_LIBRARY_VERSION_STRING is 256 in Open MPI, 8192 in MPICH.
        let (mut text, mut length) = (vec![0u8; 16384], 0);
        call!(self, MPI_Get_library_version(text.as_mut_ptr().cast(), &raw mut length))?;
        let end = text.iter().position(|&c| c == 0).unwrap_or(text.len());
        Ok(first_line(&String::from_utf8_lossy(&text[..end])))
    }

    /// Starts MPI, for calls by one thread at a time, unless it has been started.
    pub(crate) fn start(&self) -> Result<(), Fault> {
        const SERIALIZED: c_int = 2;
        let (mut started, mut provided) = (0, 0);
        call!(self, MPI_Initialized(&raw mut started))?;
        if started == 0 {
            call!(self, MPI_Init_thread(null_mut(), null_mut(), SERIALIZED, &raw mut provided))?;
        }
        Ok(())
    }

    /// Ends MPI, unless it has ended.
    pub(crate) fn end(&self) -> Result<(), Fault> {
        let mut ended = 0;
        call!(self, MPI_Finalized(&raw mut ended))?;
        if ended == 0 { call!(self, MPI_Finalize()) } else { Ok(()) }
    }

    /// Number of processes.
    pub(crate) fn size(&self, comm: Object) -> Result<usize, Fault> {
        let mut size = 0;
        call!(self, MPI_Comm_size(comm, &raw mut size))?;
        Ok(usize::try_from(size).unwrap_or(1))
    }
}

/// `Open MPI v4.1.4` of a line with more in it, `MPICH 4.0.2` of a table.
fn first_line(text: &str) -> String {
    match text.trim().strip_prefix("MPICH Version:") {
        Some(rest) => format!("MPICH {}", rest.split_whitespace().next().unwrap_or("")),
        None => text.trim().lines().next().unwrap_or("").split(',').next().unwrap_or("").trim().to_string(),
    }
}

/// The processes that were started together, or this one alone if no launcher has started it.
#[derive(Debug)]
pub struct World {
    functions: Functions,
    comm: Object,
    byte: Object,
    /// Bytes of a request.
    request: usize,
    rank: usize,
    size: usize,
}

/// `MPI_COMM_WORLD` and `MPI_BYTE` of MPICH.
const OF_MPICH: [usize; 2] = [0x4400_0000, 0x4c00_010d];

/// Room for a status of any MPI.
const STATUS: usize = 64;

/// The tag of all messages: who sends what to whom is known, and MPI keeps the order.
const TAG: c_int = 1;

impl World {
    /// Loads the MPI of this `name`, or the first of the usual ones, and starts it unless it has been started.
    ///
    /// # Errors
    /// If there is none, or if it does not start.
    pub fn start(name: Option<&str>) -> Result<World, Fault> {
        let missing = |reason: String| Fault::Missing(reason);
        let library = match name {
            Some(name) => Library::open(name).map_err(missing)?,
            None => MPI_NAMES
                .iter()
                .find_map(|name| Library::open(name).ok())
                .ok_or_else(|| missing(format!("none of {} is there", MPI_NAMES.join(", "))))?,
        };
        World::of(library)
    }

    /// Those of a `library` that has MPI inside, or needs one.
    pub(crate) fn of(library: Library) -> Result<World, Fault> {
        let missing = |function| Fault::Missing(format!("no function `{function}`"));
        let functions = Functions::find(library).map_err(missing)?;
        functions.start()?;
        let of_open_mpi = library.address("ompi_mpi_comm_world").zip(library.address("ompi_mpi_byte"));
        let ([comm, byte], request) = match of_open_mpi {
            Some((comm, byte)) => ([comm, byte], size_of::<*mut c_void>()),
            None => (OF_MPICH.map(Object::of_number), size_of::<c_int>()),
        };
        let (size, mut rank) = (functions.size(comm)?, 0);
        call!(functions, MPI_Comm_rank(comm, &raw mut rank))?;
        Ok(World { functions, comm, byte, request, rank: usize::try_from(rank).unwrap_or(0), size })
    }

    /// Ends MPI; every process has to, as its last call.
    ///
    /// # Errors
    /// If MPI fails.
    pub fn end(self) -> Result<(), Fault> {
        self.functions.end()
    }
}

/// Bytes of `values`, as MPI counts them.
fn bytes(values: &[f64]) -> Result<c_int, Fault> {
    let bytes = size_of_val(values);
    c_int::try_from(bytes).map_err(|_| Fault::Length(bytes))
}

impl Comm for World {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn barrier(&mut self) -> Result<(), Fault> {
        call!(self.functions, MPI_Barrier(self.comm))
    }

    fn broadcast(&mut self, root: usize, values: &mut [f64]) -> Result<(), Fault> {
        let count = bytes(values)?;
        call!(
            self.functions,
            MPI_Bcast(values.as_mut_ptr().cast(), count, self.byte, root as c_int, self.comm)
        )
    }

    fn all_gather(&mut self, values: &[f64]) -> Result<Vec<Vec<f64>>, Fault> {
        let (count, n) = (bytes(values)?, values.len());
        let mut all = vec![0.0f64; n * self.size];
        let (from, to) = (values.as_ptr().cast(), all.as_mut_ptr().cast());
        call!(self.functions, MPI_Allgather(from, count, self.byte, to, count, self.byte, self.comm))?;
        Ok((0..self.size).map(|rank| all[rank * n..(rank + 1) * n].to_vec()).collect())
    }

    fn exchange(&mut self, sent: &[Message], received: &mut [Message]) -> Result<(), Fault> {
        let count = sent.len() + received.len();
        // Handles have 4 or 8 bytes, a status has at most 64.
        let (mut requests, mut statuses) = (vec![0u64; count], vec![0u8; STATUS * count + STATUS]);
        let place: *mut u8 = requests.as_mut_ptr().cast();
        let mut next = (0..count).map(|i| place.wrapping_add(i * self.request).cast::<c_void>());
        let lengths: Vec<c_int> = received.iter().map(|m| bytes(&m.values)).collect::<Result<_, _>>()?;
        let to_send: Vec<c_int> = sent.iter().map(|m| bytes(&m.values)).collect::<Result<_, _>>()?;
        let mut result = Ok(());
        for ((message, length), at) in received.iter_mut().zip(lengths).zip(next.by_ref()) {
            let (buffer, rank) = (message.values.as_mut_ptr().cast(), message.rank as c_int);
            let call = call!(self.functions, MPI_Irecv(buffer, length, self.byte, rank, TAG, self.comm, at));
            result = result.and(call);
        }
        for ((message, length), at) in sent.iter().zip(to_send).zip(next) {
            let (buffer, rank) = (message.values.as_ptr().cast(), message.rank as c_int);
            let call = call!(self.functions, MPI_Isend(buffer, length, self.byte, rank, TAG, self.comm, at));
            result = result.and(call);
        }
        let statuses = statuses.as_mut_ptr();
        let statuses = statuses.wrapping_add(statuses.align_offset(16)).cast();
        result.and(call!(self.functions, MPI_Waitall(count as c_int, place.cast(), statuses)))
    }
}
