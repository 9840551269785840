//! Forces on parts of boundaries.
