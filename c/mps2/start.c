/* Start-up for the emulated board mps2-an386 (Cortex-M4 with FPU): vectors, FPU, and newlib's main with semihosting. */

#include <stddef.h>
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

struct vectors {
    uint32_t *stack;
    void (*handlers[15])(void);
};

__attribute__((section(".vectors"), used)) static const struct vectors vectors = {
    &stack_top,
    { reset, fault, fault, fault, fault, fault, NULL, NULL, NULL, NULL, fault, fault, NULL, fault, fault },
};
