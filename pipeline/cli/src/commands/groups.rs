//! The list of commands, by what they are for.

use clap::Command;

/// Commands by what they are for.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Bake", &["scene", "bake", "run"]),
    ("Look", &["render", "view", "query", "trace", "compare"]),
    (
        "Inspect and pass on",
        &["verify", "inspect", "chart", "report", "sweep", "export"],
    ),
    (
        "Stage by stage, and on clusters",
        &["extract", "train", "plan", "task", "commit"],
    ),
    ("This program", &["doctor", "completions", "man", "help"]),
];

/// A command whose help lists its subcommands by group; those in no group come last.
pub fn grouped(command: Command) -> Command {
    let subcommands: Vec<&Command> = command.get_subcommands().collect();
    let about = |command: &&Command| {
        let about = command.get_about().map(ToString::to_string);
        let about = about.unwrap_or_default();
        about.lines().next().unwrap_or_default().to_string()
    };
    let find = |name: &str| {
        subcommands
            .iter()
            .find(|command| command.get_name() == name)
    };
    let line = |name: &str, about: &str| format!("  {name:<12} {about}\n");
    let mut text = String::new();
    for (heading, names) in GROUPS {
        text += &format!("\n {heading}\n");
        for name in names {
            match (find(name), *name) {
                (Some(command), _) => text += &line(name, &about(command)),
                (None, "help") => text += &line(name, "Print the help of a command"),
                (None, _) => {}
            }
        }
    }
    let listed = |name: &str| GROUPS.iter().any(|(_, names)| names.contains(&name));
    for command in subcommands.iter().filter(|c| !listed(c.get_name())) {
        text += &line(command.get_name(), &about(command));
    }
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\nCommands:{text}\nOptions:\n{{options}}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    /// Every command is in one group, and every name of a group is a command.
    #[test]
    fn groups_hold_every_command_once() {
        let command = crate::Cli::command();
        let names: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
        let grouped: Vec<&str> = GROUPS
            .iter()
            .flat_map(|(_, names)| names.iter().copied())
            .collect();
        for name in &names {
            assert_eq!(grouped.iter().filter(|g| *g == name).count(), 1, "{name}");
        }
        for name in &grouped {
            assert!(names.contains(name) || *name == "help", "{name}");
        }
    }
}
