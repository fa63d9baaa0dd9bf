//! Programs that the user has allowed scenes to run.
//!
//! In: a program with its words, what it is to read, where it runs. Out: what it prints. No shell is run. It has a limited time and may
//! print a limited amount; then it is ended. Programs that it has started itself are not waited for.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// How often it is looked at.
const PAUSE: Duration = Duration::from_millis(5);

/// Most of its complaints that are kept \[byte\].
const COMPLAINT: u64 = 2000;

/// How much a program may take.
pub(super) struct Allowance {
    pub time: Duration,
    /// Of its output \[byte\].
    pub bytes: u64,
}

/// Runs a program in a directory. `input` is what it reads, nothing if `None`.
pub(super) fn run(
    words: &[String],
    directory: &Path,
    input: Option<Vec<u8>>,
    allowance: &Allowance,
) -> Result<Vec<u8>, String> {
    let (program, arguments) = words.split_first().ok_or("there is no program")?;
    let directory = if directory.as_os_str().is_empty() { Path::new(".") } else { directory };
    let mut child = Command::new(program)
        .args(arguments)
        .current_dir(directory)
        .stdin(if input.is_some() { Stdio::piped() } else { Stdio::null() })
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| format!("it could not be started: {e}"))?;
    let result = converse(&mut child, input, allowance);
    // It may have ended by itself.
    let _ = child.kill();
    let _ = child.wait();
    result
}

fn converse(child: &mut Child, input: Option<Vec<u8>>, allowance: &Allowance) -> Result<Vec<u8>, String> {
    let deadline = Instant::now() + allowance.time;
    if let (Some(mut pipe), Some(input)) = (child.stdin.take(), input) {
        // A program that does not read to the end is its own affair.
        thread::spawn(move || drop(pipe.write_all(&input)));
    }
    let output = collected(child.stdout.take(), allowance.bytes.saturating_add(1));
    let complaint = collected(child.stderr.take().map(Complaints), COMPLAINT);
    let too_long = || {
        format!("it ran for longer than {} s: raise the limit or run it yourself", allowance.time.as_secs())
    };
    let left = || deadline.saturating_duration_since(Instant::now());
    let output = output.recv_timeout(left()).map_err(|_| too_long())?;
    if output.len() as u64 > allowance.bytes {
        return Err(format!("it printed more than {} bytes", allowance.bytes));
    }
    let status = ended(child, deadline).map_err(|e| e.to_string())?.ok_or_else(too_long)?;
    if !status.success() {
        let complaint = complaint.recv_timeout(left()).unwrap_or_default();
        let complaint = String::from_utf8_lossy(&complaint).trim().replace('\n', "; ");
        return Err(if complaint.is_empty() { status.to_string() } else { format!("{status}: {complaint}") });
    }
    Ok(output)
}

/// Complaints, which are read to their end even if only their beginning is kept, so that who complains can go on.
struct Complaints<R: Read>(R);

impl<R: Read> Read for Complaints<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.0.read(buffer)
    }
}

impl<R: Read> Drop for Complaints<R> {
    fn drop(&mut self) {
        // It ends with the program.
        let _ = std::io::copy(&mut self.0, &mut std::io::sink());
    }
}

/// Everything that comes out of a pipe, up to a number of bytes.
fn collected(pipe: Option<impl Read + Send + 'static>, most: u64) -> Receiver<Vec<u8>> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        let mut pipe = pipe.map(|pipe| pipe.take(most));
        if let Some(pipe) = &mut pipe {
            // What came before an error is all there is.
            let _ = pipe.read_to_end(&mut bytes);
        }
        // Nobody may be waiting any more.
        let _ = sender.send(bytes);
        drop(pipe);
    });
    receiver
}

/// How it ended; `None` if it did not in time.
fn ended(child: &mut Child, deadline: Instant) -> std::io::Result<Option<ExitStatus>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if Instant::now() >= deadline {
            return Ok(None);
        }
        thread::sleep(PAUSE);
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    fn run_words(command: &[&str], input: Option<&str>, seconds: u64, bytes: u64) -> Result<String, String> {
        let words: Vec<String> = command.iter().map(|&w| w.to_owned()).collect();
        let allowance = Allowance { time: Duration::from_secs(seconds), bytes };
        let output = run(&words, Path::new(""), input.map(|text| text.as_bytes().to_vec()), &allowance)?;
        Ok(String::from_utf8(output).unwrap())
    }

    #[test]
    fn output_comes_back_and_input_goes_in() {
        assert_eq!(run_words(&["echo", "a  b", "$HOME;"], None, 20, 100).unwrap(), "a  b $HOME;\n");
        assert_eq!(run_words(&["cat"], Some("through"), 20, 100).unwrap(), "through");
    }

    #[test]
    fn what_goes_wrong_is_told() {
        let error = run_words(&["no-such-program-anywhere"], None, 20, 100).unwrap_err();
        assert!(error.contains("could not be started"), "{error}");
        let error = run_words(&["cat", "no such file"], None, 20, 100).unwrap_err();
        assert!(error.contains("exit status") && error.contains("no such file"), "{error}");
        let error = run_words(&["sleep", "30"], None, 0, 100).unwrap_err();
        assert!(error.contains("longer than 0 s"), "{error}");
        let error = run_words(&["yes"], None, 20, 1000).unwrap_err();
        assert!(error.contains("more than 1000 bytes"), "{error}");
    }
}
