//! The host's side of the user friction routine: all 39 arguments and the hidden string lengths, as Fortran passes them.

use super::flags;
use super::native::{CANARY, library_path};
use libloading::Library;
use std::sync::OnceLock;

/// FRIC as a Fortran caller sees it.
#[rustfmt::skip]
pub type Fric = unsafe extern "C" fn(
    // lm, tau, ddtddg, ddtddp, dslip, sed, sfd, ddtddt, pnewdt, statev
    *mut i32, *mut f64, *mut f64, *mut f64, *mut f64, *mut f64, *mut f64, *mut f64, *mut f64, *mut f64,
    // dgam, taulm, press, dpress, ddpddh, slip, kstep, kinc, time, dtime
    *const f64, *const f64, *const f64, *const f64, *const f64, *const f64, *const i32, *const i32, *const f64, *const f64,
    // noel, ciname, slname, msname, npt, node, npatch, coords, rcoord, drot
    *const i32, *const u8, *const u8, *const u8, *const i32, *const i32, *const i32, *const f64, *const f64, *const f64,
    // temp, predef, nfdir, mcrd, npred, nstatv, chrlngth, props, nprops
    *const f64, *const f64, *const i32, *const i32, *const i32, *const i32, *const f64, *const f64, *const i32,
    // lengths of ciname, slname, msname, by value
    usize, usize, usize,
);

/// Both symbols of the built library: with the underscore of Fortran compilers on Linux, and without.
pub fn routines() -> &'static [Fric; 2] {
    static ROUTINES: OnceLock<(Library, [Fric; 2])> = OnceLock::new();
    let (_, routines) = ROUTINES.get_or_init(|| {
        let path = library_path();
        // SAFETY: our own library, which runs no code when it is loaded.
        let library =
            unsafe { Library::new(&path) }.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        // SAFETY: both symbols have the host's signature.
        let find = |name: &str| unsafe { *library.get::<Fric>(name).expect(name) };
        let routines = [find("fric_"), find("fric")];
        (library, routines)
    });
    routines
}

/// Everything that the host hands over, and what it finds there afterwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    pub lm: i32,
    pub tau: Vec<f64>,
    /// Column by column.
    pub ddtddg: Vec<f64>,
    pub ddtddp: Vec<f64>,
    pub dslip: Vec<f64>,
    pub sed: f64,
    pub sfd: f64,
    pub ddtddt: Vec<f64>,
    pub pnewdt: f64,
    pub statev: Vec<f64>,
    pub dgam: Vec<f64>,
    pub taulm: Vec<f64>,
    pub press: f64,
    pub kstep: i32,
    pub kinc: i32,
    pub ciname: String,
    pub node: i32,
    /// Column by column.
    pub drot: [f64; 4],
    /// Pairs of values, column by column: both sides of the contact, field after field.
    pub predef: Vec<f64>,
    pub nfdir: i32,
    /// None: the length of statev.
    pub nstatv: Option<i32>,
    pub chrlngth: f64,
    pub props: Vec<f64>,
    /// None: the length of props.
    pub nprops: Option<i32>,
    /// A number for all arguments that do not matter.
    pub unused: f64,
    /// Numbers whose products overflow: only an accepted call must raise no flag then.
    pub absurd: bool,
}

impl Call {
    /// A virgin point of the host.
    pub fn new(props: &[f64], nfdir: usize, nstatv: usize) -> Self {
        Call {
            lm: 0,
            tau: vec![0.0; nfdir],
            ddtddg: vec![CANARY; nfdir * nfdir],
            ddtddp: vec![CANARY; nfdir],
            dslip: vec![CANARY; nfdir],
            sed: 0.0,
            sfd: CANARY,
            ddtddt: vec![CANARY; 2 * nfdir],
            pnewdt: 1.0,
            statev: vec![0.0; nstatv],
            dgam: vec![0.0; nfdir],
            taulm: vec![0.0; nfdir],
            press: 0.0,
            kstep: 2,
            kinc: 17,
            ciname: "PLATE-PLATE".to_string(),
            node: 4711,
            drot: [1.0, 0.0, 0.0, 1.0],
            predef: Vec::new(),
            nfdir: nfdir as i32,
            nstatv: None,
            chrlngth: 0.0,
            props: props.to_vec(),
            nprops: None,
            unused: 0.0,
            absurd: false,
        }
    }

    /// Calls FRIC; nothing may be written outside the arrays.
    pub fn run(&mut self) {
        self.run_symbol(0);
    }

    /// Calls `fric_` (0) or `fric` (1).
    pub fn run_symbol(&mut self, symbol: usize) {
        let mut outputs = [
            &self.tau,
            &self.ddtddg,
            &self.ddtddp,
            &self.dslip,
            &self.ddtddt,
            &self.statev,
        ]
        .map(|array| padded(array));
        let [tau, ddtddg, ddtddp, dslip, ddtddt, statev] =
            outputs.each_mut().map(|array| array.as_mut_ptr());
        let (dpress, ddpddh, dtime, slip) =
            (self.unused, self.unused, self.unused, [self.unused; 2]);
        let (time, coords, temp) = ([self.unused; 2], [self.unused; 3], [self.unused; 2]);
        let (noel, npt, npatch, mcrd) = (0, 3, 1, 3);
        let npred = self.predef.len() as i32 / 2;
        let nstatv = self.nstatv.unwrap_or(self.statev.len() as i32);
        let nprops = self.nprops.unwrap_or(self.props.len() as i32);
        let name = |text: &str| format!("{text:<80}").into_bytes();
        let names = [name(&self.ciname), name("SLAVE"), name("MASTER")];
        let call = || {
            // SAFETY: every argument with at least the size that the host's manual gives it.
            unsafe {
                routines()[symbol](
                    &raw mut self.lm,
                    tau,
                    ddtddg,
                    ddtddp,
                    dslip,
                    &raw mut self.sed,
                    &raw mut self.sfd,
                    ddtddt,
                    &raw mut self.pnewdt,
                    statev,
                    self.dgam.as_ptr(),
                    self.taulm.as_ptr(),
                    &raw const self.press,
                    &raw const dpress,
                    &raw const ddpddh,
                    slip.as_ptr(),
                    &raw const self.kstep,
                    &raw const self.kinc,
                    time.as_ptr(),
                    &raw const dtime,
                    &raw const noel,
                    names[0].as_ptr(),
                    names[1].as_ptr(),
                    names[2].as_ptr(),
                    &raw const npt,
                    &raw const self.node,
                    &raw const npatch,
                    coords.as_ptr(),
                    coords.as_ptr(),
                    self.drot.as_ptr(),
                    temp.as_ptr(),
                    self.predef.as_ptr(),
                    &raw const self.nfdir,
                    &raw const mcrd,
                    &raw const npred,
                    &raw const nstatv,
                    &raw const self.chrlngth,
                    self.props.as_ptr(),
                    &raw const nprops,
                    80,
                    80,
                    80,
                );
            }
            self.pnewdt
        };
        let (pnewdt, raised) = flags::raised(call);
        let may_raise = self.absurd && pnewdt <= 0.5;
        assert!(
            raised == 0 || may_raise,
            "floating-point exceptions {raised:#b}"
        );
        let mine = [
            &mut self.tau,
            &mut self.ddtddg,
            &mut self.ddtddp,
            &mut self.dslip,
            &mut self.ddtddt,
            &mut self.statev,
        ];
        for (mine, padded) in mine.into_iter().zip(outputs) {
            let (values, margin) = padded.split_at(mine.len());
            assert!(margin.iter().all(|x| *x == CANARY), "written past an array");
            mine.copy_from_slice(values);
        }
    }

    /// The same point with another increment, not yet run.
    pub fn with(&self, dgam: &[f64], press: f64) -> Self {
        Call {
            dgam: dgam.to_vec(),
            press,
            ..self.clone()
        }
    }

    /// An accepted increment: what comes out is what goes in next.
    pub fn step(&mut self, dgam: &[f64], press: f64) {
        *self = self.with(dgam, press);
        self.run();
        assert_eq!(self.pnewdt, 1.0, "the increment was refused");
    }
}

fn padded(array: &[f64]) -> Vec<f64> {
    let mut padded = array.to_vec();
    padded.extend([CANARY; 8]);
    padded
}
