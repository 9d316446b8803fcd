/* ironout: magnetometer calibration in C. MIT licence; the guide is docs/c.md.
 *
 * Quick start, four functions:
 *
 *     static ironout_session session;                  // 1.6 KB, in static memory
 *     static const ironout_sensor sensor = { { 0.15f, 0.15f, 0.15f }, 100.0f, 48.5f };
 *     static ironout_calibration calibration;
 *
 *     ironout_session_init(&session, &sensor);         // begin
 *     ironout_session_push(&session, counts, t_ms, 0); // every sample, while the board is turned
 *     if (ironout_session_stop(&session, NULL) == IRONOUT_OK)
 *         ironout_session_accept(&session, &calibration);
 *     ironout_apply_counts(&calibration, &sensor, counts, corrected_ut);   // from then on
 *
 * Axes are the board's: x forward, y right, z down. Fields are in microtesla (uT), angles in degrees, times in ms or s
 * as the name says. Functions return IRONOUT_OK or an error code and never abort. There is no heap and no global state.
 *
 * Threads: functions may run at the same time on different states. Calls on one state must not overlap: guard it, or use
 * it from one thread only. ironout_session_push, ironout_live_set, the apply functions and ironout_monitor_push are short
 * enough for an interrupt handler; ironout_session_status, ironout_session_stop, ironout_record_encode,
 * ironout_record_decode and ironout_live_init are not (time and stack: docs/c.md).
 *
 * States are opaque, and may be copied and moved as bytes. A state that was never initialised is refused if it is zeros.
 *
 * Made by cbindgen from the Rust sources in c/src: do not edit. */

#ifndef IRONOUT_H
#define IRONOUT_H

#include <stddef.h>
#include <stdint.h>

#define IRONOUT_VERSION_MAJOR 0
#define IRONOUT_VERSION_MINOR 1
#define IRONOUT_VERSION_PATCH 0

// With ironout_session_push: the chip says that an axis was out of its range. The sample is counted and not used.
#define IRONOUT_OUT_OF_RANGE 1

// With ironout_session_push: samples are missing before this one. Gaps that the time stamps show need no flag.
#define IRONOUT_GAP 2

// Size of ironout_session in words of 8 bytes.
#define IRONOUT_SESSION_WORDS 204

// The longest record. A record of a session has 328 bytes.
#define IRONOUT_RECORD_BYTES 512

// Size of ironout_live in words of 8 bytes.
#define IRONOUT_LIVE_WORDS 304

// Size of a column's name with the zero byte at its end.
#define IRONOUT_COLUMN_BYTES 33

// Size of ironout_monitor in words of 8 bytes.
#define IRONOUT_MONITOR_WORDS 16

// The most reasons that a verdict has.
#define IRONOUT_REASONS 6

// What a function returns: IRONOUT_OK, or why it did nothing. The numbers stay the same in later versions.
enum ironout_error
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Success.
    IRONOUT_OK = 0,
    // A pointer is null or misaligned.
    IRONOUT_BAD_POINTER = 1,
    // The state was not initialised: call its init function first.
    IRONOUT_NOT_INITIALISED = 2,
    // A number is not finite, or out of range for the function.
    IRONOUT_BAD_ARGUMENT = 3,
    // The caller's buffer is too small.
    IRONOUT_TOO_LITTLE_ROOM = 4,
    // The session is in another state: see the function's description.
    IRONOUT_WRONG_STATE = 5,
    // There is no further entry.
    IRONOUT_NO_MORE = 6,
    // Refused: too few samples in motion. Keep turning.
    IRONOUT_TOO_FEW_SAMPLES = 20,
    // Refused: an axis never moved. Turn in all directions; if it did move, check the driver.
    IRONOUT_STUCK_AXIS = 21,
    // Refused: an axis is a copy of another. Check the driver.
    IRONOUT_COPIED_AXIS = 22,
    // Refused: all samples lie near one plane. Tilt the board on its side and upside down.
    IRONOUT_PLANAR = 23,
    // Refused: no ellipsoid fits. Turn through more directions, away from moving iron and currents.
    IRONOUT_NOT_AN_ELLIPSOID = 24,
    // Refused: the ellipsoid passes through the sensor's zero.
    IRONOUT_THROUGH_ORIGIN = 25,
    // Refused: the offset is too large for the field. Look for a magnet, or turn through more directions.
    IRONOUT_OFFSET_TOO_LARGE = 26,
    // Refused: the axes differ too much. Check the scale of each axis, or turn through more directions.
    IRONOUT_AXIS_RATIO = 27,
    // Refused: a number is not finite or out of range.
    IRONOUT_NOT_FINITE = 28,
    // Refused: the predicted error of the corrected vector is above 1 % of the field. Keep turning.
    IRONOUT_ERROR_TOO_LARGE = 29,
    // Refused: the residual is above 5 % of the field. Keep away from moving iron and currents.
    IRONOUT_RESIDUAL_TOO_LARGE = 30,
    // Refused: more than 1 % of the samples are at the sensor's limits. Choose a wider range.
    IRONOUT_SATURATED = 31,
    // A note, not a refusal: the measured magnitude differs from the expected field by more than 20 %.
    IRONOUT_FIELD_MISMATCH = 32,
    // No record: the bytes are erased (all 0xff or all 0).
    IRONOUT_RECORD_EMPTY = 40,
    // No record: it is damaged, or only a part of it was written.
    IRONOUT_RECORD_TORN = 41,
    // A record of a version that this library does not know.
    IRONOUT_RECORD_UNSUPPORTED = 42,
    // The checksum is correct, but the numbers are not a valid calibration.
    IRONOUT_RECORD_UNSOUND = 43,
    // The record contains effects: correct with ironout_live_apply.
    IRONOUT_RECORD_HAS_EFFECTS = 44,
    // A column that an effect needs is not known: set it with ironout_live_set.
    IRONOUT_COLUMN_UNKNOWN = 60,
    // No effect of the record reads this column.
    IRONOUT_COLUMN_NOT_READ = 61,
    // An effect needs the rate of turn.
    IRONOUT_NEEDS_GYRO = 62,
    // The corrected vector would be longer than twice the field: the effects do not apply to this reading.
    IRONOUT_TOO_FAR = 63,
    // No heading: the front of the board points straight up or down.
    IRONOUT_STEEP = 80,
    // No heading: the field is vertical.
    IRONOUT_VERTICAL_FIELD = 81,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ironout_error ironout_error;
#else
typedef int32_t ironout_error;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Where a session is.
enum ironout_state
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Samples are collected.
    IRONOUT_COLLECTING = 1,
    // A calibration was found: accept it.
    IRONOUT_SOLVED = 2,
    // The samples do not support a calibration: begin again with ironout_session_init.
    IRONOUT_REFUSED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ironout_state ironout_state;
#else
typedef int32_t ironout_state;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What the user should do next.
enum ironout_hint
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Turn the board slowly in all directions: nothing has moved yet.
    IRONOUT_HINT_MOVE = 1,
    // Keep turning: bring the side `missing` to where the side `now` is now.
    IRONOUT_HINT_TURN = 2,
    // There are enough directions: call ironout_session_stop.
    IRONOUT_HINT_STOP = 3,
    // Call ironout_session_accept.
    IRONOUT_HINT_ACCEPT = 4,
    // The samples were refused: begin again with ironout_session_init.
    IRONOUT_HINT_AGAIN = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ironout_hint ironout_hint;
#else
typedef int32_t ironout_hint;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What the monitor says of the calibration in use.
enum ironout_condition
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // No disturbance was detected.
    IRONOUT_GOOD = 0,
    // Something magnetic is near: do not trust the field now.
    IRONOUT_DISTURBED = 1,
    // The calibration no longer fits the board: calibrate again.
    IRONOUT_OUTDATED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ironout_condition ironout_condition;
#else
typedef int32_t ironout_condition;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The sides of a board, as bits: front-left is IRONOUT_SIDE_FRONT | IRONOUT_SIDE_LEFT. The axes are x forward, y right,
// z down.
enum ironout_side
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // +x.
    IRONOUT_SIDE_FRONT = 1,
    // -x.
    IRONOUT_SIDE_BACK = 2,
    // +y.
    IRONOUT_SIDE_RIGHT = 4,
    // -y.
    IRONOUT_SIDE_LEFT = 8,
    // +z.
    IRONOUT_SIDE_BOTTOM = 16,
    // -z.
    IRONOUT_SIDE_TOP = 32,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ironout_side ironout_side;
#else
typedef uint32_t ironout_side;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A calibration session, in the caller's memory. Its content is the library's own.
typedef struct ironout_session {
    uint64_t opaque[IRONOUT_SESSION_WORDS];
} ironout_session;

// What the library needs to know of the sensor. All values are in the board's axes: x forward, y right, z down.
typedef struct ironout_sensor {
    // Scale of each axis, uT per count; positive.
    float ut_per_count[3];
    // Samples per second that are pushed; 0 if unknown.
    float rate_hz;
    // Magnitude of the Earth's field where the calibration is made, uT; 0 if unknown. Corrected vectors are scaled to it;
    // without it they keep the mean measured magnitude.
    float field_ut;
} ironout_sensor;

// A snapshot of a session.
typedef struct ironout_status {
    // State of the session.
    ironout_state state;
    // What to do next; ironout_hint_text makes a sentence of it.
    ironout_hint hint;
    // With IRONOUT_HINT_TURN: the side that the field has not come through yet, bits of ironout_side; 0 is any side.
    uint32_t missing;
    // With IRONOUT_HINT_TURN: the side that the field comes through now.
    uint32_t now;
    // Samples in motion, used.
    uint32_t samples;
    // Samples not used: at rest, repeated or saturated.
    uint32_t skipped;
    // Of these, samples at the sensor's limits.
    uint32_t saturated;
    // Fraction of directions seen, 0 to 1.
    float coverage;
    // Largest gap between the directions seen, degrees.
    float gap_deg;
    // Residual rms of the fit so far, uT; NaN while there is no fit.
    float rms_ut;
    // Noise of the sensor, standard deviation per axis, uT; NaN while there is no fit.
    float noise_ut;
    // Predicted error (1 sigma) of the corrected vector, over the field; NaN while there is no fit. Up to 0.01 is accepted.
    float predicted_error;
} ironout_status;

// A reason of a verdict.
typedef struct ironout_reason {
    // Which.
    ironout_error code;
    // Its number, in the unit of its kind: percent of the field (ERROR_TOO_LARGE, RESIDUAL_TOO_LARGE), percent of the
    // samples (SATURATED), samples (TOO_FEW_SAMPLES), axis 0 to 2 (STUCK_AXIS, COPIED_AXIS), percent of thickness over
    // width (PLANAR), percent of the distance (THROUGH_ORIGIN), offset over field (OFFSET_TOO_LARGE), longest over
    // shortest axis (AXIS_RATIO), measured magnitude in uT (FIELD_MISMATCH); 0 for the others.
    float value;
} ironout_reason;

// The verdict of ironout_session_stop.
typedef struct ironout_outcome {
    // 1 if the calibration may be used, 0 if not.
    uint32_t accepted;
    // How many of `reasons` are valid. An accepted calibration may have a note here.
    uint32_t reason_count;
    // The reasons, refusing ones first.
    struct ironout_reason reasons[IRONOUT_REASONS];
    // The side that the field has not come through, bits of ironout_side; 0 is any side.
    uint32_t missing;
} ironout_outcome;

// A calibration: corrected = matrix * (measured - offset). Constants from `ironout export` may be filled in by hand.
typedef struct ironout_calibration {
    // Offset (hard iron), uT in the board's axes.
    float offset_ut[3];
    // Matrix (soft iron), rows first, no unit.
    float matrix[3][3];
    // Magnitude of corrected vectors, uT.
    float field_ut;
    // Noise of the sensor, standard deviation per axis, uT.
    float noise_ut;
    // Residual rms of the corrected magnitude, uT.
    float rms_ut;
    // Predicted error (1 sigma) of the corrected vector in the worst direction, uT; NaN if unknown. Of a record it is
    // rounded up by at most 6 %.
    float predicted_error_ut;
    // Samples behind the fit.
    uint32_t samples;
    // Sequence number of the record; 0 for a calibration of a session.
    uint32_t sequence;
    // Effects in the record, which this struct does not contain.
    uint32_t effects;
    // Code of the sensor's mounting that the record was made with; 0 if it states none.
    uint32_t mounting;
} ironout_calibration;

// A correction with effects, in the caller's memory. Its content is the library's own.
typedef struct ironout_live {
    uint64_t opaque[IRONOUT_LIVE_WORDS];
} ironout_live;

// A column that is outside the range that its effect was fitted over.
typedef struct ironout_outside {
    // What the effect uses now, in the column's unit.
    double value;
    // The least value that the effect was fitted over.
    double least;
    // The greatest.
    double greatest;
    // The column's name, with a zero byte at its end.
    char column[IRONOUT_COLUMN_BYTES];
} ironout_outside;

// A watch over a calibration, in the caller's memory. Its content is the library's own.
typedef struct ironout_monitor {
    uint64_t opaque[IRONOUT_MONITOR_WORDS];
} ironout_monitor;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Begins to collect, whatever `session` was before: this is also how to begin again and how to give up. A calibration in
// use is not touched.
//
// IRONOUT_BAD_ARGUMENT: a scale is not positive, the rate or the field is negative, or a value is not finite.
ironout_error ironout_session_init(struct ironout_session *session,
                                   const struct ironout_sensor *sensor);

// Takes one sample: three counts in the board's axes, the time in ms (a tick that wraps is fine), and 0 or flags
// (IRONOUT_OUT_OF_RANGE, IRONOUT_GAP). Push every conversion once. Samples at rest, repeated ones and those at the ends of
// the 16-bit range are left out and counted. After ironout_session_stop nothing is taken.
//
// Takes the same short time for every sample; solves nothing.
ironout_error ironout_session_push(struct ironout_session *session,
                                   const int16_t counts[3],
                                   uint32_t t_ms,
                                   uint32_t flags);

// As ironout_session_push, from uT. They are rounded to counts of `ut_per_count`: choose a scale as fine as the sensor's
// resolution, so that the largest value stays below 32767 counts.
//
// IRONOUT_BAD_ARGUMENT: a value is not finite, or a flag is unknown; the sample was not taken.
ironout_error ironout_session_push_ut(struct ironout_session *session,
                                      const float measured_ut[3],
                                      uint32_t t_ms,
                                      uint32_t flags);

// Writes a snapshot of the session to `status`: what was collected, how good a calibration from it would be, and what to do
// next. It changes nothing.
//
// While the session collects, this solves the samples so far: call it once a second, not for every sample. docs/c.md
// gives the instructions and the stack it needs.
ironout_error ironout_session_status(const struct ironout_session *session,
                                     struct ironout_status *status);

// Stops collecting, solves and judges. Returns IRONOUT_OK if the calibration is accepted, otherwise the first reason why
// it is refused. `outcome` gets all reasons; it may be null. A calibration in use is not touched.
//
// IRONOUT_WRONG_STATE: the session was stopped before.
ironout_error ironout_session_stop(struct ironout_session *session,
                                   struct ironout_outcome *outcome);

// Writes the accepted calibration to `calibration`, which may be the one in use: on an error it is left as it was. The
// session stays solved, so that ironout_record_encode works before and after.
//
// IRONOUT_WRONG_STATE: there is no accepted calibration.
ironout_error ironout_session_accept(const struct ironout_session *session,
                                     struct ironout_calibration *calibration);

// Writes the corrected field of a sample in counts to `corrected_ut`, uT in the board's axes. Only `ut_per_count` of the
// sensor is read. A count at the end of the range gives a number too: what the chip calls out of range is no measurement.
ironout_error ironout_apply_counts(const struct ironout_calibration *calibration,
                                   const struct ironout_sensor *sensor,
                                   const int16_t counts[3],
                                   float corrected_ut[3]);

// Writes the corrected field of a measured vector to `corrected_ut`, both uT in the board's axes. They may be the same
// array. NaN in, NaN out.
ironout_error ironout_apply_ut(const struct ironout_calibration *calibration,
                               const float measured_ut[3],
                               float corrected_ut[3]);

// Writes the accepted calibration of a session to `bytes` as a record with a checksum, which the program `ironout` and
// every firmware with this library read, and its length to `length`. `room` is the size of `bytes`; IRONOUT_RECORD_BYTES
// is always enough. Of two stored records the one with the higher `sequence` is the newer: give the old record's plus
// one, and write it to another place than the old one, so that a power cut leaves one of them whole.
//
// IRONOUT_WRONG_STATE: there is no accepted calibration. IRONOUT_TOO_LITTLE_ROOM: nothing was written.
ironout_error ironout_record_encode(const struct ironout_session *session,
                                    uint32_t sequence,
                                    uint8_t *bytes,
                                    size_t room,
                                    size_t *length);

// Reads the calibration of a record at the beginning of `bytes`; bytes after the record are ignored, so that `length` may
// be that of a whole slot. On an error `calibration` is left as it was, but for one:
//
// IRONOUT_RECORD_HAS_EFFECTS: `calibration` was written, but is right only while every column of the effects is at its
// reference: correct with ironout_live_apply.
ironout_error ironout_record_decode(const uint8_t *bytes,
                                    size_t length,
                                    struct ironout_calibration *calibration);

// Prepares the correction of a record, with or without effects. No column is known yet. On an error `live` is left as it
// was.
ironout_error ironout_live_init(struct ironout_live *live,
                                const uint8_t *bytes,
                                size_t length);

// Sets a column, for example "temp_c" to the temperature in degrees Celsius, in the unit of the log that the effects were
// fitted on. It keeps this value until it is set again; NaN makes it unknown.
//
// IRONOUT_COLUMN_NOT_READ: no effect reads a column of this name.
ironout_error ironout_live_set(struct ironout_live *live,
                               const char *column,
                               float value);

// Writes the name of the first column that is needed and not known. IRONOUT_NO_MORE: all are known. The column "t_s" is
// the time of ironout_live_apply.
ironout_error ironout_live_missing(const struct ironout_live *live,
                                   char column[IRONOUT_COLUMN_BYTES]);

// Writes the corrected field to `corrected_ut`, uT in the board's axes; on an error it is left as it was, and the old
// correction stays in use. `t_s` is the time in seconds: any clock, but for effects of time, which need the clock of the
// log that they were fitted on. `turn_radps` is the gyro's rate of turn in the board's axes; null if there is none.
//
// IRONOUT_COLUMN_UNKNOWN: see ironout_live_missing. IRONOUT_NEEDS_GYRO, IRONOUT_TOO_FAR, IRONOUT_NOT_FINITE: not
// corrected. There is no silent fallback.
ironout_error ironout_live_apply(struct ironout_live *live,
                                 double t_s,
                                 const float measured_ut[3],
                                 const float turn_radps[3],
                                 float corrected_ut[3]);

// Writes the column number `index`, from 0, of those that are outside the range that their effect was fitted over, as of
// the last ironout_live_apply. The correction goes on there, with an error that grows with the distance; further outside
// than the range is wide the effect keeps its value. IRONOUT_NO_MORE: there is no such column.
ironout_error ironout_live_outside(const struct ironout_live *live,
                                   uint32_t index,
                                   struct ironout_outside *outside);

// Begins to watch a calibration: its field, noise and predicted error are copied.
//
// IRONOUT_BAD_ARGUMENT: its field is not positive and finite.
ironout_error ironout_monitor_init(struct ironout_monitor *monitor,
                                   const struct ironout_calibration *calibration);

// Takes a corrected sample and writes what is to be said now to `condition`. `t_ms` may wrap. `accel_mps2` is the specific
// force in the board's axes, m/s^2 (at rest level: 0, 0, -9.8); null if there is no accelerometer. A sample that is not
// finite is passed over. The calibration is never changed.
ironout_error ironout_monitor_push(struct ironout_monitor *monitor,
                                   uint32_t t_ms,
                                   const float corrected_ut[3],
                                   const float accel_mps2[3],
                                   ironout_condition *condition);

// Writes the heading of the board's front, degrees from 0 to 360 clockwise from north, tilt-compensated: from magnetic
// north with a `declination_deg` of 0, from true north with the declination of the place (east positive). Axes are x
// forward, y right, z down. `accel_mps2` is the specific force, m/s^2: at rest level 0, 0, -9.8; while the board
// accelerates, the heading is wrong.
//
// IRONOUT_NOT_FINITE: a vector is zero or not finite. IRONOUT_STEEP, IRONOUT_VERTICAL_FIELD: no heading here. On an error
// `heading` is left as it was.
ironout_error ironout_heading(const float corrected_ut[3],
                              const float accel_mps2[3],
                              float declination_deg,
                              float *heading);

// Writes the hint of a status as an English sentence, with a zero byte at its end, into `text`, which has room for `room`
// bytes. 100 are enough; a longer sentence is cut.
//
// IRONOUT_BAD_ARGUMENT: `status` was not written by ironout_session_status.
ironout_error ironout_hint_text(const struct ironout_status *status,
                                char *text,
                                size_t room);

// A sentence for a code, in English, at most 120 bytes. It is never null and stays valid. For an unknown code:
// "unknown error".
const char *ironout_error_text(int32_t error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* IRONOUT_H */

#ifndef IRONOUT_H_LAYOUT
#define IRONOUT_H_LAYOUT
/* The sizes that the library was compiled for; a compiler that lays them out differently stops here. */
typedef char ironout_check_session[sizeof(ironout_session) == 8u * IRONOUT_SESSION_WORDS ? 1 : -1];
typedef char ironout_check_live[sizeof(ironout_live) == 8u * IRONOUT_LIVE_WORDS ? 1 : -1];
typedef char ironout_check_monitor[sizeof(ironout_monitor) == 8u * IRONOUT_MONITOR_WORDS ? 1 : -1];
typedef char ironout_check_sensor[sizeof(ironout_sensor) == 20u ? 1 : -1];
typedef char ironout_check_calibration[sizeof(ironout_calibration) == 80u ? 1 : -1];
typedef char ironout_check_status[sizeof(ironout_status) == 48u ? 1 : -1];
typedef char ironout_check_outcome[sizeof(ironout_outcome) == 60u ? 1 : -1];
typedef char ironout_check_outside[sizeof(ironout_outside) == 64u ? 1 : -1];
#endif
