//! `mcubes man`: one page for all commands, in roff.

use std::io::{self, Write};

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use super::args::{Cli, EXAMPLES};

/// The page.
pub(crate) fn page() -> String {
    let mut page = Vec::new();
    // Writing to memory cannot fail.
    let _ = write(&mut page);
    String::from_utf8_lossy(&page).into_owned()
}

fn write(page: &mut Vec<u8>) -> io::Result<()> {
    let mut command = Cli::command();
    // Arguments of all commands, and names as they are typed.
    command.build();
    let main = Man::new(command.clone());
    main.render_title(page)?;
    main.render_name_section(page)?;
    main.render_synopsis_section(page)?;
    main.render_description_section(page)?;
    main.render_options_section(page)?;
    for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
        section(page, sub)?;
    }
    // As it is laid out, not filled into paragraphs.
    writeln!(page, ".SH EXAMPLES\n.nf")?;
    for line in EXAMPLES.lines().skip(1) {
        writeln!(page, "\\&{}", line.replace('\\', "\\e").replace('-', "\\-"))?;
    }
    writeln!(page, ".fi")?;
    main.render_version_section(page)
}

/// A command's part of the page: what else would be sections of its own page are parts of it. What all
/// commands have stands once, above.
fn section(page: &mut Vec<u8>, command: &Command) -> io::Result<()> {
    let command = command.clone().mut_args(|arg| {
        let is_known = arg.is_global_set() || arg.get_id() == "help";
        arg.hide(is_known)
    });
    let name = command.get_bin_name().unwrap_or(command.get_name()).to_uppercase();
    let man = Man::new(command);
    let mut own = Vec::new();
    man.render_synopsis_section(&mut own)?;
    man.render_description_section(&mut own)?;
    man.render_options_section(&mut own)?;
    let own = String::from_utf8_lossy(&own).replace("\n.SH ", "\n.SS ");
    writeln!(page, ".SH \"{name}\"")?;
    page.write_all(own.as_bytes())
}
