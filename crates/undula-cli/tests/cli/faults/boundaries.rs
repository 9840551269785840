//! Nodes at which boundaries of different bodies meet.
