//! Studies: many runs, and what their results say.
//!
//! A [`Study`] is a file: runs with their settings, tables and figures of their results, published numbers, and
//! statements. A statement has a number and a condition, both expressions over results; no verdict is text.
//!
//! | step | file |
//! | --- | --- |
//! | read a study | `file` |
//! | make its cases and compute them, or take up what an earlier call left | `engine` |
//! | what is computed besides histories: modes, errors, inf-sup constants, matrices | `quantities` |
//! | names of results in expressions | `known` |
//! | tables, figures, statements with their numbers | `report` |
//! | orders and extrapolated values of a case | `converge` |

mod chapter;
pub mod converge;
mod engine;
mod file;
mod known;
mod measures;
mod quantities;
mod report;

pub use chapter::chapter;
pub use engine::{Computed, Event, Job, Settings, Watch};
pub use file::{
    Cell, CurveEntry, FigureEntry, PictureEntry, RunEntry, Statement, Study, StudyError, TableEntry,
};
pub use known::Known;
pub use quantities::{Also, Compute, Numbers};
pub use report::{Curve, Figure, Picture, Report, RunRow, Shown, Table, Verdict, Weighed};
