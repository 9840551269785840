//! Studies: many runs, and what their results say.
//!
//! A [`Study`] is a file: runs with their settings, tables and figures of their results, published numbers, and
//! statements. A statement has a number and a condition, both expressions over results; no verdict is text.
//!
//! | step | file |
//! | --- | --- |
//! | read a study, and write out what stands for several entries | `file`, `template` |
//! | make its cases | `job` |
//! | compute them, or take up what an earlier call left | `engine` |
//! | what is computed besides histories: modes, errors, inf-sup constants, matrices | `quantities` |
//! | names of results in expressions | `known` |
//! | tables, figures, statements with their numbers | `report` |
//! | orders and extrapolated values of a case | `converge` |

mod chapter;
pub mod converge;
mod engine;
mod file;
mod job;
mod known;
mod measures;
mod quantities;
mod report;
mod template;

pub use chapter::chapter;
pub use engine::{Computed, Event, Settings, Watch};
pub use file::{
    Cell, CurveEntry, FigureEntry, PictureEntry, RunEntry, Statement, Study, StudyError, TableEntry,
};
pub use job::Job;
pub use known::Known;
pub use quantities::{Also, Compute, Numbers};
pub use report::{Curve, Figure, Picture, Report, RunRow, Shown, Table, Verdict, Weighed};
