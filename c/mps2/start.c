/* Start-up for the emulated board mps2-an386 (Cortex-M4 with FPU): vectors, FPU, and newlib's main with semihosting. */

#include <stdint.h>

extern uint32_t stack_top;
void _start(void); /* newlib's, from rdimon */

static void reset(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: the FPU on */
    __asm volatile("dsb\n isb");
    _start();
}

static void fault(void)
{
    /* Semihosting SYS_EXIT with a run-time error: the emulator ends with status 1. */
    register uint32_t operation __asm("r0") = 0x18u;
    register uint32_t reason __asm("r1") = 0x20023u;
    __asm volatile("bkpt 0xAB" : : "r"(operation), "r"(reason) : "memory");
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    &stack_top, (const void *)reset, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, (const void *)fault,
};
