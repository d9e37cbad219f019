//! The `mcubes` command.

fn main() {}
