/* Stack and instructions of the functions on an emulated processor. The stack is painted and read back. On the board with
 * the Cortex-M4, TIMER0 counts under -icount shift=6, where 1.6 ticks are an instruction; RISC-V counts them itself.
 *
 *     measure trace.txt effects.rec */

#include "ironout.h"

#include <stdio.h>

#ifdef __riscv
#define TOP_OF_STACK(top) __asm volatile("mv %0, sp" : "=r"(top))
static void start(void) {}
static uint32_t count(void)
{
    uint32_t instructions;
    __asm volatile(".option push\n.option arch, +zicsr\ncsrr %0, minstret\n.option pop" : "=r"(instructions));
    return instructions;
}
#else
#define TOP_OF_STACK(top) __asm volatile("mov %0, sp" : "=r"(top))
#define TIMER ((volatile uint32_t *)0x40000000u) /* CTRL, VALUE, RELOAD */
static uint32_t passed, last;
static void start(void)
{
    TIMER[2] = TIMER[1] = last = 0xFFFFFFFFu;
    TIMER[0] = 1u;
}
static uint32_t count(void)
{
    const uint32_t now = TIMER[1];
    passed += last - now;
    last = now;
    return passed / 16u * 10u + passed % 16u * 10u / 16u;
}
#endif

enum { PAINTED_WORDS = 8192, GAP_WORDS = 64 };
#define PAINT 0x5AA5C33Cu

static ironout_session session;
static ironout_calibration calibration;
static ironout_status status;
static ironout_live live;
static ironout_monitor monitor;
static ironout_condition condition;
static uint8_t record[IRONOUT_RECORD_BYTES], effects[IRONOUT_RECORD_BYTES];
static size_t length, effects_length;
static int16_t counts[3];
static float vector[3], corrected[3], heading;
static const float accel[3] = { 0.1f, 0.2f, -9.8f };
static uint32_t t_ms, flags;
static const ironout_sensor sensor = { { 0.15f, 0.15f, 0.12f }, 100.0f, 48.5f };

static ironout_error nothing(void) { return IRONOUT_OK; }
static ironout_error init(void) { return ironout_session_init(&session, &sensor); }
static ironout_error push(void) { return ironout_session_push(&session, counts, t_ms, flags); }
static ironout_error look(void) { return ironout_session_status(&session, &status); }
static ironout_error stop(void) { return ironout_session_stop(&session, NULL); }
static ironout_error accept(void) { return ironout_session_accept(&session, &calibration); }
static ironout_error encode(void) { return ironout_record_encode(&session, 1, record, sizeof record, &length); }
static ironout_error decode(void) { return ironout_record_decode(record, length, &calibration); }
static ironout_error apply(void) { return ironout_apply_counts(&calibration, &sensor, counts, corrected); }
static ironout_error live_init(void) { return ironout_live_init(&live, effects, effects_length); }
static ironout_error live_set(void) { return ironout_live_set(&live, "temp_c", 20.0f); }
static ironout_error live_apply(void) { return ironout_live_apply(&live, 1010.0, vector, NULL, corrected); }
static ironout_error watch(void) { return ironout_monitor_push(&monitor, t_ms, corrected, accel, &condition); }
static ironout_error turn(void) { return ironout_heading(corrected, accel, 0.0f, &heading); }

static uint32_t most_stack, most_instructions, of_measuring;

/* Runs a function and keeps the most stack and instructions that it took. */
static __attribute__((noinline)) ironout_error measured(ironout_error (*work)(void))
{
    volatile uint32_t *top, *place;
    uint32_t stack, instructions;
    ironout_error error;
    TOP_OF_STACK(top);
    for (place = top - PAINTED_WORDS; place < top - GAP_WORDS; place++)
        *place = PAINT;
    instructions = count();
    error = work();
    instructions = count() - instructions - of_measuring;
    for (place = top - PAINTED_WORDS; place < top - GAP_WORDS && *place == PAINT; place++) {
    }
    stack = (uint32_t)(top - place) * 4u;
    if (stack > most_stack)
        most_stack = stack;
    if (instructions > most_instructions)
        most_instructions = instructions;
    return error;
}

static void report(const char *name, ironout_error error)
{
    char most[12];
    if (most_stack <= GAP_WORDS * 4u)
        snprintf(most, sizeof most, "< %u", GAP_WORDS * 4u);
    else
        snprintf(most, sizeof most, "%lu", (unsigned long)most_stack);
    printf("%-24s %8s %12lu%s%s\n", name, most, (unsigned long)most_instructions,
           error == IRONOUT_OK ? "" : "  ", error == IRONOUT_OK ? "" : ironout_error_text(error));
    most_stack = most_instructions = 0;
}

int main(int argc, char **argv)
{
    FILE *trace = argc > 2 ? fopen(argv[1], "r") : NULL;
    FILE *file = argc > 2 ? fopen(argv[2], "rb") : NULL;
    unsigned long time;
    int x, y, z, out_of_range;
    ironout_error error;
    if (trace == NULL || file == NULL)
        return 2;
    effects_length = fread(effects, 1, sizeof effects, file);
    start();
    (void)measured(nothing);
    of_measuring = most_instructions;
    most_stack = most_instructions = 0;
    printf("function                 stack, B instructions\n");
    report("ironout_session_init", measured(init));
    error = IRONOUT_OK;
    while (fscanf(trace, "%lu %d %d %d %d%*[^\n]", &time, &x, &y, &z, &out_of_range) == 5) {
        counts[0] = (int16_t)x;
        counts[1] = (int16_t)y;
        counts[2] = (int16_t)z;
        t_ms = (uint32_t)time;
        flags = out_of_range ? IRONOUT_OUT_OF_RANGE : 0u;
        if (measured(push) != IRONOUT_OK)
            error = IRONOUT_WRONG_STATE;
    }
    report("ironout_session_push", error);
    report("ironout_session_status", measured(look));
    report("ironout_session_stop", measured(stop));
    report("ironout_session_accept", measured(accept));
    report("ironout_record_encode", measured(encode));
    report("ironout_record_decode", measured(decode));
    report("ironout_apply_counts", measured(apply));
    report("ironout_live_init", measured(live_init));
    report("ironout_live_set", measured(live_set));
    vector[0] = corrected[0];
    vector[1] = corrected[1];
    vector[2] = corrected[2];
    report("ironout_live_apply", measured(live_apply));
    ironout_monitor_init(&monitor, &calibration);
    (void)watch();
    t_ms += 10u;
    report("ironout_monitor_push", measured(watch));
    report("ironout_heading", measured(turn));
    return 0;
}
