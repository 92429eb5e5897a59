//! Settings from a table of a batch file.

use crate::error::BakeError;
use crate::settings::Settings;
use clap::{ArgAction, Command, CommandFactory, Parser};
use toml::{Table, Value};

/// The options alone, without a program's name before them.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Options {
    #[command(flatten)]
    settings: Settings,
}

impl Settings {
    /// Reads a table. Its keys are the names of the options with `_` for `-`, and every value is read
    /// by the parser of its option; `trim = false` is `--no-trim`.
    ///
    /// # Errors
    /// [`BakeError::Setting`] for an unknown key or a value that its option refuses.
    pub fn from_table(table: &Table) -> Result<Settings, BakeError> {
        let wrong = |option: &str, reason| BakeError::Setting {
            option: option.into(),
            reason,
        };
        let (command, mut options) = (Options::command(), Vec::new());
        for (key, value) in table {
            let typed = typed(&command, key, value).map_err(|reason| wrong(key, reason))?;
            options.extend(typed);
        }
        let parsed = Options::try_parse_from(options);
        Ok(parsed
            .map_err(|error| wrong("settings", reason(&error)))?
            .settings)
    }
}

/// A key and its value as they are typed on the command line; none where that is nothing.
fn typed(command: &Command, key: &str, value: &Value) -> Result<Option<String>, String> {
    let Some(arg) = command.get_arguments().find(|arg| arg.get_id() == key) else {
        let known = command.get_arguments().map(|arg| arg.get_id().as_str());
        let known: Vec<&str> = known.collect();
        return Err(format!(
            "is no setting; the settings are {}",
            known.join(", ")
        ));
    };
    let name = arg.get_long().unwrap_or_default();
    match (arg.get_action(), value) {
        (ArgAction::SetFalse, Value::Boolean(true)) => Ok(None),
        (ArgAction::SetFalse, Value::Boolean(false)) => Ok(Some(format!("--{name}"))),
        (ArgAction::SetFalse, _) => Err("needs true or false".into()),
        _ => {
            let text = text(value).ok_or_else(|| format!("cannot be {value}"))?;
            Ok(Some(format!("--{name}={text}")))
        }
    }
}

/// The text of a value, lists with commas.
fn text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(number.to_string()),
        Value::Array(values) => {
            let texts: Option<Vec<String>> = values.iter().map(text).collect();
            Some(texts?.join(","))
        }
        _ => None,
    }
}

/// The first paragraph of a parser's message, on one line.
fn reason(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.trim_start_matches("error: ");
    let first = text.split("\n\n").next().unwrap_or(text);
    first.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
