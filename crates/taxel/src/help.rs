//! `taxel --help`: the commands in groups, by what they are for.

use clap::Command;

/// Titles of the groups and their commands; a build without some of them leaves those out.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Data: your recordings, or simulated ones", &["record", "data", "simulate", "encode"]),
    ("Train: networks on recordings", &["init", "run", "zoo", "cost", "import", "forward", "stitch"]),
    ("Judge: which network to take", &["report", "results", "choose", "compare", "stress", "shrink"]),
    ("Ship: a model on a robot", &["fit", "calibrate", "predict", "stream", "inspect", "quantize", "export"]),
    ("Study: many experiments on many machines", &["sweep"]),
    ("Other", &["schema", "completions", "man", "help"]),
];

/// Width of the column of names.
const NAMES: usize = 12;

/// Shows the commands of the top level in their groups.
pub fn grouped(command: Command) -> Command {
    let groups: Vec<String> =
        GROUPS.iter().filter_map(|(title, names)| group(&command, title, names)).collect();
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{}\n\nOptions:\n{{options}}{{after-help}}",
        groups.join("\n\n")
    ))
}

/// Returns a title with a line for each command of the group; none where this build has none of them.
fn group(command: &Command, title: &str, names: &[&str]) -> Option<String> {
    let line = |name: &&str| {
        let about = match command.find_subcommand(name) {
            Some(found) => found.get_about().map(ToString::to_string).unwrap_or_default(),
            // clap adds it.
            None if *name == "help" => "Prints this help, or that of a command".into(),
            None => return None,
        };
        Some(format!("  {name:NAMES$} {about}"))
    };
    let lines: Vec<String> = names.iter().filter_map(line).collect();
    (!lines.is_empty()).then(|| format!("{title}\n{}", lines.join("\n")))
}

#[cfg(all(test, feature = "lab"))]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::BTreeMap;

    use clap::CommandFactory;

    use super::*;
    use crate::Arguments;

    /// Collects every command that runs something, with its name.
    fn leaves(command: &Command, name: &str, found: &mut Vec<(String, Command)>) {
        if command.get_subcommands().next().is_none() {
            found.push((name.into(), command.clone()));
        }
        for below in command.get_subcommands() {
            leaves(below, &format!("{name} {}", below.get_name()), found);
        }
    }

    fn all() -> Vec<(String, Command)> {
        let mut found = vec![];
        leaves(&Arguments::command(), "taxel", &mut found);
        found
    }

    #[test]
    fn every_command_is_in_one_group() {
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        let command = Arguments::command();
        let mut known: Vec<&str> = command.get_subcommands().map(Command::get_name).chain(["help"]).collect();
        grouped.sort_unstable();
        known.sort_unstable();
        assert_eq!(grouped, known);
    }

    #[test]
    fn every_command_has_an_example_and_every_argument_a_help() {
        for (name, mut command) in all() {
            let help = command.render_long_help().to_string();
            assert!(help.contains("Example"), "{name} --help has no example");
            for argument in command.get_arguments() {
                assert!(argument.get_help().is_some(), "{name}: {} has no help", argument.get_id());
            }
        }
    }

    /// Checks that a flag means the same wherever it stands: it takes the same kind of value, and its help begins with
    /// the same words unless it is listed here with why.
    #[test]
    fn a_flag_has_one_meaning() {
        // A first look in every command, each with its own way to be short; a fault and its severity, tested or simulated; how
        // many of what the command makes; a model, or a network of the zoo in its place; what a scene or a prediction is
        // made of; what is aimed at, in the data or on a board.
        let one_idea = [
            "count", "explain", "fault", "input", "model", "output", "quick", "set", "severity", "margin",
            "target", "weights",
        ];
        let mut meanings: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
        for (name, command) in all() {
            for argument in command.get_arguments().filter(|argument| !argument.is_hide_set()) {
                let Some(flag) = argument.get_long() else { continue };
                let help = argument.get_help().unwrap().to_string();
                let words: Vec<&str> = help.split_whitespace().take(4).collect();
                let meaning = format!("{:?} {}", argument.get_value_names(), words.join(" "));
                meanings.entry(flag.into()).or_default().push((meaning, name.clone()));
            }
        }
        for (flag, uses) in meanings.iter().filter(|(flag, _)| !one_idea.contains(&flag.as_str())) {
            assert!(uses.iter().all(|(meaning, _)| *meaning == uses[0].0), "--{flag}: {uses:?}");
        }
        for old in ["json", "out"] {
            assert!(!meanings.contains_key(old), "--{old} is an old name");
        }
    }
}
