//! Messages to the user of a host program: through its own routine where it has one, else on standard error.

use crate::error::{Error, Value};
use libc::{c_char, c_double, c_int, c_void};
use std::collections::BTreeSet;
use std::ffi::CStr;
use std::sync::{Mutex, OnceLock};

/// The longest text that the host's routine takes.
const LONGEST: usize = 500;
/// Enough for any model; past it messages stop rather than memory grow.
const MOST_CAUSES: usize = 1000;

/// What the host is to do after a message: its own level numbers.
#[derive(Clone, Copy)]
#[repr(i32)]
pub(super) enum Severity {
    /// Go on; the increment was refused.
    Error = -2,
    /// Stop the run.
    Fatal = -3,
}

/// The host's routine that ends the run.
type ExitRoutine = unsafe extern "C" fn();

/// The host's message routine: level, text, integers, reals, names, and the two string lengths.
type MessageRoutine = unsafe extern "C" fn(
    *const c_int,
    *const c_char,
    *const c_int,
    *const c_double,
    *const c_char,
    usize,
    usize,
);

/// Where in the model a routine was called.
pub(super) struct Place<'a> {
    /// Routine, as the user knows it.
    pub routine: &'a str,
    /// Contact (interaction) name.
    pub contact: &'a str,
    /// Node number.
    pub node: i32,
    /// Step number.
    pub step: i32,
    /// Increment number.
    pub increment: i32,
}

/// What a host calls an argument of the library, and the number in it that is meant.
pub(super) type HostName<'a> = &'a dyn Fn(&str, Option<usize>) -> Option<String>;

/// Whether the user has not been told of this cause at this contact yet: the number in the message does not count, nor
/// the point it was met at. Only messages depend on it.
fn is_news(contact: &str, error: &Error, host_name: HostName) -> bool {
    static TOLD: Mutex<BTreeSet<(String, String)>> = Mutex::new(BTreeSet::new());
    let mut cause = error.clone();
    cause.value = Value::None;
    cause.at.clear();
    if !cause.argument.is_empty() {
        cause.expected = "".into();
    }
    let key = (contact.to_string(), cause.words(host_name));
    let mut told = TOLD.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    told.len() < MOST_CAUSES && told.insert(key)
}

/// Tells the user, once per cause, where the host says nothing of the place and may keep the message to itself.
#[cold]
pub(super) fn note(routine: &str, error: &Error, host_name: HostName) {
    if is_news(routine, error, host_name) {
        tell(
            &format!("mepc {routine}: {}", error.words(host_name)),
            Severity::Error,
        );
    }
}

/// Tells the user, once per cause and contact name.
#[cold]
pub(super) fn report(place: &Place<'_>, severity: Severity, error: &Error, host_name: HostName) {
    if !is_news(place.contact, error, host_name) {
        return;
    }
    let text = format!(
        "mepc {}: contact {}, node {}, step {}, increment {}: {}",
        place.routine,
        place.contact,
        place.node,
        place.step,
        place.increment,
        error.words(host_name)
    );
    tell(&text, severity);
}

/// Tells the user and ends the run, for a routine that has no way to refuse: by the host's own routine where it has
/// one, else the process with code 1.
#[cold]
pub(super) fn stop(text: &str) -> ! {
    // Several threads may fail at once; the first one speaks and ends the run, the others wait for that.
    static ENDING: Mutex<()> = Mutex::new(());
    let _held = ENDING
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    tell(text, Severity::Error);
    if let Some(address) = find(c"xit_") {
        // SAFETY: the symbol of that name takes no arguments in every host that defines it.
        unsafe { std::mem::transmute::<*mut c_void, ExitRoutine>(address)() }
    }
    std::process::exit(1)
}

fn tell(text: &str, severity: Severity) {
    // The routine reads % as a format; cut at a character the host's ASCII can end with.
    let mut text: String = text
        .chars()
        .map(|c| if c == '%' || !c.is_ascii() { '?' } else { c })
        .collect();
    let Some(routine) = message_routine() else {
        use std::io::Write;
        // A host without standard error: there is nobody to tell.
        let _ = writeln!(std::io::stderr(), "{text}");
        return;
    };
    text.truncate(LONGEST);
    let (level, integer, real, name) = (severity as c_int, 0, 0.0, [b' '; 8]);
    // SAFETY: the host's own routine, with the arguments it declares: the text and its length, and arrays of one
    // entry that the text (free of %) does not refer to.
    unsafe {
        routine(
            &raw const level,
            text.as_ptr().cast(),
            &raw const integer,
            &raw const real,
            name.as_ptr().cast(),
            text.len(),
            name.len(),
        );
    }
}

/// The host's routine, looked up in the running program: linking to it would keep the library from loading elsewhere.
fn message_routine() -> Option<MessageRoutine> {
    static ROUTINE: OnceLock<Option<MessageRoutine>> = OnceLock::new();
    *ROUTINE.get_or_init(|| {
        let standard = find(c"stdb_abqerr_");
        standard.or_else(|| find(c"xplb_abqerr_")).map(|address| {
            // SAFETY: the symbols of these names have this signature in every host that defines them.
            unsafe { std::mem::transmute::<*mut c_void, MessageRoutine>(address) }
        })
    })
}

#[cfg(unix)]
fn find(name: &CStr) -> Option<*mut c_void> {
    // SAFETY: a lookup of a C string in the global scope; RTLD_DEFAULT needs no handle.
    let address = unsafe { libc::dlsym(libc::RTLD_DEFAULT, name.as_ptr()) };
    (!address.is_null()).then_some(address)
}

/// Elsewhere a program does not show its routines to the libraries it loads: messages go to standard error.
#[cfg(not(unix))]
fn find(_name: &CStr) -> Option<*mut c_void> {
    None
}
