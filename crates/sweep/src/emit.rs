//! Scripts for schedulers: Slurm's arrays, and make.

use std::path::{Path, PathBuf};

use crate::chunks::{Task, Tasks};
use crate::error::{Error, Result};
use crate::folder::SweepFolder;

/// Program and threads that scripts name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Emit {
    /// The program, by its absolute path.
    pub program: PathBuf,
    /// Threads of a task.
    pub threads: usize,
}

/// Settings of Slurm's job arrays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arrays {
    /// Tasks of one array: Slurm's `MaxArraySize` less one, and what a user may submit.
    pub max: usize,
    /// Further options of `sbatch`: `--partition=short`.
    pub options: Vec<String>,
}

/// Writes `slurm/submit.sh` below the sweep's folder, with what it needs beside it. The path of `submit.sh`.
///
/// # Errors
/// A path that no shell can name, a file that cannot be written.
pub fn slurm(folder: &SweepFolder, tasks: &Tasks, emit: &Emit, arrays: &Arrays) -> Result<PathBuf> {
    if arrays.max == 0 {
        let reason = "must be at least 1".into();
        return Err(Error::Value { key: "tasks of an array", value: "0".into(), reason });
    }
    let root = absolute(folder.path())?;
    let out = root.join("slurm");
    let logs = out.join("logs");
    std::fs::create_dir_all(&logs).map_err(|e| Error::io(&logs, "created", e))?;
    let (sweep, taxel) = (quoted(&root)?, quoted(&emit.program)?);
    let list: String = tasks.tasks.iter().map(|Task { first, count }| format!("{first} {count}\n")).collect();
    write(&out.join("tasks"), &list)?;
    let task = include_str!("task.sh")
        .replace("@TASKS@", &quoted(&out.join("tasks"))?)
        .replace("@TAXEL@", &taxel)
        .replace("@SWEEP@", &sweep);
    write(&out.join("task.sh"), &task)?;
    write(&out.join("collect.sh"), &format!("#!/bin/sh\nexec {taxel} sweep collect {sweep}\n"))?;
    let options = arrays.options.iter().map(|option| shell(option)).collect::<Result<Vec<_>>>()?;
    let log = quoted(&logs)?;
    let mut text = format!(
        "#!/bin/sh\n# {} of {} trials have no result: {} tasks of at most {} of them.\nset -eu\n\
         common() {{ sbatch --parsable --job-name=taxel-sweep {} \"$@\"; }}\n\
         array() {{ common --cpus-per-task={} --requeue --open-mode=append --signal=B:USR1@60 \
         --output={log}/%A_%a.txt \"$@\"; }}\njobs=\n",
        tasks.missing,
        tasks.planned,
        tasks.tasks.len(),
        tasks.each,
        options.join(" "),
        emit.threads,
    );
    let script = quoted(&out.join("task.sh"))?;
    for first in (0..tasks.tasks.len()).step_by(arrays.max) {
        let last = arrays.max.min(tasks.tasks.len() - first) - 1;
        // The part before a semicolon: the other one names a cluster.
        text += &format!("job=$(array --array=0-{last} {script} {first})\njobs=$jobs:${{job%%;*}}\n");
    }
    let collect = quoted(&out.join("collect.sh"))?;
    let dependency = if tasks.tasks.is_empty() { "" } else { "--dependency=afterany\"$jobs\" " };
    text += &format!("common {dependency}--output={log}/collect_%j.txt {collect}\n");
    let submit = out.join("submit.sh");
    write(&submit, &text)?;
    Ok(submit)
}

/// Writes a `Makefile` below the sweep's folder: `make -j 4 -f Makefile`. Its path.
///
/// # Errors
/// As [`slurm`].
pub fn make(folder: &SweepFolder, tasks: &Tasks, emit: &Emit) -> Result<PathBuf> {
    let root = absolute(folder.path())?;
    let plain = |path: &Path| Ok::<_, Error>(quoted(path)?.replace('$', "$$"));
    let (sweep, taxel) = (plain(&root)?, plain(&emit.program)?);
    let names: Vec<String> =
        tasks.tasks.iter().map(|Task { first, count }| format!("{first}+{count}")).collect();
    let text = format!(
        "# {} of {} trials have no result: {} tasks of at most {} of them.\n\
         # A task that fails or is stopped does not keep the others from being collected.\n\
         tasks := {}\n\
         .PHONY: collect $(tasks)\n\
         collect: $(tasks)\n\t{taxel} sweep collect {sweep}\n\
         $(tasks):\n\t-{taxel} sweep run-one {sweep} --index $(firstword $(subst +, ,$@)) \
         --count $(lastword $(subst +, ,$@)) --threads {}\n",
        tasks.missing,
        tasks.planned,
        names.len(),
        tasks.each,
        names.join(" "),
        emit.threads,
    );
    let path = root.join("Makefile");
    write(&path, &text)?;
    Ok(path)
}

fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).map_err(|e| Error::io(path, "located", e))
}

/// Quotes a path as one word of a shell.
fn quoted(path: &Path) -> Result<String> {
    let text = path.to_str().filter(|text| !text.contains('\n'));
    shell(text.ok_or_else(|| Error::file(path, "cannot stand in a script; give a path of plain text"))?)
}

fn shell(word: &str) -> Result<String> {
    let refuse = |e: shlex::QuoteError| Error::Value {
        key: "word of a script",
        value: format!("{word:?}"),
        reason: e.to_string(),
    };
    shlex::try_quote(word).map(String::from).map_err(refuse)
}

fn write(path: &Path, text: &str) -> Result<()> {
    taxel_base::files::write_whole(path, text.as_bytes()).map_err(|e| Error::io(path, "written", e))
}
