//! The floating-point exceptions that the processor noted.

/// Makes a call, refused or not, which must not raise a flag that hosts trap.
#[track_caller]
pub fn watch<T>(call: impl FnOnce() -> T) -> T {
    let (result, flags) = raised(call);
    assert_eq!(flags, 0, "floating-point exceptions {flags:#b}");
    result
}

/// Makes a call, and tells which flags it raised.
pub fn raised<T>(call: impl FnOnce() -> T) -> (T, u32) {
    taken();
    let result = call();
    (result, taken())
}

/// What was noted since this was last asked, in this thread: invalid operation (1), division by zero (4), overflow (8).
/// On other processors than x86-64 nothing.
fn taken() -> u32 {
    #[cfg(target_arch = "x86_64")]
    {
        let mut control = 0u32;
        // SAFETY: reads the control register, and writes it with its exception flags cleared; nothing else in it changes.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut control);
            let cleared = control & !0x3f;
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const cleared);
        }
        control & 0b1101
    }
    #[cfg(not(target_arch = "x86_64"))]
    0
}
