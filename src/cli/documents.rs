//! `narrowbeam completions` and `narrowbeam man`: what shells and readers of manuals need, made of the options themselves.

use super::console::print;
use super::errors::Usage;
use clap::Command;
use clap_complete::Shell;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

#[derive(Debug, clap::Args)]
pub(super) struct Man {
    /// The command that the page is about; without it the page is about all of them
    #[arg(value_name = "COMMAND")]
    command: Option<String>,
}

pub(super) fn completions(arguments: &Completions, mut program: Command) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    let name = program.get_name().to_string();
    clap_complete::generate(arguments.shell, &mut program, name, &mut script);
    print(&String::from_utf8(script)?);
    Ok(ExitCode::SUCCESS)
}

pub(super) fn man(arguments: &Man, mut program: Command) -> anyhow::Result<ExitCode> {
    // With the options of all commands in each.
    program.build();
    let about = match &arguments.command {
        None => program,
        Some(name) => {
            let unknown = || Usage(format!("man: there is no command {name}; narrowbeam --help lists them"));
            let command = program.find_subcommand(name).ok_or_else(unknown)?.clone();
            command.display_name(format!("narrowbeam-{name}"))
        }
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(about).render(&mut page)?;
    print(&String::from_utf8(page)?);
    Ok(ExitCode::SUCCESS)
}
