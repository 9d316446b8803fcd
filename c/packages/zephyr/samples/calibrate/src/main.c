/* Calibrates the magnetometer with the alias magn0, then prints the corrected field. */

#include <ironout.h>

#include <zephyr/device.h>
#include <zephyr/drivers/sensor.h>
#include <zephyr/kernel.h>

static const struct device *const magnetometer = DEVICE_DT_GET(DT_ALIAS(magn0));

/* Samples arrive in uT: the scale is the step they are kept in, the rate that of the loop. */
static const ironout_sensor sensor = { { 0.1f, 0.1f, 0.1f }, 50.0f, 0.0f };
static ironout_session session;
static ironout_calibration calibration;

/* The next sample in uT. Zephyr's channel is in gauss, in the axes of the chip: turn them into the board's here. */
static int next(float measured_ut[3])
{
    struct sensor_value value[3];
    int error;
    int axis;
    k_msleep(20);
    error = sensor_sample_fetch(magnetometer);
    if (error == 0)
        error = sensor_channel_get(magnetometer, SENSOR_CHAN_MAGN_XYZ, value);
    for (axis = 0; error == 0 && axis < 3; axis++)
        measured_ut[axis] = 100.0f * sensor_value_to_float(&value[axis]);
    return error;
}

static ironout_error calibrate(void)
{
    ironout_error error = ironout_session_init(&session, &sensor);
    int taken;
    for (taken = 1; error == IRONOUT_OK; taken++) {
        float measured_ut[3];
        ironout_status status;
        char hint[100];
        if (next(measured_ut) != 0)
            continue;
        error = ironout_session_push_ut(&session, measured_ut, k_uptime_get_32(), 0);
        if (taken % 50 != 0 || error != IRONOUT_OK)
            continue;
        ironout_session_status(&session, &status);
        ironout_hint_text(&status, hint, sizeof(hint));
        printk("%s\n", hint);
        if (status.hint == IRONOUT_HINT_STOP)
            break;
    }
    if (error == IRONOUT_OK)
        error = ironout_session_stop(&session, NULL);
    if (error == IRONOUT_OK)
        error = ironout_session_accept(&session, &calibration);
    return error;
}

int main(void)
{
    ironout_error error;
    if (!device_is_ready(magnetometer)) {
        printk("the magnetometer is not ready\n");
        return 0;
    }
    do {
        error = calibrate();
        printk("%s\n", ironout_error_text(error));
    } while (error != IRONOUT_OK);
    for (;;) {
        float field_ut[3];
        if (next(field_ut) != 0)
            continue;
        ironout_apply_ut(&calibration, field_ut, field_ut);
        printk("%.2f %.2f %.2f uT\n", (double)field_ut[0], (double)field_ut[1], (double)field_ut[2]);
    }
}
