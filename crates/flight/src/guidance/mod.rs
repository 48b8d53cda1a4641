//! Plane guidance: lateral (L1), height and speed (total energy) and attitude laws, as pure functions of state, target, parameters and time step.
