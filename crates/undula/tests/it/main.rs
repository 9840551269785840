//! The library from outside: what its modules do together, and every claim of the documentation.
//!
//! One program, because linking it is what takes time. `cargo test --test it patch` runs one file of it. Tests that
//! need a process of their own are programs beside it.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/manufactured.rs"]
mod manufactured;

mod apply;
mod assembly;
mod axisymmetric;
mod backflow;
mod bars;
mod bench;
mod borders;
mod case_errors;
mod case_files;
mod cases;
mod condensed;
mod convergence_combinations;
mod convergence_elements;
mod convergence_in_space;
mod convergence_space;
mod convergence_stabilized;
mod convergence_time;
mod damping;
mod derivatives;
mod displacement;
mod elements;
mod energy_balance;
mod examples;
mod extension;
mod fibres;
mod functionals;
mod gmsh_in_space;
mod hierarchy;
mod hydrofoil;
mod incompressible;
mod initial;
mod keys;
mod krylov;
mod layering;
mod lengths;
mod linearization;
mod materials;
mod mesh;
mod mesh_in_space;
mod methods;
mod modes;
mod moment;
mod moving_walls;
mod newton;
mod outlets;
mod output_fields;
mod output_vtu;
mod own_problems;
mod patch;
mod patch_in_space;
mod periodic;
mod pressure;
mod prestress;
mod profiles;
mod references;
mod reproducible;
mod resume;
mod ring;
mod rotor;
mod runge_kutta;
mod several_bodies;
mod slip;
mod solid_cases;
mod stability;
mod stabilization;
mod statistics;
mod studies;
mod tables;
mod tetrahedra;
mod traction;
mod transfer;
mod valve;
mod vibration;
mod viscosity;
mod vtu_meshes;
mod walled_cases;
mod walls;
mod womersley;
