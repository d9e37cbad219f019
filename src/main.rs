//! The `mcubes` command.

fn main() -> std::process::ExitCode {
    mcubes::cli::main()
}
