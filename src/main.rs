//! The `narrowbeam` program.

fn main() -> std::process::ExitCode {
    narrowbeam::cli::main()
}

/// Images come and go; this allocator keeps their memory where the system's gives it back and has it cleared anew.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;
