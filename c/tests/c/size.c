/* Programs with more and more of the library, to see its size: PROGRAM selects one. Compiled and linked, never run. */

#include "ironout.h"

static ironout_session session;
static ironout_calibration calibration;
static ironout_live live;
static ironout_monitor monitor;
static uint8_t record[IRONOUT_RECORD_BYTES];
/* Of unknown content to the compiler. */
volatile uint32_t input;
volatile uint32_t output;

static const ironout_sensor sensor = { { 0.15f, 0.15f, 0.12f }, 100.0f, 48.5f };

int main(void)
{
    int16_t counts[3] = { (int16_t)input, (int16_t)input, (int16_t)input };
    float vector[3] = { (float)input, (float)input, (float)input };
#if PROGRAM == 0
    output = (uint32_t)counts[0] + (uint32_t)vector[0] + record[input] + calibration.samples +
             (uint32_t)sensor.rate_hz + (uint32_t)(session.opaque[0] + live.opaque[0] + monitor.opaque[0]);
#endif
#if PROGRAM >= 1 && PROGRAM != 5
    output = (uint32_t)ironout_apply_counts(&calibration, &sensor, counts, vector);
#endif
#if PROGRAM == 2 || PROGRAM == 3 || PROGRAM == 4 || PROGRAM == 6
    output = (uint32_t)ironout_session_init(&session, &sensor);
    output = (uint32_t)ironout_session_push(&session, counts, input, 0);
    output = (uint32_t)ironout_session_stop(&session, NULL);
    output = (uint32_t)ironout_session_accept(&session, &calibration);
#endif
#if PROGRAM == 3 || PROGRAM == 4 || PROGRAM == 6
    {
        ironout_status status;
        char text[100];
        output = (uint32_t)ironout_session_status(&session, &status);
        output = (uint32_t)ironout_hint_text(&status, text, sizeof text);
        output = (uint32_t)text[0];
    }
#endif
#if PROGRAM == 4 || PROGRAM == 6
    {
        size_t length;
        output = (uint32_t)ironout_record_encode(&session, 1, record, sizeof record, &length);
        output = (uint32_t)ironout_record_decode(record, length, &calibration);
    }
#endif
#if PROGRAM == 5 || PROGRAM == 6
    {
        ironout_outside outside;
        output = (uint32_t)ironout_live_init(&live, record, sizeof record);
        output = (uint32_t)ironout_live_set(&live, "temp_c", vector[0]);
        output = (uint32_t)ironout_live_apply(&live, (double)input, vector, vector, vector);
        output = (uint32_t)ironout_live_outside(&live, 0, &outside);
    }
#endif
#if PROGRAM == 6
    {
        ironout_condition condition;
        char column[IRONOUT_COLUMN_BYTES];
        output = (uint32_t)ironout_session_push_ut(&session, vector, input, 0);
        output = (uint32_t)ironout_apply_ut(&calibration, vector, vector);
        output = (uint32_t)ironout_live_missing(&live, column);
        output = (uint32_t)ironout_monitor_init(&monitor, &calibration);
        output = (uint32_t)ironout_monitor_push(&monitor, input, vector, vector, &condition);
        output = (uint32_t)ironout_heading(vector, vector, 0.0f, vector);
        output = (uint32_t)(uint8_t)ironout_error_text((int32_t)input)[0];
    }
#endif
    return 0;
}
