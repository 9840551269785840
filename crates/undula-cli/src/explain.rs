//! `undula explain WORD`: what a word of the output means, or of a case.

use crate::args::{ExplainArgs, bad_input, print};
use crate::keys::aligned;
use std::process::ExitCode;
use undula::case::error::did_you_mean;
use undula::case::keys::{nearest, search};

/// A word of the output.
struct Entry {
    /// The word, and others for the same.
    words: &'static [&'static str],
    /// Where it occurs.
    place: &'static str,
    /// What it means and what to do, sentence by sentence.
    text: &'static [&'static str],
}

/// Words of messages, columns and summaries. Keys have words of their own, see [`search`].
static ENTRIES: &[Entry] = &[
    Entry {
        words: &["folding", "fold", "folded", "J"],
        place: "cause of a breakdown",
        text: &[
            "J = det F of the map from the reference domain is zero or negative somewhere: a cell is turned inside out.",
            "In the fluid: another extension (motion.model = \"biharmonic\", motion.offset) or shorter steps.",
            "In the solid: shorter steps, smaller cells, or a law that resists compression (neo-hookean).",
            "Contact of two bodies cannot be computed: no mesh follows it.",
        ],
    },
    Entry {
        words: &["divergence", "diverged", "stalled"],
        place: "cause of a breakdown",
        text: &[
            "Newton's method does not converge, and no cell folds. breakdown.txt has the residuals of all attempts.",
            "Shorter steps, or newton.linearization = \"newton\", or more of newton.max-steps and newton.line-search.",
            "`undula run --verbose` prints the residual of every iteration.",
        ],
    },
    Entry {
        words: &["slow"],
        place: "cause of a breakdown",
        text: &[
            "A linear iteration would take more steps than are allowed.",
            "newton.linearization = \"newton\", or a direct solver (linear.solver = \"multifrontal\").",
        ],
    },
    Entry {
        words: &["singular"],
        place: "cause of a breakdown",
        text: &[
            "The matrix does not determine all unknowns, such as a body that nothing holds.",
            "A condition on a boundary that determines it: clamped, spring, symmetry; for a pressure an outlet.",
        ],
    },
    Entry {
        words: &["not-finite", "nan", "inf"],
        place: "cause of a breakdown",
        text: &[
            "A residual is not a finite number, though all data are.",
            "Shorter steps: what is computed has grown without bound.",
        ],
    },
    Entry {
        words: &["backflow"],
        place: "cause of a breakdown",
        text: &[
            "The flow comes back in through an outlet, where nothing says with which velocity.",
            "boundary.NAME.backflow = \"directional\" computes through it; at a given pressure \"tangential\".",
            "A longer domain behind the vortices is the other way.",
        ],
    },
    Entry {
        words: &["closed", "overfilled"],
        place: "cause of a breakdown",
        text: &[
            "A part of the fluid without outlet is filled or drained by its data: no incompressible flow does that.",
            "Give it an outlet, or data whose flow is zero.",
        ],
    },
    Entry {
        words: &["solver"],
        place: "cause of a breakdown",
        text: &["The linear solver fails; the message says why, as too little memory."],
    },
    Entry {
        words: &["mass_balance", "balance", "mass"],
        place: "summary.json, warning at the end of a run",
        text: &[
            "Largest net flow through all boundaries of the fluid, relative to the largest flow; about newton.tolerance.",
            "Above 1e-6 something is wrong: a tolerance that is too large, or data that do not fit.",
        ],
    },
    Entry {
        words: &["swept_volume", "volume"],
        place: "summary.json",
        text: &[
            "Largest difference in a step between the change of the volume of the fluid and what its boundaries sweep,",
            "relative to the largest flow. It falls with the order of the time scheme.",
        ],
    },
    Entry {
        words: &["min_J", "min", "smallest J"],
        place: "column of history.csv",
        text: &[
            "The smallest J = det F at all quadrature points at the end of the step. 1: nothing is deformed; the mesh folds",
            "at 0.",
        ],
    },
    Entry {
        words: &["force_time"],
        place: "column of history.csv",
        text: &[
            "The time that forces, pressures and stresses of this row belong to, t⁻ + θk for a step from t⁻ to t⁻ + k.",
            "All other columns belong to `time`, the end of the step.",
        ],
    },
    Entry {
        words: &["time"],
        place: "column of history.csv",
        text: &["The end of the step [s]. Forces, pressures and stresses belong to `force_time`."],
    },
    Entry {
        words: &["newton_steps"],
        place: "column of history.csv, summary.json",
        text: &[
            "Iterations of Newton's method: of the step, of all steps. With shortened or repeated steps all count.",
        ],
    },
    Entry {
        words: &["jacobians", "factorizations"],
        place: "column of history.csv, summary.json",
        text: &[
            "How often the matrix was assembled, or factorised. A matrix is kept, also across steps, as long as that is",
            "cheaper than a new one.",
        ],
    },
    Entry {
        words: &["linear_iterations"],
        place: "summary.json, column of history.csv",
        text: &[
            "How often factors, or a cycle of multigrid, were applied: in a step, in summary.json summed over all steps. The",
            "column is there where the solver is iterative (multigrid, or linear.krylov).",
        ],
    },
    Entry {
        words: &["largest_factor_unknowns"],
        place: "summary.json",
        text: &[
            "Unknowns of the largest system that is factorised as a whole: with multigrid that of the coarsest level.",
        ],
    },
    Entry {
        words: &["processes", "engine"],
        place: "summary.json",
        text: &[
            "How many processes have computed the run, and which PETSc has solved the linear systems (linear.engine). Both are",
            "left out where there is nothing to say: one process, Undula's own solver.",
        ],
    },
    Entry {
        words: &["direct_fallbacks"],
        place: "summary.json",
        text: &[
            "Steps that were begun anew with the whole Jacobian and a direct solver, since an iteration failed.",
        ],
    },
    Entry {
        words: &["mean", "amplitude", "frequency"],
        place: "summary.json, compare, report.html",
        text: &[
            "(max + min)/2 and (max − min)/2 over the last period of the leading signal (output.leading), and 1/period [Hz].",
            "null: the signal is steady or not periodic, as its last periods differ; run it longer.",
        ],
    },
    Entry {
        words: &["deviation", "uncertainty"],
        place: "compare, report.html",
        text: &[
            "(computed − published)/published; of a mean relative to the amplitude where that is larger.",
            "The uncertainty is that of the published number, as far as it is known.",
        ],
    },
    Entry {
        words: &["cpu_seconds", "wall_seconds", "phases"],
        place: "summary.json",
        text: &[
            "Processor time since the run was last resumed, elapsed time in all, and its parts: assembly, factorization,",
            "solve, output.",
        ],
    },
    Entry {
        words: &["running", "completed", "breakdown", "failed", "interrupted", "status"],
        place: "summary.json",
        text: &[
            "running: not yet ended, or the process was killed; completed: as the case asked; breakdown: the solution could",
            "not be continued (exit code 3); failed: by an error (1); interrupted: by the user (130), go on with --resume.",
        ],
    },
    Entry {
        words: &["checkpoint", "checkpoints", "resume"],
        place: "directory of a run",
        text: &[
            "checkpoints/*.npz have the exact state of the last two checkpoints. --resume goes on from the last one, with the",
            "same bits as a run that was not interrupted.",
        ],
    },
];

/// Explains a word, or says what is close to it.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(args: &ExplainArgs) -> anyhow::Result<ExitCode> {
    let word = args.word.trim();
    let is_it =
        |other: &&str| other.eq_ignore_ascii_case(word) || other.replace('_', "-").eq_ignore_ascii_case(word);
    let mut text = String::new();
    for entry in ENTRIES.iter().filter(|entry| entry.words.iter().any(is_it)) {
        text += &format!("{} ({})\n", entry.words.join(", "), entry.place);
        entry.text.iter().for_each(|line| text += &format!("  {line}\n"));
    }
    let found = search(word);
    if !found.is_empty() && !word.is_empty() {
        text += if text.is_empty() { "" } else { "\n" };
        text += &aligned(&found);
    }
    if !text.is_empty() {
        return print(&text);
    }
    let words = ENTRIES.iter().flat_map(|entry| entry.words.iter().copied());
    let mut hint = did_you_mean(word, words);
    if hint.is_empty() {
        hint = nearest(word);
    }
    bad_input(format_args!(
        "nothing is known of `{word}`{hint}; `undula keys` lists all keys, docs/methods has the methods"
    ))
}
