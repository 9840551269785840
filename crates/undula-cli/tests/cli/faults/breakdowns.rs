//! What a run that cannot go on says.
