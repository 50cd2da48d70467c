//! The `narrowbeam` program.

fn main() -> std::process::ExitCode {
    narrowbeam::cli::main()
}
