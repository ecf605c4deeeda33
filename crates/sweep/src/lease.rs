//! Who works on a trial: a lock with a heartbeat, for machines that share nothing but a folder.
//!
//! Taking a trial up makes the file `claims/<id>.<n>`, where `n` is one more than that of the last who did:
//! making it succeeds for one process only. A lease counts while its file is written to from time to time, or
//! until it is given up. On the same machine the system says it sooner: the file is locked while its process lives.
//!
//! A process may be thought dead and live. Nothing it does then counts: who comes next first takes the folder that
//! it works in away from it, by renaming it, and a result appears as a whole.

use std::collections::HashSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use crate::error::{Error, Result};
use crate::folder::SweepFolder;

/// Heartbeats in the time after which a lease without one is over.
const BEATS: u32 = 8;
/// Heartbeats that must be missing, whatever time who looks at a lease has in mind.
const MISSED: f64 = 3.0;
/// Prefix of the name of a lease until it is whole.
const NEW: &str = ".new-";

/// Who holds a lease.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Holder {
    /// Machine.
    pub host: String,
    /// Process on that machine.
    pub pid: u32,
    /// Identifies the machine's current boot; empty where the system does not say.
    boot: String,
    /// Seconds between two heartbeats.
    beat: f64,
    /// Whether the trial was given up.
    free: bool,
}

/// A trial that this process works on.
pub(crate) struct Lease<'a> {
    folder: &'a SweepFolder,
    identity: String,
    generation: u32,
    file: File,
    holder: Holder,
    heart: Option<(Sender<()>, JoinHandle<()>)>,
}

/// The result of taking a trial up.
pub(crate) enum Taken<'a> {
    Mine(Lease<'a>),
    Held(Holder),
}

impl Holder {
    fn me() -> Self {
        let read = |path| fs::read_to_string(path).map(|text| text.trim().to_string()).unwrap_or_default();
        Holder {
            host: read("/proc/sys/kernel/hostname"),
            pid: std::process::id(),
            boot: read("/proc/sys/kernel/random/boot_id"),
            beat: 0.0,
            free: false,
        }
    }

    /// Returns the machine of this process.
    pub(crate) fn host() -> String {
        Holder::me().host
    }

    fn bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }
}

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "process {} on {}", self.pid, self.host)
    }
}

impl<'a> Lease<'a> {
    /// Takes a trial up, unless somebody else is at it; one who has not been heard of for `stale` is not.
    ///
    /// # Errors
    /// A lease that cannot be read or written.
    pub fn take(folder: &'a SweepFolder, identity: &str, stale: Duration) -> Result<Taken<'a>> {
        let mut generation = 0;
        let mut last = None;
        while let Some(file) = open(&folder.lease(identity, generation + 1))? {
            generation += 1;
            last = Some(file);
        }
        if let Some(mut file) = last {
            let path = folder.lease(identity, generation);
            let holder = read(&mut file);
            if !is_over(&file, holder.as_ref(), stale, &folder.leases())
                .map_err(|e| Error::io(&path, "read", e))?
            {
                return Ok(Taken::Held(holder.unwrap_or_else(Holder::me)));
            }
        }
        generation += 1;
        let path = folder.lease(identity, generation);
        let every = stale / BEATS;
        let holder = Holder { beat: every.as_secs_f64(), ..Holder::me() };
        match publish(&path, &holder).map_err(|e| Error::io(&path, "written", e))? {
            // Somebody was quicker.
            None => Ok(Taken::Held(open(&path)?.and_then(|mut file| read(&mut file)).unwrap_or(holder))),
            Some(file) => {
                let heart = beat(&file, &holder, every).map_err(|e| Error::io(&path, "written", e))?;
                let identity = identity.into();
                Ok(Taken::Mine(Lease { folder, identity, generation, file, holder, heart: Some(heart) }))
            }
        }
    }

    /// Returns how many times the trial was taken up, this one included.
    pub fn attempts(&self) -> u32 {
        self.generation
    }

    /// Returns the folder to work in, with the files that earlier processes left there.
    ///
    /// # Errors
    /// A folder that cannot be renamed.
    pub fn work(&self) -> Result<PathBuf> {
        let work = self.folder.work(&self.identity, self.generation);
        for generation in (1..self.generation).rev() {
            let before = self.folder.work(&self.identity, generation);
            match fs::rename(&before, &work) {
                Ok(()) => {
                    // The lock of one who is thought dead; he can write here no more.
                    let _ = fs::remove_file(work.join(".lock"));
                    break;
                }
                Err(e) if e.kind() == ErrorKind::NotFound => {}
                Err(e) => return Err(Error::io(&before, "renamed", e)),
            }
        }
        Ok(work)
    }

    /// Returns the holder that took the trial up since, because this process seemed dead.
    ///
    /// # Errors
    /// A lease that cannot be read.
    pub fn successor(&self) -> Result<Option<Holder>> {
        let next = open(&self.folder.lease(&self.identity, self.generation + 1))?;
        Ok(next.map(|mut file| read(&mut file).unwrap_or_else(Holder::me)))
    }

    /// Gives the trial up: the next one need not wait.
    pub fn release(mut self) -> Result<()> {
        self.stop_heart();
        let holder = Holder { free: true, ..self.holder.clone() };
        let path = self.folder.lease(&self.identity, self.generation);
        rewrite(&mut self.file, &holder).map_err(|e| Error::io(&path, "written", e))
    }

    /// Takes away all leases on a finished trial, and what was left in its working folders.
    pub fn finish(mut self) -> Result<()> {
        self.stop_heart();
        tidy(self.folder, &self.identity, self.generation)
    }

    fn stop_heart(&mut self) {
        if let Some((stop, heart)) = self.heart.take() {
            drop(stop);
            // It only sleeps and writes: there is nothing to say where it has ended early.
            let _ = heart.join();
        }
    }
}

/// Takes away what processes that were killed just before their end have left of a finished trial.
pub(crate) fn tidy_up(folder: &SweepFolder, identity: &str) -> Result<()> {
    let mut generation = 0;
    while folder.lease(identity, generation + 1).exists() {
        generation += 1;
    }
    tidy(folder, identity, generation)
}

/// Removes leases and working folders, the last lease first: a process that looks for them meanwhile finds those before
/// it.
fn tidy(folder: &SweepFolder, identity: &str, last: u32) -> Result<()> {
    for generation in (1..=last).rev() {
        let work = folder.work(identity, generation);
        gone(fs::remove_dir_all(&work), &work)?;
        let lease = folder.lease(identity, generation);
        gone(fs::remove_file(&lease), &lease)?;
    }
    Ok(())
}

/// Takes away leases that were never whole; for a sweep that is finished.
pub(crate) fn tidy_all(folder: &SweepFolder) -> Result<()> {
    for name in names(&folder.leases())?.iter().filter(|name| name.starts_with(NEW)) {
        let path = folder.leases().join(name);
        gone(fs::remove_file(&path), &path)?;
    }
    Ok(())
}

/// Returns the stems of all leases: of trials that somebody took up and has not tidied up yet.
pub(crate) fn begun(folder: &SweepFolder) -> Result<HashSet<String>> {
    let stem = |name: String| name.split('.').next().map(String::from).unwrap_or_default();
    Ok(names(&folder.leases())?.into_iter().map(stem).collect())
}

/// Lists the names of the files of a folder; none where there is no such folder.
fn names(folder: &Path) -> Result<Vec<String>> {
    let failed = |e| Error::io(folder, "read", e);
    match fs::read_dir(folder) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(vec![]),
        entries => entries
            .map_err(failed)?
            .map(|entry| Ok(entry.map_err(failed)?.file_name().to_string_lossy().into_owned()))
            .collect(),
    }
}

/// Accepts that a file to be removed is gone already.
fn gone(removed: std::io::Result<()>, path: &Path) -> Result<()> {
    match removed {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(Error::io(path, "removed", e)),
        _ => Ok(()),
    }
}

fn open(path: &Path) -> Result<Option<File>> {
    match OpenOptions::new().read(true).write(true).open(path) {
        Ok(file) => Ok(Some(file)),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(Error::io(path, "read", e)),
    }
}

/// Reads the holder of a lease; none while the file is being written.
fn read(file: &mut File) -> Option<Holder> {
    let mut bytes = vec![];
    file.read_to_end(&mut bytes).ok()?;
    serde_json::from_slice(&bytes).ok()
}

/// Makes a lease, whole, locked and in one step; none where there is one.
fn publish(path: &Path, holder: &Holder) -> std::io::Result<Option<File>> {
    let mut file = NamedTempFile::with_prefix_in(NEW, path.parent().unwrap_or(Path::new(".")))?;
    file.as_file().lock()?;
    file.write_all(&holder.bytes())?;
    match file.persist_noclobber(path) {
        Ok(file) => Ok(Some(file)),
        Err(e) if e.error.kind() == ErrorKind::AlreadyExists => Ok(None),
        Err(e) => Err(e.error),
    }
}

/// Checks whether nobody stands behind a lease any more.
fn is_over(file: &File, holder: Option<&Holder>, stale: Duration, folder: &Path) -> std::io::Result<bool> {
    if holder.is_some_and(|holder| holder.free) {
        return Ok(true);
    }
    let me = Holder::me();
    if !me.boot.is_empty() && holder.is_some_and(|holder| holder.boot == me.boot) {
        match file.try_lock() {
            Ok(()) => return Ok(true),
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(e)) => return Err(e),
        }
    }
    // Both times are the file system's: the clocks of two machines need not agree.
    let now = tempfile::tempfile_in(folder).and_then(|mut probe| {
        probe.write_all(b".")?;
        probe.sync_all()?;
        probe.metadata()?.modified()
    })?;
    let least = MISSED * holder.map_or(0.0, |holder| holder.beat);
    let Ok(age) = now.duration_since(file.metadata()?.modified()?) else {
        // A heartbeat from the future: the clock was set back since. It counts as one of now, or a dead process
        // would hold its lease until the clock is there again. Somebody else's file may refuse it, and stays.
        let _ = file.set_modified(now);
        return Ok(false);
    };
    Ok(age > stale && age.as_secs_f64() > least)
}

/// Flushes the lease to where other machines see it, while the work begins, and writes it again and again until
/// the sender is dropped.
fn beat(file: &File, holder: &Holder, every: Duration) -> std::io::Result<(Sender<()>, JoinHandle<()>)> {
    let (mut file, holder) = (file.try_clone()?, holder.clone());
    let (sender, receiver) = mpsc::channel::<()>();
    let heart = std::thread::Builder::new().name("heartbeat".into()).spawn(move || {
        let _ = file.sync_data();
        while receiver.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
            // A beat that cannot be written is one that nobody hears: the lease turns stale.
            let _ = rewrite(&mut file, &holder);
        }
    })?;
    Ok((sender, heart))
}

fn rewrite(file: &mut File, holder: &Holder) -> std::io::Result<()> {
    let bytes = holder.bytes();
    file.rewind()?;
    file.write_all(&bytes)?;
    file.set_len(bytes.len() as u64)?;
    file.sync_data()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(600);

    fn sweep() -> (tempfile::TempDir, SweepFolder) {
        let dir = tempfile::tempdir().unwrap();
        let folder = SweepFolder::at(dir.path());
        folder.make().unwrap();
        (dir, folder)
    }

    fn mine(taken: Taken) -> Lease {
        match taken {
            Taken::Mine(lease) => lease,
            Taken::Held(holder) => panic!("held by {holder}"),
        }
    }

    fn is_held(folder: &SweepFolder, stale: Duration) -> bool {
        matches!(Lease::take(folder, "trial", stale).unwrap(), Taken::Held(_))
    }

    #[test]
    fn one_of_many_gets_it_and_the_next_when_it_is_given_up() {
        let (_dir, folder) = sweep();
        let count = std::sync::atomic::AtomicUsize::new(0);
        let leases = std::sync::Mutex::new(vec![]);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    if let Taken::Mine(lease) = Lease::take(&folder, "trial", LONG).unwrap() {
                        count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                        leases.lock().unwrap().push(lease);
                    }
                });
            }
        });
        assert_eq!(count.into_inner(), 1);
        leases.into_inner().unwrap().pop().unwrap().release().unwrap();
        let second = mine(Lease::take(&folder, "trial", LONG).unwrap());
        assert_eq!(second.attempts(), 2);
        second.finish().unwrap();
        assert_eq!(fs::read_dir(folder.leases()).unwrap().count(), 0);
    }

    #[test]
    fn a_lease_whose_process_is_gone_is_over_at_once_here_and_after_a_while_elsewhere() {
        let (_dir, folder) = sweep();
        // As a killed process leaves it: nobody locks the file any more.
        fs::write(folder.lease("trial", 1), Holder::me().bytes()).unwrap();
        mine(Lease::take(&folder, "trial", LONG).unwrap()).finish().unwrap();
        let elsewhere = Holder { boot: "another machine".into(), ..Holder::me() };
        fs::write(folder.lease("trial", 1), elsewhere.bytes()).unwrap();
        assert!(is_held(&folder, LONG));
        std::thread::sleep(Duration::from_millis(60));
        assert_eq!(mine(Lease::take(&folder, "trial", Duration::from_millis(50)).unwrap()).attempts(), 2);
    }

    #[test]
    fn a_heart_that_beats_keeps_the_lease() {
        let (_dir, folder) = sweep();
        let stale = Duration::from_millis(800);
        let lease = mine(Lease::take(&folder, "trial", stale).unwrap());
        std::thread::sleep(Duration::from_millis(1200));
        assert!(is_held(&folder, stale));
        assert!(is_held(&folder, Duration::ZERO), "its next beat is not due yet");
        lease.release().unwrap();
    }

    #[test]
    fn a_clock_that_is_set_back_neither_breaks_a_lease_nor_keeps_it() {
        let (_dir, folder) = sweep();
        let stale = Duration::from_millis(50);
        let elsewhere = Holder { boot: "another machine".into(), ..Holder::me() };
        let path = folder.lease("trial", 1);
        fs::write(&path, elsewhere.bytes()).unwrap();
        let file = File::options().write(true).open(&path).unwrap();
        let beat = file.metadata().unwrap().modified().unwrap();
        file.set_modified(beat + Duration::from_secs(86400)).unwrap();
        assert!(is_held(&folder, stale), "its next beat is not due yet");
        std::thread::sleep(2 * stale);
        assert_eq!(mine(Lease::take(&folder, "trial", stale).unwrap()).attempts(), 2);
    }

    #[test]
    fn who_is_thought_dead_loses_his_working_folder() {
        let (_dir, folder) = sweep();
        let soon = Duration::from_millis(20);
        let mut first = mine(Lease::take(&folder, "trial", soon).unwrap());
        let before = first.work().unwrap();
        fs::create_dir(&before).unwrap();
        fs::write(before.join("saved"), "half").unwrap();
        // As if its machine were paused.
        first.stop_heart();
        std::thread::sleep(5 * soon);
        let second = mine(Lease::take(&folder, "trial", soon).unwrap());
        let work = second.work().unwrap();
        assert_eq!(first.successor().unwrap().map(|holder| holder.pid), Some(std::process::id()));
        assert_eq!(second.successor().unwrap(), None);
        assert_eq!(fs::read_to_string(work.join("saved")).unwrap(), "half");
        assert!(fs::write(before.join("more"), "").is_err(), "its folder is gone");
    }
}
