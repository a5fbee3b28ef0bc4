//! Kernels of blocks of elements: force sweep, stretch rates, assembly.
fn main() {}
