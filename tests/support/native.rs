//! The built shared library, loaded as a host loads it, by its C signatures.

use super::{decades, flags, power, signed, with};
use libloading::Library;
use std::ffi::{CStr, c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use std::time::SystemTime;

/// Statuses of the C interface.
pub const MEMORY_FULL: i32 = 1;
pub const NOT_DESCRIBED: i32 = 2;
pub const NULL_POINTER: i32 = -1;
pub const BAD_PROPERTY: i32 = -2;
pub const BAD_STATE: i32 = -3;
pub const BAD_INPUT: i32 = -4;
pub const INTERNAL: i32 = -5;

/// The opaque law of the C interface.
pub type LawPointer = *mut c_void;

/// The built library: MEPC_LIBRARY, or the release build beside the test programs.
pub fn library_path() -> PathBuf {
    if let Some(path) = std::env::var_os("MEPC_LIBRARY") {
        return PathBuf::from(path);
    }
    // A test program is TARGET/PROFILE/deps/NAME.
    let program = std::env::current_exe().expect("the path of this program");
    let target = program.ancestors().nth(3).expect("a target directory");
    let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let path = target.join("release").join(format!("{prefix}mepc{suffix}"));
    let built = path.metadata().and_then(|data| data.modified());
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    assert!(
        built.is_ok_and(|built| built >= newest(&sources)),
        "{} is not there or older than its sources: run `cargo build --release` first, or set MEPC_LIBRARY",
        path.display()
    );
    path
}

/// When a file of a folder was last changed.
fn newest(folder: &Path) -> SystemTime {
    let entries = std::fs::read_dir(folder).expect("a readable folder");
    let times = entries.map(|entry| {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            return newest(&path);
        }
        let data = path.metadata().expect("a readable file");
        data.modified().expect("a time")
    });
    times.max().unwrap_or(SystemTime::UNIX_EPOCH)
}

macro_rules! functions {
    ($($name:ident: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// Every function of the C interface, with the signature that a C compiler takes from mepc.h.
        pub struct Native {
            $(pub $name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            _library: Library,
        }

        impl Native {
            fn load() -> Self {
                let path = library_path();
                // SAFETY: our own library; it runs no code when it is loaded.
                let library = unsafe { Library::new(&path) }.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
                Native {
                    // SAFETY: the signatures are those of mepc.h.
                    $($name: unsafe { *library.get(stringify!($name)).expect(stringify!($name)) },)*
                    _library: library,
                }
            }
        }
    };
}

functions! {
    mepc_abi_version: fn() -> i32;
    mepc_version: fn() -> *const c_char;
    mepc_status_message: fn(i32) -> *const c_char;
    mepc_last_error: fn() -> *const c_char;
    mepc_law_new: fn(*const f64, i32, i32, i32, *mut LawPointer) -> i32;
    mepc_law_free: fn(LawPointer);
    mepc_state_size: fn(*const f64, i32, i32) -> i32;
    mepc_state_name: fn(LawPointer, i32) -> *const c_char;
    mepc_friction: fn(LawPointer, *const f64, f64, *const f64, *const f64, *mut f64, *mut f64, *mut f64, *mut f64,
        *mut f64) -> i32;
    mepc_interface: fn(LawPointer, *const f64, *const f64, *const f64, *mut f64, *mut f64, *mut f64, *mut f64) -> i32;
    mepc_friction_batch: fn(LawPointer, i64, *const f64, *const f64, *const f64, *const f64, *mut f64, *mut f64,
        *mut f64, *mut f64, *mut f64, *mut i32, i32) -> i32;
    mepc_interface_batch: fn(LawPointer, i64, *const f64, *const f64, *const f64, *mut f64, *mut f64, *mut f64,
        *mut f64, *mut i32, i32) -> i32;
    mepc_friction_history: fn(LawPointer, i64, *const f64, *const f64, *const f64, *mut f64, *mut f64, *mut f64,
        *mut f64, *mut f64) -> i32;
    mepc_friction_history_batch: fn(LawPointer, i64, i64, *const f64, *const f64, *const f64, *mut f64, *mut f64,
        *mut f64, *mut f64, *mut f64, *mut i32, i32) -> i32;
}

/// The library, loaded once per test program.
pub fn native() -> &'static Native {
    static NATIVE: OnceLock<Native> = OnceLock::new();
    NATIVE.get_or_init(Native::load)
}

/// A text of the library; None for NULL.
pub fn text(pointer: *const c_char) -> Option<String> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: not NULL; the library's texts are C strings.
    let text = unsafe { CStr::from_ptr(pointer) };
    Some(text.to_str().expect("UTF-8").to_string())
}

/// This thread's last error.
pub fn last_error() -> String {
    // SAFETY: no arguments.
    text(unsafe { (native().mepc_last_error)() }).expect("never NULL")
}

/// A law of the C interface, released at the end.
pub struct NativeLaw {
    pub pointer: LawPointer,
    pub ndir: usize,
    pub nstate: usize,
}

// SAFETY: a law may be used by any number of threads, by the contract of the header.
unsafe impl Send for NativeLaw {}
// SAFETY: as above.
unsafe impl Sync for NativeLaw {}

impl NativeLaw {
    /// A law for states of default size.
    pub fn new(props: &[f64], ndir: usize) -> Self {
        // SAFETY: as many properties as said.
        let size =
            unsafe { (native().mepc_state_size)(props.as_ptr(), props.len() as i32, ndir as i32) };
        Self::with_state_size(props, ndir, usize::try_from(size).expect("good properties"))
    }

    pub fn with_state_size(props: &[f64], ndir: usize, nstate: usize) -> Self {
        let mut pointer = std::ptr::null_mut();
        let (count, ndir_, nstate_) = (props.len() as i32, ndir as i32, nstate as i32);
        // SAFETY: as many properties as said, and a place for the law.
        let status = unsafe {
            (native().mepc_law_new)(props.as_ptr(), count, ndir_, nstate_, &raw mut pointer)
        };
        assert_eq!(status, 0, "{}", last_error());
        NativeLaw {
            pointer,
            ndir,
            nstate,
        }
    }

    /// One point, friction form, every output asked for.
    pub fn friction(&self, slip: &[f64], pressure: f64, state: &mut [f64]) -> Outcome {
        let n = self.ndir;
        assert!(slip.len() == n && state.len() == self.nstate);
        let mut out = Outcome::new(n, n * n);
        // SAFETY: arrays of the documented sizes; the state is its own successor.
        let call = || unsafe {
            (native().mepc_friction)(
                self.pointer,
                slip.as_ptr(),
                pressure,
                null(),
                state.as_ptr(),
                state.as_mut_ptr(),
                out.traction.as_mut_ptr(),
                out.tangent.as_mut_ptr(),
                out.dtraction_dpressure.as_mut_ptr(),
                out.energy.as_mut_ptr(),
            )
        };
        out.status = flags::watch(call);
        out
    }

    /// One point, interface form, every output asked for.
    pub fn interface(&self, opening: &[f64], state: &mut [f64]) -> Outcome {
        let n = 1 + self.ndir;
        assert!(opening.len() == n && state.len() == self.nstate);
        let mut out = Outcome::new(n, n * n);
        // SAFETY: arrays of the documented sizes; the state is its own successor.
        let call = || unsafe {
            (native().mepc_interface)(
                self.pointer,
                opening.as_ptr(),
                null(),
                state.as_ptr(),
                state.as_mut_ptr(),
                out.traction.as_mut_ptr(),
                out.tangent.as_mut_ptr(),
                out.energy.as_mut_ptr(),
            )
        };
        out.status = flags::watch(call);
        out
    }
}

impl Drop for NativeLaw {
    fn drop(&mut self) {
        // SAFETY: made by mepc_law_new, used no more.
        unsafe { (native().mepc_law_free)(self.pointer) }
    }
}

/// What a call gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub status: i32,
    pub traction: Vec<f64>,
    /// Row by row.
    pub tangent: Vec<f64>,
    /// Friction form only.
    pub dtraction_dpressure: Vec<f64>,
    /// Stored at the end, dissipated in the increment.
    pub energy: [f64; 2],
}

impl Outcome {
    fn new(traction: usize, tangent: usize) -> Self {
        Outcome {
            status: 0,
            traction: vec![0.0; traction],
            tangent: vec![0.0; tangent],
            dtraction_dpressure: vec![0.0; traction],
            energy: [0.0; 2],
        }
    }
}

/// A number that no result is.
pub const CANARY: f64 = -7.25e77;

/// An output array with canaries in it and around it.
pub struct Watched {
    numbers: Vec<f64>,
}

impl Watched {
    const MARGIN: usize = 4;

    pub fn new(len: usize) -> Self {
        Watched {
            numbers: vec![CANARY; len + 2 * Self::MARGIN],
        }
    }

    pub fn pointer(&mut self) -> *mut f64 {
        self.numbers[Self::MARGIN..].as_mut_ptr()
    }

    /// Fills the array: what it holds before the call.
    pub fn fill(&mut self, value: f64) {
        let len = self.numbers.len();
        self.numbers[Self::MARGIN..len - Self::MARGIN].fill(value);
    }

    /// The array, after a look at what is around it.
    pub fn values(&self) -> &[f64] {
        let (before, rest) = self.numbers.split_at(Self::MARGIN);
        let (values, after) = rest.split_at(rest.len() - Self::MARGIN);
        assert!(
            before.iter().chain(after).all(|x| *x == CANARY),
            "written outside the array"
        );
        values
    }

    /// True while nothing was written.
    pub fn untouched(&self) -> bool {
        self.values().iter().all(|x| *x == CANARY)
    }
}

/// A call with watched outputs, of which state1 and traction are the first; None hands over NULL.
pub trait WatchedCall {
    fn call(&mut self) -> i32;

    fn outputs(&mut self) -> &mut [Option<Watched>];

    fn values(&mut self) -> Vec<Vec<f64>> {
        let outputs = self.outputs().iter().flatten();
        outputs.map(|output| output.values().to_vec()).collect()
    }

    fn untouched(&mut self) -> bool {
        self.outputs().iter().flatten().all(Watched::untouched)
    }
}

/// One call of the friction form.
pub struct FrictionCall<'a> {
    pub law: LawPointer,
    pub slip: Option<&'a [f64]>,
    pub pressure: f64,
    pub mu_factor: Option<f64>,
    pub state0: Option<&'a [f64]>,
    /// state1, traction, dtraction_dslip, dtraction_dpressure, energy.
    pub outputs: [Option<Watched>; 5],
}

impl<'a> FrictionCall<'a> {
    pub fn new(law: &NativeLaw, slip: &'a [f64], pressure: f64, state0: &'a [f64]) -> Self {
        let n = law.ndir;
        FrictionCall {
            law: law.pointer,
            slip: Some(slip),
            pressure,
            mu_factor: None,
            state0: Some(state0),
            outputs: [law.nstate, n, n * n, n, 2].map(|len| Some(Watched::new(len))),
        }
    }
}

impl WatchedCall for FrictionCall<'_> {
    fn call(&mut self) -> i32 {
        let input = |array: Option<&[f64]>| array.map_or(null(), <[f64]>::as_ptr);
        let (slip, state0) = (input(self.slip), input(self.state0));
        let factor = self
            .mu_factor
            .as_ref()
            .map_or(null(), |factor| &raw const *factor);
        let [state1, traction, dslip, dpressure, energy] = self
            .outputs
            .each_mut()
            .map(|output| output.as_mut().map_or(null_mut(), Watched::pointer));
        // SAFETY: arrays of the documented sizes, or NULL.
        let call = || unsafe {
            (native().mepc_friction)(
                self.law,
                slip,
                self.pressure,
                factor,
                state0,
                state1,
                traction,
                dslip,
                dpressure,
                energy,
            )
        };
        flags::watch(call)
    }

    fn outputs(&mut self) -> &mut [Option<Watched>] {
        &mut self.outputs
    }
}

/// The same for the interface form: state1, traction, tangent, energy.
pub struct InterfaceCall<'a> {
    pub law: LawPointer,
    pub opening: Option<&'a [f64]>,
    pub mu_factor: Option<f64>,
    pub state0: Option<&'a [f64]>,
    pub outputs: [Option<Watched>; 4],
}

impl<'a> InterfaceCall<'a> {
    pub fn new(law: &NativeLaw, opening: &'a [f64], state0: &'a [f64]) -> Self {
        let n = 1 + law.ndir;
        InterfaceCall {
            law: law.pointer,
            opening: Some(opening),
            mu_factor: None,
            state0: Some(state0),
            outputs: [law.nstate, n, n * n, 2].map(|len| Some(Watched::new(len))),
        }
    }
}

impl WatchedCall for InterfaceCall<'_> {
    fn call(&mut self) -> i32 {
        let input = |array: Option<&[f64]>| array.map_or(null(), <[f64]>::as_ptr);
        let (opening, state0) = (input(self.opening), input(self.state0));
        let factor = self
            .mu_factor
            .as_ref()
            .map_or(null(), |factor| &raw const *factor);
        let [state1, traction, tangent, energy] = self
            .outputs
            .each_mut()
            .map(|output| output.as_mut().map_or(null_mut(), Watched::pointer));
        // SAFETY: arrays of the documented sizes, or NULL.
        let call = || unsafe {
            (native().mepc_interface)(
                self.law, opening, factor, state0, state1, traction, tangent, energy,
            )
        };
        flags::watch(call)
    }

    fn outputs(&mut self) -> &mut [Option<Watched>] {
        &mut self.outputs
    }
}

/// A law with everything that both forms need.
pub fn props() -> Vec<f64> {
    with(&with(&power(0.3, 0.002, 2.5), 7, 1e4), 8, 1e-3)
}

/// A point's random history: slips around the critical slip, pressure up and down, sometimes open.
pub fn random_inputs(
    random: &mut fastrand::Rng,
    ndir: usize,
    count: usize,
) -> Vec<(Vec<f64>, f64)> {
    (0..count)
        .map(|_| {
            let length = 0.002 * decades(random, -2.0, 0.5);
            let slip = (0..ndir).map(|_| length * signed(random)).collect();
            let pressure = if random.u32(0..10) == 0 {
                0.0
            } else {
                decades(random, 0.0, 2.0)
            };
            (slip, pressure)
        })
        .collect()
}
