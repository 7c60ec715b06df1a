//! Caches, and the memory that must not be cached (memory.x).
#![allow(unsafe_code, reason = "registers of the memory protection unit")]

use cortex_m::Peripherals;
use cortex_m::peripheral::MPU;

/// A region that is not cached: its first address, a multiple of its size, and the binary logarithm of that size.
struct Region {
    start: u32,
    log2: u32,
}

/// In the order of their region numbers; the last of the unit's eight regions is the guard of the stack.
const UNCACHED: [Region; 3] = [
    // Initialised data, with the control block of the log: 4 KiB.
    Region {
        start: 0x2400_0000,
        log2: 12,
    },
    // UNCACHED: packets of the Ethernet, data that survives a reset, the log: 32 KiB. With a cache, the last writes before a
    // reset would be lost.
    Region {
        start: 0x2407_8000,
        log2: 15,
    },
    // SETTINGS: flash is written without the cache, and read again to verify it: 256 KiB.
    Region {
        start: 0x081C_0000,
        log2: 18,
    },
];

/// Switches both caches on: without them the processor waits for flash and for the AXI SRAM.
pub(crate) fn start_caches(core: &mut Peripherals) {
    for (number, region) in (0..).zip(&UNCACHED) {
        set_uncached(&mut core.MPU, number, region);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    core.SCB.enable_icache();
    core.SCB.enable_dcache(&mut core.CPUID);
}

/// Excludes a region from the cache (Armv7-M Architecture Reference Manual, B3.5.8 and B3.5.9). Everything else is as in the
/// default map, which `softdock_crash::arm` selected when it enabled the unit.
fn set_uncached(mpu: &mut MPU, number: u32, region: &Region) {
    const VALID: u32 = 1 << 4;
    const NEVER_EXECUTED: u32 = 1 << 28;
    const FULL_ACCESS: u32 = 0b011 << 24;
    // TEX 1, C 0, B 0.
    const NORMAL_NOT_CACHED: u32 = 1 << 19;
    const ENABLED: u32 = 1;
    // SAFETY: the region has the same access as before, but not through the cache, which is off.
    unsafe {
        mpu.rbar.write(region.start | VALID | number);
        mpu.rasr.write(
            NEVER_EXECUTED | FULL_ACCESS | NORMAL_NOT_CACHED | (region.log2 - 1) << 1 | ENABLED,
        );
    }
}
