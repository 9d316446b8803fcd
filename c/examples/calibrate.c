/* A calibration from a file of samples, as firmware would do it: session, hint, verdict, record, correction.
 *
 *     cc -std=c99 -Iinclude examples/calibrate.c libironout.a -lm -o calibrate && ./calibrate trace.txt
 *
 * A line of the file is: time in ms, three counts, 1 if the chip says out of range. On a board the lines are the driver's
 * readings, and everything else is the same: c/check runs this file on the host and on an emulated Cortex-M4. */

#include "ironout.h"

#include <stdio.h>

/* Static memory: on a small board the stack is no place for 1.6 KB. */
static ironout_session session;
static ironout_calibration calibration;
static uint8_t record[IRONOUT_RECORD_BYTES];

static const ironout_sensor sensor = {
    { 0.15f, 0.15f, 0.12f }, /* uT per count, from the datasheet */
    100.0f,                  /* samples per second */
    48.5f,                   /* the Earth's field here, uT */
};

/* One line of the file; 0 at its end. */
static int read_sample(FILE *file, uint32_t *t_ms, int16_t counts[3], uint32_t *flags)
{
    unsigned long time;
    int x, y, z, out_of_range;
    if (fscanf(file, "%lu %d %d %d %d%*[^\n]", &time, &x, &y, &z, &out_of_range) != 5)
        return 0;
    *t_ms = (uint32_t)time;
    counts[0] = (int16_t)x;
    counts[1] = (int16_t)y;
    counts[2] = (int16_t)z;
    *flags = out_of_range ? IRONOUT_OUT_OF_RANGE : 0u;
    return 1;
}

int main(int argc, char **argv)
{
    FILE *file = argc > 1 ? fopen(argv[1], "r") : NULL;
    if (file == NULL) {
        printf("usage: calibrate FILE\n");
        return 2;
    }

    ironout_error error = ironout_session_init(&session, &sensor);
    uint32_t t_ms, flags, taken = 0;
    int16_t counts[3] = { 0, 0, 0 };
    while (error == IRONOUT_OK && read_sample(file, &t_ms, counts, &flags)) {
        error = ironout_session_push(&session, counts, t_ms, flags);
        if (++taken % 500 == 0) { /* once in 5 s: what should the user do? */
            ironout_status status;
            char hint[100];
            ironout_session_status(&session, &status);
            ironout_hint_text(&status, hint, sizeof hint);
            printf("%lu samples, %.0f %% of the directions: %s\n", (unsigned long)status.samples,
                   100.0 * (double)status.coverage, hint);
        }
    }
    fclose(file);

    ironout_outcome outcome;
    if (error == IRONOUT_OK)
        error = ironout_session_stop(&session, &outcome);
    if (error != IRONOUT_OK) { /* the calibration in use, if any, stays as it was */
        printf("refused: %s\n", ironout_error_text(error));
        return 1;
    }
    ironout_session_accept(&session, &calibration);
    printf("accepted: offset %.2f %.2f %.2f uT, noise %.2f uT, predicted error %.2f uT\n",
           (double)calibration.offset_ut[0], (double)calibration.offset_ut[1], (double)calibration.offset_ut[2],
           (double)calibration.noise_ut, (double)calibration.predicted_error_ut);

    /* Store it: write `length` bytes to flash. At the next start, decode them. */
    size_t length = 0;
    error = ironout_record_encode(&session, 1, record, sizeof record, &length);
    if (error == IRONOUT_OK)
        error = ironout_record_decode(record, length, &calibration);
    printf("record of %lu bytes: %s\n", (unsigned long)length, ironout_error_text(error));

    float corrected_ut[3];
    ironout_apply_counts(&calibration, &sensor, counts, corrected_ut);
    printf("the last sample: %.2f %.2f %.2f uT\n", (double)corrected_ut[0], (double)corrected_ut[1],
           (double)corrected_ut[2]);
    return error == IRONOUT_OK ? 0 : 1;
}
