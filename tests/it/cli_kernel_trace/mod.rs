//! `narrowbeam kernel` and `narrowbeam trace` as users meet them: files, headers, exit codes, messages.

mod kernel;
mod trace;
