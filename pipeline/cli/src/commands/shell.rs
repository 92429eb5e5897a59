//! `rrf completions`, `rrf man`: what shells and `man` know of the command line.

use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

/// Print a script that completes commands and options.
///
/// For bash, add this line to ~/.bashrc: source <(rrf completions bash)
#[derive(Args, Clone, Debug)]
pub struct CompletionsArgs {
    /// The shell.
    pub shell: Shell,
}

/// Write a page for `man` about each command.
#[derive(Args, Clone, Debug)]
pub struct ManArgs {
    /// Folder for the pages, such as ~/.local/share/man/man1.
    pub folder: PathBuf,
}

/// Prints the script.
pub fn completions(args: &CompletionsArgs) {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut crate::command(), "rrf", &mut script);
    print!("{}", String::from_utf8_lossy(&script));
}

/// Writes rrf.1, rrf-bake.1 and so on.
pub fn man(args: &ManArgs) -> anyhow::Result<()> {
    rrf_store::atomic::create_folder(&args.folder)?;
    let mut command = crate::command();
    command.build();
    let mut written = 0;
    for page in std::iter::once(&command).chain(command.get_subcommands()) {
        let name = match page.get_name() {
            "help" => continue,
            "rrf" => "rrf".to_string(),
            name => format!("rrf-{name}"),
        };
        let mut text = Vec::new();
        clap_mangen::Man::new(page.clone()).render(&mut text)?;
        rrf_files::replace(&args.folder.join(format!("{name}.1")), &text)?;
        written += 1;
    }
    println!("{written} pages: {}", args.folder.display());
    Ok(())
}
