//! Child processes of the tests: their output, bounded waits, and their end in every case.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs::OpenOptions;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Longest wait for anything. It only prevents a broken test from hanging; no test measures time.
pub const PATIENCE: Duration = Duration::from_secs(240);
/// Interval between two checks of a wait.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// Output of a process so far, standard output and standard error together.
#[derive(Debug, Default)]
struct Log {
    lines: Vec<String>,
    /// Streams that have not ended.
    open: u8,
}

#[derive(Debug, Default)]
struct SharedLog {
    log: Mutex<Log>,
    changed: Condvar,
}

impl SharedLog {
    fn lock(&self) -> MutexGuard<'_, Log> {
        self.log.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A child process whose output is read line by line. It is killed on drop.
#[derive(Debug)]
pub struct Running {
    name: String,
    child: Child,
    stdin: Option<ChildStdin>,
    log: Arc<SharedLog>,
    readers: Vec<JoinHandle<()>>,
    /// Number of lines that earlier waits have consumed.
    passed: usize,
}

impl Running {
    /// Starts `command`; messages call it `name`.
    ///
    /// # Panics
    /// If the program cannot be started.
    pub fn start(name: &str, command: &mut Command) -> Self {
        let piped = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = piped
            .spawn()
            .unwrap_or_else(|error| panic!("{name}: cannot start: {error}"));
        let log = Arc::new(SharedLog::default());
        log.lock().open = 2;
        let mut readers = Vec::new();
        if let Some(stream) = child.stdout.take() {
            readers.push(read_lines(stream, log.clone()));
        }
        if let Some(stream) = child.stderr.take() {
            readers.push(read_lines(stream, log.clone()));
        }
        let stdin = child.stdin.take();
        Self {
            name: name.into(),
            child,
            stdin,
            log,
            readers,
            passed: 0,
        }
    }

    /// Writes a line to its standard input.
    ///
    /// # Panics
    /// If the process does not read any more.
    pub fn say(&mut self, line: &str) {
        let stdin = self.stdin.as_mut().expect("standard input is piped");
        if let Err(error) = writeln!(stdin, "{line}") {
            panic!(
                "{}: does not read `{line}`: {error}\n{}",
                self.name,
                self.transcript()
            );
        }
    }

    /// Waits for a line that contains `text`, after those that earlier waits found.
    ///
    /// # Panics
    /// If the process ends without it, or [`PATIENCE`] is over.
    pub fn wait_for(&mut self, text: &str) -> String {
        let found = self.heard_or_ended(text);
        found.unwrap_or_else(|| {
            panic!("{}: never said `{text}`\n{}", self.name, self.transcript());
        })
    }

    /// As [`Self::wait_for`]; none if the process has ended or [`PATIENCE`] is over.
    pub fn heard_or_ended(&mut self, text: &str) -> Option<String> {
        let give_up = Instant::now() + PATIENCE;
        loop {
            if let Some(line) = self.heard(text) {
                return Some(line);
            }
            let log = self.log.lock();
            if log.open == 0 || Instant::now() > give_up {
                drop(log);
                // The last lines may have come between the two checks.
                return self.heard(text);
            }
            drop(self.log.changed.wait_timeout(log, POLL_INTERVAL));
        }
    }

    /// The first line that contains `text`, after those that earlier waits found; none if there is none yet.
    pub fn heard(&mut self, text: &str) -> Option<String> {
        let log = self.log.lock();
        let found = log
            .lines
            .iter()
            .enumerate()
            .skip(self.passed)
            .find(|(_, l)| l.contains(text));
        let (index, line) = found.map(|(index, line)| (index, line.clone()))?;
        self.passed = index + 1;
        Some(line)
    }

    /// The whole output so far.
    pub fn transcript(&self) -> String {
        self.log.lock().lines.join("\n")
    }

    /// Sends Ctrl-C (SIGINT) to this child alone.
    ///
    /// # Panics
    /// If there is no `sh` to send it.
    pub fn interrupt(&self) {
        self.signal("INT");
    }

    /// Sends a signal by its name (`STOP`, `CONT`) to this child alone.
    ///
    /// # Panics
    /// If there is no `sh` to send it.
    pub fn signal(&self, name: &str) {
        let kill = format!("kill -{name} {}", self.child.id());
        let status = Command::new("sh").args(["-c", &kill]).status();
        assert!(
            status.is_ok_and(|s| s.success()),
            "{}: `{kill}` failed",
            self.name
        );
    }

    /// Waits for the end of the process for [`PATIENCE`], then kills it. For clean-up, where a panic would hide the first
    /// one.
    pub fn finish_or_kill(mut self) {
        self.stdin = None;
        let give_up = Instant::now() + PATIENCE;
        while let Ok(None) = self.child.try_wait() {
            if Instant::now() > give_up {
                return;
            }
            thread::sleep(POLL_INTERVAL);
        }
    }

    /// Closes standard input and waits for the end; returns the exit status and the whole output.
    ///
    /// # Panics
    /// If the process does not end within [`PATIENCE`].
    pub fn finish(mut self) -> (ExitStatus, String) {
        self.stdin = None;
        let status = wait(&self.name, &mut self.child);
        for reader in self.readers.drain(..) {
            reader.join().expect("a reader of lines does not panic");
        }
        (status, self.transcript())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // An error means that the child has already ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn read_lines(stream: impl Read + Send + 'static, log: Arc<SharedLog>) -> JoinHandle<()> {
    thread::spawn(move || {
        for line in BufReader::new(stream).split(b'\n').map_while(Result::ok) {
            log.lock()
                .lines
                .push(String::from_utf8_lossy(&line).into_owned());
            log.changed.notify_all();
        }
        log.lock().open -= 1;
        log.changed.notify_all();
    })
}

fn wait(name: &str, child: &mut Child) -> ExitStatus {
    let give_up = Instant::now() + PATIENCE;
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return status,
            Ok(None) if Instant::now() < give_up => thread::sleep(POLL_INTERVAL),
            Ok(None) => {
                let _ = child.kill();
                let _ = child.wait();
                panic!("{name}: did not end");
            }
            Err(error) => panic!("{name}: cannot wait for its end: {error}"),
        }
    }
}

/// A command that has ended.
#[derive(Debug)]
pub struct Finished {
    /// Whether the exit code is 0.
    pub success: bool,
    /// Exit code; `None` after a signal.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Finished {
    /// The same, if the exit code is 0.
    ///
    /// # Panics
    /// If the exit code is not 0.
    #[track_caller]
    pub fn succeeded(self) -> Self {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        self
    }

    /// The one JSON document on standard output.
    ///
    /// # Panics
    /// If there is any other output.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("{error} in {}\n{}", self.stdout, self.stderr))
    }

    /// Checks that the exit code is 1, standard output is empty, and the error contains all these texts.
    ///
    /// # Panics
    /// If a check fails.
    #[track_caller]
    pub fn refused(&self, says: &[&str]) {
        let (said, error) = ((self.code, self.stdout.as_str()), &self.stderr);
        assert_eq!(said, (Some(1), ""), "{error}");
        assert!(
            error.lines().any(|line| line.starts_with("error: ")),
            "{error}"
        );
        for says in says {
            assert!(error.contains(says), "expected `{says}` in {error}");
        }
    }
}

/// Runs `softdock` with `arguments` in `folder` and waits for its end.
///
/// # Panics
/// If there is no binary, or it does not end within [`PATIENCE`].
pub fn softdock(folder: &Path, arguments: &[&str]) -> Finished {
    let mut command = Command::new(softdock_binary());
    command
        .current_dir(folder)
        .args(arguments)
        .stdin(Stdio::null());
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("softdock starts");
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    let stdout = thread::spawn(move || read_all(stdout));
    let stderr = thread::spawn(move || read_all(stderr));
    let status = wait(&format!("softdock {}", arguments.join(" ")), &mut child);
    Finished {
        success: status.success(),
        code: status.code(),
        stdout: stdout.join().expect("a reader does not panic"),
        stderr: stderr.join().expect("a reader does not panic"),
    }
}

/// Runs `softdock`, which must succeed; returns its output.
///
/// # Panics
/// If the command fails.
pub fn done(folder: &Path, arguments: &[&str]) -> String {
    let run = softdock(folder, arguments);
    assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.stderr);
    run.stdout
}

/// Runs `softdock` with `--json` after the arguments; returns the one JSON document that it prints.
///
/// # Panics
/// If the command fails, or prints anything else.
pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    let run = softdock(folder, &[arguments, &["--json"]].concat());
    run.succeeded().json()
}

/// Runs `softdock`, which must fail without output; returns its error.
///
/// # Panics
/// If the command succeeds or prints something.
pub fn refused(folder: &Path, arguments: &[&str]) -> String {
    let run = softdock(folder, arguments);
    run.refused(&[]);
    run.stderr
}

/// The arguments of a command line, separated by single spaces.
pub fn words(line: &str) -> Vec<&str> {
    line.split(' ').collect()
}

/// Runs an integration test, by its full name, once for each case, in separate processes: the test measures the memory of its
/// process, which other cases would change. As many run at the same time as there are processors.
///
/// # Panics
/// If the test fails; all started processes have ended then.
pub fn each_in_its_own_process<T: Debug>(test: &str, cases: &[T], run: impl Fn(&T)) {
    const ALONE: &str = "SOFTDOCK_TEST_ALONE";
    let named = |case: &T| format!("{case:?}");
    if let Ok(alone) = std::env::var(ALONE) {
        return cases.iter().filter(|c| named(c) == alone).for_each(run);
    }
    let start = |case: &T| {
        Command::new(std::env::current_exe().unwrap())
            .args([test, "--exact", "--include-ignored", "--nocapture"])
            .env(ALONE, named(case))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let at_once = thread::available_parallelism().map_or(1, usize::from);
    for some in cases.chunks(at_once) {
        let started: Vec<Child> = some.iter().map(start).collect();
        let ended: Vec<Output> = started
            .into_iter()
            .map(|child| child.wait_with_output().unwrap())
            .collect();
        for alone in ended {
            let said = String::from_utf8_lossy(&alone.stdout);
            print!("{said}");
            let failed = String::from_utf8_lossy(&alone.stderr);
            assert!(alone.status.success(), "{said}{failed}");
            assert!(
                said.contains("1 passed"),
                "no test is called {test}: {said}"
            );
        }
    }
}

/// `softdock demo` with its defaults and `--json`, run once for all tests: its folder, in which it wrote to `demo`, and its
/// output.
///
/// # Panics
/// As [`softdock()`].
pub fn demonstration() -> &'static (PathBuf, Finished) {
    static DEMONSTRATION: OnceLock<(PathBuf, Finished)> = OnceLock::new();
    DEMONSTRATION.get_or_init(|| {
        let folder = scratch("demonstration");
        let told = softdock(&folder, &["demo", "-o", "demo", "--json"]);
        (folder, told)
    })
}

fn read_all(stream: Option<impl Read>) -> String {
    let mut bytes = Vec::new();
    if let Some(mut stream) = stream {
        stream.read_to_end(&mut bytes).expect("a pipe can be read");
    }
    String::from_utf8(bytes).expect("softdock writes UTF-8")
}

/// The `softdock` command that belongs to this build: `target/<profile>/softdock`.
///
/// # Panics
/// If it was not built, or one of its sources is newer.
pub fn softdock_binary() -> PathBuf {
    let binary = profile_folder().join(format!("softdock{}", std::env::consts::EXE_SUFFIX));
    let modified = |path: &Path| path.metadata().and_then(|m| m.modified()).ok();
    let mend = "run `cargo build` (the same profile), or `tests/run`";
    let Some(built) = modified(&binary) else {
        panic!("{} is missing: {mend}", binary.display());
    };
    // Cargo lists the sources of a binary beside it: `binary: source source ..`. Files of git are not sources.
    let list = std::fs::read_to_string(binary.with_extension("d")).unwrap_or_default();
    let sources = list.split_once(": ").map_or("", |(_, sources)| sources);
    for source in sources.replace("\\ ", "\u{0}").split_whitespace() {
        let source = PathBuf::from(source.replace('\u{0}', " "));
        let is_of_git = source.components().any(|part| part.as_os_str() == ".git");
        if !is_of_git && modified(&source).is_some_and(|changed| changed > built) {
            panic!(
                "{} is older than {}: {mend}",
                binary.display(),
                source.display()
            );
        }
    }
    binary
}

/// `target/<profile>`; this test's executable is in its folder `deps`.
fn profile_folder() -> PathBuf {
    let executable = std::env::current_exe().expect("a test has a path");
    let profile = executable.parent().and_then(Path::parent);
    profile
        .expect("a test stands in target/<profile>/deps")
        .to_path_buf()
}

/// Recorded data of a machine that is not part of the project, in the folder given by `SOFTDOCK_DATA`. None if that is not
/// set; the test is then skipped, and its name is added to the file `skipped-tests`, from which `tests/run` prints it at the
/// end.
///
/// # Panics
/// If the folder is given but does not contain the data, or the file cannot be written.
pub fn recorded_data(name: &str) -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("SOFTDOCK_DATA") {
        let data = PathBuf::from(folder).join(name);
        assert!(data.exists(), "SOFTDOCK_DATA: expected {}", data.display());
        return Some(data);
    }
    note("skipped-tests", "");
    eprintln!("SKIPPED: SOFTDOCK_DATA is not set; {name} is not there");
    None
}

/// Notes that this machine does not allow what a test needs, in the file `forbidden-tests`, from which `tests/run` prints it
/// at the end.
///
/// # Panics
/// If the file cannot be written.
pub fn forbidden(what: &str) {
    note("forbidden-tests", &format!(": {what}"));
    eprintln!("SKIPPED: this machine does not allow {what}");
}

/// Adds the name of this test to a list.
fn note(list: &str, why: &str) {
    let test = thread::current();
    let line = format!("{}{why}\n", test.name().unwrap_or("a test without a name"));
    let list = OpenOptions::new()
        .create(true)
        .append(true)
        .open(profile_folder().join(list));
    let written = list.and_then(|mut list| list.write_all(line.as_bytes()));
    written.expect("the list of skipped tests can be written");
}

/// An empty folder for the files of one test, under `target/`.
///
/// # Panics
/// If the folder cannot be created, or another test uses it.
pub fn scratch(test: &str) -> PathBuf {
    static OWNERS: Mutex<BTreeMap<String, String>> = Mutex::new(BTreeMap::new());
    // Each test has its own thread, with the name of the test.
    let thread = thread::current();
    let this = thread.name().unwrap_or_default();
    let mut owners = OWNERS.lock().unwrap_or_else(PoisonError::into_inner);
    let owner = owners.entry(test.to_owned()).or_insert(this.to_owned());
    assert_eq!(owner, this, "two tests have the folder {test}");
    drop(owners);
    let folder = profile_folder().join("scratch").join(test);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("an old scratch folder can be removed");
    }
    std::fs::create_dir_all(&folder).expect("a scratch folder can be made");
    folder
}
