//! The floating-point exceptions that the processor noted.

/// Makes a call, which must not raise a flag that hosts trap when it succeeds.
#[track_caller]
pub fn watch<T>(call: impl FnOnce() -> T, succeeded: impl FnOnce(&T) -> bool) -> T {
    taken();
    let result = call();
    let flags = taken();
    assert!(
        flags == 0 || !succeeded(&result),
        "floating-point exceptions {flags:#b}"
    );
    result
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
