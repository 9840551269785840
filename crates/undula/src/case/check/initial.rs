//! The table `[initial]`.

use crate::case::Initial;
use crate::case::read::Section;

/// What the case begins with.
pub(super) fn initial(mut s: Section<'_, '_>, in_time: bool) -> Option<Initial> {
    let from = s.string("from").map(|from| super::resolve(&s, "from", &from));
    let (velocity, displacement) = (s.expressions("velocity"), s.expressions("displacement"));
    let at_rest = s.boolean("static", false);
    let keys = ["from", "velocity", "displacement", "static"];
    if s.is_present() && !keys.iter().any(|key| s.has(key)) {
        s.missing("from", "the output directory of the run whose last state is the first of this one");
    }
    if let (false, Some(key)) = (in_time, keys.iter().find(|key| s.has(key))) {
        s.wrong(key, "only for a case in time, with [time]: a stationary case has no start");
    }
    for key in ["velocity", "displacement"].into_iter().filter(|key| s.has(key)) {
        if s.has("from") {
            s.wrong(key, "initial.from gives the whole state already; remove one of the two");
        } else if at_rest {
            s.wrong(
                key,
                "with initial.static = true the stationary solution is the start; remove one of the two",
            );
        }
    }
    if at_rest && s.has("from") {
        s.wrong("static", "initial.from gives the whole state already; remove one of the two");
    }
    s.finish();
    match (from, at_rest) {
        (Some(from), _) => Some(Initial::From(from)),
        (None, true) => Some(Initial::Static),
        (None, false) if velocity.is_some() || displacement.is_some() => {
            Some(Initial::Fields { velocity, displacement })
        }
        (None, false) => None,
    }
}
