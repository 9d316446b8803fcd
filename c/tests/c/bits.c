/* Every function once, on a trace; prints the bits of what comes out, for comparison with the Rust library
 * (tests/suite/expected.rs).
 *
 *     bits trace.txt effects.rec */

#include "ironout.h"

#include <stdio.h>
#include <string.h>

enum { STEP = 97 };

static ironout_session session;
static ironout_calibration accepted, decoded;
static ironout_live live;
static ironout_monitor monitor;
static uint8_t record[IRONOUT_RECORD_BYTES];
static int failures;

static const ironout_sensor sensor = { { 0.15f, 0.15f, 0.12f }, 100.0f, 48.5f };

struct row {
    uint32_t t_ms;
    int16_t counts[3];
    uint32_t flags;
    float accel_mps2[3];
};

static void must(ironout_error error, const char *what)
{
    if (error != IRONOUT_OK) {
        printf("%s: %s\n", what, ironout_error_text(error));
        failures++;
    }
}

static void bits(const float *values, size_t n)
{
    size_t i;
    for (i = 0; i < n; i++) {
        uint32_t word;
        memcpy(&word, &values[i], sizeof word);
        printf(" %08lx", (unsigned long)word);
    }
}

static void print_status(const char *name)
{
    ironout_status status;
    must(ironout_session_status(&session, &status), name);
    printf("%s %lu %lu %lu", name, (unsigned long)status.samples, (unsigned long)status.skipped,
           (unsigned long)status.saturated);
    bits(&status.coverage, 1);
    bits(&status.gap_deg, 1);
    bits(&status.rms_ut, 1);
    bits(&status.noise_ut, 1);
    bits(&status.predicted_error, 1);
    printf("\n");
}

static void print_calibration(const char *name, const ironout_calibration *calibration)
{
    printf("%s", name);
    bits(calibration->offset_ut, 3);
    bits(calibration->matrix[0], 3);
    bits(calibration->matrix[1], 3);
    bits(calibration->matrix[2], 3);
    bits(&calibration->field_ut, 1);
    printf("\n");
}

static int read_row(FILE *file, struct row *row)
{
    unsigned long time;
    int x, y, z, out_of_range;
    if (fscanf(file, "%lu %d %d %d %d %f %f %f", &time, &x, &y, &z, &out_of_range, &row->accel_mps2[0],
               &row->accel_mps2[1], &row->accel_mps2[2]) != 8)
        return 0;
    row->t_ms = (uint32_t)time;
    row->counts[0] = (int16_t)x;
    row->counts[1] = (int16_t)y;
    row->counts[2] = (int16_t)z;
    row->flags = out_of_range ? IRONOUT_OUT_OF_RANGE : 0u;
    return 1;
}

static void print_sample(unsigned long index, const struct row *row, const float corrected_ut[3],
                         ironout_condition condition)
{
    float heading, measured_ut[3], live_ut[3], again_ut[3];
    ironout_outside outside;
    uint32_t i;
    printf("sample %lu", index);
    bits(corrected_ut, 3);
    if (ironout_heading(corrected_ut, row->accel_mps2, 3.5f, &heading) == IRONOUT_OK)
        bits(&heading, 1);
    else
        printf(" none");
    printf(" %ld\n", (long)condition);

    for (i = 0; i < 3; i++)
        measured_ut[i] = (float)row->counts[i] * sensor.ut_per_count[i];
    must(ironout_apply_ut(&accepted, measured_ut, again_ut), "apply_ut");
    if (memcmp(again_ut, corrected_ut, sizeof again_ut) != 0)
        failures++;
    must(ironout_live_set(&live, "temp_c", 5.0f + (float)index * 0.02f), "live_set");
    must(ironout_live_apply(&live, 1000.0 + (double)index * 0.1, measured_ut, NULL, live_ut), "live_apply");
    printf("live %lu", index);
    bits(live_ut, 3);
    for (i = 0; ironout_live_outside(&live, i, &outside) == IRONOUT_OK; i++)
        printf(" %s", outside.column);
    printf("\n");
}

static void calibrate(FILE *trace)
{
    struct row row;
    unsigned long taken = 0;
    size_t length = 0, i;
    must(ironout_session_init(&session, &sensor), "init");
    while (read_row(trace, &row)) {
        must(ironout_session_push(&session, row.counts, row.t_ms, row.flags), "push");
        taken++;
        if (taken == 200 || taken == 900 || taken == 1600)
            print_status("status");
    }
    must(ironout_session_stop(&session, NULL), "stop");
    print_status("stopped");
    must(ironout_session_accept(&session, &accepted), "accept");
    print_calibration("accepted", &accepted);
    must(ironout_record_encode(&session, 3, record, sizeof record, &length), "encode");
    printf("record %lu ", (unsigned long)length);
    for (i = 0; i < length; i++)
        printf("%02x", (unsigned)record[i]);
    printf("\n");
    must(ironout_record_decode(record, length, &decoded), "decode");
    print_calibration("decoded", &decoded);
    printf("decoded %lu", (unsigned long)decoded.samples);
    bits(&decoded.noise_ut, 1);
    bits(&decoded.rms_ut, 1);
    bits(&decoded.predicted_error_ut, 1);
    printf("\n");
}

static void use(FILE *trace)
{
    struct row row;
    unsigned long index;
    must(ironout_monitor_init(&monitor, &accepted), "monitor_init");
    for (index = 0; read_row(trace, &row); index++) {
        float corrected_ut[3];
        ironout_condition condition;
        must(ironout_apply_counts(&accepted, &sensor, row.counts, corrected_ut), "apply_counts");
        must(ironout_monitor_push(&monitor, row.t_ms, corrected_ut, row.accel_mps2, &condition), "monitor");
        if (index % STEP == 0)
            print_sample(index, &row, corrected_ut, condition);
    }
}

int main(int argc, char **argv)
{
    FILE *trace = argc > 2 ? fopen(argv[1], "r") : NULL;
    FILE *effects = argc > 2 ? fopen(argv[2], "rb") : NULL;
    uint8_t bytes[IRONOUT_RECORD_BYTES];
    char column[IRONOUT_COLUMN_BYTES];
    size_t length;
    if (trace == NULL || effects == NULL) {
        printf("usage: bits TRACE RECORD\n");
        return 2;
    }
    length = fread(bytes, 1, sizeof bytes, effects);
    fclose(effects);
    must(ironout_live_init(&live, bytes, length), "live_init");
    if (ironout_live_missing(&live, column) != IRONOUT_OK || strcmp(column, "temp_c") != 0)
        failures++;
    calibrate(trace);
    rewind(trace);
    use(trace);
    fclose(trace);
    return failures == 0 ? 0 : 1;
}
