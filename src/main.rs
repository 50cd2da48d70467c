//! The `narrowbeam` program.

fn main() -> std::process::ExitCode {
    narrowbeam::cli::main()
}

/// Images are allocated and freed often. This allocator keeps their memory; the system's returns it and has it cleared again.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;
