//! Simulated robots with their own code path: forward dynamics, controller, sensors.
