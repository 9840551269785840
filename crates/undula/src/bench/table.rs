//! A report for people.

use super::{CyclePart, Kernels, Report, Steps, Timing};
use std::fmt::{Display, Formatter, Result};

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Report { case, cells, threads, lanes, scheme, linearization, solver, precision, .. } = self;
        let plural = if *threads == 1 { "" } else { "s" };
        writeln!(f, "{case}: {cells} cells, {} unknowns, {scheme}, {linearization}", self.unknowns.total)?;
        writeln!(f, "{solver} in {precision} precision, {threads} thread{plural}, {lanes} lanes")?;
        if let Some(processor) = &self.processor {
            writeln!(f, "{processor}")?;
        }
        if let Some(steps) = &self.steps {
            write_steps(f, steps)?;
        }
        if let Some(kernels) = &self.kernels {
            write_kernels(f, kernels)?;
        }
        let m = &self.machine;
        writeln!(f, "\nmachine                 1 thread  {threads} thread{plural}")?;
        for (name, rates) in [("triad", m.triad), ("read", m.read)] {
            let [one, all] = [rates.one_thread, rates.all_threads].map(|r| 1e-9 * r);
            writeln!(f, "  {name:<20} {one:9.2} {all:9.2}  GB/s")?;
        }
        for (name, rate) in [("product double", m.product_double), ("product single", m.product_single)] {
            writeln!(f, "  {name:<20} {:9.2}            Gflop/s", 1e-9 * rate)?;
        }
        match self.peak_memory_bytes {
            Some(bytes) => writeln!(f, "peak memory of the steps {:.0} MB", 1e-6 * bytes as f64),
            None => Ok(()),
        }
    }
}

fn write_steps(f: &mut Formatter<'_>, s: &Steps) -> Result {
    writeln!(f, "\n{} × {} steps from t = {} s to {} s", s.repeat, s.steps, s.from, s.to)?;
    writeln!(
        f,
        "{:.3} ms a step, {:.3} to {:.3} for eight of ten; {:.2} iterations, {:.3} Jacobians",
        1e3 * s.seconds.median,
        1e3 * s.seconds.fast,
        1e3 * s.seconds.slow,
        s.newton_steps,
        s.jacobians
    )?;
    writeln!(
        f,
        "{:.2} applications of factors, {:.3} factorisations",
        s.linear_iterations, s.factorizations
    )?;
    writeln!(f, "\nmean step                     ms      part   ns/unknown")?;
    for ((name, seconds), (_, per_unknown)) in s.phases.named().into_iter().zip(s.per_unknown.named()) {
        let part = 100.0 * seconds / s.phases.wall;
        writeln!(f, "  {name:<20} {:9.3} {part:7.1} % {:12.2}", 1e3 * seconds, 1e9 * per_unknown)?;
    }
    if !s.cycles.is_empty() {
        writeln!(f, "\nmultigrid in a step           ms      part         GB/s")?;
    }
    for CyclePart { part: name, seconds, rate } in &s.cycles {
        let part = 100.0 * seconds / s.phases.wall;
        writeln!(f, "  {name:<20} {:9.3} {part:7.1} % {:12.2}", 1e3 * seconds, 1e-9 * rate)?;
    }
    Ok(())
}

fn write_kernels(f: &mut Formatter<'_>, kernels: &Kernels) -> Result {
    writeln!(f, "\nkernel                        ms   Gflop/s      GB/s")?;
    for (name, timing) in kernels.named() {
        match timing {
            None => {
                let reason = kernels.left_out.get(name).map_or("", String::as_str);
                writeln!(f, "  {name:<20} left out: {reason}")?;
            }
            Some(Timing { seconds, flops, bytes, .. }) => {
                write!(f, "  {name:<20} {:9.3}", 1e3 * seconds)?;
                for amount in [flops, bytes].into_iter().flatten() {
                    write!(f, " {:9.2}", 1e-9 * amount / seconds)?;
                }
                writeln!(f)?;
            }
        }
    }
    if let (Some(delayed), Some(held)) = (kernels.delayed, kernels.held) {
        writeln!(f, "factor_single: {delayed} delayed pivots, {:.1} MB held", 1e-6 * held as f64)?;
    }
    if let (Some(residuals), Some(deviation)) = (kernels.difference_residuals, kernels.difference_deviation) {
        writeln!(f, "differences: {residuals} residuals, {deviation:.1e} from dual numbers")?;
    }
    Ok(())
}
