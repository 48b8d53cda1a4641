//! Flight: plans, their file formats and checks, geodesy and plane guidance. Pure functions, no I/O, no clock.

pub mod guidance;
